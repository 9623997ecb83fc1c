//! The lines of the gearbox's strategy one by one for the default truck. Gears count from 0 here.

use crate::common::{GivenRoad, column, diesel, study, typical};
use ocmc_core::kernel::trace::{trace, trace_scenario};
use ocmc_core::powertrain::gearbox::ShiftInputs;

/// With half the pedal a gear is entered from 95 + 32/2 rad/s on, and left below 88 + 20/2.
const HALF: f64 = 0.5;
const UP_RADPS: f64 = 111.0;
const DOWN_RADPS: f64 = 98.0;
/// A road on which no engine could hold a higher gear, in W.
const TOO_STEEP_W: f64 = 1e9;

#[test]
fn each_line_of_the_strategy() {
    let study = study("field-truck", &[]);
    let drive = diesel(&study);
    let gears = &study.vehicle().gears;
    let full_load_nm = |w: f64| drive.engine.full_load_nm(w);
    // a truck in a gear, whose engine turns so fast, or would in another gear
    let at = |gear: usize, turning: f64, there: usize| ShiftInputs {
        gear,
        speed_mps: turning / gears[there].speed_ratio_per_m,
        pedal: HALF,
        slowing: false,
        kickdown: false,
        closed: true,
        road_power_w: 0.0,
    };
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
    // where 95 % of its full power is 110 % of what the road takes
    let turning = UP_RADPS + 0.1;
    let enough_w = 0.95 * full_load_nm(turning) * turning / 1.1;
    for (share, gear) in [(0.999, 6), (1.001, 5)] {
        let road_power_w = share * enough_w;
        assert_eq!(wanted(ShiftInputs { road_power_w, ..at(5, turning, 6) }), gear);
    }
    // up by one where the engine turns too fast, whatever the road takes; there is nothing above the top
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

#[test]
fn start_gear_a_truck_starts_in_third_gear_and_in_first_on_a_climb() {
    let study = typical(&[]);
    for (slope, first) in [(0.0, 3.0), (0.049, 3.0), (0.051, 1.0)] {
        let road = GivenRoad::flat(500.0, 50.0 / 3.6).slope(slope);
        let trace = trace_scenario(&study, road.scenario(&study));
        assert_eq!(column(&trace, "gear")[0], first, "slope {slope}");
    }
}
