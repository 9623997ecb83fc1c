//! The trace: the time series of one cycle, from the same step function. What only the motion is
//! asked of is driven eight side by side.
//!
//! Each row is one step, or one standstill or gear jump that took no step. The `*_added` columns
//! are what the record's totals gained in that row: summed in order they give the record to the
//! bit.

use super::chain::chained_scenario;
use super::observer::Observer;
use super::scheduler::drive_observed;
use super::trace_writer::{LaneWriters, Writer};
use crate::kernel::trip::lane_task::LaneTask;
use crate::lanes::WIDTH;
use crate::operating_cycle::road::Road;
use crate::powertrain::{Powertrain, PowertrainTask};
use crate::record::Record;
use crate::study::{Scenario, Study};
use crate::threads::deep;

pub use super::trace_writer::TableColumn;

/// The time series of one cycle, and its record.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Columns of equal length.
    pub columns: Vec<TableColumn>,
    /// The record, the same as in a run.
    pub record: Record,
}

/// Places of two columns.
const POSITION: usize = 2;
const SPEED: usize = 3;
/// Places of what a motion has: time, step, position, speed and the rate of fuel or energy.
const MOTION: [usize; 5] = [0, 1, POSITION, SPEED, 11];

/// Drives one cycle and writes down every step.
pub fn trace(study: &Study, seed: u64, cycle_id: u64) -> Trace {
    let mut trace = if study.chains() {
        trace_scenario(study, chained_scenario(study, seed, cycle_id))
    } else {
        trace_scenario(study, study.sample(seed, cycle_id))
    };
    trace.record.clock_at_end = None;
    trace
}

/// Drives one given scenario and writes down every step.
pub fn trace_scenario(study: &Study, scenario: Scenario) -> Trace {
    let mut traces = block(study, vec![scenario], |_| true);
    traces.pop().expect("one cycle gives one trace")
}

/// Drives given scenarios, side by side, and writes down the motion of each: time, step, position,
/// speed and the rate of fuel or energy, and what a log would tell of the road. The traces are in
/// the order of the scenarios, whose cycle ids have to increase, and none depends on the others.
pub fn motions(study: &Study, scenarios: impl IntoIterator<Item = Scenario>) -> Vec<Trace> {
    let (mut scenarios, mut traces) = (scenarios.into_iter().peekable(), Vec::new());
    while scenarios.peek().is_some() {
        let side_by_side = scenarios.by_ref().take(WIDTH).collect();
        traces.append(&mut block(study, side_by_side, |place| MOTION.contains(&place)));
    }
    traces
}

/// Drives as many scenarios as there are lanes, or fewer, and writes the columns at such places.
fn block(study: &Study, scenarios: Vec<Scenario>, writes: fn(usize) -> bool) -> Vec<Trace> {
    deep(|| study.vehicle().powertrain.dispatch(TraceTask { study, scenarios, writes }))
}

struct TraceTask<'a> {
    study: &'a Study,
    /// No more than lanes; each has the lane of its place.
    scenarios: Vec<Scenario>,
    writes: fn(usize) -> bool,
}

impl PowertrainTask for TraceTask<'_> {
    type Answer = Vec<Trace>;

    fn run<P: Powertrain>(self, powertrain: &P) -> Vec<Trace> {
        let study = self.study;
        let mut lanes = LaneWriters(std::array::from_fn(|_| Writer::new(self.writes)));
        let scenarios = self.scenarios.into_iter();
        let known = scenarios.clone().map(|scenario| (scenario.cycle_id, scenario.cycle.road));
        let known: Vec<(u64, Road)> = known.collect();
        let mut tasks = scenarios.map(|scenario| LaneTask::new(study, scenario));
        let observer = Observer::Trace(&mut lanes);
        let records = drive_observed(study, powertrain, &mut |_| tasks.next(), observer);
        let ids = records.iter().map(|record| record.cycle_id);
        assert!(ids.eq(known.iter().map(|(id, _)| *id)), "each cycle gives one record, in order");
        let driven = lanes.0.into_iter().zip(known).zip(records);
        let trace = |((writer, (_, road)), record): ((Writer, (u64, Road)), Record)| {
            let mut columns = writer.columns;
            let way = [POSITION, SPEED].map(|place| columns[place].values.as_slice());
            let seen = road_signals(study, &road, way);
            columns.extend(seen);
            Trace { columns, record }
        };
        driven.map(trace).collect()
    }
}

/// Signals of the road in a log of this drive: yaw rate and speed limit at each row's end.
fn road_signals(
    study: &Study,
    road: &Road,
    [position_m, speed_mps]: [&[f64]; 2],
) -> [TableColumn; 2] {
    let types = study.operating_cycle().road();
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
        let legal_mps = types.legal_mps(road.sections[section].road_type);
        limit.push(road.signs[sign].speed_mps.min(legal_mps));
    }
    [
        TableColumn { name: "yaw_rate_radps", values: yaw_rate },
        TableColumn { name: "limit_mps", values: limit },
    ]
}
