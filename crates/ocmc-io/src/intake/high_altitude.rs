//! Roads above the altitudes at which engines have the torque of their maps.

use super::Finding;
use crate::number_text::rounded;

/// Name of the check.
const NAME: &str = "high-altitude";
/// Altitude from which on a turbocharged engine loses torque, in m: a generating set with a Volvo
/// engine has all of it up to 1500 m, 95 % at 2000 m and 85 % at 3000 m (Atlas Copco, manual of the
/// QAS 500).
const BOUND_M: f64 = 1500.0;

/// Looks at the altitudes of a road, in m.
pub fn judge(altitudes_m: impl IntoIterator<Item = f64>) -> Option<Finding> {
    let highest_m = altitudes_m.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let text = || {
        format!(
            "the road reaches {} m: up there an engine has less torque than its map says, 95 % at \
             2,000 m and 85 % at 3,000 m, which the model does not know",
            rounded(highest_m)
        )
    };
    (highest_m > BOUND_M).then(|| {
        Finding::warned(NAME, [highest_m, BOUND_M], text(), "speeds and gears there are too good")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_high_pass_is_named() {
        assert!(judge([0.0, 1500.0]).is_none() && judge([]).is_none());
        assert!(judge([100.0, 3100.0]).unwrap().text.contains("3,100 m"));
    }
}
