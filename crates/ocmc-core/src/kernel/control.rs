//! What the driver wants and does with the pedals: the planned speed under the truck, and the
//! operational module at one stage.

use super::road_row::RoadRow;
use super::stage::{Decision, Row};
use super::state::{KernelParameters, State};
use crate::lanes::{Flags, Lanes, clip, lerp};
use crate::powertrain::Powertrain;
use fearless_simd::prelude::*;

/// What the driver does in one stage.
#[derive(Clone, Copy)]
pub(super) struct Control<S: Simd> {
    pub desired: Lanes<S>,
    /// The controller's output, and with the band of overspeed what the brakes see of it.
    pub output: Lanes<S>,
    pub demand: Lanes<S>,
    pub accelerator: Lanes<S>,
    pub brake: Lanes<S>,
    /// What the brakes realise of the controller's output, without its sign.
    pub braking: Lanes<S>,
    pub integral_rate: Lanes<S>,
}

impl<S: Simd, P: Powertrain> State<S, P> {
    /// The desired speed, in m/s, and the braking branch of its square.
    #[inline(always)]
    pub(super) fn desired(
        &self,
        row: &Row<S>,
        left: Lanes<S>,
        parameters: &KernelParameters<P>,
    ) -> (Lanes<S>, Lanes<S>) {
        let limit = row[RoadRow::LIMIT];
        let backward = row[RoadRow::BACKWARD] + self.constants.twice_deceleration * left;
        let forward = (row[RoadRow::FORWARD] - self.constants.twice_acceleration * left)
            .max(parameters.launch);
        (limit.min(backward).min(forward).sqrt(), backward)
    }

    /// The same where a step ends. Where it passes the beginning of a ramp down to a lower limit,
    /// the line from start to end would lie below the desired speed everywhere between: the second
    /// stage takes the end of the line that has its mean.
    #[inline(always)]
    pub(super) fn desired_at_end(
        &self,
        decision: &Decision<S>,
        left: Lanes<S>,
        parameters: &KernelParameters<P>,
    ) -> (Lanes<S>, Lanes<S>) {
        let (row, before) = (&decision.row, decision.control.desired);
        let limit = row[RoadRow::LIMIT];
        let backward_before = decision.backward;
        let (desired, backward) = self.desired(row, left, parameters);
        let begins = limit.simd_lt(backward_before) & backward.simd_lt(limit);
        // share of the step before the ramp
        let share = (backward_before - limit) / (backward_before - backward);
        (begins.select(lerp(share, desired, before), desired), backward)
    }

    /// The operational module at one stage.
    #[inline(always)]
    pub(super) fn control(
        &self,
        limit: Lanes<S>,
        speed: Lanes<S>,
        (desired, backward): (Lanes<S>, Lanes<S>),
        integral: Lanes<S>,
        filtered: Lanes<S>,
        hold: Flags<S>,
        held: Lanes<S>,
        parameters: &KernelParameters<P>,
    ) -> Control<S> {
        let pedals = parameters.pedals;
        let error = desired - speed;
        let lag = speed - filtered;
        let effort = self.constants.proportional * error;
        let continuous = effort + integral - self.constants.derivative_over_filter * lag;
        let output = hold.select(held, continuous);

        // speed limiter: above its speed the pedal goes down less and less far
        let vehicle = &parameters.vehicle.model;
        let end_mps = vehicle.limiter_speed_mps + vehicle.limiter_range_mps;
        let allowed = (end_mps - speed) * parameters.per_limiter_range;
        let accelerator = clip(output.min(allowed), 0.0, 1.0);

        // overspeed band: above a static limit the driver lets the truck run up to its edge
        let edge = effort + self.constants.band_output;
        let in_band = speed.simd_gt(pedals.overspeed_from_mps) & !backward.simd_lt(limit);
        let demand = in_band.select(output.max(edge), output);
        let braking = clip(-demand, 0.0, parameters.per_brake_scale);
        let realised = accelerator - braking;
        Control {
            desired,
            output,
            demand,
            accelerator,
            brake: (braking * pedals.brake_scale).min(1.0),
            braking,
            integral_rate: self.constants.integral_gain * error
                + self.constants.tracking * (realised - output),
        }
    }
}

/// The integral part within its bounds (integral clamp). Zero is within, and stays there for a
/// driver without an integral part.
#[inline(always)]
pub(super) fn clamp_integral<S: Simd, P: Powertrain>(
    integral: Lanes<S>,
    parameters: &KernelParameters<P>,
) -> Lanes<S> {
    let pid = &parameters.pedals.pid;
    clip(integral, pid.integral_minimum, pid.integral_maximum)
}
