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
//! Standard errors are those of independent values times √((1 + φ)/(1 − φ)), and √((1 − φ²)/n) for
//! a correlation φ. They are left out where they have no simple form. A variable that is nowhere
//! recorded keeps the numbers of the base study, and so do temperature and humidity of records that
//! lack a season, or day or night: harmonics of what was not seen are extrapolated.

use super::least_squares::LeastSquares;
use super::operating_cycle::StudyParameterFit;
use ocmc_core::distribution::{Law, gamma, weibull};
use ocmc_core::operating_cycle::weather::{
    Weather, WeatherModel, night, season, standard_pressure_pa,
};
use ocmc_core::special_functions::normal_quantile;
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
    /// What was recorded; `snow` is not looked at.
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
    /// What does not stop the fit and has to be known.
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
const OFF_S: f64 = 1.0;
/// Harmonics of year and day have to be seen up to here on both sides of 0 (judgement): from
/// November to February, and from May to August.
const HARMONIC_SEEN: f64 = 0.5;
/// Closest that a humidity comes to 0 and 1 on the logit scale.
const HUMIDITY_EDGE: f64 = 0.005;

struct Estimates<'a> {
    records: &'a [HourlyRecord],
    /// Places of records that an hour parts.
    pairs: Vec<[usize; 2]>,
    parameters: Vec<StudyParameterFit>,
    warnings: Vec<String>,
}

/// Fits the weather model. `base` gives what the records do not determine: the altitude, when it
/// snows, variables not recorded.
///
/// # Errors
/// [`WeatherFitError`] where nothing can be estimated.
pub fn fit(records: &[HourlyRecord], base: &WeatherModel) -> Result<WeatherFit, WeatherFitError> {
    let pairs = (1..records.len())
        .filter(|k| (records[*k].time_s - records[*k - 1].time_s - HOUR_S).abs() <= OFF_S)
        .map(|k| [k - 1, k])
        .collect();
    let mut model = base.clone();
    let mut estimates = Estimates { records, pairs, parameters: Vec::new(), warnings: Vec::new() };
    let deviations = estimates.temperature(&mut model);
    estimates.pressure(&mut model);
    estimates.humidity(deviations.as_deref(), &mut model);
    estimates.precipitation(&mut model);
    estimates.wind(&mut model);
    let Estimates { parameters, mut warnings, .. } = estimates;
    if parameters.is_empty() {
        let reasons = warnings.join("; ").replace("; it stays that of the base study", "");
        return Err(WeatherFitError::Nothing { hours: records.len(), reasons });
    }
    // each record stands for an hour
    let span_s = records[records.len() - 1].time_s - records[0].time_s + HOUR_S;
    let years = span_s / (365.0 * 86_400.0);
    if years < ENOUGH_YEARS {
        warnings.push(format!(
            "the records span {years:.1} years; with less than {ENOUGH_YEARS} the seasons are those of single years"
        ));
    }
    Ok(WeatherFit { hours: records.len(), years, parameters, warnings, model })
}

impl Estimates<'_> {
    fn push(&mut self, key: &str, value: f64, standard_error: Option<f64>, n: usize) {
        self.parameters.push(StudyParameterFit { key: key.to_owned(), value, standard_error, n });
    }

    /// Places of the records that have a value; none where there are too few.
    fn recorded(&mut self, name: &str, value: impl Fn(&Weather) -> f64) -> Option<Vec<usize>> {
        let places: Vec<usize> = (0..self.records.len())
            .filter(|k| value(&self.records[*k].weather).is_finite())
            .collect();
        if places.len() < FEWEST {
            let n = places.len();
            self.warnings.push(format!(
                "{name}: {n} values, at least {FEWEST} are needed; it stays that of the base study"
            ));
            return None;
        }
        let missing = self.records.len() - places.len();
        if missing > 0 {
            self.warnings.push(format!("{name}: {missing} records have none"));
        }
        Some(places)
    }

    /// The correlation of values over an hour, and from how many pairs.
    fn hourly_correlation(&self, values: &[f64]) -> Option<(f64, usize)> {
        let (mut before, mut after, mut both, mut n) = (0.0, 0.0, 0.0, 0);
        for [a, b] in &self.pairs {
            let (x, y) = (values[*a], values[*b]);
            if x.is_finite() && y.is_finite() {
                before += x * x;
                after += y * y;
                both += x * y;
                n += 1;
            }
        }
        // what does not vary has no correlation
        (n >= FEWEST && before * after > 0.0).then(|| (both / (before * after).sqrt(), n))
    }

    /// Estimates a correlation over an hour; what it inflates standard errors by.
    fn correlate(&mut self, key: &str, values: &[f64], into: &mut f64) -> f64 {
        let Some((phi, n)) = self.hourly_correlation(values) else {
            self.warnings.push(format!(
                "{key}: fewer than {FEWEST} records are an hour apart, or all are the same; it stays that of the base study"
            ));
            return inflation(*into);
        };
        if phi < 0.0 {
            self.warnings.push(format!(
                "{key}: an hour is forgotten by the next; the estimate {phi:.3} is taken as 0"
            ));
        }
        let phi = phi.max(0.0);
        let error = ((1.0 - phi * phi).max(0.0) / n as f64).sqrt();
        self.push(key, phi, Some(error), n);
        *into = phi;
        inflation(phi)
    }

    /// Whether these records determine the harmonics of year and day.
    fn tells_harmonics(&mut self, name: &str, places: &[usize]) -> bool {
        let seen = |of: fn((f64, f64)) -> f64| {
            let values = places.iter().map(|place| of(clock(&self.records[*place])));
            let (low, high) =
                values.fold((1.0f64, -1.0f64), |(low, high), x| (low.min(x), high.max(x)));
            low <= -HARMONIC_SEEN && high >= HARMONIC_SEEN
        };
        let lacks = match (seen(|clock| clock.0), seen(|clock| clock.1)) {
            (true, true) => return true,
            (false, _) => "winter or summer",
            (true, false) => "day or night",
        };
        self.warnings
            .push(format!("{name}: the records lack {lacks}; it stays that of the base study"));
        false
    }

    /// Temperatures; what the harmonics leave of each.
    fn temperature(&mut self, model: &mut WeatherModel) -> Option<Vec<f64>> {
        let places = self.recorded("temperature", |w| w.temperature_k)?;
        if !self.tells_harmonics("temperature", &places) {
            return None;
        }
        let records = self.records;
        let clock = |k: usize| clock(&records[places[k]]);
        let value = |k: usize| records[places[k]].weather.temperature_k;
        let harmonics = LeastSquares::reduce(places.len(), 4, |k, x| {
            let (season, night) = clock(k);
            x.copy_from_slice(&[1.0, -season, -night, -night * season]);
            value(k)
        });
        let Ok(harmonics) = harmonics else {
            self.warnings.push("temperature: the records do not tell day and year apart; it stays that of the base study".into());
            return None;
        };
        let found = harmonics.coefficients();
        let left = |k: usize| {
            let (season, night) = clock(k);
            value(k) - found[0] + found[1] * season + (found[2] + found[3] * season) * night
        };
        let spread = LeastSquares::reduce(places.len(), 2, |k, x| {
            x.copy_from_slice(&[1.0, clock(k).0]);
            left(k).abs() * FRAC_PI_2.sqrt()
        });
        let mut spread = spread.expect("the season is among the harmonics").coefficients();
        if spread[0] <= spread[1].abs() {
            self.warnings.push(
                "temperature: one season comes out without spread; both SDs are the mean one"
                    .into(),
            );
            spread[1] = 0.0;
        }
        let mut deviations = vec![f64::NAN; records.len()];
        let mut scores = deviations.clone();
        for (k, place) in places.iter().enumerate() {
            deviations[*place] = left(k);
            scores[*place] = left(k) / (spread[0] + spread[1] * clock(k).0);
        }
        let gram = harmonics.inverse_gram();
        let phi = self.hourly_correlation(&scores).map_or(0.0, |(phi, _)| phi);
        let doubt_k = 2.0 * harmonics.residual_sd() * gram[(1, 1)].sqrt() * inflation(phi);
        if found[1] < -doubt_k {
            self.warnings.push("temperature: its coldest days lie in July, and a study knows northern seasons only; it stays that of the base study, and a table whose clock is half a year ahead tells it".into());
            return Some(deviations);
        }
        if found[2] < 0.0 {
            self.warnings.push("temperature: its nights are warmer than its days; is the clock the place's standard time?".into());
        }
        let t = &mut model.temperature;
        let n = places.len();
        let inflation =
            self.correlate("temperature.hourly_correlation", &scores, &mut t.hourly_correlation);
        let error = |c: usize| Some(harmonics.residual_sd() * gram[(c, c)].sqrt() * inflation);
        t.mean_k = found[0];
        t.annual_amplitude_k = found[1];
        self.push("temperature.mean_k", found[0], error(0), n);
        self.push("temperature.annual_amplitude_k", found[1], error(1), n);
        for (key, value, into) in [
            ("winter_daily_amplitude_k", found[2] + found[3], &mut t.winter_daily_amplitude_k),
            ("summer_daily_amplitude_k", found[2] - found[3], &mut t.summer_daily_amplitude_k),
            ("winter_sd_k", spread[0] + spread[1], &mut t.winter_sd_k),
            ("summer_sd_k", spread[0] - spread[1], &mut t.summer_sd_k),
        ] {
            self.push(&format!("temperature.{key}"), value, None, n);
            *into = value;
        }
        Some(deviations)
    }

    fn pressure(&mut self, model: &mut WeatherModel) {
        let Some(places) = self.recorded("pressure", |w| w.pressure_pa) else { return };
        let value = |place: &usize| self.records[*place].weather.pressure_pa;
        let n = places.len();
        let mean = places.iter().map(value).sum::<f64>() / n as f64;
        let standard = standard_pressure_pa(model.altitude_m);
        if (mean - standard).abs() > PRESSURE_OF_ANOTHER_PLACE_PA {
            self.warnings.push(format!(
                "pressure: the mean is {:.0} hPa; a study draws it around the standard atmosphere's {:.0} hPa at its weather.altitude_m = {}: give the place's",
                mean / 100.0,
                standard / 100.0,
                model.altitude_m
            ));
        }
        let mut deviations = vec![f64::NAN; self.records.len()];
        for place in &places {
            deviations[*place] = value(place) - mean;
        }
        let sd = root_mean_square(&deviations);
        model.pressure.sd = sd;
        self.push("pressure.sd", sd, None, n);
        let into = &mut model.pressure.hourly_correlation;
        self.correlate("pressure.hourly_correlation", &deviations, into);
    }

    fn humidity(&mut self, warmer: Option<&[f64]>, model: &mut WeatherModel) {
        let Some(mut places) = self.recorded("humidity", |w| w.relative_humidity) else { return };
        if let Some(warmer) = warmer {
            places.retain(|place| warmer[*place].is_finite());
        }
        if !self.tells_harmonics("humidity", &places) {
            return;
        }
        let records = self.records;
        let edge = |share: f64| share.clamp(HUMIDITY_EDGE, 1.0 - HUMIDITY_EDGE);
        let logit = |k: usize| {
            let share = edge(records[places[k]].weather.relative_humidity);
            libm::log(share / (1.0 - share))
        };
        let slope = model.humidity.temperature_slope_per_k;
        let width = if warmer.is_some() { 4 } else { 3 };
        let row = |k: usize, x: &mut [f64]| {
            let (season, night) = clock(&records[places[k]]);
            let warm = warmer.map_or(0.0, |warmer| warmer[places[k]]);
            x.copy_from_slice(&[1.0, season, night, warm][..width]);
            logit(k)
        };
        let Ok(fit) = LeastSquares::reduce(places.len(), width, row) else {
            self.warnings.push("humidity: the records do not tell day and year apart; it stays that of the base study".into());
            return;
        };
        let found = fit.coefficients();
        let mut deviations = vec![f64::NAN; records.len()];
        let mut predictors = vec![0.0; width];
        for (k, place) in places.iter().enumerate() {
            let value = row(k, &mut predictors);
            let expected: f64 = predictors.iter().zip(found.iter()).map(|(x, b)| x * b).sum();
            deviations[*place] = value - expected;
        }
        let cut = places.iter().map(|place| records[*place].weather.relative_humidity);
        let cut = cut.filter(|share| edge(*share) != *share).count();
        if cut > 0 {
            self.warnings.push(format!(
                "humidity: {cut} values beyond {HUMIDITY_EDGE} from 0 and 1 are taken as there"
            ));
        }
        if warmer.is_none() {
            self.warnings.push(format!("humidity: without temperatures its slope stays {slope} per K, that of the base study"));
        }
        let h = &mut model.humidity;
        let n = places.len();
        let inflation =
            self.correlate("humidity.hourly_correlation", &deviations, &mut h.hourly_correlation);
        let gram = fit.inverse_gram();
        let error = |c: usize| Some(fit.residual_sd() * gram[(c, c)].sqrt() * inflation);
        h.mean_logit = found[0];
        h.annual_amplitude = found[1];
        h.daily_amplitude = found[2];
        h.sd = root_mean_square(&deviations);
        self.push("humidity.mean_logit", found[0], error(0), n);
        self.push("humidity.annual_amplitude", found[1], error(1), n);
        self.push("humidity.daily_amplitude", found[2], None, n);
        self.push("humidity.sd", h.sd, None, n);
        if warmer.is_some() {
            h.temperature_slope_per_k = found[3];
            self.push("humidity.temperature_slope_per_k", found[3], None, n);
        }
    }

    fn precipitation(&mut self, model: &mut WeatherModel) {
        let Some(places) = self.recorded("precipitation", |w| w.precipitation_mps) else { return };
        let value = |place: usize| self.records[place].weather.precipitation_mps;
        // hours that follow a dry and a wet one, and how many of them are wet
        let mut counts = [[0_usize; 2]; 2];
        for [a, b] in &self.pairs {
            if value(*a).is_finite() && value(*b).is_finite() {
                let [hours, wet] = &mut counts[usize::from(value(*a) > 0.0)];
                *hours += 1;
                *wet += usize::from(value(*b) > 0.0);
            }
        }
        let wet: Vec<f64> =
            places.iter().map(|place| value(*place)).filter(|rate| *rate > 0.0).collect();
        let rain = &mut model.precipitation;
        for ([hours, wet], key, into) in [
            (counts[0], "precipitation.wet_after_dry", &mut rain.wet_after_dry),
            (counts[1], "precipitation.wet_after_wet", &mut rain.wet_after_wet),
        ] {
            if hours < FEWEST {
                self.warnings.push(format!("{key}: {hours} hours, at least {FEWEST} are needed; it stays that of the base study"));
                continue;
            }
            let share = wet as f64 / hours as f64;
            *into = share;
            self.push(key, share, Some((share * (1.0 - share) / hours as f64).sqrt()), hours);
        }
        match gamma::fit(&wet) {
            Some(Law::Gamma { mean, shape }) if wet.len() >= FEWEST => {
                rain.intensity_shape = shape;
                rain.mean_intensity_mps = mean;
                let error = mean / (shape * wet.len() as f64).sqrt();
                self.push("precipitation.mean_intensity_mps", mean, Some(error), wet.len());
                self.push("precipitation.intensity_shape", shape, None, wet.len());
            }
            _ => self.warnings.push(format!(
                "precipitation: {} wet hours tell no law of the intensity; it stays that of the base study",
                wet.len()
            )),
        }
    }

    fn wind(&mut self, model: &mut WeatherModel) {
        if let Some(places) = self.recorded("wind speed", |w| w.wind_speed_mps) {
            self.wind_speed(&places, model);
        }
        if let Some(places) = self.recorded("wind direction", |w| w.wind_direction_rad) {
            self.wind_direction(&places, model);
        }
    }

    fn wind_speed(&mut self, places: &[usize], model: &mut WeatherModel) {
        let value = |place: usize| self.records[place].weather.wind_speed_mps;
        let moving: Vec<f64> =
            places.iter().map(|place| value(*place)).filter(|speed| *speed > 0.0).collect();
        let Some(Law::Weibull { mean, shape }) = weibull::fit(&moving) else {
            self.warnings.push(
                "wind speed: the speeds have no spread; it stays that of the base study".into(),
            );
            return;
        };
        let scale = mean / libm::tgamma(1.0 + 1.0 / shape);
        let mut scores = vec![f64::NAN; self.records.len()];
        for place in places.iter().filter(|place| value(**place) > 0.0) {
            // from the tail that is small, so that no score is infinite
            let power = libm::pow(value(*place) / scale, shape);
            let below = -libm::expm1(-power);
            scores[*place] = if below < 0.5 {
                normal_quantile(below.max(f64::MIN_POSITIVE))
            } else {
                -normal_quantile(libm::exp(-power).max(f64::MIN_POSITIVE))
            };
        }
        let calm = places.len() - moving.len();
        if calm > 0 {
            self.warnings.push(format!("wind speed: {calm} calm hours have no part in its law, nor in that of the direction"));
        }
        model.wind.mean_speed_mps = mean;
        model.wind.speed_shape = shape;
        self.push("wind.mean_speed_mps", mean, None, moving.len());
        self.push("wind.speed_shape", shape, None, moving.len());
        let into = &mut model.wind.speed_hourly_correlation;
        self.correlate("wind.speed_hourly_correlation", &scores, into);
    }

    fn wind_direction(&mut self, places: &[usize], model: &mut WeatherModel) {
        // a calm has no direction, whatever stands there
        let value = |place: usize| {
            let Weather { wind_speed_mps, wind_direction_rad, .. } = self.records[place].weather;
            if wind_speed_mps == 0.0 { f64::NAN } else { wind_direction_rad }
        };
        let places: Vec<usize> =
            places.iter().copied().filter(|place| value(*place).is_finite()).collect();
        let n = places.len() as f64;
        let north = places.iter().map(|place| libm::cos(value(*place))).sum::<f64>() / n;
        let east = places.iter().map(|place| libm::sin(value(*place))).sum::<f64>() / n;
        let length = libm::hypot(north, east);
        let turns = self.pairs.iter().map(|[a, b]| libm::cos(value(*b) - value(*a)));
        let turns: Vec<f64> = turns.filter(|cosine| cosine.is_finite()).collect();
        // a mean direction is distinguished from none where its length is beyond that of
        // independent directions
        if !(length * length * n > 9.0) || length >= 1.0 || turns.len() < FEWEST {
            self.warnings.push("wind direction: it has no prevailing direction, no spread, or no hours that follow each other; it stays that of the base study".into());
            return;
        }
        let variance = -2.0 * libm::log(length);
        let together = turns.iter().sum::<f64>() / turns.len() as f64;
        let phi = 1.0 + libm::log(together.max(f64::MIN_POSITIVE)) / variance;
        let wind = &mut model.wind;
        wind.prevailing_direction_rad = libm::atan2(east, north);
        wind.direction.sd = variance.sqrt();
        let (direction, sd) = (wind.prevailing_direction_rad, wind.direction.sd);
        self.push("wind.prevailing_direction_rad", direction, None, places.len());
        self.push("wind.direction.sd", sd, None, places.len());
        if phi < 0.0 {
            self.warnings.push(format!("wind.direction.hourly_correlation: an hour is forgotten by the next; the estimate {phi:.3} is taken as 0"));
        }
        let phi = phi.max(0.0);
        wind.direction.hourly_correlation = phi;
        self.push("wind.direction.hourly_correlation", phi, None, turns.len());
    }
}

/// Season and night of a record, as cosines that are 1 on the coldest day and in the coldest hour.
fn clock(record: &HourlyRecord) -> (f64, f64) {
    (season(record.day_of_year), night(24.0 * record.day_of_year.fract()))
}

/// What correlation φ of neighbours makes of the standard error of a mean of independent values.
fn inflation(phi: f64) -> f64 {
    let phi = phi.clamp(0.0, 1.0 - 1e-9);
    ((1.0 + phi) / (1.0 - phi)).sqrt()
}

/// Of the values that are there.
fn root_mean_square(values: &[f64]) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for value in values.iter().filter(|value| value.is_finite()) {
        sum += value * value;
        n += 1.0;
    }
    libm::sqrt(sum / n)
}
