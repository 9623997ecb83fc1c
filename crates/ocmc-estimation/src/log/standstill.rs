//! Where a vehicle stood, and for how long.
//!
//! A standstill is a time below 0.3 m/s of at least 1 s; where the speed crosses this between two
//! rows the moment is interpolated. Standstills less than 30 m of way apart are one stop, whose
//! times add up: a queue that creeps forward is one (judgement). A log shows that a vehicle stood,
//! not why: a sign, a light and a queue look alike.

use super::sensor::STANDSTILL_MPS;
use serde::Serialize;

/// Shortest standstill, in s.
const SHORTEST_S: f64 = 1.0;
/// Standstills closer than this are one stop, in m.
const ONE_STOP_M: f64 = 30.0;

/// A place at which a vehicle stood.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Standstill {
    /// Where, in m.
    pub position_m: f64,
    /// How long, in s.
    pub duration_s: f64,
}

/// The stops of a drive; times, speeds and positions by row. Standing at the start or at the end of
/// the drive is none. `unseen` says of a row whether nothing was logged before it for so long that
/// only the position shows what happened.
pub fn standstills(
    time_s: &[f64],
    speed_mps: &[f64],
    position_m: &[f64],
    unseen: &[bool],
) -> Vec<Standstill> {
    let stands = |k: usize| speed_mps[k] < STANDSTILL_MPS;
    let mut stops: Vec<Standstill> = Vec::new();
    let rows: Vec<usize> = (0..time_s.len()).collect();
    for run in rows.chunk_by(|a, b| stands(*a) == stands(*b)) {
        let (first, last) = (run[0], run[run.len() - 1]);
        if !stands(first) || first == 0 || last + 1 == rows.len() {
            continue;
        }
        // moment at which the speed passes the limit between two rows; an interval without rows was
        // stood through
        let crossing = |fast: usize, slow: usize| {
            let part = (speed_mps[fast] - STANDSTILL_MPS) / (speed_mps[fast] - speed_mps[slow]);
            time_s[fast] + part * (time_s[slow] - time_s[fast])
        };
        let start_s = if unseen[first] { time_s[first - 1] } else { crossing(first - 1, first) };
        let end_s = if unseen[last + 1] { time_s[last + 1] } else { crossing(last + 1, last) };
        let duration_s = end_s - start_s;
        if duration_s < SHORTEST_S {
            continue;
        }
        let position_m = position_m[first];
        match stops.last_mut() {
            Some(before) if position_m - before.position_m < ONE_STOP_M => {
                before.position_m = position_m;
                before.duration_s += duration_s;
            }
            _ => stops.push(Standstill { position_m, duration_s }),
        }
    }
    let end_m = position_m.last().copied().unwrap_or(0.0);
    stops.retain(|stop| stop.position_m >= ONE_STOP_M && stop.position_m <= end_m - ONE_STOP_M);
    stops
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of 10 Hz from pieces of (duration, speed at the end), linear between.
    fn drive(pieces: &[(f64, f64)]) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let (mut time_s, mut speed_mps, mut position_m) = (vec![0.0], vec![10.0], vec![0.0]);
        for &(duration_s, end_mps) in pieces {
            let (rows, start_mps) =
                ((duration_s * 10.0).round() as usize, speed_mps[speed_mps.len() - 1]);
            for k in 1..=rows {
                let speed = start_mps + (end_mps - start_mps) * k as f64 / rows as f64;
                let before = speed_mps[speed_mps.len() - 1];
                time_s.push(time_s[time_s.len() - 1] + 0.1);
                position_m.push(position_m[position_m.len() - 1] + 0.05 * (speed + before));
                speed_mps.push(speed);
            }
        }
        (time_s, speed_mps, position_m)
    }

    #[test]
    fn a_stop_has_its_place_and_its_time() {
        let (time, speed, way) =
            drive(&[(60.0, 10.0), (10.0, 0.0), (7.0, 0.0), (10.0, 10.0), (60.0, 10.0)]);
        let stops = standstills(&time, &speed, &way, &vec![false; time.len()]);
        // 650 m; below 0.3 m/s for 0.3 s on either side
        assert_eq!(stops.len(), 1);
        assert!((stops[0].position_m - 650.0).abs() < 0.1, "{stops:?}");
        assert!((stops[0].duration_s - 7.6).abs() < 1e-6, "{stops:?}");
    }

    #[test]
    fn a_creeping_queue_is_one_stop_and_the_ends_are_none() {
        let (time, speed, way) = drive(&[
            (0.1, 0.0),
            (5.0, 0.0),
            (10.0, 10.0),
            (60.0, 10.0),
            (10.0, 0.0),
            (4.0, 0.0),
            (2.0, 2.0),
            (2.0, 0.0),
            (6.0, 0.0),
            (10.0, 10.0),
            (60.0, 10.0),
            (10.0, 0.0),
            (9.0, 0.0),
        ]);
        let stops = standstills(&time, &speed, &way, &vec![false; time.len()]);
        assert_eq!(stops.len(), 1, "{stops:?}");
        // 4 s and 6 s, and what they take below 0.3 m/s: 0.3 s at 1 m/s², four times
        assert!((stops[0].duration_s - 11.2).abs() < 1e-6, "{stops:?}");
    }

    #[test]
    fn a_gap_that_was_stood_through_counts() {
        let time = [0.0, 10.0, 20.0, 25.0, 25.1, 60.0];
        let speed = [10.0, 10.0, 1.2, 0.0, 1.0, 10.0];
        let way = [0.0, 100.0, 150.0, 150.0, 150.1, 400.0];
        let unseen = [false, false, false, true, false, false];
        let stops = standstills(&time, &speed, &way, &unseen);
        // 5 s, and 0.03 s until 0.3 m/s
        assert_eq!(stops.len(), 1);
        assert!((stops[0].duration_s - 5.03).abs() < 1e-9, "{stops:?}");
    }
}
