//! View of a step: everything to a trace, the events of single lanes to the code outside of the hot
//! loop.

use super::event_flag::{LaneEvent, ShiftLanes};
use crate::energy::ledger::Ledger;
use crate::lanes::{Flags, Lanes, WIDTH};
use fearless_simd::prelude::*;

/// Course of one step, for a trace. Means are over the step.
#[derive(Clone, Copy, Debug)]
pub struct StepView<S: Simd> {
    /// Length of the step, in s.
    pub dt: Lanes<S>,
    /// Distance, in m.
    pub dx: Lanes<S>,
    /// Desired speed at the start, in m/s.
    pub desired: Lanes<S>,
    /// Accelerator pedal at the end.
    pub accelerator: Lanes<S>,
    /// Brake pedal at the end.
    pub brake: Lanes<S>,
    /// Mean engine speed, in rad/s.
    pub engine_speed: Lanes<S>,
    /// Mean engine torque, in Nm.
    pub engine_torque: Lanes<S>,
    /// Rate of the source: fuel in kg/s, or power at the battery's terminals in W.
    pub source_rate: Lanes<S>,
    /// Mean acceleration, in m/s².
    pub acceleration: Lanes<S>,
    /// Flag: the clutch is closed.
    pub closed: Flags<S>,
    /// Additions to the ledger.
    pub added: Ledger<Lanes<S>>,
    /// Flag: the lane has an event: stop, shift, check of progress.
    pub event: Flags<S>,
    /// Flag: the strategy wants another gear.
    pub wants_shift: Flags<S>,
    /// Inputs of the shift strategy.
    pub shift: ShiftLanes<S>,
}

/// The events of a step, lane by lane, for the code outside of the hot loop. Flags are bits.
#[derive(Clone, Copy, Debug)]
pub struct LaneEvents {
    /// The lanes that have an event.
    pub lanes: u64,
    wants_shift: u64,
    slowing: u64,
    closed: u64,
    brakes: u64,
    accelerator: [f64; WIDTH],
    road_power_w: [f64; WIDTH],
}

impl LaneEvents {
    /// The event of one lane.
    pub fn lane(&self, lane: usize) -> LaneEvent {
        let is_set = |flags: u64| flags >> lane & 1 != 0;
        LaneEvent {
            accelerator: self.accelerator[lane],
            wants_shift: is_set(self.wants_shift),
            slowing: is_set(self.slowing),
            closed: is_set(self.closed),
            brakes: is_set(self.brakes),
            road_power_w: self.road_power_w[lane],
        }
    }
}

impl<S: Simd> StepView<S> {
    /// The events of the lanes.
    #[inline(always)]
    pub fn events(&self) -> LaneEvents {
        LaneEvents {
            lanes: self.event.to_bitmask(),
            wants_shift: self.wants_shift.to_bitmask(),
            slowing: self.shift.slowing.to_bitmask(),
            closed: self.shift.closed.to_bitmask(),
            brakes: self.shift.brakes.to_bitmask(),
            accelerator: self.shift.accelerator.into(),
            road_power_w: self.shift.road_power.into(),
        }
    }
}
