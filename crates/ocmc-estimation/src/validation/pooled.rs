//! The scores of many drives together.

use super::ensemble::{BINS, DriveScore, Quantity, bin};
use super::score::{Score, covers};
use super::uniformity::Uniformity;
use serde::Serialize;

/// A score over many drives. Errors and CRPS are in the unit of the quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pooled {
    /// Quantity that is scored; `speed` is over all places.
    pub quantity: String,
    /// Number of drives.
    pub drives: usize,
    /// Number of values.
    pub n: usize,
    /// Mean of simulated mean less measured.
    pub mean_error: f64,
    /// Root of the mean square of that.
    pub rmse: f64,
    /// Mean continuous ranked probability score.
    pub crps: f64,
    /// Share of the values that the band of half of the trips covers.
    pub coverage50: f64,
    /// Its standard error between drives; none of a single one.
    pub coverage50_error: Option<f64>,
    /// Share of the values that the band of 90 % of the trips covers.
    pub coverage90: f64,
    /// Its standard error between drives.
    pub coverage90_error: Option<f64>,
    /// Ranks in tenths.
    pub pit: [u64; BINS],
    /// Whether the ranks of drives are uniform; none of the speed at all places, whose ranks depend
    /// on one another, and of fewer than 8 drives.
    pub uniform: Option<Uniformity>,
}

/// Everything that was scored: the speed over all places, then what is scored once a trip.
/// `shared`: size of the sample of simulated trips where all drives share one.
pub fn pooled(drives: &[DriveScore], shared: Option<usize>) -> Vec<Pooled> {
    let speed = over_places(drives);
    let once =
        Quantity::ALL.into_iter().filter_map(|quantity| over_trips(drives, quantity, shared));
    speed.into_iter().chain(once).collect()
}

/// The speed over all places, each place once.
fn over_places(drives: &[DriveScore]) -> Option<Pooled> {
    let n: usize = drives.iter().map(|drive| drive.speed.places).sum();
    if n == 0 {
        return None;
    }
    let mean = |value: &dyn Fn(&DriveScore) -> f64| {
        let sum = drives.iter().map(|drive| drive.speed.places as f64 * value(drive)).sum::<f64>();
        sum / n as f64
    };
    let mut pit = [0; BINS];
    for drive in drives {
        for (all, own) in pit.iter_mut().zip(drive.speed.pit) {
            *all += own;
        }
    }
    let [coverage50, coverage90] = [mean(&|d| d.speed.coverage50), mean(&|d| d.speed.coverage90)];
    // a ratio of sums over drives
    let error = |share: f64, own: &dyn Fn(&DriveScore) -> f64| {
        let k = drives.len() as f64;
        let squares = drives.iter().map(|drive| {
            let apart = drive.speed.places as f64 * (own(drive) - share);
            apart * apart
        });
        (drives.len() > 1).then(|| (squares.sum::<f64>() * k / (k - 1.0)).sqrt() / n as f64)
    };
    Some(Pooled {
        quantity: "speed".to_owned(),
        drives: drives.len(),
        n,
        mean_error: mean(&|d| d.speed.mean_error_mps),
        rmse: mean(&|d| d.speed.rmse_mps * d.speed.rmse_mps).sqrt(),
        crps: mean(&|d| d.speed.crps_mps),
        coverage50,
        coverage50_error: error(coverage50, &|d| d.speed.coverage50),
        coverage90,
        coverage90_error: error(coverage90, &|d| d.speed.coverage90),
        pit,
        uniform: None,
    })
}

/// Score of a quantity that is scored once a trip.
fn over_trips(drives: &[DriveScore], quantity: Quantity, shared: Option<usize>) -> Option<Pooled> {
    let scores: Vec<&Score> = drives.iter().filter_map(|drive| drive.value(quantity)).collect();
    if scores.is_empty() {
        return None;
    }
    let n = scores.len() as f64;
    let mean = |value: &dyn Fn(&Score) -> f64| scores.iter().map(|s| value(s)).sum::<f64>() / n;
    let coverage = |share: f64| mean(&|s| f64::from(u8::from(covers(share, s.pit))));
    let error = |p: f64| (scores.len() > 1).then(|| (p * (1.0 - p) / (n - 1.0)).sqrt());
    let [coverage50, coverage90] = [coverage(0.5), coverage(0.9)];
    let mut pit = [0; BINS];
    for score in &scores {
        pit[bin(score.pit)] += 1;
    }
    let ranks: Vec<f64> = scores.iter().map(|score| score.pit).collect();
    Some(Pooled {
        quantity: quantity.name().to_owned(),
        drives: scores.len(),
        n: scores.len(),
        mean_error: mean(&Score::error),
        rmse: mean(&|s| s.error() * s.error()).sqrt(),
        crps: mean(&|s| s.crps),
        coverage50,
        coverage50_error: error(coverage50),
        coverage90,
        coverage90_error: error(coverage90),
        pit,
        uniform: Uniformity::of(&ranks, shared),
    })
}
