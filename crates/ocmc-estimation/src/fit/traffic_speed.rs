//! The traffic model of measured speeds: floating cars, which scatter around the traffic's speed.
//!
//! Measured is r = exp(−½ (x/x_c)²) + noise with logit x = logit m_r(H) + u. On an almost empty
//! road r is close to 1, where a density that is worked out of each speed is the noise's: such
//! densities are not used. What noise without a mean and without memory leaves as it is, is taken
//! instead:
//!
//! - the mean of r at each hour, E exp(−½ (x/x_c)²) over u, gives the typical shares (least
//!   squares, Gauss and Newton's method);
//! - the products of the deviations of records one and two intervals apart give SD and correlation
//!   of u: by Mehler's formula their means are Σ_h a_h a_h' ρ^h and Σ_h a_h a_h' ρ^(2h) with the
//!   Hermite coefficients a_h of r as a function of u.
//!
//! The scatter beyond that of u is the noise. Standard errors are those of the estimating equations
//! with the days of a site as observations (sandwich), times t₀.₉₇₅(ν)/1.96: ν is one less than as
//! many days of equal size would be, (Σ n)²/Σ n² for days of n records.

use super::p_value::{NORMAL_975, t_of_interval};
use super::traffic::{EDGE, FEWEST_DAYS, SAME_INTERVAL, SEEN};
use nalgebra::DMatrix;
use ocmc_core::operating_cycle::traffic::TrafficModel;

/// Hermite coefficients that are kept, the mean included.
const ORDERS: usize = 7;
/// Reach and number of the nodes of integrals over u.
const REACH: f64 = 5.0;
const NODES: usize = 41;
/// Heights of the peak at which a type's law is worked out; linear between them.
const HEIGHTS: usize = 65;
/// Rounds after which a search is given up.
const MOST_ROUNDS: usize = 100;
/// SDs of u between which the answer is looked for.
const SPREADS: [f64; 2] = [0.02, 4.0];
/// Step of derivatives by shares and by SD and correlation.
const DIFFERENCE: f64 = 1e-4;

/// A measured speed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Speed {
    /// Place of its road type.
    pub of_type: usize,
    /// Height of the day's peak, 0 to 1.
    pub bell: f64,
    /// Speed over that of the empty road.
    pub ratio: f64,
    /// Day of its site.
    pub day: usize,
}

/// Parameters that speeds determine.
#[derive(Clone, Debug)]
pub(super) struct SpeedFit {
    /// Off-peak and peak share of each type.
    pub shares: Vec<[f64; 2]>,
    /// SD of u.
    pub logit_sd: f64,
    /// Correlation of u over an interval of the records.
    pub correlation: f64,
    /// SD of the noise of a speed ratio.
    pub noise_sd: f64,
    /// Standard errors, in this order: off-peak and peak share of each type, SD, correlation; none
    /// where there are too few days.
    pub errors: Option<Vec<f64>>,
}

/// The law of a type's speed ratios at heights of the peak: Hermite coefficients a_0, a_1, …
type Table = Vec<[f64; ORDERS]>;

/// Mean and Hermite coefficients of the ratio at a share.
fn law(share: f64, logit_sd: f64, critical: f64) -> [f64; ORDERS] {
    let mut coefficients = [0.0; ORDERS];
    let step = 2.0 * REACH / (NODES - 1) as f64;
    let odds = share / (1.0 - share);
    for node in 0..NODES {
        let g = step * node as f64 - REACH;
        let weight = step * libm::exp(-0.5 * g * g) / libm::sqrt(2.0 * std::f64::consts::PI);
        let odds = odds * libm::exp(logit_sd * g);
        let density = odds / (1.0 + odds) / critical;
        let ratio = weight * libm::exp(-0.5 * density * density);
        let (mut before, mut here) = (0.0, 1.0);
        for (m, sum) in coefficients.iter_mut().enumerate() {
            *sum += ratio * here;
            let order = m as f64;
            let next = (g * here - libm::sqrt(order) * before) / libm::sqrt(order + 1.0);
            (before, here) = (here, next);
        }
    }
    coefficients
}

fn table([off, peak]: [f64; 2], logit_sd: f64, critical: f64) -> Table {
    let height = |k: usize| k as f64 / (HEIGHTS - 1) as f64;
    (0..HEIGHTS).map(|k| law(off + (peak - off) * height(k), logit_sd, critical)).collect()
}

fn at(table: &Table, bell: f64) -> [f64; ORDERS] {
    let place = bell.clamp(0.0, 1.0) * (HEIGHTS - 1) as f64;
    let k = (place as usize).min(HEIGHTS - 2);
    let part = place - k as f64;
    std::array::from_fn(|m| table[k][m] + part * (table[k + 1][m] - table[k][m]))
}

/// Speeds with the pairs that are one and two intervals apart.
pub(super) struct Speeds<'a> {
    pub rows: Vec<Speed>,
    pub types: usize,
    pub pairs: [Vec<[usize; 2]>; 2],
    pub base: &'a TrafficModel,
}

/// Pairs of rows of one site one and two intervals apart, of rows (site, time, row); and the
/// interval.
pub(super) fn pairs<'a>(
    rows: impl IntoIterator<Item = (&'a str, f64, usize)>,
) -> ([Vec<[usize; 2]>; 2], f64) {
    let mut sites: std::collections::BTreeMap<&str, Vec<(f64, usize)>> =
        std::collections::BTreeMap::new();
    for (site, time_s, row) in rows {
        sites.entry(site).or_default().push((time_s, row));
    }
    let steps = sites.values().flat_map(|rows| rows.windows(2).map(|w| w[1].0 - w[0].0));
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let Some(&interval) = steps.get(steps.len() / 2) else { return Default::default() };
    let apart = |a: (f64, usize), b: (f64, usize), lag: f64| {
        let off = (b.0 - a.0 - lag * interval).abs();
        (off <= SAME_INTERVAL * interval).then_some([a.1, b.1])
    };
    let one = sites.values().flat_map(|rows| rows.windows(2).map(|w| apart(w[0], w[1], 1.0)));
    let two = sites.values().flat_map(|rows| rows.windows(3).map(|w| apart(w[0], w[2], 2.0)));
    ([one.flatten().collect(), two.flatten().collect()], interval)
}

impl Speeds<'_> {
    fn critical(&self) -> f64 {
        self.base.critical_share
    }

    fn tables(&self, shares: &[[f64; 2]], logit_sd: f64) -> Vec<Table> {
        shares.iter().map(|shares| table(*shares, logit_sd, self.critical())).collect()
    }

    /// Fits; none where the speeds do not determine SD and correlation, or the search does not end.
    pub(super) fn fit(&self) -> Option<SpeedFit> {
        let mut shares: Vec<[f64; 2]> =
            (0..self.types).map(|of_type| self.start(of_type)).collect::<Option<_>>()?;
        let (mut logit_sd, mut correlation) = (self.base.logit_sd.max(0.1), 0.5);
        for round in 0.. {
            for (of_type, shares) in shares.iter_mut().enumerate() {
                *shares = self.typical(of_type, *shares, logit_sd)?;
            }
            let before = logit_sd;
            (logit_sd, correlation) = self.spread(&shares)?;
            if (logit_sd - before).abs() < 1e-7 {
                break;
            }
            if round == MOST_ROUNDS {
                return None;
            }
        }
        let tables = self.tables(&shares, logit_sd);
        let mut beyond = 0.0;
        for row in &self.rows {
            let law = at(&tables[row.of_type], row.bell);
            let own: f64 = law[1..].iter().map(|a| a * a).sum();
            beyond += (row.ratio - law[0]) * (row.ratio - law[0]) - own;
        }
        let noise_sd = libm::sqrt((beyond / self.rows.len() as f64).max(0.0));
        let errors = self.errors(&shares, logit_sd, correlation);
        Some(SpeedFit { shares, logit_sd, correlation, noise_sd, errors })
    }

    /// Shares with the mean speeds off peak and at the peak.
    fn start(&self, of_type: usize) -> Option<[f64; 2]> {
        let mean = |low: f64, high: f64| {
            let within =
                |row: &&Speed| row.of_type == of_type && row.bell >= low && row.bell <= high;
            let (n, sum) = self
                .rows
                .iter()
                .filter(within)
                .fold((0.0, 0.0), |(n, sum), row| (n + 1.0, sum + row.ratio));
            let share = self.base.share_at((sum / n).min(0.999));
            share.is_finite().then(|| share.clamp(EDGE, 0.9))
        };
        Some([mean(0.0, SEEN[0])?, mean(SEEN[1], 1.0)?])
    }

    /// Typical shares of a type by least squares of the ratios.
    fn typical(&self, of_type: usize, start: [f64; 2], logit_sd: f64) -> Option<[f64; 2]> {
        let mut shares = start;
        for _ in 0..MOST_ROUNDS {
            let (normal, right) = self.normal_equations(of_type, shares, logit_sd);
            let determinant = normal[0] * normal[2] - normal[1] * normal[1];
            if !(determinant > 1e-9 * normal[0] * normal[2]) {
                return None;
            }
            let change = [
                (normal[2] * right[0] - normal[1] * right[1]) / determinant,
                (normal[0] * right[1] - normal[1] * right[0]) / determinant,
            ];
            // at most half the way to an edge
            for (share, change) in shares.iter_mut().zip(change) {
                *share += change.clamp(-0.5 * *share, 0.5 * (1.0 - *share));
            }
            if change.iter().all(|change| change.abs() < 1e-10) {
                return Some(shares);
            }
        }
        None
    }

    /// Slopes of the mean ratio by both shares, at the heights of the table.
    fn slopes(&self, shares: [f64; 2], logit_sd: f64) -> [Table; 2] {
        std::array::from_fn(|k| {
            let moved = |step: f64| {
                let mut shares = shares;
                shares[k] += step;
                table(shares, logit_sd, self.critical())
            };
            let step = DIFFERENCE * shares[k];
            let (more, less) = (moved(step), moved(-step));
            let slope = |(a, b): (&[f64; ORDERS], &[f64; ORDERS])| {
                std::array::from_fn(|m| (a[m] - b[m]) / (2.0 * step))
            };
            more.iter().zip(&less).map(slope).collect()
        })
    }

    fn normal_equations(
        &self,
        of_type: usize,
        shares: [f64; 2],
        logit_sd: f64,
    ) -> ([f64; 3], [f64; 2]) {
        let means = table(shares, logit_sd, self.critical());
        let slopes = self.slopes(shares, logit_sd);
        let (mut normal, mut right) = ([0.0; 3], [0.0; 2]);
        for row in self.rows.iter().filter(|row| row.of_type == of_type) {
            let off = row.ratio - at(&means, row.bell)[0];
            let [a, b] = [0, 1].map(|k| at(&slopes[k], row.bell)[0]);
            normal[0] += a * a;
            normal[1] += a * b;
            normal[2] += b * b;
            right[0] += a * off;
            right[1] += b * off;
        }
        (normal, right)
    }

    /// SD and correlation of u from the products of deviations one and two intervals apart.
    fn spread(&self, shares: &[[f64; 2]]) -> Option<(f64, f64)> {
        // the means move with the SD only little: they are taken again in the next round
        let [near, far] = [0, 1].map(|lag| {
            move |logit_sd: f64| {
                let tables = self.tables(shares, logit_sd);
                let mut sums = [0.0; ORDERS];
                for [a, b] in &self.pairs[lag] {
                    let (a, b) = (&self.rows[*a], &self.rows[*b]);
                    let (of_a, of_b) =
                        (at(&tables[a.of_type], a.bell), at(&tables[b.of_type], b.bell));
                    sums[0] += (a.ratio - of_a[0]) * (b.ratio - of_b[0]);
                    for m in 1..ORDERS {
                        sums[m] += of_a[m] * of_b[m];
                    }
                }
                sums
            }
        });
        let series = |sums: &[f64; ORDERS], rho: f64| {
            sums[1..].iter().rev().fold(0.0, |sum, of_order| rho * (sum + of_order))
        };
        // with the SD whose products one interval apart fit, what two intervals apart are too large
        let solved_at = |logit_sd: f64| {
            let sums = near(logit_sd);
            let rho = bisect(0.0, 1.0, |rho| series(&sums, rho) - sums[0]);
            let far = far(logit_sd);
            // not even with a correlation of 1 are the products as large as they were measured
            let too_small = series(&sums, 1.0) < sums[0];
            let off = if too_small { f64::INFINITY } else { series(&far, rho * rho) - far[0] };
            (off, rho, sums[0] > 0.0 && far[0] > 0.0)
        };
        let (at_low, _, known) = solved_at(SPREADS[0]);
        let (at_high, _, still) = solved_at(SPREADS[1]);
        if !(known && still && at_low > 0.0 && at_high < 0.0) {
            return None;
        }
        let logit_sd = bisect(SPREADS[0], SPREADS[1], |sd| -solved_at(sd).0);
        Some((logit_sd, solved_at(logit_sd).1))
    }

    /// Standard errors by the sandwich, days of sites as observations.
    fn errors(&self, shares: &[[f64; 2]], logit_sd: f64, correlation: f64) -> Option<Vec<f64>> {
        let size = 2 * self.types + 2;
        let days = self.rows.iter().map(|row| row.day).max()? + 1;
        let slopes: Vec<[Table; 2]> =
            shares.iter().map(|shares| self.slopes(*shares, logit_sd)).collect();
        let equations = |theta: &[f64]| {
            let shares: Vec<[f64; 2]> =
                (0..self.types).map(|k| [theta[2 * k], theta[2 * k + 1]]).collect();
            let tables = self.tables(&shares, theta[size - 2]);
            let mut sums = vec![vec![0.0; size]; days];
            for row in &self.rows {
                let off = row.ratio - at(&tables[row.of_type], row.bell)[0];
                for k in 0..2 {
                    sums[row.day][2 * row.of_type + k] +=
                        off * at(&slopes[row.of_type][k], row.bell)[0];
                }
            }
            for (lag, pairs) in self.pairs.iter().enumerate() {
                let rho = libm::pow(theta[size - 1], (lag + 1) as f64);
                for [a, b] in pairs {
                    let (a, b) = (&self.rows[*a], &self.rows[*b]);
                    let (of_a, of_b) =
                        (at(&tables[a.of_type], a.bell), at(&tables[b.of_type], b.bell));
                    let mut power = 1.0;
                    let mut expected = 0.0;
                    for m in 1..ORDERS {
                        power *= rho;
                        expected += of_a[m] * of_b[m] * power;
                    }
                    sums[b.day][size - 2 + lag] +=
                        (a.ratio - of_a[0]) * (b.ratio - of_b[0]) - expected;
                }
            }
            sums
        };
        let mut theta: Vec<f64> = shares.iter().flatten().copied().collect();
        theta.extend([logit_sd, correlation]);
        let total = |theta: &[f64]| {
            let sums = equations(theta);
            (0..size).map(|k| sums.iter().map(|day| day[k]).sum()).collect::<Vec<f64>>()
        };
        let mut jacobian = DMatrix::zeros(size, size);
        for k in 0..size {
            let step = DIFFERENCE * theta[k];
            let moved = |step: f64| {
                let mut theta = theta.clone();
                theta[k] += step;
                total(&theta)
            };
            let (more, less) = (moved(step), moved(-step));
            for j in 0..size {
                jacobian[(j, k)] = (more[j] - less[j]) / (2.0 * step);
            }
        }
        let mut sizes = vec![0.0; days];
        for row in &self.rows {
            sizes[row.day] += 1.0;
        }
        let wider = wider(&sizes)?;
        let covariance = covariance(&jacobian, &equations(&theta))?;
        Some((0..size).map(|k| wider * libm::sqrt(covariance[(k, k)])).collect())
    }
}

/// Covariance of estimates at which the sum over days of their equations is zero: J⁻¹ (Σ g gᵀ) J⁻ᵀ
/// with J the derivative of the sum.
fn covariance(jacobian: &DMatrix<f64>, days: &[Vec<f64>]) -> Option<DMatrix<f64>> {
    let size = jacobian.nrows();
    let mut middle = DMatrix::zeros(size, size);
    for day in days {
        for a in 0..size {
            for b in 0..size {
                middle[(a, b)] += day[a] * day[b];
            }
        }
    }
    let inverse = jacobian.clone().try_inverse()?;
    let covariance = &inverse * middle * inverse.transpose();
    (0..size).all(|k| covariance[(k, k)] >= 0.0).then_some(covariance)
}

/// How much wider than by the sandwich alone an interval of ± 1.96 errors is with days of these
/// sizes; none with too few days.
fn wider(sizes: &[f64]) -> Option<f64> {
    let used = sizes.iter().filter(|size| **size > 0.0).count();
    let (sum, squares) = sizes.iter().fold((0.0, 0.0), |(a, b), n| (a + n, b + n * n));
    let days = sum * sum / squares;
    let enough = used >= FEWEST_DAYS && days > 2.0;
    enough.then(|| t_of_interval(0.95, days - 1.0) / NORMAL_975 * libm::sqrt(days / (days - 1.0)))
}

/// Where a rising function is zero; an end where it is not.
pub(super) fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
