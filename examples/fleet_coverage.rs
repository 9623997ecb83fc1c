//! How often the intervals of fleets of trucks hold the truth: many fleets of real, short trips,
//! their intervals by trucks beside those that take all trips for independent.
//!
//! `fleet_coverage [FLEETS [TRUCKS [TRIPS [LENGTH_M [POOL [DAYS]]]]]]`. With POOL above 0 all
//! trucks share a pool of so many drivers, with DAYS above 0 weather and traffic of days of so many
//! trips; the intervals of trucks alone are then told, too. The truth is what all fleets have
//! together, whose own error is 1/√FLEETS of an interval's.
#![allow(clippy::print_stdout, reason = "the table is what it is for")]

use ocmc_core::energy::Carrier;
use ocmc_core::record::Record;
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::quantile::quantile;
use ocmc_fleet::run::{RunPlan, records};
use ocmc_fleet::statistic::Statistic;
use ocmc_fleet::summary::{Summary, SummaryBuilder};
use std::convert::Infallible;
use std::ops::ControlFlow;

/// Estimate of a method, and its interval.
type Estimate = (f64, Option<[f64; 2]>);

fn main() {
    let numbers: Vec<u64> =
        std::env::args().skip(1).map(|text| text.parse().expect("a whole number")).collect();
    let number = |k: usize, standard: u64| numbers.get(k).copied().unwrap_or(standard);
    let (fleets, trucks, trips) = (number(0, 1000), number(1, 200), number(2, 50));
    let length = format!("mission.length_m={}", number(3, 1000));
    let of_truck = format!("fleet.trips_per_truck={trips}");
    let mut sets = vec![length.clone(), of_truck];
    if number(4, 0) > 0 {
        sets.push(format!("fleet.driver_pool={}", number(4, 0)));
    }
    if number(5, 0) > 0 {
        sets.push(format!(
            "fleet.calendar={{ operating_days_per_week = 7, trips_per_day = {}, \
             departure_interval_s = 3600.0, shared_weather = true, shared_traffic = true }}",
            number(5, 0)
        ));
    }
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    let study = ocmc_io::study::load("field-truck", &sets).expect("a study").study;
    let mut found: Vec<[Estimate; 7]> = Vec::new();
    let (mut litres, mut km, mut all, mut years) = (0.0, 0.0, Vec::new(), Vec::new());
    for seed in 1..=fleets {
        let plan = RunPlan::new(seed, 0, trucks * trips, None, None);
        let ControlFlow::Continue(driven) =
            records::<Infallible>(&study, &plan, |_| ControlFlow::Continue(()));
        for record in &driven {
            if let Some(value) = record.consumption(Carrier::LiquidFuel) {
                litres += value * record.distance_m;
                km += record.distance_m;
                all.push(value);
            }
        }
        let dependence = Dependence::of(study.model(), seed);
        let clustered = summary(&driven, dependence);
        let by_trucks = Dependence { pool: None, shares_days: false, ..dependence };
        let by_trucks = summary(&driven, by_trucks);
        let naive = summary(&driven, Dependence::default());
        let annual = &clustered.trucks.as_ref().expect("trucks").truck_years[0];
        years.push(annual.mean.expect("trucks"));
        let annual_by_trucks = &by_trucks.trucks.as_ref().expect("trucks").truck_years[0];
        let (own, alone) = (of(&clustered), of(&naive));
        found.push([
            mean(own),
            p95(own),
            mean(annual),
            mean(of(&by_trucks)),
            p95(of(&by_trucks)),
            mean(annual_by_trucks),
            mean(alone),
        ]);
    }
    all.sort_unstable_by(f64::total_cmp);
    let truth = [
        litres / km,
        quantile(&all, 0.95).expect("trips"),
        years.iter().sum::<f64>() / years.len() as f64,
    ];
    println!("{fleets} fleets of {trucks} trucks x {trips} trips of {length}");
    let names = [
        "mean",
        "P95",
        "annual mean",
        "mean, by trucks",
        "P95, by trucks",
        "annual, by trucks",
        "mean, trips alone",
    ];
    for (k, name) in names.into_iter().enumerate() {
        let truth = truth[k % 3];
        let covered = found.iter().filter(|estimates| {
            estimates[k].1.is_some_and(|[low, high]| low <= truth && truth <= high)
        });
        let percent = 100.0 * covered.count() as f64 / fleets as f64;
        println!("{name:<18} truth {truth:8.3}  covered {percent:5.1} %");
    }
}

fn summary(driven: &[Record], dependence: Dependence) -> Summary {
    let mut fleet = SummaryBuilder::new(dependence);
    fleet.add(driven);
    fleet.finish()
}

fn of(summary: &Summary) -> &Statistic {
    summary.consumption().expect("fuel")
}

fn mean(statistic: &Statistic) -> Estimate {
    (statistic.mean.expect("trips"), statistic.ci95)
}

fn p95(statistic: &Statistic) -> Estimate {
    (statistic.quantiles[4].value.expect("trips"), statistic.quantiles[4].ci95)
}
