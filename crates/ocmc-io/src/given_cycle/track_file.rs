//! The tracks that `ocmc cycle` writes, read back: CSV (`track,rule,position_m,value`) or JSON.

use super::in_file;
use crate::intake::FileAccount;
use crate::intake::table::error::Fault;
use crate::intake::table::{Quantity, Table, TableError};
use ocmc_core::operating_cycle::drawn_part::Draw;
use ocmc_core::operating_cycle::given::{GivenCycle, GivenCycleError};
use ocmc_core::operating_cycle::tracks::{Track, Values, names, rule_of};
use serde::Deserialize;
use std::path::Path;

/// An operating cycle in JSON. What it says beside this (cycle id, seed, free-flow time) is not
/// needed.
#[derive(Deserialize)]
struct CycleJson {
    length_m: Option<f64>,
    departure_s_of_day: Option<f64>,
    departure_day_of_year: Option<f64>,
    heading_rad: Option<f64>,
    tracks: Vec<TrackJson>,
}

#[derive(Deserialize)]
struct TrackJson {
    name: String,
    position_m: Vec<f64>,
    value: Vec<CellJson>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum CellJson {
    Number(f64),
    Name(String),
}

/// Departures that a study allows: its keys, in s of the day and in days of the year.
const DEPARTURE_S: &str = "departure_s_of_day";
const DEPARTURE_DAY: &str = "departure_day_of_year";
const DEPARTURES_S: [f64; 2] = [-86_400.0, 172_800.0];
const DAYS: [f64; 2] = [0.0, 366.0];
/// One turn, in either direction; a little more for what is rounded.
const HEADINGS_RAD: [f64; 2] = [-6.3, 6.3];

/// Reads the JSON form.
pub(super) fn read_json(path: &Path, text: &str, draw: &[Draw]) -> Result<GivenCycle, TableError> {
    let json: CycleJson =
        serde_json::from_str(text).map_err(|error| TableError::of(path, Fault::Json(error)))?;
    let mut tracks = Vec::with_capacity(json.tracks.len());
    for track in json.tracks {
        let name = known(path, &track.name)?;
        let (positions, values) = (track.position_m.len(), track.value.len());
        if positions != values {
            let track = track.name;
            return Err(in_file(path)(GivenCycleError::Lengths { track, positions, values }));
        }
        let cells = track.value.into_iter().map(|cell| match cell {
            CellJson::Number(number) => Ok(number),
            CellJson::Name(name) => Err(name),
        });
        tracks.push(track_of(name, track.position_m.into_iter().zip(cells)));
    }
    let mut cycle = cycle_of(&tracks, json.length_m, draw).map_err(in_file(path))?;
    let (second, day) = (json.departure_s_of_day, json.departure_day_of_year);
    for (key, value, [from, to], allowed) in [
        ("heading_rad", json.heading_rad, HEADINGS_RAD, "an angle from -2 π to 2 π"),
        (DEPARTURE_S, second, DEPARTURES_S, "-86400 to 172800 s, with a departure_day_of_year"),
        (DEPARTURE_DAY, day, DAYS, "0 to 366, with a departure_s_of_day"),
    ] {
        let alone = key != "heading_rad" && second.is_some() != day.is_some();
        if let Some(value) = value.filter(|value| alone || !(*value >= from && *value <= to)) {
            return Err(TableError::of(path, Fault::Value { key, value, allowed }));
        }
    }
    cycle.heading_rad = json.heading_rad;
    cycle.departure = second.zip(day);
    Ok(cycle)
}

/// Reads the form of a table.
pub(super) fn read_table(
    table: Table,
    draw: &[Draw],
) -> Result<(GivenCycle, FileAccount), TableError> {
    table.refuse_others()?;
    let file = table.path().to_owned();
    table.need(&[Quantity::Track, Quantity::Position, Quantity::Value])?;
    let mut rows: Vec<(String, f64, String)> = Vec::new();
    let account = table.for_each(|row| {
        let [track, value] = [Quantity::Track, Quantity::Value].map(|q| row.text(q).to_owned());
        rows.push((track, row.number(Quantity::Position)?, value));
        Ok(())
    })?;
    let mut tracks = Vec::new();
    for name in names() {
        let cells =
            rows.iter().filter(|(track, ..)| track == name).map(|(_, position_m, value)| {
                (*position_m, value.parse::<f64>().map_err(|_| value.clone()))
            });
        tracks.push(track_of(name, cells));
    }
    for (track, ..) in &rows {
        known(&file, track)?;
    }
    let cycle = cycle_of(&tracks, None, draw).map_err(in_file(&file))?;
    Ok((cycle, account))
}

/// The cycle of the tracks; limits may be lacking where they are drawn.
fn cycle_of(
    tracks: &[Track],
    length_m: Option<f64>,
    draw: &[Draw],
) -> Result<GivenCycle, GivenCycleError> {
    if draw.contains(&Draw::Limits) {
        GivenCycle::from_partial_tracks(tracks, length_m)
    } else {
        GivenCycle::from_tracks(tracks, length_m)
    }
}

/// A track of numbers where every cell is one, otherwise of words.
fn track_of(name: &'static str, cells: impl Iterator<Item = (f64, Result<f64, String>)>) -> Track {
    let (position_m, cells): (Vec<f64>, Vec<Result<f64, String>>) = cells.unzip();
    let numbers: Option<Vec<f64>> = cells.iter().map(|cell| cell.as_ref().ok().copied()).collect();
    let value = if let Some(numbers) = numbers {
        Values::Numbers(numbers)
    } else {
        let word = |cell: Result<f64, String>| cell.map_or_else(|word| word, |n| n.to_string());
        Values::Names(cells.into_iter().map(word).collect())
    };
    Track { name, rule: rule_of(name), position_m, value }
}

fn known(path: &Path, name: &str) -> Result<&'static str, TableError> {
    names().into_iter().find(|known| *known == name).ok_or_else(|| {
        let (name, allowed) = (name.to_owned(), names().join(", "));
        TableError::of(path, Fault::Track { name, allowed })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(head: &str, tracks: &str) -> Result<GivenCycle, TableError> {
        let text = format!(r#"{{"length_m": 1000.0, {head}"tracks": [{tracks}]}}"#);
        read_json(Path::new("a.json"), &text, &[])
    }

    #[test]
    fn what_no_cycle_has_is_refused() {
        let limit = r#"{"name": "speed_limit_mps", "position_m": [0.0], "value": [20.0]}"#;
        let departure =
            r#""departure_s_of_day": 3600.0, "departure_day_of_year": 12.0, "heading_rad": 1.0, "#;
        let cycle = parse(departure, limit).unwrap();
        assert_eq!((cycle.departure, cycle.heading_rad), (Some((3600.0, 12.0)), Some(1.0)));
        let short =
            r#"{"name": "speed_limit_mps", "position_m": [0.0, 50.0, 60.0], "value": [20.0]}"#;
        for (head, tracks, words) in [
            ("", short, "3 positions and 1 values"),
            ("", &format!("{limit}, {limit}"), "two tracks `speed_limit_mps`"),
            (r#""heading_rad": 1e300, "#, limit, "`heading_rad` is 1"),
            (r#""departure_s_of_day": 1e9, "departure_day_of_year": 1, "#, limit, "172800"),
            (r#""departure_s_of_day": 1, "departure_day_of_year": -3, "#, limit, "0 to 366"),
            (r#""departure_s_of_day": 1, "#, limit, "with a departure_day_of_year"),
        ] {
            let fault = parse(head, tracks).unwrap_err().to_string();
            assert!(fault.contains("`a.json`") && fault.contains(words), "{fault}");
        }
    }
}
