//! The truck that is compared: of a job or built in, with its load, in VECTO's air.

use super::VectoRequest;
use super::error::ComparisonError;
use super::terms::Terms;
use crate::file::{Job, Second, Series, VEHICLES};
use ocmc_core::powertrain::combustion::CombustionPowertrain;
use ocmc_core::powertrain::{Powertrain, ShiftConvention, TruckInputs};
use ocmc_core::prescribed::{Body, CycleStep, DriveCycle, follow};
use ocmc_core::study::Scenario;
use ocmc_io::study::{Files, Given, LoadedStudy, StudyFileError, open};
use serde_json::json;
use std::path::PathBuf;

/// Density of VECTO's air, in kg/m³ [F: VECTO user manual].
pub(super) const AIR_DENSITY_KGPM3: f64 = 1.188;
/// Wind over whose directions VECTO takes the mean, in m/s [F: VECTO 2.2, declaration mode].
const WIND_MPS: f64 = 3.0;

/// Speed up to which VECTO's clutch slips, as a share of the way from the idle speed to that of the
/// highest power [F: VECTO 2.2].
const SLIPS: f64 = 0.03;

/// Where the truck comes from.
#[derive(Clone, Debug)]
pub enum VectoTruck {
    /// A `.vecto` file.
    Job(PathBuf),
    /// A built-in vehicle, or a file of one.
    Vehicle(String),
}

impl VectoTruck {
    /// Truck by its name: `.vecto` is a job, all else a vehicle of ours.
    pub fn named(name: &str) -> Self {
        let path = PathBuf::from(name);
        let is_job = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("vecto"));
        if is_job { Self::Job(path) } else { Self::Vehicle(name.to_owned()) }
    }

    pub(super) fn job(&self) -> Result<Option<Job>, ComparisonError> {
        match self {
            Self::Job(path) => Ok(Some(Job::read(path)?)),
            Self::Vehicle(_) => Ok(None),
        }
    }

    fn base(&self) -> String {
        match self {
            // a study's files lie beside it, and this one lies nowhere
            Self::Job(path) => {
                std::path::absolute(path).unwrap_or(path.clone()).display().to_string()
            }
            Self::Vehicle(name) => name.clone(),
        }
    }
}

/// A truck, ready to be driven.
#[derive(Clone, Debug)]
pub(super) struct ComparedTruck {
    pub(super) loaded: LoadedStudy,
    scenario: Scenario,
    pub(super) body: Body,
    auxiliary_w: f64,
}

impl ComparedTruck {
    /// With this mass, load included, and this power of auxiliaries.
    pub(super) fn new(
        request: &VectoRequest,
        gross_mass_kg: f64,
        auxiliary_w: f64,
    ) -> Result<Self, ComparisonError> {
        let study = json!({
            "study": {
                "name": "vecto", "base": "field-truck",
                "description": "One truck and one driver in VECTO's air",
            },
            "vehicle": { "base": request.truck.base() },
        });
        let without = "simulation.without=[\"traffic\", \"driver_spread\", \"vehicle_spread\", \
                       \"weather\"]"
            .to_owned();
        let auxiliary = format!("vehicle.auxiliary_power_w={auxiliary_w}");
        let mut sets = [vec![without, auxiliary], request.sets.clone()].concat();
        let curb_kg = load_json(&study, &sets, &request.files)?.model.vehicle.curb_mass_kg;
        let payload_kg = gross_mass_kg - curb_kg;
        if payload_kg < -0.5 {
            return Err(ComparisonError::TooLight { gross_mass_kg, curb_kg });
        }
        sets.push(format!("mission.payload_kg={}", payload_kg.max(0.0)));
        let loaded = load_json(&study, &sets, &request.files)?;
        // VECTO's clutch slips in all gears, a little above the idle speed
        if let Some(combustion) = loaded.study.vehicle().powertrain.combustion() {
            let idle_radps = combustion.engine_model.idle_speed_radps;
            let slips_radps = idle_radps + SLIPS * (combustion.rated_speed_radps() - idle_radps);
            let shift = "vehicle.powertrain.combustion.gearbox.shift";
            sets.push(format!("{shift}.launch_gears={}", combustion.gears.len()));
            sets.push(format!("{shift}.launch_speed_radps={slips_radps}"));
        }
        let loaded = load_json(&study, &sets, &request.files)?;
        let scenario = loaded.study.sample(1, 0);
        let model = &loaded.model.vehicle;
        let (drag_area_m2, by_speed) =
            model.cross_wind.mean_over_directions(scenario.vehicle.drag_area_m2, WIND_MPS);
        let body = Body {
            drag_area_m2,
            drag_by_speed: by_speed.prepare(),
            rolling_coefficient: scenario.vehicle.rolling_coefficient,
            air_density_kgpm3: AIR_DENSITY_KGPM3,
            ..Body::of(&loaded.study, &scenario)
        };
        Ok(Self { loaded, scenario, body, auxiliary_w })
    }

    /// Its powertrain.
    pub(super) fn combustion(&self) -> Result<&CombustionPowertrain, ComparisonError> {
        let powertrain = &self.loaded.study.vehicle().powertrain;
        powertrain.combustion().ok_or(ComparisonError::WithoutEngine)
    }

    /// Fuel of our map at the speeds and torques of the engine of a series, in kg.
    pub(super) fn fuel_kg(&self, series: &Series) -> Result<f64, ComparisonError> {
        let engine = &self.combustion()?.engine;
        let burnt = |second: &Second| {
            engine.fuel_kgps(second.engine_radps, second.engine_w / second.engine_radps)
        };
        Ok(series.seconds.iter().map(burnt).sum())
    }

    /// Terms of a cycle that the truck follows.
    pub(super) fn follow(
        &self,
        cycle: &DriveCycle,
        convention: ShiftConvention,
    ) -> Result<Terms, ComparisonError> {
        let combustion = self.combustion()?;
        let inputs = TruckInputs {
            auxiliary_power_w: self.auxiliary_w,
            ..self.scenario.vehicle.powertrain_inputs(0.0)
        };
        let mut inverse = combustion.inverse(&inputs);
        inverse.set_convention(convention);
        let followed = follow(cycle, &self.body, &mut *inverse);
        let heating_jpkg = combustion.engine_model.fuel.heating_value_jpkg;
        let retarder = |step: CycleStep| {
            combustion.retarder_n(step.speed.mean_mps()) * step.speed.distance_m()
        };
        let retarder_j = cycle.steps().map(retarder).sum();
        Ok(Terms::followed(&followed, inverse.n_shifts(), retarder_j, heating_jpkg))
    }

    /// The same truck in a study of VECTO's air, without wind, traffic and roughness.
    pub(super) fn in_vectos_air(
        &self,
        request: &VectoRequest,
    ) -> Result<LoadedStudy, ComparisonError> {
        let model = &self.loaded.model.vehicle;
        let (drag_area_m2, by_speed) =
            model.cross_wind.mean_over_directions(self.scenario.vehicle.drag_area_m2, WIND_MPS);
        let even = json!({
            "roughness": { "mean_coefficient_m3": 7.6e-6, "shape": 0.01 },
            "ground": { "asphalt": 1.0, "concrete": 0.0 },
        });
        let still = json!({
            // 20 °C and 100 kPa dry are 1.188 kg/m³
            "altitude_m": 110.9,
            "temperature": {
                "mean_k": 293.15, "annual_amplitude_k": 0.0, "winter_daily_amplitude_k": 0.0,
                "summer_daily_amplitude_k": 0.0, "winter_sd_k": 0.0, "summer_sd_k": 0.0,
            },
            "pressure": { "sd": 0.0 },
            "humidity": {
                "mean_logit": -10.0, "annual_amplitude": 0.0, "daily_amplitude": 0.0, "sd": 0.0,
            },
            "precipitation": { "wet_after_dry": 0.0 },
            "wind": { "mean_speed_mps": 0.0 },
        });
        let study = json!({
            "study": {
                "name": "vecto", "base": "field-truck",
                "description": "One truck and the typical driver in VECTO's air",
            },
            "vehicle": {
                "base": request.truck.base(),
                "drag_area_m2": drag_area_m2,
                "drag_by_speed": by_speed,
                "rolling_temperature_coefficient_per_k": 0.0,
                "auxiliary_power_w": self.auxiliary_w,
            },
            "mission": { "payload_kg": self.scenario.cycle.mission.payload_kg },
            "weather": still,
            "road": { "types": { "urban": even, "rural": even, "motorway": even } },
            "simulation": { "without": ["traffic", "driver_spread", "vehicle_spread"] },
        });
        Ok(load_json(&study, &request.sets, &request.files)?)
    }
}

fn load_json(
    study: &serde_json::Value,
    sets: &[String],
    files: &Files,
) -> Result<LoadedStudy, StudyFileError> {
    open(&Given::Dictionary(study), &files.reading(VEHICLES), sets)
}
