//! Speed limits that a drive may have been subject to, from its speed alone.
//!
//! The limit at a place is the largest speed within 500 m of it, on its way, rounded up to a
//! multiple of 10 km/h. All of it is judgement, for logs that have no column of limits: a drive
//! shows how fast it was driven, not how fast it might have been. What is compared with limits from
//! the same drive goes round in a circle.

use super::signal::LIMITS_MPS;

/// How far a speed reaches, in m.
const REACH_M: f64 = 500.0;
/// Step of limits, in m/s: 10 km/h.
const STEP_MPS: f64 = 10.0 / 3.6;
/// Excess of a speed over a limit at which it still counts as driven at it, in m/s: half a km/h.
const ABOVE_MPS: f64 = 0.5 / 3.6;

/// A limit for each row, in m/s; NaN where time or speed are missing. Without a row that has both
/// there is no limit.
pub fn limits_of_speed(time_s: &[f64], speed_mps: &[f64]) -> Vec<f64> {
    let known = |k: &usize| time_s[*k].is_finite() && speed_mps[*k].is_finite();
    let rows: Vec<usize> = (0..time_s.len().min(speed_mps.len())).filter(known).collect();
    let mut way_m = Vec::with_capacity(rows.len());
    let mut at_m = 0.0;
    for (k, &row) in rows.iter().enumerate() {
        if k > 0 {
            let before = rows[k - 1];
            let mean_mps = 0.5 * (speed_mps[before].max(0.0) + speed_mps[row].max(0.0));
            at_m += mean_mps * (time_s[row] - time_s[before]).max(0.0);
        }
        way_m.push(at_m);
    }
    let mut limits = vec![f64::NAN; time_s.len()];
    // rows whose speed is the largest up to the end of the window, the largest first
    let mut largest = std::collections::VecDeque::new();
    let mut ahead = 0;
    for k in 0..rows.len() {
        while ahead < rows.len() && way_m[ahead] <= way_m[k] + REACH_M {
            let speed = speed_mps[rows[ahead]];
            while largest.back().is_some_and(|last| speed_mps[rows[*last]] <= speed) {
                largest.pop_back();
            }
            largest.push_back(ahead);
            ahead += 1;
        }
        while largest.front().is_some_and(|first| way_m[*first] < way_m[k] - REACH_M) {
            largest.pop_front();
        }
        let fastest_mps = largest.front().map_or(0.0, |first| speed_mps[rows[*first]]);
        let steps = libm::ceil((fastest_mps - ABOVE_MPS) / STEP_MPS).max(1.0);
        limits[rows[k]] = (steps * STEP_MPS).clamp(LIMITS_MPS[0], LIMITS_MPS[1]);
    }
    limits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_above_what_is_driven_within_its_reach() {
        // 48 km/h over 4 km, 88 km/h over 4 km, at 1 Hz
        let (slow, fast) = (48.0 / 3.6, 88.0 / 3.6);
        let speed: Vec<f64> = (0..463).map(|k| if k < 300 { slow } else { fast }).collect();
        let mut time: Vec<f64> = (0..463).map(f64::from).collect();
        time[7] = f64::NAN;
        let limits = limits_of_speed(&time, &speed);
        let kmh = |k: usize| libm::round(3.6 * limits[k] * 10.0) / 10.0;
        assert!(limits[7].is_nan());
        // 300 s at 48 km/h are 4 km: the faster road reaches 37 s back
        assert_eq!([kmh(0), kmh(250), kmh(280), kmh(462)], [50.0, 50.0, 90.0, 90.0]);
        assert!(limits_of_speed(&[f64::NAN; 3], &[1.0; 3]).iter().all(|limit| limit.is_nan()));
        assert!(limits_of_speed(&[], &[]).is_empty());
        // what is too fast or in reverse still gives a limit that a road may have
        let hostile = limits_of_speed(&[0.0, 1.0, 0.5], &[1e9, -4.0, f64::INFINITY]);
        assert!(hostile.iter().all(|v| v.is_nan() || (LIMITS_MPS[0]..=LIMITS_MPS[1]).contains(v)));
    }
}
