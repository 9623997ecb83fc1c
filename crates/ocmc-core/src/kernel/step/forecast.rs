//! Pedals that a driver knows by feel before a step: those that keep the speed, that follow a
//! braking ramp or a rise, and that accelerate as hard as he ever does; and the push at which he
//! lifts his foot.
//!
//! It is read from the road under the truck, its mass, its gear, its air drag and the curves of its
//! engine in the last step: what is missing the feedback corrects.

use super::road_row::{RoadRow, RoadRowLanes};
use super::state::{KernelParameters, State};
use crate::lanes::{Lanes, UNBOUNDED};
use crate::powertrain::{PedalForces, Powertrain};
use fearless_simd::prelude::*;

/// Acceleration at which a driver lifts his foot at once, over the most that he asks for [EJ].
/// Where a road gets less steep under a truck that gathers speed, its torque is too high until it
/// has followed the pedal, and the truck would jump.
const LIFTS_AT: f64 = 1.2;

/// Outputs of a controller: the accelerator above 0, the brakes below.
#[derive(Clone, Copy)]
pub(super) struct Forecast<S: Simd> {
    /// Keeps the speed.
    pub holding: Lanes<S>,
    /// Follows a braking ramp.
    pub ramp: Lanes<S>,
    /// Gives the driver's acceleration.
    pub rise: Lanes<S>,
    /// Gives the driver's peak acceleration.
    pub peak: Lanes<S>,
    /// Force at the wheels, in N, at which he lifts his foot.
    pub most: Lanes<S>,
    /// Output that holds a truck back that a descent pushes harder: of the brakes; unbounded where
    /// none does.
    pub holding_back: Lanes<S>,
    /// Deceleration of a truck that coasts in gear, in m/s².
    pub coasting: Lanes<S>,
    /// The same with an open clutch.
    pub neutral: Lanes<S>,
}

/// Forces at a speed, in N, and the moving mass, in kg.
struct Asked<S: Simd> {
    pedal: PedalForces<S>,
    mass: Lanes<S>,
    /// Keeps the speed.
    steady: Lanes<S>,
    /// Gives the driver's acceleration, beside it.
    rise: Lanes<S>,
}

impl<S: Simd, P: Powertrain> State<S, P> {
    /// Forces of a truck at a speed.
    #[inline(always)]
    fn asked(
        &self,
        row: &RoadRowLanes<S>,
        speed: Lanes<S>,
        parameters: &KernelParameters<P>,
    ) -> Asked<S> {
        let (constants, gear) = (&self.constants, &self.gear);
        let pedal = parameters.powertrain.pedal_forces(&self.powertrain, gear, speed);
        let slips = (speed * gear.speed_ratio).simd_lt(gear.slips_below);
        let mass = slips.select(constants.moving_mass_open, constants.moving_mass_closed);
        let road = constants.mass * (row[RoadRow::ROLLING] + row[RoadRow::GRADE]);
        let steady = self.motion.drag + road;
        let rise = mass / (constants.rise_from_rest + constants.rise_per_mps * speed);
        Asked { pedal, mass, steady, rise }
    }

    /// The accelerator that gives the driver's acceleration at a speed: at the end of a step, as
    /// the power that it asks for grows with the speed.
    #[inline(always)]
    pub(super) fn rising_pedal(
        &self,
        row: &RoadRowLanes<S>,
        speed: Lanes<S>,
        parameters: &KernelParameters<P>,
    ) -> Lanes<S> {
        let Asked { pedal, steady, rise, .. } = self.asked(row, speed, parameters);
        pedal.accelerator(steady + rise)
    }

    /// The outputs of this step.
    #[inline(always)]
    pub(super) fn forecast(
        &self,
        row: &RoadRowLanes<S>,
        parameters: &KernelParameters<P>,
    ) -> Forecast<S> {
        let (constants, speed) = (&self.constants, self.motion.speed);
        let Asked { pedal, mass, steady, rise } = self.asked(row, speed, parameters);
        let slower = steady - mass * constants.twice_deceleration * 0.5;
        let wanted = rise * constants.peak_ratio;
        let most = steady + wanted * LIFTS_AT;
        let excess = most - pedal.coasting;
        let free = Lanes::splat(speed.simd, UNBOUNDED);
        let decelerations = if parameters.looks_ahead {
            [(steady - pedal.coasting) / mass, steady * constants.inverse_mass_open]
        } else {
            [steady; 2]
        };
        let [coasting, neutral] = decelerations;
        Forecast {
            coasting,
            neutral,
            holding: pedal.output(steady, constants.per_brake_force),
            ramp: pedal.output(slower, constants.per_brake_force),
            rise: pedal.accelerator(steady + rise),
            peak: pedal.accelerator(steady + wanted),
            most,
            holding_back: excess.simd_lt(0.0).select(excess * constants.per_brake_force, free),
        }
    }
}
