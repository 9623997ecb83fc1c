//! Curves in a curvature signal by thresholds with hysteresis (the guide's page on curve
//! detection).

/// Grid of the signal, in m.
pub(crate) const STEP_M: f64 = 5.0;
/// A curve begins above the first and ends below the second curvature, in 1/m.
const ENTER_PER_M: f64 = 1.0 / 700.0;
const LEAVE_PER_M: f64 = 1.0 / 1000.0;
/// Curves of one direction with a shorter gap are one, in m.
const LARGEST_GAP_M: f64 = 10.0;
/// Shorter curves, and those that turn less, are dropped.
const SHORTEST_M: f64 = 15.0;
const SMALLEST_TURN_RAD: f64 = 8.0 * std::f64::consts::PI / 180.0;

/// A curve that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DetectedCurve {
    /// First step.
    pub(crate) first: usize,
    /// Step behind the last.
    pub(crate) end: usize,
    /// 1 / mean |κ| of the middle third, in m.
    pub(crate) radius_m: f64,
    /// 1 / mean |κ| of the whole curve, in m.
    pub(crate) whole_radius_m: f64,
}

impl DetectedCurve {
    /// Step in the middle.
    pub(crate) fn middle(&self) -> usize {
        usize::midpoint(self.first, self.end)
    }
}

/// The curves of a curvature signal, in 1/m, on steps of [`STEP_M`].
pub(crate) fn detect(curvature: &[f64]) -> Vec<DetectedCurve> {
    let mut found: Vec<(usize, usize, bool)> = Vec::new();
    let mut k = 0;
    while k < curvature.len() {
        if curvature[k].abs() <= ENTER_PER_M {
            k += 1;
            continue;
        }
        let left = curvature[k] > 0.0;
        let inside = |i: usize| (curvature[i] > 0.0) == left && curvature[i].abs() >= LEAVE_PER_M;
        let before = found.last().map_or(0, |last| last.1);
        let mut first = k;
        while first > before && inside(first - 1) {
            first -= 1;
        }
        let mut end = k + 1;
        while end < curvature.len() && inside(end) {
            end += 1;
        }
        match found.last_mut() {
            Some(last) if last.2 == left && ((first - last.1) as f64) * STEP_M < LARGEST_GAP_M => {
                last.1 = end;
            }
            _ => found.push((first, end, left)),
        }
        k = end;
    }
    found.into_iter().filter_map(|(first, end, _)| measure(curvature, first, end)).collect()
}

/// The curve of some steps, unless it is too short or turns too little.
fn measure(curvature: &[f64], first: usize, end: usize) -> Option<DetectedCurve> {
    let steps = end - first;
    let turn = curvature[first..end].iter().sum::<f64>().abs() * STEP_M;
    if (steps as f64) * STEP_M < SHORTEST_M || turn < SMALLEST_TURN_RAD {
        return None;
    }
    let radius = |part: &[f64]| part.len() as f64 / part.iter().map(|k| k.abs()).sum::<f64>();
    Some(DetectedCurve {
        first,
        end,
        radius_m: radius(&curvature[first + steps / 3..end - steps / 3]),
        whole_radius_m: radius(&curvature[first..end]),
    })
}

/// Curvature of a path given every [`STEP_M`], smoothed: positions are averaged over `2 half + 1`
/// points first, because a map's roads turn at their points only. The ends, where the average is
/// lopsided, count as straight.
pub(crate) fn curvature(x: &[f64], y: &[f64], half: usize) -> Vec<f64> {
    let mut curvature = vec![0.0; x.len()];
    let (x, y) = (smooth(x, half), smooth(y, half));
    for k in half + 1..x.len().saturating_sub(half + 1) {
        let (ax, ay) = (x[k] - x[k - 1], y[k] - y[k - 1]);
        let (bx, by) = (x[k + 1] - x[k], y[k + 1] - y[k]);
        let turn = (ax * by - ay * bx).atan2(ax * bx + ay * by);
        let step_m = 0.5 * (ax.hypot(ay) + bx.hypot(by));
        // opposite ends of a hairpin may meet
        curvature[k] = if step_m > 0.0 { turn / step_m } else { 0.0 };
    }
    curvature
}

/// Moving average over `2 half + 1` values, shorter at the ends.
fn smooth(values: &[f64], half: usize) -> Vec<f64> {
    (0..values.len())
        .map(|k| {
            let window = &values[k.saturating_sub(half)..(k + half + 1).min(values.len())];
            window.iter().sum::<f64>() / window.len() as f64
        })
        .collect()
}

#[test]
fn finds_a_curve_and_its_radius() {
    let mut curvature = vec![0.0; 200];
    curvature[50..70].fill(0.01);
    curvature[100..104].fill(-0.001_6); // 20 m at 625 m: turns 1.8 degrees, dropped
    curvature[150..152].fill(0.05); // 10 m: too short
    let found = detect(&curvature);
    assert_eq!(found.len(), 1);
    assert!((found[0].radius_m - 100.0).abs() < 1e-9);
    assert_eq!((found[0].first, found[0].end, found[0].middle()), (50, 70, 60));
}
