//! The fit of curve speeds as text: the paper's two tables first, then what stands beside them.

use ocmc_estimation::fit::analysis_of_variance::VarianceRow;
use ocmc_estimation::fit::curve_speed::{
    CurveSpeedEstimate, CurveSpeedFit, DriverFit, Dropped, RandomEffects,
};
use ocmc_estimation::fit::p_value::p_text;
use ocmc_io::number_text::{count_of, grouped};
use std::fmt::Write;

/// Widths of a name and of an estimate.
const NAME: usize = 30;
const VALUE: usize = 25;

/// A line of a table: its name, and what stands in it for a model.
type Line<'a, Model> = (&'a str, fn(&Model) -> String);

/// Most drivers that are printed one by one; the JSON has them all.
const MOST_DRIVERS: usize = 50;

/// The whole answer.
pub(crate) fn curve_speed_text(fit: &CurveSpeedFit, rows: usize, values: &str) -> String {
    let mut text = heading(fit, rows);
    text.push_str("\nAnalysis of variance of ln v, each term beside those above it\n");
    text.push_str(&variance_table(&fit.anova));
    text.push_str("\nEach term beside all others\n");
    text.push_str(&variance_table(&fit.anova_marginal));
    text.push_str(&estimates(fit));
    text.push_str(&exponent_test(fit));
    text.push_str(&random_effects(fit));
    text.push_str(&drivers(fit));
    let _ = write!(text, "\nTo paste into a study:\n\n{values}");
    text
}

fn heading(fit: &CurveSpeedFit, rows: usize) -> String {
    let [smallest, largest] = fit.radius_range_m;
    let mut text = format!(
        "{} of {} curves, {}, radii of {smallest:.0} to {largest:.0} m\n",
        grouped(fit.n as u64),
        grouped(rows as u64),
        count_of(fit.drivers as u64, "driver"),
    );
    text.push_str(&dropped(&fit.dropped, "row"));
    text
}

/// How many of a thing were left out, by reason.
pub(super) fn dropped(dropped: &Dropped, thing: &str) -> String {
    let lines = dropped.iter().map(|(reason, count)| {
        format!("left out: {}, {}\n", count_of(*count as u64, thing), reason.replace('_', " "))
    });
    lines.collect()
}

fn variance_table(rows: &[VarianceRow]) -> String {
    let mut text =
        format!("{:12}{:>8}{:>14}{:>14}{:>13}{:>15}\n", "", "df", "sum sq", "mean sq", "F", "p");
    for row in rows {
        let (f, p) = match (row.f, row.ln_p) {
            (Some(f), Some(ln_p)) => (significant(f, 6), p_text(ln_p)),
            _ => (String::new(), String::new()),
        };
        let line = format!(
            "{:12}{:>8}{:>14}{:>14}{f:>13}{p:>15}",
            row.term,
            row.df,
            significant(row.sum_sq, 6),
            significant(row.mean_sq, 6),
        );
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
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
    let mut text = String::new();
    for pair in models.chunks(2) {
        let _ = write!(text, "\n{:NAME$}", "");
        for (name, _) in pair {
            let _ = write!(text, "{name:>VALUE$}");
        }
        text.push('\n');
        let speed = format!("v0, speed at {:.0} m, km/h", fit.reference_radius_m);
        let rows: [Line<CurveSpeedEstimate>; 9] = [
            ("curves", |e| grouped(e.n as u64)),
            ("exponent", |e| match e.exponent_ci95 {
                Some(ci) => with_interval(e.exponent, ci, 1.0, 3),
                None => format!("{} (fixed)", e.exponent),
            }),
            ("  by driver as cluster", |e| match e.exponent_clustered_ci95 {
                Some(ci) => with_interval(e.exponent, ci, 1.0, 3),
                None => "-".to_owned(),
            }),
            (&speed, |e| with_interval(e.reference_speed_mps, e.reference_speed_ci95, 3.6, 1)),
            ("between drivers, SD, %", |e| optional(e.driver_sd, 100.0, 1)),
            ("  weighted by curves", |e| optional(e.driver_sd_weighted, 100.0, 1)),
            ("direction, + left, %", |e| match (e.direction_effect, e.direction_effect_ci95) {
                (Some(effect), Some(ci)) => with_interval(effect, ci, 100.0, 2),
                _ => "left out".to_owned(),
            }),
            ("residual, SD, %", |e| match e.residual_sd_ci95 {
                Some(ci) => with_interval(e.residual_sd, ci, 100.0, 1),
                None => optional(Some(e.residual_sd), 100.0, 1),
            }),
            ("variance between drivers, %", |e| optional(e.driver_share, 100.0, 0)),
        ];
        for (name, value) in rows {
            let _ = write!(text, "{name:NAME$}");
            for (_, estimate) in pair {
                let _ = write!(text, "{:>VALUE$}", value(estimate));
            }
            text.push('\n');
        }
    }
    if let Some(at_limit) = fit.at_limit {
        let _ = writeln!(
            text,
            "{} curves are at the speed limit. * Diagnostic only: leaving them out cuts the response\n\
             off and bends the exponent.",
            grouped(at_limit as u64)
        );
    }
    text
}

fn with_interval(value: f64, [low, high]: [f64; 2], factor: f64, digits: usize) -> String {
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
    let mut text = format!(
        "\n{:NAME$}{:>VALUE$}{:>VALUE$}\n",
        "Drivers as random effects, REML", "one exponent", "an exponent each"
    );
    let speed = format!("v0, speed at {:.0} m, km/h", fit.reference_radius_m);
    let rows: [Line<RandomEffects>; 8] = [
        ("exponent ± error", |e| format!("{:.4} ± {:.4}", e.exponent, e.exponent_standard_error)),
        (&speed, |e| {
            let speed = 3.6 * e.reference_speed_mps;
            format!("{speed:.2} ± {:.2}", speed * e.reference_speed_log_standard_error)
        }),
        ("between drivers, SD, %", |e| optional(Some(e.driver_sd), 100.0, 2)),
        ("exponents, SD", |e| optional(e.exponent_sd, 1.0, 4)),
        ("correlation with level", |e| optional(e.correlation, 1.0, 2)),
        ("residual, SD, %", |e| optional(Some(e.residual_sd), 100.0, 2)),
        ("variance between drivers, %", |e| optional(Some(e.driver_share), 100.0, 1)),
        ("REML criterion", |e| optional(Some(e.reml_criterion), 1.0, 2)),
    ];
    for (name, value) in rows {
        let (a, b) = (value(intercept), value(slope));
        let _ = writeln!(text, "{name:NAME$}{a:>VALUE$}{b:>VALUE$}");
    }
    text
}

fn drivers(fit: &CurveSpeedFit) -> String {
    let shown = fit.by_driver.iter().take(MOST_DRIVERS);
    let width =
        shown.clone().map(|driver| driver.driver.chars().count()).max().unwrap_or(0).clamp(8, 24);
    let mut text = format!(
        "\nEach driver alone\n{:width$}{:>9}{:>25}{:>10}{:>8}\n",
        "", "curves", "exponent", "v0, km/h", "R2"
    );
    for driver in shown {
        let _ = writeln!(text, "{}", driver_row(driver, width));
    }
    if fit.by_driver.len() > MOST_DRIVERS {
        let _ =
            writeln!(text, "... and {} more: --json has all", fit.by_driver.len() - MOST_DRIVERS);
    }
    if let Some(spread) = &fit.between_drivers {
        let _ = writeln!(
            text,
            "{} drivers: exponent {:.4}, SD {:.4}; v0 {:.1} km/h, SD of ln v0 {:.1} %; correlation {:.2}",
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

fn driver_row(driver: &DriverFit, width: usize) -> String {
    let name: String = driver.driver.chars().take(width).collect();
    let exponent = match (driver.exponent, driver.exponent_ci95) {
        (Some(exponent), Some(ci)) => with_interval(exponent, ci, 1.0, 3),
        _ => "-".to_owned(),
    };
    format!(
        "{name:width$}{:>9}{exponent:>25}{:>10}{:>8}",
        grouped(driver.n as u64),
        optional(driver.reference_speed_mps, 3.6, 1),
        optional(driver.r_squared, 1.0, 3)
    )
}
