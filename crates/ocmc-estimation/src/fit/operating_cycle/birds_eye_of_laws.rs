//! The bird's-eye view by the laws of a study: what its roads are in the mean of infinitely many,
//! without drawing one.
//!
//! With s_r the share of road type r by length, n the steps of a road, L its mean length:
//!
//! - **Slopes** are normal with the SD σ_r, cut at the limit of the type. Where the net climb is
//!   given, the mean slope of each road is taken out: Var = σ_r² − 2 c_r + Σ_q s_q c_q with c_r =
//!   σ_r² (1 + a_r)/((1 − a_r) n), a_r the autoregression's coefficient.
//! - **Events** are a Poisson process that is dead for the spacing d behind each event that it
//!   keeps: of the intensity λ it keeps λ/(1 + λ d) (renewal theory, exact within a type). Mission
//!   stops at the rate ν take 1 − ν d of the others twice, before and behind them.
//! - **Curves** below 500 m are those of each sign by its share, less those that meet a turn, plus
//!   the turns.
//! - **Mission stops** are a renewal process: L/μ + (c² − 1)/2 of them in the mean, with the mean μ
//!   and the coefficient of variation c of the spacing (Cox, Renewal Theory, 1962 \[PK\]).
//!
//! All of it is \[D\]. What is left out: the first stretch of a road is a fresh one, curves that
//! are pushed over a road's end, and turns that begin within a turn.

use super::birds_eye::{BirdsEye, Counted, SLOPES, SLOWING_RADIUS_M};
use crate::fit::p_value::normal_probability;
use ocmc_core::distribution::{Law, Quantity};
use ocmc_core::operating_cycle::road::RoadTypeModel;
use ocmc_core::operating_cycle::road::point_event::{EventParameter, KINDS};
use ocmc_core::operating_cycle::road::topography::ClimbRule;
use ocmc_core::study::Study;
use ocmc_core::switch::ModelSwitch;
use std::f64::consts::FRAC_PI_2;

/// Stops that a law puts closer together are moved apart to this, in m.
const CLOSEST_STOPS_M: f64 = 50.0;
/// Quantiles over which the mean of a law is taken.
const QUANTILES: u32 = 2000;

/// The bird's-eye view of a study's laws; none where it drives given routes.
pub fn birds_eye_of_laws(study: &Study) -> Option<BirdsEye> {
    let model = study.model();
    if !model.mission.routes.is_empty() {
        return None;
    }
    let without = &model.simulation.without;
    let sampler = study.operating_cycle().road();
    let (types, shares) = (sampler.types(), sampler.share_by_length());
    let [length_m, _] = mean_and_cv(&model.mission.length_m, 0.0);
    let [mission_stops, stops_per_m] = model.mission.stops.as_ref().map_or([0.0; 2], |stops| {
        let [mean_m, cv] = mean_and_cv(&stops.spacing_m, CLOSEST_STOPS_M);
        let count = (length_m / mean_m + 0.5 * (cv * cv - 1.0)).max(0.0);
        [count, count / length_m]
    });
    let over_types = |value_of: &dyn Fn(&RoadTypeModel) -> f64| -> f64 {
        types.iter().zip(shares).map(|(road_type, share)| share * value_of(road_type)).sum()
    };
    let spacing_m = model.road.event_spacing_m;
    // ends without events
    let inner = (1.0 - 2.0 * model.road.event_free_end_m / length_m).max(0.0);
    let kept = |events: &Events| {
        let beside = (1.0 - stops_per_m * spacing_m).max(0.0);
        inner * beside * beside / (1.0 + events.per_m * spacing_m)
    };
    let events = |road_type: &RoadTypeModel| Events::of(road_type, without);
    let road_stops_per_m = over_types(&|road_type| {
        let events = events(road_type);
        kept(&events) * events.stops_per_m
    });
    let curves_per_m = over_types(&|road_type| {
        let events = events(road_type);
        let turns_per_m = kept(&events) * events.turns_per_m;
        slow_curves_per_m(study, road_type, turns_per_m)
    });
    let has_curves = !without.contains(&ModelSwitch::Curves);
    Some(BirdsEye::of(Counted {
        length_m,
        share_below: Some(shares_below(study, length_m)),
        stop_spacing_m: length_m / (mission_stops + 1.0),
        stops_per_km: 1000.0 * (road_stops_per_m + stops_per_m),
        curves_per_km: Some(if has_curves { 1000.0 * curves_per_m } else { 0.0 }),
        road_type_share: study.road_types().iter().cloned().zip(shares.iter().copied()).collect(),
    }))
}

/// Events of a road type before those too close to others are dropped, per m.
#[allow(clippy::struct_field_names, reason = "a unit is the suffix of a name")]
struct Events {
    per_m: f64,
    /// Events among them at which a truck has to stop, per m.
    stops_per_m: f64,
    /// Events among them with a turn, per m.
    turns_per_m: f64,
}

impl Events {
    fn of(road_type: &RoadTypeModel, without: &[ModelSwitch]) -> Self {
        let mut all = Self { per_m: 0.0, stops_per_m: 0.0, turns_per_m: 0.0 };
        let mut road_type = road_type.clone();
        for kind in KINDS {
            let Some(model) = kind.model.filter(|model| !without.contains(&model.switch)) else {
                continue;
            };
            let Some(events) = (model.estimation)(&mut road_type) else { continue };
            let per_m = *events.per_m;
            let (mut stops, mut turns) = (f64::from(u8::from(kind.stops)), 0.0);
            for parameter in events.parameters {
                match parameter {
                    // the only shares are those of red lights, stops and closed barriers
                    EventParameter::Share(_, share, _) => stops = *share,
                    EventParameter::TurnShare(share) => turns = *share,
                    EventParameter::Law(..) => {}
                }
            }
            all.per_m += per_m;
            all.stops_per_m += per_m * stops;
            all.turns_per_m += per_m * turns;
        }
        all
    }
}

/// Curves that slow a truck down, per m of a road type with so many turns.
fn slow_curves_per_m(study: &Study, road_type: &RoadTypeModel, turns_per_m: f64) -> f64 {
    let (curves, turn) = (&road_type.curves, &study.model().road.junction_turn);
    // the share of R = R_turn + exp(N(ln median, sd²)) below the bound
    let slow = |turn_radius_m: f64, median_m: f64, log_sd: f64| {
        let room_m = SLOWING_RADIUS_M - turn_radius_m;
        match (room_m > 0.0, log_sd > 0.0) {
            (false, _) => 0.0,
            (true, true) => normal_probability(libm::log(room_m / median_m) / log_sd),
            (true, false) => f64::from(u8::from(median_m < room_m)),
        }
    };
    let mean_of_log_normal = |median: f64, log_sd: f64| median * libm::exp(0.5 * log_sd * log_sd);
    let turn_m = FRAC_PI_2
        * 0.5
        * (1.0 + turn.minimum_share)
        * (turn.turn_radius_m + mean_of_log_normal(turn.median_radius_m, turn.radius_log_sd));
    let curve_m = mean_of_log_normal(curves.median_length_m, curves.length_log_sd);
    let free = libm::exp(-turns_per_m * (turn_m + curve_m));
    let signs = &road_type.speed_signs;
    let total: f64 = signs.share.iter().sum();
    let of_signs = signs.speed_kmh.iter().zip(&signs.share).map(|(speed_kmh, share)| {
        let sign_mps = speed_kmh / 3.6;
        let scale = curves.reference_sign_mps.map_or(1.0, |reference| sign_mps / reference);
        let median_m = curves.median_radius_m * scale;
        let slow = slow(curves.turn_radius_m, median_m, curves.radius_log_sd);
        share / total * curves.intensity_per_m(sign_mps) * slow
    });
    let turns = turns_per_m * slow(turn.turn_radius_m, turn.median_radius_m, turn.radius_log_sd);
    free * of_signs.sum::<f64>() + turns
}

/// Shares of the way on which the slope is below the limits of the classes.
fn shares_below(study: &Study, length_m: f64) -> [f64; 3] {
    let model = study.model();
    if model.simulation.without.contains(&ModelSwitch::Slope) {
        return [1.0; 3];
    }
    let sampler = study.operating_cycle().road();
    let (types, shares) = (sampler.types(), sampler.share_by_length());
    let step_m = sampler.slope_step_m();
    let bridged = model.road.climb_rule == ClimbRule::Bridge;
    let mean = if bridged { model.road.net_climb_m.centre() / length_m } else { 0.0 };
    // the covariance of a slope with the mean of its road
    let covariance = |road_type: &RoadTypeModel| {
        let topography = &road_type.topography;
        let a = topography.coefficient(step_m);
        let variance = topography.slope_sd * topography.slope_sd;
        if bridged { variance * (1.0 + a) / (1.0 - a) * step_m / length_m } else { 0.0 }
    };
    let of_mean: f64 =
        types.iter().zip(shares).map(|(road_type, share)| share * covariance(road_type)).sum();
    let share_below = |limit: f64| {
        let of_type = |(road_type, share): (&RoadTypeModel, &f64)| {
            let topography = &road_type.topography;
            let variance =
                topography.slope_sd * topography.slope_sd - 2.0 * covariance(road_type) + of_mean;
            let sd = variance.max(0.0).sqrt();
            let within = |bound: f64| {
                normal_probability((bound - mean) / sd) - normal_probability((-bound - mean) / sd)
            };
            let cut = topography.slope_limit;
            share * if limit >= cut { 1.0 } else { within(limit) / within(cut) }
        };
        types.iter().zip(shares).map(of_type).sum()
    };
    SLOPES.map(share_below)
}

/// Mean and coefficient of variation of a quantity whose draws below `least` are put there; of a
/// law without closed quantiles its own mean, and the coefficient 1.
fn mean_and_cv(quantity: &Quantity, least: f64) -> [f64; 2] {
    let law: &Law = match quantity {
        Quantity::Number(value) => return [value.max(least), 0.0],
        Quantity::Law(law) => law,
        Quantity::Levelled(levelled) => &levelled.law,
    };
    let value = |k: u32| law.quantile((f64::from(k) + 0.5) / f64::from(QUANTILES));
    let values: Option<Vec<f64>> =
        (0..QUANTILES).map(|k| value(k).map(|value| value.max(least))).collect();
    let Some(values) = values else { return [law.centre().max(least), 1.0] };
    let n = f64::from(QUANTILES);
    let mean = values.iter().sum::<f64>() / n;
    let square = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / n;
    [mean, square.sqrt() / mean]
}
