//! An event of a log: a stretch in which the driver wants one speed and the slope disturbs it.
//!
//! The slope is the exogenous input. An event begins a few seconds before the slope changes and
//! ends where the next one begins.

use super::even_slope::{EvenSlopes, SlopeScatter, even_slopes};
use super::speed_ahead::SpeedSetter;
use ocmc_core::kernel::trip::LastShift;
use serde::Serialize;
use thiserror::Error;

/// Slopes below this are flat.
const FLAT: f64 = 0.005;
/// Slopes that differ by less belong to one event.
const SAME_SLOPE: f64 = 0.004;
/// Fewest rows and shortest time of an event, in s.
const FEWEST_ROWS: usize = 30;
const SHORTEST_S: f64 = 10.0;
/// Longest time between rows of an event, in s.
const LONGEST_INTERVAL_S: f64 = 1.1;
/// A shift is over and forgotten after this time, in s: one without torque, then eight lags of the
/// engine.
const AFTER_SHIFT_S: f64 = 5.0;
/// A pedal from here on is fully pressed.
const PRESSED: f64 = 0.99;

/// The log of one event, or of a drive with several; rows in order of time, all columns equally
/// long.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PedalLog {
    /// Time, in s.
    pub time_s: Vec<f64>,
    /// Speed, in m/s.
    pub speed_mps: Vec<f64>,
    /// Accelerator pedal, 0 to 1.
    pub accelerator: Vec<f64>,
    /// Brake pedal, 0 to 1.
    pub brake: Vec<f64>,
    /// Slope, climb per metre of road: on the way from the row before to this one.
    pub grade: Vec<f64>,
    /// Position, in m; none: integrated from the speed.
    pub position_m: Option<Vec<f64>>,
    /// Gear, from 1; none: by the engine's speed.
    pub gear: Option<Vec<f64>>,
    /// The shift before the first row; none where the log has none.
    pub last_shift: Option<LastShift>,
    /// Speed limit, in m/s; none where it is not known.
    pub limit_mps: Option<Vec<f64>>,
    /// Curvature of the path, in 1/m; none where it is not known.
    pub curvature_per_m: Option<Vec<f64>>,
    /// Cause of a lower speed behind the last row; none where nothing cut the event off.
    pub ended_by: Option<SpeedSetter>,
    /// Standard error of the even stretch of slope of each row; none where the slopes are taken as
    /// they are.
    pub grade_error: Option<Vec<f64>>,
    /// Temperature of the air, in K; none: 15 °C.
    pub air_temperature_k: Option<f64>,
}

/// Why an event cannot be identified.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EventError {
    /// Columns of different lengths.
    #[error("the column {column} has {found} rows, time has {expected}")]
    Lengths {
        /// Name of the column.
        column: &'static str,
        /// Rows of the time.
        expected: usize,
        /// Rows of the column.
        found: usize,
    },
    /// Numbers that are missing.
    #[error(
        "{count} of {rows} rows lack the {column}, first row {row}: cut them off, or fill them in"
    )]
    Missing {
        /// Name of the column.
        column: &'static str,
        /// How many.
        count: usize,
        /// Rows.
        rows: usize,
        /// The first one, from 1.
        row: usize,
    },
    /// Time that does not grow, or leaps.
    #[error(
        "time goes from {before_s:.3} to {after_s:.3} s after row {row} of the event: allowed are \
         steps above 0 and up to {LONGEST_INTERVAL_S} s"
    )]
    Time {
        /// Row before, from 1.
        row: usize,
        /// Time there, in s.
        before_s: f64,
        /// Time after it, in s.
        after_s: f64,
    },
    /// Too little to identify anything.
    #[error(
        "{rows} row{} over {duration_s:.1} s{}: at least {FEWEST_ROWS} rows over {SHORTEST_S} s \
         are needed",
        if *rows == 1 { "" } else { "s" },
        ended_by.map_or(String::new(), |setter| format!(", where {}", setter.text()))
    )]
    TooShort {
        /// Rows.
        rows: usize,
        /// Duration, in s.
        duration_s: f64,
        /// Setter that ends it.
        ended_by: Option<SpeedSetter>,
    },
    /// Pedals that are no shares.
    #[error(
        "the {column} reaches {value} in row {row}: allowed are shares from 0 to 1, is it in \
         percent?"
    )]
    Pedal {
        /// Name of the column.
        column: &'static str,
        /// The value.
        value: f64,
        /// Its row, from 1.
        row: usize,
    },
    /// The answer is not needed any more.
    #[error("stopped before it was identified")]
    Stopped,
    /// A vehicle that stands.
    #[error(
        "the vehicle stands, creeps or reverses (slower than 2 m/s) in {count} rows: the set \
         speed is not constant"
    )]
    Standing {
        /// How many rows.
        count: usize,
    },
}

impl EventError {
    /// The reason without its numbers, by which many events are counted: `left out for ...`.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Lengths { .. } => "columns of different lengths",
            Self::Missing { .. } => "missing numbers",
            Self::Time { .. } => "rows more than 1.1 s apart or not in order of time",
            Self::TooShort { .. } => "less than 30 rows or 10 s",
            Self::Pedal { .. } => "pedals outside 0 to 1",
            Self::Stopped => "an end before their turn",
            Self::Standing { .. } => "a vehicle that stands, creeps or reverses",
        }
    }
}

/// Properties of an event.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EventSummary {
    /// The largest slope, signed.
    pub grade: f64,
    /// Time with a fully pressed pedal, in s.
    pub saturated_s: f64,
    /// Duration, in s.
    pub duration_s: f64,
}

impl PedalLog {
    /// Rows `first` to `end` (excluded).
    #[must_use]
    pub fn part(&self, first: usize, end: usize) -> Self {
        let part_of = |column: &Vec<f64>| column[first..end].to_vec();
        Self {
            time_s: part_of(&self.time_s),
            speed_mps: part_of(&self.speed_mps),
            accelerator: part_of(&self.accelerator),
            brake: part_of(&self.brake),
            grade: part_of(&self.grade),
            position_m: self.position_m.as_ref().map(part_of),
            gear: self.gear.as_ref().map(part_of),
            last_shift: self.last_shift_before(first),
            ended_by: self.ended_by.filter(|_| end == self.time_s.len()),
            limit_mps: self.limit_mps.as_ref().map(part_of),
            curvature_per_m: self.curvature_per_m.as_ref().map(part_of),
            grade_error: self.grade_error.as_ref().map(part_of),
            air_temperature_k: self.air_temperature_k,
        }
    }

    /// The slope events of a drive: name, and rows. An event begins `before_s` before its slope
    /// does, and ends where the next one begins, but at most `after_s` behind its slope.
    pub fn slope_events(
        &self,
        before_s: f64,
        after_s: f64,
    ) -> Vec<(String, std::ops::Range<usize>)> {
        let rows = self.time_s.len().min(self.grade.len());
        let mut slopes: Vec<(usize, usize)> = Vec::new();
        let mut k = 0;
        while k < rows {
            let grade = self.grade[k];
            let mut end = k + 1;
            while end < rows && (self.grade[end] - grade).abs() < SAME_SLOPE {
                end += 1;
            }
            if grade.abs() >= FLAT {
                slopes.push((k, end));
            }
            k = end;
        }
        // no event begins before a shift is over: the log does not determine how far it is
        let begin = |&(first, end): &(usize, usize)| {
            let start_s = self.time_s[first] - before_s;
            let mut start = self.time_s.partition_point(|t| *t < start_s).min(first);
            while start + 1 < end && self.shifts_before(start) {
                start += 1;
            }
            start
        };
        let mut events = Vec::new();
        for (place, slope) in slopes.iter().enumerate() {
            let next = slopes.get(place + 1).map_or(rows, |next| begin(next).max(slope.1));
            let last_s = self.time_s[slope.1 - 1] + after_s;
            let end = next.min(self.time_s.partition_point(|t| *t <= last_s));
            let name = format!("{:+.1} %", 100.0 * self.grade[slope.0]);
            let same =
                events.iter().filter(|(known, _): &&(String, _)| known.starts_with(&name)).count();
            let name = if same > 0 { format!("{name} ({})", same + 1) } else { name };
            events.push((name, begin(slope)..end));
        }
        events
    }

    /// The log with even stretches in place of a slope that scatters, and what scatter it had.
    #[must_use]
    pub fn with_even_slopes(self) -> (Self, Option<SlopeScatter>) {
        match even_slopes(&self.grade) {
            Some(EvenSlopes { grade, error, scatter }) => {
                (Self { grade, grade_error: Some(error), ..self }, Some(scatter))
            }
            None => (self, None),
        }
    }

    /// The even stretches whose slope is not certain: rows and standard error.
    pub fn uncertain_stretches(&self) -> Vec<(std::ops::Range<usize>, f64)> {
        let Some(error) = &self.grade_error else { return Vec::new() };
        let mut first = 0;
        self.grade
            .chunk_by(|a, b| a == b)
            .map(|stretch| {
                let rows = first..first + stretch.len();
                first = rows.end;
                (rows.clone(), error[rows.start])
            })
            .collect()
    }

    /// The last shift before a row, or in it.
    fn last_shift_before(&self, row: usize) -> Option<LastShift> {
        let at_s = *self.time_s.get(row)?;
        let gear = self.gear.as_ref()?;
        let shifts = |k: &usize| libm::round(gear[*k]) != libm::round(gear[k - 1]);
        match (1..=row).rev().find(shifts) {
            Some(k) => {
                Some(LastShift { since_s: at_s - self.time_s[k], upwards: gear[k] > gear[k - 1] })
            }
            None => self
                .last_shift
                .map(|shift| LastShift { since_s: shift.since_s + at_s - self.time_s[0], ..shift }),
        }
    }

    /// Whether another gear was engaged in a row or shortly before it.
    fn shifts_before(&self, row: usize) -> bool {
        let Some(gear) = &self.gear else { return false };
        let since_s = self.time_s[row] - AFTER_SHIFT_S;
        let mut rows = (1..=row).rev().take_while(|&k| self.time_s[k] >= since_s);
        rows.any(|k| libm::round(gear[k]) != libm::round(gear[k - 1]))
    }

    /// Checks an event.
    ///
    /// # Errors
    /// [`EventError`].
    pub fn check(&self) -> Result<EventSummary, EventError> {
        let rows = self.time_s.len();
        let columns = [
            ("time", Some(&self.time_s)),
            ("speed", Some(&self.speed_mps)),
            ("accelerator", Some(&self.accelerator)),
            ("brake", Some(&self.brake)),
            ("grade", Some(&self.grade)),
            ("position", self.position_m.as_ref()),
            ("gear", self.gear.as_ref()),
            ("error of the grade", self.grade_error.as_ref()),
        ];
        let known = || columns.into_iter().filter_map(|(column, values)| Some((column, values?)));
        if let Some((column, values)) = known().find(|(_, values)| values.len() != rows) {
            return Err(EventError::Lengths { column, expected: rows, found: values.len() });
        }
        for (column, values) in known() {
            let count = values.iter().filter(|value| !value.is_finite()).count();
            if let Some(row) = values.iter().position(|value| !value.is_finite()) {
                return Err(EventError::Missing { column, count, rows, row: row + 1 });
            }
        }
        for (row, pair) in self.time_s.windows(2).enumerate() {
            let step_s = pair[1] - pair[0];
            if !(step_s > 0.0 && step_s <= LONGEST_INTERVAL_S) {
                let (before_s, after_s) = (pair[0], pair[1]);
                return Err(EventError::Time { row: row + 1, before_s, after_s });
            }
        }
        let duration_s = self.duration_s();
        if rows < FEWEST_ROWS || duration_s < SHORTEST_S {
            return Err(EventError::TooShort { rows, duration_s, ended_by: self.ended_by });
        }
        for (column, values) in [("accelerator", &self.accelerator), ("brake", &self.brake)] {
            // noise around 0 and 1 is allowed
            if let Some(row) = values.iter().position(|value| !(-0.5..=1.5).contains(value)) {
                return Err(EventError::Pedal { column, value: values[row], row: row + 1 });
            }
        }
        let count = self.speed_mps.iter().filter(|speed| **speed < 2.0).count();
        if count > 0 {
            return Err(EventError::Standing { count });
        }
        let steeper = |most: f64, g: &f64| if g.abs() > most.abs() { *g } else { most };
        let grade = self.grade.iter().fold(0.0, steeper);
        let pressed = |k: usize| self.accelerator[k] >= PRESSED || self.brake[k] >= PRESSED;
        let saturated =
            (1..rows).filter(|k| pressed(*k)).map(|k| self.time_s[k] - self.time_s[k - 1]);
        Ok(EventSummary { grade, saturated_s: saturated.fold(0.0, |sum, s| sum + s), duration_s })
    }

    /// From the first to the last row, in s.
    pub fn duration_s(&self) -> f64 {
        match (self.time_s.first(), self.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// Whether positions are given that nowhere run backwards.
    pub fn has_positions(&self) -> bool {
        let forwards = |position_m: &Vec<f64>| position_m.windows(2).all(|pair| pair[1] >= pair[0]);
        self.position_m.as_ref().is_some_and(forwards)
    }

    /// Positions, in m: given, or integrated from the speed where none are or where they run
    /// backwards.
    pub fn positions_m(&self) -> Vec<f64> {
        if let Some(position_m) = self.position_m.as_ref().filter(|_| self.has_positions()) {
            return position_m.clone();
        }
        let mut positions = vec![0.0; self.time_s.len().min(1)];
        for k in 1..self.time_s.len() {
            let mean = 0.5 * (self.speed_mps[k] + self.speed_mps[k - 1]);
            positions.push(positions[k - 1] + mean * (self.time_s[k] - self.time_s[k - 1]));
        }
        positions
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive() -> PedalLog {
        let rows = 1000;
        let time_s: Vec<f64> = (0..rows).map(|k| 0.1 * k as f64).collect();
        let grade = |t: f64| match t {
            t if (20.0..40.0).contains(&t) => 0.035,
            t if (60.0..80.0).contains(&t) => -0.015,
            _ => 0.0,
        };
        PedalLog {
            speed_mps: vec![20.0; rows],
            accelerator: time_s
                .iter()
                .map(|t| if (30.0..31.0).contains(t) { 1.0 } else { 0.3 })
                .collect(),
            brake: vec![0.0; rows],
            grade: time_s.iter().map(|t| grade(*t)).collect(),
            time_s,
            ..PedalLog::default()
        }
    }

    #[test]
    fn slopes_are_events() {
        let log = drive();
        let events = log.slope_events(5.0, 18.0);
        let names: Vec<&str> = events.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["+3.5 %", "-1.5 %"]);
        assert_eq!((events[0].1.start, events[0].1.end, events[1].1.end), (150, 550, 980));
        let kind = log.part(events[0].1.start, events[0].1.end).check().unwrap();
        assert!(kind.grade == 0.035 && (kind.saturated_s - 1.0).abs() < 0.11, "{kind:?}");
    }

    #[test]
    fn the_last_shift_is_carried_into_an_event() {
        let gear = (0..1000).map(|k| if k < 100 { 10.0 } else { 11.0 }).collect();
        let log = PedalLog { gear: Some(gear), ..drive() };
        assert_eq!(log.part(50, 900).last_shift, None);
        let event = log.part(180, 900);
        let LastShift { since_s, upwards } = event.last_shift.expect("row 100");
        assert!((since_s - 8.0).abs() < 1e-9 && upwards);
        let later = event.part(20, 300).last_shift.expect("still known");
        assert!((later.since_s - 10.0).abs() < 1e-9);
    }

    #[test]
    fn bad_events_say_why() {
        let good = drive();
        let with = |change: &dyn Fn(&mut PedalLog)| {
            let mut log = good.clone();
            change(&mut log);
            log.check().unwrap_err()
        };
        let error = with(&|log| log.brake[7] = f64::NAN);
        assert!(matches!(error, EventError::Missing { column: "brake", count: 1, row: 8, .. }));
        assert!(matches!(with(&|log| log.time_s[7] = 0.0), EventError::Time { row: 7, .. }));
        assert!(matches!(with(&|log| log.accelerator[3] = 30.0), EventError::Pedal { row: 4, .. }));
        assert!(matches!(with(&|log| log.speed_mps[3] = 0.0), EventError::Standing { count: 1 }));
        assert!(matches!(
            with(&|log| *log = log.part(0, 20)),
            EventError::TooShort { rows: 20, .. }
        ));
        assert_eq!(LONGEST_INTERVAL_S.to_string(), "1.1");
        assert!(with(&|log| log.time_s[7] = 0.0).kind().contains("1.1 s"));
        let short = with(&|log| *log = log.part(0, 20)).kind();
        assert_eq!(short, format!("less than {FEWEST_ROWS} rows or {SHORTEST_S} s"));
        assert!(matches!(
            with(&|log| _ = log.grade.pop()),
            EventError::Lengths { column: "grade", .. }
        ));
    }
}
