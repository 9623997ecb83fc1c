//! How the cycles of a fleet ended.

use ocmc_core::record::Outcome;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Serialize, Serializer};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Number of cycles by outcome, in the order of [`Outcome::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outcomes([u64; Outcome::ALL.len()]);

impl Outcomes {
    /// Counts one.
    pub(super) fn add(&mut self, outcome: Outcome) {
        self.0[outcome as usize] += 1;
    }

    /// Number of cycles that ended so.
    pub fn of(&self, outcome: Outcome) -> u64 {
        self.0[outcome as usize]
    }

    /// Number of cycles that were not completed.
    pub fn failed(&self) -> u64 {
        self.0.iter().sum::<u64>() - self.of(Outcome::Completed)
    }

    /// Number of cycles that count in no statistic: they stalled or timed out.
    pub fn uncounted(&self) -> u64 {
        self.failed() - self.of(Outcome::Depleted)
    }

    /// Number of cycles that count, of what they drove.
    pub fn counted(&self) -> u64 {
        self.of(Outcome::Completed) + self.of(Outcome::Depleted)
    }
}

/// As it is serialised.
impl JsonSchema for Outcomes {
    fn schema_name() -> Cow<'static, str> {
        "Outcomes".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        generator.subschema_for::<BTreeMap<String, u64>>()
    }
}

impl Serialize for Outcomes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(Outcome::ALL.map(|outcome| (outcome.name(), self.of(outcome))))
    }
}
