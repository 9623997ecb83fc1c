//! Accelerations from logs: windows with the largest change of speed around changes of the limit.

use super::{SpeedChangeError, SpeedChangeOptions, check};

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

/// The acceleration at each change of the limit of a log: its kind, such as `70-to-40` in km/h, and its value, in m/s².
///
/// Rows with a missing speed or limit are passed over, and so are rows with the time of the row before.
///
/// # Errors
/// [`SpeedChangeError`] where the columns do not fit together.
pub fn accelerations(
    log: &SpeedLog,
    options: &SpeedChangeOptions,
) -> Result<Vec<(String, f64)>, SpeedChangeError> {
    check(options)?;
    let wanted = log.time_s.len();
    for (column, length) in [("speed", log.speed_mps.len()), ("limit", log.limit_mps.len())] {
        if length != wanted {
            return Err(SpeedChangeError::UnequalColumns { column, length, wanted });
        }
    }
    let seen = |k: &usize| {
        [log.time_s[*k], log.speed_mps[*k], log.limit_mps[*k]].iter().all(|value| value.is_finite())
    };
    let mut rows: Vec<usize> = (0..wanted).filter(seen).collect();
    // a second row of one time tells nothing new
    rows.dedup_by_key(|row| log.time_s[*row]);
    for pair in rows.windows(2) {
        if !(log.time_s[pair[1]] > log.time_s[pair[0]]) {
            return Err(SpeedChangeError::Time { row: pair[1] + 1, time_s: log.time_s[pair[1]] });
        }
    }
    let changes: Vec<usize> = (1..rows.len())
        .filter(|&k| {
            (log.limit_mps[rows[k]] - log.limit_mps[rows[k - 1]]).abs() > SMALLEST_CHANGE_MPS
        })
        .collect();
    let time = |k: usize| log.time_s[rows[k]];
    let mut found = Vec::new();
    for (i, &k) in changes.iter().enumerate() {
        // not into what belongs to the sign before or behind
        let begin = (time(k) - options.before_s).max(if i > 0 {
            time(changes[i - 1])
        } else {
            f64::NEG_INFINITY
        });
        let end = (time(k) + options.after_s)
            .min(changes.get(i + 1).map_or(f64::INFINITY, |&next| time(next)));
        let (from, to) = (log.limit_mps[rows[k - 1]], log.limit_mps[rows[k]]);
        let near: Vec<(f64, f64)> = rows
            .iter()
            .map(|&row| (log.time_s[row], log.speed_mps[row]))
            .filter(|point| (begin..=end).contains(&point.0))
            .collect();
        if let Some(acceleration) = largest_window(&near, options.window_s, to > from) {
            found.push((format!("{:.0}-to-{:.0}", 3.6 * from, 3.6 * to), acceleration));
        }
    }
    Ok(found)
}

/// Mean acceleration over the window in which speed rises (or falls) most; none where the points are shorter.
fn largest_window(points: &[(f64, f64)], window_s: f64, rising: bool) -> Option<f64> {
    let mut best: Option<f64> = None;
    let mut behind = 0;
    for (k, &(time, speed)) in points.iter().enumerate() {
        let until = time + window_s;
        behind = behind.max(k);
        while behind < points.len() && points[behind].0 < until {
            behind += 1;
        }
        let Some(&(later, fast)) = points.get(behind) else { break };
        let (sooner, slow) = points[behind.max(1) - 1];
        let end = if later > until && behind > k {
            slow + (fast - slow) * (until - sooner) / (later - sooner)
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

    #[test]
    fn windows_of_a_log() {
        // 70 km/h, down to 40 at -0.8 m/s2 before the sign at 100 s, up to 70 at 0.5 m/s2 behind the sign at 200 s
        let (fast, slow) = (70.0 / 3.6, 40.0 / 3.6);
        let time_s: Vec<f64> = (0..3000).map(|k| 0.1 * f64::from(k)).collect();
        let speed = |t: f64| {
            if t < 200.0 {
                (fast - 0.8 * (t - 90.0).max(0.0)).max(slow)
            } else {
                (slow + 0.5 * (t - 200.0)).min(fast)
            }
        };
        let speed_mps: Vec<f64> = time_s.iter().map(|t| speed(*t)).collect();
        let limit_mps: Vec<f64> =
            time_s.iter().map(|t| if (100.0..200.0).contains(t) { slow } else { fast }).collect();
        let log = SpeedLog { time_s: &time_s, speed_mps: &speed_mps, limit_mps: &limit_mps };
        let found = accelerations(&log, &SpeedChangeOptions::default()).unwrap();
        assert_eq!(found.len(), 2);
        for ((category, value), (name, wanted)) in
            found.iter().zip([("70-to-40", -0.8), ("40-to-70", 0.5)])
        {
            assert_eq!(category, name);
            assert!((value - wanted).abs() < 1e-9, "{value}");
        }
        // rows at any rate, with gaps
        let keep: Vec<usize> = (0..3000).filter(|k| k % 7 != 3 && k % 4 != 1).collect();
        let take = |values: &[f64]| keep.iter().map(|&k| values[k]).collect::<Vec<f64>>();
        let (t, v, l) = (take(&time_s), take(&speed_mps), take(&limit_mps));
        let log = SpeedLog { time_s: &t, speed_mps: &v, limit_mps: &l };
        let thin = accelerations(&log, &SpeedChangeOptions::default()).unwrap();
        assert!(thin.iter().zip(&found).all(|(a, b)| (a.1 - b.1).abs() < 1e-9));
        let backwards =
            SpeedLog { time_s: &[0.0, 1.0, 0.5], speed_mps: &[1.0; 3], limit_mps: &[1.0; 3] };
        assert!(matches!(
            accelerations(&backwards, &SpeedChangeOptions::default()),
            Err(SpeedChangeError::Time { row: 3, .. })
        ));
    }
}
