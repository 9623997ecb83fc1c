//! From log files to events whose driver can be identified: by the label `event`, or by the slopes of the drive.

use super::quantity::Quantity;
use super::{LoggedDrive, Need};
use ocmc_core::identification::event::PedalLog;

/// What identification needs of a log.
pub const NEEDS: [Need; 5] = [
    Need { what: "time", any_of: &[Quantity::Time] },
    Need { what: "speed", any_of: &[Quantity::Speed] },
    Need { what: "accelerator pedal", any_of: &[Quantity::Accelerator] },
    Need { what: "brake pedal", any_of: &[Quantity::Brake] },
    Need { what: "slope", any_of: &[Quantity::Grade] },
];

/// Time that an event begins before its slope does, in s.
const BEFORE_S: f64 = 5.0;
/// Time that it goes on behind its slope, in s: the 350 m between the events of the paper, at 70 km/h.
const AFTER_S: f64 = 18.0;

/// The log of one event.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedEvent {
    /// The driver.
    pub driver: String,
    /// The event.
    pub event: String,
    /// Its log.
    pub log: PedalLog,
}

/// The events of a drive, and how many of its rows were dropped because a needed number is missing, or the time repeats.
pub fn events(drive: &LoggedDrive) -> (Vec<LoggedEvent>, usize) {
    let column = |quantity| drive.column(quantity).unwrap_or_default();
    let [time, speed, accelerator, brake, grade] =
        [Quantity::Time, Quantity::Speed, Quantity::Accelerator, Quantity::Brake, Quantity::Grade]
            .map(column);
    let mut rows: Vec<usize> = Vec::with_capacity(time.len());
    for row in 0..drive.rows() {
        let needed = [time, speed, accelerator, brake, grade];
        let there = needed.iter().all(|values| values.get(row).is_some_and(|v| !v.is_nan()));
        let repeats = rows.last().is_some_and(|&last| time[last] == time[row]);
        if there && !repeats {
            rows.push(row);
        }
    }
    let of = |values: &[f64]| rows.iter().map(|&row| values[row]).collect::<Vec<f64>>();
    let known = |quantity| {
        let values = drive.column(quantity).map(of)?;
        values.iter().all(|value| !value.is_nan()).then_some(values)
    };
    let log = PedalLog {
        time_s: of(time),
        speed_mps: of(speed),
        accelerator: of(accelerator),
        brake: of(brake),
        grade: of(grade),
        position_m: known(Quantity::Position),
        gear: known(Quantity::Gear),
    };
    let dropped = drive.rows() - rows.len();
    let named = |event: String, log| LoggedEvent { driver: drive.driver.clone(), event, log };
    let events = if let Some(event) = &drive.event {
        vec![named(event.clone(), log)]
    } else {
        let found = log.slope_events(BEFORE_S, AFTER_S).into_iter();
        found.map(|(event, rows)| named(event, log.part(rows.start, rows.end))).collect()
    };
    (events, dropped)
}
