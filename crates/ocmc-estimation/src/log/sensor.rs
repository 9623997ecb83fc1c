//! Effects of the sensors: the gyro's bias, from standstill, and the lag of the speed behind the
//! gyro, by correlation.
//!
//! A vehicle at rest does not turn, so the median yaw rate at standstill is the bias. A satellite
//! receiver reports speed and course late by the same time, so the lag that makes the rate of the
//! course most like the gyro's yaw rate is the lag of the speed, too. The maximum of the
//! correlation is refined by a parabola.
//!
//! Without a gyro the course itself shows how the vehicle turns ([`yaw_rate_of_course`]).

use super::TripLog;
use super::signal::{Piece, median};
use crate::moments;
use std::f64::consts::PI;
use std::ops::Range;

/// Slower than this, in m/s, a vehicle stands.
pub const STANDSTILL_MPS: f64 = 0.3;
/// Shortest standstill in all that gives a bias, in s.
const SHORTEST_STANDSTILL_S: f64 = 5.0;
/// Largest lag that is looked for, in s.
const LARGEST_LAG_S: f64 = 4.0;
/// Step of the lags and of the resampled signals, in s.
const LAG_STEP_S: f64 = 0.1;
/// Slower than this, in m/s, the course of a receiver is noise.
const COURSE_FROM_MPS: f64 = 3.0;
/// A step of the course that is a turn and no noise, in rad: 2°.
const TURNING_STEP_RAD: f64 = 2.0 / 180.0 * PI;
/// A shorter way between positions tells no course, in m.
const MOVED_M: f64 = 2.0;
/// Length of a degree of latitude, in m: the mean radius of the Earth (IUGG).
const METRES_A_DEGREE: f64 = 6_371_008.8 * PI / 180.0;
/// A smaller correlation determines no lag.
const SMALLEST_CORRELATION: f64 = 0.5;
/// Turning time that a lag needs, in s, and the yaw rate from which it counts, in rad/s.
const SHORTEST_TURNING_S: f64 = 10.0;
const TURNING_RADPS: f64 = 0.05;

/// Median yaw rate at standstill, in rad/s; none where the vehicle never stands long enough.
pub fn gyro_bias_radps(pieces: &[Piece]) -> Option<f64> {
    let mut still = Vec::new();
    let mut time_s = 0.0;
    for piece in pieces {
        for k in 1..piece.time_s.len() {
            if piece.speed_mps[k - 1].max(piece.speed_mps[k]) < STANDSTILL_MPS {
                still.push(piece.yaw_rate_radps[k]);
                time_s += piece.time_s[k] - piece.time_s[k - 1];
            }
        }
    }
    (time_s >= SHORTEST_STANDSTILL_S).then(|| median(still))
}

/// Time by which the speed comes later than the yaw rate, in s, and the correlation there; none
/// where the log has no course or too little of it.
pub fn speed_lag_s(log: &TripLog, pieces: &[Piece]) -> Option<(f64, f64)> {
    let course = log.course_rad.as_ref()?;
    let pairs: Vec<_> = pieces.iter().filter_map(|piece| resampled(piece, course)).collect();
    let turning =
        pairs.iter().flat_map(|(yaw, _)| yaw).filter(|yaw| yaw.abs() > TURNING_RADPS).count();
    if (turning as f64) * LAG_STEP_S < SHORTEST_TURNING_S {
        return None;
    }
    let most = libm::round(LARGEST_LAG_S / LAG_STEP_S) as usize;
    let early = (1..=most).rev().map(|lag| correlation(&pairs, lag, 0));
    let late = (0..=most).map(|lag| correlation(&pairs, 0, lag));
    let correlations: Vec<f64> = early.chain(late).collect();
    let best =
        (1..correlations.len() - 1).max_by(|&a, &b| correlations[a].total_cmp(&correlations[b]))?;
    let [before, at, after] = [correlations[best - 1], correlations[best], correlations[best + 1]];
    // a maximum at the edge of the range is none
    if !(at >= SMALLEST_CORRELATION && at >= before && at >= after) {
        return None;
    }
    let bend = before - 2.0 * at + after;
    let shift = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    Some(((best as f64 - most as f64 + shift) * LAG_STEP_S, at))
}

/// Yaw rate and rate of the course to the left on an even grid; the course where the vehicle is
/// fast enough.
fn resampled(piece: &Piece, course: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
    let n = piece.time_s.len();
    let start_s = piece.time_s[0];
    let steps = libm::floor((piece.time_s[n - 1] - start_s) / LAG_STEP_S) as usize;
    let mut yaw = Vec::with_capacity(steps);
    let mut turn = Vec::with_capacity(steps);
    let mut k = 0;
    for step in 0..steps {
        let time_s = start_s + (step as f64 + 0.5) * LAG_STEP_S;
        while k + 2 < n && piece.time_s[k + 1] < time_s {
            k += 1;
        }
        let dt = piece.time_s[k + 1] - piece.time_s[k];
        let part = (time_s - piece.time_s[k]) / dt;
        yaw.push(piece.yaw_rate_radps[k] * (1.0 - part) + piece.yaw_rate_radps[k + 1] * part);
        let (from, to) = (course[piece.row[k]], course[piece.row[k + 1]]);
        let fast = piece.speed_mps[k].min(piece.speed_mps[k + 1]) > COURSE_FROM_MPS;
        // the course is clockwise
        let rate = if fast { -wrapped(to - from) / dt } else { 0.0 };
        turn.push(if rate.is_finite() { rate } else { 0.0 });
    }
    (steps > 0).then_some((yaw, turn))
}

/// The yaw rate that a receiver's course gives, in rad/s, row by row: the change of the course from
/// the update before to the one behind, over the time between. Receivers update slower than logs
/// are written: rows that repeat an update are interpolated.
///
/// Slower than 3 m/s the course is noise and the vehicle counts as going straight. NaN where
/// course, time or speed are missing.
pub fn yaw_rate_of_course(time_s: &[f64], speed_mps: &[f64], course_rad: &[f64]) -> Vec<f64> {
    let rows = time_s.len().min(speed_mps.len()).min(course_rad.len());
    let known = |k: usize| {
        time_s[k].is_finite() && course_rad[k].is_finite() && speed_mps[k] > COURSE_FROM_MPS
    };
    let slow = |k: usize| speed_mps[k] <= COURSE_FROM_MPS;
    let mut rates: Vec<f64> = (0..rows).map(|k| if slow(k) { 0.0 } else { f64::NAN }).collect();
    let hold = rows_of_an_update(course_rad);
    let rows: Vec<usize> = (0..rows).collect();
    for run in rows.chunk_by(|a, b| known(*a) == known(*b)).filter(|run| known(run[0])) {
        run_rates(&mut rates, run[0]..run[0] + run.len(), hold, time_s, course_rad);
    }
    rates
}

/// Course over ground of a vehicle, in rad, clockwise from north, from its latitudes and
/// longitudes, in degrees: the direction from the last position that is 2 m or more back
/// (judgement: what a satellite receiver at rest wanders). NaN until the vehicle has moved so far,
/// and without a position.
pub fn course_of_positions(latitude_deg: &[f64], longitude_deg: &[f64]) -> Vec<f64> {
    let mut course_rad = f64::NAN;
    let mut last: Option<(f64, f64)> = None;
    let positions = latitude_deg.iter().zip(longitude_deg);
    let courses = positions.map(|(&latitude, &longitude)| {
        if !(latitude.is_finite() && longitude.is_finite()) {
            return f64::NAN;
        }
        let Some((from_latitude, from_longitude)) = last else {
            last = Some((latitude, longitude));
            return course_rad;
        };
        let east_deg = wrapped((longitude - from_longitude).to_radians()).to_degrees();
        let north_m = (latitude - from_latitude) * METRES_A_DEGREE;
        let east_m = east_deg * METRES_A_DEGREE * libm::cos(latitude.to_radians());
        if libm::hypot(east_m, north_m) >= MOVED_M {
            course_rad = libm::atan2(east_m, north_m);
            last = Some((latitude, longitude));
        }
        course_rad
    });
    courses.collect()
}

/// Rows that repeat one update of the course, itself among them: the median where the course turns
/// fast.
fn rows_of_an_update(course_rad: &[f64]) -> usize {
    let mut held = Vec::new();
    let mut since = 0;
    for k in 1..course_rad.len() {
        since += 1;
        let change = wrapped(course_rad[k] - course_rad[k - 1]).abs();
        if change > TURNING_STEP_RAD {
            held.push(since as f64);
        }
        if change != 0.0 {
            since = 0;
        }
    }
    if held.is_empty() { 1 } else { (median(held) as usize).max(1) }
}

/// Yaw rates of consecutive rows with a course.
fn run_rates(
    rates: &mut [f64],
    run: Range<usize>,
    hold: usize,
    time_s: &[f64],
    course_rad: &[f64],
) {
    // the rows that bring an update: where the course changes, and at its beat before that
    let mut updates = vec![run.start];
    for k in run.start + 1..run.end {
        if course_rad[k] != course_rad[k - 1] {
            let last = updates[updates.len() - 1];
            updates.extend((1..=(k - last - 1) / hold).rev().map(|beats| k - beats * hold));
            updates.push(k);
        }
    }
    let last = updates[updates.len() - 1];
    updates.extend((last..run.end).step_by(hold).skip(1));
    // the course is clockwise
    let rate = |from: usize, to: usize| {
        -wrapped(course_rad[to] - course_rad[from]) / (time_s[to] - time_s[from])
    };
    let last = updates.len() - 1;
    let at = |k: usize| {
        let (from, to) = (updates[k.saturating_sub(1)], updates[(k + 1).min(last)]);
        if time_s[to] > time_s[from] { rate(from, to) } else { 0.0 }
    };
    let mut k = 0;
    for row in run {
        while k < last && updates[k + 1] <= row {
            k += 1;
        }
        let next = (k + 1).min(last);
        let (from_s, to_s) = (time_s[updates[k]], time_s[updates[next]]);
        let part = if to_s > from_s { (time_s[row] - from_s) / (to_s - from_s) } else { 0.0 };
        rates[row] = at(k) * (1.0 - part) + at(next) * part;
    }
}

/// An angle between −π and π.
fn wrapped(angle: f64) -> f64 {
    angle - 2.0 * PI * libm::round(angle / (2.0 * PI))
}

/// Correlation of the yaw rate, from a step on, with the rate of the course, from another step on.
fn correlation(pairs: &[(Vec<f64>, Vec<f64>)], yaw_from: usize, turn_from: usize) -> f64 {
    let shifted = pairs.iter().flat_map(|(yaw, turn)| {
        yaw.iter().copied().skip(yaw_from).zip(turn.iter().copied().skip(turn_from))
    });
    moments::correlation(shifted).map_or(0.0, |(correlation, _)| correlation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::signal::prepare;

    /// A drive with turns of 3 s each 20 s, whose course comes `lag_s` late, in some steps.
    fn drive(rate_hz: f64, lag_s: f64) -> TripLog<'static> {
        let rows = (600.0 * rate_hz) as usize;
        let yaw = |t: f64| {
            let phase = t % 20.0;
            let side = if t % 40.0 < 20.0 { 1.0 } else { -1.0 };
            if phase < 3.0 { side * 0.2 * (PI * phase / 3.0).sin() } else { 0.0 }
        };
        // the heading is the integral of the yaw rate
        let heading = |t: f64| {
            (0..(t.max(0.0) * 100.0) as usize).map(|k| 0.01 * yaw(k as f64 * 0.01)).sum::<f64>()
        };
        let time_s: Vec<f64> = (0..rows).map(|k| k as f64 / rate_hz).collect();
        TripLog {
            speed_mps: vec![10.0; rows].into(),
            yaw_rate_radps: time_s.iter().map(|t| yaw(*t)).collect(),
            course_rad: Some(
                time_s.iter().map(|t| (7.0 - heading(t - lag_s)) % (2.0 * PI)).collect(),
            ),
            time_s: time_s.into(),
            ..TripLog::default()
        }
    }

    #[test]
    fn the_lag_of_the_receiver_is_found() {
        for (rate_hz, lag_s, tolerance_s) in
            [(10.0, 0.7, 0.05), (1.0, 1.3, 0.25), (5.0, -0.4, 0.07)]
        {
            let log = drive(rate_hz, lag_s);
            let (pieces, _) = prepare(&log).unwrap();
            let (estimate_s, correlation) = speed_lag_s(&log, &pieces).unwrap();
            assert!(
                (estimate_s - lag_s).abs() < tolerance_s,
                "{rate_hz} Hz: {estimate_s}, {lag_s}"
            );
            assert!(correlation > 0.8);
        }
    }

    #[test]
    fn no_lag_without_turns_or_course() {
        let mut log = drive(10.0, 0.7);
        log.yaw_rate_radps.to_mut().fill(0.0);
        let (pieces, _) = prepare(&log).unwrap();
        assert_eq!(speed_lag_s(&log, &pieces), None);
        log.course_rad = None;
        assert_eq!(speed_lag_s(&log, &pieces), None);
    }

    #[test]
    fn the_bias_is_the_median_at_standstill() {
        let mut log = drive(10.0, 0.0);
        for yaw in log.yaw_rate_radps.to_mut() {
            *yaw += 0.01;
        }
        let (pieces, _) = prepare(&log).unwrap();
        assert_eq!(gyro_bias_radps(&pieces), None);
        log.speed_mps.to_mut()[50..120].fill(0.0);
        log.yaw_rate_radps.to_mut()[60] = 5.0; // a knock on the sensor
        let (pieces, _) = prepare(&log).unwrap();
        assert!((gyro_bias_radps(&pieces).unwrap() - 0.01).abs() < 1e-9);
    }

    #[test]
    fn the_course_alone_tells_the_yaw_rate() {
        // updates of 2 Hz in a log of 10 Hz; the course of a turn of 0.2 rad/s to the left that
        // begins at 20 s
        let time_s: Vec<f64> = (0..400).map(|k| 0.1 * f64::from(k)).collect();
        let heading = |t: f64| 0.2 * (t - 20.0).clamp(0.0, 10.0);
        let course: Vec<f64> = time_s
            .iter()
            .map(|t| (6.0 - heading((2.0 * t + 1e-9).floor() / 2.0)).rem_euclid(2.0 * PI))
            .collect();
        let mut speed = vec![10.0; 400];
        speed[350..360].fill(1.0);
        let mut course_with_hole = course.clone();
        course_with_hole[100] = f64::NAN;
        let rates = yaw_rate_of_course(&time_s, &speed, &course_with_hole);
        for (t, rate) in time_s.iter().zip(&rates) {
            let (inside, outside) = ((20.6..29.4).contains(t), !(19.0..31.0).contains(t));
            if inside {
                assert!((rate - 0.2).abs() < 1e-9, "{t}: {rate}");
            } else if outside && *t != time_s[100] {
                assert!(rate.abs() < 1e-9, "{t}: {rate}");
            }
        }
        assert!(rates[100].is_nan());
        // what was turned is all there
        let turned: f64 = rates.iter().filter(|rate| !rate.is_nan()).map(|rate| 0.1 * rate).sum();
        assert!((turned - 2.0).abs() < 0.02, "{turned}");
    }
}
