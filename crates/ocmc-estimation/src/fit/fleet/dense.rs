//! The same by dense matrices: V, its inverse and determinant, as the textbooks have it.

use super::components::{Components, best_ratios};
use super::likelihood::Posterior;
use super::trips::{FleetDesign, FleetTable, Trips};
use super::{FleetOptions, fit};
use crate::fit::nelder_mead::minimise;
use nalgebra::{DMatrix, DVector};
use ocmc_core::random::{Draws, Stream};
use std::f64::consts::PI;

/// Draws whose moments are looked at.
const DRAWS: u64 = 4000;

/// A small table with gaps, weights and months; `drivers_of` says who may drive a truck.
fn table(seed: u64, trucks: usize, drivers_of: impl Fn(usize) -> Vec<usize>) -> FleetTable {
    let mut draws = Draws::new(seed, 0, Stream::Bootstrap);
    let levels: Vec<f64> = (0..60).map(|_| draws.normal()).collect();
    let mut table = FleetTable {
        driver: Some(Vec::new()),
        weight: Some(Vec::new()),
        departure_s_of_year: Some(Vec::new()),
        ..FleetTable::default()
    };
    for truck in 0..trucks {
        for driver in drivers_of(truck) {
            for _ in 0..=(5.0 * draws.uniform()) as usize {
                let day = 90.0 * draws.uniform();
                let weight = 0.2 + draws.uniform();
                let trip = 0.8 * draws.normal() / weight.sqrt();
                let value = 30.0 + levels[truck] + 0.7 * levels[30 + driver] + trip + 0.01 * day;
                table.truck.push(format!("t{truck}"));
                table.driver.as_mut().unwrap().push(format!("d{driver}"));
                table.value.push(value);
                table.weight.as_mut().unwrap().push(weight);
                table.departure_s_of_year.as_mut().unwrap().push(day * 86_400.0);
            }
        }
    }
    table
}

fn options() -> FleetOptions {
    FleetOptions { month: true, ..FleetOptions::default() }
}

/// Tables of each design.
fn tables() -> Vec<(FleetDesign, FleetTable)> {
    vec![
        (FleetDesign::DriversInTrucks, table(1, 6, |t| vec![2 * t, 2 * t + 1])),
        (FleetDesign::TrucksOfDrivers, table(2, 9, |t| vec![t / 2])),
        (FleetDesign::Crossed, table(3, 8, |t| vec![t % 5, (t + 2) % 5, (t + 3) % 5])),
        (FleetDesign::Crossed, table(4, 4, |t| vec![t, t + 1, t + 2, 7])),
        // two depots
        (FleetDesign::Crossed, table(5, 8, |t| vec![4 * (t / 4) + t % 2, 4 * (t / 4) + 2])),
        (FleetDesign::TruckAndDriver, table(6, 7, |t| vec![t])),
    ]
}

/// Rows in full.
struct Full {
    x: DMatrix<f64>,
    y: DVector<f64>,
    z: [DMatrix<f64>; 2],
    weights: Vec<f64>,
}

impl Full {
    fn of(table: &FleetTable, trips: &Trips) -> Self {
        let n = table.value.len();
        let weights = table.weight.clone().unwrap();
        let mean = weights.iter().sum::<f64>() / n as f64;
        let month = |k: usize| {
            let day = table.departure_s_of_year.as_ref().unwrap()[k] / 86_400.0;
            [31.0, 59.0, 90.0].iter().position(|end| day < *end).unwrap()
        };
        let names = [&table.truck, table.driver.as_ref().unwrap()];
        let z = [0, 1].map(|f| {
            let labels = &trips.families[f].labels;
            let is = |k: usize, label: &str| label.split(" & ").next() == Some(&names[f][k]);
            DMatrix::from_fn(n, labels.len(), |k, l| f64::from(is(k, &labels[l])))
        });
        Self {
            x: DMatrix::from_fn(n, 3, |k, j| f64::from(j == 0 || month(k) == j)),
            y: DVector::from_vec(table.value.clone()),
            z,
            weights: weights.iter().map(|weight| weight / mean).collect(),
        }
    }

    fn covariance(&self, sd: [f64; 3]) -> DMatrix<f64> {
        let noise = self.weights.iter().map(|weight| sd[2] * sd[2] / weight);
        let noise = DMatrix::from_diagonal(&DVector::from_iterator(self.y.len(), noise));
        let part = |f: usize| &self.z[f] * self.z[f].transpose() * (sd[f] * sd[f]);
        noise + part(0) + part(1)
    }

    /// Minus twice the restricted log-likelihood.
    fn criterion(&self, sd: [f64; 3]) -> f64 {
        let v = self.covariance(sd).cholesky().unwrap();
        let log_det = |l: &DMatrix<f64>| 2.0 * l.diagonal().iter().map(|x| x.ln()).sum::<f64>();
        let gram = (self.x.transpose() * v.solve(&self.x)).cholesky().unwrap();
        let beta = gram.solve(&(self.x.transpose() * v.solve(&self.y)));
        let rest = &self.y - &self.x * beta;
        log_det(&v.l())
            + log_det(&gram.l())
            + rest.dot(&v.solve(&rest))
            + (self.y.len() - self.x.ncols()) as f64 * (2.0 * PI).ln()
    }
}

#[test]
fn the_criterion_is_that_of_the_dense_matrices() {
    for (design, table) in tables() {
        let trips = Trips::of(&table, &options()).unwrap();
        assert_eq!(trips.design, design);
        let full = Full::of(&table, &trips);
        for theta in [[0.0, 0.0], [0.7, 0.0], [0.0, 2.5], [0.3, 0.9], [6.0, 0.04], [40.0, 30.0]] {
            let theta = if trips.families[1].len() == 0 { [theta[0], 0.0] } else { theta };
            let trip = trips.trip_sd(theta).unwrap();
            let sd = [theta[0] * trip, theta[1] * trip, trip];
            let (fast, slow) = (trips.criterion(theta), full.criterion(sd));
            assert!((fast - slow).abs() < 1e-9 * slow.abs(), "{design:?} {theta:?} {fast} {slow}");
            // and away from the best σ
            let wide = sd.map(|sd| 1.3 * sd);
            let fast = trips.deviance(wide) - trips.deviance(sd);
            let slow = full.criterion(wide) - slow;
            assert!((fast - slow).abs() < 1e-8, "{design:?} {theta:?} {fast} {slow}");
        }
    }
}

#[test]
fn the_estimate_is_no_worse_than_that_of_a_search_without_derivatives() {
    for seed in 10..60 {
        let table = table(seed, 6, |t| match seed % 3 {
            0 => vec![2 * t, 2 * t + 1],
            1 => vec![t % 4, (t + 1) % 4],
            _ => vec![t, t + 1, t + 2],
        });
        let trips = Trips::of(&table, &FleetOptions::default()).unwrap();
        let (theta, criterion) = best_ratios(&trips);
        for start in [[0.1, 0.1], [1.0, 1.0], [2.0, 0.2]] {
            let (other, lowest) =
                minimise(|x: &[f64; 2]| trips.criterion(x.map(f64::abs)), start, 0.3);
            assert!(criterion < lowest + 1e-7, "{seed}: {theta:?} {criterion}, {other:?} {lowest}");
        }
    }
}

#[test]
fn predictions_and_their_errors_are_those_of_the_dense_matrices() {
    for (design, table) in tables() {
        let trips = Trips::of(&table, &options()).unwrap();
        let full = Full::of(&table, &trips);
        let sd = if trips.families[1].len() == 0 { [0.9, 0.0, 0.8] } else { [0.9, 0.6, 0.8] };
        let posterior = Posterior::new(&trips, sd).unwrap();
        // with a flat prior of β, all of β and b are one normal vector given y
        let v = full.covariance(sd).cholesky().unwrap();
        let gram = (full.x.transpose() * v.solve(&full.x)).try_inverse().unwrap();
        let beta = &gram * full.x.transpose() * v.solve(&full.y);
        let rest = v.solve(&(&full.y - &full.x * &beta));
        let levels = full.z[0].ncols() + full.z[1].ncols();
        let z =
            DMatrix::from_fn(full.y.len(), levels, |k, l| match l.checked_sub(full.z[0].ncols()) {
                Some(driver) => full.z[1][(k, driver)],
                None => full.z[0][(k, l)],
            });
        let prior = DVector::from_fn(levels, |l, _| {
            let sd = sd[usize::from(l >= full.z[0].ncols())];
            sd * sd
        });
        let cross = DMatrix::from_diagonal(&prior) * z.transpose();
        let effects = &cross * &rest;
        let follows = &cross * v.solve(&full.x);
        let error = DMatrix::from_diagonal(&prior) - &cross * v.solve(&cross.transpose())
            + &follows * &gram * follows.transpose();
        let place = |f: usize, l: usize| if f == 0 { l } else { full.z[0].ncols() + l };
        for family in 0..2 {
            for level in 0..trips.families[family].len() {
                let at = place(family, level);
                let combined = posterior.combine(&[0.0; 3], &[(family, level, 1.0)]);
                assert!((combined.mean - effects[at]).abs() < 1e-9, "{design:?}");
                assert!((combined.variance - error[(at, at)]).abs() < 1e-10, "{design:?}");
            }
        }
        // a combination of all of them, and of β
        let mut terms = Vec::new();
        let mut weights = DVector::zeros(levels);
        for family in 0..2 {
            for level in 0..trips.families[family].len() {
                let c = 0.1 * (level as f64 + 1.0) - 0.35 + 0.2 * family as f64;
                terms.push((family, level, c));
                weights[place(family, level)] += c;
            }
        }
        let fixed = DVector::from_vec(vec![1.0, 0.3, -0.2]);
        let combined = posterior.combine(fixed.as_slice(), &terms);
        let mean = fixed.dot(&beta) + weights.dot(&effects);
        let between = -&gram * follows.transpose();
        let variance = fixed.dot(&(&gram * &fixed))
            + weights.dot(&(&error * &weights))
            + 2.0 * fixed.dot(&(&between * &weights));
        assert!((combined.mean - mean).abs() < 1e-9, "{design:?} {combined:?} {mean}");
        assert!((combined.variance - variance).abs() < 1e-10, "{design:?} {combined:?} {variance}");
        // draws have these means and covariances
        let mut drawn = posterior.effects.clone();
        let (mut sum, mut squares) = (DVector::zeros(levels), DMatrix::zeros(levels, levels));
        for number in 0..DRAWS {
            posterior.draw(&mut Draws::new(7, number, Stream::Bootstrap), &mut drawn);
            let all = DVector::from_iterator(levels, drawn.iter().flatten().copied()) - &effects;
            squares += &all * all.transpose();
            sum += all;
        }
        for i in 0..levels {
            let sd = error[(i, i)].sqrt();
            assert!(sum[i].abs() < 4.5 * sd * (DRAWS as f64).sqrt(), "{design:?} {i}");
            for j in 0..=i {
                let size = (error[(i, i)] * error[(j, j)] + error[(i, j)].powi(2)).sqrt();
                let off = squares[(i, j)] / DRAWS as f64 - error[(i, j)];
                assert!(off.abs() < 4.5 * size / (DRAWS as f64).sqrt(), "{design:?} {i} {j}");
            }
        }
    }
}

#[test]
fn the_information_is_that_of_the_dense_matrices() {
    // expected information of the variances: tr(P Vᵢ P Vⱼ)/2. Observed and expected information
    // differ by chance alone, the less the more levels there are
    let table = table(8, 25, |t| vec![t % 9, (t + 4) % 9, 9 + t % 11]);
    let trips = Trips::of(&table, &options()).unwrap();
    let full = Full::of(&table, &trips);
    let components = Components::estimate(&trips).unwrap();
    let v = full.covariance(components.sd).try_inverse().unwrap();
    let gram = (full.x.transpose() * &v * &full.x).try_inverse().unwrap();
    let p = &v - &v * &full.x * gram * full.x.transpose() * &v;
    let noise = full.weights.iter().map(|weight| 1.0 / weight);
    let noise = DMatrix::from_diagonal(&DVector::from_iterator(full.y.len(), noise));
    let parts = [&full.z[0] * full.z[0].transpose(), &full.z[1] * full.z[1].transpose(), noise];
    let parts: Vec<DMatrix<f64>> = parts.iter().map(|part| &p * part).collect();
    // of the logarithms of SDs: times 2 σᵢ² · 2 σⱼ²
    let information = DMatrix::from_fn(3, 3, |i, j| {
        let scale = 4.0 * (components.sd[i] * components.sd[j]).powi(2);
        0.5 * scale * (&parts[i] * &parts[j]).trace()
    });
    let expected = information.try_inverse().unwrap();
    let observed = components.log_covariance.unwrap();
    for i in 0..3 {
        let ratio = (observed[(i, i)] / expected[(i, i)]).sqrt();
        assert!((0.8..1.25).contains(&ratio), "{i}: {ratio}");
    }
}

#[test]
fn what_has_no_fit_says_why() {
    let fit_of = |truck: &[&str], driver: Option<&[&str]>, value: &[f64]| {
        let words = |names: &[&str]| names.iter().map(|word| (*word).to_owned()).collect();
        fit(
            &FleetTable {
                truck: words(truck),
                driver: driver.map(words),
                value: value.to_vec(),
                ..FleetTable::default()
            },
            &FleetOptions::default(),
        )
    };
    let error = |result: Result<_, super::FleetFitError>| result.unwrap_err().to_string();
    let text = error(fit_of(&["a", "a", "b", ""], None, &[1.0, 2.0, f64::NAN, 3.0]));
    assert_eq!(
        text,
        "2 trips of 1 trucks; allowed are two trucks or more (left out: 1 no truck, 1 no value)"
    );
    let text = error(fit_of(&["a", "b", "c"], None, &[1.0, 2.0, 3.0]));
    assert!(text.contains("do not repeat"), "{text}");
    let text = error(fit_of(&["a", "a", "b", "b"], None, &[1.0, 1.0, 3.0, 3.0]));
    assert!(text.contains("all the same"), "{text}");
    let text =
        error(fit_of(&["a", "a", "b", "b"], Some(&["1", "2", "1", "2"]), &[1.0, 2.0, 2.0, 3.0]));
    assert!(text.contains("all the same"), "{text}");
    let options = FleetOptions { power: 1.0, ..FleetOptions::default() };
    let text = fit(&FleetTable::default(), &options).unwrap_err().to_string();
    assert_eq!(text, "power is 1; allowed is a share above 0 and below 1");
}
