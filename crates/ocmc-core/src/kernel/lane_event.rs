//! Which lanes have an event after a step: the gearbox may want another gear, a stop line is near, a check is due.

use super::powertrain::Powertrain;
use super::road_row::{RoadRow, UNBOUNDED};
use super::stage::Row;
use super::state::{KernelParameters, State};
use crate::lanes::{Flags, Lanes};
use fearless_simd::prelude::*;

impl<S: Simd> State<S> {
    /// Whether the strategy may want another gear: the exact answer is
    /// [`crate::powertrain::gearbox::ShiftModel::wanted_gear`].
    #[inline(always)]
    pub(super) fn wants_shift<T: Powertrain>(
        &self,
        accelerator: Lanes<S>,
        slowing: Flags<S>,
        closed: Flags<S>,
        road_power: Lanes<S>,
        parameters: &KernelParameters<T>,
    ) -> Flags<S> {
        let shift = &parameters.vehicle.shift;
        let speed = self.speed * self.gear_speed;
        let up_speed = self.speed * self.gear_speed_up;
        let up_line = accelerator * shift.up_pedal_radps + shift.up_speed_radps;
        let down_line = accelerator * shift.down_pedal_radps + shift.down_speed_radps;
        let settled = !self.hold_left.max(self.shift_left).simd_gt(0.0);
        let rolls = self.speed.simd_gt(shift.minimum_speed_mps);
        let ready = rolls & settled;

        // the most that the engine could give there; how much it does, the strategy asks the curve
        let most = up_speed * parameters.most_power_nm;
        let strong = !most.simd_lt(road_power);
        let up = ready & !up_speed.simd_lt(up_line) & strong;
        let over = self.speed.simd_gt(self.too_fast);
        let has_down = self.gear_speed_down.simd_lt(UNBOUNDED);
        // a truck that rolls to a stop with an open clutch shifts when it is driven again, not before
        let cannot_launch = !(closed | self.slips_below.simd_gt(0.0)) & accelerator.simd_gt(0.0);
        let low = speed.simd_lt(down_line) & (closed | cannot_launch);
        let kick = !self.kick_left.simd_gt(0.0)
            & speed.simd_lt(shift.kickdown_speed_radps)
            & (self.speed * self.gear_speed_down).simd_lt(shift.overspeed_radps);
        let down = has_down & slowing & (low | kick);
        up | ready & (over | down) | settled & !rolls & cannot_launch
    }

    /// Flag: the lane has an event.
    #[inline(always)]
    pub(super) fn event_flags<T: Powertrain>(
        &self,
        row: &Row<S>,
        wants_shift: Flags<S>,
        parameters: &KernelParameters<T>,
    ) -> Flags<S> {
        let simulation = parameters.simulation;
        let to_line = self.left + row[RoadRow::TO_STOP];
        let reach = self.speed.simd_lt(simulation.creep_speed_mps).select(
            Lanes::splat(to_line.simd, simulation.creep_distance_m),
            Lanes::splat(to_line.simd, simulation.capture_distance_m),
        );
        let captured = !reach.simd_lt(to_line);
        let due = !self.steps_left.simd_gt(0.0);
        captured | due | wants_shift | parameters.powertrain.is_empty(self)
    }
}
