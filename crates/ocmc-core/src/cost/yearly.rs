//! A price that may vary: between states of the world, or from year to year of a truck's life.

use crate::distribution::Quantity;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::json;
use std::fmt;

/// A price: a number, a law that is drawn once for all trips and years, or the prices of the years
/// of the life, of which the last goes on.
///
/// ```
/// use ocmc_core::cost::Yearly;
/// let price: Yearly = serde_json::from_str("[1.5, 1.6]").unwrap();
/// assert_eq!(price, Yearly::ByYear(vec![1.5, 1.6]));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Yearly {
    /// The same in all years.
    Constant(Quantity),
    /// One of each year, from the first.
    ByYear(Vec<f64>),
}

impl From<f64> for Yearly {
    fn from(price: f64) -> Self {
        Self::Constant(price.into())
    }
}

impl<'de> Deserialize<'de> for Yearly {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(YearlyVisitor)
    }
}

struct YearlyVisitor;

impl<'de> Visitor<'de> for YearlyVisitor {
    type Value = Yearly;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(
            "a number, a list of the prices by year, or a table such as \
             { distribution = \"normal\", mean = 1.0, sd = 0.1 }",
        )
    }
    fn visit_f64<E>(self, value: f64) -> Result<Yearly, E> {
        Ok(value.into())
    }
    fn visit_i64<E>(self, value: i64) -> Result<Yearly, E> {
        Ok((value as f64).into())
    }
    fn visit_u64<E>(self, value: u64) -> Result<Yearly, E> {
        Ok((value as f64).into())
    }
    fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Yearly, M::Error> {
        Quantity::deserialize(MapAccessDeserializer::new(map)).map(Yearly::Constant)
    }
    fn visit_seq<S: SeqAccess<'de>>(self, seq: S) -> Result<Yearly, S::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(seq)).map(Yearly::ByYear)
    }
}

impl JsonSchema for Yearly {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Yearly".into()
    }
    fn inline_schema() -> bool {
        // a key's range is put beside its type
        true
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut schema = Quantity::json_schema(generator);
        schema.insert("description".to_owned(), json!("a number, a distribution, or one by year"));
        schema.insert("type".to_owned(), json!(["number", "array", "object"]));
        if let Some(kinds) = schema.get_mut("anyOf").and_then(serde_json::Value::as_array_mut) {
            kinds.push(json!({ "type": "array", "items": { "type": "number" } }));
        }
        schema
    }
}
