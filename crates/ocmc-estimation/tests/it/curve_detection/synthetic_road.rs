//! A log of a drive on a road whose curves are known.

use ocmc_core::operating_cycle::road::curvature::{Curve, CurveModel};
use ocmc_core::random::{Draws, Stream};
use ocmc_estimation::log::TripLog;
use ocmc_estimation::log::sensor::yaw_rate_of_course;

/// Grid of the drive, in m.
const GRID_M: f64 = 0.5;
/// Speed on straights, acceleration and retardation: a loaded truck on a rural road.
const CRUISE_MPS: f64 = 22.0;
const ACCELERATION_MPS2: f64 = 0.5;
/// Lateral wandering of a driver: standard deviation of the curvature, in 1/m, and its length of
/// correlation, in m.
const WANDER_PER_M: f64 = 2.5e-4;
const WANDER_LENGTH_M: f64 = 20.0;
/// White noise and bias of the gyro, in rad/s: those of a cheap sensor.
const GYRO_NOISE_RADPS: f64 = 0.003;
pub(crate) const GYRO_BIAS_RADPS: f64 = 0.008;
/// The drive begins with a standstill, in s.
const STANDSTILL_S: f64 = 30.0;

/// A rural road: 1.2 curves per km, R − 20 m with median 150 m.
pub(crate) fn rural_curves(seed: u64, length_m: f64) -> Vec<Curve> {
    let model = CurveModel {
        per_m: 1.2e-3,
        maximum_per_m: 1.2e-3,
        reference_sign_mps: None,
        sign_exponent: 0.0,
        turn_radius_m: 20.0,
        median_radius_m: 150.0,
        radius_log_sd: 0.9,
        median_length_m: 120.0,
        length_log_sd: 0.6,
        maximum_heading_rad: std::f64::consts::FRAC_PI_2,
    };
    let mut curves = Vec::new();
    let mut draws = Draws::new(seed, 0, Stream::Curve);
    model.sample(0.0, length_m, 22.0, &mut draws, &mut curves);
    curves
}

/// The log of a drive along some curves, in rows of 1 / `rate_hz`, with the noise times `noise`.
pub(crate) fn log(
    seed: u64,
    curves: &[Curve],
    length_m: f64,
    rate_hz: f64,
    noise: f64,
) -> TripLog<'static> {
    let cells = (length_m / GRID_M) as usize;
    let mut curvature = vec![0.0; cells];
    for curve in curves {
        let cell = |at_m: f64| ((at_m / GRID_M).round() as usize).min(cells);
        curvature[cell(curve.start_m)..cell(curve.end_m)].fill(curve.curvature_per_m());
    }
    // the speed in curves by the field law, reached and left with the acceleration
    let mut square: Vec<f64> = curvature
        .iter()
        .map(|k| {
            let speed = 54.5 / 3.6 * (1.0 / (250.0 * k.abs().max(1e-6))).powf(0.46);
            speed.min(CRUISE_MPS).powi(2)
        })
        .collect();
    square[0] = 0.25;
    let gain = 2.0 * ACCELERATION_MPS2 * GRID_M;
    for k in 1..cells {
        square[k] = square[k].min(square[k - 1] + gain);
    }
    for k in (1..cells).rev() {
        square[k - 1] = square[k - 1].min(square[k] + gain);
    }
    let mut draws = Draws::new(seed, 1, Stream::Curve);
    let keep = (-GRID_M / WANDER_LENGTH_M).exp();
    let mut wander = 0.0;
    for k in &mut curvature {
        wander = keep * wander + (1.0 - keep * keep).sqrt() * WANDER_PER_M * noise * draws.normal();
        *k += wander;
    }
    let (mut times, mut speeds, mut yaw_rates) = (Vec::new(), Vec::new(), Vec::new());
    let (mut time_s, mut next_s) = (STANDSTILL_S, 0.0);
    let mut gyro = |speed: f64, curvature: f64| {
        speed * curvature + noise * (GYRO_BIAS_RADPS + GYRO_NOISE_RADPS * draws.normal())
    };
    while next_s < STANDSTILL_S {
        times.push(next_s);
        speeds.push(0.0);
        yaw_rates.push(gyro(0.0, 0.0));
        next_s += 1.0 / rate_hz;
    }
    for k in 0..cells - 1 {
        let (from, to) = (square[k].sqrt(), square[k + 1].sqrt());
        let took_s = 2.0 * GRID_M / (from + to);
        while next_s < time_s + took_s {
            let part = (next_s - time_s) / took_s;
            let speed = from + part * (to - from);
            times.push(next_s);
            speeds.push(speed);
            yaw_rates.push(gyro(speed, curvature[k]));
            next_s += 1.0 / rate_hz;
        }
        time_s += took_s;
    }
    TripLog {
        time_s: times.into(),
        speed_mps: speeds.into(),
        yaw_rate_radps: yaw_rates.into(),
        ..TripLog::default()
    }
}

/// Takes the gyro out of a log of `rate_hz` and `noise`, and puts in the course of a receiver that
/// updates each so many rows and whose velocity errs by `error_mps` across the way.
pub(crate) fn course_alone(
    log: &mut TripLog,
    seed: u64,
    noise: f64,
    rows_of_update: usize,
    error_mps: f64,
) {
    let mut draws = Draws::new(seed, 2, Stream::Curve);
    let (mut heading, mut shown) = (0.3f64, 0.0f64);
    let mut course = Vec::with_capacity(log.time_s.len());
    for k in 0..log.time_s.len() {
        let before = k.saturating_sub(1);
        let yaw =
            0.5 * (log.yaw_rate_radps[before] + log.yaw_rate_radps[k]) - noise * GYRO_BIAS_RADPS;
        if log.speed_mps[k] > 0.0 {
            heading += yaw * (log.time_s[k] - log.time_s[before]);
        }
        let error = error_mps * draws.normal() / log.speed_mps[k].max(0.1);
        if k % rows_of_update == 0 {
            shown = (-heading - error).rem_euclid(std::f64::consts::TAU);
        }
        course.push(shown);
    }
    log.yaw_rate_radps = yaw_rate_of_course(&log.time_s, &log.speed_mps, &course).into();
}

/// Adds the positions that follow from speed and yaw rate, near 58° north.
pub(crate) fn add_positions(log: &mut TripLog) {
    let (mut heading, mut east_m, mut north_m) = (0.3f64, 0.0, 0.0);
    let (mut latitude, mut longitude) = (vec![58.0], vec![12.0]);
    for k in 1..log.time_s.len() {
        let dt = log.time_s[k] - log.time_s[k - 1];
        let turn = 0.5 * (log.yaw_rate_radps[k - 1] + log.yaw_rate_radps[k]) * dt;
        let way_m = 0.5 * (log.speed_mps[k - 1] + log.speed_mps[k]) * dt;
        east_m += way_m * (heading + 0.5 * turn).cos();
        north_m += way_m * (heading + 0.5 * turn).sin();
        heading += turn;
        let radius_m = 6_371_008.8f64;
        latitude.push(58.0 + (north_m / radius_m).to_degrees());
        let shrink = latitude[k].to_radians().cos();
        longitude.push(12.0 + (east_m / (radius_m * shrink)).to_degrees());
    }
    log.latitude_deg = Some(latitude.into());
    log.longitude_deg = Some(longitude.into());
}
