//! Where something ahead may set the speed of a drive: up to there its driver wants one speed.
//!
//! A driver who comes down from v to v' with the deceleration a begins (v² − v'²) / (2 a) before
//! the place. All places ahead together are a backward sweep, n(x) = min_j [v'_j² + 2 a (x_j − x)],
//! as for the desired speed of a simulated drive: what it allows is below what the truck drives
//! from the place on where a driver may have begun. Taken are limits that fall, curves, and
//! standstills of the log, with the study's laws of drivers: of one who keeps as far below a limit,
//! takes a curve as slowly and brakes as softly as one in a hundred (a judgement).
//!
//! What no column shows (traffic, a crossing, a limit in a log without limits) the speed does: a
//! truck that slows down without power on a road that does not climb, to a speed below the one
//! at which the event began, and not slowly. A controller that has wound up downhill lets the
//! speed fall by less, so that 2 m/s are needed (a judgement).

use super::event::PedalLog;
use ocmc_core::distribution::Quantity;
use ocmc_core::random::Streams;
use ocmc_core::study::Study;
use std::ops::Range;

/// Share of the drivers who brake softer, or drive slower, than is reckoned with.
const SLOWEST: f64 = 0.01;
/// The same in standard deviations.
const SLOWEST_NORMAL: f64 = 2.326348;
/// A limit falls by more than this, in m/s.
const SAME_LIMIT_MPS: f64 = 0.5;
/// Below this speed a truck stands, in m/s.
const STANDS_MPS: f64 = 2.0;
/// A curvature below this is none, in 1/m.
const STRAIGHT_PER_M: f64 = 1e-4;
/// Time over which speed, pedals, slope and curvature are averaged, in s.
const AVERAGE_S: f64 = 1.0;
/// A drop of the speed below that at the start of the event that no controller lets happen, in m/s.
const DROP_MPS: f64 = 2.0;
/// A released accelerator is below this.
const RELEASED: f64 = 0.05;
/// A slope up to this does not slow a truck down.
const LEVEL: f64 = 0.005;
/// Deceleration from which on a truck is slowed down, in m/s², and the time over which it is seen,
/// in s.
const SLOWED_MPS2: f64 = 0.25;
const SEEN_S: f64 = 2.0;
/// So long before it shows in the speed the driver may have begun, in s.
const BEFORE_IT_SHOWS_S: f64 = 3.0;
/// So long behind an event a drop is looked for, in s.
const LOOK_BEHIND_S: f64 = 15.0;

/// Cause of a lower speed ahead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpeedSetter {
    /// A limit that falls.
    Limit,
    /// A curve.
    Curve,
    /// A standstill.
    Standstill,
    /// Something that is in no column.
    Unknown,
}

impl SpeedSetter {
    /// The cause in words.
    pub fn text(self) -> &'static str {
        match self {
            Self::Limit => "a lower limit ahead may set the speed",
            Self::Curve => "a curve ahead may set the speed",
            Self::Standstill => "a standstill ahead may set the speed",
            Self::Unknown => {
                "the truck is slowed down, for a limit, a curve or traffic that the log does not \
                 name"
            }
        }
    }
}

/// The rows of an event in which nothing ahead sets the speed: from where the driver is past what
/// has, up to where something else may.
pub fn until_speed_is_set(drive: &PedalLog, event: &Range<usize>, study: &Study) -> PedalLog {
    let allowed = allowed_speeds(drive, study);
    let speed_mps = averages(&drive.time_s, &drive.speed_mps);
    let is_free = |row: &usize| allowed[*row].0 >= speed_mps[*row] * speed_mps[*row];
    let start = event.clone().find(is_free).unwrap_or(event.start);
    let mut fastest_mps: f64 = 0.0;
    let known = (start..event.end).find_map(|row| {
        fastest_mps = fastest_mps.max(speed_mps[row]);
        let (squared, setter) = allowed[row];
        (squared < fastest_mps * fastest_mps).then_some((row, setter))
    });
    let seen = slowed_from(drive, &speed_mps, &(start..event.end));
    let seen = seen.map(|row| (row, SpeedSetter::Unknown));
    let first = [known, seen].into_iter().flatten().min_by_key(|(row, _)| *row);
    let end = first.map_or(event.end, |(row, _)| row);
    PedalLog { ended_by: first.map(|(_, setter)| setter), ..drive.part(start, end) }
}

/// The speed squared that what lies ahead allows in each row, in m²/s², and what it is that does.
fn allowed_speeds(drive: &PedalLog, study: &Study) -> Vec<(f64, SpeedSetter)> {
    let driver = &study.model().driver;
    let twice_deceleration = 2.0 * low(&driver.speed_change.deceleration_mps2);
    let compliance = low(&driver.speed_limit.compliance);
    let typical = driver.curve_speed.sample(&Streams::new(0, 0), false);
    let spread = libm::hypot(driver.curve_speed.driver_sd, driver.curve_speed.residual_sd);
    let slow = libm::exp(-SLOWEST_NORMAL * spread);
    let curvature = drive.curvature_per_m.as_ref().map(|per_m| averages(&drive.time_s, per_m));
    let position_m = drive.positions_m();
    let (mut node, mut setter) = (f64::INFINITY, SpeedSetter::Unknown);
    let mut allowed = vec![(node, setter); position_m.len()];
    for row in (0..position_m.len()).rev() {
        if let Some(next_m) = position_m.get(row + 1) {
            node += twice_deceleration * (next_m - position_m[row]);
        }
        let mut take = |speed_mps: f64, by: SpeedSetter| {
            if speed_mps * speed_mps < node {
                (node, setter) = (speed_mps * speed_mps, by);
            }
        };
        if let Some(limit_mps) = drive.limit_mps.as_ref().filter(|_| row > 0)
            && limit_mps[row] < limit_mps[row - 1] - SAME_LIMIT_MPS
        {
            take(compliance * limit_mps[row], SpeedSetter::Limit);
        }
        if let Some(per_m) = curvature.as_ref().map(|averages| averages[row])
            && per_m.abs() > STRAIGHT_PER_M
        {
            let speed_mps = typical.speed_mps(1.0 / per_m.abs(), per_m > 0.0, 0.0);
            take(slow * speed_mps, SpeedSetter::Curve);
        }
        if drive.speed_mps[row] < STANDS_MPS {
            take(0.0, SpeedSetter::Standstill);
        }
        allowed[row] = (node, setter);
    }
    allowed
}

/// The row of an event from which on the driver may have wanted another speed, by what the log
/// shows; none where it shows nothing.
fn slowed_from(drive: &PedalLog, speed_mps: &[f64], event: &Range<usize>) -> Option<usize> {
    if event.is_empty() {
        return None;
    }
    let time_s = &drive.time_s;
    let [accelerator, grade] =
        [&drive.accelerator, &drive.grade].map(|values| averages(time_s, values));
    let last_s = time_s[event.end - 1] + LOOK_BEHIND_S;
    let rate_mps2 = |row: usize| {
        let before = time_s.partition_point(|at_s| *at_s < time_s[row] - SEEN_S);
        let span_s = time_s[row] - time_s[before];
        if span_s > 0.0 { (speed_mps[row] - speed_mps[before]) / span_s } else { 0.0 }
    };
    let slowed = |row: &usize| {
        accelerator[*row] < RELEASED
            && grade[*row] < LEVEL
            && speed_mps[*row] < speed_mps[event.start] - DROP_MPS
            && rate_mps2(*row) < -SLOWED_MPS2
    };
    let rows = event.start..time_s.partition_point(|at_s| *at_s <= last_s);
    let shown = rows.clone().find(slowed)?;
    let began = (rows.start..shown).rev().find(|row| rate_mps2(*row) >= -SLOWED_MPS2);
    let began_s = time_s[began.unwrap_or(rows.start)] - BEFORE_IT_SHOWS_S;
    let row = time_s.partition_point(|at_s| *at_s < began_s).max(event.start);
    (row < event.end).then_some(row)
}

/// The value of a law below which one driver in a hundred is.
fn low(quantity: &Quantity) -> f64 {
    let law = match quantity {
        Quantity::Number(value) => return *value,
        Quantity::Law(law) => law,
        Quantity::Levelled(levelled) => &levelled.law,
    };
    law.quantile(SLOWEST).unwrap_or_else(|| law.practical_range().0)
}

/// The mean of each row's surroundings.
fn averages(time_s: &[f64], values: &[f64]) -> Vec<f64> {
    let (mut first, mut end, mut sum) = (0, 0, 0.0);
    let average = |at_s: &f64| {
        while end < time_s.len() && time_s[end] <= at_s + 0.5 * AVERAGE_S {
            sum += values[end];
            end += 1;
        }
        while time_s[first] < at_s - 0.5 * AVERAGE_S {
            sum -= values[first];
            first += 1;
        }
        sum / (end - first) as f64
    };
    time_s.iter().map(average).collect()
}
