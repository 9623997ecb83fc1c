//! The traffic model of measured densities: what [`ocmc_core::operating_cycle::traffic`] draws,
//! estimated.
//!
//! logit x = logit m_r(H) + u: the typical shares off peak and at the peak of each road type by
//! least squares on the logit scale (Gauss and Newton's method), with the hours and widths of the
//! peaks as the base study has them; SD of u, and its correlation over a step from records that
//! follow each other at the same site: records τ apart determine φ^(τ/step). Speeds of floating
//! cars are fitted as speeds (`traffic_speed.rs`), for a density that is worked out of each of them
//! would have their noise.
//!
//! Standard errors are those of the estimating equations with the days of a site as observations
//! (`cluster_robust.rs`), so that they do not depend on how the deviations remember within a day:
//! half of a 95 % interval over 1.96, which few days widen.

use super::cluster_robust::{Cluster, ClusterMoves};
use super::study_parameter::{Estimates, StudyParameterFit, reasons};
use super::traffic_speed::{Speed, SpeedFit, Speeds, pairs};
use crate::moments::correlation;
use nalgebra::DVector;
use ocmc_core::operating_cycle::traffic::TrafficModel;
use serde::Serialize;
use std::collections::BTreeMap;
use thiserror::Error;

/// One measurement of density.
#[derive(Clone, Debug, PartialEq)]
pub struct TrafficRecord {
    /// Where: records of one site follow each other in time.
    pub site: String,
    /// Road type there.
    pub road_type: String,
    /// Time since some midnight, in s.
    pub time_s: f64,
    /// Density as a share of the jam density; NaN where it is missing.
    pub share: f64,
}

/// Why records have no fit.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum TrafficFitError {
    /// No road type can be estimated.
    #[error("{records} records say nothing that can be estimated: {reasons}")]
    Nothing {
        /// Records.
        records: usize,
        /// Why, for each road type.
        reasons: String,
    },
    /// A road type that the base study does not have.
    #[error("the road type `{name}` is not in the base study, which has {known}")]
    UnknownRoadType {
        /// The type.
        name: String,
        /// Types of the base study.
        known: String,
    },
}

/// The traffic model of records.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrafficFit {
    /// Densities.
    pub n: usize,
    /// Numbers that were estimated.
    pub parameters: Vec<StudyParameterFit>,
    /// SD of the noise of the speeds over the speed of the empty road, where speeds were measured.
    pub speed_noise_sd: Option<f64>,
    /// Facts that do not stop the fit and have to be known.
    pub warnings: Vec<String>,
    /// The model: the base study's, with what was estimated laid over it.
    #[serde(skip)]
    pub model: TrafficModel,
}

/// Fewest densities of a type.
const FEWEST: usize = 48;
/// Closest that a share comes to 0 and 1 on the logit scale.
pub(super) const EDGE: f64 = 0.005;
/// How far two intervals may differ and still be one, as a share of it.
pub(super) const SAME_INTERVAL: f64 = 0.01;
/// Heights of the peak that have to be seen, as shares of it (judgement): one of them is an
/// extrapolation otherwise.
pub(super) const SEEN: [f64; 2] = [0.25, 0.75];
/// Rounds after which Gauss and Newton's method is given up.
const MOST_ROUNDS: usize = 100;
/// Fewest days of sites from which standard errors are worked out.
pub(super) const FEWEST_DAYS: usize = 5;
const DAY_S: f64 = 86_400.0;

/// Fits the traffic model. `base` gives what the records do not determine: hours and widths of the
/// peaks, jam and critical density.
///
/// # Errors
/// [`TrafficFitError`] says what the records lack.
pub fn fit(records: &[TrafficRecord], base: &TrafficModel) -> Result<TrafficFit, TrafficFitError> {
    fit_measured(records, None, base)
}

/// Fits the traffic model of measured speeds, over the speed of the empty road: one for each
/// record, whose density is not looked at but where it is missing.
///
/// # Errors
/// [`TrafficFitError`] says what the records lack.
pub fn fit_speeds(
    records: &[TrafficRecord],
    speed_ratios: &[f64],
    base: &TrafficModel,
) -> Result<TrafficFit, TrafficFitError> {
    fit_measured(records, Some(speed_ratios), base)
}

fn fit_measured(
    records: &[TrafficRecord],
    speed_ratios: Option<&[f64]>,
    base: &TrafficModel,
) -> Result<TrafficFit, TrafficFitError> {
    let mut by_type: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    let known = |record: &TrafficRecord| record.share.is_finite() && !record.road_type.is_empty();
    for (k, record) in records.iter().enumerate().filter(|(_, record)| known(record)) {
        by_type.entry(&record.road_type).or_default().push(k);
    }
    let n = by_type.values().map(Vec::len).sum();
    let mut model = base.clone();
    let mut estimates = Estimates::default();
    let mut warn = |n: usize, what: &str| {
        if n > 0 {
            estimates.warnings.push(format!("{n} {what}"));
        }
    };
    let missing = records.iter().filter(|record| !record.share.is_finite()).count();
    warn(missing, "records have no density");
    let untyped = records.iter().filter(|record| record.road_type.is_empty()).count();
    warn(untyped, "records have no road type");
    if speed_ratios.is_none() {
        let cut = records.iter().filter(|record| record.share != edge(record.share)).count();
        let beyond =
            format!("densities beyond {EDGE} from 0 and 1 of the jam density are taken as there");
        warn(cut - missing, &beyond);
    }
    let days = days(records);
    let count_of_days = days.iter().max().map_or(0, |day| day + 1);
    let mut deviations = vec![f64::NAN; records.len()];
    // road types whose speeds are fitted together
    let mut fitted: Vec<(&str, &Vec<usize>)> = Vec::new();
    for (road_type, places) in &by_type {
        estimates.name = road_type;
        let count = places.len();
        let Some(of_type) = model.types.get_mut(*road_type) else {
            let known = base.types.keys().cloned().collect::<Vec<_>>().join(", ");
            return Err(TrafficFitError::UnknownRoadType { name: (*road_type).to_owned(), known });
        };
        if count < FEWEST {
            estimates.stays(format_args!("{count} densities, at least {FEWEST} are needed"));
            continue;
        }
        let value = |record: &TrafficRecord| {
            (base.peak(record.time_s / 3600.0 % 24.0), logit(edge(record.share)))
        };
        let values: Vec<(f64, f64)> = places.iter().map(|k| value(&records[*k])).collect();
        let seen = values.iter().any(|(bell, _)| *bell <= SEEN[0])
            && values.iter().any(|(bell, _)| *bell >= SEEN[1]);
        if !seen {
            estimates.stays("the hours do not tell peak and off peak apart");
            continue;
        }
        if speed_ratios.is_some() {
            fitted.push((road_type, places));
            continue;
        }
        let Some((off, peak)) = typical_shares(&values) else {
            estimates.stays("the hours do not tell peak and off peak apart");
            continue;
        };
        for (k, (bell, value)) in places.iter().zip(&values) {
            deviations[*k] = value - logit(off + (peak - off) * bell);
        }
        let rows =
            places.iter().zip(&values).map(|(k, (bell, _))| (days[*k], *bell, deviations[*k]));
        let errors = share_errors(rows, count_of_days, off, peak);
        for (key, into, share, error) in [
            ("off_peak_share", &mut of_type.off_peak_share, off, errors.map(|errors| errors[0])),
            ("peak_share", &mut of_type.peak_share, peak, errors.map(|errors| errors[1])),
        ] {
            estimates.set(&format!("types.{road_type}.{key}"), into, share, error, count);
        }
    }
    let mut speed_noise_sd = None;
    if let Some(ratios) = speed_ratios.filter(|_| !fitted.is_empty()) {
        let (speeds, interval_s) = speeds(records, ratios, &fitted, &days, base);
        if let Some(speed_fit) = speeds.fit() {
            speed_noise_sd = Some(speed_fit.noise_sd);
            set_speeds(&mut estimates, &mut model, &fitted, &speeds, &speed_fit, interval_s);
        } else {
            estimates.name = "speeds";
            estimates.stays(
                "records that follow each other at one site at one interval do not tell the \
                 traffic from the noise",
            );
        }
    }
    if estimates.parameters.is_empty() {
        let reasons = reasons(&estimates.warnings);
        return Err(TrafficFitError::Nothing { records: records.len(), reasons });
    }
    if speed_ratios.is_none() {
        let known: Vec<usize> = (0..records.len()).filter(|k| deviations[*k].is_finite()).collect();
        let sd = (known.iter().map(|k| deviations[*k] * deviations[*k]).sum::<f64>()
            / known.len() as f64)
            .sqrt();
        let mut clusters = vec![Cluster::nothing(1); count_of_days];
        for k in &known {
            let day = &mut clusters[days[*k]];
            day.score[0] += deviations[*k] * deviations[*k] - sd * sd;
            day.information[(0, 0)] += 2.0 * sd;
        }
        let error = day_errors(clusters).map(|errors| errors[0]);
        estimates.set("logit_sd", &mut model.logit_sd, sd, error, known.len());
        match step_correlation(records, &deviations, &days, base.step_s) {
            Some((phi, error, pairs)) => {
                estimates.set("step_correlation", &mut model.step_correlation, phi, error, pairs);
            }
            None => estimates.warnings.push(
                "no densities follow each other at one site, at one interval and alike; the \
                 correlation stays that of the base study"
                    .to_owned(),
            ),
        }
    }
    let Estimates { parameters, warnings, .. } = estimates;
    Ok(TrafficFit { n, parameters, speed_noise_sd, warnings, model })
}

/// The day of its site that each record belongs to, counted over all sites.
fn days(records: &[TrafficRecord]) -> Vec<usize> {
    let mut places: BTreeMap<(&str, i64), usize> = BTreeMap::new();
    let day_of = |record| {
        let TrafficRecord { site, time_s, .. }: &TrafficRecord = record;
        let next = places.len();
        *places.entry((site, (time_s / DAY_S).floor() as i64)).or_insert(next)
    };
    records.iter().map(day_of).collect()
}

/// Standard errors of estimates whose equations these days sum up to, each for its own; none with
/// too few days.
fn day_errors(mut days: Vec<Cluster>) -> Option<Vec<f64>> {
    days.retain(|day| day.information.iter().any(|entry| *entry != 0.0));
    if days.len() < FEWEST_DAYS {
        return None;
    }
    let width = days[0].score.len();
    let moves = ClusterMoves::of(&days)?;
    let error = |column: usize| {
        let error = moves.error_of(&DVector::from_fn(width, |k, _| f64::from(k == column)));
        (error.informative > 1).then(|| error.written())
    };
    (0..width).map(error).collect()
}

/// Standard errors of both typical shares, of rows (day, height of the peak, deviation).
fn share_errors(
    rows: impl Iterator<Item = (usize, f64, f64)>,
    days: usize,
    off: f64,
    peak: f64,
) -> Option<[f64; 2]> {
    let mut clusters = vec![Cluster::nothing(2); days];
    for (day, bell, left) in rows {
        let share = off + (peak - off) * bell;
        let slope = 1.0 / (share * (1.0 - share));
        let x = DVector::from_column_slice(&[slope * (1.0 - bell), slope * bell]);
        clusters[day].add(&x, left);
    }
    let errors = day_errors(clusters)?;
    Some([0, 1].map(|k| errors[k]))
}

/// The speeds of these types, and the interval of their records, in s.
fn speeds<'a>(
    records: &[TrafficRecord],
    ratios: &[f64],
    fitted: &[(&str, &Vec<usize>)],
    days: &[usize],
    base: &'a TrafficModel,
) -> (Speeds<'a>, f64) {
    let mut rows = Vec::new();
    let mut places = Vec::new();
    for (of_type, (_, of_records)) in fitted.iter().enumerate() {
        for &k in *of_records {
            let bell = base.peak(records[k].time_s / 3600.0 % 24.0);
            rows.push(Speed { of_type, bell, ratio: ratios[k], day: days[k] });
            places.push(k);
        }
    }
    // in order of time within each site, which may have more than one type
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by_key(|row| places[*row]);
    let of_row = |row: &usize| {
        let record = &records[places[*row]];
        (record.site.as_str(), record.time_s, *row)
    };
    let (pairs, interval_s) = pairs(order.iter().map(of_row));
    (Speeds { rows, types: fitted.len(), pairs, base }, interval_s)
}

/// Lays what speeds determine over the model.
fn set_speeds(
    estimates: &mut Estimates,
    model: &mut TrafficModel,
    fitted: &[(&str, &Vec<usize>)],
    speeds: &Speeds,
    speed_fit: &SpeedFit,
    interval_s: f64,
) {
    let error = |k: usize| speed_fit.errors.as_ref().map(|errors| errors[k]);
    for (place, (road_type, rows)) in fitted.iter().enumerate() {
        let Some(of_type) = model.types.get_mut(*road_type) else { continue };
        let [off, peak] = speed_fit.shares[place];
        for (key, into, share, error) in [
            ("off_peak_share", &mut of_type.off_peak_share, off, error(2 * place)),
            ("peak_share", &mut of_type.peak_share, peak, error(2 * place + 1)),
        ] {
            estimates.set(&format!("types.{road_type}.{key}"), into, share, error, rows.len());
        }
    }
    let last = 2 * fitted.len();
    let n = speeds.rows.len();
    estimates.set("logit_sd", &mut model.logit_sd, speed_fit.logit_sd, error(last), n);
    let power = model.step_s / interval_s;
    let phi = libm::pow(speed_fit.correlation, power);
    let error = error(last + 1).map(|error| error * power * phi / speed_fit.correlation);
    let pairs = speeds.pairs[0].len();
    estimates.set("step_correlation", &mut model.step_correlation, phi, error, pairs);
    estimates.warnings.push(
        "step_correlation: of noisy speeds its error is somewhat small, and an interval by it \
         covers some 90 %, not 95 %"
            .to_owned(),
    );
}

/// Typical shares off peak and at the peak, of values (height of the peak from 0 to 1, logit of the
/// share).
fn typical_shares(values: &[(f64, f64)]) -> Option<(f64, f64)> {
    let mean = values.iter().map(|(_, y)| y).sum::<f64>() / values.len() as f64;
    let start = 1.0 / (1.0 + libm::exp(-mean));
    let (mut off, mut peak) = (start, start);
    for _ in 0..MOST_ROUNDS {
        // normal equations of two columns: d logit(m)/dm = 1/(m (1 − m)), times 1 − g and g
        let (mut a, mut b, mut c, mut d, mut e) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (bell, y) in values {
            let share = off + (peak - off) * bell;
            let slope = 1.0 / (share * (1.0 - share));
            let (x_off, x_peak) = (slope * (1.0 - bell), slope * bell);
            let left = y - logit(share);
            a += x_off * x_off;
            b += x_off * x_peak;
            c += x_peak * x_peak;
            d += x_off * left;
            e += x_peak * left;
        }
        let determinant = a * c - b * b;
        if !(determinant > 1e-9 * a * c) {
            return None;
        }
        // at most half the way to an edge
        let within =
            |share: f64, change: f64| share + change.clamp(-0.5 * share, 0.5 * (1.0 - share));
        let next = (
            within(off, (c * d - b * e) / determinant),
            within(peak, (a * e - b * d) / determinant),
        );
        let change = (next.0 - off).abs().max((next.1 - peak).abs());
        (off, peak) = next;
        if change < 1e-12 {
            return Some((off, peak));
        }
    }
    None
}

/// The correlation over a step, its standard error, and from how many pairs.
fn step_correlation(
    records: &[TrafficRecord],
    deviations: &[f64],
    days: &[usize],
    step_s: f64,
) -> Option<(f64, Option<f64>, usize)> {
    let mut last: BTreeMap<&str, usize> = BTreeMap::new();
    let mut pairs = Vec::new();
    for (k, record) in records.iter().enumerate() {
        if let Some(before) = last.insert(&record.site, k) {
            let interval = record.time_s - records[before].time_s;
            if interval > 0.0 && (deviations[before] * deviations[k]).is_finite() {
                pairs.push((interval, deviations[before], deviations[k], days[k]));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let interval = pairs.get(pairs.len() / 2)?.0;
    pairs.retain(|pair| (pair.0 - interval).abs() <= SAME_INTERVAL * interval);
    let (phi, n) = correlation(pairs.iter().map(|(_, x, y, _)| (*x, *y)))?;
    if n < FEWEST || !(phi > 0.0) {
        return None;
    }
    let count = days.iter().max().map_or(0, |day| day + 1);
    let mut clusters = vec![Cluster::nothing(1); count];
    for (_, x, y, day) in &pairs {
        let both = 0.5 * (x * x + y * y);
        clusters[*day].score[0] += x * y - phi * both;
        clusters[*day].information[(0, 0)] += both;
    }
    let error = day_errors(clusters).map(|errors| errors[0]);
    let power = step_s / interval;
    let over_step = libm::pow(phi, power);
    let error = error.map(|error| error * power * over_step / phi);
    Some((over_step, error, n))
}

fn edge(share: f64) -> f64 {
    share.clamp(EDGE, 1.0 - EDGE)
}

fn logit(share: f64) -> f64 {
    libm::log(share / (1.0 - share))
}
