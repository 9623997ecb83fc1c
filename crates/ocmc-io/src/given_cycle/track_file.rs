//! The tracks that `ocmc cycle` writes, read back: CSV (`track,rule,position_m,value`) or JSON.

use super::{GivenCycleFileError, in_file};
use crate::delimited::DelimitedTable;
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::tracks::{NAMES, Rule, Track, Values};
use serde::Deserialize;
use std::path::Path;

/// An operating cycle in JSON. What it says beside this (cycle id, seed, free-flow time) is not needed.
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

/// Reads the JSON form.
pub(super) fn read_json(path: &Path, text: &str) -> Result<GivenCycle, GivenCycleFileError> {
    let json: CycleJson = serde_json::from_str(text)
        .map_err(|source| GivenCycleFileError::Json { path: path.to_owned(), source })?;
    let mut tracks = Vec::with_capacity(json.tracks.len());
    for track in json.tracks {
        let name = known(path, &track.name)?;
        let cells = track.value.into_iter().map(|cell| match cell {
            CellJson::Number(number) => Ok(number),
            CellJson::Name(name) => Err(name),
        });
        tracks.push(track_of(name, track.position_m.into_iter().zip(cells)));
    }
    let mut cycle = GivenCycle::from_tracks(&tracks, json.length_m).map_err(in_file(path))?;
    cycle.heading_rad = json.heading_rad;
    cycle.departure = json.departure_s_of_day.zip(json.departure_day_of_year);
    Ok(cycle)
}

/// Reads the CSV form.
pub(super) fn read_csv(table: &DelimitedTable) -> Result<GivenCycle, GivenCycleFileError> {
    table.refuse_others(&["track", "rule", "position_m", "value"])?;
    let names = table.words(table.column(&["track"])?);
    let positions = table.numbers(table.column(&["position_m"])?)?;
    let values = table.words(table.column(&["value"])?);
    let mut tracks = Vec::new();
    for name in NAMES {
        let rows = (0..names.len()).filter(|k| names[*k] == name);
        let cells = rows.map(|k| {
            let number = values[k].parse::<f64>();
            (positions[k], number.map_err(|_| values[k].clone()))
        });
        tracks.push(track_of(name, cells));
    }
    for name in &names {
        known(table.path(), name)?;
    }
    GivenCycle::from_tracks(&tracks, None).map_err(in_file(table.path()))
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

fn rule_of(name: &str) -> Rule {
    match name {
        "altitude_m" => Rule::Linear,
        "green_light" | "give_way_pass_mps" | "speed_bump_length_m" | "speed_bump_height_m" => {
            Rule::Event
        }
        name if name.ends_with("_s") => Rule::Event,
        _ => Rule::Constant,
    }
}

fn known(path: &Path, name: &str) -> Result<&'static str, GivenCycleFileError> {
    NAMES.into_iter().find(|known| *known == name).ok_or_else(|| GivenCycleFileError::Track {
        path: path.to_owned(),
        name: name.to_owned(),
        allowed: NAMES.join(", "),
    })
}
