//! The operational module: from the speed error to the pedals.
//!
//! PID: u = K_P e + J − K_D dv/dt with J = K_I ∫e dt; the derivative acts on the filtered speed,
//! because the desired speed jumps. Anti-windup by back-calculation with tracking time T_t = r
//! K_P/K_I, and J clamped: with a fixed T_t of 2 s the integral runs to −8 while saturated and the
//! truck stalls in front of stops (anti-windup tracking, integral clamp). Switched: u = K_P e
//! while |e| > threshold, otherwise the throttle is held; a held brake is released when e ≥ 0 (held
//! throttle). Held in balance, it is the pedal that keeps the speed, and outside of the threshold
//! u = that pedal + K_P e. On a braking ramp u = what the ramp asks for + K_P e (feed-forward).
//! Pedals: a_p = clip(u, 0, 1), b_p = clip(−s u, 0, 1) with the brake scale s, because
//! the brake acts about 12 times stronger than the throttle.
//!
//! Both are one controller in the step: a PID never holds, a switched driver has K_I = K_D = 0. The
//! paper prints gains in figures only; the numbers of the default study are derived (two real poles
//! at 0.1 rad/s for 40 t at 70 km/h).
//!
//! Checked: medians, SDs and correlations of 20,000 draws lie within four standard errors, for
//! seeds 1, 2 and 3. In `tests/it/closed_loop.rs`: no chatter of pedals or gears on a smooth
//! descent, pedals that reverse hardly more often than with steps of 0.02 s, no overshoot after ten
//! minutes at full throttle, and a brake held as printed that costs fuel.

use crate::distribution::Quantity;
use crate::random::{Draws, Stream, Streams};
use crate::validation::Problems;
use nalgebra::{Matrix3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Statistical description of pedal controllers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PedalModel {
    /// Share of drivers with a PID controller; the others switch.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub pid_share: f64,
    /// The PID controller.
    pub pid: PidModel,
    /// The switched controller.
    pub switched: SwitchedModel,
    /// Brake pedal for each unit of u.
    #[schemars(range(min = 0.01, max = 10.0))]
    pub brake_scale: f64,
    /// Speed above the desired one that a driver allows downhill, in m/s.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub overspeed_band_mps: f64,
    /// Speed above which the band exists, in m/s.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub overspeed_from_mps: f64,
    /// Whether a driver on a braking ramp presses as far as the ramp asks, and corrects the rest.
    pub feed_forward: bool,
    /// Smallest K_P on a braking ramp with feed-forward, in s/m.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub ramp_gain_minimum: f64,
    /// Time before a braking ramp at which a driver leaves the accelerator, in s.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub ramp_lead_s: f64,
    /// Share of the speed that a braking ramp takes before the driver brakes: he coasts until then.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub ramp_slack_share: f64,
    /// Speed above the desired one, in m/s, at which a driver begins to brake where no braking ramp
    /// lies and no band holds; 0: with the controller's output.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub brake_tolerance_mps: f64,
}

/// The PID controller: ln K_P, ln T_i and ln K_D are normal, with correlation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PidModel {
    /// Median of K_P, in s/m.
    #[schemars(range(min = 0.01, max = 10.0))]
    pub proportional_median: f64,
    /// Standard deviation of ln K_P.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub proportional_log_sd: f64,
    /// Smallest K_P, in s/m; draws outside are redrawn.
    #[schemars(range(min = 0.001, max = 10.0))]
    pub proportional_minimum: f64,
    /// Largest K_P, in s/m.
    #[schemars(range(min = 0.001, max = 10.0))]
    pub proportional_maximum: f64,
    /// Median of T_i = K_P / K_I, in s; 0 for no integral part.
    #[schemars(range(min = 0.0, max = 10_000.0))]
    pub integral_time_median_s: f64,
    /// Standard deviation of ln T_i.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub integral_time_log_sd: f64,
    /// Median of K_D, in s²/m.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub derivative_median: f64,
    /// Standard deviation of ln K_D.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub derivative_log_sd: f64,
    /// Correlations of (ln K_P, ln T_i), (ln K_P, ln K_D), (ln T_i, ln K_D).
    #[schemars(inner(range(min = -0.99, max = 0.99)))]
    pub correlation: [f64; 3],
    /// Time constant of the speed filter of the derivative, in s.
    #[schemars(range(min = 0.2, max = 10.0))]
    pub derivative_filter_s: f64,
    /// Ratio of the tracking time to K_P / K_I.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub tracking_ratio: f64,
    /// Lowest integral part of the output.
    #[schemars(range(min = -10.0, max = 0.0))]
    pub integral_minimum: f64,
    /// Highest integral part of the output.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub integral_maximum: f64,
}

impl PidModel {
    /// Gains in order, and correlations that there can be.
    pub fn validate(&self, problems: &mut Problems) {
        problems.require(
            self.proportional_minimum <= self.proportional_maximum,
            "proportional_minimum",
            self.proportional_minimum,
            "at most proportional_maximum",
        );
        let [pi, pd, id] = self.correlation;
        let matrix = Matrix3::new(1.0, pi, pd, pi, 1.0, id, pd, id, 1.0);
        problems.require(
            matrix.cholesky().is_some(),
            "correlation",
            format!("{:?}", self.correlation),
            "a positive definite correlation matrix",
        );
    }

    fn sample(&self, draws: &mut Draws, spread: bool, stability_limit: f64) -> Pedals {
        let highest = self.proportional_maximum.min(stability_limit);
        let [pi, pd, id] = self.correlation;
        let correlation = Matrix3::new(1.0, pi, pd, pi, 1.0, id, pd, id, 1.0);
        let factor = correlation.cholesky().map_or_else(Matrix3::identity, |c| c.l());
        let mut redraws = 0;
        loop {
            let independent = Vector3::new(draws.normal(), draws.normal(), draws.normal());
            let z = if spread { factor * independent } else { Vector3::zeros() };
            let mut proportional =
                self.proportional_median * libm::exp(self.proportional_log_sd * z[0]);
            let inside = (self.proportional_minimum..=highest).contains(&proportional);
            if !inside && redraws < MOST_REDRAWS && spread {
                redraws += 1;
                continue;
            }
            proportional = proportional.max(self.proportional_minimum).min(highest);
            let time_s = self.integral_time_median_s * libm::exp(self.integral_time_log_sd * z[1]);
            return Pedals {
                proportional,
                integral: if time_s > 0.0 { proportional / time_s } else { 0.0 },
                derivative: self.derivative_median * libm::exp(self.derivative_log_sd * z[2]),
                threshold_mps: None,
                hold: Hold::Throttle,
                redraws,
            };
        }
    }
}

/// The switched proportional controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SwitchedModel {
    /// K_P, in s/m.
    #[schemars(range(min = 0.01, max = 10.0))]
    pub proportional: Quantity,
    /// Threshold of |e|, in m/s.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub threshold_mps: Quantity,
    /// The pedal that is held inside the threshold.
    pub hold: Hold,
}

/// Pedals that a switched controller holds inside its threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Hold {
    /// The throttle; a held brake is released when e ≥ 0.
    Throttle,
    /// Throttle and brake, as printed in the paper.
    Paper,
    /// The pedal that keeps the speed at the moment when holding begins; outside the threshold the
    /// driver corrects around it, until the error is a quarter of the threshold.
    Balance,
}

/// One driver's pedal controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pedals {
    /// K_P, in s/m.
    pub proportional: f64,
    /// K_I, in 1/m; 0 for a switched driver.
    pub integral: f64,
    /// K_D, in s²/m; 0 for a switched driver.
    pub derivative: f64,
    /// Threshold of a switched driver, in m/s; none for a PID.
    pub threshold_mps: Option<f64>,
    /// Pedals that a switched driver holds.
    pub hold: Hold,
    /// Draws of gains that were outside the bounds and drawn again.
    pub redraws: u32,
}

/// Tries before an impossible set of bounds gives way to its nearest corner.
const MOST_REDRAWS: u32 = 1000;

impl PedalModel {
    /// Draws one driver; `spread` false gives the median driver of the larger group.
    /// `stability_limit` is the largest K_P that the brake allows at the study's step.
    pub fn sample(&self, streams: &Streams, spread: bool, stability_limit: f64) -> Pedals {
        let mut draws = streams.open(Stream::Pedals);
        let is_pid = if spread { draws.happens(self.pid_share) } else { self.pid_share >= 0.5 };
        if is_pid {
            self.pid.sample(&mut draws, spread, stability_limit)
        } else {
            let model = &self.switched;
            let mut draw =
                |law: &Quantity| law.drawn_from(spread, streams, Stream::Pedals, &mut draws);
            Pedals {
                proportional: draw(&model.proportional).min(stability_limit),
                integral: 0.0,
                derivative: 0.0,
                threshold_mps: Some(draw(&model.threshold_mps)),
                hold: model.hold,
                redraws: 0,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::Law;

    fn model() -> PedalModel {
        PedalModel {
            pid_share: 0.7,
            pid: PidModel {
                proportional_median: 0.47,
                proportional_log_sd: 0.4,
                proportional_minimum: 0.01,
                proportional_maximum: 100.0,
                integral_time_median_s: 20.0,
                integral_time_log_sd: 0.3,
                derivative_median: 0.05,
                derivative_log_sd: 0.4,
                correlation: [0.3, 0.0, -0.2],
                derivative_filter_s: 0.5,
                tracking_ratio: 0.5,
                integral_minimum: -0.15,
                integral_maximum: 1.0,
            },
            switched: SwitchedModel {
                proportional: Quantity::Number(0.47),
                threshold_mps: Quantity::Law(Law::Uniform { lower: 0.3, upper: 1.2 }),
                hold: Hold::Throttle,
            },
            brake_scale: 0.3,
            overspeed_band_mps: 1.39,
            overspeed_from_mps: 14.0,
            feed_forward: true,
            ramp_gain_minimum: 0.8,
            ramp_lead_s: 2.0,
            ramp_slack_share: 0.04,
            brake_tolerance_mps: 0.8,
        }
    }

    #[test]
    fn gains_have_the_wanted_moments_and_correlations() {
        for seed in 1..=3 {
            let mut logs = Vec::new();
            for cycle_id in 0..20_000 {
                let streams = Streams::new(seed, cycle_id);
                let p = model().sample(&streams, true, f64::INFINITY);
                if p.threshold_mps.is_none() {
                    let time = p.proportional / p.integral;
                    logs.push([p.proportional.ln(), time.ln(), p.derivative.ln()]);
                }
            }
            let n = logs.len() as f64;
            assert!((n / 20_000.0 - 0.7).abs() < 4.0 * (0.21f64 / 20_000.0).sqrt());
            let mean = |i: usize| logs.iter().map(|x| x[i]).sum::<f64>() / n;
            let cov = |i: usize, j: usize| {
                let (a, b) = (mean(i), mean(j));
                logs.iter().map(|x| (x[i] - a) * (x[j] - b)).sum::<f64>() / (n - 1.0)
            };
            for (i, (median, sd)) in [(0.47f64, 0.4), (20.0, 0.3), (0.05, 0.4)].iter().enumerate() {
                assert!((mean(i) - median.ln()).abs() < 4.0 * sd / n.sqrt());
                assert!((cov(i, i).sqrt() - sd).abs() < 4.0 * sd / (2.0 * n).sqrt());
            }
            for (i, j, r) in [(0, 1, 0.3), (0, 2, 0.0), (1, 2, -0.2)] {
                let sample = cov(i, j) / (cov(i, i) * cov(j, j)).sqrt();
                assert!((sample - r).abs() < 4.0 * (1.0 - r * r) / n.sqrt(), "{sample} {r}");
            }
        }
    }

    #[test]
    fn gains_beyond_the_stability_bound_are_drawn_again_and_counted() {
        let mut redraws = 0;
        for cycle_id in 0..500 {
            let streams = Streams::new(1, cycle_id);
            let p = model().sample(&streams, true, 0.5);
            assert!(p.proportional <= 0.5);
            redraws += p.redraws;
        }
        assert!(redraws > 50);
    }

    #[test]
    fn no_integral_time_means_no_integral_gain() {
        let mut model = model();
        model.pid_share = 1.0;
        model.pid.integral_time_median_s = 0.0;
        let streams = Streams::new(1, 0);
        assert!(model.sample(&streams, true, 1.0).integral == 0.0);
    }
}
