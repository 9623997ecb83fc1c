//! `ocmc learn`: a study from the files of a fleet.

use crate::arguments::{FileOptions, NoiseOptions, WorkOptions, share, whole_number};
use crate::failure::Failure;
use crate::output;
use crate::progress::watched;
use crate::study::written_study;
use clap::Args;
use ocmc_api::{LearnRequest, mappings};
use std::path::{Path, PathBuf};

/// Options of learning.
#[derive(Clone, Debug, Args)]
pub(crate) struct LearnArguments {
    /// Folder with what the fleet has: tables of trips or fills, logs and tracks, tables of
    /// weather, traffic, curves and speed changes
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Says which column is what, as in fuel_amount_l=diesel; may be repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    map: Vec<String>,
    /// Name of a built-in study, or a study file, that keeps what is not learnt
    #[arg(long, value_name = "NAME|FILE", default_value = "field-truck")]
    base: String,
    #[command(flatten)]
    files: FileOptions,
    /// Share of the trips that the check is made on, whole days of a truck; 0 for none
    #[arg(
        long, value_name = "SHARE", default_value = "20%", value_parser = held_back,
        allow_negative_numbers = true
    )]
    hold_back: f64,
    #[command(flatten)]
    noise: NoiseOptions,
    /// Master seed
    #[arg(
        long, value_name = "N", default_value = "1", allow_negative_numbers = true,
        value_parser = whole_number(0..=u64::MAX)
    )]
    seed: u64,
    #[command(flatten)]
    work: WorkOptions,
    /// Study file to write
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Page to write: one HTML file that opens offline
    #[arg(long, value_name = "FILE.html")]
    page: Option<PathBuf>,
}

/// A share of the trips that is held back, or none of them.
fn held_back(text: &str) -> Result<f64, String> {
    if text == "0" || text == "0%" { Ok(0.0) } else { share(text) }
}

/// Learns a study.
pub(crate) fn learn(arguments: &LearnArguments) -> Result<(), Failure> {
    let LearnArguments { folder, base, work, out, page, .. } = arguments;
    let loaded = arguments.files.load(Path::new(base), &[])?;
    let name = out.as_ref().and_then(|path| path.file_stem());
    let name = name.map_or("my-fleet".into(), |stem| stem.to_string_lossy());
    let request = LearnRequest {
        folder: folder.clone(),
        mappings: mappings(&arguments.map)?,
        base: (base.clone(), &loaded),
        name: name.into_owned(),
        noise: arguments.noise.noise(),
        hold_back: arguments.hold_back,
        seed: arguments.seed,
        threads: work.threads,
    };
    let learnt = watched(work.answer.quiet, |watch| ocmc_api::learn(&request, watch))?;
    work.answer.show(&learnt)?;
    if let Some(page) = page {
        learnt.save_page(page)?;
        if !work.answer.quiet {
            output::note(&format!("Written: `{}`.", page.display()));
        }
    }
    out.as_ref().map_or(Ok(()), |out| written_study(out, &learnt.study_toml, work.answer.quiet))
}
