//! Powertrains: what turns fuel or charge into force at the wheels.
//!
//! The kernel asks a powertrain by the trait [`Powertrain`], the backward mode by
//! [`InversePowertrain`]. Each kind has a folder: its model, its state in the lanes, its terms of
//! the energy ledger, its columns in trace and record. The step is compiled for each kind, so that
//! none has a branch for another.

pub mod battery_electric;
pub mod combustion;
pub mod component;
pub mod efficiency;
pub mod fuel_cell;
pub mod inverse;
mod model;

use crate::charging::{ChargeCourse, ChargeCurve, ChargingPolicy};
use crate::energy::Carrier;
use crate::energy::ledger::{Ledger, StepLedger, Term};
use crate::first_order_lag::FirstOrderLag;
use crate::lanes::{Flags, Lanes};
use crate::record::Record;
use battery_electric::BatteryElectricPowertrain;
use combustion::CombustionPowertrain;
use component::gearbox::GearLanes;
use fearless_simd::prelude::*;
use fuel_cell::FuelCellPowertrain;

pub use model::{PowertrainModel, Sizes, TRUCK_LAWS};

pub use inverse::{
    GearChoice, GearOrder, InversePowertrain, InverseStep, ShiftConvention, SpeedStep, StepCost,
};

/// The kinds of powertrain.
#[derive(Clone, Debug)]
pub enum PowertrainKind {
    /// An engine behind clutch and gearbox.
    Combustion(CombustionPowertrain),
    /// A battery and a motor.
    BatteryElectric(BatteryElectricPowertrain),
    /// A fuel cell, a battery and a motor.
    FuelCell(Box<FuelCellPowertrain>),
}

impl PowertrainKind {
    /// Gives the powertrain to a task that is compiled for each kind.
    pub fn dispatch<T: PowertrainTask>(&self, task: T) -> T::Answer {
        match self {
            Self::Combustion(powertrain) => task.run(powertrain),
            Self::BatteryElectric(powertrain) => task.run(powertrain),
            Self::FuelCell(powertrain) => task.run(powertrain.as_ref()),
        }
    }

    /// A truck is charged as a policy says: without public chargers it stops with its reserve.
    pub fn follow(&mut self, policy: &ChargingPolicy) {
        // on the way to a public charger a driver uses his reserve where his forecast was wrong
        if let (Self::BatteryElectric(powertrain), None) = (self, &policy.public) {
            let battery = &mut powertrain.model.battery;
            battery.minimum_charge = battery.minimum_charge.max(policy.reserve);
        }
    }

    /// Whether it has a temperature that matters.
    pub fn has_temperature(&self) -> bool {
        match self {
            Self::Combustion(_) | Self::FuelCell(_) => false,
            Self::BatteryElectric(powertrain) => powertrain.model.battery.thermal.is_some(),
        }
    }

    /// Whether chargers charge it.
    pub fn plugs_in(&self) -> bool {
        matches!(self, Self::BatteryElectric(_))
    }

    /// How far ahead of a planned charging stop that is prepared, in m.
    pub fn preconditions_from_m(&self) -> f64 {
        match self {
            Self::Combustion(powertrain) => powertrain.preconditions_from_m(),
            Self::BatteryElectric(powertrain) => powertrain.preconditions_from_m(),
            Self::FuelCell(powertrain) => powertrain.preconditions_from_m(),
        }
    }

    /// Carriers that it stores.
    pub fn carriers(&self) -> &'static [Carrier] {
        match self {
            Self::Combustion(powertrain) => powertrain.carriers(),
            Self::BatteryElectric(powertrain) => powertrain.carriers(),
            Self::FuelCell(powertrain) => powertrain.carriers(),
        }
    }

    /// The most that a body gets at a stop beside auxiliaries, in W; none where the battery gives
    /// it.
    pub fn power_take_off_w(&self, auxiliary_power_w: f64) -> Option<f64> {
        match self {
            Self::Combustion(powertrain) => Some(powertrain.power_take_off_w(auxiliary_power_w)),
            Self::BatteryElectric(_) | Self::FuelCell(_) => None,
        }
    }

    /// The engine behind its gearbox, where it is one.
    pub fn combustion(&self) -> Option<&CombustionPowertrain> {
        if let Self::Combustion(powertrain) = self { Some(powertrain) } else { None }
    }

    /// Names of its columns in a trace.
    pub fn signals(&self) -> SignalNames {
        match self {
            Self::Combustion(_) => CombustionPowertrain::SIGNALS,
            Self::BatteryElectric(_) => BatteryElectricPowertrain::SIGNALS,
            Self::FuelCell(_) => FuelCellPowertrain::SIGNALS,
        }
    }

    /// Force at the wheels of a truck that coasts in top gear at a speed in m/s, in N.
    pub fn coasting_force_n(&self, speed_mps: f64) -> f64 {
        match self {
            Self::Combustion(powertrain) => powertrain.coasting_force_n(speed_mps),
            // a motor runs freely
            Self::BatteryElectric(_) | Self::FuelCell(_) => 0.0,
        }
    }

    /// Its constants.
    pub fn constants(&self) -> PowertrainConstants {
        match self {
            Self::Combustion(powertrain) => powertrain.constants(),
            Self::BatteryElectric(powertrain) => powertrain.constants(),
            Self::FuelCell(powertrain) => powertrain.constants(),
        }
    }
}

/// Task on a powertrain of any kind.
pub trait PowertrainTask {
    /// Result of the task.
    type Answer;
    /// Does it.
    fn run<P: Powertrain>(self, powertrain: &P) -> Self::Answer;
}

/// Numbers of a powertrain that hold for all trucks of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowertrainConstants {
    /// Moment of inertia of engine or motor, in kg m².
    pub inertia_kgm2: f64,
    /// Speed of its shaft at rest, in rad/s.
    pub idle_radps: f64,
    /// Highest torque, in Nm.
    pub peak_torque_nm: f64,
    /// Time constant with which torque follows the pedal, in s; none where it follows at once.
    pub torque_lag_s: Option<f64>,
}

/// Names of the columns in which a trace shows a powertrain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SignalNames {
    /// Speed of the shaft.
    pub speed: &'static str,
    /// Its torque.
    pub torque: &'static str,
    /// Rate taken from the source.
    pub source_rate: &'static str,
    /// A state: [`Powertrain::state_signal`].
    pub state: &'static str,
}

/// Inputs of one truck's powertrain at the start of its cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruckInputs {
    /// Power of the auxiliaries, heating and cooling included, in W.
    pub auxiliary_power_w: f64,
    /// Factor on the fuel map.
    pub map_factor: f64,
    /// State of charge; none without a battery.
    pub initial_charge: Option<f64>,
}

/// Plug of a charger for a truck at rest.
#[derive(Clone, Copy, Debug)]
pub struct Plug<'a> {
    /// Power at the battery's terminals, in W.
    pub power_w: f64,
    /// The most power that the battery takes by its state of charge.
    pub curve: Option<&'a ChargeCurve>,
    /// State of charge at which charging ends.
    pub end_at: f64,
    /// Longest time, in s.
    pub longest_s: f64,
}

/// A store of energy that can be charged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Store {
    /// Its energy, in J.
    pub capacity_j: f64,
    /// State of charge at which a truck stops.
    pub lowest_charge: f64,
}

/// Result of charging.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Charge {
    /// Its time, in s.
    pub time_s: f64,
    /// Energy that the store has gained, in J.
    pub gained_j: f64,
    /// Heat in the battery, in J.
    pub loss_j: f64,
    /// Energy at the terminals, in J, integrated on its own.
    pub supplied_j: f64,
    /// Energy that the charger gave the auxiliaries meanwhile, in J.
    pub carried_j: f64,
}

impl Charge {
    /// Adds another one.
    pub fn add(&mut self, other: &Self) {
        self.time_s += other.time_s;
        self.gained_j += other.gained_j;
        self.loss_j += other.loss_j;
        self.supplied_j += other.supplied_j;
        self.carried_j += other.carried_j;
    }
}

/// How engine or motor hang on the wheels, decided at the step's start.
#[derive(Clone, Copy)]
pub struct Coupling<S: Simd> {
    /// Flag: the shaft turns with the wheels.
    pub closed: Flags<S>,
    /// Flag: its torque comes to the wheels.
    pub engaged: Flags<S>,
    /// Speed of the shaft where it does not turn with the wheels, in rad/s.
    pub free_speed: Lanes<S>,
    /// Speed of the shaft at the start, in rad/s.
    pub start_speed: Lanes<S>,
}

/// Inputs of one stage: the demand of the driver, and the air.
#[derive(Clone, Copy)]
pub struct Demand<S: Simd> {
    /// Speed of the truck, in m/s.
    pub speed: Lanes<S>,
    /// Speed of the shaft, in rad/s.
    pub shaft_speed: Lanes<S>,
    /// Accelerator pedal.
    pub accelerator: Lanes<S>,
    /// Braking force that the driver wants, in N.
    pub brake: Lanes<S>,
    /// The most that may pull at the wheels, in N: what the tyres of the driven axles hold, or the
    /// driver lets.
    pub traction: Lanes<S>,
    /// Relative wind from ahead, at least 1 m/s.
    pub air: Lanes<S>,
    /// Cross wind, in m/s.
    pub cross: Lanes<S>,
}

/// Force at the wheels by the accelerator, once the torque has followed it.
#[derive(Clone, Copy)]
pub struct PedalForces<S: Simd> {
    /// Without a pedal, in N.
    pub coasting: Lanes<S>,
    /// Force of the line over the pedal at 0, in N: the same where the clutch is closed.
    pub released: Lanes<S>,
    /// Pedal for each N more, in 1/N.
    pub per_force: Lanes<S>,
}

impl<S: Simd> PedalForces<S> {
    /// Least force between a released and a pressed accelerator, in N: keeps a quotient finite.
    pub const LEAST_SPAN_N: f64 = 1.0;

    // functions and no closures: a closure is not compiled for the CPU that its caller is
    /// Accelerator that gives a force, in N.
    #[inline(always)]
    pub fn accelerator(&self, force: Lanes<S>) -> Lanes<S> {
        (force - self.released) * self.per_force
    }

    /// Output of a controller that gives a force, in N: the brakes below what coasting gives.
    #[inline(always)]
    pub fn output(&self, force: Lanes<S>, per_brake_force: Lanes<S>) -> Lanes<S> {
        let brakes = (force - self.coasting) * per_brake_force;
        force.simd_gt(self.coasting).select(self.accelerator(force), brakes)
    }
}

/// Torques and forces of one stage.
#[derive(Clone, Copy)]
pub struct TractiveEffort<S: Simd, Own> {
    /// Torque that goes to the gears, in Nm.
    pub gearbox_torque: Lanes<S>,
    /// Force of the driveline at the wheels, in N.
    pub wheel: Lanes<S>,
    /// Losses of the driveline, in N at the wheels.
    pub lost: Lanes<S>,
    /// Force of the brakes, in N.
    pub brake: Lanes<S>,
    /// Part of the engine brake, in N.
    pub engine_brake: Lanes<S>,
    /// Tangent of the wind's angle.
    pub wind_tangent: Lanes<S>,
    /// Further quantities of this kind of powertrain.
    pub own: Own,
}

/// Course of the shaft of engine or motor in a step.
#[derive(Clone, Copy)]
pub struct ShaftStep<S: Simd> {
    /// Length of the step, in s.
    pub dt: Lanes<S>,
    /// Angle of the shaft, in rad.
    pub angle: Lanes<S>,
    /// Angle of the gearbox's input, in rad.
    pub gearbox_angle: Lanes<S>,
    /// Mean speed, in rad/s.
    pub speed: Lanes<S>,
    /// Mean torque that goes to the gears, in Nm.
    pub gearbox_torque: Lanes<S>,
    /// Mean force of the engine brake times distance, in J.
    pub engine_brake: Lanes<S>,
    /// Share that the second stage has in the means over the step.
    pub weight: Lanes<S>,
}

/// How a step ended, for the powertrain's state.
#[derive(Clone, Copy)]
pub struct StepOutcome<S: Simd> {
    /// Flag: the torque came to the wheels.
    pub engaged: Flags<S>,
    /// Flag: the step is taken back.
    pub too_long: Flags<S>,
    /// Share that the second stage has in the means over the step.
    pub weight: Lanes<S>,
    /// The lag of the torque over the step.
    pub lag: FirstOrderLag<S>,
}

/// A kind of powertrain, as the step of the kernel asks it.
pub trait Powertrain {
    /// Its state in the lanes of a block.
    type State<S: Simd>: Clone;
    /// State of a stage beside torques and forces that all kinds have.
    type Stage<S: Simd>: Copy;
    /// Prediction of the second stage's torque before its pedals are known.
    type Predicted<S: Simd>: Copy;

    /// The sources in the energy balance.
    const SOURCES: &'static [Term];
    /// The terms that count what its stores gave, in the order of [`Powertrain::carriers`].
    const STORES: &'static [Term];
    /// The terms of the energy ledger that are its own.
    const TERMS: &'static [Term];
    /// Its columns in a trace.
    const SIGNALS: SignalNames;

    /// Carriers that it stores.
    fn carriers(&self) -> &'static [Carrier];
    /// Numbers that hold for all trucks.
    fn constants(&self) -> PowertrainConstants;
    /// Highest torque at a speed in rad/s, in Nm.
    fn full_load_nm(&self, speed_radps: f64) -> f64;
    /// Heating and cooling at a temperature, in W, beside the auxiliaries of the truck.
    fn climate_w(&self, _air_temperature_k: f64) -> f64 {
        0.0
    }

    /// The state of trucks that stand for ever.
    fn parked<S: Simd>(&self, simd: S) -> Self::State<S>;
    /// Parks one lane.
    fn park<S: Simd>(&self, state: &mut Self::State<S>, lane: usize);
    /// Loads what belongs to one truck, in air of a temperature in K.
    fn enter<S: Simd>(
        &self,
        state: &mut Self::State<S>,
        lane: usize,
        truck: &TruckInputs,
        air_temperature_k: f64,
    );
    /// A truck at rest prepares to start.
    fn start<S: Simd>(&self, _state: &mut Self::State<S>, _lane: usize) {}
    /// A truck has rolled with an accelerator pedal for long; shaft speed in rad/s.
    fn settle<S: Simd>(
        &self,
        _state: &mut Self::State<S>,
        _lane: usize,
        _speed_radps: f64,
        _accelerator: f64,
    ) {
    }
    /// Stands for some time, in s. From a battery its auxiliaries draw down to the lowest charge,
    /// and nothing while a charger carries them.
    fn stand<S: Simd>(
        &self,
        state: &mut Self::State<S>,
        lane: usize,
        time_s: f64,
        ledger: &mut Ledger<f64>,
    );

    /// Stands for some time, in s, while the body of the truck takes a power, in W. Returns the
    /// work that the body gets, in J.
    fn stand_working<S: Simd>(
        &self,
        state: &mut Self::State<S>,
        lane: usize,
        time_s: f64,
        power_w: f64,
        ledger: &mut Ledger<f64>,
    ) -> f64;

    /// Stands for some time, in s, with what can be stopped stopped; `power_w`: of the auxiliaries
    /// that run on, given back afterwards.
    fn stand_stopped<S: Simd>(
        &self,
        state: &mut Self::State<S>,
        lane: usize,
        time_s: f64,
        _power_w: f64,
        ledger: &mut Ledger<f64>,
    ) {
        self.stand(state, lane, time_s, ledger);
    }

    /// How it hangs on the wheels in this step. `speed`: of the trucks, in m/s; `shifting`: flag,
    /// the gearbox shifts; `opens`: flag, the clutch is kept open.
    fn couple<S: Simd>(
        &self,
        state: &mut Self::State<S>,
        gear: &GearLanes<S>,
        speed: Lanes<S>,
        shifting: Flags<S>,
        opens: Flags<S>,
        accelerator: Lanes<S>,
    ) -> Coupling<S>;
    /// Forces of the accelerator at a speed of the trucks in m/s, from the curves of the last step:
    /// what a driver knows by feel.
    fn pedal_forces<S: Simd>(
        &self,
        state: &Self::State<S>,
        gear: &GearLanes<S>,
        speed: Lanes<S>,
    ) -> PedalForces<S>;
    /// Torques and forces at one stage; `predicted` at the second one.
    fn tractive_effort<S: Simd>(
        &self,
        state: &Self::State<S>,
        gear: &GearLanes<S>,
        coupling: &Coupling<S>,
        demand: &Demand<S>,
        predicted: Option<&Self::Predicted<S>>,
    ) -> TractiveEffort<S, Self::Stage<S>>;
    /// Prediction of the torque at the second stage: the mean of both stages has to be the mean
    /// over the step.
    fn predict<S: Simd>(
        &self,
        state: &Self::State<S>,
        lag: FirstOrderLag<S>,
        first: &Self::Stage<S>,
    ) -> Self::Predicted<S>;
    /// Adds the terms of its own to the ledger. Returns the mean torque of the shaft, in Nm, and
    /// what is taken from the source: fuel in kg/s, or power at the battery's terminals in W.
    fn consume<S: Simd>(
        &self,
        state: &mut Self::State<S>,
        shaft: &ShaftStep<S>,
        first: &Self::Stage<S>,
        second: &Self::Stage<S>,
        ledger: &mut StepLedger<S>,
    ) -> [Lanes<S>; 2];
    /// The new state at the end of a step.
    #[inline(always)]
    fn commit<S: Simd>(
        &self,
        _state: &mut Self::State<S>,
        _outcome: &StepOutcome<S>,
        _first: &Self::Stage<S>,
        _second: &Self::Stage<S>,
    ) {
    }
    /// The same powertrain with a source that never empties; none where it has none that does.
    fn never_emptying(&self) -> Option<Self>
    where
        Self: Sized,
    {
        None
    }
    /// Its store; none without a battery.
    fn store(&self) -> Option<Store> {
        None
    }
    /// Charge by a charger from a state of charge on, and how it goes on; none where nothing can be
    /// charged.
    fn charged_by(&self, _plug: &Plug, _charge: f64, _course: &mut ChargeCourse) -> Option<Charge> {
        None
    }
    /// State of charge of one lane; none without a battery.
    fn charge_of<S: Simd>(&self, _state: &Self::State<S>, _lane: usize) -> Option<f64> {
        None
    }
    /// By how much the state of charge rises with an energy that the store gains, in J.
    fn rise(&self, _gained_j: f64) -> f64 {
        0.0
    }
    /// Charges one lane at rest, whose auxiliaries the charger carries first; nothing where nothing
    /// can be charged. The truck stays plugged in.
    fn charge<S: Simd>(
        &self,
        _state: &mut Self::State<S>,
        _lane: usize,
        _plug: &Plug,
        _course: &mut ChargeCourse,
    ) -> Charge {
        Charge::default()
    }
    /// Unplugs one lane; returns what the charger has given its auxiliaries since it was charged,
    /// in J.
    fn unplug<S: Simd>(&self, _state: &mut Self::State<S>, _lane: usize) -> f64 {
        0.0
    }
    /// How far ahead of a planned charging stop its temperature is prepared, in m.
    fn preconditions_from_m(&self) -> f64 {
        0.0
    }
    /// Looks at the temperature of one lane, by its sums over the cycle. `preconditions`: whether a
    /// charging stop is near.
    fn look_at_temperature<S: Simd>(
        &self,
        _state: &mut Self::State<S>,
        _lane: usize,
        _ledger: &Ledger<f64>,
        _preconditions: bool,
    ) {
    }
    /// Flag: the source is empty.
    fn depleted<S: Simd>(&self, state: &Self::State<S>) -> Flags<S>;

    /// The state that a trace shows. `closed`: whether the shaft turned with the wheels.
    fn state_signal<S: Simd>(&self, state: &Self::State<S>, lane: usize, closed: bool) -> f64;
    /// Torque, in Nm, and source rate of a truck that stood, from what was added to its ledger.
    fn standing_signals(&self, added: &Ledger<f64>, time_s: f64, speed_radps: f64) -> [f64; 2];
    /// Fills in what the record of a driven cycle says of it.
    fn record<S: Simd>(
        &self,
        state: &Self::State<S>,
        lane: usize,
        ledger: &Ledger<f64>,
        record: &mut Record,
    );

    /// The same powertrain in the backward mode.
    fn inverse<'a>(&'a self, truck: &TruckInputs) -> Box<dyn InversePowertrain + 'a>;
}
