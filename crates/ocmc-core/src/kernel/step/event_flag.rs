//! Flags that a step sets where the gearbox may want another gear, a stop line is near, a check is
//! due or the store is empty; the code outside of the hot loop handles these events.

use super::road_row::{RoadRow, RoadRowLanes};
use super::state::{KernelParameters, State};
use crate::lanes::{Bounded, Flags, Lanes, UNBOUNDED};
use crate::powertrain::Powertrain;
use fearless_simd::prelude::*;

/// An event of one lane: what the step knows that its handling needs.
#[derive(Clone, Copy, Debug)]
pub struct LaneEvent {
    /// Accelerator pedal.
    pub accelerator: f64,
    /// Whether the strategy may want another gear.
    pub wants_shift: bool,
    /// Whether the truck slows.
    pub slowing: bool,
    /// Whether the clutch is closed.
    pub closed: bool,
    /// Whether the driver brakes, or soon will.
    pub brakes: bool,
    /// Steady power that the road asks for, in W.
    pub road_power_w: f64,
}

/// Inputs of the shift strategy for the trucks of a block.
#[derive(Clone, Copy, Debug)]
pub struct ShiftLanes<S: Simd> {
    /// Accelerator pedal.
    pub accelerator: Lanes<S>,
    /// Flag: the truck slows.
    pub slowing: Flags<S>,
    /// Flag: the truck gathers speed.
    pub gathers: Flags<S>,
    /// Flag: the clutch is closed.
    pub closed: Flags<S>,
    /// Flag: the driver brakes, or soon will.
    pub brakes: Flags<S>,
    /// Steady power that the road asks for, in W.
    pub road_power: Lanes<S>,
}

impl<S: Simd, P: Powertrain> State<S, P> {
    /// Whether the strategy may want another gear: the exact answer is
    /// [`crate::powertrain::component::gearbox::ShiftModel::wanted_gear`].
    #[inline(always)]
    pub(super) fn wants_shift(
        &self,
        inputs: &ShiftLanes<S>,
        parameters: &KernelParameters<P>,
    ) -> Flags<S> {
        let ShiftLanes { accelerator, slowing, gathers, closed, brakes, road_power } = *inputs;
        let (motion, shift) = (&self.motion, &parameters.vehicle.shift);
        let speed = self.motion.speed * self.gear.speed_ratio;
        let up_speed = self.motion.speed * self.gear.upshift_ratio(gathers);
        let up_line = accelerator * shift.up_pedal_radps + shift.up_speed_radps;
        let down_line = accelerator * shift.down_pedal_radps + shift.down_speed_radps;
        let (up_left, down_left) = (motion.up_left, motion.down_left);
        let settled = !up_left.at_most(down_left).at_least(motion.shift_left).simd_gt(0.0);
        let rolls = self.motion.speed.simd_gt(shift.minimum_speed_mps);
        let ready = rolls & settled;

        // the most that the engine could give there; how much it does, the strategy asks the curve
        let most = up_speed * parameters.most_power_nm;
        let speeding = motion.speed * self.constants.moving_mass_open * parameters.least_mps2;
        let needed = (road_power * shift.power_reserve).at_least(road_power + speeding);
        let may_up = ready & !up_left.simd_gt(0.0) & !brakes;
        let up = may_up & !up_speed.simd_lt(up_line) & !most.simd_lt(needed);
        let over = self.motion.speed.simd_gt(self.gear.too_fast);
        let has_down = self.gear.speed_ratio_down.simd_lt(UNBOUNDED);
        // a truck that rolls to a stop with an open clutch shifts when it is driven again, not
        // before
        let cannot_launch =
            !(closed | self.gear.slips_below.simd_gt(0.0)) & accelerator.simd_gt(0.0);
        let low = speed.simd_lt(down_line) & (closed | cannot_launch);
        let kick = !self.motion.kick_left.simd_gt(0.0)
            & speed.simd_lt(shift.kickdown_speed_radps)
            & (self.motion.speed * self.gear.speed_ratio_down).simd_lt(shift.overspeed_radps);
        let urgent = speed.simd_lt(parameters.idle_radps);
        let may_down = !down_left.simd_gt(0.0) | urgent;
        let down = has_down & slowing & may_down & (low | kick);
        up | ready & (over | down) | settled & !rolls & cannot_launch
    }

    /// Flag: the lane has an event.
    #[inline(always)]
    pub(super) fn event_flags(
        &self,
        row: &RoadRowLanes<S>,
        wants_shift: Flags<S>,
        parameters: &KernelParameters<P>,
    ) -> Flags<S> {
        let simulation = parameters.simulation;
        let to_line = self.motion.left + row[RoadRow::TO_STOP];
        let reach = self.motion.speed.simd_lt(simulation.creep_speed_mps).select(
            Lanes::splat(to_line.simd, simulation.creep_distance_m),
            Lanes::splat(to_line.simd, simulation.capture_distance_m),
        );
        let captured = !reach.simd_lt(to_line);
        let due = !self.motion.steps_left.simd_gt(0.0);
        captured | due | wants_shift | parameters.powertrain.depleted(&self.powertrain)
    }
}
