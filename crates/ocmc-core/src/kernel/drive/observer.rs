//! Observers of the lanes: a fleet has none, a trace writes each step down, events of a drive are
//! noted and end in time.

use super::rolling_truck::RollingTrucks;
use super::trace_writer::LaneWriters;
use crate::kernel::step::state::{KernelParameters, Lane, State};
use crate::kernel::step::step_view::StepView;
use crate::kernel::trip::lane_task::LaneTask;
use crate::powertrain::Powertrain;
use fearless_simd::prelude::*;

/// Observer of every step of every lane. The loop is compiled once for all of them.
pub(super) enum Observer<'a> {
    /// None: a fleet is not observed.
    Nobody,
    /// Writes traces.
    Trace(&'a mut LaneWriters),
    /// Notes events of a drive.
    Events(&'a mut RollingTrucks),
}

impl Observer<'_> {
    /// Whether it is none.
    #[inline(always)]
    pub(super) fn is_nobody(&self) -> bool {
        matches!(self, Self::Nobody)
    }

    /// A truck has entered a lane; the block's lanes are counted from the first one.
    pub(super) fn entered<S: Simd, P: Powertrain>(
        &mut self,
        first: usize,
        task: &mut LaneTask,
        lane: &mut Lane<S, P>,
    ) {
        if let Self::Events(trucks) = self {
            trucks.entered(first, task, lane);
        }
    }

    /// After a step, before its events are handled. Returns the lanes whose time is over, as bits.
    pub(super) fn after_step<S: Simd, P: Powertrain>(
        &mut self,
        parameters: &KernelParameters<P>,
        state: &State<S, P>,
        view: &StepView<S>,
        (first, tasks): (usize, &[Option<LaneTask>]),
    ) -> u64 {
        match self {
            Self::Nobody => 0,
            Self::Trace(writers) => {
                writers.after_step(parameters, state, view, tasks);
                0
            }
            Self::Events(trucks) => trucks.after_step(state, view, (first, tasks)),
        }
    }

    /// After the event of a lane, that of this task, has been handled.
    pub(super) fn after_event<S: Simd, P: Powertrain>(
        &mut self,
        parameters: &KernelParameters<P>,
        state: &State<S, P>,
        task: (usize, &LaneTask),
    ) {
        if let Self::Trace(writers) = self {
            writers.after_event(parameters, state, task);
        }
    }

    /// Before the next step of a block, whose events have been handled.
    pub(super) fn before_step<S: Simd, P: Powertrain>(
        &mut self,
        parameters: &KernelParameters<P>,
        state: &mut State<S, P>,
        (first, tasks): (usize, &[Option<LaneTask>]),
    ) {
        if let Self::Events(trucks) = self {
            trucks.before_step(parameters, state, (first, tasks));
        }
    }
}
