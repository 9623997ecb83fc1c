//! Curvature along the way: κ = Δψ / Δs, the heading change over each cell of the way.
//!
//! Speed and yaw rate are taken as linear between rows, so way and heading are known exactly at
//! every cell's ends whatever the sampling rate, and no division by a noisy speed is needed. The
//! vehicle does not turn at standstill.

use super::sensor::STANDSTILL_MPS;
use super::signal::Piece;

/// Curvature of one piece of a log in cells of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurvatureGrid {
    /// Length of a cell, in m.
    pub cell_m: f64,
    /// Way from the start of the log to the first cell, gaps not counted, in m.
    pub start_m: f64,
    /// Way of the whole piece, in m: the last cell ends at or before it.
    pub way_m: f64,
    /// Curvature of each cell, in 1/m, positive to the left; 0 in slow cells.
    pub curvature_per_m: Vec<f64>,
    /// Moving average of the curvature, in 1/m: what the detectors see.
    pub smooth_per_m: Vec<f64>,
    /// Time at which each cell begins, and at which the last one ends, in s.
    pub time_s: Vec<f64>,
    /// Cells that were driven too slowly for a curvature.
    pub slow_cells: usize,
}

impl CurvatureGrid {
    /// The grid of a piece.
    ///
    /// `bias_radps` is subtracted from the yaw rate, the speed is taken `lag_s` later than its row
    /// says; cells slower than `slowest_mps` count as straight; `smooth_m` is the length of the
    /// moving average.
    pub fn new(
        piece: &Piece,
        bias_radps: f64,
        lag_s: f64,
        cell_m: f64,
        smooth_m: f64,
        slowest_mps: f64,
    ) -> Self {
        let speed_mps = shifted(piece, lag_s);
        let mut grid = Self { cell_m, ..Self::default() };
        let (mut way_m, mut heading_rad, mut cell_heading_rad) = (0.0, 0.0, 0.0);
        grid.time_s.push(piece.time_s[0]);
        for k in 1..piece.time_s.len() {
            let dt = piece.time_s[k] - piece.time_s[k - 1];
            let (v0, v1) = (speed_mps[k - 1], speed_mps[k]);
            let (mut w0, mut w1) =
                (piece.yaw_rate_radps[k - 1] - bias_radps, piece.yaw_rate_radps[k] - bias_radps);
            if v0.max(v1) < STANDSTILL_MPS {
                (w0, w1) = (0.0, 0.0);
            }
            let slope = (v1 - v0) / dt;
            let length_m = 0.5 * (v0 + v1) * dt;
            // every cell that ends within this interval
            loop {
                let end_m = grid.time_s.len() as f64 * cell_m;
                let ahead_m = end_m - way_m;
                if !(ahead_m <= length_m) || length_m <= 0.0 {
                    break;
                }
                let reach = v0 + (v0 * v0 + 2.0 * slope * ahead_m).max(0.0).sqrt();
                let t = if reach > 0.0 { (2.0 * ahead_m / reach).min(dt) } else { dt };
                let at_end = heading_rad + w0 * t + 0.5 * (w1 - w0) / dt * t * t;
                let time_s = piece.time_s[k - 1] + t;
                let took_s = time_s - grid.time_s[grid.time_s.len() - 1];
                let slow = !(cell_m >= slowest_mps * took_s);
                grid.slow_cells += usize::from(slow);
                grid.curvature_per_m.push(if slow {
                    0.0
                } else {
                    (at_end - cell_heading_rad) / cell_m
                });
                grid.time_s.push(time_s);
                cell_heading_rad = at_end;
            }
            way_m += length_m;
            heading_rad += 0.5 * (w0 + w1) * dt;
        }
        grid.way_m = way_m;
        grid.smooth_per_m = moving_average(&grid.curvature_per_m, smooth_m, cell_m);
        grid
    }

    /// Whether a cell was driven more slowly than this, in m/s.
    pub fn is_slow(&self, cell: usize, slowest_mps: f64) -> bool {
        !(self.cell_m >= slowest_mps * (self.time_s[cell + 1] - self.time_s[cell]))
    }
}

/// The speed at each row's time, measured `lag_s` later; held at the ends.
fn shifted(piece: &Piece, lag_s: f64) -> Vec<f64> {
    if lag_s == 0.0 {
        return piece.speed_mps.clone();
    }
    let (times, speeds) = (&piece.time_s, &piece.speed_mps);
    let last = times.len() - 1;
    let mut k = 0;
    times
        .iter()
        .map(|time_s| {
            let at = time_s + lag_s;
            if at <= times[0] {
                return speeds[0];
            }
            while k + 1 < last && times[k + 1] < at {
                k += 1;
            }
            let part = ((at - times[k]) / (times[k + 1] - times[k])).min(1.0);
            speeds[k] * (1.0 - part) + speeds[k + 1] * part
        })
        .collect()
}

/// Mean over the cells within half of `smooth_m` on each side, fewer at the ends; without a shift.
fn moving_average(values: &[f64], smooth_m: f64, cell_m: f64) -> Vec<f64> {
    let half = libm::floor(0.5 * smooth_m / cell_m) as usize;
    (0..values.len())
        .map(|k| {
            let window = &values[k.saturating_sub(half)..(k + half + 1).min(values.len())];
            window.iter().sum::<f64>() / window.len() as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Constant acceleration and a heading that follows the way: κ = 1/200 everywhere.
    fn circle(rate_hz: f64) -> Piece {
        let time_s: Vec<f64> = (0..(20.0 * rate_hz) as usize).map(|k| k as f64 / rate_hz).collect();
        let speed_mps: Vec<f64> = time_s.iter().map(|t| 5.0 + 0.5 * t).collect();
        Piece {
            yaw_rate_radps: speed_mps.iter().map(|v| v / 200.0 + 0.01).collect(),
            row: (0..time_s.len()).collect(),
            speed_mps,
            time_s,
        }
    }

    #[test]
    fn a_circle_has_one_curvature_at_every_rate() {
        for rate_hz in [1.0, 10.0, 100.0] {
            let piece = circle(rate_hz);
            let grid = CurvatureGrid::new(&piece, 0.01, 0.0, 5.0, 15.0, 2.0);
            let end_s = piece.time_s[piece.time_s.len() - 1];
            assert!((grid.way_m - (5.0 * end_s + 0.25 * end_s * end_s)).abs() < 1e-9);
            assert_eq!(grid.curvature_per_m.len(), (grid.way_m / 5.0) as usize);
            for k in 0..grid.curvature_per_m.len() {
                assert!((grid.curvature_per_m[k] - 0.005).abs() < 1e-12, "{rate_hz} Hz, cell {k}");
                assert!((grid.smooth_per_m[k] - 0.005).abs() < 1e-12);
                let t = grid.time_s[k];
                assert!((5.0 * t + 0.25 * t * t - 5.0 * k as f64).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_late_speed_is_taken_back() {
        let mut piece = circle(10.0);
        for (speed, time) in piece.speed_mps.iter_mut().zip(&piece.time_s) {
            *speed = 5.0 + 0.5 * (time - 0.8);
        }
        let grid = CurvatureGrid::new(&piece, 0.01, 0.8, 5.0, 15.0, 2.0);
        // the last 0.8 s hold their speed
        for k in 0..grid.curvature_per_m.len() - 3 {
            assert!((grid.curvature_per_m[k] - 0.005).abs() < 1e-12);
        }
    }

    #[test]
    fn slow_cells_are_straight_and_counted() {
        let mut piece = circle(10.0);
        piece.speed_mps.fill(1.0);
        let grid = CurvatureGrid::new(&piece, 0.0, 0.0, 5.0, 15.0, 2.0);
        assert_eq!((grid.curvature_per_m.len(), grid.slow_cells), (3, 3));
        assert!(grid.curvature_per_m.iter().all(|k| *k == 0.0));
        piece.speed_mps.fill(0.0);
        assert!(CurvatureGrid::new(&piece, 0.0, 0.0, 5.0, 15.0, 2.0).curvature_per_m.is_empty());
    }
}
