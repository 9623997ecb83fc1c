//! A number of a study file that may vary: how it is drawn, read and written.

use super::Law;
use crate::random::Draws;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
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
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Quantity {
    /// The same for all.
    Number(f64),
    /// Drawn from a law.
    Law(Law),
}

impl Quantity {
    /// One draw; a number takes nothing from the stream.
    pub fn sample(&self, draws: &mut Draws) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Law(law) => law.sample(draws),
        }
    }

    /// The value where the spread is turned off: the number, the median of a symmetric or
    /// log-normal law, otherwise the mean.
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
    fn inline_schema() -> bool {
        // a key's range is put beside its type
        true
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        schemars::json_schema!({
            "description": "a number, or a distribution",
            "type": ["number", "object"],
            "anyOf": [{ "type": "number" }, { "$ref": "#/$defs/Law" }]
        })
    }
}
