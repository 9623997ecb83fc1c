//! The summary of one route.

use super::statistic::{Statistic, by_name, consumption_of};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// The summary of the cycles of one route.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RouteSummary {
    /// Its place among the routes, from 0.
    pub route_id: u32,
    /// Its file, where it is known.
    pub file: Option<String>,
    /// Cycles that count.
    pub cycles: u64,
    /// Distance driven in them, in m.
    pub distance_m: f64,
    /// The quantities, over them.
    #[serde(serialize_with = "by_name")]
    #[schemars(with = "BTreeMap<String, Statistic>")]
    pub statistics: Vec<Statistic>,
}

impl RouteSummary {
    /// The statistic of that name.
    pub fn statistic(&self, column: &str) -> Option<&Statistic> {
        self.statistics.iter().find(|statistic| statistic.column == column)
    }

    /// Name for people: the name of its file, without folders, or its number.
    pub fn name(&self) -> String {
        let name = |file: &String| file.rsplit(['/', '\\']).next().map(str::to_owned);
        self.file.as_ref().and_then(name).unwrap_or_else(|| format!("route {}", self.route_id))
    }

    /// The consumption that it is judged by.
    pub fn consumption(&self) -> Option<&Statistic> {
        consumption_of(&self.statistics)
    }
}
