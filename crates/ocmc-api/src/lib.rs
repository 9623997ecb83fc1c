//! Questions to `ocmc`: one function a question, a request in, an answer out that serialises to the
//! JSON of the command. Nothing here prints or listens to signals; the caller watches the work, and
//! can end it.
//!
//! ```
//! use ocmc_api::{Answer, CompareRequest, RunPlan, compare, go_on, study};
//! let a = study::load("field-truck", &["mission.length_m=5000"])?;
//! let b = a.set(&["driver.curve_speed.exponent=0.5"])?;
//! let request = CompareRequest {
//!     studies: vec![("estimated".to_owned(), &a), ("square root".to_owned(), &b)],
//!     plan: RunPlan::new(1, 0, 10, None, None),
//!     column: None,
//!     keep: false,
//! };
//! let answer = compare(&request, &mut go_on)?;
//! assert!(answer.text().starts_with("A          estimated\nB          square root\n"));
//! assert!(answer.to_json().contains("\"pairs\":10"));
//! # Ok::<(), ocmc_api::Error>(())
//! ```

mod answer;
pub mod ask;
mod benchmark;
mod birds_eye;
mod bound;
mod calibrate_totals;
mod compare;
mod cost;
mod curves;
mod cycle;
mod doubt;
mod drive;
mod error;
mod fit;
mod identify;
mod learn;
mod measured_training;
mod merge;
mod mixed_fleet;
mod named_total;
mod precision;
mod progress;
mod range;
mod report;
mod road;
mod run;
mod sensitivity;
mod simulator_study;
mod size;
mod source;
mod stored;
pub mod study;
mod study_difference;
mod sweep;
mod text;
mod totals_rows;
mod trace;
mod training;
mod validate;
mod vecto;
mod verify;
mod watch;
mod word;

pub use answer::Answer;
pub use benchmark::{
    AdjustedFor, BenchmarkAnswer, BenchmarkContrast, BenchmarkLevel, BenchmarkMember,
    BenchmarkRequest, Compared, Covariate, FarTrip, benchmark,
};
pub use birds_eye::{BirdsEyeAnswer, BirdsEyeRequest, birds_eye};
pub use bound::{BoundAnswer, BoundRequest, CycleBound, PotentialShare, bound};
pub use calibrate_totals::{
    CalibrateTotalsAnswer, CalibrateTotalsRequest, CalibratedNumbers, FEWEST_ROWS, HeldBackTrip,
    Noise, Question, Questioned, Shape, calibrate_totals,
};
pub use compare::{CompareAnswer, CompareRequest, ComparedStudies, compare};
pub use cost::{CostAnswer, CostRequest, Costed, CostedStudy, cost};
pub use curves::{
    CURVE_COLUMNS, Correction, CurveCell, CurveOptions, CurvesAnswer, CurvesRequest, Detector,
    DrivenCurve, HiddenMarkov, RadiusDefinition, Steering, Threshold, TripCurves, TripError,
    curves,
};
pub use cycle::{RealisedCycle, Track, Values, operating_cycle};
pub use doubt::{DoubtAnswer, DoubtRequest, DoubtedNumbers, JudgedDifference, doubt};
pub use drive::{
    Account, Draw, Follow, GivenDrive, GivenDriveError, Keep, RouteModel, check_readable,
};
pub use error::{Error, FitError, columns, compared_columns, factors};
pub use fit::{
    Best, CalibrateCurveSpeedRequest, CalibrationOptions, Coding, CurveSpeedCalibration,
    CurveSpeedOptions, CurveSpeedRequest, FitAnswer, FleetAnswer, FleetOptions, FleetRequest,
    MOST_DRAWS, MOST_NEXT_TRIPS, MeasuredTable, OperatingCycleRequest, PlaceClock, RoadOptions,
    RoadSource, SpeedChangeOptions, SpeedChangeRequest, TrafficRequest, Trips, WeatherRequest,
    calibrate_curve_speed, fit_curve_speed, fit_fleet, fit_operating_cycle, fit_speed_change,
    fit_traffic, fit_weather,
};
pub use identify::{
    ControllerKind, IdentifyAnswer, IdentifyOptions, IdentifyRequest, SpeedTerm, Unknown, Unknowns,
    identify,
};
pub use learn::{Doubted, HeldBack, LearnAnswer, LearnRequest, LearntFile, LearntPart, learn};
pub use measured_training::{MeasuredTrainingAnswer, MeasuredTrainingRequest, measured_training};
pub use merge::{MergeRequest, merge};
pub use mixed_fleet::{GroupAnswer, MixedFleetAnswer, MixedFleetRequest, Replaceable, mixed_fleet};
pub use named_total::NamedTotal;
pub use precision::precision;
pub use range::{RangeAnswer, RangeRequest, range, range_of_run};
pub use report::{
    FLEET, Gathered, MOST_RECORDS, REPORT, Reported, WORKBOOK, WorkbookError, check_cycles,
    directory_of, note_report, report, run_workbook, runs_in, stored_workbook,
};
pub use road::{MadeRoad, MissingLimits, RoadAnswer, RoadRequest, road};
pub use run::{
    Asked, CpuLevel, LAST_CYCLE_ID, MANIFEST, MOST_THREADS, Manifest, Precision, RecordFormat,
    RequeueRequest, ResumeRequest, RunAnswer, RunDirectoryError, RunEnd, RunPlan, RunRequest,
    SUMMARY, requeue, resume, run,
};
pub use sensitivity::{Over, SensitivityAnswer, SensitivityError, SensitivityRequest, sensitivity};
pub use simulator_study::{
    MOST_REPETITIONS, SIMULATOR_DRIVERS, SimulatorStudyAnswer, SimulatorStudyRequest,
    simulator_study,
};
pub use size::{Season, SizeAnswer, SizeRequest, size};
pub use source::{GivenTable, Mapping, Source, mappings};
pub use stored::{
    GROUP_ROWS, PartsError, in_our_order, joined, load, record_batch, records, save, schema,
    summed_up,
};
pub use study_difference::{StudyDifferenceAnswer, study_difference};
pub use sweep::{Against, MOST_POINTS, SweepAnswer, SweepPoints, SweepRequest, SweptPoint, sweep};
pub use trace::{TimeSeries, trace};
pub use training::{TrainingAnswer, TrainingRequest, training};
pub use validate::{
    FEWEST_TRIPS, MOST_TRIPS, RUN_IN_M, ValidateAnswer, ValidateRequest, ValidatedDrive,
    ValidatedRoad, check_empty, validate,
};
pub use vecto::vecto;
pub use verify::{CheckedFile, VerifyAnswer, verify};
pub use watch::{Progress, Watch, go_on};
pub use word::{
    AGAINSTS, BESTS, CODINGS, CONTROLLERS, DRAWS, FOLLOWS, FORMATS, KEEPS, OVERS, RADII,
    RUN_FORMATS, RunFormat, SEASONS, SPEED_TERMS, UNKNOWNS, Word, detectors,
};

pub use ocmc_core::energy::Carrier;
pub use ocmc_core::kernel::drive::trace::TableColumn;
pub use ocmc_core::record::Record;
pub use ocmc_io::charging_table::{chargings_batch, loads_batch};
pub use ocmc_io::label::label;
pub use ocmc_io::trucks::record_batch as truck_batch;
pub use ocmc_io::{number_text, printable, shell_word};
pub use ocmc_vecto::comparison::{
    Attribution, ComparisonError, SpeedMatch, Terms, VectoAnswer, VectoComparison, VectoRequest,
    VectoRun, VectoTruck,
};
