//! Whether the points of a road are close enough for its curves.
//!
//! Two figures tell it, both as the consumption that hangs on them. Halves: the road of every
//! second point, and of certain corners, has other curves than that of all where the points are too
//! few; below the 45 m over which curvature is averaged, the error falls with the square of the
//! spacing, and what remains is a third. Rounding: between points that are far apart a bend may be
//! sharper, or as wide as the points allow ([`Rounding`]). The consumption is stood for by what is
//! braked away ahead of curves, by an even speed-up and slow-down on a flat road, over the work
//! against rolling and air.
//!
//! The bounds are those at which of 680 answers on random roads 3 are more than 2 % off without a
//! warning, and of the 344 that are less than 0.5 % off 36 have one (`scripts/thinned_roads.py`).

use super::Finding;
use crate::number_text::{count_of, rounded};
use ocmc_core::operating_cycle::road::route_fillet::{
    Rounding, corners, rounded as rounded_points, turns,
};
use ocmc_core::operating_cycle::road::route_geometry::Path2d;

/// Consumption that hangs on what is not known of curves, from which on a route is warned of.
const DOUBT: f64 = 0.02;
/// Edges from which on a road is hardly straight, in m (judgement).
const BEELINE_M: f64 = 3000.0;
/// Share of the way in such edges from which on is warned.
const BEELINE_SHARE: f64 = 0.1;
/// Mean edge from which on a way that turns is no road, in m (judgement).
const NO_ROAD_M: f64 = 5000.0;
/// Turn in all from which on it does, in rad.
const TURNING_RAD: f64 = 0.1;
/// Mean edge from which on curves show in nothing where a road turns, in m (judgement).
const HIDING_M: f64 = 1200.0;
/// Longest road whose points are spread and judged, in m.
pub(crate) const LONGEST_M: f64 = 5e6;
/// Spacing below which no answer changes, in m.
const DENSE_M: f64 = 8.0;
/// Spacing where a road turns from which on its points tell no curve, in m (judgement: the curves
/// of the studies' roads are 40 to 350 m long).
const TELLING_M: f64 = 200.0;
/// Length over which curvature is averaged, in m.
const AVERAGED_M: f64 = 45.0;
/// Share of the difference of halves that remains where points are close.
const SQUARE: f64 = 1.0 / 3.0;
/// Steps of the speed, in m.
const STEP_M: f64 = 5.0;
/// Lateral acceleration in curves, and the rates of speed-up and slow-down, in m/s² (judgement).
const LATERAL_MPS2: f64 = 2.0;
const SPEED_UP_MPS2: f64 = 0.3;
const SLOW_DOWN_MPS2: f64 = 0.6;
/// Slowest speed in a curve, in m/s.
const SLOWEST_MPS: f64 = 3.0;
/// Work against rolling and air, in J per kg and m.
const WORK_J_PER_KG_M: f64 = 0.1;

/// Gaps between the points of a road, and the corrections for them. `limit_mps` holds from each
/// point on, `odometer_m` are the places of the points where they are measured.
pub fn sparse_points(path: &Path2d, odometer_m: Option<&[f64]>, limit_mps: &[f64]) -> Vec<Finding> {
    let (x_m, y_m) = path.points_m();
    let (turns, edges_m) = turns(x_m, y_m);
    let length_m: f64 = edges_m.iter().sum();
    let mut findings: Vec<Finding> = beelines(&turns, &edges_m, length_m).into_iter().collect();
    let measured_m = odometer_m.and_then(<[f64]>::last).copied().unwrap_or(length_m);
    if findings.iter().any(Finding::is_refusal) || length_m.max(measured_m) > LONGEST_M {
        return findings;
    }
    let road = Road { path, odometer_m, limit_mps, length_m };
    let spacing_m = spacing_m(&turns, &edges_m).unwrap_or(0.0);
    if spacing_m < DENSE_M {
        return findings;
    }
    let doubt = road.doubt(spacing_m, &corners(&turns, &edges_m));
    if doubt > DOUBT {
        let text = format!(
            "its points are {} m apart where it turns: how sharp its curves are between them is \
             worth about {} % of the consumption",
            rounded(spacing_m),
            rounded(100.0 * doubt)
        );
        let remedy = "give a point each 10 m in bends, or a column `curvature_per_m`";
        let figures = [100.0 * doubt, 100.0 * DOUBT];
        findings.push(Finding::warned("sparse-points", figures, text, remedy));
    } else if let Some(hidden) = hidden(&turns, &edges_m, length_m) {
        findings.push(hidden);
    } else if let spread @ 1.. = rounded_points(x_m, y_m, Rounding::LIKELY).rounded {
        let text = format!(
            "the turns at {}, farther apart than {AVERAGED_M} m, are spread along the road: its \
             curves lie between its points",
            count_of(spread as u64, "point")
        );
        findings.push(Finding::mended("spread-turns", [spread as f64, 0.0], text));
    }
    findings
}

/// The spacing where it turns, in m; none where it does not.
fn spacing_m(turns: &[f64], edges_m: &[f64]) -> Option<f64> {
    let (mut turned, mut spaced) = (0.0, 0.0);
    for (k, pair) in edges_m.windows(2).enumerate() {
        turned += turns[k + 1].abs();
        spaced += turns[k + 1].abs() * pair[0].min(pair[1]);
    }
    (turned > 0.0).then(|| spaced / turned)
}

/// Whether the points of a way are so far apart that they tell no curve of it.
pub fn tells_no_curves(path: &Path2d) -> bool {
    let (x_m, y_m) = path.points_m();
    let (turns, edges_m) = turns(x_m, y_m);
    let mean_m = edges_m.iter().sum::<f64>() / edges_m.len().max(1) as f64;
    spacing_m(&turns, &edges_m).map_or(mean_m, |spacing_m| spacing_m.min(mean_m)) > TELLING_M
}

/// Finds beelines among points that tell no curve: nothing else is asked of them.
pub fn beeline(path: &Path2d) -> Option<Finding> {
    let (x_m, y_m) = path.points_m();
    let (turns, edges_m) = turns(x_m, y_m);
    beelines(&turns, &edges_m, edges_m.iter().sum())
}

/// Points that are so far apart that a bend between them shows in nothing.
fn hidden(turns: &[f64], edges_m: &[f64], length_m: f64) -> Option<Finding> {
    let mean_m = length_m / edges_m.len().max(1) as f64;
    let turned: f64 = turns.iter().map(|turn| turn.abs()).sum();
    (mean_m > HIDING_M && turned > TURNING_RAD).then(|| {
        let text = format!(
            "its points are {} km apart in the mean, and it turns by {:.0}° in all: curves between \
             them are not seen, and the consumption may be too low",
            rounded(mean_m / 1000.0),
            turned.to_degrees()
        );
        let remedy = "give a point each 10 m in bends, or a column `curvature_per_m`";
        Finding::warned("sparse-points", [mean_m, HIDING_M], text, remedy)
    })
}

/// Points that are so far apart that no road goes straight from one to the next.
fn beelines(turns: &[f64], edges_m: &[f64], length_m: f64) -> Option<Finding> {
    let mean_m = length_m / edges_m.len().max(1) as f64;
    let turned: f64 = turns.iter().map(|turn| turn.abs()).sum();
    let long_m: f64 = edges_m.iter().filter(|edge_m| **edge_m > BEELINE_M).sum();
    let remedy = "give the points of the road itself, as of a map's route or a receiver, or the \
                  way along the road, `position_m`, and have the curves drawn, `--draw curves`";
    if mean_m > NO_ROAD_M && turned > TURNING_RAD {
        let text = format!(
            "its points are {} km apart in the mean, and it turns by {}° in all: beelines, of \
             which neither the length nor the curves are a road's",
            rounded(mean_m / 1000.0),
            rounded(turned.to_degrees())
        );
        return Some(Finding::refused("beeline", [mean_m, NO_ROAD_M], text, remedy));
    }
    (long_m > BEELINE_SHARE * length_m).then(|| {
        let longest_m = edges_m.iter().copied().fold(0.0, f64::max);
        let text = format!(
            "{} % of its way goes straight over more than {} km from one point to the next, at \
             most {} km: roads are longer, and have curves",
            rounded(100.0 * long_m / length_m),
            rounded(BEELINE_M / 1000.0),
            rounded(longest_m / 1000.0)
        );
        Finding::warned("beeline", [long_m / length_m, BEELINE_SHARE], text, remedy)
    })
}

struct Road<'a> {
    path: &'a Path2d,
    odometer_m: Option<&'a [f64]>,
    limit_mps: &'a [f64],
    length_m: f64,
}

impl Road<'_> {
    /// Share of the consumption that hangs on what is between the points.
    fn doubt(&self, spacing_m: f64, corners: &[usize]) -> f64 {
        let all: Vec<usize> = (0..self.limit_mps.len()).collect();
        let likely = self.braked(&all, Rounding::LIKELY);
        let work = WORK_J_PER_KG_M * self.length_m + likely;
        let sharp = self.braked(&all, Rounding::SHARP) - likely;
        let wide = self.braked(&all, Rounding::WIDE) - likely;
        let last = all.len() - 1;
        let half = |first: usize| {
            let stays = |k: &usize| {
                *k == 0 || *k == last || k % 2 == first || corners.binary_search(k).is_ok()
            };
            let points: Vec<usize> = (0..=last).filter(stays).collect();
            (self.braked(&points, Rounding::BENDS) - likely).abs()
        };
        let halves = 0.5 * (half(0) + half(1));
        let remaining = (spacing_m / AVERAGED_M).clamp(SQUARE, 1.0);
        (halves * remaining + sharp.abs().max(wide.abs())) / work
    }

    /// Energy per mass braked away ahead of the curves of some points, in J/kg.
    fn braked(&self, points: &[usize], how: Rounding) -> f64 {
        let selected = |values: &[f64]| -> Vec<f64> { points.iter().map(|k| values[*k]).collect() };
        let (x_m, y_m) = self.path.points_m();
        let path = Path2d::of_points(selected(x_m), selected(y_m));
        let odometer_m = self.odometer_m.map(selected);
        let places_m = odometer_m.as_deref().unwrap_or(&path.position_m);
        let (curves, places_m) = match path.rounded(odometer_m.as_deref(), how) {
            Some((road, given_m)) => (road.curves(&road.position_m), given_m),
            None => (path.curves(places_m), places_m.to_vec()),
        };
        let (start_m, end_m) = (places_m[0], places_m[places_m.len() - 1]);
        let count = ((end_m - start_m) / STEP_M) as usize + 2;
        let mut square = Vec::with_capacity(count);
        let mut point = 0;
        for k in 0..count {
            let at_m = start_m + k as f64 * STEP_M;
            while point + 1 < places_m.len() && places_m[point + 1] <= at_m {
                point += 1;
            }
            let limit_mps = self.limit_mps[points[point]];
            square.push(limit_mps * limit_mps);
        }
        for curve in curves {
            let most = (LATERAL_MPS2 * curve.radius_m).max(SLOWEST_MPS * SLOWEST_MPS);
            let [first, last] = [curve.start_m, curve.end_m].map(|at_m| (at_m / STEP_M) as usize);
            for value in square.iter_mut().take(last + 1).skip(first) {
                *value = value.min(most);
            }
        }
        for k in 1..count {
            square[k] = square[k].min(square[k - 1] + 2.0 * SPEED_UP_MPS2 * STEP_M);
        }
        for k in (1..count).rev() {
            square[k - 1] = square[k - 1].min(square[k] + 2.0 * SLOW_DOWN_MPS2 * STEP_M);
        }
        square.windows(2).map(|pair| 0.5 * (pair[0] - pair[1]).max(0.0)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    /// A road of straights and bends with ramps, a point each 5 m, 15 km long.
    fn road(seed: u64, [least_m, most_m]: [f64; 2]) -> (Vec<f64>, Vec<f64>) {
        let mut draws = Draws::new(seed, 0, Stream::Curve);
        let (mut x, mut y, mut heading) = (vec![0.0], vec![0.0], 0.0);
        let mut step = |turn: f64| {
            heading += 0.5 * turn;
            x.push(x[x.len() - 1] + 5.0 * f64::cos(heading));
            y.push(y[y.len() - 1] + 5.0 * f64::sin(heading));
            heading += 0.5 * turn;
        };
        let mut done_m = 0.0;
        while done_m < 15_000.0 {
            let straight = 10 + (100.0 * draws.uniform()) as usize;
            let radius_m = least_m * (most_m / least_m).powf(draws.uniform());
            let turn = 0.2 + 1.2 * draws.uniform();
            let side = if draws.uniform() < 0.5 { -1.0 } else { 1.0 };
            let steps = (radius_m * turn / 5.0) as usize + 6;
            (0..straight).for_each(|_| step(0.0));
            let ramp = steps / 4 + 1;
            let weight = |k: usize| (k + 1).min(steps - k).min(ramp) as f64;
            let all: f64 = (0..steps).map(weight).sum();
            (0..steps).for_each(|k| step(side * turn * weight(k) / all));
            done_m += 5.0 * (straight + steps) as f64;
        }
        (x, y)
    }

    /// The points that stay where none moves by more than a tolerance (Douglas and Peucker).
    fn thinned(x: &[f64], y: &[f64], tolerance_m: f64) -> Vec<usize> {
        let mut keep = vec![0, x.len() - 1];
        let mut parts = vec![(0, x.len() - 1)];
        while let Some((a, b)) = parts.pop() {
            let (dx, dy) = (x[b] - x[a], y[b] - y[a]);
            let length_m = (dx * dx + dy * dy).sqrt().max(1e-9);
            let beside = |k: &usize| ((x[*k] - x[a]) * dy - (y[*k] - y[a]) * dx).abs() / length_m;
            let farthest = (a + 1..b).max_by(|j, k| beside(j).total_cmp(&beside(k)));
            if let Some(k) = farthest.filter(|k| beside(k) > tolerance_m) {
                keep.push(k);
                parts.extend([(a, k), (k, b)]);
            }
        }
        keep.sort_unstable();
        keep
    }

    fn spaced(x: &[f64], metres: usize) -> Vec<usize> {
        (0..x.len()).step_by(metres / 5).collect()
    }

    fn findings((x, y): &(Vec<f64>, Vec<f64>), points: &[usize]) -> Vec<Finding> {
        let selected = |values: &[f64]| -> Vec<f64> { points.iter().map(|k| values[*k]).collect() };
        let path = Path2d::of_points(selected(x), selected(y));
        sparse_points(&path, None, &vec![80.0 / 3.6; points.len()])
    }

    fn warns(findings: &[Finding]) -> bool {
        findings.iter().any(|finding| finding.check == "sparse-points")
    }

    #[test]
    fn close_points_are_not_warned_of_and_wide_bends_hardly_ever() {
        let mut warned = 0;
        for seed in 1..=10 {
            for radii_m in [[50.0, 500.0], [15.0, 40.0], [700.0, 2500.0]] {
                let road = road(seed, radii_m);
                let fine = thinned(&road.0, &road.1, 0.3);
                for points in [spaced(&road.0, 5), spaced(&road.0, 10), fine] {
                    let findings = findings(&road, &points);
                    assert!(!warns(&findings), "{seed} {radii_m:?} {findings:?}");
                }
            }
            let wide = road(seed, [713.0, 2500.0]);
            for points in [
                thinned(&wide.0, &wide.1, 5.0),
                thinned(&wide.0, &wide.1, 20.0),
                spaced(&wide.0, 100),
                spaced(&wide.0, 200),
            ] {
                let findings = findings(&wide, &points);
                let spread = findings.iter().any(|finding| finding.check == "spread-turns");
                assert!(warns(&findings) != spread, "{seed} {findings:?}");
                warned += usize::from(warns(&findings));
            }
        }
        assert!(warned <= 4, "{warned} of 40 roads, which are all right");
    }

    #[test]
    fn points_that_leave_bends_open_are_warned_of() {
        for seed in 1..=10 {
            for radii_m in [[50.0, 500.0], [15.0, 40.0]] {
                let road = road(seed, radii_m);
                for points in [
                    thinned(&road.0, &road.1, 10.0),
                    thinned(&road.0, &road.1, 20.0),
                    spaced(&road.0, 50),
                    spaced(&road.0, 100),
                    spaced(&road.0, 500),
                    spaced(&road.0, 2000),
                ] {
                    let findings = findings(&road, &points);
                    assert!(warns(&findings), "{seed} {radii_m:?} {} {findings:?}", points.len());
                }
            }
        }
    }

    #[test]
    fn beelines_are_refused_and_long_straights_are_warned_of() {
        let sides = |y_m: f64| Path2d::of_points(vec![0.0, 20e3, 50e3], vec![0.0, 0.0, y_m]);
        let findings = sparse_points(&sides(20e3), None, &[22.0; 3]);
        assert!(findings[0].is_refusal() && findings[0].check == "beeline", "{findings:?}");
        let findings = sparse_points(&sides(0.0), None, &[22.0; 3]);
        assert!(!findings[0].is_refusal() && findings[0].check == "beeline", "{findings:?}");
    }

    #[test]
    fn corners_of_blocks_stay_corners() {
        // blocks of 300 m: a quarter turn at each, to either side in turn
        let x: Vec<f64> = (0..40).map(|k| 300.0 * f64::from((k + 1) / 2)).collect();
        let y: Vec<f64> = (0..40).map(|k| 300.0 * f64::from(k / 2)).collect();
        let path = Path2d::of_points(x.clone(), y);
        assert!(path.rounded(None, Rounding::LIKELY).is_none());
        let curves = path.curves(&path.position_m);
        assert!(curves.len() == 38 && curves.iter().all(|curve| curve.radius_m < 40.0));
    }
}
