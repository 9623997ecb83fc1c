//! Where trips end in a log that goes on: at the ignition, or at a standstill that the reader calls
//! a pause. A time without rows alone ends no trip: a receiver may be lost on the way.

use super::{LoggedTrip, Words};
use crate::intake::Finding;
use crate::intake::table::Quantity;
use crate::number_text::{count_of, rounded};
use ocmc_core::operating_cycle::road::route_geometry::Path2d;
use std::ops::Range;

/// Way within which a vehicle that pauses stays, in m (judgement: a receiver wanders, and a truck
/// is moved at a ramp).
const STAYS_WITHIN_M: f64 = 150.0;
/// Speed above which a vehicle moves, where nothing tells its place, in m/s.
const MOVES_MPS: f64 = 0.5;
/// Fewest rows of a trip.
const FEWEST: usize = 3;
/// Words for an ignition that is on and off.
const ON: [&str; 6] = ["on", "true", "1", "an", "ein", "yes"];
const OFF: [&str; 5] = ["off", "false", "0", "aus", "no"];

/// The trips of a drive whose rows no label parts, and what is said of them. Without an ignition
/// and without a pause, in s, the drive is one trip.
pub(super) fn split(drive: LoggedTrip, pause_s: Option<f64>) -> (Vec<LoggedTrip>, Option<Finding>) {
    let by_ignition = ignition(&drive);
    let trips = match (&by_ignition, pause_s) {
        (None, None) => return (vec![drive], None),
        (Some(trips), None) => trips.clone(),
        (None, Some(pause_s)) => without_pauses(&drive, 0..drive.rows(), pause_s),
        (Some(trips), Some(pause_s)) => {
            let parts = trips.iter().map(|trip| without_pauses(&drive, trip.clone(), pause_s));
            parts.flatten().collect()
        }
    };
    let (kept, short): (Vec<Range<usize>>, Vec<Range<usize>>) =
        trips.into_iter().partition(|trip| trip.len() >= FEWEST);
    let by = match (by_ignition, pause_s) {
        (Some(_), None) => "the ignition".to_owned(),
        (None, Some(s)) => format!("pauses of {} min and more", rounded(s / 60.0)),
        _ => format!("the ignition, and pauses of {} min", rounded(pause_s.unwrap_or(0.0) / 60.0)),
    };
    let left_out = match short.len() {
        0 => String::new(),
        some => format!("; {} of fewer than {FEWEST} rows left out", count_of(some as u64, "trip")),
    };
    let count = kept.len();
    let text = format!("{} by {by}{left_out}", count_of(count as u64, "trip"));
    let finding = Finding::noted("trip-ends", [count as f64, 1.0], text, "");
    let several = count > 1;
    let trips = kept.into_iter().enumerate().map(|(k, rows)| {
        let name = if several { format!("{} {}", drive.drive, k + 1) } else { drive.drive.clone() };
        part(&drive, rows, name)
    });
    (trips.collect(), Some(finding))
}

/// The rows between switching on and off; none without a word on the ignition.
fn ignition(drive: &LoggedTrip) -> Option<Vec<Range<usize>>> {
    let words = drive.words(Quantity::Ignition)?;
    let is_on = |word: &str| {
        let is_one = |known: &[&str]| known.iter().any(|known| known.eq_ignore_ascii_case(word));
        if is_one(&ON) {
            Some(true)
        } else if is_one(&OFF) {
            Some(false)
        } else {
            None
        }
    };
    let states: Vec<Option<bool>> = words.rows().map(is_on).collect();
    states.iter().flatten().next()?;
    let mut trips = Vec::new();
    let mut begin = Some(0);
    for (row, state) in states.iter().enumerate() {
        match (state, begin) {
            // what is switched off ends with this row
            (Some(false), Some(first)) => {
                trips.push(first..row + 1);
                begin = None;
            }
            (Some(true), None) => begin = Some(row),
            // switched on twice: the off was lost, and the trip goes on
            _ => {}
        }
    }
    trips.extend(begin.map(|first| first..states.len()));
    // an off at the very start ends nothing
    trips.retain(|trip| trip.len() > 1);
    Some(trips)
}

/// Rows of some, without standstills of at least `pause_s`.
fn without_pauses(drive: &LoggedTrip, rows: Range<usize>, pause_s: f64) -> Vec<Range<usize>> {
    let column = |quantity| drive.column(quantity).unwrap_or_default();
    let [time_s, speed_mps, position_m, latitude, longitude] = [
        Quantity::Time,
        Quantity::Speed,
        Quantity::Position,
        Quantity::Latitude,
        Quantity::Longitude,
    ]
    .map(column);
    let at = |values: &[f64], row: usize| values.get(row).copied().unwrap_or(f64::NAN);
    let moved = |from: usize, to: usize| {
        let [lat, lon] = [latitude, longitude].map(|values| [at(values, from), at(values, to)]);
        if lat.iter().chain(&lon).all(|value| value.is_finite()) {
            return Path2d::new(&lat, &lon).position_m[1] > STAYS_WITHIN_M;
        }
        let way_m = at(position_m, to) - at(position_m, from);
        if way_m.is_finite() { way_m > STAYS_WITHIN_M } else { at(speed_mps, to) > MOVES_MPS }
    };
    let mut trips = Vec::new();
    let (mut begin, mut anchor) = (rows.start, rows.start);
    // the last row at the anchor's place, and whether the vehicle has stood there long enough
    let mut stays = false;
    for row in rows.clone().skip(1) {
        if !moved(anchor, row) {
            stays |= time_s[row] - time_s[anchor] >= pause_s;
            continue;
        }
        if stays {
            if anchor > begin {
                trips.push(begin..anchor + 1);
            }
            begin = row - 1;
        }
        (anchor, stays) = (row, false);
    }
    trips.push(if stays { begin..anchor + 1 } else { begin..rows.end });
    trips.retain(|trip| trip.len() > 1);
    trips
}

/// Some rows of a drive.
fn part(drive: &LoggedTrip, rows: Range<usize>, name: String) -> LoggedTrip {
    let columns = drive
        .columns
        .iter()
        .map(|(quantity, values)| (*quantity, values.slice(rows.start, rows.len())));
    let words = drive.words.iter().map(|(quantity, words)| {
        let mut own = Words::default();
        for word in words.rows().skip(rows.start).take(rows.len()) {
            own.push(word);
        }
        (*quantity, own)
    });
    LoggedTrip {
        drive: name,
        driver: drive.driver.clone(),
        truck: drive.truck.clone(),
        event: drive.event.clone(),
        columns: columns.collect(),
        words: words.collect(),
        measured_each_s: drive.measured_each_s,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two trips of 10 minutes at 20 m/s, with half an hour between them of which no row is there.
    fn day() -> LoggedTrip {
        let minutes: Vec<f64> = (0..=10).chain(40..=50).map(f64::from).collect();
        let way_m = |m: f64| 1200.0 * if m <= 10.0 { m } else { m - 30.0 };
        let position_m = minutes.iter().map(|m| way_m(*m)).collect();
        let time_s = minutes.iter().map(|m| 60.0 * m).collect();
        LoggedTrip::new("t", "day", [(Quantity::Time, time_s), (Quantity::Position, position_m)])
    }

    #[test]
    fn a_stated_pause_ends_a_trip_and_a_gap_on_the_way_does_not() {
        let (trips, finding) = split(day(), Some(1200.0));
        let names: Vec<&str> = trips.iter().map(|trip| trip.drive.as_str()).collect();
        assert_eq!(names, ["day 1", "day 2"]);
        assert!(trips.iter().all(|trip| trip.rows() == 11), "{trips:?}");
        assert!(finding.unwrap().text.contains("2 trips by pauses of 20"));
        assert_eq!(split(day(), None).0.len(), 1);
        assert_eq!(split(day(), Some(7200.0)).0.len(), 1);
        // the receiver was lost for half an hour in which the truck drove on
        let on = day();
        let position_m = (0..on.rows()).map(|k| 3000.0 * k as f64).collect::<Vec<f64>>();
        let time_s = on.column(Quantity::Time).unwrap().to_vec();
        let on = [(Quantity::Time, time_s), (Quantity::Position, position_m)];
        assert_eq!(split(LoggedTrip::new("t", "day", on), Some(1200.0)).0.len(), 1);
    }

    #[test]
    fn the_ignition_ends_trips() {
        let mut drive = day();
        let mut words = Words::default();
        for row in 0..22 {
            words.push(match row {
                0 | 11 => "on",
                10 | 21 => "off",
                _ => "",
            });
        }
        drive.words.insert(Quantity::Ignition, words);
        let (trips, finding) = split(drive, None);
        assert_eq!(trips.iter().map(LoggedTrip::rows).collect::<Vec<_>>(), [11, 11]);
        assert_eq!(trips[1].column(Quantity::Time).unwrap()[0], 2400.0);
        assert!(finding.unwrap().text.contains("the ignition"));
    }
}
