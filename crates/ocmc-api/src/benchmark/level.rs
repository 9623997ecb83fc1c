//! Trucks and drivers beside each other: how far they differ beyond chance, and who stands where.

use ocmc_estimation::fit::fleet::{
    FleetFit, FleetOptions, FleetTable, League, LeagueMember, VarianceComponent, fit, level_tests,
};
use ocmc_estimation::fit::p_value::NORMAL_975;
use serde::Serialize;

/// Level of the test whether members differ.
const SIGNIFICANCE: f64 = 0.05;

/// Trucks, or drivers.
#[derive(Clone, Debug, Serialize)]
pub struct BenchmarkLevel {
    /// `truck`, `driver` or `truck_and_driver`.
    pub level: &'static str,
    /// How many there are.
    pub count: usize,
    /// SD of the logarithm of their ratios, without what chance adds.
    pub sd: f64,
    /// Its 95 % interval.
    pub sd_ci95: Option<[f64; 2]>,
    /// Probability of as large differences where there are none.
    pub p: f64,
    /// Whether they differ beyond chance.
    pub differ: bool,
    /// The members, the thriftiest first; none where they do not differ beyond chance.
    pub members: Vec<BenchmarkMember>,
}

/// A truck or a driver.
#[derive(Clone, Debug, Serialize)]
pub struct BenchmarkMember {
    /// Its name; of a driver a pseudonym, unless names were asked for.
    pub name: String,
    /// Trips.
    pub trips: usize,
    /// Mean of its trips over what was expected of them, over that of the fleet; not shrunken.
    pub raw_ratio: f64,
    /// Ratio to the mean member, adjusted and shrunken.
    pub ratio: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
    /// Probability that it truly takes less than the median member.
    pub better_than_median: f64,
    /// How far its own trips decide: 0 nothing is known of it, 1 all.
    pub reliability: f64,
}

/// The levels, the SD of a trip and the mean of the logarithms with its interval; none where
/// members do not repeat.
pub(super) struct Levels {
    pub(super) all: Vec<BenchmarkLevel>,
    pub(super) trip_sd: f64,
    pub(super) mean: [f64; 3],
    pub(super) notes: Vec<String>,
}

impl Levels {
    pub(super) fn of(table: &FleetTable, by_driver: bool, seed: u64) -> Option<Self> {
        let options = FleetOptions { seed, ..FleetOptions::default() };
        let fleet_fit = fit(table, &options).ok()?;
        let tests = level_tests(table, &options).ok()?;
        let level = |component: &VarianceComponent| {
            let test = tests.iter().find(|test| test.level == component.level)?;
            let differ = test.p < SIGNIFICANCE && component.sd > 0.0;
            let league = fleet_fit.leagues.iter().find(|league| league.level == component.level);
            let league = league.filter(|_| differ);
            Some(BenchmarkLevel {
                level: if by_driver { "driver" } else { component.level },
                count: component.groups,
                sd: component.sd,
                sd_ci95: component.ci95,
                p: test.p,
                differ,
                members: league
                    .map_or_else(Vec::new, |league| members(league, component, &fleet_fit)),
            })
        };
        let levels = fleet_fit.components.iter().filter_map(level).collect();
        let trip = fleet_fit.components.iter().find(|component| component.level == "trip");
        let [low, high] = fleet_fit.mean_ci95;
        Some(Self {
            all: levels,
            trip_sd: trip.map_or(f64::NAN, |trip| trip.sd),
            mean: [fleet_fit.mean, low, high],
            notes: if by_driver { Vec::new() } else { notes(&fleet_fit) },
        })
    }
}

/// Notes of the fit; errors of the SDs are in the intervals here.
fn notes(fleet_fit: &FleetFit) -> Vec<String> {
    let is_of_errors = |note: &&String| note.contains("takes it as known");
    fleet_fit.notes.iter().filter(|note| !is_of_errors(note)).cloned().collect()
}

fn members(
    league: &League,
    component: &VarianceComponent,
    fleet_fit: &FleetFit,
) -> Vec<BenchmarkMember> {
    let log_error = component.standard_error.map_or(0.0, |error| error / component.sd);
    let member = |member: &LeagueMember| {
        // an effect λ d with λ = τ²/(τ² + s²) moves by 2 (1 − λ) of itself with ln τ
        let by_sd = 2.0 * (1.0 - member.reliability) * member.effect * log_error;
        let error = libm::hypot(member.standard_error, by_sd);
        let ratio = |effect: f64| libm::exp(effect);
        let (low, high) = (member.effect - NORMAL_975 * error, member.effect + NORMAL_975 * error);
        BenchmarkMember {
            name: member.label.clone(),
            trips: member.trips,
            raw_ratio: ratio(member.mean - fleet_fit.mean),
            ratio: ratio(member.effect),
            ci95: [ratio(low), ratio(high)],
            better_than_median: member.better_than_median,
            reliability: member.reliability,
        }
    };
    league.members.iter().map(member).collect()
}
