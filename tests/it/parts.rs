//! Turning a part off changes the records, in the physically right direction.

use crate::common::{mean_and_error, run, sd, study};
use ocmc_core::energy::Carrier;
use ocmc_core::record::Record;

const CYCLES: u64 = 300;

fn without(part: &str) -> Vec<Record> {
    run(&study("field-truck", &[&format!("simulation.without=[\"{part}\"]")]), CYCLES)
}

fn litres(records: &[Record]) -> Vec<f64> {
    records.iter().map(|r| r.consumption(Carrier::LiquidFuel).unwrap()).collect()
}

/// Paired mean difference b − a and its standard error.
fn paired(a: &[Record], b: &[Record], value: fn(&Record) -> f64) -> (f64, f64) {
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| value(b) - value(a)).collect();
    mean_and_error(&differences)
}

#[test]
fn each_part_matters_in_the_right_direction() {
    let all = run(&study("field-truck", &[]), CYCLES);
    let fuel: fn(&Record) -> f64 = |r| r.consumption(Carrier::LiquidFuel).unwrap();
    let time: fn(&Record) -> f64 = |r| r.duration_s;
    // without slope, curves, stops and bumps a truck brakes less: less fuel
    for part in ["slope", "curves", "stop_signs", "give_ways", "traffic_lights", "speed_bumps"] {
        let (difference, error) = paired(&all, &without(part), fuel);
        assert!(difference < -2.0 * error, "{part}: {difference} +- {error}");
    }
    // without signs, stops and traffic it is faster
    for part in ["signs", "curves", "stop_signs", "give_ways", "traffic_lights", "traffic"] {
        let (difference, error) = paired(&all, &without(part), time);
        assert!(difference < -2.0 * error, "{part}: {difference} s +- {error}");
    }
    // the climate's mean is 8 degC with wind and rain; still dry air at 15 degC resists less
    let (difference, error) = paired(&all, &without("weather"), fuel);
    assert!(difference < -2.0 * error, "weather: {difference} +- {error}");
    // a fleet of equal payloads varies less
    let equal = without("payload_spread");
    assert!(sd(&litres(&equal)) < 0.8 * sd(&litres(&all)));
    assert!(equal.iter().all(|r| r.payload_kg == equal[0].payload_kg));
    // equal drivers and equal trucks
    let equal = without("driver_spread");
    assert!(
        equal.iter().all(|r| r.driver_kp == equal[0].driver_kp && r.driver_effect == Some(0.0))
    );
    assert!(paired(&all, &equal, fuel).0 != 0.0);
    let equal = without("vehicle_spread");
    assert!(equal.iter().all(|r| r.drag_area_m2 == equal[0].drag_area_m2));
    assert!(paired(&all, &equal, fuel).0 != 0.0);
}

#[test]
fn january_differs_from_july_and_rush_hour_from_night() {
    let on_day = |day: u32| {
        run(&study("field-truck", &[&format!("mission.departure_day_of_year={day}")]), CYCLES)
    };
    let (january, july) = (on_day(15), on_day(196));
    let (difference, error) =
        paired(&july, &january, |r| r.consumption(Carrier::LiquidFuel).unwrap());
    assert!(difference > 4.0 * error, "{difference} +- {error}");
    let (colder, _) = paired(&july, &january, |r| r.air_temperature_k);
    assert!(colder < -10.0);

    let at = |hour: u32| {
        run(
            &study("field-truck", &[&format!("mission.departure_s_of_day={}", hour * 3600)]),
            CYCLES,
        )
    };
    let (night, rush) = (at(1), at(7));
    let (difference, error) = paired(&night, &rush, |r| r.duration_s);
    assert!(difference > 4.0 * error, "{difference} s +- {error}");
}

#[test]
fn traffic_and_weather_hold_over_blocks_of_any_length() {
    // seven blocks of 90.7 s, divided by 90.7 s, are less than seven in floating-point numbers
    for step_s in [10.3, 90.7, 100.1, 300.0, 2999.9] {
        let study = study("field-truck", &[&format!("traffic.step_s={step_s}")]);
        for id in 0..5 {
            let cycle = study.sample(1, id).cycle;
            let blocks = (cycle.free_flow_s / step_s).ceil() as usize;
            let stretches = cycle.weather.len();
            // a block that begins and ends at a stop has no road
            assert!((1..=blocks).contains(&stretches), "{step_s}: {stretches} of {blocks}");
            assert!(stretches as f64 > 0.5 * blocks as f64, "{step_s}: {stretches} of {blocks}");
            assert!(cycle.weather.is_sorted_by(|a, b| a.start_m <= b.start_m), "{step_s}");
            assert!(cycle.traffic.is_sorted_by(|a, b| a.start_m <= b.start_m), "{step_s}");
        }
    }
}

#[test]
fn parts_off_leave_the_other_draws_alone() {
    let all = run(&study("field-truck", &[]), 40);
    for part in [
        "slope",
        "curves",
        "signs",
        "weather",
        "traffic",
        "payload_spread",
        "driver_spread",
        "vehicle_spread",
    ] {
        let fewer = without(part);
        for (a, b) in all.iter().zip(&fewer) {
            assert!(part == "payload_spread" || a.payload_kg == b.payload_kg);
            assert!(part == "driver_spread" || a.driver_kp == b.driver_kp);
            assert!(part == "vehicle_spread" || a.drag_area_m2 == b.drag_area_m2);
            assert!(
                a.urban_share == b.urban_share && a.departure_s_of_year == b.departure_s_of_year
            );
            // changes within a millimetre are one segment, so the sum of the climbs differs a
            // little
            assert!(part == "slope" || (a.climb_m - b.climb_m).abs() < 1e-2);
            assert!(part == "curves" || a.n_curves == b.n_curves);
        }
    }
}
