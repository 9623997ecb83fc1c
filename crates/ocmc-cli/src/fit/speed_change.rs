//! `ocmc fit speed-change`: log-normal accelerations and decelerations.

use super::{no_fit, write_study};
use crate::answer::Answer;
use crate::arguments::SpeedChangeArguments;
use crate::failure::Failure;
use crate::log::mappings;
use crate::number_text::count_of;
use crate::output;
use ocmc_core::driver::speed_change::SpeedChangeModel;
use ocmc_core::study::StudyModel;
use ocmc_estimation::fit::speed_change::{
    SpeedChangeFit, SpeedChangeLaw, SpeedChangeOptions, SpeedChangeTable, fit,
};
use ocmc_io::study::FittedPart;
use ocmc_io::table::Source;
use ocmc_io::{speed_change_table, study};
use std::fmt::Write;

/// Where the values stand in a study.
const KEYS: [&str; 2] = ["driver", "speed_change"];

/// Fits speed changes and prints their laws.
pub(crate) fn speed_change(arguments: &SpeedChangeArguments) -> Result<(), Failure> {
    let base = study::load(&arguments.fitted.base, &[] as &[&str])?;
    let mappings = mappings(&arguments.map)?;
    let options = SpeedChangeOptions {
        window_s: arguments.window,
        smallest_acceleration_mps2: arguments.smallest_acceleration,
        smallest_deceleration_mps2: arguments.smallest_deceleration,
        ..SpeedChangeOptions::default()
    };
    let mut table = SpeedChangeTable::default();
    for path in &arguments.files {
        for note in speed_change_table::append(&mut table, Source::File(path), &mappings, &options)?
        {
            output::note(&format!("warning: {note}"));
        }
    }
    let sources = &arguments.files;
    let fit = fit(&table, &options).map_err(|error| no_fit(&sources[0], error))?;
    let model = fit.population(&base.model.driver.speed_change, arguments.untruncated);
    let answer = speed_change_answer(&fit, &model, &base.model);
    super::print(&arguments.fitted, &answer)?;
    write_study(&arguments.fitted, "speed-change", sources, &answer)
}

/// What the fit of speed changes tells; `model` is the part of a study that follows from it, `base` the study that it is laid over.
pub fn speed_change_answer(
    fit: &SpeedChangeFit,
    model: &SpeedChangeModel,
    base: &StudyModel,
) -> Answer {
    let part = FittedPart::new(base, &KEYS, model);
    let laws = [("acceleration", &fit.acceleration), ("deceleration", &fit.deceleration)];
    let missing = laws.into_iter().filter(|(_, law)| law.is_none());
    let warning = |name| format!("no {name} was measured: the study keeps the one of its base");
    let mut warnings: Vec<String> = missing.map(|(name, _)| warning(name)).collect();
    if fit.drivers == 1 {
        warnings.push("there is one driver only: nothing is known about how drivers differ".into());
    }
    super::answer(fit, text(fit, &part.text()), &warnings, &part)
}

/// Columns of the printed table: a name, then numbers.
const COLUMNS: usize = 6;

fn text(fit: &SpeedChangeFit, values: &str) -> String {
    let mut text = format!("{}\n", count_of(fit.n as u64, "speed change"));
    text.push_str(&super::curve_speed_text::dropped(&fit.dropped, "speed change"));
    let pooled = [&fit.acceleration, &fit.deceleration].into_iter().flatten();
    let laws: Vec<&SpeedChangeLaw> = fit.by_category.iter().chain(pooled).collect();
    text.push('\n');
    text.push_str(&law_table(&laws));
    text.push_str(
        "p normal: of a log-normal law, by Anderson and Darling. With threshold: median and SD with the\n\
         changes below the threshold in the likelihood.\n",
    );
    let _ = write!(text, "\nTo paste into a study:\n\n{values}");
    text
}

/// A row a law, in columns as wide as what stands in them.
fn law_table(laws: &[&SpeedChangeLaw]) -> String {
    let head = ["", "n", "median, m/s2", "SD of ln", "p normal", "with threshold"];
    let rows: Vec<[String; COLUMNS]> =
        std::iter::once(head.map(str::to_owned)).chain(laws.iter().map(|law| row(law))).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths: [usize; COLUMNS] = std::array::from_fn(|column| width(column).unwrap_or(0));
    let between = std::iter::once(None).chain(laws.iter().map(|law| law.driver_log_sd));
    let mut text = String::new();
    for (row, between) in rows.iter().zip(between) {
        let _ = write!(text, "{:width$}", row[0], width = widths[0]);
        for (cell, width) in row.iter().zip(widths).skip(1) {
            let _ = write!(text, "  {cell:>width$}");
        }
        text.push('\n');
        if let Some(sd) = between {
            let _ = writeln!(
                text,
                "{:width$}  between drivers, SD of ln {sd:.3}",
                "",
                width = widths[0]
            );
        }
    }
    text
}

fn row(law: &SpeedChangeLaw) -> [String; COLUMNS] {
    let interval = |value: f64, ci: Option<[f64; 2]>| match ci {
        Some([low, high]) => format!("{value:.3} ({low:.3} ; {high:.3})"),
        None => format!("{value:.3}"),
    };
    let name = if law.category.is_empty() { "unnamed" } else { &law.category };
    let p = law.anderson_darling_p.map_or("-".to_owned(), |p| format!("{p:.3}"));
    let whole = law
        .untruncated
        .map_or("-".to_owned(), |law| format!("{:.3}, {:.3}", law.median_mps2, law.log_sd));
    let sd = law.log_sd.map_or("-".to_owned(), |sd| {
        let [low, high] = law.log_sd_ci95.unwrap_or([f64::NAN; 2]);
        format!("{sd:.2} ({low:.2} ; {high:.2})")
    });
    let median = interval(law.median_mps2, law.median_ci95);
    [name.to_owned(), law.n.to_string(), median, sd, p, whole]
}
