//! Choice of the gear by the driver.

use super::VectoDriver;
use super::polygon::ShiftPolygons;
use super::truck::{Motion, Truck};

/// Memory of the gear choice: the seconds before.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GearMemory {
    /// Gear of the last second; none at rest and with an open clutch.
    pub(super) gear: Option<usize>,
    /// Seconds since another gear was engaged, counted at the second that is to be driven.
    pub(super) since_other_s: f64,
    /// Whether the last shift on the way was one up; none since a start.
    pub(super) last_up: Option<bool>,
    /// Seconds since then.
    pub(super) since_shift_s: f64,
    /// Mean engine speed of the last second, in rad/s; none before the first one.
    pub(super) engine_radps: Option<f64>,
    /// Whether the clutch slipped in the last second.
    pub(super) slipped: bool,
}

/// Chooses gears for a truck.
#[derive(Clone, Debug)]
pub(super) struct GearChoice<'a> {
    truck: &'a Truck<'a>,
    driver: &'a VectoDriver,
    polygons: ShiftPolygons,
}

/// Engine speed and torque in a gear.
#[derive(Clone, Copy, Debug)]
struct Load {
    speed_radps: f64,
    torque_nm: f64,
    /// Share of full load that is left.
    reserve: f64,
}

impl<'a> GearChoice<'a> {
    pub(super) fn new(truck: &'a Truck<'a>, driver: &'a VectoDriver) -> Self {
        let polygons = ShiftPolygons::new(&driver.shift_polygons, truck.powertrain);
        Self { truck, driver, polygons }
    }

    fn top(&self) -> usize {
        self.truck.powertrain.gears.len() - 1
    }

    fn down_radps(&self, gear: usize, torque_nm: f64) -> f64 {
        self.polygons.of(gear).down.at_radps(torque_nm)
    }

    fn up_radps(&self, gear: usize, torque_nm: f64) -> f64 {
        self.polygons.of(gear).up.at_radps(torque_nm)
    }

    /// Load of a gear on the engine, by mean efficiencies and within the engine's limits; an engine
    /// that is slowed from another speed gives its energy back.
    fn load(&self, gear: usize, motion: &Motion, last_radps: Option<f64>) -> Load {
        let truck = self.truck;
        let speed_radps = truck.speed_radps(gear, motion.speed_mps);
        let spin_w = last_radps.map_or(0.0, |last| truck.spin_w(last, speed_radps));
        let wanted_w = truck.quick_w(gear, motion) + spin_w;
        let full_w = truck.full_w(speed_radps);
        let power_w = wanted_w.max(truck.drag_w(speed_radps)).min(full_w);
        let torque_nm = power_w / speed_radps.max(1e-3);
        Load { speed_radps, torque_nm, reserve: 1.0 - power_w / full_w.max(1e-3) }
    }

    /// The gear of a truck that is rolling when its mission starts.
    pub(super) fn rolling_start(&self, motion: &Motion) -> usize {
        for gear in (0..=self.top()).rev() {
            let load = self.load(gear, motion, None);
            if load.speed_radps > self.up_radps(gear, load.torque_nm) {
                return (gear + 1).min(self.top());
            }
            let fast = load.speed_radps > self.down_radps(gear, load.torque_nm);
            if fast && load.reserve >= self.driver.torque_reserve {
                return gear;
            }
        }
        0
    }

    /// The gear of a truck that starts from rest.
    pub(super) fn start(&self, slope: f64, auxiliary_w: f64, last_radps: Option<f64>) -> usize {
        let driver = self.driver;
        let motion = Motion {
            speed_mps: driver.start_speed_mps,
            acceleration_mps2: driver.start_acceleration_mps2,
            slope,
            auxiliary_w,
        };
        let peak_nm = self.truck.powertrain.engine.peak_torque_nm();
        for gear in (1..=self.top()).rev() {
            let load = self.load(gear, &motion, last_radps);
            let turns = load.speed_radps <= self.truck.rated_radps
                && load.speed_radps >= self.truck.idle_radps
                && load.speed_radps > self.down_radps(gear, load.torque_nm.min(peak_nm));
            let strong = load.reserve >= driver.start_torque_reserve || load.torque_nm < 0.0;
            if turns && strong {
                return gear;
            }
        }
        0
    }

    /// The gear for a second of driving.
    pub(super) fn next(&self, motion: &Motion, memory: &GearMemory) -> usize {
        let Some(gear) = memory.gear else {
            return self.rolling_start(motion);
        };
        let truck = self.truck;
        let turns_radps = truck.speed_radps(gear, motion.speed_mps);
        let slow = turns_radps < truck.idle_radps;
        let urgent = slow || turns_radps > truck.fast_radps();
        if memory.slipped && motion.acceleration_mps2 > 0.0 {
            return gear;
        }
        if memory.since_other_s <= self.driver.shift_time_s && !urgent {
            return gear;
        }
        let back_s = self.driver.opposite_shift_time_s;
        let waits =
            |up: bool| !urgent && memory.last_up == Some(!up) && memory.since_shift_s <= back_s;
        let load = |gear: usize| self.load(gear, motion, memory.engine_radps);
        let here = load(gear);
        if waits(false) && here.speed_radps <= self.down_radps(gear, here.torque_nm) {
            return gear;
        }
        if slow || here.speed_radps <= self.down_radps(gear, here.torque_nm) {
            return self.lower(gear, load);
        }
        let must = here.speed_radps > self.up_radps(gear, here.torque_nm);
        let may = self.driver.early_upshift && here.speed_radps > truck.idle_radps;
        if waits(true) {
            return gear;
        }
        if must || may { self.higher(gear, must, load) } else { gear }
    }

    /// One gear down, and further while the next one is not above its upshift line.
    fn lower(&self, gear: usize, load: impl Fn(usize) -> Load) -> usize {
        let mut gear = gear.saturating_sub(1);
        while self.driver.skip_gears && gear > 0 {
            let next = load(gear - 1);
            let turns = next.speed_radps >= self.truck.idle_radps;
            if !(turns && next.speed_radps < self.up_radps(gear - 1, next.torque_nm)) {
                break;
            }
            gear -= 1;
        }
        gear
    }

    /// Up while the next gear has a reserve and is above its downshift line; one gear up in any
    /// case where it must.
    fn higher(&self, gear: usize, must: bool, load: impl Fn(usize) -> Load) -> usize {
        let top = self.top();
        let mut gear = if must { (gear + 1).min(top) } else { gear };
        let mut first = !must;
        while gear < top && (first || self.driver.skip_gears) {
            let next = load(gear + 1);
            let turns = next.speed_radps > self.truck.idle_radps
                && next.speed_radps <= self.truck.rated_radps
                && next.speed_radps > self.down_radps(gear + 1, next.torque_nm);
            if !turns || next.reserve < self.driver.torque_reserve {
                break;
            }
            gear += 1;
            first = false;
        }
        gear
    }
}
