//! Statistics of one quantity of a fleet: its mean, and how it is spread over the cycles.

use super::adjustment::AdjustedStatistic;
use super::clustering::{Clusters, Spread};
use super::histogram::Histogram;
use super::quantile::{LEVELS, interval_of_clusters, quantile};
use super::quantity::CONSUMPTIONS;
use super::ratio::Ratio;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::borrow::Cow;

/// The consumption that statistics are judged by: fuel, else electricity, else the work at the
/// wheels.
pub(crate) fn consumption_of(statistics: &[Statistic]) -> Option<&Statistic> {
    let known = |column: &&str| statistics.iter().find(|s| s.column == *column && s.n > 0);
    CONSUMPTIONS.iter().find_map(known)
}

/// One quantity of a fleet. What cannot be estimated from so few cycles is `None`.
///
/// Mean and interval are the fleet's (total over total); standard deviation, quantiles and
/// histogram count each cycle once.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistic {
    /// Name of the quantity, with its unit.
    pub column: &'static str,
    /// Cycles that have it.
    pub n: u64,
    /// Mean of the fleet.
    pub mean: Option<f64>,
    /// 95 % interval of the mean.
    pub ci95: Option<[f64; 2]>,
    /// Standard deviation over the cycles.
    pub sd: Option<f64>,
    /// Quantiles over the cycles.
    pub quantiles: [Quantile; LEVELS.len()],
    /// How the cycles are spread.
    pub histogram: Option<Histogram>,
    /// Mean and quantiles adjusted by what the cycles are known to have on average; none where that
    /// is not known, or the cycles are too few.
    pub adjusted: Option<AdjustedStatistic>,
}

/// One quantile over the cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantile {
    /// Share of the cycles below it.
    pub level: f64,
    /// Its name, as `p95`.
    pub name: &'static str,
    /// Its value.
    pub value: Option<f64>,
    /// 95 % interval between order statistics.
    pub ci95: Option<[f64; 2]>,
}

impl Statistic {
    /// With intervals of clusters in several ways instead of by trucks alone; without any where
    /// they are not known.
    #[must_use]
    pub(super) fn with(mut self, error: Option<Spread>) -> Self {
        self.ci95 = self.mean.zip(error).map(|(mean, error)| error.around(mean));
        for quantile in &mut self.quantiles {
            let known = quantile.value.zip(quantile.ci95).zip(error);
            quantile.ci95 = known.map(|((value, [low, high]), error)| {
                [value - error.widened(value - low), value + error.widened(high - value)]
            });
        }
        self
    }

    /// Sums up the values of cycles (id and finite value, in the order of the ids) under the mean
    /// of their fleet.
    pub fn new(
        column: &'static str,
        mean: Option<Ratio>,
        cycles: &(impl Iterator<Item = (u64, f64)> + Clone),
        clusters: &Clusters,
    ) -> Self {
        let mut values: Vec<f64> = cycles.clone().map(|(_, value)| value).collect();
        let sd = standard_deviation(&values);
        values.sort_unstable_by(f64::total_cmp);
        Self {
            column,
            n: values.len() as u64,
            mean: mean.map(|mean| mean.ratio),
            ci95: mean.and_then(|mean| mean.ci95),
            sd,
            quantiles: LEVELS.map(|(level, name)| Quantile {
                level,
                name,
                value: quantile(&values, level),
                ci95: interval_of_clusters(&values, level, clusters, cycles.clone()),
            }),
            histogram: Histogram::of(&values),
            adjusted: None,
        }
    }
}

/// Standard deviation of a sample, with n − 1; none below two values.
pub(super) fn standard_deviation(values: &[f64]) -> Option<f64> {
    if values.len() < 2 {
        return None;
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    Some(libm::sqrt(squares / (n - 1.0)))
}

/// As it is serialised.
impl JsonSchema for Statistic {
    fn schema_name() -> Cow<'static, str> {
        "Statistic".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let number = generator.subschema_for::<Option<f64>>();
        let interval = generator.subschema_for::<Option<[f64; 2]>>();
        let adjusted = generator.subschema_for::<Option<AdjustedStatistic>>();
        let mut properties = serde_json::json!({
            "mean": number, "ci95": interval, "sd": number, "adjusted": adjusted
        });
        let mut required = vec!["mean".to_owned(), "ci95".to_owned(), "sd".to_owned()];
        for (_, name) in LEVELS {
            for (key, schema) in [(name.to_owned(), &number), (format!("{name}_ci95"), &interval)] {
                properties[&key] = schema.clone().to_value();
                required.push(key);
            }
        }
        json_schema!({
            "description": "Mean, standard deviation and quantiles, with their 95 % intervals",
            "type": "object",
            "properties": properties,
            "required": required,
        })
    }
}

impl Serialize for Statistic {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("mean", &self.mean)?;
        map.serialize_entry("ci95", &self.ci95)?;
        map.serialize_entry("sd", &self.sd)?;
        for quantile in &self.quantiles {
            map.serialize_entry(quantile.name, &quantile.value)?;
        }
        for quantile in &self.quantiles {
            map.serialize_entry(&format!("{}_ci95", quantile.name), &quantile.ci95)?;
        }
        if let Some(histogram) = &self.histogram {
            map.serialize_entry("histogram", histogram)?;
        }
        if let Some(adjusted) = &self.adjusted {
            map.serialize_entry("adjusted", adjusted)?;
        }
        map.end()
    }
}

/// Statistics as a map from their names.
pub(super) fn by_name<S: Serializer>(
    statistics: &[Statistic],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(statistics.iter().map(|statistic| (statistic.column, statistic)))
}
