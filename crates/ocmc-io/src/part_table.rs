//! Tables of a fleet's routes, road types and kinds of events, as people read them.

use crate::label::label;
use crate::number_text::{grouped, percent};
use ocmc_core::breakdown::Axis;
use ocmc_fleet::parts::FleetPart;
use ocmc_fleet::route_summary::RouteSummary;
use ocmc_fleet::statistic::Statistic;
use ocmc_fleet::summary::Summary;

/// A table of parts: its title, the names of its columns, and a row for each part.
#[derive(Clone, Debug, PartialEq)]
pub struct PartTable {
    /// By what the fleet is broken down.
    pub title: &'static str,
    /// Meaning of its numbers.
    pub caption: &'static str,
    /// Name of the column of names.
    pub first: &'static str,
    /// Names of the columns behind that of the part.
    pub columns: Vec<String>,
    /// Name of the part, and its cells.
    pub rows: Vec<(String, Vec<String>)>,
}

/// The tables of a fleet's parts: routes, road types, kinds of events.
pub fn part_tables(summary: &Summary) -> Vec<PartTable> {
    let axes = Axis::ALL.into_iter().filter_map(|axis| part_table(&summary.parts, axis));
    route_table(&summary.routes).into_iter().chain(axes).collect()
}

/// The table of the routes; none where there are not several.
fn route_table(routes: &[RouteSummary]) -> Option<PartTable> {
    let (unit, factor) = label(routes.first()?.consumption()?.column);
    let number = |value: Option<f64>, factor: f64, digits: usize| {
        value.map_or_else(|| "-".to_owned(), |value| format!("{:.digits$}", factor * value))
    };
    let row = |route: &RouteSummary| {
        let own = route.consumption();
        let mean = |column: &str| route.statistic(column).and_then(|statistic| statistic.mean);
        let quantile = |p: f64| {
            let quantiles = own.map_or(&[][..], |own| &own.quantiles[..]);
            quantiles.iter().find(|quantile| quantile.level == p).and_then(|q| q.value)
        };
        let half = |own: &Statistic| own.ci95.map(|[low, high]| (high - low) / 2.0);
        let cells = vec![
            grouped(route.cycles),
            number(Some(route.distance_m / route.cycles as f64), 1e-3, 1),
            number(own.and_then(|own| own.mean), factor, 2),
            number(own.and_then(half), factor, 2),
            number(quantile(0.05), factor, 2),
            number(quantile(0.95), factor, 2),
            number(mean("mean_speed_mps"), 3.6, 1),
            number(mean("duration_s"), 1.0 / 3600.0, 2),
        ];
        (route.name(), cells)
    };
    let columns = ["trips", "km", unit, "± 95 %", "P5", "P95", "km/h", "h"];
    Some(PartTable {
        title: "By route",
        caption: "Means of the fleet on each route with their 95 % intervals, and quantiles of its \
                  trips.",
        first: "route",
        columns: columns.map(str::to_owned).to_vec(),
        rows: routes.iter().map(row).collect(),
    })
}

fn part_table(parts: &[FleetPart], axis: Axis) -> Option<PartTable> {
    let of_axis = || parts.iter().filter(|part| part.axis == axis && part.distance_m > 0.0);
    let first = of_axis().next()?;
    let share = |part: &FleetPart, value_of: &dyn Fn(&FleetPart) -> f64| {
        let whole: f64 = of_axis().map(value_of).sum();
        if whole == 0.0 { "-".to_owned() } else { percent(value_of(part) / whole) }
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
    Some(PartTable {
        title,
        caption: "Shares of the whole, standstill and idling included, and the consumption of each \
                  part over its own way.",
        first: "part",
        columns,
        rows: of_axis().map(row).collect(),
    })
}
