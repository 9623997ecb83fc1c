//! Accumulation: what a step adds to the energy ledger.

use super::one_step::Stages;
use super::stage::engine_speed_at;
use super::state::{KernelParameters, State};
use crate::energy::ledger::{Ledger, StepLedger, Term};
use crate::lanes::{Bounded, Lanes, lerp, masked};
use crate::powertrain::{Powertrain, ShaftStep};
use fearless_simd::prelude::*;

/// Keeps a quotient finite, in N.
const SMALLEST_FORCE_N: f64 = 1e-9;

/// Additions of a step to the ledger, and its means.
#[derive(Clone, Copy)]
pub(super) struct StepTotals<S: Simd> {
    pub added: Ledger<Lanes<S>>,
    pub drag: Lanes<S>,
    /// Mean speed of the engine, and its speed at the end, in rad/s.
    pub engine_speed: Lanes<S>,
    pub end_speed: Lanes<S>,
    pub engine_torque: Lanes<S>,
    pub source_rate: Lanes<S>,
}

impl<S: Simd, P: Powertrain> State<S, P> {
    /// Adds the step to the integrals over the cycle.
    #[inline(always)]
    pub(super) fn accumulate(
        &mut self,
        stages: &Stages<S, P>,
        parameters: &KernelParameters<P>,
    ) -> StepTotals<S> {
        let half = 0.5;
        let Stages { decision, first, second, end, .. } = stages;
        let (dt, dx) = (end.dt, end.dx);
        let coupling = &decision.coupling;
        let start_speed = coupling.start_speed;
        let end_speed = engine_speed_at(end.speed, &self.gear, coupling);
        let mean_speed = (start_speed + end_speed) * half;

        let gearbox_angle = dx * self.gear.speed_ratio;
        let angle = coupling.closed.select(gearbox_angle, dt * coupling.free_speed);
        let weight = end.weight;
        let (start, later) = (&first.effort, &second.effort);
        let gearbox_torque = lerp(weight, start.gearbox_torque, later.gearbox_torque);
        let jump = self.motion.engine_speed * self.motion.engine_speed - start_speed * start_speed;
        let drag = lerp(weight, first.drag, second.drag);
        let engine_brake = lerp(weight, start.engine_brake, later.engine_brake);
        let service_brake = lerp(weight, start.brake, later.brake) - engine_brake;
        // at the hubs: what speeds up the engine or the motor does not come through them
        let inertia = self.constants.moving_mass_closed - self.constants.moving_mass_open;
        let rotating = masked(coupling.closed & coupling.engaged, inertia);
        let hub = start.wheel - rotating * first.acceleration;
        let later_hub = later.wheel - rotating * second.acceleration;
        // the mean of the positive part of a force that changes evenly
        let hub_end = hub + (weight + weight) * (later_hub - hub);
        let positive = hub.at_least(0.0) + hub_end.at_least(0.0);
        let twice = hub.abs() + hub_end.abs();
        let driving = positive * positive / (twice + twice + SMALLEST_FORCE_N);
        let mut ledger = StepLedger::new(dt.simd, &mut self.ledger);
        ledger.add(Term::Time, dt);
        ledger.add(Term::Distance, dx);
        let pedals = &decision.control;
        let pressed = pedals.accelerator.simd_gt(0.0) | pedals.braking.simd_gt(0.0);
        ledger.add(Term::Coasting, masked(!pressed, dx));
        let shaft = ShaftStep {
            dt,
            angle,
            gearbox_angle,
            speed: mean_speed,
            gearbox_torque,
            engine_brake: engine_brake * dx,
            weight,
        };
        let [engine_torque, source_rate] = parameters.powertrain.consume(
            &mut self.powertrain,
            &shaft,
            &start.own,
            &later.own,
            &mut ledger,
        );
        let lost = lerp(weight, start.lost, later.lost);
        ledger.add(Term::Transmission, lost * dx);
        ledger.add(Term::Shift, jump * (0.5 * parameters.engine_inertia_kgm2));
        ledger.add(Term::Drag, drag * dx);
        ledger.add(Term::Rolling, decision.rolling * dx);
        ledger.add(Term::Grade, decision.grade * dx);
        ledger.add(Term::ServiceBrake, service_brake * dx);
        ledger.add(Term::Wheel, driving * dx);
        let added = ledger.added;
        StepTotals { added, drag, engine_speed: mean_speed, end_speed, engine_torque, source_rate }
    }
}
