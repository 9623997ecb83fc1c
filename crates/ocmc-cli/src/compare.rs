//! `ocmc compare`: studies under common random numbers, the first one as the baseline.

use crate::analysis::Analysis;
use crate::answer::Answer;
use crate::arguments::CompareArguments;
use crate::failure::Failure;
use crate::number_text::{count_of, grouped, percent, rough, rounded};
use crate::{output, request};
use ocmc_core::fleet::comparison::{Comparison, compare as compare_studies};
use ocmc_core::fleet::quantity::WHEEL;
use ocmc_core::fleet::run::RunPlan;
use ocmc_core::study::{Study, StudyModel};
use ocmc_io::label::label;
use ocmc_io::study::{self, LoadedStudy, study_hash};
use serde::Serialize;
use std::fmt::Write;

/// A study, and how it is called in the answer.
struct Candidate {
    name: String,
    loaded: LoadedStudy,
}

/// One comparison, as `--json` prints it.
#[derive(Serialize)]
struct Content<'a> {
    study_a: &'a str,
    study_hash_a: String,
    study_b: &'a str,
    study_hash_b: String,
    seed: u64,
    first_cycle: u64,
    #[serde(flatten)]
    comparison: &'a Comparison,
}

/// Compares the studies and prints the differences.
pub(crate) fn compare(arguments: &CompareArguments) -> Result<(), Failure> {
    let candidates = candidates(arguments)?;
    let (plan, quantity) = request::analysis(&arguments.analysis)?;
    let studies: Vec<&Study> = candidates.iter().map(|c| &c.loaded.study).collect();
    let analysis = Analysis::begin(plan.cycles * studies.len() as u64, &arguments.analysis);
    let compared = compare_studies(&studies, &plan, quantity, |cycles| analysis.reach(cycles));
    let (comparisons, wall_s) = analysis.end(compared)?;

    let named: Vec<(&str, &StudyModel)> =
        candidates.iter().map(|c| (c.name.as_str(), &c.loaded.model)).collect();
    let answer = comparison_answer(&named, &plan, &comparisons, quantity.is_some(), wall_s);
    if arguments.analysis.json {
        return output::answer_json(&answer.json);
    }
    output::answer(&answer.text)
}

/// What comparisons with the first of these studies tell; two studies are one comparison, more are a list in the JSON.
/// `asked` says whether somebody named the quantity.
pub fn comparison_answer(
    studies: &[(&str, &StudyModel)],
    plan: &RunPlan,
    comparisons: &[Comparison],
    asked: bool,
    wall_s: f64,
) -> Answer {
    let [(name_a, model_a), others @ ..] = studies else {
        return Answer::default();
    };
    let contents: Vec<Content> = comparisons
        .iter()
        .zip(others)
        .map(|(comparison, (name, model))| Content {
            study_a: name_a,
            study_hash_a: study_hash(model_a),
            study_b: name,
            study_hash_b: study_hash(model),
            seed: plan.seed,
            first_cycle: plan.first_cycle,
            comparison,
        })
        .collect();
    let json = match contents.as_slice() {
        [content] => serde_json::to_value(content),
        several => serde_json::to_value(several),
    };
    let mut text = format!("{:<10} {name_a}\n", "A");
    if let [(other, _)] = others {
        let _ = writeln!(text, "{:<10} {}", "B", other.replace(" with ", "\n  with "));
    }
    let _ = writeln!(text, "{:<10} {}", "seed", plan.seed);
    let (first, last) = (plan.first_cycle, plan.first_cycle + (plan.cycles - 1));
    let cycles = grouped(plan.cycles);
    let _ = writeln!(text, "{:<10} {cycles} in each study, ids {first} to {last}", "cycles");
    text.push_str(&Analysis::took(wall_s, plan.threads, plan.cycles * studies.len() as u64));
    if !asked && comparisons.iter().all(|comparison| comparison.column == WHEEL) {
        text.push_str(&no_common_consumption(studies));
    }
    for (comparison, (name, _)) in comparisons.iter().zip(others) {
        text.push('\n');
        if comparisons.len() > 1 {
            let _ = writeln!(text, "{:<10} {name}", "B");
        }
        text.push_str(&comparison_text(comparison, [name_a, name]));
    }
    Answer { json: json.expect("numbers and words"), text, warnings: Vec::new() }
}

/// The studies that were named; of a single one, the study as it is and with the settings.
fn candidates(arguments: &CompareArguments) -> Result<Vec<Candidate>, Failure> {
    let none: &[String] = &[];
    let load = |name: &String, sets: &[String]| -> Result<Candidate, Failure> {
        let loaded = study::load(name, sets)?;
        Ok(Candidate { name: loaded.origin.to_string(), loaded })
    };
    if let [only] = arguments.studies.as_slice() {
        if arguments.set.is_empty() {
            return Err(request::usage(
                "a study is compared with another one, or with itself under --set: give a second \
                 study, or --set KEY=VALUE",
            ));
        }
        let (a, mut b) = (load(only, none)?, load(only, &arguments.set)?);
        b.name = format!("{} with {}", b.name, arguments.set.join(" with "));
        return Ok(vec![a, b]);
    }
    arguments.studies.iter().map(|name| load(name, &arguments.set)).collect()
}

/// Why studies are compared by the work at the wheels, where some burn no fuel.
fn no_common_consumption(studies: &[(&str, &StudyModel)]) -> String {
    let electric = studies.iter().filter(|(_, model)| model.vehicle.electric.is_some());
    let electric: Vec<&str> = electric.map(|(name, _)| *name).collect();
    let burn = match electric.len() {
        0 => return String::new(),
        1 => "burns",
        _ => "burn",
    };
    let names = electric.join(", ");
    format!("{:<10} {names} {burn} no fuel: compared by work at the wheels\n", "note")
}

/// One comparison in words and numbers.
fn comparison_text(comparison: &Comparison, names: [&str; 2]) -> String {
    let (label, factor) = label(comparison.column);
    let mut text = format!("{label}, mean of the fleet\n");
    let mut line = |name: &str, value: &str| {
        let _ = writeln!(text, "  {name:<18} {value}");
    };
    if comparison.difference.is_some() {
        difference_lines(comparison, factor, &mut line);
    } else {
        let without = [
            (names[0], comparison.a_without_quantity, comparison.a_failed),
            (names[1], comparison.b_without_quantity, comparison.b_failed),
        ];
        let all = |(_, without, failed): &&(&str, u64, u64)| {
            *without > 0 && without + failed == comparison.cycles
        };
        let named: Vec<&str> = without.iter().filter(all).map(|(name, ..)| *name).collect();
        match named.as_slice() {
            [] => line("no pairs", "no cycle has it in both studies"),
            [name] => line("no pairs", &format!("{name} has no {}", comparison.column)),
            _ => line("no pairs", &format!("neither study has {}", comparison.column)),
        }
    }
    for (name, failed) in [("A", comparison.a_failed), ("B", comparison.b_failed)] {
        if failed > 0 {
            line("not completed", &format!("{} of {name}, left out", count_of(failed, "cycle")));
        }
    }
    text
}

/// What the pairs tell, line by line.
fn difference_lines(comparison: &Comparison, factor: f64, line: &mut impl FnMut(&str, &str)) {
    let (Some(a), Some(b), Some(difference)) = (comparison.a, comparison.b, comparison.difference)
    else {
        return;
    };
    line("A", &rounded(factor * a));
    line("B", &rounded(factor * b));
    let digits = decimals_of(comparison, factor);
    let half = |[low, high]: [f64; 2]| format!("{:.digits$}", factor * (high - low) / 2.0);
    let interval = comparison.ci95.map_or("-".to_owned(), half);
    line(
        "B - A",
        &format!(
            "{:+.digits$} ± {interval} ({:+.2} %)",
            factor * difference,
            100.0 * difference / a
        ),
    );
    if let Some(uncertain) = comparison.parameter_uncertainty {
        let (wide, draws) = (half(uncertain.ci95), grouped(uncertain.replicates));
        line("with parameters", &format!("± {wide}, over {draws} draws of the curve-speed fit"));
    }
    let pairs = count_of(comparison.pairs - comparison.pairs_without_value, "pair");
    if let (Some(lower), Some(equal)) = (comparison.share_a_lower, comparison.share_equal) {
        let higher = 1.0 - lower - equal;
        let [lower, equal, higher] = [lower, equal, higher].map(percent);
        line("A lower", &format!("in {lower} % of {pairs}"));
        line("B lower", &format!("in {higher} %, the same in {equal} %"));
    }
    if let Some(reduction) = comparison.variance_reduction {
        let like = rough(reduction * comparison.pairs as f64);
        line(
            "variance",
            &format!("1/{} of two independent runs', like {like} cycles each", rough(reduction)),
        );
    }
    if comparison.pairs_without_value > 0 {
        let pairs = count_of(comparison.pairs_without_value, "pair");
        line("no value", &format!("{pairs}, counted in the means alone"));
    }
}

/// Decimals that show the interval with two digits.
fn decimals_of(comparison: &Comparison, factor: f64) -> usize {
    let half_width = comparison.ci95.map_or(0.0, |[low, high]| factor * (high - low) / 2.0);
    if half_width > 0.0 { (1.0 - half_width.log10().floor()).clamp(0.0, 6.0) as usize } else { 3 }
}
