//! Difference in cost of two fleets on the same roads, and their break-even prices.
//!
//! Both drive the same cycles, and a trip counts where both complete it. In a state of the world a
//! key that both studies have with the same law has one price. With v what trips pay over a km and
//! k what a truck costs in a year, levelised, B costs as much as A at
//!
//! d* = (k_B − k_A) / (v_A − v_B)
//!
//! km a year; there is no such distance where it is not positive. A price p of energy or of the
//! battery goes into the difference linearly, Δ(p) = Δ(0) + p (Δ(1) − Δ(0)), so that the break-even
//! price is p* = −Δ(0)/(Δ(1) − Δ(0)), the same in all years.
//!
//! Two spreads are told apart. `ci95` is what the finite number of trips leaves open: percentiles
//! over [`RESAMPLES`] bootstrap samples of the trips. P5 and P95 are over states of the world, at
//! the fleets' means.

use super::comparison::AdjustedDifference;
use super::cost::{InputShare, Percentiles, STATES, batches, shares};
use super::dependence::Dependence;
use super::variance_share::{LEAST_GROUPS, drawn_again, percentiles};
use ocmc_core::cost::costing::{BREAK_EVEN_KEYS, Costing, Input, Trip};
use ocmc_core::cost::levelised::Levelised;
use ocmc_core::cost::state::State;
use ocmc_core::study::Study;
use schemars::JsonSchema;
use serde::Serialize;

/// Bootstrap samples of the trips behind an interval: percentiles of 2.5 % lie between the fifth
/// and the sixth of them.
pub const RESAMPLES: u64 = 200;

/// Difference in cost of two fleets.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CostDifference {
    /// Code of the currency of both.
    pub currency: String,
    /// Trips that both completed.
    pub pairs: u64,
    /// Trips that one of them did not complete, left out.
    pub left_out: u64,
    /// Over distance, in 1/km.
    pub per_km: Side,
    /// Over payload times distance, in 1/tkm; none where a fleet carries nothing.
    pub per_tkm: Option<Side>,
    /// Share of the trips in which A pays less, the truck included, at the centres of the prices.
    pub share_of_trips_a_cheaper: f64,
    /// Where both cost the same; none without a life.
    pub break_even_distance_km_per_a: Option<BreakEven>,
    /// Prices at which both cost the same.
    pub break_even_prices: Vec<BreakEvenPrice>,
    /// Inputs that decide the difference over km, the largest share first.
    pub inputs: Vec<InputShare>,
}

/// A and B, over one denominator.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Side {
    /// Cost of A, at the centres of the prices.
    pub a: f64,
    /// Cost of B.
    pub b: f64,
    /// B less A.
    pub difference: f64,
    /// 95 % interval over the trips that were drawn; none of fewer than ten.
    pub difference_ci95: Option<[f64; 2]>,
    /// The difference adjusted by what the trips are known to have on average; none where that is
    /// not known, or the trips are too few.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adjusted: Option<AdjustedDifference>,
    /// B less A over states of the world; none where no price is a law.
    pub difference_of_states: Option<Percentiles>,
    /// Share of the states in which A is cheaper; 0 or 1 where no price is a law.
    pub probability_a_cheaper: f64,
    /// 95 % interval over the trips that were drawn; none of fewer than ten.
    pub probability_ci95: Option<[f64; 2]>,
}

/// Where two fleets cost the same.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct BreakEven {
    /// At the centres of the prices; none where one fleet is always cheaper.
    pub value: Option<f64>,
    /// 95 % interval over the trips that were drawn; none where a sample of them has no break-even.
    pub ci95: Option<[f64; 2]>,
    /// Share of the states of the world that have one; none where no price is a law.
    pub share_of_states: Option<f64>,
    /// Over these states.
    pub states: Option<Percentiles>,
}

/// A price at which two fleets cost the same.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct BreakEvenPrice {
    /// Path of its key.
    pub key: String,
    /// Its price, the same in all years.
    #[serde(flatten)]
    pub price: BreakEven,
}

/// A side of the comparison.
#[derive(Clone, Copy, Debug)]
pub struct Fleet<'a> {
    /// Costing that applies to its trucks.
    pub costing: &'a Costing,
    /// Its trips.
    pub trips: &'a [Trip],
}

/// Both sides, trips paired.
struct Pairs<'a> {
    costing: [&'a Costing; 2],
    /// All trips together.
    all: [Trip; 2],
    /// Batches of trips that depend on one another, of both.
    batches: Vec<[Trip; 2]>,
}

/// Both sides in one state of the world.
type Both = [Levelised; 2];

impl CostDifference {
    /// Compares two fleets; none where no trip was completed by both.
    pub fn of(a: Fleet, b: Fleet, seed: u64, dependence: Dependence) -> Option<Self> {
        let (trips, left_out) = paired(a.trips, b.trips);
        let [of_a, of_b] = [0, 1].map(|side| {
            let side: Vec<Trip> = trips.iter().map(|pair| pair[side].clone()).collect();
            side
        });
        let all = [Trip::total(of_a.iter())?, Trip::total(of_b.iter())?];
        let zipped = batches(&of_a, dependence.batch).into_iter();
        let zipped = zipped.zip(batches(&of_b, dependence.batch));
        let batches = zipped.map(|(a, b)| [a, b]).collect();
        let pairs = Pairs { costing: [a.costing, b.costing], all, batches };
        let central = pairs.at(&pairs.central());
        let uncertain = pairs.uncertain();
        let states: Vec<[State; 2]> = if uncertain.is_empty() {
            Vec::new()
        } else {
            (0..STATES).map(|number| pairs.drawn(seed, number, &|_| false)).collect()
        };
        let levelised: Vec<Both> = states.iter().map(|state| pairs.at(state)).collect();
        let resampled = pairs.resampled(seed);
        let side = |over: fn(&Trip) -> f64| pairs.side(over, &central, &levelised, &resampled);
        let cheaper = trips.iter().filter(|[a, b]| central[0].cost(a) < central[1].cost(b));
        let share_of_trips_a_cheaper = cheaper.count() as f64 / trips.len() as f64;
        let distance = pairs.has_life().then(|| {
            let over_states: Vec<Option<f64>> =
                levelised.iter().map(|both| break_even_km_per_a(both, &pairs.all)).collect();
            let value = break_even_km_per_a(&central, &pairs.all);
            let over_trips: Vec<Option<f64>> =
                resampled.iter().map(|all| break_even_km_per_a(&central, all)).collect();
            BreakEven::of(value, &over_trips, &over_states)
        });
        let inputs = shares(&uncertain, seed, |number, second| {
            let [a, b] = pairs.at(&pairs.drawn(seed, number, second));
            b.per_km(&pairs.all[1]) - a.per_km(&pairs.all[0])
        });
        Some(Self {
            currency: a.costing.currency.clone(),
            pairs: trips.len() as u64,
            left_out,
            per_km: side(|trip| trip.km)?,
            per_tkm: side(|trip| trip.tkm),
            share_of_trips_a_cheaper,
            break_even_distance_km_per_a: distance,
            break_even_prices: pairs.break_even_prices(&states, &resampled),
            inputs,
        })
    }
}

impl CostDifference {
    /// With the difference over km adjusted, at the centres of the prices ([`super::adjustment`]).
    /// `ids`: all cycles that both studies have driven under the seed.
    #[must_use]
    pub fn with_adjusted(
        mut self,
        fleets: [Fleet; 2],
        studies: [&Study; 2],
        seed: u64,
        ids: &[u64],
    ) -> Self {
        let central = fleets.map(|fleet| {
            let costing = fleet.costing;
            Levelised::of(costing, &State::central(costing))
        });
        let (trips, _) = paired(fleets[0].trips, fleets[1].trips);
        let mut trips = trips.iter().peekable();
        let pairs = ids.iter().map(|id| {
            let pair = trips.next_if(|[a, _]| a.cycle_id == *id);
            let totals = |side: usize| {
                pair.map_or((0.0, 0.0), |pair| (central[side].cost(&pair[side]), pair[side].km))
            };
            [totals(0), totals(1)]
        });
        let pairs: Vec<[(f64, f64); 2]> = pairs.collect();
        self.per_km.adjusted = AdjustedDifference::of_totals(studies, seed, ids, &pairs);
        self
    }
}

/// Trips that both fleets completed, and the number of the others.
fn paired(a: &[Trip], b: &[Trip]) -> (Vec<[Trip; 2]>, u64) {
    let mut pairs = Vec::with_capacity(a.len().min(b.len()));
    let mut others = b.iter().peekable();
    for trip in a {
        while others.next_if(|other| other.cycle_id < trip.cycle_id).is_some() {}
        if let Some(other) = others.next_if(|other| other.cycle_id == trip.cycle_id) {
            pairs.push([trip.clone(), other.clone()]);
        }
    }
    let left_out = (a.len() + b.len() - 2 * pairs.len()) as u64;
    (pairs, left_out)
}

/// The distance of a year at which both cost the same over a km.
fn break_even_km_per_a([a, b]: &Both, [of_a, of_b]: &[Trip; 2]) -> Option<f64> {
    let trips_less = a.charged(of_a) / of_a.km - b.charged(of_b) / of_b.km;
    let truck_more = b.truck_per_a() - a.truck_per_a();
    Some(truck_more / trips_less).filter(|km| km.is_finite() && *km > 0.0)
}

/// The price at which a difference is zero, from those at prices of 0 and 1.
fn break_even_price(at_zero: f64, at_one: f64) -> Option<f64> {
    Some(-at_zero / (at_one - at_zero)).filter(|price| price.is_finite() && *price > 0.0)
}

impl BreakEven {
    fn of(value: Option<f64>, trips: &[Option<f64>], states: &[Option<f64>]) -> Self {
        let sample: Option<Vec<f64>> = trips.iter().copied().collect();
        let ci95 = sample.filter(|_| value.is_some()).and_then(percentiles);
        let count = states.len() as f64;
        let known: Vec<f64> = states.iter().copied().flatten().collect();
        let share_of_states = (count > 0.0).then(|| known.len() as f64 / count);
        Self { value, ci95, share_of_states, states: Percentiles::of(known) }
    }
}

impl Pairs<'_> {
    fn central(&self) -> [State; 2] {
        self.costing.map(State::central)
    }

    fn drawn(&self, seed: u64, number: u64, second: &dyn Fn(&Input) -> bool) -> [State; 2] {
        self.costing.map(|costing| State::drawn(costing, seed, number, second))
    }

    fn at(&self, [a, b]: &[State; 2]) -> Both {
        [Levelised::of(self.costing[0], a), Levelised::of(self.costing[1], b)]
    }

    /// Inputs in which states differ, of either study, each once.
    fn uncertain(&self) -> Vec<&Input> {
        let [a, b] = self.costing.map(|costing| {
            costing.inputs.iter().filter(|input| input.is_uncertain()).collect::<Vec<_>>()
        });
        let mut all = a;
        for input in b {
            if all.iter().all(|known| known.key != input.key) {
                all.push(input);
            }
        }
        all
    }

    fn has_life(&self) -> bool {
        self.costing.iter().all(|costing| costing.has_whole_life())
    }

    /// Totals of bootstrap samples of the batches, of both; none of too few batches.
    fn resampled(&self, seed: u64) -> Vec<[Trip; 2]> {
        let n = self.batches.len();
        if n < LEAST_GROUPS {
            return Vec::new();
        }
        let sample = |number| {
            let mut drawn = vec![0.0_f64; n];
            drawn_again(seed, number, n).for_each(|k| drawn[k] += 1.0);
            [0, 1].map(|side| {
                let mut total = self.batches[0][side].clone();
                total.scale(drawn[0]);
                for (pair, times) in self.batches.iter().zip(&drawn).skip(1) {
                    let mut some = pair[side].clone();
                    some.scale(*times);
                    total.add(&some);
                }
                total
            })
        };
        (0..RESAMPLES).map(sample).collect()
    }

    fn side(
        &self,
        over: fn(&Trip) -> f64,
        central: &Both,
        states: &[Both],
        resampled: &[[Trip; 2]],
    ) -> Option<Side> {
        let [a, b] = sides(over, central, &self.all)?;
        let difference = |both: &Both, trips: &[Trip; 2]| {
            sides(over, both, trips).map_or(f64::NAN, |[a, b]| b - a)
        };
        let cheaper = |trips: &[Trip; 2]| {
            let those = if states.is_empty() { std::slice::from_ref(central) } else { states };
            let count = those.iter().filter(|both| difference(both, trips) > 0.0).count();
            count as f64 / those.len() as f64
        };
        let over_states = states.iter().map(|both| difference(both, &self.all)).collect();
        Some(Side {
            a,
            b,
            difference: b - a,
            difference_ci95: percentiles(
                resampled.iter().map(|trips| difference(central, trips)).collect(),
            ),
            adjusted: None,
            difference_of_states: Percentiles::of(over_states),
            probability_a_cheaper: cheaper(&self.all),
            probability_ci95: percentiles(resampled.iter().map(cheaper).collect()),
        })
    }

    fn break_even_prices(
        &self,
        states: &[[State; 2]],
        resampled: &[[Trip; 2]],
    ) -> Vec<BreakEvenPrice> {
        let central = self.central();
        let mut prices = Vec::new();
        for key in BREAK_EVEN_KEYS {
            let inputs = self.costing.map(|costing| costing.input(key));
            if inputs == [None, None] {
                continue;
            }
            let ends = |state: &[State; 2]| {
                [0.0, 1.0].map(|price| {
                    self.at(&[state[0].with(inputs[0], price), state[1].with(inputs[1], price)])
                })
            };
            let price_of = |[zero, one]: &[Both; 2], [a, b]: &[Trip; 2]| {
                let less = |both: &Both| both[1].per_km(b) - both[0].per_km(a);
                break_even_price(less(zero), less(one))
            };
            let at_centre = ends(&central);
            let over_trips: Vec<Option<f64>> =
                resampled.iter().map(|trips| price_of(&at_centre, trips)).collect();
            let over_states: Vec<Option<f64>> =
                states.iter().map(|state| price_of(&ends(state), &self.all)).collect();
            let price = BreakEven::of(price_of(&at_centre, &self.all), &over_trips, &over_states);
            prices.push(BreakEvenPrice { key: key.to_owned(), price });
        }
        prices
    }
}

/// Both sides over a denominator; none where one is nothing.
fn sides(over: fn(&Trip) -> f64, both: &Both, trips: &[Trip; 2]) -> Option<[f64; 2]> {
    let side = |k: usize| {
        let (cost, over) = (both[k].cost(&trips[k]), over(&trips[k]));
        (over > 0.0).then(|| cost / over)
    };
    Some([side(0)?, side(1)?])
}
