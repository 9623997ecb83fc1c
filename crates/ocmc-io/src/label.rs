//! Labels of quantities for people, the factors to the units in which people read them, and what
//! has to be said of those that look wrong and are not.

use crate::number_text::{count_of, grouped, percent, rounded, rounded_share};
use ocmc_core::charging::ChargingPlace;
use ocmc_core::energy::carrier::{ALL_STORES, CARRIERS};
use ocmc_fleet::summary::{OUTSIDE_MAP_SHARE, Summary};
use std::fmt::Write;

/// A quantity of the summary: its name with the unit for people, and the factor to that unit.
pub fn label(column: &str) -> (&str, f64) {
    for declared in CARRIERS {
        let columns = [declared.consumption.name, declared.per_tonne.name];
        if let Some(place) = columns.iter().position(|name| *name == column) {
            return (declared.labels[place], 1.0);
        }
    }
    match column {
        name if name == ALL_STORES.name => ("all kWh/km", 1.0),
        "whole_trip_kwh_per_km" => ("whole kWh/km", 1.0),
        "wheel_kwh_per_km" => ("traction kWh/km", 1.0),
        "co2_g_per_km" => ("g CO2/km", 1.0),
        "grid_co2_g_per_km" => ("grid g CO2e/km", 1.0),
        "well_to_wheel_g_per_km" => ("WTW g CO2e/km", 1.0),
        "well_to_wheel_g_per_tkm" => ("WTW g CO2e/tkm", 1.0),
        "mean_speed_mps" => ("speed, km/h", 3.6),
        "duration_s" => ("duration, h", 1.0 / 3600.0),
        "stops_per_km" => ("stops per km", 1.0),
        other => (other, 1.0),
    }
}

/// A quantity of the summary for a table with a column of units: what it is, its unit, and the
/// factor to it.
pub fn measured(column: &str) -> (String, &str, f64) {
    for declared in CARRIERS {
        let names = [(declared.consumption.name, ""), (declared.per_tonne.name, ", by tonne")];
        if let Some(place) = names.iter().position(|(name, _)| *name == column) {
            let words = format!("{} consumption{}", declared.name, names[place].1);
            return (words, declared.labels[place], 1.0);
        }
    }
    let (words, unit) = match column {
        name if name == ALL_STORES.name => ("consumption of all stores", "kWh/km"),
        "whole_trip_kwh_per_km" => ("consumption of whole trips", "kWh/km"),
        "wheel_kwh_per_km" => ("traction", "kWh/km"),
        "co2_g_per_km" => ("carbon dioxide from the fuel", "g CO2/km"),
        "grid_co2_g_per_km" => ("greenhouse gases of the grid", "g CO2e/km"),
        "well_to_wheel_g_per_km" => ("greenhouse gases, well to wheel", "g CO2e/km"),
        "well_to_wheel_g_per_tkm" => ("greenhouse gases, well to wheel, by tonne", "g CO2e/tkm"),
        "mean_speed_mps" => ("speed", "km/h"),
        "duration_s" => ("duration", "h"),
        "stops_per_km" => ("stops", "1/km"),
        other => (other, ""),
    };
    (words.to_owned(), unit, label(column).1)
}

/// Chargers of a kind.
pub fn charger_name(place: ChargingPlace) -> &'static str {
    match place {
        ChargingPlace::Depot => "depots",
        ChargingPlace::Public => "public chargers",
        ChargingPlace::Stop => "chargers at stops",
    }
}

/// The time at which a quarter of an hour of the day begins.
pub fn clock(quarter_hour: u64) -> String {
    format!("{:02}:{:02}", quarter_hour / 4, 15 * (quarter_hour % 4))
}

/// Remarks on what a reader may take for an error in a table over cycles, a sentence each: a mean
/// that lies above its own quantiles, and traction above the energy that it came from.
pub fn remarks(summary: &Summary) -> Vec<String> {
    let n = |column: &str| summary.statistic(column).map_or(0, |statistic| statistic.n);
    let mut remarks = Vec::new();
    let counted = summary.outcomes.counted();
    for column in CARRIERS.iter().map(|declared| declared.per_tonne.name) {
        let carrying = n(column);
        if (1..counted).contains(&carrying) {
            let (unit, empty) = (label(column).0, count_of(counted - carrying, "empty trip"));
            remarks.push(format!("{unit}: the mean alone counts {empty}, and may exceed P75."));
        }
    }
    if CARRIERS.iter().any(|declared| declared.filled.is_none() && n(declared.consumption.name) > 0)
    {
        let traction =
            "traction: what drives the wheels; what braking gives back is not taken off.";
        remarks.push(traction.to_owned());
    }
    if n(ALL_STORES.name) > 0 {
        let stores =
            "each store: what it gave less what it got from another; all kWh/km is their sum.";
        remarks.push(stores.to_owned());
    }
    if summary.payloads_cut > 0 {
        let share = percent(summary.payloads_cut as f64 / summary.cycles as f64);
        remarks.push(format!(
            "payload: {share} % of the loads were cut at `vehicle.gross_mass_limit_kg`."
        ));
    }
    remarks
}

/// Work a cycle, in J, below which nothing is missing at the wheels but digits.
const ROUNDING_J: f64 = 1.0;

/// Where powertrains could not do what a followed speed asked for, and left their maps, in lines;
/// none where that is not worth a word.
pub fn saturation(summary: &Summary) -> Option<String> {
    let saturation = &summary.saturation;
    let (cycles, all_cycles) = (grouped(saturation.cycles), grouped(summary.cycles));
    let limited_s = saturation.limited_s.unwrap_or(0.0);
    let missing_j = saturation.missing_energy_j.unwrap_or(0.0);
    let share = saturation.outside_map_share();
    let outside = (share >= OUTSIDE_MAP_SHARE)
        .then(|| format!("{} % of the energy", rounded_share(100.0 * share)));
    // the balance of a step is exact but for rounding
    if !(limited_s > 0.0 || missing_j > ROUNDING_J * summary.cycles as f64) {
        return outside.map(|part| {
            format!(
                "Beyond the points of the powertrain's maps: {part} was taken there,\n\
                 in {cycles} of {all_cycles} cycles."
            )
        });
    }
    let mut text = format!(
        "Saturated in {cycles} of {all_cycles} cycles: {} s at the powertrain's limit, \
         {} kWh missing at the wheels",
        rounded(limited_s),
        rounded(missing_j / 3.6e6),
    );
    if let Some(part) = outside {
        let _ = write!(text, ",\n{part} beyond the points of its map");
    }
    text.push('.');
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::examples;
    use ocmc_core::energy::Carrier;
    use ocmc_core::record::Outcome;
    use ocmc_fleet::quantity::QUANTITIES;
    use ocmc_fleet::summary::SummaryBuilder;

    fn remarks_of(carrying: usize, electric: bool) -> Vec<String> {
        let mut records = examples::records(5);
        for (k, record) in records.iter_mut().enumerate() {
            record.outcome = Outcome::Completed;
            record.of_carrier_mut(Carrier::LiquidFuel)[2] = (k < carrying).then_some(2.0);
            record.of_carrier_mut(Carrier::Electricity)[1] = electric.then_some(1.2);
        }
        let mut fleet = SummaryBuilder::default();
        fleet.add(&records);
        remarks(&fleet.finish())
    }

    #[test]
    fn every_quantity_has_a_unit_of_its_own() {
        for quantity in QUANTITIES {
            let ((label, factor), (words, unit, own)) =
                (label(quantity.column), measured(quantity.column));
            assert_eq!(factor, own);
            assert!(words != quantity.column && !unit.is_empty(), "{words}");
            // the same unit as where it stands in the label
            assert!(label.ends_with(unit) || unit == "1/km", "{label}: {unit}");
        }
    }

    #[test]
    fn rows_that_look_wrong_have_a_remark() {
        assert_eq!(remarks_of(5, false), Vec::<String>::new());
        let empty = "L/100 tkm: the mean alone counts 1 empty trip, and may exceed P75.";
        assert_eq!(remarks_of(4, false), [empty]);
        let remarks = remarks_of(5, true);
        assert!(remarks.len() == 1 && remarks[0].starts_with("traction: "), "{remarks:?}");
    }
}
