//! How studies differ under common random numbers, the first one as the baseline.

mod files;

use crate::answer::Answer;
use crate::cost::{difference as cost_difference, sides_text};
use crate::doubt::{JudgedDifference, cycles_of_difference, of_difference};
use crate::error::Error;
use crate::study_difference::beside_comparison;
use crate::text::{decimals_for, effects, fact, took};
use crate::watch::{Watch, watched};
use files::{KeptRun, kept_runs};
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_fleet::comparison::{
    AdjustedDifference, Compared, Comparison, compare as compare_fleets, compare_driven, cycles_of,
};
use ocmc_fleet::cost_difference::CostDifference;
use ocmc_fleet::quantity::{NamedQuantity, WHEEL, numeric_columns, quantity, quantity_of_column};
use ocmc_fleet::run::RunPlan;
use ocmc_io::label::label;
use ocmc_io::number_text::{count_of, grouped, percent, rough, rounded};
use ocmc_io::study::{KeyDifference, differences};
use ocmc_io::study::{LoadedStudy, nearest, study_hash};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Serialize, Serializer};
use std::borrow::Cow;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::time::Instant;

/// The studies, and what is compared.
#[derive(Clone, Debug)]
pub struct CompareRequest<'a> {
    /// The studies and how the answer calls them, the baseline first; two at least.
    pub studies: Vec<(String, &'a LoadedStudy)>,
    /// The cycles that each of them drives.
    pub plan: RunPlan,
    /// Name of the quantity, or of another column of the records that is a number; the first
    /// consumption that all have where there is none.
    pub column: Option<String>,
    /// Whether the answer keeps the records of the studies, for [`CompareAnswer::save`].
    pub keep: bool,
}

/// The differences.
#[derive(Clone, Debug)]
pub struct CompareAnswer {
    /// One for each study but the baseline.
    pub comparisons: Vec<ComparedStudies>,
    /// Studies that are compared by the work at the wheels, although it was not asked for, because
    /// they burn no fuel.
    pub(crate) without_fuel: Vec<String>,
    pub(crate) plan: RunPlan,
    pub(crate) driven: u64,
    pub(crate) wall_s: f64,
    /// Run of each study, where it was to be kept.
    pub(crate) kept: Vec<KeptRun>,
}

/// How a study B differs from the baseline A.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ComparedStudies {
    /// Name of A.
    pub study_a: String,
    /// Hash of the resolved study A.
    pub study_hash_a: String,
    /// Name of B.
    pub study_b: String,
    /// Hash of the resolved study B.
    pub study_hash_b: String,
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// The difference.
    #[serde(flatten)]
    pub comparison: Comparison,
    /// Effect of judged numbers on the difference; none where no number is judged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub judged: Option<JudgedDifference>,
    /// The keys in which they differ, what differs most first.
    pub differing_keys: Vec<KeyDifference>,
    /// Difference in cost; none where they have not both prices in one currency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cost: Option<Box<CostDifference>>,
}

/// Drives the same cycles in all studies and compares them with the first one.
///
/// ```
/// use ocmc_api::{CompareRequest, RunPlan, compare, go_on, study};
/// let empty = study::load("field-truck", &["mission.length_m=5000"])?;
/// let loaded = empty.set(&["mission.payload_kg=20000"])?;
/// let request = CompareRequest {
///     studies: vec![("empty".to_owned(), &empty), ("loaded".to_owned(), &loaded)],
///     plan: RunPlan::new(1, 0, 20, None, None),
///     column: Some("consumption_l_per_100km".to_owned()),
///     keep: false,
/// };
/// let answer = compare(&request, &mut go_on)?;
/// assert!(answer.comparisons[0].comparison.difference > Some(0.0));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::NoColumn`] and [`Error::Interrupted`]; [`Error::NothingToCompare`] where there are not
/// two studies.
pub fn compare(request: &CompareRequest, watch: &mut Watch) -> Result<CompareAnswer, Error> {
    compare_known(request, None, watch)
}

/// As [`compare`], where the records of the studies may be known.
pub(crate) fn compare_known(
    request: &CompareRequest,
    known: Option<Vec<Vec<Record>>>,
    watch: &mut Watch,
) -> Result<CompareAnswer, Error> {
    let CompareRequest { studies, plan, column, keep } = request;
    let [(name_a, a), others @ ..] = studies.as_slice() else {
        return Err(Error::NothingToCompare);
    };
    if others.is_empty() {
        return Err(Error::NothingToCompare);
    }
    let all: Vec<&Study> = studies.iter().map(|(_, loaded)| &loaded.study).collect();
    let named = |name| column_named(name, all.iter().copied());
    let quantity = column.as_deref().map(named).transpose()?;
    let clock = Instant::now();
    let pairs: Vec<[&LoadedStudy; 2]> = others.iter().map(|(_, b)| [*a, *b]).collect();
    let of_pairs: u64 = pairs.iter().map(|pair| cycles_of_difference(pair, plan).1).sum();
    let cycles = cycles_of(&all, plan) + of_pairs;
    let (Compared { comparisons: compared, fleets }, judged) = watched(cycles, watch, |look| {
        let (quantity, all) = (quantity.as_ref(), all.as_slice());
        let comparisons = match known {
            Some(driven) => compare_driven(all, plan, quantity, driven, &mut *look)?,
            None => compare_fleets(all, plan, quantity, &mut *look)?,
        };
        let judged = judged(&comparisons, quantity, &pairs, plan, look)?;
        ControlFlow::Continue((comparisons, judged))
    })?;
    let wall_s = clock.elapsed().as_secs_f64();
    let by_wheels = compared.iter().all(|comparison| comparison.column == WHEEL);
    let without_fuel = studies.iter().filter(|(_, study)| {
        let carriers = study.model.vehicle.powertrain.carriers().iter();
        let fills = carriers.map(|carrier| carrier.declaration().filled).any(|keys| keys.is_some());
        column.is_none() && by_wheels && !fills
    });
    let without_fuel = without_fuel.map(|(name, _)| name.clone()).collect();
    let comparisons =
        compared.into_iter().zip(others).zip(judged).enumerate().map(|(k, (compared, judged))| {
            let (comparison, (name, b)) = compared;
            let sides = [(*a, fleets[0].as_slice()), (*b, fleets[k + 1].as_slice())];
            ComparedStudies {
                study_a: name_a.clone(),
                study_hash_a: study_hash(&a.model),
                study_b: name.clone(),
                study_hash_b: study_hash(&b.model),
                seed: plan.seed,
                first_cycle: plan.first_cycle,
                comparison,
                judged,
                differing_keys: differences(&a.model, &b.model),
                cost: cost_difference(sides, plan).map(Box::new),
            }
        });
    let comparisons = comparisons.collect();
    let kept = if *keep { kept_runs(studies, plan, fleets, wall_s, cycles) } else { Vec::new() };
    Ok(CompareAnswer { comparisons, without_fuel, plan: *plan, driven: cycles, wall_s, kept })
}

/// The effect of judged numbers on each difference.
fn judged(
    Compared { comparisons, fleets }: &Compared,
    asked: Option<&NamedQuantity>,
    pairs: &[[&LoadedStudy; 2]],
    plan: &RunPlan,
    look: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> ControlFlow<(), Vec<Option<JudgedDifference>>> {
    let all: Vec<&Study> = pairs.iter().map(|[_, b]| &b.study).collect();
    let mut driven = plan.cycles * (all.len() as u64 + 1);
    let mut effects = Vec::with_capacity(pairs.len());
    for (k, (pair, comparison)) in pairs.iter().zip(comparisons).enumerate() {
        let fleets = [&*fleets[0], &*fleets[k + 1]];
        let known =
            asked.or_else(|| quantity(&comparison.column).map(|known| known as &NamedQuantity));
        let Some(known) = known else {
            effects.push(None);
            continue;
        };
        let mut on = |cycles| look(driven + cycles);
        effects.push(of_difference(known, pair, &fleets, plan, &mut on)?);
        driven += cycles_of_difference(pair, plan).1;
    }
    ControlFlow::Continue(effects)
}

/// The quantity of a column that one of the studies has at least.
pub(crate) fn column_named<'a, 'b>(
    name: &'a str,
    studies: impl Iterator<Item = &'b Study> + Clone,
) -> Result<NamedQuantity<'a>, Error> {
    let parts = studies.filter_map(Study::breakdown);
    let parts = parts.flat_map(|columns| columns.names()).map(String::as_str);
    quantity_of_column(name, parts.clone()).ok_or_else(|| {
        let mut known: Vec<&str> = numeric_columns().collect();
        known.extend(parts);
        let nearest = nearest(name, &known).map(str::to_owned);
        Error::NoColumn { name: name.to_owned(), nearest }
    })
}

/// As it is serialised.
impl JsonSchema for CompareAnswer {
    fn schema_name() -> Cow<'static, str> {
        "CompareAnswer".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let one = generator.subschema_for::<ComparedStudies>();
        let several = generator.subschema_for::<Vec<ComparedStudies>>();
        json_schema!({
            "description": "Of two studies one comparison, of more a list",
            "anyOf": [one, several]
        })
    }
}

/// Two studies are one comparison, more are a list.
impl Serialize for CompareAnswer {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.comparisons.as_slice() {
            [one] => one.serialize(serializer),
            several => several.serialize(serializer),
        }
    }
}

impl Answer for CompareAnswer {
    fn text(&self) -> String {
        let Self { comparisons, plan, .. } = self;
        let mut text = fact("A", &comparisons[0].study_a);
        if let [only] = comparisons.as_slice() {
            text.push_str(&fact("B", only.study_b.replace(" with ", "\n  with ")));
        }
        text.push_str(&fact("seed", plan.seed));
        let (first, last) = (plan.first_cycle, plan.first_cycle + (plan.cycles - 1));
        let cycles = format!("{} in each study, ids {first} to {last}", grouped(plan.cycles));
        text.push_str(&fact("cycles", cycles));
        text.push_str(&took(self.wall_s, plan.threads, self.driven));
        text.push_str(&no_common_consumption(&self.without_fuel));
        for compared in comparisons {
            text.push('\n');
            if comparisons.len() > 1 {
                text.push_str(&fact("B", &compared.study_b));
            }
            let names = [compared.study_a.as_str(), compared.study_b.as_str()];
            text.push_str(&comparison_text(&compared.comparison, names));
            text.push_str(&judged_text(compared));
            if let Some(cost) = &compared.cost {
                text.push_str("\nCost, item by item with break-even: ocmc cost --against\n");
                text.push_str(&sides_text(cost));
            }
            text.push_str(&beside_comparison(&compared.differing_keys));
        }
        text
    }
}

/// Why studies are compared by the work at the wheels, where some burn no fuel.
fn no_common_consumption(without_fuel: &[String]) -> String {
    let burn = match without_fuel.len() {
        0 => return String::new(),
        1 => "burns",
        _ => "burn",
    };
    let names = without_fuel.join(", ");
    fact("note", format!("{names} {burn} no fuel: compared by work at the wheels"))
}

/// One comparison in words and numbers.
fn comparison_text(comparison: &Comparison, names: [&str; 2]) -> String {
    let (label, factor) = label(&comparison.column);
    let kind = if quantity(&comparison.column).is_some() { "fleet" } else { "cycles" };
    let mut text = format!("{label}, mean of the {kind}\n");
    let mut line = |name: &str, value: &str| {
        let _ = writeln!(text, "  {name:<18} {value}");
    };
    if let Comparison { a: Some(a), b: Some(b), difference: Some(change), .. } = *comparison {
        difference_lines(comparison, [a, b, change], factor, &mut line);
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

/// Results of the pairs, line by line.
fn difference_lines(
    comparison: &Comparison,
    [a, b, difference]: [f64; 3],
    factor: f64,
    line: &mut impl FnMut(&str, &str),
) {
    line("A", &rounded(factor * a));
    line("B", &rounded(factor * b));
    let digits = decimals_of(comparison, factor);
    let half = |[low, high]: [f64; 2]| format!("{:.digits$}", factor * (high - low) / 2.0);
    let interval = comparison.ci95.map_or("-".to_owned(), half);
    let change = factor * difference;
    let share = 100.0 * difference / a;
    let share = if a == 0.0 { String::new() } else { format!(" ({share:+.2} %)") };
    line("B - A", &format!("{change:+.digits$} ± {interval}{share}"));
    if let Some(AdjustedDifference { difference, ci95 }) = comparison.adjusted {
        let text = format!("{:+.digits$} ± {}", factor * difference, half(ci95));
        line("adjusted", &format!("{text}, for what was drawn"));
    }
    if let Some(uncertain) = &comparison.parameter_uncertainty {
        let wide = half(uncertain.ci95);
        line("with parameters", &format!("± {wide}, with the errors of the uncertain numbers"));
        for effect in effects(uncertain, factor) {
            line("", &effect);
        }
    }
    let pairs = count_of(comparison.pairs - comparison.pairs_without_value, "pair");
    if let (Some(lower), Some(equal)) = (comparison.share_a_lower, comparison.share_equal) {
        let higher = 1.0 - lower - equal;
        let [lower, equal, higher] = [lower, equal, higher].map(percent);
        line("A lower", &format!("in {lower} % of {pairs}"));
        line("B lower", &format!("in {higher} %, the same in {equal} %"));
    }
    if let Some(reduction) = comparison.variance_reduction {
        let (part, like) = (rough(reduction), rough(reduction * comparison.pairs as f64));
        line("variance", &format!("1/{part} of two independent runs', like {like} cycles each"));
    }
    if comparison.pairs_without_value > 0 {
        let pairs = count_of(comparison.pairs_without_value, "pair");
        line("no value", &format!("{pairs}, counted in the means alone"));
    }
}

/// The effect of judged numbers on the difference.
fn judged_text(compared: &ComparedStudies) -> String {
    let (Some(judged), Some(_)) = (&compared.judged, compared.comparison.difference) else {
        return String::new();
    };
    let (_, factor) = label(&compared.comparison.column);
    let Some(plus_minus) = judged.plus_minus else {
        return "  judged             unknown: ocmc doubt --against finds it\n".to_owned();
    };
    let digits = decimals_of(&compared.comparison, factor);
    format!(
        "  judged             ± {:.digits$} from the {} that matter most: see ocmc doubt\n",
        factor * plus_minus,
        judged.moved.len()
    )
}

/// Decimals that show the narrowest interval with two digits.
fn decimals_of(comparison: &Comparison, factor: f64) -> usize {
    let narrowest = comparison.adjusted.map(|adjusted| adjusted.ci95).or(comparison.ci95);
    let half_width = narrowest.map_or(0.0, |[low, high]| factor * (high - low) / 2.0);
    decimals_for(half_width)
}
