//! The drives of a log, completed one by one, and what all of them add up to: so a log can be given
//! away in parts while it is read.

use super::{LogFile, LoggedTrip, Need, account, motion, trip_end};
use crate::intake::account::DriveSteps;
use crate::intake::slope::SlopeSum;
use crate::intake::table::error::Fault;
use crate::intake::table::{Column, Quantity, TableError};
use crate::intake::{Finding, contradiction};
use account::how_numbers_are_written;
use std::collections::BTreeSet;
use std::path::Path;

/// Longest way between two rows whose slope is judged, in m.
const LONGEST_STEP_M: f64 = 200.0;

/// How drives are completed, and what was found in those so far.
pub(super) struct Completion<'a> {
    pub(super) path: &'a Path,
    /// Whether a label parts the drives.
    pub(super) is_labelled: bool,
    /// Standstill that ends a trip, in s.
    pub(super) pause_s: Option<f64>,
    ends: Vec<Finding>,
    motions: Vec<Finding>,
    standing: Vec<Finding>,
    ambient_k: Vec<f64>,
    steps: DriveSteps,
    slopes: SlopeSum,
    /// Quantities of which there is a number somewhere.
    numbers: BTreeSet<Quantity>,
}

impl<'a> Completion<'a> {
    /// Begins without a drive.
    pub(super) fn new(path: &'a Path, is_labelled: bool, pause_s: Option<f64>) -> Self {
        Self {
            path,
            is_labelled,
            pause_s,
            ends: Vec::new(),
            motions: Vec::new(),
            standing: Vec::new(),
            ambient_k: Vec::new(),
            steps: DriveSteps::default(),
            slopes: SlopeSum::default(),
            numbers: BTreeSet::new(),
        }
    }

    /// The trips of some drives, with what follows from their columns. `is_part`: whether there are
    /// others.
    pub(super) fn complete(
        &mut self,
        drives: Vec<LoggedTrip>,
        is_part: bool,
    ) -> Result<Vec<LoggedTrip>, TableError> {
        let mut trips = Vec::with_capacity(drives.len());
        for mut drive in drives {
            drive.count_fuel();
            if self.is_labelled {
                trips.push(drive);
                continue;
            }
            let (parts, finding) = trip_end::split(drive, self.pause_s);
            self.ends.extend(finding);
            trips.extend(parts);
        }
        let several = is_part || trips.len() > 1;
        for trip in &mut trips {
            self.complete_trip(trip, several)?;
        }
        Ok(trips)
    }

    fn complete_trip(&mut self, trip: &mut LoggedTrip, several: bool) -> Result<(), TableError> {
        let name = trip.drive.clone();
        let told = |finding: Finding| {
            let place = if several { format!("drive `{name}`: ") } else { String::new() };
            Finding { text: place + &finding.text, ..finding }
        };
        self.ambient_k.extend(trip.ambient_k());
        self.motions.extend(motion::complete(trip).into_iter().map(told));
        let [time_s, speed_mps] = [Quantity::Time, Quantity::Speed].map(|q| trip.column(q));
        if let Some((time_s, speed_mps)) = time_s.zip(speed_mps) {
            self.steps.add(time_s, Some(speed_mps));
        }
        sloped_steps(trip).for_each(|(way_m, slope)| self.slopes.add(way_m, slope));
        let has_number = |column: &[f64]| column.iter().any(|value| !value.is_nan());
        let quantities = trip.columns.iter().filter(|(_, column)| has_number(column.values()));
        self.numbers.extend(quantities.map(|(quantity, _)| *quantity));
        let mut findings = trip.stand();
        findings.extend(contradiction::of_drive(&|quantity| trip.column(quantity)));
        for finding in findings.into_iter().map(told) {
            if finding.is_refusal() {
                return Err(TableError::of(self.path, Fault::Check(finding)));
            }
            self.standing.push(finding);
        }
        Ok(())
    }

    /// Says in the account of a file what was found in all of its drives.
    pub(super) fn finish(self, file: &mut LogFile, needs: &[Need]) -> Result<(), TableError> {
        file.read.findings.extend(self.ends);
        file.read.findings.extend(account::ambient_temperature(&self.ambient_k));
        file.read.findings.extend(self.motions);
        file.read.extent = self.steps.extent();
        file.read.judged(self.path, self.slopes.judge(file.read.has_slope_with_unit()))?;
        for need in needs {
            check_numbers(file, need, &self.numbers)?;
        }
        file.read.findings.extend(self.standing);
        Ok(())
    }
}

/// The way of each row of a drive, in m, with its slope.
fn sloped_steps(drive: &LoggedTrip) -> impl Iterator<Item = (f64, f64)> + '_ {
    let column = |quantity| drive.column(quantity).unwrap_or_default();
    let [time_s, speed_mps, grade] = [Quantity::Time, Quantity::Speed, Quantity::Grade].map(column);
    let steps = time_s.windows(2).zip(speed_mps).zip(grade);
    let way = steps.map(|((time, speed), grade)| ((time[1] - time[0]) * speed, *grade));
    way.filter(|(way_m, grade)| *way_m > 0.0 && *way_m < LONGEST_STEP_M && grade.is_finite())
}

/// A column that is needed has a number somewhere.
fn check_numbers(
    file: &LogFile,
    need: Need,
    numbers: &BTreeSet<Quantity>,
) -> Result<(), TableError> {
    let present = file.columns.iter().filter(|(column, _)| need.contains(&column.quantity));
    let has_number = |(column, _): &(Column, String)| numbers.contains(&column.quantity);
    let Some((_, column)) =
        present.clone().next_back().filter(|_| !present.clone().any(has_number))
    else {
        return Ok(());
    };
    let example = file.unreadable.iter().find(|cells| cells.column == *column);
    let fault = Fault::NoNumbers {
        column: column.clone(),
        rows: file.rows,
        example: example.map_or_else(String::new, |cells| {
            let hint = how_numbers_are_written(&cells.column, &cells.text);
            format!(": {} has `{}`{hint}", cells.place, cells.text)
        }),
    };
    Err(TableError::of(&file.path, fault))
}
