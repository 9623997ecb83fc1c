//! A sampled climate, recorded by the hour, comes back.

use crate::common::field_truck_model;
use ocmc_core::fit::weather::{HourlyRecord, WeatherFit, WeatherFitError, fit};
use ocmc_core::random::Streams;
use ocmc_core::weather::WeatherModel;

const YEARS: usize = 3;

/// What three years at one place record.
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
            // 20 values tell an SD within a factor of 2
            assert!((0.5..2.0).contains(&(error / sd)), "{key}: {error} given, {sd} seen");
        }
    }
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
