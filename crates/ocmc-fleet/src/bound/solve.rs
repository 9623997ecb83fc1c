//! The least energy over all legs of a trip in at most so much time: one price of time for all
//! legs, found from coarse to fine. Each stage knows eight prices at once; the next one looks
//! closer, at the prices and at the speeds around what was found.

use super::driven::{DrivenLeg, Heights};
use super::grid::{Fineness, Place};
use super::moves::{Levels, Move, Search, Truck};
use super::sweep::{PRICES, Swept, Way};
use std::sync::atomic::AtomicBool;

/// By how much the prices of the next stage reach beyond what a stage has found.
const BEYOND: [f64; 4] = [1.1, 1.03, 1.01, 1.0];
/// Lowest speed of the first stage, in m/s, and as a share of the highest.
const LOWEST_MPS: f64 = 1.0;
const LOWEST_SHARE: f64 = 0.25;
/// Spacing of the speeds by stage, as multiples of the last one's.
const SPACINGS: [f64; 4] = [4.0, 2.0, 1.0, 1.0];
/// How far the speeds of a stage reach beyond what the one before has found, in its spacings.
const REACH: f64 = 4.0;
/// How often prices beside those of a stage are tried, and by how much they differ at least.
const MOST_SHIFTED: u32 = 4;
const LEAST_SPAN: f64 = 1.2;
/// Rounding of times, as a share.
const ROUNDING: f64 = 1e-9;

/// A leg, and where its speed is free.
#[derive(Clone, Debug)]
pub(super) struct Problem<'a> {
    /// The leg as it was driven.
    pub leg: &'a DrivenLeg,
    /// Its places.
    pub places: &'a [Place],
    /// For each place whether its speed is free; elsewhere it is as it was driven.
    pub free: Vec<bool>,
}

/// What is asked for over all legs.
pub(super) struct Question<'a> {
    /// The truck.
    pub truck: &'a Truck<'a>,
    /// Heights along the road.
    pub heights: &'a Heights,
    /// The legs.
    pub legs: Vec<Problem<'a>>,
    /// Time that the legs may take together, in s; without end where time has one price.
    pub most_s: f64,
    /// Prices of time among which the search begins, in W.
    pub prices_w: [f64; 2],
    /// How fine the search is.
    pub fineness: Fineness,
    /// Once it is set, there is no answer.
    pub stop: &'a AtomicBool,
}

/// Ways along all legs.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Answer {
    /// One a leg.
    pub ways: Vec<Way>,
    /// Price of time, in W.
    pub price_w: f64,
}

impl Answer {
    /// Energy, in J, with the price of what is missing.
    pub(super) fn energy_j(&self) -> f64 {
        self.ways.iter().map(|way| way.energy_j).sum()
    }

    /// Moving time, in s.
    pub(super) fn time_s(&self) -> f64 {
        self.ways.iter().map(|way| way.time_s).sum()
    }
}

/// Speeds at the places of a leg on a way along it, in m/s.
fn speeds_at(way: &Way, places: &[Place]) -> Vec<f64> {
    let mut speeds = vec![0.0; places.len()];
    let (mut at, mut now) = (0, places[0].driven_mps);
    speeds[0] = now;
    for Move { to, speed_mps, .. } in &way.moves {
        for k in at + 1..=*to {
            let whole_m = places[*to].way_m - places[at].way_m;
            let share = (places[k].way_m - places[at].way_m) / whole_m;
            let square: f64 = now * now + share * (speed_mps * speed_mps - now * now);
            speeds[k] = square.sqrt();
        }
        (at, now) = (*to, *speed_mps);
    }
    speeds
}

/// The speeds that are tried at the places of a leg; `around`: speeds to stay near to.
fn levels(leg: &Problem, about_mps: f64, around: Option<[&[f64]; 2]>) -> Vec<Levels> {
    let last = leg.places.len() - 1;
    let of = |(k, place): (usize, &Place)| {
        if k == 0 || k == last || !leg.free[k] {
            return Levels::between(place.driven_mps, place.driven_mps, 1.0);
        }
        let most_mps = place.most_mps;
        let lowest_mps = LOWEST_MPS.max(LOWEST_SHARE * most_mps).min(0.5 * most_mps);
        let (low_mps, high_mps) = match around {
            None => (lowest_mps, most_mps),
            Some([a, b]) => {
                let reach_mps = REACH * about_mps;
                let low_mps = (a[k].min(b[k]) - reach_mps).max(lowest_mps.min(0.5));
                (low_mps.min(most_mps), (a[k].max(b[k]) + reach_mps).min(most_mps))
            }
        };
        Levels::between(low_mps, high_mps, about_mps)
    };
    leg.places.iter().enumerate().map(of).collect()
}

impl Question<'_> {
    /// The least energy in the time; none where no way was found.
    pub(super) fn answer(&self) -> Option<Answer> {
        let mut range = self.prices_w;
        let pinned = self.legs.iter().all(|leg| leg.free.iter().all(|free| !free));
        let mut around: Option<Vec<[Vec<f64>; 2]>> = None;
        let mut best: Option<Answer> = None;
        let (mut stage, mut shifted) = (0, 0);
        while stage < SPACINGS.len() {
            let (spacing, beyond) = (SPACINGS[stage], BEYOND[stage]);
            stage += 1;
            let about_mps = spacing * self.fineness.speed_mps;
            let ratio = libm::pow(range[1] / range[0], 1.0 / (PRICES as f64 - 1.0));
            let mut prices = [range[0]; PRICES];
            for k in 1..PRICES {
                prices[k] = prices[k - 1] * ratio;
            }
            let near = |k: usize| -> Option<[&[f64]; 2]> {
                around.as_ref().map(|around| [&around[k][0][..], &around[k][1][..]])
            };
            let of = |(k, leg): (usize, &Problem)| levels(leg, about_mps, near(k));
            let levels: Vec<Vec<Levels>> = self.legs.iter().enumerate().map(of).collect();
            let searches: Vec<Search> = self.searches(&levels);
            let swept: Option<Vec<Swept>> =
                searches.iter().map(|search| Swept::of(search, &prices, self.stop)).collect();
            let swept = swept?;
            let found: Vec<[Option<Way>; PRICES]> =
                searches.iter().zip(&swept).map(|(search, swept)| swept.ways(search)).collect();
            let time_s = |price: usize| -> f64 {
                let time_s = |ways: &[Option<Way>; PRICES]| {
                    ways[price].as_ref().map_or(f64::INFINITY, |way| way.time_s)
                };
                found.iter().map(time_s).sum()
            };
            let in_time = |price: &usize| time_s(*price) <= self.most_s * (1.0 + ROUNDING);
            let fast = (0..PRICES).find(in_time);
            let high = fast.unwrap_or(PRICES - 1);
            let low = high.saturating_sub(1);
            if fast.is_some() {
                let mixed = self.mix(&found, high, prices[high]);
                let answer = mixed.map(|mixed| self.fill(mixed, &searches, &swept, &found, high));
                best = self.better(best, answer);
            }
            if pinned {
                return best;
            }
            if time_s(low).is_infinite() || time_s(high).is_infinite() {
                return best;
            }
            let near = found.iter().zip(&self.legs).map(|(ways, leg)| {
                [low, high].map(|price| {
                    let way = ways[price].as_ref();
                    way.map_or_else(Vec::new, |way| speeds_at(way, leg.places))
                })
            });
            around = Some(near.collect());
            if self.most_s.is_infinite() {
                continue;
            }
            range = [prices[low] / beyond, prices[high] * beyond];
            let span = (prices[PRICES - 1] / prices[0]).max(LEAST_SPAN);
            if fast.is_none() || high == 0 {
                // the price lies beside those that were tried
                let above = fast.is_none();
                let first = if above { prices[high] / ratio } else { prices[0] * ratio / span };
                range = [first, first * span];
                if shifted < MOST_SHIFTED {
                    (stage, shifted) = (stage - 1, shifted + 1);
                }
            }
        }
        best
    }

    /// The ways at the higher price of time; where there is time left, the slower ways that save
    /// most take it.
    fn mix(&self, found: &[[Option<Way>; PRICES]], high: usize, price_w: f64) -> Option<Answer> {
        let ways: Option<Vec<Way>> = found.iter().map(|ways| ways[high].clone()).collect();
        let mut answer = Answer { ways: ways?, price_w };
        let mut left_s = self.most_s - answer.time_s();
        loop {
            let mut best: Option<(f64, usize, &Way)> = None;
            for (k, (way, ways)) in answer.ways.iter().zip(found).enumerate() {
                for other in ways.iter().flatten() {
                    let saved_j = way.energy_j - other.energy_j;
                    let fits = other.time_s - way.time_s <= left_s;
                    if fits && saved_j > best.map_or(0.0, |(saved_j, ..)| saved_j) {
                        best = Some((saved_j, k, other));
                    }
                }
            }
            let Some((_, k, other)) = best else { return Some(answer) };
            left_s -= other.time_s - answer.ways[k].time_s;
            answer.ways[k] = other.clone();
        }
    }

    /// Takes the time that is still left: a leg goes at the higher price of time up to some place,
    /// and from there on at the lower one.
    fn fill(
        &self,
        mut answer: Answer,
        searches: &[Search],
        swept: &[Swept],
        found: &[[Option<Way>; PRICES]],
        high: usize,
    ) -> Answer {
        if high == 0 || self.most_s.is_infinite() {
            return answer;
        }
        for (k, (search, swept)) in searches.iter().zip(swept).enumerate() {
            let left_s = self.most_s - answer.time_s();
            // a leg that was slowed already has taken its time
            if found[k][high].as_ref().is_none_or(|way| way.time_s != answer.ways[k].time_s) {
                continue;
            }
            let (mut from, mut to) = (0, search.places.len() - 1);
            while from < to {
                let middle = from.midpoint(to);
                let way = swept.way(search, [high, high - 1], middle);
                let fits = |way: &Way| way.time_s - answer.ways[k].time_s <= left_s;
                if way.as_ref().is_some_and(fits) {
                    to = middle;
                } else {
                    from = middle + 1;
                }
            }
            let left_s = left_s + answer.ways[k].time_s;
            if let Some(way) = swept.way(search, [high, high - 1], to)
                && way.time_s <= left_s
                && way.energy_j < answer.ways[k].energy_j
            {
                answer.ways[k] = way;
            }
        }
        answer
    }

    /// The legs with the speeds that are tried.
    fn searches<'a>(&'a self, levels: &'a [Vec<Levels>]) -> Vec<Search<'a>> {
        let of = |(leg, levels): (&'a Problem, &'a Vec<Levels>)| Search {
            truck: self.truck,
            leg: leg.leg,
            heights: self.heights,
            places: leg.places,
            levels,
        };
        self.legs.iter().zip(levels).map(of).collect()
    }

    fn better(&self, a: Option<Answer>, b: Option<Answer>) -> Option<Answer> {
        // where time has one price it counts, too
        let price_w = if self.most_s.is_infinite() { self.prices_w[0] } else { 0.0 };
        let cost = |answer: &Answer| answer.energy_j() + price_w * answer.time_s();
        match (a, b) {
            (Some(a), Some(b)) => Some(if cost(&b) <= cost(&a) { b } else { a }),
            (a, b) => a.or(b),
        }
    }
}
