//! Where the energy went: every kind of loss, over all completed cycles.

use super::gathered::Sums;
use super::svg;
use ocmc_core::energy::carrier::CARRIERS;
use ocmc_core::energy::ledger::{Place, Recorded, TERMS};
use ocmc_core::record::{Record, column};
use std::fmt::Write;

/// A kind of loss that is a field of the record, and its part of one.
type Loss = (&'static str, fn(&Record) -> Option<f64>);

/// Losses of the stores' energy, beside those with a column of their own.
const LOSSES: [Loss; 14] = [
    ("engine", |r| r.engine_loss_j),
    ("battery", |r| r.battery_loss_j),
    ("motor and inverter", |r| r.motor_loss_j),
    ("rolling resistance", |r| Some(r.rolling_energy_j)),
    ("air drag", |r| Some(r.drag_energy_j)),
    ("service brakes", |r| Some(r.service_brake_energy_j)),
    ("engine brake", |r| r.engine_brake_energy_j),
    ("gearbox and axle", |r| Some(r.transmission_loss_j)),
    ("auxiliaries", |r| Some(r.auxiliary_energy_j)),
    ("clutch", |r| r.clutch_loss_j),
    ("gear shifts", |r| r.shift_loss_j),
    ("climb, net", |r| Some(r.potential_change_j)),
    ("speed at the end", |r| Some(r.kinetic_change_j)),
    // a speed that is followed exactly is kept with work that nothing has done
    ("missing at the wheels", |r| r.missing_energy_j.filter(|j| *j > 0.0).map(|j| -j)),
];

/// Losses of the stores' energy, kind by kind; together they are all of it.
pub(super) fn losses(record: &Record) -> impl Iterator<Item = (&'static str, Option<f64>)> {
    let fields = LOSSES.iter().map(|(name, loss_of)| (*name, loss_of(record)));
    let own = TERMS.iter().filter(|declared| declared.place == Place::Loss);
    let own = own.filter_map(|declared| match declared.recorded {
        Recorded::Column { name, label, .. } => {
            Some((label, column(name).and_then(|column| column.get(record).number())))
        }
        _ => None,
    });
    fields.chain(own)
}

/// Joules of a kilowatt-hour.
const KWH_J: f64 = 3.6e6;

/// Where the energy is from, and the three largest parts that it goes into, as shares of it; none
/// where no energy was used.
pub(super) fn largest_losses(sums: &Sums) -> (&'static str, Vec<(&'static str, f64)>) {
    let (used, store) = used(sums);
    let parts = sums.losses_j.iter().filter_map(|(name, energy)| Some((*name, (*energy)? / used)));
    let mut parts: Vec<_> = parts.filter(|(_, share)| share.is_finite() && *share > 0.0).collect();
    parts.sort_by(|a, b| b.1.total_cmp(&a.1));
    parts.truncate(3);
    (store, parts)
}

/// The energy that was used, and where it is from.
fn used(sums: &Sums) -> (f64, &'static str) {
    let mut carriers = CARRIERS.iter().filter(|declared| sums.stores[declared.carrier as usize]);
    let place = match (carriers.next(), carriers.next()) {
        (Some(only), None) => only.place,
        _ => "from all stores",
    };
    (sums.stored_energy_j.unwrap_or(0.0), place)
}

/// The breakdown as bars; nothing where no energy was used.
pub(super) fn breakdown(sums: &Sums) -> String {
    let (used, store) = used(sums);
    let distance_km = sums.distance_m.unwrap_or(0.0) / 1000.0;
    if !(used > 0.0 && distance_km > 0.0) {
        return String::new();
    }
    let rows: Vec<(String, f64, String)> = sums
        .losses_j
        .iter()
        .filter_map(|(name, energy)| Some((name, (*energy)?)))
        .map(|(name, energy)| {
            let per_km = energy / KWH_J / distance_km;
            // what rounds to nothing has no sign
            let shown = |value: f64, unit: f64| if value.abs() < unit / 2.0 { 0.0 } else { value };
            let share = shown(100.0 * energy / used, 0.1);
            let words = format!("{share:.1} %, {:.3} kWh/km", shown(per_km, 0.001));
            ((*name).to_owned(), energy, words)
        })
        .collect();
    let missing = if sums.is_missing {
        " What was missing at the wheels came from nowhere and counts against the rest."
    } else {
        ""
    };
    let closed: f64 = rows.iter().map(|row| row.1).sum::<f64>() / used;
    let mut text = "<h2>Where the energy went</h2>\n".to_owned();
    let _ = writeln!(
        text,
        "<figure>{}<figcaption>Of the energy {store}, {:.2} kWh/km, over all completed cycles. \
         The rows add up to {:.4} % of it.{missing}</figcaption></figure>",
        svg::bars(&rows, "Energy by kind of loss"),
        used / KWH_J / distance_km,
        100.0 * closed
    );
    text
}
