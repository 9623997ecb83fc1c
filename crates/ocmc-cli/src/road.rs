//! `ocmc road`, `ocmc validate`: the road of a drive as an operating cycle, and measured drives
//! over simulated ones on the same road.

use crate::arguments::{
    FiledWorkOptions, StudyOptions, TableOptions, one_of, sources, whole_number,
};
use crate::failure::Failure;
use crate::log::SteeringArguments;
use crate::output::{self, Target, warn};
use crate::progress::watched;
use clap::Args;
use ocmc_api::{
    Answer, CurveOptions, KEEPS, Keep, MOST_TRIPS, MissingLimits, RUN_IN_M, RoadOptions,
    RoadRequest, RunPlan, ValidateAnswer, ValidateRequest, Watch, mappings,
};
use std::path::{Path, PathBuf};

/// Logs, and how roads are found in them.
#[derive(Clone, Debug, Args)]
struct RoadOfLogArguments {
    /// Logs: CSV with time and speed, plain or compressed, or VECTO's time series (`.vmod`)
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Says which column is what, as in speed_mph=gps_speed or yaw_rate_degps=-gyro; may be
    /// repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    map: Vec<String>,
    /// Speed limit of logs that have no column of limits, in m/s [default: what their speed shows]
    #[arg(long, value_name = "MPS", allow_negative_numbers = true)]
    limit: Option<f64>,
    /// Road type of logs that have no column road_type [default: by the speed limit]
    #[arg(long, value_name = "NAME")]
    road_type: Option<String>,
    /// Standstills are no stops of the road, but for objects of the map and stops of the mission
    #[arg(long)]
    no_stops: bool,
    /// Standstills from this time on are stops of the mission, in s
    #[arg(long, value_name = "S", default_value = "300", allow_negative_numbers = true)]
    mission_stop: f64,
    /// Length over which altitudes are averaged, in m
    #[arg(long, value_name = "M", default_value = "200", allow_negative_numbers = true)]
    altitude_average: f64,
    /// Smallest and largest radius of curves that are taken, in m
    #[arg(
        long, value_names = ["LOWER", "UPPER"], num_args = 2, default_values = ["20", "500"],
        allow_negative_numbers = true
    )]
    radius_range: Vec<f64>,
    /// Cuts a curve in two where its curvature steps by this factor or more
    #[arg(long, value_name = "RATIO")]
    split: Option<f64>,
    #[command(flatten)]
    steering: SteeringArguments,
}

/// Options of `ocmc road`.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("out", |out| out.help("File to write, `.csv` or `.json`; of several roads each \
    gets a number: road-1.csv. An existing one is replaced [default: CSV to standard output]")))]
pub(crate) struct RoadArguments {
    #[command(flatten)]
    road: RoadOfLogArguments,
    #[command(flatten)]
    table: TableOptions,
    /// No account of what was found and left out
    #[arg(long)]
    quiet: bool,
}

/// Options of `ocmc validate`.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("quiet", |quiet| quiet.help("No progress and no account of what was left out")))]
pub(crate) struct ValidateArguments {
    #[command(flatten)]
    road_of_log: RoadOfLogArguments,
    /// Road that all of the logs were driven on: `.csv` or `.json` of `ocmc road` or `ocmc cycle`,
    /// a route, VECTO's `.vdri` [default: each drive on the road that its own log shows]
    #[arg(long, value_name = "FILE")]
    road: Option<PathBuf>,
    /// Parts that are taken from the road's file instead of being drawn from the study; may be
    /// repeated or joined by commas
    #[arg(long, value_name = "WHAT", value_delimiter = ',', value_parser = one_of(KEEPS))]
    keep: Vec<Keep>,
    #[command(flatten)]
    study: StudyOptions,
    /// Independent trips that are simulated on each road
    #[arg(
        long, value_name = "N", default_value = "2000", allow_negative_numbers = true,
        value_parser = whole_number(2..=MOST_TRIPS)
    )]
    trips: u64,
    /// Master seed of the trips
    #[arg(
        long, value_name = "N", default_value = "1", allow_negative_numbers = true,
        value_parser = whole_number(0..=u64::MAX)
    )]
    seed: u64,
    /// Way behind a moving start and before a moving end that is not scored, in m: simulated trips
    /// begin and end at rest
    #[arg(long, value_name = "M", default_value_t = RUN_IN_M, allow_negative_numbers = true)]
    run_in: f64,
    #[command(flatten)]
    work: FiledWorkOptions,
}

impl RoadOfLogArguments {
    fn options(&self) -> RoadOptions {
        let standard = RoadOptions::default();
        RoadOptions {
            curves: CurveOptions { split_ratio: self.split, ..standard.curves },
            radius_range_m: [self.radius_range[0], self.radius_range[1]],
            altitude_average_m: self.altitude_average,
            mission_stop_s: self.mission_stop,
            road_type: self.road_type.clone(),
            missing_limits: self.limit.map_or(MissingLimits::OfSpeed, MissingLimits::Everywhere),
            ..standard
        }
    }
}

/// Makes the roads of logs and writes them down.
pub(crate) fn road(arguments: &RoadArguments) -> Result<(), Failure> {
    let RoadArguments { road, table, quiet } = arguments;
    let target = table.target()?;
    let request = RoadRequest {
        logs: &sources(&road.logs),
        mappings: mappings(&road.map)?,
        options: road.options(),
        steering: road.steering.steering()?,
        stops: !road.no_stops,
    };
    let answer = watched(*quiet, |watch| ocmc_api::road(&request, &mut remarks(*quiet), watch))?;
    if !quiet {
        answer.notes().iter().for_each(|told| output::note(told));
        output::note(answer.text().trim_end());
    }
    match (answer.roads.as_slice(), &table.out) {
        ([only], _) => target.write(only, |bytes| only.write_csv(bytes)),
        (several, Some(out)) => several.iter().enumerate().try_for_each(|(k, road)| {
            let path = numbered(out, k + 1);
            Target::of(Some(&path))?.write(road, |bytes| road.write_csv(bytes))
        }),
        (several, None) => Err(Failure::Usage(format!(
            "the logs show {} roads: give --out, and each of them gets a file",
            several.len()
        ))),
    }
}

/// Prints what was left out of logs, unless quiet was asked for.
fn remarks(quiet: bool) -> impl FnMut(&str) {
    move |text| {
        if !quiet {
            warn(text);
        }
    }
}

/// The name of one of several files.
fn numbered(path: &Path, number: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{number}.{ending}"))
}

/// Lays measured drives over simulated ones.
pub(crate) fn validate(arguments: &ValidateArguments) -> Result<(), Failure> {
    let ValidateArguments { road_of_log, study, work, .. } = arguments;
    if !(arguments.run_in >= 0.0 && arguments.run_in.is_finite()) {
        let text = format!("--run-in is {}: allowed is a number from 0 on", arguments.run_in);
        return Err(Failure::Usage(text));
    }
    work.check_out()?;
    let request = ValidateRequest {
        logs: &sources(&road_of_log.logs),
        mappings: mappings(&road_of_log.map)?,
        study: &study.load()?,
        road: arguments.road.as_deref(),
        options: road_of_log.options(),
        steering: road_of_log.steering.steering()?,
        stops: !road_of_log.no_stops,
        keep: arguments.keep.clone(),
        plan: RunPlan::new(arguments.seed, 0, arguments.trips, work.threads, None),
        run_in_m: arguments.run_in,
    };
    let mut remarks = remarks(work.answer.quiet);
    let ask = |watch: &mut Watch| ocmc_api::validate(&request, &mut remarks, watch);
    work.write(ask, ValidateAnswer::save)
}
