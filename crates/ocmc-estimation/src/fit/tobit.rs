//! Regression of a response that is cut off from above at a known limit, one level for each group:
//! Tobit.
//!
//! y* = level_g + x β + e, e ~ N(0, σ²); seen is y = y* where y* lies below the row's limit c, and
//! only "at least c" elsewhere. In the parameters γ = (levels, β)/σ and h = 1/σ the log-likelihood
//!
//! Σ_seen (ln h − (h y − xγ)²/2) + Σ_cut ln P(Z > h c − xγ)
//!
//! is concave, so that Newton's method with halved steps finds its one maximum.
//!
//! Source: R. J. Olsen, Note on the uniqueness of the maximum likelihood estimator for the Tobit
//! model, Econometrica 46 (1978), 1211-1215 \[PK\].

use super::p_value::{ln_normal_tail, normal_hazard};
use nalgebra::{DMatrix, DVector};

/// Most steps of Newton's method.
const MOST_STEPS: usize = 100;

/// Squared length of a step, in standard errors, that is the last one.
const SETTLED: f64 = 1e-8;

/// One row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TobitRow<const X: usize> {
    /// Group, from 0.
    pub group: usize,
    /// Predictors.
    pub x: [f64; X],
    /// The response, or the limit where it is cut.
    pub y: f64,
    /// Whether the response is only known to be at least `y`.
    pub cut: bool,
}

/// A fitted Tobit regression.
#[derive(Clone, Debug, PartialEq)]
pub struct TobitFit {
    /// Level of each group, then the coefficients, then σ.
    pub parameters: DVector<f64>,
    /// Their covariance, from the curvature of the log-likelihood.
    pub covariance: DMatrix<f64>,
    /// Their covariance with rows of one group taken as one observation, times G/(G − 1); the
    /// levels' part has no meaning, since a group determines its own level.
    pub clustered_covariance: DMatrix<f64>,
    /// Logarithm of the likelihood.
    pub log_likelihood: f64,
    /// Rows that are cut.
    pub cut: usize,
}

/// The log-likelihood of a row at z = h y − xγ, and minus its first and second derivative by z.
fn curve(z: f64, cut: bool) -> [f64; 3] {
    if cut {
        let hazard = normal_hazard(z);
        [ln_normal_tail(z), hazard, (hazard * (hazard - z)).clamp(0.0, 1.0)]
    } else {
        [-0.5 * z * z - 0.5 * libm::log(2.0 * std::f64::consts::PI), z, 1.0]
    }
}

/// Derivatives of the log-likelihood.
struct Derivatives {
    value: f64,
    gradient: DVector<f64>,
    /// Minus the second derivatives.
    information: DMatrix<f64>,
    /// Sum over groups of the products of their gradients.
    group_products: DMatrix<f64>,
}

/// Fits `groups` levels, `X` coefficients and σ to rows.
///
/// None where a group has no row below its limit, where the coefficients are not determined, or
/// where the search does not end.
pub fn fit<const X: usize>(rows: &[TobitRow<X>], groups: usize) -> Option<TobitFit> {
    let mut seen = vec![0usize; groups];
    for row in rows.iter().filter(|row| !row.cut) {
        seen[row.group] += 1;
    }
    let total: usize = seen.iter().sum();
    if seen.contains(&0) || total <= groups + X {
        return None;
    }
    let mut theta = start(rows, &seen);
    let mut here = derivatives(rows, groups, &theta);
    for _ in 0..MOST_STEPS {
        let step = here.information.clone().cholesky()?.solve(&here.gradient);
        let decrement = step.dot(&here.gradient);
        if decrement < SETTLED {
            // the likelihood cannot distinguish this step from none any more, while the step still
            // doubles the digits
            let theta = theta + step;
            let here = derivatives(rows, groups, &theta);
            return Some(summary(rows, groups, &theta, &here));
        }
        let mut share = 1.0;
        loop {
            let next = &theta + share * &step;
            if next[groups + X] > 0.0 {
                let there = derivatives(rows, groups, &next);
                if there.value >= here.value {
                    (theta, here) = (next, there);
                    break;
                }
            }
            share *= 0.5;
            if share < 1e-10 {
                return Some(summary(rows, groups, &theta, &here));
            }
        }
    }
    None
}

/// Group means of what is seen, no slope.
fn start<const X: usize>(rows: &[TobitRow<X>], seen: &[usize]) -> DVector<f64> {
    let groups = seen.len();
    let mut level = vec![0.0; groups];
    for row in rows.iter().filter(|row| !row.cut) {
        level[row.group] += row.y / seen[row.group] as f64;
    }
    let off = rows.iter().filter(|row| !row.cut).map(|row| row.y - level[row.group]);
    let squares: f64 = off.map(|off| off * off).sum();
    let total: usize = seen.iter().sum();
    let h = 1.0 / libm::sqrt(squares / total as f64).max(1e-6);
    let mut theta = DVector::zeros(groups + X + 1);
    for (group, level) in level.iter().enumerate() {
        theta[group] = h * level;
    }
    theta[groups + X] = h;
    theta
}

fn derivatives<const X: usize>(
    rows: &[TobitRow<X>],
    groups: usize,
    theta: &DVector<f64>,
) -> Derivatives {
    let size = groups + X + 1;
    let h = theta[size - 1];
    let mut value = 0.0;
    let mut gradient = DVector::zeros(size);
    let mut information = DMatrix::zeros(size, size);
    // a group's gradient has one level, the coefficients and h
    let mut group_gradients = DMatrix::<f64>::zeros(groups, X + 2);
    // where the entries of a row's predictors stand, the level's 1 and h's -y included
    let (mut places, mut entries) = (vec![0; X + 2], vec![1.0; X + 2]);
    for row in rows {
        let mut z = h * row.y - theta[row.group];
        places[0] = row.group;
        for j in 0..X {
            z -= row.x[j] * theta[groups + j];
            entries[1 + j] = row.x[j];
            places[1 + j] = groups + j;
        }
        entries[1 + X] = -row.y;
        places[1 + X] = size - 1;
        let [of_row, slope, bend] = curve(z, row.cut);
        value += of_row;
        for a in 0..X + 2 {
            let slope = slope * entries[a];
            gradient[places[a]] += slope;
            group_gradients[(row.group, a)] += slope;
            for b in 0..=a {
                information[(places[a], places[b])] += bend * entries[a] * entries[b];
            }
        }
        if !row.cut {
            value += libm::log(h);
            gradient[size - 1] += 1.0 / h;
            group_gradients[(row.group, 1 + X)] += 1.0 / h;
            information[(size - 1, size - 1)] += 1.0 / (h * h);
        }
    }
    information.fill_upper_triangle_with_lower_triangle();
    let mut group_products = DMatrix::zeros(size, size);
    for group in 0..groups {
        let place = |a: usize| if a == 0 { group } else { groups + a - 1 };
        for a in 0..X + 2 {
            for b in 0..X + 2 {
                group_products[(place(a), place(b))] +=
                    group_gradients[(group, a)] * group_gradients[(group, b)];
            }
        }
    }
    Derivatives { value, gradient, information, group_products }
}

/// From (γ, h) to (levels, β, σ), with covariances by the linearised map.
fn summary<const X: usize>(
    rows: &[TobitRow<X>],
    groups: usize,
    theta: &DVector<f64>,
    here: &Derivatives,
) -> TobitFit {
    let last = groups + X;
    let sigma = 1.0 / theta[last];
    let mut map = DMatrix::identity(last + 1, last + 1) * sigma;
    let mut parameters = theta * sigma;
    for j in 0..last {
        map[(j, last)] = -theta[j] * sigma * sigma;
    }
    map[(last, last)] = -sigma * sigma;
    parameters[last] = sigma;
    let inverse = here.information.clone().try_inverse();
    let inverse = inverse.unwrap_or_else(|| DMatrix::zeros(last + 1, last + 1));
    let covariance = &map * &inverse * map.transpose();
    let correction = groups as f64 / (groups as f64 - 1.0);
    let middle = &inverse * &here.group_products * &inverse * correction;
    TobitFit {
        parameters,
        covariance,
        clustered_covariance: &map * middle * map.transpose(),
        log_likelihood: here.value,
        cut: rows.iter().filter(|row| row.cut).count(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    fn rows(seed: u64, limit: f64) -> Vec<TobitRow<1>> {
        let mut draws = Draws::new(seed, 0, Stream::Vehicle);
        (0..6000)
            .map(|k| {
                let (group, x) = (k % 3, draws.normal());
                let y = group as f64 + 0.5 * x + 0.7 * draws.normal();
                TobitRow { group, x: [x], y: y.min(limit), cut: y >= limit }
            })
            .collect()
    }

    #[test]
    fn gets_back_what_was_cut() {
        for seed in 1..=3 {
            let fit = fit(&rows(seed, 1.2), 3).unwrap();
            assert!(fit.cut > 1500);
            for (j, wanted) in [0.0, 1.0, 2.0, 0.5, 0.7].into_iter().enumerate() {
                let error = fit.covariance[(j, j)].sqrt();
                assert!(error < 0.05);
                assert!((fit.parameters[j] - wanted).abs() < 4.0 * error, "{j} {}", fit.parameters);
            }
        }
    }

    #[test]
    fn without_a_cut_it_is_least_squares() {
        let rows = rows(1, f64::INFINITY);
        let fit = fit(&rows, 3).unwrap();
        let line = super::super::least_squares::LeastSquares::reduce(rows.len(), 4, |k, x| {
            let row = &rows[k];
            x.copy_from_slice(&[1.0, row.x[0], (row.group == 1).into(), (row.group == 2).into()]);
            row.y
        })
        .unwrap();
        let b = line.coefficients();
        assert!((fit.parameters[0] - b[0]).abs() < 1e-8 && (fit.parameters[3] - b[1]).abs() < 1e-8);
        // maximum likelihood divides by n
        let sd = (line.residual_sum_sq / rows.len() as f64).sqrt();
        assert!((fit.parameters[4] - sd).abs() < 1e-8);
        let error = (line.inverse_gram()[(1, 1)]).sqrt() * sd;
        assert!((fit.covariance[(3, 3)].sqrt() - error).abs() < 1e-6 * error);
    }

    #[test]
    fn the_maximum_is_one() {
        // by differences: no parameter can be moved to a larger likelihood
        let rows = rows(2, 0.8);
        let best = fit(&rows, 3).unwrap();
        let value = |theta: &DVector<f64>| derivatives(&rows, 3, theta).value;
        let sigma = best.parameters[4];
        let mut theta = &best.parameters / sigma;
        theta[4] = 1.0 / sigma;
        for j in 0..5 {
            for step in [-0.01, 0.01] {
                let mut moved = theta.clone();
                moved[j] += step;
                assert!(value(&moved) < value(&theta), "{j}");
            }
        }
    }

    #[test]
    fn a_group_that_is_always_cut_has_no_level() {
        let mut rows = rows(1, 1.2);
        for row in rows.iter_mut().filter(|row| row.group == 2) {
            row.cut = true;
        }
        assert!(fit(&rows, 3).is_none());
    }
}
