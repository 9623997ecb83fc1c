//! A realised operating cycle as CSV tracks or JSON.

use crate::intake::table::spreadsheet;
use crate::study::LoadedStudy;
use ocmc_core::operating_cycle::given::{GivenCycle, GivenCycleError};
use ocmc_core::operating_cycle::tracks::{Track, Values};
use serde::Serialize;
use std::io::{self, Write};

/// One operating cycle of a study: its mission, and its tracks along the road.
#[derive(Clone, Debug, Serialize)]
pub struct RealisedCycle {
    /// Id of the cycle.
    pub cycle_id: u64,
    /// Master seed.
    pub seed: u64,
    /// Length, in m.
    pub length_m: f64,
    /// Time of departure, in s from midnight.
    pub departure_s_of_day: f64,
    /// Day of departure, from the beginning of the year.
    pub departure_day_of_year: f64,
    /// Payload, in kg.
    pub payload_kg: f64,
    /// Heading of the road at its start, in rad.
    pub heading_rad: f64,
    /// Time along the road at the speed of free traffic, in s.
    pub free_flow_s: f64,
    /// The tracks.
    pub tracks: Vec<Track>,
}

impl RealisedCycle {
    /// The cycle that a study draws.
    pub fn new(study: &LoadedStudy, seed: u64, cycle_id: u64) -> Self {
        let study = &study.study;
        let cycle = study.sample(seed, cycle_id).cycle;
        let tracks = cycle.tracks(study.road_types(), study.operating_cycle().road().types());
        Self {
            cycle_id,
            seed,
            length_m: cycle.road.length_m,
            departure_s_of_day: cycle.mission.departure_s,
            departure_day_of_year: cycle.mission.day_of_year,
            payload_kg: cycle.mission.payload_kg,
            heading_rad: cycle.road.heading_rad,
            free_flow_s: cycle.free_flow_s,
            tracks,
        }
    }

    /// The cycle as a given one, as if it had been read from its JSON.
    ///
    /// # Errors
    /// Where its tracks are no road.
    pub fn given(&self) -> Result<GivenCycle, GivenCycleError> {
        Ok(GivenCycle {
            heading_rad: Some(self.heading_rad),
            departure: Some((self.departure_s_of_day, self.departure_day_of_year)),
            ..GivenCycle::from_tracks(&self.tracks, Some(self.length_m))?
        })
    }

    /// Writes the tracks one below the other: `track,rule,position_m,value`.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_csv(&self, out: &mut impl Write) -> io::Result<()> {
        write_tracks(&self.tracks, out)
    }
}

/// Writes tracks one below the other: `track,rule,position_m,value`.
///
/// # Errors
/// Those of writing.
pub fn write_tracks(tracks: &[Track], out: &mut impl Write) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(out);
    writer.write_record(["track", "rule", "position_m", "value"])?;
    for track in tracks {
        for (k, position_m) in track.position_m.iter().enumerate() {
            let value = match &track.value {
                Values::Numbers(values) => format!("{:?}", values[k]),
                Values::Names(names) => spreadsheet::written(&names[k]).into_owned(),
            };
            let (rule, position_m) = (track.rule.name(), format!("{position_m:?}"));
            writer.write_record([track.name, rule, &position_m, &value])?;
        }
    }
    writer.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{given_cycle, study};

    #[test]
    fn a_given_cycle_is_what_its_file_gives() {
        let study = study::load("field-truck", &["mission.length_m=3000"]).expect("built in");
        let directory = tempfile::tempdir().expect("a directory");
        for cycle_id in 0..3 {
            let cycle = RealisedCycle::new(&study, 1, cycle_id);
            let path = directory.path().join("cycle.json");
            let json = serde_json::to_string(&cycle).expect("numbers and words");
            std::fs::write(&path, json).expect("space");
            let read = given_cycle::read(&path, &[]).expect("an operating cycle");
            assert_eq!(cycle.given().expect("a road"), read);
        }
    }
}
