//! Round trip: operating cycles are drawn from the default study, written as tracks, and their
//! parameters estimated.

use crate::common::field_truck;
use ocmc_core::distribution::{Law, Quantity};
use ocmc_core::operating_cycle::coverage::{Coverage, CurveCoverage, CurveWindow};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::mission::MissionStopModel;
use ocmc_core::operating_cycle::road::RoadTypeModel;
use ocmc_core::operating_cycle::road::curvature::Curve;
use ocmc_core::operating_cycle::road::point_event::RailwayCrossingModel;
use ocmc_estimation::fit::operating_cycle::{
    Density, Hilliness, RoadFit, TransportCycle, birds_eye_of_study, fit, fit_with_coverage,
};
use ocmc_estimation::log::road::LoggedRoad;
use std::convert::Infallible;
use std::ops::ControlFlow;

const CYCLES: u64 = 200;

fn fitted(seed: u64) -> RoadFit {
    fit(&cycles(seed), field_truck(|_| {}).model()).unwrap()
}

fn cycles(seed: u64) -> Vec<GivenCycle> {
    let study = field_truck(|_| {});
    let given = |id| {
        let cycle = study.sample(seed, id).cycle;
        let tracks = cycle.tracks(study.road_types(), study.operating_cycle().road().types());
        GivenCycle::from_tracks(&tracks, Some(cycle.road.length_m)).unwrap()
    };
    (0..CYCLES).map(given).collect()
}

/// The limit that holds for trucks, as a trace gives it: a sign beyond it is not seen.
fn with_limits_of_trucks(mut cycle: GivenCycle) -> GivenCycle {
    let types = cycle.road_types.clone().unwrap();
    let study = field_truck(|_| {});
    let truck_limit_mps = |at_m: f64| {
        let k = types.partition_point(|start| start.0 <= at_m);
        study.model().road.types[&types[k - 1].1].truck_limit_mps.unwrap_or(f64::INFINITY)
    };
    let ends: Vec<f64> = types.iter().map(|start| start.0).collect();
    for (at_m, limit_mps) in &mut cycle.limits {
        *limit_mps = limit_mps.min(truck_limit_mps(*at_m));
    }
    cycle.limits.dedup_by(|b, a| a.1 == b.1 && !ends.contains(&b.0));
    cycle
}

#[test]
fn limits_of_trucks_hide_signs_whose_shares_and_changes_are_those_of_the_base() {
    let study = field_truck(|_| {});
    for seed in 1..=3 {
        let logged: Vec<GivenCycle> = cycles(seed).into_iter().map(with_limits_of_trucks).collect();
        let fit = fit(&logged, study.model()).unwrap();
        let warned = |name: &str| {
            fit.warnings.iter().any(|text| text.contains(&format!("{name}: its limits end at")))
        };
        assert!(warned("motorway") && warned("rural") && !warned("urban"), "{:?}", fit.warnings);
        for name in ["motorway", "rural"] {
            let (model, found) = (&study.model().road.types[name], &fit.model.types[name]);
            assert_eq!(found.speed_signs.speed_kmh, model.speed_signs.speed_kmh);
            for (a, b) in found.speed_signs.share.iter().zip(&model.speed_signs.share) {
                assert!((a - b).abs() < 0.06, "{name}: {a} {b}");
            }
            let of_type = fit.types.iter().find(|of_type| of_type.road_type == name).unwrap();
            let mut numbers = of_type.parameters.iter();
            let length = numbers.find(|fit| fit.key == "speed_signs.mean_length_m").unwrap();
            let off = (length.value - model.speed_signs.mean_length_m).abs();
            assert!(off < 4.0 * length.standard_error.unwrap(), "{name}: {length:?}");
        }
    }
    // one limit above the truck limit: all are posted signs
    let mut logged: Vec<GivenCycle> = cycles(1).into_iter().map(with_limits_of_trucks).collect();
    let cycle = logged.iter_mut().find(|cycle| cycle.road_types.as_ref().unwrap().len() > 3);
    let cycle = cycle.unwrap();
    let start = cycle.road_types.as_ref().unwrap().iter().find(|start| start.1 == "motorway");
    let at_m = start.unwrap().0;
    cycle.limits.iter_mut().find(|limit| limit.0 >= at_m).unwrap().1 = 30.0;
    let fit = fit(&logged, study.model()).unwrap();
    assert!(!fit.warnings.iter().any(|text| text.contains("its limits end at")));
}

#[test]
fn values_that_are_not_uniform_get_the_law_of_their_mean_and_spread() {
    use ocmc_core::operating_cycle::road::point_event::EventKind;
    let study = field_truck(|_| {});
    let mut logged = cycles(1);
    // some have queued before the line
    let mut count = 0;
    for event in logged.iter_mut().flat_map(|cycle| &mut cycle.events) {
        if let EventKind::GiveWayPass { speed_mps } = &mut event.kind {
            count += 1;
            *speed_mps = if count % 20 == 0 { 2.0 } else { *speed_mps };
        }
    }
    let fit = fit(&logged, study.model()).unwrap();
    let law = &fit.model.types["urban"].give_ways.pass_speed_mps;
    let Quantity::Law(Law::Uniform { lower, .. }) = law else { panic!("{law:?}") };
    // 95 % of mean 6.25 and SD 0.4, 5 % of 2
    assert!((mean(law) - 6.04).abs() < 0.05 && *lower > 4.0, "{law:?}");
}

fn mean(law: &Quantity) -> f64 {
    match law {
        Quantity::Law(Law::Uniform { lower, upper }) => 0.5 * (lower + upper),
        Quantity::Law(Law::Exponential { mean }) => *mean,
        _ => panic!("a law of the default study"),
    }
}

/// Value of a key in the study.
fn truth(model: &RoadTypeModel, key: &str) -> Option<f64> {
    let curves = &model.curves;
    Some(match key {
        "mean_length_m" => model.mean_length_m,
        "speed_signs.mean_length_m" => model.speed_signs.mean_length_m,
        "speed_signs.similarity_kmh" => model.speed_signs.similarity_kmh,
        "stop_signs.per_m" => model.stop_signs.per_m,
        "stop_signs.standstill_s, mean" => mean(&model.stop_signs.standstill_s),
        "stop_signs.turn_share" => model.stop_signs.turn_share,
        "give_ways.per_m" => model.give_ways.per_m,
        "give_ways.stop_probability" => model.give_ways.stop_probability,
        "give_ways.wait_s, mean" => mean(&model.give_ways.wait_s),
        "give_ways.pass_speed_mps, mean" => mean(&model.give_ways.pass_speed_mps),
        "traffic_lights.per_m" => model.traffic_lights.per_m,
        "traffic_lights.red_probability" => model.traffic_lights.red_probability,
        "traffic_lights.wait_s, mean" => mean(&model.traffic_lights.wait_s),
        "traffic_lights.turn_share" => model.traffic_lights.turn_share,
        "speed_bumps.per_m" => model.speed_bumps.per_m,
        "speed_bumps.length_m, mean" => mean(&model.speed_bumps.length_m),
        "speed_bumps.height_m, mean" => mean(&model.speed_bumps.height_m),
        "curves.per_m" => curves.per_m,
        "curves.sign_exponent" => curves.sign_exponent,
        "curves.median_radius_m" => curves.median_radius_m,
        "curves.radius_log_sd" => curves.radius_log_sd,
        "curves.median_length_m" => curves.median_length_m,
        "curves.length_log_sd" => curves.length_log_sd,
        "roughness.mean_coefficient_m3" => model.roughness.mean_coefficient_m3,
        _ => return key.strip_prefix("next.").and_then(|name| model.next.get(name)).copied(),
    })
}

#[test]
fn parameters_of_the_default_study_come_back() {
    let study = field_truck(|_| {});
    for seed in 1..=3 {
        let fit = fitted(seed);
        assert_eq!((fit.cycles, fit.types.len()), (200, 3));
        let mut compared = 0;
        for of_type in &fit.types {
            let model = &study.model().road.types[&of_type.road_type];
            for parameter in &of_type.parameters {
                let Some(error) = parameter.standard_error else { continue };
                let Some(wanted) = truth(model, &parameter.key) else { continue };
                compared += 1;
                let off = (parameter.value - wanted).abs();
                assert!(
                    off <= 4.0 * error + 1e-12,
                    "seed {seed}, {}: {parameter:?}, wanted {wanted}",
                    of_type.road_type
                );
            }
        }
        assert!(compared > 60, "{compared}");
    }
}

#[test]
fn slopes_signs_grounds_and_the_view_from_above() {
    let study = field_truck(|_| {});
    for seed in 1..=3 {
        let fit = fitted(seed);
        for (name, model) in &study.model().road.types {
            let found = &fit.model.types[name];
            let ratio = found.topography.slope_sd / model.topography.slope_sd;
            assert!((0.95..1.05).contains(&ratio), "{name}: {ratio}");
            let ratio = found.topography.hill_length_m / model.topography.hill_length_m;
            assert!((ratio - 1.0).abs() < 0.05, "{name}: {ratio}");
            // its squared variation has the error of a few per cent over some thousand blocks
            let ratio = found.roughness.shape / model.roughness.shape;
            assert!((ratio - 1.0).abs() < 0.15, "{name}: {ratio}");
            assert_eq!(found.speed_signs.speed_kmh, model.speed_signs.speed_kmh);
            for (a, b) in found.speed_signs.share.iter().zip(&model.speed_signs.share) {
                assert!((a - b).abs() < 0.06, "{name}: {a} {b}");
            }
            for (ground, share) in &model.ground {
                let found = found.ground.get(ground).copied().unwrap_or(0.0);
                assert!((found - share).abs() < 0.08, "{name}: {found} {share}");
            }
        }
        let view = &fit.birds_eye;
        assert_eq!(view.transport_cycle, TransportCycle::LongDistance);
        // slopes of 2 %: |slope| < 6 % on more than 98 % of the way, not below 3 %
        assert_eq!(view.hilliness, Some(Hilliness::PredominantlyFlat));
        let shares: f64 = view.road_type_share.values().sum();
        assert!((shares - 1.0).abs() < 1e-9);
    }
}

/// A number of a road type.
type Number = fn(&RoadTypeModel) -> f64;

#[test]
fn what_the_mean_slope_takes_and_what_ends_cut_off_is_made_up_for() {
    let study = field_truck(|_| {});
    let fits: Vec<RoadFit> = (1..=12).map(fitted).collect();
    let model = &study.model().road.types;
    // The bridge takes the mean slope of each road, and with it 1 % of the SD of a road of one
    // type; in towns, where slopes are small, the shift by the others' mean adds 2 %. The end of a
    // road cuts curves off, and turns remove the long ones.
    let numbers: [(&str, &str, Number); 5] = [
        ("motorway", "slope_sd", |road_type| road_type.topography.slope_sd),
        ("urban", "slope_sd", |road_type| road_type.topography.slope_sd),
        ("motorway", "hill_length_m", |road_type| road_type.topography.hill_length_m),
        ("motorway", "length_log_sd", |road_type| road_type.curves.length_log_sd),
        ("urban", "median_length_m", |road_type| road_type.curves.median_length_m),
    ];
    for (name, key, number) in numbers {
        let truth = number(&model[name]);
        let found: Vec<f64> = fits.iter().map(|fit| number(&fit.model.types[name])).collect();
        let n = found.len() as f64;
        let mean = found.iter().sum::<f64>() / n;
        let squares: f64 = found.iter().map(|value| (value - mean).powi(2)).sum();
        let error = (squares / (n - 1.0) / n).sqrt();
        let z = (mean - truth) / error;
        assert!(z.abs() < 3.0, "{name} {key}: {mean} for {truth}, {z} SE");
        // and the error is small enough to see it
        assert!(error < 0.006 * truth, "{name} {key}: {error}");
    }
}

#[test]
fn the_view_of_a_study_is_that_of_its_tracks() {
    let go_on = |_| ControlFlow::<Infallible>::Continue(());
    let study = field_truck(|_| {});
    let ControlFlow::Continue(view) = birds_eye_of_study(&study, 1, 0..CYCLES, go_on);
    let of_tracks = fitted(1).birds_eye;
    // tracks hold altitudes, whose differences are the slopes up to rounding
    assert_eq!(view.curves_per_km, of_tracks.curves_per_km);
    assert_eq!(view.stops_per_km, of_tracks.stops_per_km);
    for (a, b) in view.share_below.unwrap().iter().zip(of_tracks.share_below.unwrap()) {
        assert!((a - b).abs() < 1e-3, "{a} {b}");
    }
    for (name, share) in &view.road_type_share {
        assert!((share - of_tracks.road_type_share[name]).abs() < 1e-9, "{name}: {share}");
    }
    assert_eq!(
        (view.hilliness, view.transport_cycle, view.stop_density, view.curve_density),
        (
            of_tracks.hilliness,
            of_tracks.transport_cycle,
            of_tracks.stop_density,
            of_tracks.curve_density
        )
    );

    // roads whose classes are known: steep slopes, a stop every 400 m, a curve now and then
    let study = field_truck(|model| {
        model.mission.length_m = Quantity::Number(20.0e3);
        model.mission.stops = Some(MissionStopModel {
            spacing_m: Quantity::Number(400.0),
            dwell_s: Quantity::Number(30.0),
            cargo: None,
            power_take_off: None,
        });
        for road in model.road.types.values_mut() {
            road.topography.slope_sd = 0.08;
            road.topography.slope_limit = 0.25;
            road.curves.per_m = 0.0;
            road.stop_signs.turn_share = 0.0;
            road.give_ways.turn_share = 0.0;
            road.traffic_lights.turn_share = 0.0;
        }
    });
    let ControlFlow::Continue(view) = birds_eye_of_study(&study, 1, 0..20, go_on);
    assert_eq!(
        (view.hilliness, view.transport_cycle, view.stop_density, view.curve_density),
        (Some(Hilliness::VeryHilly), TransportCycle::StopAndGo, Density::High, Some(Density::Low))
    );
    assert_eq!((view.curves_per_km, view.length_m), (Some(0.0), 400.0e3));
    let stopped = birds_eye_of_study(&study, 1, 0..20, |done| {
        if done < 3 { ControlFlow::Continue(()) } else { ControlFlow::Break(done) }
    });
    assert_eq!(stopped, ControlFlow::Break(3));
}

#[test]
fn turns_at_junctions_and_missions_come_back() {
    let study = field_truck(|model| {
        let law = |text: &str| {
            toml::from_str::<toml::Value>(&format!("x = {text}")).unwrap()["x"].clone()
        };
        let quantity = |text: &str| law(text).try_into::<Quantity>().unwrap();
        model.mission.length_m =
            quantity("{ distribution = 'log_normal', median = 60.0e3, log_sd = 0.4 }");
        model.mission.stops = Some(MissionStopModel {
            spacing_m: quantity("{ distribution = 'log_normal', median = 20.0e3, log_sd = 0.7 }"),
            dwell_s: quantity("{ distribution = 'log_normal', median = 1500.0, log_sd = 0.5 }"),
            cargo: None,
            power_take_off: None,
        });
    });
    let wanted = study.model();
    for seed in 1..=3 {
        let cycles: Vec<GivenCycle> = (0..CYCLES)
            .map(|id| {
                let cycle = study.sample(seed, id).cycle;
                let tracks =
                    cycle.tracks(study.road_types(), study.operating_cycle().road().types());
                let mut given =
                    GivenCycle::from_tracks(&tracks, Some(cycle.road.length_m)).unwrap();
                given.departure = Some((cycle.mission.departure_s, cycle.mission.day_of_year));
                given
            })
            .collect();
        let fit = fit(&cycles, wanted).unwrap();
        let turns = &wanted.road.junction_turn;
        let parameter = |key: &str| {
            let all = fit.junction_turn.iter().chain(&fit.mission);
            all.clone().find(|p| p.key == key).unwrap_or_else(|| panic!("{key}: {fit:?}")).clone()
        };
        for (key, value) in [
            ("junction_turn.median_radius_m", turns.median_radius_m),
            ("junction_turn.radius_log_sd", turns.radius_log_sd),
            ("junction_turn.minimum_share", turns.minimum_share),
            ("length_m, mean", 60.0e3 * (0.5f64 * 0.16).exp()),
            // one in five is empty, the others Beta(4, 2) of 24.3 t
            ("payload_kg, mean", 0.8 * 24300.0 * 4.0 / 6.0),
            ("stops.spacing_m, median", 20.0e3),
            ("stops.dwell_s, mean", 1500.0 * (0.5f64 * 0.25).exp()),
            // a uniform day, rounded down
            ("departure_day_of_year, mean", 182.0),
        ] {
            let found = parameter(key);
            let error = found.standard_error.unwrap();
            assert!((found.value - value).abs() <= 4.0 * error, "seed {seed}: {found:?}, {value}");
        }
        let mission = &fit.mission_model;
        let Quantity::Law(Law::LogNormal { log_sd, .. }) = mission.length_m else { panic!() };
        assert!((log_sd - 0.4).abs() < 4.0 * 0.4 / 400f64.sqrt(), "{log_sd}");
        // a mixture has no fit: the values themselves
        let Quantity::Law(Law::Empirical { values, .. }) = &mission.payload_kg else { panic!() };
        let empty = values.iter().filter(|kg| **kg == 0.0).count() as f64 / values.len() as f64;
        assert!((empty - 0.2).abs() < 4.0 * (0.16f64 / 200.0).sqrt() + 0.01, "{empty}");
        assert!(mission.stops.is_some());
    }
}

/// Curves of one road type, and what a detector sees of them.
fn seen_by(window: &CurveWindow, cycles: &mut [GivenCycle]) -> usize {
    let mut hidden = 0;
    for cycle in cycles {
        let all = cycle.curves.len();
        cycle.curves.retain(|curve| window.sees(curve.radius_m, curve.end_m - curve.start_m));
        hidden += all - cycle.curves.len();
    }
    hidden
}

#[test]
fn curves_outside_the_window_of_a_detector_are_made_up_for() {
    // rural roads as they are, without events whose turns would drop curves
    let study = field_truck(|model| {
        for road in model.road.types.values_mut() {
            road.stop_signs.per_m = 0.0;
            road.give_ways.per_m = 0.0;
            road.traffic_lights.per_m = 0.0;
        }
    });
    let window = CurveWindow {
        radius_m: [20.0, 500.0],
        shortest_m: 15.0,
        smallest_turn_rad: 8.0 / 180.0 * std::f64::consts::PI,
    };
    let coverage = Coverage { curves: CurveCoverage::Within(window), ..Coverage::ALL };
    for seed in 1..=3 {
        let mut cycles: Vec<GivenCycle> = (0..CYCLES)
            .map(|id| {
                let cycle = study.sample(seed, id).cycle;
                let tracks =
                    cycle.tracks(study.road_types(), study.operating_cycle().road().types());
                GivenCycle::from_tracks(&tracks, Some(cycle.road.length_m)).unwrap()
            })
            .collect();
        let hidden = seen_by(&window, &mut cycles);
        assert!(hidden > 1000, "{hidden}");
        let roads: Vec<LoggedRoad> = cycles
            .iter()
            .map(|cycle| LoggedRoad { cycle: cycle.clone(), ..LoggedRoad::default() })
            .collect();
        let mut plain_misses = 0;
        for (fit, with_window) in [
            (fit_with_coverage(&roads, &coverage, study.model()).unwrap(), true),
            (fit_with_coverage(&roads, &Coverage::ALL, study.model()).unwrap(), false),
        ] {
            for name in ["urban", "rural"] {
                let model = &study.model().road.types[name];
                let of_type = fit.types.iter().find(|of_type| of_type.road_type == name).unwrap();
                for key in [
                    "curves.per_m",
                    "curves.median_radius_m",
                    "curves.radius_log_sd",
                    "curves.median_length_m",
                    "curves.length_log_sd",
                ] {
                    let found = of_type.parameters.iter().find(|p| p.key == key).unwrap();
                    let off = (found.value - truth(model, key).unwrap()).abs();
                    let near = off <= 4.0 * found.standard_error.unwrap();
                    assert!(near || !with_window, "seed {seed}, {name}: {found:?}, off by {off}");
                    plain_misses += usize::from(!near);
                }
            }
        }
        // taken for all curves, those of the window give other laws
        assert!(plain_misses >= 6, "{plain_misses}");
    }
}

#[test]
fn a_curve_that_the_road_before_has_pushed_over_its_end_is_left_out() {
    let study = field_truck(|_| ());
    // row: where the curve behind the one across the change of type begins, if there is one
    let laws = |row_m: Option<f64>| {
        let curve = |start_m: f64, length_m: f64, radius_m: f64| Curve {
            start_m,
            end_m: start_m + length_m,
            radius_m,
            left: true,
        };
        let mut curves = vec![curve(9_900.0, 110.0, 60.0)];
        curves.extend(row_m.map(|start_m| curve(start_m, 20.0, 320.0)));
        let motorway = |k: u32| {
            let shares = [0.8, 1.0, 1.3];
            let at_m = 12_000.0 + 3_000.0 * f64::from(k);
            curve(at_m, 300.0 * shares[k as usize % 3], 900.0 * shares[(k as usize + 1) % 3])
        };
        curves.extend((0..20).map(motorway));
        let cycle = GivenCycle {
            length_m: 80_000.0,
            road_types: Some(vec![(0.0, "rural".to_owned()), (1e4, "motorway".to_owned())]),
            limits: vec![(0.0, 70.0 / 3.6)],
            altitude: vec![(0.0, 0.0), (80_000.0, 0.0)],
            curves,
            ..GivenCycle::default()
        };
        let fit = fit(&[cycle], study.model()).unwrap();
        let of = &fit.model.types["motorway"].curves;
        [of.median_radius_m, of.radius_log_sd, of.median_length_m, of.length_log_sd]
    };
    let without = laws(None);
    assert_eq!(laws(Some(10_010.0)), without);
    // with a gap before it, it is one of the motorway's own
    let own = laws(Some(10_040.0));
    assert!(own[1] > 1.5 * without[1] && own[3] > 1.5 * without[3], "{own:?}, {without:?}");
}

#[test]
fn railway_crossings_come_back_where_the_base_study_has_them() {
    let uniform = |lower, upper| Quantity::Law(Law::Uniform { lower, upper });
    let crossings = RailwayCrossingModel {
        per_m: 0.5e-3,
        closed_probability: 0.2,
        wait_s: uniform(30.0, 180.0),
        pass_speed_mps: uniform(5.0, 10.0),
        stop_s: uniform(3.0, 6.0),
    };
    let study = field_truck(|model| {
        for road_type in model.road.types.values_mut() {
            road_type.railway_crossings = Some(crossings.clone());
        }
    });
    let cycles: Vec<GivenCycle> = (0..50)
        .map(|id| {
            let cycle = study.sample(1, id).cycle;
            let tracks = cycle.tracks(study.road_types(), study.operating_cycle().road().types());
            GivenCycle::from_tracks(&tracks, Some(cycle.road.length_m)).unwrap()
        })
        .collect();
    let mut compared = 0;
    for of_type in fit(&cycles, study.model()).unwrap().types {
        for parameter in of_type.parameters {
            let wanted = match parameter.key.as_str() {
                "railway_crossings.per_m" => crossings.per_m,
                "railway_crossings.closed_probability" => crossings.closed_probability,
                "railway_crossings.wait_s, mean" => mean(&crossings.wait_s),
                "railway_crossings.pass_speed_mps, mean" => mean(&crossings.pass_speed_mps),
                "railway_crossings.stop_s, mean" => mean(&crossings.stop_s),
                _ => continue,
            };
            compared += 1;
            let error = parameter.standard_error.unwrap();
            assert!((parameter.value - wanted).abs() <= 4.0 * error, "{parameter:?}, {wanted}");
        }
    }
    assert_eq!(compared, 15, "five numbers of three road types");
    let bare = fit(&cycles, field_truck(|_| {}).model()).unwrap();
    let left_out = "its railway_crossings have no table in the base study and are left out";
    assert!(bare.warnings.iter().any(|text| text.contains(left_out)), "{:?}", bare.warnings);
    assert!(bare.model.types.values().all(|of| of.railway_crossings.is_none()));
}
