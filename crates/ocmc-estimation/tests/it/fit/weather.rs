//! A sampled climate, recorded by the hour, comes back.

use crate::common::field_truck_model;
use ocmc_core::operating_cycle::weather::{TemperatureModel, WeatherModel};
use ocmc_core::random::Streams;
use ocmc_estimation::fit::weather::{HourlyRecord, WeatherFit, WeatherFitError, fit};

const YEARS: usize = 3;

/// Records of three years at one place.
fn recorded(truth: &WeatherModel, seed: u64) -> Vec<HourlyRecord> {
    let hours = YEARS * 365 * 24;
    let series = truth.sample(0.0, 0.0, 3600.0 * hours as f64, &Streams::new(seed, 0));
    (0..hours)
        .map(|hour| {
            let time_s = 3600.0 * hour as f64;
            let day_of_year = time_s / 86_400.0;
            HourlyRecord { time_s, day_of_year, weather: series.at(time_s) }
        })
        .collect()
}

/// The number at a key such as `wind.direction.sd`.
fn number(model: &WeatherModel, key: &str) -> f64 {
    let value = serde_json::to_value(model).unwrap();
    key.split('.').fold(&value, |value, part| &value[part]).as_f64().unwrap()
}

#[test]
fn a_sampled_climate_comes_back() {
    let truth = field_truck_model().weather;
    // a base that knows nothing: every number has to come from the records
    let mut base = truth.clone();
    base.temperature.mean_k = 290.0;
    base.wind.mean_speed_mps = 9.0;
    let fits: Vec<WeatherFit> =
        (1..=20).map(|seed| fit(&recorded(&truth, seed), &base).unwrap()).collect();
    assert_eq!(fits[0].parameters.len(), 25);
    assert!(fits[0].warnings.is_empty(), "{:?}", fits[0].warnings);
    let n = fits.len() as f64;
    for parameter in &fits[0].parameters {
        let key = &parameter.key;
        let values: Vec<f64> = fits.iter().map(|fit| number(&fit.model, key)).collect();
        let mean = values.iter().sum::<f64>() / n;
        let sd = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        let wanted = number(&truth, key);
        // a direction comes back up to whole turns
        let off = mean - wanted;
        let off = if key == "wind.prevailing_direction_rad" { off.sin() } else { off };
        assert!(off.abs() < 4.0 * sd / n.sqrt(), "{key}: {mean} ± {sd}, sampled with {wanted}");
        if let Some(error) = parameter.standard_error {
            // 20 values determine an SD within a factor of 2
            assert!((0.5..2.0).contains(&(error / sd)), "{key}: {error} given, {sd} seen");
        }
    }
}

#[test]
fn every_third_hour_tells_the_same_with_the_same_error() {
    let truth = field_truck_model().weather;
    let records = recorded(&truth, 1);
    let thinned: Vec<HourlyRecord> = records.iter().step_by(3).copied().collect();
    let [whole, third] = [&records, &thinned].map(|records| fit(records, &truth).unwrap());
    for key in [
        "temperature.mean_k",
        "temperature.hourly_correlation",
        "pressure.hourly_correlation",
        "humidity.mean_logit",
        "wind.mean_speed_mps",
    ] {
        let [a, b] = [&whole, &third].map(|fit| {
            let found = fit.parameters.iter().find(|found| found.key == key).unwrap();
            (found.value, found.standard_error.unwrap())
        });
        // a third of the records of a memory of many hours know nearly as much
        assert!((0.8..2.0).contains(&(b.1 / a.1)), "{key}: {a:?} {b:?}");
        assert!((a.0 - b.0).abs() < 3.0 * a.1.max(b.1), "{key}: {a:?} {b:?}");
    }
    // what follows from hour to hour alone stays
    let has = |fit: &WeatherFit, key: &str| fit.parameters.iter().any(|found| found.key == key);
    assert!(
        has(&whole, "precipitation.wet_after_wet") && !has(&third, "precipitation.wet_after_wet")
    );
}

#[test]
fn what_is_not_recorded_stays_and_is_told() {
    let truth = field_truck_model().weather;
    let mut records = recorded(&truth, 1);
    records.truncate(1000);
    for (k, record) in records.iter_mut().enumerate() {
        record.weather.pressure_pa = f64::NAN;
        record.weather.wind_speed_mps = 0.0;
        if k % 10 == 0 {
            record.weather.relative_humidity = f64::NAN;
        }
    }
    let some = fit(&records, &truth).unwrap();
    assert_eq!(some.model.pressure, truth.pressure);
    assert_eq!(some.model.wind.mean_speed_mps, truth.wind.mean_speed_mps);
    for word in ["pressure: 0 values", "humidity: 100 records", "0.1 years", "wind speed"] {
        assert!(some.warnings.iter().any(|w| w.contains(word)), "{word}: {:?}", some.warnings);
    }
    assert!(matches!(fit(&records[..3], &truth), Err(WeatherFitError::Nothing { hours: 3, .. })));
    assert!(fit(&[], &truth).is_err());
}

#[test]
fn a_constant_pressure_of_another_altitude_is_told_and_nothing_is_nan() {
    let truth = field_truck_model().weather;
    let mut records = recorded(&truth, 1);
    records.truncate(1000);
    for record in &mut records {
        record.weather.pressure_pa = 84_500.0;
    }
    let some = fit(&records, &truth).unwrap();
    assert!(some.parameters.iter().all(|parameter| parameter.value.is_finite()));
    assert_eq!(some.model.pressure.hourly_correlation, truth.pressure.hourly_correlation);
    for word in ["845 hPa", "pressure.hourly_correlation"] {
        assert!(some.warnings.iter().any(|w| w.contains(word)), "{word}: {:?}", some.warnings);
    }
}

#[test]
fn a_calm_has_no_direction() {
    let truth = field_truck_model().weather;
    let records = recorded(&truth, 1);
    let calm = |direction: f64| {
        let mut records = records.clone();
        for record in records.iter_mut().step_by(3) {
            record.weather.wind_speed_mps = 0.0;
            record.weather.wind_direction_rad = direction;
        }
        fit(&records, &truth).unwrap()
    };
    // services write north, or nothing
    let (north, nothing) = (calm(0.0), calm(f64::NAN));
    assert_eq!(north.model.wind, nothing.model.wind);
    let all = fit(&records, &truth).unwrap().model.wind;
    let turned = north.model.wind.prevailing_direction_rad - all.prevailing_direction_rad;
    assert!(turned.abs() < 0.02, "{turned}");
}

#[test]
fn a_season_that_was_not_seen_is_not_made_up() {
    let truth = field_truck_model().weather;
    let base = WeatherModel {
        temperature: TemperatureModel { mean_k: 290.0, ..truth.temperature.clone() },
        ..truth.clone()
    };
    let records = recorded(&truth, 1);
    let spring = fit(&records[60 * 24..120 * 24], &base).unwrap();
    let noon: Vec<_> = records.iter().skip(12).step_by(24).copied().collect();
    for (some, words) in
        [(spring, "lack winter or summer"), (fit(&noon, &base).unwrap(), "lack day or night")]
    {
        assert_eq!(
            (&some.model.temperature, &some.model.humidity),
            (&base.temperature, &base.humidity)
        );
        for variable in ["temperature", "humidity"] {
            let message = format!("{variable}: the records {words}");
            assert!(some.warnings.iter().any(|w| w.starts_with(&message)), "{:?}", some.warnings);
        }
    }
    // and a southern year is no northern one
    let mut south = truth.clone();
    south.temperature.annual_amplitude_k = -9.0;
    let some = fit(&recorded(&south, 1), &base).unwrap();
    assert_eq!(some.model.temperature, base.temperature);
    assert!(some.warnings.iter().any(|w| w.contains("northern seasons")), "{:?}", some.warnings);
}

#[test]
fn what_an_hour_forgets_has_no_negative_correlation() {
    let mut truth = field_truck_model().weather;
    truth.temperature.hourly_correlation = 0.0;
    truth.pressure.hourly_correlation = 0.0;
    truth.humidity.hourly_correlation = 0.0;
    truth.wind.speed_hourly_correlation = 0.0;
    truth.wind.direction.hourly_correlation = 0.0;
    let mut taken = 0;
    for seed in 1..=3 {
        let some = fit(&recorded(&truth, seed), &field_truck_model().weather).unwrap();
        let of =
            |end: &str| some.parameters.iter().filter(|p| p.key.ends_with(end)).collect::<Vec<_>>();
        let correlations = of("hourly_correlation");
        assert_eq!(correlations.len(), 5);
        for parameter in correlations {
            // four errors of 26 280 hours
            assert!((0.0..0.025).contains(&parameter.value), "{parameter:?}");
            assert_eq!(number(&some.model, &parameter.key), parameter.value);
        }
        taken += some.warnings.iter().filter(|w| w.contains("is taken as 0")).count();
    }
    // about half of fifteen
    assert!((2..=13).contains(&taken), "{taken}");
}
