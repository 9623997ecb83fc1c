//! A map over speed and torque in cells, multiplied out for the hot loop.

use super::engine::MOST_KNOTS;

/// {a, b, c, d} of a + b w + T (c + d w) in each cell between two speeds w and two torques T, in
/// rows of `MOST_KNOTS`.
pub(super) type Cells = Box<[[f64; 4]; MOST_KNOTS * MOST_KNOTS]>;

/// The cells of a map with a row for each speed and a column for each torque.
pub(super) fn cells(speeds: &[f64], torques: &[f64], map: &[Vec<f64>]) -> Cells {
    let mut cells = Box::new([[0.0; 4]; MOST_KNOTS * MOST_KNOTS]);
    for (i, w) in speeds.windows(2).enumerate() {
        for (j, t) in torques.windows(2).enumerate() {
            let (f00, f01) = (map[i][j], map[i][j + 1]);
            let (f10, f11) = (map[i + 1][j], map[i + 1][j + 1]);
            let area = (w[1] - w[0]) * (t[1] - t[0]);
            let d = (f00 - f01 - f10 + f11) / area;
            let b = (f10 - f00) / (w[1] - w[0]) - d * t[0];
            let c = (f01 - f00) / (t[1] - t[0]) - d * w[0];
            let a = f00 - b * w[0] - c * t[0] - d * w[0] * t[0];
            cells[i * MOST_KNOTS + j] = [a, b, c, d];
        }
    }
    cells
}
