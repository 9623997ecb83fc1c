//! Altitude over the way of a log, and the ways on which nothing determines it.

use ocmc_core::operating_cycle::road::route_geometry::interpolate;

/// Ways without slope or altitude up to this length are bridged evenly, in m (judgement: altitudes
/// are averaged over as much).
const LONGEST_BRIDGE_M: f64 = 200.0;
/// Step on which altitudes are averaged, in m.
const ALTITUDE_STEP_M: f64 = 5.0;

/// What the rows of a road determine of its altitude.
pub(super) struct Climb {
    /// Altitude over position, both in m.
    pub altitude: Vec<(f64, f64)>,
    /// Ways on which it is not known: from and to, in m.
    pub unobserved_m: Vec<[f64; 2]>,
    /// Rows that do not determine it.
    pub missing: usize,
}

impl Climb {
    /// For a road of which no row determines anything.
    pub(super) fn unobserved(way_m: &[f64]) -> Self {
        let length_m = way_m.last().copied().unwrap_or(0.0);
        let missing = way_m.len();
        Self { altitude: vec![(0.0, 0.0)], unobserved_m: vec![[0.0, length_m]], missing }
    }

    /// From slopes, each on the way from the row before.
    pub(super) fn of_grades(way_m: &[f64], grade: &[f64]) -> Self {
        let mut climb = Self { altitude: vec![(0.0, 0.0)], unobserved_m: vec![], missing: 0 };
        let (mut altitude_m, mut slope) = (0.0, 0.0);
        // where the last slope was known
        let mut known_to = None;
        for k in 1..way_m.len() {
            if grade[k].is_finite() {
                climb.leave_out(known_to, way_m[k - 1]);
                (slope, known_to) = (grade[k], Some(way_m[k]));
            } else {
                climb.missing += 1;
            }
            altitude_m += slope * (way_m[k] - way_m[k - 1]);
            if way_m[k] > climb.altitude[climb.altitude.len() - 1].0 {
                climb.altitude.push((way_m[k], altitude_m));
            }
        }
        climb.leave_out(known_to, way_m.last().copied().unwrap_or(0.0));
        climb
    }

    /// From altitudes, averaged over a length; not across what is not known.
    pub(super) fn of_altitudes(way_m: &[f64], altitude_m: &[f64], average_m: f64) -> Self {
        let mut climb = Self { altitude: vec![], unobserved_m: vec![], missing: 0 };
        let mut piece: Vec<(f64, f64)> = Vec::new();
        for (&at_m, &altitude_m) in way_m.iter().zip(altitude_m) {
            let last_m = piece.last().map(|last| last.0);
            if !altitude_m.is_finite() {
                climb.missing += 1;
            } else if last_m.is_none_or(|last_m| at_m > last_m) {
                if climb.leave_out(last_m, at_m) {
                    climb.altitude.extend(averaged(std::mem::take(&mut piece), average_m));
                }
                piece.push((at_m, altitude_m));
            }
        }
        let (last_m, length_m) = (piece.last().map(|last| last.0), way_m.last().copied());
        climb.altitude.extend(averaged(piece, average_m));
        // behind the last altitude nothing shows where the road goes
        if let (Some(last_m), Some(length_m)) = (last_m, length_m)
            && length_m > last_m
        {
            climb.unobserved_m.push([last_m, length_m]);
        }
        climb
    }

    /// Leaves out what lies between two places where something is known, if it is too long; whether
    /// it was.
    fn leave_out(&mut self, known_to: Option<f64>, known_from_m: f64) -> bool {
        let (from_m, bridge_m) = known_to.map_or((0.0, 0.0), |to_m| (to_m, LONGEST_BRIDGE_M));
        let long = known_from_m - from_m > bridge_m;
        if long {
            self.unobserved_m.push([from_m, known_from_m]);
        }
        long
    }
}

/// Altitudes averaged over a length, on an even step; the same where there is no length.
fn averaged(points: Vec<(f64, f64)>, length_m: f64) -> Vec<(f64, f64)> {
    if length_m <= 0.0 || points.len() < 2 {
        return points;
    }
    let (x, z): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
    let steps = libm::ceil((x[x.len() - 1] - x[0]) / ALTITUDE_STEP_M) as usize;
    let at = |k: usize| x[0] + k as f64 * ALTITUDE_STEP_M;
    let even: Vec<f64> = (0..=steps).map(|k| interpolate(&x, &z, at(k))).collect();
    let half = libm::round(0.5 * length_m / ALTITUDE_STEP_M) as usize;
    let mut sums = vec![0.0];
    for value in &even {
        sums.push(sums[sums.len() - 1] + value);
    }
    (0..even.len())
        .map(|k| {
            // as far to one side as to the other
            let reach = half.min(k).min(even.len() - 1 - k);
            let sum = sums[k + reach + 1] - sums[k - reach];
            (at(k), sum / (2 * reach + 1) as f64)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_row_tells_is_left_out_and_short_ways_are_bridged() {
        let way_m: Vec<f64> = (0..=200).map(|k| 10.0 * f64::from(k)).collect();
        // 3 % up; nothing from 300 to 400 m, nothing from 1000 m on
        let known = |at_m: f64| !(at_m > 300.0 && at_m < 400.0) && at_m <= 1000.0;
        let column = |value: &dyn Fn(f64) -> f64| -> Vec<f64> {
            way_m.iter().map(|at_m| if known(*at_m) { value(*at_m) } else { f64::NAN }).collect()
        };
        for climb in [
            Climb::of_grades(&way_m, &column(&|_| 0.03)),
            Climb::of_altitudes(&way_m, &column(&|at_m| 0.03 * at_m), 100.0),
        ] {
            assert_eq!(climb.unobserved_m, [[1000.0, 2000.0]]);
            assert_eq!(climb.missing, 9 + 100);
            let known = climb.altitude.iter().filter(|point| point.0 <= 1000.0);
            for (at_m, altitude_m) in known {
                assert!((altitude_m - 0.03 * at_m).abs() < 1e-9, "{at_m}: {altitude_m}");
            }
        }
    }

    #[test]
    fn averages_do_not_reach_across_what_is_not_known() {
        // flat at 0 m, nothing over 500 m, flat at 50 m
        let way_m: Vec<f64> = (0..=300).map(|k| 5.0 * f64::from(k)).collect();
        let of = |at_m: &f64| match *at_m {
            at_m if at_m <= 500.0 => 0.0,
            at_m if at_m >= 1000.0 => 50.0,
            _ => f64::NAN,
        };
        let altitude_m: Vec<f64> = way_m.iter().map(of).collect();
        let climb = Climb::of_altitudes(&way_m, &altitude_m, 200.0);
        assert_eq!(climb.unobserved_m, [[500.0, 1000.0]]);
        assert!(climb.altitude.iter().all(|point| point.1 == of(&point.0)));
        // what comes before the first value is not known either
        let late = Climb::of_grades(&[0.0, 10.0, 20.0], &[f64::NAN, f64::NAN, 0.01]);
        assert_eq!((late.unobserved_m, late.missing), (vec![[0.0, 10.0]], 1));
    }
}
