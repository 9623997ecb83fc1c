//! The closed loop of an event: the study's truck on the log's slopes, a driver with given gains who wants one speed.
//!
//! The truck starts as the log says: speed, gear, and an engine that has followed the pedal. What the controller knows at
//! the start is not in a log: the filtered speed follows from the measured acceleration, the integral part is estimated with
//! the gains. The air is still, dry and at 15 °C, the road smooth asphalt, the truck the typical one with the mean payload.

use super::event::PedalLog;
use crate::driver::Driver;
use crate::driver::pedal::{Hold, Pedals};
use crate::driver::speed_change::Rise;
use crate::operating_cycle::{OperatingCycle, TrafficStretch, UNLIMITED_MPS, WeatherStretch};
use crate::random::Streams;
use crate::road::Road;
use crate::road::road_type::Section;
use crate::road::speed_sign::SpeedSign;
use crate::road::surface::Ground;
use crate::simulation::event::{EventDrive, Rolling, drive_event};
use crate::study::{Part, Scenario, Study};
use crate::weather::STANDARD_WEATHER;

/// Length of a cell of constant slope, in m.
const CELL_M: f64 = 5.0;
/// Road behind the event, in m: nobody brakes for its end within the event.
const BEHIND_M: f64 = 600.0;
/// Roughness at which rolling resistance is that of a smooth road, in m³: an IRI of 1.5 mm/m.
const SMOOTH_M3: f64 = 7.603e-6;
/// Length of a roughness block, in m.
const BLOCK_M: f64 = 1000.0;
/// Time over which what a log shows at the start is averaged, in s.
const START_S: f64 = 1.0;
/// Engine speed that a gear has at least, in rad/s, where a log does not tell the gear.
const SLOWEST_ENGINE_RADPS: f64 = 100.0;

/// A pedal controller with its set speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Controller {
    /// PID.
    Pid {
        /// K_P, in s/m.
        proportional: f64,
        /// K_I, in 1/m.
        integral: f64,
        /// K_D, in s²/m.
        derivative: f64,
        /// Set speed, in m/s.
        set_speed_mps: f64,
        /// Integral part J at the start.
        start: f64,
    },
    /// Switched proportional.
    Switched {
        /// K_P, in s/m.
        proportional: f64,
        /// Threshold, in m/s.
        threshold_mps: f64,
        /// Set speed, in m/s.
        set_speed_mps: f64,
    },
}

/// An event made ready to be driven again and again.
#[derive(Clone, Debug)]
pub struct ClosedLoop<'a> {
    study: &'a Study,
    scenario: Scenario,
    rolling: Rolling,
    /// Output of the controller at the start, from the pedals.
    pub start_output: f64,
    /// Factor from the set speed to the driver's compliance.
    compliance_per_mps: f64,
    duration_s: f64,
}

impl<'a> ClosedLoop<'a> {
    /// Makes a checked event ready.
    pub fn new(study: &'a Study, log: &PedalLog) -> Self {
        let position_m = log.positions_m();
        let rows = position_m.len();
        let origin_m = CELL_M * libm::floor(position_m[0] / CELL_M);
        let way_m = position_m[rows - 1] - origin_m + BEHIND_M;
        let cells = libm::ceil(way_m / CELL_M) as usize;
        let slopes = cell_slopes(&position_m, &log.grade, origin_m, cells);
        let length_m = cells as f64 * CELL_M;
        let blocks = libm::ceil(length_m / BLOCK_M) as usize;
        let streams = Streams::new(0, 0);
        let without = [Part::PayloadSpread, Part::DriverSpread, Part::VehicleSpread];
        let model = study.model();
        let mission = model.mission.sample(Some(length_m), &streams, &without);
        let payload_kg = mission.payload_kg;
        let road = Road {
            length_m,
            sections: vec![Section { start_m: 0.0, end_m: length_m, road_type: 0 }],
            signs: vec![SpeedSign { start_m: 0.0, speed_mps: UNLIMITED_MPS }],
            slopes,
            slope_step_m: CELL_M,
            roughness_m3: vec![SMOOTH_M3; blocks],
            roughness_block_m: BLOCK_M,
            grounds: vec![Ground::Asphalt],
            climb_reached: true,
            ..Road::default()
        };
        let mut driver: Driver = model.driver.sample(&streams, &without, f64::INFINITY);
        driver.speed_change.rise = Rise::Paper;
        // brakes late and hard for the end of the road, which the event does not reach
        driver.speed_change.deceleration_mps2 = 1.0;
        driver.speed_limit.maximum_speed_mps = f64::INFINITY;
        let types = study.operating_cycle().road().types();
        let legal = types[0].truck_limit_mps.unwrap_or(f64::INFINITY).min(UNLIMITED_MPS);
        let scenario = Scenario {
            cycle_id: 0,
            cycle: OperatingCycle {
                mission,
                road,
                weather: vec![WeatherStretch { start_m: 0.0, weather: STANDARD_WEATHER }],
                traffic: vec![TrafficStretch { start_m: 0.0, density_per_m: 0.0 }],
                ..OperatingCycle::default()
            },
            driver,
            curve_residuals: Vec::new(),
            vehicle: model.vehicle.sample(payload_kg, &streams, &without),
        };
        // the controller's filter has followed the speed, the engine the pedal: both with a lag
        let speed_mps = log.speed_mps[0];
        let (_, acceleration_mps2) = line_at_start(&log.time_s, &log.speed_mps);
        let (pedal, pedal_rate) = line_at_start(&log.time_s, &log.accelerator);
        let (brake, _) = line_at_start(&log.time_s, &log.brake);
        let lag_s =
            study.powertrain().diesel().map_or(0.0, |drive| drive.engine_model.torque_lag_s);
        let accelerator = (pedal - lag_s * pedal_rate).clamp(0.0, 1.0);
        let filter_s = model.driver.pedals.pid.derivative_filter_s;
        let start_output = pedal - brake / model.driver.pedals.brake_scale;
        let rolling = Rolling {
            offset_m: position_m[0] - origin_m,
            speed_mps,
            gear: start_gear(study, log, speed_mps),
            accelerator,
            integral: 0.0,
            filtered_mps: speed_mps - filter_s * acceleration_mps2,
            held: start_output,
            holds: false,
        };
        Self {
            study,
            scenario,
            rolling,
            start_output,
            compliance_per_mps: 1.0 / legal,
            duration_s: log.duration_s(),
        }
    }

    /// Speed at the start, in m/s.
    pub fn start_speed_mps(&self) -> f64 {
        self.rolling.speed_mps
    }

    /// Drives the event.
    pub fn drive(&self, controller: &Controller) -> EventDrive {
        let mut scenario = self.scenario.clone();
        let mut rolling = self.rolling;
        let gains = &mut scenario.driver.pedals;
        let set_speed = match *controller {
            Controller::Pid { proportional, integral, derivative, set_speed_mps, start } => {
                rolling.integral = start;
                *gains = Pedals {
                    proportional,
                    integral,
                    derivative,
                    threshold_mps: None,
                    holds_brake: false,
                    redraws: 0,
                };
                set_speed_mps
            }
            Controller::Switched { proportional, threshold_mps, set_speed_mps } => {
                let hold = self.study.model().driver.pedals.switched.hold;
                rolling.holds = (set_speed_mps - rolling.speed_mps).abs() < threshold_mps;
                *gains = Pedals {
                    proportional,
                    integral: 0.0,
                    derivative: 0.0,
                    threshold_mps: Some(threshold_mps),
                    holds_brake: hold == Hold::Paper,
                    redraws: 0,
                };
                set_speed_mps
            }
        };
        scenario.driver.speed_limit.compliance = set_speed * self.compliance_per_mps;
        drive_event(self.study, scenario, &rolling, self.duration_s)
    }
}

/// Mean slope of each cell: row k's grade holds on the way from row k − 1 to row k, the last one beyond.
fn cell_slopes(position_m: &[f64], grade: &[f64], origin_m: f64, cells: usize) -> Vec<f64> {
    let rows = position_m.len();
    let mut row = 0;
    (0..cells)
        .map(|cell| {
            let (mut at, end) =
                (origin_m + cell as f64 * CELL_M, origin_m + (cell + 1) as f64 * CELL_M);
            let mut climb = 0.0;
            while at < end {
                while row < rows && position_m[row] <= at {
                    row += 1;
                }
                let (to, slope) = if row < rows {
                    (position_m[row].min(end), grade[row])
                } else {
                    (end, grade[rows - 1])
                };
                climb += slope * (to - at);
                at = to;
            }
            climb / CELL_M
        })
        .collect()
}

/// Value at the first row, and slope, of a line through the first [`START_S`].
fn line_at_start(time_s: &[f64], values: &[f64]) -> (f64, f64) {
    let rows = time_s.partition_point(|t| *t <= time_s[0] + START_S).max(3).min(values.len());
    let n = rows as f64;
    let mean_t = time_s[..rows].iter().sum::<f64>() / n;
    let mean_v = values[..rows].iter().sum::<f64>() / n;
    let (mut tv, mut tt) = (0.0, 0.0);
    for k in 0..rows {
        tv += (time_s[k] - mean_t) * (values[k] - mean_v);
        tt += (time_s[k] - mean_t) * (time_s[k] - mean_t);
    }
    let slope = if tt > 0.0 { tv / tt } else { 0.0 };
    (mean_v + slope * (time_s[0] - mean_t), slope)
}

/// Gear at the start, from 0: that of the log, or the highest one in which the engine turns fast enough.
fn start_gear(study: &Study, log: &PedalLog, speed_mps: f64) -> usize {
    let gears = &study.powertrain().gears;
    if let Some(gear) = &log.gear {
        return (libm::round(gear[0]).max(1.0) as usize).min(gears.len()) - 1;
    }
    let fast = |gear: &usize| gears[*gear].speed_ratio_per_m * speed_mps >= SLOWEST_ENGINE_RADPS;
    (0..gears.len()).rev().find(fast).unwrap_or(0)
}
