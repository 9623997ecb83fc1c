//! Requirements on a log, and its pieces between gaps. Nothing is dropped without being counted.

use super::{Samples, TripLog};
use crate::option_check::OptionError;
use serde::Serialize;
use thiserror::Error;

/// Fewest usable rows of a log.
pub const FEWEST_ROWS: usize = 10;
/// Sampling rates that the detectors are meant for, in Hz, with some slack for clocks.
pub const RATES_HZ: [f64; 2] = [0.9, 110.0];
/// Rows farther apart than this many sampling intervals, and than [`SHORTEST_GAP_S`], have a gap
/// between them.
const GAP_INTERVALS: f64 = 2.5;
/// See [`GAP_INTERVALS`], in s: a log of 1 Hz has no gap there either, and a trace has steps of up
/// to 2 s.
const SHORTEST_GAP_S: f64 = 2.05;
/// Speeds and yaw rates above these, in m/s and rad/s, are no road vehicle's: the unit is probably
/// wrong.
const IMPLAUSIBLE_SPEED_MPS: f64 = 70.0;
const IMPLAUSIBLE_YAW_RADPS: f64 = 2.0;
/// Speed limits that can be, in m/s; anything else, such as 0 or 255 km/h, says that the map knows
/// none.
pub(crate) const LIMITS_MPS: [f64; 2] = [1.0, 70.0];
/// Nothing on the ground is faster than this, in m/s: the way of such a log would not fit into
/// memory.
const FASTEST_MPS: f64 = 1000.0;
/// Slower than this, in m/s, the vehicle reverses; slightly negative speeds are noise around 0.
const REVERSE_MPS: f64 = -0.5;

/// Why a log cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LogError {
    /// Columns of different lengths.
    #[error(
        "the column {column} has {found} rows, time has {expected}: all columns need the same \
         number"
    )]
    Lengths {
        /// Name of the column.
        column: &'static str,
        /// Rows of the time.
        expected: usize,
        /// Rows of the column.
        found: usize,
    },
    /// Too little to work with.
    #[error(
        "{} of {} rows can be used ({} lack the time, {} the speed, {} the yaw rate, \
         {} repeat a time or reverse): at least {FEWEST_ROWS} are needed",
        .0.used, .0.rows, .0.missing_time, .0.missing_speed, .0.missing_yaw_rate,
        .0.repeated_time + .0.reversing
    )]
    TooFewRows(Box<LogCounts>),
    /// Time that runs backwards.
    #[error(
        "time runs backwards {}, first after row {row}, from {before_s:.3} to {after_s:.3} s: \
         sort the rows, or name the column that tells the drives apart",
        if *count == 1 { "once".to_owned() } else { format!("{count} times") }
    )]
    Backwards {
        /// How often.
        count: usize,
        /// Row before the first one, from 1.
        row: usize,
        /// Time there, in s.
        before_s: f64,
        /// Time after it, in s.
        after_s: f64,
    },
    /// Sampling that is too slow or too fast.
    #[error(
        "the rows are {interval_s} s apart in the median ({rate_hz:.3} Hz): allowed are 1 to 100 \
         Hz; is the unit of time right?"
    )]
    Rate {
        /// Median interval, in s.
        interval_s: f64,
        /// Its reciprocal, in Hz.
        rate_hz: f64,
    },
    /// A speed that is none.
    #[error(
        "row {row} has a speed of {speed_mps} m/s: allowed are up to {FASTEST_MPS} m/s; is the \
         unit of speed right?"
    )]
    Speed {
        /// The row, from 1.
        row: usize,
        /// Its speed, in m/s.
        speed_mps: f64,
    },
    /// nothing that determines road types.
    #[error(
        "no road type is known: name a column road_type, or one with the speed limit, from which \
         types follow, or give one type for the whole log (--road-type)"
    )]
    NoRoadType,
    /// An option that makes no sense.
    #[error("{} is {}: allowed is {}", .0.option, .0.value, .0.allowed)]
    Option(OptionError),
}

/// Counts of the preparation of a log.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LogCounts {
    /// Rows of the log.
    pub rows: usize,
    /// Rows that were used.
    pub used: usize,
    /// Rows without time.
    pub missing_time: usize,
    /// Rows without speed.
    pub missing_speed: usize,
    /// Rows without yaw rate.
    pub missing_yaw_rate: usize,
    /// Rows with the same time as the row before, without that which ends a trace.
    pub repeated_time: usize,
    /// Rows that reverse; not used.
    pub reversing: usize,
    /// Rows above 70 m/s, which are used: is the unit right?
    pub implausible_speed: usize,
    /// Rows above 2 rad/s, which are used: is the unit right?
    pub implausible_yaw_rate: usize,
    /// Gaps in time, where the log is cut.
    pub gaps: usize,
    /// Time in gaps, in s.
    pub gap_s: f64,
    /// Median sampling interval, in s.
    pub interval_s: f64,
}

/// A log without gaps; all columns have equal lengths of at least 2, optional ones are empty where
/// they are not known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    /// Time, in s, increasing.
    pub time_s: Vec<f64>,
    /// Speed, in m/s, not negative.
    pub speed_mps: Vec<f64>,
    /// Yaw rate, in rad/s.
    pub yaw_rate_radps: Vec<f64>,
    /// Row of the log.
    pub row: Vec<usize>,
}

/// Time between rows from which on there is a gap, in s, at a median interval, in s.
pub(crate) fn longest_interval_s(interval_s: f64) -> f64 {
    (GAP_INTERVALS * interval_s).max(SHORTEST_GAP_S)
}

/// Checks a log and cuts it at gaps.
///
/// # Errors
/// [`LogError`] where columns have different lengths, too few rows are usable, time runs backwards,
/// or the sampling rate is outside 1 to 100 Hz.
pub fn prepare(log: &TripLog) -> Result<(Vec<Piece>, LogCounts), LogError> {
    let expected = log.time_s.len();
    let optional = |column: &Option<Samples>| column.as_ref().map_or(expected, |c| c.len());
    let lengths = [
        ("speed", log.speed_mps.len()),
        ("yaw rate", log.yaw_rate_radps.len()),
        ("course", optional(&log.course_rad)),
        ("latitude", optional(&log.latitude_deg)),
        ("longitude", optional(&log.longitude_deg)),
        ("limit", optional(&log.limit_mps)),
    ];
    if let Some((column, found)) = lengths.into_iter().find(|(_, found)| *found != expected) {
        return Err(LogError::Lengths { column, expected, found });
    }
    let mut counts = LogCounts { rows: expected, ..LogCounts::default() };
    let rows = usable_rows(log, &mut counts);
    if let Some(&row) = rows.iter().find(|&&row| log.speed_mps[row] > FASTEST_MPS) {
        return Err(LogError::Speed { row: row + 1, speed_mps: log.speed_mps[row] });
    }
    check_time(&log.time_s, &rows)?;
    let mut kept: Vec<usize> = Vec::with_capacity(rows.len());
    for row in rows {
        if kept.last().is_some_and(|&last| log.time_s[last] == log.time_s[row]) {
            counts.repeated_time += usize::from(!ends_at_rest(&log.time_s, &log.speed_mps, row));
        } else {
            kept.push(row);
        }
    }
    counts.used = kept.len();
    if kept.len() < FEWEST_ROWS {
        return Err(LogError::TooFewRows(Box::new(counts)));
    }
    let intervals = kept.windows(2).map(|pair| log.time_s[pair[1]] - log.time_s[pair[0]]);
    counts.interval_s = median(intervals.collect());
    let rate_hz = 1.0 / counts.interval_s;
    if !(RATES_HZ[0]..=RATES_HZ[1]).contains(&rate_hz) {
        return Err(LogError::Rate { interval_s: counts.interval_s, rate_hz });
    }
    let longest_s = longest_interval_s(counts.interval_s);
    let mut pieces = vec![Piece::default()];
    let mut before_s = f64::NAN;
    for row in kept {
        let time_s = log.time_s[row];
        if time_s - before_s > longest_s {
            counts.gaps += 1;
            counts.gap_s += time_s - before_s;
            pieces.push(Piece::default());
        }
        before_s = time_s;
        let piece = pieces.last_mut().expect("there is always one");
        piece.time_s.push(time_s);
        piece.speed_mps.push(log.speed_mps[row].max(0.0));
        piece.yaw_rate_radps.push(log.yaw_rate_radps[row]);
        piece.row.push(row);
    }
    pieces.retain(|piece| piece.time_s.len() >= 2);
    Ok((pieces, counts))
}

/// Whether a row that repeats a time only says that the drive ends at rest there, as the last row
/// of a trace does.
pub fn ends_at_rest(time_s: &[f64], speed_mps: &[f64], row: usize) -> bool {
    row + 1 == time_s.len() && speed_mps[row] == 0.0
}

fn usable_rows(log: &TripLog, counts: &mut LogCounts) -> Vec<usize> {
    let mut rows = Vec::with_capacity(counts.rows);
    for row in 0..counts.rows {
        let (speed, yaw) = (log.speed_mps[row], log.yaw_rate_radps[row]);
        if !log.time_s[row].is_finite() {
            counts.missing_time += 1;
        } else if !speed.is_finite() {
            counts.missing_speed += 1;
        } else if !yaw.is_finite() {
            counts.missing_yaw_rate += 1;
        } else if speed < REVERSE_MPS {
            counts.reversing += 1;
        } else {
            counts.implausible_speed += usize::from(speed > IMPLAUSIBLE_SPEED_MPS);
            counts.implausible_yaw_rate += usize::from(yaw.abs() > IMPLAUSIBLE_YAW_RADPS);
            rows.push(row);
        }
    }
    rows
}

/// Checks that time never runs backwards over these rows.
///
/// # Errors
/// [`LogError::Backwards`].
pub fn check_time(time_s: &[f64], rows: &[usize]) -> Result<(), LogError> {
    let mut back = rows.windows(2).filter(|pair| time_s[pair[1]] < time_s[pair[0]]);
    let Some(first) = back.next() else { return Ok(()) };
    Err(LogError::Backwards {
        count: 1 + back.count(),
        row: first[0] + 1,
        before_s: time_s[first[0]],
        after_s: time_s[first[1]],
    })
}

/// The median of some numbers; NaN of none.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    values.sort_by(f64::total_cmp);
    let n = values.len();
    f64::midpoint(values[(n - 1) / 2], values[n / 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(rows: usize) -> TripLog<'static> {
        TripLog {
            time_s: (0..rows).map(|k| k as f64 * 0.1).collect(),
            speed_mps: vec![10.0; rows].into(),
            yaw_rate_radps: vec![0.0; rows].into(),
            ..TripLog::default()
        }
    }

    #[test]
    fn a_speed_beyond_all_units_is_refused() {
        let mut log = log(100);
        log.speed_mps.to_mut()[7] = 1e308;
        let error = prepare(&log).unwrap_err();
        assert_eq!(error, LogError::Speed { row: 8, speed_mps: 1e308 });
        assert!(error.to_string().contains("is the unit of speed right?"));
    }

    #[test]
    fn everything_that_is_left_out_is_counted() {
        let mut log = log(100);
        log.time_s.to_mut()[3] = f64::NAN;
        log.speed_mps.to_mut()[10] = f64::NAN;
        log.yaw_rate_radps.to_mut()[20..40].fill(f64::NAN); // 2.1 s without yaw rate: a gap
        log.speed_mps.to_mut()[50] = -3.0;
        log.speed_mps.to_mut()[60] = 100.0;
        log.yaw_rate_radps.to_mut()[61] = 9.0;
        log.time_s.to_mut()[70] = log.time_s[69];
        let (pieces, counts) = prepare(&log).unwrap();
        assert_eq!(
            (counts.missing_time, counts.missing_speed, counts.missing_yaw_rate),
            (1, 1, 20)
        );
        assert_eq!((counts.reversing, counts.repeated_time), (1, 1));
        assert_eq!((counts.implausible_speed, counts.implausible_yaw_rate), (1, 1));
        assert_eq!((counts.gaps, pieces.len(), counts.used), (1, 2, 76));
        assert!((counts.gap_s - 2.1).abs() < 1e-9 && (counts.interval_s - 0.1).abs() < 1e-9);
        assert_eq!(pieces[1].row[0], 40);
    }

    #[test]
    fn what_cannot_be_used_says_why() {
        let mut backwards = log(50);
        backwards.time_s.to_mut()[30] = 0.0;
        let error = prepare(&backwards).unwrap_err();
        assert!(matches!(error, LogError::Backwards { count: 1, row: 30, .. }), "{error}");
        assert!(matches!(prepare(&log(3)), Err(LogError::TooFewRows(few)) if few.rows == 3));
        let empty = prepare(&TripLog::default());
        assert!(matches!(empty, Err(LogError::TooFewRows(few)) if few.rows == 0));
        let mut short = log(50);
        short.yaw_rate_radps.to_mut().pop();
        assert!(matches!(prepare(&short), Err(LogError::Lengths { column: "yaw rate", .. })));
        let mut milliseconds = log(50);
        for time in milliseconds.time_s.to_mut() {
            *time *= 1000.0;
        }
        assert!(matches!(prepare(&milliseconds), Err(LogError::Rate { .. })));
        let mut empty = log(50);
        empty.yaw_rate_radps.to_mut().fill(f64::NAN);
        let message = prepare(&empty).unwrap_err().to_string();
        assert!(message.contains("50 the yaw rate"), "{message}");
    }
}
