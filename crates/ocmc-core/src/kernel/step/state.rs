//! The state of trucks that drive side by side, and the numbers that they share.

use super::road_row::RoadRow;
use super::step_length::AFTER_JUMP;
use crate::charging::ChargingPolicy;
use crate::driver::look_ahead::LookAheadModel;
use crate::driver::pedal::PedalModel;
use crate::energy::ledger::Ledger;
use crate::lanes::{Lanes, UNBOUNDED, WIDTH};
use crate::powertrain::Powertrain;
use crate::powertrain::component::gearbox::GearLanes;
use crate::study::{SimulationModel, Study};
use crate::vehicle::VehicleParameters;
use crate::vehicle::resistance::GRAVITY_MPS2;
use fearless_simd::prelude::*;

/// Rate, in 1/s, at which a step evaluates the torque lag of a powertrain without one. One division
/// serves that lag and the one of the driver's filter: the rate is part of the filter's last bits.
const RATE_WITHOUT_LAG: f64 = 1.0;

/// Numbers that all trucks of a study share, read in every step.
#[derive(Clone, Debug)]
pub struct KernelParameters<'a, P> {
    /// The powertrain.
    pub powertrain: &'a P,
    /// Gears, cross wind.
    pub vehicle: &'a VehicleParameters,
    /// Numerics.
    pub simulation: &'a SimulationModel,
    /// Pedals.
    pub pedals: &'a PedalModel,
    /// Looking ahead.
    pub look_ahead: &'a LookAheadModel,
    /// Whether any of it is on.
    pub looks_ahead: bool,
    /// Charging, where the study has a policy.
    pub charging: Option<&'a ChargingPolicy>,
    /// Whether the powertrain has a temperature that matters.
    pub has_temperature: bool,
    /// Square of the speed to which a truck coasts before a stop, in m²/s²: 0, or unbounded where
    /// it does not.
    pub stop_target: f64,
    /// Inertia of engine or motor, in kg m².
    pub engine_inertia_kgm2: f64,
    /// Speed of the engine at rest, in rad/s.
    pub idle_radps: f64,
    /// Wheels' inertia as a mass, in kg.
    pub wheel_mass_kg: f64,
    /// Inverse of the limiter's range, in s/m.
    pub per_limiter_range: f64,
    /// Inverse of the brake pedal's scale: the most of the controller's output that brakes realise.
    pub per_brake_scale: f64,
    /// Deceleration that the brakes give for each unit of it, in m/s².
    pub brake_mps2: f64,
    /// Share of the static speed that a braking ramp leaves before the driver brakes.
    pub braked_share: f64,
    /// Longest step of a truck whose acceleration changes, in s.
    pub short_step_s: f64,
    /// Longest step after a jump of the pedals, in s.
    pub step_after_jump_s: f64,
    /// Speed, in m/s, below which a truck without progress is for half of the time, at least.
    pub slow_mps: f64,
    /// Torque, in Nm, that with an engine speed gives the highest power, in W, that counts after an
    /// upshift.
    pub most_power_nm: f64,
    /// Acceleration that has to be left after an upshift, in m/s².
    pub least_mps2: f64,
    /// Number of road types.
    pub road_types: usize,
    /// Inverse time constants of the powertrain's torque and of the derivative filter, in 1/s.
    pub per_lag_s: [f64; 2],
}

impl<'a, P: Powertrain> KernelParameters<'a, P> {
    /// Collects them from a study that has this powertrain.
    pub fn new(study: &'a Study, powertrain: &'a P) -> Self {
        let vehicle = study.vehicle();
        let pedals = &study.model().driver.pedals;
        let look_ahead = &study.model().driver.look_ahead;
        let simulation = &study.model().simulation;
        let constants = powertrain.constants();
        let shift = &vehicle.shift;
        let torque_rate = constants.torque_lag_s.map_or(RATE_WITHOUT_LAG, |lag_s| 1.0 / lag_s);
        Self {
            powertrain,
            vehicle,
            simulation,
            pedals,
            look_ahead,
            looks_ahead: look_ahead.drives(),
            charging: study.model().charging.as_ref(),
            has_temperature: vehicle.powertrain.has_temperature(),
            stop_target: if look_ahead.coasting { 0.0 } else { UNBOUNDED },
            engine_inertia_kgm2: constants.inertia_kgm2,
            idle_radps: constants.idle_radps,
            wheel_mass_kg: vehicle.model.wheel_mass_kg(),
            per_limiter_range: 1.0 / vehicle.model.limiter_range_mps,
            per_brake_scale: 1.0 / pedals.brake_scale,
            brake_mps2: pedals.brake_scale * vehicle.model.brakes.full_deceleration_mps2,
            braked_share: 1.0 - pedals.ramp_slack_share,
            short_step_s: simulation.short_step_s(),
            step_after_jump_s: AFTER_JUMP * simulation.step_s,
            slow_mps: 2.0 * simulation.stall_distance_m / simulation.stall_time_s,
            most_power_nm: constants.peak_torque_nm * shift.power_share,
            least_mps2: shift.minimum_acceleration_mps2,
            road_types: study.road_types().len(),
            per_lag_s: [torque_rate, 1.0 / pedals.pid.derivative_filter_s],
        }
    }
}

/// Trucks of a block.
#[derive(Clone, Debug)]
pub struct State<S: Simd, P: Powertrain> {
    /// Quantities that change from step to step.
    pub motion: Motion<S>,
    /// Quantities that hold over a cycle.
    pub constants: LaneConstants<S>,
    /// The gears that are engaged.
    pub gear: GearLanes<S>,
    /// The powertrain's own state.
    pub powertrain: P::State<S>,
    /// Sums over the cycle.
    pub ledger: Ledger<Lanes<S>>,
}

/// Motion and driver of the trucks of a block. A flag is 1 or 0.
#[derive(Clone, Debug)]
pub struct Motion<S: Simd> {
    /// Speed, in m/s.
    pub speed: Lanes<S>,
    /// The road rows of each truck.
    pub roads: [Vec<RoadRow>; WIDTH],
    /// The row that each truck is on.
    pub at: [usize; WIDTH],
    /// Distance left in the segment, in m; 0 where the next step begins with the next row.
    pub left: Lanes<S>,
    /// Integral part J of the controller.
    pub integral: Lanes<S>,
    /// Filtered speed of the derivative part, in m/s.
    pub filtered: Lanes<S>,
    /// Controller output that a switched driver holds.
    pub held: Lanes<S>,
    /// Flag: a switched driver was holding it in the last step.
    pub holding: Lanes<S>,
    /// Flag: the clutch was kept open on a descent in the last step.
    pub rolling: Lanes<S>,
    /// Engine speed at the end of the last step, in rad/s.
    pub engine_speed: Lanes<S>,
    /// Time left of a shift, in s.
    pub shift_left: Lanes<S>,
    /// Time left until the next upshift is allowed, in s.
    pub up_left: Lanes<S>,
    /// Time left until the next downshift is allowed, in s.
    pub down_left: Lanes<S>,
    /// Square of the desired speed at the end of the last step, in m²/s²: from there it rises with
    /// the driver's acceleration.
    pub ceiling: Lanes<S>,
    /// Drag of the air in the last step, in N.
    pub drag: Lanes<S>,
    /// Time left until the pressed pedal asks for a kick-down, in s.
    pub kick_left: Lanes<S>,
    /// Longest next step, in s.
    pub longest: Lanes<S>,
    /// Steps left until the next check of progress; those of a moving truck count little.
    pub steps_left: Lanes<S>,
}

/// Constants of the trucks of a block and their drivers over a cycle, the masses in a gear.
#[derive(Clone, Debug)]
pub struct LaneConstants<S: Simd> {
    /// Longest step with a pressed brake, in s: with longer ones the pedals would oscillate.
    pub brake_step: Lanes<S>,
    /// Inverse of the moving mass with the clutch closed, in 1/kg.
    pub inverse_mass_closed: Lanes<S>,
    /// Inverse of the moving mass without the engine, in 1/kg.
    pub inverse_mass_open: Lanes<S>,
    /// Moving mass with the clutch closed, in kg.
    pub moving_mass_closed: Lanes<S>,
    /// Moving mass without the engine, in kg.
    pub moving_mass_open: Lanes<S>,
    /// Mass, in kg.
    pub mass: Lanes<S>,
    /// Mass on the driven axles, in kg.
    pub driven_mass: Lanes<S>,
    /// Output of the controller for each N of braking force, in 1/N.
    pub per_brake_force: Lanes<S>,
    /// Drag area without cross wind, in m².
    pub drag_area: Lanes<S>,
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
    /// K_P times the speed over the desired one at which the driver brakes; far below zero where he
    /// brakes with the controller's output.
    pub tolerance_output: Lanes<S>,
    /// Flag: the driver follows braking ramps with feed-forward.
    pub feeds: Lanes<S>,
    /// K_P on a braking ramp.
    pub ramp_gain: Lanes<S>,
    /// Threshold of a switched driver, in m/s; far below zero for a PID, which never holds.
    pub threshold: Lanes<S>,
    /// The same for beginning to hold.
    pub entry_threshold: Lanes<S>,
    /// Error that a driver around a held pedal leaves as it is, in m/s; 0 for all others.
    pub dead_zone: Lanes<S>,
    /// Flag: what is held is the pedal that keeps the speed.
    pub balances: Lanes<S>,
    /// Lowest output that is held where the desired speed is above the truck's: 0, or none where a
    /// held brake is held.
    pub lowest_held: Lanes<S>,
    /// Twice the deceleration, in m/s².
    pub twice_deceleration: Lanes<S>,
    /// Inverse of the driver's acceleration from rest, in s²/m.
    pub rise_from_rest: Lanes<S>,
    /// Its growth with the speed, in s³/m².
    pub rise_per_mps: Lanes<S>,
    /// The most that the accelerator asks for, over the driver's acceleration.
    pub peak_ratio: Lanes<S>,
    /// Least square of the speed from which the desired speed rises, in m²/s²; unbounded where it
    /// follows the limit at once.
    pub least_ceiling: Lanes<S>,
    /// Twice the deceleration times the time before a ramp at which the driver leaves the
    /// accelerator, in m/s.
    pub lead: Lanes<S>,
    /// The same for the time before a ramp without upshifts.
    pub before_ramp: Lanes<S>,
}

impl<S: Simd, P: Powertrain> State<S, P> {
    /// Trucks that stand on a flat road for ever: what an empty lane does.
    pub fn parked(simd: S, parameters: &KernelParameters<P>) -> Self {
        let all = |value| Lanes::splat(simd, value);
        let zero = all(0.0);
        Self {
            motion: Motion {
                speed: zero,
                roads: std::array::from_fn(|_| vec![RoadRow::PARKED]),
                at: [0; WIDTH],
                left: all(UNBOUNDED),
                integral: zero,
                filtered: zero,
                held: zero,
                holding: zero,
                rolling: zero,
                engine_speed: all(parameters.idle_radps),
                shift_left: zero,
                up_left: zero,
                down_left: zero,
                ceiling: zero,
                drag: zero,
                kick_left: all(UNBOUNDED),
                longest: all(parameters.short_step_s),
                steps_left: all(f64::INFINITY),
            },
            constants: LaneConstants {
                brake_step: all(parameters.short_step_s),
                inverse_mass_closed: all(1e-3),
                inverse_mass_open: all(1e-3),
                moving_mass_closed: all(1e3),
                moving_mass_open: all(1e3),
                mass: all(1e3),
                driven_mass: all(UNBOUNDED),
                per_brake_force: all(1e-3),
                drag_area: all(1.0),
                proportional: all(1.0),
                integral_gain: zero,
                derivative_over_filter: zero,
                tracking: zero,
                band_output: zero,
                tolerance_output: all(-UNBOUNDED),
                feeds: zero,
                ramp_gain: zero,
                threshold: all(-UNBOUNDED),
                entry_threshold: all(-UNBOUNDED),
                dead_zone: zero,
                balances: zero,
                lowest_held: zero,
                twice_deceleration: all(1.0),
                rise_from_rest: all(UNBOUNDED),
                rise_per_mps: zero,
                peak_ratio: all(1.0),
                least_ceiling: zero,
                lead: zero,
                before_ramp: zero,
            },
            gear: GearLanes::parked(simd, &parameters.vehicle.gears),
            powertrain: parameters.powertrain.parked(simd),
            ledger: Ledger::of(zero),
        }
    }

    /// The road row that a lane's truck is on.
    #[inline(always)]
    pub fn row(&self, lane: usize) -> &RoadRow {
        &self.motion.roads[lane][self.motion.at[lane]]
    }

    /// Engages a gear (from 0) in a lane.
    pub fn set_gear(&mut self, lane: usize, gear: usize, parameters: &KernelParameters<P>) {
        let vehicle = parameters.vehicle;
        self.gear.engage(lane, gear, &vehicle.gears, &vehicle.shift);
        let ratio = self.gear.speed_ratio[lane];
        let open = self.constants.mass[lane] + parameters.wheel_mass_kg;
        let engine = parameters.engine_inertia_kgm2 * ratio * ratio;
        self.constants.moving_mass_open[lane] = open;
        self.constants.moving_mass_closed[lane] = open + engine;
        self.constants.inverse_mass_open[lane] = 1.0 / open;
        self.constants.inverse_mass_closed[lane] = 1.0 / (open + engine);
    }

    /// Slope of the road under a lane's truck, as climb per metre.
    pub fn slope(&self, lane: usize) -> f64 {
        self.row(lane).0[RoadRow::GRADE] / GRAVITY_MPS2
    }
}

/// One lane of a block, outside of the hot loop.
pub(crate) struct Lane<'a, S: Simd, P: Powertrain> {
    /// The block.
    pub state: &'a mut State<S, P>,
    /// Its number there.
    pub number: usize,
    /// Parameters that hold for all lanes.
    pub parameters: &'a KernelParameters<'a, P>,
}

impl<S: Simd, P: Powertrain> Lane<'_, S, P> {
    /// Leaves the lane without a cycle.
    pub(crate) fn park(&mut self) {
        let (motion, lane) = (&mut self.state.motion, self.number);
        for column in [&mut motion.speed, &mut motion.integral, &mut motion.holding] {
            column[lane] = 0.0;
        }
        motion.left[lane] = UNBOUNDED;
        motion.roads[lane] = vec![RoadRow::PARKED];
        motion.at[lane] = 0;
        motion.steps_left[lane] = f64::INFINITY;
        (motion.up_left[lane], motion.down_left[lane]) = (f64::INFINITY, f64::INFINITY);
        (motion.ceiling[lane], motion.drag[lane]) = (0.0, 0.0);
        self.state.constants.integral_gain[lane] = 0.0;
        self.parameters.powertrain.park(&mut self.state.powertrain, lane);
    }

    /// Translational energy, and rotational energy of the wheels, in J.
    pub(crate) fn translational_j(&self) -> f64 {
        let speed = self.state.motion.speed[self.number];
        let mass = self.state.constants.mass[self.number] + self.parameters.wheel_mass_kg;
        0.5 * mass * speed * speed
    }

    /// Translational energy, and rotational energy of wheels and engine, in J.
    pub(crate) fn kinetic_energy_j(&self) -> f64 {
        let engine = self.state.motion.engine_speed[self.number];
        self.translational_j() + 0.5 * self.parameters.engine_inertia_kgm2 * engine * engine
    }

    /// Whether the truck is at the end of its row.
    pub(crate) fn is_at_end(&self) -> bool {
        self.state.motion.left[self.number] <= 0.0
    }

    /// Stop capture, and creep capture of a slow truck.
    pub(crate) fn is_captured(&self) -> bool {
        let (simulation, motion) = (self.parameters.simulation, &self.state.motion);
        let slow = motion.speed[self.number] < simulation.creep_speed_mps;
        let reach = if slow { simulation.creep_distance_m } else { simulation.capture_distance_m };
        motion.left[self.number] + self.state.row(self.number).0[RoadRow::TO_STOP] <= reach
    }

    /// The row at whose end the next stop line is.
    pub(crate) fn stop_row(&self) -> usize {
        let at = self.state.motion.at[self.number];
        let ahead = self.state.motion.roads[self.number][at..].iter();
        at + ahead.take_while(|row| row.dwell_s().is_none()).count()
    }
}
