//! Cost of a fleet's trips: item by item at the centres of the prices, and how far states of the
//! world differ.
//!
//! An item over km is a ratio of two totals over the completed trips, with its interval. Where a
//! price is a law, [`STATES`] states of the world are drawn, each with one price for all trips;
//! mean, P5 and P95 are over these states, at the fleet's means. Shares of that variance are those
//! of Saltelli's and Jansen's estimators with bootstrap intervals ([`variance_share`]), from as
//! many states.
//!
//! [`variance_share`]: super::variance_share

use super::clustering::Clusters;
use super::dependence::Dependence;
use super::quantile::quantile;
use super::truck_year::Total;
use super::variance_share::Outputs;
use ocmc_core::cost::CostModel;
use ocmc_core::cost::costing::{Costing, Input, Trip};
use ocmc_core::cost::emissions::TripEmissions;
use ocmc_core::cost::item::Item;
use ocmc_core::cost::levelised::{Levelised, Money};
use ocmc_core::cost::state::State;
use ocmc_core::record::Record;
use ocmc_core::study::StudyModel;
use ocmc_core::vehicle::VehicleModel;
use schemars::JsonSchema;
use serde::Serialize;

/// States of the world that are drawn where a price is a law: a probability of one half has a
/// standard error of 0.8 % then. Judgement.
pub const STATES: u64 = 4096;

/// Prices of the trips of a study, at their centres.
#[derive(Clone, Debug)]
pub struct TripPrices {
    costing: Costing,
    central: Levelised,
}

impl TripPrices {
    /// Prices of a study; none where it has none.
    pub fn of(study: &StudyModel) -> Option<Self> {
        Some(Self::new(study.cost.as_ref()?, &study.vehicle))
    }

    /// Prices of such trucks.
    pub fn new(cost: &CostModel, vehicle: &VehicleModel) -> Self {
        let costing = Costing::of(cost, vehicle);
        let central = Levelised::of(&costing, &State::central(&costing));
        Self { costing, central }
    }

    /// Code of the currency.
    pub fn currency(&self) -> &str {
        &self.costing.currency
    }

    /// Cost of a trip with its share of the truck; none of one that stalled or timed out.
    pub fn cost(&self, record: &Record) -> Option<f64> {
        Some(self.central.cost(&self.costing.trip(record)?))
    }
}

/// An item of the cost, or all of it, in the currency of the study.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ItemCost {
    /// Name of the item; `total` for all.
    pub item: &'static str,
    /// Cost of the mean trip.
    pub per_trip: f64,
    /// Sum over all trips that were driven.
    pub all_trips: f64,
    /// Over distance, in 1/km.
    pub per_km: f64,
    /// 95 % interval over the trips that were drawn.
    pub per_km_ci95: Option<[f64; 2]>,
    /// Over payload times distance, in 1/tkm; none of an empty fleet.
    pub per_tkm: Option<f64>,
    /// Cost of a truck in a year, in 1/a; none without a life.
    pub per_a: Option<f64>,
    /// Cost of a truck over its whole life, worth at its start; none without a life.
    pub whole_life: Option<f64>,
    /// Cost of a truck over its whole life, as it is paid; none without a life.
    pub whole_life_paid: Option<f64>,
}

/// Cost of a fleet of trucks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct FleetOfTrucks {
    /// Trucks.
    pub trucks: u64,
    /// Trips that each of them makes.
    pub trips_per_truck: u64,
    /// Cost of all of them, and where another fleet of as many lies.
    pub cost: Total,
}

/// How the total differs between states of the world.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CostSpread {
    /// States that were drawn.
    pub states: u64,
    /// Cost of the mean trip.
    pub per_trip: Percentiles,
    /// Over distance, in 1/km.
    pub per_km: Percentiles,
    /// Over payload times distance, in 1/tkm; none of an empty fleet.
    pub per_tkm: Option<Percentiles>,
    /// Cost of a truck in a year, in 1/a; none without a life.
    pub per_a: Option<Percentiles>,
    /// Cost of a truck over its whole life, worth at its start; none without a life.
    pub whole_life: Option<Percentiles>,
}

/// Mean and percentiles over states of the world, or over trips.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Percentiles {
    /// Mean.
    pub mean: f64,
    /// 5 % lie below.
    pub p5: f64,
    /// Half of them.
    pub p50: f64,
    /// 95 % of them.
    pub p95: f64,
}

/// Share of the variance between states of the world that an input explains.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct InputShare {
    /// Path of its key.
    pub key: String,
    /// Share that it explains alone.
    pub first: f64,
    /// 95 % interval.
    pub first_ci95: Option<[f64; 2]>,
    /// Share that would be gone if it were fixed, joint effects included.
    pub total: f64,
    /// 95 % interval.
    pub total_ci95: Option<[f64; 2]>,
}

/// Emissions of a fleet's trips over distance.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct FleetEmissions {
    /// From tank to wheel, in kg of CO2 per km.
    pub tank_to_wheel_kg_per_km: f64,
    /// 95 % interval.
    pub tank_to_wheel_ci95: Option<[f64; 2]>,
    /// From well to wheel, in kg of CO2 equivalents per km; none without a factor.
    pub well_to_wheel_kg_per_km: Option<f64>,
    /// 95 % interval.
    pub well_to_wheel_ci95: Option<[f64; 2]>,
    /// From well to wheel, in kg of CO2 equivalents per tkm; none without a factor, and of an empty
    /// fleet.
    pub well_to_wheel_kg_per_tkm: Option<f64>,
}

/// Cost of a fleet.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct FleetCost {
    /// Code of the currency.
    pub currency: String,
    /// Trips that were completed; the others have no cost.
    pub trips: u64,
    /// Trips that were not.
    pub failed: u64,
    /// Cost of trucks that make several trips; none where each trip has a truck of its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fleet: Option<FleetOfTrucks>,
    /// Mean distance of a trip, in km.
    pub km_per_trip: f64,
    /// Mean payload over distance, in t.
    pub mean_payload_t: f64,
    /// The items that have a price.
    pub items: Vec<ItemCost>,
    /// All of them.
    pub total: ItemCost,
    /// How trips differ in it, at the centres of the prices: of a trip, unweighted.
    pub over_trips: Percentiles,
    /// How states of the world differ; none where no price is a law.
    pub spread: Option<CostSpread>,
    /// Inputs that decide, the largest share first.
    pub inputs: Vec<InputShare>,
    /// Greenhouse gases.
    pub emissions: FleetEmissions,
}

impl Percentiles {
    /// Percentiles of some values; none of no values.
    pub fn of(mut values: Vec<f64>) -> Option<Self> {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.sort_unstable_by(f64::total_cmp);
        let at = |level| quantile(&values, level);
        Some(Self { mean, p5: at(0.05)?, p50: at(0.5)?, p95: at(0.95)? })
    }
}

/// Totals of batches of trips that depend on one another.
pub(super) fn batches(trips: &[Trip], batch: u64) -> Vec<Trip> {
    let mut totals: Vec<Trip> = Vec::new();
    for trip in trips {
        match totals.last_mut() {
            Some(last) if last.cycle_id / batch == trip.cycle_id / batch => last.add(trip),
            _ => totals.push(trip.clone()),
        }
    }
    totals
}

impl FleetCost {
    /// Cost of these trips; none of no trips. `seed` fixes the states of the world.
    pub fn of(
        costing: &Costing,
        trips: &[Trip],
        emitted: &[TripEmissions],
        failed: u64,
        seed: u64,
        dependence: Dependence,
    ) -> Option<Self> {
        let all = Trip::total(trips.iter())?;
        let clusters = Clusters::of(dependence, trips.iter().map(|trip| trip.cycle_id));
        let batches = if clusters.has_several_ways() {
            trips.to_vec()
        } else {
            batches(trips, dependence.batch)
        };
        let state = State::central(costing);
        let central = Levelised::of(costing, &state);
        let fleet = Fleet { costing, all, clusters, batches, trips: trips.len() as f64 };
        let present = |item: &Item| {
            fleet.costing.charges.iter().any(|charge| charge.item == *item)
                || central.truck.iter().any(|(known, _)| known == item)
        };
        let items = Item::ALL.into_iter().filter(present);
        let items = items.map(|item| fleet.item(&central, Some(item))).collect();
        let total = fleet.item(&central, None);
        let of_trips: Vec<(u64, f64)> =
            trips.iter().map(|trip| (trip.cycle_id, central.cost(trip))).collect();
        let trips_per_truck = dependence.trips_per_truck;
        let of_truck =
            |a: &Trip, b: &Trip| a.cycle_id / trips_per_truck == b.cycle_id / trips_per_truck;
        let of_trucks = dependence.has_trucks().then(|| FleetOfTrucks {
            trucks: trips.chunk_by(of_truck).count() as u64,
            trips_per_truck,
            cost: Total::of_trips(&of_trips, &fleet.clusters, dependence),
        });
        let over_trips = of_trips.into_iter().map(|(_, cost)| cost).collect();
        let uncertain: Vec<&Input> =
            costing.inputs.iter().filter(|input| input.is_uncertain()).collect();
        let spread = if uncertain.is_empty() { None } else { fleet.spread(seed) };
        let inputs = shares(&uncertain, seed, |number, second| {
            let state = State::drawn(costing, seed, number, second);
            Levelised::of(costing, &state).per_km(&fleet.all)
        });
        Some(Self {
            currency: costing.currency.clone(),
            trips: trips.len() as u64,
            failed,
            fleet: of_trucks,
            km_per_trip: fleet.all.km / fleet.trips,
            mean_payload_t: fleet.all.tkm / fleet.all.km,
            items,
            total,
            over_trips: Percentiles::of(over_trips)?,
            spread,
            inputs,
            emissions: FleetEmissions::of(emitted, dependence)?,
        })
    }
}

/// The trips of a fleet, and what they pay for.
struct Fleet<'a> {
    costing: &'a Costing,
    all: Trip,
    /// In which clusters trips are.
    clusters: Clusters,
    /// Totals of batches of trips; where they belong together in several ways, each trip.
    batches: Vec<Trip>,
    trips: f64,
}

impl Fleet<'_> {
    /// An item, or all of them.
    fn item(&self, central: &Levelised, item: Option<Item>) -> ItemCost {
        let is_item = |known: Item| item.is_none_or(|item| item == known);
        let priced = || {
            let charges = self.costing.charges.iter().zip(&central.prices).enumerate();
            charges.filter(|(_, (charge, _))| is_item(charge.item))
        };
        let charged = |trip: &Trip, money: fn(&Money) -> f64| -> f64 {
            priced().map(|(k, (_, price))| money(price) * trip.amounts[k]).sum()
        };
        let truck = central.truck.iter().filter(|(known, _)| is_item(*known));
        let truck = truck.fold(Money::default(), |sum, (_, money)| Money {
            paid: sum.paid + money.paid,
            discounted: sum.discounted + money.discounted,
        });
        let life = central.life.as_ref();
        let truck_per_km =
            life.map_or(0.0, |life| truck.discounted / (life.discounted_a * life.km_per_a));
        let cost = |trip: &Trip| charged(trip, |m| m.discounted) + truck_per_km * trip.km;
        let rows = self.batches.iter().map(|trips| (trips.cycle_id, cost(trips), trips.km));
        let per_km = self.clusters.ratio(rows).expect("trips have a length");
        let Trip { km, tkm, .. } = self.all;
        let paid_per_km = charged(&self.all, |m| m.paid) / km;
        ItemCost {
            item: item.map_or("total", Item::name),
            per_trip: cost(&self.all) / self.trips,
            all_trips: cost(&self.all),
            per_km: per_km.ratio,
            per_km_ci95: per_km.ci95,
            per_tkm: (tkm > 0.0).then(|| cost(&self.all) / tkm),
            per_a: life.map(|life| per_km.ratio * life.km_per_a),
            whole_life: life.map(|life| per_km.ratio * life.km_per_a * life.discounted_a),
            whole_life_paid: life
                .map(|life| paid_per_km * life.km_per_a * life.years_a + truck.paid),
        }
    }

    /// How the total differs between states of the world.
    fn spread(&self, seed: u64) -> Option<CostSpread> {
        let states: Vec<Levelised> = (0..STATES)
            .map(|number| State::drawn(self.costing, seed, number, |_| false))
            .map(|state| Levelised::of(self.costing, &state))
            .collect();
        let over =
            |per: &dyn Fn(&Levelised) -> f64| Percentiles::of(states.iter().map(per).collect());
        let Trip { km, tkm, .. } = self.all;
        let has_life = self.costing.has_whole_life();
        let per_a = |state: &Levelised| {
            state.life.as_ref().map_or(0.0, |life| life.km_per_a) * state.per_km(&self.all)
        };
        let years = |state: &Levelised| state.life.as_ref().map_or(0.0, |life| life.discounted_a);
        Some(CostSpread {
            states: STATES,
            per_trip: over(&|state| state.cost(&self.all) / self.trips)?,
            per_km: over(&|state| state.cost(&self.all) / km)?,
            per_tkm: if tkm > 0.0 { over(&|state| state.cost(&self.all) / tkm) } else { None },
            per_a: if has_life { over(&per_a) } else { None },
            whole_life: if has_life { over(&|state| per_a(state) * years(state)) } else { None },
        })
    }
}

/// Share of the variance of an output that each input explains, the largest total first. `output`
/// gives it of a state by its number and by which inputs come from the second sample.
pub(super) fn shares(
    inputs: &[&Input],
    seed: u64,
    output: impl Fn(u64, &dyn Fn(&Input) -> bool) -> f64,
) -> Vec<InputShare> {
    if inputs.is_empty() {
        return Vec::new();
    }
    let all = |second: &dyn Fn(&Input) -> bool| -> Vec<f64> {
        (0..STATES).map(|number| output(number, second)).collect()
    };
    let outputs = Outputs {
        a: all(&|_| false),
        b: all(&|_| true),
        ab: inputs.iter().map(|input| all(&|other| other.key == input.key)).collect(),
        groups: (0..STATES as usize).map(|row| vec![row]).collect(),
    };
    let (_, variance) = outputs.moments();
    if !(variance > 0.0) {
        return Vec::new();
    }
    let mut shares: Vec<InputShare> = inputs
        .iter()
        .zip(outputs.shares(seed))
        .map(|(input, share)| InputShare {
            key: input.key.clone(),
            first: share.first,
            first_ci95: share.first_ci95,
            total: share.total,
            total_ci95: share.total_ci95,
        })
        .collect();
    shares.sort_by(|a, b| b.total.total_cmp(&a.total));
    shares
}

impl FleetEmissions {
    fn of(emitted: &[TripEmissions], dependence: Dependence) -> Option<Self> {
        let clusters = Clusters::of(dependence, emitted.iter().map(|trip| trip.cycle_id));
        let ratio = |kg: fn(&TripEmissions) -> Option<f64>, over: fn(&TripEmissions) -> f64| {
            let known = emitted.iter().map(|trip| Some((trip.cycle_id, kg(trip)?, over(trip))));
            let known: Option<Vec<(u64, f64, f64)>> = known.collect();
            clusters.ratio(known?.into_iter())
        };
        let tank = ratio(|trip| Some(trip.tank_to_wheel_kg), |trip| trip.km)?;
        let well = ratio(|trip| trip.well_to_wheel_kg, |trip| trip.km);
        Some(Self {
            tank_to_wheel_kg_per_km: tank.ratio,
            tank_to_wheel_ci95: tank.ci95,
            well_to_wheel_kg_per_km: well.map(|well| well.ratio),
            well_to_wheel_ci95: well.and_then(|well| well.ci95),
            well_to_wheel_kg_per_tkm: ratio(|trip| trip.well_to_wheel_kg, |trip| trip.tkm)
                .map(|well| well.ratio),
        })
    }
}
