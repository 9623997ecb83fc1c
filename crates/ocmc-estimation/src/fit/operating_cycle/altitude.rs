//! Slopes of altitudes that scatter and wander: SD and hill length by the likelihood of the
//! altitudes as they were measured, before any average.
//!
//! The slope of a road is Y = m + σ_r s: its mean m, the SD σ_r of the road type, and a
//! standardised state s of the correlation exp(−θ_r x) over the way x, which carries over where the
//! type changes. Over the step L_s of the study it is a = cos(2π L_s/L_h)
//! ([`TopographyModel::coefficient`]), so θ = −ln a/L_s. A slope that is constant on steps whose
//! places nobody knows has the same covariance to (1 − a)²/8 of σ² \[D\]. Over x, with ρ = e^{−θx},
//!
//! - s' = ρ s + ε, z' = z + m x + σ (1 − ρ)/θ s + η,
//! - Var ε = 1 − ρ², Cov(ε, η) = σ (1 − ρ)²/θ, Var η = 2σ²/θ² \[θx − 2(1 − ρ) + (1 − ρ²)/2\],
//! - measured is z + d + e: the error d of a receiver fades with the time t, at rest, too,
//!   d' = φ d + ζ with φ = e^{−t/T} and Var ζ = (1 − φ²) δ²; Var e = τ²/n of the mean of n rows.
//!
//! These are integrals of ds = −θ s dx + √(2θ) dW \[D\]. Kalman's filter over (z, s, m, d) gives
//! the likelihood of all roads, with a prior of m that is flat beside any road: so the mean slope
//! that a bridge to the net climb shifts takes no share of σ. A standstill has x = 0: it tells δ, T
//! and τ and no slope. What lies between two measurements is unknown, however long it is.
//!
//! Below some 100 m, seams between types and the places of the steps would be taken for hills. So
//! each measurement gets a known scatter of 0.3 m, drawn from a stream of its own, as that of whole
//! metres: on that scale it outweighs the slopes, and beside a receiver's it is nothing. Without it
//! hills of 450 m come out as 570 m where altitudes are exact.
//!
//! SD and hill length of a type are estimated together. Where the altitudes leave the hill length
//! an error above half of it, it stays that of the base study and the SD is estimated beside it;
//! where they do not tell that, either, both stay.
//!
//! Source: A. Harvey, Forecasting, Structural Time Series Models and the Kalman Filter (1989),
//! section 3.4 \[PK\]. Checked: `tests/it/fit/plain_log.rs`.

use super::stretch::Stretch;
use crate::fit::descent::{descend, differences};
use crate::fit::study_parameter::Estimates;
use crate::log::road::{LoggedRoad, MeasuredAltitude};
use nalgebra::{DMatrix, SymmetricEigen};
use ocmc_core::operating_cycle::road::RoadModel;
use ocmc_core::operating_cycle::road::route_noise::noise_of_values;
use ocmc_core::operating_cycle::road::topography::TopographyModel;
use ocmc_core::random::{Draws, Stream};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Scatter that each measurement gets, in m.
const ADDED_M: f64 = 0.3;
/// Master seed of its draws.
const ADDED_SEED: u64 = 0x616c_7469_7475_6465;
/// SD of the mean slope of a road before it is seen: flat beside any road.
const MEAN_SLOPE_SD: f64 = 1.0;
/// Smallest scatter and drift that the search tells from none, in m.
const LEAST_M: f64 = 0.02;
/// Smallest scatter where the search begins, in m; the drift begins there at a metre.
const FIRST_M: f64 = 0.1;
/// How long a drift lasts: where the search begins, and bounds of it, in s.
const MEMORY_S: f64 = 60.0;
const MEMORIES_S: [f64; 2] = [2.0, 3600.0];
/// Products of variances within these need no logarithm yet.
const SMALLEST: f64 = 1e-200;
const LARGEST: f64 = 1e200;
/// Way over the decay below which the variance of a climb is expanded.
const SHORT_WAY: f64 = 1e-3;
/// Smallest gain that a step of the search has to promise, in ln likelihood.
const TOLERANCE: f64 = 1e-3;
/// From twice so many roads on, the search begins with one of so many.
const PART: usize = 4;
/// Step of the differences that give the errors, in ln.
const DIFFERENCE: f64 = 1e-2;
/// Curvatures below this are flat: nothing is determined there, as of a noise of 0.
const FLAT: f64 = 1e-2;
/// Largest relative standard error of an estimate (judgement).
const LARGEST_ERROR: f64 = 0.5;
/// SDs and hill lengths that a study takes; hills in m.
const SDS: [f64; 2] = [1e-6, 0.15];
const LONGEST_HILL_M: f64 = 1.0e5;

/// Slopes of one road type by the altitudes of its roads.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Hills {
    /// Way between measurements, in m.
    pub way_m: f64,
    /// Measurements.
    measured: usize,
    /// SD of the slope, and its standard error, where the hill length is determined.
    slope_sd: Option<(f64, Option<f64>)>,
    /// Hill length and its standard error, in m.
    hill_length_m: Option<[f64; 2]>,
    /// Scatter of the altitudes, and how far they wander over a minute, in m.
    noise_m: f64,
    wander_m: f64,
}

/// A way of one type up to a place, and what was measured there.
struct Passage {
    way_m: f64,
    time_s: f64,
    road_type: usize,
    /// Altitude, in m, and the rows of which it is the mean.
    measured: Option<(f64, f64)>,
}

/// The process of one type.
#[derive(Clone, Copy)]
struct SlopeProcess {
    sd: f64,
    decay_per_m: f64,
}

/// The error of a receiver.
#[derive(Clone, Copy)]
struct ErrorProcess {
    /// Variance of what differs from row to row, in m².
    scatter_m2: f64,
    /// Variance of what fades with time, in m².
    drift_m2: f64,
    /// How long that lasts, in s.
    memory_s: f64,
}

impl ErrorProcess {
    /// SD of the change over a minute that is no scatter, in m.
    fn wander_m(self) -> f64 {
        libm::sqrt(2.0 * self.drift_m2 * (1.0 - libm::exp(-60.0 / self.memory_s)))
    }
}

/// Variables of the search: SD and hill length of each type, and the error of the altitudes.
struct Variables {
    step_m: f64,
    types: usize,
}

impl Variables {
    /// Hills are longer than this, in m.
    fn least_m(&self) -> f64 {
        4.0 * self.step_m
    }

    fn of(&self, model: &TopographyModel) -> [f64; 2] {
        let beyond = (model.hill_length_m / self.least_m() - 1.0).max(0.01);
        [libm::log(model.slope_sd), libm::log(beyond)]
    }

    fn hill_length_m(&self, at: &[f64], road_type: usize) -> f64 {
        self.least_m() * (1.0 + libm::exp(at[2 * road_type + 1]))
    }

    fn process(&self, at: &[f64], road_type: usize) -> SlopeProcess {
        let hill_length_m = self.hill_length_m(at, road_type);
        let coefficient = libm::cos(TAU * self.step_m / hill_length_m);
        let decay_per_m = -libm::log(coefficient) / self.step_m;
        SlopeProcess { sd: libm::exp(at[2 * road_type]), decay_per_m }
    }

    /// The error of the altitudes.
    fn error(&self, at: &[f64]) -> ErrorProcess {
        let [scatter_m2, drift_m2] = [0, 1].map(|k| {
            let error_m = libm::exp(at[2 * self.types + k]).max(LEAST_M);
            error_m * error_m
        });
        let memory_s = libm::exp(at[2 * self.types + 2]).clamp(MEMORIES_S[0], MEMORIES_S[1]);
        ErrorProcess { scatter_m2, drift_m2, memory_s }
    }
}

/// The slopes of each type on roads whose altitudes were measured, each with its stretches.
pub(super) fn hills(
    roads: &[(&LoggedRoad, Vec<Stretch>)],
    base: &RoadModel,
) -> BTreeMap<String, Hills> {
    let with_altitudes = || roads.iter().filter(|road| road.0.altitudes.len() > 1);
    let mut of_type: BTreeMap<String, Hills> = with_altitudes()
        .flat_map(|road| road.1.iter().map(|stretch| (stretch.2.to_owned(), Hills::default())))
        .collect();
    if of_type.is_empty() {
        return of_type;
    }
    let names: Vec<String> = of_type.keys().cloned().collect();
    let place = |name: &str| names.binary_search_by(|n| n.as_str().cmp(name)).unwrap_or(0);
    let all: Vec<Vec<Passage>> = with_altitudes()
        .enumerate()
        .map(|(number, (road, stretches))| passages(number, road, stretches, place))
        .collect();
    for passage in all.iter().flatten() {
        if let Some(hills) = of_type.get_mut(&names[passage.road_type]) {
            hills.way_m += passage.way_m;
            hills.measured += usize::from(passage.measured.is_some());
        }
    }
    let models: Vec<&TopographyModel> =
        names.iter().filter_map(|name| Some(&base.types.get(name)?.topography)).collect();
    let noise_m = with_altitudes().map(|(road, _)| {
        let values: Vec<f64> = road.altitudes.iter().map(|at| at.altitude_m).collect();
        noise_of_values(&values)
    });
    let noise_m = noise_m.fold(FIRST_M, f64::max);
    let fits = search(&all, &models, noise_m, base.slope_step_m);
    for (hills, fit) in of_type.values_mut().zip(fits) {
        *hills = Hills { way_m: hills.way_m, measured: hills.measured, ..fit };
    }
    of_type
}

/// The passages of a road: between its measurements, and up to where its type changes.
fn passages(
    number: usize,
    road: &LoggedRoad,
    stretches: &[Stretch],
    place: impl Fn(&str) -> usize,
) -> Vec<Passage> {
    let mut draws = Draws::new(ADDED_SEED, number as u64, Stream::Topography);
    let mut all: Vec<Passage> = Vec::with_capacity(road.altitudes.len() + stretches.len());
    let mut stretches = stretches.iter().peekable();
    let mut before: Option<(f64, f64)> = None;
    for &MeasuredAltitude { position_m, time_s, altitude_m, rows } in &road.altitudes {
        let (mut from_m, from_s) = before.unwrap_or((position_m, time_s));
        while let Some((_, end_m, name)) = stretches.next_if(|stretch| stretch.1 < position_m) {
            let way_m = (end_m - from_m).max(0.0);
            let road_type = place(name);
            all.push(Passage { way_m, time_s: 0.0, road_type, measured: None });
            from_m = from_m.max(*end_m);
        }
        let road_type = match stretches.peek() {
            Some(stretch) => place(stretch.2),
            None => all.last().map_or(0, |last| last.road_type),
        };
        let way_m = (position_m - from_m).max(0.0);
        let measured = Some((altitude_m + ADDED_M * draws.normal(), rows as f64));
        all.push(Passage { way_m, time_s: time_s - from_s, road_type, measured });
        before = Some((position_m, time_s));
    }
    all
}

/// The estimates of all types.
fn search(
    roads: &[Vec<Passage>],
    models: &[&TopographyModel],
    noise_m: f64,
    step_m: f64,
) -> Vec<Hills> {
    let types = models.len();
    let variables = Variables { step_m, types };
    let mut at: Vec<f64> = models.iter().flat_map(|model| variables.of(model)).collect();
    let first = at.clone();
    at.extend([libm::log(noise_m), 0.0, libm::log(MEMORY_S)]);
    let mut held = vec![false; at.len()];
    loop {
        let free: Vec<usize> = (0..at.len()).filter(|k| !held[*k]).collect();
        let whole = |part: &[f64]| {
            let mut whole = at.clone();
            free.iter().zip(part).for_each(|(k, value)| whole[*k] = *value);
            whole
        };
        let of_roads = |part: &[f64], step: usize| {
            let at = whole(part);
            let processes: Vec<_> = (0..types).map(|k| variables.process(&at, k)).collect();
            let error = variables.error(&at);
            let misfit = |road: &Vec<Passage>| minus_log_likelihood(road, &processes, error);
            // in the order of the roads, whoever computes them
            roads.par_iter().step_by(step).map(misfit).collect::<Vec<f64>>().iter().sum::<f64>()
        };
        let mut start: Vec<f64> = free.iter().map(|k| at[*k]).collect();
        if roads.len() >= 2 * PART {
            start = descend(&|part: &[f64]| of_roads(part, PART), &start, TOLERANCE).0;
        }
        let function = |part: &[f64]| of_roads(part, 1);
        let (best, value) = descend(&function, &start, TOLERANCE);
        let (_, bend) = differences(&function, &best, value, DIFFERENCE);
        let errors = errors(bend);
        let optimum = whole(&best);
        let error = |k: usize| {
            let place = free.iter().position(|free| *free == k);
            place.map_or(0.0, |place| errors[place])
        };
        let mut untold = Vec::new();
        for k in 0..types {
            let (sd, hill) = (2 * k, 2 * k + 1);
            let sd_is_in = (SDS[0]..=SDS[1]).contains(&libm::exp(optimum[sd]));
            let sd_is_told = sd_is_in && error(sd) <= LARGEST_ERROR;
            let hill_length_m = variables.hill_length_m(&optimum, k);
            let of_hill = error(hill) * (1.0 - variables.least_m() / hill_length_m);
            let hill_is_told = of_hill <= LARGEST_ERROR && hill_length_m <= LONGEST_HILL_M;
            if !(held[hill] || hill_is_told && sd_is_told) {
                untold.push(hill);
            } else if !(held[sd] || sd_is_told) {
                untold.push(sd);
            }
        }
        if untold.is_empty() {
            let of_altitudes = variables.error(&optimum);
            let of_type = |k: usize| {
                let (sd, hill) = (libm::exp(optimum[2 * k]), variables.hill_length_m(&optimum, k));
                let of_hill = error(2 * k + 1) * (hill - variables.least_m());
                let of_sd = (!held[2 * k + 1]).then(|| error(2 * k) * sd);
                Hills {
                    slope_sd: (!held[2 * k]).then_some((sd, of_sd)),
                    hill_length_m: (!held[2 * k + 1]).then_some([hill, of_hill]),
                    noise_m: libm::sqrt(of_altitudes.scatter_m2),
                    wander_m: of_altitudes.wander_m(),
                    ..Hills::default()
                }
            };
            return (0..types).map(of_type).collect();
        }
        at = optimum;
        for k in untold {
            held[k] = true;
            at[k] = first[k];
        }
    }
}

/// Standard errors from the curvature of the likelihood; endless ones of what is flat.
fn errors(bend: DMatrix<f64>) -> Vec<f64> {
    let count = bend.nrows();
    if !bend.iter().all(|value| value.is_finite()) {
        return vec![f64::INFINITY; count];
    }
    let flat: Vec<bool> = (0..count).map(|k| !(bend[(k, k)] > FLAT)).collect();
    let own = SymmetricEigen::new(bend);
    let mut variances = vec![0.0; count];
    for (vector, curvature) in own.eigenvectors.column_iter().zip(own.eigenvalues.iter()) {
        for (variance, part) in variances.iter_mut().zip(vector.iter()) {
            *variance += part * part / curvature.max(FLAT);
        }
    }
    let error = |(variance, flat): (f64, bool)| {
        if flat { f64::INFINITY } else { libm::sqrt(variance) }
    };
    variances.into_iter().zip(flat).map(error).collect()
}

/// Minus the logarithm of the likelihood of one road; less a constant.
fn minus_log_likelihood(road: &[Passage], processes: &[SlopeProcess], error: ErrorProcess) -> f64 {
    let scatter = |rows: f64| error.scatter_m2 / rows + ADDED_M * ADDED_M;
    let Some(Passage { measured: Some((first_m, rows)), .. }) = road.first() else { return 0.0 };
    // the state and its covariance
    let (mut z, mut s, mut m, mut e) = (*first_m, 0.0, 0.0, 0.0);
    let (mut zz, mut ze, mut ee) =
        (error.drift_m2 + scatter(*rows), -error.drift_m2, error.drift_m2);
    let (mut zs, mut zm, mut se, mut me) = (0.0, 0.0, 0.0, 0.0);
    let (mut ss, mut sm, mut mm) = (1.0, 0.0, MEAN_SLOPE_SD * MEAN_SLOPE_SD);
    let (mut sum, mut product) = (0.0, 1.0);
    let (mut time_s, mut fades) = (0.0, 1.0);
    for passage in &road[1..] {
        let SlopeProcess { sd, decay_per_m } = processes[passage.road_type];
        let (x, way_m) = (decay_per_m * passage.way_m, passage.way_m);
        if x > 0.0 {
            let rest = libm::exp(-x);
            let lost = 1.0 - rest * rest;
            let of_state = sd * (1.0 - rest) / decay_per_m;
            let shape = if x < SHORT_WAY {
                x * x * x * (1.0 / 3.0 - 0.25 * x)
            } else {
                x - 2.0 * (1.0 - rest) + 0.5 * lost
            };
            let climb = 2.0 * sd * sd * shape / (decay_per_m * decay_per_m);
            let both = sd * (1.0 - rest) * (1.0 - rest) / decay_per_m;
            z += of_state * s + way_m * m;
            s *= rest;
            zz += of_state * of_state * ss
                + way_m * way_m * mm
                + 2.0 * (of_state * zs + way_m * zm + of_state * way_m * sm)
                + climb;
            zs = rest * (zs + of_state * ss + way_m * sm) + both;
            zm += of_state * sm + way_m * mm;
            ze += of_state * se + way_m * me;
            ss = rest * rest * ss + lost;
            sm *= rest;
            se *= rest;
        }
        if passage.time_s > 0.0 {
            // rows are mostly equally far apart
            if passage.time_s != time_s {
                time_s = passage.time_s;
                fades = libm::exp(-time_s / error.memory_s);
            }
            e *= fades;
            ze *= fades;
            se *= fades;
            me *= fades;
            ee = fades * fades * ee + (1.0 - fades * fades) * error.drift_m2;
        }
        if let Some((measured_m, rows)) = passage.measured {
            let [of_z, of_s, of_m, of_e] = [zz + ze, zs + se, zm + me, ze + ee];
            let variance = of_z + of_e + scatter(rows);
            let off = measured_m - z - e;
            sum += off * off / variance;
            product *= variance;
            if !(SMALLEST..=LARGEST).contains(&product) {
                sum += libm::log(product);
                product = 1.0;
            }
            let per = 1.0 / variance;
            let [gain_z, gain_s, gain_m, gain_e] = [of_z * per, of_s * per, of_m * per, of_e * per];
            z += gain_z * off;
            s += gain_s * off;
            m += gain_m * off;
            e += gain_e * off;
            zz -= gain_z * of_z;
            zs -= gain_z * of_s;
            zm -= gain_z * of_m;
            ze -= gain_z * of_e;
            ss -= gain_s * of_s;
            sm -= gain_s * of_m;
            se -= gain_s * of_e;
            mm -= gain_m * of_m;
            me -= gain_m * of_e;
            ee -= gain_e * of_e;
        }
    }
    0.5 * (sum + libm::log(product))
}

/// Lays what altitudes determine over the model of a type.
pub(super) fn set_hills(hills: &Hills, model: &mut TopographyModel, estimates: &mut Estimates) {
    let n = hills.measured;
    let km = hills.way_m / 1000.0;
    let Some((sd, error)) = hills.slope_sd else {
        return estimates.warn(format_args!(
            "altitudes over {km:.1} km do not tell its slopes, which stay those of the base study"
        ));
    };
    estimates.set("topography.slope_sd", &mut model.slope_sd, sd, error, n);
    if let Some([hill, error]) = hills.hill_length_m {
        let into = &mut model.hill_length_m;
        estimates.set("topography.hill_length_m", into, hill, Some(error), n);
    } else {
        estimates.warn(format_args!(
            "altitudes over {km:.1} km tell hardly more than the product of the slope's SD and the \
             root of the hill length: that length, {} m, stays that of the base study, and \
             `topography.slope_sd` is what goes with it, without a standard error",
            model.hill_length_m
        ));
    }
    estimates.push("altitudes, scatter in m", hills.noise_m, None, n);
    estimates.push("altitudes, wander over a minute in m", hills.wander_m, None, n);
}
