//! Given operating cycles from the logs of drives.

use crate::answer::Answer;
use crate::error::Error;
use crate::source::{Mapping, Source};
use crate::text::table;
use crate::watch::{Progress, Watch};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::tracks::Track;
use ocmc_estimation::log::road::RoadOptions;
use ocmc_io::given_cycle::{Account, account};
use ocmc_io::intake::{FileAccount, unlike_a_road};
use ocmc_io::log::curves::Steering;
use ocmc_io::log::driven::{MeasuredDrive, MeasuredDrives};
use ocmc_io::log::roads::NEEDS;
use ocmc_io::number_text::rounded;
use ocmc_io::operating_cycle::write_tracks;
use serde::Serialize;
use std::io::{self, Write};

pub use ocmc_estimation::log::road::MissingLimits;

/// Logs, and how roads are found in them.
#[derive(Clone, Debug)]
pub struct RoadRequest<'a> {
    /// The logs.
    pub logs: &'a [Source],
    /// Columns of the quantities.
    pub mappings: Vec<Mapping>,
    /// How roads are found.
    pub options: RoadOptions,
    /// Steering ratio and wheelbase, for logs that only have the steering wheel's angle.
    pub steering: Option<Steering>,
    /// Whether the standstills that no object of the map explains are stops of the road.
    pub stops: bool,
}

/// The roads that were driven on.
#[derive(Clone, Debug, Serialize)]
pub struct RoadAnswer {
    /// The roads, one for each piece of a drive.
    pub roads: Vec<MadeRoad>,
    /// Number of drives that gave none.
    pub left_out: usize,
    /// Files that were read.
    pub inputs: Vec<FileAccount>,
}

/// A road as an operating cycle; its JSON is a file that is driven.
#[derive(Clone, Debug, Serialize)]
pub struct MadeRoad {
    /// The drive that it was made from.
    pub name: String,
    /// Length, in m.
    pub length_m: f64,
    /// Number of curves.
    pub curves: usize,
    /// Number of places at which a vehicle stands.
    pub stops: usize,
    /// Sum of the climbs, in m.
    pub climb_m: f64,
    /// Where the limits come from: `column`, `given` or `estimated`.
    pub limit_source: String,
    /// Departure, in s from midnight, where it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub departure_s_of_day: Option<f64>,
    /// Day of the departure, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub departure_day_of_year: Option<f64>,
    /// The tracks.
    pub tracks: Vec<Track>,
    /// Account of the road, and of the parts of it that are hardly a road.
    #[serde(skip)]
    pub account: Account,
}

impl MadeRoad {
    fn new(name: String, cycle: &GivenCycle) -> Self {
        let climbs = cycle.altitude.windows(2).map(|pair| (pair[1].1 - pair[0].1).max(0.0));
        let findings = unlike_a_road::judge(cycle);
        let read = FileAccount { file: name.clone(), findings, ..FileAccount::default() };
        let account = account(name.as_ref(), cycle, read);
        Self {
            name,
            length_m: cycle.length_m,
            curves: account.n_curves,
            stops: account.n_stops,
            climb_m: climbs.sum(),
            limit_source: cycle.limit_source.clone().unwrap_or_default(),
            departure_s_of_day: cycle.departure.map(|departure| departure.0),
            departure_day_of_year: cycle.departure.map(|departure| departure.1),
            tracks: cycle.tracks(),
            account,
        }
    }

    /// Writes the tracks one below the other: `track,rule,position_m,value`.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_csv(&self, out: &mut impl Write) -> io::Result<()> {
        write_tracks(&self.tracks, out)
    }
}

/// Makes operating cycles of the roads that logs were driven on. `warn` receives what is odd in a
/// log, and what is left out of it.
///
/// ```
/// use ocmc_api::{MissingLimits, RoadOptions, RoadRequest, Source, go_on, road};
/// // 1 km at 10 m/s, and for 10 s a left turn with a radius of 100 m
/// let row = |k: u32| (f64::from(k) / 10.0, if (200..300).contains(&k) { 0.1 } else { 0.0 });
/// let rows = (0..1000).map(row).map(|(time, yaw)| format!("{time},10,{yaw},13.9\n"));
/// let text = format!("time_s,speed_mps,yaw_rate_radps,limit_mps\n{}", rows.collect::<String>());
/// let folder = tempfile::tempdir().expect("a directory");
/// let file = folder.path().join("log.csv");
/// std::fs::write(&file, text).expect("space");
/// let request = RoadRequest {
///     logs: &[Source::File(file)],
///     mappings: Vec::new(),
///     options: RoadOptions { missing_limits: MissingLimits::OfSpeed, ..RoadOptions::default() },
///     steering: None,
///     stops: true,
/// };
/// let answer = road(&request, &mut |_| (), &mut go_on)?;
/// let road = &answer.roads[0];
/// assert_eq!((road.curves, road.stops, road.limit_source.as_str()), (1, 0, "column"));
/// assert!((road.length_m - 999.0).abs() < 1e-6);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where a log cannot be read, [`Error::Drive`] where no drive gives a road,
/// [`Error::Interrupted`].
pub fn road(
    request: &RoadRequest,
    warn: &mut dyn FnMut(&str),
    watch: &mut Watch,
) -> Result<RoadAnswer, Error> {
    let measured = drives(request, warn, watch)?;
    let made = |drive: &MeasuredDrive| {
        let name = drive.name.clone();
        drive.road.as_ref().map(|cycle| MadeRoad::new(name, cycle))
    };
    let roads: Vec<MadeRoad> = measured.drives.iter().filter_map(made).collect();
    let doubts = roads.iter().flat_map(|road| &road.account.warnings);
    doubts.for_each(|doubt| warn(doubt));
    Ok(RoadAnswer { roads, left_out: measured.left_out.len(), inputs: measured.inputs })
}

/// The drives of logs with their roads; one at least.
pub(crate) fn drives(
    request: &RoadRequest,
    warn: &mut dyn FnMut(&str),
    watch: &mut Watch,
) -> Result<MeasuredDrives, Error> {
    let RoadRequest { logs, mappings, options, steering, stops } = request;
    let mut measured = MeasuredDrives::default();
    for (done, log) in logs.iter().enumerate() {
        Progress::of_logs(done, logs.len()).look(watch)?;
        let file = log.log(mappings, &NEEDS, warn)?;
        measured.add_with_roads(&file, options, *steering, *stops);
    }
    told(&measured, logs, warn)?;
    let estimated = measured.drives.iter().filter(|drive| {
        let limits = drive.road.as_ref().and_then(|road| road.limit_source.as_deref());
        limits == Some("estimated")
    });
    let names: Vec<&str> = estimated.map(|drive| drive.name.as_str()).collect();
    if let Some(first) = names.first() {
        let named = match names.len() {
            1 => (*first).to_owned(),
            n => format!("{first} and {} more", n - 1),
        };
        warn(&format!(
            "{named}: no column of speed limits: those of the road are what the speed of the drive \
             shows (the largest within 500 m, rounded up to 10 km/h), and no validation of it"
        ));
    }
    Ok(measured)
}

/// Says what was odd and left out; an error where nothing is left.
pub(crate) fn told(
    measured: &MeasuredDrives,
    logs: &[Source],
    warn: &mut dyn FnMut(&str),
) -> Result<(), Error> {
    if measured.drives.is_empty() {
        return Err(match measured.left_out.first() {
            Some((place, fault)) => Error::Drive { place: place.clone(), fault: fault.clone() },
            None => Error::NoDrive(
                logs.first().map_or(String::new(), |log| log.path().display().to_string()),
                "it has no piece of 200 m or more without a gap".to_owned(),
            ),
        });
    }
    measured.notes.iter().for_each(|note| warn(note));
    for (place, fault) in &measured.left_out {
        warn(&format!("{place} is left out: {fault}"));
    }
    Ok(())
}

/// Widths of the columns of the table.
const WIDTHS: [usize; 6] = [30, 9, 8, 8, 10, 12];

impl Answer for RoadAnswer {
    fn notes(&self) -> Vec<String> {
        FileAccount::told_of(&self.inputs)
    }

    fn text(&self) -> String {
        let rows = self.roads.iter().map(|road| {
            let name: String = road.name.chars().take(WIDTHS[0] - 1).collect();
            [
                name,
                rounded(road.length_m / 1000.0),
                road.curves.to_string(),
                road.stops.to_string(),
                rounded(road.climb_m),
                road.limit_source.clone(),
            ]
        });
        let head = ["road of", "km", "curves", "stops", "climb, m", "limits"];
        let mut text = table(&WIDTHS, &head, rows);
        for told in self.roads.iter().flat_map(|road| &road.account.told) {
            text.push_str(told);
            text.push('\n');
        }
        text
    }
}
