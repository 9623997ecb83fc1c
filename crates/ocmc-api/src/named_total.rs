//! Totals of a fleet by their names, and their lines for people.

use ocmc_fleet::summary::Summary;
use ocmc_fleet::truck_year::Total;
use ocmc_io::fleet_total::{FleetTotal, fleet_totals};
use ocmc_io::number_text::{rough, rounded};
use schemars::JsonSchema;
use serde::Serialize;

/// A total of a fleet, or of a group.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct NamedTotal {
    /// Name of it.
    pub name: String,
    /// Unit of it.
    pub unit: String,
    /// The total, and where that of another fleet of as many trucks lies.
    #[serde(flatten)]
    pub total: Total,
}

/// Totals of a run in the units of people; none where each trip has a truck of its own.
pub(crate) fn named_totals(summary: &Summary) -> Vec<NamedTotal> {
    let named = |FleetTotal { name, unit, factor, total: Total { total, prediction95 } }| {
        let scaled = prediction95.map(|ends| ends.map(|end| factor * end));
        let total = Total { total: factor * total, prediction95: scaled };
        NamedTotal { name: name.to_owned(), unit: unit.to_owned(), total }
    };
    summary.trucks.iter().flat_map(fleet_totals).map(named).collect()
}

/// A total with its unit, ± where that of another fleet of as many trucks would lie.
pub(crate) fn amount(NamedTotal { unit, total, .. }: &NamedTotal) -> String {
    let Total { total, prediction95 } = total;
    let half = prediction95.map(|[low, high]| format!(" ± {}", rough((high - low) / 2.0)));
    format!("{}{} {unit}", rounded(*total), half.unwrap_or_default())
}

/// Lines of totals, ± where another fleet of as many trucks would lie.
pub(crate) fn totals_text(totals: &[NamedTotal]) -> String {
    let line = |named: &NamedTotal| format!("  {:<11} {}\n", named.name, amount(named));
    totals.iter().map(line).collect()
}
