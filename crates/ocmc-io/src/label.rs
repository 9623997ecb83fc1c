//! What quantities are called for people, and the factors to the units in which people read them.

/// A quantity of the summary: its name with the unit for people, and the factor to that unit.
pub fn label(column: &str) -> (&str, f64) {
    match column {
        "consumption_l_per_100km" => ("L/100 km", 1.0),
        "consumption_l_per_100tkm" => ("L/100 tkm", 1.0),
        "consumption_kwh_per_km" => ("kWh/km", 1.0),
        "whole_trip_kwh_per_km" => ("whole kWh/km", 1.0),
        "wheel_kwh_per_km" => ("wheel kWh/km", 1.0),
        "co2_g_per_km" => ("g CO2/km", 1.0),
        "mean_speed_mps" => ("speed, km/h", 3.6),
        "duration_s" => ("duration, h", 1.0 / 3600.0),
        "stops_per_km" => ("stops per km", 1.0),
        other => (other, 1.0),
    }
}
