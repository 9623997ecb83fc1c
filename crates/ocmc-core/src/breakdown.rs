//! Breakdown of a cycle by road type and by kind of event: distance, time, work at the wheels, and
//! what its stores gave. The parts of either add up to the whole.

use crate::energy::carrier::{CARRIERS, Carrier, MOST_CARRIERS};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Axis by which cycles are broken down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// The road types of the study.
    RoadType,
    /// Demand of each metre of road on a driver: a stop, a curve, a limit, a hill or cruising.
    EventKind,
}

impl Axis {
    /// Both.
    pub const ALL: [Self; 2] = [Self::RoadType, Self::EventKind];

    /// Prefix of a part's name in a column.
    fn prefix(self) -> &'static str {
        match self {
            Self::RoadType => "",
            Self::EventKind => KIND,
        }
    }
}

/// Prefix that tells the columns of kinds from those of road types.
const KIND: &str = "kind_";

/// Whether a road type may have this name: its columns have to differ from those of event kinds.
pub fn is_road_type_name(name: &str) -> bool {
    !name.starts_with(KIND)
}

/// Amount that is broken down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Amount {
    /// Distance, in m.
    Distance,
    /// Duration with standstill, in s.
    Duration,
    /// Positive work at the hubs of the driven wheels, in J.
    Wheel,
    /// Amount taken of a carrier, in its unit.
    Taken(Carrier),
}

/// The amounts that every cycle has.
const COMMON: [Amount; 3] = [Amount::Distance, Amount::Duration, Amount::Wheel];

/// Most amounts that a cycle has: those of all cycles, and what its carriers gave.
pub const MOST_AMOUNTS: usize = COMMON.len() + MOST_CARRIERS;

impl Amount {
    /// The column of the whole.
    pub fn column(self) -> &'static str {
        match self {
            Self::Distance => "distance_m",
            Self::Duration => "duration_s",
            Self::Wheel => "wheel_energy_j",
            Self::Taken(carrier) => carrier.declaration().amount.name,
        }
    }
}

/// A part of the road.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// By what.
    pub axis: Axis,
    /// Its name there.
    pub name: String,
}

/// The columns of a breakdown: for each part its amounts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BreakdownColumns {
    parts: Vec<Part>,
    amounts: Vec<Amount>,
    names: Vec<String>,
}

impl BreakdownColumns {
    /// Columns of these parts, where trucks store these carriers.
    pub fn new(parts: Vec<Part>, carriers: &[Carrier]) -> Self {
        let taken = carriers.iter().copied().map(Amount::Taken);
        let amounts: Vec<Amount> = COMMON.into_iter().chain(taken).collect();
        let mut names = Vec::with_capacity(parts.len() * amounts.len());
        for Part { axis, name } in &parts {
            let column = |amount: &Amount| format!("{}_{}{name}", amount.column(), axis.prefix());
            names.extend(amounts.iter().map(column));
        }
        Self { parts, amounts, names }
    }

    /// Breakdown columns among the columns of a table; none where a part lacks one of its columns.
    pub fn among<'a>(names: &(impl Iterator<Item = &'a str> + Clone)) -> Option<Arc<Self>> {
        let names_of = |amount: Amount| {
            names.clone().filter_map(move |name| {
                name.strip_prefix(amount.column()).and_then(|rest| rest.strip_prefix('_'))
            })
        };
        let part = |name: &str| match name.strip_prefix(KIND) {
            Some(kind) => Part { axis: Axis::EventKind, name: kind.to_owned() },
            None => Part { axis: Axis::RoadType, name: name.to_owned() },
        };
        let parts: Vec<Part> = names_of(Amount::Distance).map(part).collect();
        let carriers = CARRIERS.iter().map(|declared| declared.carrier);
        let taken = carriers.filter(|carrier| names_of(Amount::Taken(*carrier)).next().is_some());
        let columns = Self::new(parts, &taken.collect::<Vec<_>>());
        let is_there = |column: &String| names.clone().any(|name| name == column);
        let whole = !columns.parts.is_empty() && columns.names.iter().all(is_there);
        whole.then(|| Arc::new(columns))
    }

    /// The parts, road types first.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The amounts of each part.
    pub fn amounts(&self) -> &[Amount] {
        &self.amounts
    }

    /// The carriers of which each part took something.
    pub fn carriers(&self) -> impl Iterator<Item = Carrier> + Clone {
        self.amounts.iter().filter_map(|amount| match amount {
            Amount::Taken(carrier) => Some(*carrier),
            _ => None,
        })
    }

    /// Names of the columns, part by part.
    pub fn names(&self) -> &[String] {
        &self.names
    }
}

/// The breakdown of one cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Breakdown {
    columns: Option<Arc<BreakdownColumns>>,
    /// One for each column; empty where they are not known.
    values: Vec<f64>,
}

impl Breakdown {
    /// Values of these columns; none where they are not known.
    pub fn new(columns: Arc<BreakdownColumns>, values: Option<Vec<f64>>) -> Self {
        Self { columns: Some(columns), values: values.unwrap_or_default() }
    }

    /// The columns, where the study has any.
    pub fn columns(&self) -> Option<&Arc<BreakdownColumns>> {
        self.columns.as_ref()
    }

    /// Names of the columns.
    pub fn names(&self) -> &[String] {
        self.columns.as_ref().map_or(&[], |columns| columns.names())
    }

    /// The value of a column, by its place.
    pub fn value(&self, column: usize) -> Option<f64> {
        self.values.get(column).copied()
    }

    /// The amounts of a part, by its place.
    pub fn of_part(&self, part: usize) -> Option<&[f64]> {
        let amounts = self.columns.as_ref()?.amounts.len();
        self.values.get(amounts * part..amounts * (part + 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> BreakdownColumns {
        let part = |axis, name: &str| Part { axis, name: name.to_owned() };
        let parts = vec![part(Axis::RoadType, "rural"), part(Axis::EventKind, "stop")];
        BreakdownColumns::new(parts, Carrier::LiquidFuel.alone())
    }

    #[test]
    fn columns_are_found_again_by_their_names() {
        let columns = columns();
        assert_eq!(columns.names()[3], "fuel_kg_rural");
        assert_eq!(columns.names()[4], "distance_m_kind_stop");
        let with_others = || ["distance_m", "fuel_kg"].into_iter();
        let names = with_others().chain(columns.names().iter().map(String::as_str));
        assert_eq!(BreakdownColumns::among(&names).as_deref(), Some(&columns));
        assert_eq!(BreakdownColumns::among(&with_others()), None);
        let without =
            columns.names().iter().map(String::as_str).filter(|name| *name != "fuel_kg_rural");
        assert_eq!(BreakdownColumns::among(&without), None);
    }

    #[test]
    fn a_cycle_without_values_has_none_of_them() {
        let breakdown = Breakdown::new(Arc::new(columns()), None);
        assert_eq!(breakdown.names().len(), 2 * 4);
        assert_eq!((breakdown.value(0), breakdown.of_part(1)), (None, None));
    }
}
