//! The trace: the time series of one cycle, from the same step function with one lane.
//!
//! Each row is one step, or one standstill or gear jump that took no step. The `*_added` columns are what the record's
//! totals gained in that row: summed in order they give the record to the bit.

use super::lane_task::{LaneTask, slope};
use super::record::Record;
use super::scheduler::{Observer, drive_observed};
use super::state::{State, Total};
use super::step_view::StepView;
use crate::operating_cycle::road::Road;
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

/// Names of the columns that come before the totals.
const SIGNALS: [&str; 14] = [
    "time_s",
    "step_s",
    "position_m",
    "speed_mps",
    "desired_speed_mps",
    "acceleration_mps2",
    "accelerator",
    "brake",
    "gear",
    "engine_speed_radps",
    "engine_torque_nm",
    "fuel_rate_kgps",
    "grade",
    "clutch_closed",
];

/// The last of them with a motor and a battery.
const ELECTRIC_SIGNALS: [&str; 5] =
    ["motor_speed_radps", "motor_torque_nm", "battery_power_w", "grade", "state_of_charge"];

/// Which powertrain has a total.
#[derive(Clone, Copy, PartialEq)]
enum Has {
    Both,
    Diesel,
    Electric,
}

/// Names of the columns of the totals, by [`Total`].
const ADDED: [(&str, Has); Total::COUNT] = [
    ("simulated_added_s", Has::Both),
    ("distance_added_m", Has::Both),
    ("fuel_added_kg", Has::Diesel),
    ("crankshaft_work_added_j", Has::Diesel),
    ("auxiliary_energy_added_j", Has::Both),
    ("clutch_loss_added_j", Has::Diesel),
    ("transmission_loss_added_j", Has::Both),
    ("shift_loss_added_j", Has::Both),
    ("drag_energy_added_j", Has::Both),
    ("rolling_energy_added_j", Has::Both),
    ("potential_added_j", Has::Both),
    ("service_brake_energy_added_j", Has::Both),
    ("engine_brake_energy_added_j", Has::Diesel),
    ("wheel_energy_added_j", Has::Both),
    ("battery_energy_added_j", Has::Electric),
    ("battery_loss_added_j", Has::Electric),
    ("motor_loss_added_j", Has::Electric),
    ("regenerated_energy_added_j", Has::Electric),
    ("charged_energy_added_j", Has::Electric),
    ("charging_loss_added_j", Has::Electric),
    ("outside_map_added_s", Has::Both),
];

/// The columns of a powertrain: name and place among the written ones.
fn columns_of(electric: bool) -> impl Iterator<Item = (&'static str, usize)> {
    let mut signals = SIGNALS;
    if electric {
        signals[SIGNALS.len() - ELECTRIC_SIGNALS.len()..].copy_from_slice(&ELECTRIC_SIGNALS);
    }
    let absent = if electric { Has::Diesel } else { Has::Electric };
    let totals = ADDED.into_iter().map(move |(name, has)| (name, has != absent));
    let all = signals.into_iter().map(|name| (name, true)).chain(totals);
    all.enumerate().filter(|(_, (_, there))| *there).map(|(place, (name, _))| (name, place))
}

/// Drives one cycle and writes down every step.
pub fn trace(study: &Study, seed: u64, cycle_id: u64) -> Trace {
    trace_scenario(study, study.sample(seed, cycle_id))
}

/// Drives one given scenario and writes down every step.
pub fn trace_scenario(study: &Study, scenario: Scenario) -> Trace {
    let electric = study.vehicle().diesel().is_none();
    let mut writer = Writer::new(electric);
    let road = scenario.cycle.road.clone();
    let mut task = Some(LaneTask::new(study, scenario));
    let mut records = drive_observed(study, &mut |_| task.take(), &mut writer);
    let column = |(name, place): (_, usize)| TableColumn {
        name,
        values: std::mem::take(&mut writer.columns[place]),
    };
    let mut columns: Vec<TableColumn> = columns_of(electric).map(column).collect();
    let seen = road_signals(study, &road, &columns[POSITION].values, &columns[SPEED].values);
    columns.extend(seen);
    let record = records.pop().expect("one cycle gives one record");
    Trace { columns, record }
}

/// Places of two of the [`SIGNALS`].
const POSITION: usize = 2;
const SPEED: usize = 3;

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
    kept: [f64; Total::COUNT],
    /// Whether there is a battery instead of an engine.
    electric: bool,
}

impl Writer {
    fn new(electric: bool) -> Self {
        Self {
            columns: vec![Vec::new(); SIGNALS.len() + Total::COUNT],
            time_s: 0.0,
            position_m: 0.0,
            standstill_s: 0.0,
            kept: [0.0; Total::COUNT],
            electric,
        }
    }

    /// State of charge, or whether the clutch is closed.
    fn last_signal<S: Simd>(&self, state: &State<S>, closed: bool) -> f64 {
        if self.electric { state.charge[0] } else { f64::from(u8::from(closed)) }
    }

    fn push(&mut self, signals: [f64; SIGNALS.len()], added: [f64; Total::COUNT]) {
        for (column, value) in self.columns.iter_mut().zip(signals.into_iter().chain(added)) {
            column.push(value);
        }
    }
}

impl Observer for Writer {
    fn after_step<S: Simd>(
        &mut self,
        state: &State<S>,
        view: &StepView<S>,
        tasks: &[Option<LaneTask>],
    ) {
        let Some(task) = &tasks[0] else { return };
        let mut added = view.added.map(|lanes| lanes[0]);
        // of a step that was taken back nothing is left but the jump of the engine's speed: the next row has it
        for (amount, kept) in added.iter_mut().zip(&mut self.kept) {
            *amount += std::mem::take(kept);
        }
        if view.dt[0] == 0.0 {
            self.kept = added;
            return;
        }
        self.time_s += view.dt[0];
        self.position_m += view.dx[0];
        self.push(
            [
                self.time_s,
                view.dt[0],
                self.position_m,
                state.speed[0],
                view.desired[0],
                view.acceleration[0],
                view.accelerator[0],
                view.brake[0],
                task.gear() as f64 + 1.0,
                view.engine_speed[0],
                view.engine_torque[0],
                view.store_rate[0],
                view.grade[0] / GRAVITY_MPS2,
                self.last_signal(state, view.closed.test(0)),
            ],
            added,
        );
    }

    fn after_event<S: Simd>(&mut self, state: &State<S>, _lane: usize, tasks: &[Option<LaneTask>]) {
        let Some(task) = &tasks[0] else { return };
        let added = *task.added_by_event();
        let waited_s = task.standstill_s() - self.standstill_s;
        if added == [0.0; Total::COUNT] && waited_s == 0.0 {
            return;
        }
        self.standstill_s = task.standstill_s();
        self.time_s += waited_s;
        let engine_speed = state.engine_speed[0];
        let per_second = |total: Total| {
            if waited_s > 0.0 { added[total as usize] / waited_s } else { 0.0 }
        };
        let (torque, rate) = if self.electric {
            (0.0, per_second(Total::Auxiliary))
        } else {
            (per_second(Total::Crankshaft) / engine_speed, per_second(Total::Fuel))
        };
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
                rate,
                slope(state, 0),
                self.last_signal(state, false),
            ],
            added,
        );
    }
}
