//! Sign of breaks inside of driving times: trips are slow, and speeds differ widely, both most on
//! short trips, as a break takes its time on any of them.

use super::{Member, Response, TotalsRow};
use nalgebra::{DVector, SMatrix, SVector};

/// Break of every second trip that says which way breaks move the figures, in s: half an hour to 50
/// minutes are one for lunch, for loading, or the 45 minutes of the law.
const BREAK_S: f64 = 2000.0;

/// Least variance of a figure, so that one that all fleets share, as the slope where all trips have
/// one length, tells nothing.
const LEAST_VARIANCE: f64 = 1e-9;

/// Figures of a fleet.
type Figures = SVector<f64, 4>;

/// Mean and SD of ln speed, its slope over ln length, and the correlation of ln length with how far
/// trips are from that line: breaks part the speeds of short trips more than those of long ones.
fn figures(trips: &[(f64, f64)]) -> Figures {
    let (ln_lengths, ln_speeds): (Vec<f64>, Vec<f64>) = trips.iter().copied().unzip();
    let (x, y) = (centred(&ln_lengths), centred(&ln_speeds));
    let square = x.norm_squared();
    let slope = if square > x.len() as f64 * LEAST_VARIANCE { x.dot(&y) / square } else { 0.0 };
    let apart: Vec<f64> = (&y - &x * slope).iter().map(|residual| residual.abs()).collect();
    let apart = centred(&apart);
    let norms = x.norm() * apart.norm();
    let grown = if norms > 0.0 { x.dot(&apart) / norms } else { 0.0 };
    let n = trips.len() as f64;
    Figures::new(ln_speeds.iter().sum::<f64>() / n, y.norm() / libm::sqrt(n), slope, grown)
}

fn centred(values: &[f64]) -> DVector<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    DVector::from_iterator(values.len(), values.iter().map(|value| value - mean))
}

/// ln length and ln speed of each trip.
fn trips(rows: &[TotalsRow]) -> Vec<(f64, f64)> {
    let logarithms =
        |row: &TotalsRow| (libm::log(row.length_m), row.responses[Response::Speed as usize]);
    rows.iter().map(logarithms).collect()
}

/// The same, with a break in every second trip.
fn with_breaks(rows: &[TotalsRow]) -> Vec<(f64, f64)> {
    let with_break = |(k, (ln_length, ln_speed)): (usize, (f64, f64))| {
        let slowed = libm::log1p(BREAK_S * libm::exp(ln_speed - ln_length));
        (ln_length, if k % 2 == 0 { ln_speed } else { ln_speed - slowed })
    };
    trips(rows).into_iter().enumerate().map(with_break).collect()
}

/// How far the rows lie the way in which breaks would move them, in SDs of simulated fleets without
/// breaks: the discriminant of Fisher between those and the same ones with breaks. None of rows
/// without speeds.
pub fn sign_of_breaks(members: &[Member], rows: &[TotalsRow]) -> Option<f64> {
    let has_speed = rows.iter().all(|row| row.responses[Response::Speed as usize].is_finite());
    if !has_speed || rows.is_empty() || members.len() < 2 {
        return None;
    }
    // as many trips as the table has rows, so that chance does as much to both
    let part = |member: &Member| member.trips.len().min(rows.len());
    let fleets: Vec<_> = members.iter().map(|m| figures(&trips(&m.trips[..part(m)]))).collect();
    let n = fleets.len() as f64;
    let mean = fleets.iter().sum::<Figures>() / n;
    let spread = fleets.iter().map(|fleet| (fleet - mean) * (fleet - mean).transpose());
    let covariance =
        spread.sum::<SMatrix<f64, 4, 4>>() / n + SMatrix::<f64, 4, 4>::identity() * LEAST_VARIANCE;
    let broken = members.iter().map(|m| figures(&with_breaks(&m.trips[..part(m)])));
    let way = broken.sum::<Figures>() / n - mean;
    let weights = covariance.cholesky()?.solve(&way);
    let sd = libm::sqrt(weights.dot(&(covariance * weights)));
    Some(weights.dot(&(figures(&trips(rows)) - mean)) / sd)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    const TRIPS: usize = 60;

    /// A fleet with a mean speed of its own; `break_s` in that share of the trips.
    fn fleet(seed: u64, lengths: [f64; 2], break_s: f64, share: f64) -> Member {
        let mut draws = Draws::new(seed, 0, Stream::Calibration);
        let own = 0.1 * draws.normal();
        let trip = |_| {
            let length_m = draws.uniform_between(lengths[0], lengths[1]);
            let speed_mps = libm::exp(2.9 + own + 0.15 * draws.normal());
            let lost_s = if draws.uniform_between(0.0, 1.0) < share { break_s } else { 0.0 };
            let ln_speed = libm::log(length_m / (length_m / speed_mps + lost_s));
            TotalsRow {
                gross_kg: 25e3,
                length_m,
                responses: [f64::NAN, ln_speed, f64::NAN],
                trips: 1.0,
            }
        };
        Member { scores: Vec::new(), trips: (0..TRIPS).map(trip).collect() }
    }

    fn signs(lengths: [f64; 2], break_s: f64, share: f64) -> Vec<f64> {
        let members: Vec<_> = (0..100).map(|seed| fleet(seed, lengths, 0.0, 0.0)).collect();
        let sign = |seed| sign_of_breaks(&members, &fleet(seed, lengths, break_s, share).trips);
        (1000..1200).map(|seed| sign(seed).expect("speeds")).collect()
    }

    #[test]
    fn fleets_without_breaks_are_standard_normal_and_those_with_them_lie_beyond() {
        let (clean, broken) = (signs([3e4, 2e5], 0.0, 0.0), signs([3e4, 2e5], 2000.0, 0.5));
        let n = clean.len() as f64;
        let mean = clean.iter().sum::<f64>() / n;
        let square = clean.iter().map(|x| x * x).sum::<f64>() / n;
        assert!(mean.abs() < 0.3 && (0.7..1.4).contains(&square), "{mean} {square}");
        assert!(broken.iter().filter(|sign| **sign > 3.0).count() > 195);
    }

    #[test]
    fn trips_of_one_length_have_no_slope_and_rows_without_speeds_no_sign() {
        let broken = signs([8e4, 8e4], 2000.0, 0.5);
        assert!(broken.iter().all(|sign| sign.is_finite()));
        let without = fleet(1, [8e4, 8e4], 0.0, 0.0);
        let mut rows = without.trips.clone();
        rows[3].responses[Response::Speed as usize] = f64::NAN;
        assert_eq!(sign_of_breaks(&[without.clone(), without], &rows), None);
    }
}
