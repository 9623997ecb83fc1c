//! The noise of a given route's positions and altitudes, and the road behind them.
//!
//! Errors are no bends: they lie to either side in turn. Of second differences of white noise 73 in
//! 100 have the other sign than the one before, of an error that fades from row to row at least 66;
//! of what is bent, thinned or not, at most half. Where fewer than 60 do, or where points are far
//! apart, nothing is taken for an error.
//!
//! How much they scatter is seen in fourth differences, which a smooth road has almost none of: of
//! independent errors with the SD σ, z₋₂/4 − z₋₁ + 3 z₀/2 − z₁ + z₂/4 has the SD σ √4.375. The
//! median of its magnitude is taken, so that a few sharp bends do not count. Of positions it is the
//! distance from the chord of both neighbours that is compared with that of the neighbours, because
//! points may lie unevenly along a road.
//!
//! The road is what minimises Σ (z_i − f(s_i))² + λ Σ (Δᵖ f)² on an even grid (Whittaker 1923; P.
//! Eilers, Anal. Chem. 75, 2003), Δᵖ the p-th difference: of altitudes the second, of positions the
//! third, for which a bend of one radius costs little. λ minimises Mallows' criterion RSS + 2 σ²
//! df, with df = Σ 1/(1 + λ (2 − 2 cos ω)ᵖ h/g), points every h on a grid of g. Where the positions
//! lie farther from the road than their noise explains, as around sharp bends, λ is lowered tenfold
//! and the road is fitted again, four times at most. Noise that does not change from point to
//! point, as that of a receiver's slow drift, is not seen, and bends the road little.

use crate::operating_cycle::road::route_geometry::interpolate;
use std::f64::consts::PI;

/// Scatter below which points are taken as they are, in m (judgement): altitudes in whole metres
/// scatter by 0.3 m.
pub const LEAST_NOISE_M: f64 = 0.5;
/// The same of altitudes over the way between them: steps of altitudes are slopes.
const LEAST_SLOPE_NOISE: f64 = 0.005;
/// Most scatter from which a road is made, in m (judgement).
pub const MOST_NOISE_M: f64 = 8.0;
/// √4.375 Φ⁻¹(3/4): median of the magnitude of the differences over σ.
const MEDIAN_PER_SD: f64 = 2.091_650_066_335_189 * 0.674_489_750_196_081_7;
/// Points closer than so many times the scatter become one.
const CLOSEST: f64 = 3.0;
/// Fewest points of which noise is told.
const FEWEST: usize = 30;
/// Points of a plane farther apart tell no noise, in m (judgement): an error of 3 m bends a way of
/// such steps by 4°, which is no curve.
const FAR_M: f64 = 100.0;
/// Likewise of altitudes, in m (judgement).
const FAR_ALTITUDES_M: f64 = 200.0;
/// Times that a point may scatter of the way between its neighbours until that has no direction.
const BLURRED: f64 = 4.0;
/// Way over which points that scatter by some metres have a direction, in m.
const DIRECTED_M: f64 = 40.0;
/// Share of bends in turn from which on they are errors.
const IN_TURN: f64 = 0.6;
/// Grids of positions and of altitudes, in m.
const GRID_M: [f64; 2] = [5.0, 10.0];
/// Order of the differences that are kept small.
const ORDER: [usize; 2] = [3, 2];
/// Powers of ten of λ that are tried, in halves.
const POWERS: std::ops::RangeInclusive<i32> = -4..=16;
/// Fits with a lower λ around bends.
const ROUNDS: usize = 4;
/// Way to either side over which positions are compared with the road, in m.
const NEAR_M: f64 = 60.0;
/// Excess of the mean square there, in its SDs, that noise does not explain.
const EXCESS: f64 = 2.4;

/// Median of magnitudes over that of independent noise.
fn scatter(mut differences: Vec<f64>) -> f64 {
    if differences.len() < FEWEST {
        return 0.0;
    }
    for difference in &mut differences {
        *difference = difference.abs();
    }
    differences.sort_by(f64::total_cmp);
    differences[differences.len() / 2] / MEDIAN_PER_SD
}

/// SD of the noise that makes bends, of which some are not known; 0 where they are those of what is
/// measured.
fn noise_of_bends(bends: &[Option<f64>]) -> f64 {
    let product = |w: &[Option<f64>]| Some(w[0]? * w[1]?);
    let products = bends.windows(2).filter_map(product).filter(|product| *product != 0.0);
    let (mut all, mut in_turn) = (0_usize, 0_usize);
    for product in products {
        all += 1;
        in_turn += usize::from(product < 0.0);
    }
    if (in_turn as f64) < IN_TURN * all as f64 {
        return 0.0;
    }
    let bent = |w: &[Option<f64>]| Some(w[1]? - 0.5 * (w[0]? + w[2]?));
    scatter(bends.windows(3).filter_map(bent).collect())
}

/// SD of the noise of values, in their unit, whatever else they may be.
pub fn noise_of_values(values: &[f64]) -> f64 {
    let bent = |w: &[f64]| 0.25 * (w[0] + w[4]) - w[1] + 1.5 * w[2] - w[3];
    scatter(values.windows(5).map(bent).collect())
}

/// SD of the noise of altitudes at their places, both in m.
pub fn noise_of_altitudes(position_m: &[f64], altitude_m: &[f64]) -> f64 {
    let bend = |k: usize| {
        let far = position_m[k + 1] - position_m[k - 1] > 2.0 * FAR_ALTITUDES_M;
        (!far).then(|| altitude_m[k] - 0.5 * (altitude_m[k - 1] + altitude_m[k + 1]))
    };
    let bends: Vec<Option<f64>> = (1..altitude_m.len().saturating_sub(1)).map(bend).collect();
    noise_of_bends(&bends)
}

/// Scatter of altitudes at these places below which they are taken as they are, in m: at most
/// [`LEAST_NOISE_M`].
pub fn least_noise_of_altitudes_m(position_m: &[f64]) -> f64 {
    let mut steps_m: Vec<f64> = position_m.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps_m.sort_by(f64::total_cmp);
    let usual_m = steps_m.get(steps_m.len() / 2).copied().unwrap_or(f64::INFINITY);
    LEAST_NOISE_M.min(LEAST_SLOPE_NOISE * usual_m)
}

/// SD of the noise of points on a plane across their path, in m. Where points are closer than they
/// scatter, the way between neighbours has no direction: there it is that over more points.
pub fn noise_of_points(x_m: &[f64], y_m: &[f64]) -> f64 {
    let beside = |k: usize| {
        let (bx, by) = (x_m[k + 1] - x_m[k - 1], y_m[k + 1] - y_m[k - 1]);
        let (px, py) = (x_m[k] - x_m[k - 1], y_m[k] - y_m[k - 1]);
        let chord = libm::hypot(bx, by);
        let far = libm::hypot(px, py).max(libm::hypot(bx - px, by - py)) > FAR_M;
        (!far).then(|| if chord > 0.0 { (px * by - py * bx) / chord } else { 0.0 })
    };
    let bends: Vec<Option<f64>> = (1..x_m.len().saturating_sub(1)).map(beside).collect();
    let noise_m = noise_of_bends(&bends);
    let is_directed = noise_m > 0.0 && BLURRED * noise_m < median_chord_m(x_m, y_m, 1);
    let Some(reach) = points_along(x_m, y_m).filter(|_| !is_directed) else { return noise_m };
    let beside = |k: usize| {
        let (a, b) = (k - reach, k + reach);
        let (bx, by) = (x_m[b] - x_m[a], y_m[b] - y_m[a]);
        let chord = libm::hypot(bx, by);
        let px = x_m[k] - 0.5 * (x_m[k - 1] + x_m[k + 1]);
        let py = y_m[k] - 0.5 * (y_m[k - 1] + y_m[k + 1]);
        Some(if chord > 0.0 { (px * by - py * bx) / chord } else { 0.0 })
    };
    let bends: Vec<Option<f64>> = (reach..x_m.len() - reach).map(beside).collect();
    noise_of_bends(&bends)
}

/// Points to either side over which the way has a direction; none where neighbours are that far.
fn points_along(x_m: &[f64], y_m: &[f64]) -> Option<usize> {
    let mut reach = 1;
    while 2 * reach + FEWEST < x_m.len() {
        if median_chord_m(x_m, y_m, reach) >= DIRECTED_M {
            return (reach > 1).then_some(reach);
        }
        reach *= 2;
    }
    None
}

/// Median distance of points that are `reach` before and behind another one, in m.
fn median_chord_m(x_m: &[f64], y_m: &[f64], reach: usize) -> f64 {
    let chord =
        |k: usize| libm::hypot(x_m[k + reach] - x_m[k - reach], y_m[k + reach] - y_m[k - reach]);
    let mut chords_m: Vec<f64> = (reach..x_m.len() - reach).map(chord).collect();
    chords_m.sort_by(f64::total_cmp);
    chords_m[chords_m.len() / 2]
}

/// Values on a grid.
struct OnGrid {
    step_m: f64,
    count: usize,
    /// Node before each datum, and its share of the way to the next.
    places: Vec<(usize, f64)>,
}

impl OnGrid {
    fn new(places_m: &[f64], step_m: f64) -> Self {
        let length_m = places_m.last().copied().unwrap_or(0.0);
        let count = (libm::ceil(length_m / step_m) as usize + 1).max(8);
        let place = |at_m: &f64| {
            let k = ((at_m / step_m) as usize).min(count - 2);
            (k, at_m / step_m - k as f64)
        };
        Self { step_m, count, places: places_m.iter().map(place).collect() }
    }

    fn nodes(&self) -> impl Iterator<Item = f64> {
        let step_m = self.step_m;
        (0..self.count).map(move |k| k as f64 * step_m)
    }

    /// Fitted value at each datum.
    fn at_data(&self, nodes: &[f64]) -> Vec<f64> {
        let at = |(k, share): &(usize, f64)| nodes[*k] + share * (nodes[k + 1] - nodes[*k]);
        self.places.iter().map(at).collect()
    }

    /// The smooth values of each column at the nodes; `stiffness`: λ of each difference.
    fn fit(&self, columns: &[&[f64]], order: usize, stiffness: &[f64]) -> Vec<Vec<f64>> {
        let band = order.max(1);
        let mut matrix = vec![vec![0.0; band + 1]; self.count];
        for (k, share) in &self.places {
            matrix[*k][0] += (1.0 - share) * (1.0 - share);
            matrix[k + 1][0] += share * share;
            matrix[*k][1] += share * (1.0 - share);
        }
        let weights: &[f64] = if order == 3 { &[-1.0, 3.0, -3.0, 1.0] } else { &[1.0, -2.0, 1.0] };
        for (first, stiffness) in stiffness.iter().enumerate() {
            for (i, a) in weights.iter().enumerate() {
                for (j, b) in weights[i..].iter().enumerate() {
                    matrix[first + i][j] += stiffness * a * b;
                }
            }
        }
        for row in &mut matrix {
            // nodes without data beyond a gap are held by the differences alone
            row[0] += 1e-9;
        }
        factorise(&mut matrix, band);
        let solution = |values: &&[f64]| {
            let mut right = vec![0.0; self.count];
            for ((k, share), value) in self.places.iter().zip(*values) {
                right[*k] += (1.0 - share) * value;
                right[k + 1] += share * value;
            }
            solve(&matrix, band, &mut right);
            right
        };
        columns.iter().map(solution).collect()
    }

    /// Squares of the distances of the data from what is fitted, a mean over the columns.
    fn squares(&self, columns: &[&[f64]], fitted: &[Vec<f64>]) -> Vec<f64> {
        let mut squares = vec![0.0; self.places.len()];
        for (values, nodes) in columns.iter().zip(fitted) {
            for ((square, value), fit) in squares.iter_mut().zip(*values).zip(self.at_data(nodes)) {
                *square += (value - fit) * (value - fit) / columns.len() as f64;
            }
        }
        squares
    }

    /// λ by Mallows' criterion.
    fn stiffness(&self, columns: &[&[f64]], order: usize, noise: f64) -> f64 {
        let n = self.places.len() as f64;
        let per_node = n / self.count as f64;
        let freedom = |stiffness: f64| {
            let smoothing = |k: i32| {
                let rough = 2.0 - 2.0 * libm::cos(PI * (f64::from(k) + 0.5) / 400.0);
                let power = if order == 3 { rough * rough * rough } else { rough * rough };
                1.0 / (1.0 + stiffness * power / per_node)
            };
            (0..400).map(smoothing).sum::<f64>() / 400.0 * self.count as f64
        };
        let mut best = (f64::INFINITY, 1.0);
        for power in POWERS {
            let stiffness = libm::pow(10.0, 0.5 * f64::from(power));
            let fitted = self.fit(columns, order, &vec![stiffness; self.count - order]);
            let squares: f64 = self.squares(columns, &fitted).iter().sum();
            let criterion = squares + 2.0 * noise * noise * freedom(stiffness);
            if criterion < best.0 {
                best = (criterion, stiffness);
            }
        }
        best.1
    }
}

/// Cholesky's factor of a symmetric band matrix, by rows: row k holds its diagonal and what stands
/// behind it; after it, Lᵀ.
fn factorise(matrix: &mut [Vec<f64>], band: usize) {
    for k in 0..matrix.len() {
        let (done, rest) = matrix.split_at_mut(k);
        let row = &mut rest[0];
        for back in 1..=band.min(k) {
            let above = &done[k - back];
            let factor = above[back];
            for j in 0..=band - back {
                row[j] -= factor * above[back + j];
            }
        }
        let root = row[0].max(f64::MIN_POSITIVE).sqrt();
        for value in row.iter_mut() {
            *value /= root;
        }
    }
}

fn solve(factor: &[Vec<f64>], band: usize, right: &mut [f64]) {
    for k in 0..factor.len() {
        for back in 1..=band.min(k) {
            right[k] -= factor[k - back][back] * right[k - back];
        }
        right[k] /= factor[k][0];
    }
    for k in (0..factor.len()).rev() {
        for ahead in 1..=band.min(factor.len() - 1 - k) {
            right[k] -= factor[k][ahead] * right[k + ahead];
        }
        right[k] /= factor[k][0];
    }
}

/// Altitudes without their noise, over position, both in m.
pub fn smooth_altitudes(position_m: &[f64], altitude_m: &[f64], noise_m: f64) -> Vec<(f64, f64)> {
    let grid = OnGrid::new(position_m, GRID_M[1]);
    let columns = [altitude_m];
    let stiffness = grid.stiffness(&columns, ORDER[1], noise_m);
    let fitted = grid.fit(&columns, ORDER[1], &vec![stiffness; grid.count - ORDER[1]]);
    let length_m = position_m.last().copied().unwrap_or(0.0);
    let within = grid.nodes().zip(fitted.into_iter().flatten());
    let mut points: Vec<(f64, f64)> = within.take_while(|(at_m, _)| *at_m <= length_m).collect();
    if points.len() < 2 {
        points = position_m.iter().copied().zip(altitude_m.iter().copied()).collect();
    }
    points
}

/// The road behind noisy points on a plane.
#[derive(Clone, Debug)]
pub struct SmoothPath {
    /// Its points: to the east and to the north, in m.
    pub x_m: Vec<f64>,
    /// To the north, in m.
    pub y_m: Vec<f64>,
    /// Where each of the given points lies along it, in m, growing.
    pub given_m: Vec<f64>,
}

/// Smooths points on a plane. Those closer than the noise, as where a truck stands, become one.
pub fn smooth_points(x_m: &[f64], y_m: &[f64], noise_m: f64) -> SmoothPath {
    let closest_m = CLOSEST * noise_m;
    // means of groups, and the middles of the groups' numbers
    let (mut gx, mut gy, mut middle) = (Vec::new(), Vec::new(), Vec::new());
    let mut first = 0;
    while first < x_m.len() {
        let is_near = |k: &usize| {
            libm::hypot(x_m[*k] - x_m[first], y_m[*k] - y_m[first]) < closest_m || *k == first
        };
        let last = (first..x_m.len()).take_while(is_near).last().unwrap_or(first);
        let n = (last - first + 1) as f64;
        gx.push(x_m[first..=last].iter().sum::<f64>() / n);
        gy.push(y_m[first..=last].iter().sum::<f64>() / n);
        middle.push(0.5 * (first + last) as f64);
        first = last + 1;
    }
    if gx.len() < FEWEST {
        let given_m = along(x_m, y_m);
        return SmoothPath { x_m: x_m.to_vec(), y_m: y_m.to_vec(), given_m };
    }
    let way_m = along(&gx, &gy);
    let [x, y] = smooth_over(&way_m, [&gx, &gy], noise_of_points(&gx, &gy));
    let road_m = along(&x, &y);
    let nodes: Vec<f64> = (0..x.len()).map(|k| k as f64 * GRID_M[0]).collect();
    let group_m: Vec<f64> =
        way_m.iter().map(|way_m| interpolate(&nodes, &road_m, *way_m)).collect();
    let mut before_m = f64::NEG_INFINITY;
    let given = (0..x_m.len()).map(|k| {
        let at_m = interpolate(&middle, &group_m, k as f64).max(before_m + APART_M);
        before_m = at_m;
        at_m
    });
    let given_m: Vec<f64> = given.collect();
    SmoothPath { x_m: x, y_m: y, given_m }
}

/// Points of one place are so far apart, in m.
const APART_M: f64 = 1e-3;

/// Smooths both coordinates over the way, which the points' places need not be even on; on a grid
/// of 5 m from 0 on.
pub fn smooth_over(way_m: &[f64], columns: [&[f64]; 2], noise_m: f64) -> [Vec<f64>; 2] {
    let grid = OnGrid::new(way_m, GRID_M[0]);
    let order = ORDER[0];
    let stiffness = grid.stiffness(&columns, order, noise_m);
    let mut stiffness = vec![stiffness; grid.count - order];
    let mut fitted = grid.fit(&columns, order, &stiffness);
    for _ in 0..ROUNDS {
        let squares = grid.squares(&columns, &fitted);
        let mut sums = vec![0.0];
        for square in &squares {
            sums.push(sums[sums.len() - 1] + square);
        }
        let bends = |at_m: f64| {
            let from = way_m.partition_point(|way_m| *way_m < at_m - NEAR_M);
            let to = way_m.partition_point(|way_m| *way_m <= at_m + NEAR_M);
            let n = (to - from) as f64;
            let allowed = noise_m * noise_m * (1.0 + EXCESS / n.sqrt());
            to > from && (sums[to] - sums[from]) / n > allowed
        };
        let mut any = false;
        for (k, stiffness) in stiffness.iter_mut().enumerate() {
            if bends((k + 1) as f64 * GRID_M[0]) {
                *stiffness *= 0.1;
                any = true;
            }
        }
        if !any {
            break;
        }
        fitted = grid.fit(&columns, order, &stiffness);
    }
    let mut fitted = fitted.into_iter();
    [fitted.next().unwrap_or_default(), fitted.next().unwrap_or_default()]
}

/// Distances along points, in m.
pub(super) fn along(x_m: &[f64], y_m: &[f64]) -> Vec<f64> {
    let mut way_m = vec![0.0];
    for k in 1..x_m.len() {
        way_m.push(way_m[k - 1] + libm::hypot(x_m[k] - x_m[k - 1], y_m[k] - y_m[k - 1]));
    }
    way_m
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that scatter evenly, with the SD 1.
    fn scattered(n: usize) -> Vec<f64> {
        let mut state: u64 = 7;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..n).map(|_| (0..12).map(|_| next()).sum::<f64>() - 6.0).collect()
    }

    #[test]
    fn noise_is_told_from_the_road() {
        let hills = |k: usize| 40.0 * (k as f64 / 60.0).sin();
        let clean: Vec<f64> = (0..2000).map(hills).collect();
        let position: Vec<f64> = (0..2000).map(|k| 20.0 * k as f64).collect();
        assert!(noise_of_altitudes(&position, &clean) < 0.02);
        let noisy: Vec<f64> = clean.iter().zip(scattered(2000)).map(|(z, e)| z + 3.0 * e).collect();
        assert!(
            (noise_of_altitudes(&position, &noisy) - 3.0).abs() < 0.3,
            "{}",
            noise_of_altitudes(&position, &noisy)
        );
        let smooth = smooth_altitudes(&position, &noisy, 3.0);
        let at = |k: usize| smooth[2 * k].1 - clean[k];
        let mean = (0..1990).map(|k| at(k) * at(k)).sum::<f64>() / 1990.0;
        assert!(mean.sqrt() < 1.2, "{mean}");
    }

    #[test]
    fn points_closer_than_they_scatter_have_noise() {
        let (e, f) = (scattered(4000), scattered(8000));
        for noise_m in [1.0, 3.0] {
            let at = |k: usize| (k as f64 / 300.0).sin_cos();
            let x: Vec<f64> = (0..4000).map(|k| 300.0 * at(k).0 + noise_m * e[k]).collect();
            let y: Vec<f64> = (0..4000).map(|k| 300.0 * at(k).1 + noise_m * f[4000 + k]).collect();
            let found_m = noise_of_points(&x, &y);
            assert!((found_m / noise_m - 1.0).abs() < 0.1, "{noise_m}: {found_m}");
        }
    }

    #[test]
    fn thinned_or_far_points_are_no_noise() {
        // a winding road by its corners: two bends to the left, two to the right
        let mut at = (0.0, 0.0, 0.0_f64);
        let mut points = Vec::new();
        for k in 0..200 {
            points.push((at.0, at.1));
            at.2 += if k % 4 < 2 { 0.5 } else { -0.5 };
            at.0 += 60.0 * at.2.cos();
            at.1 += 60.0 * at.2.sin();
        }
        let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        assert_eq!(noise_of_points(&x, &y), 0.0);
        // rows 30 s apart
        let e = scattered(200);
        let x: Vec<f64> = (0..200).map(|k| 600.0 * f64::from(k)).collect();
        let y: Vec<f64> = e.iter().map(|e| 30.0 * e).collect();
        assert_eq!(noise_of_points(&x, &y), 0.0);
        assert_eq!(noise_of_altitudes(&x, &y), 0.0);
    }

    #[test]
    fn a_straight_road_with_a_corner_stays_one() {
        // 1 km north, then 1 km east, a point every 10 m
        let corner = |k: usize| {
            let s = 10.0 * k as f64;
            if s <= 1000.0 { (0.0, s) } else { (s - 1000.0, 1000.0) }
        };
        let (x, y): (Vec<f64>, Vec<f64>) = (0..201).map(corner).unzip();
        let e = scattered(402);
        let nx: Vec<f64> = x.iter().zip(&e).map(|(x, e)| x + 3.0 * e).collect();
        let ny: Vec<f64> = y.iter().zip(&e[201..]).map(|(y, e)| y + 3.0 * e).collect();
        let noise = noise_of_points(&nx, &ny);
        assert!((noise - 3.0).abs() < 0.8, "{noise}");
        let raw_m = along(&nx, &ny).pop().unwrap();
        let path = smooth_points(&nx, &ny, noise);
        let length_m = *path.given_m.last().unwrap();
        assert!(raw_m > 2100.0 && (length_m - 2000.0).abs() < 25.0, "{raw_m} {length_m}");
        let near = path.x_m.iter().zip(&path.y_m).map(|(x, y)| libm::hypot(*x, y - 1000.0));
        assert!(near.fold(f64::INFINITY, f64::min) < 15.0);
    }
}
