//! How far battery trucks come: the distance to empty as a distribution, from trips of which some
//! arrive before the battery is empty.

use super::dependence::Dependence;
use super::kaplan_meier::{Observation, Survival};
use super::run::{Ranges, RunPlan, run_with};
use ocmc_core::kernel::drive::scheduler::{Deliver, Driving, sampled};
use ocmc_core::record::{Outcome, Record};
use ocmc_core::study::Study;
use schemars::JsonSchema;
use serde::Serialize;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;

impl RangeSummary {
    /// Whether so few trips emptied the battery that no length is known.
    pub fn is_too_short(&self) -> bool {
        let known = self.all.arriving.iter().any(|arriving| arriving.range_m.is_some());
        self.lowest_charge.is_some() && !known
    }
}

/// Shares of the trips that arrive, for which the longest trip is told.
pub const ARRIVING: [f64; 7] = [0.99, 0.95, 0.9, 0.75, 0.5, 0.25, 0.05];

/// Points of the curve of arrivals, about.
const CURVE_POINTS: f64 = 40.0;

/// Parts of equal size by which loaded trips are told apart.
const PAYLOAD_PARTS: usize = 3;

/// Evidence of a trip on the range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeTrip {
    cycle_id: u64,
    distance_m: f64,
    outcome: Outcome,
    payload_kg: f64,
    departure_s_of_year: f64,
    final_charge: f64,
}

impl RangeTrip {
    /// Evidence of a record; none without a battery.
    pub fn of(record: &Record) -> Option<Self> {
        let final_charge = record.final_charge?;
        let Record { cycle_id, distance_m, outcome, payload_kg, departure_s_of_year, .. } = *record;
        Some(Self { cycle_id, distance_m, outcome, payload_kg, departure_s_of_year, final_charge })
    }
}

/// How far trucks come.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RangeSummary {
    /// Range over all trips.
    #[serde(flatten)]
    pub all: RangeOf,
    /// The lowest state of charge at the end of a trip that arrived; none where none arrived.
    pub lowest_charge: Option<f64>,
    /// Share that arrives over the length of the trip.
    pub curve: Vec<CurvePoint>,
    /// By the season of the north in which trips depart.
    pub by_season: Vec<RangeGroup>,
    /// Empty trips, and loaded ones in thirds.
    pub by_payload: Vec<RangeGroup>,
}

/// How far the trips of a group come.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RangeOf {
    /// Trips.
    pub trips: u64,
    /// Trips that emptied the battery.
    pub depleted: u64,
    /// Trips that were given up for another reason: they count up to there.
    pub given_up: u64,
    /// The longest trips with which shares of the trucks arrive, from the surest.
    pub arriving: Vec<ArrivingRange>,
}

/// The longest trip with which a share of the trucks arrives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ArrivingRange {
    /// The share.
    pub share: f64,
    /// The length, in m; none where the trips that are known are too short to tell.
    pub range_m: Option<f64>,
    /// Its 95 % interval; an end is none where no trip bounds it.
    pub ci95_m: [Option<f64>; 2],
}

/// Share that arrives with a trip of a length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CurvePoint {
    /// The length, in m.
    pub distance_m: f64,
    /// The share.
    pub share: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
}

/// A group of trips.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RangeGroup {
    /// Its name.
    pub group: String,
    /// How far they come.
    #[serde(flatten)]
    pub range: RangeOf,
}

/// Seasons by month, from January.
pub const SEASONS: [&str; 4] = ["winter", "spring", "summer", "autumn"];
/// Days before March, and those of a season (judgement: all as long).
const FIRST_OF_MARCH: f64 = 59.0;
const DAYS_OF_SEASON: f64 = 365.0 / 4.0;
const DAY_S: f64 = 86_400.0;

/// Place of the season of a departure: December, January and February are winter.
pub fn season_of(departure_s_of_year: f64) -> usize {
    let day = departure_s_of_year / DAY_S;
    let since_march = (day - FIRST_OF_MARCH + 365.0) % 365.0;
    (1 + (since_march / DAYS_OF_SEASON) as usize) % 4
}

fn survival(trips: &[RangeTrip], dependence: Dependence) -> Option<Survival> {
    let observation = |trip: &RangeTrip| Observation {
        cluster: trip.cycle_id / dependence.batch,
        distance_m: trip.distance_m,
        event: trip.outcome == Outcome::Depleted,
    };
    Survival::new(trips.iter().map(observation).collect())
}

fn range_of(trips: &[RangeTrip], dependence: Dependence) -> RangeOf {
    let count = |is: fn(Outcome) -> bool| trips.iter().filter(|t| is(t.outcome)).count() as u64;
    let survival = survival(trips, dependence);
    let arriving = ARRIVING.map(|share| {
        let curve = survival.as_ref();
        let range_m = curve.and_then(|s| s.quantile(share));
        let ci95_m = curve.map_or([None; 2], |s| s.quantile_ci95(share));
        ArrivingRange { share, range_m, ci95_m }
    });
    RangeOf {
        trips: trips.len() as u64,
        depleted: count(|outcome| outcome == Outcome::Depleted),
        given_up: count(|outcome| !outcome.counts()),
        arriving: arriving.to_vec(),
    }
}

/// A round step, in m, so that there are about so many in a distance.
fn round_step_m(distance_m: f64) -> f64 {
    let rough = (distance_m / CURVE_POINTS).max(1.0);
    let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
    let times = [1.0, 2.0, 5.0].into_iter().find(|times| times * power >= rough * (1.0 - 1e-12));
    times.unwrap_or(10.0) * power
}

/// Sums up the trips; none of none.
pub fn summarise(trips: &[RangeTrip], dependence: Dependence) -> Option<RangeSummary> {
    let all = survival(trips, dependence)?;
    let farthest_m = trips.iter().map(|trip| trip.distance_m).fold(0.0, f64::max);
    let step_m = round_step_m(farthest_m);
    let points = 1 + (farthest_m / step_m) as usize;
    let curve = (0..=points).filter_map(|k| {
        let distance_m = k as f64 * step_m;
        let share = all.share(distance_m)?;
        Some(CurvePoint { distance_m, share, ci95: all.ci95(distance_m)? })
    });
    let group = |name: String, is: &dyn Fn(&RangeTrip) -> bool| {
        let own: Vec<RangeTrip> = trips.iter().copied().filter(|trip| is(trip)).collect();
        (!own.is_empty()).then(|| RangeGroup { group: name, range: range_of(&own, dependence) })
    };
    let seasons = SEASONS.iter().enumerate();
    let by_season = seasons.filter_map(|(k, name)| {
        group((*name).to_owned(), &|trip| season_of(trip.departure_s_of_year) == k)
    });
    let mut loads: Vec<f64> = trips.iter().map(|t| t.payload_kg).filter(|kg| *kg > 0.0).collect();
    loads.sort_unstable_by(f64::total_cmp);
    let mut by_payload: Vec<RangeGroup> =
        group("empty".to_owned(), &|trip| trip.payload_kg <= 0.0).into_iter().collect();
    let mut above_kg = 0.0;
    for part in 1..=PAYLOAD_PARTS {
        let Some(to_kg) = (part * loads.len() / PAYLOAD_PARTS).checked_sub(1).map(|k| loads[k])
        else {
            continue;
        };
        let name = format!("{:.1} to {:.1} t", above_kg / 1000.0, to_kg / 1000.0);
        by_payload
            .extend(group(name, &|trip| trip.payload_kg > above_kg && trip.payload_kg <= to_kg));
        above_kg = to_kg;
    }
    let arrived = trips.iter().filter(|trip| trip.outcome == Outcome::Completed);
    Some(RangeSummary {
        all: range_of(trips, dependence),
        lowest_charge: arrived.map(|trip| trip.final_charge).reduce(f64::min),
        curve: curve.collect(),
        by_season: by_season.collect(),
        by_payload,
    })
}

/// Drives the cycles of a plan until they arrive or are empty. `progress` receives the number of
/// cycles driven so far, several times a second; breaking ends the run.
pub fn drive<B>(
    study: &Study,
    plan: &RunPlan,
    mut progress: impl FnMut(u64) -> ControlFlow<B>,
) -> ControlFlow<B, Vec<Record>> {
    let drive = |ranges: Ranges, stop: &AtomicBool, deliver: Deliver| {
        let driving = Driving { study, level: plan.level, stop, whole_trips: false };
        driving.each(&mut sampled(study, plan.seed, ranges.flatten()), deliver);
    };
    let mut all = Vec::new();
    run_with(plan, &drive, |records| {
        all.extend(records);
        progress(all.len() as u64)
    })?;
    ControlFlow::Continue(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trip(cycle_id: u64, distance_m: f64, outcome: Outcome) -> RangeTrip {
        RangeTrip {
            cycle_id,
            distance_m,
            outcome,
            payload_kg: 1000.0 * (cycle_id % 4) as f64,
            departure_s_of_year: DAY_S * (cycle_id % 365) as f64,
            final_charge: if outcome == Outcome::Depleted { 0.0 } else { 0.7 },
        }
    }

    #[test]
    fn groups_hold_all_trips_and_the_curve_falls() {
        let trips: Vec<RangeTrip> =
            (0..730).map(|k| trip(k, 1000.0 * (100 + k % 90) as f64, Outcome::Depleted)).collect();
        let range = summarise(&trips, Dependence::default()).expect("trips");
        let count = |groups: &[RangeGroup]| groups.iter().map(|g| g.range.trips).sum::<u64>();
        assert_eq!((count(&range.by_season), count(&range.by_payload)), (730, 730));
        let names: Vec<&str> = range.by_payload.iter().map(|g| g.group.as_str()).collect();
        assert_eq!(names, ["empty", "0.0 to 1.0 t", "1.0 to 2.0 t", "2.0 to 3.0 t"]);
        assert!(range.curve.windows(2).all(|pair| pair[0].share >= pair[1].share));
        assert_eq!(range.curve[0].share, 1.0);
        assert_eq!(range.curve.last().expect("points").share, 0.0);
        let median = range.all.arriving[4];
        assert_eq!((median.share, median.range_m), (0.5, Some(144e3)));
        assert!(summarise(&[], Dependence::default()).is_none());
    }

    #[test]
    fn seasons_are_those_of_the_north() {
        let on = |day: u64| SEASONS[season_of(DAY_S * day as f64)];
        assert_eq!(
            [0, 58, 59, 150, 200, 300, 340].map(on),
            ["winter", "winter", "spring", "spring", "summer", "autumn", "winter"]
        );
    }

    #[test]
    fn trips_that_were_given_up_are_told_and_count_up_to_there() {
        let trips = [
            trip(0, 100.0, Outcome::Depleted),
            trip(1, 150.0, Outcome::Stalled),
            trip(2, 200.0, Outcome::Depleted),
            trip(3, 200.0, Outcome::Completed),
        ];
        let range = summarise(&trips, Dependence::default()).expect("trips").all;
        assert_eq!((range.trips, range.depleted, range.given_up), (4, 2, 1));
        assert_eq!(range.arriving[3].range_m, Some(100.0));
        assert_eq!(range.arriving[6].range_m, None);
    }

    #[test]
    fn trips_of_which_next_to_none_is_empty_are_too_short() {
        let all = |empty: u64, at_m: f64| {
            let outcome = |k| if k < empty { Outcome::Depleted } else { Outcome::Completed };
            let length_m = |k| if k < empty { at_m } else { 200.0 };
            let trips: Vec<RangeTrip> =
                (0..1000).map(|k| trip(k, length_m(k), outcome(k))).collect();
            summarise(&trips, Dependence::default()).expect("trips")
        };
        assert_eq!((all(0, 0.0).lowest_charge, all(1000, 90.0).lowest_charge), (Some(0.7), None));
        assert!(all(0, 0.0).is_too_short() && all(9, 190.0).is_too_short());
        // 99 % arrive with a known length
        assert!(!all(20, 190.0).is_too_short() && !all(1000, 90.0).is_too_short());
    }
}
