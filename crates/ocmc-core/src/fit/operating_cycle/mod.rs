//! The road model of operating cycles: every parameter that a realised road tells.
//!
//! The cycles are those of `ocmc cycle`, or others in the same tracks. Each parameter comes back as the maximum-likelihood or the
//! moment estimate of the model that draws it, with its standard error where that has a simple form:
//!
//! - road types: jumps by their counts, mean length by exposure, the last stretch of a road censored;
//! - signs: shares by length, mean length by the number of changes, similarity by the likelihood of the changes;
//! - point events: intensity by exposure, less the length that the spacing of events blocks; marks by the law of the base study;
//! - curves: intensity by Poisson regression on the sign, radius and length log-normal, lengths that the largest heading cuts off
//!   as censored, junction turns apart;
//! - slope: SD, and hill length by sign changes, relative to the road's mean slope;
//! - roughness by moments of its blocks, ground by its stretches.
//!
//! Weather and traffic are not estimated: the tracks hold them at the free-flow clock of one departure, without the clock. They
//! have fits of their own, [`super::weather`] and [`super::traffic`].

mod birds_eye;
mod curve;
mod event;
mod stretch;
mod surface;

pub use birds_eye::{BirdsEye, Hilliness, TransportCycle, birds_eye};

use crate::operating_cycle::given::GivenCycle;
use crate::road::{RoadModel, RoadTypeModel};
use serde::Serialize;
use std::collections::BTreeMap;
use stretch::Stretches;
use thiserror::Error;

/// Why operating cycles have no fit.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum RoadFitError {
    /// Nothing to estimate from.
    #[error("there is no operating cycle")]
    NoCycles,
    /// A cycle without road types.
    #[error("operating cycle {cycle} has no track `road_type`, which says what belongs together")]
    NoRoadTypes {
        /// The cycle, from 1.
        cycle: usize,
    },
    /// A road type that the base study does not have.
    #[error(
        "the road type `{name}` is not in the base study, which has {known}; the numbers that roads do not tell come from there"
    )]
    UnknownRoadType {
        /// The type.
        name: String,
        /// Types of the base study.
        known: String,
    },
}

/// One estimated number of the study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterFit {
    /// Path of the key below the road type, such as `curves.per_m`.
    pub key: String,
    /// Estimate.
    pub value: f64,
    /// Standard error; none where it has no simple form.
    pub standard_error: Option<f64>,
    /// What was counted: stretches, signs, events, curves, steps, blocks.
    pub n: usize,
}

/// What the roads tell about one type.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RoadTypeFit {
    /// Name of the type.
    pub road_type: String,
    /// Length, in m.
    pub length_m: f64,
    /// Numbers that were estimated.
    pub parameters: Vec<ParameterFit>,
}

/// The road model of operating cycles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RoadFit {
    /// Cycles.
    pub cycles: usize,
    /// Length, in m.
    pub length_m: f64,
    /// What each type's roads tell.
    pub types: Vec<RoadTypeFit>,
    /// What does not stop the fit and has to be known.
    pub warnings: Vec<String>,
    /// The bird's-eye view of the roads.
    pub birds_eye: BirdsEye,
    /// The model: the base study's, with what was estimated laid over it. Types that no road has keep their numbers.
    #[serde(skip)]
    pub model: RoadModel,
}

/// Everything of one road type, over all cycles.
#[derive(Clone, Debug, Default)]
struct TypeRoads {
    length_m: f64,
    /// Lengths of stretches, and whether they ended by themselves.
    stretches: Vec<(f64, bool)>,
    /// Types that followed.
    next: BTreeMap<String, usize>,
    /// Length under each sign, by its face in tenths of km/h.
    sign_length_m: BTreeMap<i64, f64>,
    /// Changes from face to face.
    sign_changes: Vec<(i64, i64)>,
    /// Curves with the sign at their start, in m/s.
    curves: Vec<(crate::road::curvature::Curve, f64)>,
    /// Length of junction turns under each sign's face.
    turns: Vec<(crate::road::curvature::Curve, i64)>,
    /// Events, and whether they carry a turn.
    events: Vec<(crate::road::point_event::EventKind, bool)>,
    /// Length at the ends of the road that has no events, in m.
    eventless_m: f64,
    /// Slopes of consecutive steps, one list a stretch and cycle.
    slopes: Vec<(usize, Vec<f64>)>,
    /// Roughness of blocks, in m³.
    blocks: Vec<f64>,
    /// Stretches on each ground.
    grounds: BTreeMap<crate::road::surface::Ground, usize>,
}

/// The estimates of one type while they are made.
struct Estimates<'a> {
    parameters: Vec<ParameterFit>,
    warnings: &'a mut Vec<String>,
    road_type: &'a str,
}

impl Estimates<'_> {
    fn push(&mut self, key: &str, value: f64, standard_error: Option<f64>, n: usize) {
        self.parameters.push(ParameterFit { key: key.to_owned(), value, standard_error, n });
    }

    fn warn(&mut self, message: &str) {
        self.warnings.push(format!("{}: {message}", self.road_type));
    }
}

/// Fits the road model. `base` gives what roads do not tell: steps and spacings, smallest lengths and radii, families of laws.
///
/// # Errors
/// [`RoadFitError`] says what the cycles lack.
pub fn fit(cycles: &[GivenCycle], base: &RoadModel) -> Result<RoadFit, RoadFitError> {
    if cycles.is_empty() {
        return Err(RoadFitError::NoCycles);
    }
    let mut roads: BTreeMap<String, TypeRoads> = BTreeMap::new();
    for (k, cycle) in cycles.iter().enumerate() {
        let stretches = Stretches::of(cycle).ok_or(RoadFitError::NoRoadTypes { cycle: k + 1 })?;
        if let Some(name) = stretches.names().find(|name| !base.types.contains_key(*name)) {
            let known: Vec<&str> = base.types.keys().map(String::as_str).collect();
            let (name, known) = (name.to_owned(), known.join(", "));
            return Err(RoadFitError::UnknownRoadType { name, known });
        }
        stretches.collect(k, cycle, base, &mut roads);
    }
    let mut warnings = Vec::new();
    let mut model = base.clone();
    let mut types = Vec::new();
    for (name, roads) in &roads {
        let mut estimates =
            Estimates { parameters: vec![], warnings: &mut warnings, road_type: name };
        if let Some(model) = model.types.get_mut(name) {
            fit_type(roads, base, model, cycles.len(), &mut estimates);
        }
        let parameters = estimates.parameters;
        types.push(RoadTypeFit { road_type: name.clone(), length_m: roads.length_m, parameters });
    }
    for name in base.types.keys().filter(|name| !roads.contains_key(*name)) {
        warnings.push(format!(
            "{name}: no road has this type, its numbers stay those of the base study"
        ));
    }
    let length_m = cycles.iter().map(|cycle| cycle.length_m).sum();
    let birds_eye = birds_eye(cycles, base.slope_step_m);
    Ok(RoadFit { cycles: cycles.len(), length_m, types, warnings, birds_eye, model })
}

fn fit_type(
    roads: &TypeRoads,
    base: &RoadModel,
    model: &mut RoadTypeModel,
    cycles: usize,
    estimates: &mut Estimates,
) {
    stretch::fit_chain(roads, model, estimates);
    stretch::fit_signs(roads, &mut model.speed_signs, estimates);
    event::fit_events(roads, base.event_spacing_m, model, estimates);
    curve::fit_curves(roads, &mut model.curves, estimates);
    surface::fit_slopes(roads, base.slope_step_m, cycles, &mut model.topography, estimates);
    surface::fit_surface(roads, model, estimates);
}
