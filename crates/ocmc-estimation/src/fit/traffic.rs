//! The traffic model of measured densities: what [`ocmc_core::operating_cycle::traffic`] draws,
//! estimated.
//!
//! logit x = logit m_r(H) + u: the typical shares off peak and at the peak of each road type by
//! least squares on the logit scale (Gauss and Newton's method), with the hours and widths of the
//! peaks as the base study has them; SD of u, and its correlation over a step from records that
//! follow each other at the same site: records τ apart determine φ^(τ/step).

use super::study_parameter::{Estimates, StudyParameterFit, reasons};
use crate::moments::correlation;
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
    /// What does not stop the fit and has to be known.
    pub warnings: Vec<String>,
    /// The model: the base study's, with what was estimated laid over it.
    #[serde(skip)]
    pub model: TrafficModel,
}

/// Fewest densities of a type.
const FEWEST: usize = 48;
/// Closest that a share comes to 0 and 1 on the logit scale.
const EDGE: f64 = 0.005;
/// How far two intervals may differ and still be one, as a share of it.
const SAME_INTERVAL: f64 = 0.01;
/// Heights of the peak that have to be seen, as shares of it (judgement): one of them is an
/// extrapolation otherwise.
const SEEN: [f64; 2] = [0.25, 0.75];
/// Rounds after which Gauss and Newton's method is given up.
const MOST_ROUNDS: usize = 100;

/// Fits the traffic model. `base` gives what the records do not determine: hours and widths of the
/// peaks, jam and critical density.
///
/// # Errors
/// [`TrafficFitError`] says what the records lack.
pub fn fit(records: &[TrafficRecord], base: &TrafficModel) -> Result<TrafficFit, TrafficFitError> {
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
    let cut = records.iter().filter(|record| record.share != edge(record.share)).count() - missing;
    let beyond =
        format!("densities beyond {EDGE} from 0 and 1 of the jam density are taken as there");
    warn(cut, &beyond);
    let mut deviations = vec![f64::NAN; records.len()];
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
        let shares = if seen { typical_shares(&values) } else { None };
        let Some((off, peak)) = shares else {
            estimates.stays("the hours do not tell peak and off peak apart");
            continue;
        };
        for (key, into, share) in [
            ("off_peak_share", &mut of_type.off_peak_share, off),
            ("peak_share", &mut of_type.peak_share, peak),
        ] {
            estimates.set(&format!("types.{road_type}.{key}"), into, share, None, count);
        }
        for (k, (bell, value)) in places.iter().zip(&values) {
            deviations[*k] = value - logit(off + (peak - off) * bell);
        }
    }
    if estimates.parameters.is_empty() {
        let reasons = reasons(&estimates.warnings);
        return Err(TrafficFitError::Nothing { records: records.len(), reasons });
    }
    let known: Vec<f64> = deviations.iter().copied().filter(|u| u.is_finite()).collect();
    let sd = (known.iter().map(|u| u * u).sum::<f64>() / known.len() as f64).sqrt();
    estimates.set("logit_sd", &mut model.logit_sd, sd, None, known.len());
    match step_correlation(records, &deviations, base.step_s) {
        Some((phi, pairs)) => {
            estimates.set("step_correlation", &mut model.step_correlation, phi, None, pairs);
        }
        None => estimates.warnings.push(
            "no densities follow each other at one site, at one interval and alike; the correlation stays that of the base study".to_owned(),
        ),
    }
    let Estimates { parameters, warnings, .. } = estimates;
    Ok(TrafficFit { n, parameters, warnings, model })
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

/// The correlation over a step, and from how many pairs.
fn step_correlation(
    records: &[TrafficRecord],
    deviations: &[f64],
    step_s: f64,
) -> Option<(f64, usize)> {
    let mut last: BTreeMap<&str, usize> = BTreeMap::new();
    let mut pairs = Vec::new();
    for (k, record) in records.iter().enumerate() {
        if let Some(before) = last.insert(&record.site, k) {
            let interval = record.time_s - records[before].time_s;
            if interval > 0.0 && (deviations[before] * deviations[k]).is_finite() {
                pairs.push((interval, deviations[before], deviations[k]));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let interval = pairs.get(pairs.len() / 2)?.0;
    let alike = pairs.iter().filter(|p| (p.0 - interval).abs() <= SAME_INTERVAL * interval);
    let (phi, n) = correlation(alike.map(|(_, x, y)| (*x, *y)))?;
    (n >= FEWEST && phi > 0.0).then(|| (libm::pow(phi, step_s / interval), n))
}

fn edge(share: f64) -> f64 {
    share.clamp(EDGE, 1.0 - EDGE)
}

fn logit(share: f64) -> f64 {
    libm::log(share / (1.0 - share))
}
