//! The planner on missions that are made up.

use super::*;
use crate::engine_b::engine_b;
use ocmc_core::energy::ledger::Term;
use ocmc_core::powertrain::component::gearbox::GearboxModel;
use ocmc_core::powertrain::{Powertrain, ShiftConvention, TruckInputs};
use ocmc_core::prescribed::follow;
use ocmc_core::vehicle::resistance::DragBySpeed;

const RADIUS_M: f64 = 0.492;
const KMPH: f64 = 1.0 / 3.6;

fn powertrain() -> CombustionPowertrain {
    let gearbox: GearboxModel = serde_json::from_value(serde_json::json!({
        "ratio": [14.93, 11.64, 9.02, 7.04, 5.64, 4.4, 3.39, 2.65, 2.05, 1.6, 1.28, 1.0],
        "loss_torque_nm": 5.06, "loss_torque_nms": 0.0483, "direct_loss_share": 0.005,
        "indirect_loss_share": 0.02, "retarder_torque_nm": 0.0, "axle_ratio": 2.59,
        "axle_loss_torque_nm": 40.0, "axle_loss_share": 0.015,
        "shift": { "duration_s": 1.0, "interval_s": 2.0, "minimum_speed_mps": 0.5,
            "opposite_interval_s": 10.0, "before_ramp_s": 4.0, "minimum_acceleration_mps2": 0.1,
            "up_speed_radps": 95.0, "up_pedal_radps": 32.0, "down_speed_radps": 88.0,
            "down_pedal_radps": 20.0, "overspeed_radps": 219.0, "power_share": 0.95,
            "power_reserve": 1.1, "most_steps": 3, "kickdown_pedal": 0.99, "kickdown_s": 2.0,
            "kickdown_speed_radps": 136.0, "start_gear": 1, "steep_start_gear": 1,
            "steep_slope": 0.05, "launch_gears": 12, "launch_speed_radps": 66.0,
            "open_share": 0.9 }
    }))
    .unwrap();
    CombustionPowertrain::new(&engine_b(), &gearbox, RADIUS_M, 0.0)
}

fn body(mass_kg: f64) -> Body {
    Body {
        mass_kg,
        wheel_mass_kg: 850.0,
        drag_area_m2: 6.0,
        drag_by_speed: DragBySpeed::NONE,
        rolling_coefficient: 0.0058,
        air_density_kgpm3: 1.188,
    }
}

fn driver() -> VectoDriver {
    VectoDriver::new(AccelerationTable {
        speed_mps: [0.0, 25.0, 50.0, 60.0, 120.0].map(|v| v * KMPH).to_vec(),
        acceleration_mps2: vec![1.0, 1.0, 0.642857143, 0.5, 0.5],
        deceleration_mps2: vec![-1.0, -1.0, -1.0, -0.5, -0.5],
    })
}

/// Rows of a metre; `at`: target in km/h and gradient at a place.
fn mission(length_m: u32, at: impl Fn(u32) -> (f64, f64)) -> Mission {
    let row = |s: u32| {
        let (target_kmph, gradient) = at(s);
        let stop_s = if target_kmph > 0.0 { 0.0 } else { 3.0 };
        let target_mps = target_kmph * KMPH;
        MissionRow { distance_m: f64::from(s), target_mps, gradient, stop_s, auxiliary_w: 0.0 }
    };
    Mission::new(&(0..=length_m).map(row).collect::<Vec<_>>()).unwrap()
}

fn plan_of(mission: &Mission, mass_kg: f64, driver: &VectoDriver) -> Plan {
    plan(mission, &body(mass_kg), &powertrain(), 4000.0, driver)
}

fn means(plan: &Plan) -> impl Iterator<Item = (f64, f64)> + '_ {
    plan.speed_mps.windows(2).map(|pair| (0.5 * (pair[0] + pair[1]), pair[1] - pair[0]))
}

#[test]
fn a_level_road_is_driven_at_one_speed_in_one_gear() {
    let flat = mission(2000, |_| (80.0, 0.0));
    let plan = plan_of(&flat, 30_000.0, &driver());
    assert!(plan.speed_mps.iter().all(|v| (v - 80.0 * KMPH).abs() < 1e-5), "{plan:?}");
    assert!(plan.seconds.iter().all(|second| second.gear == GearOrder::Engaged(11)));
    // the second that is left out at a start on the move, and that in which the mission ends
    let short_m = flat.length_m() - plan.distance_m();
    assert!((0.0..3.0 * 80.0 * KMPH).contains(&short_m), "{short_m}");
    let cycle = plan.drive_cycle().unwrap();
    assert_eq!(cycle.duration_s(), plan.seconds.len() as f64);
    assert_eq!(cycle.gears().len(), plan.speed_mps.len());
}

#[test]
fn a_stop_is_reached_by_the_table_and_the_way_is_covered() {
    let end = |s: u32| if s == 0 || s == 1500 { 0.0 } else { 50.0 };
    let road = mission(1500, |s| (end(s), 0.0));
    let driver = driver();
    let plan = plan_of(&road, 20_000.0, &driver);
    assert!((plan.distance_m() - road.length_m()).abs() < 10.0, "{}", plan.distance_m());
    assert_eq!(plan.speed_mps.last(), Some(&0.0));
    let table = &driver.acceleration;
    for (mean_mps, change) in means(&plan) {
        assert!(change <= table.acceleration_mps2(mean_mps) + 1e-9, "{mean_mps} {change}");
        assert!(change >= table.deceleration_mps2(mean_mps) - 1e-9, "{mean_mps} {change}");
    }
    // at its hardest
    let hard = means(&plan).filter(|(_, change)| (change + 1.0).abs() < 1e-9).count();
    assert!(hard >= 8, "{hard}");
    // a shift has a second without a gear
    let gears: Vec<GearOrder> = plan.seconds.iter().map(|second| second.gear).collect();
    let jumps = gears.windows(2).filter(|pair| match (pair[0], pair[1]) {
        (GearOrder::Engaged(a), GearOrder::Engaged(b)) => a != b,
        _ => false,
    });
    assert_eq!((jumps.count(), plan.shifts() > 4), (0, true));
}

#[test]
fn a_truck_without_reserve_climbs_at_full_load() {
    let hill = mission(3000, |s| (80.0, if s < 300 { 0.0 } else { 0.05 }));
    let (driver, powertrain, body) = (driver(), powertrain(), body(40_000.0));
    let plan = plan(&hill, &body, &powertrain, 4000.0, &driver);
    let slowest_mps = plan.speed_mps.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(slowest_mps < 50.0 * KMPH && slowest_mps > 10.0 * KMPH, "{slowest_mps}");
    let second = plan.seconds.len() - 1;
    let GearOrder::Engaged(gear) = plan.seconds[second].gear else {
        panic!("{:?}", plan.seconds[second]);
    };
    let (mean_mps, change) = means(&plan).last().unwrap();
    let gears = powertrain.gears[gear];
    let turns_radps = gears.speed_ratio_per_m * mean_mps;
    let force_n = (body.mass_kg + body.wheel_mass_kg) * change
        + body.road_forces(mean_mps, sine(0.05)).sum_n();
    let axle_per_m = gears.speed_ratio_per_m / gears.ratio;
    let torque_nm = powertrain.gearbox.input_torque_nm(&gears, axle_per_m, mean_mps, force_n)
        + 4000.0 / turns_radps;
    let share = torque_nm / powertrain.engine.full_load_nm(turns_radps);
    assert!((0.98..1.001).contains(&share), "{share}");
}

#[test]
fn overspeed_is_taken_downhill_and_ends_at_its_bound() {
    let hill = mission(4000, |s| (80.0, if (500..2500).contains(&s) { -0.03 } else { 0.0 }));
    let fastest = |driver: &VectoDriver| {
        plan_of(&hill, 30_000.0, driver).speed_mps.iter().copied().fold(0.0, f64::max) / KMPH
    };
    let without = driver();
    assert!((fastest(&without) - 80.0).abs() < 1e-3);
    let above_mps = 5.0 * KMPH;
    let bound = Overspeed { minimum_speed_mps: 50.0 * KMPH, above_mps };
    let with = VectoDriver { overspeed: Some(bound), ..without };
    assert!((fastest(&with) - 85.0).abs() < 1e-3, "{}", fastest(&with));
}

#[test]
fn looking_ahead_coasts_before_the_ramp() {
    let slower = mission(3000, |s| (if s < 2000 { 80.0 } else { 55.0 }, 0.0));
    let blind = driver();
    let minimum_speed_mps = 50.0 * KMPH;
    let window = LookAhead::Window { deceleration_mps2: -0.5, minimum_speed_mps };
    let decision = LookAhead::DecisionFactor { minimum_speed_mps };
    let at = |look_ahead| {
        let driver = VectoDriver { look_ahead, ..blind.clone() };
        let plan = plan_of(&slower, 30_000.0, &driver);
        plan.speed_mps.iter().filter(|v| **v > 79.9 * KMPH).count()
    };
    let (without, two, three) = (at(None), at(Some(window)), at(Some(decision)));
    assert!(two <= without && three + 3 < without, "{without} {two} {three}");
}

/// Before a stop far ahead the whole coasting is in the gear that the truck had before it: the
/// nodes that it has lowered already do not change the gear of the seconds to come.
#[test]
fn coasting_to_a_stop_stays_in_the_gear_in_which_the_truck_came() {
    let (powertrain, body) = (powertrain(), body(30_000.0));
    let truck = truck::Truck::new(&body, &powertrain);
    let window = LookAhead::Window { deceleration_mps2: -0.5, minimum_speed_mps: 50.0 * KMPH };
    for slope in [0.0, 0.005, 0.01] {
        let road = mission(2000, |s| (if s == 2000 { 0.0 } else { 80.0 }, slope));
        let prepared = |look_ahead| {
            let driver = VectoDriver { look_ahead, ..driver() };
            let mut nodes = road.nodes(&driver.acceleration);
            coasting::prepare(&mut nodes, &road, &truck, &driver, 4000.0);
            nodes.speed_mps
        };
        let (braked, coasted) = (prepared(None), prepared(Some(window)));
        let lowered: Vec<usize> =
            (1..braked.len()).filter(|k| coasted[*k] < braked[*k] - 1e-6).collect();
        assert!(lowered.len() >= 8, "{slope}: {lowered:?}");
        for node in lowered {
            let start_mps = coasted[node - 1];
            let change = coasted[node] - start_mps;
            let top_mps2 = truck.coasting_mps2(11, start_mps, sine(slope), 4000.0);
            assert!((change - top_mps2).abs() < 1e-9, "{slope}, {node}: {change} {top_mps2}");
        }
    }
}

fn deciding_on_the_way() -> VectoDriver {
    let minimum_speed_mps = 50.0 * KMPH;
    VectoDriver {
        look_ahead: Some(LookAhead::DecisionFactor { minimum_speed_mps }),
        overspeed: Some(Overspeed { minimum_speed_mps, above_mps: 5.0 * KMPH }),
        ..driver()
    }
}

/// Ways and speeds at the nodes of a plan.
fn over_way(plan: &Plan) -> Vec<(f64, f64)> {
    let ways = plan.speed_mps.windows(2).scan(0.0, |way_m, pair| {
        *way_m += 0.5 * (pair[0] + pair[1]);
        Some((*way_m, pair[1]))
    });
    std::iter::once((0.0, plan.speed_mps[0])).chain(ways).collect()
}

#[test]
fn who_decides_on_the_way_stops_where_he_has_to() {
    let end = |s: u32| if [0, 1500, 2600].contains(&s) { 0.0 } else { 70.0 };
    let road = mission(2600, |s| (end(s), if s < 700 { 0.01 } else { -0.02 }));
    let driver = deciding_on_the_way();
    let plan = plan_of(&road, 30_000.0, &driver);
    let nodes = over_way(&plan);
    let rests: Vec<f64> =
        nodes.iter().filter(|(_, v)| *v == 0.0).map(|(way_m, _)| *way_m).collect();
    // 3 s at each stop, and the second in which the mission ends
    assert_eq!(rests.len(), 4 + 4 + 5, "{rests:?}");
    for (rest_m, stop_m) in rests.iter().zip([[0.0; 4], [1500.0; 4]].concat()) {
        assert!((rest_m - stop_m).abs() < 0.5, "{rests:?}");
    }
    assert!((plan.distance_m() - 2600.0).abs() < 0.5, "{}", plan.distance_m());
    for (mean_mps, change) in means(&plan) {
        let [most, least] = [
            driver.acceleration.acceleration_mps2(mean_mps),
            driver.acceleration.deceleration_mps2(mean_mps),
        ];
        assert!(change <= most + 1e-9 && change >= least - 0.05, "{mean_mps} {change}");
    }
}

#[test]
fn who_decides_on_the_way_coasts_to_a_stop_by_its_energy() {
    let road = mission(3000, |s| (if s == 3000 { 0.0 } else { 80.0 }, 0.0));
    let (powertrain, body) = (powertrain(), body(20_000.0));
    let plan = plan(&road, &body, &powertrain, 4000.0, &deciding_on_the_way());
    let nodes = over_way(&plan);
    let fast_mps = 80.0 * KMPH;
    let first = nodes.iter().position(|(_, v)| *v < fast_mps - 1e-3).unwrap();
    // the way over which 2.5 times the force of coasting takes the energy
    let air_and_tyres_n = body.road_forces(fast_mps / 2.0_f64.sqrt(), 0.0).sum_n();
    let gear = powertrain.gears[11];
    let drag_nm = powertrain.engine.drag_nm(gear.speed_ratio_per_m * fast_mps);
    let [engine_n, _] = powertrain.losses.wheel_and_lost_n(&gear, fast_mps, drag_nm);
    let energy_j = 0.5 * (body.mass_kg + body.wheel_mass_kg) * fast_mps * fast_mps;
    let from_m = 3000.0 - energy_j / (2.5 * (air_and_tyres_n - engine_n));
    let begun_m = nodes[first - 1].0;
    assert!((begun_m - from_m).abs() < fast_mps, "{begun_m} {from_m}");
    // and the brakes act where the table's ramp is met
    let brakes = nodes.windows(2).find(|pair| pair[0].1 - pair[1].1 > 0.45).unwrap()[0].1;
    assert!((60.0 * KMPH..75.0 * KMPH).contains(&brakes), "{}", brakes / KMPH);
}

#[test]
fn who_decides_on_the_way_gets_to_a_stop_uphill_and_stalls_nowhere() {
    for slope in [0.03, 0.06, 0.09] {
        let road = mission(3000, |s| {
            (if s == 3000 { 0.0 } else { 80.0 }, if s < 2500 { 0.0 } else { slope })
        });
        let plan = plan_of(&road, 40_000.0, &deciding_on_the_way());
        assert!((plan.distance_m() - 3000.0).abs() < 0.5, "{slope}: {}", plan.distance_m());
        assert!(plan.speed_mps.iter().all(|v| *v >= 0.0), "{slope}");
    }
}

#[test]
fn opposite_shifts_wait_where_the_driver_waits() {
    let hilly = mission(8000, |s| (80.0, if s / 150 % 2 == 0 { 0.05 } else { -0.02 }));
    let soonest_s = |opposite_shift_time_s| {
        let driver = VectoDriver { opposite_shift_time_s, ..deciding_on_the_way() };
        let plan = plan_of(&hilly, 40_000.0, &driver);
        let gears = plan.seconds.iter().enumerate().filter_map(|(k, second)| match second.gear {
            GearOrder::Engaged(gear) => Some((k, gear)),
            _ => None,
        });
        let gears: Vec<(usize, usize)> = gears.collect();
        let shifts: Vec<(usize, bool)> = gears
            .windows(2)
            .filter(|pair| pair[0].1 != pair[1].1)
            .map(|pair| (pair[1].0, pair[1].1 > pair[0].1))
            .collect();
        shifts.windows(2).filter(|p| p[0].1 != p[1].1).map(|p| p[1].0 - p[0].0).min()
    };
    let (without, with) = (soonest_s(0.0).unwrap(), soonest_s(10.0).unwrap());
    assert!(without < 9 && with >= 10, "{without} {with}");
}

#[test]
fn who_decides_on_the_way_runs_over_the_target_downhill_alone() {
    let slope = |s: u32| if (500..2500).contains(&s) { -0.03 } else { 0.004 };
    let hill = mission(4000, |s| (80.0, slope(s)));
    let plan = plan_of(&hill, 30_000.0, &deciding_on_the_way());
    let nodes = over_way(&plan);
    let fastest = nodes.iter().map(|node| node.1).fold(0.0, f64::max) / KMPH;
    assert!((fastest - 85.0).abs() < 1e-3, "{fastest}");
    // braked at 0.5 m/s² behind the foot: 5 km/h in 3 s
    let later = nodes.iter().filter(|(way_m, _)| !(500.0..2500.0 + 4.0 * 24.0).contains(way_m));
    for (way_m, speed_mps) in later {
        assert!(*speed_mps < 80.0 * KMPH + 1e-6, "{way_m} {speed_mps}");
    }
    // between two stops without a target: slow, but an answer
    let row = |distance_m| MissionRow { distance_m, stop_s: 2.0, ..MissionRow::default() };
    let still = Mission::new(&[row(0.0), row(20.0)]).unwrap();
    let plan = plan_of(&still, 20_000.0, &deciding_on_the_way());
    assert!((plan.distance_m() - 20.0).abs() < 0.5, "{}", plan.distance_m());
}

#[test]
fn missions_that_say_nothing_are_refused_and_gaps_between_rows_are_filled() {
    let row =
        |distance_m, target_mps| MissionRow { distance_m, target_mps, ..MissionRow::default() };
    let error = Mission::new(&[row(0.0, 1.0)]).unwrap_err();
    assert_eq!(error, MissionError::Short { rows: 1 });
    for rows in [[row(0.0, 1.0), row(0.0, 1.0)], [row(0.0, 1.0), row(5.0, f64::NAN)]] {
        assert!(Mission::new(&rows).is_err(), "{rows:?}");
    }
    let steep = MissionRow { gradient: 0.04, ..row(0.0, 0.0) };
    let filled = Mission::new(&[steep, row(10.0, 20.0), row(30.0, 20.0)]).unwrap();
    assert_eq!((filled.length_m(), filled.gradient(5.5), filled.gradient(9.5)), (30.0, 0.04, 0.02));
    // no target, no driver's table and stops all the way: slow, but an answer
    let still = Mission::new(&[row(0.0, 0.0), row(20.0, 0.0)]).unwrap();
    let plan = plan_of(&still, 20_000.0, &VectoDriver::new(AccelerationTable::default()));
    assert!(plan.speed_mps.iter().all(|v| v.is_finite()));
}

#[test]
fn the_generic_polygon_lies_between_idle_and_the_fastest_useful_speed() {
    let powertrain = powertrain();
    let polygon = ShiftPolygon::generic(&powertrain);
    let idle = powertrain.engine_model.idle_speed_radps;
    for torque_nm in [-300.0, 0.0, 500.0, 1200.0, 2000.0] {
        let (down, up) = (polygon.down.at_radps(torque_nm), polygon.up.at_radps(torque_nm));
        assert!(idle <= down + 1e-9 && down < up && up < 220.0, "{torque_nm}: {down} {up}");
    }
}

#[test]
fn the_backward_mode_follows_a_plan_with_its_gears() {
    let hill = mission(3000, |s| {
        (if s == 0 || s == 1500 { 0.0 } else { 70.0 }, if s < 1800 { 0.0 } else { 0.04 })
    });
    let (powertrain, body) = (powertrain(), body(35_000.0));
    let plan = plan(&hill, &body, &powertrain, 4000.0, &driver());
    let truck = TruckInputs { auxiliary_power_w: 4000.0, map_factor: 1.0, initial_charge: None };
    let mut inverse = powertrain.inverse(&truck);
    inverse.set_convention(ShiftConvention::Returned);
    let followed = follow(&plan.drive_cycle().unwrap(), &body, &mut *inverse);
    let ledger = &followed.ledger;
    let missing = ledger[Term::Missing] / ledger[Term::Wheel];
    // the clutch slips in every gear of a start, as the plan has it
    assert!(missing < 5e-3, "{missing}");
    assert!((ledger[Term::Distance] - plan.distance_m()).abs() < 1e-6);
    assert_eq!(followed.duration_s, plan.seconds.len() as f64);
}
