//! The closed-loop rules by their names in the guide (`docs/src/theory/closed-loop-rules.md`): each
//! test fails without its rule. Others stand with their parts.

use crate::common::{GivenRoad, column, mean_and_error, run, study, typical, unassisted};
use ocmc_core::driver::speed_change::Rise;
use ocmc_core::energy::Carrier;
use ocmc_core::kernel::drive::scheduler::drive_scenario;
use ocmc_core::kernel::drive::trace::{Trace, trace_scenario};
use ocmc_core::record::Outcome;
use ocmc_core::study::Scenario;

/// How often a column goes from zero to above.
fn presses(values: &[f64]) -> usize {
    values.windows(2).filter(|w| w[0] == 0.0 && w[1] > 0.0).count()
}

fn shifts(trace: &Trace) -> u32 {
    trace.record.n_gear_shifts
}

#[test]
fn launch_floor_and_clutch_a_40_t_truck_starts_again_after_a_stop_sign_on_a_6_percent_climb() {
    for sets in [&[][..], &["driver.pedals.pid_share=0.0"][..]] {
        let study = typical(sets);
        let road = GivenRoad::flat(3000.0, 80.0 / 3.6).slope(0.06).stop(1500.0, 5.0);
        let trace = trace_scenario(&study, road.scenario(&study));
        assert_eq!(trace.record.outcome, Outcome::Completed);
        assert_eq!(trace.record.n_stops, 1);
        // steep: it starts in first gear, with a slipping clutch and an engine that never dies
        let restart = column(&trace, "step_s").iter().position(|dt| *dt == 5.0).unwrap();
        assert!(column(&trace, "gear")[restart] == 1.0);
        assert!(trace.record.clutch_loss_j.unwrap() > 0.0);
        let engine = column(&trace, "engine_speed_radps");
        assert!(engine.iter().all(|w| *w >= 0.9 * 62.8), "the engine never turns below 0.9 idle");
    }
}

#[test]
fn launch_ramp_the_desired_speed_rises_with_the_drivers_acceleration_and_the_truck_with_it() {
    for acceleration in [0.3, 0.5, 0.8] {
        let study = typical(&[
            &format!("driver.speed_change.acceleration_mps2={acceleration}"),
            "simulation.step_s=0.2",
        ]);
        let road = GivenRoad { payload_kg: 0.0, ..GivenRoad::flat(2000.0, 80.0 / 3.6) };
        let road = road.stop(1000.0, 5.0);
        let scenario = road.scenario(&study);
        // the typical driver has the typical factor on the rated power
        let factor = study.model().driver.speed_change.acceleration_power_factor.unwrap();
        let power_w = factor * study.vehicle().rated_power_w;
        let scenario_mass_kg = scenario.vehicle.mass_kg;
        let trace = trace_scenario(&study, scenario);
        let [time, step, desired, speed, rate] =
            ["time_s", "step_s", "desired_speed_mps", "speed_mps", "acceleration_mps2"]
                .map(|name| column(&trace, name));
        let restart = step.iter().position(|dt| *dt == 5.0).unwrap();
        // no jump at the line: seconds later it is what the acceleration has come to
        for k in restart + 1..desired.len() {
            let since_s = time[k] - step[k] - time[restart];
            if since_s > 15.0 {
                break;
            }
            // g = 1/a grows along the rise as g² = g₀² + 2 t dg/dv
            let (rest, grows) = (1.0 / acceleration, scenario_mass_kg / power_w);
            let wanted = ((rest * rest + 2.0 * grows * since_s).sqrt() - rest) / grows;
            assert!((desired[k] - wanted).abs() < 1e-6, "{since_s} s: {} {wanted}", desired[k]);
            // what a shift loses is made up with half as much again at most, but for the lag
            assert!(rate[k] < 1.85 * acceleration, "{since_s} s: {}", rate[k]);
        }
        let later = time.iter().position(|t| *t > time[restart] + 12.0).unwrap();
        // the gaps of its shifts are made up
        assert!(speed[later] > 0.8 * desired[later], "{} {}", speed[later], desired[later]);
    }
}

#[test]
fn launch_ramp_a_truck_is_never_pushed_much_harder_than_its_driver_wants() {
    // climbs that end while the truck starts, and a descent that pulls it
    let climb = [[0.05; 20], [0.02; 20]].concat();
    let crest = [[0.05; 80], [0.0; 80]].concat();
    let descent = vec![-0.08];
    for slopes in [climb, crest, descent] {
        for acceleration in [0.25, 0.5] {
            let study =
                typical(&[&format!("driver.speed_change.acceleration_mps2={acceleration}")]);
            // the climb ends 5 m behind the line
            let road = GivenRoad { slopes: slopes.clone(), ..GivenRoad::flat(3000.0, 22.0) };
            let road = road.stop(495.0, 5.0).stop(1990.0, 5.0);
            let trace = trace_scenario(&study, road.scenario(&study));
            assert_eq!(trace.record.outcome, Outcome::Completed);
            let [rate, speed] = ["acceleration_mps2", "speed_mps"].map(|name| column(&trace, name));
            // before the first upshift: while the gearbox shifts, no engine drags on a descent
            let starts = rate.iter().zip(speed).filter(|(_, speed)| **speed < 3.4);
            let most = starts.fold(0.0_f64, |most, (rate, _)| most.max(*rate));
            let ratio = most / acceleration;
            // half as much again as the driver's, and he lifts his foot at 1.2 of that
            assert!((1.0..1.81).contains(&ratio), "{slopes:?} {acceleration}: {ratio}");
        }
    }
}

#[test]
fn grip_traction_is_what_the_driven_axles_hold() {
    // full pedal in first gear on snow, empty and full: 0.4 of the weight on the driven axle
    for (payload_kg, share) in [(0.0, 0.29), (24_750.0, 0.25)] {
        let study = typical(&["driver.speed_change.peak_acceleration_ratio=100"]);
        let road = GivenRoad { payload_kg, ..GivenRoad::flat(500.0, 50.0 / 3.6).slope(0.051) };
        let mut scenario = road.scenario(&study);
        scenario.driver.speed_change.rise = Rise::Paper;
        let weather = &mut scenario.cycle.weather[0].weather;
        (weather.precipitation_mps, weather.snow) = (1e-7, true);
        let grip_n = 0.4 * share * scenario.vehicle.mass_kg * 9.80665;
        let trace = trace_scenario(&study, scenario);
        let [wheel, way] =
            ["wheel_energy_added_j", "distance_added_m"].map(|name| column(&trace, name));
        let most_n = (0..way.len()).filter(|k| way[*k] > 0.1).map(|k| wheel[k] / way[k]);
        let most_n = most_n.fold(0.0, f64::max);
        assert!((0.97 * grip_n..1.0001 * grip_n).contains(&most_n), "{most_n} {grip_n}");
    }
}

#[test]
fn feed_forward_a_truck_follows_its_braking_ramp() {
    for (payload_kg, slope) in [(0.0, 0.0), (24_300.0, -0.02), (24_300.0, 0.01)] {
        let study = typical(&[]);
        let flat = GivenRoad::flat(3000.0, 80.0 / 3.6).slope(slope);
        let road = GivenRoad { payload_kg, ..flat }.stop(2500.0, 5.0);
        let trace = trace_scenario(&study, road.scenario(&study));
        let [step, position, speed, desired] =
            ["step_s", "position_m", "speed_mps", "desired_speed_mps"]
                .map(|name| column(&trace, name));
        let stood = step.iter().position(|dt| *dt == 5.0).unwrap();
        assert!((0.5..1.3).contains(&speed[stood - 1]), "{}", speed[stood - 1]);
        let ramp = (1..stood).filter(|k| position[*k] > 2350.0 && position[*k] < 2490.0);
        for k in ramp {
            // a row has the desired speed of its start
            let excess = speed[k - 1] - desired[k];
            assert!(excess.abs() < 0.5, "{slope}, {} m: {excess} m/s", position[k]);
        }
    }
}

#[test]
fn overspeed_band_no_pedal_or_gear_chatter_on_a_smooth_descent() {
    for share in ["1.0", "0.0"] {
        let study = typical(&[&format!("driver.pedals.pid_share={share}")]);
        for slope in [-0.01, -0.02, -0.03, -0.05] {
            let road = GivenRoad::flat(10_000.0, 80.0 / 3.6).slope(slope);
            let trace = trace_scenario(&study, road.scenario(&study));
            // without the launch and the final stop, which have shifts and brakes of their own
            let brake = column(&trace, "brake");
            let position = column(&trace, "position_m");
            let gear = column(&trace, "gear");
            let inside: Vec<usize> =
                (0..brake.len()).filter(|&k| (2000.0..9000.0).contains(&position[k])).collect();
            let brakes: Vec<f64> = inside.iter().map(|&k| brake[k]).collect();
            let changes = inside.windows(2).filter(|w| gear[w[0]] != gear[w[1]]).count();
            assert!(presses(&brakes) <= 1, "share {share} slope {slope}: {}", presses(&brakes));
            assert!(changes <= 1, "share {share} slope {slope}: {changes} shifts");
        }
    }
}

#[test]
fn overspeed_band_saves_the_brakes_on_gentle_descents() {
    let with = unassisted(&[]);
    let without = unassisted(&["driver.pedals.overspeed_band_mps=0"]);
    // a descent on which a coasting truck settles between 80 and 85 km/h
    let road = GivenRoad::flat(10_000.0, 80.0 / 3.6).slope(-0.01365);
    let braked = |study: &ocmc_core::study::Study| {
        let trace = trace_scenario(study, road.scenario(study));
        let position = column(&trace, "position_m");
        let service = column(&trace, "service_brake_energy_added_j");
        let engine = column(&trace, "engine_brake_energy_added_j");
        let inside = (0..position.len()).filter(|&k| (2000.0..9000.0).contains(&position[k]));
        inside.map(|k| service[k] + engine[k]).sum::<f64>()
    };
    let (a, b) = (braked(&with), braked(&without));
    assert!(b > 1e6 && a < 0.2 * b, "{a} {b}");
    let trace = trace_scenario(&with, road.slope(-0.03).scenario(&with));
    let fastest = column(&trace, "speed_mps").iter().fold(0.0, |a: f64, b| a.max(*b));
    assert!(fastest < (80.0 + 5.0 + 2.0) / 3.6, "{fastest}");
}

#[test]
fn overspeed_band_ends_where_a_ramp_to_a_lower_speed_begins() {
    // a driver without integral and derivative part: u = K_P (v_desired - v), and the brake pedal
    // is 0.3 of it below zero
    let study = typical(&[
        "driver.pedals.pid.integral_time_median_s=0",
        "driver.pedals.pid.derivative_median=0",
        "driver.pedals.feed_forward=false",
        "driver.pedals.brake_tolerance_mps=0",
        "simulation.step_s=0.02",
    ]);
    // a descent on which a coasting truck gets faster
    let road = GivenRoad::flat(3000.0, 80.0 / 3.6).slope(-0.02).stop(2500.0, 5.0);
    let scenario = road.scenario(&study);
    let gain = scenario.driver.pedals.proportional;
    let band_mps = study.model().driver.pedals.overspeed_band_mps;
    let trace = trace_scenario(&study, scenario);
    let [desired, speed, brake] =
        ["desired_speed_mps", "speed_mps", "brake"].map(|name| column(&trace, name));
    let top_mps = desired.iter().fold(0.0, |a: f64, b| a.max(*b));
    let (mut before, mut ramp) = (0, 0);
    for k in 1..speed.len() - 1 {
        // above the speed from which there is a band, and faster than wanted
        let over_mps = speed[k] - desired[k + 1];
        if speed[k].min(speed[k - 1]) < 15.0 || over_mps <= 0.01 {
            continue;
        }
        if desired[k].min(desired[k + 1]) == top_mps {
            assert!(over_mps > band_mps - 0.01 || brake[k] == 0.0, "{over_mps} {}", brake[k]);
            before += 1;
        } else if desired[k].max(desired[k + 1]) < top_mps {
            let wanted = 0.3 * gain * over_mps;
            assert!((brake[k] - wanted).abs() < 0.01 * wanted + 1e-3, "{wanted} {}", brake[k]);
            ramp += 1;
        }
    }
    assert!(before > 100 && ramp > 100, "{before} {ramp}");
}

#[test]
fn stop_capture_trucks_arrive_slowly_and_stop_at_the_line() {
    let study = study("regional", &["mission.length_m=20000"]);
    let mut arrivals = Vec::new();
    for id in 0..20 {
        let trace = ocmc_core::kernel::drive::trace::trace(&study, 1, id);
        let speed = column(&trace, "speed_mps");
        let booked = column(&trace, "service_brake_energy_added_j");
        let driven = column(&trace, "simulated_added_s");
        for k in 1..speed.len() {
            // a row of a stop takes no simulated time
            if driven[k] == 0.0 {
                arrivals.push(speed[k - 1]);
                assert!(booked[k] > 0.0 || speed[k - 1] == 0.0);
            }
        }
        // a thousand steps are summed up, each rounded to 4e-12 m at most
        let distance_m = trace.record.distance_m;
        assert!(distance_m > 20_000.0 - 3.0 && distance_m < 20_000.0 + 1e-8, "{distance_m}");
    }
    arrivals.sort_by(f64::total_cmp);
    let median = arrivals[arrivals.len() / 2];
    // sqrt(2 x 0.6 x 0.5) = 0.8 m/s is wanted half a metre before the line
    assert!(arrivals.len() > 40 && (0.5..1.3).contains(&median), "{median}");
    assert!(arrivals[arrivals.len() - 1] < 2.0, "{arrivals:?}");
}

#[test]
fn stop_capture_who_stops_beyond_the_end_of_a_segment_has_left_it() {
    // a truck that comes to rest within a step may pass the segment's end on the way
    for name in ["regional", "passenger-car", "battery-truck"] {
        for record in run(&study(name, &[]), 80) {
            let too_far = record.distance_m - 100_000.0;
            assert!(too_far < 1e-7, "{name}, cycle {}: {too_far} m", record.cycle_id);
        }
    }
}

#[test]
fn stop_capture_who_is_below_creep_speed_three_metres_before_the_line_has_stopped() {
    // a gentle driver, whose ramp has a speed of √(2 × 0.2 × 3) = 1.1 m/s three metres before the
    // line and of 0.45 m/s half a metre before it; a step is at most 0.02 s long
    let stop = |creep_speed_mps: f64, creep_distance_m: f64| {
        let study = typical(&[
            "driver.speed_change.deceleration_mps2=0.2",
            "simulation.step_s=0.02",
            &format!("simulation.creep_speed_mps={creep_speed_mps}"),
            &format!("simulation.creep_distance_m={creep_distance_m}"),
        ]);
        let road = GivenRoad::flat(400.0, 30.0 / 3.6).stop(200.0, 5.0);
        let trace = trace_scenario(&study, road.scenario(&study));
        assert_eq!((trace.record.outcome, trace.record.n_stops), (Outcome::Completed, 1));
        let stood = column(&trace, "step_s").iter().position(|dt| *dt == 5.0).unwrap();
        let [position, speed] =
            ["position_m", "speed_mps"].map(|name| column(&trace, name)[stood - 1]);
        (200.0 - position, speed)
    };
    let short_m = 2.0 * 0.02;
    // slower than the creep speed all along the creep distance: captured where it begins
    for creep_distance_m in [3.0, 2.0] {
        let (left_m, speed_mps) = stop(2.0, creep_distance_m);
        let begin = creep_distance_m - short_m..=creep_distance_m;
        assert!(begin.contains(&left_m) && speed_mps < 2.0, "{left_m} {speed_mps}");
    }
    // never slower: captured half a metre before the line, as without a creep distance
    for (creep_speed_mps, creep_distance_m) in [(0.0, 3.0), (2.0, 0.5)] {
        let (left_m, speed_mps) = stop(creep_speed_mps, creep_distance_m);
        assert!((0.5 - short_m..=0.5).contains(&left_m), "{left_m}");
        assert!(speed_mps > 0.3, "{speed_mps}");
    }
}

#[test]
fn torque_during_a_shift_the_engine_drives_the_auxiliaries_only() {
    let study = study("field-truck", &["mission.length_m=20000", "driver.pedals.pid_share=1"]);
    let mut shifts = 0;
    for id in 0..5 {
        let trace = ocmc_core::kernel::drive::trace::trace(&study, 1, id);
        let [gear, driven, crankshaft, auxiliary, wheel] = [
            "gear",
            "simulated_added_s",
            "crankshaft_work_added_j",
            "auxiliary_energy_added_j",
            "wheel_energy_added_j",
        ]
        .map(|name| column(&trace, name));
        // at a stop, where no time is driven, the gear to start in is there at once
        let shifts_at =
            |k: &usize| gear[*k] > gear[*k - 1] && driven[*k] > 0.0 && driven[*k - 1] > 0.0;
        for k in (1..gear.len()).filter(shifts_at) {
            let (mut left_s, mut row) = (study.vehicle().shift.duration_s, k);
            while left_s > 1e-9 && row < gear.len() && gear[row] == gear[k] {
                let (work, taken) = (crankshaft[row], auxiliary[row]);
                assert!((work - taken).abs() <= 1e-9 * taken, "{work} {taken}");
                assert_eq!(wheel[row], 0.0);
                left_s -= driven[row];
                row += 1;
            }
            assert!(left_s > -1e-9, "the step is cut where the shift ends: {left_s}");
            shifts += 1;
        }
    }
    assert!(shifts > 50, "{shifts}");
}

#[test]
fn launch_clutch_slips_until_the_gear_has_come_to_the_engines_speed() {
    // where the pedal asks for less than the auxiliaries take, the wheels of a truck that starts
    // must not drive them
    let hardly = "driver.speed_change.launch_speed_mps=0.5";
    let length = "mission.length_m=20000";
    let mut slipped_j = 0.0;
    for (name, sets) in [
        ("field-truck", &[length][..]),
        ("urban-delivery", &[length]),
        ("passenger-car", &[length]),
        ("field-truck", &[length, hardly]),
    ] {
        let study = study(name, sets);
        for id in 0..10 {
            let trace = ocmc_core::kernel::drive::trace::trace(&study, 1, id);
            for lost_j in column(&trace, "clutch_loss_added_j") {
                // the gear is up to a thousandth of a step faster where the step ends
                assert!(*lost_j > -1.0, "{name}, cycle {id}: {lost_j} J");
                slipped_j += lost_j;
            }
        }
    }
    assert!(slipped_j > 1e6);
}

#[test]
fn stall_an_undrivable_climb_is_an_outcome() {
    let study = typical(&[
        "road.types.motorway.topography.slope_limit=0.25",
        "vehicle.powertrain.combustion.gearbox.shift.launch_gears=3",
    ]);
    let road = GivenRoad::flat(2000.0, 80.0 / 3.6).slope(0.24).stop(500.0, 1.0);
    let mut scenario = road.scenario(&study);
    scenario.vehicle.mass_kg = 120_000.0;
    let record = drive_scenario(&study, scenario);
    assert_eq!(record.outcome, Outcome::Stalled);
    // it cannot move at all: found after 60 s without a metre, or after twice that
    assert!((60.0..=130.0).contains(&record.duration_s), "{}", record.duration_s);
}

/// How often a driver goes from one pedal to the other.
fn reversals(trace: &Trace) -> usize {
    let (accelerator, brake) = (column(trace, "accelerator"), column(trace, "brake"));
    let pedals = accelerator.iter().zip(brake);
    let pressed: Vec<bool> =
        pedals.filter(|(a, b)| (**a > 0.0) != (**b > 0.0)).map(|(_, b)| *b > 0.0).collect();
    pressed.windows(2).filter(|w| w[0] != w[1]).count()
}

#[test]
fn brake_stability_limit_steps_hardly_add_to_the_reversals_of_the_pedals() {
    let pid = "driver.pedals.pid_share=1.0";
    let study = study("field-truck", &[pid]);
    // steps with which no pedal can swing from step to step
    let short = crate::common::study("field-truck", &[pid, "simulation.step_s=0.02"]);
    let (mut drawn, mut drawn_short) = (0, 0);
    for id in 0..10 {
        let trip = study.sample(1, id);
        let long = reversals(&trace_scenario(&study, trip.clone()));
        let fine = reversals(&trace_scenario(&short, trip));
        assert!(5 * long < 8 * fine + 50, "cycle {id}: {long} {fine}");
        drawn += long;
        drawn_short += fine;
    }
    // one or two a kilometre, made by the hills
    assert!(drawn < 2000 && 10 * drawn < 13 * drawn_short, "{drawn} {drawn_short}");
}

#[test]
fn brake_stability_limit_a_pressed_brake_shortens_the_step() {
    // 5 m/s² x 0.3 x K_P x dt <= 1: with steps of 1.5 s, which nothing else would have shortened,
    // the truck braked 70 times
    let study = typical(&["driver.pedals.pid.proportional_median=0.99"]);
    let road = GivenRoad::flat(4000.0, 30.0 / 3.6).slope(-0.015);
    let trace = trace_scenario(&study, road.scenario(&study));
    let (brake, step) = (column(&trace, "brake"), column(&trace, "step_s"));
    assert!(presses(brake) <= 4, "{}", presses(brake));
    let driven = column(&trace, "simulated_added_s");
    for k in 1..brake.len() {
        let bound = 1.0 / (5.0 * 0.3 * 0.99) + 1e-9;
        assert!(brake[k - 1] == 0.0 || driven[k] == 0.0 || step[k] <= bound, "{}", step[k]);
    }
}

#[test]
fn launch_clutch_does_not_chatter_when_a_truck_comes_to_a_stop() {
    // a driver who touches the accelerator on the way to a stop: a clutch that let go of the
    // braking engine there made him brake, and closed again as he did, thousands of times within a
    // second
    let sharp = ["proportional_median=1.5", "proportional_maximum=2.0"]
        .map(|gain| format!("driver.pedals.pid.{gain}"));
    let study = study("field-truck", &["driver.pedals.pid_share=1.0", &sharp[0], &sharp[1]]);
    for id in [2, 97, 117, 251, 277] {
        let trace = ocmc_core::kernel::drive::trace::trace(&study, 1, id);
        let closed = column(&trace, "clutch_closed");
        let changes = closed.windows(2).filter(|w| w[0] != w[1]).count();
        // at each stop it opens and closes, once more where the truck rolls up to the line
        assert!(changes < 100, "cycle {id}: {changes} for {} stops", trace.record.n_stops);
    }
}

#[test]
fn anti_windup_tracking_no_wind_up_on_a_long_climb() {
    // ten minutes at full throttle; then the road is flat and the truck has to meet its limit
    // without overshoot
    let study = typical(&[]);
    let mut road = GivenRoad::flat(16_000.0, 80.0 / 3.6);
    road.slopes = vec![0.05; 400];
    road.slopes.push(0.0);
    let trace = trace_scenario(&study, road.scenario(&study));
    let fastest = column(&trace, "speed_mps").iter().fold(0.0, |a: f64, b| a.max(*b));
    assert!(fastest < (80.0 + 2.0) / 3.6, "{} km/h", fastest * 3.6);
    // and stops at the end at once
    assert_eq!(trace.record.outcome, Outcome::Completed);
    // a tracking time without bound and a wide clamp bring the wind-up back
    let wound = typical(&[
        "driver.pedals.pid.tracking_ratio=100",
        "driver.pedals.pid.integral_maximum=10",
        "driver.pedals.pid.integral_minimum=-10",
    ]);
    let trace = trace_scenario(&wound, road.scenario(&wound));
    let wound = column(&trace, "speed_mps").iter().fold(0.0, |a: f64, b| a.max(*b));
    assert!(wound > fastest + 0.5, "{wound} {fastest}");
}

#[test]
fn integral_clamp_keeps_a_descents_brake_out_of_the_plain_behind_it() {
    // how far a truck falls below its desired speed behind 3 km of -10 % at 40 km/h, where no band
    // lets it run; in the gear of the plain before it
    let below_mps = |sets: &[&str]| {
        let study = typical(&[sets, &["driver.pedals.brake_tolerance_mps=0"]].concat());
        let mut road = GivenRoad::flat(7000.0, 40.0 / 3.6).stop(6500.0, 5.0);
        road.slopes = [vec![0.0; 40], vec![-0.1; 120], vec![0.0]].concat();
        let trace = trace_scenario(&study, road.scenario(&study));
        assert_eq!(trace.record.outcome, Outcome::Completed);
        let [position, speed, desired] =
            ["position_m", "speed_mps", "desired_speed_mps"].map(|name| column(&trace, name));
        let behind = (0..position.len()).filter(|&k| (4000.0..6000.0).contains(&position[k]));
        behind.map(|k| desired[k] - speed[k]).fold(0.0, f64::max)
    };
    let [clamped, free] = [below_mps(&[]), below_mps(&["driver.pedals.pid.integral_minimum=-10"])];
    assert!(clamped < 0.9 && free > 1.2, "{clamped} {free}");
    // a driver without an integral part has nothing to wind up, and no tracking term, which would
    // divide by zero
    let without = below_mps(&["driver.pedals.pid.integral_time_median_s=0"]);
    assert!(without < clamped, "{without} {clamped}");
}

#[test]
fn held_throttle_a_brake_held_as_printed_costs_fuel() {
    let sets = |hold: &str| {
        study(
            "field-truck",
            &[
                "driver.pedals.pid_share=0.0",
                "driver.pedals.feed_forward=false",
                "driver.pedals.brake_tolerance_mps=0",
                &format!("driver.pedals.switched.hold={hold}"),
            ],
        )
    };
    let fuel = |study: &ocmc_core::study::Study| {
        let records = run(study, 60);
        records.iter().map(|r| r.amount(Carrier::LiquidFuel).unwrap()).sum::<f64>()
            / records.iter().map(|r| r.distance_m).sum::<f64>()
    };
    let (throttle, paper) = (fuel(&sets("throttle")), fuel(&sets("paper")));
    assert!(paper > 1.02 * throttle, "{paper} {throttle}");
}

#[test]
fn upshift_line_shifts_per_km_are_those_of_the_field() {
    let per_km = |name: &str| {
        let records = run(&study(name, &[]), 60);
        records.iter().map(|r| f64::from(r.n_gear_shifts)).sum::<f64>()
            / records.iter().map(|r| r.distance_m / 1000.0).sum::<f64>()
    };
    // judged in advance: about 1 on long haul and 4 on regional roads; it was 1.4 and 2.8, and is
    // 2.3 on regional roads since drivers take bends by the calibrated law, which slows them less
    // often. A strategy that looks at the power of each slope step shifts 38 % more
    for (name, wanted) in [("long-haul", 1.3), ("regional", 2.3)] {
        let found = per_km(name);
        assert!((found / wanted - 1.0).abs() < 0.15, "{name}: {found}");
    }
}

#[test]
fn upshift_line_a_constant_climb_does_not_hunt() {
    let study = typical(&[]);
    for slope in [0.01, 0.02, 0.03, 0.04, 0.05, 0.06] {
        let road = GivenRoad::flat(12_000.0, 80.0 / 3.6).slope(slope);
        let trace = trace_scenario(&study, road.scenario(&study));
        let (gear, position) = (column(&trace, "gear"), column(&trace, "position_m"));
        let inside: Vec<usize> =
            (0..gear.len()).filter(|&k| (4000.0..11_000.0).contains(&position[k])).collect();
        let changes = inside.windows(2).filter(|w| gear[w[0]] != gear[w[1]]).count();
        assert!(changes <= 2, "slope {slope}: {changes} of {} shifts", shifts(&trace));
    }
}

#[test]
fn no_stalled_cycle_in_10_000_of_the_default_study() {
    let records = run(&study("field-truck", &[]), 10_000);
    let failed = records.iter().filter(|r| r.outcome != Outcome::Completed).count();
    assert_eq!(failed, 0);
    // gain law: a redraw of gains is rare
    let redrawn: u32 = records.iter().filter_map(|r| r.driver_gain_redraws).sum();
    assert!(f64::from(redrawn) < 0.2 * records.len() as f64);
    // payload mixture: mean gross about 29 t
    let gross: Vec<f64> = records.iter().map(|r| (15_700.0 + r.payload_kg) / 1000.0).collect();
    let (mean, error) = mean_and_error(&gross);
    // 15.7 + 0.8 x 24.3 x 2/3
    assert!((mean - 28.66).abs() < 4.0 * error, "{mean}");
}

#[test]
fn road_mix_shares_of_the_road_mixes() {
    for (name, printed) in [("field-truck", [0.50, 0.41, 0.09]), ("long-haul", [0.80, 0.17, 0.03])]
    {
        let study = study(name, &[]);
        let shares = study.operating_cycle().road().share_by_length();
        for (share, printed) in shares.iter().zip(printed) {
            assert!((share - printed).abs() < 0.011, "{name}: {shares:?}");
        }
    }
}

/// The mean time from one upward crossing of the mean speed to the next, in s, of a speed that
/// swings; crossings count once the speed has been a quarter of the swing below.
fn period_s(time_s: &[f64], speed_mps: &[f64], low: f64, high: f64) -> f64 {
    let (middle, quarter) = (0.5 * (low + high), 0.25 * (high - low));
    let (mut was_low, mut crossings) = (false, Vec::new());
    for (time, speed) in time_s.iter().zip(speed_mps) {
        was_low |= *speed < middle - quarter;
        if was_low && *speed > middle {
            crossings.push(*time);
            was_low = false;
        }
    }
    let between = crossings.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>();
    between.iter().sum::<f64>() / between.len() as f64
}

#[test]
fn held_throttle_a_steady_limit_is_driven_steadily() {
    // swings of the speed behind the launch and before the end, on the plain and on even grades,
    // of drawn drivers of both kinds: 95 % within 4 km/h, and slow ones where there are any
    for share in ["1", "0"] {
        let [without, kind] = [
            "simulation.without=[\"vehicle_spread\"]".to_owned(),
            format!("driver.pedals.pid_share={share}"),
        ];
        let study = study("field-truck", &[&without, &kind]);
        let (mut swings_kmh, mut periods_s) = (Vec::new(), Vec::new());
        for cycle_id in 0..12 {
            for limit_kmh in [30.0, 50.0, 80.0] {
                for slope in [0.0, 0.015, -0.01] {
                    let road = GivenRoad::flat(12_000.0, limit_kmh / 3.6).slope(slope);
                    let driver = study.sample(1, cycle_id).driver;
                    let trace =
                        trace_scenario(&study, Scenario { driver, ..road.scenario(&study) });
                    let [time, position, speed] =
                        ["time_s", "position_m", "speed_mps"].map(|name| column(&trace, name));
                    let from = position.partition_point(|x| *x < 4000.0);
                    let to = position.partition_point(|x| *x < 11_000.0);
                    let inside = &speed[from..to];
                    let low = inside.iter().copied().fold(f64::INFINITY, f64::min);
                    let high = inside.iter().copied().fold(0.0, f64::max);
                    swings_kmh.push(3.6 * (high - low));
                    // what nobody feels has no period
                    let period_s = period_s(&time[from..to], inside, low, high);
                    if 3.6 * (high - low) > 0.5 && period_s.is_finite() {
                        periods_s.push(period_s);
                    }
                }
            }
        }
        swings_kmh.sort_by(f64::total_cmp);
        periods_s.sort_by(f64::total_cmp);
        let p95 = swings_kmh[swings_kmh.len() * 95 / 100];
        println!(
            "PID share {share}: swings {p95:.2} km/h at 95 %, {:.2} at most, of {}; {} periods \
             {:.1?}",
            swings_kmh[swings_kmh.len() - 1],
            swings_kmh.len(),
            periods_s.len(),
            periods_s.iter().take(5).collect::<Vec<_>>()
        );
        assert!(p95 < 4.0, "{share}: {p95}");
        assert!(periods_s.iter().all(|period_s| *period_s >= 15.0), "{share}: {periods_s:?}");
    }
}
