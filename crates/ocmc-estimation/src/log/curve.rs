//! The curves of a log: where they are, how tight, and how fast they were driven.
//!
//! Only the central part of a curve is measured, the middle third of its length by default: speeds
//! change before and behind it (the paper does the same, without a number). There
//!
//! v = length / time,   R by one of three definitions: 1/κ (the default: length over heading
//! change, 1 / mean |κ|), the mean of 1/|κ| (what the paper calls the average of the radius; noise
//! biases it upwards), or the circle through the positions.

use super::TripLog;
use super::circle::fitted_radius;
use super::grid::CurvatureGrid;
use super::hidden_markov::{HiddenMarkov, Training};
use super::sensor::{gyro_bias_radps, speed_lag_s};
use super::signal::{LogCounts, LogError, Piece, prepare};
use super::surroundings::{Neighbourhood, Surroundings};
use super::threshold::Threshold;
use crate::option_check::{above_0, check_options, from_0};
use serde::Serialize;

/// Mean radius of the earth, in m (IUGG).
const EARTH_RADIUS_M: f64 = 6_371_008.8;
/// Curvatures below this, in 1/m, count as this in the mean of 1/|κ|.
const FLATTEST_PER_M: f64 = 1.0 / 5000.0;

/// Largest bias of a yaw rate that can be given, in rad/s: gyros are off by a hundredth of it.
const LARGEST_BIAS_RADPS: f64 = 1.0;
/// Largest lag of the speed that can be given, in s, either way: receivers are late by a few.
const LARGEST_LAG_S: f64 = 60.0;

/// How curves are distinguished from straights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Detector {
    /// Hidden Markov states with given laws.
    HiddenMarkov(HiddenMarkov),
    /// Hidden Markov states whose laws are fitted to the log first, from these.
    TrainedHiddenMarkov(HiddenMarkov),
    /// Thresholds with hysteresis.
    Threshold(Threshold),
}

/// Definition of the radius of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RadiusDefinition {
    /// 1 / mean |κ|: length over heading change.
    InverseMeanCurvature,
    /// Mean of 1/|κ|, as in the paper.
    MeanRadius,
    /// The circle through the positions of the receiver.
    Positions,
}

/// A correction that is estimated from the log, or given.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Correction {
    /// Estimated; 0 where the log does not determine it.
    Estimated,
    /// Given.
    Given(f64),
}

impl Correction {
    fn given(self) -> Option<f64> {
        match self {
            Self::Estimated => None,
            Self::Given(value) => Some(value),
        }
    }
}

/// Options of the curve detection.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CurveOptions {
    /// How curves are distinguished from straights.
    pub detector: Detector,
    /// Definition of the radius.
    pub radius: RadiusDefinition,
    /// Share of a curve's length, in its middle, in which speed and radius are measured.
    pub central_share: f64,
    /// Length of a cell, in m.
    pub cell_m: f64,
    /// Length of the moving average of the curvature, in m.
    pub smooth_m: f64,
    /// Cells that are driven more slowly have no curvature, in m/s.
    pub slowest_mps: f64,
    /// Curves of one direction with a shorter gap are one, in m.
    pub largest_gap_m: f64,
    /// A curve whose curvature steps by this factor or more is cut there in two; none for no cuts.
    /// On a real road a transition curve would be cut off, too.
    pub split_ratio: Option<f64>,
    /// Shorter curves are dropped, in m.
    pub shortest_m: f64,
    /// Curves that turn less are dropped, in rad.
    pub smallest_turn_rad: f64,
    /// Bias of the yaw rate, in rad/s.
    pub gyro_bias_radps: Correction,
    /// Time by which the speed comes later than the yaw rate, in s.
    pub speed_lag_s: Correction,
}

impl Default for CurveOptions {
    fn default() -> Self {
        Self {
            detector: Detector::HiddenMarkov(HiddenMarkov::default()),
            radius: RadiusDefinition::InverseMeanCurvature,
            central_share: 1.0 / 3.0,
            cell_m: 5.0,
            smooth_m: 15.0,
            slowest_mps: 2.0,
            largest_gap_m: 10.0,
            split_ratio: None,
            shortest_m: 15.0,
            smallest_turn_rad: 8.0 / 180.0 * std::f64::consts::PI,
            gyro_bias_radps: Correction::Estimated,
            speed_lag_s: Correction::Estimated,
        }
    }
}

/// A curve that was driven.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DrivenCurve {
    /// Way from the start of the log to the curve, gaps not counted, in m.
    pub start_m: f64,
    /// Way to its end, in m.
    pub end_m: f64,
    /// Time at which it begins, in s.
    pub start_s: f64,
    /// Time at which it ends, in s.
    pub end_s: f64,
    /// True for a left curve.
    pub left: bool,
    /// Heading change, in rad, not negative.
    pub turn_rad: f64,
    /// Radius of the central part, in m.
    pub radius_m: f64,
    /// Mean speed in the central part, in m/s.
    pub speed_mps: f64,
    /// Mean acceleration over the central part, in m/s².
    pub acceleration_mps2: f64,
    /// Speed limit in the middle, in m/s, where the log has one.
    pub limit_mps: Option<f64>,
    /// Surroundings of the curve.
    #[serde(flatten)]
    pub around: Surroundings,
}

impl DrivenCurve {
    /// Length, in m.
    pub fn length_m(&self) -> f64 {
        self.end_m - self.start_m
    }
}

/// Curves that were found in a log, and the parts that were not used.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CurveDetection {
    /// The curves, in order.
    pub curves: Vec<DrivenCurve>,
    /// Rows.
    pub counts: LogCounts,
    /// Way of the log, gaps not counted, in m.
    pub way_m: f64,
    /// Length too slow for a curvature, in m.
    pub slow_m: f64,
    /// Bias that was subtracted from the yaw rate, in rad/s; none where the log does not determine
    /// it.
    pub gyro_bias_radps: Option<f64>,
    /// Lag of the speed that was taken back, in s; none where the log does not determine it.
    pub speed_lag_s: Option<f64>,
    /// Correlation of the rate of the course with the yaw rate at this lag, where it was estimated.
    pub lag_correlation: Option<f64>,
    /// Curves that were dropped because they are too short.
    pub too_short: usize,
    /// Curves that were dropped because they turn too little.
    pub too_straight: usize,
    /// Curves that were dropped because the vehicle crept or stood in their central part.
    pub too_slow: usize,
    /// Curves that were dropped because their radius cannot be determined: fewer than four
    /// positions, or no turn in the middle.
    pub without_radius: usize,
    /// The fitted laws of a trained detector.
    pub training: Option<Training>,
}

/// Finds and measures the curves of a log.
///
/// # Errors
/// [`LogError`] where the log cannot be used or an option is out of its range.
pub fn detect_curves(log: &TripLog, options: &CurveOptions) -> Result<CurveDetection, LogError> {
    options.check()?;
    let (pieces, counts) = prepare(log)?;
    let given_lag_s = options.speed_lag_s.given();
    let estimated_lag = if given_lag_s.is_none() { speed_lag_s(log, &pieces) } else { None };
    let mut detection = CurveDetection {
        counts,
        gyro_bias_radps: options.gyro_bias_radps.given().or_else(|| gyro_bias_radps(&pieces)),
        speed_lag_s: given_lag_s.or(estimated_lag.map(|(lag_s, _)| lag_s)),
        lag_correlation: estimated_lag.map(|(_, correlation)| correlation),
        ..CurveDetection::default()
    };
    let mut grids = Vec::with_capacity(pieces.len());
    for piece in &pieces {
        let mut grid = CurvatureGrid::new(
            piece,
            detection.gyro_bias_radps.unwrap_or(0.0),
            detection.speed_lag_s.unwrap_or(0.0),
            options.cell_m,
            options.smooth_m,
            options.slowest_mps,
        );
        grid.start_m = detection.way_m;
        detection.way_m += grid.way_m;
        detection.slow_m += grid.slow_cells as f64 * options.cell_m;
        grids.push(grid);
    }
    if let Detector::TrainedHiddenMarkov(start) = options.detector {
        let signals: Vec<&[f64]> = grids.iter().map(|grid| grid.smooth_per_m.as_slice()).collect();
        detection.training = Some(start.trained(&signals, options.cell_m));
    }
    for (grid, piece) in grids.iter().zip(&pieces) {
        let directions = match options.detector {
            Detector::Threshold(threshold) => threshold.directions(&grid.smooth_per_m),
            Detector::HiddenMarkov(model) | Detector::TrainedHiddenMarkov(model) => {
                let model = detection.training.map_or(model, |training| training.model);
                model.directions(&grid.smooth_per_m, options.cell_m)
            }
        };
        let mut parts = Vec::new();
        for run in runs(&directions, options.largest_gap_m / options.cell_m) {
            split(grid, run, options, &mut parts);
        }
        let neighbourhood = Neighbourhood::new(piece, grid);
        // a run that is too short or too straight is no curve, nor a neighbour
        parts.retain(|part| is_curve(grid, part, options, &mut detection));
        for (k, part) in parts.iter().enumerate() {
            let before = k.checked_sub(1).map(|k| parts[k].end);
            let after = parts.get(k + 1).map(|next| next.first);
            let around = neighbourhood.of([part.first, part.end], before, after);
            measure(log, piece, grid, part, around, options, &mut detection);
        }
    }
    Ok(detection)
}

impl CurveOptions {
    fn check(&self) -> Result<(), LogError> {
        let share = self.central_share;
        let ratio = self.split_ratio.unwrap_or(f64::INFINITY);
        let bias_radps = self.gyro_bias_radps.given().unwrap_or(0.0);
        let lag_s = self.speed_lag_s.given().unwrap_or(0.0);
        let small = bias_radps.abs() <= LARGEST_BIAS_RADPS;
        check_options([
            ("the central share", share, "above 0 and at most 1", share > 0.0 && share <= 1.0),
            above_0("the cell, in m,", self.cell_m),
            from_0("the moving average, in m,", self.smooth_m),
            from_0("the slowest speed, in m/s,", self.slowest_mps),
            from_0("the largest gap, in m,", self.largest_gap_m),
            from_0("the shortest curve, in m,", self.shortest_m),
            ("the split ratio", ratio, "a number above 1", ratio > 1.0),
            from_0("the smallest turn, in rad,", self.smallest_turn_rad),
            ("the bias of the yaw rate, in rad/s,", bias_radps, "-1 to 1", small),
            ("the lag of the speed, in s,", lag_s, "-60 to 60", lag_s.abs() <= LARGEST_LAG_S),
        ])
        .map_err(LogError::Option)
    }
}

/// Cells of one direction.
struct Run {
    first: usize,
    end: usize,
    left: bool,
}

/// Runs of one direction; runs with a gap of fewer than `gap` cells are one.
fn runs(directions: &[i8], gap: f64) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let mut end = 0;
    for cells in directions.chunk_by(|a, b| a == b) {
        let (first, left) = (end, cells[0] > 0);
        end += cells.len();
        if cells[0] == 0 {
            continue;
        }
        match runs.last_mut() {
            Some(last) if last.left == left && ((first - last.end) as f64) < gap => last.end = end,
            _ => runs.push(Run { first, end, left }),
        }
    }
    runs
}

/// Cells at a run's ends, and at a step, whose curvature is a mixture of both sides.
const MIXED_CELLS: usize = 2;

/// Cuts a run where its curvature steps most, and the parts again, as far as each part is a curve
/// of its own.
fn split(grid: &CurvatureGrid, run: Run, options: &CurveOptions, parts: &mut Vec<Run>) {
    let cut = options.split_ratio.and_then(|ratio| largest_step(grid, &run, ratio, options));
    let Some(cut) = cut else { return parts.push(run) };
    split(grid, Run { end: cut, ..run }, options, parts);
    split(grid, Run { first: cut, ..run }, options, parts);
}

/// The cell before which the curvature of a run steps most, by the sum of squares between both
/// parts.
fn largest_step(
    grid: &CurvatureGrid,
    run: &Run,
    ratio: f64,
    options: &CurveOptions,
) -> Option<usize> {
    let (first, end) = (run.first + MIXED_CELLS, run.end.saturating_sub(MIXED_CELLS));
    let fewest = libm::ceil(options.shortest_m / options.cell_m).max(2.0) as usize + MIXED_CELLS;
    let side = if run.left { 1.0 } else { -1.0 };
    let sum =
        |first: usize, end: usize| side * grid.curvature_per_m[first..end].iter().sum::<f64>();
    let mut best = None;
    let mut most = 0.0;
    for cut in first + fewest..(end + 1).saturating_sub(fewest) {
        let (before, after) = (sum(first, cut), sum(cut, end));
        let (n, m) = ((cut - first) as f64, (end - cut) as f64);
        let (a, b) = (before / n, after / m);
        let turns = before.min(after) * options.cell_m >= options.smallest_turn_rad;
        let between = (a - b) * (a - b) * n * m / (n + m);
        if turns && a.max(b) >= ratio * a.min(b) && between > most {
            most = between;
            best = Some(cut);
        }
    }
    best
}

impl Run {
    /// 1 for a left curve, −1 for a right one.
    fn side(&self) -> f64 {
        if self.left { 1.0 } else { -1.0 }
    }

    /// Heading change in its direction, in rad.
    fn turn_rad(&self, grid: &CurvatureGrid) -> f64 {
        let turn: f64 = grid.curvature_per_m[self.first..self.end].iter().sum();
        self.side() * turn * grid.cell_m
    }
}

/// Whether a run is long enough and turns enough; it is counted where it does not.
fn is_curve(
    grid: &CurvatureGrid,
    run: &Run,
    options: &CurveOptions,
    detection: &mut CurveDetection,
) -> bool {
    if ((run.end - run.first) as f64 * options.cell_m) < options.shortest_m {
        detection.too_short += 1;
        return false;
    }
    let turns = run.turn_rad(grid) >= options.smallest_turn_rad;
    detection.too_straight += usize::from(!turns);
    turns
}

/// Adds a curve, or counts why it cannot be measured.
fn measure(
    log: &TripLog,
    piece: &Piece,
    grid: &CurvatureGrid,
    run: &Run,
    around: Surroundings,
    options: &CurveOptions,
    detection: &mut CurveDetection,
) {
    let cells = run.end - run.first;
    let side = run.side();
    let margin = libm::floor(cells as f64 * 0.5 * (1.0 - options.central_share) + 1e-9) as usize;
    let (first, end) = (run.first + margin, run.end - margin);
    let (enter_s, leave_s) = (grid.time_s[first], grid.time_s[end]);
    let inner = (end - first) as f64;
    if (first..end).any(|cell| grid.is_slow(cell, options.slowest_mps)) {
        detection.too_slow += 1;
        return;
    }
    let radius_m = match options.radius {
        RadiusDefinition::InverseMeanCurvature => {
            let turn = side * grid.curvature_per_m[first..end].iter().sum::<f64>();
            (turn > 0.0).then(|| inner / turn)
        }
        RadiusDefinition::MeanRadius => {
            let radii =
                grid.smooth_per_m[first..end].iter().map(|k| 1.0 / k.abs().max(FLATTEST_PER_M));
            Some(radii.sum::<f64>() / inner)
        }
        RadiusDefinition::Positions => radius_of_positions(log, piece, enter_s, leave_s),
    };
    let Some(radius_m) = radius_m else {
        detection.without_radius += 1;
        return;
    };
    let gain_mps = speed_at_mps(piece, leave_s) - speed_at_mps(piece, enter_s);
    let middle_s = f64::midpoint(enter_s, leave_s);
    let row = piece.row[piece.time_s.partition_point(|t| *t <= middle_s).max(1) - 1];
    detection.curves.push(DrivenCurve {
        start_m: grid.start_m + run.first as f64 * options.cell_m,
        end_m: grid.start_m + run.end as f64 * options.cell_m,
        start_s: grid.time_s[run.first],
        end_s: grid.time_s[run.end],
        left: run.left,
        turn_rad: run.turn_rad(grid),
        radius_m,
        speed_mps: inner * options.cell_m / (leave_s - enter_s),
        acceleration_mps2: gain_mps / (leave_s - enter_s),
        limit_mps: log.limit_mps.as_ref().map(|limit| limit[row]).filter(|limit| limit.is_finite()),
        around,
    });
}

/// Speed at a moment, linear between rows, in m/s.
fn speed_at_mps(piece: &Piece, time_s: f64) -> f64 {
    let (times, speeds) = (&piece.time_s, &piece.speed_mps);
    let k = times.partition_point(|t| *t < time_s).clamp(1, times.len() - 1);
    let part = ((time_s - times[k - 1]) / (times[k] - times[k - 1])).clamp(0.0, 1.0);
    speeds[k - 1] + part * (speeds[k] - speeds[k - 1])
}

/// Radius of the circle through the positions between two moments, one row more on each side, in m.
fn radius_of_positions(log: &TripLog, piece: &Piece, enter_s: f64, leave_s: f64) -> Option<f64> {
    let (latitude, longitude) = (log.latitude_deg.as_ref()?, log.longitude_deg.as_ref()?);
    let first = piece.time_s.partition_point(|t| *t < enter_s).max(1) - 1;
    let end = (piece.time_s.partition_point(|t| *t <= leave_s) + 1).min(piece.time_s.len());
    let rows = piece.row[first..end].iter().copied();
    let points: Vec<(f64, f64)> = rows
        .map(|row| (latitude[row].to_radians(), longitude[row].to_radians()))
        .filter(|(latitude, longitude)| latitude.is_finite() && longitude.is_finite())
        .collect();
    let (latitude_0, longitude_0) = *points.first()?;
    let shrink = libm::cos(latitude_0);
    let (x, y): (Vec<f64>, Vec<f64>) = points
        .iter()
        .map(|(latitude, longitude)| {
            let east = (longitude - longitude_0) * shrink;
            (EARTH_RADIUS_M * east, EARTH_RADIUS_M * (latitude - latitude_0))
        })
        .unzip();
    fitted_radius(&x, &y)
}
