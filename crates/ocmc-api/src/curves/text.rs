//! What is said about logs: what was found, and everything that was not used.

use ocmc_estimation::log::signal::LogCounts;
use ocmc_io::log::curves::TripCurves;
use ocmc_io::number_text::{count_of, grouped, rounded};
use std::fmt::Write;

/// Most drives that get a line of their own.
const MOST_LINES: usize = 40;

/// What was found in the drives.
pub(crate) fn curves_account(drives: &[TripCurves], left_out: usize) -> String {
    let mut text = String::new();
    if drives.len() <= MOST_LINES {
        for drive in drives {
            let found = &drive.detection;
            let _ = write!(
                text,
                "{}: {} km, {}",
                drive.drive,
                rounded(found.way_m / 1000.0),
                count_of(found.curves.len() as u64, "curve")
            );
            if drive.turning != "yaw_rate" {
                let _ = write!(text, ", turning by its {}", drive.turning.replace('_', " "));
            }
            if let Some(bias) = found.gyro_bias_radps.filter(|bias| *bias != 0.0) {
                let _ = write!(text, ", yaw rate less {bias:.5} rad/s");
            }
            if let Some(lag) = found.speed_lag_s {
                let _ = write!(text, ", speed {lag:.2} s late");
            }
            let _ = writeln!(text, "{}", left_out_of(&found.counts));
        }
    }
    let sum = |count: &dyn Fn(&TripCurves) -> usize| drives.iter().map(count).sum::<usize>() as u64;
    let way_km: f64 = drives.iter().map(|drive| drive.detection.way_m / 1000.0).sum();
    let slow_km: f64 = drives.iter().map(|drive| drive.detection.slow_m / 1000.0).sum();
    let _ = write!(
        text,
        "{} on {} km of {} ({} km of it too slow to tell)",
        count_of(sum(&|drive| drive.detection.curves.len()), "curve"),
        rounded(way_km),
        count_of(drives.len() as u64, "drive"),
        rounded(slow_km)
    );
    let rows = sum(&|drive| drive.detection.counts.rows);
    let used = sum(&|drive| drive.detection.counts.used);
    let _ = write!(text, "\n{} of {} rows used", grouped(used), grouped(rows));
    for (what, count) in [
        ("rows without time", sum(&|drive| drive.detection.counts.missing_time)),
        ("rows without speed", sum(&|drive| drive.detection.counts.missing_speed)),
        ("rows without yaw rate", sum(&|drive| drive.detection.counts.missing_yaw_rate)),
        (
            "rows with the time of the row before",
            sum(&|drive| drive.detection.counts.repeated_time),
        ),
        (
            "rows in reverse (is the sign of the speed right?)",
            sum(&|drive| drive.detection.counts.reversing),
        ),
        ("gaps in time", sum(&|drive| drive.detection.counts.gaps)),
        ("curves too short", sum(&|drive| drive.detection.too_short)),
        ("curves that turn too little", sum(&|drive| drive.detection.too_straight)),
        ("curves in which the vehicle crept or stood", sum(&|drive| drive.detection.too_slow)),
        ("curves whose radius cannot be measured", sum(&|drive| drive.detection.without_radius)),
        ("drives left out", left_out as u64),
        (
            "drives without standstill, so the bias of the gyro is not known",
            sum(&|drive| usize::from(drive.detection.gyro_bias_radps.is_none())),
        ),
    ] {
        if count > 0 {
            let _ = write!(text, "; {what}: {}", grouped(count));
        }
    }
    for (what, count) in [
        ("faster than 70 m/s", sum(&|drive| drive.detection.counts.implausible_speed)),
        ("turning by more than 2 rad/s", sum(&|drive| drive.detection.counts.implausible_yaw_rate)),
    ] {
        if count > 0 {
            let _ =
                write!(text, "\nwarning: {} rows are {what}: is the unit right?", grouped(count));
        }
    }
    text
}

/// Rows of one drive that were not used.
fn left_out_of(counts: &LogCounts) -> String {
    let unused = counts.rows - counts.used;
    let mut text = String::new();
    if unused > 0 {
        let _ = write!(text, ", {} not used", count_of(unused as u64, "row"));
    }
    if counts.gaps > 0 {
        let _ = write!(
            text,
            ", {} of {} s",
            count_of(counts.gaps as u64, "gap"),
            rounded(counts.gap_s)
        );
    }
    text
}
