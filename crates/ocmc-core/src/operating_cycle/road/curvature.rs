//! Curves: Poisson starts, shifted log-normal radius, log-normal length, random direction.
//!
//! R = r_turn + exp(N(ln median, σ²)); ln L ~ N(ln median, σ_L²); curvature is constant within a
//! curve and zero outside. A curve that would start inside another starts at its end, which keeps
//! the intensity; L is shortened so that the heading change L/R stays within its bound.
//!
//! On urban and rural roads curves follow the sign: λ(v) = λ_ref (v_ref / v_sign)^p, at most λ_max,
//! and the median of R − r_turn is proportional to v_sign. Derived from an OpenStreetMap extract of
//! Lower Saxony: drawn independently of the sign, tight bends fall on 80 km/h roads and cost 1.6
//! L/100 km (curves by the sign). Junction turns belong to events, see [`super::point_event`].
//!
//! Checked: number, mean and SD of ln(R − r_turn), and the share of left curves on 2000 km lie
//! within four standard errors, for seeds 1, 2 and 3. Curves do not overlap and make no loops. The
//! intensity follows the sign, up to its bound.

use crate::random::Draws;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Curves of one road type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurveModel {
    /// Intensity of curve starts, per m, at the reference sign.
    #[schemars(range(min = 0.0, max = 0.05))]
    pub per_m: f64,
    /// Highest intensity, per m.
    #[schemars(range(min = 0.0, max = 0.05))]
    pub maximum_per_m: f64,
    /// Sign at which intensity and median radius hold, in m/s; absent: they hold for every sign.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 2.0, max = 70.0))]
    pub reference_sign_mps: Option<f64>,
    /// Exponent of the intensity in v_ref / v_sign.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub sign_exponent: f64,
    /// Smallest radius R_turn, in m.
    #[schemars(range(min = 5.0, max = 2000.0))]
    pub turn_radius_m: f64,
    /// Median of R − R_turn, in m, at the reference sign.
    #[schemars(range(min = 1.0, max = 10_000.0))]
    pub median_radius_m: f64,
    /// Standard deviation of ln(R − R_turn).
    #[schemars(range(min = 0.0, max = 3.0))]
    pub radius_log_sd: f64,
    /// Median length, in m.
    #[schemars(range(min = 1.0, max = 5000.0))]
    pub median_length_m: f64,
    /// Standard deviation of ln L.
    #[schemars(range(min = 0.0, max = 3.0))]
    pub length_log_sd: f64,
    /// Largest heading change L/R, in rad.
    #[schemars(range(min = 0.1, max = 6.3))]
    pub maximum_heading_rad: f64,
}

/// A curve of constant radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    /// Where it starts, in m.
    pub start_m: f64,
    /// Where it ends, in m.
    pub end_m: f64,
    /// Radius, in m.
    pub radius_m: f64,
    /// True for a left curve (positive curvature).
    pub left: bool,
}

impl Curve {
    /// Signed curvature, in 1/m; positive to the left.
    pub fn curvature_per_m(&self) -> f64 {
        if self.left { 1.0 / self.radius_m } else { -1.0 / self.radius_m }
    }
}

impl CurveModel {
    /// Intensity under a sign, per m.
    pub fn intensity_per_m(&self, sign_mps: f64) -> f64 {
        let factor = match self.reference_sign_mps {
            Some(reference) => libm::pow(reference / sign_mps, self.sign_exponent),
            None => 1.0,
        };
        (self.per_m * factor).min(self.maximum_per_m)
    }

    /// Appends the curves that start in [`from_m`, `to_m`), under one sign.
    pub fn sample(
        &self,
        from_m: f64,
        to_m: f64,
        sign_mps: f64,
        draws: &mut Draws,
        curves: &mut Vec<Curve>,
    ) {
        let intensity = self.intensity_per_m(sign_mps);
        if intensity <= 0.0 {
            return;
        }
        let scale = self.reference_sign_mps.map_or(1.0, |reference| sign_mps / reference);
        let median = self.median_radius_m * scale;
        let mut position = from_m;
        loop {
            position += draws.exponential() / intensity;
            if position >= to_m {
                return;
            }
            let radius_m =
                self.turn_radius_m + median * libm::exp(self.radius_log_sd * draws.normal());
            let length = self.median_length_m * libm::exp(self.length_log_sd * draws.normal());
            let left = draws.happens(0.5);
            let start_m = curves.last().map_or(position, |last| position.max(last.end_m));
            let end_m = start_m + length.min(self.maximum_heading_rad * radius_m);
            curves.push(Curve { start_m, end_m, radius_m, left });
        }
    }
}

/// Places junction turns, which win: a curve that a turn overlaps is dropped, and so is a turn that
/// begins inside an earlier one. Both lists are in order of position; so is the result.
pub fn merge_turns(curves: &mut Vec<Curve>, turns: &[Curve]) {
    if turns.is_empty() {
        return;
    }
    let mut kept: Vec<Curve> = Vec::with_capacity(turns.len());
    for turn in turns {
        if kept.last().is_none_or(|last| turn.start_m >= last.end_m) {
            kept.push(*turn);
        }
    }
    curves.retain(|curve| {
        !kept.iter().any(|turn| curve.start_m < turn.end_m && turn.start_m < curve.end_m)
    });
    curves.extend_from_slice(&kept);
    curves.sort_by(|a, b| a.start_m.total_cmp(&b.start_m));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    fn rural() -> CurveModel {
        CurveModel {
            per_m: 1.0e-3,
            maximum_per_m: 4.0e-3,
            reference_sign_mps: Some(70.0 / 3.6),
            sign_exponent: 2.5,
            turn_radius_m: 15.0,
            median_radius_m: 250.0,
            radius_log_sd: 0.9,
            median_length_m: 120.0,
            length_log_sd: 0.6,
            maximum_heading_rad: 1.57,
        }
    }

    #[test]
    fn moments_within_four_standard_errors() {
        let (from, to) = (0.0, 2.0e6);
        for seed in 1..=3 {
            let mut curves = Vec::new();
            let mut draws = Draws::new(seed, 0, Stream::Curve);
            rural().sample(from, to, 70.0 / 3.6, &mut draws, &mut curves);
            let n = curves.len() as f64;
            let expected = 1.0e-3 * (to - from);
            assert!((n - expected).abs() < 4.0 * expected.sqrt(), "{n} curves");
            let log = |c: &Curve| (c.radius_m - 15.0).ln();
            let mean = curves.iter().map(log).sum::<f64>() / n;
            let var = curves.iter().map(|c| (log(c) - mean).powi(2)).sum::<f64>() / (n - 1.0);
            assert!((mean - 250f64.ln()).abs() < 4.0 * 0.9 / n.sqrt(), "{mean}");
            assert!((var.sqrt() - 0.9).abs() < 4.0 * 0.9 / (2.0 * n).sqrt(), "{var}");
            let left = curves.iter().filter(|c| c.left).count() as f64;
            assert!((left / n - 0.5).abs() < 4.0 * 0.5 / n.sqrt());
        }
    }

    #[test]
    fn curves_do_not_overlap_and_turn_no_loops() {
        let mut curves = Vec::new();
        let mut draws = Draws::new(1, 0, Stream::Curve);
        rural().sample(0.0, 1.0e6, 30.0 / 3.6, &mut draws, &mut curves);
        for pair in curves.windows(2) {
            assert!(pair[1].start_m >= pair[0].end_m);
        }
        for curve in &curves {
            assert!((curve.end_m - curve.start_m) / curve.radius_m <= 1.57 + 1e-9);
        }
    }

    #[test]
    fn curves_follow_the_sign() {
        let model = rural();
        let slow = model.intensity_per_m(50.0 / 3.6);
        let fast = model.intensity_per_m(80.0 / 3.6);
        assert!((slow / fast - 1.6f64.powf(2.5)).abs() < 1e-12);
        assert!((model.intensity_per_m(20.0 / 3.6) - 4.0e-3).abs() < 1e-18);
    }

    #[test]
    fn turns_replace_the_curves_they_overlap() {
        let curve = |start_m, end_m| Curve { start_m, end_m, radius_m: 100.0, left: true };
        let mut curves = vec![curve(0.0, 10.0), curve(20.0, 40.0), curve(50.0, 60.0)];
        merge_turns(&mut curves, &[curve(35.0, 45.0), curve(44.0, 48.0)]);
        let starts: Vec<f64> = curves.iter().map(|c| c.start_m).collect();
        assert_eq!(starts, [0.0, 35.0, 50.0]);
    }
}
