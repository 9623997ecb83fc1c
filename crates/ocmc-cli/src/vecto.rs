//! `ocmc vecto`: VECTO's results beside what is computed here, from VECTO's own files.

use crate::arguments::{AnswerOptions, FileOptions};
use crate::failure::Failure;
use clap::Args;
use ocmc_api::{VectoRequest, VectoTruck};
use std::path::PathBuf;

/// A truck, its missions and VECTO's results.
#[derive(Clone, Debug, Args)]
pub(crate) struct VectoArguments {
    /// A job of VECTO (`.vecto`), with the files that it names beside it; or a vehicle: a built-in
    /// name or a file
    #[arg(value_name = "JOB|VEHICLE")]
    truck: String,
    /// Missions (`.vdri`) [default: VECTO's speed alone is followed]
    #[arg(value_name = "MISSION")]
    missions: Vec<PathBuf>,
    /// Results of VECTO: a time series (`.vmod`) or sums (`.vsum`), gzip or not; may be repeated
    /// [default: the time series beside the job]
    #[arg(long = "result", value_name = "FILE")]
    results: Vec<PathBuf>,
    /// Replaces one value of the truck's study, as in
    /// vehicle.powertrain.combustion.gearbox.indirect_loss_share=0.04; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    files: FileOptions,
    #[command(flatten)]
    answer: AnswerOptions,
}

/// Compares and prints.
pub(crate) fn vecto(arguments: &VectoArguments) -> Result<(), Failure> {
    let VectoArguments { truck, missions, results, set, files, answer } = arguments;
    let request = VectoRequest {
        truck: VectoTruck::named(truck),
        missions: missions.clone(),
        results: results.clone(),
        sets: set.clone(),
        files: files.files(),
    };
    answer.show(&ocmc_api::vecto(&request)?)
}
