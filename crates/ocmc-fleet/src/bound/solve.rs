//! The least energy over all legs of a trip in at most so much time: one price of time for all
//! legs, found from coarse to fine. Each stage knows eight prices at once; the next one looks
//! closer, at the prices and at the speeds and gears around what was found.

use super::driven::{DrivenLeg, Heights};
use super::grid::{Fineness, Place};
use super::moves::{ALL_GEARS, Levels, Move, Search, Truck};
use super::sweep::{Swept, Way};
use std::sync::atomic::AtomicBool;

/// How many prices of time a stage knows at once where there is more than one.
pub(super) const PRICES: usize = 8;

/// One stage of the search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stage {
    /// Spacing of its speeds, as a multiple of the last one's.
    pub spacing: f64,
    /// How far its speeds reach beyond those that it begins around, in its spacings.
    pub reach: f64,
    /// How far its gears do.
    pub gears: usize,
    /// By how much the prices of the next stage reach beyond what it has found.
    pub beyond: f64,
}

/// From all speeds and gears to the last spacing.
pub(super) const FROM_NOTHING: [Stage; 5] = [
    Stage { spacing: 8.0, reach: 0.0, gears: 0, beyond: 1.1 },
    Stage { spacing: 4.0, reach: 3.0, gears: 2, beyond: 1.05 },
    Stage { spacing: 2.0, reach: 3.0, gears: 2, beyond: 1.02 },
    Stage { spacing: 1.0, reach: 3.0, gears: 2, beyond: 1.0 },
    Stage { spacing: 1.0, reach: 2.0, gears: 1, beyond: 1.0 },
];
/// The same where much is known already.
pub(super) const FROM_TRACKS: [Stage; 2] = [
    Stage { spacing: 5.0, reach: 2.0, gears: 2, beyond: 1.0 },
    Stage { spacing: 1.0, reach: 4.0, gears: 1, beyond: 1.0 },
];

/// Lowest speed of the first stage, in m/s, and as a share of the highest.
const LOWEST_MPS: f64 = 1.0;
const LOWEST_SHARE: f64 = 0.4;
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

/// Question over all legs.
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
    /// The stages of the search.
    pub stages: &'a [Stage],
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
    /// Its ways at the places of their legs.
    pub(super) fn tracks(&self, places: &[Vec<Place>]) -> Vec<Track> {
        self.ways.iter().zip(places).map(|(way, places)| Track::of(way, places)).collect()
    }

    /// Energy, in J, with the price of what is missing.
    pub(super) fn energy_j(&self) -> f64 {
        self.ways.iter().map(|way| way.energy_j).sum()
    }

    /// Moving time, in s.
    pub(super) fn time_s(&self) -> f64 {
        self.ways.iter().map(|way| way.time_s).sum()
    }
}

/// A way at the places of its leg.
#[derive(Clone, Debug)]
pub(super) struct Track {
    /// Speeds, in m/s.
    speed_mps: Vec<f64>,
    /// Lowest and highest of the gears before and behind each place.
    gears: Vec<[usize; 2]>,
}

impl Track {
    /// Reads a way off.
    fn of(way: &Way, places: &[Place]) -> Self {
        let (mut at, mut now, mut engaged) = (0, places[0].driven_mps, way.gear);
        let mut track =
            Self { speed_mps: vec![now; places.len()], gears: vec![[engaged; 2]; places.len()] };
        for Move { to, speed_mps, gear, .. } in &way.moves {
            let gears = [engaged.min(*gear), engaged.max(*gear)];
            let [low, high] = track.gears[at];
            track.gears[at] = [low.min(gears[0]), high.max(gears[1])];
            for k in at + 1..=*to {
                let whole_m = places[*to].way_m - places[at].way_m;
                let share = (places[k].way_m - places[at].way_m) / whole_m;
                let square: f64 = now * now + share * (speed_mps * speed_mps - now * now);
                track.speed_mps[k] = square.sqrt();
                track.gears[k] = if k < *to { gears } else { [*gear; 2] };
            }
            (at, now, engaged) = (*to, *speed_mps, *gear);
        }
        track
    }
}

/// The ways of all legs at the prices that were asked for.
struct WaysAtPrices<'a, const N: usize> {
    searches: &'a [Search<'a>],
    swept: &'a [Swept<N>],
    /// By leg and price.
    ways: Vec<[Option<Way>; N]>,
    /// Their time by price, in s, once it is known.
    times_s: [Option<f64>; N],
}

impl<'a, const N: usize> WaysAtPrices<'a, N> {
    fn new(searches: &'a [Search<'a>], swept: &'a [Swept<N>]) -> Self {
        let ways = searches.iter().map(|_| [const { None }; N]).collect();
        Self { searches, swept, ways, times_s: [None; N] }
    }

    /// Time of the ways at a price, in s; without end where there is no way.
    fn time_s(&mut self, price: usize) -> f64 {
        if let Some(time_s) = self.times_s[price] {
            return time_s;
        }
        let mut time_s = 0.0;
        for ((search, swept), ways) in self.searches.iter().zip(self.swept).zip(&mut self.ways) {
            ways[price] = swept.way(search, price);
            time_s += ways[price].as_ref().map_or(f64::INFINITY, |way| way.time_s);
        }
        self.times_s[price] = Some(time_s);
        time_s
    }
}

/// The speeds and gears that are tried at the places of a leg; `around`: those to stay near to, and
/// how near.
fn levels(leg: &Problem, about_mps: f64, around: Option<(&[Track; 2], &Stage)>) -> Vec<Levels> {
    let last = leg.places.len() - 1;
    let levels_of = |(k, place): (usize, &Place)| {
        let most_mps = place.most_mps;
        let lowest_mps = LOWEST_MPS.max(LOWEST_SHARE * most_mps).min(0.5 * most_mps);
        let (mut speeds, mut gears) = ([lowest_mps, most_mps], ALL_GEARS);
        if let Some(([a, b], stage)) = around {
            let reach_mps = stage.reach * about_mps;
            let (one, other) = (a.speed_mps[k], b.speed_mps[k]);
            let low_mps = (one.min(other) - reach_mps).max(lowest_mps.min(0.5));
            speeds = [low_mps.min(most_mps), (one.max(other) + reach_mps).min(most_mps)];
            let low = a.gears[k][0].min(b.gears[k][0]);
            gears =
                [low.saturating_sub(stage.gears), a.gears[k][1].max(b.gears[k][1]) + stage.gears];
        }
        if k == 0 || k == last || !leg.free[k] {
            speeds = [place.driven_mps; 2];
        }
        Levels { gears, ..Levels::between(speeds[0], speeds[1], about_mps) }
    };
    leg.places.iter().enumerate().map(levels_of).collect()
}

impl Question<'_> {
    /// The least energy in the time, with `N` prices at once; none where no way was found.
    /// `around`: for each leg, the tracks that the first stage begins around; without them it tries
    /// all.
    pub(super) fn answer<const N: usize>(
        &self,
        mut around: Option<Vec<[Track; 2]>>,
    ) -> Option<Answer> {
        let mut range = self.prices_w;
        let pinned = self.legs.iter().all(|leg| leg.free.iter().all(|free| !free));
        let mut best: Option<Answer> = None;
        let (mut stage, mut shifted) = (0, 0);
        while let Some(now) = self.stages.get(stage) {
            stage += 1;
            let about_mps = now.spacing * self.fineness.speed_mps;
            let ratio = libm::pow(range[1] / range[0], 1.0 / (N as f64 - 1.0).max(1.0));
            let mut prices = [range[0]; N];
            for k in 1..N {
                prices[k] = prices[k - 1] * ratio;
            }
            let near = |k: usize| around.as_ref().map(|around| &around[k]);
            let levels_of = |(k, leg): (usize, &Problem)| {
                levels(leg, about_mps, near(k).map(|tracks| (tracks, now)))
            };
            let levels: Vec<Vec<Levels>> = self.legs.iter().enumerate().map(levels_of).collect();
            let searches: Vec<Search> = self.searches(&levels);
            let swept: Option<Vec<Swept<N>>> =
                searches.iter().map(|search| Swept::of(search, &prices, self.stop)).collect();
            let swept = swept?;
            let mut at_prices = WaysAtPrices::new(&searches, &swept);
            let in_time = |at_prices: &mut WaysAtPrices<N>, price: usize| {
                at_prices.time_s(price) <= self.most_s * (1.0 + ROUNDING)
            };
            // a higher price takes no longer
            let (mut low, mut high) = (0, N);
            while low < high {
                let middle = low.midpoint(high);
                if in_time(&mut at_prices, middle) {
                    high = middle;
                } else {
                    low = middle + 1;
                }
            }
            let fast = high < N;
            let high = high.min(N - 1);
            let low = high.saturating_sub(1);
            let times_s = [low, high].map(|price| at_prices.time_s(price));
            if fast {
                let mut answer = self.mix(&at_prices.ways, high, prices[high]);
                if let Some(answer) = answer.as_mut().filter(|_| stage == self.stages.len()) {
                    self.fill(answer, &at_prices, high);
                }
                best = self.better(best, answer);
            }
            if pinned {
                return best;
            }
            if times_s.iter().any(|time_s| time_s.is_infinite()) {
                return best;
            }
            let near = at_prices.ways.iter().zip(&self.legs).map(|(ways, leg)| {
                let track = |price: usize| Some(Track::of(ways[price].as_ref()?, leg.places));
                Some([track(low)?, track(high)?])
            });
            around = near.collect();
            if self.most_s.is_infinite() {
                continue;
            }
            range = [prices[low] / now.beyond, prices[high] * now.beyond];
            let span = (prices[N - 1] / prices[0]).max(LEAST_SPAN);
            if !fast || high == 0 {
                // the price lies beside those that were tried
                let first = if fast { prices[0] * ratio / span } else { prices[high] / ratio };
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
    fn mix<const N: usize>(
        &self,
        ways_by_price: &[[Option<Way>; N]],
        high: usize,
        price_w: f64,
    ) -> Option<Answer> {
        let ways: Option<Vec<Way>> = ways_by_price.iter().map(|ways| ways[high].clone()).collect();
        let mut answer = Answer { ways: ways?, price_w };
        let mut left_s = self.most_s - answer.time_s();
        loop {
            let mut best: Option<(f64, usize, &Way)> = None;
            for (k, (way, ways)) in answer.ways.iter().zip(ways_by_price).enumerate() {
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
    fn fill<const N: usize>(&self, answer: &mut Answer, at_prices: &WaysAtPrices<N>, high: usize) {
        if high == 0 || self.most_s.is_infinite() {
            return;
        }
        for (k, (search, swept)) in at_prices.searches.iter().zip(at_prices.swept).enumerate() {
            let left_s = self.most_s - answer.time_s();
            let [Some(fast), Some(slow)] =
                [high, high - 1].map(|price| at_prices.ways[k][price].as_ref())
            else {
                continue;
            };
            // a leg that was slowed already has taken its time
            if fast.time_s != answer.ways[k].time_s {
                continue;
            }
            let change = |from: usize| swept.change(search, [fast, slow], high - 1, from);
            let most_s = left_s + fast.time_s;
            let (mut from, mut to) = (0, search.places.len() - 1);
            while from < to {
                let middle = from.midpoint(to);
                if change(middle).is_some_and(|way| way.time_s <= most_s) {
                    to = middle;
                } else {
                    from = middle + 1;
                }
            }
            if let Some(way) = change(to)
                && way.time_s <= most_s
                && way.energy_j < fast.energy_j
            {
                answer.ways[k] = way;
            }
        }
    }

    /// The legs with the speeds that are tried.
    fn searches<'a>(&'a self, levels: &'a [Vec<Levels>]) -> Vec<Search<'a>> {
        let search = |(leg, levels): (&'a Problem, &'a Vec<Levels>)| Search {
            truck: self.truck,
            leg: leg.leg,
            heights: self.heights,
            places: leg.places,
            levels,
        };
        self.legs.iter().zip(levels).map(search).collect()
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
