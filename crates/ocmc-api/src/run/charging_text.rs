//! The part of a run's answer that is about charging.

use ocmc_fleet::charging::ChargingSummary;
use ocmc_fleet::load::{LoadCurves, LoadOfPlace};
use ocmc_fleet::summary::Summary;
use ocmc_io::label::{charger_name, clock};
use ocmc_io::number_text::{count_of, grouped, short};
use std::fmt::Write;

/// How often trips were charged on the way, for how long, and where the energy came from.
pub(super) fn charging(summary: &Summary) -> String {
    let Some(charging) = &summary.charging else { return String::new() };
    let ChargingSummary { trips, arrived_with_stops, depleted, .. } = charging;
    let percent = |count: u64| format!("{:.1} %", 100.0 * count as f64 / *trips as f64);
    let mut text = format!("\nCharging stops on the way, of {}\n", count_of(*trips, "trip"));
    let last = arrived_with_stops.len() - 1;
    for (stops, count) in arrived_with_stops.iter().enumerate().filter(|(_, count)| **count > 0) {
        let name = match stops {
            0 => "arrives without".to_owned(),
            k if k == last => format!("with {k} or more"),
            k => format!("with {k}"),
        };
        let _ = writeln!(text, "  {name:<18} {:>8}  {:>7}", grouped(*count), percent(*count));
    }
    if *depleted > 0 {
        let (count, share) = (grouped(*depleted), percent(*depleted));
        let _ = writeln!(text, "  {:<18} {count:>8}  {share:>7}", "does not arrive");
    }
    let mean_min = |total_s: f64| short(total_s / 60.0 / charging.arrived().max(1) as f64);
    if charging.arrived_with_stops[1..].iter().any(|count| *count > 0) {
        let _ = writeln!(
            text,
            "Trips that arrive charge for {} min on the way in the mean and wait {} min.",
            mean_min(charging.charging_s),
            mean_min(charging.charging_wait_s)
        );
        if let Some(lowest) = charging.lowest_charge {
            let percent = short(100.0 * lowest);
            let _ = writeln!(text, "The lowest charge of one that arrives is {percent} %.");
        }
    }
    let depot = charging.grid_energy_depot_j.map(|j| ("depots", j));
    let way = [
        ("public chargers", charging.grid_energy_public_j),
        ("stops", charging.grid_energy_stop_j),
    ];
    let metered = depot.into_iter().chain(way).filter(|(_, energy_j)| *energy_j > 0.0);
    let parts: Vec<String> = metered
        .map(|(place, energy_j)| format!("{place} {} kWh", short(energy_j / 3.6e6 / *trips as f64)))
        .collect();
    if !parts.is_empty() {
        let _ = writeln!(text, "Meters count per trip: {}.", parts.join(", "));
    }
    text + &loads(summary)
}

/// The highest power that the chargers of each kind draw together.
fn loads(summary: &Summary) -> String {
    let Some(LoadCurves { places, .. }) = &summary.loads else { return String::new() };
    let of_fleet = summary.trucks.is_some();
    let days = places.first().map_or(0, |place| place.days);
    let whose = if of_fleet { "The fleet's chargers" } else { "All trips, put into one year," };
    let mut text =
        format!("{whose} draw together, mean of a quarter of an hour, over {days} days\n");
    for place in places {
        let LoadOfPlace { p95_power_w, p95_quarter_hour, highest_power_w, .. } = *place;
        let _ = writeln!(
            text,
            "  {:<18} below {} kW on 19 of 20 days ({}), {} kW at most",
            charger_name(place.place),
            short(p95_power_w / 1000.0),
            clock(p95_quarter_hour),
            short(highest_power_w / 1000.0)
        );
    }
    text
}
