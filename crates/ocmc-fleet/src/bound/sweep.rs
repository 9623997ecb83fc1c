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
    /// What it takes, in J.
    pub energy_j: f64,
    /// How long, in s.
    pub time_s: f64,
}

/// What is left at a place, by speed and gear.
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

/// What is left along a leg, by place, speed, gear and price, of which it knows `N`.
pub(super) struct Swept<const N: usize> {
    tables: Vec<Table<N>>,
    prices: [f64; N],
}

impl<const N: usize> Swept<N> {
    /// Sweeps a leg from its end to its start, at prices of time in W; none once the flag is set.
    pub(super) fn of(search: &Search, prices: &[f64; N], stop: &AtomicBool) -> Option<Self> {
        Some(Self { tables: backward(search, prices, stop)?, prices: *prices })
    }

    /// The best ways, one for each price; none where there is no way at all.
    pub(super) fn ways(&self, search: &Search) -> [Option<Way>; N] {
        let mut ways = [const { None }; N];
        for (k, way) in ways.iter_mut().enumerate() {
            *way = self.way(search, [k, k], 0);
        }
        ways
    }

    /// The best way at one price, by its number, and from some place on at another one.
    pub(super) fn way(&self, search: &Search, prices: [usize; 2], from: usize) -> Option<Way> {
        let last = search.places.len() - 1;
        let first = &self.tables[0];
        let start_mps = search.levels[0].low_mps;
        let price_at = |at: usize| prices[usize::from(at >= from)];
        let starts = (0..first.gears).filter(|gear| search.truck.holds(*gear, start_mps, false));
        let left = |gear: usize| first.at(0, gear)[price_at(0)];
        let gear = starts.min_by(|a, b| left(*a).total_cmp(&left(*b)))?;
        let mut way = Way { moves: Vec::new(), gear, energy_j: 0.0, time_s: 0.0 };
        let (mut at, mut speed_mps, mut engaged) = (0, start_mps, gear);
        let (mut shifts, mut moves) = (Shifts::default(), Vec::new());
        while at < last {
            search.shifts(at, speed_mps, &mut shifts);
            search.moves(at, speed_mps, engaged, &shifts, &mut moves);
            let price = price_at(at);
            let cost = |step: &Move| {
                let (low, high, share) = self.tables[step.to].between(step.speed_mps, step.gear);
                let between = if share > 0.0 { share * (high[price] - low[price]) } else { 0.0 };
                let sum = step.energy_j + self.prices[price] * step.time_s + low[price] + between;
                if sum.is_nan() { f64::INFINITY } else { sum }
            };
            let best = moves.iter().min_by(|a, b| cost(a).total_cmp(&cost(b)))?;
            if cost(best).is_infinite() {
                return None;
            }
            way.energy_j += best.energy_j;
            way.time_s += best.time_s;
            (at, speed_mps, engaged) = (best.to, best.speed_mps, best.gear);
            way.moves.push(*best);
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
