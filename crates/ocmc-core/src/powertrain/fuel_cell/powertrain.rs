//! Fuel cell, battery and motor, in the step of the kernel.
//!
//! To motor and battery the cell's power is auxiliaries of the other sign: the battery sees A − P.
//! It is decided where a step begins, and held over it. Hydrogen, its energy and the cell's loss
//! are integrated each on its own.

use super::FuelCellModel;
use super::cell::Cell;
use super::inverse::InverseFuelCell;
use super::split::given_share;
use crate::energy::Carrier;
use crate::energy::ledger::{Ledger, Mode, StepLedger, Term};
use crate::first_order_lag::FirstOrderLag;
use crate::lanes::{Flags, Lanes, masked, one};
use crate::powertrain::battery_electric::{BatteryElectricPowertrain, BatteryState};
use crate::powertrain::component::battery::BatteryLimits;
use crate::powertrain::component::gearbox::GearLanes;
use crate::powertrain::{
    Coupling, Demand, InversePowertrain, PedalForces, Powertrain, PowertrainConstants, ShaftStep,
    SignalNames, TractiveEffort, TruckInputs,
};
use crate::record::{Outcome, Record};
use fearless_simd::prelude::*;

/// Longest time for which the cell's power holds at rest, in s.
const SLICE_S: f64 = 60.0;

/// A powertrain prepared for the hot loop.
#[derive(Clone, Debug)]
pub struct FuelCellPowertrain {
    /// Motor, gears and battery.
    pub electric: BatteryElectricPowertrain,
    /// Fuel cell.
    pub cell: Cell,
    /// The numbers as given.
    pub model: FuelCellModel,
}

/// Cells and batteries of a block.
#[derive(Clone, Debug)]
pub struct FuelCellState<S: Simd> {
    /// The batteries; their auxiliaries are those of the truck less the cell's power.
    pub battery: BatteryState<S>,
    /// Power of the auxiliaries, in W.
    pub auxiliary: Lanes<S>,
    /// Electric demand behind its filter, in W.
    pub demand: Lanes<S>,
    /// Net power of the cell, in W.
    pub power: Lanes<S>,
    /// Factor on the cell's map.
    pub factor: Lanes<S>,
    /// Hydrogen in the tank, in kg.
    pub tank: Lanes<S>,
}

impl FuelCellPowertrain {
    /// Prepares a checked model.
    pub fn new(model: &FuelCellModel, wheel_radius_m: f64) -> Self {
        let electric = BatteryElectricPowertrain::new(&model.electric, wheel_radius_m);
        Self { electric, cell: Cell::new(&model.cell), model: model.clone() }
    }

    /// Power of a cell, in W, of a truck with this charge, filtered demand and auxiliaries, in W.
    pub(super) fn cell_power_w(&self, inputs: [f64; 3], tank_kg: f64) -> f64 {
        let battery = &self.electric.model.battery;
        let inputs = inputs.map(one);
        let limits = BatteryLimits::of(inputs[0].simd, battery);
        let split = &self.model.split;
        let power_w = split.cell_powers_w(inputs, battery, &limits, self.cell.power_w)[0];
        if tank_kg > 0.0 { power_w } else { 0.0 }
    }

    /// Adds what the cell takes for a power, in W, over a time, in s; returns the hydrogen, in kg.
    pub(super) fn book(
        &self,
        power_w: f64,
        factor: f64,
        time_s: f64,
        ledger: &mut Ledger<f64>,
    ) -> f64 {
        let taken_w = self.cell.hydrogen_w(power_w) * factor;
        let hydrogen_kg = taken_w * self.cell.kg_per_j * time_s;
        ledger[Term::CellInput] += taken_w * time_s;
        ledger[Term::CellLoss] += (taken_w - power_w) * time_s;
        ledger[Term::Fuel] += hydrogen_kg;
        hydrogen_kg
    }

    /// Fills in the columns of both stores.
    pub(super) fn record_stores(
        charge: f64,
        ledger: &Ledger<f64>,
        mode: Mode,
        record: &mut Record,
    ) {
        let (drawn_j, hydrogen_kg) = (ledger[Term::Battery], ledger[Term::Fuel]);
        record.take(Carrier::Electricity, drawn_j, drawn_j, mode);
        record.take(Carrier::Hydrogen, hydrogen_kg, hydrogen_kg, mode);
        record.fuel_energy_j = Some(ledger[Term::CellInput]);
        record.final_charge = Some(charge);
        record.take_all(mode);
        if record.outcome == Outcome::Completed {
            record.drove_whole_trip(record.distance_m, record.all_kwh_per_km());
        }
    }
}

impl Powertrain for FuelCellPowertrain {
    type State<S: Simd> = FuelCellState<S>;
    type Stage<S: Simd> = ();
    type Predicted<S: Simd> = ();

    const SOURCES: &'static [Term] = &[Term::CellInput, Term::Battery];
    const STORES: &'static [Term] = &[Term::Battery, Term::Fuel];
    const TERMS: &'static [Term] = &[
        Term::Fuel,
        Term::CellInput,
        Term::CellLoss,
        Term::Battery,
        Term::BatteryLoss,
        Term::MotorLoss,
        Term::Regenerated,
    ];
    const SIGNALS: SignalNames = BatteryElectricPowertrain::SIGNALS;

    fn carriers(&self) -> &'static [Carrier] {
        &[Carrier::Electricity, Carrier::Hydrogen]
    }

    fn constants(&self) -> PowertrainConstants {
        self.electric.constants()
    }

    fn full_load_nm(&self, speed_radps: f64) -> f64 {
        self.electric.full_load_nm(speed_radps)
    }

    fn climate_w(&self, air_temperature_k: f64) -> f64 {
        self.electric.climate_w(air_temperature_k)
    }

    fn parked<S: Simd>(&self, simd: S) -> FuelCellState<S> {
        let zero = Lanes::splat(simd, 0.0);
        FuelCellState {
            battery: self.electric.parked(simd),
            auxiliary: zero,
            demand: zero,
            power: zero,
            factor: zero,
            tank: Lanes::splat(simd, f64::INFINITY),
        }
    }

    fn park<S: Simd>(&self, state: &mut FuelCellState<S>, lane: usize) {
        self.electric.park(&mut state.battery, lane);
        state.tank[lane] = f64::INFINITY;
    }

    fn enter<S: Simd>(
        &self,
        state: &mut FuelCellState<S>,
        lane: usize,
        truck: &TruckInputs,
        air_temperature_k: f64,
    ) {
        self.electric.enter(&mut state.battery, lane, truck, air_temperature_k);
        state.auxiliary[lane] = truck.auxiliary_power_w;
        state.demand[lane] = truck.auxiliary_power_w;
        state.power[lane] = 0.0;
        state.factor[lane] = truck.map_factor;
        state.tank[lane] = self.model.usable_hydrogen_kg;
    }

    /// The auxiliaries draw, and the cell brings the battery to its target.
    fn stand<S: Simd>(
        &self,
        state: &mut FuelCellState<S>,
        lane: usize,
        time_s: f64,
        ledger: &mut Ledger<f64>,
    ) {
        let battery = &self.electric.model.battery;
        let (auxiliary_w, mut left_s) = (state.auxiliary[lane], time_s);
        while left_s > 0.0 {
            let slice_s = left_s.min(SLICE_S);
            let (charge, demand_w) = (state.battery.charge[lane], state.demand[lane]);
            let power_w = self.cell_power_w([charge, demand_w, auxiliary_w], state.tank[lane]);
            let flow = battery.flow(charge, auxiliary_w - power_w);
            // with an empty tank there may be nothing left to draw
            let drawn_s = battery.lasts_s(charge, flow.store_w, slice_s);
            ledger[Term::Battery] += flow.store_w * drawn_s;
            ledger[Term::BatteryLoss] += flow.loss_w * drawn_s;
            ledger[Term::Auxiliary] += auxiliary_w * drawn_s;
            state.battery.charge[lane] -= flow.store_w * drawn_s / battery.capacity_j;
            state.tank[lane] -= self.book(power_w, state.factor[lane], drawn_s, ledger);
            let [filtered, demand, dt] = [demand_w, auxiliary_w, slice_s].map(one);
            state.demand[lane] = self.model.split.followed_w(filtered, demand, dt)[0];
            left_s -= slice_s;
        }
    }

    /// The body draws as the auxiliaries do.
    fn stand_working<S: Simd>(
        &self,
        state: &mut FuelCellState<S>,
        lane: usize,
        time_s: f64,
        power_w: f64,
        ledger: &mut Ledger<f64>,
    ) -> f64 {
        let own_w = state.auxiliary[lane];
        state.auxiliary[lane] = own_w + power_w;
        self.stand(state, lane, time_s, ledger);
        state.auxiliary[lane] = own_w;
        power_w * time_s
    }

    #[inline(always)]
    fn couple<S: Simd>(
        &self,
        state: &mut FuelCellState<S>,
        gear: &GearLanes<S>,
        speed: Lanes<S>,
        shifting: Flags<S>,
        opens: Flags<S>,
        accelerator: Lanes<S>,
    ) -> Coupling<S> {
        let battery = &self.electric.model.battery;
        let charge = state.battery.charge;
        let fed = state.tank.simd_gt(0.0);
        // with an empty tank the truck drives on until its battery is empty, too
        let share = given_share(battery, charge);
        let share = fed.select(share, Lanes::splat(share.simd, 1.0));
        state.battery.limits.set_discharge_power(share * battery.discharge_power_w);
        let inputs = [charge, state.demand, state.auxiliary];
        let limits = &state.battery.limits;
        let power = self.model.split.cell_powers_w(inputs, battery, limits, self.cell.power_w);
        state.power = masked(fed, power);
        state.battery.auxiliary_power = state.auxiliary - state.power;
        self.electric.couple(&mut state.battery, gear, speed, shifting, opens, accelerator)
    }

    #[inline(always)]
    fn pedal_forces<S: Simd>(
        &self,
        state: &FuelCellState<S>,
        gear: &GearLanes<S>,
        speed: Lanes<S>,
    ) -> PedalForces<S> {
        self.electric.pedal_forces(&state.battery, gear, speed)
    }

    #[inline(always)]
    fn tractive_effort<S: Simd>(
        &self,
        state: &FuelCellState<S>,
        gear: &GearLanes<S>,
        coupling: &Coupling<S>,
        demand: &Demand<S>,
        predicted: Option<&()>,
    ) -> TractiveEffort<S, ()> {
        self.electric.tractive_effort(&state.battery, gear, coupling, demand, predicted)
    }

    #[inline(always)]
    fn predict<S: Simd>(&self, _state: &FuelCellState<S>, _lag: FirstOrderLag<S>, _first: &()) {}

    #[inline(always)]
    fn consume<S: Simd>(
        &self,
        state: &mut FuelCellState<S>,
        shaft: &ShaftStep<S>,
        _first: &(),
        _second: &(),
        ledger: &mut StepLedger<S>,
    ) -> [Lanes<S>; 2] {
        let drawn = self.electric.draw(&mut state.battery, shaft, state.auxiliary, ledger);
        let (power, dt) = (state.power, shaft.dt);
        let taken = self.cell.hydrogens_w(power) * state.factor;
        let hydrogen = taken * dt * self.cell.kg_per_j;
        ledger.add(Term::CellInput, taken * dt);
        ledger.add(Term::CellLoss, (taken - power) * dt);
        ledger.add(Term::Fuel, hydrogen);
        state.tank -= hydrogen;
        state.demand = self.model.split.followed_w(state.demand, drawn[1] + power, dt);
        drawn
    }

    /// A tank without end.
    fn never_emptying(&self) -> Option<Self> {
        let mut endless = self.clone();
        endless.model.usable_hydrogen_kg = f64::INFINITY;
        Some(endless)
    }

    #[inline(always)]
    fn depleted<S: Simd>(&self, state: &FuelCellState<S>) -> Flags<S> {
        let is_fed = state.tank.simd_gt(0.0);
        !is_fed & self.electric.depleted(&state.battery)
    }

    fn state_signal<S: Simd>(&self, state: &FuelCellState<S>, lane: usize, closed: bool) -> f64 {
        self.electric.state_signal(&state.battery, lane, closed)
    }

    fn standing_signals(&self, added: &Ledger<f64>, time_s: f64, _speed_radps: f64) -> [f64; 2] {
        let terminals_j = added[Term::Battery] - added[Term::BatteryLoss];
        [0.0, if time_s > 0.0 { terminals_j / time_s } else { 0.0 }]
    }

    fn record<S: Simd>(
        &self,
        state: &FuelCellState<S>,
        lane: usize,
        ledger: &Ledger<f64>,
        record: &mut Record,
    ) {
        Self::record_stores(state.battery.charge[lane], ledger, Mode::Driven, record);
    }

    fn inverse<'a>(&'a self, truck: &TruckInputs) -> Box<dyn InversePowertrain + 'a> {
        Box::new(InverseFuelCell::new(self, truck))
    }
}
