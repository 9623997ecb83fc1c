//! Slopes that no road has over its length: per cent, or degrees, under a name that means a ratio.

use super::Finding;
use crate::number_text::rounded;

/// Name of the check.
const NAME: &str = "slope-scale";
/// Mean magnitude of the slope over the way from which on it is none of a road (judgement: roads
/// over the steepest passes have 10 % in the mean).
const REFUSED: f64 = 0.15;
/// The same of a column whose name has a unit: cliffs.
const REFUSED_WITH_UNIT: f64 = 0.6;
/// Mean magnitude from which on it is unusual.
const UNUSUAL: f64 = 0.08;
/// Shortest way that is judged, in m: a ramp may be steep.
const SHORTEST_M: f64 = 300.0;

/// Looks at slopes over the way: pairs of a length in m and the slope on it, of a column whose name
/// may have a unit.
pub fn judge(steps: impl IntoIterator<Item = (f64, f64)>, has_unit: bool) -> Option<Finding> {
    let mut sum = SlopeSum::default();
    steps.into_iter().for_each(|(length_m, slope)| sum.add(length_m, slope));
    sum.judge(has_unit)
}

/// A way with its slopes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SlopeSum {
    way_m: f64,
    climbed_m: f64,
}

impl SlopeSum {
    /// Adds a piece of way, in m, with its slope.
    pub(crate) fn add(&mut self, way_m: f64, slope: f64) {
        self.way_m += way_m;
        self.climbed_m += way_m * slope.abs();
    }

    /// As [`judge`].
    pub(crate) fn judge(self, has_unit: bool) -> Option<Finding> {
        let Self { way_m, climbed_m } = self;
        let mean = climbed_m / way_m;
        if !(way_m >= SHORTEST_M && mean > UNUSUAL) {
            return None;
        }
        let text = format!(
            "the slope is {} in the mean, up or down, over {} km: as a ratio {} %",
            rounded(mean),
            rounded(way_m / 1000.0),
            rounded(100.0 * mean)
        );
        let remedy = "no road is so steep; is it in per cent or degrees? Then name the column \
                  `grade_percent` or `grade_deg`";
        let refused = if has_unit { REFUSED_WITH_UNIT } else { REFUSED };
        Some(if mean > refused {
            Finding::refused(NAME, [mean, refused], text, remedy)
        } else {
            Finding::warned(
                NAME,
                [mean, UNUSUAL],
                text,
                "is it in per cent, or do altitudes scatter?",
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intake::End;

    #[test]
    fn slopes_of_roads_pass_and_per_cent_does_not() {
        let end = |way_m, slope| judge([(way_m, slope)], false).map(|finding| finding.end);
        for (way_m, slope, wanted) in [
            (5000.0, 0.03, None),
            (5000.0, -0.07, None),
            (200.0, 0.3, None),
            (5000.0, 0.1, Some(End::Warned)),
            (5000.0, 0.3, Some(End::Refused)),
            (5000.0, -3.0, Some(End::Refused)),
        ] {
            assert_eq!(end(way_m, slope), wanted, "{way_m} m of {slope}");
        }
        assert!(judge([], false).is_none());
        // VECTO's manoeuvres of 25 %
        let steep = judge([(1000.0, 0.2425)], true).expect("unusual");
        assert_eq!(steep.end, End::Warned);
    }
}
