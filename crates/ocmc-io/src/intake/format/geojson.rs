//! GeoJSON (RFC 7946): lines, alone or as features, and points with properties.
//!
//! Each feature with a line is a drive. The times of a line are a list in its properties:
//! `coordTimes` or `times` (toGeoJSON, MapBox). Other lists of the length of the line are columns
//! of their own, by their names. Points are rows of one table, and their properties its columns.

use super::points::{PLACES, Point, Points};
use super::{Content, Format, contains, text_of};
use crate::intake::Finding;
use crate::intake::table::given::GivenTable;
use crate::number_text::count_of;
use arrow_array::{ArrayRef, Float64Array, StringArray};
use serde::Deserialize;
use serde_json::value::RawValue;
use serde_json::{Map, Value};
use std::path::Path;
use std::sync::Arc;

/// The format.
pub(super) const GEOJSON: Format = Format { name: "GeoJSON", is_track: true, is_one, read };

/// Most bytes: lists of numbers take some times their text in memory.
const MOST_BYTES: usize = 128 << 20;
/// Properties that have the times of a line.
const TIMES: [&str; 3] = ["coordTimes", "times", "timestamps"];
/// Properties that name a drive.
const NAMES: [&str; 5] = ["trip", "trip_id", "drive", "name", "id"];

fn is_one(start: &[u8]) -> bool {
    let types: [&[u8]; 5] = [
        b"\"FeatureCollection\"",
        b"\"Feature\"",
        b"\"LineString\"",
        b"\"MultiLineString\"",
        b"\"GeometryCollection\"",
    ];
    start.trim_ascii_start().starts_with(b"{") && types.iter().any(|kind| contains(start, kind))
}

/// An object of the format: a collection, a feature or a geometry.
#[derive(Deserialize)]
struct Object<'a> {
    #[serde(rename = "type")]
    kind: String,
    #[serde(borrow, default)]
    features: Vec<Object<'a>>,
    #[serde(borrow, default)]
    geometries: Vec<Object<'a>>,
    #[serde(borrow)]
    geometry: Option<Box<Object<'a>>>,
    #[serde(borrow)]
    coordinates: Option<&'a RawValue>,
    properties: Option<Map<String, Value>>,
}

/// Points with properties, a row a point.
#[derive(Default)]
struct Places {
    points: Vec<Point>,
    properties: Vec<Map<String, Value>>,
}

fn read(path: &Path, bytes: &[u8]) -> Result<Content, String> {
    if bytes.len() > MOST_BYTES {
        return Err(format!("has more than {MOST_BYTES} bytes; split it up"));
    }
    let text = text_of(bytes);
    let object: Object =
        serde_json::from_str(&text).map_err(|error| format!("has a fault: {error}"))?;
    let (mut lines, mut places) = (Points::default(), Places::default());
    take(&object, None, &mut lines, &mut places)?;
    if lines.len() == 0 && !places.points.is_empty() {
        return Ok(places.table(path));
    }
    if !places.points.is_empty() {
        lines.left_out.insert("place", places.points.len());
    }
    lines.table(path)
}

/// Takes the lines and points of an object, with the properties of its feature.
fn take(
    object: &Object,
    properties: Option<&Map<String, Value>>,
    lines: &mut Points,
    places: &mut Places,
) -> Result<(), String> {
    let properties = object.properties.as_ref().or(properties);
    let coordinates = || object.coordinates.map_or("[]", RawValue::get);
    let fault = |error: serde_json::Error| format!("has coordinates that are none: {error}");
    match object.kind.as_str() {
        "Point" => {
            let place: Vec<f64> = serde_json::from_str(coordinates()).map_err(fault)?;
            places.points.push(point_of(&place));
            places.properties.push(properties.cloned().unwrap_or_default());
        }
        "LineString" => {
            let line: Vec<Vec<f64>> = serde_json::from_str(coordinates()).map_err(fault)?;
            lines.begin(&name_of(properties));
            add(&line, properties, lines)?;
        }
        "MultiLineString" => {
            let parts: Vec<Vec<Vec<f64>>> = serde_json::from_str(coordinates()).map_err(fault)?;
            lines.begin(&name_of(properties));
            // times of several parts stand in as many lists
            for (part, line) in parts.iter().enumerate() {
                let own = properties.map(|properties| part_of(properties, part));
                add(line, own.as_ref(), lines)?;
            }
        }
        "Polygon" | "MultiPolygon" | "MultiPoint" => {
            *lines.left_out.entry("area or group of places").or_default() += 1;
        }
        _ => {}
    }
    let parts = object.geometry.iter().map(Box::as_ref);
    for part in parts.chain(&object.features).chain(&object.geometries) {
        take(part, properties, lines, places)?;
    }
    Ok(())
}

/// Properties with the lists of one part of a line.
fn part_of(properties: &Map<String, Value>, part: usize) -> Map<String, Value> {
    let own = properties.iter().map(|(name, value)| {
        let list =
            value.as_array().and_then(|lists| lists.get(part)).filter(|list| list.is_array());
        (name.clone(), list.unwrap_or(value).clone())
    });
    own.collect()
}

fn name_of(properties: Option<&Map<String, Value>>) -> String {
    let value = properties.and_then(|all| NAMES.iter().find_map(|name| all.get(*name)));
    value.map_or_else(String::new, word)
}

/// A property as a word.
fn word(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Null => String::new(),
        other => other.to_string(),
    }
}

fn point_of(place: &[f64]) -> Point {
    let at = |k: usize| place.get(k).copied().unwrap_or(f64::NAN);
    Point { longitude_deg: at(0), latitude_deg: at(1), altitude_m: at(2), ..Point::default() }
}

/// Adds a line, with the lists of its properties.
fn add(
    line: &[Vec<f64>],
    properties: Option<&Map<String, Value>>,
    lines: &mut Points,
) -> Result<(), String> {
    let list = |name: &str| {
        let all = properties?;
        let nested = all.get("coordinateProperties").and_then(Value::as_object);
        let list = all.get(name).or_else(|| nested?.get(name))?.as_array()?;
        (list.len() == line.len()).then_some(list)
    };
    let times = TIMES.iter().find_map(|name| list(name));
    let numbers = |name: &str, k: usize| list(name).and_then(|list| list[k].as_f64());
    for (k, place) in line.iter().enumerate() {
        let mut point = point_of(place);
        point.time = times.map(|times| time_of(&times[k]));
        point.speed_mps = numbers("speed_mps", k).unwrap_or_else(|| {
            numbers("speed_kmh", k).map_or(f64::NAN, |speed_kmh| speed_kmh / 3.6)
        });
        point.course_deg = numbers("course_deg", k).unwrap_or(f64::NAN);
        lines.add(point)?;
    }
    Ok(())
}

/// A time as a stamp: a text, or a number of milliseconds or seconds since 1970.
fn time_of(value: &Value) -> String {
    let Some(number) = value.as_f64() else { return word(value) };
    let milliseconds = if number.abs() > 1e11 { number } else { 1000.0 * number };
    let stamp = jiff::Timestamp::from_millisecond(milliseconds as i64);
    stamp.map_or_else(|_| word(value), |stamp| stamp.to_string())
}

/// A property of points as a column: of numbers where all are, otherwise of words.
fn column_of(values: &[Option<&Value>]) -> ArrayRef {
    let is_number = |value: &&Value| value.is_number() || value.is_null();
    if values.iter().flatten().all(is_number) {
        let numbers = values.iter().map(|value| value.and_then(Value::as_f64));
        return Arc::new(numbers.collect::<Float64Array>());
    }
    let words = values.iter().map(|value| value.map(word));
    Arc::new(words.collect::<StringArray>())
}

impl Places {
    /// A table of points, a row a point: their properties by their names.
    fn table(self, path: &Path) -> Content {
        let mut names: Vec<String> = Vec::new();
        for own in &self.properties {
            names
                .extend(own.keys().filter(|key| !names.contains(key)).cloned().collect::<Vec<_>>());
            if names.len() > 200 {
                names.truncate(200);
                break;
            }
        }
        let values_of =
            |name: &str| self.properties.iter().map(move |own| own.get(name)).collect::<Vec<_>>();
        let mut columns: Vec<ArrayRef> =
            names.iter().map(|name| column_of(&values_of(name))).collect();
        for (name, coordinate) in PLACES {
            let is_known = self.points.iter().any(|point| !coordinate(point).is_nan());
            if is_known && !names.iter().any(|known| known == name) {
                names.push(name.to_owned());
                columns.push(Arc::new(Float64Array::from_iter_values(
                    self.points.iter().map(coordinate),
                )));
            }
        }
        let text = format!("{}, a row each", count_of(self.points.len() as u64, "place"));
        let findings = vec![Finding::noted("track", [self.points.len() as f64, 0.0], text, "")];
        Content::Columns(
            GivenTable::export(&path.to_string_lossy(), names, vec![columns]),
            findings,
        )
    }
}
