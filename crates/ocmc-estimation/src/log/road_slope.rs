//! Altitude over the way of a log, and the ways on which nothing determines it.
//!
//! A receiver's altitude wanders, most of all while the vehicle stands, and jumps as it finds or
//! loses satellites. So rows at one place are one altitude, their mean: a standstill has no slope.
//! What changes between two rows by more than the steepest road and six SDs of their noise is a
//! jump, which tells no slope: it is taken out of all that follows. The altitude is averaged by a
//! straight line over a length around each place, which at the ends lies as far inside as it has
//! to; what is still steeper than the steepest road is taken as steep as that, and counted.

use ocmc_core::operating_cycle::road::route_geometry::interpolate;
use ocmc_core::operating_cycle::road::route_noise::noise_of_values;

/// Ways without slope or altitude up to this length are bridged evenly, in m (judgement: altitudes
/// are averaged over as much).
const LONGEST_BRIDGE_M: f64 = 200.0;
/// Step on which altitudes are averaged, in m.
const ALTITUDE_STEP_M: f64 = 5.0;

/// Rows that are closer along the way are at one place, in m (judgement: a receiver's speed at rest
/// is not quite 0).
const ONE_PLACE_M: f64 = 1.0;
/// Steepest road that altitudes tell, as climb per metre (judgement: few public roads are steeper,
/// and what looks steeper is a receiver's error more often than a road).
const STEEPEST: f64 = 0.1;
/// SDs of the noise between two places, by which their altitudes may differ beyond that.
const NOISE_SDS: f64 = 6.0;
/// Fewest places whose altitudes tell their noise.
const FEWEST_PLACES: usize = 40;
/// Way and time over which altitudes become one measurement, in m and s: a log of 10 Hz has no more
/// of them than one of 1 Hz.
const MEASURED_OVER: (f64, f64) = (10.0, 10.0);

/// An altitude as it was measured: the mean of some rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredAltitude {
    /// Mean place of the rows, in m.
    pub position_m: f64,
    /// Mean time, in s.
    pub time_s: f64,
    /// Mean altitude, in m.
    pub altitude_m: f64,
    /// Number of rows.
    pub rows: usize,
}

impl MeasuredAltitude {
    /// The mean of rows of place, time and altitude; one at least.
    fn of(rows: &[[f64; 3]]) -> Self {
        let n = rows.len() as f64;
        let mean = |k: usize| rows.iter().map(|row| row[k]).sum::<f64>() / n;
        Self { position_m: mean(0), time_s: mean(1), altitude_m: mean(2), rows: rows.len() }
    }
}

/// The altitudes that were measured along a way, row by row or over [`MEASURED_OVER`], without
/// jumps, in order.
pub(super) fn measured(way_m: &[f64], time_s: &[f64], altitude_m: &[f64]) -> Vec<MeasuredAltitude> {
    let (_, rows) = without_jumps(way_m, time_s, altitude_m);
    let apart = |first: &[f64; 3], row: &[f64; 3]| {
        row[0] - first[0] >= MEASURED_OVER.0 || row[1] - first[1] >= MEASURED_OVER.1
    };
    groups(&rows, apart).map(MeasuredAltitude::of).collect()
}

/// Runs of rows: each begins where a row is apart from the first of the run.
fn groups(
    rows: &[[f64; 3]],
    apart: impl Fn(&[f64; 3], &[f64; 3]) -> bool,
) -> impl Iterator<Item = &[[f64; 3]]> {
    let mut rest = rows;
    std::iter::from_fn(move || {
        let first = rest.first()?;
        let end = rest.iter().position(|row| apart(first, row)).unwrap_or(rest.len());
        let (group, behind) = rest.split_at(end);
        rest = behind;
        Some(group)
    })
}

/// The rows that tell an altitude, as place, time and altitude, without jumps; and what these were
/// together, in m.
fn without_jumps(way_m: &[f64], time_s: &[f64], altitude_m: &[f64]) -> (f64, Vec<[f64; 3]>) {
    let all = way_m.iter().zip(time_s).zip(altitude_m).map(|((x, t), z)| [*x, *t, *z]);
    let mut rows: Vec<[f64; 3]> = all.filter(|row| row[2].is_finite()).collect();
    let apart = |first: &[f64; 3], row: &[f64; 3]| row[0] - first[0] >= ONE_PLACE_M;
    let places: Vec<f64> = groups(&rows, apart).map(|group| group[0][2]).collect();
    let allowed_m = match places.len() {
        0..FEWEST_PLACES => f64::INFINITY,
        _ => NOISE_SDS * std::f64::consts::SQRT_2 * noise_of_values(&places),
    };
    let (mut shift_m, mut jumps_m) = (0.0, 0.0);
    // the altitude before, as it was measured
    let mut before: Option<[f64; 2]> = None;
    for row in &mut rows {
        let [at_m, _, measured_m] = *row;
        if let Some([before_m, before_altitude_m]) = before {
            let change_m = measured_m - before_altitude_m;
            let most_m = allowed_m + STEEPEST * (at_m - before_m).max(ONE_PLACE_M);
            if change_m.abs() > most_m {
                shift_m += change_m;
                jumps_m += change_m.abs();
            }
        }
        before = Some([at_m, measured_m]);
        row[2] -= shift_m;
    }
    (jumps_m, rows)
}

/// Altitude as the rows of a road determine it.
pub(super) struct Climb {
    /// Altitude over position, both in m.
    pub altitude: Vec<(f64, f64)>,
    /// Ways on which it is not known: from and to, in m.
    pub unobserved_m: Vec<[f64; 2]>,
    /// Rows that do not determine it.
    pub missing: usize,
    /// Altitude that was taken out as jumps of the receiver, or steeper than any road, in m.
    pub jumps_m: f64,
}

impl Climb {
    /// For a road of which no row determines anything.
    pub(super) fn unobserved(way_m: &[f64]) -> Self {
        let length_m = way_m.last().copied().unwrap_or(0.0);
        let missing = way_m.len();
        Self {
            altitude: vec![(0.0, 0.0)],
            unobserved_m: vec![[0.0, length_m]],
            missing,
            jumps_m: 0.0,
        }
    }

    /// From slopes, each on the way from the row before.
    pub(super) fn of_grades(way_m: &[f64], grade: &[f64]) -> Self {
        let mut climb = Self::of_nothing(vec![(0.0, 0.0)]);
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
    pub(super) fn of_altitudes(
        way_m: &[f64],
        time_s: &[f64],
        altitude_m: &[f64],
        average_m: f64,
    ) -> Self {
        let mut climb = Self::of_nothing(vec![]);
        climb.missing = altitude_m.iter().filter(|altitude_m| !altitude_m.is_finite()).count();
        let (jumps_m, rows) = without_jumps(way_m, time_s, altitude_m);
        climb.jumps_m = jumps_m;
        let apart = |first: &[f64; 3], row: &[f64; 3]| row[0] - first[0] >= ONE_PLACE_M;
        let mut piece: Vec<(f64, f64)> = Vec::new();
        let mut known_to = None;
        for place in groups(&rows, apart) {
            let MeasuredAltitude { position_m, altitude_m, .. } = MeasuredAltitude::of(place);
            if climb.leave_out(known_to, place[0][0]) {
                climb.add(std::mem::take(&mut piece), average_m);
            }
            piece.push((position_m, altitude_m));
            known_to = Some(place[place.len() - 1][0]);
        }
        climb.add(piece, average_m);
        // behind the last altitude nothing shows where the road goes
        if let (Some(last_m), Some(&length_m)) = (known_to, way_m.last())
            && length_m > last_m
        {
            climb.unobserved_m.push([last_m, length_m]);
        }
        climb
    }

    /// A climb of an altitude with nothing left out of it.
    fn of_nothing(altitude: Vec<(f64, f64)>) -> Self {
        Self { altitude, unobserved_m: vec![], missing: 0, jumps_m: 0.0 }
    }

    /// Adds altitudes, averaged over a length, none of them steeper than a road.
    fn add(&mut self, points: Vec<(f64, f64)>, average_m: f64) {
        let mut shift_m = 0.0;
        let mut before: Option<(f64, f64)> = None;
        for (at_m, altitude_m) in averaged(points, average_m) {
            if let Some((before_m, before_altitude_m)) = before {
                let most_m = STEEPEST * (at_m - before_m);
                let change_m = altitude_m - before_altitude_m;
                let excess_m = change_m - change_m.clamp(-most_m, most_m);
                shift_m += excess_m;
                self.jumps_m += excess_m.abs();
            }
            before = Some((at_m, altitude_m));
            self.altitude.push((at_m, altitude_m - shift_m));
        }
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

/// Altitudes averaged over a length, on an even step, by the line of least squares around each
/// place; the same where there is no length.
fn averaged(points: Vec<(f64, f64)>, length_m: f64) -> Vec<(f64, f64)> {
    if length_m <= 0.0 || points.len() < 2 {
        return points;
    }
    let (x, z): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
    let steps = libm::ceil((x[x.len() - 1] - x[0]) / ALTITUDE_STEP_M) as usize;
    let at = |k: usize| x[0] + k as f64 * ALTITUDE_STEP_M;
    let even: Vec<f64> = (0..=steps).map(|k| interpolate(&x, &z, at(k))).collect();
    let half = libm::round(0.5 * length_m / ALTITUDE_STEP_M) as usize;
    // sums up to each place, of the values and of the values times their numbers
    let mut sums = vec![[0.0; 2]];
    for (k, value) in even.iter().enumerate() {
        let [sum, moment] = sums[k];
        sums.push([sum + value, moment + k as f64 * value]);
    }
    let width = (2 * half + 1).min(even.len());
    let line = |k: usize| {
        let first = k.saturating_sub(half).min(even.len() - width);
        let window_sum = |j: usize| sums[first + width][j] - sums[first][j];
        let (n, mean) = (width as f64, window_sum(0) / width as f64);
        let middle = first as f64 + 0.5 * (n - 1.0);
        let spread = n * (n * n - 1.0) / 12.0;
        let slope = if width > 1 { (window_sum(1) - middle * window_sum(0)) / spread } else { 0.0 };
        mean + slope * (k as f64 - middle)
    };
    (0..even.len()).map(|k| (at(k), line(k))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_row_tells_is_left_out_and_short_ways_are_bridged() {
        let way_m: Vec<f64> = (0..=200).map(|k| 10.0 * f64::from(k)).collect();
        let time_s = way_m.clone();
        // 3 % up; nothing from 300 to 400 m, nothing from 1000 m on
        let known = |at_m: f64| !(at_m > 300.0 && at_m < 400.0) && at_m <= 1000.0;
        let column = |value: &dyn Fn(f64) -> f64| -> Vec<f64> {
            way_m.iter().map(|at_m| if known(*at_m) { value(*at_m) } else { f64::NAN }).collect()
        };
        for climb in [
            Climb::of_grades(&way_m, &column(&|_| 0.03)),
            Climb::of_altitudes(&way_m, &time_s, &column(&|at_m| 0.03 * at_m), 100.0),
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
        let altitude_at = |at_m: &f64| match *at_m {
            at_m if at_m <= 500.0 => 0.0,
            at_m if at_m >= 1000.0 => 50.0,
            _ => f64::NAN,
        };
        let altitude_m: Vec<f64> = way_m.iter().map(altitude_at).collect();
        let climb = Climb::of_altitudes(&way_m, &way_m, &altitude_m, 200.0);
        assert_eq!(climb.unobserved_m, [[500.0, 1000.0]]);
        assert!(climb.altitude.iter().all(|point| point.1 == altitude_at(&point.0)));
        // what comes before the first value is not known either
        let late = Climb::of_grades(&[0.0, 10.0, 20.0], &[f64::NAN, f64::NAN, 0.01]);
        assert_eq!((late.unobserved_m, late.missing), (vec![[0.0, 10.0]], 1));
    }

    #[test]
    fn a_receiver_that_wanders_at_rest_and_jumps_makes_no_hill() {
        // flat; at 600 m the vehicle creeps over half a metre for a minute, in which the altitude
        // rises by 3 m, and at 1400 m it jumps by 45 m
        let (mut rows, mut drift_m) = (Vec::new(), 0.0);
        for k in 0..100 {
            let at_m = 20.0 * f64::from(k);
            let jump_m = if at_m >= 1400.0 { 45.0 } else { 0.0 };
            rows.push((at_m, jump_m + drift_m));
            for creeps in 0..if k == 30 { 60 } else { 0 } {
                drift_m += 0.05;
                rows.push((at_m + 0.008 * f64::from(creeps), drift_m));
            }
        }
        let (way_m, altitude_m): (Vec<f64>, Vec<f64>) = rows.into_iter().unzip();
        let time_s: Vec<f64> = (0..way_m.len()).map(|k| k as f64).collect();
        let climb = Climb::of_altitudes(&way_m, &time_s, &altitude_m, 200.0);
        assert_eq!(climb.jumps_m, 45.0);
        let steepest = climb.altitude.windows(2).map(|pair| {
            let ((from_m, low_m), (to_m, high_m)) = (pair[0], pair[1]);
            ((high_m - low_m) / (to_m - from_m)).abs()
        });
        // 3 m over the length of the average
        let steepest = steepest.fold(0.0, f64::max);
        assert!(steepest > 0.005 && steepest < 0.02, "{steepest}");
        // a minute at one place is a few measurements, of all its rows
        let measured = measured(&way_m, &time_s, &altitude_m);
        let at_rest: Vec<_> =
            measured.iter().filter(|point| (599.0..601.0).contains(&point.position_m)).collect();
        assert!((6..=8).contains(&at_rest.len()), "{at_rest:?}");
        assert_eq!(measured.iter().map(|point| point.rows).sum::<usize>(), way_m.len());
    }

    #[test]
    fn an_average_at_the_ends_of_a_road_is_as_long_as_elsewhere() {
        // noise at the first row alone: its slope is that of the line over 200 m, not of two rows
        let way_m: Vec<f64> = (0..100).map(|k| 20.0 * f64::from(k)).collect();
        let altitude_m: Vec<f64> =
            way_m.iter().map(|at_m| if *at_m == 0.0 { 1.5 } else { 0.02 * at_m }).collect();
        let climb = Climb::of_altitudes(&way_m, &way_m, &altitude_m, 200.0);
        let slope = (climb.altitude[1].1 - climb.altitude[0].1) / 5.0;
        assert!((slope - 0.02).abs() < 0.004, "{slope}");
    }
}
