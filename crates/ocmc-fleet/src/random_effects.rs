//! Two-way random effects: every cycle with every driver, a second opinion on who the spread comes
//! from.
//!
//! yᵢⱼ = μ + cᵢ + dⱼ + eᵢⱼ, cycles i = 1…I crossed with drivers j = 1…J, one observation each. With
//! the mean squares of the analysis of variance,
//!
//! σ_c² = (MS_c − MS_e)/J,  σ_d² = (MS_d − MS_e)/I,  σ_e² = MS_e
//!
//! where e holds what cycle and driver do together. Estimates are reported as they are and may be
//! negative. Source: S. R. Searle, G. Casella, C. E. McCulloch, *Variance Components* (1992),
//! chapter 4 \[PK\].

use super::quantity::{RecordQuantity, consumption};
use super::run::{RunPlan, records};
use super::sensitivity::SensitivityError;
use ocmc_core::random::sampling::Sampling;
use ocmc_core::random::{Factor, PickFreeze, StreamSet};
use ocmc_core::study::Study;
use schemars::JsonSchema;
use serde::Serialize;
use std::ops::ControlFlow;

/// Shares of the variance in a crossed design of cycles and drivers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct TwoWay {
    /// Cycles that every driver completed and that have the quantity with each of them.
    pub cycles: u64,
    /// Drivers.
    pub drivers: u64,
    /// Share of road, weather, traffic, mission and vehicle.
    pub cycle: f64,
    /// Share of the driver.
    pub driver: f64,
    /// Share of what both do together.
    pub both: f64,
}

impl TwoWay {
    /// Estimates the shares from one row a cycle, one column a driver; none from fewer than two of
    /// either or without spread.
    pub fn estimate(rows: &[Vec<f64>]) -> Option<Self> {
        let (cycles, drivers) = (rows.len(), rows.first()?.len());
        if cycles < 2 || drivers < 2 {
            return None;
        }
        let (i, j) = (cycles as f64, drivers as f64);
        let row_means: Vec<f64> = rows.iter().map(|row| row.iter().sum::<f64>() / j).collect();
        let column_mean = |k: usize| rows.iter().map(|row| row[k]).sum::<f64>() / i;
        let column_means: Vec<f64> = (0..drivers).map(column_mean).collect();
        let mean = row_means.iter().sum::<f64>() / i;
        let squares = |means: &[f64]| means.iter().map(|m| (m - mean) * (m - mean)).sum::<f64>();
        let mut rest = 0.0;
        for (row, row_mean) in rows.iter().zip(&row_means) {
            for (y, column_mean) in row.iter().zip(&column_means) {
                let e = y - row_mean - column_mean + mean;
                rest += e * e;
            }
        }
        let both = rest / ((i - 1.0) * (j - 1.0));
        let cycle = squares(&row_means) / (i - 1.0) - both / j;
        let driver = squares(&column_means) / (j - 1.0) - both / i;
        let whole = cycle + driver + both;
        (whole > 0.0).then(|| Self {
            cycles: cycles as u64,
            drivers: drivers as u64,
            cycle: cycle / whole,
            driver: driver / whole,
            both: both / whole,
        })
    }
}

/// Drives the plan's cycles with each of so many drivers, and splits the variance. A cycle that one
/// of them does not complete, or that has no value with one of them, is left out. Without a
/// quantity that of the consumption.
///
/// `progress` receives the number of cycles driven so far, of `plan.cycles` × `drivers`; breaking
/// ends the analysis.
pub fn two_way<B>(
    study: &Study,
    plan: &RunPlan,
    drivers: u64,
    quantity: Option<&'static RecordQuantity>,
    mut progress: impl FnMut(u64) -> ControlFlow<B>,
) -> ControlFlow<B, Result<TwoWay, SensitivityError>> {
    // strata would pass for spread that drivers and cycles do not have
    if study.model().simulation.sampling != Sampling::Independent {
        return ControlFlow::Continue(Err(SensitivityError::NotIndependent));
    }
    let streams = StreamSet::of_factor(Factor::Driver);
    let mut quantity = quantity;
    let mut rows: Vec<Option<Vec<f64>>> = vec![Some(Vec::new()); plan.cycles as usize];
    for driver in 0..drivers {
        // of each truck its first driver
        let cycle_id = Some(driver * study.nesting().trips_per_truck);
        let plan = RunPlan { pick_freeze: PickFreeze { streams, cycle_id }, ..*plan };
        let before = driver * plan.cycles;
        let driven = records(study, &plan, |cycles| progress(before + cycles))?;
        let quantity = *quantity.get_or_insert_with(|| consumption(&driven));
        for (row, record) in rows.iter_mut().zip(&driven) {
            match (quantity.of_cycle(record), row.as_mut()) {
                (Some(value), Some(values)) => values.push(value),
                _ => *row = None,
            }
        }
    }
    let column = quantity.map_or("", |quantity| quantity.column);
    let complete: Vec<Vec<f64>> = rows.into_iter().flatten().collect();
    let count = complete.len() as u64;
    ControlFlow::Continue(match TwoWay::estimate(&complete) {
        Some(shares) => Ok(shares),
        None if count < 2 => {
            let dropped = plan.cycles - count;
            Err(SensitivityError::TooFewCrossed { column, cycles: count, dropped })
        }
        None => Err(SensitivityError::NoSpread { column }),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    #[test]
    fn a_small_case_by_hand() {
        // row means 1, 3; column means 1, 3; mean 2; no rest
        let shares = TwoWay::estimate(&[vec![0.0, 2.0], vec![2.0, 4.0]]).expect("it varies");
        assert_eq!((shares.cycle, shares.driver, shares.both), (0.5, 0.5, 0.0));
        assert_eq!(TwoWay::estimate(&[vec![1.0, 2.0]]), None);
        assert_eq!(TwoWay::estimate(&[vec![1.0, 1.0], vec![1.0, 1.0]]), None);
        assert_eq!(TwoWay::estimate(&[]), None);
    }

    #[test]
    fn known_variances_are_recovered() {
        // standard deviations 3, 1 and 2: shares 9/14, 1/14, 4/14
        const RUNS: u64 = 200;
        let mut sums = [0.0; 3];
        let mut squares = [0.0; 3];
        for run in 0..RUNS {
            let mut draws = Draws::new(1, run, Stream::Curve);
            let drivers: Vec<f64> = (0..20).map(|_| draws.normal()).collect();
            let rows: Vec<Vec<f64>> = (0..60)
                .map(|_| {
                    let cycle = 3.0 * draws.normal();
                    drivers.iter().map(|driver| cycle + driver + 2.0 * draws.normal()).collect()
                })
                .collect();
            let TwoWay { cycle, driver, both, .. } = TwoWay::estimate(&rows).expect("it varies");
            for (k, share) in [cycle, driver, both].into_iter().enumerate() {
                sums[k] += share;
                squares[k] += share * share;
            }
        }
        let n = RUNS as f64;
        for (k, known) in [9.0 / 14.0, 1.0 / 14.0, 4.0 / 14.0].into_iter().enumerate() {
            let mean = sums[k] / n;
            let error = ((squares[k] / n - mean * mean) / n).sqrt();
            // a share is a quotient of estimates: its bias is of the order of 1/60
            assert!((mean - known).abs() < 4.0 * error + 0.01, "{k}: {mean} {known}");
        }
    }
}
