//! Variance of the coefficients of a regression whose rows belong to clusters of unequal size: the
//! sandwich in the form CR2, with the degrees of freedom of its own distribution.
//!
//! Of each cluster g enter the information S_g = X_gᵀX_g and the score s_g = X_gᵀe_g, what levels
//! of groups have in them eliminated. With M = (Σ S_g)⁻¹ = L Lᵀ and Q_g = Lᵀ S_g L = V Λ Vᵀ a
//! cluster moves the coefficients by
//!
//! m_g = L (I − Q_g)^(−1/2) Lᵀ s_g,
//!
//! and Σ m_g m_gᵀ is without bias where the rows are independent and alike: a cluster that holds
//! most of the information pulls the line to itself, and (I − Q_g)^(−1/2) restores its residuals.
//! A direction that one cluster alone determines has λ = 1 there: its score is zero whatever was
//! measured, and tells nothing.
//!
//! For a contrast c let w = Lᵀc, u_g = (I − Q_g)^(−1/2) Q_g w and d_g = wᵀ Q_g w. With independent
//! normal rows cᵀ Σ m_g m_gᵀ c is a quadratic form of normal numbers, independent of cᵀβ, whose
//! matrix of clusters is B = diag(d_g + |u_g|²) − U Uᵀ with the rows u_g of U. By Craig's form of
//! the normal law a ratio T of error and standard error lies outside ± q with the probability
//!
//! P(|T| > q) = 2/π ∫ det(I + q² B / (tr B sin²φ))^(−1/2) dφ over 0 to π/2,
//!
//! and the degrees of freedom ν are those of Student's law with the same 97.5 % quantile.
//! Satterthwaite's (tr B)²/tr B² makes intervals of few unequal clusters too wide (97 % for 95 %
//! where five have numbers of rows with a log-SD of 1.1); of many it is as good.
//!
//! Sources: R. M. Bell, D. F. McCaffrey, *Bias reduction in standard errors for linear regression
//! with multi-stage samples*, Survey Methodology 28 (2002) 169-181 \[PK\]; J. E. Pustejovsky, E.
//! Tipton, *Small-sample methods for cluster-robust variance estimation and hypothesis testing in
//! fixed effects models*, J. Bus. Econ. Stat. 36 (2018) 672-683, also for absorbed levels \[PK\];
//! J. W. Craig, IEEE MILCOM (1991) 571-575 \[PK\].

use super::p_value::{NORMAL_975, t_of_interval};
use super::traffic_speed::bisect;
use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};
use std::f64::consts::FRAC_PI_2;

/// Below this, 1 − λ is a direction that its cluster alone determines.
const ALONE: f64 = 1e-8;
/// Share of a contrast's variance that the scores have to see.
const SEEN: f64 = 0.999;
/// Share of the variance from which on a cluster says something of it.
const SAYS: f64 = 1e-9;
/// Level of the interval whose quantile the degrees of freedom give.
const LEVEL: f64 = 0.95;
/// Degrees of freedom from which on Satterthwaite's are good to 0.1 % of an interval.
const MANY: f64 = 200.0;
/// Nodes of the integral over φ = π/2 (10 x³ − 15 x⁴ + 6 x⁵), which flattens both ends.
const NODES: usize = 64;

/// The information and the score of one cluster.
#[derive(Clone, Debug)]
pub(super) struct Cluster {
    /// S_g.
    pub information: DMatrix<f64>,
    /// s_g.
    pub score: DVector<f64>,
}

impl Cluster {
    /// A cluster without a row.
    pub(super) fn nothing(width: usize) -> Self {
        Self { information: DMatrix::zeros(width, width), score: DVector::zeros(width) }
    }

    /// Adds a row with these columns and this residual.
    pub(super) fn add(&mut self, columns: &DVector<f64>, residual: f64) {
        self.information.ger(1.0, columns, columns, 1.0);
        self.score.axpy(residual, columns, 1.0);
    }
}

/// Standard error of a sum of clusters' parts, and its correlation with another one; 0 where one of
/// them does not vary.
pub(super) fn with_correlation(parts: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let [mut square, mut other, mut both] = [0.0; 3];
    for (a, b) in parts {
        square += a * a;
        other += b * b;
        both += a * b;
    }
    let product = libm::sqrt(square * other);
    (libm::sqrt(square), if product > 0.0 { (both / product).clamp(-1.0, 1.0) } else { 0.0 })
}

/// How the clusters move the coefficients of a regression.
#[derive(Clone, Debug)]
pub(super) struct ClusterMoves {
    /// m_g of each cluster.
    pub moves: Vec<DVector<f64>>,
    /// L.
    root: DMatrix<f64>,
    /// Eigenvalues λ and eigenvectors of each Q_g.
    parts: Vec<SymmetricEigen<f64, nalgebra::Dyn>>,
}

/// Standard error of a contrast, with its degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ClusteredError {
    /// Standard error.
    pub standard_error: f64,
    /// Degrees of freedom of Student's law with the same 95 % interval.
    pub degrees: f64,
    /// Clusters that say something of the contrast; 0 where it has a part that one of them alone
    /// determines.
    pub informative: usize,
}

impl ClusteredError {
    /// The error as a study has it: half of the 95 % interval over 1.96.
    pub(super) fn written(&self) -> f64 {
        self.standard_error * t_of_interval(LEVEL, self.degrees) / NORMAL_975
    }
}

impl ClusterMoves {
    /// Moves by these clusters; none where their information does not determine the coefficients.
    pub(super) fn of(clusters: &[Cluster]) -> Option<Self> {
        let width = clusters.first()?.score.len();
        let mut information = DMatrix::zeros(width, width);
        for cluster in clusters {
            information += &cluster.information;
        }
        // M = L Lᵀ with L the inverse of the transposed triangle of Σ S_g
        let triangle = Cholesky::new(information)?.l();
        let root = triangle.try_inverse()?.transpose();
        let (mut moves, mut parts) = (Vec::new(), Vec::new());
        for Cluster { information, score } in clusters {
            let part = SymmetricEigen::new(root.transpose() * information * &root);
            let along = part.eigenvectors.transpose() * (root.transpose() * score);
            let restored = along.zip_map(&part.eigenvalues, |along, share| along * grows(share));
            moves.push(&root * (&part.eigenvectors * restored));
            parts.push(part);
        }
        Some(Self { moves, root, parts })
    }

    /// Standard error of a linear combination of the coefficients.
    pub(super) fn error_of(&self, contrast: &DVector<f64>) -> ClusteredError {
        let w = self.root.transpose() * contrast;
        let mut form =
            Form { diagonal: Vec::new(), off: DMatrix::zeros(self.parts.len(), w.len()) };
        let (mut sum, mut informative) = (0.0, 0);
        for (g, part) in self.parts.iter().enumerate() {
            let along = part.eigenvectors.transpose() * &w;
            let (mut seen, mut u) = (0.0, along.clone());
            for (u, share) in u.iter_mut().zip(&part.eigenvalues) {
                seen += if grows(*share) > 0.0 { share * *u * *u } else { 0.0 };
                *u *= share * grows(*share);
            }
            form.off.set_row(g, &(&part.eigenvectors * &u).transpose());
            form.diagonal.push(seen + u.norm_squared());
            sum += seen;
            informative += usize::from(seen > SAYS * w.norm_squared());
        }
        let variance: f64 = self.moves.iter().map(|moves| contrast.dot(moves)).map(|x| x * x).sum();
        ClusteredError {
            standard_error: libm::sqrt(variance),
            degrees: form.degrees(sum),
            informative: if sum < SEEN * w.norm_squared() { 0 } else { informative },
        }
    }
}

/// The matrix B = diag(`diagonal`) − U Uᵀ.
struct Form {
    diagonal: Vec<f64>,
    /// U.
    off: DMatrix<f64>,
}

impl Form {
    /// ln det(I + s B), by the determinants of its diagonal and of the rest.
    fn ln_determinant(&self, s: f64) -> f64 {
        let width = self.off.ncols();
        let mut rest = DMatrix::identity(width, width);
        let mut ln = 0.0;
        for (diagonal, u) in self.diagonal.iter().zip(self.off.row_iter()) {
            let scale = 1.0 + s * diagonal;
            ln += libm::log(scale);
            for a in 0..width {
                for b in 0..width {
                    rest[(a, b)] -= s / scale * u[a] * u[b];
                }
            }
        }
        ln + libm::log(rest.determinant())
    }

    /// P(|T| > q) with tr B given.
    fn outside(&self, q: f64, trace: f64) -> f64 {
        let node = |k: usize| {
            let x = (k as f64 + 0.5) / NODES as f64;
            let phi = FRAC_PI_2 * x * x * x * (10.0 + x * (6.0 * x - 15.0));
            let weight = 30.0 * x * x * (1.0 - x) * (1.0 - x);
            let sine = libm::sin(phi);
            weight * libm::exp(-0.5 * self.ln_determinant(q * q / (trace * sine * sine)))
        };
        (0..NODES).map(node).sum::<f64>() / NODES as f64
    }

    fn degrees(&self, trace: f64) -> f64 {
        let products = self.off.transpose() * &self.off;
        let rows = self.diagonal.iter().zip(self.off.row_iter());
        let of_diagonal = rows.map(|(d, u)| d * d - 2.0 * d * u.norm_squared()).sum::<f64>();
        let satterthwaite = trace * trace / (of_diagonal + products.norm_squared());
        if !(satterthwaite < MANY) {
            return satterthwaite;
        }
        let q = bisect(1.0, t_of_interval(LEVEL, 1.0), |q| 1.0 - LEVEL - self.outside(q, trace));
        libm::exp(bisect(0.0, libm::log(MANY), |ln| q - t_of_interval(LEVEL, libm::exp(ln))))
    }
}

/// (1 − λ)^(−1/2), and 0 where the cluster alone determines the direction.
fn grows(share: f64) -> f64 {
    let left = 1.0 - share;
    if left > ALONE { 1.0 / libm::sqrt(left) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    /// Rows of x and y of clusters of these sizes, a level of its own in each.
    fn clusters(sizes: &[usize], draws: &mut Draws) -> Vec<Vec<[f64; 3]>> {
        let cluster = |n: &usize| {
            let level = draws.normal();
            (0..*n).map(|_| [1.0, 0.5 * level + draws.normal(), draws.normal()]).collect()
        };
        sizes.iter().map(cluster).collect()
    }

    /// The cluster of rows [1, x, e] with its level eliminated.
    fn eliminated(rows: &[[f64; 3]], slope: f64) -> Cluster {
        let n = rows.len() as f64;
        let mean = |k: usize| rows.iter().map(|row| row[k]).sum::<f64>() / n;
        let (x, y) = (mean(1), mean(2));
        let mut cluster = Cluster { information: DMatrix::zeros(1, 1), score: DVector::zeros(1) };
        for row in rows {
            cluster.information[(0, 0)] += (row[1] - x) * (row[1] - x);
            cluster.score[0] += (row[1] - x) * (row[2] - y - slope * (row[1] - x));
        }
        cluster
    }

    /// The same by matrices of all rows, levels as columns: A_g = (I − H_gg)^(−1/2) by its
    /// eigenvalues.
    #[test]
    fn without_levels_eliminated_it_is_the_same_by_matrices_of_all_rows() {
        let sizes = [9, 2, 5, 3];
        let rows = clusters(&sizes, &mut Draws::new(4, 0, Stream::Vehicle));
        let n: usize = sizes.iter().sum();
        let mut x = DMatrix::zeros(n, 1 + sizes.len());
        let mut y = DVector::zeros(n);
        let mut starts = vec![0];
        for (g, cluster) in rows.iter().enumerate() {
            let start = starts[g];
            for (k, row) in cluster.iter().enumerate() {
                x[(start + k, 0)] = row[1];
                x[(start + k, 1 + g)] = 1.0;
                y[start + k] = row[2];
            }
            starts.push(start + cluster.len());
        }
        let inverse = (x.transpose() * &x).try_inverse().unwrap();
        let left = DMatrix::identity(n, n) - &x * &inverse * x.transpose();
        let residual = &left * &y;
        let slope = (&inverse * x.transpose() * &y)[0];
        // columns p_g of the quadratic form Σ (p_gᵀ y)²
        let mut columns = DMatrix::zeros(n, sizes.len());
        let mut variance = 0.0;
        for g in 0..sizes.len() {
            let (start, size) = (starts[g], sizes[g]);
            let own = left.view((start, start), (size, size)).into_owned();
            let parts = SymmetricEigen::new(own);
            let root =
                parts.eigenvalues.map(|value| if value > 1e-9 { value.powf(-0.5) } else { 0.0 });
            let a = &parts.eigenvectors
                * DMatrix::from_diagonal(&root)
                * parts.eigenvectors.transpose();
            let pulls = a * x.rows(start, size) * inverse.column(0);
            let p = left.columns(start, size) * &pulls;
            columns.set_column(g, &p);
            variance += pulls.dot(&residual.rows(start, size)).powi(2);
        }
        let own: Vec<Cluster> = rows.iter().map(|rows| eliminated(rows, slope)).collect();
        let slope_error = ClusterMoves::of(&own).unwrap().error_of(&DVector::from_element(1, 1.0));
        let products = columns.transpose() * &columns;
        // the 97.5 % quantile of that form, by its eigenvalues and draws
        let shares = SymmetricEigen::new(products.clone()).eigenvalues / products.trace();
        let mut draws = Draws::new(5, 0, Stream::Vehicle);
        let mut normal = || draws.normal();
        let (runs, reach) = (400_000, t_of_interval(0.95, slope_error.degrees));
        let outside = (0..runs).filter(|_| {
            let spread: f64 = shares.iter().map(|share| share * normal().powi(2)).sum();
            normal().powi(2) > reach * reach * spread
        });
        let (outside, error) =
            (outside.count() as f64 / runs as f64, (0.0475 / runs as f64).sqrt());
        assert!((outside - 0.05).abs() < 4.0 * error, "{outside}");
        assert!(
            (slope_error.standard_error / variance.sqrt() - 1.0).abs() < 1e-12,
            "{slope_error:?}"
        );
        assert_eq!(slope_error.informative, 4);
    }

    #[test]
    fn equal_clusters_are_counted_less_one() {
        let mut draws = Draws::new(1, 0, Stream::Vehicle);
        let cluster = |_| Cluster {
            information: DMatrix::from_element(1, 1, 2.0),
            score: DVector::from_element(1, draws.normal()),
        };
        let clusters: Vec<Cluster> = (0..7).map(cluster).collect();
        let error = ClusterMoves::of(&clusters).unwrap().error_of(&DVector::from_element(1, 1.0));
        assert!((error.degrees - 6.0).abs() < 1e-6, "{error:?}");
        // G/(G − 1) times the plain sandwich
        let plain: f64 = clusters.iter().map(|cluster| (cluster.score[0] / 14.0).powi(2)).sum();
        assert!((error.standard_error - (7.0 / 6.0 * plain).sqrt()).abs() < 1e-14);
    }

    #[test]
    fn a_cluster_that_determines_a_coefficient_alone_says_nothing_of_its_error() {
        let rows = clusters(&[300, 1, 1, 1, 1], &mut Draws::new(2, 0, Stream::Vehicle));
        let own: Vec<Cluster> = rows.iter().map(|rows| eliminated(rows, 0.1)).collect();
        let error = ClusterMoves::of(&own).unwrap().error_of(&DVector::from_element(1, 1.0));
        assert_eq!((error.informative, error.standard_error), (0, 0.0));
    }
}
