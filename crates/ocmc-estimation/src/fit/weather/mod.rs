//! The weather model of hourly records of one place: what [`ocmc_core::operating_cycle::weather`]
//! draws, estimated.
//!
//! - temperature and humidity: the harmonics of year and day by least squares; SD and correlation
//!   over an hour of what they leave, the temperature's SD by season from E|ξ| = SD √(2/π);
//! - pressure: SD and correlation about its mean;
//! - rain and snow: wet hours by counts, the intensity of wet hours by the gamma likelihood;
//! - wind: the Weibull likelihood of the speeds, correlation of their normal scores; the direction
//!   by the moments of a wrapped normal law, E cos(θ − θ₀) = exp(−SD²/2) and E cos(θ' − θ) =
//!   exp(−SD²(1 − φ)).
//!
//! Standard errors are those of the model: of normal autoregressions with the estimated φ, over the
//! times that were recorded. A harmonic's follows from the sum over all pairs of hours; that of the
//! humidity's also has the errors of the temperature's harmonics, from which its deviations are
//! taken; those of the Weibull law and of directions follow from their functions of normal scores
//! (`autocorrelated.rs`), √((1 − φ²)/n) is that of a correlation. What the fitted means took
//! of a sum of squares is restored to the standard deviations. A variable that is nowhere recorded
//! keeps the numbers of the base study, and so do temperature and humidity of records that lack a
//! season, or day or night: harmonics of what was not seen are extrapolated.

mod memory;
mod wind;

use super::autocorrelated::{inflation, long_run, sd_error};
use super::least_squares::LeastSquares;
use super::study_parameter::{Estimates, StudyParameterFit, reasons};
use nalgebra::DMatrix;
use ocmc_core::distribution::{Law, gamma};
use ocmc_core::operating_cycle::weather::{
    HumidityModel, PrecipitationModel, TemperatureModel, Weather, WeatherModel, night, season,
    standard_pressure_pa,
};
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;
use thiserror::Error;

/// The weather of one hour. What was not recorded is NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HourlyRecord {
    /// Time since some midnight, in s; the records are in order of it.
    pub time_s: f64,
    /// Day of the year, from 0, with its fraction.
    pub day_of_year: f64,
    /// Recorded weather; `snow` is not looked at.
    pub weather: Weather,
}

/// Why records have no fit.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum WeatherFitError {
    /// No variable can be estimated.
    #[error("{hours} hourly records say nothing that can be estimated: {reasons}")]
    Nothing {
        /// Records.
        hours: usize,
        /// Why, for each variable.
        reasons: String,
    },
}

/// The weather model of records.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WeatherFit {
    /// Records.
    pub hours: usize,
    /// From the first to the last, in years of 365 days.
    pub years: f64,
    /// Numbers that were estimated.
    pub parameters: Vec<StudyParameterFit>,
    /// Facts that do not stop the fit and have to be known.
    pub warnings: Vec<String>,
    /// The model: the base study's, with what was estimated laid over it.
    #[serde(skip)]
    pub model: WeatherModel,
}

/// Years below which the seasons are not distinguished from single winters.
const ENOUGH_YEARS: f64 = 3.0;
/// Difference of a mean pressure from the standard atmosphere's at which the records are of another
/// altitude, in Pa: some 80 m.
const PRESSURE_OF_ANOTHER_PLACE_PA: f64 = 1000.0;

/// Fewest values from which anything is estimated.
const FEWEST: usize = 48;
/// An hour, and how far two records that are an hour apart may be off it, in s.
const HOUR_S: f64 = 3600.0;
/// Harmonics of year and day have to be seen up to here on both sides of 0 (judgement): from
/// November to February, and from May to August.
const HARMONIC_SEEN: f64 = 0.5;
/// Closest that a humidity comes to 0 and 1 on the logit scale.
const HUMIDITY_EDGE: f64 = 0.005;

/// Covariances of the sizes of two normal scores that go together with ρ, over π/2: √(1 − ρ²) + ρ
/// asin ρ − 1 = Σ c_m ρ^(2m). The last one has the rest of the series, π/2 − 1 at ρ = 1.
const SIZE_SERIES: [f64; 5] = [0.5, 1.0 / 24.0, 1.0 / 80.0, 5.0 / 896.0, 0.011_049];

/// Deviations of the temperatures, as the humidity needs them.
struct Temperatures {
    /// Deviations of each record from the harmonics, in K.
    deviation_k: Vec<f64>,
    /// Covariance of the coefficients of [`harmonics`].
    covariance: DMatrix<f64>,
}

struct Hours<'a> {
    records: &'a [HourlyRecord],
    /// Places of records that a step parts.
    pairs: Vec<[usize; 2]>,
    /// The step, in h: 1, or more where records are farther apart.
    step_h: f64,
    estimates: Estimates<'static>,
}

/// Fits the weather model. `base` gives what the records do not determine: the altitude, when it
/// snows, variables not recorded.
///
/// # Errors
/// [`WeatherFitError`] where nothing can be estimated.
pub fn fit(records: &[HourlyRecord], base: &WeatherModel) -> Result<WeatherFit, WeatherFitError> {
    let (pairs, step_s) = memory::pairs(records);
    let mut model = base.clone();
    let (step_h, estimates) = (step_s / HOUR_S, Estimates::default());
    let mut hours = Hours { records, pairs, step_h, estimates };
    let temperatures = hours.temperature(&mut model.temperature);
    hours.pressure(&mut model);
    hours.humidity(temperatures.as_ref(), &mut model.humidity);
    hours.precipitation(&mut model.precipitation);
    hours.wind_speed(&mut model.wind);
    hours.wind_direction(&mut model.wind);
    let Estimates { parameters, mut warnings, .. } = hours.estimates;
    if parameters.is_empty() {
        return Err(WeatherFitError::Nothing { hours: records.len(), reasons: reasons(&warnings) });
    }
    // each record stands for an hour
    let span_s = records[records.len() - 1].time_s - records[0].time_s + HOUR_S;
    let years = span_s / (365.0 * 86_400.0);
    if years < ENOUGH_YEARS {
        warnings.push(format!(
            "the records span {years:.1} years; with less than {ENOUGH_YEARS} the seasons are \
             those of single years, and intervals of the SDs by their errors cover some 90 %, not \
             95 %"
        ));
    }
    Ok(WeatherFit { hours: records.len(), years, parameters, warnings, model })
}

impl Hours<'_> {
    /// Places of the records that have a value; none where there are too few.
    fn recorded(&mut self, name: &'static str, value: fn(&Weather) -> f64) -> Option<Vec<usize>> {
        self.estimates.name = name;
        let places: Vec<usize> = (0..self.records.len())
            .filter(|k| value(&self.records[*k].weather).is_finite())
            .collect();
        let n = places.len();
        if n < FEWEST {
            self.estimates.stays(format_args!("{n} values, at least {FEWEST} are needed"));
            return None;
        }
        let missing = self.records.len() - n;
        if missing > 0 {
            self.estimates.warn(format_args!("{missing} records have none"));
        }
        Some(places)
    }

    /// Time of a record, in h.
    fn time_h(&self, place: usize) -> f64 {
        self.records[place].time_s / HOUR_S
    }

    /// Whether these records determine the harmonics of year and day.
    fn tells_harmonics(&mut self, places: &[usize]) -> bool {
        let seen = |value_of: fn((f64, f64)) -> f64| {
            let values = places.iter().map(|place| value_of(clock(&self.records[*place])));
            let (low, high) =
                values.fold((1.0f64, -1.0f64), |(low, high), x| (low.min(x), high.max(x)));
            low <= -HARMONIC_SEEN && high >= HARMONIC_SEEN
        };
        let lacks = match (seen(|clock| clock.0), seen(|clock| clock.1)) {
            (true, true) => return true,
            (false, _) => "winter or summer",
            (true, false) => "day or night",
        };
        self.estimates.stays(format_args!("the records lack {lacks}"));
        false
    }

    /// Temperatures; what they leave to the humidity.
    fn temperature(&mut self, model: &mut TemperatureModel) -> Option<Temperatures> {
        let places = self.recorded("temperature", |w| w.temperature_k)?;
        if !self.tells_harmonics(&places) {
            return None;
        }
        let n = places.len();
        let records = self.records;
        let at = |k: usize| &records[places[k]];
        let fitted = LeastSquares::reduce(n, 4, |k, x| {
            x.copy_from_slice(&harmonics(at(k)));
            at(k).weather.temperature_k
        });
        let Ok(fitted) = fitted else {
            self.estimates.stays("the records do not tell day and year apart");
            return None;
        };
        let coefficients = fitted.coefficients();
        let left = |record: &HourlyRecord| {
            let (season, night) = clock(record);
            record.weather.temperature_k - coefficients[0]
                + coefficients[1] * season
                + (coefficients[2] + coefficients[3] * season) * night
        };
        let sizes = LeastSquares::reduce(n, 2, |k, x| {
            x.copy_from_slice(&[1.0, clock(at(k)).0]);
            left(at(k)).abs() * FRAC_PI_2.sqrt()
        });
        let sizes = sizes.expect("the season is among the harmonics");
        let mut spread = sizes.coefficients();
        if spread[0] <= spread[1].abs() {
            self.estimates.warn("one season comes out without spread; both SDs are the mean one");
            spread[1] = 0.0;
        }
        let sd_k = |r: &HourlyRecord| spread[0] + spread[1] * clock(r).0;
        let scores: Vec<f64> = self.records.iter().map(|r| left(r) / sd_k(r)).collect();
        let deviation_k = self.records.iter().map(left).collect();
        // the sandwich of what the memory of the deviations does to the coefficients
        let phi = self.hourly_correlation(&scores).map_or(0.0, |(phi, _)| phi);
        let gram = fitted.inverse_gram();
        let rows =
            (0..n).map(|k| (self.time_h(places[k]), harmonics(at(k)).map(|x| x * sd_k(at(k)))));
        let products = long_run(rows, phi);
        let all: f64 = (0..n).map(|k| sd_k(at(k)) * sd_k(at(k))).sum();
        let larger = restored((&gram * &products).trace(), all);
        let covariance = &gram * products * &gram;
        let size_gram = sizes.inverse_gram();
        let size_covariance = SIZE_SERIES.iter().enumerate().map(|(m, weight)| {
            let rows = (0..n).map(|k| {
                let (season, _) = clock(at(k));
                (self.time_h(places[k]), [1.0, season].map(|x| x * sd_k(at(k))))
            });
            let phi = libm::pow(phi.max(0.0), 2.0 * (m + 1) as f64);
            &size_gram * long_run(rows, phi) * &size_gram * *weight
        });
        let size_covariance = size_covariance.fold(DMatrix::zeros(2, 2), |sum, part| sum + part);
        let temperatures = Temperatures { deviation_k, covariance };
        let covariance = &temperatures.covariance;
        if coefficients[1] < -2.0 * covariance[(1, 1)].sqrt() {
            self.estimates.warn(
                "its coldest days lie in July, and a study knows northern seasons only; it stays \
                 that of the base study, and a table whose clock is half a year ahead tells it",
            );
            return Some(temperatures);
        }
        if coefficients[2] < 0.0 {
            self.estimates.warn(
                "its nights are warmer than its days; is the clock the place's standard time?",
            );
        }
        let into = &mut model.hourly_correlation;
        self.correlate("temperature.hourly_correlation", &scores, into);
        let mut set = |key, into: &mut f64, value, variance: f64| {
            let key = format!("temperature.{key}");
            self.estimates.set(&key, into, value, Some(variance.max(0.0).sqrt()), n);
        };
        // of the sum of two coefficients, or of their difference
        let both = |c: &DMatrix<f64>, a: usize, b: usize, side: f64| {
            c[(a, a)] + c[(b, b)] + 2.0 * side * c[(a, b)]
        };
        set("mean_k", &mut model.mean_k, coefficients[0], covariance[(0, 0)]);
        // a place without seasons: within its error below 0
        let annual_k = coefficients[1].max(0.0);
        set("annual_amplitude_k", &mut model.annual_amplitude_k, annual_k, covariance[(1, 1)]);
        for (key, into, side) in [
            ("winter_daily_amplitude_k", &mut model.winter_daily_amplitude_k, 1.0),
            ("summer_daily_amplitude_k", &mut model.summer_daily_amplitude_k, -1.0),
        ] {
            set(key, into, coefficients[2] + side * coefficients[3], both(covariance, 2, 3, side));
        }
        for (key, into, side) in [
            ("winter_sd_k", &mut model.winter_sd_k, 1.0),
            ("summer_sd_k", &mut model.summer_sd_k, -1.0),
        ] {
            let sd = larger * (spread[0] + side * spread[1]);
            set(key, into, sd, both(&size_covariance, 0, 1, side));
        }
        Some(temperatures)
    }

    fn pressure(&mut self, model: &mut WeatherModel) {
        let Some(places) = self.recorded("pressure", |w| w.pressure_pa) else { return };
        let n = places.len();
        let values = places.iter().map(|place| self.records[*place].weather.pressure_pa);
        let mean = values.sum::<f64>() / n as f64;
        let standard = standard_pressure_pa(model.altitude_m);
        if (mean - standard).abs() > PRESSURE_OF_ANOTHER_PLACE_PA {
            self.estimates.warn(format_args!(
                "the mean is {:.0} hPa; a study draws it around the standard atmosphere's {:.0} \
                 hPa at its weather.altitude_m = {}: give the place's",
                mean / 100.0,
                standard / 100.0,
                model.altitude_m
            ));
        }
        let deviations: Vec<f64> =
            self.records.iter().map(|record| record.weather.pressure_pa - mean).collect();
        let model = &mut model.pressure;
        let phi = self.hourly_correlation(&deviations).map_or(0.0, |(phi, _)| self.over_step(phi));
        let sd = root_mean_square(&deviations) * restored(inflation(phi), n as f64);
        self.estimates.set("pressure.sd", &mut model.sd, sd, Some(sd_error(sd, phi, n)), n);
        let into = &mut model.hourly_correlation;
        self.correlate("pressure.hourly_correlation", &deviations, into);
    }

    fn humidity(&mut self, temperatures: Option<&Temperatures>, model: &mut HumidityModel) {
        let warmer = temperatures.map(|temperatures| temperatures.deviation_k.as_slice());
        let recorded = self.recorded("humidity", |w| w.relative_humidity);
        let Some(mut places) = recorded else { return };
        if let Some(warmer) = warmer {
            places.retain(|place| warmer[*place].is_finite());
        }
        if !self.tells_harmonics(&places) {
            return;
        }
        let n = places.len();
        let edge = |share: f64| share.clamp(HUMIDITY_EDGE, 1.0 - HUMIDITY_EDGE);
        let width = if warmer.is_some() { 4 } else { 3 };
        let row = |k: usize, x: &mut [f64]| {
            let record = &self.records[places[k]];
            let (season, night) = clock(record);
            let warm = warmer.map_or(0.0, |warmer| warmer[places[k]]);
            x.copy_from_slice(&[1.0, season, night, warm][..width]);
            let share = edge(record.weather.relative_humidity);
            libm::log(share / (1.0 - share))
        };
        let Ok(fit) = LeastSquares::reduce(n, width, row) else {
            return self.estimates.stays("the records do not tell day and year apart");
        };
        let coefficients = fit.coefficients();
        let mut deviations = vec![f64::NAN; self.records.len()];
        let mut predictors = vec![0.0; width];
        for (k, place) in places.iter().enumerate() {
            let value = row(k, &mut predictors);
            let expected: f64 =
                predictors.iter().zip(coefficients.iter()).map(|(x, b)| x * b).sum();
            deviations[*place] = value - expected;
        }
        let cut = places.iter().map(|place| self.records[*place].weather.relative_humidity);
        let cut = cut.filter(|share| edge(*share) != *share).count();
        if cut > 0 {
            self.estimates.warn(format_args!(
                "{cut} values beyond {HUMIDITY_EDGE} from 0 and 1 are taken as there"
            ));
        }
        if warmer.is_none() {
            let slope = model.temperature_slope_per_k;
            self.estimates.warn(format_args!(
                "without temperatures its slope stays {slope} per K, that of the base study"
            ));
        }
        let into = &mut model.hourly_correlation;
        let phi = self.correlate("humidity.hourly_correlation", &deviations, into);
        let over_step = self.over_step(phi);
        let gram = fit.inverse_gram();
        // columns that are not fitted stay 0
        let columns = |k: usize| {
            let (season, night) = clock(&self.records[places[k]]);
            [1.0, season, night, warmer.map_or(0.0, |warmer| warmer[places[k]])]
        };
        let rows = (0..n).map(|k| (self.time_h(places[k]), columns(k)));
        let own = long_run(rows, phi).view((0, 0), (width, width)).into_owned();
        let taken = (&gram * &own).trace();
        let sd = root_mean_square(&deviations) * restored(taken, n as f64);
        let own = own * (sd * sd);
        let mut covariance = &gram * own * &gram;
        if let Some(temperatures) = temperatures {
            // the deviations lie off the true ones by the errors of the temperature's harmonics
            let mut products = DMatrix::zeros(width, 4);
            for k in 0..n {
                let (row, of_temperature) = (columns(k), harmonics(&self.records[places[k]]));
                for a in 0..width {
                    for b in 0..4 {
                        products[(a, b)] += row[a] * of_temperature[b];
                    }
                }
            }
            let follows = &gram * products * coefficients[3];
            covariance += &follows * &temperatures.covariance * follows.transpose();
        }
        let mut set = |key, into: &mut f64, value, error: f64| {
            self.estimates.set(&format!("humidity.{key}"), into, value, Some(error), n);
        };
        let error = |c: usize| covariance[(c, c)].sqrt();
        set("mean_logit", &mut model.mean_logit, coefficients[0], error(0));
        set("annual_amplitude", &mut model.annual_amplitude, coefficients[1], error(1));
        set("daily_amplitude", &mut model.daily_amplitude, coefficients[2], error(2));
        set("sd", &mut model.sd, sd, sd_error(sd, over_step, n));
        if warmer.is_some() {
            set(
                "temperature_slope_per_k",
                &mut model.temperature_slope_per_k,
                coefficients[3],
                error(3),
            );
        }
    }

    fn precipitation(&mut self, model: &mut PrecipitationModel) {
        let recorded = self.recorded("precipitation", |w| w.precipitation_mps);
        let Some(places) = recorded else { return };
        let value = |place: usize| self.records[place].weather.precipitation_mps;
        // hours that follow a dry and a wet one, and how many of them are wet
        let mut counts = [[0_usize; 2]; 2];
        for [a, b] in self.hour_pairs() {
            if value(*a).is_finite() && value(*b).is_finite() {
                let [hours, wet] = &mut counts[usize::from(value(*a) > 0.0)];
                *hours += 1;
                *wet += usize::from(value(*b) > 0.0);
            }
        }
        for ([hours, wet], key, into) in [
            (counts[0], "precipitation.wet_after_dry", &mut model.wet_after_dry),
            (counts[1], "precipitation.wet_after_wet", &mut model.wet_after_wet),
        ] {
            if hours >= FEWEST {
                self.estimates.share(key, into, wet, hours);
                continue;
            }
            self.estimates.name = key;
            self.estimates.stays(format_args!("{hours} hours, at least {FEWEST} are needed"));
        }
        let wet: Vec<f64> =
            places.iter().map(|place| value(*place)).filter(|rate| *rate > 0.0).collect();
        let n = wet.len();
        match gamma::fit(&wet) {
            Some(Law::Gamma { mean, shape }) if n >= FEWEST => {
                let error = Some(mean / (shape * n as f64).sqrt());
                let into = &mut model.mean_intensity_mps;
                self.estimates.set("precipitation.mean_intensity_mps", into, mean, error, n);
                let into = &mut model.intensity_shape;
                let information = n as f64 * (gamma::trigamma(shape) - 1.0 / shape);
                let error = Some(1.0 / information.sqrt());
                self.estimates.set("precipitation.intensity_shape", into, shape, error, n);
            }
            _ => {
                self.estimates.name = "precipitation";
                self.estimates.stays(format_args!("{n} wet hours tell no law of the intensity"));
            }
        }
    }
}

/// Season and night of a record, as cosines that are 1 on the coldest day and in the coldest hour.
fn clock(record: &HourlyRecord) -> (f64, f64) {
    (season(record.day_of_year), night(24.0 * record.day_of_year.fract()))
}

/// The columns of the temperature: mean, and the harmonics of the year, of the day, and of both.
fn harmonics(record: &HourlyRecord) -> [f64; 4] {
    let (season, night) = clock(record);
    [1.0, -season, -night, -night * season]
}

/// By what a standard deviation of residuals is too small, where a fit took `taken` of an expected
/// sum of squares `all`: a mean of values that remember takes more than one of them.
fn restored(taken: f64, all: f64) -> f64 {
    1.0 / libm::sqrt((1.0 - taken / all).max(0.1))
}

/// Root mean square of the values that are there.
fn root_mean_square(values: &[f64]) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for value in values.iter().filter(|value| value.is_finite()) {
        sum += value * value;
        n += 1.0;
    }
    libm::sqrt(sum / n)
}
