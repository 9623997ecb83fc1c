//! A job: which vehicle, engine, gearbox and driver.

use super::driver::{Coasting, OverSpeedEcoRoll, of_job};
use super::error::VectoError;
use super::gearbox::GearboxFile;
use super::part::{beside, read};
use super::vehicle::{EngineFile, VehicleFile};
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
    Ok(ForeignVehicle { keys: job.vehicle_keys()?, base: job.base_vehicle(), notes: Vec::new() })
}

/// A `.vecto` file with the files that it names.
#[derive(Clone, Debug)]
pub struct Job {
    path: PathBuf,
    vehicle: (PathBuf, VehicleFile),
    engine: (PathBuf, EngineFile),
    gearbox: (PathBuf, GearboxFile),
    driver: VectoDriver,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct JobBody {
    vehicle_file: String,
    engine_file: String,
    gearbox_file: String,
    #[serde(rename = "VACC", default)]
    pub(super) vacc: String,
    #[serde(rename = "LAC")]
    pub(super) lac: Coasting,
    pub(super) over_speed_eco_roll: OverSpeedEcoRoll,
}

impl Job {
    /// Reads a job.
    ///
    /// # Errors
    /// [`VectoError`] names the file, what is wrong, and what is allowed.
    pub fn read(path: &Path) -> Result<Self, VectoError> {
        let body: JobBody = read(path)?;
        let vehicle = beside(path, &body.vehicle_file)?;
        let engine = beside(path, &body.engine_file)?;
        let gearbox = beside(path, &body.gearbox_file)?;
        let gears: GearboxFile = read(&gearbox)?;
        gears.check(&gearbox)?;
        let truck: VehicleFile = read(&vehicle)?;
        truck.check(&vehicle)?;
        Ok(Self {
            path: path.to_owned(),
            driver: gears.shifts(of_job(&body, path)?, &gearbox)?,
            vehicle: (vehicle, truck),
            engine: (engine.clone(), read(&engine)?),
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
        Ok(keys)
    }

    /// The built-in vehicle that has what a job does not say: brakes and a strategy of shifting.
    pub fn base_vehicle(&self) -> &'static str {
        self.vehicle.1.base_vehicle()
    }
}
