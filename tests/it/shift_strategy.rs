//! The lines of the gearbox's strategy one by one for the default truck. Gears count from 0 here.

use crate::common::{GivenRoad, column, diesel, study, typical};
use ocmc_core::kernel::drive::trace::{Trace, trace, trace_scenario};
use ocmc_core::powertrain::component::gearbox::ShiftInputs;

/// With half the pedal a gear is entered from 95 + 32/2 rad/s on, and left below 88 + 20/2.
const HALF: f64 = 0.5;
const UP_RADPS: f64 = 111.0;
const DOWN_RADPS: f64 = 98.0;
/// A road on which no engine could hold a higher gear, in W.
const TOO_STEEP_W: f64 = 1e9;
/// A truck without its engine, in kg, and the engine.
const MASS_KG: f64 = 41_000.0;
const INERTIA_KGM2: f64 = 5.15;

#[test]
fn each_line_of_the_strategy() {
    let study = study(
        "field-truck",
        &["vehicle.powertrain.combustion.gearbox.shift.minimum_acceleration_mps2=-10"],
    );
    let drive = diesel(&study);
    let gears = &study.vehicle().gears;
    let full_load_nm = |w: f64| drive.engine.full_load_nm(w);
    // a truck in a gear, whose engine turns so fast, or would in another gear
    let at = |gear, turning, there: usize| shifting(gear, turning / gears[there].speed_ratio_per_m);
    let wanted =
        |inputs: ShiftInputs| drive.gearbox.shift.wanted_gear(&inputs, gears, full_load_nm);
    let slowing = |inputs| ShiftInputs { slowing: true, ..inputs };
    let climbing = |inputs| ShiftInputs { road_power_w: TOO_STEEP_W, ..inputs };

    // up to the highest gear above its line, three steps at most
    assert_eq!(wanted(at(5, UP_RADPS + 0.1, 6)), 6);
    assert_eq!(wanted(at(5, UP_RADPS - 0.1, 6)), 5);
    assert_eq!(wanted(at(5, UP_RADPS + 0.1, 8)), 8);
    assert_eq!(wanted(at(5, UP_RADPS - 0.1, 8)), 7);
    assert_eq!(wanted(at(5, UP_RADPS + 0.1, 9)), 8);
    // the more the pedal is pressed the later
    let pressed = ShiftInputs { pedal: 1.0, ..at(5, 126.9, 6) };
    assert_eq!([wanted(pressed), wanted(ShiftInputs { pedal: 0.99, ..pressed })], [5, 6]);
    // where 95 % of its full power is 119 % of what the road takes
    let turning = UP_RADPS + 0.1;
    let enough_w = 0.95 * full_load_nm(turning) * turning / 1.19;
    for (share, gear) in [(0.999, 6), (1.001, 5)] {
        let road_power_w = share * enough_w;
        assert_eq!(wanted(ShiftInputs { road_power_w, ..at(5, turning, 6) }), gear);
    }
    // up by one where the engine turns too fast, whatever the road takes; there is nothing above
    // the top
    assert_eq!([wanted(climbing(at(5, 219.1, 5))), wanted(climbing(at(5, 218.9, 5)))], [6, 5]);
    assert_eq!(wanted(climbing(at(11, 230.0, 11))), 11);

    // down where a slowing truck falls below its line, to the highest gear above the line up
    assert_eq!(wanted(slowing(at(8, DOWN_RADPS - 0.1, 8))), 7);
    assert_eq!(wanted(slowing(at(8, DOWN_RADPS + 0.1, 8))), 8);
    assert_eq!(wanted(at(8, DOWN_RADPS - 0.1, 8)), 8);
    assert_eq!(wanted(slowing(at(8, 60.0, 8))), 5);
    // a pedal to the floor for two seconds, while the truck slows
    let kicked = |turning| ShiftInputs { kickdown: true, pedal: 1.0, ..at(8, turning, 8) };
    assert_eq!(wanted(climbing(slowing(kicked(135.9)))), 7);
    assert_eq!(wanted(climbing(slowing(kicked(136.1)))), 8);
    assert_eq!(wanted(climbing(kicked(135.9))), 8);

    // nothing below half a metre a second
    let crawling = ShiftInputs { speed_mps: 0.49, ..at(2, 1.0, 2) };
    assert_eq!(wanted(slowing(crawling)), 2);

    // what a shift a short time ago or the driver's brake forbids; an engine below idle is shifted
    // down all the same
    let no_up = ShiftInputs { may_up: false, ..at(5, UP_RADPS + 0.1, 6) };
    assert_eq!(wanted(no_up), 5);
    let no_down = |turning| ShiftInputs { may_down: false, ..slowing(at(8, turning, 8)) };
    assert_eq!([wanted(no_down(62.9)), wanted(no_down(62.7))], [8, 5]);
}

#[test]
fn shift_look_ahead_an_upshift_leaves_some_acceleration_behind_its_gap() {
    let study = study("field-truck", &[]);
    let drive = diesel(&study);
    let gears = &study.vehicle().gears;
    let full_load_nm = |w: f64| drive.engine.full_load_nm(w);
    let wanted = |road_n: f64| {
        let speed_mps = 112.0 / gears[9].speed_ratio_per_m;
        let inputs = ShiftInputs { road_power_w: road_n * speed_mps, ..shifting(8, speed_mps) };
        drive.gearbox.shift.wanted_gear(&inputs, gears, full_load_nm)
    };
    // the force on the road for which the truck, a second later and slower, has 0.1 m/s² left
    let left = |road_n: f64| {
        let per_m = gears[9].speed_ratio_per_m;
        let after_mps = 112.0 / per_m - road_n / MASS_KG;
        let mass_kg = MASS_KG + INERTIA_KGM2 * per_m * per_m;
        (0.95 * full_load_nm(per_m * after_mps) * per_m - road_n) / mass_kg - 0.1
    };
    let (mut low, mut high) = (0.0, 60_000.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if left(middle) > 0.0 { low = middle } else { high = middle }
    }
    assert!((10_000.0..20_000.0).contains(&low), "{low}");
    assert_eq!([wanted(0.999 * low), wanted(1.001 * low)], [9, 8]);
}

/// A truck that moves on in a gear with half the pedal, without anything that forbids a shift.
fn shifting(gear: usize, speed_mps: f64) -> ShiftInputs {
    ShiftInputs {
        gear,
        speed_mps,
        pedal: HALF,
        slowing: false,
        kickdown: false,
        closed: true,
        road_power_w: 0.0,
        may_up: true,
        may_down: true,
        idle_radps: 62.83,
        mass_kg: MASS_KG,
        inertia_kgm2: INERTIA_KGM2,
    }
}

#[test]
fn shift_interval_two_seconds_lie_between_shifts() {
    let study = study("regional", &[]);
    for id in 0..10 {
        let trace = trace(&study, 1, id);
        let (gear, time) = (column(&trace, "gear"), column(&trace, "time_s"));
        let driven = column(&trace, "simulated_added_s");
        let mut shifted_at_s = f64::NEG_INFINITY;
        for k in 1..gear.len() {
            if driven[k] == 0.0 {
                // at a stop the gear to start in is chosen at once
                shifted_at_s = f64::NEG_INFINITY;
            } else if gear[k] != gear[k - 1] && driven[k - 1] > 0.0 {
                let between = time[k - 1] - shifted_at_s;
                assert!(between > 2.0 - 1e-9, "cycle {id}: {between} s before {} s", time[k]);
                shifted_at_s = time[k - 1];
            }
        }
    }
}

/// Rows of a trace from which on a higher gear is engaged while the truck drives.
fn upshifts(trace: &Trace) -> Vec<usize> {
    let [gear, driven] = ["gear", "simulated_added_s"].map(|name| column(trace, name));
    let up = |k: &usize| gear[*k] > gear[*k - 1] && driven[*k] > 0.0 && driven[*k - 1] > 0.0;
    (1..gear.len()).filter(up).collect()
}

#[test]
fn shift_interval_counts_from_the_shifts_beginning() {
    // gears that are shifted one by one as soon as the interval is over: the torque is gone for
    // half of it
    for (duration_s, interval_s) in [(1.0, 2.0), (1.5, 3.0)] {
        let study = typical(&[
            "vehicle.powertrain.combustion.gearbox.shift.most_steps=1",
            "vehicle.powertrain.combustion.gearbox.shift.up_speed_radps=60",
            "vehicle.powertrain.combustion.gearbox.shift.up_pedal_radps=1",
            "vehicle.powertrain.combustion.gearbox.shift.down_speed_radps=50",
            "vehicle.powertrain.combustion.gearbox.shift.down_pedal_radps=0",
            &format!("vehicle.powertrain.combustion.gearbox.shift.duration_s={duration_s}"),
            &format!("vehicle.powertrain.combustion.gearbox.shift.interval_s={interval_s}"),
        ]);
        // downhill and without payload: speed and power never lack
        let road = GivenRoad { payload_kg: 0.0, ..GivenRoad::flat(1500.0, 22.0).slope(-0.03) };
        let trace = trace_scenario(&study, road.scenario(&study));
        let time = column(&trace, "time_s");
        let at: Vec<f64> = upshifts(&trace).iter().map(|k| time[k - 1]).collect();
        let between: Vec<f64> = at.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let shortest = between.iter().copied().fold(f64::INFINITY, f64::min);
        // counted from a shift's end the shortest would be longer by the shift
        let allowed = interval_s - 1e-9..interval_s + 0.5 * duration_s;
        assert!(allowed.contains(&shortest), "{interval_s}: {between:?}");
    }
}

#[test]
fn upshift_line_a_step_ends_where_the_engine_reaches_the_line_of_the_next_gear() {
    // without it a shift came up to a whole step too late. Nothing but the line holds a shift back
    let study = typical(&[
        "vehicle.powertrain.combustion.gearbox.shift.duration_s=0",
        "vehicle.powertrain.combustion.gearbox.shift.interval_s=0",
        "vehicle.powertrain.combustion.gearbox.shift.most_steps=1",
        "vehicle.powertrain.combustion.gearbox.shift.up_pedal_radps=0",
        "simulation.step_s=2.0",
    ]);
    let gears = &study.vehicle().gears;
    let mut shifts = 0;
    for slope in [0.0, -0.01, 0.005] {
        let road = GivenRoad { payload_kg: 5000.0, ..GivenRoad::flat(4000.0, 22.0).slope(slope) };
        let trace = trace_scenario(&study, road.scenario(&study));
        let [speed, gear, step] = ["speed_mps", "gear", "step_s"].map(|name| column(&trace, name));
        for k in upshifts(&trace) {
            let up = |speed_mps: f64| speed_mps * gears[gear[k] as usize - 1].speed_ratio_per_m;
            let (before, after) = (up(speed[k - 2]), up(speed[k - 1]));
            // where the line was passed already, the row before was a shift, too; a step that
            // something else has cut before may be short
            if before < 95.0 && step[k - 1] > 0.01 {
                // cut where the speed would be at the acceleration of the step's start; the torque
                // grows within it. Uncut, a step of 2 s would end 10 rad/s beyond the line and more
                let beyond = (after - 95.0) / (after - before);
                assert!((0.0..0.4).contains(&beyond), "{before} {after} in {} s", step[k - 1]);
                shifts += 1;
            }
        }
    }
    assert!(shifts >= 10, "{shifts}");
}

#[test]
fn kickdown_counts_a_pressed_pedal_from_where_the_torque_is_back() {
    // a loaded truck on a climb that it cannot take in any high gear; the lines of engine speed
    // alone do not shift it down
    let study = typical(&[
        "vehicle.powertrain.combustion.gearbox.shift.down_speed_radps=60",
        "vehicle.powertrain.combustion.gearbox.shift.down_pedal_radps=0",
        "vehicle.powertrain.combustion.gearbox.shift.interval_s=0",
        "vehicle.powertrain.combustion.gearbox.shift.opposite_interval_s=0",
        "vehicle.powertrain.combustion.gearbox.shift.kickdown_speed_radps=210",
    ]);
    let mut road = GivenRoad::flat(4000.0, 80.0 / 3.6);
    road.slopes = vec![0.0; 80];
    road.slopes.push(0.06);
    let trace = trace_scenario(&study, road.scenario(&study));
    let [gear, time] = ["gear", "time_s"].map(|name| column(&trace, name));
    let position = column(&trace, "position_m");
    let climbing = (1..gear.len()).filter(|k| (2000.0..3800.0).contains(&position[*k]));
    let at: Vec<f64> = climbing.filter(|k| gear[*k] < gear[*k - 1]).map(|k| time[k - 1]).collect();
    let between: Vec<f64> = at.windows(2).map(|pair| pair[1] - pair[0]).collect();
    // 0.6 s without torque, and two seconds with the pedal down; a step more until it is seen
    let shortest = between.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((2.6 - 1e-9..4.6).contains(&shortest) && at.len() >= 3, "{between:?}");
}

#[test]
fn start_gear_a_truck_starts_in_third_gear_and_in_first_on_a_climb() {
    let study = typical(&[]);
    for (slope, first) in [(0.0, 3.0), (0.049, 3.0), (0.051, 1.0)] {
        let road = GivenRoad::flat(500.0, 50.0 / 3.6).slope(slope);
        let trace = trace_scenario(&study, road.scenario(&study));
        assert_eq!(column(&trace, "gear")[0], first, "slope {slope}");
    }
}

/// Shifts while a truck drives, as times and directions, and standstills, without a direction.
fn shifts(trace: &Trace) -> Vec<(f64, f64)> {
    let [gear, driven, time] =
        ["gear", "simulated_added_s", "time_s"].map(|name| column(trace, name));
    let drives = |k: usize| driven[k] > 0.0 && driven[k - 1] > 0.0;
    let at = |k: usize| match gear[k] - gear[k - 1] {
        _ if !drives(k) => Some((time[k - 1], 0.0)),
        0.0 => None,
        change => Some((time[k - 1], change.signum())),
    };
    (1..gear.len()).filter_map(at).collect()
}

/// Pairs of opposite shifts within 10 s, without a standstill between them.
fn opposite(shifts: &[(f64, f64)]) -> usize {
    let hunts = |pair: &&[(f64, f64)]| pair[1].1 * pair[0].1 < 0.0 && pair[1].0 - pair[0].0 <= 10.0;
    shifts.windows(2).filter(hunts).count()
}

#[test]
fn shift_look_ahead_no_driver_hunts_at_30_km_h_on_4_percent() {
    for kind in ["1", "0"] {
        for gain in [0.2, 0.3, 0.47, 0.7, 1.0] {
            let study = typical(&[
                &format!("driver.pedals.pid_share={kind}"),
                &format!("driver.pedals.pid.proportional_median={gain}"),
                &format!("driver.pedals.switched.proportional={gain}"),
            ]);
            let road = GivenRoad::flat(6000.0, 30.0 / 3.6).slope(0.04);
            let trace = trace_scenario(&study, road.scenario(&study));
            let shifts = shifts(&trace);
            let hunting = opposite(&shifts);
            assert!(hunting == 0 && shifts.len() < 20, "{kind} {gain}: {shifts:?}");
        }
    }
}

#[test]
fn shift_look_ahead_a_fleet_hardly_hunts() {
    // with those shifts that a new limit or a change of grade explains
    let hunting = |name: &str, sets: &[&str]| -> (usize, usize) {
        let study = study(name, sets);
        let all: Vec<Vec<(f64, f64)>> = (0..30).map(|id| shifts(&trace(&study, 1, id))).collect();
        let n = all.iter().flatten().filter(|shift| shift.1 != 0.0).count();
        (all.iter().map(|shifts| opposite(shifts)).sum(), n)
    };
    for name in ["field-truck", "long-haul", "regional"] {
        let (hunting, n) = hunting(name, &[]);
        assert!(n > 2000 && 100 * hunting < n, "{name}: {hunting} of {n}");
    }
    let (hunting, n) = hunting(
        "field-truck",
        &["vehicle.powertrain.combustion.gearbox.shift.opposite_interval_s=0"],
    );
    assert!(50 * hunting > n, "{hunting} of {n}");
}
