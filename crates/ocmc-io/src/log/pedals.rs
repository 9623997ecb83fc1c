//! From log files to events whose driver can be identified: by the label `event`, or by the slopes
//! of the drive.

use super::{LoggedTrip, Need, counted};
use crate::intake::table::Quantity;
use ocmc_core::study::Study;
use ocmc_estimation::identification::event::PedalLog;
use ocmc_estimation::identification::one_truck::NamedEvent;
use ocmc_estimation::identification::speed_ahead::until_speed_is_set;
use ocmc_estimation::log::signal::{LogError, check_time, ends_at_rest};

/// Needs of identification in a log.
pub const NEEDS: [Need; 5] = [
    &[Quantity::Time],
    &[Quantity::Speed],
    &[Quantity::Accelerator],
    &[Quantity::Brake],
    &[Quantity::Grade],
];

/// Time that an event begins before its slope does, in s.
const BEFORE_S: f64 = 5.0;
/// Time that it goes on behind its slope, in s: the 350 m between the events of the paper, at 70
/// km/h.
const AFTER_S: f64 = 18.0;

/// Below this speed a yaw rate says nothing about the curvature, in m/s.
const SLOWEST_MPS: f64 = 2.0;

/// The events of a drive, and notes about what was not used of it; `place` is where it stands.
///
/// An event ends where a driver of the study may want another speed, for what lies ahead.
///
/// # Errors
/// [`LogError::Backwards`].
pub fn events(
    drive: &LoggedTrip,
    place: &str,
    study: &Study,
) -> Result<(Vec<NamedEvent>, Vec<String>), LogError> {
    let needed = NEEDS.map(|need| drive.column(need[0]).unwrap_or_default());
    let [time, speed, accelerator, brake, grade] = needed;
    let mut rows: Vec<usize> = Vec::with_capacity(time.len());
    let (mut missing, mut repeated) = ([0; 5], 0);
    for row in 0..drive.rows() {
        let lacks = |values: &&[f64]| values.get(row).is_none_or(|value| value.is_nan());
        if let Some(k) = needed.iter().position(lacks) {
            missing[k] += 1;
        } else if rows.last().is_some_and(|&last| time[last] == time[row]) {
            repeated += usize::from(!ends_at_rest(time, speed, row));
        } else {
            rows.push(row);
        }
    }
    check_time(time, &rows)?;
    let lacking = |quantity| {
        let values = drive.column(quantity)?;
        Some(rows.iter().filter(|&&row| values[row].is_nan()).count())
    };
    let [positions, gears] =
        [Quantity::Position, Quantity::Gear].map(|quantity| lacking(quantity).unwrap_or(0));
    let unused = NEEDS.map(|need| format!("without {}: not used", need[0].noun()));
    let missing = missing.into_iter().zip(&unused);
    let mut notes = counted(place, missing.map(|(count, what)| (count, "row", what.as_str())));
    notes.extend(counted(
        place,
        [
            (repeated, "row", "with the time of the row before: not used"),
            (
                positions,
                "row",
                "without position: the column is not used, the way is the integral of the speed",
            ),
            (
                gears,
                "row",
                "without gear: the column is not used, gears follow from the speed of the \
                 engine",
            ),
        ],
    ));
    let selected = |values: &[f64]| rows.iter().map(|&row| values[row]).collect::<Vec<f64>>();
    let known = |quantity| {
        let values = drive.column(quantity).map(selected)?;
        values.iter().all(|value| !value.is_nan()).then_some(values)
    };
    let log = PedalLog {
        time_s: selected(time),
        speed_mps: selected(speed),
        accelerator: selected(accelerator),
        brake: selected(brake),
        grade: selected(grade),
        position_m: known(Quantity::Position),
        gear: known(Quantity::Gear),
        limit_mps: known(Quantity::Limit),
        curvature_per_m: known(Quantity::Curvature).or_else(|| {
            let per_m = |(yaw, speed): (f64, &f64)| yaw / speed.max(SLOWEST_MPS);
            Some(known(Quantity::YawRate)?.into_iter().zip(&selected(speed)).map(per_m).collect())
        }),
        air_temperature_k: drive.ambient_k(),
        ..PedalLog::default()
    };
    if log.position_m.is_some() && !log.has_positions() {
        let what =
            "positions run backwards: the column is not used, the way is the integral of the speed";
        notes.push(format!("{place}: {what}"));
    }
    let (log, scatter) = log.with_even_slopes();
    if let Some(scatter) = scatter {
        notes.push(format!("{place}: {}", scatter.text()));
    }
    let ranges = match &drive.event {
        Some(event) => vec![(event.clone(), 0..log.time_s.len())],
        None => log.slope_events(BEFORE_S, AFTER_S),
    };
    let events = ranges.into_iter().map(|(event, rows)| NamedEvent {
        driver: drive.driver.clone(),
        event,
        log: until_speed_is_set(&log, &rows, study),
    });
    Ok((events.collect(), notes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::read;
    use crate::study;
    use crate::table::Source;
    use ocmc_estimation::identification::closed_loop::{ClosedLoop, Controller};
    use std::path::Path;

    #[test]
    fn the_air_of_an_event_is_as_warm_as_the_log_says() {
        let model = study::load("field-truck", &[] as &[&str]).unwrap().model;
        let study = Study::new(model).unwrap();
        // what an event is driven to in 20 s without a pedal, and what is said of its air
        let driven = |name: &str, ambient: [&str; 2]| {
            let rows = (0..200).map(|k| {
                let ambient = ambient[k % 2];
                format!("{},20,0,0,0,a,{ambient}\n", 0.1 * k as f64)
            });
            let names = "time_s,speed_mps,accelerator,brake,grade,event";
            let text = format!("{names},{name}\n{}", rows.collect::<String>());
            let file = read(Source::Text(Path::new("log.csv"), &text), &[], &NEEDS).unwrap();
            let (events, _) = events(&file.drives[0], "log.csv", &study).unwrap();
            let controller = Controller { start_speed_mps: 20.0, ..Controller::default() };
            let series = ClosedLoop::new(&study, &events[0].log).drive(&controller);
            (*series.speed_mps.last().unwrap(), file.read.told().join("\n"))
        };
        let (standard, told) = driven("note", ["", "x"]);
        assert!(!told.contains("ambient"), "{told}");
        let (mild, _) = driven("outside_temperature_c", ["15", ""]);
        assert!((mild - standard).abs() < 1e-9, "{mild} {standard}");
        let (cold, told) = driven("Außentemperatur [°C]", ["-19", "-21"]);
        assert!(told.contains("-20.0 °C in the mean of a drive"), "{told}");
        assert!(cold < standard - 0.1, "{cold} {standard}");
    }
}
