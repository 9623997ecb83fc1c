//! Roads that hardly are: too many curves, too steep, too rough.

use super::Finding;
use crate::number_text::rounded;
use ocmc_core::operating_cycle::given::GivenCycle;

/// Curves per km from which on they are hardly a road's (judgement: the map roads of West Sweden
/// have 1.3).
const MANY_CURVES_PER_KM: f64 = 5.0;
/// Mean magnitude of the slope from which on it is hardly a road's (judgement: the steepest road
/// types of the built-in studies have 2 %).
const STEEP_MEAN: f64 = 0.04;
/// A shorter road may well be one hill, in km.
const SHORTEST_KM: f64 = 5.0;
/// Changes of the slope, without sign, added up over a km (judgement: drawn roads have 0.1 to 0.3).
const MANY_CHANGES_PER_KM: f64 = 1.0;

/// Slopes of a cycle, each with the way that it holds, in m.
pub(crate) fn slopes(cycle: &GivenCycle) -> Vec<(f64, f64)> {
    let points = cycle.altitude.windows(2).filter(|pair| pair[1].0 > pair[0].0);
    let slope = |pair: &[(f64, f64)]| {
        let way_m = pair[1].0 - pair[0].0;
        (way_m, (pair[1].1 - pair[0].1) / way_m)
    };
    points.map(slope).collect()
}

/// Looks at a cycle.
pub fn judge(cycle: &GivenCycle) -> Vec<Finding> {
    let km = cycle.length_m / 1000.0;
    let slopes = slopes(cycle);
    let climbed_m: f64 = slopes.iter().map(|(way_m, slope)| way_m * slope.abs()).sum();
    let mean = climbed_m / cycle.length_m.max(1.0);
    let changes = slopes.windows(2).map(|pair| (pair[1].1 - pair[0].1).abs());
    let changes_per_km = changes.sum::<f64>() / km;
    let curves_per_km = cycle.curves.len() as f64 / km;
    let percent = |share: f64| rounded(100.0 * share);
    let doubts = [
        (
            "many-curves",
            [curves_per_km, MANY_CURVES_PER_KM],
            true,
            format!("{} curves per km", rounded(curves_per_km)),
            "is it the noise of its positions or its curvature?",
        ),
        (
            "steep-mean",
            [mean, STEEP_MEAN],
            km > SHORTEST_KM,
            format!("a slope of {} % in the mean, up or down", percent(mean)),
            "is it the noise of its altitudes, or a slope in per cent?",
        ),
        (
            "rough-slopes",
            [changes_per_km, MANY_CHANGES_PER_KM],
            true,
            format!("slopes that change by {} % per km in sum", percent(changes_per_km)),
            "average its altitudes or slopes before, as `ocmc road LOG --altitude-average 200` \
             does of a log",
        ),
    ];
    let held = doubts.into_iter().filter(|(_, [figure, bound], told, ..)| *told && figure > bound);
    let finding = |(name, figures, _, what, hint): (&'static str, [f64; 2], bool, String, &str)| {
        Finding::warned(name, figures, format!("it has {what}, which is hardly a road"), hint)
    };
    held.map(finding).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::given_cycle::read_tracks;
    use std::fmt::Write;

    /// Names of what is found in a road of 10 km with these altitudes each 50 m.
    fn found(altitude_m: impl Fn(u32) -> f64) -> Vec<&'static str> {
        let mut text = "track,rule,position_m,value\nspeed_limit_mps,constant,0,20\n".to_owned();
        for k in 0..=200 {
            writeln!(text, "altitude_m,linear,{},{}", 50 * k, altitude_m(k)).expect("text");
        }
        let cycle = read_tracks("road.csv".as_ref(), &text).expect("a cycle");
        judge(&cycle).iter().map(|finding| finding.check).collect()
    }

    #[test]
    fn what_is_hardly_a_road_is_named() {
        assert_eq!(found(|k| 10.0 * f64::from(k / 25)), Vec::<&str>::new());
        assert_eq!(found(|k| 3.0 * f64::from(k)), ["steep-mean"]);
        assert_eq!(found(|k| 8.0 * f64::from(k % 2)), ["steep-mean", "rough-slopes"]);
        assert_eq!(found(|k| 1.9 * f64::from(k % 2)), ["rough-slopes"]);
    }
}
