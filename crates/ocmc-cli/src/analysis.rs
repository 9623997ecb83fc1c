//! `ocmc sensitivity`, `ocmc compare`, `ocmc doubt`: which factors the spread between cycles comes
//! from, how studies differ under common random numbers, and what the answer owes to judged
//! numbers.

use crate::arguments::{
    FileOptions, FiledWorkOptions, RangeArguments, StudyOptions, check_range, one_of, whole_number,
};
use crate::failure::Failure;
use crate::output;
use clap::builder::{PossibleValue, PossibleValuesParser, StringValueParser, TypedValueParser};
use clap::error::Error as ArgumentError;
use clap::{Arg, Args, Command};
use ocmc_api::study::LoadedStudy;
use ocmc_api::{
    CompareRequest, DoubtAnswer, DoubtRequest, FORMATS, OVERS, Over, REPORT, RecordFormat,
    SensitivityAnswer, SensitivityRequest, Watch, columns, compared_columns, factors,
};
use std::ffi::OsStr;
use std::path::PathBuf;

/// Most cycles of a crossed design: the values of all of them are held in memory, once for each
/// driver.
const MOST_CROSSED: u64 = 1_000_000;

/// Options of an analysis that drives many cycles.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("out", |out| out.help(
    "Directory for records, tables and a page; it has to be empty, and is made where it is not \
     there"
)))]
struct AnalysisArguments {
    #[command(flatten)]
    range: RangeArguments,
    /// Quantity that is asked about [default: the consumption; of several studies the first that
    /// all have]
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(columns()))]
    column: Option<String>,
    #[command(flatten)]
    work: FiledWorkOptions,
}

impl AnalysisArguments {
    /// Reports the files written, and their place.
    fn note_out(&self, files: &str) {
        let FiledWorkOptions { out, answer, .. } = &self.work;
        if let Some(directory) = out.as_ref().filter(|_| !answer.quiet && !answer.json) {
            let shown = directory.display();
            output::note(&format!("Written to `{shown}`: {files}. Any browser opens {REPORT}."));
        }
    }
}

/// The name of a column of the records: those that all studies have are offered, and each study
/// has those of its road types.
#[derive(Clone, Debug)]
struct ColumnName;

impl TypedValueParser for ColumnName {
    type Value = String;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<String, ArgumentError> {
        StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(compared_columns().into_iter().map(PossibleValue::new)))
    }
}

/// `--column` of a comparison: any column of the records that is a number.
pub(crate) fn any_column(column: Arg) -> Arg {
    column.value_parser(ColumnName).hide_possible_values(true).help(
        "Column of the records that is compared, such as mean_speed_mps or fuel_kg_urban \
         [default: the first consumption that all studies have]",
    )
}

/// A sensitivity analysis.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("cycles", |cycles| cycles.help(
    "Number of rows of the design: each drives two cycles, and one more for each factor"
)))]
pub(crate) struct SensitivityArguments {
    #[command(flatten)]
    study: StudyOptions,
    /// Only these factors; may be repeated or joined by commas [default: all]
    #[arg(
        long, value_name = "NAME", value_delimiter = ',',
        value_parser = PossibleValuesParser::new(factors())
    )]
    factor: Vec<String>,
    /// Unit over which the variance is taken [default: trip]
    #[arg(long, value_name = "WHAT", value_parser = one_of(OVERS))]
    over: Option<Over>,
    /// A second opinion: also drives so many cycles with each of 30 drivers, and splits the
    /// variance two ways
    #[arg(
        long, value_name = "N", allow_negative_numbers = true,
        value_parser = whole_number(2..=MOST_CROSSED)
    )]
    crossed: Option<u64>,
    /// Shares of the six factors that add up to one, too: Shapley effects, for 64 more cycles a row
    #[arg(long)]
    shapley: bool,
    #[command(flatten)]
    analysis: AnalysisArguments,
}

/// Studies to compare.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("cycles", |cycles| cycles.help("Number of cycles in each study")))]
#[command(mut_arg("column", any_column))]
pub(crate) struct CompareArguments {
    /// Built-in studies or study files, the baseline first; a single one is compared with itself
    /// under --set
    #[arg(value_name = "NAME|FILE", required = true)]
    studies: Vec<PathBuf>,
    /// Replaces one value of every study; of a single one, in its second version; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    files: FileOptions,
    #[command(flatten)]
    analysis: AnalysisArguments,
    /// Format of the records in --out [default: parquet]
    #[arg(long, value_name = "FORMAT", requires = "out", value_parser = one_of(FORMATS))]
    format: Option<RecordFormat>,
}

/// A study whose judged numbers are moved.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("cycles", |cycles| cycles.default_value("2000").help(
    "Number of cycles at each end of the twelve entries that matter most; the others drive a tenth"
)))]
pub(crate) struct DoubtArguments {
    #[command(flatten)]
    study: StudyOptions,
    /// Asks how far the difference to this study hangs on judged numbers: B less the study
    #[arg(long, value_name = "NAME|FILE")]
    against: Option<PathBuf>,
    #[command(flatten)]
    analysis: AnalysisArguments,
}

/// Moves the judged numbers and prints what that does.
pub(crate) fn doubt(arguments: &DoubtArguments) -> Result<(), Failure> {
    let DoubtArguments { study, against, analysis } = arguments;
    let own = study.load()?;
    let other = against.as_ref().map(|name| study.load_other(name)).transpose()?;
    analysis.work.check_out()?;
    let named = |loaded: &LoadedStudy| loaded.origin.to_string();
    let request = DoubtRequest {
        study: (named(&own), &own),
        against: other.as_ref().map(|other| (named(other), other)),
        plan: analysis.range.plan(analysis.work.threads)?,
        column: analysis.column.clone(),
    };
    let ask = |watch: &mut Watch| ocmc_api::doubt(&request, watch);
    analysis.work.write(ask, DoubtAnswer::save)?;
    analysis.note_out("doubt.json, doubt.csv, the studies and a page");
    Ok(())
}

/// Drives the design and prints the shares.
pub(crate) fn sensitivity(arguments: &SensitivityArguments) -> Result<(), Failure> {
    let SensitivityArguments { study, factor, crossed, shapley, over, analysis } = arguments;
    let study = &study.load()?;
    analysis.work.check_out()?;
    let plan = analysis.range.plan(analysis.work.threads)?;
    if let Some(cycles) = *crossed {
        check_range(plan.first_cycle, cycles).map_err(|_| {
            let text = "--first-cycle with --crossed goes beyond the largest cycle id";
            Failure::Usage(text.to_owned())
        })?;
    }
    let factors = (!factor.is_empty()).then(|| factor.clone());
    let column = analysis.column.clone();
    let (over, crossed, shapley) = (over.unwrap_or_default(), *crossed, *shapley);
    let request = SensitivityRequest { study, plan, column, factors, over, crossed, shapley };
    let ask = |watch: &mut Watch| ocmc_api::sensitivity(&request, watch);
    analysis.work.write(ask, SensitivityAnswer::save)?;
    analysis.note_out("the design, the study, sensitivity.json and a page");
    Ok(())
}

/// Compares the studies and prints the differences.
pub(crate) fn compare(arguments: &CompareArguments) -> Result<(), Failure> {
    let analysis = &arguments.analysis;
    let named = named(arguments)?;
    analysis.work.check_out()?;
    let request = CompareRequest {
        studies: named.iter().map(|(name, loaded)| (name.clone(), loaded)).collect(),
        plan: analysis.range.plan(analysis.work.threads)?,
        column: analysis.column.clone(),
        keep: analysis.work.out.is_some(),
    };
    let ask = |watch: &mut Watch| ocmc_api::compare(&request, watch);
    let format = arguments.format.unwrap_or_default();
    analysis.work.write(ask, |answer, directory| answer.save(directory, format))?;
    analysis.note_out("the runs, their pairs, the studies, comparison.json and a page");
    Ok(())
}

/// The studies that were named; of a single one, the study as it is and with the settings.
fn named(arguments: &CompareArguments) -> Result<Vec<(String, LoadedStudy)>, Failure> {
    let CompareArguments { studies, set, files, .. } = arguments;
    let load = |name: &PathBuf, sets: &[String]| -> Result<(String, LoadedStudy), Failure> {
        let loaded = files.load(name, sets)?;
        Ok((loaded.origin.to_string(), loaded))
    };
    let [only] = studies.as_slice() else {
        return studies.iter().map(|name| load(name, set)).collect();
    };
    if set.is_empty() {
        return Err(Failure::Usage(
            "a study is compared with another one, or with itself under --set: give a second \
             study, or --set KEY=VALUE"
                .to_owned(),
        ));
    }
    let (a, mut b) = (load(only, &[])?, load(only, set)?);
    b.0 = format!("{} with {}", b.0, set.join(" with "));
    Ok(vec![a, b])
}
