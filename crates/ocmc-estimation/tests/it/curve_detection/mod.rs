//! Curves of logs whose roads are known: how many are found, how many are made up, and how their
//! radii err.
//!
//! Prints the table of `docs/src/theory/curve-detection.md`:
//! `cargo test -p ocmc-estimation --test it curve_detection -- --nocapture`.

mod synthetic_road;

use ocmc_core::operating_cycle::road::curvature::Curve;
use ocmc_estimation::log::curve::{
    Correction, CurveOptions, Detector, DrivenCurve, RadiusDefinition, detect_curves,
};
use ocmc_estimation::log::hidden_markov::HiddenMarkov;
use ocmc_estimation::log::threshold::Threshold;
use synthetic_road::{GYRO_BIAS_RADPS, add_positions, course_alone, log, rural_curves};

/// Length of a road, in m.
const LENGTH_M: f64 = 200_000.0;
/// Radii that the fit uses, in m.
const RADII_M: std::ops::RangeInclusive<f64> = 20.0..=500.0;

/// How a detector did.
#[derive(Default)]
struct Score {
    curves: usize,
    found: usize,
    false_curves: usize,
    detected: usize,
    errors: Vec<f64>,
}

impl Score {
    fn add(&mut self, truth: &[Curve], found: &[DrivenCurve], options: &CurveOptions) {
        // a standstill has no way: positions of log and road agree
        let overlaps = |curve: &Curve, driven: &DrivenCurve| {
            curve.left == driven.left
                && driven.start_m < curve.end_m.min(LENGTH_M)
                && curve.start_m < driven.end_m
        };
        let wanted = truth.iter().filter(|curve| {
            let length_m = curve.end_m - curve.start_m;
            RADII_M.contains(&curve.radius_m)
                && length_m >= options.shortest_m
                && length_m / curve.radius_m >= options.smallest_turn_rad
        });
        for curve in wanted {
            let middle_m = f64::midpoint(curve.start_m, curve.end_m);
            self.curves += 1;
            let Some(driven) = found
                .iter()
                .find(|d| d.left == curve.left && d.start_m <= middle_m && middle_m <= d.end_m)
            else {
                continue;
            };
            self.found += 1;
            self.errors.push((driven.radius_m / curve.radius_m).ln());
        }
        self.detected += found.len();
        self.false_curves +=
            found.iter().filter(|driven| !truth.iter().any(|c| overlaps(c, driven))).count();
    }

    /// Mean and standard deviation of the error of ln R.
    fn radius_error(&self) -> (f64, f64) {
        let mean =
            |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / self.errors.len() as f64;
        let bias = mean(&mut self.errors.iter().copied());
        (bias, mean(&mut self.errors.iter().map(|error| (error - bias).powi(2))).sqrt())
    }

    fn row(&self, what: &str) -> String {
        let (bias, sd) = self.radius_error();
        let percent = |part: usize, whole: usize| 100.0 * part as f64 / whole as f64;
        format!(
            "| {what} | {} | {:.1} % | {:.1} % | {bias:+.4} | {sd:.3} |",
            self.curves,
            percent(self.found, self.curves),
            percent(self.false_curves, self.detected),
        )
    }
}

fn score(rate_hz: f64, noise: f64, options: &CurveOptions) -> Score {
    let mut score = Score::default();
    for seed in 1..=3 {
        let truth = rural_curves(seed, LENGTH_M);
        let drive = log(seed, &truth, LENGTH_M, rate_hz, noise);
        let found = detect_curves(&drive, options).unwrap();
        let bias = found.gyro_bias_radps.unwrap();
        assert!((bias - noise * GYRO_BIAS_RADPS).abs() < 0.003 * noise + 1e-12, "{bias}");
        score.add(&truth, &found.curves, options);
    }
    score
}

#[test]
fn nearly_all_curves_are_found_and_none_is_made_up() {
    let hidden = CurveOptions::default();
    let cut = CurveOptions { split_ratio: Some(1.3), ..CurveOptions::default() };
    let trained =
        CurveOptions { detector: Detector::TrainedHiddenMarkov(HiddenMarkov::default()), ..cut };
    // without noise and without cuts the threshold detector joins a curve to a wider one behind it:
    // a bias of 0.014
    let threshold = CurveOptions { detector: Detector::Threshold(Threshold::default()), ..cut };
    println!("| detector | log | curves | found | false | bias of ln R | SD of ln R |");
    println!("|---|---|---|---|---|---|---|");
    for (name, options) in [
        ("hidden Markov", &hidden),
        ("hidden Markov, cut at steps", &cut),
        ("hidden Markov, trained, cut at steps", &trained),
        ("threshold, cut at steps", &threshold),
    ] {
        for (rate_hz, noise) in [(1.0, 1.0), (5.0, 1.0), (10.0, 0.0), (10.0, 2.0), (100.0, 1.0)] {
            let score = score(rate_hz, noise, options);
            println!("{}", score.row(&format!("{name} | {rate_hz} Hz, noise × {noise}")));
            let share = |part: usize, whole: usize| part as f64 / whole as f64;
            assert!(share(score.found, score.curves) >= 0.97);
            assert!(share(score.false_curves, score.detected) <= 0.01);
            let (bias, sd) = score.radius_error();
            assert!(bias.abs() <= 0.01, "{bias}");
            // where two curves of one direction meet, only the cut separates them
            assert!(sd < if options.split_ratio.is_some() { 0.1 } else { 0.25 }, "{sd}");
        }
    }
    let paper = CurveOptions { radius: RadiusDefinition::MeanRadius, ..cut };
    let score = score(10.0, 2.0, &paper);
    println!("{}", score.row("the same, mean of R | 10 Hz, noise × 2"));
    assert!(score.radius_error().0 > 0.0, "noise biases the mean radius upwards");
}

#[test]
fn the_course_of_a_receiver_does_for_a_gyro() {
    println!("| detector | log | curves | found | false | bias of ln R | SD of ln R |");
    let plain = CurveOptions { gyro_bias_radps: Correction::Given(0.0), ..CurveOptions::default() };
    let cut = CurveOptions { split_ratio: Some(1.3), ..plain };
    for (name, options) in [("course alone", plain), ("course alone, cut at steps", cut)] {
        for (rate_hz, rows, error_mps) in [
            (1.0, 1, 0.1),
            (5.0, 1, 0.1),
            (10.0, 10, 0.1),
            (10.0, 2, 0.1),
            (10.0, 1, 0.0),
            (10.0, 1, 0.1),
        ] {
            let mut score = Score::default();
            for seed in 1..=3 {
                let truth = rural_curves(seed, LENGTH_M);
                let mut drive = log(seed, &truth, LENGTH_M, rate_hz, 1.0);
                course_alone(&mut drive, seed, 1.0, rows, error_mps);
                let found = detect_curves(&drive, &options).unwrap();
                score.add(&truth, &found.curves, &options);
            }
            let updates_hz = rate_hz / rows as f64;
            println!(
                "{}",
                score.row(&format!(
                    "{name} | {rate_hz} Hz, {updates_hz} updates a second, {error_mps} m/s"
                ))
            );
            let share = |part: usize, whole: usize| part as f64 / whole as f64;
            assert!(share(score.found, score.curves) >= 0.97);
            assert!(share(score.false_curves, score.detected) <= 0.01);
            let (bias, _) = score.radius_error();
            assert!(bias.abs() <= 0.01, "{bias}");
        }
    }
}

#[test]
fn gaps_cut_the_log_and_cost_only_the_curves_in_them() {
    let truth = rural_curves(1, LENGTH_M);
    let mut drive = log(1, &truth, LENGTH_M, 10.0, 1.0);
    // every 100 s three seconds without yaw rate
    for (time_s, yaw) in drive.time_s.iter().zip(drive.yaw_rate_radps.to_mut()) {
        if time_s % 100.0 > 97.0 {
            *yaw = f64::NAN;
        }
    }
    let found = detect_curves(&drive, &CurveOptions::default()).unwrap();
    let expected = (drive.time_s[drive.time_s.len() - 1] / 100.0) as usize;
    assert!(found.counts.gaps.abs_diff(expected) <= 1, "{:?}", found.counts);
    assert!((found.counts.missing_yaw_rate as f64 / drive.time_s.len() as f64 - 0.03).abs() < 1e-3);
    let whole =
        detect_curves(&log(1, &truth, LENGTH_M, 10.0, 1.0), &CurveOptions::default()).unwrap();
    assert!(found.way_m < whole.way_m && found.way_m > 0.96 * whole.way_m);
    // a curve with a gap in it is cut in two, or loses an end; no other curve changes in number
    let with_gap = |curve: &&DrivenCurve| {
        let next_s = 100.0 * (curve.start_s / 100.0).ceil();
        next_s - 3.0 < curve.end_s || curve.start_s % 100.0 > 97.0
    };
    let (n, m) = (found.curves.len(), whole.curves.len());
    let touched = whole.curves.iter().filter(with_gap).count();
    assert!(touched > 5 && n.abs_diff(m) <= touched, "{n} {m} {touched}");
}

#[test]
fn positions_give_the_same_radii() {
    let truth = rural_curves(2, 50_000.0);
    let mut drive = log(2, &truth, 50_000.0, 10.0, 0.0);
    add_positions(&mut drive);
    let of = |radius| {
        let options = CurveOptions { radius, ..CurveOptions::default() };
        detect_curves(&drive, &options).unwrap().curves
    };
    let (turns, circles) =
        (of(RadiusDefinition::InverseMeanCurvature), of(RadiusDefinition::Positions));
    assert_eq!(turns.len(), circles.len());
    let errors: Vec<f64> =
        turns.iter().zip(&circles).map(|(a, b)| (b.radius_m / a.radius_m).ln()).collect();
    let near = errors.iter().filter(|error| error.abs() < 0.05).count();
    assert!(near as f64 > 0.9 * errors.len() as f64, "{near} of {}", errors.len());
}
