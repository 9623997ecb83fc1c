//! Runs that end when their answer is precise enough.
//!
//! The answer is checked after fixed numbers of cycles: 250, and then 1.25 times as many each
//! time, whatever the number of threads. It is precise enough when half of its 95 % interval,
//! relative to it, is at most what was asked for.
//!
//! Every check is a chance to stop too early by luck, so the first check is late and the others are
//! far apart: for the mean of a normal law, checks from 10 cycles on cover 92.4 % instead of 95 %,
//! from 100 on with a factor of 1.25 94.7 % \[D\].

use super::quantile::LEVELS;
use super::summary::SummaryBuilder;
use ocmc_core::record::Record;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// Cycles before the first check.
pub const FIRST_CHECK: u64 = 250;

/// Cycles of a check over those of the one before.
const GROWTH: f64 = 1.25;

/// Quantity that has to be known, and how well.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Precision {
    /// `mean`, or the name of a quantile as in [`LEVELS`].
    pub of: String,
    /// Half of the 95 % interval, relative to the value.
    pub wanted: f64,
}

/// How well it is known.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Reached {
    /// Precision that was asked for.
    #[serde(flatten)]
    pub precision: Precision,
    /// Half of the 95 % interval, relative to the value; none where there is no interval.
    pub reached: Option<f64>,
    /// Whether that is precise enough.
    pub met: bool,
}

impl Precision {
    /// Names of what can be known precisely.
    pub fn names() -> impl Iterator<Item = &'static str> {
        std::iter::once("mean").chain(LEVELS.map(|(_, name)| name))
    }

    /// How well the fleet's consumption is known from these cycles.
    pub fn check(&self, fleet: &mut SummaryBuilder) -> Reached {
        let level = LEVELS.into_iter().find(|(_, name)| *name == self.of).map(|(level, _)| level);
        let reached = fleet.relative_half_width(level);
        let met = reached.is_some_and(|reached| reached <= self.wanted);
        Reached { precision: self.clone(), reached, met }
    }
}

/// Cycles at the first check from so many on.
pub fn next_check(cycles: u64) -> u64 {
    let mut check = FIRST_CHECK;
    while check < cycles {
        check = (check as f64 * GROWTH).ceil() as u64;
    }
    check
}

/// Watches a run whose records a fleet takes, and ends it at the first check at which it knows its
/// answer precisely enough. Where that happens depends on the records alone.
#[derive(Clone, Debug)]
pub struct InterimChecks<'a> {
    precision: Option<&'a Precision>,
    next: u64,
    trips_per_truck: u64,
}

impl<'a> InterimChecks<'a> {
    /// For a run of which the fleet has so many cycles already; without a precision it goes on to
    /// its last cycle. A run that was interrupted at a check has not been checked yet.
    /// Checks are made behind whole trucks.
    pub fn new(precision: Option<&'a Precision>, cycles: u64, trips_per_truck: u64) -> Self {
        let next = next_check(cycles).next_multiple_of(trips_per_truck.max(1));
        Self { precision, next, trips_per_truck: trips_per_truck.max(1) }
    }

    /// Gives the next records to the fleet, and those that count to `sink`, with the number of
    /// cycles so far.
    ///
    /// Breaks with nothing when the fleet knows enough, with what `sink` says where that breaks.
    pub fn take<B>(
        &mut self,
        fleet: &mut SummaryBuilder,
        records: &[Record],
        mut sink: impl FnMut(&[Record], u64) -> ControlFlow<B>,
    ) -> ControlFlow<Option<B>> {
        let mut rest = records;
        loop {
            let before_check = match self.precision {
                Some(_) => (self.next - fleet.cycles()) as usize,
                None => usize::MAX,
            };
            let (now, later) = rest.split_at(rest.len().min(before_check));
            fleet.add(now);
            if let ControlFlow::Break(broken) = sink(now, fleet.cycles()) {
                return ControlFlow::Break(Some(broken));
            }
            if let Some(precision) = self.precision
                && self.next == fleet.cycles()
            {
                if precision.check(fleet).met {
                    return ControlFlow::Break(None);
                }
                let next = next_check(fleet.cycles() + 1);
                self.next = next.next_multiple_of(self.trips_per_truck);
            }
            if later.is_empty() {
                return ControlFlow::Continue(());
            }
            rest = later;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::energy::Carrier;
    use ocmc_core::random::{Draws, Stream};

    #[test]
    fn checks_grow_from_250_by_a_quarter() {
        let mut checks = vec![next_check(0)];
        for _ in 0..5 {
            checks.push(next_check(checks[checks.len() - 1] + 1));
        }
        assert_eq!(checks, [250, 313, 392, 490, 613, 767]);
        assert_eq!((next_check(250), next_check(251), next_check(330)), (250, 313, 392));
    }

    #[test]
    fn a_run_that_was_interrupted_at_a_check_ends_there_when_it_is_resumed() {
        let precision = Precision { of: "mean".to_owned(), wanted: 0.1 };
        let records: Vec<Record> =
            (0..1300).map(|k| record(1.0, 30.0 + f64::from(k % 2))).collect();
        let mut fleet = SummaryBuilder::default();
        let mut checks = InterimChecks::new(Some(&precision), 0, 1);
        // Ctrl-C, which is noticed when the 250th record has been written
        let interrupted = checks.take(&mut fleet, &records, |_, _| ControlFlow::Break("Ctrl-C"));
        assert_eq!((interrupted, fleet.cycles()), (ControlFlow::Break(Some("Ctrl-C")), 250));
        let mut checks = InterimChecks::new(Some(&precision), fleet.cycles(), 1);
        let resumed: ControlFlow<Option<()>> =
            checks.take(&mut fleet, &records[250..], |_, _| ControlFlow::Continue(()));
        assert_eq!((resumed, fleet.cycles()), (ControlFlow::Break(None), 250));
    }

    fn record(distance_m: f64, litres: f64) -> Record {
        Record {
            distance_m,
            duration_s: 1.0,
            wheel_kwh_per_km: 1.0,
            ..Record::default().with(Carrier::LiquidFuel, [None, Some(litres), None])
        }
    }

    /// Share of 1000 runs, each stopped by the rule, whose interval covers the truth.
    fn coverage(
        statistic: &str,
        wanted: f64,
        truth: f64,
        cycle: impl Fn(&mut Draws) -> Record,
    ) -> (f64, f64) {
        const RUNS: u64 = 1000;
        let precision = Precision { of: statistic.to_owned(), wanted };
        let (mut covered, mut cycles) = (0, 0);
        for k in 0..RUNS {
            let mut draws = Draws::new(1, k, Stream::CurveResidual);
            let mut fleet = SummaryBuilder::default();
            loop {
                let rows = next_check(fleet.cycles() + 1) - fleet.cycles();
                let records: Vec<Record> = (0..rows).map(|_| cycle(&mut draws)).collect();
                fleet.add(&records);
                if precision.check(&mut fleet).met {
                    break;
                }
            }
            cycles += fleet.cycles();
            let summary = fleet.finish();
            let litres = summary.consumption().expect("fuel");
            let quantile = litres.quantiles.iter().find(|quantile| quantile.name == statistic);
            let interval = quantile.map_or(litres.ci95, |quantile| quantile.ci95);
            let [low, high] = interval.expect("at least 250 cycles");
            covered += u64::from(low <= truth && truth <= high);
        }
        (covered as f64 / RUNS as f64, cycles as f64 / RUNS as f64)
    }

    #[test]
    fn intervals_of_runs_that_were_stopped_cover_the_mean_as_often_as_they_should() {
        // distances log-normal, litres shifted log-normal (skewed, as consumption is): the fleet's
        // mean is 30 + e^(1/8)·4. a spread of 6 % of the mean over 1000 cycles gives 0.4 %, so 0.25
        // % takes several checks
        let truth = 30.0 + 4.0 * libm::exp(0.125);
        let (share, cycles) = coverage("mean", 0.0025, truth, |draws| {
            let distance_m = libm::exp(0.3 * draws.normal());
            record(distance_m, 30.0 + 4.0 * libm::exp(0.5 * draws.normal()))
        });
        assert!((0.936..=0.964).contains(&share), "{share}");
        assert!((2000.0..4000.0).contains(&cycles), "several checks: {cycles}");
    }

    #[test]
    fn and_the_95_percent_quantile() {
        let truth = 30.0 + 3.0 * 1.6448536269514722;
        let (share, cycles) =
            coverage("p95", 0.008, truth, |draws| record(1.0, 30.0 + 3.0 * draws.normal()));
        assert!((0.936..=0.964).contains(&share), "{share}");
        assert!(cycles > 1200.0, "several checks: {cycles}");
    }
}
