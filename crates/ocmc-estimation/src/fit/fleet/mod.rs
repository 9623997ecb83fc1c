//! The records of a fleet: how much trucks, drivers and trips differ, and what follows from it.
//!
//! y = μ + truck + driver + trip, each part normal with an SD of its own, estimated by restricted
//! maximum likelihood (REML). Drivers may belong to trucks, trucks to drivers, or both be mixed;
//! numbers of trips need not be equal. [`fit`] also answers how many trips tell two of them apart
//! ([`TellingApart`]), who is best and how sure that is ([`League`]), and what the next year brings
//! ([`NextYear`]).
//!
//! Checked against criteria and SDs of other programs (Dyestuff, Pastes, Penicillin), the analysis
//! of variance, dense matrices of six designs, and simulated fleets (`tests/it/fit/fleet.rs`).

mod components;
#[cfg(test)]
mod dense;
mod league;
mod likelihood;
mod next_year;
mod telling_apart;
mod trips;

use crate::option_check::{OptionError, check_options};
use components::{Components, test_of};
use next_year::{Around, next_year};
use serde::Serialize;
use std::collections::BTreeMap;
use thiserror::Error;
use trips::Trips;

pub use components::{IntervalKind, VarianceComponent};
pub use league::{League, LeagueMember};
pub use next_year::{Expected, NextYear};
pub use telling_apart::{TellingApart, difference_with, power_of, trips_to_tell};
pub use trips::{FleetDesign, FleetTable};

/// Rows that do not count, by reason.
pub type Dropped = BTreeMap<&'static str, usize>;

/// Good end of a quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Best {
    /// Less is better.
    #[default]
    Lowest,
    /// More is better.
    Highest,
}

impl Best {
    /// Key that is smallest for the best.
    fn key(self, value: f64) -> f64 {
        match self {
            Self::Lowest => value,
            Self::Highest => -value,
        }
    }
}

/// Trips that count, and the questions.
#[derive(Clone, Debug, PartialEq)]
pub struct FleetOptions {
    /// Drivers are numbered within each truck: driver 1 of two trucks are two drivers.
    pub own_drivers: bool,
    /// Months are part of the model, as fixed effects.
    pub month: bool,
    /// The difference that is to be told apart, as a share of the mean.
    pub differ: f64,
    /// The power of that test.
    pub power: f64,
    /// Its significance, two-sided.
    pub significance: f64,
    /// Trips of each truck in the next year; none for as many as in the records.
    pub next_trips: Option<u64>,
    /// Good end of the quantity.
    pub best: Best,
    /// Draws of all effects for the league tables.
    pub draws: u64,
    /// Seed of the draws.
    pub seed: u64,
}

impl Default for FleetOptions {
    fn default() -> Self {
        Self {
            own_drivers: false,
            month: false,
            differ: 0.01,
            power: 0.8,
            significance: 0.05,
            next_trips: None,
            best: Best::Lowest,
            draws: 4000,
            seed: 1,
        }
    }
}

/// Largest number of draws.
pub const MOST_DRAWS: u64 = 1_000_000;
/// Largest number of trips of a truck in the next year.
pub const MOST_NEXT_TRIPS: u64 = 1_000_000_000;

impl FleetOptions {
    fn check(&self) -> Result<(), OptionError> {
        let share = |name, x: f64| (name, x, "a share above 0 and below 1", x > 0.0 && x < 1.0);
        let draws = (1..=MOST_DRAWS).contains(&self.draws);
        let next = self.next_trips.is_none_or(|trips| (1..=MOST_NEXT_TRIPS).contains(&trips));
        let trips = self.next_trips.unwrap_or(0) as f64;
        check_options([
            share("differ", self.differ),
            share("power", self.power),
            share("significance", self.significance),
            ("draws", self.draws as f64, "a whole number from 1 to 1000000", draws),
            ("next_trips", trips, "a whole number from 1 to 1000000000", next),
        ])
    }
}

/// Why records have no fit.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FleetFitError {
    /// Fewer than two trucks.
    #[error(
        "{trips} trips of {trucks} trucks; allowed are two trucks or more{}",
        dropped_text(dropped)
    )]
    FewTrucks {
        /// Trucks.
        trucks: usize,
        /// Trips that count.
        trips: usize,
        /// Rows that do not.
        dropped: Dropped,
    },
    /// Trips that all have their own level.
    #[error(
        "{trips} trips of {trucks} trucks do not repeat: trucks and drivers cannot be told from \
         trips; give more trips of the same trucks"
    )]
    NoRepeats {
        /// Trips that count.
        trips: usize,
        /// Trucks.
        trucks: usize,
    },
    /// Trips that do not differ.
    #[error("the trips of each truck and driver are all the same; they have to differ")]
    NoSpread,
    /// A pool that is too large.
    #[error(
        "{levels} trucks or drivers are mixed up in one pool; allowed are {most} of the smaller \
         number: fit parts of the fleet, or leave the drivers out"
    )]
    Entangled {
        /// The smaller number of trucks and drivers.
        levels: usize,
        /// Largest number.
        most: usize,
    },
    /// An option out of its range.
    #[error(transparent)]
    Option(#[from] OptionError),
}

/// Rows that do not count, for a message.
fn dropped_text(dropped: &Dropped) -> String {
    let parts: Vec<String> = dropped
        .iter()
        .map(|(reason, rows)| format!("{rows} {}", reason.replace('_', " ")))
        .collect();
    if parts.is_empty() { String::new() } else { format!(" (left out: {})", parts.join(", ")) }
}

/// The mean of a month beside that of all trips, with equal trucks and drivers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MonthEffect {
    /// The month, from 1.
    pub month: usize,
    /// Difference from the mean.
    pub effect: f64,
    /// Standard error of that.
    pub standard_error: f64,
}

/// Results from the records of a fleet.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FleetFit {
    /// Trips.
    pub n: usize,
    /// Trucks.
    pub trucks: usize,
    /// Drivers; none where the records do not name them.
    pub drivers: Option<usize>,
    /// Design: the driver of each truck's trips.
    pub design: FleetDesign,
    /// Rows left out, by reason.
    pub dropped: Dropped,
    /// Mean over trucks and drivers.
    pub mean: f64,
    /// Its standard error.
    pub mean_standard_error: f64,
    /// Its 95 % interval.
    pub mean_ci95: [f64; 2],
    /// The SDs, that of a trip last.
    pub components: Vec<VarianceComponent>,
    /// Minus twice the restricted log-likelihood.
    pub reml_criterion: f64,
    /// Months beside the mean, where they are part of the model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub months: Vec<MonthEffect>,
    /// Trips that tell two trucks or two drivers apart.
    pub telling_apart: Vec<TellingApart>,
    /// League tables of the levels whose members differ.
    pub leagues: Vec<League>,
    /// The year to come.
    pub next_year: NextYear,
    /// Facts that have to be known to read this.
    pub notes: Vec<String>,
}

/// Fits the records of a fleet.
///
/// # Errors
/// [`FleetFitError`].
pub fn fit(table: &FleetTable, options: &FleetOptions) -> Result<FleetFit, FleetFitError> {
    options.check()?;
    let trips = Trips::of(table, options)?;
    let components = Components::estimate(&trips).ok_or(FleetFitError::NoSpread)?;
    let around = Around::new(&trips, &components).ok_or(FleetFitError::NoSpread)?;
    let mean = around.fleet_mean(&trips);
    let told = components.told(&trips, mean.mean);
    let notes = notes(&trips, &told, table.driver.is_some());
    Ok(FleetFit {
        n: trips.n,
        trucks: trips.counted[0],
        drivers: table.driver.is_some().then_some(trips.counted[1]),
        design: trips.design,
        dropped: trips.dropped.clone(),
        mean: mean.mean,
        mean_standard_error: mean.sd,
        mean_ci95: mean.ci95,
        components: told,
        reml_criterion: components.criterion,
        months: months(&trips, &around),
        telling_apart: telling_apart::telling_apart(&trips, &components, mean.mean, options),
        leagues: league::leagues(&trips, &components, &around.centre, options),
        next_year: next_year(&trips, &around, options),
        notes,
    })
}

/// The test whether members of a level differ at all.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LevelTest {
    /// `truck`, `driver` or `truck_and_driver`.
    pub level: &'static str,
    /// Restricted likelihood ratio, in −2 l.
    pub statistic: f64,
    /// Probability of as large a one where they do not differ.
    pub p: f64,
}

/// Tests the levels of the records of a fleet.
///
/// # Errors
/// [`FleetFitError`].
pub fn level_tests(
    table: &FleetTable,
    options: &FleetOptions,
) -> Result<Vec<LevelTest>, FleetFitError> {
    options.check()?;
    let trips = Trips::of(table, options)?;
    let families = (0..2).filter(|family| trips.families[*family].len() > 1);
    let test = |family| {
        let (statistic, p) = test_of(&trips, family);
        let level = match (family, trips.design) {
            (0, FleetDesign::TruckAndDriver) => "truck_and_driver",
            (0, _) => "truck",
            _ => "driver",
        };
        LevelTest { level, statistic, p }
    };
    Ok(families.map(test).collect())
}

/// Each month beside the mean of all trips.
fn months(trips: &Trips, around: &Around) -> Vec<MonthEffect> {
    let mean = trips.mean_predictors();
    let effect = |(place, month): (usize, &usize)| {
        let mut fixed: Vec<f64> = mean.iter().map(|x| -x).collect();
        fixed[0] = 0.0;
        if place > 0 {
            fixed[place] += 1.0;
        }
        let combined = around.centre.combine(&fixed, &[]);
        MonthEffect {
            month: month + 1,
            effect: combined.mean,
            standard_error: libm::sqrt(combined.variance),
        }
    };
    trips.months.iter().enumerate().map(effect).collect()
}

/// Relative error of an SD from which on the errors of a league are said to be too small: with
/// twelve trucks their squares are about 1.8 times what is said, with forty 1.03 times (simulated
/// fleets; the probabilities hold in both).
const UNSURE: f64 = 0.25;

/// Several of a level.
fn plural(level: &str) -> &'static str {
    match level {
        "truck" => "trucks",
        "driver" => "drivers",
        "truck_and_driver" => "trucks with their drivers",
        _ => "trips",
    }
}

/// Facts that have to be known to read the answers.
fn notes(trips: &Trips, told: &[VarianceComponent], has_drivers: bool) -> Vec<String> {
    let mut notes = Vec::new();
    let who = match trips.design {
        FleetDesign::TrucksOnly if !has_drivers => {
            "the records name no drivers: what differs between the drivers of a truck is part of \
             its trips, and a driver who always has the same truck is part of the truck"
        }
        FleetDesign::TrucksOnly if trips.counted[1] == 1 => {
            "all trips have one driver: how drivers differ is not known"
        }
        FleetDesign::TrucksOnly => {
            "each driver has one trip: what differs between drivers is part of the trips"
        }
        FleetDesign::TruckAndDriver => {
            "each truck has one driver and each driver one truck: their parts cannot be told \
             apart, and are one level, truck and driver together"
        }
        _ => "",
    };
    if !who.is_empty() {
        notes.push(who.to_owned());
    }
    for component in told.iter().filter(|component| component.sd == 0.0) {
        notes.push(format!(
            "the SD between {} is 0, the end of its range: they differ by no more than by chance; \
             its upper limit says what may be hidden",
            plural(component.level)
        ));
    }
    let unsure = told.iter().filter_map(|component| {
        let error = component.standard_error? / component.sd;
        (component.level != "trip" && error > UNSURE).then_some((component.level, error))
    });
    for (level, error) in unsure {
        notes.push(format!(
            "the SD between {} is known to {:.0} % only; the league takes it as known, and its \
             errors are too small",
            plural(level),
            100.0 * error
        ));
    }
    let unbounded = |component: &&VarianceComponent| {
        component.ci95.is_some_and(|[_, upper]| !upper.is_finite())
    };
    for component in told.iter().filter(unbounded) {
        let level = plural(component.level);
        notes.push(format!("the records set no upper limit to the SD between {level}"));
    }
    notes
}
