//! The closed loop of an event: the study's truck on the log's slopes, a driver with given gains
//! who wants one speed.
//!
//! The truck starts as the log says: gear, and an engine that has followed the pedal. What the
//! controller knows at the start is not in a log: the filtered speed follows from the measured
//! acceleration, the integral part is estimated with the gains, and so is the speed itself, of
//! which the first second of the log says how fast it was and how sure that is. The air is still,
//! dry and at 15 °C or as warm as the log says, the road smooth asphalt, the truck the typical one
//! with the mean payload or of a given mass. A driver may see the speed late.

use super::event::PedalLog;
use super::noise::{noise_sd, pedal_noise_sd};
use nalgebra::{DMatrix, DVector};
use ocmc_core::driver::Driver;
use ocmc_core::driver::pedal::Pedals;
use ocmc_core::driver::speed_change::Rise;
use ocmc_core::kernel::drive::pedal_event::{EventSeries, RollingStart, simulate_events};
use ocmc_core::kernel::trip::InitialMotion;
use ocmc_core::lanes::UNBOUNDED;
use ocmc_core::operating_cycle::road::Road;
use ocmc_core::operating_cycle::road::road_type::Section;
use ocmc_core::operating_cycle::road::speed_sign::SpeedSign;
use ocmc_core::operating_cycle::road::surface::Ground;
use ocmc_core::operating_cycle::weather::{STANDARD_WEATHER, Weather};
use ocmc_core::operating_cycle::{OperatingCycle, TrafficStretch, UNLIMITED_MPS, WeatherStretch};
use ocmc_core::random::Streams;
use ocmc_core::random::nesting::Trip;
use ocmc_core::study::{Scenario, Study};
use ocmc_core::switch::ModelSwitch;
use std::slice::from_ref;

/// Length of a cell of constant slope where the study's step is too coarse for the log's slopes, in
/// m.
const CELL_M: f64 = 5.0;
/// Slopes that differ by less are the same.
const SAME_SLOPE: f64 = 5e-4;
/// Road behind the event, in m: no driver brakes for its end within the event.
const BEHIND_M: f64 = 600.0;
/// Roughness at which rolling resistance is that of a smooth road, in m³: an IRI of 1.5 mm/m.
const SMOOTH_M3: f64 = 7.603e-6;
/// Length of a roughness block, in m.
const BLOCK_M: f64 = 1000.0;
/// Time over which what a log shows at the start is averaged, in s.
const START_S: f64 = 1.0;
/// Highest degree of that average.
const HIGHEST_DEGREE: usize = 4;
/// The same where a signal scatters by more than this, in m/s or pedals: a line through one second
/// of it says too little about its lag.
const NOISY_START_S: f64 = 3.0;
const NOISY: f64 = 0.005;
/// A coefficient of so many standard errors is one.
const SIGNIFICANT: f64 = 5.0;
/// Standard deviation of a speed sensor at least, in m/s: one that resolves 0.01 m/s [EJ].
const LEAST_SPEED_SD_MPS: f64 = 0.003;
/// An event begins unsettled where its speed or a pedal changes faster than this, in m/s² and 1/s
/// [EJ].
const SETTLED_MPS2: f64 = 0.05;
const SETTLED_PER_S: f64 = 0.02;
/// Engine speed that a gear has at least, in rad/s, where a log does not determine the gear.
const SLOWEST_ENGINE_RADPS: f64 = 100.0;

/// A pedal controller with its set speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Controller {
    /// K_P, in s/m.
    pub proportional: f64,
    /// K_I, in 1/m; 0 for a switched driver.
    pub integral: f64,
    /// K_D, in s²/m; 0 for a switched driver.
    pub derivative: f64,
    /// Threshold of a switched driver, in m/s; none for a PID.
    pub threshold_mps: Option<f64>,
    /// Set speed, in m/s.
    pub set_speed_mps: f64,
    /// Integral part J at the start.
    pub start: f64,
    /// Speed at the start, in m/s.
    pub start_speed_mps: f64,
    /// How late the driver sees the speed, in s.
    pub delay_s: f64,
    /// Mass of the truck, in kg; none: the study's.
    pub mass_kg: Option<f64>,
    /// Rolling resistance and air drag above the study's, as a share of them.
    pub resistance_share: f64,
}

/// Start of the event by the first second of its log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventStart {
    /// Speed, in m/s, and its standard error.
    pub speed_mps: [f64; 2],
    /// Acceleration, in m/s².
    pub acceleration_mps2: f64,
    /// Change of the accelerator pedal, in 1/s.
    pub accelerator_per_s: f64,
    /// Change of the brake pedal, in 1/s.
    pub brake_per_s: f64,
    /// Standard errors of the filtered speed, in m/s, and of the pedal that the engine has
    /// followed.
    pub lagged_errors: [f64; 2],
}

impl EventStart {
    /// Why it is no settled drive; none where it is one.
    pub fn unsettled(&self) -> Option<String> {
        let Self { acceleration_mps2, accelerator_per_s, brake_per_s, .. } = *self;
        let mut why = Vec::new();
        if acceleration_mps2.abs() > SETTLED_MPS2 {
            why.push(format!("the speed changes by {acceleration_mps2:+.2} m/s²"));
        }
        for (pedal, per_s) in [("accelerator", accelerator_per_s), ("brake", brake_per_s)] {
            if per_s.abs() > SETTLED_PER_S {
                why.push(format!("the {pedal} moves by {per_s:+.2} 1/s"));
            }
        }
        (!why.is_empty()).then(|| why.join(", "))
    }
}

/// An event made ready to be driven again and again.
#[derive(Clone, Debug)]
pub struct ClosedLoop<'a> {
    study: &'a Study,
    scenario: Scenario,
    /// Motion at the start.
    pub rolling: InitialMotion,
    /// Start of the event by its log.
    pub start: EventStart,
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
        // a step of the simulation is cut where a cell ends: no more cells than the slopes need
        let step_m = study.model().road.slope_step_m;
        let cell_m = if fits(&position_m, &log.grade, step_m) { step_m } else { CELL_M };
        let (origin_m, slopes) = cell_slopes(&position_m, &log.grade, cell_m, BEHIND_M);
        let length_m = slopes.len() as f64 * cell_m;
        let blocks = libm::ceil(length_m / BLOCK_M) as usize;
        let streams = Streams::new(0, 0);
        let without =
            [ModelSwitch::PayloadSpread, ModelSwitch::DriverSpread, ModelSwitch::VehicleSpread];
        let model = study.model();
        let mission = model.mission.sample(Some(length_m), &streams, &without);
        let payload_kg = mission.payload_kg;
        let road = Road {
            length_m,
            sections: vec![Section { start_m: 0.0, end_m: length_m, road_type: 0 }],
            signs: vec![SpeedSign { start_m: 0.0, speed_mps: UNLIMITED_MPS }],
            slopes,
            slope_step_m: cell_m,
            roughness_m3: vec![SMOOTH_M3; blocks],
            roughness_block_m: BLOCK_M,
            grounds: vec![Ground::Asphalt],
            climb_reached: true,
            route: None,
            ..Road::default()
        };
        let mut driver: Driver =
            model.driver.sample(&streams, &without, f64::INFINITY, f64::INFINITY);
        driver.speed_change.rise = Rise::Paper;
        driver.speed_change.peak_ratio = UNBOUNDED;
        // brakes late and hard for the end of the road, which the event does not reach
        driver.speed_change.deceleration_mps2 = 1.0;
        driver.speed_limit.maximum_speed_mps = f64::INFINITY;
        let temperature_k = log.air_temperature_k.unwrap_or(STANDARD_WEATHER.temperature_k);
        let weather = Weather { temperature_k, ..STANDARD_WEATHER };
        let legal = study.operating_cycle().road().legal_mps(0).min(UNLIMITED_MPS);
        let scenario = Scenario {
            cycle_id: 0,
            trip: Trip::default(),
            cycle: OperatingCycle {
                mission,
                road,
                weather: vec![WeatherStretch { start_m: 0.0, weather }],
                traffic: vec![TrafficStretch { start_m: 0.0, density_per_m: 0.0 }],
                ..OperatingCycle::default()
            },
            driver,
            curve_residuals: Vec::new(),
            vehicle: model.vehicle.sample(payload_kg, &streams, &without),
            loads: Vec::new(),
            driven_before_s: 0.0,
            handover: None,
            payload_cut_kg: 0.0,
            chargers: Vec::new(),
        };
        // the controller's filter has followed the speed, the engine the pedal: both with a lag
        let first = start_of(log, &log.speed_mps);
        let (speed, speed_mps) = (&first.coefficients, first.coefficients[0]);
        let pedals = [&log.accelerator, &log.brake].map(|values| start_of(log, values));
        let [pedal, brake] = pedals.each_ref().map(|pedal| &pedal.coefficients);
        let sd_mps = noise_sd(&log.speed_mps).max(LEAST_SPEED_SD_MPS);
        let lag_s = study.vehicle().powertrain.constants().torque_lag_s.unwrap_or(0.0);
        let filter_s = model.driver.pedals.pid.derivative_filter_s;
        let start = EventStart {
            lagged_errors: [
                sd_mps * first.spread(filter_s),
                pedal_noise_sd(&log.accelerator) * pedals[0].spread(lag_s),
            ],
            speed_mps: [speed_mps, sd_mps * first.spread(0.0)],
            acceleration_mps2: first.rate(),
            accelerator_per_s: pedals[0].rate(),
            brake_per_s: pedals[1].rate(),
        };
        let accelerator = lagged(pedal, lag_s).clamp(0.0, 1.0);
        let start_output = pedal[0] - brake[0] / model.driver.pedals.brake_scale;
        let rolling = InitialMotion {
            offset_m: position_m[0] - origin_m,
            speed_mps,
            gear: start_gear(study, log, speed_mps),
            last_shift: log.last_shift,
            accelerator,
            integral: 0.0,
            filtered_mps: lagged(speed, filter_s),
            held: start_output,
            holds: false,
            reaction_delay_s: 0.0,
            acceleration_mps2: first.rate(),
        };
        Self {
            study,
            scenario,
            rolling,
            start,
            start_output,
            compliance_per_mps: 1.0 / legal,
            duration_s: log.duration_s(),
        }
    }

    /// Mass of the study's truck, and the one without payload, in kg.
    pub fn masses_kg(&self) -> [f64; 2] {
        [self.scenario.vehicle.mass_kg, self.study.model().vehicle.curb_mass_kg]
    }

    /// The same event with inputs that are wrong by one standard error each: slopes of uncertain
    /// stretches, and what filter and engine knew at the start.
    pub fn one_error_off(&self, log: &PedalLog) -> Vec<Self> {
        let mut all: Vec<Self> = log
            .uncertain_stretches()
            .into_iter()
            .map(|(rows, error)| {
                let mut other = log.clone();
                other.grade[rows].iter_mut().for_each(|grade| *grade += error);
                Self::new(self.study, &other)
            })
            .collect();
        let [filtered_mps, accelerator] = self.start.lagged_errors;
        let mut other = self.clone();
        other.rolling.filtered_mps += filtered_mps;
        all.push(other);
        let mut other = self.clone();
        other.rolling.accelerator = (other.rolling.accelerator + accelerator).clamp(0.0, 1.0);
        all.push(other);
        all
    }

    /// Drives the event.
    pub fn drive(&self, controller: &Controller) -> EventSeries {
        self.drive_each(from_ref(controller)).pop().expect("one drive gives one series")
    }

    /// Drives the event with each of some controllers, side by side.
    pub fn drive_each(&self, controllers: &[Controller]) -> Vec<EventSeries> {
        let starts: Vec<RollingStart> =
            controllers.iter().map(|controller| self.rolling_start(controller)).collect();
        simulate_events(self.study, starts, self.duration_s)
    }

    /// Start of a drive with a controller.
    fn rolling_start(&self, controller: &Controller) -> RollingStart {
        let mut scenario = self.scenario.clone();
        let Controller { proportional, integral, derivative, threshold_mps, .. } = *controller;
        let Controller { set_speed_mps, start_speed_mps, .. } = *controller;
        let hold = self.study.model().driver.pedals.switched.hold;
        scenario.driver.pedals =
            Pedals { proportional, integral, derivative, threshold_mps, hold, redraws: 0 };
        scenario.driver.speed_limit.compliance = set_speed_mps * self.compliance_per_mps;
        if let Some(mass_kg) = controller.mass_kg {
            let vehicle = &self.study.model().vehicle;
            let (streams, without) = (Streams::new(0, 0), [ModelSwitch::VehicleSpread]);
            let payload_kg = mass_kg - vehicle.curb_mass_kg;
            scenario.vehicle = vehicle.sample(payload_kg, &streams, &without);
        }
        scenario.vehicle.rolling_coefficient *= 1.0 + controller.resistance_share;
        scenario.vehicle.drag_area_m2 *= 1.0 + controller.resistance_share;
        let near = |threshold_mps| (set_speed_mps - start_speed_mps).abs() < threshold_mps;
        let rolling = InitialMotion {
            integral: controller.start,
            holds: threshold_mps.is_some_and(near),
            speed_mps: start_speed_mps,
            filtered_mps: self.rolling.filtered_mps + start_speed_mps - self.rolling.speed_mps,
            reaction_delay_s: controller.delay_s,
            ..self.rolling
        };
        (scenario, rolling)
    }
}

/// Whether cells of this length, in m, have the slopes of the rows.
fn fits(position_m: &[f64], grade: &[f64], cell_m: f64) -> bool {
    let (origin_m, slopes) = cell_slopes(position_m, grade, cell_m, 0.0);
    (1..position_m.len()).all(|k| {
        let middle_m = 0.5 * (position_m[k - 1] + position_m[k]);
        let cell = ((middle_m - origin_m) / cell_m) as usize;
        slopes.get(cell).is_none_or(|slope| (slope - grade[k]).abs() < SAME_SLOPE)
    })
}

/// Where the first cell begins, and the mean slope of each up to `behind_m` behind the last row:
/// row k's grade holds on the way from row k − 1 to row k, the last one beyond.
fn cell_slopes(position_m: &[f64], grade: &[f64], cell_m: f64, behind_m: f64) -> (f64, Vec<f64>) {
    let rows = position_m.len();
    let origin_m = cell_m * libm::floor(position_m[0] / cell_m);
    let cells = libm::ceil((position_m[rows - 1] - origin_m + behind_m) / cell_m) as usize;
    let mut row = 0;
    let slope = |cell: usize| {
        let mut at = origin_m + cell as f64 * cell_m;
        let end = origin_m + (cell + 1) as f64 * cell_m;
        let mut climb = 0.0;
        while at < end {
            while row < rows && position_m[row] <= at {
                row += 1;
            }
            let to = if row < rows { position_m[row].min(end) } else { end };
            climb += grade[row.min(rows - 1)] * (to - at);
            at = to;
        }
        climb / cell_m
    };
    (origin_m, (0..cells).map(slope).collect())
}

/// A polynomial of the time since the first row.
struct StartPolynomial {
    /// From the constant on.
    coefficients: Vec<f64>,
    /// Inverse of R of their QR decomposition.
    inverse: DMatrix<f64>,
    /// Whether there is a significant slope.
    moves: bool,
}

impl StartPolynomial {
    /// Standard error of what a lag shows at the start, for a scatter of 1: of the first
    /// coefficient without a lag.
    fn spread(&self, lag_s: f64) -> f64 {
        let count = self.coefficients.len();
        let weights = DVector::from_fn(count, |k, _| {
            let mut unit = vec![0.0; count];
            unit[k] = 1.0;
            lagged(&unit, lag_s)
        });
        self.inverse.tr_mul(&weights).norm()
    }

    /// Rate at the start; 0 where it is no more than the scatter explains.
    fn rate(&self) -> f64 {
        if self.moves { self.coefficients.get(1).copied().unwrap_or(0.0) } else { 0.0 }
    }
}

/// The polynomial through the first [`START_S`] or [`NOISY_START_S`] of even slope: of the highest
/// degree whose last coefficient is more than the scatter explains, at least a line.
fn start_of(log: &PedalLog, values: &[f64]) -> StartPolynomial {
    let time_s = &log.time_s;
    let span_s = if noise_sd(values) > NOISY { NOISY_START_S } else { START_S };
    let rows = time_s.partition_point(|t| *t <= time_s[0] + span_s);
    // a driver bends his pedal where the slope does
    let even = log.grade.iter().take_while(|grade| (*grade - log.grade[0]).abs() < SAME_SLOPE);
    let rows = rows.min(even.count()).max(3).min(values.len());
    let power = |row: usize, column: usize| libm::pow(time_s[row] - time_s[0], column as f64);
    let right = DVector::from_column_slice(&values[..rows]);
    for degree in (1..=HIGHEST_DEGREE.min(rows - 2)).rev() {
        let matrix = DMatrix::from_fn(rows, degree + 1, power);
        let factors = matrix.clone().qr();
        let projected = factors.q().transpose() * &right;
        let Some(solution) = factors.r().solve_upper_triangular(&projected) else { continue };
        let freedom = (rows - degree - 1) as f64;
        let scatter = (&right - matrix * &solution).norm() / freedom.sqrt();
        let error = scatter / factors.r()[(degree, degree)].abs();
        let moves = solution[degree].abs() > SIGNIFICANT * error;
        if degree == 1 || moves {
            let identity = DMatrix::identity(degree + 1, degree + 1);
            let inverse = factors.r().solve_upper_triangular(&identity).unwrap_or(identity);
            let coefficients = solution.iter().copied().collect();
            return StartPolynomial { coefficients, inverse, moves };
        }
    }
    let inverse = DMatrix::identity(1, 1);
    StartPolynomial { coefficients: vec![values[0]], inverse, moves: false }
}

/// Response of a first-order lag to a polynomial c₀ + c₁ t + c₂ t² + ... at t = 0, long after it
/// began: Σ (−τ)^k k! c_k.
fn lagged(coefficients: &[f64], lag_s: f64) -> f64 {
    let (mut factor, mut sum) = (1.0, 0.0);
    for (k, coefficient) in coefficients.iter().enumerate() {
        sum += factor * coefficient;
        factor *= -lag_s * (k + 1) as f64;
    }
    sum
}

/// Gear at the start, from 0: that of the log, or the highest one in which the engine turns fast
/// enough.
fn start_gear(study: &Study, log: &PedalLog, speed_mps: f64) -> usize {
    let gears = &study.vehicle().gears;
    if let Some(gear) = &log.gear {
        return (libm::round(gear[0]).max(1.0) as usize).min(gears.len()) - 1;
    }
    let fast = |gear: &usize| gears[*gear].speed_ratio_per_m * speed_mps >= SLOWEST_ENGINE_RADPS;
    (0..gears.len()).rev().find(fast).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_lag_makes_of_a_polynomial() {
        // f = t² − 2 t + 2 solves f' + f = t²
        assert!((lagged(&[0.0, 0.0, 1.0], 1.0) - 2.0).abs() < 1e-12);
        assert!((lagged(&[3.0, 0.4], 0.5) - 2.8).abs() < 1e-12);
        let time_s: Vec<f64> = (0..40).map(|k| 7.0 + 0.05 * f64::from(k)).collect();
        let log = PedalLog { grade: vec![0.0; 40], time_s, ..PedalLog::default() };
        let time_s = &log.time_s;
        let cubic: Vec<f64> = time_s.iter().map(|t| 0.3 + 0.2 * (t - 7.0).powi(3)).collect();
        let coefficients = start_of(&log, &cubic).coefficients;
        assert!(
            (lagged(&coefficients, 0.5) - (0.3 - 0.125 * 6.0 * 0.2)).abs() < 1e-9,
            "{coefficients:?}"
        );
        // noise does not bend
        let noisy: Vec<f64> =
            time_s.iter().enumerate().map(|(k, t)| 0.1 * t + [0.02, -0.02][k % 2]).collect();
        let coefficients = start_of(&log, &noisy).coefficients;
        assert!(
            coefficients.len() == 2 && (coefficients[1] - 0.1).abs() < 0.02,
            "{coefficients:?}"
        );
    }
}
