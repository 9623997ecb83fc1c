//! The moves of a truck along a leg and what they take: the road forces and the powertrain of the
//! backward mode, asked about steps that are not driven yet.
//!
//! A move keeps its gear to the next place, or shifts: it first rolls with an open clutch for as
//! long as the gearbox shifts, and then drives on in its new gear to the first place that it does
//! not reach before the next shift is allowed. Acceleration is constant over each part.

use super::driven::{DrivenLeg, Heights};
use super::grid::Place;
use ocmc_core::powertrain::{GearChoice, GearOrder, InversePowertrain, SpeedStep};
use ocmc_core::prescribed::Body;

/// Price in the search of a joule that is missing at the wheels, in J of the source: so much that
/// it is taken only where nothing else goes.
const MISSING_PRICE: f64 = 5.0;
/// Spacing of the speeds at which the reach of the powertrain is known, in m/s.
const REACH_STEP_MPS: f64 = 0.25;
/// Highest speed at which it is, in m/s.
const REACH_FASTEST_MPS: f64 = 45.0;
/// A force, in N, beyond what any powertrain gives.
const BEYOND_N: f64 = 1e7;
/// Share of full load that a search counts on.
const FULL_SHARE: f64 = 0.99;
/// Shares of the way from coasting to full load that are tried.
const SHARES: [f64; 4] = [0.2, 0.4, 0.6, 0.8];
/// Hardest braking that is tried, in m/s².
const HARDEST_MPS2: f64 = 3.0;
/// Slowest speed between two places, in m/s.
const SLOWEST_MPS: f64 = 0.02;

/// The gears that are tried where all are.
pub(super) const ALL_GEARS: [usize; 2] = [0, usize::MAX];

/// A truck in the backward mode, and what it can do.
pub(super) struct Truck<'a> {
    /// As the road sees it.
    pub body: Body,
    /// Its powertrain.
    pub inverse: &'a dyn InversePowertrain,
    /// Its gears; none where the powertrain chooses.
    pub choice: Option<GearChoice>,
    /// Price of a joule that brings the engine to the speed of a new gear, in J of the source.
    jump_price: f64,
    inertia_kg: f64,
    /// By gear and speed: force at the wheels in overrun and at full load, in N.
    reach: Vec<Vec<[f64; 2]>>,
}

/// A shift that has begun a move: speed in m/s and way in m at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gap {
    /// Speed at its end, in m/s.
    pub speed_mps: f64,
    /// Way during it, in m.
    pub way_m: f64,
}

/// Energy and time of a piece of a move, in J and s, and the kinetic energy of the shaft at its
/// start and its end, in J.
struct Piece {
    energy_j: f64,
    time_s: f64,
    shaft_j: [f64; 2],
}

/// A move to a later place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Move {
    /// Number of the place.
    pub to: usize,
    /// Gear at its end.
    pub gear: usize,
    /// Speed at its end, in m/s.
    pub speed_mps: f64,
    /// Energy that it takes from the source, in J, with the price of what is missing.
    pub energy_j: f64,
    /// Its duration, in s.
    pub time_s: f64,
    /// The shift before it.
    pub gap: Option<Gap>,
}

/// The shifts at a place and a speed, whatever gear is left.
#[derive(Debug, Default)]
pub(super) struct Shifts {
    /// The gap, and way and climb during it, in m; none where there is no shift.
    gap: Option<(Gap, [f64; 2])>,
    /// Moves without what the gap takes, and the kinetic energy that the shaft begins them with,
    /// in J.
    after: Vec<(Move, f64)>,
}

/// Speeds at a place among which values are linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Levels {
    /// The lowest, in m/s.
    pub low_mps: f64,
    /// Their spacing, in m/s.
    pub step_mps: f64,
    /// How many.
    pub count: usize,
    /// The lowest and the highest gear that is tried.
    pub gears: [usize; 2],
}

impl Levels {
    /// From a low to a high speed with about this spacing, all in m/s.
    pub(super) fn between(low_mps: f64, high_mps: f64, about_mps: f64) -> Self {
        let span_mps = high_mps - low_mps;
        if span_mps < 1e-3 {
            return Self { low_mps: high_mps, step_mps: 1.0, count: 1, gears: ALL_GEARS };
        }
        let count = libm::ceil(span_mps / about_mps) as usize + 1;
        Self { low_mps, step_mps: span_mps / (count - 1) as f64, count, gears: ALL_GEARS }
    }

    /// Whether a gear is tried.
    pub(super) fn has(&self, gear: usize) -> bool {
        gear >= self.gears[0] && gear <= self.gears[1]
    }

    /// Level number `k`, in m/s.
    pub(super) fn at(&self, k: usize) -> f64 {
        self.low_mps + k as f64 * self.step_mps
    }

    /// The highest, in m/s.
    pub(super) fn high_mps(&self) -> f64 {
        self.at(self.count - 1)
    }
}

impl<'a> Truck<'a> {
    /// A body with a powertrain; `jump_price`: of a joule that brings the engine to the speed of a
    /// new gear, in J of the source.
    pub(super) fn new(body: Body, inverse: &'a dyn InversePowertrain, jump_price: f64) -> Self {
        let choice = inverse.gear_choice();
        let inertia_kg = body.mass_kg + (body.wheel_mass_kg + inverse.rotating_mass_kg());
        let gears = choice.as_ref().map_or(1, |choice| choice.per_m.len());
        let mut truck = Self { body, inverse, choice, jump_price, inertia_kg, reach: Vec::new() };
        let speeds = (REACH_FASTEST_MPS / REACH_STEP_MPS) as usize;
        truck.reach = (0..gears)
            .map(|gear| {
                let at = |k: usize| {
                    let speed_mps = (k as f64 * REACH_STEP_MPS).max(0.05);
                    let order = truck.order(gear);
                    let step = SpeedStep {
                        dt_s: 1.0,
                        start_mps: speed_mps,
                        end_mps: speed_mps,
                        gear: order,
                    };
                    let overrun_n = match truck.choice {
                        Some(_) => inverse.cost(&step, -BEYOND_N, 0.0).wheel_n,
                        None => 0.0,
                    };
                    [overrun_n, inverse.cost(&step, BEYOND_N, 0.0).wheel_n * FULL_SHARE]
                };
                (0..speeds).map(at).collect()
            })
            .collect();
        truck
    }

    /// How many gears there are to choose from.
    pub(super) fn gears(&self) -> usize {
        self.reach.len()
    }

    pub(super) fn order(&self, gear: usize) -> GearOrder {
        if self.choice.is_some() { GearOrder::Engaged(gear) } else { GearOrder::Free }
    }

    /// Whether a gear can be held at a speed; below the slowest one only to roll out, and to start.
    pub(super) fn holds(&self, gear: usize, speed_mps: f64, rolls_out: bool) -> bool {
        let Some(choice) = &self.choice else { return true };
        let shaft_radps = choice.per_m[gear] * speed_mps;
        let slow = shaft_radps < choice.slowest_radps && gear >= choice.launch_gears;
        let fast = shaft_radps > choice.fastest_radps && gear + 1 < choice.per_m.len();
        !fast && (!slow || rolls_out)
    }

    /// Energy and time of a step over a piece of road; `climb_m`: over it; `shaft_radps`: before a
    /// step without a gear.
    fn step(
        &self,
        gear: GearOrder,
        [start_mps, end_mps]: [f64; 2],
        [way_m, climb_m]: [f64; 2],
        shaft_radps: f64,
    ) -> Piece {
        let mean_mps = 0.5 * (start_mps + end_mps);
        let dt_s = way_m / mean_mps;
        let step = SpeedStep { dt_s, start_mps, end_mps, gear };
        let slope = (climb_m / way_m).clamp(-0.5, 0.5);
        let road_n = self.body.road_forces(mean_mps, slope).sum_n();
        let wanted_n = self.inertia_kg * step.acceleration_mps2() + road_n;
        let cost = self.inverse.cost(&step, wanted_n, shaft_radps);
        let missing_j = (wanted_n - cost.wheel_n).max(0.0) * way_m;
        let energy_j = cost.energy_j + MISSING_PRICE * missing_j;
        Piece { energy_j, time_s: dt_s, shaft_j: [cost.shaft_start_j, cost.shaft_end_j] }
    }

    /// Cost of a change of the shaft's kinetic energy, in J of the source.
    fn jump_j(&self, before_j: f64, after_j: f64) -> f64 {
        self.jump_price * (after_j - before_j).max(0.0)
    }

    /// Energy of a piece of road without gears, and its time at a price in W, in J.
    #[cfg(test)]
    pub(super) fn piece_j(&self, speeds: [f64; 2], piece: [f64; 2], price_w: f64) -> f64 {
        let Piece { energy_j, time_s, .. } = self.step(GearOrder::Free, speeds, piece, 0.0);
        energy_j + price_w * time_s
    }

    /// Energy of a level road at constant speed, in J.
    pub(super) fn steady_j(&self, gear: usize, speed_mps: f64, way_m: f64) -> f64 {
        self.step(self.order(gear), [speed_mps, speed_mps], [way_m, 0.0], 0.0).energy_j
    }

    /// Force at the wheels, in N: number 0 in overrun, number 1 at full load.
    fn reach_at(&self, gear: usize, speed_mps: f64, number: usize) -> f64 {
        let row = &self.reach[gear];
        let x = (speed_mps / REACH_STEP_MPS).clamp(0.0, row.len() as f64 - 1.001);
        let k = x as usize;
        row[k][number] + (x - k as f64) * (row[k + 1][number] - row[k][number])
    }

    /// Speeds after a piece of road in overrun and at full load, in m/s.
    fn reached(&self, gear: usize, start_mps: f64, way_m: f64, climb_m: f64) -> [f64; 2] {
        let shaft_kg = self
            .choice
            .as_ref()
            .map_or(0.0, |choice| choice.inertia_kgm2 * choice.per_m[gear] * choice.per_m[gear]);
        let slope = (climb_m / way_m).clamp(-0.5, 0.5);
        let mut ends_mps = [start_mps; 2];
        for (number, end_mps) in ends_mps.iter_mut().enumerate() {
            for _ in 0..2 {
                let mean_mps = 0.5 * (start_mps + *end_mps);
                let force_n = self.reach_at(gear, mean_mps, number)
                    - self.body.road_forces(mean_mps, slope).sum_n();
                let square =
                    start_mps * start_mps + 2.0 * way_m * force_n / (self.inertia_kg + shaft_kg);
                *end_mps = square.max(0.0).sqrt();
            }
        }
        ends_mps
    }

    /// Rolls with an open clutch for the time of a shift.
    fn gap(&self, speed_mps: f64, slope: f64, gap_s: f64) -> Gap {
        let mut end_mps = speed_mps;
        for _ in 0..3 {
            let mean_mps = 0.5 * (speed_mps + end_mps);
            let step =
                SpeedStep { dt_s: gap_s, start_mps: speed_mps, end_mps, gear: GearOrder::Open };
            let lost_n = self.inverse.cost(&step, 0.0, 0.0).wheel_n;
            let force_n = lost_n - self.body.road_forces(mean_mps, slope).sum_n();
            end_mps = (speed_mps + gap_s * force_n / self.inertia_kg).max(0.0);
        }
        Gap { speed_mps: end_mps, way_m: 0.5 * (speed_mps + end_mps) * gap_s }
    }
}

/// A leg that is searched.
pub(super) struct Search<'a> {
    /// The truck.
    pub truck: &'a Truck<'a>,
    /// The leg as it was driven.
    pub leg: &'a DrivenLeg,
    /// Heights along the road.
    pub heights: &'a Heights,
    /// The places.
    pub places: &'a [Place],
    /// The speeds that are tried at each place.
    pub levels: &'a [Levels],
}

impl Search<'_> {
    fn height_at(&self, way_m: f64) -> f64 {
        self.heights.at(self.leg.place_m(way_m))
    }

    /// Writes the moves from a place at a speed in a gear; `shifts`: those at this speed.
    pub(super) fn moves(
        &self,
        from: usize,
        speed_mps: f64,
        gear: usize,
        shifts: &Shifts,
        moves: &mut Vec<Move>,
    ) {
        moves.clear();
        self.keep(from, speed_mps, gear, moves);
        let truck = self.truck;
        let (Some(choice), Some((gap, piece))) = (&truck.choice, shifts.gap) else { return };
        let shaft_radps = choice.per_m[gear] * speed_mps;
        let shaft_j = 0.5 * choice.inertia_kgm2 * shaft_radps * shaft_radps;
        let before = truck.step(GearOrder::Open, [speed_mps, gap.speed_mps], piece, shaft_radps);
        let before_j = before.energy_j + truck.jump_j(shaft_j, before.shaft_j[0]);
        for (after, shaft_j) in &shifts.after {
            if after.gear != gear && after.gear <= gear + choice.most_up {
                let jump_j = truck.jump_j(before.shaft_j[1], *shaft_j);
                moves.push(Move {
                    energy_j: before_j + (after.energy_j + jump_j),
                    time_s: before.time_s + after.time_s,
                    ..*after
                });
            }
        }
    }

    /// Moves that keep the gear.
    fn keep(&self, from: usize, speed_mps: f64, gear: usize, moves: &mut Vec<Move>) {
        let (truck, a, b) = (self.truck, &self.places[from], &self.places[from + 1]);
        let piece = [b.way_m - a.way_m, b.height_m - a.height_m];
        let levels = &self.levels[from + 1];
        if !levels.has(gear) {
            return;
        }
        let last = from + 2 == self.places.len();
        let mut add = |end_mps: f64| {
            if 0.5 * (speed_mps + end_mps) < SLOWEST_MPS || !truck.holds(gear, end_mps, true) {
                return;
            }
            let Piece { energy_j, time_s, .. } =
                truck.step(truck.order(gear), [speed_mps, end_mps], piece, 0.0);
            moves.push(Move {
                to: from + 1,
                gear,
                speed_mps: end_mps,
                energy_j,
                time_s,
                gap: None,
            });
        };
        if levels.count == 1 {
            add(levels.low_mps);
            return;
        }
        let [coast_mps, full_mps] = truck.reached(gear, speed_mps, piece[0], piece[1]);
        let hardest = speed_mps * speed_mps - 2.0 * HARDEST_MPS2 * piece[0];
        let least_mps = hardest.max(0.0).sqrt().max(levels.low_mps);
        let most_mps = full_mps.min(levels.high_mps());
        let within = |end_mps: f64| end_mps >= least_mps && end_mps <= most_mps;
        let first = ((least_mps - levels.low_mps) / levels.step_mps).max(0.0) as usize;
        for k in first..levels.count {
            let end_mps = levels.at(k);
            if within(end_mps) {
                add(end_mps);
            }
        }
        let squares = [coast_mps * coast_mps, full_mps * full_mps];
        let between = SHARES.map(|share| squares[0] + share * (squares[1] - squares[0]));
        for square in between.into_iter().chain(squares) {
            let end_mps = square.max(0.0).sqrt();
            if within(end_mps) {
                add(end_mps);
            }
        }
        if within(speed_mps) {
            add(speed_mps);
        }
        if !last && most_mps < least_mps {
            // steeper than the truck can climb: what is missing is paid for
            add(least_mps);
        }
    }

    /// Writes what the shifts at a place and a speed have in common, whatever gear is left.
    pub(super) fn shifts(&self, from: usize, speed_mps: f64, shifts: &mut Shifts) {
        shifts.gap = None;
        shifts.after.clear();
        let truck = self.truck;
        let Some(choice) = &truck.choice else { return };
        if speed_mps <= choice.minimum_speed_mps {
            return;
        }
        let (a, b) = (&self.places[from], &self.places[from + 1]);
        let slope = (b.height_m - a.height_m) / (b.way_m - a.way_m);
        let first = truck.gap(speed_mps, slope, choice.gap_s);
        if first.speed_mps <= choice.minimum_speed_mps {
            return;
        }
        let climb_m = self.height_at(a.way_m + first.way_m) - a.height_m;
        let gap = truck.gap(speed_mps, climb_m / first.way_m, choice.gap_s);
        if gap.speed_mps <= choice.minimum_speed_mps {
            return;
        }
        let rest_s = (choice.interval_s - choice.gap_s).max(0.0);
        let least_m = a.way_m + gap.way_m + gap.speed_mps * rest_s;
        let mut to = from + 1;
        while to < self.places.len() && self.places[to].way_m < least_m {
            to += 1;
        }
        if to + 1 >= self.places.len() {
            return;
        }
        let b = &self.places[to];
        let half_m = self.height_at(a.way_m + gap.way_m);
        let piece = [b.way_m - a.way_m - gap.way_m, b.height_m - half_m];
        if piece[0] < 0.1 {
            return;
        }
        shifts.gap = Some((gap, [gap.way_m, half_m - a.height_m]));
        let levels = &self.levels[to];
        for gear in 0..choice.per_m.len() {
            if !levels.has(gear) || !truck.holds(gear, gap.speed_mps, false) {
                continue;
            }
            let mut add = |end_mps: f64| {
                if !truck.holds(gear, end_mps, false) || !self.allows(from, to, gap, end_mps) {
                    return;
                }
                let speeds = [gap.speed_mps, end_mps];
                let Piece { energy_j, time_s, shaft_j } =
                    truck.step(truck.order(gear), speeds, piece, 0.0);
                let after = Move { to, gear, speed_mps: end_mps, energy_j, time_s, gap: Some(gap) };
                shifts.after.push((after, shaft_j[0]));
            };
            if levels.count == 1 {
                add(levels.low_mps);
                continue;
            }
            let [coast_mps, full_mps] = truck.reached(gear, gap.speed_mps, piece[0], piece[1]);
            let squares = [coast_mps * coast_mps, full_mps * full_mps];
            let half_mps = (0.5 * (squares[0] + squares[1])).sqrt();
            let high_mps = levels.high_mps();
            let within = |end_mps: f64| end_mps >= levels.low_mps && end_mps <= high_mps;
            for end_mps in [coast_mps, half_mps, full_mps, speed_mps, high_mps] {
                let reached = end_mps <= full_mps && end_mps + 1e-9 >= coast_mps.min(high_mps);
                if within(end_mps) && reached {
                    add(end_mps);
                }
            }
        }
    }

    /// Whether the places between are passed no faster than is allowed.
    fn allows(&self, from: usize, to: usize, gap: Gap, end_mps: f64) -> bool {
        let start_m = self.places[from].way_m + gap.way_m;
        let end_m = self.places[to].way_m;
        self.places[from + 1..to].iter().all(|place| {
            let share = ((place.way_m - start_m) / (end_m - start_m)).max(0.0);
            let start = gap.speed_mps * gap.speed_mps;
            let square = start + share * (end_mps * end_mps - start);
            square <= place.most_mps * place.most_mps * 1.001 + 0.01
        })
    }
}
