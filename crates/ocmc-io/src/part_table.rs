//! What a fleet took on each road type and near each kind of event, as people read it.

use crate::label::label;
use crate::number_text::percent;
use ocmc_core::breakdown::Axis;
use ocmc_fleet::parts::FleetPart;

/// A table of parts: its title, the names of its columns, and a row for each part.
#[derive(Clone, Debug, PartialEq)]
pub struct PartTable {
    /// By what the fleet is broken down.
    pub title: &'static str,
    /// Names of the columns behind that of the part.
    pub columns: Vec<String>,
    /// Name of the part, and its cells.
    pub rows: Vec<(String, Vec<String>)>,
}

/// The tables of a fleet's parts, road types first.
pub fn part_tables(parts: &[FleetPart]) -> Vec<PartTable> {
    Axis::ALL.into_iter().filter_map(|axis| part_table(parts, axis)).collect()
}

fn part_table(parts: &[FleetPart], axis: Axis) -> Option<PartTable> {
    let of_axis = || parts.iter().filter(|part| part.axis == axis && part.distance_m > 0.0);
    let first = of_axis().next()?;
    let share = |part: &FleetPart, of: &dyn Fn(&FleetPart) -> f64| {
        let whole: f64 = of_axis().map(of).sum();
        if whole == 0.0 { "-".to_owned() } else { percent(of(part) / whole) }
    };
    let mut columns = ["way %", "time %", "traction %"].map(str::to_owned).to_vec();
    for taken in &first.taken {
        let declared = taken.carrier.declaration();
        columns.push(format!("{} %", declared.name));
        columns.push(label(declared.consumption.name).0.to_owned());
    }
    columns.push("km/h".to_owned());
    let row = |part: &FleetPart| {
        let mut cells = vec![
            share(part, &|part| part.distance_m),
            share(part, &|part| part.duration_s),
            share(part, &|part| part.wheel_energy_j),
        ];
        for (k, taken) in part.taken.iter().enumerate() {
            let factor = label(taken.carrier.declaration().consumption.name).1;
            let consumption = taken.consumption.map(|value| format!("{:.2}", factor * value));
            cells.push(share(part, &|part| part.taken[k].amount));
            cells.push(consumption.unwrap_or_else(|| "-".to_owned()));
        }
        let speed = if part.duration_s > 0.0 {
            format!("{:.1}", 3.6 * part.distance_m / part.duration_s)
        } else {
            "-".to_owned()
        };
        cells.push(speed);
        (part.name.clone(), cells)
    };
    let title = match axis {
        Axis::RoadType => "By road type",
        Axis::EventKind => "By event kind",
    };
    Some(PartTable { title, columns, rows: of_axis().map(row).collect() })
}
