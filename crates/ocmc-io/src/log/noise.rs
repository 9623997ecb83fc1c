//! The noise of a log's positions and altitudes: taken out before its road is found, as of a given
//! route ([`ocmc_core::operating_cycle::road::route_noise`]).
//!
//! Positions matter where nothing else tells how the vehicle turned: the course of the smoothed way
//! takes their place. Altitudes matter where no slope is known.

use super::LoggedTrip;
use super::curves::{TripError, tells_turns};
use crate::given_cycle::checked_noise;
use crate::intake::table::Quantity;
use arrow_array::Float64Array;
use ocmc_core::operating_cycle::given::PointNoise;
use ocmc_core::operating_cycle::road::route_geometry::{Path2d, interpolate};
use ocmc_core::operating_cycle::road::route_noise::{
    LEAST_NOISE_M, noise_of_altitudes, smooth_altitudes,
};
use std::borrow::Cow;

/// Rows that are closer than this along the way are one, in m (judgement: a receiver at rest
/// wanders, and says nothing of the road).
const CLOSEST_M: f64 = 0.5;

/// A drive without the noise of its positions and altitudes, and how large that was; the drive as
/// it is where it is below 0.5 m.
///
/// # Errors
/// [`GivenCycleError::Noise`] where they scatter so much that they tell no road.
pub(super) fn without_noise(
    drive: &LoggedTrip,
) -> Result<(Cow<'_, LoggedTrip>, PointNoise), TripError> {
    let mut quiet = Cow::Borrowed(drive);
    let mut noise = PointNoise::default();
    let way_m = way_of(drive);
    if let Some((rows, path)) = turning_path(drive, &way_m) {
        noise.positions_m = checked_noise("positions", path.noise_m())?;
        if noise.positions_m >= LEAST_NOISE_M {
            let (smooth, given_m) = path.smoothed(None, noise.positions_m);
            let course_rad = given_m.iter().map(|at_m| smooth.course_rad(*at_m));
            put(&mut quiet, Quantity::Course, held(&rows, course_rad, way_m.len()));
        }
    }
    if let (Some(altitude), None) =
        (known(drive, Quantity::Altitude), known(drive, Quantity::Grade))
    {
        let rows = advancing(&way_m, |k| altitude[k].is_finite());
        let altitude_m: Vec<f64> = rows.iter().map(|k| altitude[*k]).collect();
        let at_m: Vec<f64> = rows.iter().map(|k| way_m[*k] - way_m[rows[0]]).collect();
        noise.altitudes_m = checked_noise("altitudes", noise_of_altitudes(&at_m, &altitude_m))?;
        if noise.altitudes_m >= LEAST_NOISE_M {
            let smooth = smooth_altitudes(&at_m, &altitude_m, noise.altitudes_m);
            let (at_m, smooth_m): (Vec<f64>, Vec<f64>) = smooth.into_iter().unzip();
            let smoothed = |k: usize| {
                let value = interpolate(&at_m, &smooth_m, way_m[k] - way_m[rows[0]]);
                if altitude[k].is_finite() { value } else { f64::NAN }
            };
            put(&mut quiet, Quantity::Altitude, (0..way_m.len()).map(smoothed).collect());
        }
    }
    Ok((quiet, noise))
}

/// How much the positions of a drive scatter, in m, where they alone tell how it turned; 0
/// otherwise.
pub(super) fn noise_of_turning(drive: &LoggedTrip) -> f64 {
    turning_path(drive, &way_of(drive)).map_or(0.0, |(_, path)| path.noise_m())
}

/// The path that alone tells how a vehicle turned, and its rows; none where another column does.
fn turning_path(drive: &LoggedTrip, way_m: &[f64]) -> Option<(Vec<usize>, Path2d)> {
    if tells_turns(drive) {
        return None;
    }
    let latitude = known(drive, Quantity::Latitude)?;
    let longitude = known(drive, Quantity::Longitude)?;
    let rows = advancing(way_m, |k| latitude[k].is_finite() && longitude[k].is_finite());
    let selected = |values: &[f64]| rows.iter().map(|k| values[*k]).collect::<Vec<f64>>();
    let path = (rows.len() > 1).then(|| Path2d::new(&selected(latitude), &selected(longitude)))?;
    Some((rows, path))
}

/// A column that has a number.
fn known(drive: &LoggedTrip, quantity: Quantity) -> Option<&[f64]> {
    drive.column(quantity).filter(|values| values.iter().any(|value| value.is_finite()))
}

fn put(drive: &mut Cow<LoggedTrip>, quantity: Quantity, values: Vec<f64>) {
    drive.to_mut().columns.insert(quantity, Float64Array::from(values));
}

/// Distance that was driven up to each row, in m: of the column of positions where it never falls,
/// otherwise of the speed.
fn way_of(drive: &LoggedTrip) -> Vec<f64> {
    if let Some(position_m) = drive.column(Quantity::Position)
        && position_m.windows(2).all(|pair| pair[1] >= pair[0])
    {
        return position_m.to_vec();
    }
    let time_s = drive.column(Quantity::Time).unwrap_or_default();
    let speed_mps = drive.column(Quantity::Speed).unwrap_or_default();
    let mut sum_m = 0.0;
    let mut way_m = Vec::with_capacity(time_s.len());
    for k in 0..time_s.len().min(speed_mps.len()) {
        if k > 0 {
            let mean_mps = 0.5 * (speed_mps[k - 1] + speed_mps[k]);
            let step_m = mean_mps * (time_s[k] - time_s[k - 1]);
            sum_m += if step_m > 0.0 { step_m } else { 0.0 };
        }
        way_m.push(sum_m);
    }
    way_m
}

/// The rows that can be used, each farther along the way than the one before.
fn advancing(way_m: &[f64], is_usable: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut rows: Vec<usize> = Vec::new();
    for k in (0..way_m.len()).filter(|k| is_usable(*k)) {
        if rows.last().is_none_or(|last| way_m[k] - way_m[*last] >= CLOSEST_M) {
            rows.push(k);
        }
    }
    rows
}

/// Values of some rows, each held until the next one; none before the first.
fn held(rows: &[usize], values: impl Iterator<Item = f64>, count: usize) -> Vec<f64> {
    let mut all = vec![f64::NAN; count];
    for (row, value) in rows.iter().zip(values) {
        all[*row..].fill(value);
    }
    all
}
