//! The trace: the time series of one cycle, from the same step function with one lane.
//!
//! Each row is one step, or one standstill or gear jump that took no step. The `*_added` columns
//! are what the record's totals gained in that row: summed in order they give the record to the
//! bit.

use super::lane_task::{LaneTask, slope};
use super::scheduler::{Observer, drive_observed};
use super::state::{KernelParameters, State};
use super::step_view::StepView;
use crate::energy_ledger::{Ledger, Mode, TERMS, Term};
use crate::operating_cycle::road::Road;
use crate::powertrain::{Powertrain, PowertrainTask, SignalNames};
use crate::record::Record;
use crate::study::{Scenario, Study};
use crate::vehicle::resistance::GRAVITY_MPS2;
use fearless_simd::prelude::*;

/// One column of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct TableColumn {
    /// Name, with its unit as a suffix.
    pub name: &'static str,
    /// Values, one a row.
    pub values: Vec<f64>,
}

/// The time series of one cycle, and its record.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Columns of equal length.
    pub columns: Vec<TableColumn>,
    /// The record, the same as in a run.
    pub record: Record,
}

/// Number of columns that come before those of the ledger.
const SIGNALS: usize = 14;
/// Places of two of them.
const POSITION: usize = 2;
const SPEED: usize = 3;

/// Their names; those of the powertrain are its own.
fn signal_names(powertrain: SignalNames) -> [&'static str; SIGNALS] {
    [
        "time_s",
        "step_s",
        "position_m",
        "speed_mps",
        "desired_speed_mps",
        "acceleration_mps2",
        "accelerator",
        "brake",
        "gear",
        powertrain.speed,
        powertrain.torque,
        powertrain.source_rate,
        "grade",
        powertrain.state,
    ]
}

/// Drives one cycle and writes down every step.
pub fn trace(study: &Study, seed: u64, cycle_id: u64) -> Trace {
    trace_scenario(study, study.sample(seed, cycle_id))
}

/// Drives one given scenario and writes down every step.
pub fn trace_scenario(study: &Study, scenario: Scenario) -> Trace {
    study.vehicle().powertrain.dispatch(TraceTask { study, scenario })
}

struct TraceTask<'a> {
    study: &'a Study,
    scenario: Scenario,
}

impl PowertrainTask for TraceTask<'_> {
    type Answer = Trace;

    fn run<P: Powertrain>(self, powertrain: &P) -> Trace {
        let study = self.study;
        let mut writer = Writer::default();
        let road = self.scenario.cycle.road.clone();
        let mut task = Some(LaneTask::new(study, self.scenario));
        let mut records = drive_observed(study, powertrain, &mut |_| task.take(), &mut writer);
        let is_there = |term: Term| term.is_in(Mode::Driven, P::TERMS);
        let terms = TERMS.iter().map(|declared| (declared.trace, is_there(declared.term)));
        let signals = signal_names(P::SIGNALS).into_iter().map(|name| (name, true));
        let columns = signals.chain(terms).zip(writer.columns);
        let there = columns.filter(|((_, is_there), _)| *is_there);
        let mut columns: Vec<TableColumn> =
            there.map(|((name, _), values)| TableColumn { name, values }).collect();
        let seen = road_signals(study, &road, &columns[POSITION].values, &columns[SPEED].values);
        columns.extend(seen);
        let record = records.pop().expect("one cycle gives one record");
        Trace { columns, record }
    }
}

/// What a log of this drive would tell of the road: yaw rate and speed limit at each row's end.
fn road_signals(
    study: &Study,
    road: &Road,
    position_m: &[f64],
    speed_mps: &[f64],
) -> [TableColumn; 2] {
    let types = study.operating_cycle().road().types();
    let (mut curve, mut sign, mut section) = (0, 0, 0);
    let mut yaw_rate = Vec::with_capacity(position_m.len());
    let mut limit = Vec::with_capacity(position_m.len());
    for (at, speed) in position_m.iter().zip(speed_mps) {
        while road.curves.get(curve).is_some_and(|c| c.end_m <= *at) {
            curve += 1;
        }
        while road.signs.get(sign + 1).is_some_and(|next| next.start_m <= *at) {
            sign += 1;
        }
        while road.sections.get(section + 1).is_some_and(|next| next.start_m <= *at) {
            section += 1;
        }
        let here = road.curves.get(curve).filter(|c| c.start_m <= *at);
        yaw_rate.push(here.map_or(0.0, |c| c.curvature_per_m() * speed));
        let legal = types[road.sections[section].road_type].truck_limit_mps;
        limit.push(road.signs[sign].speed_mps.min(legal.unwrap_or(f64::INFINITY)));
    }
    [
        TableColumn { name: "yaw_rate_radps", values: yaw_rate },
        TableColumn { name: "limit_mps", values: limit },
    ]
}

/// Collects rows.
struct Writer {
    columns: Vec<Vec<f64>>,
    time_s: f64,
    position_m: f64,
    standstill_s: f64,
    /// What a step that was taken back added.
    kept: Ledger<f64>,
}

impl Default for Writer {
    fn default() -> Self {
        Self {
            columns: vec![Vec::new(); SIGNALS + Term::COUNT],
            time_s: 0.0,
            position_m: 0.0,
            standstill_s: 0.0,
            kept: Ledger::EMPTY,
        }
    }
}

impl Writer {
    fn push(&mut self, signals: [f64; SIGNALS], added: &Ledger<f64>) {
        for (column, value) in self.columns.iter_mut().zip(signals.into_iter().chain(added.sums()))
        {
            column.push(value);
        }
    }
}

impl Observer for Writer {
    fn after_step<S: Simd, P: Powertrain>(
        &mut self,
        parameters: &KernelParameters<P>,
        state: &State<S, P>,
        view: &StepView<S>,
        tasks: &[Option<LaneTask>],
    ) {
        let Some(task) = &tasks[0] else { return };
        let mut added = view.added.lane(0);
        // of a step that was taken back nothing is left but the jump of the engine's speed: the
        // next row has it
        added.add(&std::mem::replace(&mut self.kept, Ledger::EMPTY));
        if view.dt[0] == 0.0 {
            self.kept = added;
            return;
        }
        self.time_s += view.dt[0];
        self.position_m += view.dx[0];
        let closed = view.closed.test(0);
        self.push(
            [
                self.time_s,
                view.dt[0],
                self.position_m,
                state.motion.speed[0],
                view.desired[0],
                view.acceleration[0],
                view.accelerator[0],
                view.brake[0],
                task.gear() as f64 + 1.0,
                view.engine_speed[0],
                view.engine_torque[0],
                view.source_rate[0],
                view.grade[0] / GRAVITY_MPS2,
                parameters.powertrain.state_signal(&state.powertrain, 0, closed),
            ],
            &added,
        );
    }

    fn after_event<S: Simd, P: Powertrain>(
        &mut self,
        parameters: &KernelParameters<P>,
        state: &State<S, P>,
        tasks: &[Option<LaneTask>],
    ) {
        let Some(task) = &tasks[0] else { return };
        let added = *task.added_by_event();
        let waited_s = task.standstill_s() - self.standstill_s;
        if added == Ledger::EMPTY && waited_s == 0.0 {
            return;
        }
        self.standstill_s = task.standstill_s();
        self.time_s += waited_s;
        let engine_speed = state.motion.engine_speed[0];
        let powertrain = parameters.powertrain;
        let [torque, source_rate] = powertrain.standing_signals(&added, waited_s, engine_speed);
        self.push(
            [
                self.time_s,
                waited_s,
                self.position_m,
                0.0,
                0.0,
                0.0,
                0.0,
                1.0,
                task.gear() as f64 + 1.0,
                engine_speed,
                torque,
                source_rate,
                slope(state, 0),
                powertrain.state_signal(&state.powertrain, 0, false),
            ],
            &added,
        );
    }
}
