//! One cell of a map over speed and torque, multiplied out for the hot loop.

/// {a, b, c, d} of a + b w + T (c + d w) in a cell between two speeds w and two torques T.
/// `corners`: a row for each speed.
pub(super) fn bilinear_cell(
    [w0, w1]: [f64; 2],
    [t0, t1]: [f64; 2],
    corners: [[f64; 2]; 2],
) -> [f64; 4] {
    let [[f00, f01], [f10, f11]] = corners;
    let area = (w1 - w0) * (t1 - t0);
    let d = (f00 - f01 - f10 + f11) / area;
    let b = (f10 - f00) / (w1 - w0) - d * t0;
    let c = (f01 - f00) / (t1 - t0) - d * w0;
    let a = f00 - b * w0 - c * t0 - d * w0 * t0;
    [a, b, c, d]
}
