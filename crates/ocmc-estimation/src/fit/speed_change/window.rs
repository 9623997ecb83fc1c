//! Accelerations from logs: windows with the largest change of speed around changes of the limit.

use super::{SpeedChangeError, SpeedChangeOptions, check};
use crate::log::TripLog;
use crate::log::signal::{LIMITS_MPS, LogCounts, Piece, prepare};

/// Smallest difference of two limits, in m/s.
const SMALLEST_CHANGE_MPS: f64 = 0.1;

/// A time series with speed limits, as columns of equal length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLog<'a> {
    /// Time, rising, in s.
    pub time_s: &'a [f64],
    /// Speed, in m/s.
    pub speed_mps: &'a [f64],
    /// Speed limit, in m/s.
    pub limit_mps: &'a [f64],
}

/// The speed changes of a log, and what was not used of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoggedChanges {
    /// Kind of each change of the limit, such as `70-to-40` in km/h, and the acceleration, in m/s².
    pub changes: Vec<(String, f64)>,
    /// Rows.
    pub rows: LogCounts,
    /// Rows whose limit is missing or impossible: the one before holds.
    pub without_limit: usize,
    /// Changes of the limit around which no window without a gap was logged.
    pub without_window: usize,
}

/// A change of the limit.
struct Change {
    time_s: f64,
    from_mps: f64,
    to_mps: f64,
}

/// The acceleration at each change of the limit of a log. No window reaches over a gap.
///
/// # Errors
/// [`SpeedChangeError`] where an option is out of its range or the log cannot be used.
pub fn accelerations(
    log: &SpeedLog,
    options: &SpeedChangeOptions,
) -> Result<LoggedChanges, SpeedChangeError> {
    check(options)?;
    let (pieces, rows) = prepare(&TripLog {
        time_s: log.time_s.into(),
        speed_mps: log.speed_mps.into(),
        yaw_rate_radps: vec![0.0; log.time_s.len()].into(),
        limit_mps: Some(log.limit_mps.into()),
        ..TripLog::default()
    })?;
    let mut logged = LoggedChanges { rows, ..LoggedChanges::default() };
    let signs = changes(log.limit_mps, &pieces, &mut logged.without_limit);
    for (k, sign) in signs.iter().enumerate() {
        // not into what belongs to the sign before or behind
        let before_s = k.checked_sub(1).map_or(f64::NEG_INFINITY, |before| signs[before].time_s);
        let behind_s = signs.get(k + 1).map_or(f64::INFINITY, |behind| behind.time_s);
        let begin_s = before_s.max(sign.time_s - options.before_s);
        let end_s = behind_s.min(sign.time_s + options.after_s);
        let rising = sign.to_mps > sign.from_mps;
        let first =
            pieces.partition_point(|piece| !(piece.time_s[piece.time_s.len() - 1] >= begin_s));
        let near = pieces[first..].iter().take_while(|piece| piece.time_s[0] <= end_s);
        let windows = near.filter_map(|piece| {
            let from = piece.time_s.partition_point(|time_s| *time_s < begin_s);
            let to = piece.time_s.partition_point(|time_s| *time_s <= end_s);
            largest_window(
                &piece.time_s[from..to],
                &piece.speed_mps[from..to],
                options.window_s,
                rising,
            )
        });
        match windows.reduce(|a, b| if rising { a.max(b) } else { a.min(b) }) {
            Some(acceleration) => {
                let kind = format!("{:.0}-to-{:.0}", 3.6 * sign.from_mps, 3.6 * sign.to_mps);
                logged.changes.push((kind, acceleration));
            }
            None => logged.without_window += 1,
        }
    }
    Ok(logged)
}

/// Where the limit changes; rows without a possible one are counted.
fn changes(limit_mps: &[f64], pieces: &[Piece], without_limit: &mut usize) -> Vec<Change> {
    let mut changes = Vec::new();
    let mut holds_mps = f64::NAN;
    for piece in pieces {
        for (&row, &time_s) in piece.row.iter().zip(&piece.time_s) {
            let to_mps = limit_mps[row];
            if !(LIMITS_MPS[0]..=LIMITS_MPS[1]).contains(&to_mps) {
                *without_limit += 1;
                continue;
            }
            if (to_mps - holds_mps).abs() > SMALLEST_CHANGE_MPS {
                changes.push(Change { time_s, from_mps: holds_mps, to_mps });
            }
            holds_mps = to_mps;
        }
    }
    changes
}

/// Mean acceleration over the window in which speed rises (or falls) most; none where the rows span
/// less.
fn largest_window(time_s: &[f64], speed_mps: &[f64], window_s: f64, rising: bool) -> Option<f64> {
    let mut best: Option<f64> = None;
    let mut behind = 0;
    for (k, (time, speed)) in time_s.iter().zip(speed_mps).enumerate() {
        let until = time + window_s;
        behind = behind.max(k);
        while behind < time_s.len() && time_s[behind] < until {
            behind += 1;
        }
        let (Some(&later), Some(&fast)) = (time_s.get(behind), speed_mps.get(behind)) else {
            break;
        };
        let before = behind.max(1) - 1;
        let end = if later > until && behind > k {
            let part = (until - time_s[before]) / (later - time_s[before]);
            speed_mps[before] + (fast - speed_mps[before]) * part
        } else {
            fast
        };
        let acceleration = (end - speed) / window_s;
        let better =
            best.is_none_or(|best| if rising { acceleration > best } else { acceleration < best });
        if better {
            best = Some(acceleration);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::signal::LogError;

    /// 70 km/h, down to 40 at -0.8 m/s² before the sign at 100 s, up to 70 at 0.5 m/s² behind the
    /// sign at 200 s; ten rows a second.
    fn drive() -> [Vec<f64>; 3] {
        let (fast, slow) = (70.0 / 3.6, 40.0 / 3.6);
        let time_s: Vec<f64> = (0..3000).map(|k| 0.1 * f64::from(k)).collect();
        let speed = |t: f64| {
            if t < 200.0 {
                (fast - 0.8 * (t - 90.0).max(0.0)).max(slow)
            } else {
                (slow + 0.5 * (t - 200.0)).min(fast)
            }
        };
        let speed_mps = time_s.iter().map(|t| speed(*t)).collect();
        let limit_mps =
            time_s.iter().map(|t| if (100.0..200.0).contains(t) { slow } else { fast }).collect();
        [time_s, speed_mps, limit_mps]
    }

    fn found([time_s, speed_mps, limit_mps]: &[Vec<f64>; 3]) -> LoggedChanges {
        let log = SpeedLog { time_s, speed_mps, limit_mps };
        accelerations(&log, &SpeedChangeOptions::default()).unwrap()
    }

    #[test]
    fn windows_of_a_log() {
        let log = drive();
        let all = found(&log);
        assert_eq!((all.rows.used, all.without_limit, all.without_window), (3000, 0, 0));
        assert_eq!(all.changes.len(), 2);
        for ((category, value), (name, wanted)) in
            all.changes.iter().zip([("70-to-40", -0.8), ("40-to-70", 0.5)])
        {
            assert_eq!(category, name);
            assert!((value - wanted).abs() < 1e-9, "{value}");
        }
        // rows at any rate, with gaps
        let keep: Vec<usize> = (0..3000).filter(|k| k % 7 != 3 && k % 4 != 1).collect();
        let thin = log.map(|values| keep.iter().map(|&k| values[k]).collect::<Vec<f64>>());
        let thin = found(&thin).changes;
        assert!(thin.iter().zip(&all.changes).all(|(a, b)| (a.1 - b.1).abs() < 1e-9));
    }

    #[test]
    fn what_is_not_used_is_counted() {
        let mut log = drive();
        log[1][5] = f64::NAN;
        log[0][6] = f64::NAN;
        log[0][8] = log[0][7];
        // a map that knows no limit, and one that says so by 255 km/h: the limit before holds
        log[2][300] = f64::NAN;
        log[2][301] = 255.0 / 3.6;
        let some = found(&log);
        let rows = &some.rows;
        assert_eq!((rows.missing_speed, rows.missing_time, rows.repeated_time), (1, 1, 1));
        assert_eq!((some.without_limit, some.without_window, some.changes.len()), (2, 0, 2));
        // nothing was logged around the second sign, but 2 s on either side
        for speed in &mut log[1][1710..1980] {
            *speed = f64::NAN;
        }
        for speed in &mut log[1][2020..2400] {
            *speed = f64::NAN;
        }
        let some = found(&log);
        assert_eq!((some.without_window, some.changes.len()), (0, 2));
        for rows in [1980..1990, 2008..2020] {
            log[1][rows].fill(f64::NAN);
        }
        let some = found(&log);
        assert_eq!((some.without_window, some.changes.len()), (1, 1));
    }

    #[test]
    fn time_that_runs_backwards_is_refused() {
        let mut log = drive();
        log[0].swap(10, 20);
        let [time_s, speed_mps, limit_mps] = &log;
        let log = SpeedLog { time_s, speed_mps, limit_mps };
        let error = accelerations(&log, &SpeedChangeOptions::default()).unwrap_err();
        assert!(matches!(
            error,
            SpeedChangeError::Log(LogError::Backwards { count: 2, row: 11, .. })
        ));
    }
}
