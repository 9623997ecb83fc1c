//! Fits as text: tables of estimates with their errors or intervals.

use crate::birds_eye::birds_eye_text;
use crate::text::{row, table};
use ocmc_estimation::fit::analysis_of_variance::VarianceRow;
use ocmc_estimation::fit::curve_speed::{
    CurveSpeedEstimate, CurveSpeedFit, Dropped, RandomEffects,
};
use ocmc_estimation::fit::operating_cycle::RoadFit;
use ocmc_estimation::fit::p_value::p_text;
use ocmc_estimation::fit::speed_change::{SpeedChangeFit, SpeedChangeLaw};
use ocmc_estimation::fit::study_parameter::StudyParameterFit;
use ocmc_io::number_text::{count_of, grouped};
use std::fmt::Write;
use std::iter::once;

/// Widths of a name and of an estimate.
const NAME: usize = 30;
const VALUE: usize = 25;

/// A line of a table: its name, and what stands in it for a model.
type Line<'a, Model> = (&'a str, fn(&Model) -> String);

/// Most drivers that are printed one by one; the JSON has them all.
const MOST_DRIVERS: usize = 50;

/// Curve speeds: the paper's two tables first, then what stands beside them.
pub(super) fn curve_speed(fit: &CurveSpeedFit, rows: usize) -> String {
    let [smallest, largest] = fit.radius_range_m;
    let (used, rows) = (grouped(fit.n as u64), grouped(rows as u64));
    let drivers = count_of(fit.drivers as u64, "driver");
    [
        format!("{used} of {rows} curves, {drivers}, radii of {smallest:.0} to {largest:.0} m\n"),
        dropped(&fit.dropped, "row"),
        variance_table("Analysis of variance of ln v, each term beside those above it", &fit.anova),
        variance_table("Each term beside all others", &fit.anova_marginal),
        estimates(fit),
        exponent_test(fit),
        random_effects(fit),
        each_driver(fit),
    ]
    .concat()
}

/// How many of a thing were left out, by reason.
fn dropped(dropped: &Dropped, thing: &str) -> String {
    let lines = dropped.iter().map(|(reason, count)| {
        format!("left out: {}, {}\n", count_of(*count as u64, thing), reason.replace('_', " "))
    });
    lines.collect()
}

fn variance_table(title: &str, rows: &[VarianceRow]) -> String {
    let rows = rows.iter().map(|row| {
        let (f, p) = match (row.f, row.ln_p) {
            (Some(f), Some(ln_p)) => (significant(f, 6), p_text(ln_p)),
            _ => (String::new(), String::new()),
        };
        let [sum_sq, mean_sq] = [row.sum_sq, row.mean_sq].map(|sum| significant(sum, 6));
        [row.term.to_string(), row.df.to_string(), sum_sq, mean_sq, f, p]
    });
    let head = ["", "df", "sum sq", "mean sq", "F", "p"];
    format!("\n{title}\n{}", table(&[12, 8, 14, 14, 13, 15], &head, rows))
}

/// A number with so many significant digits, in powers of ten where it is very large or small.
fn significant(number: f64, digits: i32) -> String {
    let size = number.abs();
    if size == 0.0 || !number.is_finite() {
        return number.to_string();
    }
    if !(1e-4..1e6).contains(&size) {
        return format!("{number:.*e}", (digits - 1) as usize);
    }
    let whole = size.log10().floor() as i32 + 1;
    format!("{number:.*}", (digits - whole).max(0) as usize)
}

/// The estimates of two or more models side by side.
fn estimates(fit: &CurveSpeedFit) -> String {
    let mut models = vec![("estimated", &fit.estimated), ("exponent fixed", &fit.fixed)];
    if let Some(tobit) = &fit.tobit {
        models.push(("at limits censored", tobit));
    }
    if let Some(below) = &fit.below_limit {
        models.push(("below limits only*", below));
    }
    let speed = format!("v0, speed at {:.0} m, km/h", fit.reference_radius_m);
    let rows: [Line<CurveSpeedEstimate>; 9] = [
        ("curves", |e| grouped(e.n as u64)),
        ("exponent", |e| match e.exponent_ci95 {
            Some(ci) => interval(e.exponent, ci, 1.0, 3),
            None => format!("{} (fixed)", e.exponent),
        }),
        ("  by driver as cluster", |e| match e.exponent_clustered_ci95 {
            Some(ci) => interval(e.exponent, ci, 1.0, 3),
            None => "-".to_owned(),
        }),
        (&speed, |e| interval(e.reference_speed_mps, e.reference_speed_ci95, 3.6, 1)),
        ("between drivers, SD, %", |e| optional(e.driver_sd_corrected.or(e.driver_sd), 100.0, 1)),
        ("  weighted by curves", |e| optional(e.driver_sd_weighted, 100.0, 1)),
        ("direction, + left, %", |e| match (e.direction_effect, e.direction_effect_ci95) {
            (Some(effect), Some(ci)) => interval(effect, ci, 100.0, 2),
            _ => "left out".to_owned(),
        }),
        ("residual, SD, %", |e| match e.residual_sd_ci95 {
            Some(ci) => interval(e.residual_sd, ci, 100.0, 1),
            None => optional(Some(e.residual_sd), 100.0, 1),
        }),
        ("variance between drivers, %", |e| optional(e.driver_share, 100.0, 0)),
    ];
    let mut text = String::new();
    for pair in models.chunks(2) {
        let head: Vec<&str> = once("").chain(pair.iter().map(|(name, _)| *name)).collect();
        let rows = rows.iter().map(|(name, value)| -> Vec<String> {
            let values = pair.iter().map(|(_, estimate)| value(estimate));
            once((*name).to_owned()).chain(values).collect()
        });
        let _ = write!(text, "\n{}", table(&[NAME, VALUE, VALUE], &head, rows));
    }
    if let Some(at_limit) = fit.at_limit {
        let _ = writeln!(
            text,
            "{} curves are at the speed limit. * Diagnostic only: leaving them out cuts the \
             response\n\
             off and bends the exponent.",
            grouped(at_limit as u64)
        );
    }
    text
}

/// A number with its interval.
fn interval(value: f64, [low, high]: [f64; 2], factor: f64, digits: usize) -> String {
    format!("{:.digits$} ({:.digits$} ; {:.digits$})", factor * value, factor * low, factor * high)
}

fn optional(value: Option<f64>, factor: f64, digits: usize) -> String {
    value.map_or("-".to_owned(), |value| format!("{:.digits$}", factor * value))
}

fn exponent_test(fit: &CurveSpeedFit) -> String {
    let test = &fit.exponent_test;
    let mut text = format!(
        "\nexponent {}: t = {}, {} df, p = {}",
        test.exponent,
        significant(test.t, 4),
        test.df,
        p_text(test.ln_p)
    );
    if let (Some(t), Some(ln_p)) = (test.t_clustered, test.ln_p_clustered) {
        let _ = write!(
            text,
            "; drivers as clusters: t = {}, {} df, p = {}",
            significant(t, 4),
            fit.drivers - 1,
            p_text(ln_p)
        );
    }
    text.push('\n');
    text
}

fn random_effects(fit: &CurveSpeedFit) -> String {
    let (Some(intercept), Some(slope)) = (&fit.random_intercept, &fit.random_slope) else {
        return String::new();
    };
    let speed = format!("v0, speed at {:.0} m, km/h", fit.reference_radius_m);
    let rows: [Line<RandomEffects>; 8] = [
        ("exponent ± error", |e| format!("{:.4} ± {:.4}", e.exponent, e.exponent_standard_error)),
        (&speed, |e| {
            let speed = 3.6 * e.reference_speed_mps;
            format!("{speed:.2} ± {:.2}", speed * e.reference_speed_log_standard_error)
        }),
        ("between drivers, SD, %", |e| match e.driver_sd_ci95 {
            Some(ci) => interval(e.driver_sd, ci, 100.0, 2),
            None => optional(Some(e.driver_sd), 100.0, 2),
        }),
        ("exponents, SD", |e| optional(e.exponent_sd, 1.0, 4)),
        ("correlation with level", |e| optional(e.correlation, 1.0, 2)),
        ("residual, SD, %", |e| optional(Some(e.residual_sd), 100.0, 2)),
        ("variance between drivers, %", |e| optional(Some(e.driver_share), 100.0, 1)),
        ("REML criterion", |e| optional(Some(e.reml_criterion), 1.0, 2)),
    ];
    let rows = rows.map(|(name, value)| [name.to_owned(), value(intercept), value(slope)]);
    let head = ["Drivers as random effects, REML", "one exponent", "an exponent each"];
    let mut text = format!("\n{}", table(&[NAME, VALUE, VALUE], &head, rows));
    if intercept.singular {
        text.push_str("One exponent: singular, drivers differ by no more than their curves do.\n");
    }
    if slope.singular {
        text.push_str(
            "An exponent each: singular, levels or exponents have no variance of their own, and \
             the\n\
             correlation says nothing.\n",
        );
    }
    text
}

fn each_driver(fit: &CurveSpeedFit) -> String {
    let shown = fit.by_driver.iter().take(MOST_DRIVERS);
    let width =
        shown.clone().map(|driver| driver.driver.chars().count()).max().unwrap_or(0).clamp(8, 24);
    let rows = shown.map(|driver| {
        let exponent = match (driver.exponent, driver.exponent_ci95) {
            (Some(exponent), Some(ci)) => interval(exponent, ci, 1.0, 3),
            _ => "-".to_owned(),
        };
        let speed = optional(driver.reference_speed_mps, 3.6, 1);
        let name = driver.driver.chars().take(width).collect();
        let r_squared = optional(driver.r_squared, 1.0, 3);
        [name, grouped(driver.n as u64), exponent, speed, r_squared]
    });
    let head = ["", "curves", "exponent", "v0, km/h", "R2"];
    let mut text = format!("\nEach driver alone\n{}", table(&[width, 9, 25, 10, 8], &head, rows));
    if fit.by_driver.len() > MOST_DRIVERS {
        let _ =
            writeln!(text, "... and {} more: --json has all", fit.by_driver.len() - MOST_DRIVERS);
    }
    if let Some(spread) = &fit.between_drivers {
        let _ = writeln!(
            text,
            "{} drivers: exponent {:.4}, SD {:.4}; v0 {:.1} km/h, SD of ln v0 {:.1} %; \
             correlation {:.2}",
            spread.drivers,
            spread.exponent_mean,
            spread.exponent_sd,
            3.6 * spread.reference_speed_mean_mps,
            100.0 * spread.reference_speed_log_sd,
            spread.correlation
        );
    }
    text
}

/// Columns of the printed table: a name, then numbers.
const COLUMNS: usize = 6;

/// The whole answer.
pub(super) fn speed_change(fit: &SpeedChangeFit) -> String {
    let mut text = format!("{}\n", count_of(fit.n as u64, "speed change"));
    text.push_str(&dropped(&fit.dropped, "speed change"));
    let pooled = [&fit.acceleration, &fit.deceleration].into_iter().flatten();
    let laws: Vec<&SpeedChangeLaw> = fit.by_category.iter().chain(pooled).collect();
    text.push('\n');
    text.push_str(&law_table(&laws));
    text.push_str(
        "p normal: of a log-normal law, by Anderson and Darling. With threshold: median and SD \
         with the\n\
         changes below the threshold in the likelihood.\n",
    );
    text
}

/// A row a law, in columns as wide as what stands in them.
fn law_table(laws: &[&SpeedChangeLaw]) -> String {
    let head = ["", "n", "median, m/s2", "SD of ln", "p normal", "with threshold"];
    let rows: Vec<[String; COLUMNS]> =
        once(head.map(str::to_owned)).chain(laws.iter().map(|law| cells(law))).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths: [usize; COLUMNS] = std::array::from_fn(|column| width(column).unwrap_or(0));
    let between = once(None).chain(laws.iter().map(|law| law.between_drivers));
    let mut text = String::new();
    for (cells, between) in rows.iter().zip(between) {
        text.push_str(&row("  ", &widths, cells));
        if let Some(between) = between {
            let first = widths[0];
            let sd = match between.driver_log_sd_ci95 {
                Some(ci) => interval(between.driver_log_sd, ci, 1.0, 3),
                None => format!("{:.3}", between.driver_log_sd),
            };
            let _ = writeln!(
                text,
                "{:first$}  {} drivers: median {:.3} m/s2, SD of ln between drivers {sd}, of a \
                 driver's changes {:.3}",
                "", between.drivers, between.median_mps2, between.change_log_sd
            );
        }
    }
    text
}

fn cells(law: &SpeedChangeLaw) -> [String; COLUMNS] {
    let name = if law.category.is_empty() { "unnamed" } else { &law.category };
    let p = law.anderson_darling_p.map_or("-".to_owned(), |p| format!("{p:.3}"));
    let whole = law
        .untruncated
        .map_or("-".to_owned(), |law| format!("{:.3}, {:.3}", law.median_mps2, law.log_sd));
    let sd = law.log_sd.map_or("-".to_owned(), |sd| {
        interval(sd, law.log_sd_ci95.unwrap_or([f64::NAN; 2]), 1.0, 2)
    });
    let median = match law.median_ci95 {
        Some(ci) => interval(law.median_mps2, ci, 1.0, 3),
        None => format!("{:.3}", law.median_mps2),
    };
    [name.to_owned(), law.n.to_string(), median, sd, p, whole]
}

/// Roads: what they look like from above, and the estimates of each road type.
pub(super) fn roads(fit: &RoadFit) -> String {
    let cycles = count_of(fit.cycles as u64, "operating cycle");
    let mut text = format!("{cycles}, {:.1} km\n", fit.length_m / 1000.0);
    text.push_str(&birds_eye_text(&fit.birds_eye));
    for of_type in &fit.types {
        let _ = writeln!(text, "\n{}, {:.1} km", of_type.road_type, of_type.length_m / 1000.0);
        text.push_str(&parameter_table("", &of_type.parameters));
    }
    for (title, parameters) in
        [("turns at junctions", &fit.junction_turn), ("mission", &fit.mission)]
    {
        if !parameters.is_empty() {
            let _ = write!(text, "\n{}", parameter_table(title, parameters));
        }
    }
    text
}

/// A table of estimated numbers with their errors, under a title.
pub(super) fn parameter_table(title: &str, parameters: &[StudyParameterFit]) -> String {
    let rows = parameters.iter().map(|parameter| {
        let error = parameter.standard_error.map_or("-".to_owned(), short);
        [parameter.key.clone(), short(parameter.value), error, parameter.n.to_string()]
    });
    table(&[38, 14, 14, 10], &[title, "estimate", "error", "n"], rows)
}

/// Four digits, in powers of ten where it is small.
fn short(number: f64) -> String {
    match number.abs() {
        0.0 => "0".to_owned(),
        size if size < 1e-2 => format!("{number:.3e}"),
        size if size < 10.0 => format!("{number:.4}"),
        _ => format!("{number:.1}"),
    }
}
