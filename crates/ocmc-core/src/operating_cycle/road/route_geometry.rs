//! The geometry of a given route: length, heading and curves from latitude and longitude, or curves
//! from curvature.
//!
//! Points lie on a plane around the first one: x = R cos φ₀ Δλ, y = R Δφ, R = 6 371 008.8 m (mean
//! radius of the Earth, IUGG); good to 0.1 % within a few hundred km of the start's latitude. They
//! are resampled every 5 m and averaged over 45 m, because the roads of maps turn at their points
//! only; where points are farther apart their turns are spread first
//! ([`route_fillet`](super::route_fillet)); κ = change of direction per metre.
//!
//! A curve is where |κ| > 1/700 1/m somewhere and ≥ 1/1000 1/m throughout, in one direction, over
//! at least 15 m and 8° (judgement, the thresholds with which the default road was compared with
//! maps); its radius is 1 / mean |κ| of its middle third.

use super::curvature::Curve;
use super::route_fillet::{Rounding, rounded};
use super::route_noise::{SmoothPath, along, noise_of_points, smooth_over, smooth_points};

/// Mean radius of the Earth, in m (IUGG).
const EARTH_RADIUS_M: f64 = 6_371_008.8;
/// Grid of the curvature, in m.
const STEP_M: f64 = 5.0;
/// Half width of the moving average, in steps: 45 m in all.
const HALF_WINDOW: usize = 4;
/// Curvature above which a curve begins, in 1/m.
const ENTER_PER_M: f64 = 1.0 / 700.0;
/// Curvature below which it ends, in 1/m.
const LEAVE_PER_M: f64 = 1.0 / 1000.0;
/// Shorter curves are dropped, in m.
const SHORTEST_M: f64 = 15.0;
/// Curves that turn less are dropped, in rad: 8°.
const SMALLEST_TURN_RAD: f64 = 8.0 * std::f64::consts::PI / 180.0;

/// A path on a plane.
#[derive(Clone, Debug)]
pub struct Path2d {
    /// To the east, in m.
    x_m: Vec<f64>,
    /// To the north, in m.
    y_m: Vec<f64>,
    /// Distance along the path, in m.
    pub position_m: Vec<f64>,
}

impl Path2d {
    /// Puts latitudes and longitudes, in degrees, on a plane; longitudes may step from 180 to -180
    /// and from 360 to 0.
    pub fn new(latitude_deg: &[f64], longitude_deg: &[f64]) -> Self {
        let (phi, lambda) = (latitude_deg[0], longitude_deg[0]);
        let per_degree = EARTH_RADIUS_M.to_radians();
        let shrink = libm::cos(phi.to_radians());
        // some count eastwards all around, and the date line is no step: from each point the short
        // way to the next
        let mut turns = 0.0;
        let mut before = lambda;
        let x_m: Vec<f64> = longitude_deg
            .iter()
            .map(|&degrees| {
                turns -= libm::round((degrees - before) / 360.0);
                before = degrees;
                (degrees - lambda + 360.0 * turns) * per_degree * shrink
            })
            .collect();
        let y_m: Vec<f64> = latitude_deg.iter().map(|d| (d - phi) * per_degree).collect();
        Self::of_points(x_m, y_m)
    }

    /// A path whose points are known on the plane, in m.
    pub fn of_points(x_m: Vec<f64>, y_m: Vec<f64>) -> Self {
        let position_m = along(&x_m, &y_m);
        Self { x_m, y_m, position_m }
    }

    /// How much its points scatter, in m.
    pub fn noise_m(&self) -> f64 {
        noise_of_points(&self.x_m, &self.y_m)
    }

    /// The road behind points that scatter, and where the points lie on it, in m. `positions_m`:
    /// their places by an odometer, where there is one.
    pub fn smoothed(&self, positions_m: Option<&[f64]>, noise_m: f64) -> (Self, Vec<f64>) {
        match positions_m {
            None => {
                let SmoothPath { x_m, y_m, given_m } = smooth_points(&self.x_m, &self.y_m, noise_m);
                (Self::of_points(x_m, y_m), given_m)
            }
            Some(positions_m) => {
                let [x_m, y_m] = smooth_over(positions_m, [&self.x_m, &self.y_m], noise_m);
                let position_m = (0..x_m.len()).map(|k| k as f64 * STEP_M).collect();
                (Self { x_m, y_m, position_m }, positions_m.to_vec())
            }
        }
    }

    /// Its points on the plane, to the east and to the north, in m.
    pub fn points_m(&self) -> (&[f64], &[f64]) {
        (&self.x_m, &self.y_m)
    }

    /// The road with the bends of points that are far apart rounded, and where the points lie on
    /// it, in m; none where no point is. `positions_m`: their places by an odometer, where there is
    /// one.
    pub fn rounded(&self, positions_m: Option<&[f64]>, how: Rounding) -> Option<(Self, Vec<f64>)> {
        let path = rounded(&self.x_m, &self.y_m, how);
        if path.rounded == 0 {
            return None;
        }
        let mut road = Self::of_points(path.x_m, path.y_m);
        let given_m: Vec<f64> = path.given.iter().map(|k| road.position_m[*k]).collect();
        let Some(positions_m) = positions_m else { return Some((road, given_m)) };
        for at_m in &mut road.position_m {
            *at_m = interpolate(&given_m, positions_m, *at_m);
        }
        Some((road, positions_m.to_vec()))
    }

    /// Compass heading at the start, in rad from north, clockwise.
    pub fn heading_rad(&self) -> f64 {
        let last = self.x_m.len() - 1;
        let k = self.position_m.iter().position(|s| *s >= STEP_M).unwrap_or(last);
        libm::atan2(self.x_m[k] - self.x_m[0], self.y_m[k] - self.y_m[0])
    }

    /// Compass course at a distance along the path, in rad from north, clockwise.
    pub fn course_rad(&self, at_m: f64) -> f64 {
        let east = |at_m: f64| interpolate(&self.position_m, &self.x_m, at_m);
        let north = |at_m: f64| interpolate(&self.position_m, &self.y_m, at_m);
        let (from_m, to_m) = (at_m - STEP_M, at_m + STEP_M);
        libm::atan2(east(to_m) - east(from_m), north(to_m) - north(from_m))
    }

    /// The curves; `positions_m` are the points' distances along the road, which may be an
    /// odometer's.
    pub fn curves(&self, positions_m: &[f64]) -> Vec<Curve> {
        let length_m = positions_m.last().copied().unwrap_or(0.0);
        let count = libm::floor(length_m / STEP_M) as usize + 1;
        let at = |values: &[f64], k: usize| interpolate(positions_m, values, k as f64 * STEP_M);
        let x: Vec<f64> = (0..count).map(|k| at(&self.x_m, k)).collect();
        let y: Vec<f64> = (0..count).map(|k| at(&self.y_m, k)).collect();
        curves_on_grid(&path_curvature(&x, &y), length_m)
    }
}

/// The curves of a curvature, in 1/m, that holds from each position, in m, to the next.
pub fn curves_of_curvature(positions_m: &[f64], curvature_per_m: &[f64]) -> Vec<Curve> {
    let length_m = positions_m.last().copied().unwrap_or(0.0);
    let count = libm::floor(length_m / STEP_M) as usize;
    let held = |k: usize| {
        let middle_m = (k as f64 + 0.5) * STEP_M;
        curvature_per_m[positions_m.partition_point(|s| *s <= middle_m).max(1) - 1]
    };
    let curvature: Vec<f64> = (0..count).map(held).collect();
    curves_on_grid(&curvature, length_m)
}

/// Linear interpolation over increasing places.
pub fn interpolate(places: &[f64], values: &[f64], place: f64) -> f64 {
    let k = places.partition_point(|x| *x <= place).clamp(1, places.len() - 1);
    let share = ((place - places[k - 1]) / (places[k] - places[k - 1])).clamp(0.0, 1.0);
    values[k - 1] + share * (values[k] - values[k - 1])
}

/// Curvature of a path given on the grid, smoothed. The ends, where the average is lopsided, count
/// as straight.
fn path_curvature(x: &[f64], y: &[f64]) -> Vec<f64> {
    let mut curvature = vec![0.0; x.len()];
    let (x, y) = (smooth(x), smooth(y));
    for k in HALF_WINDOW + 1..x.len().saturating_sub(HALF_WINDOW + 1) {
        let (ax, ay) = (x[k] - x[k - 1], y[k] - y[k - 1]);
        let (bx, by) = (x[k + 1] - x[k], y[k + 1] - y[k]);
        let turn = libm::atan2(ax * by - ay * bx, ax * bx + ay * by);
        let step_m = 0.5 * (libm::hypot(ax, ay) + libm::hypot(bx, by));
        // opposite ends of a hairpin may meet
        curvature[k] = if step_m > 0.0 { turn / step_m } else { 0.0 };
    }
    curvature
}

/// Moving average, shorter at the ends.
fn smooth(values: &[f64]) -> Vec<f64> {
    let mean = |k: usize| {
        let window =
            &values[k.saturating_sub(HALF_WINDOW)..(k + HALF_WINDOW + 1).min(values.len())];
        window.iter().sum::<f64>() / window.len() as f64
    };
    (0..values.len()).map(mean).collect()
}

/// The curves of a curvature on the grid.
fn curves_on_grid(curvature: &[f64], length_m: f64) -> Vec<Curve> {
    let mut curves = Vec::new();
    let mut first = 0;
    while first < curvature.len() {
        let left = curvature[first] > 0.0;
        let inside = |k: &f64| (*k > 0.0) == left && k.abs() >= LEAVE_PER_M;
        let steps = curvature[first..].iter().take_while(|k| inside(k)).count();
        let bend = &curvature[first..first + steps];
        let turn = bend.iter().sum::<f64>().abs() * STEP_M;
        let sharp = bend.iter().any(|k| k.abs() > ENTER_PER_M);
        if sharp && turn >= SMALLEST_TURN_RAD && steps as f64 * STEP_M >= SHORTEST_M {
            let middle = &bend[steps / 3..steps - steps / 3];
            let total: f64 = middle.iter().map(|k| k.abs()).sum();
            let start_m = first as f64 * STEP_M;
            let end_m = ((first + steps) as f64 * STEP_M).min(length_m);
            let radius_m = middle.len() as f64 / total;
            curves.push(Curve { start_m, end_m, radius_m, left });
        }
        first += steps.max(1);
    }
    curves
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_date_line_and_a_full_turn_are_no_step() {
        let latitude = [10.0; 4];
        let plain = Path2d::new(&latitude, &[5.0, 5.001, 5.002, 5.001]);
        for longitude in [[179.999, -180.0, -179.999, 180.0], [359.999, 0.0, 0.001, 360.0]] {
            let path = Path2d::new(&latitude, &longitude);
            for (a, b) in path.position_m.iter().zip(&plain.position_m) {
                assert!((a - b).abs() < 1e-5, "{longitude:?}: {a} {b}");
            }
            assert!((path.heading_rad() - plain.heading_rad()).abs() < 1e-9);
        }
    }
}
