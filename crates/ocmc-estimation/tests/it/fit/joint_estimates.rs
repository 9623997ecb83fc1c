//! Numbers that are estimated together are written together or not at all: curves that do not tell
//! how their number follows the sign, or how many a detector does not see.

use crate::common::field_truck_model;
use ocmc_core::operating_cycle::coverage::{Coverage, CurveCoverage, CurveWindow};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::road::curvature::{Curve, CurveModel};
use ocmc_core::random::{Draws, Stream};
use ocmc_estimation::fit::operating_cycle::{RoadFit, fit, fit_with_coverage};
use ocmc_estimation::fit::study_parameter::StudyParameterFit;
use ocmc_estimation::log::road::LoggedRoad;

/// An urban road of stretches of signs, in km/h, each of a length in km, with so many curves of
/// 50 m.
fn road(stretches: &[(f64, f64, usize)]) -> GivenCycle {
    let mut draws = Draws::new(3, 0, Stream::Curve);
    let (mut limits, mut curves, mut at_m) = (Vec::new(), Vec::new(), 0.0);
    for &(sign_kmh, km, count) in stretches {
        limits.push((at_m, sign_kmh / 3.6));
        for k in 0..count {
            let start_m = at_m + 1000.0 * km * (k as f64 + 0.5) / count as f64;
            let length_m = 40.0 + 20.0 * draws.uniform();
            let radius_m = 60.0 + 60.0 * draws.uniform();
            curves.push(Curve { start_m, end_m: start_m + length_m, radius_m, left: k % 2 == 0 });
        }
        at_m += 1000.0 * km;
    }
    GivenCycle {
        length_m: at_m,
        road_types: Some(vec![(0.0, "urban".to_owned())]),
        limits,
        altitude: vec![(0.0, 0.0), (at_m, 0.0)],
        curves,
        ..GivenCycle::default()
    }
}

fn urban(fit: &RoadFit) -> &CurveModel {
    &fit.model.types["urban"].curves
}

fn parameter<'a>(fit: &'a RoadFit, key: &str) -> Option<&'a StudyParameterFit> {
    fit.types[0].parameters.iter().find(|parameter| parameter.key == key)
}

/// Curves that a model expects on the stretches of a road.
fn expected(model: &CurveModel, stretches: &[(f64, f64, usize)]) -> f64 {
    stretches.iter().map(|(kmh, km, _)| 1000.0 * km * model.intensity_per_m(kmh / 3.6)).sum()
}

#[test]
fn an_exponent_that_the_signs_do_not_tell_stays_and_the_intensity_goes_with_it() {
    let base = field_truck_model();
    let exponent = base.road.types["urban"].curves.sign_exponent;
    // one sign; curves under the slow sign only, whose likelihood rises with the exponent for ever;
    // more curves under the fast sign, for which it would be negative
    for stretches in [
        vec![(50.0, 40.0, 60)],
        vec![(30.0, 20.0, 40), (50.0, 20.0, 0)],
        vec![(30.0, 20.0, 5), (50.0, 20.0, 45)],
    ] {
        let fit = fit(&[road(&stretches)], &base).unwrap();
        let model = urban(&fit);
        assert_eq!(model.sign_exponent, exponent, "{stretches:?}");
        assert!(parameter(&fit, "curves.sign_exponent").is_none());
        // the number of curves that were there is what the model expects
        let count: usize = stretches.iter().map(|stretch| stretch.2).sum();
        let ratio = expected(model, &stretches) / count as f64;
        assert!((ratio - 1.0).abs() < 1e-3, "{stretches:?}: {ratio}");
        let per_m = parameter(&fit, "curves.per_m").unwrap();
        let reference_kmh = 3.6 * model.reference_sign_mps.unwrap();
        let is_said = fit.warnings.iter().any(|text| text.contains("how their number follows"));
        // beside signs that are not the reference's it leans on the exponent
        assert_eq!(per_m.standard_error.is_none(), is_said, "{reference_kmh}: {per_m:?}");
    }
}

#[test]
fn an_exponent_that_the_signs_tell_comes_with_the_intensity() {
    let base = field_truck_model();
    // λ from 3 to 1 per km as the sign goes from 30 to 60 km/h: p = ln 3/ln 2
    let stretches = [(30.0, 60.0, 180), (60.0, 60.0, 60)];
    let fit = fit(&[road(&stretches)], &base).unwrap();
    let found = parameter(&fit, "curves.sign_exponent").unwrap();
    let wanted = 3.0_f64.ln() / 2.0_f64.ln();
    assert!((found.value - wanted).abs() < 1e-3, "{found:?}");
    // of two counts: √(1/180 + 1/60)/ln 2
    let error = (1.0_f64 / 180.0 + 1.0 / 60.0).sqrt() / 2.0_f64.ln();
    assert!((found.standard_error.unwrap() / error - 1.0).abs() < 0.01, "{found:?}");
    let ratio = expected(urban(&fit), &stretches) / 240.0;
    assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
}

#[test]
fn more_curves_than_the_highest_intensity_raise_it() {
    let base = field_truck_model();
    let highest = base.road.types["urban"].curves.maximum_per_m;
    // twice as many curves as it explains
    let count = (2.0 * highest * 10.0e3) as usize;
    let fit = fit(&[road(&[(30.0, 10.0, count), (50.0, 30.0, 60)])], &base).unwrap();
    let found = parameter(&fit, "curves.maximum_per_m").unwrap();
    assert!((found.value / (2.0 * highest) - 1.0).abs() < 0.01, "{found:?}");
    assert_eq!(urban(&fit).maximum_per_m, found.value);
}

#[test]
fn curves_at_the_edge_of_the_window_do_not_tell_how_many_there_are() {
    let base = field_truck_model();
    let window = CurveWindow {
        radius_m: [20.0, 500.0],
        shortest_m: 15.0,
        smallest_turn_rad: 8.0_f64.to_radians(),
    };
    let coverage = Coverage { curves: CurveCoverage::Within(window), ..Coverage::ALL };
    // each curve is hardly longer than what is seen of its radius: the shorter the law, the better
    let mut cycle = road(&[(30.0, 40.0, 20), (50.0, 80.0, 20)]);
    let mut draws = Draws::new(4, 0, Stream::Curve);
    for curve in &mut cycle.curves {
        curve.radius_m = 60.0 + 300.0 * draws.uniform();
        let least_m = window.least_length_m(curve.radius_m);
        curve.end_m = curve.start_m + least_m * (1.0 + 0.1 * draws.exponential());
    }
    let roads = [LoggedRoad { cycle, ..LoggedRoad::default() }];
    let fit = fit_with_coverage(&roads, &coverage, &base).unwrap();
    let (found, base) = (urban(&fit), &base.road.types["urban"].curves);
    assert_eq!(
        [found.median_radius_m, found.radius_log_sd, found.median_length_m, found.length_log_sd],
        [base.median_radius_m, base.radius_log_sd, base.median_length_m, base.length_log_sd]
    );
    let per_m = parameter(&fit, "curves.per_m").unwrap();
    // 40 curves on 120 km, of which the base study's laws let more than a quarter be seen
    assert!(per_m.standard_error.is_none() && per_m.value < 0.003, "{per_m:?}");
    assert!(fit.warnings.iter().any(|text| text.contains("fit many laws")), "{:?}", fit.warnings);
}
