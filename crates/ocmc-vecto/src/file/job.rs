//! A job: which vehicle, engine, gearbox and driver.

use super::driver::{Coasting, OverSpeedEcoRoll, of_job};
use super::engine::EngineFile;
use super::error::VectoError;
use super::gearbox::GearboxFile;
use super::kind;
use super::part::{Part, beside, read};
use super::vehicle::VehicleFile;
use crate::driver::VectoDriver;
use ocmc_io::study::{ForeignVehicle, VehicleReader};
use serde::Deserialize;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Reads the trucks of jobs as vehicles of studies.
pub const VEHICLES: VehicleReader = VehicleReader(|path| {
    let is_job = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("vecto"));
    is_job.then(|| truck(path).map_err(|error| error.to_string()))
});

/// The truck of a job; what a job does not say is that of a built-in vehicle.
fn truck(path: &Path) -> Result<ForeignVehicle, VectoError> {
    let job = Job::read(path)?;
    // beside a result the auxiliaries are those of the result
    let of_auxiliaries =
        job.of_auxiliaries.iter().map(|note| format!("`{}`: {note}", path.display()));
    let notes = job.notes.iter().cloned().chain(of_auxiliaries).collect();
    Ok(ForeignVehicle { keys: job.vehicle_keys()?, base: job.base_vehicle(), notes })
}

/// Power that holds instead of auxiliaries by technology.
const AUXILIARIES: &str = "the power of the auxiliaries is that of the built-in vehicle of its \
                           kind, unless `vehicle.auxiliary_power_w` is set";

/// A `.vecto` file with the files that it names.
#[derive(Clone, Debug)]
pub struct Job {
    path: PathBuf,
    vehicle: (PathBuf, VehicleFile),
    engine: (PathBuf, EngineFile),
    gearbox: (PathBuf, GearboxFile),
    driver: VectoDriver,
    auxiliary_w: Option<f64>,
    notes: Vec<String>,
    of_auxiliaries: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct JobBody {
    vehicle_file: String,
    engine_file: String,
    gearbox_file: String,
    #[serde(rename = "VACC", default)]
    pub(super) vacc: String,
    /// Jobs of VECTO 3's declaration mode do not write this: it is declared.
    #[serde(rename = "LAC")]
    pub(super) lac: Option<Coasting>,
    pub(super) over_speed_eco_roll: Option<OverSpeedEcoRoll>,
    /// Power of the auxiliaries in engineering mode, in W.
    padd: Option<f64>,
    #[serde(default)]
    auxiliary_assembly: String,
}

impl JobBody {
    /// Auxiliaries that are not used.
    fn of_auxiliaries(&self, is_engineering: bool) -> Option<String> {
        let kind = &self.auxiliary_assembly;
        if !["", "classic"].contains(&kind.to_lowercase().as_str()) {
            return Some(format!("`AuxiliaryAssembly` `{kind}`: {AUXILIARIES}"));
        }
        (self.padd.is_none() && is_engineering).then(|| format!("no `Padd`: {AUXILIARIES}"))
    }
}

impl Job {
    /// Reads a job.
    ///
    /// # Errors
    /// [`VectoError`] names the file, what is wrong, and what is allowed.
    pub fn read(path: &Path) -> Result<Self, VectoError> {
        let part = Part::read(path)?;
        kind::check(&part)?;
        let body: JobBody = part.keys()?;
        let vehicle = beside(path, &body.vehicle_file)?;
        let engine = beside(path, &body.engine_file)?;
        let gearbox = beside(path, &body.gearbox_file)?;
        let gears: GearboxFile = read(&gearbox)?;
        gears.check(&gearbox)?;
        let truck = VehicleFile::read(&vehicle)?;
        let motor: EngineFile = read(&engine)?;
        motor.check(&engine)?;
        let is_engineering = truck.gross_mass_kg().is_some();
        let of_parts = [
            (path, body.lac.as_ref().map(Coasting::notes).unwrap_or_default()),
            (&*vehicle, truck.notes()),
            (&*engine, motor.notes()),
            (&*gearbox, gears.notes()),
        ];
        let named = |(path, notes): (&Path, Vec<String>)| {
            let named = move |note| format!("`{}`: {note}", path.display());
            notes.into_iter().map(named).collect::<Vec<String>>()
        };
        Ok(Self {
            path: path.to_owned(),
            driver: gears.shifts(of_job(&body, path)?, &gearbox)?,
            auxiliary_w: body.padd.filter(|_| is_engineering),
            of_auxiliaries: body.of_auxiliaries(is_engineering),
            notes: of_parts.into_iter().flat_map(named).collect(),
            vehicle: (vehicle, truck),
            engine: (engine, motor),
            gearbox: (gearbox, gears),
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// How it is driven.
    pub fn driver(&self) -> &VectoDriver {
        &self.driver
    }

    /// Values of its files that are not used, for people.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Mass with its load, in kg; none in declaration mode, where the mission gives it.
    pub fn gross_mass_kg(&self) -> Option<f64> {
        self.vehicle.1.gross_mass_kg()
    }

    /// Its truck as keys of a study's vehicle, to be laid over [`Job::base_vehicle`].
    ///
    /// # Errors
    /// [`VectoError`] where a file that it names cannot be used.
    pub fn vehicle_keys(&self) -> Result<Value, VectoError> {
        let mut keys = self.vehicle.1.keys(&self.vehicle.0)?;
        let combustion = &mut keys["powertrain"]["combustion"];
        combustion["engine"] = self.engine.1.keys(&self.engine.0)?;
        let most_nm = self.engine.1.peak_torque_nm(&self.engine.0)?;
        combustion["gearbox"] = self.gearbox.1.keys(&self.gearbox.0, most_nm)?;
        if let Some((path, ratio)) = self.vehicle.1.retarder(&self.vehicle.0)? {
            super::gearbox::add_retarder(&mut combustion["gearbox"], &path, ratio)?;
        }
        if let Some(auxiliary_w) = self.auxiliary_w {
            keys["auxiliary_power_w"] = auxiliary_w.into();
        }
        Ok(keys)
    }

    /// The built-in vehicle that has what a job does not say: brakes and a strategy of shifting.
    pub fn base_vehicle(&self) -> &'static str {
        self.vehicle.1.base_vehicle()
    }
}
