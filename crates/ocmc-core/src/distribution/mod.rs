//! The scalar laws that a study file names, and the number-or-distribution that uses them.
//!
//! Every law samples with elementary operations and `libm`, so that the bits are the same everywhere.

mod normal_quantile;

pub use normal_quantile::normal_quantile;

use crate::random::Draws;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// A number of the study whose population may vary: a number, or a law.
///
/// ```
/// use ocmc_core::distribution::Quantity;
/// let number: Quantity = serde_json::from_str("5.3").unwrap();
/// let law: Quantity =
///     serde_json::from_str(r#"{"distribution":"log_normal","median":5.3,"log_sd":0.04}"#).unwrap();
/// assert!(number.centre() == law.centre());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Quantity {
    /// The same for all.
    Number(f64),
    /// Drawn from a law.
    Law(Law),
}

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

impl Quantity {
    /// One draw; a number takes nothing from the stream.
    pub fn sample(&self, draws: &mut Draws) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Law(law) => law.sample(draws),
        }
    }

    /// The value where the spread is turned off: the number, the median of a symmetric or log-normal
    /// law, otherwise the mean.
    pub fn centre(&self) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Law(law) => law.centre(),
        }
    }
}

impl From<f64> for Quantity {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl Law {
    /// One draw.
    pub fn sample(&self, draws: &mut Draws) -> f64 {
        match self {
            Self::Normal { mean, sd, lower, upper } => {
                let limit = |bound: Option<f64>| bound.map(|b| (b - mean) / sd);
                mean + sd * truncated_normal(draws, limit(*lower), limit(*upper))
            }
            Self::LogNormal { median, log_sd, lower, upper } => {
                let limit = |bound: Option<f64>| bound.map(|b| libm::log(b / median) / log_sd);
                let z = truncated_normal(draws, limit(*lower), limit(*upper));
                let x = median * libm::exp(log_sd * z);
                x.clamp(lower.unwrap_or(0.0), upper.unwrap_or(f64::INFINITY))
            }
            Self::Uniform { lower, upper } => draws.uniform_between(*lower, *upper),
            Self::Exponential { mean } => mean * draws.exponential(),
            Self::Gamma { mean, shape } => mean / shape * standard_gamma(draws, *shape),
            Self::Weibull { mean, shape } => {
                let scale = mean / libm::tgamma(1.0 + 1.0 / shape);
                scale * libm::pow(draws.exponential(), 1.0 / shape)
            }
            Self::Beta { alpha, beta, scale } => {
                let a = standard_gamma(draws, *alpha);
                scale * a / (a + standard_gamma(draws, *beta))
            }
            Self::Mixture { weights, components } => {
                let part = draws.index(weights);
                components[part].sample(draws)
            }
            Self::Empirical { values, weights } => match weights {
                Some(weights) => values[draws.index(weights)],
                None => values[(draws.uniform() * values.len() as f64) as usize],
            },
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
            Self::Mixture { weights, components } => {
                let total: f64 = weights.iter().sum();
                weights.iter().zip(components).map(|(w, c)| w * c.centre()).sum::<f64>() / total
            }
            Self::Empirical { values, weights } => match weights {
                Some(weights) => {
                    let total: f64 = weights.iter().sum();
                    weights.iter().zip(values).map(|(w, v)| w * v).sum::<f64>() / total
                }
                None => values.iter().sum::<f64>() / values.len() as f64,
            },
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
            Self::Mixture { components, .. } => components
                .iter()
                .map(|part| match part {
                    Quantity::Number(value) => (*value, *value),
                    Quantity::Law(law) => law.support(),
                })
                .fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1))),
            Self::Empirical { values, .. } => values
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |a, &v| (a.0.min(v), a.1.max(v))),
        }
    }

    /// The range of all draws but one in a million on each side.
    ///
    /// Gamma by the approximation of E. B. Wilson and M. M. Hilferty (1931): good to a few per cent there.
    pub fn practical_range(&self) -> (f64, f64) {
        const Z: f64 = 4.753424308822899;
        const RARE: f64 = 1e-6;
        let (low, high) = match self {
            Self::Normal { mean, sd, .. } => (mean - Z * sd, mean + Z * sd),
            Self::LogNormal { median, log_sd, .. } => {
                (median * libm::exp(-Z * log_sd), median * libm::exp(Z * log_sd))
            }
            Self::Exponential { mean } => (mean * RARE, -mean * libm::log(RARE)),
            Self::Gamma { mean, shape } => {
                let cube = |z: f64| {
                    let root = 1.0 - 1.0 / (9.0 * shape) + z / (3.0 * shape.sqrt());
                    mean * root.max(0.0) * root.max(0.0) * root.max(0.0)
                };
                (cube(-Z), cube(Z))
            }
            Self::Weibull { mean, shape } => {
                let scale = mean / libm::tgamma(1.0 + 1.0 / shape);
                let at = |p: f64| scale * libm::pow(-libm::log1p(-p), 1.0 / shape);
                (at(RARE), at(1.0 - RARE))
            }
            Self::Uniform { .. } | Self::Beta { .. } | Self::Empirical { .. } => self.support(),
            Self::Mixture { weights, components } => weights
                .iter()
                .zip(components)
                .filter(|(weight, _)| **weight > 0.0)
                .map(|(_, part)| match part {
                    Quantity::Number(value) => (*value, *value),
                    Quantity::Law(law) => law.practical_range(),
                })
                .fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1))),
        };
        let (lower, upper) = self.support();
        (low.max(lower), high.min(upper))
    }

    /// What is wrong with the law's own parameters: (parameter, value, what is allowed).
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
            Self::Beta { alpha, beta, scale } => positive("alpha", *alpha)
                .or_else(|| positive("beta", *beta))
                .or_else(|| positive("scale", *scale)),
            Self::Mixture { weights, components } => {
                weighted(weights, components.len()).or_else(|| {
                    components.iter().find_map(|part| match part {
                        Quantity::Number(_) => None,
                        Quantity::Law(law) => law.fault(),
                    })
                })
            }
            Self::Empirical { values, weights } => match weights {
                Some(weights) => weighted(weights, values.len()),
                None => positive("values", values.len() as f64),
            },
        }
    }
}

/// Standard normal truncated to [`lower`, `upper`], by inversion: exactly one uniform a draw.
fn truncated_normal(draws: &mut Draws, lower: Option<f64>, upper: Option<f64>) -> f64 {
    let u = draws.uniform();
    if lower.is_none() && upper.is_none() {
        return normal_quantile(u);
    }
    let cdf = |x: f64| 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2);
    let a = lower.map_or(0.0, cdf);
    let b = upper.map_or(1.0, cdf);
    let p = (a + (b - a) * u).clamp(f64::MIN_POSITIVE, 1.0 - f64::EPSILON / 2.0);
    normal_quantile(p).clamp(lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY))
}

/// Gamma with scale 1. G. Marsaglia and W. W. Tsang, "A simple method for generating gamma
/// variables", ACM Transactions on Mathematical Software 26 (2000) 363-372.
pub fn standard_gamma(draws: &mut Draws, shape: f64) -> f64 {
    if shape < 1.0 {
        let boost = libm::pow(draws.uniform(), 1.0 / shape);
        return boost * standard_gamma(draws, shape + 1.0);
    }
    let d = shape - 1.0 / 3.0;
    let c = 1.0 / (9.0 * d).sqrt();
    loop {
        let x = draws.normal();
        let t = 1.0 + c * x;
        if t <= 0.0 {
            continue;
        }
        let v = t * t * t;
        if libm::log(draws.uniform()) < 0.5 * x * x + d - d * v + d * libm::log(v) {
            return d * v;
        }
    }
}

impl Serialize for Quantity {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Number(value) => serializer.serialize_f64(*value),
            Self::Law(law) => law.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Quantity {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(QuantityVisitor)
    }
}

struct QuantityVisitor;

impl<'de> Visitor<'de> for QuantityVisitor {
    type Value = Quantity;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(
            "a number, or a table such as { distribution = \"normal\", mean = 1.0, sd = 0.1 }",
        )
    }
    fn visit_f64<E>(self, value: f64) -> Result<Quantity, E> {
        Ok(Quantity::Number(value))
    }
    fn visit_i64<E>(self, value: i64) -> Result<Quantity, E> {
        Ok(Quantity::Number(value as f64))
    }
    fn visit_u64<E>(self, value: u64) -> Result<Quantity, E> {
        Ok(Quantity::Number(value as f64))
    }
    fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Quantity, M::Error> {
        Law::deserialize(MapAccessDeserializer::new(map)).map(Quantity::Law)
    }
}

impl JsonSchema for Quantity {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Quantity".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let law = generator.subschema_for::<Law>();
        schemars::json_schema!({
            "description": "a number, or a distribution",
            "anyOf": [{ "type": "number" }, law]
        })
    }
}
