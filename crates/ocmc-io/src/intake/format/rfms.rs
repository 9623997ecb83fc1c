//! Answers of an rFMS server (Remote Fleet Management System, versions 2 to 4): vehicle positions
//! and vehicle statuses, one answer or a list of them.
//!
//! Units are those of the standard: metres, millilitres, kilograms, km/h, °C. A trigger tells where
//! the engine was switched on and off.

use super::{Content, Format, contains, text_of};
use crate::intake::Finding;
use crate::intake::table::given::GivenTable;
use crate::number_text::count_of;
use arrow_array::{ArrayRef, Float64Array, StringArray};
use serde::Deserialize;
use std::path::Path;
use std::sync::Arc;

/// The format.
pub(super) const RFMS: Format = Format { name: "rFMS", is_track: true, is_one, read };

/// Most bytes: a message takes some times its text in memory.
const MOST_BYTES: usize = 128 << 20;
/// Millilitres in a litre.
const ML_PER_L: f64 = 1000.0;

fn is_one(start: &[u8]) -> bool {
    let keys: [&[u8]; 4] = [
        b"\"vehicleStatusResponse\"",
        b"\"vehiclePositionResponse\"",
        b"\"vehicleStatuses\"",
        b"\"vehiclePositions\"",
    ];
    start.trim_ascii_start().starts_with(b"{") && keys.iter().any(|key| contains(start, key))
        || start.trim_ascii_start().starts_with(b"[") && keys.iter().any(|key| contains(start, key))
}

/// An answer, or what one wraps.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Answer {
    #[serde(rename = "vehicleStatusResponse")]
    with_statuses: Option<Messages>,
    #[serde(rename = "vehiclePositionResponse")]
    with_positions: Option<Messages>,
    #[serde(flatten)]
    bare: Messages,
}

/// Messages of vehicles.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Messages {
    #[serde(rename = "vehicleStatuses", alias = "vehicleStatus")]
    statuses: Vec<Message>,
    #[serde(rename = "vehiclePositions", alias = "vehiclePosition")]
    positions: Vec<Message>,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Message {
    vin: String,
    created_date_time: Option<String>,
    trigger_type: Option<Trigger>,
    hr_total_vehicle_distance: Option<f64>,
    engine_total_fuel_used: Option<f64>,
    gross_combination_vehicle_weight: Option<f64>,
    driver1_id: Option<Driver>,
    gnss_position: Option<Place>,
    wheel_based_speed: Option<f64>,
    tachograph_speed: Option<f64>,
    snapshot_data: Option<Snapshot>,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Snapshot {
    gnss_position: Option<Place>,
    wheel_based_speed: Option<f64>,
    tachograph_speed: Option<f64>,
    gross_combination_vehicle_weight: Option<f64>,
    /// In °C.
    ambient_air_temperature: Option<f64>,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Place {
    latitude: Option<f64>,
    longitude: Option<f64>,
    heading: Option<f64>,
    altitude: Option<f64>,
    speed: Option<f64>,
    position_date_time: Option<String>,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Trigger {
    #[serde(alias = "type")]
    trigger_type: String,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Driver {
    tacho_driver_identification: Option<Card>,
    oem_driver_identification: Option<Card>,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Card {
    driver_identification: Option<String>,
    oem_driver_identification: Option<String>,
}

impl Message {
    fn place(&self) -> Option<&Place> {
        let inside = self.snapshot_data.as_ref().and_then(|data| data.gnss_position.as_ref());
        self.gnss_position.as_ref().or(inside)
    }

    /// Its time: that of the position, where there is one.
    fn time(&self) -> Option<&str> {
        let of_place = self.place().and_then(|place| place.position_date_time.as_deref());
        of_place.or(self.created_date_time.as_deref())
    }

    fn driver(&self) -> Option<&str> {
        let driver = self.driver1_id.as_ref()?;
        let card = driver.tacho_driver_identification.as_ref();
        let card = card.or(driver.oem_driver_identification.as_ref())?;
        card.driver_identification.as_deref().or(card.oem_driver_identification.as_deref())
    }

    fn speed_kmh(&self) -> Option<f64> {
        let inside =
            |value_of: fn(&Snapshot) -> Option<f64>| self.snapshot_data.as_ref().and_then(value_of);
        let wheel = self.wheel_based_speed.or_else(|| inside(|data| data.wheel_based_speed));
        let tachograph = || self.tachograph_speed.or_else(|| inside(|data| data.tachograph_speed));
        wheel.or_else(tachograph).or_else(|| self.place()?.speed)
    }

    fn weight_kg(&self) -> Option<f64> {
        let inside =
            self.snapshot_data.as_ref().and_then(|data| data.gross_combination_vehicle_weight);
        self.gross_combination_vehicle_weight.or(inside)
    }

    /// Whether the engine runs, where a trigger tells it.
    fn ignition(&self) -> Option<&'static str> {
        match self.trigger_type.as_ref()?.trigger_type.as_str() {
            "IGNITION_ON" | "ENGINE_ON" => Some("on"),
            "IGNITION_OFF" | "ENGINE_OFF" => Some("off"),
            _ => None,
        }
    }
}

/// Columns of words and of numbers, with their values in a message.
const WORDS: [Word; 4] = [
    ("truck", |message| Some(message.vin.as_str())),
    ("driver", Message::driver),
    ("time", Message::time),
    ("ignition", |message| message.ignition()),
];
const NUMBERS: [Number; 9] = [
    ("latitude_deg", |message| message.place()?.latitude),
    ("longitude_deg", |message| message.place()?.longitude),
    ("altitude_m", |message| message.place()?.altitude),
    ("course_deg", |message| message.place()?.heading),
    ("speed_kmh", Message::speed_kmh),
    ("position_m", |message| message.hr_total_vehicle_distance),
    ("fuel_used_l", |message| Some(message.engine_total_fuel_used? / ML_PER_L)),
    ("gross_weight_kg", Message::weight_kg),
    ("ambient_temperature_c", |message| message.snapshot_data.as_ref()?.ambient_air_temperature),
];

/// Columns: their names, and their values in a message.
type Word = (&'static str, fn(&Message) -> Option<&str>);
type Number = (&'static str, fn(&Message) -> Option<f64>);

fn read(path: &Path, bytes: &[u8]) -> Result<Content, String> {
    if bytes.len() > MOST_BYTES {
        return Err(format!("has more than {MOST_BYTES} bytes; split it up"));
    }
    let text = text_of(bytes);
    let fault = |error: serde_json::Error| format!("has a fault: {error}");
    let answers: Vec<Answer> = if text.trim_ascii_start().starts_with('[') {
        serde_json::from_str(&text).map_err(fault)?
    } else {
        vec![serde_json::from_str(&text).map_err(fault)?]
    };
    let mut messages: Vec<Message> = Vec::new();
    for answer in answers {
        let wrapped = answer.with_statuses.into_iter().chain(answer.with_positions);
        for part in wrapped.chain([answer.bare]) {
            messages.extend(part.statuses);
            messages.extend(part.positions);
        }
    }
    if messages.is_empty() {
        return Err("has no message of a vehicle".to_owned());
    }
    // servers send messages as they arrive
    messages.sort_by(|a, b| (&a.vin, a.time()).cmp(&(&b.vin, b.time())));
    let vehicles = messages.chunk_by(|a, b| a.vin == b.vin).count();
    let text = format!(
        "{} of {}",
        count_of(messages.len() as u64, "message"),
        count_of(vehicles as u64, "vehicle")
    );
    let findings = vec![Finding::noted("messages", [messages.len() as f64, 0.0], text, "")];
    let (mut names, mut columns): (Vec<String>, Vec<ArrayRef>) = (Vec::new(), Vec::new());
    for (name, word_of) in WORDS {
        if messages.iter().any(|message| word_of(message).is_some()) {
            names.push(name.to_owned());
            let words: StringArray = messages.iter().map(word_of).collect();
            columns.push(Arc::new(words));
        }
    }
    for (name, number_of) in NUMBERS {
        if messages.iter().any(|message| number_of(message).is_some()) {
            names.push(name.to_owned());
            let numbers: Float64Array = messages.iter().map(number_of).collect();
            columns.push(Arc::new(numbers));
        }
    }
    let table = GivenTable::export(&path.to_string_lossy(), names, vec![columns]);
    Ok(Content::Columns(table, findings))
}
