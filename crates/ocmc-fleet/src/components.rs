//! How the consumption of trips is spread between trucks, or drivers, and within them.
//!
//! With v_t the means of the n trucks, m trips each,
//!
//! s_b² = (s_v² − s_w²/m̄)  between trucks,  s_w² within them, between trips
//!
//! by the analysis of variance for trucks with different numbers of trips. Source: S. R. Searle, G.
//! Casella, C. E. McCulloch, *Variance Components* (1992), section 3.6 \[PK\].

use schemars::JsonSchema;
use serde::Serialize;

/// Count, mean and squares about the mean, by B. P. Welford's update.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spread {
    /// Id of the truck, or driver.
    owner: u64,
    n: f64,
    mean: f64,
    squares: f64,
}

impl Spread {
    /// Spread of nothing yet, of this truck or driver.
    pub(super) fn of(owner: u64) -> Self {
        Self { owner, ..Self::default() }
    }

    /// Whether it is of this one.
    pub(super) fn is_of(&self, owner: u64) -> bool {
        self.owner == owner
    }

    pub(super) fn add(&mut self, value: f64) {
        self.n += 1.0;
        let off = value - self.mean;
        self.mean += off / self.n;
        self.squares += off * (value - self.mean);
    }
}

/// How the consumption of trips is spread between trucks and within them, each trip counted once.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Components {
    /// Variance between trucks; as it is estimated, so that it may be negative.
    pub between_variance: f64,
    /// Variance within trucks.
    pub within_variance: f64,
    /// Standard deviation between trucks; 0 where the variance is negative.
    pub between_sd: f64,
    /// Standard deviation between trips of a truck.
    pub within_sd: f64,
    /// Share of the variance of trips that is between trucks.
    pub share_of_trips: f64,
    /// Share of the variance of the trucks' means that is between trucks, and not the chance of
    /// their trips.
    pub share_of_means: f64,
}

/// Components of the trips of trucks, or of drivers.
pub(super) fn components(spread: &[Spread]) -> Option<Components> {
    let trucks = spread.len() as f64;
    let n: f64 = spread.iter().map(|truck| truck.n).sum();
    if trucks < 2.0 || n <= trucks {
        return None;
    }
    let within: f64 = spread.iter().map(|truck| truck.squares).sum::<f64>() / (n - trucks);
    let mean = spread.iter().map(|truck| truck.n * truck.mean).sum::<f64>() / n;
    let between = spread.iter().map(|truck| truck.n * (truck.mean - mean) * (truck.mean - mean));
    let between = between.sum::<f64>() / (trucks - 1.0);
    let squares: f64 = spread.iter().map(|truck| truck.n * truck.n).sum();
    // trips of a truck, where all have as many
    let trips = (n - squares / n) / (trucks - 1.0);
    let between_variance = (between - within) / trips;
    let real = between_variance.max(0.0);
    let whole = real + within;
    (whole > 0.0).then(|| Components {
        between_variance,
        within_variance: within,
        between_sd: libm::sqrt(real),
        within_sd: libm::sqrt(within),
        share_of_trips: real / whole,
        share_of_means: real / (real + within / trips),
    })
}
