//! From log files to drives on a road: the way that was driven, the road that was driven on, and
//! the energy that it took.

use super::curves::{Steering, TripError, tells_steering_only};
use super::noise::without_noise;
use super::roads::{found, notes, road_log, steering_note};
use super::{LogFile, LoggedTrip, row_notes};
use crate::intake::FileAccount;
use crate::intake::table::Quantity;
use ocmc_core::energy::carrier::CARRIERS;
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::road::point_event::{EventKind, PointEvent};
use ocmc_core::operating_cycle::road::route_noise::LEAST_NOISE_M;
use ocmc_estimation::log::road::{LoggedRoad, RoadOptions, ways};
use ocmc_estimation::log::way::DrivenWay;

/// A drive that was measured.
#[derive(Clone, Debug)]
pub struct MeasuredDrive {
    /// The drive, and which piece of it.
    pub name: String,
    /// Fingerprint of the drive, whatever its file is called.
    pub fingerprint: String,
    /// Its way.
    pub way: DrivenWay,
    /// Energy taken from its first row on, row by row, and the rate by which the log tells it.
    pub energy: Option<(Quantity, Vec<f64>)>,
    /// The road that it was driven on, where it was asked for.
    pub road: Option<GivenCycle>,
}

/// Drives of logs.
#[derive(Clone, Debug, Default)]
pub struct MeasuredDrives {
    /// The drives.
    pub drives: Vec<MeasuredDrive>,
    /// Notes that have to be known, each with its place.
    pub notes: Vec<String>,
    /// Where the drives stand that could not be used, and why.
    pub left_out: Vec<(String, TripError)>,
    /// Files that were read.
    pub inputs: Vec<FileAccount>,
}

impl MeasuredDrives {
    /// Adds the drives of a log with the roads that they were driven on. With `stops` the
    /// standstills that no object of the map explains are on the road, too. Positions and altitudes
    /// that scatter are smoothed first, as those of given routes.
    pub fn add_with_roads(
        &mut self,
        file: &LogFile,
        options: &RoadOptions,
        steering: Option<Steering>,
        stops: bool,
    ) {
        self.inputs.push(file.read.clone());
        for drive in &file.drives {
            let place = file.place(drive);
            let quiet = without_noise(drive).and_then(|(quiet, noise)| {
                let mut options = options.clone();
                if noise.altitudes_m >= LEAST_NOISE_M {
                    // what has no noise any more is not averaged
                    options.altitude_average_m = 0.0;
                }
                let steered = steering.is_none() && tells_steering_only(&quiet);
                if steered {
                    self.notes.push(steering_note(&place));
                }
                Ok((found(&quiet, &options, steering, !steered)?, noise))
            });
            let (measured, noise) = match quiet {
                Ok(measured) => measured,
                Err(fault) => {
                    self.left_out.push((place, fault));
                    continue;
                }
            };
            self.notes.extend(notes(&place, &measured.counts));
            let count = measured.roads.len();
            for (k, road) in measured.roads.into_iter().enumerate() {
                let source = (drive.fingerprint(), measured.limits.name());
                match given(&road, stops, source) {
                    Ok(given) => {
                        let given = GivenCycle { noise, ..given };
                        self.push(drive, (k, count), road.way, Some(given));
                    }
                    Err(fault) => self.left_out.push((place.clone(), fault)),
                }
            }
        }
    }

    /// Adds the drives of a log, whose roads are known.
    pub fn add(&mut self, file: &LogFile) {
        self.inputs.push(file.read.clone());
        for drive in &file.drives {
            let place = file.place(drive);
            match ways(&road_log(drive, None)) {
                Ok((ways, counts)) => {
                    self.notes.extend(row_notes(&place, &counts));
                    let count = ways.len();
                    for (k, way) in ways.into_iter().enumerate() {
                        self.push(drive, (k, count), way, None);
                    }
                }
                Err(fault) => self.left_out.push((place, fault.into())),
            }
        }
    }

    fn push(
        &mut self,
        drive: &LoggedTrip,
        (piece, pieces): (usize, usize),
        way: DrivenWay,
        road: Option<GivenCycle>,
    ) {
        let piece = if pieces > 1 { format!(" ({})", piece + 1) } else { String::new() };
        let event = drive.event.as_ref().map_or(String::new(), |event| format!(", {event}"));
        let name = format!("{}{event}{piece}", drive.drive);
        let energy = energy(drive, &way);
        let fingerprint = drive.fingerprint();
        self.drives.push(MeasuredDrive { name, fingerprint, way, energy, road });
    }
}

/// The energy of a drive up to each row of its way: a rate is the mean since the row before.
fn energy(drive: &LoggedTrip, way: &DrivenWay) -> Option<(Quantity, Vec<f64>)> {
    let rates = CARRIERS.iter().map(|declared| Quantity::rate_of(declared.carrier));
    let (rate, rates) = rates.into_iter().find_map(|rate| Some((rate, drive.column(rate)?)))?;
    let mut sum = 0.0;
    let mut all = Vec::with_capacity(way.row.len());
    for (k, &row) in way.row.iter().enumerate() {
        if k > 0 {
            sum += rates[row] * (way.time_s[k] - way.time_s[k - 1]);
        }
        all.push(sum);
    }
    // a row without a rate leaves everything behind it unknown
    sum.is_finite().then_some((rate, all))
}

/// The road of a log as a given cycle: as a file of it is read back.
fn given(
    road: &LoggedRoad,
    stops: bool,
    (log, limits): (String, &str),
) -> Result<GivenCycle, TripError> {
    let mut cycle = road.cycle.clone();
    if stops {
        cycle.events.extend(road.standstills.iter().map(|stop| PointEvent {
            position_m: stop.position_m,
            kind: EventKind::StopSign { standstill_s: stop.duration_s },
            turns: false,
        }));
        cycle.events.sort_by(|a, b| a.position_m.total_cmp(&b.position_m));
    }
    cycle.source_log = Some(log);
    cycle.limit_source = Some(limits.to_owned());
    if cycle.limits.iter().any(|limit| limit.1.is_nan()) {
        return Err(TripError::NoLimit);
    }
    let again = GivenCycle::from_tracks(&cycle.tracks(), Some(cycle.length_m))?;
    let whole = |(second, day): &(f64, f64)| second.is_finite() && day.is_finite();
    Ok(GivenCycle { departure: cycle.departure.filter(whole), ..again })
}
