//! A number of a study file that may vary: how it is drawn, read and written.

use super::levelled::LEVEL_KEYS;
use super::{Law, LevelledLaw};
use crate::random::nesting::Level;
use crate::random::{Draws, Stream, Streams};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeSeed, IntoDeserializer, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;

/// A number of the study whose population may vary: a number, or a law.
///
/// ```
/// use ocmc_core::distribution::Quantity;
/// let number: Quantity = serde_json::from_str("5.3").unwrap();
/// let text = r#"{"distribution":"log_normal","median":5.3,"log_sd":0.04}"#;
/// let law: Quantity = serde_json::from_str(text).unwrap();
/// assert!(number.centre() == law.centre());
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Quantity {
    /// The same for all.
    Number(f64),
    /// Drawn from a law.
    Law(Law),
    /// Drawn from a law at a level of its own, or with a spread between trucks.
    Levelled(Box<LevelledLaw>),
}

impl Quantity {
    /// One draw; a number takes nothing from the stream.
    pub fn sample(&self, draws: &mut Draws) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Law(law) => law.sample(draws),
            Self::Levelled(levelled) => levelled.law.sample(draws),
        }
    }

    /// One draw of what a trip has once, from the draws of its stream, at the quantity's level.
    pub fn sample_once(&self, streams: &Streams, stream: Stream, draws: &mut Draws) -> f64 {
        match self {
            Self::Levelled(levelled) => levelled.sample(streams, stream, draws),
            _ => self.sample(draws),
        }
    }

    /// As [`Self::sample_once`], from the start of a stream; its centre where it is not spread.
    pub fn drawn(&self, spread: bool, streams: &Streams, stream: Stream) -> f64 {
        self.drawn_from(spread, streams, stream, &mut streams.open(stream))
    }

    /// As [`Self::drawn`], from draws of the stream that are open already.
    pub fn drawn_from(
        &self,
        spread: bool,
        streams: &Streams,
        stream: Stream,
        draws: &mut Draws,
    ) -> f64 {
        if spread { self.sample_once(streams, stream, draws) } else { self.centre() }
    }

    /// Mean of the draws, those above `most` counted as `most`: closed form, or midpoint rule over
    /// the quantiles. None of laws of trucks, and of a gamma or beta law that is cut.
    ///
    /// ```
    /// use ocmc_core::distribution::Quantity;
    /// let law: Quantity =
    ///     serde_json::from_str(r#"{"distribution":"uniform","lower":0.0,"upper":4.0}"#).unwrap();
    /// // a half is cut at 2: 1 below, 2 above
    /// assert!((law.mean_below(2.0).unwrap() - 1.5).abs() < 1e-6);
    /// ```
    pub fn mean_below(&self, most: f64) -> Option<f64> {
        match self {
            Self::Number(value) => Some(value.min(most)),
            Self::Law(law) => law.mean_below(most),
            Self::Levelled(_) => None,
        }
    }

    /// Fault of a law's own parameters: (parameter, value, what is allowed).
    pub fn fault(&self) -> Option<(&'static str, f64, &'static str)> {
        match self {
            Self::Number(_) => None,
            Self::Law(law) => law.fault(),
            Self::Levelled(levelled) => levelled.fault(),
        }
    }

    /// See [`Law::practical_range`]; a number is a range of its own.
    pub fn practical_range(&self) -> (f64, f64) {
        match self {
            Self::Number(value) => (*value, *value),
            Self::Law(law) => law.practical_range(),
            Self::Levelled(levelled) => levelled.practical_range(),
        }
    }

    /// The value where the spread is turned off: the number, the median of a symmetric or
    /// log-normal law, otherwise the mean.
    pub fn centre(&self) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Law(law) => law.centre(),
            Self::Levelled(levelled) => levelled.law.centre(),
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
        let mut level_keys = LevelKeys::default();
        let law = WithoutLevelKeys { map, level_keys: &mut level_keys };
        let law = Law::deserialize(MapAccessDeserializer::new(law))?;
        let LevelKeys { level, truck_sd, truck_log_sd } = level_keys;
        if level.is_none() && truck_sd.is_none() && truck_log_sd.is_none() {
            return Ok(Quantity::Law(law));
        }
        let levelled = LevelledLaw { law, level, truck_sd, truck_log_sd };
        Ok(Quantity::Levelled(Box::new(levelled)))
    }
}

/// Keys of a table beside its law.
#[derive(Default)]
struct LevelKeys {
    level: Option<Level>,
    truck_sd: Option<f64>,
    truck_log_sd: Option<f64>,
}

/// A table less the keys that stand beside its law.
struct WithoutLevelKeys<'a, M> {
    map: M,
    level_keys: &'a mut LevelKeys,
}

impl<'de, M: MapAccess<'de>> MapAccess<'de> for WithoutLevelKeys<'_, M> {
    type Error = M::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, M::Error> {
        let [level, truck_sd, truck_log_sd] = LEVEL_KEYS;
        while let Some(key) = self.map.next_key::<String>()? {
            if key == level {
                self.level_keys.level = Some(self.map.next_value()?);
            } else if key == truck_sd {
                self.level_keys.truck_sd = Some(self.map.next_value()?);
            } else if key == truck_log_sd {
                self.level_keys.truck_log_sd = Some(self.map.next_value()?);
            } else {
                return seed.deserialize(key.into_deserializer()).map(Some);
            }
        }
        Ok(None)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, M::Error> {
        self.map.next_value_seed(seed)
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
