//! The best that is possible: the least energy for the same road, truck and trip time.
//!
//! A cycle is driven by its driver and traced. The optimum has his road, his truck, his stops and
//! rests; it is never faster than his plan or, where he was faster, than he was; it takes no more
//! time. It is found by dynamic programming over speed and gear (Bellman 1957), with a price λ of
//! time such that the trip takes as long as his: least energy + λ time, leg by leg from rest to
//! rest. A shift takes the time that the gearbox needs, without torque, and the next one comes no
//! sooner than the gearbox allows. The clutch opens for shifts alone: the truck does not roll with
//! an open clutch otherwise.
//!
//! What a move takes is what the backward mode takes ([`ocmc_core::prescribed`]): air of the
//! departure, without wind, a smooth road, the engine's torque without a lag. The driver's own
//! speed and gears are driven by the same mode, and the two are compared. A joule that the engine
//! could not give there, because he had a tail wind, is paid for with what a joule at the wheels
//! took him.

mod driven;
mod fleet;
mod grid;
mod level;
mod moves;
mod potential;
mod solve;
mod sweep;
#[cfg(test)]
mod tests;

pub use driven::{Driven, DrivenLeg, Heights};
pub use fleet::{TripBound, bounds};
pub use grid::Fineness;
pub use level::{LevelRoad, level_road};
pub use ocmc_core::event_kind::Kind;
pub use potential::Potential;

use grid::{Place, places};
use moves::Truck;
use ocmc_core::energy::ledger::{Ledger, Term};
use ocmc_core::powertrain::{GearOrder, InversePowertrain, Powertrain, PowertrainTask};
use ocmc_core::prescribed::{Body, DriveCycle, follow_observed};
use ocmc_core::record::{Outcome, Record};
use ocmc_core::study::{Scenario, Study};
use ocmc_core::tactical::{SpeedProfile, plan};
use solve::{Answer, FROM_NOTHING, FROM_TRACKS, PRICES, Problem, Question, Track};
use std::sync::atomic::AtomicBool;
use thiserror::Error;

/// Prices of time among which the search begins, as shares of the power that the driver took.
const FIRST_PRICES: [f64; 2] = [0.02, 20.0];

/// Why a cycle has no bound.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BoundError {
    /// The driver did not arrive.
    #[error(
        "cycle {cycle_id} is not completed ({}): there is no drive to compare with", outcome.name()
    )]
    NotCompleted {
        /// The cycle.
        cycle_id: u64,
        /// How it ended.
        outcome: Outcome,
    },
    /// The truck does not have one mass on its way.
    #[error(
        "cycle {cycle_id} changes its load or works with its body at stops: the bound is one of \
         trucks with one load; leave out `mission.stops.cargo` and `mission.stops.power_take_off`"
    )]
    LoadChanges {
        /// The cycle.
        cycle_id: u64,
    },
}

/// Energy of a speed with its gears in the backward mode.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Energy from tank or battery, what is missing paid for, in J.
    pub energy_j: f64,
    /// Energy from tank or battery, in J.
    pub source_j: f64,
    /// Energy that was missing at the wheels, in J.
    pub missing_j: f64,
    /// Energy that brought the engine to the speeds of new gears, in J.
    pub jumps_j: f64,
    /// Energy at the wheels, in J.
    pub wheel_j: f64,
    /// Duration with all rests, in s.
    pub duration_s: f64,
    /// Distance, in m.
    pub distance_m: f64,
    /// Shifts.
    pub n_gear_shifts: u32,
    /// Energy by road type, in the order of the study, in J.
    pub by_road_type_j: Vec<f64>,
    /// Energy that has to be paid for by road type, in J.
    unpaid_j: Vec<f64>,
    /// All integrals.
    pub ledger: Ledger<f64>,
    /// Kinetic energy at the end less at the start, in J.
    pub kinetic_j: f64,
}

/// The best that is possible for one cycle.
#[derive(Clone, Debug)]
pub struct Bound {
    /// Id of the cycle.
    pub cycle_id: u64,
    /// Record of the simulation.
    pub record: Record,
    /// The driver's speed and gears in the backward mode.
    pub driver: Figure,
    /// The optimum in the backward mode; the driver's own where the search found nothing better.
    pub optimum: Figure,
    /// Whether the search found better than the driver.
    pub is_better: bool,
    /// Worth of a second more, in W; none where nothing was found.
    pub price_w: Option<f64>,
    /// The optimum, speed and gears over time.
    pub cycle: DriveCycle,
    /// The driver's own speed and gears over time.
    pub driven_cycle: DriveCycle,
}

impl Bound {
    /// Share of the driver's energy that was not needed.
    pub fn potential(&self) -> f64 {
        1.0 - self.optimum.energy_j / self.driver.energy_j
    }
}

/// The bound of a cycle of a study.
///
/// # Errors
/// [`BoundError`] where the driver does not arrive, and where the load changes on the way.
pub fn bound(
    study: &Study,
    seed: u64,
    cycle_id: u64,
    fineness: Fineness,
) -> Result<Bound, BoundError> {
    bound_scenario(study, &study.sample(seed, cycle_id), fineness)
}

/// The bound of a scenario.
///
/// # Errors
/// [`BoundError`] where the driver does not arrive, and where the load changes on the way.
pub fn bound_scenario(
    study: &Study,
    scenario: &Scenario,
    fineness: Fineness,
) -> Result<Bound, BoundError> {
    let driven = completed(study, scenario)?;
    let stop = &AtomicBool::new(false);
    let task = BoundTask { study, scenario, driven, fineness, stop, apart: false };
    Ok(study.vehicle().powertrain.dispatch(task).0)
}

/// The bound of a scenario, and where the driver's potential lies. Once the flag is set, the search
/// gives up, and what it gives is worth nothing.
fn potential(
    study: &Study,
    scenario: &Scenario,
    fineness: Fineness,
    stop: &AtomicBool,
) -> Result<(Bound, Option<Potential>), BoundError> {
    let driven = completed(study, scenario)?;
    let task = BoundTask { study, scenario, driven, fineness, stop, apart: true };
    Ok(study.vehicle().powertrain.dispatch(task))
}

/// Drives a scenario whose driver has to arrive, with one load.
fn completed(study: &Study, scenario: &Scenario) -> Result<Driven, BoundError> {
    if !scenario.loads.is_empty() {
        return Err(BoundError::LoadChanges { cycle_id: scenario.cycle_id });
    }
    let driven = Driven::of(study, scenario);
    match driven.record.outcome {
        Outcome::Completed => Ok(driven),
        outcome => Err(BoundError::NotCompleted { cycle_id: scenario.cycle_id, outcome }),
    }
}

struct BoundTask<'a> {
    study: &'a Study,
    scenario: &'a Scenario,
    driven: Driven,
    fineness: Fineness,
    /// Once it is set, the search gives up.
    stop: &'a AtomicBool,
    /// Whether the potential is taken apart.
    apart: bool,
}

impl PowertrainTask for BoundTask<'_> {
    type Answer = (Bound, Option<Potential>);

    fn run<P: Powertrain>(self, powertrain: &P) -> Self::Answer {
        let weather = &self.scenario.cycle.weather[0].weather;
        let climate_w = powertrain.climate_w(weather.temperature_k);
        let inputs = self.scenario.vehicle.powertrain_inputs(climate_w);
        let fresh = || powertrain.inverse(&inputs);
        let trip = Trip::new(&self, &fresh);
        let (bound, tracks) = trip.bound();
        let potential = self.apart.then(|| trip.potential(&bound, tracks));
        (bound, potential)
    }
}

/// One cycle while its bound is found.
struct Trip<'a> {
    study: &'a Study,
    scenario: &'a Scenario,
    driven: &'a Driven,
    fineness: Fineness,
    stop: &'a AtomicBool,
    body: Body,
    heights: Heights,
    places: Vec<Vec<Place>>,
    /// A powertrain at its start.
    fresh: &'a dyn Fn() -> Box<dyn InversePowertrain + 'a>,
}

impl<'a> Trip<'a> {
    fn new(
        task: &'a BoundTask<'a>,
        fresh: &'a dyn Fn() -> Box<dyn InversePowertrain + 'a>,
    ) -> Self {
        let BoundTask { study, scenario, driven, fineness, stop, .. } = task;
        let heights = Heights::of(scenario);
        let mut profile = SpeedProfile::default();
        plan(study, scenario, &mut profile);
        let legs = driven.legs.iter();
        let places = legs.map(|leg| places(leg, &profile, &heights, fineness)).collect();
        let body = Body::of(study, scenario);
        Self { study, scenario, driven, fineness: *fineness, stop, body, heights, places, fresh }
    }

    /// The bound, and the tracks of the optimum where one was found.
    fn bound(&self) -> (Bound, Option<Vec<Track>>) {
        let driven_cycle = self.driven.cycle_of(&self.driven.legs, &self.heights);
        let mut driver = self.figure(&driven_cycle, &self.driven.legs);
        let price = driver.source_j / driver.wheel_j.max(1.0);
        driver.pay(price);
        let inverse = (self.fresh)();
        let truck = Truck::new(self.body, &*inverse, price);
        let moving_s: f64 = self.driven.legs.iter().map(DrivenLeg::duration_s).sum();
        let free = self.places.iter().map(|places| vec![true; places.len()]).collect();
        let power_w = driver.energy_j / driver.duration_s;
        let range = FIRST_PRICES.map(|share| share * power_w);
        let answer = self.answer::<PRICES>(&truck, moving_s, range, free, None);
        let tracks = answer.as_ref().map(|answer| answer.tracks(&self.places));
        let better = answer.and_then(|answer| {
            let legs = self.legs_of(&answer, &truck);
            let cycle = self.driven.cycle_of(&legs, &self.heights);
            let mut optimum = self.figure(&cycle, &legs);
            optimum.pay(price);
            let fits = optimum.duration_s <= driver.duration_s * (1.0 + 1e-9);
            (fits && optimum.energy_j <= driver.energy_j).then_some((
                optimum,
                cycle,
                answer.price_w,
            ))
        });
        let is_better = better.is_some();
        let price_w = better.as_ref().map(|(_, _, price_w)| *price_w);
        let (optimum, cycle) = match better {
            Some((optimum, cycle, _)) => (optimum, cycle),
            None => (driver.clone(), driven_cycle.clone()),
        };
        let record = self.driven.record.clone();
        let cycle_id = self.scenario.cycle_id;
        (
            Bound { cycle_id, record, driver, optimum, is_better, price_w, cycle, driven_cycle },
            tracks,
        )
    }

    /// The least energy in so much time, where the speed is free; `around`: tracks of the legs that
    /// the search begins around.
    fn answer<const N: usize>(
        &self,
        truck: &Truck,
        most_s: f64,
        prices_w: [f64; 2],
        free: Vec<Vec<bool>>,
        around: Option<Vec<[Track; 2]>>,
    ) -> Option<Answer> {
        let stages = if around.is_some() { &FROM_TRACKS[..] } else { &FROM_NOTHING };
        let legs = self.driven.legs.iter().zip(&self.places).zip(free);
        let legs = legs.map(|((leg, places), free)| Problem { leg, places, free }).collect();
        let Self { heights, fineness, stop, .. } = self;
        let fineness = *fineness;
        Question { truck, heights, legs, most_s, prices_w, stages, fineness, stop }
            .answer::<N>(around)
    }

    /// The legs of an answer, step by step.
    fn legs_of(&self, answer: &Answer, truck: &Truck) -> Vec<DrivenLeg> {
        let all = answer.ways.iter().zip(&self.places).zip(&self.driven.legs);
        let leg_of = |((way, places), driven): ((&sweep::Way, &Vec<Place>), &DrivenLeg)| {
            let mut leg = DrivenLeg::begin();
            (leg.rest_s, leg.road_m) = (driven.rest_s, driven.road_m);
            let (mut at, mut now_mps) = (0, places[0].driven_mps);
            leg.speed_mps[0] = now_mps;
            for step in &way.moves {
                let mut way_m = places[step.to].way_m - places[at].way_m;
                if let Some(gap) = step.gap {
                    let dt_s = gap.way_m / (0.5 * (now_mps + gap.speed_mps));
                    leg.push(dt_s, gap.speed_mps, GearOrder::Open);
                    way_m -= gap.way_m;
                    now_mps = gap.speed_mps;
                }
                let dt_s = way_m / (0.5 * (now_mps + step.speed_mps));
                leg.push(dt_s, step.speed_mps, truck.order(step.gear));
                (at, now_mps) = (step.to, step.speed_mps);
            }
            leg
        };
        all.map(leg_of).collect()
    }

    /// Figure of a drive cycle; nothing is paid for yet. `legs`: its legs.
    fn figure(&self, cycle: &DriveCycle, legs: &[DrivenLeg]) -> Figure {
        let sections = &self.scenario.cycle.road.sections;
        let mut by_road_type_j = vec![0.0; self.study.road_types().len()];
        let mut unpaid_by_type_j = by_road_type_j.clone();
        let mut unpaid_j = 0.0;
        let mut inverse = (self.fresh)();
        let stores = inverse.stores();
        let (mut leg, mut way_m, mut section, mut before_j) = (0, 0.0, 0, 0.0);
        let (mut jumps_j, mut lost_j) = (0.0, 0.0);
        let followed = follow_observed(cycle, &self.body, &mut *inverse, &mut |step, ledger| {
            way_m += step.speed.distance_m();
            jumps_j += (lost_j - ledger[Term::Shift]).max(0.0);
            lost_j = ledger[Term::Shift];
            let place_m = legs[leg].place_m(way_m.min(legs[leg].length_m()));
            while section + 1 < sections.len() && sections[section].end_m < place_m {
                section += 1;
            }
            let road_type = sections[section].road_type;
            let given_j: f64 = stores.iter().map(|store| ledger[*store]).sum();
            by_road_type_j[road_type] += given_j - before_j;
            before_j = given_j;
            unpaid_by_type_j[road_type] += jumps_j + ledger[Term::Missing] - unpaid_j;
            unpaid_j = jumps_j + ledger[Term::Missing];
            if step.speed.distance_m() <= 0.0 && way_m > 0.0 && leg + 1 < legs.len() {
                (leg, way_m) = (leg + 1, 0.0);
            }
        });
        let ledger = followed.ledger;
        Figure {
            energy_j: before_j,
            source_j: before_j,
            missing_j: ledger[Term::Missing],
            jumps_j,
            wheel_j: ledger[Term::Wheel],
            duration_s: followed.duration_s,
            distance_m: ledger[Term::Distance],
            n_gear_shifts: inverse.n_shifts(),
            by_road_type_j,
            unpaid_j: unpaid_by_type_j,
            ledger,
            kinetic_j: followed.kinetic_j,
        }
    }
}

impl Figure {
    /// Pays for what is missing, in J of the source a J.
    fn pay(&mut self, price: f64) {
        self.energy_j = self.source_j + price * (self.missing_j + self.jumps_j);
        for (by_road_type_j, unpaid_j) in self.by_road_type_j.iter_mut().zip(&mut self.unpaid_j) {
            *by_road_type_j += price * std::mem::take(unpaid_j);
        }
    }
}
