//! Round trip: operating cycles are drawn from the default study, written as tracks, and their parameters estimated.

use super::common::field_truck;
use ocmc_core::distribution::{Law, Quantity};
use ocmc_core::fit::operating_cycle::{Hilliness, RoadFit, TransportCycle, fit};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::road::RoadTypeModel;

const CYCLES: u64 = 200;

fn fitted(seed: u64) -> RoadFit {
    let study = field_truck(|_| {});
    let cycles: Vec<GivenCycle> = (0..CYCLES)
        .map(|id| {
            let cycle = study.sample(seed, id).cycle;
            let tracks = cycle.tracks(study.road_types(), study.operating_cycle().road().types());
            GivenCycle::from_tracks(&tracks, Some(cycle.road.length_m)).unwrap()
        })
        .collect();
    fit(&cycles, &study.model().road).unwrap()
}

fn mean(law: &Quantity) -> f64 {
    match law {
        Quantity::Law(Law::Uniform { lower, upper }) => 0.5 * (lower + upper),
        Quantity::Law(Law::Exponential { mean }) => *mean,
        _ => panic!("a law of the default study"),
    }
}

/// What the study says of a key.
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
            // The bridge shifts all slopes of a road alike. It removes 1.3 % of the SD of a road of one type; where slopes are
            // small, the shift by the others' mean, of SD 0.0033, adds to them: √(1 + (0.0033/0.015)²) = 1.024 in towns.
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
        assert_eq!(view.hilliness, Hilliness::PredominantlyFlat);
        let shares: f64 = view.road_type_share.values().sum();
        assert!((shares - 1.0).abs() < 1e-9);
    }
}
