//! What a fleet took on each road type and near each kind of event, as people read it.

use crate::label::label;
use crate::number_text::percent;
use ocmc_core::breakdown::{Amount, Axis};
use ocmc_fleet::parts::FleetPart;

/// A table of parts: its title, the names of its columns, and a row for each part.
#[derive(Clone, Debug, PartialEq)]
pub struct PartTable {
    /// By what the fleet is broken down.
    pub title: &'static str,
    /// Names of the columns behind that of the part.
    pub columns: [String; 6],
    /// Name of the part, and its cells.
    pub rows: Vec<(String, [String; 6])>,
}

/// The tables of a fleet's parts, road types first.
pub fn part_tables(parts: &[FleetPart]) -> Vec<PartTable> {
    Axis::ALL.into_iter().filter_map(|axis| part_table(parts, axis)).collect()
}

fn part_table(parts: &[FleetPart], axis: Axis) -> Option<PartTable> {
    let of_axis = || parts.iter().filter(|part| part.axis == axis && part.distance_m > 0.0);
    let first = of_axis().next()?;
    let total = |of: fn(&FleetPart) -> f64| of_axis().map(of).sum::<f64>();
    let totals: [fn(&FleetPart) -> f64; 4] = [
        |part| part.distance_m,
        |part| part.duration_s,
        |part| part.wheel_energy_j,
        |part| part.source_amount,
    ];
    let source = if first.source == Amount::Fuel { "fuel %" } else { "battery %" };
    let (consumption, factor) = label(first.consumption_column());
    let names = ["way %", "time %", "traction %", source, consumption, "km/h"];
    let row = |part: &FleetPart| {
        let shares = totals.map(|of| {
            let whole = total(of);
            if whole == 0.0 { "-".to_owned() } else { percent(of(part) / whole) }
        });
        let consumption = part.consumption.map_or("-".to_owned(), |c| format!("{:.2}", factor * c));
        let speed = if part.duration_s > 0.0 {
            format!("{:.1}", 3.6 * part.distance_m / part.duration_s)
        } else {
            "-".to_owned()
        };
        let [way, time, traction, source] = shares;
        (part.name.clone(), [way, time, traction, source, consumption, speed])
    };
    let title = match axis {
        Axis::RoadType => "By road type",
        Axis::EventKind => "By event kind",
    };
    Some(PartTable { title, columns: names.map(str::to_owned), rows: of_axis().map(row).collect() })
}
