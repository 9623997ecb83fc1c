//! Mean, spread and correlation of measured values, each counted once.

/// Number, mean and squares of some values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments {
    pub n: f64,
    pub mean: f64,
    /// Sum of the squared deviations from the mean.
    pub squares: f64,
}

impl Moments {
    pub(crate) fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        Self { n, mean, squares: values.iter().map(|x| (x - mean) * (x - mean)).sum() }
    }

    /// With n − 1.
    pub(crate) fn variance(&self) -> f64 {
        self.squares / (self.n - 1.0)
    }

    /// Sample standard deviation.
    pub(crate) fn sd(&self) -> f64 {
        libm::sqrt(self.variance())
    }

    /// Standard error of the mean.
    pub(crate) fn standard_error(&self) -> f64 {
        libm::sqrt(self.variance() / self.n)
    }
}

/// Correlation of pairs about 0, and their number; none where one side does not vary.
pub(crate) fn correlation(pairs: impl IntoIterator<Item = (f64, f64)>) -> Option<(f64, usize)> {
    let (mut xx, mut yy, mut xy, mut n) = (0.0, 0.0, 0.0, 0);
    for (x, y) in pairs {
        xx += x * x;
        yy += y * y;
        xy += x * y;
        n += 1;
    }
    (xx * yy > 0.0).then(|| (xy / libm::sqrt(xx * yy), n))
}
