//! Statistics for tests: moments with their errors, and the test of Kolmogorov and Smirnov.

/// Seeds of every statistical test, chosen before the first run.
pub(crate) const SEEDS: [u64; 3] = [1, 2, 3];

/// Mean and standard error of independent values.
pub(crate) fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// Fails where the mean of independent values is more than four standard errors from `wanted`.
#[track_caller]
pub(crate) fn assert_mean(what: &str, values: &[f64], wanted: f64) {
    let (mean, error) = mean_and_error(values);
    let n = values.len();
    assert!(
        (mean - wanted).abs() <= 4.0 * error,
        "{what}: {mean} of {n} values, wanted {wanted}, standard error {error}"
    );
}

/// Fails where a share of `n` trials is more than four standard errors from `p`.
#[track_caller]
pub(crate) fn assert_share(what: &str, count: usize, n: usize, p: f64) {
    let share = count as f64 / n as f64;
    let error = (p * (1.0 - p) / n as f64).sqrt();
    assert!((share - p).abs() <= 4.0 * error, "{what}: {share} of {n}, wanted {p}");
}

/// Fails where a Poisson count is more than four standard deviations from its mean.
#[track_caller]
pub(crate) fn assert_count(what: &str, count: usize, wanted: f64) {
    assert!(
        (count as f64 - wanted).abs() <= 4.0 * wanted.sqrt(),
        "{what}: {count}, wanted {wanted}"
    );
}

/// Fails where an estimate is more than four standard errors from its true value.
#[track_caller]
pub(crate) fn assert_near(what: &str, estimate: f64, wanted: f64, error: f64) {
    assert!(
        (estimate - wanted).abs() <= 4.0 * error,
        "{what}: {estimate}, wanted {wanted}, standard error {error}"
    );
}

/// Kolmogorov-Smirnov: fails where independent draws of a continuous law contradict its
/// distribution function at level 0.001. The largest distance exceeds √(−ln(α/2) / 2n) with
/// probability α for large n.
#[track_caller]
pub(crate) fn assert_follows(what: &str, mut values: Vec<f64>, cdf: impl Fn(f64) -> f64) {
    let n = values.len() as f64;
    values.sort_by(f64::total_cmp);
    let distance = values
        .iter()
        .enumerate()
        .map(|(i, &x)| {
            let p = cdf(x);
            (p - i as f64 / n).max((i as f64 + 1.0) / n - p)
        })
        .fold(0.0, f64::max);
    let critical = (-f64::ln(0.001 / 2.0) / (2.0 * n)).sqrt();
    assert!(distance < critical, "{what}: distance {distance}, critical {critical}, n {n}");
}
