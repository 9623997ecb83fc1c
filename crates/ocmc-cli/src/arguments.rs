//! Common parts of the commands' arguments: plain data, and how values are read.

use crate::failure::Failure;
use crate::output::{self, Target, warn};
use crate::progress::watched;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use ocmc_api::study::{self, Files, Given, LoadedStudy, Opened};
use ocmc_api::{
    Answer, Error, LAST_CYCLE_ID, MOST_THREADS, Noise, RunPlan, Source, Watch, Word, check_empty,
};
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Most trips of a truck.
pub(crate) const MOST_TRIPS: u64 = 1_000_000;

/// The files that a study may name.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct FileOptions {
    /// Reads no file that a study is or names, for services that run studies of others: built-in
    /// studies and vehicles are allowed, and `-`, the text on standard input
    #[arg(long)]
    no_files: bool,
}

impl FileOptions {
    /// The files.
    pub(crate) fn files(self) -> Files {
        if self.no_files { Files::Refused } else { Files::here() }
    }

    /// A study, or those of all groups of a fleet, with what is set in them.
    pub(crate) fn load_all(
        self,
        study: &Path,
        sets: &[String],
    ) -> Result<Vec<LoadedStudy>, Failure> {
        let studies = match study::open_all(&Given::Named(study), &self.files(), sets)? {
            Opened::Study(study) => vec![*study],
            Opened::Fleet(groups) => groups.into_iter().map(|group| group.study).collect(),
        };
        studies.iter().flat_map(LoadedStudy::warnings).for_each(|warning| warn(&warning));
        Ok(studies)
    }

    /// A study with what is set in it.
    pub(crate) fn load(self, study: &Path, sets: &[String]) -> Result<LoadedStudy, Failure> {
        let loaded = study::open(&Given::Named(study), &self.files(), sets)?;
        loaded.warnings().iter().for_each(|warning| warn(warning));
        Ok(loaded)
    }
}

/// A study, and what is set in it.
#[derive(Clone, Debug, Args)]
pub(crate) struct StudyOptions {
    /// Name of a built-in study, a study file, or `-` for standard input
    #[arg(long, value_name = "NAME|FILE", default_value = "field-truck")]
    pub(crate) study: PathBuf,
    /// Replaces one value of the study, as in driver.curve_speed.exponent=0.5; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    #[command(flatten)]
    files: FileOptions,
}

impl StudyOptions {
    /// The study with what is set in it.
    pub(crate) fn load(&self) -> Result<LoadedStudy, Failure> {
        self.load_other(&self.study)
    }

    /// The same study with one more setting.
    pub(crate) fn with(&self, setting: Option<String>) -> Self {
        let mut with = self.clone();
        with.set.extend(setting);
        with
    }

    /// Another study with what is set in this one.
    pub(crate) fn load_other(&self, study: &Path) -> Result<LoadedStudy, Failure> {
        self.files.load(study, &self.set)
    }
}

/// Range of cycles.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct RangeArguments {
    /// Number of cycles
    #[arg(
        long, value_name = "N", default_value = "1000", allow_negative_numbers = true,
        value_parser = whole_number(1..=LAST_CYCLE_ID)
    )]
    pub(crate) cycles: u64,
    /// Id of the first cycle
    #[arg(
        long, value_name = "ID", default_value = "0", allow_negative_numbers = true,
        value_parser = whole_number(0..=LAST_CYCLE_ID - 1)
    )]
    pub(crate) first_cycle: u64,
    /// Master seed
    #[arg(
        long, value_name = "N", default_value = "1", allow_negative_numbers = true,
        value_parser = whole_number(0..=u64::MAX)
    )]
    pub(crate) seed: u64,
}

impl RangeArguments {
    /// The plan to drive them.
    pub(crate) fn plan(self, threads: Option<usize>) -> Result<RunPlan, Failure> {
        check_range(self.first_cycle, self.cycles)?;
        Ok(RunPlan::new(self.seed, self.first_cycle, self.cycles, threads, None))
    }
}

/// Trucks that make several trips.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct TruckOptions {
    /// Number of trucks, in place of --cycles: each makes the study's `fleet.trips_per_truck`
    /// trips, or --trips
    #[arg(
        long, value_name = "N", conflicts_with = "cycles", allow_negative_numbers = true,
        value_parser = whole_number(1..=LAST_CYCLE_ID)
    )]
    pub(crate) trucks: Option<u64>,
    /// Trips of each truck: sets `fleet.trips_per_truck` of the study
    #[arg(
        long, value_name = "N", allow_negative_numbers = true,
        value_parser = whole_number(1..=MOST_TRIPS)
    )]
    pub(crate) trips: Option<u64>,
}

impl TruckOptions {
    /// The setting that a study has by them.
    pub(crate) fn setting(self) -> Option<String> {
        self.trips.map(|trips| format!("fleet.trips_per_truck={trips}"))
    }

    /// The cycles of so many trucks of a study; those of the range where no number was given.
    pub(crate) fn range(self, range: RangeArguments, study: &LoadedStudy) -> RangeArguments {
        let each = study.model.fleet.trips_per_truck.max(1);
        let cycles = self.trucks.map_or(range.cycles, |trucks| trucks.saturating_mul(each));
        RangeArguments { cycles, ..range }
    }
}

/// How noisy a table of trips is.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct NoiseOptions {
    /// Noise of the amounts, SD as a share
    #[arg(long, value_name = "SHARE", default_value = "0.03", allow_negative_numbers = true)]
    amount_noise: f64,
    /// Noise of the gross weights, SD as a share
    #[arg(long, value_name = "SHARE", default_value = "0.05", allow_negative_numbers = true)]
    weight_noise: f64,
}

impl NoiseOptions {
    /// As requests have it.
    pub(crate) fn noise(self) -> Noise {
        Noise { amount: self.amount_noise, weight: self.weight_noise }
    }
}

/// Whether anything is told beside an answer. All commands take it: scripts give it to all.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct QuietOption {
    /// No progress, no hints and no account of what was read
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// How an answer is waited for and given.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct AnswerOptions {
    /// No progress, no hints and no account of what was read
    #[arg(long)]
    pub(crate) quiet: bool,
    /// The answer as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

impl AnswerOptions {
    /// Asks a question, and prints its answer.
    pub(crate) fn print<A: Answer>(
        self,
        ask: impl FnOnce(&mut Watch) -> Result<A, Error>,
    ) -> Result<(), Failure> {
        self.show(&watched(self.quiet, ask)?)
    }

    /// Prints an answer, with what was read where that is to be told.
    pub(crate) fn show(self, answer: &impl Answer) -> Result<(), Failure> {
        let print = if self.quiet { output::print_quietly } else { output::print };
        print(answer, self.json)
    }
}

/// Where a table goes.
#[derive(Clone, Debug, Args)]
pub(crate) struct TableOptions {
    /// File to write, `.csv` or `.json`; an existing one is replaced [default: CSV to standard
    /// output]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// JSON instead of CSV to standard output
    #[arg(long, conflicts_with = "out")]
    pub(crate) json: bool,
}

impl TableOptions {
    /// The file, or standard output.
    pub(crate) fn target(&self) -> Result<Target<'_>, Failure> {
        if self.json { Ok(Target::json()) } else { Target::of(self.out.as_deref()) }
    }
}

/// How many threads find an answer, and how it is given.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct WorkOptions {
    /// Threads [default: one for each CPU]
    #[arg(
        long, value_name = "N", allow_negative_numbers = true,
        value_parser = whole_number(1..=MOST_THREADS)
    )]
    pub(crate) threads: Option<usize>,
    #[command(flatten)]
    pub(crate) answer: AnswerOptions,
}

/// As [`WorkOptions`], of answers that are files, too.
#[derive(Clone, Debug, Args)]
pub(crate) struct FiledWorkOptions {
    /// Threads [default: one for each CPU]
    #[arg(
        long, value_name = "N", allow_negative_numbers = true,
        value_parser = whole_number(1..=MOST_THREADS)
    )]
    pub(crate) threads: Option<usize>,
    /// Directory for tables, pictures and a page; it has to be empty, and is made where it is not
    /// there
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) answer: AnswerOptions,
}

impl FiledWorkOptions {
    /// Checks, before anything is driven, that nothing is in the directory.
    pub(crate) fn check_out(&self) -> Result<(), Failure> {
        Ok(self.out.as_deref().map_or(Ok(()), check_empty)?)
    }

    /// Asks a question, writes the files of its answer where there is a directory for them, and
    /// prints it.
    pub(crate) fn write<A: Answer>(
        &self,
        ask: impl FnOnce(&mut Watch) -> Result<A, Error>,
        save: impl FnOnce(&A, &Path) -> Result<(), Error>,
    ) -> Result<(), Failure> {
        let answer = watched(self.answer.quiet, ask)?;
        self.out.as_deref().map_or(Ok(()), |directory| save(&answer, directory))?;
        self.answer.show(&answer)
    }
}

/// Checks that all cycles have an id.
pub(crate) fn check_range(first_cycle: u64, cycles: u64) -> Result<(), Failure> {
    if first_cycle.checked_add(cycles).is_none_or(|end| end > LAST_CYCLE_ID) {
        return Err(Failure::Usage(format!(
            "--first-cycle {first_cycle} with --cycles {cycles} goes beyond the largest cycle id; \
             allowed is a sum of at most {LAST_CYCLE_ID}"
        )));
    }
    Ok(())
}

/// Files to read.
pub(crate) fn sources(files: &[PathBuf]) -> Vec<Source> {
    files.iter().cloned().map(Source::File).collect()
}

/// One of the words that stand for values.
pub(crate) fn one_of<T, const N: usize>(words: [Word<T>; N]) -> impl TypedValueParser<Value = T>
where
    T: Clone + Send + Sync + 'static,
{
    let names = words.clone().map(|(name, help, _)| PossibleValue::new(name).help(help));
    PossibleValuesParser::new(names).map(move |typed| {
        let known = words.iter().find(|(name, ..)| *name == typed);
        known.expect("one of these names").2.clone()
    })
}

/// A whole number within a range; `10_000` is one, too.
pub(crate) fn whole_number<T>(
    allowed: RangeInclusive<T>,
) -> impl Fn(&str) -> Result<T, String> + Clone
where
    T: TryFrom<u64> + PartialOrd + Display + Clone,
{
    move |text| {
        let digits = Some(text.replace('_', ""));
        let digits = digits.filter(|digits| digits.bytes().all(|byte| byte.is_ascii_digit()));
        let number = digits.and_then(|digits| digits.parse::<u64>().ok()?.try_into().ok());
        number.filter(|number| allowed.contains(number)).ok_or_else(|| {
            let meant = meant(text)
                .filter(|meant| T::try_from(*meant).is_ok_and(|number| allowed.contains(&number)));
            let hint = meant.map_or_else(String::new, |meant| format!("; type {meant}"));
            // some part thousands by a point
            let parted = text.split_once('.').filter(|(_, behind)| behind.len() == 3);
            let parted = parted.filter(|_| !hint.is_empty());
            let hint = hint + &parted.map_or_else(String::new, |(a, b)| format!(" or {a}{b}"));
            format!("allowed is a whole number from {} to {}{hint}", allowed.start(), allowed.end())
        })
    }
}

/// The whole number that people mean by 1e4, 10k, 2M or 10,000.
fn meant(text: &str) -> Option<u64> {
    let mut groups = text.split([',', '\'', ' ']);
    let first = groups.next()?.len();
    let plain = if (1..=3).contains(&first) && groups.all(|group| group.len() == 3) {
        text.replace([',', '\'', ' '], "")
    } else {
        text.to_owned()
    };
    let (number, times) = match plain.strip_suffix(['k', 'K']) {
        Some(number) => (number, 1e3),
        None => plain.strip_suffix('M').map_or((plain.as_str(), 1.0), |number| (number, 1e6)),
    };
    let number = number.parse::<f64>().ok()? * times;
    // what a float counts exactly
    (number.fract() == 0.0 && (0.0..9e15).contains(&number)).then_some(number as u64)
}

/// A share in per cent: `1%`. Without the unit, 0.8 would be 0.8 % for some and 80 % for others.
pub(crate) fn share(text: &str) -> Result<f64, String> {
    let allowed = || "allowed is a share above 0% and below 100%, as in 1%".to_owned();
    let number = text.strip_suffix('%').unwrap_or(text).trim();
    let share = number.parse::<f64>().map_err(|_| allowed())? / 100.0;
    if !(share > 0.0 && share < 1.0) {
        return Err(allowed());
    }
    if !text.ends_with('%') {
        return Err(format!("the unit is missing: type {text}%"));
    }
    Ok(share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares() {
        assert_eq!(share("1%"), Ok(0.01));
        assert_eq!(share("80 %"), Ok(0.8));
        assert!(share("0.8").is_err_and(|message| message.contains("type 0.8%")));
        for text in ["", "%", "0%", "-1%", "100%", "nan%", "inf%", "1%%", "x"] {
            assert!(share(text).is_err_and(|message| message.contains("as in 1%")), "{text}");
        }
    }

    #[test]
    fn numbers() {
        let any = whole_number(0..=u64::MAX);
        assert_eq!(any("10_000"), Ok(10_000));
        assert_eq!(any("18446744073709551615"), Ok(u64::MAX));
        for text in ["", "_", "-1", "+1", "1.5", "1e3", "18446744073709551616", "x"] {
            assert!(any(text).is_err(), "{text}");
        }
        for (text, typed) in
            [("1e4", 10_000), ("10k", 10_000), ("10,000", 10_000), ("2M", 2_000_000)]
        {
            let hint = format!("; type {typed}");
            assert!(any(text).is_err_and(|message| message.ends_with(&hint)), "{text}");
        }
        for text in ["1.5", "1e-3", "-1e4", "1,5", "10,00", "k", "1e40", "inf", "nan", ",", ""] {
            assert!(
                any(text).is_err_and(|message| message.ends_with(&u64::MAX.to_string())),
                "{text}"
            );
        }
        let at_least_one = whole_number(1..=LAST_CYCLE_ID);
        assert_eq!(at_least_one("288230376151711743"), Ok(LAST_CYCLE_ID));
        for text in ["0", "288230376151711744"] {
            assert!(
                at_least_one(text).is_err_and(|message| message.contains("288230376151711743"))
            );
        }
        let crossed = whole_number(2..=1_000_000_u64);
        assert_eq!(crossed("2"), Ok(2));
        for text in ["1", "1000001", "99999999999999", "x"] {
            assert!(crossed(text).is_err_and(|message| message.contains("2 to 1000000")), "{text}");
        }
        let threads = whole_number(1..=1024_usize);
        assert!(threads("0").is_err() && threads("1025").is_err() && threads("1024").is_ok());
    }
}
