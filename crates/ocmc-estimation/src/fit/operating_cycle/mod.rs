//! The road model of operating cycles: every parameter that a realised road determines.
//!
//! The cycles are those of `ocmc cycle`, others in the same tracks, or the roads of logs
//! ([`crate::log::road`]), of which not everything is known ([`Coverage`]): what is not known stays
//! as in the base study, and a warning says so. Each parameter comes back as the maximum-likelihood
//! or the moment estimate of the model that draws it, with its standard error where that has a
//! simple form:
//!
//! - road types: jumps by their counts, mean length by exposure, the last stretch of a road
//!   censored;
//! - signs: shares by length, mean length by the number of changes, similarity by the likelihood of
//!   the changes;
//! - point events: intensity by exposure, less the length that the spacing of events blocks; marks
//!   by the law of the base study;
//! - curves: intensity by Poisson regression on the sign, radius and length log-normal, lengths
//!   that the largest heading cuts off as censored, junction turns apart; where a detector sees a
//!   window of radii and turns, with that window in the likelihood;
//! - turns at junctions: their radii and angles, over all road types;
//! - slope: SD, and hill length by sign changes, relative to the road's mean slope, whose share of
//!   the variance is made up for; of measured altitudes both by their likelihood;
//! - roughness by moments of its blocks, ground by its stretches;
//! - mission: length, payload, departure, distance between stops and dwell.
//!
//! Weather and traffic are not estimated: the tracks hold them at the free-flow clock of one
//! departure, without the clock. They have fits of their own, [`super::weather`] and
//! [`super::traffic`].

mod altitude;
mod birds_eye;
mod birds_eye_of_laws;
mod curve;
mod curve_intensity;
mod curve_window;
mod event;
mod mission;
mod speed_sign;
mod stretch;
mod surface;
mod topography;

pub use birds_eye::{BirdsEye, Density, Hilliness, TransportCycle, birds_eye, birds_eye_of_study};
pub use birds_eye_of_laws::birds_eye_of_laws;

use super::study_parameter::{Estimates, StudyParameterFit};
use crate::log::road::LoggedRoad;
use ocmc_core::operating_cycle::coverage::{Coverage, CurveCoverage};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::mission::MissionModel;
use ocmc_core::operating_cycle::road::curvature::Curve;
use ocmc_core::operating_cycle::road::point_event::{EventKind, JunctionTurnModel};
use ocmc_core::operating_cycle::road::surface::Ground;
use ocmc_core::operating_cycle::road::{RoadModel, RoadTypeModel};
use ocmc_core::study::StudyModel;
use serde::Serialize;
use std::collections::BTreeMap;
use stretch::Stretch;
use thiserror::Error;

/// Why operating cycles have no fit.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum RoadFitError {
    /// Nothing to estimate from.
    #[error("there is no operating cycle, and no stretch of a log of 200 m or more")]
    NoCycles,
    /// A cycle without road types, counted from 1.
    #[error("operating cycle {0} has no track `road_type`, which says what belongs together")]
    NoRoadTypes(usize),
    /// A road type that the base study does not have.
    #[error(
        "the road type `{name}` is not in the base study, which has {known}; the numbers that \
         roads do not tell come from there"
    )]
    UnknownRoadType {
        /// The type.
        name: String,
        /// Types of the base study.
        known: String,
    },
}

/// Parameters of one type that the roads determine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RoadTypeFit {
    /// Name of the type.
    pub road_type: String,
    /// Length, in m.
    pub length_m: f64,
    /// Numbers that were estimated.
    pub parameters: Vec<StudyParameterFit>,
}

/// The road model of operating cycles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RoadFit {
    /// Operating cycles: each of them, or drive of a log, is a mission.
    pub cycles: usize,
    /// Length, in m.
    pub length_m: f64,
    /// Coverage of the roads' source.
    #[serde(rename = "told")]
    pub coverage: Coverage,
    /// Fit of each type's roads.
    pub types: Vec<RoadTypeFit>,
    /// Turns at junctions, over all types; keys below `road`.
    pub junction_turn: Vec<StudyParameterFit>,
    /// Keys below `mission`.
    pub mission: Vec<StudyParameterFit>,
    /// Facts that do not stop the fit and have to be known.
    pub warnings: Vec<String>,
    /// The bird's-eye view of the roads.
    pub birds_eye: BirdsEye,
    /// The model: the base study's, with what was estimated laid over it. Types that no road has
    /// keep their numbers.
    #[serde(skip)]
    pub model: RoadModel,
    /// The mission: the base study's, with what was estimated laid over it.
    #[serde(skip)]
    pub mission_model: MissionModel,
}

/// Fit of roads as a study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FittedStudy<'a> {
    road: FittedRoad<'a>,
    mission: &'a MissionModel,
}

/// The part `road` of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct FittedRoad<'a> {
    junction_turn: &'a JunctionTurnModel,
    types: &'a BTreeMap<String, RoadTypeModel>,
}

impl RoadFit {
    /// The part of a study that follows.
    pub fn study(&self) -> FittedStudy<'_> {
        let RoadModel { junction_turn, types, .. } = &self.model;
        FittedStudy { road: FittedRoad { junction_turn, types }, mission: &self.mission_model }
    }
}

/// A curve under a sign.
#[derive(Clone, Copy, Debug)]
struct SignedCurve {
    curve: Curve,
    /// The sign at its start, in m/s.
    sign_mps: f64,
    /// Whether the end of the road cuts it off.
    is_cut: bool,
    /// Whether it may have been drawn by the road type before: a curve that would start inside
    /// another starts at its end.
    may_be_pushed: bool,
}

/// Everything of one road type, over all cycles.
#[derive(Clone, Debug, Default)]
struct TypeRoads {
    length_m: f64,
    /// Lengths of stretches, and whether they ended by themselves.
    stretches: Vec<(f64, bool)>,
    /// Types that followed.
    next: BTreeMap<String, usize>,
    /// Length under each sign that is known, by its face in tenths of km/h.
    sign_length_m: BTreeMap<i64, f64>,
    /// Length on which curves are known, by the face of the sign over them; 0 where it is not
    /// known.
    curve_way_m: BTreeMap<i64, f64>,
    /// Curves that would follow a sign which is not known.
    unsigned_curves: usize,
    /// Changes from face to face.
    sign_changes: Vec<(i64, i64)>,
    curves: Vec<SignedCurve>,
    /// Junction turns, and the face of the sign over each.
    turns: Vec<(Curve, i64)>,
    /// Events, and whether they carry a turn.
    events: Vec<(EventKind, bool)>,
    /// Times at rest that no object of a map explains, in s.
    standstills_s: Vec<f64>,
    /// Length at the ends of the road that has no events, in m.
    eventless_m: f64,
    /// Slopes of consecutive steps, one list for each run of them within a stretch.
    slopes: Vec<(usize, Vec<f64>)>,
    /// Roughness of blocks, in m³.
    blocks: Vec<f64>,
    /// Stretches on each ground.
    grounds: BTreeMap<Ground, usize>,
}

/// Fits the road model and the mission of whole operating cycles. `base` gives what roads do not
/// determine: steps and spacings, smallest lengths and radii, families of laws.
///
/// # Errors
/// [`RoadFitError`] says what the cycles lack.
pub fn fit(cycles: &[GivenCycle], base: &StudyModel) -> Result<RoadFit, RoadFitError> {
    let road = |cycle: &GivenCycle| LoggedRoad { cycle: cycle.clone(), ..LoggedRoad::default() };
    let roads: Vec<LoggedRoad> = cycles.iter().map(road).collect();
    fit_with_coverage(&roads, &Coverage::ALL, base)
}

/// As [`fit`], of roads of which not everything is known.
///
/// # Errors
/// As [`fit`].
pub fn fit_with_coverage(
    roads: &[LoggedRoad],
    coverage: &Coverage,
    base: &StudyModel,
) -> Result<RoadFit, RoadFitError> {
    if roads.is_empty() {
        return Err(RoadFitError::NoCycles);
    }
    let base_road = &base.road;
    let mut of_type: BTreeMap<String, TypeRoads> = BTreeMap::new();
    let mut with_stretches: Vec<(&LoggedRoad, Vec<Stretch>)> = Vec::new();
    for (k, road) in roads.iter().enumerate() {
        let cycle = &road.cycle;
        let stretches = stretch::stretches(cycle).ok_or(RoadFitError::NoRoadTypes(k + 1))?;
        let unknown = |stretch: &&Stretch| !base_road.types.contains_key(stretch.2);
        if let Some((_, _, name)) = stretches.iter().find(unknown) {
            let known: Vec<&str> = base_road.types.keys().map(String::as_str).collect();
            let (name, known) = ((*name).to_owned(), known.join(", "));
            return Err(RoadFitError::UnknownRoadType { name, known });
        }
        stretch::collect(&stretches, k, road, coverage, base_road, &mut of_type);
        with_stretches.push((road, stretches));
    }
    let hills = altitude::hills(&with_stretches, base_road);
    let mut estimates = Estimates { warnings: undetermined(coverage), ..Estimates::default() };
    let mut model = base_road.clone();
    let mut types = Vec::new();
    let of_mean_slope = topography::shares_of_mean(&of_type);
    let of_trucks = speed_sign::are_of_trucks(&of_type, base_road);
    for (name, roads) in &of_type {
        estimates.name = name;
        if let Some(model) = model.types.get_mut(name) {
            fit_type(roads, coverage, base_road, of_trucks, model, &mut estimates);
            if coverage.slopes {
                let (step_m, model) = (base_road.slope_step_m, &mut model.topography);
                let known_m = step_m * topography::steps(roads) as f64;
                if let Some(hills) = hills.get(name).filter(|hills| hills.way_m > known_m) {
                    altitude::set_hills(hills, model, &mut estimates);
                } else {
                    let share = of_mean_slope[name];
                    topography::fit_slopes(roads, step_m, share, model, &mut estimates);
                }
            }
        }
        let parameters = std::mem::take(&mut estimates.parameters);
        types.push(RoadTypeFit { road_type: name.clone(), length_m: roads.length_m, parameters });
    }
    for name in base_road.types.keys().filter(|name| !of_type.contains_key(*name)) {
        estimates.name = name;
        estimates.warn("no road has this type, its numbers stay those of the base study");
    }
    estimates.name = "turns at junctions";
    if coverage.events {
        curve::fit_turns(&of_type, coverage, &mut model.junction_turn, &mut estimates);
    }
    let junction_turn = std::mem::take(&mut estimates.parameters);
    estimates.name = "mission";
    let missions = mission::missions(roads);
    let mut mission_model = base.mission.clone();
    mission::fit_mission(&missions, coverage.mission_stop_s, &mut mission_model, &mut estimates);
    let Estimates { parameters: mission, warnings, .. } = estimates;
    Ok(RoadFit {
        cycles: missions.len(),
        length_m: roads.iter().map(|road| road.cycle.length_m).sum(),
        coverage: *coverage,
        types,
        junction_turn,
        mission,
        warnings,
        birds_eye: birds_eye(roads, base_road.slope_step_m),
        model,
        mission_model,
    })
}

/// Unknown parts, in words.
fn undetermined(coverage: &Coverage) -> Vec<String> {
    [
        (coverage.signs, "no speed limits are known: signs stay those of the base study"),
        (
            coverage.events,
            "no objects of a map are known (column map_object), and a standstill alone does not \
             tell a sign from a queue: events and turns at junctions stay those of the base \
             study, and such turns count as curves",
        ),
        (coverage.slopes, "no slope or altitude is known: slopes stay those of the base study"),
        (
            coverage.curves != CurveCoverage::None,
            "nothing tells how the vehicle turned: curves stay those of the base study",
        ),
    ]
    .into_iter()
    .filter(|(known, _)| !known)
    .map(|(_, text)| text.to_owned())
    .collect()
}

fn fit_type(
    roads: &TypeRoads,
    coverage: &Coverage,
    base: &RoadModel,
    signs_are_of_trucks: bool,
    model: &mut RoadTypeModel,
    estimates: &mut Estimates,
) {
    stretch::fit_chain(roads, model, estimates);
    if coverage.signs {
        let truck_limit_mps = model.truck_limit_mps.filter(|_| signs_are_of_trucks);
        speed_sign::fit_signs(roads, truck_limit_mps, &mut model.speed_signs, estimates);
    }
    if coverage.events {
        let all_turns = coverage.curves == CurveCoverage::All;
        event::fit_events(roads, base.event_spacing_m, all_turns, model, estimates);
    } else {
        event::count_standstills(roads, estimates);
    }
    if roads.unsigned_curves > 0 && coverage.signs {
        estimates.warn(format_args!(
            "{} curves on roads without a speed limit are left out: they follow the signs",
            roads.unsigned_curves
        ));
    }
    let way_m: f64 = roads.curve_way_m.values().sum();
    match coverage.curves {
        CurveCoverage::None => {}
        _ if !coverage.signs && model.curves.reference_sign_mps.is_some() => estimates.warn(
            "its curves follow the signs, which are not known: they stay those of the base study",
        ),
        _ if !(way_m > 0.0) => estimates.warn(
            "nothing tells its curves on any of its roads: they stay those of the base study",
        ),
        CurveCoverage::All => curve::fit_curves(roads, &mut model.curves, estimates),
        CurveCoverage::Within(window) => {
            curve_window::fit_curves(roads, &window, &mut model.curves, estimates);
        }
    }
    surface::fit_surface(roads, model, estimates);
}
