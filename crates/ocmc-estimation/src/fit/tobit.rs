//! Regression of a response that is cut off from above at a known limit, one level for each group:
//! Tobit.
//!
//! y* = level_g + x β + e, e ~ N(0, σ²); seen is y = y* where y* lies below the row's limit c, and
//! only "at least c" elsewhere. In the parameters γ = (levels, β)/σ and h = 1/σ the log-likelihood
//!
//! Σ_seen (ln h − (h y − xγ)²/2) + Σ_cut ln P(Z > h c − xγ)
//!
//! is concave, so that Newton's method with halved steps finds its one maximum. A row has one
//! level, so the second derivatives by the levels are a diagonal: they are eliminated, and
//! thousands of groups cost no more than their rows. Sums over rows are compensated (Neumaier), so
//! that the last steps are seen beside the sum of a million rows.
//!
//! The σ of the maximum is too small: p levels and coefficients were fitted, too. The one given is
//! at the maximum of
//!
//! l(γ̂(h), h) − ½ ln |−∂²l/∂(levels, β)²|,
//!
//! the likelihood with the levels and β integrated out by Laplace's method. Without cut rows this
//! is the residual sum of squares over n − p, and REML's. The levels and β stay those of the
//! maximum, which many groups do not bias; their errors are those of the corrected σ.
//!
//! Sources: R. J. Olsen, Note on the uniqueness of the maximum likelihood estimator for the Tobit
//! model, Econometrica 46 (1978), 1211-1215 \[PK\]; D. R. Cox, N. Reid, Journal of the Royal
//! Statistical Society B 49 (1987) \[PK\]; W. Greene, Econometric Reviews 23 (2004) \[PK\].

use super::cluster_robust::{Cluster, ClusterMoves, ClusteredError, with_correlation};
use super::compensated_sum::CompensatedSum;
use super::p_value::{ln_normal_tail, normal_hazard};
use nalgebra::{DMatrix, DVector};

/// Most steps of Newton's method.
const MOST_STEPS: usize = 100;

/// Squared length of a step, in standard errors, that is the last one.
const SETTLED: f64 = 1e-8;

/// Relative step of the derivative of the determinant by ln σ.
const DIFFERENCE: f64 = 1e-3;

/// Relative error of the corrected σ.
const SIGMA_ERROR: f64 = 1e-9;

/// Largest correction of ln σ.
const LARGEST_CORRECTION: f64 = 2.0;

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
    /// Level of each group.
    pub levels: Vec<f64>,
    /// Variance of each level.
    pub level_variances: Vec<f64>,
    /// The part of it that is the group's own: the rest is the error of β and σ, which all share.
    pub own_variances: Vec<f64>,
    /// Variance of the unweighted mean of the levels.
    pub mean_level_variance: f64,
    /// Standard error of that mean with the rows of one group taken as one observation: that for
    /// the groups that these stand for; and its correlation with the first coefficient's. None with
    /// one group.
    pub(super) clustered_mean_level: Option<(f64, f64)>,
    /// Coefficients β.
    pub coefficients: Vec<f64>,
    /// Their covariance, from the curvature of the log-likelihood.
    pub covariance: DMatrix<f64>,
    /// The error of the first of them with rows of one group taken as one observation; none with
    /// one group.
    pub(super) clustered: Option<ClusteredError>,
    /// Corrected σ.
    pub sigma: f64,
    /// Its standard error.
    pub sigma_standard_error: f64,
    /// The σ of the maximum, which is too small.
    pub sigma_of_maximum: f64,
    /// Logarithm of the likelihood at its maximum.
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

/// Parameters: the levels, then β, both over σ, and h.
#[derive(Clone, Debug, PartialEq)]
struct Place {
    levels: Vec<f64>,
    /// β/σ, then h.
    common: DVector<f64>,
}

impl Place {
    fn h(&self) -> f64 {
        self.common[self.common.len() - 1]
    }

    fn moved(&self, step: &Place, share: f64) -> Place {
        let levels = self.levels.iter().zip(&step.levels);
        Place {
            levels: levels.map(|(level, step)| level + share * step).collect(),
            common: &self.common + share * &step.common,
        }
    }
}

/// Derivatives of the log-likelihood; minus the second ones are \[D B; Bᵀ A\].
struct Derivatives {
    value: f64,
    /// By the levels.
    of_levels: Vec<f64>,
    /// By the common parameters.
    of_common: DVector<f64>,
    diagonal: Vec<f64>,
    border: DMatrix<f64>,
    corner: DMatrix<f64>,
    /// The part of A of each group's rows, a row a group, entry by entry.
    group_corners: DMatrix<f64>,
    /// Gradient by the common parameters of each group's rows, a row a group.
    group_gradients: DMatrix<f64>,
}

impl Derivatives {
    /// A − Bᵀ D⁻¹ B, as far as the first `count` common parameters reach.
    fn schur(&self, count: usize) -> DMatrix<f64> {
        let mut left = self.corner.view((0, 0), (count, count)).into_owned();
        for (group, diagonal) in self.diagonal.iter().enumerate() {
            let border = self.border.row(group);
            for a in 0..count {
                for b in 0..count {
                    left[(a, b)] -= border[a] * border[b] / diagonal;
                }
            }
        }
        left
    }

    /// The information and the gradient of a group's rows by the common parameters, its own level
    /// eliminated.
    fn cluster(&self, group: usize) -> Cluster {
        let (border, diagonal) = (self.border.row(group).transpose(), self.diagonal[group]);
        let width = border.len();
        let corner = self.group_corners.row(group);
        let corner = DMatrix::from_row_iterator(width, width, corner.iter().copied());
        Cluster {
            information: corner - &border * border.transpose() / diagonal,
            score: self.group_gradients.row(group).transpose()
                - border * (self.of_levels[group] / diagonal),
        }
    }

    /// Newton's step of the levels and the first `count` common parameters, and its squared length
    /// in standard errors.
    fn step(&self, count: usize) -> Option<(Place, f64)> {
        let mut right = self.of_common.rows(0, count).into_owned();
        for (group, (slope, diagonal)) in self.of_levels.iter().zip(&self.diagonal).enumerate() {
            for a in 0..count {
                right[a] -= self.border[(group, a)] * slope / diagonal;
            }
        }
        let some = if count > 0 { self.schur(count).cholesky()?.solve(&right) } else { right };
        let common = some.resize_vertically(self.of_common.len(), 0.0);
        let along = |group: usize| self.border.row(group).transpose().dot(&common);
        let rows = self.of_levels.iter().zip(&self.diagonal).enumerate();
        let levels: Vec<f64> =
            rows.map(|(group, (slope, diagonal))| (slope - along(group)) / diagonal).collect();
        let length =
            levels.iter().zip(&self.of_levels).map(|(step, slope)| step * slope).sum::<f64>()
                + common.dot(&self.of_common);
        Some((Place { levels, common }, length))
    }

    /// ln of the determinant of the second derivatives by levels and coefficients over σ.
    fn log_determinant(&self, coefficients: usize) -> Option<f64> {
        let levels: f64 = self.diagonal.iter().map(|diagonal| libm::log(*diagonal)).sum();
        if coefficients == 0 {
            return Some(levels);
        }
        let l = self.schur(coefficients).cholesky()?;
        let rest: f64 = (0..coefficients).map(|j| libm::log(l.l_dirty()[(j, j)])).sum();
        Some(levels + 2.0 * rest)
    }
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
    let best = climbed(rows, start(rows, &seen), X + 1)?;
    let here = derivatives(rows, &best);
    let sigma = corrected_sigma(rows, &best)?;
    summary(rows, &best, &here, sigma)
}

/// The maximum over the levels and the first `count` common parameters.
fn climbed<const X: usize>(rows: &[TobitRow<X>], start: Place, count: usize) -> Option<Place> {
    let mut place = start;
    let mut here = derivatives(rows, &place);
    for _ in 0..MOST_STEPS {
        let (step, length) = here.step(count)?;
        if length < SETTLED.max(f64::EPSILON * here.value.abs()) {
            // the likelihood cannot distinguish this step from none any more, while the step still
            // doubles the digits
            return Some(place.moved(&step, 1.0));
        }
        let mut share = 1.0;
        loop {
            let next = place.moved(&step, share);
            if next.h() > 0.0 {
                let there = derivatives(rows, &next);
                if there.value >= here.value {
                    (place, here) = (next, there);
                    break;
                }
            }
            share *= 0.5;
            if share < 1e-10 {
                return Some(place);
            }
        }
    }
    None
}

/// The σ at which the derivative by ln σ of the likelihood without levels and coefficients is zero,
/// by the secant.
fn corrected_sigma<const X: usize>(rows: &[TobitRow<X>], best: &Place) -> Option<f64> {
    let p = (best.levels.len() + X) as f64;
    let at = |log_ratio: f64| {
        // levels and coefficients over σ go with h
        let factor = libm::exp(-log_ratio);
        let levels = best.levels.iter().map(|level| level * factor).collect();
        climbed(rows, Place { levels, common: &best.common * factor }, X)
    };
    let determinant = |log_ratio: f64| derivatives(rows, &at(log_ratio)?).log_determinant(X);
    let slope = |log_ratio: f64| {
        let place = at(log_ratio)?;
        // by ln σ = −ln h; the derivatives by the others are zero
        let of_likelihood = -place.h() * derivatives(rows, &place).of_common[X];
        let more = determinant(log_ratio + DIFFERENCE)?;
        let less = determinant(log_ratio - DIFFERENCE)?;
        // by levels and coefficients themselves the determinant has 2 p ln h more
        Some(of_likelihood + p - 0.5 * (more - less) / (2.0 * DIFFERENCE))
    };
    let (mut a, mut at_a) = (0.0, slope(0.0)?);
    // without cut rows this is the solution
    let n = rows.len() as f64;
    let mut b = -0.5 * libm::log1p(-(p / n).min(0.9));
    for _ in 0..MOST_STEPS {
        let at_b = slope(b)?;
        let change = at_b * (b - a) / (at_b - at_a);
        if !(change.is_finite() && change.abs() > SIGMA_ERROR) {
            break;
        }
        (a, at_a) = (b, at_b);
        b = (b - change).clamp(-LARGEST_CORRECTION, LARGEST_CORRECTION);
    }
    Some(libm::exp(b) / best.h())
}

/// Group means of what is seen, no slope.
fn start<const X: usize>(rows: &[TobitRow<X>], seen: &[usize]) -> Place {
    let groups = seen.len();
    let mut level = vec![0.0; groups];
    for row in rows.iter().filter(|row| !row.cut) {
        level[row.group] += row.y / seen[row.group] as f64;
    }
    let off = rows.iter().filter(|row| !row.cut).map(|row| row.y - level[row.group]);
    let squares: f64 = off.map(|off| off * off).sum();
    let total: usize = seen.iter().sum();
    let h = 1.0 / libm::sqrt(squares / total as f64).max(1e-6);
    let mut common = DVector::zeros(X + 1);
    common[X] = h;
    Place { levels: level.iter().map(|level| h * level).collect(), common }
}

fn derivatives<const X: usize>(rows: &[TobitRow<X>], place: &Place) -> Derivatives {
    let groups = place.levels.len();
    let h = place.h();
    let mut value = CompensatedSum::default();
    let mut of_levels = vec![CompensatedSum::default(); groups];
    let mut of_common = vec![CompensatedSum::default(); X + 1];
    let mut diagonal = vec![0.0; groups];
    let mut border = DMatrix::zeros(groups, X + 1);
    let mut group_corners = DMatrix::<f64>::zeros(groups, (X + 1) * (X + 1));
    let mut group_gradients = DMatrix::<f64>::zeros(groups, X + 1);
    let log_h = libm::log(h);
    // a row's predictors, and -y for h
    let mut entries = vec![0.0; X + 1];
    for row in rows {
        let mut z = h * row.y - place.levels[row.group];
        for j in 0..X {
            z -= row.x[j] * place.common[j];
            entries[j] = row.x[j];
        }
        entries[X] = -row.y;
        let [of_row, slope, bend] = curve(z, row.cut);
        value.add(of_row);
        of_levels[row.group].add(slope);
        diagonal[row.group] += bend;
        for a in 0..=X {
            let along = slope * entries[a];
            of_common[a].add(along);
            group_gradients[(row.group, a)] += along;
            border[(row.group, a)] += bend * entries[a];
            for b in 0..=X {
                group_corners[(row.group, a * (X + 1) + b)] += bend * entries[a] * entries[b];
            }
        }
        if !row.cut {
            value.add(log_h);
            of_common[X].add(1.0 / h);
            group_gradients[(row.group, X)] += 1.0 / h;
            group_corners[(row.group, (X + 1) * (X + 1) - 1)] += 1.0 / (h * h);
        }
    }
    let corner = DMatrix::from_row_iterator(X + 1, X + 1, group_corners.row_sum().iter().copied());
    Derivatives {
        value: value.sum(),
        of_levels: of_levels.iter().map(CompensatedSum::sum).collect(),
        of_common: DVector::from_iterator(X + 1, of_common.iter().map(CompensatedSum::sum)),
        diagonal,
        border,
        corner,
        group_corners,
        group_gradients,
    }
}

/// From (γ, h) to (levels, β, σ), with covariances by the linearised map.
fn summary<const X: usize>(
    rows: &[TobitRow<X>],
    best: &Place,
    here: &Derivatives,
    sigma: f64,
) -> Option<TobitFit> {
    let groups = best.levels.len();
    let of_maximum = 1.0 / best.h();
    // errors are proportional to σ
    let larger = (sigma / of_maximum) * (sigma / of_maximum);
    let inverse = here.schur(X + 1).try_inverse()?;
    // β and σ by γ and h
    let mut map = DMatrix::identity(X + 1, X + 1) * of_maximum;
    for j in 0..X {
        map[(j, X)] = -best.common[j] * of_maximum * of_maximum;
    }
    map[(X, X)] = -of_maximum * of_maximum;
    let all = &map * &inverse * map.transpose() * larger;
    let (mut own_variances, mut level_variances) = (Vec::new(), Vec::new());
    let (mut own, mut together) = (0.0, DVector::zeros(X + 1));
    let mut clusters = Vec::with_capacity(groups);
    for group in 0..groups {
        let border = here.border.row(group).transpose();
        let diagonal = here.diagonal[group];
        clusters.push(here.cluster(group));
        // what an error of the common parameters does to the level
        let mut follows = -of_maximum / diagonal * border;
        follows[X] -= best.levels[group] * of_maximum * of_maximum;
        let alone = of_maximum * of_maximum / diagonal * larger;
        own_variances.push(alone);
        level_variances.push(alone + (&inverse * &follows).dot(&follows) * larger);
        own += alone;
        together += follows;
    }
    let count = groups as f64;
    let moves = (groups > 1).then(|| ClusterMoves::of(&clusters)).flatten();
    let first = map.row(0).transpose();
    let clustered = moves.as_ref().map(|moves| moves.error_of(&first));
    let mean_level = best.levels.iter().sum::<f64>() / count;
    // by its own level, and by what it does to the others through the common parameters
    let clustered_mean_level = moves.map(|moves| {
        with_correlation(best.levels.iter().zip(&moves.moves).map(|(level, moved)| {
            let own = (level - mean_level) * of_maximum * libm::sqrt(count / (count - 1.0));
            ((own + together.dot(moved)) / count, first.dot(moved))
        }))
    });
    let shared = (&inverse * &together).dot(&together) * larger;
    Some(TobitFit {
        levels: best.levels.iter().map(|level| level * of_maximum).collect(),
        level_variances,
        own_variances,
        mean_level_variance: (own + shared) / (count * count),
        clustered_mean_level,
        coefficients: (0..X).map(|j| best.common[j] * of_maximum).collect(),
        covariance: all.view((0, 0), (X, X)).into_owned(),
        clustered,
        sigma,
        sigma_standard_error: libm::sqrt(all[(X, X)]),
        sigma_of_maximum: of_maximum,
        log_likelihood: here.value,
        cut: rows.iter().filter(|row| row.cut).count(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    /// `n` rows of `groups` groups with levels 0, 1, 2, 0, ...
    fn drawn(seed: u64, limit: f64, n: usize, groups: usize) -> Vec<TobitRow<1>> {
        let mut draws = Draws::new(seed, 0, Stream::Vehicle);
        (0..n)
            .map(|k| {
                let (group, x) = (k % groups, draws.normal());
                let y = (group % 3) as f64 + 0.5 * x + 0.7 * draws.normal();
                TobitRow { group, x: [x], y: y.min(limit), cut: y >= limit }
            })
            .collect()
    }

    fn rows(seed: u64, limit: f64) -> Vec<TobitRow<1>> {
        drawn(seed, limit, 6000, 3)
    }

    #[test]
    fn gets_back_what_was_cut() {
        for seed in 1..=3 {
            let fit = fit(&rows(seed, 1.2), 3).unwrap();
            assert!(fit.cut > 1500);
            let mut estimates: Vec<(f64, f64)> =
                fit.levels.iter().copied().zip(fit.level_variances.iter().copied()).collect();
            estimates.push((fit.coefficients[0], fit.covariance[(0, 0)]));
            estimates.push((fit.sigma, fit.sigma_standard_error.powi(2)));
            for ((value, variance), wanted) in estimates.into_iter().zip([0.0, 1.0, 2.0, 0.5, 0.7])
            {
                let error = variance.sqrt();
                assert!(error < 0.05);
                assert!((value - wanted).abs() < 4.0 * error, "{value} ± {error}, {wanted}");
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
        let (b, gram, sd) = (line.coefficients(), line.inverse_gram(), line.residual_sd());
        assert!((fit.levels[0] - b[0]).abs() < 1e-8 && (fit.coefficients[0] - b[1]).abs() < 1e-8);
        // maximum likelihood divides by n, the corrected σ by n less levels and coefficients
        let of_maximum = (line.residual_sum_sq / rows.len() as f64).sqrt();
        assert!((fit.sigma_of_maximum - of_maximum).abs() < 1e-8);
        assert!((fit.sigma - sd).abs() < 1e-7 * sd, "{} {sd}", fit.sigma);
        let error = gram[(1, 1)].sqrt() * sd;
        assert!((fit.covariance[(0, 0)].sqrt() - error).abs() < 1e-6 * error);
        let error = gram[(0, 0)].sqrt() * sd;
        assert!((fit.level_variances[0].sqrt() - error).abs() < 1e-6 * error);
        // the mean level is b0 and a third of each contrast
        let weights = DVector::from_vec(vec![1.0, 0.0, 1.0 / 3.0, 1.0 / 3.0]);
        let variance = (&gram * &weights).dot(&weights) * sd * sd;
        assert!((fit.mean_level_variance / variance - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_maximum_is_one() {
        // by differences: no parameter can be moved to a larger likelihood
        let rows = rows(2, 0.8);
        let best = climbed(&rows, start(&rows, &[1, 1, 1]), 2).unwrap();
        let value = |place: &Place| derivatives(&rows, place).value;
        for step in [-0.01, 0.01] {
            for j in 0..3 {
                let mut moved = best.clone();
                moved.levels[j] += step;
                assert!(value(&moved) < value(&best), "{j}");
            }
            for j in 0..2 {
                let mut moved = best.clone();
                moved.common[j] += step;
                assert!(value(&moved) < value(&best), "{j}");
            }
        }
    }

    #[test]
    fn sigma_of_few_rows_a_group_is_not_too_small() {
        // 60 groups of five rows, a seventh of them cut: over 40 sets the maximum's σ is 10 % too
        // small, the corrected one is right within four of its errors
        let sets: Vec<TobitFit> =
            (0..40).filter_map(|seed| fit(&drawn(seed, 2.3, 300, 60), 60)).collect();
        assert!(sets.len() >= 20, "{}", sets.len());
        let mean = |value_of: fn(&TobitFit) -> f64| {
            sets.iter().map(value_of).sum::<f64>() / sets.len() as f64
        };
        let variance = mean(|fit| (fit.sigma - 0.7).powi(2));
        let error = (variance / sets.len() as f64).sqrt();
        let sigma = mean(|fit| fit.sigma);
        assert!((sigma - 0.7).abs() < 4.0 * error && error < 0.01, "{sigma} ± {error}");
        assert!(mean(|fit| fit.sigma_of_maximum) < 0.66);
    }

    #[test]
    fn a_million_rows_settle() {
        let rows = drawn(4, 1.2, 1_000_000, 4);
        let fit = fit(&rows, 4).unwrap();
        assert!((fit.sigma - 0.7).abs() < 4.0 * fit.sigma_standard_error, "{}", fit.sigma);
        let error = fit.covariance[(0, 0)].sqrt();
        assert!((fit.coefficients[0] - 0.5).abs() < 4.0 * error && error < 0.001);
        // the gradient is zero to rounding: another step changes nothing
        let best = climbed(&rows, start(&rows, &[1; 4]), 2).unwrap();
        let (_, length) = derivatives(&rows, &best).step(2).unwrap();
        assert!(length < 1e-12, "{length}");
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
