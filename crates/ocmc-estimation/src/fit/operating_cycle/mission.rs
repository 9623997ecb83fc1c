//! Missions: length, payload, departure, distance between stops, dwell. Each cycle, or drive of a
//! log, counts as one mission.

use super::curve::{Row, minus_log_likelihood_of_cut};
use super::event::fitted_law;
use crate::fit::nelder_mead::minimise;
use crate::fit::study_parameter::Estimates;
use crate::moments::Moments;
use ocmc_core::distribution::{Law, Quantity};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::mission::{MissionModel, MissionStopModel};
use ocmc_core::operating_cycle::road::point_event::EventKind;

/// Most values of an empirical law: quantiles of as many equal shares where there are more.
const MOST_VALUES: usize = 100;

/// Values that differ by less, relative to the largest, are one.
const SAME: f64 = 1e-9;

/// Laws of the mission: of the families of the base study where these have a fit, otherwise the
/// measured values themselves.
pub(super) fn fit_mission(
    cycles: &[&GivenCycle],
    model: &mut MissionModel,
    estimates: &mut Estimates,
) {
    let lengths: Vec<f64> = cycles.iter().map(|cycle| cycle.length_m).collect();
    let payloads: Vec<f64> = cycles.iter().filter_map(|cycle| cycle.payload_kg).collect();
    let departures = |of: fn((f64, f64)) -> f64| -> Vec<f64> {
        let values = cycles.iter().filter_map(|cycle| cycle.departure.map(of));
        values.filter(|value| value.is_finite()).collect()
    };
    let (seconds, days) = (departures(|at| at.0), departures(|at| at.1));
    law(estimates, "length_m", &lengths, &mut model.length_m);
    law(estimates, "payload_kg", &payloads, &mut model.payload_kg);
    law(estimates, "departure_s_of_day", &seconds, &mut model.departure_s_of_day);
    law(estimates, "departure_day_of_year", &days, &mut model.departure_day_of_year);
    if let Quantity::Law(Law::Uniform { lower, upper }) = &mut model.departure_day_of_year {
        // the ends that are moved out beyond the measured days stay within the year
        (*lower, *upper) = (lower.max(0.0), upper.min(365.0));
    }
    fit_stops(cycles, model, estimates);
}

/// The law of measured values; without one it stays.
fn law(estimates: &mut Estimates, key: &str, values: &[f64], quantity: &mut Quantity) {
    let n = values.len();
    if n == 0 {
        return estimates
            .warn(format_args!("nothing tells {key}, which stays that of the base study"));
    }
    let moments = Moments::of(values);
    let mean = moments.mean;
    estimates.push(&format!("{key}, mean"), mean, (n > 1).then(|| moments.standard_error()), n);
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
fn fit_stops(cycles: &[&GivenCycle], model: &mut MissionModel, estimates: &mut Estimates) {
    let (mut spacings, mut dwells) = (Vec::new(), Vec::new());
    for cycle in cycles {
        let mut before_m = 0.0;
        for event in &cycle.events {
            if let EventKind::MissionStop { standstill_s } = event.kind {
                spacings.push((event.position_m - before_m, false));
                dwells.push(standstill_s);
                before_m = event.position_m;
            }
        }
        spacings.push((cycle.length_m - before_m, true));
    }
    let n = dwells.len();
    if n == 0 {
        if model.stops.is_some() {
            estimates.warn("no stop: their distances and dwells stay those of the base study");
        }
        return;
    }
    let base = model.stops.take();
    let exponential = || {
        let mean = spacings.iter().map(|row| row.0).sum::<f64>() / n as f64;
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
    law(estimates, "stops.dwell_s", &dwells, &mut stops.dwell_s);
    stops.spacing_m = Quantity::Law(spacing);
    model.stops = Some(stops);
}

/// Log-normal distances, those that the road's end cuts off as at least so long.
fn log_normal_spacing(spacings: &[(f64, bool)], n: usize) -> (Law, &'static str, f64, Option<f64>) {
    let positive = spacings.iter().filter(|row| row.0 > 0.0);
    let row = |row: &(f64, bool)| Row { value: libm::log(row.0), is_cut: row.1, weight: 1.0 };
    let rows: Vec<Row> = positive.map(row).collect();
    let minus_log_likelihood = |theta: &[f64; 2]| minus_log_likelihood_of_cut(&rows, theta);
    let mean = rows.iter().map(|row| row.value).sum::<f64>() / rows.len() as f64;
    let (theta, _) = minimise(minus_log_likelihood, [mean, libm::log(0.5)], 0.3);
    let (median, log_sd) = (libm::exp(theta[0]), libm::exp(theta[1]));
    let law = Law::LogNormal { median, log_sd, lower: None, upper: None };
    (law, "median", median, Some(median * log_sd / libm::sqrt(n as f64)))
}
