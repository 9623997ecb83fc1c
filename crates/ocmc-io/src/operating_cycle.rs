//! A realised operating cycle as CSV tracks or JSON.

use ocmc_core::operating_cycle::OperatingCycle;
use ocmc_core::operating_cycle::given::{GivenCycle, GivenCycleError};
use ocmc_core::operating_cycle::tracks::{Track, Values};
use ocmc_core::study::Study;
use serde_json::{Value, json};
use std::io::{self, Write};

/// All tracks of a cycle of a study.
pub fn tracks(study: &Study, cycle: &OperatingCycle) -> Vec<Track> {
    cycle.tracks(study.road_types(), study.operating_cycle().road().types())
}

/// The cycle as a given one, as if it had been read from what [`to_json`] gives.
///
/// # Errors
/// Where its tracks are no road.
pub fn given(cycle: &OperatingCycle, tracks: &[Track]) -> Result<GivenCycle, GivenCycleError> {
    let mission = &cycle.mission;
    Ok(GivenCycle {
        heading_rad: Some(cycle.road.heading_rad),
        departure: Some((mission.departure_s, mission.day_of_year)),
        ..GivenCycle::from_tracks(tracks, Some(cycle.road.length_m))?
    })
}

/// Writes the tracks one below the other: `track,rule,position_m,value`.
pub fn write_csv(out: &mut impl Write, tracks: &[Track]) -> io::Result<()> {
    writeln!(out, "track,rule,position_m,value")?;
    for track in tracks {
        let rule = json!(track.rule);
        let rule = rule.as_str().unwrap_or_default();
        for (k, position_m) in track.position_m.iter().enumerate() {
            write!(out, "{},{rule},{position_m:?},", track.name)?;
            match &track.value {
                Values::Numbers(values) => writeln!(out, "{:?}", values[k])?,
                Values::Names(names) => writeln!(out, "{}", names[k])?,
            }
        }
    }
    Ok(())
}

/// The cycle as a JSON object: its mission, and a list of tracks.
pub fn to_json(cycle_id: u64, seed: u64, cycle: &OperatingCycle, tracks: &[Track]) -> Value {
    json!({
        "cycle_id": cycle_id,
        "seed": seed,
        "length_m": cycle.road.length_m,
        "departure_s_of_day": cycle.mission.departure_s,
        "departure_day_of_year": cycle.mission.day_of_year,
        "payload_kg": cycle.mission.payload_kg,
        "heading_rad": cycle.road.heading_rad,
        "free_flow_s": cycle.free_flow_s,
        "tracks": tracks,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{given_cycle, study};

    #[test]
    fn a_given_cycle_is_what_its_file_gives() {
        let study = study::load("field-truck", &["mission.length_m=3000"]).expect("built in").study;
        let directory = tempfile::tempdir().expect("a directory");
        for cycle_id in 0..3 {
            let cycle = study.sample(1, cycle_id).cycle;
            let tracks = tracks(&study, &cycle);
            let path = directory.path().join("cycle.json");
            let json = to_json(cycle_id, 1, &cycle, &tracks);
            std::fs::write(&path, json.to_string()).expect("space");
            let read = given_cycle::read(&path, &[]).expect("an operating cycle");
            assert_eq!(given(&cycle, &tracks).expect("a road"), read);
        }
    }
}
