//! Drive of a driver, as legs from rest to rest: his speed along the road, his gears, and the drive
//! cycle by which the backward mode drives them again.

use ocmc_core::kernel::drive::trace::{Trace, trace_scenario};
use ocmc_core::powertrain::GearOrder;
use ocmc_core::prescribed::DriveCycle;
use ocmc_core::record::Record;
use ocmc_core::study::{Scenario, Study};

/// Shorter steps of a trace are joined to the next one, in s.
const SHORTEST_STEP_S: f64 = 1e-3;
/// Time in which a truck comes to rest that a stop line has caught, in s.
const CAUGHT_S: f64 = 0.1;
/// Shortest rest between two legs, in s.
const SHORTEST_REST_S: f64 = 0.01;

/// A leg from rest to rest as it was driven: one entry a step, the first at its start.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrivenLeg {
    /// Time since its start, in s.
    pub time_s: Vec<f64>,
    /// Way since its start, in m.
    pub way_m: Vec<f64>,
    /// Speed, in m/s.
    pub speed_mps: Vec<f64>,
    /// Gear of the step that ends there.
    pub gear: Vec<GearOrder>,
    /// Rest after it, in s.
    pub rest_s: f64,
    /// Where it begins and ends on the road, in m.
    pub road_m: [f64; 2],
}

impl DrivenLeg {
    pub(super) fn begin() -> Self {
        Self {
            time_s: vec![0.0],
            way_m: vec![0.0],
            speed_mps: vec![0.0],
            gear: vec![GearOrder::Open],
            ..Self::default()
        }
    }

    /// Adds a step; linear in speed over time.
    pub(super) fn push(&mut self, dt_s: f64, speed_mps: f64, gear: GearOrder) {
        let k = self.time_s.len() - 1;
        self.time_s.push(self.time_s[k] + dt_s);
        self.way_m.push(self.way_m[k] + 0.5 * (self.speed_mps[k] + speed_mps) * dt_s);
        self.speed_mps.push(speed_mps);
        self.gear.push(gear);
    }

    /// Its length, in m.
    pub fn length_m(&self) -> f64 {
        self.way_m[self.way_m.len() - 1]
    }

    /// Its duration, in s.
    pub fn duration_s(&self) -> f64 {
        self.time_s[self.time_s.len() - 1]
    }

    /// Place on the road after some way, in m.
    pub fn place_m(&self, way_m: f64) -> f64 {
        let share = way_m / self.length_m();
        self.road_m[0] + share * (self.road_m[1] - self.road_m[0])
    }

    /// Speed after some way, in m/s: the square of the speed is linear over the way.
    pub fn speed_at(&self, way_m: f64) -> f64 {
        let k = self.way_m.partition_point(|way| *way < way_m).clamp(1, self.way_m.len() - 1);
        let (from, to) = (self.way_m[k - 1], self.way_m[k]);
        let share = if to > from { ((way_m - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        let square = |k: usize| self.speed_mps[k] * self.speed_mps[k];
        (square(k - 1) + share * (square(k) - square(k - 1))).sqrt()
    }
}

/// The legs of a cycle, and the record of the drive.
#[derive(Clone, Debug)]
pub struct Driven {
    /// The legs in order.
    pub legs: Vec<DrivenLeg>,
    /// Record of the simulation.
    pub record: Record,
}

impl Driven {
    /// Drives a scenario.
    pub fn of(study: &Study, scenario: &Scenario) -> Self {
        let trace = trace_scenario(study, scenario.clone());
        let gap_s = study.vehicle().shift.duration_s;
        let orders = study.model().vehicle.powertrain.battery_electric().is_none();
        let mut legs = legs(&trace, gap_s, orders);
        anchor(&mut legs, scenario);
        Self { legs, record: trace.record }
    }

    /// The drive cycle of legs that rest as these do; `legs`: points of each leg.
    pub fn cycle_of(&self, legs: &[DrivenLeg], heights: &Heights) -> DriveCycle {
        let (mut time, mut speed) = (vec![0.0], vec![0.0]);
        let (mut slope, mut gear) = (vec![0.0], vec![GearOrder::Open]);
        let mut now_s = 0.0;
        for (k, leg) in legs.iter().enumerate() {
            let mut height_m = heights.at(leg.place_m(0.0));
            for i in 1..leg.time_s.len() {
                let way_m = leg.way_m[i] - leg.way_m[i - 1];
                let next_m = heights.at(leg.place_m(leg.way_m[i]));
                time.push(now_s + leg.time_s[i]);
                speed.push(leg.speed_mps[i]);
                slope.push(if way_m > 0.0 { (next_m - height_m) / way_m } else { 0.0 });
                gear.push(leg.gear[i]);
                height_m = next_m;
            }
            now_s += leg.duration_s();
            if k + 1 < legs.len() {
                now_s += self.legs[k].rest_s.max(SHORTEST_REST_S);
                time.push(now_s);
                speed.push(0.0);
                slope.push(0.0);
                gear.push(GearOrder::Open);
            }
        }
        let slope = slope.into_iter().map(|slope: f64| slope.clamp(-0.5, 0.5)).collect();
        DriveCycle::of_plan(time, speed, slope).with_gears(gear)
    }
}

/// Reads the legs off a trace.
fn legs(trace: &Trace, gap_s: f64, orders: bool) -> Vec<DrivenLeg> {
    let column = |name: &str| {
        let column = trace.columns.iter().find(|column| column.name == name);
        column.map_or(&[][..], |column| column.values.as_slice())
    };
    let [step, place, speed, desired, brake, gear] =
        ["step_s", "position_m", "speed_mps", "desired_speed_mps", "brake", "gear"].map(column);
    let mut legs = Vec::new();
    let mut leg = DrivenLeg::begin();
    let (mut waiting_s, mut engaged, mut gap_left_s) = (0.0, 0.0, 0.0);
    let close = |leg: &mut DrivenLeg| {
        if leg.speed_mps[leg.speed_mps.len() - 1] > 0.0 {
            leg.push(CAUGHT_S, 0.0, GearOrder::Open);
        }
    };
    for k in 0..step.len() {
        // a row of a stop, not of a step
        if speed[k] == 0.0 && desired[k] == 0.0 && brake[k] == 1.0 {
            close(&mut leg);
            leg.rest_s += step[k];
            leg.road_m[1] = place[k];
            if leg.length_m() > 0.0 {
                legs.push(std::mem::replace(&mut leg, DrivenLeg::begin()));
                leg.road_m[0] = place[k];
            }
            (waiting_s, gap_left_s, engaged) = (0.0, 0.0, 0.0);
            continue;
        }
        waiting_s += step[k];
        if waiting_s < SHORTEST_STEP_S {
            continue;
        }
        if gear[k] != engaged && engaged > 0.0 {
            gap_left_s = gap_s;
        }
        engaged = gear[k];
        let order = match (orders, gap_left_s > 0.5 * SHORTEST_STEP_S) {
            (false, _) => GearOrder::Free,
            (true, true) => GearOrder::Open,
            (true, false) => GearOrder::Engaged(gear[k] as usize - 1),
        };
        gap_left_s -= waiting_s;
        leg.push(waiting_s, speed[k], order);
        waiting_s = 0.0;
        leg.road_m[1] = place[k];
    }
    close(&mut leg);
    if leg.length_m() > 0.0 {
        legs.push(leg);
    }
    legs
}

/// Puts the ends of the legs where the road has its stops: a truck rests a little before a line.
fn anchor(legs: &mut [DrivenLeg], scenario: &Scenario) {
    let road = &scenario.cycle.road;
    let stops = (0..road.events.len()).filter(|k| scenario.passage(*k).standstill_s().is_some());
    let mut places: Vec<f64> = stops.map(|k| road.events[k].position_m).collect();
    places.push(road.length_m);
    if places.len() != legs.len() {
        return;
    }
    let mut from_m = 0.0;
    for (leg, to_m) in legs.iter_mut().zip(places) {
        leg.road_m = [from_m, to_m];
        from_m = to_m;
    }
}

/// Heights along a road over its start: linear within each slope step.
#[derive(Clone, Debug)]
pub struct Heights {
    step_m: f64,
    height_m: Vec<f64>,
    slopes: Vec<f64>,
}

impl Heights {
    /// Heights of the road of a scenario.
    pub fn of(scenario: &Scenario) -> Self {
        let road = &scenario.cycle.road;
        Self::new(road.slope_step_m, road.slopes.clone())
    }

    /// Heights of a level road.
    pub(super) fn level() -> Self {
        Self::new(1.0, vec![0.0])
    }

    /// Heights by slopes, each over so many metres.
    pub(super) fn new(step_m: f64, slopes: Vec<f64>) -> Self {
        let mut height_m = Vec::with_capacity(slopes.len());
        let mut now_m = 0.0;
        for slope in &slopes {
            height_m.push(now_m);
            now_m += slope * step_m;
        }
        Self { step_m, height_m, slopes }
    }

    /// Height at a place, in m.
    pub fn at(&self, place_m: f64) -> f64 {
        let last = self.height_m.len() - 1;
        let k = ((place_m / self.step_m).max(0.0) as usize).min(last);
        self.height_m[k] + self.slopes[k] * (place_m - k as f64 * self.step_m)
    }
}
