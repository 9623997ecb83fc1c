//! Interface of a powertrain for the backward mode: the speed is given, and the source follows.

use crate::energy::ledger::{Ledger, Term};
use crate::record::Record;

/// Gear of a step by a prescribed speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GearOrder {
    /// Nothing: the powertrain has its own strategy.
    #[default]
    Free,
    /// No torque passes: the gearbox shifts, or the clutch is open.
    Open,
    /// This gear, from 0.
    Engaged(usize),
}

/// Where the kinetic energy of an engine goes whose speed jumps, and what it does meanwhile, in
/// the backward mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShiftConvention {
    /// It is lost in clutch and synchronisers. An engine that is let go turns down by its drag and
    /// its auxiliaries, and a slipping clutch passes torque.
    #[default]
    Lost,
    /// As VECTO 2.2 counts: the wheels get it back. An engine that has pulled keeps its speed in
    /// the gap and burns fuel for its auxiliaries, and a slipping clutch passes power.
    Returned,
}

/// One step of prescribed speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedStep {
    /// Length, in s.
    pub dt_s: f64,
    /// Speed at its start, in m/s.
    pub start_mps: f64,
    /// Speed at its end, in m/s.
    pub end_mps: f64,
    /// Its gear.
    pub gear: GearOrder,
}

impl SpeedStep {
    /// Mean speed, in m/s.
    pub fn mean_mps(&self) -> f64 {
        0.5 * (self.start_mps + self.end_mps)
    }

    /// Distance, in m.
    pub fn distance_m(&self) -> f64 {
        self.mean_mps() * self.dt_s
    }

    /// Acceleration, in m/s².
    pub fn acceleration_mps2(&self) -> f64 {
        (self.end_mps - self.start_mps) / self.dt_s
    }
}

/// Result of a step of prescribed speed beside the additions to the ledger.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InverseStep {
    /// Force of the driveline at the wheels, in N; less than was asked for where the powertrain is
    /// at its limit, more where brakes have to help.
    pub wheel_n: f64,
    /// Largest force of the engine brake at the wheels, in N.
    pub engine_brake_reach_n: f64,
    /// Whether the powertrain is at its limit.
    pub limited: bool,
    /// Work at the crankshaft or the motor's shaft, in J.
    pub shaft_j: f64,
}

/// Cost of a step of prescribed speed, before it is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepCost {
    /// Energy that the source would give, in J: fuel energy, or what leaves the battery's store.
    pub energy_j: f64,
    /// Force of the driveline at the wheels, in N.
    pub wheel_n: f64,
    /// Kinetic energy of a shaft that can turn apart from the wheels at its start, in J: what it
    /// had less before brings an engine to the speed of a new gear.
    pub shaft_start_j: f64,
    /// The same at its end, in J.
    pub shaft_end_j: f64,
}

/// The gears that can be ordered of a powertrain, and what a shift is.
#[derive(Clone, Debug, PartialEq)]
pub struct GearChoice {
    /// Shaft speed for each m/s, from first to top gear, in rad/m.
    pub per_m: Vec<f64>,
    /// Inertia that turns with the shaft, in kg m².
    pub inertia_kgm2: f64,
    /// Gears, from first, in which the truck can start.
    pub launch_gears: usize,
    /// Shaft speed below which no gear is held that does not start the truck, in rad/s.
    pub slowest_radps: f64,
    /// Shaft speed above which a gear is left for the next one, in rad/s.
    pub fastest_radps: f64,
    /// Speed below which there is no shift, in m/s.
    pub minimum_speed_mps: f64,
    /// Time of a shift without torque, in s.
    pub gap_s: f64,
    /// Shortest time from shift to shift, in s.
    pub interval_s: f64,
    /// Most gears in one upshift.
    pub most_up: usize,
}

/// A powertrain in the backward mode: from the force at the wheels to what it takes.
pub trait InversePowertrain {
    /// The terms that count what its stores give, in J.
    fn stores(&self) -> &'static [Term];
    /// The gears that can be ordered; none where it has to choose its own.
    fn gear_choice(&self) -> Option<GearChoice> {
        None
    }
    /// Cost of a step with that force wanted at the wheels, in N: what [`Self::step`] would add to
    /// the ledger, by the convention [`ShiftConvention::Lost`]. `shaft_radps`: speed of the shaft
    /// before a step without a gear.
    fn cost(&self, step: &SpeedStep, force_n: f64, shaft_radps: f64) -> StepCost;
    /// The terms of the energy ledger that are its own.
    fn terms(&self) -> &'static [Term];
    /// Carries one step with that force wanted at the wheels.
    fn step(&mut self, step: &SpeedStep, force_n: f64, ledger: &mut Ledger<f64>) -> InverseStep;
    /// Counts shifts by this convention from now on, where it has an engine that shifts.
    fn set_convention(&mut self, _convention: ShiftConvention) {}
    /// Kinetic energy beside that of the truck and of the mass that turns with it, in J.
    fn kinetic_j(&self) -> f64 {
        0.0
    }
    /// Mass that turns with the wheels, in kg.
    fn rotating_mass_kg(&self) -> f64 {
        0.0
    }
    /// Shifts so far.
    fn n_shifts(&self) -> u32 {
        0
    }
    /// Time after the source had run empty, in s.
    fn depleted_s(&self) -> f64 {
        0.0
    }
    /// Fills in what the record of a followed cycle says of it.
    fn record(&self, _ledger: &Ledger<f64>, _record: &mut Record) {}
}
