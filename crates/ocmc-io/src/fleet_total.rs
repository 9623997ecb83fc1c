//! Totals of a fleet of trucks, named and in units for people.

use ocmc_core::energy::carrier::CARRIERS;
use ocmc_fleet::truck_year::{Total, TruckSummary};

/// A total of a fleet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FleetTotal<'a> {
    /// Name of it.
    pub name: &'static str,
    /// Unit for people.
    pub unit: &'a str,
    /// Factor to that unit from the total's own.
    pub factor: f64,
    /// The total itself.
    pub total: Total,
}

impl FleetTotal<'_> {
    /// Whether it is used, emitted or paid, not how far or how long trucks drive.
    pub fn is_answer(&self) -> bool {
        !["distance", "time"].contains(&self.name)
    }
}

/// Place of a total among all, by its name.
pub fn place(name: &str) -> usize {
    let known = CARRIERS.iter().map(|declared| declared.name).chain(BEHIND);
    known.take_while(|known| *known != name).count()
}

/// Names of the totals behind those of the carriers.
const BEHIND: [&str; 5] = ["CO2", "WTW CO2e", "cost", "distance", "time"];

/// Totals that a fleet has: what it uses, then what it emits and costs, then how far it drives.
pub fn fleet_totals(trucks: &TruckSummary) -> Vec<FleetTotal<'_>> {
    let totals = &trucks.totals;
    let used = CARRIERS.iter().zip(totals.sold).map(|(declared, total)| {
        let (unit, factor) = declared.total;
        (declared.name, unit, factor, total)
    });
    let currency = trucks.currency.as_deref().unwrap_or_default();
    let behind = [
        ("t", 1e-3, totals.co2_kg),
        ("t", 1e-3, totals.well_to_wheel_kg),
        (currency, 1.0, totals.cost),
        ("km", 1e-3, totals.distance_m),
        ("h", 1.0 / 3600.0, totals.duration_s),
    ];
    let behind = BEHIND.into_iter().zip(behind);
    let behind = behind.map(|(name, (unit, factor, total))| (name, unit, factor, total));
    used.chain(behind)
        .filter_map(|(name, unit, factor, total)| {
            Some(FleetTotal { name, unit, factor, total: total? })
        })
        .collect()
}
