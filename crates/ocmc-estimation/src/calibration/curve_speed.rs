//! The law of curve speeds behind a measured table of curves (indirect inference).
//!
//! The regression of measured curve speeds ([`curve_speed::fit`]) is an auxiliary model: its v₀, δ,
//! SD between drivers and residual SD also hold what signs, stops, traffic and neighbouring bends
//! did. The law of a study says what a driver wants where nothing else slows him. Its four numbers
//! are moved until the curves of simulated trips, detected and fitted as the measured ones were,
//! give the measured four: indirect inference (Gouriéroux, Monfort, Renault, Journal of Applied
//! Econometrics 8, 1993), with the root finder of [`super::root`] and the same random numbers at
//! every point. Standard errors come by the delta method from those of the table and from the
//! simulation's own, by leaving out groups of drivers (jackknife).
//!
//! A table may be out of reach: where the surroundings alone scatter more than it does, no law
//! brings the residual down to it. Then the law's residual stays at its floor and the answer says
//! what of the study makes the rest.

use super::delta_method::{correlation, delta_covariance};
use super::root::{Root, Search, derivatives, solve};
use super::simulated::watched_curves;
use crate::fit::curve_speed::{
    self, CurveSpeedFit, CurveSpeedFitError, CurveSpeedOptions, CurveTable,
};
use crate::log::curve::CurveOptions;
use crate::option_check::{OptionError, above_0, check_options};
use nalgebra::Matrix4;
use ocmc_core::driver::curve_speed::{CurveSpeedForm, CurveSpeedModel};
use ocmc_core::study::Study;
use ocmc_core::switch::ModelSwitch;
use serde::Serialize;
use std::ops::ControlFlow;
use thiserror::Error;

pub use super::simulated::{Trips, simulated_curves};

/// Numbers of the law.
pub const COUNT: usize = 4;
/// Their names, as the study has them.
pub const NAMES: [&str; COUNT] = ["reference_speed_mps", "exponent", "driver_sd", "residual_sd"];
/// Longest step of a simulated log, in s: detection asks for 5 Hz.
const LOG_STEP_S: f64 = 0.2;
/// Groups of drivers, one of which is left out at a time.
const GROUPS: usize = 20;
/// The first sample's share of all trips.
const FIRST_SHARE: u64 = 4;
/// Least drivers of a sample.
const LEAST_DRIVERS: u64 = 20;
/// Tolerance: ln v₀, δ and the two variances (0.001 of an SD of 0.06 and of 0.25).
const TOLERANCE: [f64; COUNT] = [0.002, 0.002, 0.00012, 0.0005];
/// Steps of the derivatives, in ln v₀, δ and the variances (of SDs of 0.07 and 0.16).
const STEP: [f64; COUNT] = [0.04, 0.04, 0.005, 0.025];
/// Least SD at which a variance's error is one of the SD.
const LEAST_SD: f64 = 1e-3;
/// Bounds of v₀, in m/s: those of a study.
const SPEEDS_MPS: [f64; 2] = [3.0, 60.0];

/// The four numbers of a table or of a law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CurveSpeedNumbers {
    /// Speed v₀ at the reference radius, in m/s.
    pub reference_speed_mps: f64,
    /// Exponent δ.
    pub exponent: f64,
    /// SD between drivers, of ln v.
    pub driver_sd: f64,
    /// SD of the residual, of ln v.
    pub residual_sd: f64,
}

/// A measured table, with the standard errors of its numbers; that of v₀ is of ln v₀.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasuredCurves {
    /// The numbers.
    pub numbers: CurveSpeedNumbers,
    /// Covariance of ln v₀, δ and the variances of drivers and residual.
    #[serde(skip)]
    covariance: Matrix4<f64>,
    /// Standard errors of ln v₀, δ and the SDs.
    pub standard_errors: [f64; COUNT],
}

/// How a law is calibrated.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationOptions {
    /// The trips.
    pub trips: Trips,
    /// How curves are found.
    pub detection: CurveOptions,
    /// Curves that count.
    pub fit: CurveSpeedOptions,
    /// Smallest residual SD that the law may have: 4.8 % of the paper's simulator, where nothing
    /// but the bend changed a driver's speed.
    pub least_residual_sd: f64,
}

impl Default for CalibrationOptions {
    fn default() -> Self {
        Self {
            trips: Trips { seed: 1, drivers: 240, per_driver: 1, threads: 0 },
            detection: CurveOptions::default(),
            fit: CurveSpeedOptions::default(),
            least_residual_sd: 0.048,
        }
    }
}

/// Why there is no calibration.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CalibrationError {
    /// An option out of its range.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// The measured curves have no fit.
    #[error("the measured curves: {0}")]
    Measured(CurveSpeedFitError),
    /// One driver was measured.
    #[error(
        "one driver was measured, so that nothing is known about how drivers differ; allowed are \
         two or more"
    )]
    OneDriver,
    /// The simulated curves have no fit.
    #[error("the simulated curves of this study: {0}; more trips may help")]
    Simulated(CurveSpeedFitError),
    /// A study that takes its law from a table of trucks.
    #[error(
        "the law is drawn from a table of trucks; allowed are studies with form = \"pooled\" or \
         \"calibrated\""
    )]
    Form,
    /// The law does not fit the study.
    #[error("the study does not take a law of the search: {0}")]
    Study(String),
    /// It was ended.
    #[error("ended")]
    Ended,
}

/// Sources of the scatter of simulated curves beside the law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Surroundings {
    /// Parts that are turned off, as in `simulation.without`.
    pub without: Vec<ModelSwitch>,
    /// The numbers then, with the calibrated law.
    pub numbers: CurveSpeedNumbers,
}

/// A calibrated law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CurveSpeedCalibration {
    /// The measured table.
    pub measured: MeasuredCurves,
    /// Numbers that the study's original law gives.
    pub before: CurveSpeedNumbers,
    /// The law that the search ended at.
    pub law: CurveSpeedNumbers,
    /// Standard errors of the law: of ln v₀, δ and the SDs; 0 where a number stays on a bound.
    pub standard_errors: [f64; COUNT],
    /// Correlation of the errors of the law.
    pub error_correlation: [[f64; COUNT]; COUNT],
    /// Numbers that this law gives.
    pub simulated: CurveSpeedNumbers,
    /// Numbers of the law that stay on a bound: the table is out of reach in them.
    pub at_bound: Vec<&'static str>,
    /// Whether the others of the table are met.
    pub solved: bool,
    /// Curves of the last sample.
    pub curves: usize,
    /// Drivers and trips of each.
    pub drivers: u64,
    /// Trips of each driver.
    pub trips_per_driver: u64,
    /// Times that the study was driven.
    pub evaluations: usize,
    /// Numbers of the same law with parts of the study turned off.
    pub surroundings: Vec<Surroundings>,
}

impl CurveSpeedNumbers {
    /// Numbers of a law as it is written.
    pub fn of_law(law: &CurveSpeedModel) -> Self {
        Self {
            reference_speed_mps: law.reference_speed_mps,
            exponent: law.exponent,
            driver_sd: law.driver_sd,
            residual_sd: law.residual_sd,
        }
    }

    /// Numbers of a fit; none with one driver.
    fn of_fit(fit: &CurveSpeedFit) -> Option<Self> {
        let reml = fit.random_intercept.as_ref().map(|drivers| drivers.driver_sd);
        Some(Self {
            reference_speed_mps: fit.estimated.reference_speed_mps,
            exponent: fit.estimated.exponent,
            driver_sd: reml.or(fit.estimated.driver_sd)?,
            residual_sd: fit.estimated.residual_sd,
        })
    }

    /// (ln v₀, δ, driver variance, residual variance): variances add up, so that those of a table
    /// are nearly linear in those of the law.
    fn coordinates(&self) -> [f64; COUNT] {
        let Self { driver_sd, residual_sd, .. } = self;
        let log_speed = libm::log(self.reference_speed_mps);
        [log_speed, self.exponent, driver_sd * driver_sd, residual_sd * residual_sd]
    }

    fn from_coordinates([log_speed, exponent, driver, residual]: [f64; COUNT]) -> Self {
        let [driver_sd, residual_sd] = [driver, residual].map(|square| square.max(0.0).sqrt());
        // a bound of the search, by its logarithm, is not exactly that of a study
        let [slowest_mps, fastest_mps] = SPEEDS_MPS;
        let reference_speed_mps = libm::exp(log_speed).clamp(slowest_mps, fastest_mps);
        Self { reference_speed_mps, exponent, driver_sd, residual_sd }
    }

    /// Errors of (ln v₀, δ, driver SD, residual SD) from the covariance of the coordinates.
    fn errors(&self, covariance: &Matrix4<f64>) -> [f64; COUNT] {
        let slopes = self.slopes();
        std::array::from_fn(|k| covariance[(k, k)].max(0.0).sqrt() / slopes[k])
    }

    /// Derivatives of the coordinates by (ln v₀, δ, driver SD, residual SD).
    fn slopes(&self) -> [f64; COUNT] {
        let [driver, residual] =
            [self.driver_sd, self.residual_sd].map(|sd| 2.0 * sd.max(LEAST_SD));
        [1.0, 1.0, driver, residual]
    }
}

impl MeasuredCurves {
    /// A table whose numbers are known with independent standard errors.
    pub fn stated(numbers: CurveSpeedNumbers, standard_errors: [f64; COUNT]) -> Self {
        let slopes = numbers.slopes();
        let covariance = Matrix4::from_fn(|i, k| {
            let error = if i == k { slopes[k] * standard_errors[k] } else { 0.0 };
            error * error
        });
        Self { numbers, covariance, standard_errors }
    }

    /// Measured curves of some drivers.
    ///
    /// # Errors
    /// [`CalibrationError::Measured`] where the curves have no fit,
    /// [`CalibrationError::OneDriver`].
    pub fn of_curves(
        table: &CurveTable,
        options: &CurveSpeedOptions,
    ) -> Result<Self, CalibrationError> {
        let fit = curve_speed::fit(table, options).map_err(CalibrationError::Measured)?;
        let numbers = CurveSpeedNumbers::of_fit(&fit).ok_or(CalibrationError::OneDriver)?;
        let covariance = jackknife(table, options);
        Ok(Self { numbers, covariance, standard_errors: numbers.errors(&covariance) })
    }

    /// The numbers that a study's law was printed with, their errors as far as it states them:
    /// those of ln v₀ and δ, and that of the SD between as many trucks as its table has.
    ///
    /// # Errors
    /// [`CalibrationError::Form`] where drivers are drawn from a table of trucks.
    pub fn of_law(law: &CurveSpeedModel) -> Result<Self, CalibrationError> {
        if !law.form.is_one_law() {
            return Err(CalibrationError::Form);
        }
        let trucks = law.table.as_ref().map_or(0, |table| table.truck.len());
        let driver_error =
            if trucks > 1 { law.driver_sd / (2.0 * (trucks as f64 - 1.0)).sqrt() } else { 0.0 };
        let errors = [
            law.reference_speed_log_standard_error,
            law.exponent_standard_error,
            driver_error,
            0.0,
        ];
        Ok(Self::stated(CurveSpeedNumbers::of_law(law), errors))
    }
}

/// Finds the law with which a study gives a measured table back. `look` is asked several times a
/// second, with the number of times that the study was driven.
///
/// # Errors
/// [`CalibrationError`].
pub fn calibrate(
    measured: &MeasuredCurves,
    study: &Study,
    options: &CalibrationOptions,
    look: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<CurveSpeedCalibration, CalibrationError> {
    check(options)?;
    let law = &study.model().driver.curve_speed;
    if !law.form.is_one_law() {
        return Err(CalibrationError::Form);
    }
    let wanted = measured.numbers.coordinates();
    let mut driven = Driven { study, options, evaluations: 0, look };
    let small = Trips {
        drivers: (options.trips.drivers / FIRST_SHARE)
            .max(LEAST_DRIVERS)
            .min(options.trips.drivers),
        ..options.trips
    };
    let away = |simulated: [f64; COUNT]| std::array::from_fn(|k| simulated[k] - wanted[k]);
    let floor = options.least_residual_sd;
    let search = Search {
        lower: [libm::log(SPEEDS_MPS[0]), 0.0, 0.0, floor * floor],
        upper: [libm::log(SPEEDS_MPS[1]), 1.0, 1.0, 1.0],
        step: STEP,
        tolerance: TOLERANCE,
    };
    let start: [f64; COUNT] = {
        let at = wanted;
        std::array::from_fn(|k| at[k].max(search.lower[k]).min(search.upper[k]))
    };
    let mut near = |point: &[f64; COUNT]| driven.numbers(point, &small).map(away);
    let value = near(&start)?;
    let jacobian = derivatives(&mut near, &search, &start, &value)?;
    let Root { point, .. } = solve(&mut near, &search, &start, &jacobian)?;
    let mut far = |point: &[f64; COUNT]| driven.numbers(point, &options.trips).map(away);
    let value = far(&point)?;
    let jacobian = derivatives(&mut far, &search, &point, &value)?;
    let root = solve(&mut far, &search, &point, &jacobian)?;
    driven.answer(measured, &root, &jacobian)
}

fn check(options: &CalibrationOptions) -> Result<(), OptionError> {
    let Trips { drivers, per_driver, .. } = options.trips;
    let floor = options.least_residual_sd;
    check_options([
        above_0("the reference radius", options.fit.reference_radius_m),
        ("the number of drivers", drivers as f64, "a number from 20 on", drivers >= LEAST_DRIVERS),
        (
            "the number of trips of a driver",
            per_driver as f64,
            "a number from 1 on",
            per_driver >= 1,
        ),
        ("the smallest residual SD", floor, "a number from 0 to 1", (0.0..=1.0).contains(&floor)),
    ])
}

/// A study that is driven again and again with other laws.
struct Driven<'a> {
    study: &'a Study,
    options: &'a CalibrationOptions,
    evaluations: usize,
    look: &'a mut dyn FnMut(usize) -> ControlFlow<()>,
}

impl Driven<'_> {
    /// The curves of a law, with parts of the study turned off.
    fn curves(
        &mut self,
        law: &CurveSpeedNumbers,
        trips: &Trips,
        without: &[ModelSwitch],
    ) -> Result<CurveTable, CalibrationError> {
        let mut model = self.study.model().clone();
        let own = &mut model.driver.curve_speed;
        own.form = CurveSpeedForm::Pooled;
        own.parameter_uncertainty = false;
        own.reference_speed_mps = law.reference_speed_mps;
        own.exponent = law.exponent;
        own.driver_sd = law.driver_sd;
        own.residual_sd = law.residual_sd;
        model.simulation.step_s = model.simulation.step_s.min(LOG_STEP_S);
        model.simulation.without.extend_from_slice(without);
        let study = self
            .study
            .with_model(model)
            .map_err(|error| CalibrationError::Study(error.to_string()))?;
        let Self { look, options, evaluations, .. } = self;
        let curves = watched_curves(&study, trips, &options.detection, || look(*evaluations));
        self.evaluations += 1;
        match curves {
            ControlFlow::Continue(curves) => Ok(curves),
            ControlFlow::Break(()) => Err(CalibrationError::Ended),
        }
    }

    fn fitted(&self, curves: &CurveTable) -> Result<CurveSpeedNumbers, CalibrationError> {
        let fit =
            curve_speed::fit(curves, &self.options.fit).map_err(CalibrationError::Simulated)?;
        CurveSpeedNumbers::of_fit(&fit).ok_or(CalibrationError::OneDriver)
    }

    /// The numbers of a point.
    fn numbers(
        &mut self,
        point: &[f64; COUNT],
        trips: &Trips,
    ) -> Result<[f64; COUNT], CalibrationError> {
        let curves = self.curves(&CurveSpeedNumbers::from_coordinates(*point), trips, &[])?;
        Ok(self.fitted(&curves)?.coordinates())
    }

    fn answer(
        &mut self,
        measured: &MeasuredCurves,
        root: &Root<COUNT>,
        jacobian: &Matrix4<f64>,
    ) -> Result<CurveSpeedCalibration, CalibrationError> {
        let (trips, fit) = (self.options.trips, &self.options.fit);
        let law = CurveSpeedNumbers::from_coordinates(root.point);
        let curves = self.curves(&law, &trips, &[])?;
        let simulated = self.fitted(&curves)?;
        let covariance = measured.covariance + jackknife(&curves, fit);
        let errors = delta_covariance(jacobian, &covariance, root.at_bound);
        let before = CurveSpeedNumbers::of_law(&self.study.model().driver.curve_speed);
        let before = self.numbers(&before.coordinates(), &trips)?;
        let mut surroundings = Vec::new();
        for without in parts() {
            let curves = self.curves(&law, &trips, &without)?;
            surroundings.push(Surroundings { without, numbers: self.fitted(&curves)? });
        }
        let named = NAMES.iter().zip(root.at_bound).filter(|(_, bound)| *bound);
        Ok(CurveSpeedCalibration {
            measured: measured.clone(),
            before: CurveSpeedNumbers::from_coordinates(before),
            law,
            standard_errors: law.errors(&errors),
            error_correlation: correlation(&errors),
            simulated,
            at_bound: named.map(|(name, _)| *name).collect(),
            solved: root.solved,
            curves: curves.driver.len(),
            drivers: trips.drivers,
            trips_per_driver: trips.per_driver,
            evaluations: self.evaluations,
            surroundings,
        })
    }
}

/// Parts that are turned off to see their effect: traffic, what stops or slows at one place, both,
/// and the signs, too.
fn parts() -> [Vec<ModelSwitch>; 4] {
    let traffic = vec![ModelSwitch::Traffic];
    let events = vec![
        ModelSwitch::StopSigns,
        ModelSwitch::GiveWays,
        ModelSwitch::TrafficLights,
        ModelSwitch::SpeedBumps,
        ModelSwitch::RailwayCrossings,
    ];
    let both = [&traffic[..], &events[..]].concat();
    let signs = [&both[..], &[ModelSwitch::Signs]].concat();
    [traffic, events, both, signs]
}

/// Covariance of the coordinates of a table, by leaving out groups of its drivers.
fn jackknife(table: &CurveTable, options: &CurveSpeedOptions) -> Matrix4<f64> {
    let mut names: Vec<&String> = table.driver.iter().collect();
    names.sort();
    names.dedup();
    let groups = GROUPS.min(names.len());
    let points: Vec<[f64; COUNT]> = (0..groups)
        .filter_map(|group| {
            let stays = |row: usize| {
                names.binary_search(&&table.driver[row]).is_ok_and(|place| place % groups != group)
            };
            let fit = curve_speed::fit(&rows_of(table, stays), options).ok()?;
            Some(CurveSpeedNumbers::of_fit(&fit)?.coordinates())
        })
        .collect();
    let n = points.len() as f64;
    if points.len() < 2 {
        return Matrix4::zeros();
    }
    let mean: [f64; COUNT] =
        std::array::from_fn(|k| points.iter().map(|point| point[k]).sum::<f64>() / n);
    Matrix4::from_fn(|i, j| {
        let products = points.iter().map(|point| (point[i] - mean[i]) * (point[j] - mean[j]));
        (n - 1.0) / n * products.sum::<f64>()
    })
}

/// Some rows of a table.
fn rows_of(table: &CurveTable, stays: impl Fn(usize) -> bool) -> CurveTable {
    let rows: Vec<usize> = (0..table.driver.len()).filter(|row| stays(*row)).collect();
    let numbers = |column: &[f64]| rows.iter().map(|row| column[*row]).collect::<Vec<f64>>();
    CurveTable {
        driver: rows.iter().map(|row| table.driver[*row].clone()).collect(),
        radius_m: numbers(&table.radius_m),
        speed_mps: numbers(&table.speed_mps),
        left: table.left.as_ref().map(|left| rows.iter().map(|row| left[*row]).collect()),
        route_m: table.route_m.as_deref().map(numbers),
        limit_mps: table.limit_mps.as_deref().map(numbers),
        acceleration_mps2: table.acceleration_mps2.as_deref().map(numbers),
        around: table.around.as_ref().map(|around| rows.iter().map(|row| around[*row]).collect()),
    }
}

impl CurveSpeedCalibration {
    /// The law as a study has it; what a table of curves does not tell stays that of `model`.
    pub fn population(&self, model: &CurveSpeedModel) -> CurveSpeedModel {
        let [log_error, exponent_error, _, _] = self.standard_errors;
        CurveSpeedModel {
            form: CurveSpeedForm::Calibrated,
            reference_speed_mps: self.law.reference_speed_mps,
            exponent: self.law.exponent,
            exponent_standard_error: exponent_error,
            reference_speed_log_standard_error: log_error,
            error_correlation: self.error_correlation[0][1],
            parameter_uncertainty: true,
            driver_sd: self.law.driver_sd,
            residual_sd: self.law.residual_sd,
            ..model.clone()
        }
    }
}
