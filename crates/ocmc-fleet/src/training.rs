//! Worth of training the drivers of a fleet who stand worst in its records.
//!
//! Each trip is driven twice, with the same road, weather, traffic, load and truck: by its own
//! driver, and by another one, who is the same for all trips, or by its own driver after a training
//! that changes keys of the study. The difference of the two, over the distance of a driver's
//! trips, is the driver's excess. It holds nothing of the truck, the roads or the chance of the
//! trips.
//!
//! A manager does not see it. What the records show is a driver's mean, which is made of the
//! driver, the truck and chance, and who stands worst in it does so by all three. So three numbers
//! are told apart, each over the distance of the chosen drivers:
//!
//! - what the records show: the mean of the chosen less that of the middle fifth of drivers;
//! - what of it would come back in other trips of the same drivers on the same trucks: that times
//!   the reliability of a mean, s_b²/(s_b² + s_w²/m) (regression to the mean);
//! - what the training gives: the excess of the chosen falls to that of the middle fifth of drivers
//!   by their excess; where the training changes keys, it falls to nothing.
//!
//! The interval is that of percentiles over [`RESAMPLES`] bootstrap samples of the drivers, in each
//! of which the worst are chosen anew. Source: S. M. Stigler, Regression towards the mean,
//! historically considered, *Statistical Methods in Medical Research* 6 (1997) 103-114 \[PK\], for
//! the idea; the estimator is ours \[D\].

use super::components::{Spread, components};
use super::quantity::{RecordQuantity, consumption};
use super::variance_share::{drawn_again, percentiles};
use ocmc_core::record::Record;
use serde::Serialize;
use std::collections::BTreeMap;

/// Bootstrap samples of the drivers.
pub const RESAMPLES: u64 = 400;

/// Drivers below which there is no interval.
const LEAST_DRIVERS: usize = 10;

/// Trips of each driver in the records, for which is told how sure the choice is.
const RECORDED: [usize; 8] = [5, 10, 20, 50, 100, 200, 500, 1000];

/// Choice of the drivers who are trained, and of the drive after training.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingOptions {
    /// Share of the drivers who are trained: those who stand worst in the records.
    pub share: f64,
    /// Whether the other drive is that of a trained driver, and not that of another one.
    pub is_trained: bool,
    /// Fixes the bootstrap samples.
    pub seed: u64,
}

/// Price of a trip; none where it was not completed.
pub type Price<'a> = &'a dyn Fn(&Record) -> Option<f64>;

/// Worth of training.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Training {
    /// Name of the quantity.
    pub column: &'static str,
    /// Drivers.
    pub drivers: usize,
    /// Number of them who are trained.
    pub chosen: usize,
    /// Trips that were completed in both drives.
    pub pairs: u64,
    /// Trips that were not, left out.
    pub left_out: u64,
    /// Distance of a chosen driver's trips, in m.
    pub distance_m: f64,
    /// How reliable a driver's mean in the records is: the share of its variance that would come
    /// back; none where drivers do not differ beyond chance.
    pub reliability: Option<f64>,
    /// Excess in the records: mean of the chosen less that of the middle fifth.
    pub shown: f64,
    /// Part of it that would come back.
    pub expected: Option<f64>,
    /// Gain by training.
    pub gain: Gain,
    /// Gain if the drivers who are truly worst were chosen.
    pub gain_if_known: Gain,
    /// Share of the chosen who are truly among the worst.
    pub truly_worst: f64,
    /// How that depends on the records.
    pub by_trips: Vec<Choice>,
}

/// A gain of the chosen drivers by training.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Gain {
    /// In the unit of the quantity.
    pub of_quantity: f64,
    /// 95 % interval over drivers; none of fewer than ten.
    pub of_quantity_ci95: Option<[f64; 2]>,
    /// Time over distance, in s/m: positive where the trained driver is faster.
    pub time_s_per_m: f64,
    /// Money over distance, in 1/km, the truck and the driver's hours included; none without
    /// prices.
    pub money_per_km: Option<f64>,
    /// 95 % interval over drivers.
    pub money_per_km_ci95: Option<[f64; 2]>,
}

/// The choice from records of so many trips.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// Trips of each driver.
    pub trips: usize,
    /// Share of the chosen who are truly among the worst.
    pub truly_worst: f64,
    /// Excess in the records.
    pub shown: f64,
    /// Gain by training.
    pub gain: f64,
}

/// Totals of a driver's trips.
#[derive(Clone, Debug, Default)]
struct Driver {
    /// (y, x) of each trip, in their order.
    trips: Vec<(f64, f64)>,
    /// Σ y less that of the other drive, Σ x, seconds and money less, m.
    excess: Sums,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    y: f64,
    x: f64,
    time_s: f64,
    money: f64,
    distance_m: f64,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.y += other.y;
        self.x += other.x;
        self.time_s += other.time_s;
        self.money += other.money;
        self.distance_m += other.distance_m;
    }

    fn of<'a>(all: impl Iterator<Item = &'a Self>) -> Self {
        all.fold(Self::default(), |mut sum, one| {
            sum.add(one);
            sum
        })
    }

    /// Over its own distance: of the quantity, time, money.
    fn over(&self) -> [f64; 3] {
        [self.y / self.x, self.time_s / self.distance_m, 1000.0 * self.money / self.distance_m]
    }
}

impl Driver {
    /// Mean of its first trips.
    fn recorded(&self, trips: usize) -> f64 {
        let first = self.trips.iter().take(trips);
        let (y, x) = first.fold((0.0, 0.0), |sum, trip| (sum.0 + trip.0, sum.1 + trip.1));
        y / x
    }
}

/// Standing of a driver by the records and by the excess, so that drivers may be sampled.
#[derive(Clone, Copy, Debug)]
struct Standing {
    recorded: f64,
    excess: Sums,
}

impl Training {
    /// From the records of two drives of the same cycles: by each trip's own driver, and by the
    /// other one. `price` is what a trip costs. None where fewer than two drivers have a trip that
    /// both completed, or no trip has a consumption.
    pub fn of(
        own: &[Record],
        other: &[Record],
        options: &TrainingOptions,
        price: Option<Price>,
    ) -> Option<Self> {
        let quantity = consumption(own);
        let mut drivers: BTreeMap<u64, Driver> = BTreeMap::new();
        let mut spread: BTreeMap<u64, Spread> = BTreeMap::new();
        let mut pairs = 0;
        for (a, b) in own.iter().zip(other) {
            let Some((id, trip, excess)) = pair(quantity, a, b, price) else { continue };
            pairs += 1;
            let driver = drivers.entry(id).or_default();
            driver.trips.push(trip);
            driver.excess.add(&excess);
            if let Some(value) = quantity.of_cycle(a) {
                spread.entry(id).or_insert_with(|| Spread::of(id)).add(value);
            }
        }
        let drivers: Vec<Driver> = drivers.into_values().collect();
        if drivers.len() < 2 {
            return None;
        }
        let chosen = chosen_of(drivers.len(), options.share);
        let standings = |trips: usize| -> Vec<Standing> {
            let standing = |driver: &Driver| Standing {
                recorded: driver.recorded(trips),
                excess: driver.excess,
            };
            drivers.iter().map(standing).collect()
        };
        let all = standings(usize::MAX);
        let shown = |standings: &[Standing]| shown(standings, chosen);
        let spread: Vec<Spread> = spread.into_values().collect();
        let reliability = components(&spread).map(|components| components.share_of_means);
        let samples = samples(&all, options);
        let gain = |by: By| Gain::of(&all, by, options, &samples, price.is_some());
        let truly = ranked(&all, By::Excess);
        let truly_worst = |standings: &[Standing]| {
            let these = ranked(standings, By::Records);
            let hits = these[..chosen].iter().filter(|k| truly[..chosen].contains(k)).count();
            hits as f64 / chosen as f64
        };
        let most = drivers.iter().map(|driver| driver.trips.len()).max().unwrap_or(0);
        let choice = |trips: usize| {
            let standings = standings(trips);
            Choice {
                trips,
                truly_worst: truly_worst(&standings),
                shown: shown(&standings),
                gain: gained(&standings, By::Records, options)[0],
            }
        };
        let by_trips = RECORDED.into_iter().filter(|trips| *trips < most).map(choice);
        let whole = choice(most);
        let by_trips = by_trips.chain([whole]).collect();
        let places = ranked(&all, By::Records);
        let distance: f64 = places[..chosen].iter().map(|k| all[*k].excess.distance_m).sum();
        Some(Self {
            column: quantity.column,
            drivers: drivers.len(),
            chosen,
            pairs,
            left_out: own.len() as u64 - pairs,
            distance_m: distance / chosen as f64,
            reliability,
            shown: whole.shown,
            expected: reliability.map(|reliability| reliability * whole.shown),
            gain: gain(By::Records),
            gain_if_known: gain(By::Excess),
            truly_worst: whole.truly_worst,
            by_trips,
        })
    }
}

/// Driver, totals of its own drive, and how much more that is than the other one; none where one of
/// them was not completed.
fn pair(
    quantity: &RecordQuantity,
    a: &Record,
    b: &Record,
    price: Option<Price>,
) -> Option<(u64, (f64, f64), Sums)> {
    let (own, other) = (quantity.totals(a)?, quantity.totals(b)?);
    let money = match price {
        Some(price) => price(a)? - price(b)?,
        None => 0.0,
    };
    let excess = Sums {
        y: own.0 - other.0,
        x: own.1,
        time_s: a.duration_s - b.duration_s,
        money,
        distance_m: a.distance_m,
    };
    Some((a.driver_id.unwrap_or(a.cycle_id), own, excess))
}

/// How many of so many drivers are chosen.
fn chosen_of(drivers: usize, share: f64) -> usize {
    (libm::round(share * drivers as f64) as usize).clamp(1, drivers)
}

/// By what drivers are chosen.
#[derive(Clone, Copy, Debug)]
enum By {
    Records,
    Excess,
}

/// Places of the drivers, the worst first.
fn ranked(standings: &[Standing], by: By) -> Vec<usize> {
    let key = |k: &usize| match by {
        By::Records => standings[*k].recorded,
        By::Excess => standings[*k].excess.over()[0],
    };
    let mut places: Vec<usize> = (0..standings.len()).collect();
    places.sort_by(|a, b| key(b).total_cmp(&key(a)));
    places
}

/// The middle fifth of places, at least one.
fn middle(places: &[usize]) -> &[usize] {
    let n = places.len();
    &places[(2 * n / 5).min((n - 1) / 2)..(3 * n).div_ceil(5)]
}

/// Excess in the records: the mean of the chosen less that of the middle fifth, each driver counted
/// once.
fn shown(standings: &[Standing], chosen: usize) -> f64 {
    let places = ranked(standings, By::Records);
    let mean = |some: &[usize]| {
        some.iter().map(|k| standings[*k].recorded).sum::<f64>() / some.len() as f64
    };
    mean(&places[..chosen]) - mean(middle(&places))
}

/// Gain by training over the distance of the chosen: of the quantity, time, money.
fn gained(standings: &[Standing], by: By, options: &TrainingOptions) -> [f64; 3] {
    let places = ranked(standings, by);
    let chosen = &places[..chosen_of(places.len(), options.share)];
    let sum = |some: &[usize]| Sums::of(some.iter().map(|k| &standings[*k].excess)).over();
    let have = sum(chosen);
    if options.is_trained {
        return have;
    }
    let truly = ranked(standings, By::Excess);
    let reached = sum(middle(&truly));
    [0, 1, 2].map(|k| have[k] - reached[k])
}

/// Bootstrap samples of the drivers; none of too few.
fn samples(standings: &[Standing], options: &TrainingOptions) -> Vec<Vec<Standing>> {
    let n = standings.len();
    if n < LEAST_DRIVERS {
        return Vec::new();
    }
    let sample = |number| drawn_again(options.seed, number, n).map(|k| standings[k]).collect();
    (0..RESAMPLES).map(sample).collect()
}

impl Gain {
    fn of(
        standings: &[Standing],
        by: By,
        options: &TrainingOptions,
        samples: &[Vec<Standing>],
        has_prices: bool,
    ) -> Self {
        let [of_quantity, time_s_per_m, money] = gained(standings, by, options);
        let drawn: Vec<[f64; 3]> =
            samples.iter().map(|sample| gained(sample, by, options)).collect();
        let interval = |k: usize| percentiles(drawn.iter().map(|gains| gains[k]).collect());
        Self {
            of_quantity,
            of_quantity_ci95: interval(0),
            time_s_per_m,
            money_per_km: has_prices.then_some(money),
            money_per_km_ci95: interval(2).filter(|_| has_prices),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::energy::Carrier;
    use ocmc_core::random::{Draws, Stream};

    const OPTIONS: TrainingOptions = TrainingOptions { share: 0.2, is_trained: false, seed: 1 };

    fn trip(driver: u64, cycle_id: u64, litres: f64) -> Record {
        Record {
            cycle_id,
            driver_id: Some(driver),
            distance_m: 1000.0,
            duration_s: 60.0,
            ..Record::default().with(Carrier::LiquidFuel, [None, Some(litres), None])
        }
    }

    /// Drivers with SD 1 on trucks with SD 2, and trips with SD 5; the other driver takes 29 litres
    /// on the mean truck.
    fn drives(seed: u64, drivers: u64, trips: u64) -> (Vec<Record>, Vec<Record>) {
        let mut draws = Draws::new(seed, 0, Stream::Curve);
        let (mut own, mut other) = (Vec::new(), Vec::new());
        for driver in 0..drivers {
            let (person, truck) = (draws.normal(), 2.0 * draws.normal());
            for k in 0..trips {
                let road = truck + 5.0 * draws.normal();
                let id = driver * trips + k;
                own.push(trip(driver, id, 30.0 + person + road));
                other.push(trip(driver, id, 29.0 + road));
            }
        }
        (own, other)
    }

    #[test]
    fn five_drivers_by_hand() {
        // means 20, 30, 40, 50, 60; they take 0, 1, 2, 3, 5 more than the other driver
        let more = [0.0, 1.0, 2.0, 3.0, 5.0];
        let own: Vec<Record> = (0..5).map(|k| trip(k, k, 20.0 + 10.0 * k as f64)).collect();
        let other: Vec<Record> =
            (0..5).map(|k| trip(k, k, 20.0 + 10.0 * k as f64 - more[k as usize])).collect();
        let training = Training::of(&own, &other, &OPTIONS, None).expect("five drivers");
        assert_eq!((training.drivers, training.chosen, training.pairs), (5, 1, 5));
        // the worst takes 60, the middle one 40; its excess falls from 5 to 2
        assert!((training.shown - 20.0).abs() < 1e-12);
        assert!((training.gain.of_quantity - 3.0).abs() < 1e-12, "{training:?}");
        assert_eq!(training.truly_worst, 1.0);
        assert_eq!((training.gain.of_quantity_ci95, training.gain.money_per_km), (None, None));
        let trained = TrainingOptions { is_trained: true, ..OPTIONS };
        let training = Training::of(
            &own,
            &other,
            &trained,
            Some(&|record| Some(record.consumption(Carrier::LiquidFuel)? / 100.0)),
        );
        let training = training.expect("five drivers");
        assert!((training.gain.of_quantity - 5.0).abs() < 1e-12);
        assert!((training.gain.money_per_km.expect("a price") - 0.05).abs() < 1e-12);
    }

    #[test]
    fn records_promise_more_than_training_gives() {
        let (own, other) = drives(1, 500, 20);
        let training = Training::of(&own, &other, &OPTIONS, None).expect("drivers");
        // the worst fifth of a normal law lies 1.400 SD above its middle (0.2800/0.2); a mean has
        // SD √(1 + 4 + 25/20) = 2.5, and of it the share 1/6.25 is the driver's variance
        let shown = 1.400 * 2.5;
        let own_share = shown / 6.25;
        // errors of the mean of 100 of 500 drivers: about 0.12 and 0.10
        assert!((training.shown - shown).abs() < 0.48, "{training:?}");
        assert!((training.gain.of_quantity - own_share).abs() < 0.40, "{training:?}");
        let known = training.gain_if_known.of_quantity;
        assert!((known - 1.400).abs() < 0.2, "{known}");
        // s_b²/(s_b² + s_w²/m) = 5/6.25; its error is about 0.015
        assert!((training.reliability.expect("they differ") - 0.8).abs() < 0.06, "{training:?}");
        assert!(training.truly_worst > 0.25 && training.truly_worst < 0.6, "{training:?}");
        let [low, high] = training.gain.of_quantity_ci95.expect("500 drivers");
        assert!(low < training.gain.of_quantity && training.gain.of_quantity < high);
        // records of more trips choose better
        let trips: Vec<usize> = training.by_trips.iter().map(|choice| choice.trips).collect();
        assert_eq!(trips, [5, 10, 20]);
    }

    #[test]
    fn the_interval_covers_the_gain() {
        const RUNS: usize = 200;
        // the law's own: the chosen by the records, 1.400/2.5 of an SD of 1
        let mut covered = 0;
        for seed in 0..RUNS as u64 {
            let (own, other) = drives(seed + 10, 100, 20);
            let training = Training::of(&own, &other, &OPTIONS, None).expect("drivers");
            let [low, high] = training.gain.of_quantity_ci95.expect("100 drivers");
            covered += usize::from(low <= 0.56 && 0.56 <= high);
        }
        let share = covered as f64 / RUNS as f64;
        assert!((0.89..=0.99).contains(&share), "{share}");
    }

    #[test]
    fn one_driver_and_none() {
        let (own, other) = drives(1, 1, 20);
        assert!(Training::of(&own, &other, &OPTIONS, None).is_none());
        assert!(Training::of(&[], &[], &OPTIONS, None).is_none());
    }
}
