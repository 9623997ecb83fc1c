//! A fuel-cell powertrain in the backward mode: that of a battery-electric one, whose battery the
//! cell feeds by the same rule.

use super::FuelCellPowertrain;
use crate::energy::ledger::{Ledger, Mode, Term};
use crate::lanes::one;
use crate::powertrain::battery_electric::InverseBatteryElectric;
use crate::powertrain::{
    InversePowertrain, InverseStep, Powertrain, SpeedStep, StepCost, TruckInputs,
};
use crate::record::Record;

/// The powertrain, its battery, and what is in its tank.
#[derive(Clone, Debug)]
pub(super) struct InverseFuelCell<'a> {
    powertrain: &'a FuelCellPowertrain,
    electric: InverseBatteryElectric<'a>,
    auxiliary_w: f64,
    demand_w: f64,
    factor: f64,
    tank_kg: f64,
    depleted_s: f64,
}

impl<'a> InverseFuelCell<'a> {
    pub(super) fn new(powertrain: &'a FuelCellPowertrain, truck: &TruckInputs) -> Self {
        Self {
            powertrain,
            electric: InverseBatteryElectric::new(&powertrain.electric, truck),
            auxiliary_w: truck.auxiliary_power_w,
            demand_w: truck.auxiliary_power_w,
            factor: truck.map_factor,
            tank_kg: powertrain.model.usable_hydrogen_kg,
            depleted_s: 0.0,
        }
    }
}

impl InversePowertrain for InverseFuelCell<'_> {
    fn terms(&self) -> &'static [Term] {
        FuelCellPowertrain::TERMS
    }

    fn stores(&self) -> &'static [Term] {
        &[Term::Battery, Term::CellInput]
    }

    /// Energy that the step draws, as if the battery gave all of it.
    fn cost(&self, step: &SpeedStep, force_n: f64, shaft_radps: f64) -> StepCost {
        self.electric.cost(step, force_n, shaft_radps)
    }

    fn step(&mut self, step: &SpeedStep, force_n: f64, ledger: &mut Ledger<f64>) -> InverseStep {
        let inputs = [self.electric.charge(), self.demand_w, self.auxiliary_w];
        let power_w = self.powertrain.cell_power_w(inputs, self.tank_kg);
        self.electric.set_auxiliary_w(self.auxiliary_w - power_w);
        let at_terminals_j =
            |ledger: &Ledger<f64>| ledger[Term::Battery] - ledger[Term::BatteryLoss];
        let (before_j, depleted_s) = (at_terminals_j(ledger), self.electric.depleted_s());
        let done = self.electric.step(step, force_n, ledger);
        // the motor's side has booked the auxiliaries less the cell's power
        ledger[Term::Auxiliary] += power_w * step.dt_s;
        let fed = self.tank_kg > 0.0;
        self.tank_kg -= self.powertrain.book(power_w, self.factor, step.dt_s, ledger);
        if !fed {
            self.depleted_s += self.electric.depleted_s() - depleted_s;
        }
        if step.dt_s > 0.0 {
            let demand_w = (at_terminals_j(ledger) - before_j) / step.dt_s + power_w;
            let [filtered, demand, dt] = [self.demand_w, demand_w, step.dt_s].map(one);
            self.demand_w = self.powertrain.model.split.followed_w(filtered, demand, dt)[0];
        }
        done
    }

    fn rotating_mass_kg(&self) -> f64 {
        self.electric.rotating_mass_kg()
    }

    fn n_shifts(&self) -> u32 {
        self.electric.n_shifts()
    }

    fn depleted_s(&self) -> f64 {
        self.depleted_s
    }

    fn record(&self, ledger: &Ledger<f64>, record: &mut Record) {
        FuelCellPowertrain::record_stores(self.electric.charge(), ledger, Mode::Followed, record);
    }
}
