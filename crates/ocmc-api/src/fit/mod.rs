//! From measurements to the numbers of a study.

mod calibrate;
mod fleet;
mod text;

use crate::answer::Answer;
use crate::cycle::RealisedCycle;
use crate::error::{Error, FitError};
use crate::source::{Mapping, Source, read_at_once};
use crate::watch::{Progress, Watch};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::study::StudyModel;
use ocmc_estimation::fit::curve_speed::CurveSpeedFit;
use ocmc_estimation::fit::operating_cycle::{RoadFit, fit_with_coverage};
use ocmc_estimation::fit::speed_change::{SpeedChangeFit, SpeedChangeTable};
use ocmc_estimation::fit::study_parameter::StudyParameterFit;
use ocmc_estimation::fit::traffic::TrafficFit;
use ocmc_estimation::fit::weather::WeatherFit;
use ocmc_estimation::fit::{curve_speed, speed_change, traffic, weather};
use ocmc_io::intake::FileAccount;
use ocmc_io::log::curves::Steering;
use ocmc_io::log::roads::{FoundRoads, is_log};
use ocmc_io::study::{Estimate, FittedPart};
use ocmc_io::{curve_table, given_cycle, speed_change_table, traffic_table, weather_table};
use serde::Serialize;
use serde_json::Value;
use std::path::Path;

pub use calibrate::{CalibrateCurveSpeedRequest, MeasuredTable, calibrate_curve_speed};
pub use fleet::{FleetAnswer, FleetRequest, fit_fleet};
pub use ocmc_estimation::calibration::curve_speed::{
    CalibrationOptions, CurveSpeedCalibration, Trips,
};
pub use ocmc_estimation::fit::curve_speed::{Coding, CurveSpeedOptions};
pub use ocmc_estimation::fit::fleet::{Best, FleetOptions, MOST_DRAWS, MOST_NEXT_TRIPS};
pub use ocmc_estimation::fit::speed_change::SpeedChangeOptions;
pub use ocmc_estimation::log::road::RoadOptions;
pub use ocmc_io::intake::table::clock::PlaceClock;

/// Results of measurements.
#[derive(Clone, Debug, Serialize)]
pub struct FitAnswer<Fit> {
    /// The estimates.
    #[serde(flatten)]
    pub fit: Fit,
    /// The part of a study that follows from them.
    pub study: Value,
    /// Files that were read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<FileAccount>,
    #[serde(skip)]
    text: String,
    #[serde(skip)]
    warnings: Vec<String>,
}

impl<Fit> FitAnswer<Fit> {
    fn new(fit: Fit, text: &str, mut warnings: Vec<String>, part: &FittedPart) -> Self {
        warnings.extend(part.warnings());
        let text = format!("{text}\nTo paste into a study:\n\n{}", part.text());
        Self { fit, study: part.json(), inputs: Vec::new(), text, warnings }
    }

    /// With what was read, and what the checks warn of in it before all else.
    fn with_inputs(mut self, inputs: Vec<FileAccount>) -> Self {
        let warnings: Vec<String> = inputs.iter().flat_map(FileAccount::warnings).collect();
        self.warnings.splice(0..0, warnings);
        self.inputs = inputs;
        self
    }
}

impl<Fit: Serialize> Answer for FitAnswer<Fit> {
    fn text(&self) -> String {
        self.text.clone()
    }

    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    fn notes(&self) -> Vec<String> {
        FileAccount::told_of(&self.inputs)
    }
}

/// Numbers of a study with their standard errors, the keys below a path.
fn estimates<'a>(
    below: &'a str,
    parameters: &'a [StudyParameterFit],
) -> impl Iterator<Item = Estimate> + 'a {
    let estimate = move |parameter: &StudyParameterFit| {
        let (key, value) = (format!("{below}.{}", parameter.key), parameter.value);
        Some(Estimate { key, value, standard_error: parameter.standard_error? })
    };
    parameters.iter().filter_map(estimate)
}

/// An estimate of a law of the driver: its key there, the number, its standard error.
fn of_driver(law: &str, (key, value, standard_error): (&str, f64, f64)) -> Estimate {
    Estimate { key: format!("driver.{law}.{key}"), value, standard_error }
}

/// Measurements that have no fit.
fn no_fit(source: &Path, error: impl Into<FitError>) -> Error {
    Error::Fit(source.to_owned(), error.into())
}

/// Name of several tables in messages: that of the first one.
fn first_of(tables: &[Source]) -> &Path {
    tables.first().map_or("".as_ref(), Source::path)
}

/// Curves, and what is asked of them.
#[derive(Clone, Debug)]
pub struct CurveSpeedRequest<'a> {
    /// One row a curve.
    pub curves: Source,
    /// Columns of the quantities.
    pub mappings: Vec<Mapping>,
    /// The study that keeps what curves do not tell.
    pub base: &'a StudyModel,
    /// Criteria of the curves that count, and the method.
    pub options: CurveSpeedOptions,
    /// The population from the censored regression at the speed limits.
    pub tobit: bool,
}

/// Fits the curve speeds of drivers: regression, analysis of variance, population.
///
/// ```
/// use ocmc_api::{CurveSpeedOptions, CurveSpeedRequest, Source, fit_curve_speed, study};
/// let folder = tempfile::tempdir().expect("a directory");
/// let file = folder.path().join("curves.csv");
/// let curves = "driver,radius_m,speed_mps\na,50,10.1\na,100,13.9\na,200,20.2\na,400,27.8\n\
///               b,50,11.1\nb,100,15.3\nb,200,22.1\nb,400,30.6\n";
/// std::fs::write(&file, curves).expect("space");
/// let base = study::load("field-truck", &[] as &[&str])?.model;
/// let (curves, mappings) = (Source::File(file), Vec::new());
/// let options = CurveSpeedOptions::default();
/// let request = CurveSpeedRequest { curves, mappings, base: &base, options, tobit: false };
/// let answer = fit_curve_speed(&request)?;
/// assert!((answer.fit.estimated.exponent - 0.49).abs() < 0.01);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where the table cannot be read, [`Error::Fit`] where the curves do not
/// determine the model, [`Error::Tobit`] where they do not determine the censored one.
pub fn fit_curve_speed(request: &CurveSpeedRequest) -> Result<FitAnswer<CurveSpeedFit>, Error> {
    let CurveSpeedRequest { curves, mappings, base, options, tobit } = request;
    let (table, read) = curve_table::read(curves.lent(), mappings)?;
    let fit = curve_speed::fit(&table, options).map_err(|error| no_fit(curves.path(), error))?;
    let censored = fit.tobit.as_ref().filter(|_| *tobit);
    if *tobit && censored.is_none() {
        return Err(Error::Tobit);
    }
    let population = fit.population(censored, &base.driver.curve_speed);
    let errors = fit.errors_of(&population, censored).into_iter();
    let errors = errors.map(|error| of_driver("curve_speed", error));
    let part = FittedPart::new(base, &["driver", "curve_speed"], &population);
    let part = part.with_errors(base, "curve_speed", errors);
    let text = text::curve_speed(&fit, table.driver.len());
    let warnings = fit.warnings.clone();
    Ok(FitAnswer::new(fit, &text, warnings, &part).with_inputs(vec![read]))
}

/// Speed changes, and what is asked of them.
#[derive(Clone, Debug)]
pub struct SpeedChangeRequest<'a> {
    /// Tables with one row a change, or logs; one at least.
    pub tables: &'a [Source],
    /// Columns of a log.
    pub mappings: Vec<Mapping>,
    /// The study that keeps what was not measured.
    pub base: &'a StudyModel,
    /// Criteria of a change.
    pub options: SpeedChangeOptions,
    /// The study from the laws with the thresholds in their likelihood.
    pub untruncated: bool,
}

/// Fits accelerations and decelerations. `warn` receives what is odd in a log.
///
/// ```
/// use ocmc_api::{SpeedChangeOptions, SpeedChangeRequest, Source, fit_speed_change, go_on, study};
/// let folder = tempfile::tempdir().expect("a directory");
/// let file = folder.path().join("changes.csv");
/// std::fs::write(&file, "acceleration_mps2\n0.4\n0.5\n0.8\n-0.5\n-0.6\n-0.9\n").expect("space");
/// let base = study::load("field-truck", &[] as &[&str])?.model;
/// let request = SpeedChangeRequest {
///     tables: &[Source::File(file)],
///     mappings: Vec::new(),
///     base: &base,
///     options: SpeedChangeOptions::default(),
///     untruncated: false,
/// };
/// let fit = fit_speed_change(&request, &mut |_| (), &mut go_on)?.fit;
/// assert_eq!(fit.deceleration.expect("three of them").n, 3);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::SpeedChange`] where a table or a log cannot be read, [`Error::Fit`] where no change is
/// left, [`Error::Interrupted`].
pub fn fit_speed_change(
    request: &SpeedChangeRequest,
    warn: &mut dyn FnMut(&str),
    watch: &mut Watch,
) -> Result<FitAnswer<SpeedChangeFit>, Error> {
    let SpeedChangeRequest { tables, mappings, base, options, untruncated } = request;
    let (mut changes, mut inputs) = (SpeedChangeTable::default(), Vec::new());
    for (done, source) in tables.iter().enumerate() {
        Progress::of_logs(done, tables.len()).look(watch)?;
        let (read, notes) =
            speed_change_table::append(&mut changes, source.lent(), mappings, options)?;
        read.warnings().iter().chain(&notes).for_each(|note| warn(note));
        inputs.push(read);
    }
    let fit = speed_change::fit(&changes, options);
    let fit = fit.map_err(|error| no_fit(first_of(tables), error))?;
    let population = fit.population(&base.driver.speed_change, *untruncated);
    let errors = fit.errors_of(&population, *untruncated).into_iter();
    let errors = errors.map(|error| of_driver("speed_change", error));
    let part = FittedPart::new(base, &["driver", "speed_change"], &population);
    let part = part.with_errors(base, "speed_change", errors);
    let warnings = fit.warnings();
    let text = text::speed_change(&fit);
    Ok(FitAnswer { inputs, ..FitAnswer::new(fit, &text, warnings, &part) })
}

/// Roads, and what is asked of them.
#[derive(Clone, Debug)]
pub struct OperatingCycleRequest<'a> {
    /// Operating cycles and logs.
    pub roads: &'a [RoadSource<'a>],
    /// Columns of a log; where one is said, all files are logs.
    pub mappings: Vec<Mapping>,
    /// The study with these road types that keeps what roads do not tell.
    pub base: &'a StudyModel,
    /// How logs are read.
    pub options: RoadOptions,
    /// Radii of the curves that are known; those of `options` for logs, all for operating cycles
    /// where there are none.
    pub radius_range_m: Option<[f64; 2]>,
    /// Steering ratio and wheelbase, for logs that only have the steering wheel's angle.
    pub steering: Option<Steering>,
}

/// A road.
#[derive(Clone, Debug)]
pub enum RoadSource<'a> {
    /// An operating cycle of a study.
    Cycle(&'a RealisedCycle),
    /// A file or a table: a log, or, where it has no column of one, an operating cycle.
    Measured(Source),
}

/// Fits the road model. `warn` receives what is odd in a log, and what is left out of it.
///
/// ```
/// use ocmc_api::{OperatingCycleRequest, RoadOptions, RoadSource, fit_operating_cycle, go_on};
/// use ocmc_api::{operating_cycle, study};
/// let study = study::load("field-truck", &["mission.length_m=5000"])?;
/// let cycles: Vec<_> = (0..20).map(|id| operating_cycle(&study, 1, id)).collect();
/// let roads: Vec<_> = cycles.iter().map(RoadSource::Cycle).collect();
/// let request = OperatingCycleRequest {
///     roads: &roads,
///     mappings: Vec::new(),
///     base: &study.model,
///     options: RoadOptions::default(),
///     radius_range_m: None,
///     steering: None,
/// };
/// let fit = fit_operating_cycle(&request, &mut |_| (), &mut go_on)?.fit;
/// assert_eq!((fit.cycles, fit.length_m), (20, 100_000.0));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where something cannot be read, [`Error::Drive`]
/// where no drive can be used, [`Error::Fit`] where the roads do not determine the model,
/// [`Error::Interrupted`].
pub fn fit_operating_cycle(
    request: &OperatingCycleRequest,
    warn: &mut dyn FnMut(&str),
    watch: &mut Watch,
) -> Result<FitAnswer<RoadFit>, Error> {
    let OperatingCycleRequest { roads, mappings, base, options, radius_range_m, steering } =
        request;
    let curb_mass_kg = options.curb_mass_kg.or(Some(base.vehicle.curb_mass_kg));
    let options = &RoadOptions { curb_mass_kg, ..options.clone() };
    let mut found_roads = FoundRoads::default();
    let read = |road: &RoadSource| match road {
        RoadSource::Cycle(cycle) => {
            let given = cycle.given().map_err(|error| no_fit(source(roads), error))?;
            Ok(ReadRoad::Cycle(Box::new(given), None))
        }
        RoadSource::Measured(Source::File(path))
            if mappings.is_empty() && !is_log(path, mappings) =>
        {
            let (cycle, read) = given_cycle::read_with_account(path, &[])?;
            Ok(ReadRoad::Cycle(Box::new(cycle), Some(read)))
        }
        RoadSource::Measured(log) => {
            let roads = log.roads(mappings, options, *steering)?;
            Ok::<_, Error>(ReadRoad::Log(Box::new(roads)))
        }
    };
    for (done, road) in read_at_once(roads, read).enumerate() {
        let progress = Progress::of_logs(done, roads.len());
        progress.look(watch)?;
        match road? {
            ReadRoad::Cycle(cycle, read) => {
                found_roads.add_cycle(*cycle);
                if let Some(read) = read {
                    read.warnings().iter().for_each(|warning| warn(warning));
                    found_roads.inputs.push(read);
                }
            }
            ReadRoad::Log(roads) => {
                let warnings = roads.inputs.iter().flat_map(FileAccount::warnings);
                warnings.for_each(|warning| warn(&warning));
                found_roads.append(*roads);
            }
        }
    }
    if let Some((place, fault)) = found_roads.failed() {
        return Err(Error::Drive { place: place.clone(), fault: fault.clone() });
    }
    found_roads.told().iter().for_each(|told| warn(told));
    let (fit, part) = roads_part(&found_roads, *radius_range_m, base, source(roads))?;
    let (text, warnings) = (text::roads(&fit), fit.warnings.clone());
    // what is odd in them was said while they were read
    Ok(FitAnswer { inputs: found_roads.inputs, ..FitAnswer::new(fit, &text, warnings, &part) })
}

/// Fits the road model to roads that were found; `path` is what errors call them.
pub(crate) fn roads_part(
    found_roads: &FoundRoads,
    radius_range_m: Option<[f64; 2]>,
    base: &StudyModel,
    path: &Path,
) -> Result<(RoadFit, FittedPart), Error> {
    let coverage = found_roads.coverage(radius_range_m);
    let fit = fit_with_coverage(&found_roads.roads, &coverage, base)
        .map_err(|error| no_fit(path, error))?;
    let mut errors: Vec<Estimate> = Vec::new();
    for road_type in &fit.types {
        let below = format!("road.types.{}", road_type.road_type);
        errors.extend(estimates(&below, &road_type.parameters));
    }
    errors.extend(estimates("road", &fit.junction_turn).chain(estimates("mission", &fit.mission)));
    let part = FittedPart::new(base, &[], &fit.study()).with_errors(base, "road", errors);
    Ok((fit, part))
}

/// A road that was read.
enum ReadRoad {
    Cycle(Box<GivenCycle>, Option<FileAccount>),
    Log(Box<FoundRoads>),
}

/// Name of the roads in messages: that of the first one.
fn source<'a>(roads: &'a [RoadSource]) -> &'a Path {
    match roads.first() {
        Some(RoadSource::Measured(source)) => source.path(),
        _ => "cycles".as_ref(),
    }
}

/// Measured traffic.
#[derive(Clone, Debug)]
pub struct TrafficRequest<'a> {
    /// One row a measurement.
    pub table: Source,
    /// Columns of the quantities.
    pub mappings: Vec<Mapping>,
    /// The study that keeps what was not measured.
    pub base: &'a StudyModel,
    /// The clock of the place, for times in UTC and for local times with summer time.
    pub place: Option<PlaceClock>,
}

/// Recorded weather of one place.
#[derive(Clone, Debug)]
pub struct WeatherRequest<'a> {
    /// The tables, which are joined by time.
    pub tables: &'a [Source],
    /// Columns of the quantities, where their names do not say it.
    pub mappings: Vec<Mapping>,
    /// The study that keeps what was not measured.
    pub base: &'a StudyModel,
    /// The clock of the place, for times in UTC and for local times with summer time.
    pub place: Option<PlaceClock>,
}

/// Fits traffic densities.
///
/// ```
/// use ocmc_api::{Error, Source, TrafficRequest, fit_traffic, study};
/// let folder = tempfile::tempdir().expect("a directory");
/// let file = folder.path().join("traffic.csv");
/// std::fs::write(&file, "time_s,road_type,density_share\n0,rural,0.1\n").expect("space");
/// let base = study::load("field-truck", &[] as &[&str])?.model;
/// let (table, mappings) = (Source::File(file), Vec::new());
/// let request = TrafficRequest { table, mappings, base: &base, place: None };
/// // one measurement is not enough
/// assert!(matches!(fit_traffic(&request), Err(Error::Fit { .. })));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where the table cannot be read, [`Error::Fit`] where it does not determine a
/// density.
pub fn fit_traffic(request: &TrafficRequest) -> Result<FitAnswer<TrafficFit>, Error> {
    let TrafficRequest { table, mappings, base, place } = request;
    let read = traffic_table::read_table(table.lent(), mappings, &base.traffic, place.as_ref())?;
    let fit = match &read.speed_ratios {
        Some(ratios) => traffic::fit_speeds(&read.records, ratios, &base.traffic),
        None => traffic::fit(&read.records, &base.traffic),
    };
    let fit = fit.map_err(|error| no_fit(table.path(), error))?;
    let errors = estimates("traffic", &fit.parameters);
    let part = FittedPart::new(base, &["traffic"], &fit.model).with_errors(base, "traffic", errors);
    let table = text::parameter_table("", &fit.parameters);
    let head = match fit.speed_noise_sd {
        Some(sd) => format!("{} speeds, with noise of an SD of {sd:.3} of the free speed", fit.n),
        None => format!("{} densities", fit.n),
    };
    let (text, warnings) = (format!("{head}\n{table}"), fit.warnings.clone());
    Ok(FitAnswer::new(fit, &text, warnings, &part).with_inputs(vec![read.read]))
}

/// Fits the weather model.
///
/// ```
/// use ocmc_api::{Error, Source, WeatherRequest, fit_weather, study};
/// let folder = tempfile::tempdir().expect("a directory");
/// let file = folder.path().join("weather.csv");
/// std::fs::write(&file, "time_s,temperature_k\n0,281\n").expect("space");
/// let base = study::load("field-truck", &[] as &[&str])?.model;
/// let (table, mappings) = (Source::File(file), Vec::new());
/// let request = WeatherRequest { tables: &[table], mappings, base: &base, place: None };
/// // one hour is not enough
/// assert!(matches!(fit_weather(&request), Err(Error::Fit { .. })));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where the table cannot be read, [`Error::Fit`] where it determines nothing.
pub fn fit_weather(request: &WeatherRequest) -> Result<FitAnswer<WeatherFit>, Error> {
    let WeatherRequest { tables, mappings, base, place } = request;
    let lent: Vec<_> = tables.iter().map(Source::lent).collect();
    let (records, read) = weather_table::read(&lent, mappings, place.as_ref())?;
    let fit = weather::fit(&records, &base.weather);
    let fit = fit.map_err(|error| no_fit(first_of(tables), error))?;
    let errors = estimates("weather", &fit.parameters);
    let part = FittedPart::new(base, &["weather"], &fit.model).with_errors(base, "weather", errors);
    let table = text::parameter_table("", &fit.parameters);
    let text = format!("{} hours over {:.1} years\n{table}", fit.hours, fit.years);
    let warnings = fit.warnings.clone();
    Ok(FitAnswer::new(fit, &text, warnings, &part).with_inputs(read))
}
