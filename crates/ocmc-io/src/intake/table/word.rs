//! Other words for what a column is called: synonyms, and those of German, French, Swedish and
//! Spanish. A word stands for a name of the vocabulary; the unit behind it stays.

/// Other ends of names, and the suffixes of units that they stand for, where a name with them is
/// none of the vocabulary: `ms` of a speed are m/s.
const ENDS: &[(&str, &[&str])] = &[
    ("s", &["sec", "secs", "second", "seconds"]),
    ("min", &["minutes"]),
    ("h", &["hours"]),
    ("m", &["meter", "meters", "metre", "metres"]),
    ("km", &["kilometer", "kilometers", "kilometre", "kilometres"]),
    ("ft", &["feet"]),
    ("mi", &["mile", "miles"]),
    ("kmh", &["kph", "kmph", "km_h", "km/h"]),
    ("mps", &["ms", "m_s", "m/s"]),
    ("kn", &["kt", "kts", "knots"]),
    ("percent", &["pct", "perc", "prozent", "procent"]),
    ("permille", &["promille"]),
    ("deg", &["degree", "degrees"]),
    ("rad", &["radian", "radians"]),
    ("c", &["degc", "celsius"]),
    ("f", &["degf", "fahrenheit"]),
    ("k", &["kelvin"]),
];

/// Words as they are compared ([`folded`]), behind the name that they stand for.
const WORDS: &[(&str, &[&str])] = &[
    (
        "time",
        &[
            "elapsed_time",
            "test_time",
            "timestamp",
            "zeit",
            "zeitstempel",
            "messzeit",
            "temps",
            "duree",
            "tid",
            "tidpunkt",
            "tiempo",
            "uhrzeit",
            "heure",
            "klockslag",
            "hora",
            "fecha_hora",
            "datetime",
            "date_time",
            "mess_datum",
        ],
    ),
    (
        "speed",
        &[
            "vehicle_speed",
            "target_speed",
            "vehiclespeed",
            "gps_speed",
            "gpsspeed",
            "velocity",
            "geschwindigkeit",
            "fahrgeschwindigkeit",
            "tempo",
            "vitesse",
            "hastighet",
            "fart",
            "velocidad",
        ],
    ),
    (
        "limit",
        &[
            "maxspeed",
            "vmax",
            "v_max",
            "zulaessige_geschwindigkeit",
            "max_speed",
            "speedlimit",
            "posted_speed",
            "tempolimit",
            "hoechstgeschwindigkeit",
            "geschwindigkeitsbegrenzung",
            "limite_de_vitesse",
            "vitesse_limite",
            "limitation_de_vitesse",
            "hastighetsgraens",
            "hastighetsbegraensning",
            "limite_de_velocidad",
            "velocidad_maxima",
        ],
    ),
    (
        "position",
        &[
            "distance",
            "chainage",
            "odometer",
            "mileage",
            "kilometerstand",
            "strecke",
            "weg",
            "wegstrecke",
            "entfernung",
            "straecka",
            "avstaand",
            "avstand",
            "distancia",
            "posicion",
            "dist",
            "kilometer",
            "kilometre",
        ],
    ),
    ("order", &["sequence", "reihenfolge", "stop_no", "stop_nr", "ordre", "ordning", "orden"]),
    ("leg", &["distance_from_previous", "leg_distance", "etappe", "teilstrecke", "etape"]),
    (
        "dwell",
        &[
            "dwell_time",
            "standzeit",
            "aufenthalt",
            "verweilzeit",
            "haltezeit",
            "stop_duration",
            "service_time",
            "uppehaall",
            "estancia",
        ],
    ),
    (
        "loaded",
        &[
            "load_on",
            "beladung",
            "geladen",
            "pickup",
            "abholung",
            "chargement",
            "lastning",
            "carga",
        ],
    ),
    (
        "unloaded",
        &[
            "load_off",
            "entladung",
            "entladen",
            "abgeladen",
            "delivery",
            "delivered",
            "lieferung",
            "dechargement",
            "lossning",
            "descarga",
        ],
    ),
    ("arrival", &["arrival_time", "eta", "ankunft", "arrivee", "ankomst", "llegada"]),
    ("latitude", &["gps_lat", "gps_latitude", "breitengrad", "latitud"]),
    ("longitude", &["lng", "long", "gps_lon", "gps_longitude", "laengengrad", "longitud"]),
    (
        "altitude",
        &[
            "alt",
            "ele",
            "elev",
            "gps_altitude",
            "height",
            "gps_elevation",
            "hoehe",
            "meereshoehe",
            "hoejd",
            "altitud",
            "elevacion",
        ],
    ),
    (
        "grade",
        &[
            "slope",
            "road_grade",
            "roadgrade",
            "roadslope",
            "road_slope",
            "road_gradient",
            "incline",
            "inclination",
            "steigung",
            "neigung",
            "laengsneigung",
            "pente",
            "declivite",
            "inclinaison",
            "lutning",
            "stigning",
            "pendiente",
            "inclinacion",
        ],
    ),
    ("acceleration", &["beschleunigung", "aceleracion"]),
    ("yaw_rate", &["gierrate", "giergeschwindigkeit", "vitesse_de_lacet", "girhastighet"]),
    ("course", &["heading", "bearing", "kurs", "cap", "rumbo"]),
    ("date", &["datum", "fecha"]),
    ("time_s", &["time_utc", "time_unix"]),
    ("time_ns", &["t_unix_ns"]),
    // the names of the German weather service
    ("temperature_c", &["tt_tu"]),
    ("relative_humidity_percent", &["rf_tu"]),
    ("pressure_hpa", &["p0"]),
    ("precipitation_mm_per_h", &["r1"]),
    ("temperature", &["temp", "temperatur", "lufttemperatur", "temperatura", "air_temperature"]),
    ("pressure", &["luftdruck", "pression", "lufttryck", "presion", "air_pressure"]),
    (
        "relative_humidity",
        &["humidity", "relative_feuchte", "luftfeuchte", "luftfuktighet", "humidite", "humedad"],
    ),
    ("precipitation", &["rain", "niederschlag", "precipitations", "nederboerd", "precipitacion"]),
    (
        "wind_speed",
        &[
            "windspeed",
            "windgeschwindigkeit",
            "vitesse_du_vent",
            "vindhastighet",
            "velocidad_del_viento",
        ],
    ),
    ("wind_direction", &["winddirection", "windrichtung", "direction_du_vent", "vindriktning"]),
    ("payload", &["nutzlast", "zuladung", "charge_utile", "nyttolast", "carga_util"]),
    ("driver", &["driver_id", "driver_name", "fahrer", "conducteur", "foerare", "conductor"]),
    (
        "truck",
        &[
            "truck_id",
            "vehicle",
            "vehicle_id",
            "vin",
            "fahrzeug",
            "fahrzeug_id",
            "kennzeichen",
            "license_plate",
            "registration",
            "lkw",
            "camion",
            "lastbil",
            "vehicule",
            "fordon",
            "vehiculo",
        ],
    ),
    ("drive", &["fahrt", "trip", "trip_id", "trip_no", "journey", "trajet", "resa", "viaje"]),
    ("ignition", &["zuendung", "engine_on", "contact", "key_on"]),
    ("fuel_used", &["fuel_counter", "engine_total_fuel_used", "verbrauch_gesamt"]),
    (
        "gross_weight",
        &[
            "gcw",
            "gcvw",
            "gross_combination_vehicle_weight",
            "gesamtgewicht",
            "gesamtmasse",
            "poids_total",
            "totalvikt",
            "peso_total",
        ],
    ),
    ("litres", &["liter", "litre", "litros"]),
    (
        "fuel_amount",
        &[
            "kraftstoff",
            "kraftstoffmenge",
            "tankmenge",
            "diesel",
            "carburant",
            "braensle",
            "combustible",
        ],
    ),
    (
        "driving_time",
        &[
            "drive_time",
            "fahrzeit",
            "lenkzeit",
            "temps_de_conduite",
            "koertid",
            "tiempo_de_conduccion",
        ],
    ),
    ("climb", &["elevation_gain", "hoehenmeter", "anstieg", "denivele"]),
    ("full", &["vollgetankt", "plein"]),
    (
        "ambient_temperature",
        &[
            "ambient_temp",
            "ambient_air_temperature",
            "ambientairtemperature",
            "outside_temp",
            "aussentemperatur",
            "umgebungstemperatur",
            "temperature_exterieure",
            "utetemperatur",
            "yttertemperatur",
            "temperatura_exterior",
        ],
    ),
    ("gear", &["gang", "vaexel", "rapport", "marcha"]),
];

/// A name without accents, in the letters of the vocabulary: `Höhe` is `hoehe`.
fn folded(name: &str) -> String {
    let mut text = String::with_capacity(name.len());
    for letter in name.to_lowercase().chars() {
        text.push_str(match letter {
            'ä' | 'æ' => "ae",
            'ö' | 'ø' => "oe",
            'ü' => "ue",
            'å' => "aa",
            'ß' => "ss",
            'é' | 'è' | 'ê' => "e",
            'á' | 'à' | 'â' => "a",
            'í' | 'î' => "i",
            'ó' | 'ô' => "o",
            'ú' | 'û' => "u",
            'ñ' => "n",
            'ç' => "c",
            '-' | ' ' | '\'' | '.' => "_",
            other => {
                text.push(other);
                continue;
            }
        });
    }
    text
}

/// The name of the vocabulary that a name stands for, with the unit that it has: `hoehe_m` is
/// `altitude_m`, `grade_pct` `grade_percent`.
pub(super) fn known_as(name: &str) -> Option<String> {
    let folded = folded(name);
    let known = known_word(&folded);
    let text = known.as_deref().unwrap_or(&folded);
    let end = |other: &&str| text.strip_suffix(*other).is_some_and(|base| base.ends_with('_'));
    let ends = ENDS.iter().find_map(|(unit, others)| {
        others.iter().find(|other| end(other)).map(|other| (*unit, *other))
    });
    match ends {
        Some((unit, other)) => Some(format!("{}{unit}", &text[..text.len() - other.len()])),
        None => known,
    }
}

/// The same of its first words alone.
fn known_word(name: &str) -> Option<String> {
    let mut best: Option<(&str, &str)> = None;
    for (known, words) in WORDS {
        for word in words.iter().copied() {
            let rest = name.strip_prefix(word);
            let is_whole = rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('_'));
            if is_whole && best.is_none_or(|(_, longest)| word.len() > longest.len()) {
                best = Some((known, word));
            }
        }
    }
    best.map(|(known, word)| format!("{known}{}", &name[word.len()..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_four_languages_are_names_of_the_vocabulary() {
        for (name, known) in [
            ("Zeit", "time"),
            ("Höhe_m", "altitude_m"),
            ("Geschwindigkeit_kmh", "speed_kmh"),
            ("vitesse limite_kmh", "limit_kmh"),
            ("vitesse_kmh", "speed_kmh"),
            ("hastighetsgräns_kmh", "limit_kmh"),
            ("Pendiente_percent", "grade_percent"),
            ("slope_percent", "grade_percent"),
            ("grade_pct", "grade_percent"),
            ("speed_kph", "speed_kmh"),
            ("vehicle_speed_ms", "speed_mps"),
            ("elevation_feet", "elevation_ft"),
            ("roadGrade_degrees", "grade_deg"),
            ("Außentemperatur_celsius", "ambient_temperature_c"),
            ("Liter", "litres"),
            ("Fahrzeit_h", "driving_time_h"),
        ] {
            assert_eq!(known_as(name).as_deref(), Some(known), "{name}");
        }
        for name in ["tidal", "speedy", "time", "weather", "limits"] {
            assert_eq!(known_as(name), None, "{name}");
        }
    }

    #[test]
    fn every_word_stands_for_one_name_that_is_known() {
        let mut words: Vec<&str> =
            WORDS.iter().flat_map(|(_, words)| words.iter().copied()).collect();
        let all = words.len();
        words.sort_unstable();
        words.dedup();
        assert_eq!(words.len(), all);
        for (known, words) in WORDS {
            let mut entries = super::super::quantity::VOCABULARY.iter();
            let is_known = entries.any(|entry| {
                entry.names.contains(known) || entry.quantity.names().any(|name| name == *known)
            });
            assert!(is_known, "{known}");
            assert!(words.iter().all(|word| folded(word) == *word), "{known}");
        }
    }
}
