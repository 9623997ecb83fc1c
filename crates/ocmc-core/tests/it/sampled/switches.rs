//! Freezing a factor takes it from cycle 0 and changes nothing else; turning a part off changes
//! only what it must.

use crate::common::field_truck;
use ocmc_core::operating_cycle::road::Road;
use ocmc_core::operating_cycle::road::point_event::{EventKind, PointEvent};
use ocmc_core::operating_cycle::weather::STANDARD_WEATHER;
use ocmc_core::random::Factor;
use ocmc_core::study::{Scenario, Study};
use ocmc_core::switch::ModelSwitch;
use std::collections::BTreeMap;
use std::fmt::Debug;

const SEED: u64 = 1;
const CYCLES: std::ops::Range<u64> = 1..40;

/// All digits of a value: equal texts are equal bits.
fn bits(value: &impl Debug) -> String {
    format!("{value:?}")
}

/// Groups of the quantities that each factor decides, free of the effects of the others.
struct Groups {
    road: String,
    weather: String,
    traffic: String,
    mission: String,
    driver: String,
    vehicle: String,
}

fn groups(study: &Study, scenario: &Scenario) -> Groups {
    let Scenario { cycle, driver, vehicle, .. } = scenario;
    // weather at departure: pressure and wind do not know the season
    let weather = &cycle.weather[0].weather;
    Groups {
        road: bits(&cycle.road),
        weather: bits(&(weather.pressure_pa, weather.wind_speed_mps, weather.wind_direction_rad)),
        traffic: format!("{:.9}", traffic_deviation(study, scenario)),
        mission: bits(&cycle.mission),
        driver: bits(driver),
        vehicle: bits(&(vehicle.drag_area_m2, vehicle.auxiliary_power_w, vehicle.map_factor)),
    }
}

/// Deviation of the traffic from its profile at departure, on the logit scale.
fn traffic_deviation(study: &Study, scenario: &Scenario) -> f64 {
    let cycle = &scenario.cycle;
    let traffic = study.operating_cycle().traffic();
    let name = &study.road_types()[cycle.road.sections[0].road_type];
    let middle_s = cycle.mission.departure_s + 0.5 * traffic.step_s;
    let typical = traffic.typical_share(&traffic.types[name], middle_s % 86_400.0 / 3600.0);
    let share = cycle.traffic[0].density_per_m / traffic.jam_density_per_m;
    (share / (1.0 - share)).ln() - (typical / (1.0 - typical)).ln()
}

#[test]
fn freezing_a_factor_changes_nothing_else() {
    let free = field_truck(|_| ());
    let zero = groups(&free, &free.sample(SEED, 0));
    let all = [
        Factor::Road,
        Factor::Weather,
        Factor::Traffic,
        Factor::Mission,
        Factor::Driver,
        Factor::Vehicle,
    ];
    for factor in all {
        let frozen = field_truck(|model| model.simulation.frozen = vec![factor]);
        let mut moved = 0;
        for cycle_id in CYCLES {
            let a = groups(&free, &free.sample(SEED, cycle_id));
            let b = groups(&frozen, &frozen.sample(SEED, cycle_id));
            for (group, with, without, of_zero) in [
                (Factor::Road, &a.road, &b.road, &zero.road),
                (Factor::Weather, &a.weather, &b.weather, &zero.weather),
                (Factor::Traffic, &a.traffic, &b.traffic, &zero.traffic),
                (Factor::Mission, &a.mission, &b.mission, &zero.mission),
                (Factor::Driver, &a.driver, &b.driver, &zero.driver),
                (Factor::Vehicle, &a.vehicle, &b.vehicle, &zero.vehicle),
            ] {
                if group == factor {
                    assert_eq!(without, of_zero, "{factor:?} is that of cycle 0");
                    moved += usize::from(with != without);
                } else {
                    assert_eq!(with, without, "{factor:?} frozen moves {group:?}");
                }
            }
        }
        assert!(moved > 30, "{factor:?} is free otherwise");
    }
}

#[test]
fn weather_traffic_driver_and_vehicle_leave_the_whole_cycle_alone() {
    let free = field_truck(|_| ());
    for factor in [Factor::Driver, Factor::Vehicle] {
        let frozen = field_truck(|model| model.simulation.frozen = vec![factor]);
        for cycle_id in CYCLES {
            let (a, b) = (free.sample(SEED, cycle_id), frozen.sample(SEED, cycle_id));
            assert_eq!(bits(&a.cycle), bits(&b.cycle));
        }
    }
    for factor in [Factor::Weather, Factor::Traffic] {
        let frozen = field_truck(|model| model.simulation.frozen = vec![factor]);
        for cycle_id in CYCLES {
            let (mut a, b) = (free.sample(SEED, cycle_id), frozen.sample(SEED, cycle_id));
            if factor == Factor::Weather {
                a.cycle.weather.clone_from(&b.cycle.weather);
            } else {
                a.cycle.traffic.clone_from(&b.cycle.traffic);
            }
            assert_eq!(bits(&a), bits(&b));
        }
    }
}

/// Scenarios of the default study with and without a part. Events keep no distance, because an
/// event that is gone makes room for one that it had pushed out.
fn with_and_without(part: ModelSwitch) -> impl Iterator<Item = (Scenario, Scenario)> {
    let with = field_truck(|model| model.road.event_spacing_m = 0.0);
    let without = field_truck(|model| {
        model.road.event_spacing_m = 0.0;
        model.simulation.without = vec![part];
    });
    CYCLES.map(move |id| (with.sample(SEED, id), without.sample(SEED, id)))
}

/// Checks that two scenarios are equal once `repair` has given the first what the part must change.
fn assert_only(part: ModelSwitch, repair: impl Fn(&mut Scenario, &Scenario)) {
    for (mut a, b) in with_and_without(part) {
        assert_ne!(bits(&a), bits(&b), "{part:?} does something");
        repair(&mut a, &b);
        assert_eq!(bits(&a), bits(&b), "{part:?} does nothing else");
    }
}

#[test]
fn without_slope_the_road_is_flat_and_nothing_else_changes() {
    assert_only(ModelSwitch::Slope, |a, b| {
        assert!(b.cycle.road.slopes.iter().all(|s| *s == 0.0));
        assert_eq!(a.cycle.road.slopes.len(), b.cycle.road.slopes.len());
        a.cycle.road.slopes.clone_from(&b.cycle.road.slopes);
    });
}

#[test]
fn without_curves_the_road_is_straight_and_nothing_else_changes() {
    assert_only(ModelSwitch::Curves, |a, b| {
        assert!(b.cycle.road.curves.is_empty() && b.curve_residuals.is_empty());
        a.cycle.road.curves.clear();
        a.curve_residuals.clear();
    });
}

#[test]
fn without_weather_or_traffic_the_road_stays() {
    assert_only(ModelSwitch::Weather, |a, b| {
        assert!(b.cycle.weather.iter().all(|w| w.weather == STANDARD_WEATHER));
        a.cycle.weather.clone_from(&b.cycle.weather);
    });
    assert_only(ModelSwitch::Traffic, |a, b| {
        assert!(b.cycle.traffic.iter().all(|t| t.density_per_m == 0.0));
        a.cycle.traffic.clone_from(&b.cycle.traffic);
    });
}

#[test]
fn without_signs_curves_and_places_stay() {
    assert_only(ModelSwitch::Signs, |a, b| {
        for (sign, free) in a.cycle.road.signs.iter_mut().zip(&b.cycle.road.signs) {
            assert!((3.6 * free.speed_mps - 130.0).abs() < 1e-9);
            sign.speed_mps = free.speed_mps;
        }
        // a faster passage meets the same weather and traffic elsewhere
        for (with, without) in a.cycle.weather.iter().zip(&b.cycle.weather) {
            assert_eq!(bits(&with.weather), bits(&without.weather));
        }
        a.cycle.weather.clone_from(&b.cycle.weather);
        a.cycle.traffic.clone_from(&b.cycle.traffic);
        a.cycle.free_flow_s = b.cycle.free_flow_s;
    });
}

#[test]
fn without_spread_the_others_stay() {
    assert_only(ModelSwitch::PayloadSpread, |a, b| {
        assert!((b.cycle.mission.payload_kg - 0.8 * 24_300.0 * 4.0 / 6.0).abs() < 1e-9);
        a.cycle.mission.payload_kg = b.cycle.mission.payload_kg;
        a.vehicle.mass_kg = b.vehicle.mass_kg;
        a.vehicle.driven_mass_kg = b.vehicle.driven_mass_kg;
        a.vehicle.rolling_coefficient = b.vehicle.rolling_coefficient;
    });
    assert_only(ModelSwitch::DriverSpread, |a, b| {
        assert!(b.driver.curve_speed.residual_sd == 0.0);
        a.driver = b.driver;
    });
    assert_only(ModelSwitch::VehicleSpread, |a, b| {
        assert!(b.vehicle.mass_kg == a.vehicle.mass_kg && b.vehicle.drag_area_m2 == 5.3);
        a.vehicle = b.vehicle;
    });
}

/// Curves by the bits of their start, with what belongs to them.
fn curves(scenario: &Scenario) -> BTreeMap<u64, String> {
    let curves = scenario.cycle.road.curves.iter().zip(&scenario.curve_residuals);
    curves.map(|(curve, residual)| (curve.start_m.to_bits(), bits(&(curve, residual)))).collect()
}

/// Whether an event is of a kind.
type Kind = fn(&EventKind) -> bool;

fn other_events(road: &Road, part: Kind) -> Vec<PointEvent> {
    road.events.iter().filter(|event| !part(&event.kind)).copied().collect()
}

#[test]
fn without_one_kind_of_event_the_other_events_curves_and_residuals_stay() {
    let kinds: [(ModelSwitch, Kind); 4] = [
        (ModelSwitch::StopSigns, |kind| matches!(kind, EventKind::StopSign { .. })),
        (ModelSwitch::GiveWays, |kind| {
            matches!(kind, EventKind::GiveWayStop { .. } | EventKind::GiveWayPass { .. })
        }),
        (ModelSwitch::TrafficLights, |kind| {
            matches!(kind, EventKind::RedLight { .. } | EventKind::GreenLight)
        }),
        (ModelSwitch::SpeedBumps, |kind| matches!(kind, EventKind::SpeedBump { .. })),
    ];
    for (part, is) in kinds {
        let (mut gone, mut kept) = (0, 0);
        for (a, b) in with_and_without(part) {
            assert_eq!(bits(&other_events(&a.cycle.road, is)), bits(&b.cycle.road.events));
            gone += a.cycle.road.events.len() - b.cycle.road.events.len();
            // curves at the same place are the same curves, turns at junctions included
            let (with, without) = (curves(&a), curves(&b));
            for (start, curve) in &with {
                if let Some(same) = without.get(start) {
                    assert_eq!(curve, same, "{part:?}");
                    kept += 1;
                }
            }
            let road = |s: &Scenario| {
                let r = &s.cycle.road;
                bits(&(&r.sections, &r.signs, &r.slopes, &r.roughness_m3, &r.grounds))
            };
            assert_eq!(road(&a), road(&b));
            assert_eq!(bits(&(a.driver, a.vehicle)), bits(&(b.driver, b.vehicle)));
            assert_eq!(bits(&a.cycle.mission), bits(&b.cycle.mission));
        }
        assert!(gone > 10 && kept > 1000, "{part:?} {gone} {kept}");
    }
}

#[test]
fn a_cycle_is_a_function_of_seed_and_id() {
    let study = field_truck(|_| ());
    let mut reused = study.sample(SEED, 3);
    for cycle_id in CYCLES {
        study.resample(SEED, cycle_id, &mut reused);
        assert_eq!(bits(&reused), bits(&field_truck(|_| ()).sample(SEED, cycle_id)));
    }
    assert_ne!(bits(&study.sample(1, 1).cycle.road), bits(&study.sample(2, 1).cycle.road));
}
