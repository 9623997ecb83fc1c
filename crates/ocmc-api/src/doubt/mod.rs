//! The effect of judged numbers on an answer: each is driven at both ends of its plausible
//! range, on the same cycles.

mod files;
mod text;

use crate::answer::Answer;
use crate::error::Error;
use crate::run::whole_trucks;
use crate::sensitivity::quantity_named;
use crate::watch::{Watch, watched};
use files::KeptStudies;
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::doubt::{Change, Changes, Moved, Shape, effect, effect_square};
use ocmc_fleet::quantity::{NamedQuantity, shared_consumption};
use ocmc_fleet::run::{RunPlan, records};
use ocmc_io::study::{
    End, JudgedKey, JudgedNumbers, LoadedStudy, ReplacedNumber, resolved_toml, study_hash,
};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::time::Instant;

/// Part of the cycles that every entry drives at each end.
const SCREENED: u64 = 10;
/// Fewest of them.
const FEWEST: u64 = 100;
/// Entries that drive all cycles.
const LARGEST: usize = 12;

/// The study, and what is asked of it.
#[derive(Clone, Debug)]
pub struct DoubtRequest<'a> {
    /// The study, and what it is called.
    pub study: (String, &'a LoadedStudy),
    /// Another one, where it is their difference that is asked about.
    pub against: Option<(String, &'a LoadedStudy)>,
    /// The cycles of the twelve entries that matter most; the others drive a tenth of them.
    pub plan: RunPlan,
    /// Name of the quantity; the first consumption that the studies have where there is none.
    pub column: Option<String>,
}

/// The effect of judged numbers on an answer.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct DoubtAnswer {
    /// Name of the study.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Name of the other one, and the hash of its resolved study.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against: Option<[String; 2]>,
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// Cycles on each side of the entries that matter most.
    pub cycles: u64,
    /// Cycles on each side of the others.
    pub screened_cycles: u64,
    /// Cycles that were driven in all.
    pub driven: u64,
    /// Name of the quantity.
    pub column: &'static str,
    /// Mean of the fleet, standard deviation and 95th percentile over the cycles; their
    /// differences, of two studies.
    #[serde(flatten)]
    pub is: Option<Shape>,
    /// Roots of the sums of squares of the effects.
    pub together: Shape,
    /// The entries, the largest effect on the mean first.
    pub numbers: Vec<DoubtedNumbers>,
    /// Numbers of the study that were judged, and that others have replaced.
    pub replaced: Vec<ReplacedNumber>,
    /// How long it took, in s.
    pub wall_s: f64,
    /// Threads that it took.
    pub threads: usize,
    #[serde(skip)]
    pub(crate) kept: KeptStudies,
}

/// Judged numbers that move together, and their effect.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct DoubtedNumbers {
    /// Name of the entry.
    pub name: String,
    /// Why they lie within their ranges.
    pub reason: String,
    /// Paths of the keys.
    pub keys: Vec<String>,
    /// Where the numbers come from: always `judged`, since what is typed or fitted is not in doubt.
    pub standing: &'static str,
    /// The command whose data would replace them; none where they have to be typed.
    pub replaced_by: Option<&'static str>,
    /// Changes at the first end; none where no cycle counts, or the study cannot be moved there.
    pub low: Option<Changes>,
    /// Changes at the other end.
    pub high: Option<Changes>,
    /// Roots of the mean squares of the changes, less what sampling adds to them.
    pub effect: Shape,
    /// Share of the sum of squares of the effects on the mean; below zero where the changes happen
    /// to be smaller than sampling makes them.
    pub share: f64,
    /// Why the study could not be moved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
    /// Mean squares of the changes, less what sampling adds to them.
    #[serde(skip)]
    pub(crate) squares: Shape,
}

/// The roots of sums of squares.
fn root(squares: impl IntoIterator<Item = Shape>) -> Shape {
    let squares: Vec<Shape> = squares.into_iter().collect();
    let sum = |value_of: fn(&Shape) -> f64| effect(squares.iter().map(value_of));
    Shape { mean: sum(|s| s.mean), sd: sum(|s| s.sd), p95: sum(|s| s.p95) }
}

/// An entry of one study or of both.
struct Entry<'a> {
    of_studies: [Option<&'a JudgedNumbers>; 2],
    /// The records at each end, of each study.
    ends: [Vec<Vec<Record>>; 2],
    studies: [Vec<Study>; 2],
    refused: Option<String>,
    low: Option<Changes>,
    high: Option<Changes>,
}

impl<'a> Entry<'a> {
    fn numbers(&self) -> Option<&'a JudgedNumbers> {
        self.of_studies[0].or(self.of_studies[1])
    }

    fn square(&self, change_of: fn(&Changes) -> Change) -> f64 {
        match (&self.low, &self.high) {
            (Some(low), Some(high)) => effect_square(change_of(low), change_of(high)),
            (Some(one), None) | (None, Some(one)) => effect_square(change_of(one), change_of(one)),
            (None, None) => 0.0,
        }
    }

    fn squares(&self) -> Shape {
        let [mean, sd, p95] =
            [self.square(|c| c.mean), self.square(|c| c.sd), self.square(|c| c.p95)];
        Shape { mean, sd, p95 }
    }

    /// How much more is to be learnt of it: the effect, noise included.
    fn size(&self) -> f64 {
        let by = |changes: &Option<Changes>| changes.as_ref().map_or(0.0, |c| c.mean.by.abs());
        by(&self.low).max(by(&self.high))
    }
}

/// Drives the judged numbers of a study at both ends of their ranges.
///
/// ```
/// use ocmc_api::{Answer, DoubtRequest, RunPlan, doubt, go_on, study};
/// let study = study::load("field-truck", &["mission.length_m=3000"])?;
/// let plan = RunPlan::new(1, 0, 8, None, None);
/// let request =
///     DoubtRequest { study: ("mine".to_owned(), &study), against: None, plan, column: None };
/// let answer = doubt(&request, &mut go_on)?;
/// assert!(answer.numbers.iter().any(|numbers| numbers.name == "payload"));
/// // what is typed is not in doubt
/// assert!(answer.numbers.iter().all(|numbers| numbers.name != "trip_length"));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::UnknownColumn`], [`Error::PartOfTruck`] and [`Error::Interrupted`];
/// [`Error::NothingJudged`] where no number is judged.
pub fn doubt(request: &DoubtRequest, watch: &mut Watch) -> Result<DoubtAnswer, Error> {
    let DoubtRequest { study: (name, study), against, plan, column } = request;
    let quantity = quantity_named(column.as_deref())?;
    let studies: Vec<&LoadedStudy> =
        std::iter::once(*study).chain(against.iter().map(|(_, study)| *study)).collect();
    for loaded in &studies {
        whole_trucks(&loaded.study, plan)?;
    }
    let clock = Instant::now();
    let mut entries = entries(&studies);
    if entries.is_empty() {
        return Err(Error::NothingJudged);
    }
    let screened = screened(&studies, plan);
    let first = RunPlan { cycles: screened, ..*plan };
    let rest = RunPlan {
        first_cycle: plan.first_cycle + screened,
        cycles: plan.cycles - screened,
        ..*plan
    };
    let sides = 2 * studies.len() as u64;
    let total = plan.cycles * studies.len() as u64
        + sides * (screened * entries.len() as u64)
        + sides * rest.cycles * entries.len().min(LARGEST) as u64;
    let (effects, driven) = watched(total, watch, |look| {
        let mut driver = Driver { driven: 0, look };
        let mut before = Vec::with_capacity(studies.len());
        for loaded in &studies {
            before.push(driver.records(&loaded.study, plan)?);
        }
        let fleets: Vec<&[Record]> = before.iter().map(Vec::as_slice).collect();
        let quantity = quantity.unwrap_or_else(|| shared_consumption(&fleets));
        let asked = Asked { quantity, studies: &studies, before: &fleets, seed: plan.seed };
        let column = quantity.column;
        for entry in &mut entries {
            driver.at_ends(entry, &studies, &first)?;
            asked.change(entry);
        }
        entries.sort_by(|a, b| b.size().total_cmp(&a.size()));
        if rest.cycles > 0 {
            for entry in entries.iter_mut().take(LARGEST) {
                driver.at_ends(entry, &studies, &rest)?;
                asked.change(entry);
            }
        }
        let (is, numbers) = asked.found(&entries);
        ControlFlow::Continue(((column, is, numbers), driver.driven))
    })?;
    let (column, is, numbers) = effects;
    let together = root(numbers.iter().map(|entry| entry.squares));
    Ok(DoubtAnswer {
        study: name.clone(),
        study_hash: study_hash(&study.model),
        against: against.as_ref().map(|(name, b)| [name.clone(), study_hash(&b.model)]),
        seed: plan.seed,
        first_cycle: plan.first_cycle,
        cycles: plan.cycles,
        screened_cycles: screened,
        driven,
        column,
        is,
        together,
        numbers,
        replaced: study.replaced().to_vec(),
        wall_s: clock.elapsed().as_secs_f64(),
        threads: plan.threads,
        kept: KeptStudies {
            plan: *plan,
            column: request.column.clone(),
            resolved: studies.iter().map(|loaded| resolved_toml(&loaded.model)).collect(),
        },
    })
}

/// The entries of the studies; one that both have is one.
fn entries<'a>(studies: &[&'a LoadedStudy]) -> Vec<Entry<'a>> {
    let entry = |of_studies| {
        let (ends, studies) = ([vec![], vec![]], [vec![], vec![]]);
        Entry { of_studies, ends, studies, refused: None, low: None, high: None }
    };
    let of_first = studies[0].judged().iter();
    let mut entries: Vec<Entry> = of_first.map(|numbers| entry([Some(numbers), None])).collect();
    for numbers in studies.get(1).into_iter().flat_map(|study| study.judged()) {
        let same = |own: &&mut Entry| {
            own.of_studies[0].is_some_and(|own| {
                let has = |key: &JudgedKey| own.keys.iter().any(|other| other.path == key.path);
                own.name == numbers.name && numbers.keys.iter().any(has)
            })
        };
        match entries.iter_mut().find(same) {
            Some(own) => own.of_studies[1] = Some(numbers),
            None => entries.push(entry([None, Some(numbers)])),
        }
    }
    entries
}

/// Cycles on each side of every entry: whole trucks and batches of all studies.
fn screened(studies: &[&LoadedStudy], plan: &RunPlan) -> u64 {
    let batch = |loaded: &&LoadedStudy| Dependence::of(&loaded.model, plan.seed).batch;
    let batch = studies.iter().map(batch).max().unwrap_or(1);
    let wanted = (plan.cycles / SCREENED).max(FEWEST).next_multiple_of(batch);
    wanted.min(plan.cycles)
}

/// Drives, and counts what it has driven.
struct Driver<'a> {
    driven: u64,
    look: &'a mut dyn FnMut(u64) -> ControlFlow<()>,
}

impl Driver<'_> {
    fn records(&mut self, study: &Study, plan: &RunPlan) -> ControlFlow<(), Vec<Record>> {
        let driven = records(study, plan, |cycles| (self.look)(self.driven + cycles))?;
        self.driven += plan.cycles;
        ControlFlow::Continue(driven)
    }

    /// More records of an entry at both ends, in the studies that it is one of; the others drive as
    /// they do without it.
    fn at_ends(
        &mut self,
        entry: &mut Entry,
        studies: &[&LoadedStudy],
        plan: &RunPlan,
    ) -> ControlFlow<()> {
        for (k, end) in [End::Low, End::High].into_iter().enumerate() {
            if entry.studies[k].is_empty() {
                let moved = studies.iter().zip(entry.of_studies).map(|(study, of)| match of {
                    Some(numbers) => study.at_end(numbers, end).map(|moved| moved.study),
                    None => Ok(study.study.clone()),
                });
                match moved.collect::<Result<Vec<Study>, _>>() {
                    Ok(moved) => entry.studies[k] = moved,
                    Err(error) => {
                        entry.refused = Some(error.to_string());
                        continue;
                    }
                }
                entry.ends[k] = vec![Vec::new(); studies.len()];
            }
            for (study, records) in entry.studies[k].iter().zip(&mut entry.ends[k]) {
                records.extend(self.records(study, plan)?);
            }
        }
        ControlFlow::Continue(())
    }
}

/// The question that the records answer.
struct Asked<'a> {
    quantity: &'a NamedQuantity<'a>,
    studies: &'a [&'a LoadedStudy],
    before: &'a [&'a [Record]],
    seed: u64,
}

impl Asked<'_> {
    fn dependence(&self) -> Dependence {
        let dependence_of = |study: &&LoadedStudy| Dependence::of(&study.model, self.seed);
        let all = self.studies.iter().map(dependence_of);
        all.reduce(Dependence::of_pairs).unwrap_or_default()
    }

    /// Weight of each study.
    fn sign(&self, study: usize) -> f64 {
        if study + 1 == self.before.len() { 1.0 } else { -1.0 }
    }

    /// Reckons the changes of an entry from its records.
    fn change(&self, entry: &mut Entry) {
        let changes = |ends: &[Vec<Record>]| {
            let fleets =
                ends.iter().zip(self.before).enumerate().map(|(study, (after, before))| {
                    let before = &before[..after.len()];
                    Moved { sign: self.sign(study), before, after }
                });
            Changes::of(self.quantity, self.dependence(), &fleets.collect::<Vec<_>>())
        };
        (entry.low, entry.high) = (changes(&entry.ends[0]), changes(&entry.ends[1]));
    }

    /// The shape of the fleet, and the entries, the largest effect first.
    fn found(&self, entries: &[Entry]) -> (Option<Shape>, Vec<DoubtedNumbers>) {
        let shapes = self.before.iter().enumerate().map(|(study, records)| {
            let shape = Shape::of(self.quantity, records)?;
            Some(shape.times(self.sign(study)))
        });
        let shapes: Option<Vec<Shape>> = shapes.collect();
        let shape = shapes.and_then(|shapes| shapes.into_iter().reduce(Shape::plus));
        let all: f64 = entries.iter().map(|entry| entry.squares().mean).sum();
        let numbers = entries.iter().filter_map(|entry| {
            let numbers = entry.numbers()?;
            let squares = entry.squares();
            Some(DoubtedNumbers {
                name: numbers.name.clone(),
                reason: numbers.reason.clone(),
                keys: numbers.keys.iter().map(|key| key.path.clone()).collect(),
                standing: "judged",
                replaced_by: numbers.replaced_by(),
                low: entry.low,
                high: entry.high,
                effect: root([squares]),
                share: if all > 0.0 { squares.mean / all } else { 0.0 },
                refused: entry.refused.clone(),
                squares,
            })
        });
        let mut numbers: Vec<DoubtedNumbers> = numbers.collect();
        numbers.sort_by(|a, b| b.squares.mean.total_cmp(&a.squares.mean));
        (shape, numbers)
    }
}

/// The effect on a difference of the judged numbers that matter most in either study.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct JudgedDifference {
    /// Root of the sum of squares of their effects on the difference: no confidence interval. None
    /// where it is not known which numbers matter most, and from few cycles.
    pub plus_minus: Option<f64>,
    /// The entries that were moved.
    pub moved: Vec<String>,
    /// Cycles at each end.
    pub cycles: u64,
}

/// Part of the cycles of a comparison that these entries drive at each end.
const OF_COMPARISON: u64 = 20;
/// Most of them, and fewest that tell anything.
const MOST_OF_COMPARISON: u64 = 100;
const FEWEST_OF_COMPARISON: u64 = 10;

/// The entries of two studies that matter most, as far as it is stored.
fn largest<'a>(studies: &[&'a LoadedStudy]) -> Option<Vec<Entry<'a>>> {
    let mut names = BTreeSet::new();
    for study in studies {
        if let Some(doubt) = study.judged_doubt() {
            names.extend(doubt.stored?.largest.into_iter().map(|numbers| numbers.name));
        }
    }
    let mut entries = entries(studies);
    entries.retain(|entry| entry.numbers().is_some_and(|numbers| names.contains(&numbers.name)));
    Some(entries)
}

/// Cycles that [`of_difference`] drives at each end, and those that it drives in all.
pub(crate) fn cycles_of_difference(studies: &[&LoadedStudy], plan: &RunPlan) -> (u64, u64) {
    let batch = |loaded: &&LoadedStudy| Dependence::of(&loaded.model, plan.seed).batch;
    let batch = studies.iter().map(batch).max().unwrap_or(1);
    let wanted = (plan.cycles / OF_COMPARISON).min(MOST_OF_COMPARISON);
    let each = if wanted < FEWEST_OF_COMPARISON { 0 } else { wanted.next_multiple_of(batch) };
    let each = if each > plan.cycles { 0 } else { each };
    let entries = largest(studies).map_or(0, |entries| entries.len() as u64);
    (each, 4 * each * entries)
}

/// Drives the entries of both that matter most. `before`: what the two have driven of the plan.
/// None where no number of either is judged.
pub(crate) fn of_difference(
    quantity: &NamedQuantity,
    studies: &[&LoadedStudy],
    before: &[&[Record]],
    plan: &RunPlan,
    look: &mut dyn FnMut(u64) -> ControlFlow<()>,
) -> ControlFlow<(), Option<JudgedDifference>> {
    if studies.iter().all(|study| study.judged().is_empty()) {
        return ControlFlow::Continue(None);
    }
    let (cycles, _) = cycles_of_difference(studies, plan);
    let mut entries = largest(studies).filter(|_| cycles > 0).unwrap_or_default();
    let plan = RunPlan { cycles, ..*plan };
    let asked = Asked { quantity, studies, before, seed: plan.seed };
    let mut driver = Driver { driven: 0, look };
    for entry in &mut entries {
        driver.at_ends(entry, studies, &plan)?;
        asked.change(entry);
    }
    let known = entries.iter().any(|entry| entry.low.is_some());
    let moved = entries.iter().filter_map(|entry| Some(entry.numbers()?.name.clone())).collect();
    let plus_minus = known.then(|| root(entries.iter().map(Entry::squares)).mean);
    ControlFlow::Continue(Some(JudgedDifference { plus_minus, moved, cycles }))
}

impl Answer for DoubtAnswer {
    fn text(&self) -> String {
        text::doubt_text(self)
    }
}
