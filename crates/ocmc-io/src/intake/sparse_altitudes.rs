//! Altitudes that are far apart: the hills between them are not there.
//!
//! Altitudes of the roads of `field-truck`, `regional` and `long-haul`, thinned to even spacings
//! and driven by the same trucks: at 100 m they take 0.2 % less fuel than with all, at 300 m 0.8 %,
//! at 500 m 1.5 % and at 1000 m 2.6 %, some roads half as much again (24 roads of 20 km, seed 1).

use super::Finding;
use crate::number_text::rounded;

const NAME: &str = "sparse-altitudes";
/// Loss at 1000 m, in %, about in proportion to the spacing.
const LOST_PERCENT: f64 = 2.7;
/// Spacing, in m, from which on single roads lose more than 2 %.
const BOUND_M: f64 = 450.0;
/// Mean slope, up or down, of a road that is flat enough for any spacing.
const FLAT: f64 = 0.003;
/// Shorter roads have no hills to lose, in m.
const SHORTEST_M: f64 = 2000.0;

/// Looks at the altitudes of a route at their positions, all in m.
pub fn judge(position_m: &[f64], altitude_m: &[f64]) -> Option<Finding> {
    let length_m = position_m.last()? - position_m.first()?;
    let steps = || position_m.windows(2).map(|pair| pair[1] - pair[0]);
    // the spacing in which a place of the road lies, in the mean
    let spacing_m = steps().map(|step_m| step_m * step_m).sum::<f64>() / length_m;
    let climbs = altitude_m.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let slope = climbs.sum::<f64>() / length_m;
    if length_m < SHORTEST_M || spacing_m < BOUND_M || slope < FLAT {
        return None;
    }
    let text = format!(
        "its altitudes are {} m apart: hills between them are lost, on the roads of the default \
         study worth about {} % of the consumption",
        rounded(spacing_m),
        rounded(LOST_PERCENT * spacing_m / 1000.0)
    );
    let remedy = "give altitudes each 100 m, or have hills drawn between them, `--draw hills`";
    Some(Finding::warned(NAME, [spacing_m, BOUND_M], text, remedy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hills_far_apart_are_named_and_a_plain_is_not() {
        let judged = |step_m: f64, height_m: f64| {
            let position_m: Vec<f64> = (0..20).map(|k| step_m * f64::from(k)).collect();
            let altitude_m: Vec<f64> = (0..20).map(|k| f64::from(k % 2) * height_m).collect();
            judge(&position_m, &altitude_m)
        };
        assert!(judged(1000.0, 10.0).is_some_and(|finding| finding.text.contains("2.7")));
        assert_eq!((judged(1000.0, 1.0), judged(200.0, 10.0)), (None, None));
    }
}
