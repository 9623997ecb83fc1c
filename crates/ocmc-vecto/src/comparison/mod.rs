//! VECTO's files and results beside what is computed here: on VECTO's own speed, and by drivers.

mod closed_loop;
mod error;
mod matching;
mod on_its_speed;
mod terms;
mod truck;

pub use closed_loop::SpeedMatch;
pub use error::ComparisonError;
pub use terms::{TABLE, TermOf, Terms};
pub use truck::VectoTruck;

use crate::driver::VectoDriver;
use crate::file::{MissionFile, declared_driver};
use matching::{Case, Result as FoundResult};
use ocmc_core::powertrain::ShiftConvention;
use ocmc_io::study::Files;
use serde::Serialize;
use std::path::PathBuf;
use truck::ComparedTruck;

/// Request of a comparison with VECTO.
#[derive(Clone, Debug)]
pub struct VectoRequest {
    /// The truck.
    pub truck: VectoTruck,
    /// Missions (`.vdri`).
    pub missions: Vec<PathBuf>,
    /// Files of VECTO's results (`.vmod`, `.vsum`); those beside the job where none is given.
    pub results: Vec<PathBuf>,
    /// Values of the truck's study that are replaced, each as `KEY=VALUE`.
    pub sets: Vec<String>,
    /// Files that the truck may be or name; those of a job are allowed or refused with them.
    pub files: Files,
}

/// The comparisons.
#[derive(Clone, Debug, Serialize)]
pub struct VectoAnswer {
    /// One for each result.
    pub comparisons: Vec<VectoComparison>,
    /// Values of the files of a job that are not used; absent where there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

/// One result of VECTO, and what is computed here.
#[derive(Clone, Debug, Serialize)]
pub struct VectoComparison {
    /// The mission.
    pub mission: String,
    /// Mass with its load, in kg.
    pub gross_mass_kg: f64,
    /// Power of the auxiliaries, in W.
    pub auxiliary_power_w: f64,
    /// Results of VECTO.
    pub vecto: Terms,
    /// Runs that are computed here.
    pub runs: Vec<VectoRun>,
    /// Difference in the fuel on VECTO's speed with its gears; absent without a time series.
    pub attribution: Option<Attribution>,
}

/// Differences in fuel by cause, as shares of VECTO's fuel: an energy counts as its share of the
/// engine's work.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Attribution {
    /// Against the air.
    pub air: f64,
    /// Against the tyres.
    pub rolling: f64,
    /// In gearbox, axle and retarder.
    pub transmission: f64,
    /// By auxiliaries.
    pub auxiliaries: f64,
    /// By the brakes, which take what the others leave.
    pub brakes: f64,
    /// The map: our fuel at VECTO's speeds and torques of the engine.
    pub engine_map: f64,
    /// Rest: slopes, gaps, idling, and that an energy is not always worth the same.
    pub rest: f64,
    /// Their sum: the difference with VECTO's gears.
    pub with_its_gears: f64,
    /// The choice of gears: the difference with ours less that with VECTO's.
    pub gear_choice: f64,
}

impl Attribution {
    fn new(vecto: &Terms, theirs: &Terms, ours: &Terms, map_fuel_kg: f64) -> Self {
        let engine_j = vecto.engine_j.unwrap_or(f64::NAN);
        let share = |value: fn(&Terms) -> f64| (value(theirs) - value(vecto)) / engine_j;
        let difference = |terms: &Terms| terms.fuel_kg / vecto.fuel_kg - 1.0;
        let [air, rolling] = [share(|t| t.air_j), share(|t| t.rolling_j)];
        let transmission = share(|t| t.transmission_j);
        let [auxiliaries, brakes] = [share(|t| t.auxiliary_j), share(|t| t.brake_j)];
        let engine_map = map_fuel_kg / vecto.fuel_kg - 1.0;
        let with_its_gears = difference(theirs);
        let named = air + rolling + transmission + auxiliaries + brakes + engine_map;
        Self {
            air,
            rolling,
            transmission,
            auxiliaries,
            brakes,
            engine_map,
            rest: with_its_gears - named,
            with_its_gears,
            gear_choice: difference(ours) - with_its_gears,
        }
    }
}

/// The mission as it is computed here.
#[derive(Clone, Debug, Serialize)]
pub struct VectoRun {
    /// How it was driven.
    pub driven: String,
    /// Terms of the run.
    pub terms: Terms,
    /// How its speed lies to VECTO's; absent where it is VECTO's, or not known.
    pub speed: Option<SpeedMatch>,
}

impl VectoRun {
    fn new(driven: &str, terms: Terms) -> Self {
        Self { driven: driven.to_owned(), terms, speed: None }
    }
}

/// Compares.
///
/// # Errors
/// [`ComparisonError`] names a file that cannot be used, and what is allowed.
pub fn vecto(request: &VectoRequest) -> Result<VectoAnswer, ComparisonError> {
    if let (VectoTruck::Job(path), Files::Refused) = (&request.truck, &request.files) {
        return Err(ComparisonError::Refused(path.clone()));
    }
    let job = request.truck.job()?;
    let cases = matching::cases(&request.missions, &request.results, job.as_ref())?;
    let driver = job.as_ref().map_or_else(declared_driver, |job| job.driver().clone());
    let compared = |case: &Case| compare(request, case, &driver);
    let comparisons = cases.iter().map(compared).collect::<Result<_, _>>()?;
    Ok(VectoAnswer { comparisons, notes: job.map_or_else(Vec::new, |job| job.notes().to_vec()) })
}

fn compare(
    request: &VectoRequest,
    case: &Case,
    driver: &VectoDriver,
) -> Result<VectoComparison, ComparisonError> {
    let truck = ComparedTruck::new(request, case.gross_mass_kg, case.auxiliary_w)?;
    let (mut runs, mut attribution, mut its_speed) = (Vec::new(), None, None);
    let vecto = match &case.result {
        FoundResult::Series(path, series) => {
            let cycle = on_its_speed::drive_cycle(path, series)?;
            let theirs = truck.follow(&cycle, ShiftConvention::Returned)?;
            let ours = truck.follow(&cycle.clone().without_gears(), ShiftConvention::Lost)?;
            let vecto = Terms::series(series);
            let map_fuel_kg = truck.fuel_kg(series)?;
            attribution = Some(Attribution::new(&vecto, &theirs, &ours, map_fuel_kg));
            runs.push(VectoRun::new("its speed and gears", theirs));
            runs.push(VectoRun::new("its speed, our gears", ours));
            its_speed = Some(cycle);
            vecto
        }
        FoundResult::Sum(sum) => Terms::sum(sum),
    };
    if let Some(file) = &case.mission_file {
        let mission = MissionFile::read(file)?;
        let (terms, cycle) =
            closed_loop::by_vectos_driver(&truck, &mission, case.auxiliary_w, driver)?;
        let speed = its_speed.map(|vectos| closed_loop::speed_match(&cycle, &vectos));
        runs.push(VectoRun { speed, ..VectoRun::new("its driver", terms) });
        let ours = closed_loop::by_our_driver(request, &truck, file, &mission)?;
        runs.extend(ours.map(|terms| VectoRun::new("our driver", terms)));
    }
    Ok(VectoComparison {
        mission: case.mission.clone(),
        gross_mass_kg: case.gross_mass_kg,
        auxiliary_power_w: case.auxiliary_w,
        vecto,
        runs,
        attribution,
    })
}
