//! Surroundings of a curve: whether it was driven freely.
//!
//! The law of curve speeds is that of a truck that the curve alone slows. Close behind another
//! curve, a junction or a standstill a truck still accelerates for its driver's wish in the middle
//! of the curve, and close before one it brakes already.

use super::grid::CurvatureGrid;
use super::sensor::STANDSTILL_MPS;
use super::signal::Piece;
use serde::Serialize;

/// Way before and behind a curve in which [`Surroundings::slowest_near_mps`] looks, in m
/// (judgement: from 30 to 50 km/h a truck takes 120 m at 0.5 m/s²).
pub const NEAR_M: f64 = 150.0;

/// Surroundings of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Surroundings {
    /// Way from the end of the curve before, in m; where there is none from the start of the log,
    /// or of what was logged without a gap.
    pub gap_before_m: f64,
    /// Way to the start of the next curve, in m; where there is none to the end of the log, or of
    /// what was logged without a gap.
    pub gap_after_m: f64,
    /// Slowest speed from 150 m before to 150 m behind the curve, in m/s, the curve included.
    pub slowest_near_mps: f64,
    /// Way between the curve and the nearest place where the vehicle stood, in m, 0 within the
    /// curve; none where it never stood.
    pub stop_near_m: Option<f64>,
}

/// The rows of a piece on the cells of its grid.
pub(super) struct Neighbourhood<'a> {
    piece: &'a Piece,
    grid: &'a CurvatureGrid,
    /// Cells in which the vehicle stood, rising.
    stood: Vec<usize>,
}

impl<'a> Neighbourhood<'a> {
    pub(super) fn new(piece: &'a Piece, grid: &'a CurvatureGrid) -> Self {
        let mut stood: Vec<usize> = Vec::new();
        for (time_s, speed_mps) in piece.time_s.iter().zip(&piece.speed_mps) {
            if *speed_mps < STANDSTILL_MPS {
                let cell = grid.time_s.partition_point(|t| t < time_s);
                if stood.last() != Some(&cell) {
                    stood.push(cell);
                }
            }
        }
        Self { piece, grid, stood }
    }

    /// Around the cells from `first` to before `end`, between the end of the curve before and the
    /// start of the next one, where there are such.
    pub(super) fn of(
        &self,
        [first, end]: [usize; 2],
        before: Option<usize>,
        after: Option<usize>,
    ) -> Surroundings {
        let grid = self.grid;
        let cell_m = grid.cell_m;
        let near = libm::round(NEAR_M / cell_m) as usize;
        let time_s = |cell: usize| grid.time_s[cell.min(grid.time_s.len() - 1)];
        let from_s = time_s(first.saturating_sub(near));
        let to_s = time_s(end + near);
        let rows = &self.piece.time_s;
        // one row more on either side: the rows may be farther apart than the cells
        let from = rows.partition_point(|t| *t <= from_s).max(1) - 1;
        let to = (rows.partition_point(|t| *t < to_s) + 1).min(rows.len());
        let slowest_near_mps =
            self.piece.speed_mps[from..to].iter().copied().fold(f64::INFINITY, f64::min);
        let place = self.stood.partition_point(|cell| *cell <= first);
        let behind = self.stood.get(place).map(|cell| cell.saturating_sub(end));
        let ahead = place.checked_sub(1).map(|place| first - self.stood[place]);
        let nearest = behind.into_iter().chain(ahead).min();
        let cells = |cells: usize| cells as f64 * cell_m;
        Surroundings {
            gap_before_m: cells(first - before.unwrap_or(0)),
            gap_after_m: after.map_or(grid.way_m - cells(end), |start| cells(start - end)),
            slowest_near_mps,
            stop_near_m: nearest.map(cells),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 10 m/s for 60 s, braking to rest over 10 s, 5 s of rest, and off again; ten rows a second.
    fn drive() -> (Piece, CurvatureGrid) {
        let time_s: Vec<f64> = (0..1500).map(|k| 0.1 * f64::from(k)).collect();
        let speed =
            |t: f64| if t < 70.0 { 10.0 - (t - 60.0).max(0.0) } else { (t - 75.0).max(0.0) };
        let piece = Piece {
            speed_mps: time_s.iter().map(|t| speed(*t).clamp(0.0, 10.0)).collect(),
            yaw_rate_radps: vec![0.0; time_s.len()],
            row: (0..time_s.len()).collect(),
            time_s,
        };
        let grid = CurvatureGrid::new(&piece, 0.0, 0.0, 5.0, 15.0, 2.0);
        (piece, grid)
    }

    #[test]
    fn gaps_stops_and_the_slowest_speed_near_a_curve() {
        let (piece, grid) = drive();
        let near = Neighbourhood::new(&piece, &grid);
        // the vehicle stands at 650 m; a curve from 400 to 440 m, another from 100 to 150 m
        let around = near.of([80, 88], Some(30), None);
        assert_eq!(around.gap_before_m, 250.0);
        assert!((around.gap_after_m - (grid.way_m - 440.0)).abs() < 1e-9);
        assert!((around.stop_near_m.unwrap() - 210.0).abs() <= 5.0, "{around:?}");
        assert_eq!(around.slowest_near_mps, 10.0);
        // 150 m behind its end the vehicle stands
        let around = near.of([96, 100], Some(88), Some(120));
        assert_eq!((around.gap_before_m, around.gap_after_m), (40.0, 100.0));
        assert!((around.stop_near_m.unwrap() - 150.0).abs() <= 5.0, "{around:?}");
        assert!(around.slowest_near_mps < 1.0, "{around:?}");
        // a curve behind the standstill, and one in which it stood
        let behind = near.of([150, 160], None, None);
        assert_eq!(behind.gap_before_m, 750.0);
        assert!((behind.stop_near_m.unwrap() - 100.0).abs() <= 5.0, "{behind:?}");
        assert_eq!(near.of([125, 140], None, None).stop_near_m, Some(0.0));
    }

    #[test]
    fn a_vehicle_that_never_stood_has_no_stop_near() {
        let (mut piece, _) = drive();
        piece.speed_mps.fill(10.0);
        let grid = CurvatureGrid::new(&piece, 0.0, 0.0, 5.0, 15.0, 2.0);
        let around = Neighbourhood::new(&piece, &grid).of([80, 88], None, Some(90));
        assert_eq!((around.stop_near_m, around.gap_after_m), (None, 10.0));
    }
}
