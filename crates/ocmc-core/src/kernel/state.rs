//! The state of trucks that drive side by side.

use super::powertrain::Powertrain;
use super::road_row::{RoadRow, UNBOUNDED};
use super::step_length::AFTER_JUMP;
use crate::driver::pedal::PedalModel;
use crate::lanes::{Lanes, WIDTH};
use crate::powertrain::diesel::engine::Curves;
use crate::study::{SimulationModel, Study};
use crate::vehicle::VehicleParameters;
use fearless_simd::prelude::*;

/// What is summed up over a cycle. Each is integrated on its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Total {
    /// Integrated time, in s.
    Time,
    /// Distance, in m.
    Distance,
    /// Fuel, in kg.
    Fuel,
    /// Work of the engine at the crankshaft or of the motor at its shaft, in J.
    Crankshaft,
    /// Work of the auxiliaries, in J.
    Auxiliary,
    /// Loss of the slipping clutch, in J.
    Clutch,
    /// Loss of gearbox, retarder and axle, in J.
    Transmission,
    /// Kinetic energy of the engine that its jumps in speed lose, signed, in J.
    Shift,
    /// Work against the air, in J.
    Drag,
    /// Work against rolling resistance, in J.
    InitialMotion,
    /// Work against gravity, in J.
    Grade,
    /// Work of the service brakes, in J.
    ServiceBrake,
    /// Work of the engine brake, in J.
    EngineBrake,
    /// Positive work at the wheels, in J.
    Wheel,
    /// Energy that the battery's store has lost, charging at stops not counted, in J.
    Battery,
    /// Heat in the battery, in J.
    BatteryLoss,
    /// Losses of motor and inverter, in J.
    MotorLoss,
    /// Energy that braking by the motor brought back to the terminals, in J.
    Regenerated,
    /// Energy that charging at stops put into the store, in J.
    Charged,
    /// Heat in the battery while it was charged, in J.
    ChargingLoss,
    /// Time beyond the points of a map, or beyond what the battery can give, in s.
    OutsideMap,
}

impl Total {
    /// How many there are.
    pub const COUNT: usize = 21;
}

/// Numbers that all trucks of a study share, read in every step.
#[derive(Clone, Debug)]
pub struct KernelParameters<'a, T> {
    /// The powertrain.
    pub powertrain: T,
    /// Gears, cross wind.
    pub vehicle: &'a VehicleParameters,
    /// Numerics.
    pub simulation: &'a SimulationModel,
    /// Pedals.
    pub pedals: &'a PedalModel,
    /// Inertia of engine or motor, in kg m².
    pub engine_inertia_kgm2: f64,
    /// Speed of the engine at rest, in rad/s.
    pub idle_radps: f64,
    /// Wheels' inertia as a mass, in kg.
    pub wheel_mass_kg: f64,
    /// Launch speed squared, in m²/s².
    pub launch: f64,
    /// Inverse of the limiter's range, in s/m.
    pub per_limiter_range: f64,
    /// Inverse of the brake pedal's scale: what the brakes realise of the controller's output, at most.
    pub per_brake_scale: f64,
    /// Deceleration that the brakes give for each unit of it, in m/s².
    pub brake_mps2: f64,
    /// Longest step of a truck whose acceleration changes, in s.
    pub short_step_s: f64,
    /// Longest step after a jump of the pedals, in s.
    pub step_after_jump_s: f64,
    /// Speed, in m/s, below which a truck that makes too little progress is for half of the time, at least.
    pub slow_mps: f64,
    /// Torque, in Nm, that with an engine speed gives the highest road power, in W, with which a gear is strong enough.
    pub most_power_nm: f64,
    /// Inverse time constants of the engine's torque and of the derivative filter, in 1/s.
    pub per_lag_s: [f64; 2],
}

impl<'a, T: Powertrain> KernelParameters<'a, T> {
    /// Collects them from a study that has this powertrain.
    pub fn new(study: &'a Study, powertrain: T) -> Self {
        let vehicle = study.vehicle();
        let pedals = &study.model().driver.pedals;
        let simulation = &study.model().simulation;
        let torque_lag_s = powertrain.torque_lag_s();
        let launch_mps = study.model().driver.speed_change.launch_speed_mps;
        let shift = &vehicle.shift;
        let most_power_nm = powertrain.peak_torque_nm() * shift.power_share / shift.power_reserve;
        Self {
            engine_inertia_kgm2: powertrain.inertia_kgm2(),
            idle_radps: powertrain.idle_radps(),
            powertrain,
            vehicle,
            simulation,
            pedals,
            wheel_mass_kg: vehicle.model.wheel_mass_kg(),
            launch: launch_mps * launch_mps,
            per_limiter_range: 1.0 / vehicle.model.limiter_range_mps,
            per_brake_scale: 1.0 / pedals.brake_scale,
            brake_mps2: pedals.brake_scale * vehicle.model.brakes.full_deceleration_mps2,
            short_step_s: simulation.short_step_s(),
            step_after_jump_s: AFTER_JUMP * simulation.step_s,
            slow_mps: 2.0 * simulation.stall_distance_m / simulation.stall_time_s,
            most_power_nm,
            per_lag_s: [1.0 / torque_lag_s, 1.0 / pedals.pid.derivative_filter_s],
        }
    }
}

/// Eight trucks. A flag is 1 or 0.
#[derive(Clone, Debug)]
pub struct State<S: Simd> {
    /// Speed, in m/s.
    pub speed: Lanes<S>,
    /// The road rows of each truck.
    pub roads: [Vec<RoadRow>; WIDTH],
    /// The row that each truck is on.
    pub at: [usize; WIDTH],
    /// Distance left in the segment, in m; 0 where the next step begins with the next row.
    pub left: Lanes<S>,
    /// Torque of the engine when it drives the wheels, in Nm.
    pub torque: Lanes<S>,
    /// Integral part J of the controller.
    pub integral: Lanes<S>,
    /// Filtered speed of the derivative part, in m/s.
    pub filtered: Lanes<S>,
    /// Controller output that a switched driver holds.
    pub held: Lanes<S>,
    /// Flag: a switched driver was holding it in the last step.
    pub holding: Lanes<S>,
    /// Engine speed at the end of the last step, in rad/s.
    pub engine_speed: Lanes<S>,
    /// Time left of a shift, in s.
    pub shift_left: Lanes<S>,
    /// Time left until the next shift is allowed, in s.
    pub hold_left: Lanes<S>,
    /// Time left until the pressed pedal asks for a kick-down, in s.
    pub kick_left: Lanes<S>,
    /// Longest next step, in s.
    pub longest: Lanes<S>,
    /// Steps left until the next check of progress; those of a moving truck count little.
    pub steps_left: Lanes<S>,
    /// Engine speed for each m/s in this gear, in rad/m.
    pub gear_speed: Lanes<S>,
    /// The same in the next higher gear; 0 in the top gear.
    pub gear_speed_up: Lanes<S>,
    /// The same in the next lower gear; far above everything in first gear.
    pub gear_speed_down: Lanes<S>,
    /// Share of the input torque that the gearbox loses.
    pub gear_loss: Lanes<S>,
    /// Engine speed below which the clutch may slip in this gear, in rad/s; 0 where it may not.
    pub slips_below: Lanes<S>,
    /// Longest step with a pressed brake, in s: with longer ones the pedals would swing from step to step.
    pub brake_step: Lanes<S>,
    /// Accelerator from which on an engine at the speed of a slipping clutch drives; with less the clutch does not slip.
    pub slips_from: Lanes<S>,
    /// Speed above which the engine turns too fast in this gear, in m/s; none in the top gear.
    pub too_fast: Lanes<S>,
    /// Inverse of the moving mass with the clutch closed, in 1/kg.
    pub inverse_mass_closed: Lanes<S>,
    /// Inverse of the moving mass without the engine, in 1/kg.
    pub inverse_mass_open: Lanes<S>,
    /// Mass, in kg.
    pub mass: Lanes<S>,
    /// Drag area without cross wind, in m².
    pub drag_area: Lanes<S>,
    /// Power of the auxiliaries, in W.
    pub auxiliary_power: Lanes<S>,
    /// Factor on the fuel map.
    pub fuel_factor: Lanes<S>,
    /// K_P.
    pub proportional: Lanes<S>,
    /// K_I.
    pub integral_gain: Lanes<S>,
    /// K_D over the filter's time constant.
    pub derivative_over_filter: Lanes<S>,
    /// Anti-windup gain on J, 1/T_t, in 1/s.
    pub tracking: Lanes<S>,
    /// K_P times the band of overspeed.
    pub band_output: Lanes<S>,
    /// Threshold of a switched driver, in m/s; far below zero for a PID, which never holds.
    pub threshold: Lanes<S>,
    /// Lowest output that is held where the desired speed is above the truck's: 0, or none where a held brake is held.
    pub lowest_held: Lanes<S>,
    /// Twice the deceleration, in m/s².
    pub twice_deceleration: Lanes<S>,
    /// Twice the acceleration, in m/s².
    pub twice_acceleration: Lanes<S>,
    /// Full load and drag in this step.
    pub curves: Curves<S>,
    /// State of charge of the battery.
    pub charge: Lanes<S>,
    /// Sums over the cycle, by [`Total`].
    pub totals: [Lanes<S>; Total::COUNT],
}

impl<S: Simd> State<S> {
    /// Trucks that stand on a flat road for ever: what an empty lane does.
    pub fn parked<T: Powertrain>(simd: S, parameters: &KernelParameters<T>) -> Self {
        let all = |value| Lanes::splat(simd, value);
        let zero = all(0.0);
        let gear = &parameters.vehicle.gears[0];
        Self {
            speed: zero,
            roads: std::array::from_fn(|_| vec![RoadRow::PARKED]),
            at: [0; WIDTH],
            left: all(UNBOUNDED),
            torque: zero,
            integral: zero,
            filtered: zero,
            held: zero,
            holding: zero,
            engine_speed: all(parameters.idle_radps),
            shift_left: zero,
            hold_left: zero,
            kick_left: all(UNBOUNDED),
            longest: all(parameters.short_step_s),
            steps_left: all(f64::INFINITY),
            gear_speed: all(gear.speed_ratio_per_m),
            gear_speed_up: zero,
            gear_speed_down: all(UNBOUNDED),
            gear_loss: all(gear.loss_share),
            slips_below: zero,
            brake_step: all(parameters.short_step_s),
            slips_from: zero,
            too_fast: all(UNBOUNDED),
            inverse_mass_closed: all(1e-3),
            inverse_mass_open: all(1e-3),
            mass: all(1e3),
            drag_area: all(1.0),
            auxiliary_power: zero,
            fuel_factor: zero,
            proportional: all(1.0),
            integral_gain: zero,
            derivative_over_filter: zero,
            tracking: zero,
            band_output: zero,
            threshold: all(-UNBOUNDED),
            lowest_held: zero,
            twice_deceleration: all(1.0),
            twice_acceleration: all(1.0),
            curves: Curves { lines: [zero; 4], map_torque: zero },
            charge: all(f64::INFINITY),
            totals: [zero; Total::COUNT],
        }
    }

    /// Takes a lane out of service: its truck stands on an endless road.
    pub fn park(&mut self, lane: usize) {
        for column in [&mut self.speed, &mut self.torque, &mut self.integral, &mut self.holding] {
            column[lane] = 0.0;
        }
        self.integral_gain[lane] = 0.0;
        self.left[lane] = UNBOUNDED;
        self.roads[lane] = vec![RoadRow::PARKED];
        self.at[lane] = 0;
        self.steps_left[lane] = f64::INFINITY;
        self.hold_left[lane] = f64::INFINITY;
        self.charge[lane] = f64::INFINITY;
    }

    /// One total of one lane.
    pub fn total(&self, lane: usize, total: Total) -> f64 {
        self.totals[total as usize][lane]
    }

    /// The road row that a lane's truck is on.
    #[inline(always)]
    pub fn row(&self, lane: usize) -> &RoadRow {
        &self.roads[lane][self.at[lane]]
    }

    /// Engages a gear (from 0) in a lane.
    pub fn set_gear<T: Powertrain>(
        &mut self,
        lane: usize,
        gear: usize,
        parameters: &KernelParameters<T>,
    ) {
        let gears = &parameters.vehicle.gears;
        let here = &gears[gear];
        self.gear_speed[lane] = here.speed_ratio_per_m;
        self.gear_speed_up[lane] = gears.get(gear + 1).map_or(0.0, |up| up.speed_ratio_per_m);
        self.gear_speed_down[lane] =
            gear.checked_sub(1).map_or(UNBOUNDED, |down| gears[down].speed_ratio_per_m);
        self.gear_loss[lane] = here.loss_share;
        let shift = &parameters.vehicle.shift;
        self.slips_below[lane] = if here.launches { shift.launch_speed_radps } else { 0.0 };
        let is_top = gear + 1 == gears.len();
        self.too_fast[lane] =
            if is_top { UNBOUNDED } else { shift.overspeed_radps / here.speed_ratio_per_m };
        let open = self.mass[lane] + parameters.wheel_mass_kg;
        let engine =
            parameters.engine_inertia_kgm2 * here.speed_ratio_per_m * here.speed_ratio_per_m;
        self.inverse_mass_open[lane] = 1.0 / open;
        self.inverse_mass_closed[lane] = 1.0 / (open + engine);
    }
}
