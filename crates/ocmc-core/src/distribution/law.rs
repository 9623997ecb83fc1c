//! The laws of a study file, and which file samples them.

use super::{
    Quantity, RARE, beta, empirical, exponential, gamma, log_normal, mixture, normal, practical,
    uniform, weibull,
};
use crate::random::Draws;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A scalar law of a study file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "distribution", rename_all = "snake_case", deny_unknown_fields)]
pub enum Law {
    /// Normal.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation.
        sd: f64,
        /// Draws below are impossible (truncation, by inversion).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lower: Option<f64>,
        /// Draws above are impossible (truncation, by inversion).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        upper: Option<f64>,
    },
    /// Log-normal: ln x is normal with mean ln(median) and standard deviation `log_sd`.
    LogNormal {
        /// Median.
        median: f64,
        /// Standard deviation of ln x.
        log_sd: f64,
        /// Draws below are impossible (truncation, by inversion).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lower: Option<f64>,
        /// Draws above are impossible (truncation, by inversion).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        upper: Option<f64>,
    },
    /// Uniform on (`lower`, `upper`).
    Uniform {
        /// Lower end.
        lower: f64,
        /// Upper end.
        upper: f64,
    },
    /// Exponential.
    Exponential {
        /// Mean.
        mean: f64,
    },
    /// Gamma.
    Gamma {
        /// Mean.
        mean: f64,
        /// Shape; the coefficient of variation is 1/√shape.
        shape: f64,
    },
    /// Weibull: P(x > t) = exp(-(t/scale)^shape).
    Weibull {
        /// Mean.
        mean: f64,
        /// Shape.
        shape: f64,
    },
    /// Beta on (0, `scale`).
    Beta {
        /// First shape.
        alpha: f64,
        /// Second shape.
        beta: f64,
        /// Upper end.
        scale: f64,
    },
    /// One of several numbers or laws.
    Mixture {
        /// Weights, not necessarily summing to one.
        weights: Vec<f64>,
        /// The parts.
        components: Vec<Quantity>,
    },
    /// One of the given values.
    Empirical {
        /// The values.
        values: Vec<f64>,
        /// Their weights; equal where absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        weights: Option<Vec<f64>>,
    },
}

/// Points of the midpoint rule for a mean.
const QUADRATURE_POINTS: u32 = 20_000;

impl Law {
    /// Smallest shape of a beta law: below it a draw is 0 or `scale`, almost surely.
    pub const LEAST_SHAPE: f64 = 1e-3;

    /// One draw.
    pub fn sample(&self, draws: &mut Draws) -> f64 {
        match self {
            Self::Normal { mean, sd, lower, upper } => {
                normal::quantile(*mean, *sd, *lower, *upper, practical(draws.uniform()))
            }
            Self::LogNormal { median, log_sd, lower, upper } => {
                let p = practical(draws.uniform());
                log_normal::quantile(*median, *log_sd, *lower, *upper, p)
            }
            Self::Uniform { lower, upper } => uniform::sample(*lower, *upper, draws),
            Self::Exponential { mean } => exponential::sample(*mean, draws),
            Self::Gamma { mean, shape } => gamma::sample(*mean, *shape, draws),
            Self::Weibull { mean, shape } => weibull::sample(*mean, *shape, draws),
            Self::Beta { alpha, beta, scale } => beta::sample(*alpha, *beta, *scale, draws),
            Self::Mixture { weights, components } => mixture::sample(weights, components, draws),
            Self::Empirical { values, weights } => {
                empirical::sample(values, weights.as_deref(), draws)
            }
        }
    }

    /// The value below which a share `p` of all draws lies, for p in (0, 1); none where it has no
    /// closed form (gamma, beta, mixture, empirical).
    ///
    /// ```
    /// use ocmc_core::distribution::Law;
    /// let law = Law::Exponential { mean: 6.0 };
    /// assert!((law.quantile(0.5).unwrap() - 6.0 * 2f64.ln()).abs() < 1e-12);
    /// ```
    pub fn quantile(&self, p: f64) -> Option<f64> {
        match self {
            Self::Normal { mean, sd, lower, upper } => {
                Some(normal::quantile(*mean, *sd, *lower, *upper, p))
            }
            Self::LogNormal { median, log_sd, lower, upper } => {
                Some(log_normal::quantile(*median, *log_sd, *lower, *upper, p))
            }
            Self::Uniform { lower, upper } => Some(uniform::quantile(*lower, *upper, p)),
            Self::Exponential { mean } => Some(exponential::quantile(*mean, p)),
            Self::Weibull { mean, shape } => Some(weibull::quantile(*mean, *shape, p)),
            Self::Gamma { .. }
            | Self::Beta { .. }
            | Self::Mixture { .. }
            | Self::Empirical { .. } => None,
        }
    }

    /// See [`Quantity::mean_below`].
    pub(super) fn mean_below(&self, most: f64) -> Option<f64> {
        match self {
            Self::Mixture { weights, components } => {
                let total: f64 = weights.iter().sum();
                let parts = weights.iter().zip(components);
                let parts = parts.map(|(w, part)| Some(w / total * part.mean_below(most)?));
                parts.sum()
            }
            Self::Empirical { values, weights } => {
                let cut: Vec<f64> = values.iter().map(|value| value.min(most)).collect();
                Some(empirical::mean(&cut, weights.as_deref()))
            }
            Self::Beta { .. } | Self::Gamma { .. } => {
                (self.support().1 <= most).then(|| self.centre())
            }
            _ => {
                let p = |k: u32| (f64::from(k) + 0.5) / f64::from(QUADRATURE_POINTS);
                let values = (0..QUADRATURE_POINTS).map(|k| self.quantile(practical(p(k))));
                let sum: f64 = values.map(|value| Some(value?.min(most))).sum::<Option<f64>>()?;
                Some(sum / f64::from(QUADRATURE_POINTS))
            }
        }
    }

    /// See [`Quantity::centre`].
    pub fn centre(&self) -> f64 {
        match self {
            Self::Normal { mean, .. }
            | Self::Exponential { mean }
            | Self::Gamma { mean, .. }
            | Self::Weibull { mean, .. } => *mean,
            Self::LogNormal { median, .. } => *median,
            Self::Uniform { lower, upper } => 0.5 * (lower + upper),
            Self::Beta { alpha, beta, scale } => scale * alpha / (alpha + beta),
            Self::Mixture { weights, components } => mixture::centre(weights, components),
            Self::Empirical { values, weights } => empirical::mean(values, weights.as_deref()),
        }
    }

    /// The smallest and largest possible value.
    pub fn support(&self) -> (f64, f64) {
        match self {
            Self::Normal { lower, upper, .. } => {
                (lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY))
            }
            Self::LogNormal { lower, upper, .. } => {
                (lower.unwrap_or(0.0), upper.unwrap_or(f64::INFINITY))
            }
            Self::Uniform { lower, upper } => (*lower, *upper),
            Self::Exponential { .. } | Self::Gamma { .. } | Self::Weibull { .. } => {
                (0.0, f64::INFINITY)
            }
            Self::Beta { scale, .. } => (0.0, *scale),
            Self::Mixture { components, .. } => mixture::support(components),
            Self::Empirical { values, .. } => empirical::support(values),
        }
    }

    /// The range of all draws. Of a law whose tails go on it is that of all but one in a million on
    /// each side: those draws are put at its ends, so that a value that the check of a study has
    /// not seen is never drawn. (Gamma: its tail goes on.)
    pub fn practical_range(&self) -> (f64, f64) {
        match self {
            Self::Gamma { mean, shape } => (
                gamma::approximate_quantile(*mean, *shape, RARE),
                gamma::approximate_quantile(*mean, *shape, 1.0 - RARE),
            ),
            Self::Mixture { weights, components } => mixture::practical_range(weights, components),
            _ => match (self.quantile(RARE), self.quantile(1.0 - RARE)) {
                (Some(low), Some(high)) => (low, high),
                _ => self.support(),
            },
        }
    }

    /// Fault of the law's own parameters: (parameter, value, what is allowed).
    #[allow(
        clippy::neg_cmp_op_on_partial_ord,
        reason = "a parameter that is not a number is at fault"
    )]
    pub fn fault(&self) -> Option<(&'static str, f64, &'static str)> {
        let positive = |name, value: f64| (!(value > 0.0)).then_some((name, value, "above 0"));
        let not_negative =
            |name, value: f64| (!(value >= 0.0)).then_some((name, value, "0 or more"));
        let ordered = |lower: Option<f64>, upper: Option<f64>| match (lower, upper) {
            (Some(a), Some(b)) if !(a < b) => Some(("upper", b, "above `lower`")),
            _ => None,
        };
        let weighted = |weights: &[f64], n: usize| {
            if weights.len() != n || n == 0 {
                return Some((
                    "weights",
                    weights.len() as f64,
                    "as many weights as parts, at least one",
                ));
            }
            if let Some(&w) = weights.iter().find(|w| !(**w >= 0.0 && w.is_finite())) {
                return Some(("weights", w, "0 or more each"));
            }
            positive("weights", weights.iter().sum())
        };
        match self {
            Self::Normal { sd, lower, upper, .. } => {
                positive("sd", *sd).or_else(|| ordered(*lower, *upper))
            }
            Self::LogNormal { median, log_sd, lower, upper } => positive("median", *median)
                .or_else(|| positive("log_sd", *log_sd))
                .or_else(|| lower.and_then(|b| not_negative("lower", b)))
                .or_else(|| ordered(*lower, *upper)),
            Self::Uniform { lower, upper } => ordered(Some(*lower), Some(*upper)),
            Self::Exponential { mean } => positive("mean", *mean),
            Self::Gamma { mean, shape } | Self::Weibull { mean, shape } => {
                positive("mean", *mean).or_else(|| positive("shape", *shape))
            }
            Self::Beta { alpha, beta, scale } => [("alpha", *alpha), ("beta", *beta)]
                .into_iter()
                .find(|(_, shape)| !(*shape >= Self::LEAST_SHAPE))
                .map(|(name, shape)| (name, shape, "0.001 or more"))
                .or_else(|| positive("scale", *scale)),
            Self::Mixture { weights, components } => weighted(weights, components.len())
                .or_else(|| components.iter().find_map(Quantity::fault)),
            Self::Empirical { values, weights } => match weights {
                Some(weights) => weighted(weights, values.len()),
                None => positive("values", values.len() as f64),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_draw_lies_beyond_what_the_check_of_a_study_has_seen() {
        // cycle 12974788 of seed 1 draws a length that only one in seven million is below
        let draws = || Draws::new(1, 12_974_788, crate::random::Stream::MissionLength);
        assert!(draws().uniform() < 1e-6);
        let laws = [
            Law::Normal { mean: 20_000.0, sd: 4160.0, lower: None, upper: None },
            Law::LogNormal { median: 0.6, log_sd: 0.25, lower: None, upper: Some(1.0) },
            Law::Exponential { mean: 6.0 },
            Law::Weibull { mean: 4.0, shape: 2.0 },
        ];
        for law in laws {
            let (low, high) = law.practical_range();
            let (drawn, rounding) = (law.sample(&mut draws()), 1e-9 * high);
            assert!(drawn >= low - rounding && drawn <= high + rounding, "{law:?}: {drawn}");
        }
    }

    #[test]
    fn quantile_inverts_the_order_of_draws() {
        // a law that samples by inversion draws its quantile of the stream's uniform
        let laws = [
            Law::Normal { mean: 1.0, sd: 0.03, lower: Some(0.92), upper: None },
            Law::LogNormal { median: 0.6, log_sd: 0.25, lower: None, upper: Some(1.0) },
            Law::Uniform { lower: 2.0, upper: 8.0 },
            Law::Exponential { mean: 6.0 },
            Law::Weibull { mean: 4.0, shape: 2.0 },
        ];
        for law in laws {
            let mut draws = Draws::new(1, 0, crate::random::Stream::Vehicle);
            for _ in 0..100 {
                let u = draws.clone().uniform();
                // the exponential family takes 1 - u
                let p = match law {
                    Law::Exponential { .. } | Law::Weibull { .. } => 1.0 - u,
                    _ => u,
                };
                let (drawn, quantile) = (law.sample(&mut draws), law.quantile(p).unwrap());
                assert!((drawn - quantile).abs() < 1e-12 * drawn.abs(), "{law:?} {p}");
            }
        }
    }
}
