//! How far battery trucks come: of a study, driven until they are empty, or of a run that is kept.

use crate::answer::Answer;
use crate::error::Error;
use crate::text::{fact, folded, table, took};
use crate::watch::{Watch, watched};
use ocmc_core::record::Record;
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::range::{
    ArrivingRange, CurvePoint, RangeOf, RangeSummary, RangeTrip, drive, summarise,
};
use ocmc_fleet::run::RunPlan;
use ocmc_io::number_text::{count_of, grouped};
use ocmc_io::run_directory::{RunDirectoryError, read_groups};
use ocmc_io::study::LoadedStudy;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

/// Trips to be driven until the store is empty.
#[derive(Clone, Debug)]
pub struct RangeRequest<'a> {
    /// The study, and what the answer calls it.
    pub study: (String, &'a LoadedStudy),
    /// The cycles.
    pub plan: RunPlan,
}

/// How far the trucks come.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct RangeAnswer {
    /// Name of the study, or of the run.
    pub source: String,
    /// Length of the trips, in m; none where they have lengths of their own.
    pub trip_length_m: Option<f64>,
    /// The answer.
    #[serde(flatten)]
    pub range: RangeSummary,
    /// Remark that the trips are too short to show the range of trucks, and the remedy; none where
    /// they are long enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub too_short: Option<String>,
    #[serde(skip)]
    driven: Option<(RunPlan, f64)>,
}

/// Trips of the pilot run that tells how long trips have to be.
const PILOT: u64 = 64;
/// Length of the trips over the range with the least consumption of the pilot run.
const LONGER: f64 = 1.5;
/// Longest trip that a study can have, in m.
const LONGEST_M: f64 = 5.0e6;
/// Shortest drive, in m, whose consumption the pilot run looks at.
const SHORT_M: f64 = 5000.0;

/// Drives a study's trucks until their batteries are empty, without charging on the way. Trips are
/// made as long as that takes; those on given routes keep their lengths, and those that arrive tell
/// only that the range is longer.
///
/// ```
/// use ocmc_api::{RangeRequest, RunPlan, go_on, range, study};
/// let capacity = "vehicle.powertrain.battery_electric.battery.capacity_j=1.8e8";
/// let study = study::load("battery-truck", &[capacity])?;
/// let study = ("battery-truck".to_owned(), &study);
/// let plan = RunPlan::new(1, 0, 40, None, None);
/// let answer = range(&RangeRequest { study, plan }, &mut go_on)?;
/// assert_eq!((answer.range.all.trips, answer.range.all.depleted), (40, 40));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::NoBattery`] and [`Error::Interrupted`].
pub fn range(request: &RangeRequest, watch: &mut Watch) -> Result<RangeAnswer, Error> {
    let RangeRequest { study: (name, study), plan } = request;
    let reserve = study.model.charging.as_ref().map_or(0.0, |charging| charging.reserve);
    let Some(usable_j) = study.model.vehicle.powertrain.usable_j(reserve) else {
        return Err(Error::NoBattery(name.clone()));
    };
    let clock = Instant::now();
    let mut sets = Vec::new();
    if let Some(charging) = &study.model.charging {
        let public = charging.public.as_ref().map(|_| "charging.public.available_share=0");
        let stop = charging.stop.as_ref().map(|_| "charging.stop.begin_below=0");
        sets.extend(public.into_iter().chain(stop).map(str::to_owned));
        // without chargers nothing is left to use the reserve for
        if let (Some(_), Some(electric)) =
            (public, study.model.vehicle.powertrain.battery_electric())
        {
            let lowest = electric.battery.minimum_charge.max(charging.reserve);
            sets.push(format!(
                "vehicle.powertrain.battery_electric.battery.minimum_charge={lowest}"
            ));
        }
    }
    let mut trip_length_m = None;
    if study.model.mission.routes.is_empty() {
        let pilot = RunPlan::new(plan.seed, 0, PILOT, Some(plan.threads), None);
        let records = watched(PILOT, watch, |look| drive(&study.study, &pilot, look))?;
        let used = |r: &Record| r.drawn_kwh_per_km().filter(|_| r.distance_m > SHORT_M);
        let least = records.iter().filter_map(used).fold(f64::INFINITY, f64::min).max(0.01);
        let simulation = &study.model.simulation;
        let speed_mps =
            study.model.driver.speed_limit.highest_mps(study.model.vehicle.limiter_speed_mps);
        let most_m = LONGEST_M.min(0.5 * simulation.longest_duration_s * speed_mps);
        let length_m = (LONGER * usable_j / 3.6e6 / least).ceil() * 1000.0;
        let length_m = if least.is_finite() { length_m.min(most_m) } else { most_m };
        sets.push(format!("mission.length_m={length_m}"));
        trip_length_m = Some(length_m);
    }
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    let long = study.set(&sets)?;
    let records = watched(plan.cycles, watch, |look| drive(&long.study, plan, look))?;
    let trips: Vec<RangeTrip> = records.iter().filter_map(RangeTrip::of).collect();
    let none = || Error::NoBattery(name.clone());
    let range = summarise(&trips, Dependence::of(&long.model, plan.seed)).ok_or_else(none)?;
    let driven = Some((*plan, clock.elapsed().as_secs_f64()));
    let remedy = if trip_length_m.is_some() { LONGER_DURATION } else { LONGER_ROUTE };
    let too_short = too_short(&range, remedy);
    Ok(RangeAnswer { source: name.clone(), trip_length_m, range, too_short, driven })
}

/// Remedies where trips are too short to show the range: those of a study's length, of given
/// routes, and of a run.
const LONGER_DURATION: &str = "a longer `simulation.longest_duration_s` allows longer ones";
const LONGER_ROUTE: &str =
    "a longer route shows it, and `ocmc size` how small a battery this one needs";
const LONGER_TRIPS: &str =
    "`ocmc range --study NAME|FILE`, without a run, drives trips that are long enough";

/// Remark that trips are too short, and the remedy; none where they are long enough.
fn too_short(range: &RangeSummary, remedy: &str) -> Option<String> {
    let charge = range.lowest_charge.filter(|_| range.is_too_short())?;
    let RangeOf { trips, depleted, .. } = range.all;
    let percent = (100.0 * charge).floor();
    let trips = match depleted {
        0 => format!("All trips that arrive end with at least {percent} % of charge"),
        1 => format!("Only 1 of {} runs empty", count_of(trips, "trip")),
        _ => format!("Only {} of {} run empty", grouped(depleted), count_of(trips, "trip")),
    };
    Some(format!("{trips}: they are too short to show how far trucks come; {remedy}."))
}

/// Range from the records of a run: a trip that arrived tells that it is longer.
///
/// # Errors
/// [`Error::RunDirectory`] where there is no run that was ended, and [`Error::NoBattery`].
pub fn range_of_run(directory: &Path) -> Result<RangeAnswer, Error> {
    let mut trips = Vec::new();
    let read = read_groups(directory, |group| {
        trips.extend(group.records.iter().filter_map(RangeTrip::of));
    });
    let (manifest, _) = read.map_err(|error: RunDirectoryError| Error::from(error))?;
    let none = || Error::NoBattery(manifest.study.clone());
    let range = summarise(&trips, manifest.dependence()).ok_or_else(none)?;
    let source = directory.display().to_string();
    let on_routes = !manifest.routes().is_empty() || manifest.followed.is_some();
    let too_short = too_short(&range, if on_routes { LONGER_ROUTE } else { LONGER_TRIPS });
    Ok(RangeAnswer { source, trip_length_m: None, range, too_short, driven: None })
}

/// Widths of the table of ranges.
const WIDTHS: [usize; 9] = [16, 8, 8, 8, 8, 8, 8, 8, 8];
/// Rows that the curve has in a text, about.
const CURVE_ROWS: usize = 12;

fn km(distance_m: Option<f64>) -> String {
    distance_m.map_or("-".to_owned(), |m| format!("{:.0}", m / 1000.0))
}

fn cells(name: &str, summary: &RangeOf) -> Vec<String> {
    let ranges = summary.arriving.iter().map(|arriving| km(arriving.range_m));
    [name.to_owned(), grouped(summary.trips)].into_iter().chain(ranges).collect()
}

fn interval(arriving: &ArrivingRange) -> String {
    match arriving.ci95_m.map(|end| end.map(|_| km(end))) {
        [Some(low), Some(high)] => format!("{low}-{high}"),
        [None, Some(high)] => format!("<{high}"),
        [Some(low), None] => format!(">{low}"),
        [None, None] => "-".to_owned(),
    }
}

/// The curve in words and bars.
fn curve(points: &[CurvePoint]) -> String {
    let mut text = "\nTrip length and the trucks that arrive, with the 95 % interval\n".to_owned();
    for point in points.iter().step_by(points.len().div_ceil(CURVE_ROWS).max(1)) {
        let CurvePoint { distance_m, share, ci95 } = *point;
        let range = format!("{:.1} to {:.1}", 100.0 * ci95[0], 100.0 * ci95[1]);
        let bar = "█".repeat((40.0 * share).round() as usize);
        let line =
            format!("{:>6} km {:>6.1} % {range:>14}  {bar}", km(Some(distance_m)), 100.0 * share);
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

impl Answer for RangeAnswer {
    fn text(&self) -> String {
        let all = &self.range.all;
        let mut text = fact(if self.driven.is_some() { "study" } else { "run" }, &self.source);
        if let Some((plan, wall_s)) = &self.driven {
            text.push_str(&fact("seed", plan.seed));
            let trips = count_of(all.trips, "trip");
            let how = match self.trip_length_m {
                Some(length_m) => format!("{trips} of {} km, until empty", km(Some(length_m))),
                None => format!("{trips} on the given routes, as long as these are"),
            };
            text.push_str(&fact("driven", how));
            text.push_str(&took(*wall_s, plan.threads, plan.cycles));
        }
        let share = 100.0 * all.depleted as f64 / all.trips.max(1) as f64;
        text.push_str(&fact(
            "empty",
            format!("{} of {} ({share:.1} %)", grouped(all.depleted), count_of(all.trips, "trip")),
        ));
        if all.given_up > 0 {
            let trips = count_of(all.given_up, "trip");
            text.push_str(&fact("given up", format!("{trips} that stalled or timed out")));
        }
        if let Some(told) = &self.too_short {
            let _ = writeln!(text, "\n{}", folded(told, ""));
        }
        text.push_str("\nLongest trip, in km, with which so many of the trucks arrive\n");
        let shares = all.arriving.iter().map(|a| format!("{:.0} %", 100.0 * a.share));
        let head: Vec<String> =
            [String::new(), "trips".to_owned()].into_iter().chain(shares).collect();
        let head: Vec<&str> = head.iter().map(String::as_str).collect();
        let groups = self.range.by_season.iter().chain(&self.range.by_payload);
        let rows = groups.map(|group| cells(&group.group, &group.range));
        let intervals = all.arriving.iter().map(interval);
        let ends = ["  95 % interval".to_owned(), String::new()].into_iter().chain(intervals);
        let first = [cells("all", all), ends.collect()];
        text.push_str(&table(&WIDTHS, &head, first.into_iter().chain(rows)));
        if all.arriving.iter().any(|arriving| arriving.ci95_m.contains(&None)) {
            text.push_str(OPEN);
        }
        text.push_str(&curve(&self.range.curve));
        text.push_str(NOTE);
        text
    }
}

/// Explanation of an interval with an open side.
const OPEN: &str = "  <, >, -: no trip bounds that side; more trips do\n";

/// Scope of the figures, and the effects left out.
const NOTE: &str = "
From the charge at departure to the lowest charge that the study allows.
Intervals are of the chance of trips alone, not of how right the study is.
A trip that arrives tells only that the range is longer (Kaplan and Meier).
";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::watch::go_on;
    use ocmc_io::study::load;

    #[test]
    fn a_diesel_truck_has_no_battery() {
        let study = load::<&str>("field-truck", &[]).expect("a study");
        let plan = RunPlan::new(1, 0, 10, Some(1), None);
        let request = RangeRequest { study: ("field-truck".to_owned(), &study), plan };
        let error = range(&request, &mut go_on).expect_err("no battery");
        assert!(error.to_string().contains("battery-truck"), "{error}");
    }

    #[test]
    fn lines_fit_eighty_columns() {
        let study = load(
            "battery-truck",
            &["vehicle.powertrain.battery_electric.battery.capacity_j=1.8e8"],
        );
        let study = study.expect("a study");
        let plan = RunPlan::new(1, 0, 60, Some(2), None);
        let request = RangeRequest { study: ("battery-truck".to_owned(), &study), plan };
        let text = range(&request, &mut go_on).expect("a range").text();
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    }
}
