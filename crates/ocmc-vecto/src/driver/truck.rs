//! The truck as the planner asks it: what a second of driving takes of the engine.

use ocmc_core::powertrain::combustion::CombustionPowertrain;
use ocmc_core::powertrain::component::gearbox::GearboxModel;
use ocmc_core::prescribed::Body;

/// Revolutions per minute in rad/s.
pub(super) const RPM: f64 = std::f64::consts::PI / 30.0;
/// Share of the span from idle to rated speed below which the clutch slips.
const SLIP_SHARE: f64 = 0.03;
/// Share of that span, from idle, above which an engine turns too fast.
const FAST_SHARE: f64 = 1.2;
/// Share of an open engine's power that is that of its drag.
const FALLING_SHARE: f64 = 0.75;
/// Points of engine speed and torque over which efficiencies are averaged.
const POINTS: f64 = 15.0 * 11.0;
/// Steps of a fixed point; each takes two digits and more.
const FIXED_POINT_STEPS: usize = 12;

/// Body and powertrain, and what is computed of them before a drive.
#[derive(Clone, Debug)]
pub(super) struct Truck<'a> {
    body: &'a Body,
    pub(super) powertrain: &'a CombustionPowertrain,
    axle_per_m: f64,
    /// Mass with that of the wheels at the rim, in kg.
    inertia_kg: f64,
    /// Mean efficiency from the engine to the wheels by gear.
    efficiency: Vec<f64>,
    /// Speed at which the engine has its greatest power, in rad/s.
    pub(super) rated_radps: f64,
    /// Idle speed, in rad/s.
    pub(super) idle_radps: f64,
}

/// A second of driving: its means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motion {
    /// Speed, in m/s.
    pub(super) speed_mps: f64,
    /// Acceleration, in m/s².
    pub(super) acceleration_mps2: f64,
    /// Climb per metre of road.
    pub(super) slope: f64,
    /// Power of all auxiliaries, in W.
    pub(super) auxiliary_w: f64,
}

impl<'a> Truck<'a> {
    pub(super) fn new(body: &'a Body, powertrain: &'a CombustionPowertrain) -> Self {
        let gear = &powertrain.gears[0];
        let axle_per_m = gear.speed_ratio_per_m / gear.ratio;
        let idle_radps = powertrain.engine_model.idle_speed_radps;
        let mut truck = Self {
            body,
            powertrain,
            axle_per_m,
            inertia_kg: body.mass_kg + body.wheel_mass_kg,
            efficiency: Vec::new(),
            rated_radps: rated_radps(powertrain),
            idle_radps,
        };
        truck.efficiency = truck.mean_efficiencies();
        truck
    }

    /// Mean efficiencies over the upper two thirds of torque, by gear: of the gear, times that of
    /// the axle over all gears.
    fn mean_efficiencies(&self) -> Vec<f64> {
        let CombustionPowertrain { engine, gears, gearbox, .. } = self.powertrain;
        // the same box with an ideal axle: what the gears alone lose
        let box_alone = GearboxModel {
            axle_loss_torque_nm: 0.0,
            axle_loss_share: 0.0,
            retarder_torque_nm: 0.0,
            retarder_torque_nms2: None,
            ..gearbox.clone()
        };
        let both = [&box_alone, gearbox].map(|gearbox| gearbox.losses(self.axle_per_m));
        let span_radps = (self.rated_radps - self.idle_radps) / 15.0;
        let (mut axle_sum, mut gear_means) = (0.0, Vec::with_capacity(gears.len()));
        for gear in gears {
            let mut gear_sum = 0.0;
            for k in 1..=15 {
                let speed_radps = self.idle_radps + f64::from(k) * span_radps;
                let speed_mps = speed_radps / gear.speed_ratio_per_m;
                let full_nm = engine.full_load_nm(speed_radps);
                for j in 0..=10 {
                    let torque_nm = full_nm * (1.0 / 3.0 + f64::from(j) / 15.0);
                    let [shaft_n, wheel_n] =
                        both.map(|losses| losses.wheel_and_lost_n(gear, speed_mps, torque_nm)[0]);
                    gear_sum += shaft_n / (torque_nm * gear.speed_ratio_per_m);
                    axle_sum += wheel_n / shaft_n;
                }
            }
            gear_means.push(gear_sum / POINTS);
        }
        let axle_mean = axle_sum / (POINTS * gears.len() as f64);
        gear_means.iter().map(|mean| (mean * axle_mean).clamp(0.1, 1.0)).collect()
    }

    /// Power at the wheels, in W.
    pub(super) fn wheel_w(&self, motion: &Motion) -> f64 {
        self.wheel_n(motion) * motion.speed_mps
    }

    fn wheel_n(&self, motion: &Motion) -> f64 {
        let road_n = self.body.road_forces(motion.speed_mps, motion.slope).sum_n();
        self.inertia_kg * motion.acceleration_mps2 + road_n
    }

    /// Engine speed in a gear at a speed of the truck, in rad/s.
    pub(super) fn speed_radps(&self, gear: usize, speed_mps: f64) -> f64 {
        self.powertrain.gears[gear].speed_ratio_per_m * speed_mps
    }

    /// Power for turning the engine from one speed to another in a second, in W.
    pub(super) fn spin_w(&self, from_radps: f64, to_radps: f64) -> f64 {
        let inertia_kgm2 = self.powertrain.engine_model.inertia_kgm2;
        0.5 * inertia_kgm2 * (to_radps * to_radps - from_radps * from_radps)
    }

    /// Power that the gearbox takes at its input in a gear, in W; a slipping clutch passes it.
    pub(super) fn gearbox_w(&self, gear: usize, motion: &Motion) -> f64 {
        let CombustionPowertrain { gears, gearbox, .. } = self.powertrain;
        let (gear, speed_mps) = (&gears[gear], motion.speed_mps);
        let force_n = self.wheel_n(motion);
        let torque_nm = gearbox.input_torque_nm(gear, self.axle_per_m, speed_mps, force_n);
        torque_nm * gear.speed_ratio_per_m * speed_mps
    }

    /// Power of the engine in a gear by mean efficiencies, in W, without that for its own inertia.
    pub(super) fn quick_w(&self, gear: usize, motion: &Motion) -> f64 {
        let (wheel_w, efficiency) = (self.wheel_w(motion), self.efficiency[gear]);
        let gearbox_w = if wheel_w > 0.0 { wheel_w / efficiency } else { wheel_w * efficiency };
        gearbox_w + motion.auxiliary_w
    }

    /// Full load in W at a speed in rad/s.
    pub(super) fn full_w(&self, speed_radps: f64) -> f64 {
        self.powertrain.engine.full_load_nm(speed_radps) * speed_radps
    }

    /// Drag power (negative) in W at a speed in rad/s.
    pub(super) fn drag_w(&self, speed_radps: f64) -> f64 {
        self.powertrain.engine.drag_nm(speed_radps) * speed_radps
    }

    /// Engine speed below which the clutch slips at a start, in rad/s.
    pub(super) fn slips_below_radps(&self) -> f64 {
        self.idle_radps + SLIP_SHARE * (self.rated_radps - self.idle_radps)
    }

    /// Engine speed behind a slipping clutch whose other side has a speed, both in rad/s.
    pub(super) fn slipping_radps(&self, speed_radps: f64) -> f64 {
        let span_radps = self.rated_radps - self.idle_radps;
        let share = SLIP_SHARE / self.slips_below_radps();
        self.idle_radps + speed_radps.max(self.idle_radps) * share * span_radps
    }

    /// Engine speed above which it turns too fast, in rad/s.
    pub(super) fn fast_radps(&self) -> f64 {
        self.idle_radps + FAST_SHARE * (self.rated_radps - self.idle_radps)
    }

    /// Engine speed after a second with an open clutch, in rad/s: J w' (w' - w) is a share of the
    /// power that the engine gave in the second before, the rest is that of its drag.
    pub(super) fn released_radps(&self, last_radps: f64, last_w: f64) -> f64 {
        let inertia_kgm2 = self.powertrain.engine_model.inertia_kgm2;
        let excess_w = |w: f64| {
            let power_w = (1.0 - FALLING_SHARE) * last_w + FALLING_SHARE * self.drag_w(w);
            power_w - inertia_kgm2 * w * (w - last_radps)
        };
        let (mut low, mut high) = (self.idle_radps.min(last_radps), last_radps);
        if excess_w(high) >= 0.0 {
            return high.max(self.idle_radps);
        }
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if excess_w(middle) > 0.0 { low = middle } else { high = middle }
        }
        high.max(self.idle_radps)
    }

    /// Acceleration of a truck that begins a second at a speed and is pushed by a force at its
    /// wheels that depends on its mean speed, in m/s².
    fn free_mps2(
        &self,
        start_mps: f64,
        slope: f64,
        inertia_kg: f64,
        wheel_n: impl Fn(f64) -> f64,
    ) -> f64 {
        let mut acceleration_mps2 = 0.0;
        for _ in 0..FIXED_POINT_STEPS {
            let mean_mps = (start_mps + 0.5 * acceleration_mps2).max(0.0);
            let road_n = self.body.road_forces(mean_mps, slope).sum_n();
            acceleration_mps2 = (wheel_n(mean_mps) - road_n) / inertia_kg;
        }
        acceleration_mps2
    }

    /// Acceleration of a truck that rolls with an open clutch, in m/s².
    pub(super) fn rolling_mps2(&self, start_mps: f64, slope: f64) -> f64 {
        self.free_mps2(start_mps, slope, self.inertia_kg, |_| 0.0)
    }

    /// Mass with that of the wheels and of the engine in a gear, in kg, by mean efficiencies.
    fn coasting_kg(&self, gear: usize) -> f64 {
        let per_m = self.powertrain.gears[gear].speed_ratio_per_m;
        let inertia_kgm2 = self.powertrain.engine_model.inertia_kgm2;
        self.inertia_kg + inertia_kgm2 * per_m * per_m / self.efficiency[gear]
    }

    /// Force at the wheels of an engine that drags in a gear at a speed, in N, by mean
    /// efficiencies.
    fn dragging_n(&self, gear: usize, speed_mps: f64, auxiliary_w: f64) -> f64 {
        let per_m = self.powertrain.gears[gear].speed_ratio_per_m;
        let engine_nm = self.powertrain.engine.drag_nm(per_m * speed_mps);
        (engine_nm * per_m - auxiliary_w / speed_mps.max(1.0)) / self.efficiency[gear]
    }

    /// Acceleration of a truck that is slowed by its engine in a gear, in m/s², by mean
    /// efficiencies.
    pub(super) fn coasting_mps2(
        &self,
        gear: usize,
        start_mps: f64,
        slope: f64,
        auxiliary_w: f64,
    ) -> f64 {
        self.free_mps2(start_mps, slope, self.coasting_kg(gear), |mean_mps| {
            self.dragging_n(gear, mean_mps, auxiliary_w)
        })
    }

    /// Acceleration of a truck that is slowed by its engine in a gear, in m/s², by the losses of
    /// that gear. An engine that would turn below idle is let go.
    pub(super) fn dragged_mps2(
        &self,
        gear: usize,
        start_mps: f64,
        slope: f64,
        auxiliary_w: f64,
    ) -> f64 {
        if self.speed_radps(gear, start_mps) < self.idle_radps {
            return self.rolling_mps2(start_mps, slope);
        }
        let per_m = self.powertrain.gears[gear].speed_ratio_per_m;
        let inertia_kg =
            self.inertia_kg + self.powertrain.engine_model.inertia_kgm2 * per_m * per_m;
        self.free_mps2(start_mps, slope, inertia_kg, |mean_mps| {
            self.dragged_n(gear, mean_mps, auxiliary_w)
        })
    }

    /// Force at the wheels (negative) of an engine that drags in a gear at a speed, in N.
    fn dragged_n(&self, gear: usize, speed_mps: f64, auxiliary_w: f64) -> f64 {
        let CombustionPowertrain { engine, gears, losses, .. } = self.powertrain;
        let speed_radps = self.speed_radps(gear, speed_mps).max(self.idle_radps);
        let torque_nm = engine.drag_nm(speed_radps) - auxiliary_w / speed_radps;
        losses.wheel_and_lost_n(&gears[gear], speed_mps, torque_nm)[0]
    }

    /// Energy that has to go between two speeds in m/s and a climb in m, and force of coasting on
    /// the level: air by the mean of the squares of the speeds, the engine at the first one.
    pub(super) fn slowing(
        &self,
        gear: Option<usize>,
        [start_mps, end_mps]: [f64; 2],
        climb_m: f64,
    ) -> Slowing {
        let squares = [start_mps * start_mps, end_mps * end_mps];
        let mean_mps = (0.5 * (squares[0] + squares[1])).sqrt();
        let level_n = self.body.road_forces(mean_mps, 0.0).sum_n();
        let engine_n = gear.map_or(0.0, |gear| self.dragged_n(gear, start_mps, 0.0));
        // a slope of 1 has the weight as its force
        let weight_n = self.body.road_forces(0.0, 1.0).grade_n;
        let kinetic_j = 0.5 * self.inertia_kg * (squares[0] - squares[1]);
        Slowing { energy_j: kinetic_j - weight_n * climb_m, coasting_n: level_n - engine_n }
    }
}

/// Energies of slowing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slowing {
    /// Energy that has to go, in J.
    pub(super) energy_j: f64,
    /// Force of coasting, in N.
    pub(super) coasting_n: f64,
}

/// The engine speed of the greatest power on a grid of whole revolutions per minute, in rad/s.
fn rated_radps(powertrain: &CombustionPowertrain) -> f64 {
    let model = &powertrain.engine_model;
    let last_radps = model.full_load_speed_radps.last().copied().unwrap_or(model.idle_speed_radps);
    let (first, last) = (libm::round(model.idle_speed_radps / RPM), libm::round(last_radps / RPM));
    let power_w = |w: f64| powertrain.engine.full_load_nm(w) * w;
    let mut best = model.idle_speed_radps;
    for k in 0..=(last - first).clamp(0.0, 20_000.0) as u32 {
        let w = (first + f64::from(k)) * RPM;
        if power_w(w) > power_w(best) {
            best = w;
        }
    }
    best
}
