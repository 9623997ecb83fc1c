//! An engine or motor of which only the efficiency over its power is known, as FASTSim and many
//! data sheets have it.

use super::{InversePowertrain, InverseStep, SpeedStep, StepCost};
use crate::energy::ledger::{Ledger, Term};

/// Efficiency over the share of the rated power, linear between the points.
#[derive(Clone, Debug, PartialEq)]
pub struct EfficiencyCurve {
    /// Rated power, in W.
    pub rated_power_w: f64,
    /// Shares of it, rising.
    pub power_share: Vec<f64>,
    /// Efficiency at each share, above 0.
    pub efficiency: Vec<f64>,
}

impl EfficiencyCurve {
    /// Power that has to go in for a power that comes out, in W; beyond the rated power the last
    /// efficiency holds.
    pub fn input_w(&self, output_w: f64) -> f64 {
        if output_w <= 0.0 {
            return 0.0;
        }
        let share = output_w / self.rated_power_w;
        let (x, y) = (&self.power_share, &self.efficiency);
        let k = x.partition_point(|point| *point <= share).clamp(1, x.len() - 1);
        let part = ((share - x[k - 1]) / (x[k] - x[k - 1])).clamp(0.0, 1.0);
        output_w / (y[k - 1] + part * (y[k] - y[k - 1]))
    }
}

/// A driveline of which only efficiencies are known, as in FASTSim: no gears, no drag torque, no
/// engine brake.
#[derive(Clone, Debug, PartialEq)]
pub struct EfficiencyDriveline {
    /// Efficiency from engine to wheels.
    pub transmission_efficiency: f64,
    /// The engine.
    pub engine: EfficiencyCurve,
    /// Power of the auxiliaries, in W.
    pub auxiliary_power_w: f64,
}

impl InversePowertrain for EfficiencyDriveline {
    fn terms(&self) -> &'static [Term] {
        &[Term::Crankshaft]
    }

    fn stores(&self) -> &'static [Term] {
        &[Term::FuelEnergy]
    }

    fn cost(&self, step: &SpeedStep, force_n: f64, _shaft_radps: f64) -> StepCost {
        let mut ledger = Ledger::EMPTY;
        let done = self.clone().step(step, force_n, &mut ledger);
        let energy_j = ledger[Term::FuelEnergy];
        StepCost { energy_j, wheel_n: done.wheel_n, ..StepCost::default() }
    }

    fn step(&mut self, step: &SpeedStep, force_n: f64, ledger: &mut Ledger<f64>) -> InverseStep {
        let wanted_w = (force_n * step.mean_mps()).max(0.0);
        let most_w = (self.engine.rated_power_w - self.auxiliary_power_w).max(0.0);
        let gearbox_w = (wanted_w / self.transmission_efficiency).min(most_w);
        let wheel_w = gearbox_w * self.transmission_efficiency;
        let engine_w = gearbox_w + self.auxiliary_power_w;
        ledger[Term::Crankshaft] += engine_w * step.dt_s;
        ledger[Term::Auxiliary] += self.auxiliary_power_w * step.dt_s;
        ledger[Term::Transmission] += (gearbox_w - wheel_w) * step.dt_s;
        ledger[Term::FuelEnergy] += self.engine.input_w(engine_w) * step.dt_s;
        InverseStep {
            wheel_n: if step.mean_mps() > 0.0 { wheel_w / step.mean_mps() } else { 0.0 },
            engine_brake_reach_n: 0.0,
            limited: wanted_w / self.transmission_efficiency > most_w,
            shaft_j: engine_w * step.dt_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_between_the_points_and_held_beyond() {
        let curve = EfficiencyCurve {
            rated_power_w: 1000.0,
            power_share: vec![0.0, 0.5, 1.0],
            efficiency: vec![0.1, 0.3, 0.4],
        };
        assert!((curve.input_w(250.0) - 250.0 / 0.2).abs() < 1e-9);
        assert!((curve.input_w(750.0) - 750.0 / 0.35).abs() < 1e-9);
        assert!((curve.input_w(2000.0) - 2000.0 / 0.4).abs() < 1e-9);
        assert_eq!(curve.input_w(0.0), 0.0);
    }
}
