//! The powertrain as the step sees it: a diesel engine behind clutch and gearbox, or a battery and a motor.
//!
//! A run has one kind. The step is compiled for each of them, so that neither knows of the other.

use super::record::Record;
use super::state::{State, Total};
use crate::lanes::{Flags, Lanes};
use crate::vehicle::Vehicle;
use fearless_simd::prelude::*;

/// How the engine or motor hangs on the wheels, decided at the step's start.
#[derive(Clone, Copy)]
pub struct Coupling<S: Simd> {
    /// Flag: its shaft turns with the wheels.
    pub closed: Flags<S>,
    /// Flag: its torque comes to the wheels.
    pub engaged: Flags<S>,
    /// Its speed where it does not turn with the wheels, in rad/s.
    pub free_speed: Lanes<S>,
    /// Its speed at the start, in rad/s.
    pub start_speed: Lanes<S>,
    /// Inverse of the moving mass, in 1/kg.
    pub inverse_mass: Lanes<S>,
    /// Force of the engine brake for each rad/s, in N s.
    pub engine_brake: Lanes<S>,
}

/// The inputs of one stage: the demand of the driver, and the air.
#[derive(Clone, Copy)]
pub struct Demand<S: Simd> {
    /// Speed of the truck, in m/s.
    pub speed: Lanes<S>,
    /// Speed of the engine or motor, in rad/s.
    pub engine_speed: Lanes<S>,
    /// Torque that the engine had reached, in Nm.
    pub torque: Lanes<S>,
    /// What comes to it for each Nm of the command; nothing in the first stage.
    pub follow: Option<Lanes<S>>,
    /// Accelerator pedal.
    pub accelerator: Lanes<S>,
    /// Braking force that the driver wants, in N.
    pub brake: Lanes<S>,
    /// Relative wind from ahead, at least 1 m/s.
    pub air: Lanes<S>,
    /// Cross wind, in m/s.
    pub cross: Lanes<S>,
}

/// Torques and forces of one stage.
#[derive(Clone, Copy)]
pub struct TractiveEffort<S: Simd> {
    /// Torque that the engine's torque follows, in Nm.
    pub command: Lanes<S>,
    /// Highest torque of the engine, in Nm.
    pub full_load: Lanes<S>,
    /// Lowest torque of the engine, in Nm.
    pub drag_torque: Lanes<S>,
    /// Torque of the auxiliaries on the shaft, in Nm.
    pub auxiliary_torque: Lanes<S>,
    /// Torque that goes to the gears, in Nm.
    pub gearbox_torque: Lanes<S>,
    /// Force of the driveline at the wheels, in N.
    pub wheel: Lanes<S>,
    /// What the driveline takes on the way, in N at the wheels.
    pub lost: Lanes<S>,
    /// Force of the brakes, in N.
    pub brake: Lanes<S>,
    /// What the engine brake has of it, in N.
    pub engine_brake: Lanes<S>,
    /// Tangent of the wind's angle.
    pub wind_tangent: Lanes<S>,
}

/// What the shaft of the engine or motor does in a step.
#[derive(Clone, Copy)]
pub struct ShaftStep<S: Simd> {
    /// Length of the step, in s.
    pub dt: Lanes<S>,
    /// Angle of the shaft, in rad.
    pub angle: Lanes<S>,
    /// Mean speed, in rad/s.
    pub speed: Lanes<S>,
    /// Mean torque, in Nm.
    pub torque: Lanes<S>,
    /// What the auxiliaries have of it, in Nm.
    pub auxiliary: Lanes<S>,
}

/// Takes an amount for a total.
pub type Add<'a> = &'a mut dyn FnMut(Total, f64);

/// A kind of powertrain.
pub trait Powertrain {
    /// Moment of inertia of engine or motor, in kg m².
    fn inertia_kgm2(&self) -> f64;
    /// Speed of the engine at rest, in rad/s.
    fn idle_radps(&self) -> f64;
    /// Highest torque, in Nm.
    fn peak_torque_nm(&self) -> f64;
    /// Time constant with which torque follows the pedal, in s; above 0 also where torque has no memory.
    fn torque_lag_s(&self) -> f64;
    /// Highest torque at a speed in rad/s, in Nm.
    fn full_load_nm(&self, speed_radps: f64) -> f64;
    /// Torque that has followed a pedal for long, in Nm; 0 where torque has no memory.
    fn settled_torque_nm(&self, speed_radps: f64, accelerator: f64) -> f64;
    /// Heating and cooling at a temperature, in W.
    fn climate_w(&self, air_temperature_k: f64) -> f64;

    /// How it hangs on the wheels in this step.
    fn couple<S: Simd>(&self, state: &mut State<S>, accelerator: Lanes<S>) -> Coupling<S>;
    /// Torques and forces at one stage.
    fn tractive_effort<S: Simd>(
        &self,
        state: &State<S>,
        at: &Demand<S>,
        coupling: &Coupling<S>,
    ) -> TractiveEffort<S>;
    /// Adds what the step takes from the store and what it loses on the way to the shaft, and returns the rate: fuel in kg/s, or
    /// power at the battery's terminals in W.
    fn consume<S: Simd>(
        &self,
        state: &mut State<S>,
        shaft: &ShaftStep<S>,
        added: &mut [Lanes<S>; Total::COUNT],
    ) -> Lanes<S>;
    /// Flag: the store is empty.
    fn is_empty<S: Simd>(&self, state: &State<S>) -> Flags<S>;

    /// Whether that of one truck is.
    fn is_stranded<S: Simd>(&self, state: &State<S>, lane: usize) -> bool;
    /// Loads what belongs to one truck.
    fn enter<S: Simd>(&self, state: &mut State<S>, lane: usize, vehicle: &Vehicle);
    /// Stands for some time, in s.
    fn stand<S: Simd>(&self, state: &mut State<S>, lane: usize, time_s: f64, add: Add);
    /// Fills in what the record says of it.
    fn record<S: Simd>(&self, state: &State<S>, lane: usize, plain: Record) -> Record;
}
