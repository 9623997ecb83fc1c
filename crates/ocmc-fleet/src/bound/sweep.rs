//! Dynamic programming over one leg: from its end to its start the least of energy + λ time that is
//! left, for several prices λ of time at once; then from its start to its end the moves that have
//! it.

use super::moves::{Levels, Move, Search, Shifts};
use std::sync::atomic::{AtomicBool, Ordering};

/// One way along a leg.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Way {
    /// The moves; the first begins where the leg does.
    pub moves: Vec<Move>,
    /// Gear at the start.
    pub gear: usize,
    /// Energy that it takes, in J.
    pub energy_j: f64,
    /// How long, in s.
    pub time_s: f64,
}

impl Way {
    fn push(&mut self, step: Move) {
        self.energy_j += step.energy_j;
        self.time_s += step.time_s;
        self.moves.push(step);
    }
}

/// Cost that remains at a place, by speed and gear.
struct Table<const N: usize> {
    levels: Levels,
    gears: usize,
    left: Vec<[f64; N]>,
}

impl<const N: usize> Table<N> {
    fn at(&self, k: usize, gear: usize) -> &[f64; N] {
        &self.left[k * self.gears + gear]
    }

    /// Between two speeds the value is linear.
    fn between(&self, speed_mps: f64, gear: usize) -> (&[f64; N], &[f64; N], f64) {
        let levels = &self.levels;
        if levels.count == 1 {
            let only = self.at(0, gear);
            return (only, only, 0.0);
        }
        let x = ((speed_mps - levels.low_mps) / levels.step_mps).max(0.0);
        let nearest = (x + 0.5) as usize;
        if (x - nearest as f64).abs() < 1e-6 {
            let here = self.at(nearest.min(levels.count - 1), gear);
            return (here, here, 0.0);
        }
        let k = (x as usize).min(levels.count - 2);
        (self.at(k, gear), self.at(k + 1, gear), x - k as f64)
    }
}

/// Cost that remains along a leg, by place, speed, gear and price, of which it knows `N`.
pub(super) struct Swept<const N: usize> {
    tables: Vec<Table<N>>,
    prices: [f64; N],
}

impl<const N: usize> Swept<N> {
    /// Sweeps a leg from its end to its start, at prices of time in W; none once the flag is set.
    pub(super) fn of(search: &Search, prices: &[f64; N], stop: &AtomicBool) -> Option<Self> {
        Some(Self { tables: backward(search, prices, stop)?, prices: *prices })
    }

    /// The best way at one price, by its number.
    pub(super) fn way(&self, search: &Search, price: usize) -> Option<Way> {
        let start_mps = search.levels[0].low_mps;
        let first = &self.tables[0];
        let starts = (0..first.gears).filter(|gear| search.truck.holds(*gear, start_mps, false));
        let left = |gear: usize| first.at(0, gear)[price];
        let gear = starts.min_by(|a, b| left(*a).total_cmp(&left(*b)))?;
        let way = Way { moves: Vec::new(), gear, energy_j: 0.0, time_s: 0.0 };
        self.follow(search, price, way, None)
    }

    /// Goes along a way up to some place, and from there on at the price of another one, by its
    /// number.
    pub(super) fn change(
        &self,
        search: &Search,
        [one, other]: [&Way; 2],
        price: usize,
        from: usize,
    ) -> Option<Way> {
        let mut way = Way { moves: Vec::new(), energy_j: 0.0, time_s: 0.0, ..*one };
        let mut at = 0;
        for step in &one.moves {
            if at >= from {
                break;
            }
            at = step.to;
            way.push(*step);
        }
        self.follow(search, price, way, Some(other))
    }

    /// Goes on at one price to the end of the leg; `known`: the way that does so from the start,
    /// which is the rest of it where the two meet.
    fn follow(
        &self,
        search: &Search,
        price: usize,
        mut way: Way,
        known: Option<&Way>,
    ) -> Option<Way> {
        let last = search.places.len() - 1;
        let (mut at, mut speed_mps, mut engaged) = (0, search.levels[0].low_mps, way.gear);
        if let Some(step) = way.moves.last() {
            (at, speed_mps, engaged) = (step.to, step.speed_mps, step.gear);
        }
        let (mut shifts, mut moves) = (Shifts::default(), Vec::new());
        let known = known.map_or(&[][..], |known| &known.moves);
        let mut passed = 0;
        while at < last {
            while passed < known.len() && known[passed].to < at {
                passed += 1;
            }
            let meets = |step: &Move| {
                (step.to, step.speed_mps, step.gear) == (at, speed_mps, engaged) && at > 0
            };
            if known.get(passed).is_some_and(meets) {
                for step in &known[passed + 1..] {
                    way.push(*step);
                }
                break;
            }
            search.shifts(at, speed_mps, &mut shifts);
            search.moves(at, speed_mps, engaged, &shifts, &mut moves);
            let cost = |step: &Move| {
                let (low, high, share) = self.tables[step.to].between(step.speed_mps, step.gear);
                let between = if share > 0.0 { share * (high[price] - low[price]) } else { 0.0 };
                let sum = step.energy_j + self.prices[price] * step.time_s + low[price] + between;
                if sum.is_nan() { f64::INFINITY } else { sum }
            };
            let mut best: Option<(f64, &Move)> = None;
            for step in &moves {
                let cost = cost(step);
                if best.is_none_or(|(least, _)| cost < least) {
                    best = Some((cost, step));
                }
            }
            let (cost, step) = best?;
            if cost.is_infinite() {
                return None;
            }
            (at, speed_mps, engaged) = (step.to, step.speed_mps, step.gear);
            way.push(*step);
        }
        Some(way)
    }
}

fn backward<const N: usize>(
    search: &Search,
    prices: &[f64; N],
    stop: &AtomicBool,
) -> Option<Vec<Table<N>>> {
    let no_way = [f64::INFINITY; N];
    let gears = search.truck.gears();
    let last = search.places.len() - 1;
    let mut tables: Vec<Table<N>> = search
        .levels
        .iter()
        .map(|levels| Table { levels: *levels, gears, left: vec![no_way; levels.count * gears] })
        .collect();
    tables[last].left.fill([0.0; N]);
    let (mut shifts, mut moves) = (Shifts::default(), Vec::new());
    for from in (0..last).rev() {
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        let levels = search.levels[from];
        for k in 0..levels.count {
            let speed_mps = levels.at(k);
            search.shifts(from, speed_mps, &mut shifts);
            for gear in 0..gears {
                if !levels.has(gear) || !search.truck.holds(gear, speed_mps, from > 0) {
                    continue;
                }
                search.moves(from, speed_mps, gear, &shifts, &mut moves);
                let mut best = no_way;
                for step in &moves {
                    let (low, high, share) = tables[step.to].between(step.speed_mps, step.gear);
                    for i in 0..N {
                        let left =
                            if share > 0.0 { low[i] + share * (high[i] - low[i]) } else { low[i] };
                        let cost = step.energy_j + prices[i] * step.time_s + left;
                        // not a number where there is no way
                        if cost < best[i] {
                            best[i] = cost;
                        }
                    }
                }
                tables[from].left[k * gears + gear] = best;
            }
        }
    }
    Some(tables)
}
