//! Ridge regression on (what is known of a trip) × (1, scores), its penalty by leaving out groups
//! of members (cross-validation).

use nalgebra::{DMatrix, DVector};

/// Groups of members, one of which is left out at a time.
const GROUPS: usize = 10;
/// Penalties that are tried, in rows: the largest leave nothing of the scores, where they say
/// nothing.
const PENALTIES: [f64; 7] = [1.0, 10.0, 100.0, 1000.0, 1e4, 1e5, 1e6];

/// Sums over the rows of a group of members.
#[derive(Clone, Debug)]
struct Sums {
    gram: DMatrix<f64>,
    products: DMatrix<f64>,
}

/// A response over what is known of a trip, x, and the scores z: y ≈ xᵀ C (1, z).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Surface {
    /// A row an x, a column for 1 and for each z.
    pub(super) coefficients: DMatrix<f64>,
    /// Mean square of the mean residuals of members that were left out, what their trips' residuals
    /// add to it taken off.
    pub(super) lack_of_fit: f64,
}

impl Surface {
    /// The response.
    pub(super) fn at(&self, x: &[f64], scores: &[f64]) -> f64 {
        let gradient =
            |z: usize| (0..x.len()).map(|k| x[k] * self.coefficients[(k, z)]).sum::<f64>();
        gradient(0)
            + scores.iter().enumerate().map(|(z, score)| score * gradient(z + 1)).sum::<f64>()
    }

    /// Its derivatives by the scores.
    pub(super) fn gradient(&self, x: &[f64]) -> DVector<f64> {
        let scores = self.coefficients.ncols() - 1;
        DVector::from_fn(scores, |z, _| {
            (0..x.len()).map(|k| x[k] * self.coefficients[(k, z + 1)]).sum::<f64>()
        })
    }
}

/// The rows of a member: x of each trip, and its responses.
pub(super) struct MemberRows<'a> {
    pub(super) scores: &'a [f64],
    pub(super) x: Vec<Vec<f64>>,
    pub(super) y: Vec<Vec<f64>>,
}

impl MemberRows<'_> {
    fn features(&self, x: &[f64]) -> DVector<f64> {
        let width = 1 + self.scores.len();
        DVector::from_fn(x.len() * width, |place, _| {
            let (k, z) = (place / width, place % width);
            x[k] * if z == 0 { 1.0 } else { self.scores[z - 1] }
        })
    }
}

/// Fits each response of the rows.
pub(super) fn surfaces(members: &[MemberRows], responses: usize) -> Vec<Surface> {
    let width = 1 + members[0].scores.len();
    let known = members[0].x[0].len();
    let size = known * width;
    let groups = GROUPS.min(members.len()).max(1);
    let zero =
        || Sums { gram: DMatrix::zeros(size, size), products: DMatrix::zeros(size, responses) };
    let mut sums: Vec<Sums> = (0..groups).map(|_| zero()).collect();
    for (m, member) in members.iter().enumerate() {
        // the rows of a member at once
        let rows = member.x.len();
        let mut matrix = DMatrix::zeros(size, rows);
        for (k, x) in member.x.iter().enumerate() {
            matrix.set_column(k, &member.features(x));
        }
        let y = DMatrix::from_fn(rows, responses, |k, j| member.y[k][j]);
        let group = &mut sums[m % groups];
        group.gram += &matrix * matrix.transpose();
        group.products += &matrix * y;
    }
    let mut all = zero();
    for group in &sums {
        all.gram += &group.gram;
        all.products += &group.products;
    }
    // shrunk: what the scores do, and more what they do to the slopes of x
    let penalty = DVector::from_fn(size, |place, _| {
        let (k, z) = (place / width, place % width);
        if z == 0 {
            1e-6
        } else if k == 0 {
            1.0
        } else {
            3.0
        }
    });
    let solved = |gram: &DMatrix<f64>, products: &DMatrix<f64>, lambda: f64| {
        let mut matrix = gram.clone();
        for k in 0..size {
            matrix[(k, k)] += lambda * penalty[k];
        }
        matrix.cholesky().map_or_else(|| DMatrix::zeros(size, responses), |c| c.solve(products))
    };
    // square of the mean residual of members left out, by penalty and response
    let mut errors = DMatrix::<f64>::zeros(PENALTIES.len(), responses);
    for (l, &lambda) in PENALTIES.iter().enumerate() {
        for (g, group) in sums.iter().enumerate() {
            let rest =
                solved(&(&all.gram - &group.gram), &(&all.products - &group.products), lambda);
            for member in members.iter().skip(g).step_by(groups) {
                for j in 0..responses {
                    let residuals: Vec<f64> = (member.x.iter().zip(&member.y))
                        .map(|(x, y)| y[j] - member.features(x).dot(&rest.column(j)))
                        .collect();
                    let n = residuals.len() as f64;
                    let mean = residuals.iter().sum::<f64>() / n;
                    errors[(l, j)] += mean * mean / members.len() as f64;
                }
            }
        }
    }
    let surface = |j: usize| {
        let best = (0..PENALTIES.len()).min_by(|a, b| errors[(*a, j)].total_cmp(&errors[(*b, j)]));
        let best = best.unwrap_or(0);
        let solution = solved(&all.gram, &all.products, PENALTIES[best]);
        let coefficients = DMatrix::from_fn(known, width, |k, z| solution[(k * width + z, j)]);
        let surface = Surface { coefficients, lack_of_fit: 0.0 };
        let sampling = members.iter().map(|member| {
            let n = member.x.len() as f64;
            let residual = |(x, y): (&Vec<f64>, &Vec<f64>)| y[j] - surface.at(x, member.scores);
            let all: Vec<f64> = member.x.iter().zip(&member.y).map(residual).collect();
            let mean = all.iter().sum::<f64>() / n;
            all.iter().map(|r| (r - mean) * (r - mean)).sum::<f64>() / (n - 1.0).max(1.0) / n
        });
        let sampling = sampling.sum::<f64>() / members.len() as f64;
        Surface { lack_of_fit: (errors[(best, j)] - sampling).max(0.0), ..surface }
    };
    (0..responses).map(surface).collect()
}

/// A number of each member over its scores.
#[derive(Clone, Debug, PartialEq)]
pub struct MemberEmulator {
    surface: Surface,
}

impl MemberEmulator {
    /// Fits the numbers of members with these scores.
    pub fn fit(scores: &[Vec<f64>], numbers: &[f64]) -> Self {
        let pair = |(scores, number): (&'_ Vec<f64>, &f64)| (scores.clone(), *number);
        let all: Vec<(Vec<f64>, f64)> = scores.iter().zip(numbers).map(pair).collect();
        let rows: Vec<MemberRows> = all
            .iter()
            .map(|(scores, number)| MemberRows {
                scores,
                x: vec![vec![1.0]],
                y: vec![vec![*number]],
            })
            .collect();
        let surface = surfaces(&rows, 1).remove(0);
        Self { surface }
    }

    /// The number of scores, and its derivatives by them.
    pub fn at(&self, scores: &[f64]) -> (f64, DVector<f64>) {
        (self.surface.at(&[1.0], scores), self.surface.gradient(&[1.0]))
    }

    /// Mean square of what the scores leave.
    pub fn lack_of_fit(&self) -> f64 {
        self.surface.lack_of_fit
    }
}
