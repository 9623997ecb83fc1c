//! Rows far from all others of their group, such as a trip that was written down twice.
//!
//! y = group + Xβ + e. Groups' medians are the start; then in turn β within groups of the rows that
//! count, a scale by the median of absolute residuals, and anew which rows lie further than
//! [`FAR`] scales away. A group's level is drawn to that of all by one row, so that of two rows the
//! one that is far is found.

use nalgebra::{Cholesky, DMatrix, DVector};

/// SDs from which on a row is far: of a normal law one in two million.
pub const FAR: f64 = 5.0;
/// The same, of residuals from medians alone.
const FAR_OF_MEDIANS: f64 = 8.0;
/// Median of the absolute value of a standard normal number, inverted.
const SD_OF_MEDIAN: f64 = 1.482_602_218_505_602;
const MOST_TURNS: usize = 20;

/// Within groups: the slopes that rows have, and which columns these are of; a column that does
/// not vary within groups, or that others determine, has none.
#[derive(Clone, Debug, PartialEq)]
pub struct WithinGroups {
    /// The columns that have a slope.
    pub columns: Vec<usize>,
    /// The slopes.
    pub slopes: Vec<f64>,
}

/// Share of a column's square within groups below which others determine it.
const COLLINEAR: f64 = 1e-6;

impl WithinGroups {
    /// Fits the rows that count.
    pub fn fit(value: &[f64], columns: &[Vec<f64>], group: &[usize], counts: &[bool]) -> Self {
        let rows = || (0..value.len()).filter(|k| counts[*k]);
        let groups = group.iter().max().map_or(0, |last| last + 1);
        let centred = |values: &[f64]| -> Vec<f64> {
            let mut sums = vec![(0.0, 0.0); groups];
            for k in rows() {
                sums[group[k]].0 += values[k];
                sums[group[k]].1 += 1.0;
            }
            rows().map(|k| values[k] - sums[group[k]].0 / sums[group[k]].1).collect()
        };
        let y = centred(value);
        let x: Vec<Vec<f64>> = columns.iter().map(|column| centred(column)).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut kept: Vec<usize> = Vec::new();
        let mut orthogonal: Vec<Vec<f64>> = Vec::new();
        for (place, column) in x.iter().enumerate() {
            let mut left = column.clone();
            for other in &orthogonal {
                let along = dot(&left, other) / dot(other, other);
                for (left, other) in left.iter_mut().zip(other) {
                    *left -= along * other;
                }
            }
            // beside rounding of the values themselves
            let size = columns[place].iter().map(|x| x * x).sum::<f64>();
            let whole = dot(column, column);
            if whole > 1e-12 * size && dot(&left, &left) > COLLINEAR * whole {
                kept.push(place);
                orthogonal.push(left);
            }
        }
        let p = kept.len();
        let gram = DMatrix::from_fn(p, p, |a, b| dot(&x[kept[a]], &x[kept[b]]));
        let products = DVector::from_fn(p, |a, _| dot(&x[kept[a]], &y));
        match Cholesky::new(gram) {
            Some(factor) if p > 0 => {
                let slopes = factor.solve(&products).iter().copied().collect();
                Self { columns: kept, slopes }
            }
            _ => Self { columns: Vec::new(), slopes: Vec::new() },
        }
    }

    fn at(&self, columns: &[Vec<f64>], row: usize) -> f64 {
        self.columns.iter().zip(&self.slopes).map(|(c, slope)| slope * columns[*c][row]).sum()
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 {
        return 0.0;
    }
    f64::midpoint(values[(n - 1) / 2], values[n / 2])
}

/// Variance of each row beside its group and the slopes, a + b s² with s the SD that was expected
/// of it: what a row varies by beside that is a.
///
/// The squares of the residuals are fitted with weights s⁻⁴, their variances but for a factor.
pub fn variances(value: &[f64], columns: &[Vec<f64>], group: &[usize], sd: &[f64]) -> Vec<f64> {
    let n = value.len();
    let within = WithinGroups::fit(value, columns, group, &vec![true; n]);
    let groups = group.iter().max().map_or(0, |last| last + 1);
    let rest: Vec<f64> = (0..n).map(|k| value[k] - within.at(columns, k)).collect();
    let mut sums = vec![(0.0, 0.0); groups];
    for k in 0..n {
        sums[group[k]].0 += rest[k];
        sums[group[k]].1 += 1.0;
    }
    // sums of 1, s², s⁴ and of the squares with 1 and s², each over s⁴
    let mut sum = [0.0; 5];
    for k in 0..n {
        let (total, count) = sums[group[k]];
        if count < 2.0 {
            continue;
        }
        let off = rest[k] - total / count;
        let square = off * off * count / (count - 1.0);
        let s2 = sd[k] * sd[k];
        let weight = 1.0 / (s2 * s2);
        let terms = [1.0, s2, s2 * s2, square, s2 * square];
        sum.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
    }
    let [one, by, square, y, with] = sum;
    let determinant = one * square - by * by;
    let mut components =
        [(square * y - by * with) / determinant, (one * with - by * y) / determinant];
    if !(determinant > 1e-9 * one * square) || components[1] < 0.0 {
        components = [y / one, 0.0];
    } else if components[0] < 0.0 {
        components = [0.0, with / square];
    }
    let [a, b] = components;
    if !(a + b > 0.0) {
        return vec![1.0; n];
    }
    sd.iter().map(|sd| a + b * sd * sd).collect()
}

/// Whether each row counts: its residual lies within [`FAR`] SDs, each row's as a multiple of the
/// one that was expected of it.
pub fn near_rows(value: &[f64], columns: &[Vec<f64>], group: &[usize], sd: &[f64]) -> Vec<bool> {
    let n = value.len();
    let groups = group.iter().max().map_or(0, |last| last + 1);
    let of_group = |k: usize| value.iter().zip(group).filter(move |row| *row.1 == k).map(|r| *r.0);
    let medians: Vec<f64> = (0..groups).map(|k| median(of_group(k).collect())).collect();
    let from_median: Vec<f64> =
        (0..n).map(|k| (value[k] - medians[group[k]]).abs() / sd[k]).collect();
    let scale = SD_OF_MEDIAN * median(from_median.clone());
    let mut counts: Vec<bool> = from_median.iter().map(|r| *r <= FAR_OF_MEDIANS * scale).collect();
    for _ in 0..MOST_TURNS {
        let within = WithinGroups::fit(value, columns, group, &counts);
        let rest: Vec<f64> = (0..n).map(|k| value[k] - within.at(columns, k)).collect();
        let counting = || (0..n).filter(|k| counts[*k]);
        let all = counting().map(|k| rest[k]).sum::<f64>() / counting().count().max(1) as f64;
        let mut levels = vec![(all, 1.0); groups];
        for k in counting() {
            levels[group[k]].0 += rest[k];
            levels[group[k]].1 += 1.0;
        }
        let off: Vec<f64> = (0..n)
            .map(|k| (rest[k] - levels[group[k]].0 / levels[group[k]].1).abs() / sd[k])
            .collect();
        let scale = SD_OF_MEDIAN * median(counting().map(|k| off[k]).collect());
        let next: Vec<bool> = off.iter().map(|off| *off <= FAR * scale).collect();
        if next == counts || !(scale > 0.0) {
            break;
        }
        counts = next;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    #[test]
    fn doubled_trips_are_far_and_all_others_are_near() {
        let mut draws = Draws::new(1, 0, Stream::Bootstrap);
        let (mut value, mut x, mut group) = (Vec::new(), Vec::new(), Vec::new());
        for truck in 0..12 {
            let level = 0.03 * draws.normal();
            for _ in 0..if truck == 0 { 2 } else { 20 } {
                let load = draws.normal();
                x.push(load);
                group.push(truck);
                value.push(3.5 + level + 0.2 * load + 0.03 * draws.normal());
            }
        }
        let doubled = [1, 40, 41, 199];
        for k in doubled {
            value[k] += std::f64::consts::LN_2;
        }
        let near = near_rows(&value, &[x.clone()], &group, &vec![0.05; group.len()]);
        let far: Vec<usize> = (0..near.len()).filter(|k| !near[*k]).collect();
        assert_eq!(far, doubled);
        let within = WithinGroups::fit(&value, &[x.clone(), x], &group, &near);
        assert_eq!(within.columns, [0], "the second column is the first");
        assert!((within.slopes[0] - 0.2).abs() < 0.01, "{within:?}");
    }

    #[test]
    fn variances_have_what_is_expected_and_what_is_not() {
        // 0.03² beside 0.5 s², of 40 groups with 50 rows
        let mut draws = Draws::new(2, 0, Stream::Bootstrap);
        let (mut value, mut group, mut sd) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..2000 {
            let s = 0.05 + 0.1 * draws.uniform();
            let variance: f64 = 0.0009 + 0.5 * s * s;
            value.push((k % 40) as f64 + variance.sqrt() * draws.normal());
            group.push(k % 40);
            sd.push(s);
        }
        for (variance, s) in variances(&value, &[], &group, &sd).iter().zip(&sd) {
            // within what 2000 squares tell: 2/2000 of a variance squared, and its slope
            assert!((variance / (0.0009 + 0.5 * s * s) - 1.0).abs() < 0.15, "{variance} {s}");
        }
    }
}
