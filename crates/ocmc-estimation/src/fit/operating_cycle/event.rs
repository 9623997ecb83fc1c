//! Point events: intensities and marks.

use super::TypeRoads;
use crate::fit::study_parameter::Estimates;
use crate::moments::Moments;
use ocmc_core::distribution::{
    Law, Quantity, exponential, gamma, log_normal, normal, uniform, weibull,
};
use ocmc_core::operating_cycle::road::RoadTypeModel;
use ocmc_core::operating_cycle::road::point_event::{
    EventEstimation, EventKind, EventModel, EventParameter, KINDS,
};

/// Standard errors between the mean of values and that of the uniform law through their extremes
/// from which on the law has the values' mean and standard deviation.
const MEANS_AGREE: f64 = 4.0;

/// Intensities and marks of all kinds; shares of turns only where all turns are known.
pub(super) fn fit_events(
    roads: &TypeRoads,
    spacing_m: f64,
    all_turns: bool,
    model: &mut RoadTypeModel,
    estimates: &mut Estimates,
) {
    // an event blocks the spacing behind it for all kinds
    let blocked = spacing_m * roads.events.len() as f64 + roads.eventless_m;
    let exposure = roads.length_m - blocked;
    if !(exposure > 0.0) {
        estimates.warn("it is too short to tell about events, which stay those of the base study");
        return;
    }
    for declared in KINDS {
        let of_kind: Vec<&(EventKind, bool)> =
            roads.events.iter().filter(|(kind, _)| declared.includes(kind)).collect();
        let Some(EventModel { table, estimation, .. }) = declared.model else { continue };
        let Some(EventEstimation { per_m, parameters }) = estimation(model) else {
            if !of_kind.is_empty() {
                estimates.warn(format_args!(
                    "its {table} have no table in the base study and are left out"
                ));
            }
            continue;
        };
        let n = of_kind.len();
        let error = Some(libm::sqrt((n as f64).max(1.0)) / exposure);
        estimates.set(&format!("{table}.per_m"), per_m, n as f64 / exposure, error, n);
        for parameter in parameters {
            match parameter {
                EventParameter::Share(key, value, holds) if n > 0 => {
                    let count = of_kind.iter().filter(|(kind, _)| holds(kind)).count();
                    estimates.share(&format!("{table}.{key}"), value, count, n);
                }
                EventParameter::Law(key, law, value) => {
                    let values: Vec<f64> =
                        of_kind.iter().filter_map(|(kind, _)| value(kind)).collect();
                    mark(estimates, &format!("{table}.{key}"), &values, law);
                }
                EventParameter::TurnShare(value) if n > 0 && all_turns => {
                    let turns = of_kind.iter().filter(|(_, turns)| *turns).count();
                    estimates.share(&format!("{table}.turn_share"), value, turns, n);
                }
                EventParameter::Share(..) | EventParameter::TurnShare(_) => {}
            }
        }
    }
}

/// Stops that no object of a map explains: how often and how long, for those who know what they
/// were.
pub(super) fn count_standstills(roads: &TypeRoads, estimates: &mut Estimates) {
    let n = roads.standstills_s.len();
    let (count, length_m) = (n as f64, roads.length_m);
    let error = libm::sqrt(count.max(1.0)) / length_m;
    estimates.push("standstills, per m", count / length_m, Some(error), n);
    if n >= 2 {
        let moments = Moments::of(&roads.standstills_s);
        let error = Some(moments.standard_error());
        estimates.push("standstills, mean in s", moments.mean, error, n);
    }
}

/// Marks are times, lengths and speeds: the end that is moved out beyond the smallest value stops
/// at 0.
fn not_negative(law: Law) -> Law {
    match law {
        Law::Uniform { lower, upper } => Law::Uniform { lower: lower.max(0.0), upper },
        other => other,
    }
}

/// Uniform law between the ends that the extremes determine; where its mean is not that of the
/// values, some of which then have another cause, such as a queue before a give way, the law with
/// their mean and standard deviation.
fn uniform_law(values: &[f64]) -> Option<Law> {
    let extremes = uniform::fit(values)?;
    let moments = Moments::of(values);
    let Law::Uniform { lower, upper } = extremes else { return None };
    let error = (upper - lower) / libm::sqrt(12.0 * values.len() as f64);
    let half = libm::sqrt(3.0) * moments.sd();
    let by_moments = Law::Uniform { lower: moments.mean - half, upper: moments.mean + half };
    let agree = (moments.mean - f64::midpoint(lower, upper)).abs() <= MEANS_AGREE * error;
    Some(if agree { extremes } else { by_moments })
}

/// The law of a mark, of the family that it has in the base study; with fewer than two values, or
/// another family, it stays. Values that are no numbers are not known.
fn mark(estimates: &mut Estimates, key: &str, values: &[f64], law: &mut Quantity) {
    let values: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    if values.len() < 2 {
        return;
    }
    let Some(fitted) = fitted_law(&values, law) else {
        return estimates.warn(format_args!(
            "the law of {key} has no fit here and stays that of the base study"
        ));
    };
    let moments = Moments::of(&values);
    let error = Some(moments.standard_error());
    estimates.push(&format!("{key}, mean"), moments.mean, error, values.len());
    *law = Quantity::Law(fitted);
}

/// A law of the family that a number has in the base study; none where that family has no fit, or
/// the values have none of it.
pub(super) fn fitted_law(values: &[f64], base: &Quantity) -> Option<Law> {
    let Quantity::Law(law) = base else { return None };
    match law {
        Law::Normal { lower: None, upper: None, .. } => normal::fit(values),
        Law::LogNormal { lower: None, upper: None, .. } => log_normal::fit(values),
        Law::Uniform { .. } => uniform_law(values).map(not_negative),
        Law::Exponential { .. } => exponential::fit(values),
        Law::Gamma { .. } => gamma::fit(values),
        Law::Weibull { .. } => weibull::fit(values),
        _ => None,
    }
}
