//! The nonlinear least-squares problems of NIST (StRD), from both starts: what the solver of the
//! identification reaches.
//!
//! Prints a row for each problem and start: `cargo test -p ocmc-estimation --test it nist_nonlinear
//! -- --nocapture`.

use crate::others_data::shared;
use ocmc_estimation::identification::bounded_least_squares::{Tolerances, minimise, one_by_one};
use std::f64::consts::PI;

/// A model: parameters, predictors.
type Model = fn(&[f64], &[f64]) -> f64;

/// Model of each problem, by the name of its file.
const PROBLEMS: [(&str, Model); 21] = [
    ("Bennett5", |b, x| b[0] * (b[1] + x[0]).powf(-1.0 / b[2])),
    ("BoxBOD", |b, x| b[0] * (1.0 - (-b[1] * x[0]).exp())),
    ("Chwirut1", |b, x| (-b[0] * x[0]).exp() / (b[1] + b[2] * x[0])),
    ("Chwirut2", |b, x| (-b[0] * x[0]).exp() / (b[1] + b[2] * x[0])),
    ("DanWood", |b, x| b[0] * x[0].powf(b[1])),
    ("ENSO", |b, x| {
        let wave = |a: f64, c: f64, period: f64| {
            let angle = 2.0 * PI * x[0] / period;
            a * angle.cos() + c * angle.sin()
        };
        b[0] + wave(b[1], b[2], 12.0) + wave(b[4], b[5], b[3]) + wave(b[7], b[8], b[6])
    }),
    ("Eckerle4", |b, x| b[0] / b[1] * (-0.5 * ((x[0] - b[2]) / b[1]).powi(2)).exp()),
    ("Gauss1", gauss),
    ("Gauss2", gauss),
    ("Lanczos1", lanczos),
    ("Lanczos2", lanczos),
    ("Lanczos3", lanczos),
    ("MGH09", |b, x| b[0] * (x[0] * x[0] + x[0] * b[1]) / (x[0] * x[0] + x[0] * b[2] + b[3])),
    ("MGH17", |b, x| b[0] + b[1] * (-x[0] * b[3]).exp() + b[2] * (-x[0] * b[4]).exp()),
    ("Misra1a", |b, x| b[0] * (1.0 - (-b[1] * x[0]).exp())),
    ("Misra1b", |b, x| b[0] * (1.0 - (1.0 + b[1] * x[0] / 2.0).powi(-2))),
    ("Misra1c", |b, x| b[0] * (1.0 - (1.0 + 2.0 * b[1] * x[0]).powf(-0.5))),
    ("Misra1d", |b, x| b[0] * b[1] * x[0] / (1.0 + b[1] * x[0])),
    ("Nelson", |b, x| b[0] - b[1] * x[0] * (-b[2] * x[1]).exp()),
    ("Rat42", |b, x| b[0] / (1.0 + (b[1] - b[2] * x[0]).exp())),
    ("Roszman1", |b, x| b[0] - b[1] * x[0] - (b[2] / (x[0] - b[3])).atan() / PI),
];

fn gauss(b: &[f64], x: &[f64]) -> f64 {
    let bell =
        |height: f64, centre: f64, width: f64| height * (-((x[0] - centre) / width).powi(2)).exp();
    b[0] * (-b[1] * x[0]).exp() + bell(b[2], b[3], b[4]) + bell(b[5], b[6], b[7])
}

fn lanczos(b: &[f64], x: &[f64]) -> f64 {
    (0..3).map(|k| b[2 * k] * (-b[2 * k + 1] * x[0]).exp()).sum()
}

/// A problem with its certified answer.
struct Problem {
    starts: [Vec<f64>; 2],
    certified: Vec<f64>,
    sum_of_squares: f64,
    y: Vec<f64>,
    x: Vec<Vec<f64>>,
}

fn read(path: &std::path::Path) -> Problem {
    let text = std::fs::read_to_string(path).unwrap();
    let numbers = |line: &str| -> Vec<f64> {
        line.split_whitespace().filter_map(|word| word.parse().ok()).collect()
    };
    let mut problem = Problem {
        starts: [Vec::new(), Vec::new()],
        certified: Vec::new(),
        sum_of_squares: f64::NAN,
        y: Vec::new(),
        x: Vec::new(),
    };
    let mut in_data = false;
    for line in text.lines() {
        let is_parameter = line.trim_start().strip_prefix('b').is_some_and(|rest| {
            rest.trim_start().starts_with(|c: char| c.is_ascii_digit()) && line.contains('=')
        });
        if let (true, Some((_, values))) = (is_parameter && !in_data, line.split_once('=')) {
            let values = numbers(values);
            if values.len() == 4 {
                problem.starts[0].push(values[0]);
                problem.starts[1].push(values[1]);
                problem.certified.push(values[2]);
            }
        } else if let Some(value) = line.strip_prefix("Residual Sum of Squares:") {
            problem.sum_of_squares = numbers(value)[0];
        } else if line.starts_with("Data:")
            && !line.contains("Response")
            && !line.contains("Predictor")
        {
            in_data = true;
        } else if in_data {
            let row = numbers(line);
            if row.len() >= 2 {
                problem.y.push(row[0]);
                problem.x.push(row[1..].to_vec());
            }
        }
    }
    problem
}

/// Correct digits of the worst parameter.
fn digits(found: &[f64], certified: &[f64]) -> f64 {
    let error = found.iter().zip(certified).map(|(a, b)| ((a - b) / b).abs());
    -error.fold(1e-15, f64::max).log10()
}

#[test]
fn certified_from_both_starts() {
    let Some(folder) = shared("stats/nist_nonlinear") else { return };
    println!("| problem | start | digits | iterations | sum of squares / certified |");
    println!("|---|---|---|---|---|");
    let mut failures = Vec::new();
    for (name, model) in PROBLEMS {
        let mut problem = read(&folder.join(format!("{name}.dat")));
        if name == "Nelson" {
            // the model is of log y
            problem.y.iter_mut().for_each(|y| *y = y.ln());
        }
        let count = problem.certified.len();
        assert!(count >= 2 && problem.y.len() >= 6, "{name}");
        for start in 0..2 {
            let mut residuals = one_by_one(|b| {
                problem.x.iter().zip(&problem.y).map(|(x, y)| model(b, x) - y).collect()
            });
            let free = vec![[f64::NEG_INFINITY, f64::INFINITY]; count];
            let tolerances = Tolerances { most_iterations: 5000, ..Tolerances::default() };
            let found = minimise(&mut residuals, &problem.starts[start], &free, &tolerances);
            let digits = digits(&found.parameters, &problem.certified);
            println!(
                "| {name} | {} | {digits:.1} | {} | {:.10} |",
                start + 1,
                found.iterations,
                found.sum_of_squares / problem.sum_of_squares
            );
            if digits < 6.0 {
                failures.push(format!("{name} from start {}: {digits:.1} digits", start + 1));
            }
        }
    }
    // From (1, 1) the second step makes b2 so large that exp(−b2 x) is zero at every x: the
    // residuals no longer depend on b2, and nothing leads back. Solvers that start from here need a
    // box, or other starts.
    assert_eq!(failures, ["BoxBOD from start 1: -2.3 digits"]);
    let problem = read(&folder.join("BoxBOD.dat"));
    let model = |b: &[f64], x: f64| b[0] * (1.0 - (-b[1] * x).exp());
    let mut residuals =
        one_by_one(|b| problem.x.iter().zip(&problem.y).map(|(x, y)| model(b, x[0]) - y).collect());
    let tolerances = Tolerances::default();
    let boxed =
        minimise(&mut residuals, &problem.starts[0], &[[0.0, 1000.0], [0.0, 1.0]], &tolerances);
    assert!(digits(&boxed.parameters, &problem.certified) > 6.0, "{boxed:?}");
}

/// MGH10 (R. R. Meyer, 1970; More, Garbow, Hillstrom 1981, problem 10): resistance of a thermistor
/// over temperature, y = b1 exp(b2 / (x + b3)). From its first start the way to the optimum leads
/// through b1 of 1e-26, along a valley that bends at every step: thousands of iterations, and no
/// stop on the way that calls itself converged.
#[test]
fn the_thermistor_is_found_from_both_starts() {
    let y = [
        34780.0, 28610.0, 23650.0, 19630.0, 16370.0, 13720.0, 11540.0, 9744.0, 8261.0, 7030.0,
        6005.0, 5147.0, 4427.0, 3820.0, 3307.0, 2872.0,
    ];
    let certified = [5.6096364710e-03, 6.1813463463e+03, 3.4522363462e+02];
    let model = |b: &[f64], x: f64| b[0] * (b[1] / (x + b[2])).exp();
    let mut residuals =
        one_by_one(|b| y.iter().zip(10..).map(|(y, k)| model(b, 5.0 * f64::from(k)) - y).collect());
    let free = [[f64::NEG_INFINITY, f64::INFINITY]; 3];
    let tolerances = Tolerances { most_iterations: 20_000, ..Tolerances::default() };
    for start in [[2.0, 400_000.0, 25_000.0], [0.02, 4000.0, 250.0]] {
        let found = minimise(&mut residuals, &start, &free, &tolerances);
        let digits = digits(&found.parameters, &certified);
        println!("from {start:?}: {digits:.1} digits after {} iterations", found.iterations);
        assert!(digits > 6.0 && found.converged, "{found:?}");
        assert!((found.sum_of_squares / 8.7945855171e+01 - 1.0).abs() < 1e-8, "{found:?}");
    }
}
