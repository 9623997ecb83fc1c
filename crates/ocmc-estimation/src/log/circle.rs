//! The circle that lies closest to some points: the algebraic fit of Taubin (1991), by Newton's
//! method.
//!
//! G. Taubin, "Estimation of planar curves, surfaces and nonplanar space curves defined by implicit
//! equations", IEEE Transactions on Pattern Analysis and Machine Intelligence 13 (1991) 1115-1138.
//! Its radius is hardly biased on short arcs, where the simplest fit (Kåsa) is biased to small
//! radii.

/// Rounds of Newton's method; it takes four or five.
const MOST_ROUNDS: usize = 50;

/// Radius of the circle closest to some points, in their unit; none for fewer than four points, or
/// points on a line.
pub fn fitted_radius(x: &[f64], y: &[f64]) -> Option<f64> {
    let n = x.len() as f64;
    if x.len() < 4 || x.len() != y.len() {
        return None;
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / n;
    let (mean_x, mean_y) = (mean(x), mean(y));
    let (mut xx, mut yy, mut xy, mut xz, mut yz, mut zz) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        let (x, y) = (x - mean_x, y - mean_y);
        let z = x * x + y * y;
        xx += x * x / n;
        yy += y * y / n;
        xy += x * y / n;
        xz += x * z / n;
        yz += y * z / n;
        zz += z * z / n;
    }
    // coefficients of the characteristic polynomial
    let z = xx + yy;
    let determinant = xx * yy - xy * xy;
    let variance = zz - z * z;
    let a3 = 4.0 * z;
    let a2 = -3.0 * z * z - zz;
    let a1 = variance * z + 4.0 * determinant * z - xz * xz - yz * yz;
    let a0 = xz * (xz * yy - yz * xy) + yz * (yz * xx - xz * xy) - variance * determinant;
    let mut root = 0.0;
    for _ in 0..MOST_ROUNDS {
        let value = a0 + root * (a1 + root * (a2 + root * a3));
        let slope = a1 + root * (2.0 * a2 + root * 3.0 * a3);
        let next = root - value / slope;
        if !next.is_finite() || (next - root).abs() <= 1e-12 * next.abs() {
            break;
        }
        root = next;
    }
    let below = 2.0 * (root * root - root * z + determinant);
    let centre_x = (xz * (yy - root) - yz * xy) / below;
    let centre_y = (yz * (xx - root) - xz * xy) / below;
    let radius = (centre_x * centre_x + centre_y * centre_y + z).sqrt();
    radius.is_finite().then_some(radius)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    fn arc(radius: f64, turn: f64, points: usize) -> (Vec<f64>, Vec<f64>) {
        let angle = |k: usize| 0.3 + turn * k as f64 / (points - 1) as f64;
        (0..points).map(|k| (700.0 + radius * angle(k).cos(), radius * angle(k).sin())).unzip()
    }

    #[test]
    fn exact_points_give_the_exact_radius() {
        for (radius, turn, points) in [(20.0, 1.5, 4), (150.0, 0.3, 6), (500.0, 0.1, 30)] {
            let (x, y) = arc(radius, turn, points);
            let fitted = fitted_radius(&x, &y).unwrap();
            assert!((fitted / radius - 1.0).abs() < 1e-6, "{fitted}");
        }
    }

    #[test]
    fn noise_biases_little() {
        let mut draws = Draws::new(1, 0, Stream::Vehicle);
        let mut sum = 0.0;
        for _ in 0..400 {
            let (mut x, mut y) = arc(100.0, 0.6, 15);
            for value in x.iter_mut().chain(&mut y) {
                *value += 0.3 * draws.normal();
            }
            sum += libm::log(fitted_radius(&x, &y).unwrap() / 100.0);
        }
        assert!((sum / 400.0).abs() < 0.02, "{}", sum / 400.0);
    }

    #[test]
    fn no_circle_through_a_line_or_three_points() {
        let x: Vec<f64> = (0..9).map(f64::from).collect();
        assert_eq!(fitted_radius(&x, &[0.0; 9]), None);
        assert_eq!(fitted_radius(&x[..3], &x[..3]), None);
    }
}
