//! Comparisons of studies as text: the means, the paired difference with its interval, and what was
//! left out.

use super::CompareAnswer;
use crate::cost::took;
use ocmc_core::fleet::comparison::Comparison;
use ocmc_io::label::label;
use ocmc_io::number_text::{count_of, grouped, percent, rough, rounded};
use std::fmt::Write;

/// The whole answer.
pub(crate) fn answer(answer: &CompareAnswer) -> String {
    let CompareAnswer { comparisons, plan, .. } = answer;
    let mut text = format!("{:<10} {}\n", "A", comparisons[0].study_a);
    if let [only] = comparisons.as_slice() {
        let _ = writeln!(text, "{:<10} {}", "B", only.study_b.replace(" with ", "\n  with "));
    }
    let _ = writeln!(text, "{:<10} {}", "seed", plan.seed);
    let (first, last) = (plan.first_cycle, plan.first_cycle + (plan.cycles - 1));
    let cycles = grouped(plan.cycles);
    let _ = writeln!(text, "{:<10} {cycles} in each study, ids {first} to {last}", "cycles");
    let driven = plan.cycles * (comparisons.len() as u64 + 1);
    text.push_str(&took(answer.wall_s, plan.threads, driven));
    text.push_str(&no_common_consumption(&answer.without_fuel));
    for compared in comparisons {
        text.push('\n');
        if comparisons.len() > 1 {
            let _ = writeln!(text, "{:<10} {}", "B", compared.study_b);
        }
        let names = [compared.study_a.as_str(), compared.study_b.as_str()];
        text.push_str(&comparison_text(&compared.comparison, names));
    }
    text
}

/// Why studies are compared by the work at the wheels, where some burn no fuel.
fn no_common_consumption(without_fuel: &[String]) -> String {
    let burn = match without_fuel.len() {
        0 => return String::new(),
        1 => "burns",
        _ => "burn",
    };
    let names = without_fuel.join(", ");
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
