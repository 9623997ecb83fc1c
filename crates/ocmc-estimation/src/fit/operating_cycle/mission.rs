//! Missions: length, payload, departure, distance between stops, dwell. Each cycle, or drive of a
//! log, counts as one mission; a time without rows does not end it. A log may begin and end within
//! a row of its mission, alike in all logs: the error of the mean length has the way of a row in
//! it.
//!
//! In a log without objects of a map, standstills of some minutes are stops. Where the dwells that
//! are seen leave more than 1 % of a log-normal law of them below that, others are shorter and not
//! seen: then the distances are those between long stops, and neither they nor the dwells are
//! estimates of all.

use super::curve::{CensoredNormal, minus_log_likelihood_of_cut};
use super::event::fitted_law;
use crate::fit::nelder_mead::minimise;
use crate::fit::p_value::normal_probability;
use crate::fit::study_parameter::Estimates;
use crate::log::road::LoggedRoad;
use crate::moments::Moments;
use ocmc_core::distribution::{Law, Quantity};
use ocmc_core::operating_cycle::mission::{MissionModel, MissionStopModel};
use ocmc_core::operating_cycle::road::point_event::EventKind;

/// Most values of an empirical law: quantiles of as many equal shares where there are more.
const MOST_VALUES: usize = 100;

/// Values that differ by less, relative to the largest, are one.
const SAME: f64 = 1e-9;

/// Fewest stops that tell whether shorter ones are not seen.
const FEWEST_STOPS: usize = 5;

/// Largest share of the stops that may be too short to be seen (judgement).
const MOST_UNSEEN: f64 = 0.01;

/// One mission, as far as it is known.
pub(super) struct Mission {
    length_m: f64,
    /// Way from row to row of its log, in m.
    row_m: f64,
    payload_kg: Option<f64>,
    /// Second of the day, and day of the year.
    departure: Option<(f64, f64)>,
    /// Stops: where, in m, and for how long, in s.
    stops: Vec<[f64; 2]>,
}

/// The missions of roads, each of one or more parts of a drive.
pub(super) fn missions(roads: &[LoggedRoad]) -> Vec<Mission> {
    let mut missions: Vec<Mission> = Vec::new();
    for road in roads {
        let LoggedRoad { cycle, part, row_way_m, .. } = road;
        if road.begins_drive() {
            missions.push(Mission {
                length_m: part.map_or(cycle.length_m, |part| part.drive_m),
                row_m: *row_way_m,
                payload_kg: cycle.payload_kg,
                departure: cycle.departure,
                stops: Vec::new(),
            });
        }
        let Some(mission) = missions.last_mut() else { continue };
        let start_m = part.map_or(0.0, |part| part.start_m);
        mission.payload_kg = mission.payload_kg.or(cycle.payload_kg);
        mission.stops.extend(cycle.events.iter().filter_map(|event| match event.kind {
            EventKind::MissionStop { standstill_s } => {
                Some([start_m + event.position_m, standstill_s])
            }
            _ => None,
        }));
    }
    missions
}

/// Laws of the mission: of the families of the base study where these have a fit, otherwise the
/// measured values themselves.
pub(super) fn fit_mission(
    missions: &[Mission],
    shortest_stop_s: f64,
    model: &mut MissionModel,
    estimates: &mut Estimates,
) {
    let lengths: Vec<f64> = missions.iter().map(|mission| mission.length_m).collect();
    let payloads: Vec<f64> = missions.iter().filter_map(|mission| mission.payload_kg).collect();
    let departures = |value_of: fn((f64, f64)) -> f64| -> Vec<f64> {
        let values = missions.iter().filter_map(|mission| mission.departure.map(value_of));
        values.filter(|value| value.is_finite()).collect()
    };
    let (seconds, days) = (departures(|at| at.0), departures(|at| at.1));
    let row_m = missions.iter().map(|mission| mission.row_m).sum::<f64>() / lengths.len() as f64;
    law(estimates, "length_m", &lengths, row_m, &mut model.length_m);
    law(estimates, "payload_kg", &payloads, 0.0, &mut model.payload_kg);
    law(estimates, "departure_s_of_day", &seconds, 0.0, &mut model.departure_s_of_day);
    law(estimates, "departure_day_of_year", &days, 0.0, &mut model.departure_day_of_year);
    if let Quantity::Law(Law::Uniform { lower, upper }) = &mut model.departure_day_of_year {
        // the ends that are moved out beyond the measured days stay within the year
        (*lower, *upper) = (lower.max(0.0), upper.min(365.0));
    }
    fit_stops(missions, shortest_stop_s, model, estimates);
}

/// The law of measured values; without one it stays. `resolution`: what all of them may be off by.
fn law(
    estimates: &mut Estimates,
    key: &str,
    values: &[f64],
    resolution: f64,
    quantity: &mut Quantity,
) {
    let n = values.len();
    if n == 0 {
        return estimates
            .warn(format_args!("nothing tells {key}, which stays that of the base study"));
    }
    let moments = Moments::of(values);
    let mean = moments.mean;
    let error = (n > 1).then(|| libm::hypot(moments.standard_error(), resolution));
    estimates.push(&format!("{key}, mean"), mean, error, n);
    let widest = values.iter().map(|x| (x - mean).abs()).fold(0.0, f64::max);
    *quantity = if widest <= SAME * mean.abs() {
        Quantity::Number(mean)
    } else if let Some(law) = fitted_law(values, quantity) {
        Quantity::Law(law)
    } else {
        Quantity::Law(Law::Empirical { values: quantiles(values), weights: None })
    };
}

/// The values in order, or as many quantiles of them as an empirical law holds.
fn quantiles(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    if n <= MOST_VALUES {
        return sorted;
    }
    let middle = |k: usize| (k as f64 + 0.5) / MOST_VALUES as f64;
    (0..MOST_VALUES).map(|k| sorted[((middle(k) * n as f64) as usize).min(n - 1)]).collect()
}

/// Stops: the distance from one to the next, with the one that the road's end cuts off, and the
/// dwell.
fn fit_stops(
    missions: &[Mission],
    shortest_s: f64,
    model: &mut MissionModel,
    estimates: &mut Estimates,
) {
    let (mut spacings, mut dwells) = (Vec::new(), Vec::new());
    for mission in missions {
        let mut before_m = 0.0;
        for [position_m, standstill_s] in &mission.stops {
            spacings.push((position_m - before_m, false));
            dwells.push(*standstill_s);
            before_m = *position_m;
        }
        spacings.push((mission.length_m - before_m, true));
    }
    let n = dwells.len();
    if n == 0 {
        if model.stops.is_some() {
            estimates.warn("no stop: their distances and dwells stay those of the base study");
        }
        return;
    }
    if shortest_s > 0.0 && !(share_below(&dwells, shortest_s) <= MOST_UNSEEN) {
        let moments = Moments::of(&dwells);
        let way_m: f64 = missions.iter().map(|mission| mission.length_m).sum();
        estimates.push("standstills of the mission, per m", n as f64 / way_m, None, n);
        estimates.push("standstills of the mission, mean in s", moments.mean, None, n);
        return estimates.warn(format_args!(
            "{n} standstills of {shortest_s} s or more do not tell how many of its stops are \
             shorter, which a log does not tell from queues: distances and dwells of its stops \
             stay those of the base study (a column map_object with mission_stop tells all)"
        ));
    }
    let base = model.stops.take();
    let exponential = || {
        let mean = spacings.iter().map(|spacing| spacing.0).sum::<f64>() / n as f64;
        (Law::Exponential { mean }, "mean", mean, Some(mean / libm::sqrt(n as f64)))
    };
    let (spacing, what, value, error) = match base.as_ref().map(|stops| &stops.spacing_m) {
        Some(Quantity::Law(Law::LogNormal { .. })) if n >= 5 => log_normal_spacing(&spacings, n),
        _ => exponential(),
    };
    estimates.push(&format!("stops.spacing_m, {what}"), value, error, n);
    let mut stops = base.unwrap_or(MissionStopModel {
        spacing_m: Quantity::Number(0.0),
        dwell_s: Quantity::Law(Law::LogNormal {
            median: 1.0,
            log_sd: 1.0,
            lower: None,
            upper: None,
        }),
        cargo: None,
        power_take_off: None,
    });
    law(estimates, "stops.dwell_s", &dwells, 0.0, &mut stops.dwell_s);
    stops.spacing_m = Quantity::Law(spacing);
    model.stops = Some(stops);
}

/// The share of a log-normal law of times that lies below one of them; none of too few of them.
fn share_below(times_s: &[f64], below_s: f64) -> f64 {
    if times_s.len() < FEWEST_STOPS {
        return f64::NAN;
    }
    let logs: Vec<f64> = times_s.iter().map(|time_s| libm::log(*time_s)).collect();
    let moments = Moments::of(&logs);
    let sd = moments.sd();
    if sd > 0.0 { normal_probability((libm::log(below_s) - moments.mean) / sd) } else { 0.0 }
}

/// Log-normal distances, those that the road's end cuts off as at least so long.
fn log_normal_spacing(spacings: &[(f64, bool)], n: usize) -> (Law, &'static str, f64, Option<f64>) {
    let positive = spacings.iter().filter(|spacing| spacing.0 > 0.0);
    let normal = |(spacing_m, is_cut): &(f64, bool)| CensoredNormal {
        value: libm::log(*spacing_m),
        is_cut: *is_cut,
        weight: 1.0,
    };
    let normals: Vec<CensoredNormal> = positive.map(normal).collect();
    let minus_log_likelihood = |theta: &[f64; 2]| minus_log_likelihood_of_cut(&normals, theta);
    let mean = normals.iter().map(|normal| normal.value).sum::<f64>() / normals.len() as f64;
    let (theta, _) = minimise(minus_log_likelihood, [mean, libm::log(0.5)], 0.3);
    let (median, log_sd) = (libm::exp(theta[0]), libm::exp(theta[1]));
    let law = Law::LogNormal { median, log_sd, lower: None, upper: None };
    (law, "median", median, Some(median * log_sd / libm::sqrt(n as f64)))
}
