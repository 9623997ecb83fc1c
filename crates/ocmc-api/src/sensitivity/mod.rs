//! Factors that cause the spread between cycles.

mod files;

use crate::answer::Answer;
use crate::error::Error;
use crate::run::whole_trucks;
use crate::text::{fact, took};
use crate::watch::{Watch, watched};
use files::KeptDesign;
use ocmc_core::random::sampling::Sampling;
use ocmc_fleet::quantity::{RecordQuantity, quantity};
use ocmc_fleet::random_effects::{TwoWay, two_way};
use ocmc_fleet::run::RunPlan;
use ocmc_fleet::sensitivity::{
    FactorGroup, FactorShare, Sensitivity, factor_groups, sensitivity as shares_of,
};
use ocmc_fleet::shapley::{ShapleyEffects, cycles_of_row, shapley};
use ocmc_fleet::variance_share::LEAST_GROUPS;
use ocmc_io::label::label;
use ocmc_io::number_text::{grouped, percent, rounded, share_text};
use ocmc_io::study::{LoadedStudy, Origin, resolved_toml, study_hash};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;
use std::time::Instant;

pub use ocmc_fleet::sensitivity::{Over, SensitivityError};

/// Drivers of a crossed design.
const DRIVERS: u64 = 30;

/// Output whose variance is analysed, and the factors to which it is shared out.
#[derive(Clone, Debug)]
pub struct SensitivityRequest<'a> {
    /// The study.
    pub study: &'a LoadedStudy,
    /// The rows of the design: each drives two cycles, and one more for each factor.
    pub plan: RunPlan,
    /// Name of the quantity; the consumption where there is none.
    pub column: Option<String>,
    /// Names of the factors; all where there are none.
    pub factors: Option<Vec<String>>,
    /// Unit over which the variance is taken.
    pub over: Over,
    /// A second opinion: so many cycles with each of 30 drivers, and the variance split two ways.
    pub crossed: Option<u64>,
    /// Shares of the six factors that add up to one, too: 64 more cycles a row.
    pub shapley: bool,
}

/// The shares of the variance.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct SensitivityAnswer {
    /// Name of the study.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Where the study comes from.
    #[serde(skip)]
    pub origin: Origin,
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// The shares.
    #[serde(flatten)]
    pub sensitivity: Sensitivity,
    /// The second opinion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub two_way: Option<TwoWay>,
    /// The shares that add up to one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shapley: Option<ShapleyEffects>,
    /// How long the design took, in s.
    pub wall_s: f64,
    /// Threads that it took.
    pub threads: usize,
    /// Output of each cycle of the design, and the study, for [`SensitivityAnswer::save`].
    #[serde(skip)]
    pub(crate) kept: KeptDesign,
}

/// Drives the design and shares the variance out.
///
/// ```
/// use ocmc_api::{Over, RunPlan, SensitivityRequest, go_on, sensitivity, study};
/// let study = study::load("field-truck", &["mission.length_m=5000"])?;
/// let request = SensitivityRequest {
///     study: &study,
///     plan: RunPlan::new(1, 0, 20, None, None),
///     column: None,
///     factors: Some(vec!["road".to_owned(), "driver".to_owned()]),
///     over: Over::Trip,
///     crossed: None,
///     shapley: false,
/// };
/// let answer = sensitivity(&request, &mut go_on)?;
/// assert_eq!(answer.sensitivity.factors[1].factor, "driver");
/// assert_eq!(answer.sensitivity.cycles, 80);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::UnknownColumn`] and [`Error::UnknownFactor`]; [`Error::Sensitivity`] where too few
/// cycles count, or where a crossed design is asked for of cycles that depend on one another;
/// [`Error::Interrupted`].
pub fn sensitivity(
    request: &SensitivityRequest,
    watch: &mut Watch,
) -> Result<SensitivityAnswer, Error> {
    let SensitivityRequest { study, plan, column, factors, over, crossed, shapley: wanted } =
        request;
    let quantity = quantity_named(column.as_deref())?;
    let groups = groups_named(factors.as_deref())?;
    if crossed.is_some() && study.model.simulation.sampling != Sampling::Independent {
        return Err(SensitivityError::NotIndependent.into());
    }
    if *over == Over::Truck {
        whole_trucks(&study.study, plan)?;
    }
    let clock = Instant::now();
    let cycles = plan.cycles.saturating_mul(2 + groups.len() as u64);
    let (shares, design) = watched(cycles, watch, |look| {
        shares_of(&study.study, plan, &groups, quantity, *over, look)
    })??;
    let effects = || {
        let cycles = plan.cycles.saturating_mul(cycles_of_row());
        watched(cycles, watch, |look| shapley(&study.study, plan, quantity, *over, look))?
            .map_err(Error::from)
    };
    let effects = wanted.then(effects).transpose()?;
    let wall_s = clock.elapsed().as_secs_f64();
    let split = |cycles: u64| {
        let (plan, total) = (RunPlan { cycles, ..*plan }, cycles * DRIVERS);
        watched(total, watch, |look| two_way(&study.study, &plan, DRIVERS, quantity, look))?
            .map_err(Error::from)
    };
    Ok(SensitivityAnswer {
        study: study.model.study.name.clone(),
        study_hash: study_hash(&study.model),
        origin: study.origin.clone(),
        seed: plan.seed,
        first_cycle: plan.first_cycle,
        sensitivity: shares,
        two_way: crossed.map(split).transpose()?,
        shapley: effects,
        wall_s,
        threads: plan.threads,
        kept: KeptDesign {
            design,
            resolved: resolved_toml(&study.model),
            plan: *plan,
            factors: factors.clone(),
            crossed: *crossed,
        },
    })
}

impl Answer for SensitivityAnswer {
    fn text(&self) -> String {
        let shares = &self.sensitivity;
        let mut text = heading(self, shares);
        let more = self.shapley.as_ref().map_or(0, |effects| effects.cycles);
        text.push_str(&took(self.wall_s, self.threads, shares.cycles + more));
        text.push('\n');
        text.push_str(&table(shares));
        if let Some(effects) = &self.shapley {
            text.push_str(&shapley_text(effects));
        }
        if let Some(two_way) = &self.two_way {
            text.push_str(&two_way_text(two_way));
        }
        text
    }
}

/// The quantity of that name, where one is named.
pub(crate) fn quantity_named(
    column: Option<&str>,
) -> Result<Option<&'static RecordQuantity>, Error> {
    let known = |name: &str| quantity(name).ok_or_else(|| Error::UnknownColumn(name.to_owned()));
    column.map(known).transpose()
}

/// The groups of these names, in the order of the design; all where none are named.
fn groups_named(names: Option<&[String]>) -> Result<Vec<FactorGroup>, Error> {
    let mut groups = factor_groups();
    if let Some(names) = names {
        if let Some(name) = names.iter().find(|name| groups.iter().all(|g| g.name != **name)) {
            return Err(Error::UnknownFactor(name.clone()));
        }
        groups.retain(|group| names.iter().any(|name| name == group.name));
    }
    Ok(groups)
}

/// Width of the names, and of a share with its interval.
const WIDTHS: (usize, usize) = (17, 21);

/// Width of the bars.
const BAR: usize = 18;

/// The shares that add up to one.
fn shapley_text(effects: &ShapleyEffects) -> String {
    let (name_width, width) = WIDTHS;
    let dropped = match effects.dropped_rows {
        0 => String::new(),
        rows => format!(", {} dropped", grouped(rows)),
    };
    let mut text = format!(
        "\nShapley effects, joint effects shared out, from {} rows of {} cycles{dropped}:\n\n",
        grouped(effects.rows),
        cycles_of_row()
    );
    for share in &effects.factors {
        let cell = share_text(share.share, share.ci95);
        let _ = writeln!(text, "{}", row_of(share.factor, &cell, "", share.share).trim_end());
    }
    let sum: f64 = effects.factors.iter().map(|share| share.share).sum();
    let _ = writeln!(text, "{:name_width$}{:>width$}", "together", percent(sum));
    text
}

fn two_way_text(shares: &TwoWay) -> String {
    let [cycle, driver, both] = [shares.cycle, shares.driver, shares.both].map(percent);
    format!(
        "\nA second opinion, {} cycles by {} drivers, two-way random effects, in %:\n\
         cycle {cycle}, driver {driver}, both together {both}\n",
        grouped(shares.cycles),
        shares.drivers
    )
}

fn heading(answer: &SensitivityAnswer, shares: &Sensitivity) -> String {
    let replicates = shares.replicates.map(|draws| {
        let draws = grouped(draws);
        fact("replicates", format!("{draws}, each with its draw of the uncertain parameters"))
    });
    [
        fact("study", &answer.origin),
        fact("seed", answer.seed),
        fact("rows", format!("{}{}", grouped(shares.rows), dropped(shares))),
        fact("cycles", grouped(shares.cycles)),
        replicates.unwrap_or_default(),
    ]
    .concat()
}

/// How many rows were dropped, and why.
fn dropped(shares: &Sensitivity) -> String {
    match (shares.failed_rows, shares.rows_without_value) {
        (0, 0) => String::new(),
        (failed, 0) => format!(", {} dropped because a cycle was not completed", grouped(failed)),
        (0, without) => format!(", {} dropped because a cycle had no value", grouped(without)),
        (failed, without) => format!(
            ", {} dropped because a cycle was not completed,\n{:<10} {} because one had no value",
            grouped(failed),
            "",
            grouped(without)
        ),
    }
}

fn table(shares: &Sensitivity) -> String {
    let (name_width, width) = WIDTHS;
    let (label, factor) = label(shares.column);
    let known = shares.factors.iter().any(|share| share.total_ci95.is_some());
    let intervals = if known {
        "with 95 % intervals".to_owned()
    } else {
        format!("no intervals below {LEAST_GROUPS} independent groups of rows")
    };
    let mut text = format!(
        "{label}: mean of the {} {}, SD {}.\nShares of the variance in %, {intervals}:\n\n",
        match shares.over {
            Over::Trip => "cycles",
            Over::Truck => "trucks",
        },
        rounded(factor * shares.mean),
        rounded(factor * shares.variance.sqrt())
    );
    let _ = writeln!(text, "{:name_width$}{:>width$}{:>width$}", "", "first-order", "total effect");
    for share in &shares.factors {
        let _ = writeln!(text, "{}", row(share).trim_end());
    }
    text
}

/// A factor with its shares.
fn row(share: &FactorShare) -> String {
    let first = share_text(share.first, share.first_ci95);
    row_of(share.factor, &first, &share_text(share.total, share.total_ci95), share.total)
}

/// A factor, two cells, and a bar.
fn row_of(factor: &str, first: &str, second: &str, bar: f64) -> String {
    let (name_width, width) = WIDTHS;
    // a part stands below its factor
    let name = match factor.split_once('.') {
        Some((_, part)) => format!("  {part}"),
        None => factor.to_owned(),
    };
    let bar = "█".repeat((BAR as f64 * bar.clamp(0.0, 1.0)).round() as usize);
    // a space of its own, whatever the width of the second
    let rest = width - 1;
    format!("{name:name_width$}{first:>width$} {second:>rest$}  {bar}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_intervals_do_not_run_together() {
        let share = FactorShare {
            factor: "road",
            first: 1.083,
            first_ci95: Some([0.771, 1.365]),
            total: 1.061,
            total_ci95: Some([0.838, 1.29]),
        };
        let message = row(&share);
        assert!(message.contains("108.3 (77.1 to 136.5) 106.1 (83.8 to 129.0)  █"), "{message}");
        assert!(message.chars().count() <= 80, "{message}");
        let unsure = row(&FactorShare { first_ci95: None, total_ci95: None, ..share });
        assert!(unsure.contains(" 108.3 ") && !unsure.contains('('), "{unsure}");
    }
}
