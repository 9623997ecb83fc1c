//! Records of fleets with known SDs, and published data with known estimates.

use ocmc_core::random::{Draws, Stream};
use ocmc_estimation::fit::fleet::{
    Best, FleetDesign, FleetFit, FleetOptions, FleetTable, IntervalKind, fit,
};

/// Few draws, where the league is not looked at.
fn quick() -> FleetOptions {
    FleetOptions { draws: 1, ..FleetOptions::default() }
}

fn table(rows: impl IntoIterator<Item = (String, Option<String>, f64)>) -> FleetTable {
    let mut table = FleetTable::default();
    for (truck, driver, value) in rows {
        table.truck.push(truck);
        if let Some(driver) = driver {
            table.driver.get_or_insert_default().push(driver);
        }
        table.value.push(value);
    }
    table
}

fn near(found: f64, wanted: f64, digits: f64) {
    assert!((found - wanted).abs() <= 0.5000001 * digits, "{found}, not {wanted}");
}

/// SD of a level.
fn sd(fit: &FleetFit, level: &str) -> f64 {
    fit.components.iter().find(|component| component.level == level).unwrap().sd
}

// Published data. REML estimates as lme4 prints them: D. Bates, lme4: Mixed-effects modeling with R
// (2010), chapters 1 and 2. Criteria with all digits, by programs that share no code with lme4: the
// tests of the repositories MixedModels.jl (Dyestuff) and Metida.jl (the others, also by SPSS).

/// Yield of dyestuff from six batches: O. L. Davies, P. L. Goldsmith, Statistical Methods in
/// Research and Production, 4th ed. (1972), table 6.2.
const DYESTUFF: [[f64; 5]; 6] = [
    [1545.0, 1440.0, 1440.0, 1520.0, 1580.0],
    [1540.0, 1555.0, 1490.0, 1560.0, 1495.0],
    [1595.0, 1550.0, 1605.0, 1510.0, 1560.0],
    [1445.0, 1440.0, 1595.0, 1465.0, 1545.0],
    [1595.0, 1630.0, 1515.0, 1635.0, 1625.0],
    [1520.0, 1455.0, 1450.0, 1480.0, 1445.0],
];

#[test]
fn dyestuff_one_level() {
    let rows = DYESTUFF.iter().enumerate();
    let rows = rows.flat_map(|(b, batch)| batch.iter().map(move |y| (b.to_string(), None, *y)));
    let fit = fit(&table(rows), &quick()).unwrap();
    assert!((fit.reml_criterion - 319.654_276_842_252_16).abs() < 1e-8, "{}", fit.reml_criterion);
    near(sd(&fit, "truck"), 42.001, 2e-3);
    near(sd(&fit, "trip"), 49.510, 1e-3);
    near(fit.mean, 1527.5, 1e-9);
    near(fit.mean_standard_error, 19.38, 0.01);
    // of balanced trips −2 l = Σ ν (ln λ + MS/λ) over λ = σ² + 5 τ² with 5 and λ = σ² with 24
    // degrees of freedom: at both ends it is by 3.84 (1 + 1/15) above the smallest, σ at its best
    let means = DYESTUFF.map(|batch| batch.iter().sum::<f64>() / 5.0);
    let between = means.iter().map(|mean| (mean - 1527.5).powi(2)).sum::<f64>();
    let rest = DYESTUFF.iter().zip(means);
    let rest = rest.flat_map(|(batch, mean)| batch.iter().map(move |y| (y - mean).powi(2)));
    let rest = rest.sum::<f64>();
    let deviance = |tau: f64, trip: f64| {
        let (v, w) = (trip * trip + 5.0 * tau * tau, trip * trip);
        5.0 * v.ln() + 5.0 * between / v + 24.0 * w.ln() + rest / w
    };
    let profile = |tau: f64| {
        (0..80_000).map(|k| deviance(tau, 20.0 + 0.001 * f64::from(k))).fold(f64::MAX, f64::min)
    };
    let wanted = profile(fit.components[0].sd) + 3.841_459 * (1.0 + 1.0 / 15.0);
    for end in fit.components[0].ci95.unwrap() {
        let at = if end > 0.0 { profile(end) } else { wanted };
        assert!((at - wanted).abs() < 1e-3, "{end}: {at} {wanted}");
    }
    assert!(fit.components[0].ci95.unwrap()[1] > 84.0);
    assert_eq!(fit.components[0].ci95_by, Some(IntervalKind::ProfileLikelihood));
}

/// Strength of a paste, two assays of three casks of each of ten batches: the same, table 6.5.
const PASTES: [[[f64; 2]; 3]; 10] = [
    [[62.8, 62.6], [60.1, 62.3], [62.7, 63.1]],
    [[60.0, 61.4], [57.5, 56.9], [61.1, 58.9]],
    [[58.7, 57.5], [63.9, 63.1], [65.4, 63.7]],
    [[57.1, 56.4], [56.9, 58.6], [64.7, 64.5]],
    [[55.1, 55.1], [54.7, 54.2], [58.8, 57.5]],
    [[63.4, 64.9], [59.3, 58.1], [60.5, 60.0]],
    [[62.5, 62.6], [61.0, 58.7], [56.9, 57.7]],
    [[59.2, 59.4], [65.2, 66.0], [64.8, 64.1]],
    [[54.8, 54.8], [64.0, 64.0], [57.7, 56.8]],
    [[58.3, 59.3], [59.2, 59.2], [58.9, 56.6]],
];

fn nested<const K: usize, const J: usize>(
    data: &[[[f64; K]; J]],
) -> impl Iterator<Item = (String, Option<String>, f64)> + '_ {
    data.iter().enumerate().flat_map(|(i, truck)| {
        truck.iter().enumerate().flat_map(move |(j, driver)| {
            driver.iter().map(move |y| (format!("t{i}"), Some(j.to_string()), *y))
        })
    })
}

#[test]
fn pastes_nested() {
    // casks are numbered within batches
    let options = FleetOptions { own_drivers: true, ..quick() };
    let fit = fit(&table(nested(&PASTES)), &options).unwrap();
    assert_eq!((fit.design, fit.drivers), (FleetDesign::DriversInTrucks, Some(30)));
    assert!((fit.reml_criterion - 246.990_745_853_486_23).abs() < 1e-8, "{}", fit.reml_criterion);
    near(fit.mean, 60.053_333, 1e-5);
    // balanced: the analysis of variance
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let driver = |i: usize, j: usize| mean(&PASTES[i][j]);
    let truck = |i: usize| mean(&[driver(i, 0), driver(i, 1), driver(i, 2)]);
    let whole = mean(&(0..10).map(truck).collect::<Vec<_>>());
    let (mut a, mut b, mut c) = (0.0, 0.0, 0.0);
    for i in 0..10 {
        a += 6.0 * (truck(i) - whole).powi(2) / 9.0;
        for j in 0..3 {
            b += 2.0 * (driver(i, j) - truck(i)).powi(2) / 20.0;
            c += PASTES[i][j].iter().map(|y| (y - driver(i, j)).powi(2)).sum::<f64>() / 30.0;
        }
    }
    let wanted = [((a - b) / 6.0).sqrt(), ((b - c) / 2.0).sqrt(), c.sqrt()];
    // observed and expected information are the same where the mean squares are what is expected
    let errors = [
        ((a * a / 9.0 + b * b / 20.0) / 18.0).sqrt() / (2.0 * wanted[0]),
        (0.5 * (b * b / 20.0 + c * c / 30.0)).sqrt() / (2.0 * wanted[1]),
        (c * c / 15.0).sqrt() / (2.0 * wanted[2]),
    ];
    for (component, (wanted, error)) in fit.components.iter().zip(wanted.iter().zip(errors)) {
        assert!((component.sd - wanted).abs() < 2e-6 * wanted, "{component:?} {wanted}");
        let found = component.standard_error.unwrap();
        assert!((found - error).abs() < 1e-4 * error, "{component:?} {error}");
    }
    near(sd(&fit, "driver"), 2.904, 1e-3);
    near(sd(&fit, "trip"), 0.8234, 1e-4);
}

/// Zones of inhibition by six samples of penicillin on 24 plates: the same, section 6.6; of each
/// plate the diameters in mm.
const PENICILLIN: [[u8; 6]; 24] = [
    [27, 23, 26, 23, 23, 21],
    [27, 23, 26, 23, 23, 21],
    [25, 21, 25, 24, 24, 20],
    [26, 23, 25, 23, 23, 20],
    [25, 22, 26, 22, 23, 20],
    [24, 22, 25, 23, 22, 19],
    [24, 20, 23, 21, 22, 19],
    [26, 22, 26, 24, 24, 21],
    [24, 21, 24, 22, 22, 20],
    [24, 21, 24, 23, 22, 19],
    [26, 23, 26, 24, 24, 21],
    [25, 22, 26, 24, 24, 20],
    [26, 24, 26, 24, 25, 22],
    [26, 23, 26, 23, 23, 20],
    [26, 23, 25, 24, 24, 22],
    [25, 22, 25, 23, 23, 20],
    [25, 21, 24, 23, 23, 20],
    [25, 22, 24, 23, 23, 19],
    [24, 21, 23, 21, 21, 19],
    [26, 23, 26, 24, 24, 21],
    [25, 21, 24, 22, 22, 18],
    [25, 22, 25, 22, 22, 20],
    [24, 21, 24, 22, 24, 19],
    [24, 21, 24, 22, 21, 18],
];

#[test]
fn penicillin_crossed() {
    let rows = PENICILLIN.iter().enumerate().flat_map(|(plate, samples)| {
        samples.iter().enumerate().map(move |(sample, diameter)| {
            (plate.to_string(), Some(sample.to_string()), f64::from(*diameter))
        })
    });
    let fit = fit(&table(rows), &quick()).unwrap();
    assert_eq!(fit.design, FleetDesign::Crossed);
    assert!((fit.reml_criterion - 330.860_588_991_091_84).abs() < 1e-8, "{}", fit.reml_criterion);
    near(sd(&fit, "truck"), 0.8467, 1e-4);
    near(sd(&fit, "driver"), 1.9316, 1e-4);
    near(sd(&fit, "trip"), 0.5499, 1e-4);
    near(fit.mean, 22.9722, 1e-4);
    near(fit.mean_standard_error, 0.8086, 1e-4);
}

#[test]
fn trucks_that_do_not_differ_are_at_the_end_of_the_range() {
    // means of trucks are all 2: less than by chance
    let rows = (0..12).map(|k| ((k / 3).to_string(), None, [1.0, 2.0, 3.0][k % 3]));
    let fit = fit(&table(rows), &quick()).unwrap();
    let truck = &fit.components[0];
    assert!(truck.sd == 0.0 && truck.standard_error.is_none(), "{truck:?}");
    let [low, high] = truck.ci95.unwrap();
    assert!(low == 0.0 && high > 0.1 && high.is_finite(), "{truck:?}");
    // then all trips are one sample
    assert!((fit.components[1].sd - (8.0_f64 / 11.0).sqrt()).abs() < 1e-9);
    assert!(fit.leagues.is_empty());
    assert!(fit.notes.iter().any(|note| note.contains("between trucks is 0")), "{:?}", fit.notes);
}

/// SDs of trucks, drivers and trips, and what is asked of them.
const SD: [f64; 3] = [0.9, 0.6, 2.0];

/// A fleet with known SDs: drivers of a truck, and trips of each pair.
fn fleet(
    seed: u64,
    trucks: usize,
    drivers_of: impl Fn(usize) -> Vec<usize>,
    trips_of: impl Fn(usize, usize) -> usize,
) -> FleetTable {
    let mut draws = Draws::new(seed, 0, Stream::Bootstrap);
    let levels: Vec<f64> = (0..trucks).map(|_| SD[0] * draws.normal()).collect();
    let drivers: Vec<f64> = (0..2000).map(|_| SD[1] * draws.normal()).collect();
    let mut rows = Vec::new();
    for truck in 0..trucks {
        for (place, driver) in drivers_of(truck).into_iter().enumerate() {
            for _ in 0..trips_of(truck, place) {
                let value = 30.0 + levels[truck] + drivers[driver] + SD[2] * draws.normal();
                rows.push((format!("t{truck}"), Some(format!("d{driver}")), value));
            }
        }
    }
    table(rows)
}

/// 10 trips of each pair, or 1 to 25.
fn even(_: usize, _: usize) -> usize {
    10
}

fn uneven(truck: usize, place: usize) -> usize {
    1 + (7 * truck + 11 * place + truck * place) % 25
}

/// A design: its name, who drives what, how often, and what it is.
type Design = (&'static str, fn(usize) -> Vec<usize>, fn(usize, usize) -> usize, FleetDesign);

const DESIGNS: [Design; 6] = [
    ("nested", |t| (3 * t..3 * t + 3).collect(), even, FleetDesign::DriversInTrucks),
    (
        "nested, uneven",
        |t| (5 * t..5 * t + 1 + t % 4).collect(),
        uneven,
        FleetDesign::DriversInTrucks,
    ),
    ("pool", |t| (0..4).map(|k| (7 * t + 13 * k) % 45).collect(), even, FleetDesign::Crossed),
    (
        "pool, uneven",
        |t| (0..2 + t % 4).map(|k| (7 * t + 13 * k) % 45).collect(),
        uneven,
        FleetDesign::Crossed,
    ),
    (
        "depots",
        |t| (0..3).map(|k| 6 * (t / 5) + (t + 2 * k) % 6).collect(),
        uneven,
        FleetDesign::Crossed,
    ),
    ("trucks of drivers", |t| vec![t / 3], |t, _| 10 + t % 20, FleetDesign::TrucksOfDrivers),
];

#[test]
fn set_variances_come_back() {
    for (name, drivers_of, trips_of, design) in DESIGNS {
        let mut sum = [0.0; 3];
        let mut squares = [0.0; 3];
        for seed in 1..=20 {
            let fit = fit(&fleet(seed, 60, drivers_of, trips_of), &quick()).unwrap();
            assert_eq!(fit.design, design, "{name}");
            for (k, component) in fit.components.iter().enumerate() {
                let error = component.standard_error.unwrap_or(0.35);
                let off = component.sd - SD[k];
                assert!(off.abs() < 4.0 * error, "{name} {seed}: {component:?}");
                sum[k] += off;
                squares[k] += off * off;
            }
        }
        // and without bias: what REML has of order 1/levels is below a hundredth of the SD
        for k in 0..3 {
            let mean = sum[k] / 20.0;
            let error = ((squares[k] / 20.0 - mean * mean) / 19.0).sqrt();
            println!("{name} {k}: off by {mean:.4} ± {error:.4}");
            assert!(mean.abs() < 4.0 * error + 0.01 * SD[k], "{name} {k}: {mean} {error}");
        }
    }
}

#[test]
fn intervals_and_standard_errors_are_those_seen() {
    const FLEETS: u64 = 200;
    for (name, drivers_of, trips_of, _) in [DESIGNS[1], DESIGNS[4]] {
        let mut covered = [0; 4];
        let (mut sum, mut squares, mut told) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for seed in 0..FLEETS {
            let fit = fit(&fleet(1000 + seed, 30, drivers_of, trips_of), &quick()).unwrap();
            for (k, component) in fit.components.iter().enumerate() {
                let [low, high] = component.ci95.unwrap();
                covered[k] += usize::from(low <= SD[k] && SD[k] <= high);
                let log = (component.sd.max(0.05) / SD[k]).ln();
                sum[k] += log;
                squares[k] += log * log;
                told[k] += component.standard_error.map_or(0.0, |e| (e / component.sd).powi(2));
            }
            covered[3] += usize::from(fit.mean_ci95[0] <= 30.0 && 30.0 <= fit.mean_ci95[1]);
        }
        println!("{name}: {covered:?} of {FLEETS}");
        assert!(covered.iter().all(|count| (182..=196).contains(count)), "{name}: {covered:?}");
        for k in [0, 2] {
            let n = FLEETS as f64;
            let seen = (squares[k] / n - (sum[k] / n).powi(2)).sqrt();
            let told = (told[k] / n).sqrt();
            assert!((0.8..1.25).contains(&(told / seen)), "{name} {k}: {told} {seen}");
        }
    }
}

#[test]
fn two_trucks_are_ranked_by_the_normal_law() {
    // two trucks alone say too little of the SD between trucks: eight, of which any two are
    // compared
    let rows = fleet(5, 2, |t| vec![t], |_, _| 40);
    let options = FleetOptions { draws: 20_000, ..FleetOptions::default() };
    let two = fit(&rows, &options).unwrap();
    assert_eq!(two.design, FleetDesign::TruckAndDriver);
    let league = &two.leagues[0];
    let first = &league.members[0];
    let p = first.before_next.unwrap();
    // the closed form: σ_t² and σ²/40 of each, their difference d shrunk by w = σ_t²/(σ_t² + σ²/40)
    let [level, trip] = [two.components[0].sd, two.components[1].sd];
    let noise = trip * trip / 40.0;
    let w = level * level / (level * level + noise);
    let d = league.members[1].mean - first.mean;
    let size = w * d / (2.0 * w * noise).sqrt();
    let wanted = 1.0 - 0.5 * both_tails(size);
    assert!((p - wanted).abs() < 1e-6, "{p} {wanted}");
    let error = (wanted * (1.0 - wanted) / 20_000.0).sqrt();
    assert!((league.first_is_first - wanted).abs() < 4.0 * error, "{league:?} {wanted}");
    assert_eq!(first.is_first, league.first_is_first);
    assert_eq!(league.order_is_right, league.first_is_first);
    assert_eq!(first.label, format!("t{0} & d{0}", &first.label[1..2]));
    // the same draws again
    assert_eq!(fit(&rows, &options).unwrap(), two);
}

/// P(|Z| > x) by its integral, so that nothing is shared with what is tested.
fn both_tails(x: f64) -> f64 {
    let density = |z: f64| (-0.5 * z * z).exp() * (2.0 / std::f64::consts::PI).sqrt();
    let (from, steps) = (x, 20_000);
    let h = (12.0 - from) / f64::from(steps);
    let inner: f64 = (1..steps)
        .map(|k| (if k % 2 == 1 { 4.0 } else { 2.0 }) * density(from + h * f64::from(k)))
        .sum();
    (density(from) + density(12.0) + inner) * h / 3.0
}

/// Leagues of simulated fleets beside the truth: sums of the probabilities, of how often it was so,
/// and of the variances; and the mean square of the predictions' errors over what is said.
fn leagues_beside_the_truth(trucks: usize) -> ([[f64; 3]; 3], f64) {
    let (mut sums, mut squares, mut members) = ([[0.0; 3]; 3], 0.0, 0.0);
    for seed in 5000..5150 {
        // the truth is drawn first, as `fleet` draws it
        let mut draws = Draws::new(seed, 0, Stream::Bootstrap);
        let truth: Vec<f64> = (0..trucks).map(|_| SD[0] * draws.normal()).collect();
        let drivers = |t: usize| (3 * t..3 * t + 3).collect();
        let rows = fleet(seed, trucks, drivers, |t, k| 3 + 2 * uneven(t, k));
        let best = if seed % 2 == 0 { Best::Lowest } else { Best::Highest };
        let options = FleetOptions { draws: 400, best, ..FleetOptions::default() };
        let fit = fit(&rows, &options).unwrap();
        let Some(league) = fit.leagues.iter().find(|league| league.level == "truck") else {
            continue;
        };
        let number = |label: &str| label[1..].parse::<usize>().unwrap();
        let places: Vec<usize> = league.members.iter().map(|m| number(&m.label)).collect();
        let mut order: Vec<usize> = (0..trucks).collect();
        order.sort_by(|a, b| truth[*a].total_cmp(&truth[*b]));
        if best == Best::Highest {
            order.reverse();
        }
        let rank = |truck: usize| order.iter().position(|other| *other == truck).unwrap();
        let three = places[..3].iter().all(|truck| rank(*truck) < 3);
        let told = [
            (league.first_is_first, places[0] == order[0]),
            (league.three_are_three.unwrap(), three),
            (league.members[5].before_next.unwrap(), rank(places[5]) < rank(places[6])),
        ];
        for (k, (p, is)) in told.into_iter().enumerate() {
            sums[0][k] += p;
            sums[1][k] += f64::from(u8::from(is));
            sums[2][k] += p * (1.0 - p);
        }
        for member in &league.members {
            let off = member.effect - truth[number(&member.label)];
            squares += (off / member.standard_error).powi(2);
            members += 1.0;
        }
    }
    (sums, squares / members)
}

#[test]
fn probabilities_of_leagues_are_those_seen() {
    // calibration: the first is truly the first as often as said, and so on
    for (trucks, largest) in [(12, 2.5), (40, 1.25)] {
        let ([said, seen, variance], pulls) = leagues_beside_the_truth(trucks);
        println!("{trucks} trucks: said {said:?}, seen {seen:?}; mean square of errors {pulls}");
        for k in 0..3 {
            assert!((said[k] - seen[k]).abs() < 4.0 * variance[k].sqrt(), "{k}: {said:?} {seen:?}");
        }
        // the errors of the estimated SDs are left out: much with few trucks
        assert!((0.85..largest).contains(&pulls), "{pulls}");
    }
}

#[test]
fn the_next_year_lies_in_its_intervals() {
    const FLEETS: u64 = 200;
    let (mut fleets, mut trucks, mut new) = (0, 0, 0);
    for seed in 0..FLEETS {
        let shape = |t: usize| (3 * t..3 * t + 1 + t % 3).collect::<Vec<_>>();
        let rows = fleet(9000 + seed, 20, shape, uneven);
        let options = FleetOptions { next_trips: Some(25), ..quick() };
        let next = fit(&rows, &options).unwrap().next_year;
        // the same trucks and drivers, as `fleet` draws them, with other trips
        let mut draws = Draws::new(9000 + seed, 0, Stream::Bootstrap);
        let levels: Vec<f64> = (0..20).map(|_| SD[0] * draws.normal()).collect();
        let drivers: Vec<f64> = (0..2000).map(|_| SD[1] * draws.normal()).collect();
        let mut draws = Draws::new(9000 + seed, 1, Stream::Bootstrap);
        let mut sum = 0.0;
        for truck in 0..20 {
            let counts: Vec<f64> =
                (0..shape(truck).len()).map(|k| uneven(truck, k) as f64).collect();
            let all: f64 = counts.iter().sum();
            let of = shape(truck).into_iter().zip(&counts).map(|(d, n)| drivers[d] * n / all);
            let mean = 30.0 + levels[truck] + of.sum::<f64>() + SD[2] / 5.0 * draws.normal();
            let [low, high] = next.trucks[truck].ci95;
            assert_eq!(next.trucks[truck].trips, 25);
            trucks += usize::from(low <= mean && mean <= high);
            sum += mean / 20.0;
        }
        let [low, high] = next.fleet.ci95;
        fleets += usize::from(low <= sum && sum <= high);
        let other =
            30.0 + SD[0] * draws.normal() + SD[1] * draws.normal() + SD[2] / 5.0 * draws.normal();
        let [low, high] = next.new_truck.ci95;
        new += usize::from(low <= other && other <= high);
    }
    println!("next year: {fleets} fleets, {trucks} trucks, {new} new trucks");
    assert!((182..=198).contains(&fleets), "{fleets}");
    assert!((182..=198).contains(&new), "{new}");
    // trucks of a fleet share its errors
    assert!((3700..=3900).contains(&trucks), "{trucks}");
}

#[test]
fn weights_and_months_are_taken_out() {
    // trips of 10 to 100 km whose variance is inverse to that, and a winter of 5
    let mut draws = Draws::new(11, 0, Stream::Bootstrap);
    let mut table = FleetTable {
        weight: Some(Vec::new()),
        departure_s_of_year: Some(Vec::new()),
        ..FleetTable::default()
    };
    for truck in 0..200 {
        let level = draws.normal();
        for _ in 0..30 {
            let (weight, day) = (10.0 + 90.0 * draws.uniform(), 365.0 * draws.uniform());
            let winter = if day < 59.0 { 5.0 } else { 0.0 };
            let trip = 3.0 * draws.normal() * (55.0 / weight).sqrt();
            table.truck.push(truck.to_string());
            table.value.push(30.0 + level + winter + trip);
            table.weight.as_mut().unwrap().push(weight);
            table.departure_s_of_year.as_mut().unwrap().push(86_400.0 * day);
        }
    }
    let options = FleetOptions { month: true, ..quick() };
    let with = fit(&table, &options).unwrap();
    // 3 at the mean weight, within four of its errors
    let trip = &with.components[1];
    assert!((trip.sd - 3.0).abs() < 4.0 * trip.standard_error.unwrap(), "{trip:?}");
    assert!((sd(&with, "truck") - 1.0).abs() < 4.0 * with.components[0].standard_error.unwrap());
    assert_eq!(with.months.len(), 12);
    let january = with.months[0];
    let july = with.months[6];
    let off = january.effect - july.effect - 5.0;
    assert!(
        off.abs() < 4.0 * (january.standard_error + july.standard_error),
        "{january:?} {july:?}"
    );
    // without them trips differ more
    let months_left = fit(&table, &quick()).unwrap();
    assert!(sd(&months_left, "trip") > 3.3);
    let unweighted = FleetTable { weight: None, ..table };
    let without = fit(&unweighted, &options).unwrap();
    assert!(without.components[0].standard_error > with.components[0].standard_error);
    assert!(sd(&without, "trip") > 1.1 * trip.sd, "{without:?}");
}

#[test]
fn a_large_fleet() {
    // 120,000 trips of 2000 trucks: the SDs come back
    let options = FleetOptions { draws: 100, ..FleetOptions::default() };
    let started = std::time::Instant::now();
    let fit = fit(&fleet(3, 1000, |t| vec![2 * t % 2000, (2 * t + 1) % 2000], |_, _| 60), &options);
    let fit = fit.unwrap();
    println!("{} trips in {:.2} s", fit.n, started.elapsed().as_secs_f64());
    assert_eq!((fit.n, fit.design), (120_000, FleetDesign::DriversInTrucks));
    for (component, wanted) in fit.components.iter().zip(SD) {
        assert!((component.sd - wanted).abs() < 4.0 * component.standard_error.unwrap());
    }
    // a pool of 300 drivers, all of them connected
    let started = std::time::Instant::now();
    let pool = fleet(4, 400, |t| (0..5).map(|k| (17 * t + 61 * k) % 300).collect(), |_, _| 8);
    let fit = self::fit(&pool, &options).unwrap();
    println!("{} trips of a pool in {:.2} s", fit.n, started.elapsed().as_secs_f64());
    assert_eq!(fit.design, FleetDesign::Crossed);
    for (component, wanted) in fit.components.iter().zip(SD) {
        assert!((component.sd - wanted).abs() < 4.0 * component.standard_error.unwrap());
    }
}
