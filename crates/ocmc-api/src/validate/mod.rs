//! Measured drives over simulated ones, on the same road.

mod files;
mod placing;
mod text;

pub use files::check_empty;
pub(crate) use files::written;

use crate::error::Error;
use crate::road::{RoadRequest, drives, told};
use crate::source::{Mapping, Source};
use crate::watch::{Progress, Watch};
use ocmc_core::energy::Carrier;
use ocmc_core::kernel::drive::trace::{Trace, motions};
use ocmc_core::lanes::WIDTH;
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::route::Keep;
use ocmc_estimation::log::road::RoadOptions;
use ocmc_estimation::validation::ensemble::{DriveScore, Ensemble, Measured};
use ocmc_estimation::validation::passage::{Passage, Places, Rows};
use ocmc_estimation::validation::pooled::{Pooled, pooled};
use ocmc_estimation::validation::simulated;
use ocmc_fleet::run::{RunPlan, each};
use ocmc_io::given_cycle;
use ocmc_io::intake::FileAccount;
use ocmc_io::log::curves::Steering;
use ocmc_io::log::driven::{MeasuredDrive, MeasuredDrives};
use ocmc_io::log::roads::NEEDS;
use ocmc_io::report::RoadPicture;
use ocmc_io::study::{LoadedStudy, study_hash};
use ocmc_io::table::Quantity;
use placing::{Placed, place};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Fewest trips with which bands are what they say: fewer are driven and warned of.
pub const FEWEST_TRIPS: u64 = 2000;
/// Most trips on a road: their speeds at all places are held, 60 kB a trip.
pub const MOST_TRIPS: u64 = 20_000;
/// Way behind a moving start and before a moving end that is not scored, in m, by default
/// (judgement): simulated trips begin and end at rest.
pub const RUN_IN_M: f64 = 500.0;
/// Most drives of a road whose speeds the answer holds.
const MOST_HELD: usize = 12;

/// Logs, the road that they were driven on, and the study whose trips are laid under them.
#[derive(Clone, Debug)]
pub struct ValidateRequest<'a> {
    /// The logs.
    pub logs: &'a [Source],
    /// Columns of the quantities.
    pub mappings: Vec<Mapping>,
    /// The study with drivers and trucks.
    pub study: &'a LoadedStudy,
    /// The road that all of them were driven on: a file as `ocmc drive` takes it; none: each drive
    /// on the road that its own log shows.
    pub road: Option<&'a Path>,
    /// How roads are found in logs.
    pub options: RoadOptions,
    /// Steering ratio and wheelbase, for logs that only have the steering wheel's angle.
    pub steering: Option<Steering>,
    /// Whether the standstills of a log are stops of the road that it shows.
    pub stops: bool,
    /// Parts that are taken from the road instead of being drawn from the study.
    pub keep: Vec<Keep>,
    /// The trips.
    pub plan: RunPlan,
    /// Way behind a moving start and before a moving end that is not scored, in m.
    pub run_in_m: f64,
}

/// Measured drives over simulated ones.
#[derive(Clone, Debug, Serialize)]
pub struct ValidateAnswer {
    /// Name of the study.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Master seed.
    pub seed: u64,
    /// Independent trips on each road.
    pub trips: u64,
    /// Parts of the road that come from the validated logs themselves: `limits`, `stops`.
    pub circular: Vec<&'static str>,
    /// Unit of energy: `kg` of fuel, or `J` of the battery.
    pub energy_unit: &'static str,
    /// Carrier that the truck stores.
    #[serde(skip)]
    pub carrier: Carrier,
    /// Scores over all drives.
    pub pooled: Vec<Pooled>,
    /// The drives.
    pub drives: Vec<ValidatedDrive>,
    /// Number of drives that could not be scored.
    pub left_out: usize,
    /// The roads.
    pub roads: Vec<ValidatedRoad>,
    /// Files that were read.
    pub inputs: Vec<FileAccount>,
    /// How long it took, in s.
    pub wall_s: f64,
    /// Threads that it took.
    pub threads: usize,
}

/// One measured drive.
#[derive(Clone, Debug, Serialize)]
pub struct ValidatedDrive {
    /// Its scores.
    #[serde(flatten)]
    pub score: DriveScore,
    /// Number of its road, from 0.
    pub road: usize,
    /// Parts of the road that come from this drive: `limits`, `stops`.
    pub circular: Vec<&'static str>,
    /// The factor by which its way was stretched to the length of the road.
    pub stretched: f64,
}

/// One road, and the speeds along it.
#[derive(Clone, Debug, Serialize)]
pub struct ValidatedRoad {
    /// Name of the road.
    pub name: String,
    /// Length, in m.
    pub length_m: f64,
    /// Where its limits come from: `column`, `given`, `estimated`; none of a road that was not made
    /// from a log.
    pub limit_source: Option<String>,
    /// Trips that arrived.
    pub completed: usize,
    /// Places, in m.
    pub position_m: Vec<f64>,
    /// Limit at each place, in m/s.
    pub limit_mps: Vec<f64>,
    /// Speed at each place that 5 % of the trips fall below, in m/s.
    pub p5_mps: Vec<f64>,
    /// 25 %.
    pub p25_mps: Vec<f64>,
    /// Half.
    pub p50_mps: Vec<f64>,
    /// 75 %.
    pub p75_mps: Vec<f64>,
    /// 95 %.
    pub p95_mps: Vec<f64>,
    /// Names of the first twelve drives on it, and their speeds at each place, in m/s; null where
    /// they were not.
    pub measured_mps: Vec<(String, Vec<f64>)>,
    #[serde(skip)]
    picture: RoadPicture,
}

/// A road and the drives on it.
struct Group {
    name: String,
    path: PathBuf,
    cycle: GivenCycle,
    drives: Vec<(MeasuredDrive, Placed)>,
}

/// Lays measured drives over simulated ones. `warn` receives what is odd in a log, and what is left
/// out.
///
/// ```
/// use ocmc_api::{Answer, MissingLimits, RUN_IN_M, RoadOptions, RunPlan, Source, ValidateRequest};
/// use ocmc_api::{go_on, study, trace, validate};
/// // a log from the study itself, on the road of its own
/// let sets = ["mission.length_m=3000", "simulation.step_s=0.5"];
/// let study = study::load("passenger-car", &sets)?;
/// let folder = tempfile::tempdir().expect("a directory");
/// let file = folder.path().join("log.csv");
/// let mut text = Vec::new();
/// trace(&study, 7, 3).write_csv(&mut text).expect("memory");
/// std::fs::write(&file, text).expect("space");
/// let request = ValidateRequest {
///     logs: &[Source::File(file)],
///     mappings: Vec::new(),
///     study: &study,
///     road: None,
///     options: RoadOptions { missing_limits: MissingLimits::OfSpeed, ..RoadOptions::default() },
///     steering: None,
///     stops: true,
///     keep: Vec::new(),
///     plan: RunPlan::new(1, 0, 20, None, None),
///     run_in_m: RUN_IN_M,
/// };
/// let answer = validate(&request, &mut |_| (), &mut go_on)?;
/// assert_eq!((answer.drives.len(), answer.roads[0].completed), (1, 20));
/// assert!(answer.text().contains("speed at all places, km/h"));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where a log or the road cannot be read, [`Error::Drive`] and [`Error::NoDrive`]
/// where no drive can be scored, [`Error::Study`] where the road does not fit the study,
/// [`Error::NoTrip`] where no trip arrives, [`Error::Interrupted`].
pub fn validate(
    request: &ValidateRequest,
    warn: &mut dyn FnMut(&str),
    watch: &mut Watch,
) -> Result<ValidateAnswer, Error> {
    let ValidateRequest { study, plan, keep, .. } = request;
    let clock = Instant::now();
    if plan.cycles < FEWEST_TRIPS {
        warn(&format!("{} trips: bands and ranks want {FEWEST_TRIPS} or more", plan.cycles));
    }
    let OnRoads { groups, mut left_out, inputs } = groups(request, warn, watch)?;
    let powertrain = &study.study.vehicle().powertrain;
    let (carrier, signal) = (powertrain.carriers()[0], powertrain.signals().source_rate);
    let rate = Quantity::rate_of(carrier);
    let (mut drives, mut roads) = (Vec::new(), Vec::new());
    let total = plan.cycles * groups.len() as u64;
    let mut first_fault = None;
    for (k, group) in groups.iter().enumerate() {
        let on_road = (*study).clone().on_route(&group.path, group.cycle.clone(), keep);
        let on_road = match on_road {
            Ok(on_road) => on_road.study,
            Err(error) => {
                left_out += group.drives.len();
                if groups.len() > 1 {
                    warn(&format!("{} is left out: {error}", group.name));
                }
                first_fault.get_or_insert(Error::Study(error));
                continue;
            }
        };
        let places = Places::of(group.cycle.length_m);
        let end = plan.first_cycle + plan.cycles;
        let side_by_side = |block: u64, _: &AtomicBool| {
            let first = plan.first_cycle + block * WIDTH as u64;
            let ids = first..(first + WIDTH as u64).min(end);
            let drives = motions(&on_road, ids.map(|id| on_road.sample(plan.seed, id)));
            let passage = |drive: &Trace| simulated::passage(places, drive, signal);
            drives.iter().map(passage).collect::<Vec<_>>()
        };
        let before = k as u64 * plan.cycles;
        let progress = |done| Progress { what: "trips", done, total };
        progress(before).look(watch)?;
        let mut done = before;
        let cycles = plan.cycles.div_ceil(WIDTH as u64);
        let blocks = RunPlan { first_cycle: 0, cycles, ..*plan };
        let driven = each(&blocks, &side_by_side, |count| {
            done = before + (count * WIDTH as u64).min(plan.cycles);
            watch(progress(done))
        });
        let trips = progress(done).ended(driven)?;
        let trips: Vec<Passage> = trips.into_iter().flatten().flatten().collect();
        if trips.len() < 2 {
            left_out += group.drives.len();
            let error = Error::NoTrip { road: group.name.clone(), trips: plan.cycles };
            if groups.len() > 1 {
                warn(&error.to_string());
            }
            first_fault.get_or_insert(error);
            continue;
        }
        let ensemble = Ensemble::new(places, trips);
        let mut held = Vec::new();
        for (drive, placed) in &group.drives {
            let measured = measured(drive, placed, places, rate, (plan.seed, drives.len() as u64));
            if held.len() < MOST_HELD {
                let speeds = measured.passage.speed_mps.iter().map(|v| f64::from(*v)).collect();
                held.push((drive.name.clone(), speeds));
            }
            if let Some(score) = ensemble.score(&measured) {
                let circular = circular(&group.cycle, &drive.fingerprint);
                let (road, stretched) = (roads.len(), placed.stretched);
                drives.push(ValidatedDrive { score, road, circular, stretched });
            } else {
                left_out += 1;
                let reason = "its part that is scored is shorter than two places".to_owned();
                let place = drive.name.clone();
                warn(&format!("{place} is left out: {reason}"));
                first_fault.get_or_insert(Error::NoDrive(place, reason));
            }
        }
        roads.push(ValidatedRoad::new(group, &ensemble, held));
    }
    if drives.is_empty() {
        return Err(first_fault.unwrap_or_else(|| {
            Error::NoDrive("the logs".to_owned(), "no drive can be scored".to_owned())
        }));
    }
    let scores: Vec<DriveScore> = drives.iter().map(|drive| drive.score.clone()).collect();
    let shared = (roads.len() == 1).then(|| roads[0].completed);
    let mut all: Vec<&'static str> = drives.iter().flat_map(|d| d.circular.clone()).collect();
    all.sort_unstable();
    all.dedup();
    Ok(ValidateAnswer {
        study: study.model.study.name.clone(),
        study_hash: study_hash(&study.model),
        seed: plan.seed,
        trips: plan.cycles,
        circular: all,
        energy_unit: carrier.declaration().units.0,
        carrier,
        pooled: pooled(&scores, shared),
        drives,
        left_out,
        roads,
        inputs,
        wall_s: clock.elapsed().as_secs_f64(),
        threads: plan.threads,
    })
}

/// Drives on their roads.
struct OnRoads {
    groups: Vec<Group>,
    /// Number of drives that lie on none.
    left_out: usize,
    /// Files that were read.
    inputs: Vec<FileAccount>,
}

/// The roads with the drives on them.
fn groups(
    request: &ValidateRequest,
    warn: &mut dyn FnMut(&str),
    watch: &mut Watch,
) -> Result<OnRoads, Error> {
    let ValidateRequest { logs, mappings, options, steering, stops, run_in_m, .. } = request;
    let Some(path) = request.road else {
        let (mappings, options) = (mappings.clone(), options.clone());
        let (steering, stops) = (*steering, *stops);
        let roads = RoadRequest { logs, mappings, options, steering, stops };
        let measured = drives(&roads, warn, watch)?;
        let left_out = measured.left_out.len();
        let group = |mut drive: MeasuredDrive| {
            let cycle = drive.road.take()?;
            let path = PathBuf::from(&drive.name);
            // its road is its own way
            drive.way.position_m = None;
            let placed = place(&drive.way, drive.way.length_m(), *run_in_m).ok()?;
            Some(Group { name: drive.name.clone(), path, cycle, drives: vec![(drive, placed)] })
        };
        let groups = measured.drives.into_iter().filter_map(group).collect();
        return Ok(OnRoads { groups, left_out, inputs: measured.inputs });
    };
    let (cycle, read) = given_cycle::read_with_account(path, &[])?;
    read.warnings().iter().for_each(|warning| warn(warning));
    let mut measured = MeasuredDrives::default();
    for (done, log) in logs.iter().enumerate() {
        Progress::of_logs(done, logs.len()).look(watch)?;
        measured.add(&log.log(mappings, &NEEDS, warn)?);
    }
    told(&measured, logs, warn)?;
    let (mut placed, mut left_out) = (Vec::new(), measured.left_out.len());
    let inputs = std::iter::once(read).chain(measured.inputs).collect();
    let mut first = None;
    for drive in measured.drives {
        match place(&drive.way, cycle.length_m, *run_in_m) {
            Ok(on_road) => placed.push((drive, on_road)),
            Err(reason) => {
                left_out += 1;
                warn(&format!("{} is left out: {reason}", drive.name));
                first.get_or_insert(Error::NoDrive(drive.name, reason));
            }
        }
    }
    match first {
        Some(error) if placed.is_empty() => Err(error),
        _ => {
            let (name, path) = (path.display().to_string(), path.to_owned());
            let groups = vec![Group { name, path, cycle, drives: placed }];
            Ok(OnRoads { groups, left_out, inputs })
        }
    }
}

/// A drive over the places of its road.
fn measured(
    drive: &MeasuredDrive,
    placed: &Placed,
    places: Places,
    rate: Quantity,
    draw: (u64, u64),
) -> Measured {
    let way = &drive.way;
    let energy = drive.energy.as_ref().filter(|energy| energy.0 == rate);
    let rows = Rows {
        time_s: &way.time_s,
        position_m: &placed.position_m,
        speed_mps: &way.speed_mps,
        energy: energy.map_or(&[], |energy| &energy.1),
    };
    let first_m = placed.position_m[0];
    let mut stops = way.standstills();
    for stop in &mut stops {
        stop.position_m = first_m + placed.stretched * stop.position_m;
    }
    let passage = Passage::new(places, &rows, stops);
    Measured { name: drive.name.clone(), passage, part_m: placed.part_m, draw }
}

/// Parts of a road that come from the drive with this fingerprint.
fn circular(road: &GivenCycle, fingerprint: &str) -> Vec<&'static str> {
    if road.source_log.as_deref() != Some(fingerprint) {
        return Vec::new();
    }
    let limits = road.limit_source.as_deref() == Some("estimated");
    let stops = road.events.iter().any(|event| event.kind.standstill_s().is_some());
    [(limits, "limits"), (stops, "stops")].into_iter().filter(|(is, _)| *is).map(|w| w.1).collect()
}

impl ValidatedRoad {
    fn new(group: &Group, ensemble: &Ensemble, drives: Vec<(String, Vec<f64>)>) -> Self {
        let (places, bands_mps) = (ensemble.places(), ensemble.bands());
        let position_m: Vec<f64> = (0..places.count).map(|place| places.at(place)).collect();
        let level = |k: usize| bands_mps.iter().map(|levels| levels[k]).collect::<Vec<f64>>();
        let [p5_mps, p25_mps, p50_mps, p75_mps, p95_mps] = [0, 1, 2, 3, 4].map(level);
        let picture = RoadPicture {
            name: group.name.clone(),
            position_m: position_m.clone(),
            bands_mps,
            limits_mps: group.cycle.limits.clone(),
            drives: drives.clone(),
        };
        Self {
            name: group.name.clone(),
            length_m: group.cycle.length_m,
            limit_source: group.cycle.limit_source.clone(),
            completed: ensemble.size(),
            limit_mps: position_m.iter().map(|at_m| picture.limit_mps(*at_m)).collect(),
            position_m,
            p5_mps,
            p25_mps,
            p50_mps,
            p75_mps,
            p95_mps,
            measured_mps: drives,
            picture,
        }
    }
}
