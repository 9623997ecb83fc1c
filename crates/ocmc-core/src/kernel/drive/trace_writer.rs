//! The rows of a trace, lane by lane.

use crate::energy::ledger::{Ledger, Mode, TERMS};
use crate::kernel::step::state::{KernelParameters, State};
use crate::kernel::step::step_view::StepView;
use crate::kernel::trip::lane_task::LaneTask;
use crate::lanes::WIDTH;
use crate::powertrain::Powertrain;
use fearless_simd::prelude::*;

/// One column of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct TableColumn {
    /// Name, with its unit as a suffix.
    pub name: &'static str,
    /// Values, one a row.
    pub values: Vec<f64>,
}

/// Collects the rows of each lane.
pub(super) struct LaneWriters(pub(super) [Writer; WIDTH]);

/// Collects rows.
pub(super) struct Writer {
    /// Columns that are written, by their places.
    writes: fn(usize) -> bool,
    pub(super) columns: Vec<TableColumn>,
    time_s: f64,
    position_m: f64,
    standstill_s: f64,
    /// Additions of the step before that were taken back.
    kept: Option<Ledger<f64>>,
}

/// Point of a trace: pedals, which are at rest at a standstill, and the engine.
struct TracePoint {
    step_s: f64,
    desired_mps: f64,
    acceleration_mps2: f64,
    accelerator: f64,
    brake: f64,
    engine_speed: f64,
    torque: f64,
    source_rate: f64,
    closed: bool,
}

impl Writer {
    pub(super) fn new(writes: fn(usize) -> bool) -> Self {
        Self {
            writes,
            columns: Vec::new(),
            time_s: 0.0,
            position_m: 0.0,
            standstill_s: 0.0,
            kept: None,
        }
    }

    fn push<S: Simd, P: Powertrain>(
        &mut self,
        parameters: &KernelParameters<P>,
        state: &State<S, P>,
        (number, task): (usize, &LaneTask),
        point: &TracePoint,
        added: &Ledger<f64>,
    ) {
        self.time_s += point.step_s;
        let own = parameters.powertrain.state_signal(&state.powertrain, number, point.closed);
        let signals = [
            ("time_s", self.time_s),
            ("step_s", point.step_s),
            ("position_m", self.position_m),
            ("speed_mps", state.motion.speed[number]),
            ("desired_speed_mps", point.desired_mps),
            ("acceleration_mps2", point.acceleration_mps2),
            ("accelerator", point.accelerator),
            ("brake", point.brake),
            ("gear", task.progress.gear as f64 + 1.0),
            (P::SIGNALS.speed, point.engine_speed),
            (P::SIGNALS.torque, point.torque),
            (P::SIGNALS.source_rate, point.source_rate),
            ("grade", state.slope(number)),
            (P::SIGNALS.state, own),
        ];
        let terms = TERMS.iter().filter(|declared| declared.term.is_in(Mode::Driven, P::TERMS));
        let terms = terms.map(|declared| (declared.trace, added[declared.term]));
        let written = signals.into_iter().chain(terms).enumerate();
        let written = written.filter(|(place, _)| (self.writes)(*place));
        for (k, (_, (name, value))) in written.enumerate() {
            match self.columns.get_mut(k) {
                Some(column) => column.values.push(value),
                None => self.columns.push(TableColumn { name, values: vec![value] }),
            }
        }
    }

    fn after_step<S: Simd, P: Powertrain>(
        &mut self,
        parameters: &KernelParameters<P>,
        state: &State<S, P>,
        view: &StepView<S>,
        (number, task): (usize, &LaneTask),
    ) {
        let mut added = view.added.lane(number);
        // of a step that was taken back nothing is left but the jump of the engine's speed: the
        // next row has it
        added.add(&self.kept.take().unwrap_or(Ledger::EMPTY));
        if view.dt[number] == 0.0 {
            self.kept = Some(added);
            return;
        }
        self.position_m += view.dx[number];
        let point = TracePoint {
            step_s: view.dt[number],
            desired_mps: view.desired[number],
            acceleration_mps2: view.acceleration[number],
            accelerator: view.accelerator[number],
            brake: view.brake[number],
            engine_speed: view.engine_speed[number],
            torque: view.engine_torque[number],
            source_rate: view.source_rate[number],
            closed: view.closed.test(number),
        };
        self.push(parameters, state, (number, task), &point, &added);
    }

    fn after_event<S: Simd, P: Powertrain>(
        &mut self,
        parameters: &KernelParameters<P>,
        state: &State<S, P>,
        (number, task): (usize, &LaneTask),
    ) {
        let added = &task.added_by_event;
        let waited_s = task.progress.standstill_s - self.standstill_s;
        if *added == Ledger::EMPTY && waited_s == 0.0 {
            return;
        }
        self.standstill_s = task.progress.standstill_s;
        let engine_speed = state.motion.engine_speed[number];
        let [torque, source_rate] =
            parameters.powertrain.standing_signals(added, waited_s, engine_speed);
        let point = TracePoint {
            step_s: waited_s,
            desired_mps: 0.0,
            acceleration_mps2: 0.0,
            accelerator: 0.0,
            brake: 1.0,
            engine_speed,
            torque,
            source_rate,
            closed: false,
        };
        self.push(parameters, state, (number, task), &point, added);
    }
}

impl LaneWriters {
    /// Writes the rows of a step.
    pub(super) fn after_step<S: Simd, P: Powertrain>(
        &mut self,
        parameters: &KernelParameters<P>,
        state: &State<S, P>,
        view: &StepView<S>,
        tasks: &[Option<LaneTask>],
    ) {
        for (number, (writer, task)) in self.0.iter_mut().zip(tasks).enumerate() {
            if let Some(task) = task {
                writer.after_step(parameters, state, view, (number, task));
            }
        }
    }

    /// Writes the row of an event, where it has taken time or energy.
    pub(super) fn after_event<S: Simd, P: Powertrain>(
        &mut self,
        parameters: &KernelParameters<P>,
        state: &State<S, P>,
        (number, task): (usize, &LaneTask),
    ) {
        self.0[number].after_event(parameters, state, (number, task));
    }
}
