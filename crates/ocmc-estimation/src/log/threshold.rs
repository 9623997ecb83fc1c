//! The threshold detector: a curve begins above one curvature and ends below a smaller one.
//!
//! The numbers are judgement: a curve of 700 m hardly slows a truck, and the hysteresis keeps a
//! curve of changing radius in one piece.

use serde::Serialize;

/// Thresholds of the curvature.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Threshold {
    /// A curve begins above it, in 1/m.
    pub enter_per_m: f64,
    /// It ends below it, in 1/m.
    pub leave_per_m: f64,
}

impl Default for Threshold {
    fn default() -> Self {
        Self { enter_per_m: 1.0 / 700.0, leave_per_m: 1.0 / 1000.0 }
    }
}

impl Threshold {
    /// Direction of the curve that each cell lies in: 1 left, −1 right, 0 none.
    pub fn directions(&self, curvature_per_m: &[f64]) -> Vec<i8> {
        let mut directions = vec![0; curvature_per_m.len()];
        for (k, curvature) in curvature_per_m.iter().enumerate() {
            if directions[k] != 0 || !(curvature.abs() > self.enter_per_m) {
                continue;
            }
            let sign = if *curvature > 0.0 { 1 } else { -1 };
            let inside = |i: usize| f64::from(sign) * curvature_per_m[i] >= self.leave_per_m;
            let mut first = k;
            while first > 0 && directions[first - 1] == 0 && inside(first - 1) {
                first -= 1;
            }
            let mut end = k + 1;
            while end < curvature_per_m.len() && inside(end) {
                end += 1;
            }
            directions[first..end].fill(sign);
        }
        directions
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enters_and_leaves_with_hysteresis() {
        let curvature = [0.0, 0.0012, 0.002, 0.0012, 0.0008, -0.0012, -0.0009, -0.01, f64::NAN];
        let directions = Threshold::default().directions(&curvature);
        // −0.0012 alone is no curve, and −0.0009 lies between it and the right curve
        assert_eq!(directions, [0, 1, 1, 1, 0, 0, 0, -1, 0]);
    }
}
