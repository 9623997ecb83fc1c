//! What quantities are called for people, and the factors to the units in which people read them.

/// A quantity of the summary: its name with the unit for people, and the factor to that unit.
pub fn label(column: &str) -> (&str, f64) {
    match column {
        "consumption_l_per_100km" => ("L/100 km", 1.0),
        "consumption_l_per_100tkm" => ("L/100 tkm", 1.0),
        "consumption_kwh_per_km" => ("kWh/km", 1.0),
        "wheel_kwh_per_km" => ("wheel kWh/km", 1.0),
        "co2_g_per_km" => ("g CO2/km", 1.0),
        "mean_speed_mps" => ("speed, km/h", 3.6),
        "duration_s" => ("duration, h", 1.0 / 3600.0),
        "stops_per_km" => ("stops per km", 1.0),
        other => (other, 1.0),
    }
}

/// A column of the records, likewise; a count or a climb without its distance.
pub fn label_of_record(column: &str) -> (&str, f64) {
    match column {
        "payload_kg" => ("payload, t", 1e-3),
        "climb_m" => ("climb, m", 1.0),
        "mean_limit_mps" => ("mean of the signs, km/h", 3.6),
        "urban_share" => ("urban share, %", 100.0),
        "motorway_share" => ("motorway share, %", 100.0),
        "n_curves" => ("curves", 1.0),
        "n_stops" => ("stops", 1.0),
        "n_gear_shifts" => ("gear shifts", 1.0),
        "air_temperature_k" => ("air temperature, K", 1.0),
        "head_wind_mps" => ("head wind, m/s", 1.0),
        "drag_area_m2" => ("drag area, m²", 1.0),
        "driver_curve_speed_mps" => ("driver: curve speed, km/h", 3.6),
        "driver_deceleration_mps2" => ("driver: deceleration, m/s²", 1.0),
        "driver_acceleration_mps2" => ("driver: acceleration, m/s²", 1.0),
        "driver_compliance" => ("driver: factor on limits", 1.0),
        "driver_kp" => ("driver: pedal gain, s/m", 1.0),
        other => label(other),
    }
}
