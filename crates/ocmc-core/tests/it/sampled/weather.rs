//! Weather: means, deviations and persistence by season, against the equations of the guide written
//! out again.

use super::{CYCLES, cycles};
use crate::common::field_truck_model;
use crate::common::statistics::{
    SEEDS, assert_count, assert_follows, assert_mean, assert_share, mean_and_error,
};
use ocmc_core::operating_cycle::weather::Weather;
use ocmc_core::random::Streams;
use statrs::distribution::{ContinuousCDF, Gamma, Normal, Weibull};
use std::f64::consts::TAU;
use std::ops::Range;

/// A season: day and hour of a departure, and what the equations give there.
struct Season {
    day: f64,
    hour: f64,
    temperature_sd_k: f64,
    daily_amplitude_k: f64,
}

/// 21 January and 21 July, where the season's cosine is 1 and -1.
const SEASONS: [Season; 2] = [
    Season { day: 20.0, hour: 3.0, temperature_sd_k: 4.5, daily_amplitude_k: 1.0 },
    Season { day: 202.0, hour: 15.0, temperature_sd_k: 3.0, daily_amplitude_k: 4.0 },
];

impl Season {
    /// Weather at departure and one hour later, of each cycle.
    fn sample(&self, seed: u64) -> Vec<[Weather; 2]> {
        let model = field_truck_model().weather;
        cycles(seed)
            .map(|streams| {
                let series = model.sample(self.day, 3600.0 * self.hour, 7200.0, &streams);
                [series.at(0.0), series.at(3600.0)]
            })
            .collect()
    }

    /// Cosine of the year; the tests stay within a day of its extremes, where it is right to 4e-4.
    fn year(&self) -> f64 {
        (TAU * (self.day + self.hour / 24.0 - 20.0) / 365.0).cos()
    }

    /// Cosine of the day, `h` hours after departure.
    fn night(&self, h: usize) -> f64 {
        (TAU * (self.hour + h as f64 - 3.0) / 24.0).cos()
    }

    /// Standardised deviation of the temperature.
    fn temperature_score(&self, weather: &Weather, h: usize) -> f64 {
        let mean = 281.15 - 8.5 * self.year() - self.daily_amplitude_k * self.night(h);
        (weather.temperature_k - mean) / self.temperature_sd_k
    }

    /// Standardised deviation of the humidity's logit, temperature taken out.
    fn humidity_score(&self, weather: &Weather, h: usize) -> f64 {
        let rh = weather.relative_humidity;
        let warmer_k = self.temperature_score(weather, h) * self.temperature_sd_k;
        let mean = 1.3 + 0.4 * self.year() + 0.4 * self.night(h) - 0.06 * warmer_k;
        ((rh / (1.0 - rh)).ln() - mean) / 0.7
    }
}

/// Checks scores of two following hours: standard normal, with the wanted correlation.
#[track_caller]
fn assert_autoregression(what: &str, scores: &[[f64; 2]], correlation: f64) {
    let normal = Normal::new(0.0, 1.0).unwrap();
    for hour in 0..2 {
        let at: Vec<f64> = scores.iter().map(|s| s[hour]).collect();
        assert_mean(what, &at, 0.0);
        assert_mean(what, &at.iter().map(|z| z * z).collect::<Vec<_>>(), 1.0);
        assert_follows(what, at, |z| normal.cdf(z));
    }
    // the difference of neighbours has variance 2 (1 - correlation): sharper than their product
    let steps: Vec<f64> = scores.iter().map(|s| (s[1] - s[0]).powi(2)).collect();
    assert_mean(&format!("{what}, steps"), &steps, 2.0 * (1.0 - correlation));
}

#[test]
fn temperature_and_humidity_by_season() {
    for season in &SEASONS {
        for seed in SEEDS {
            let drawn = season.sample(seed);
            let scores = |score: fn(&Season, &Weather, usize) -> f64| -> Vec<[f64; 2]> {
                drawn.iter().map(|w| [score(season, &w[0], 0), score(season, &w[1], 1)]).collect()
            };
            let temperature = scores(Season::temperature_score);
            let humidity = scores(Season::humidity_score);
            assert_autoregression("temperature", &temperature, 0.98);
            assert_autoregression("humidity", &humidity, 0.9);
            // what is left of the humidity has nothing to do with the temperature
            let products: Vec<f64> =
                temperature.iter().zip(&humidity).map(|(t, h)| t[0] * h[0]).collect();
            assert_mean("temperature and humidity", &products, 0.0);
            // snow where it is cold
            assert!(drawn.iter().flatten().all(|w| w.snow == (w.temperature_k < 273.65)));
        }
    }
}

#[test]
fn pressure_and_wind() {
    let mean_pa = 101_325.0 * (1.0 - 2.2558e-5 * 50.0f64).powf(5.2559);
    let speed = Weibull::new(2.0, 4.0 / (std::f64::consts::PI.sqrt() / 2.0)).unwrap();
    let normal = Normal::new(0.0, 1.0).unwrap();
    for seed in SEEDS {
        let drawn = SEASONS[0].sample(seed);
        let scores = |score: &dyn Fn(&Weather) -> f64| -> Vec<[f64; 2]> {
            drawn.iter().map(|w| [score(&w[0]), score(&w[1])]).collect()
        };
        let pressure = scores(&|w| (w.pressure_pa - mean_pa) / 1100.0);
        assert_autoregression("pressure", &pressure, 0.99);
        let direction = scores(&|w| (w.wind_direction_rad - 3.92699) / 1.2);
        assert_autoregression("wind direction", &direction, 0.95);
        let wind = scores(&|w| normal.inverse_cdf(speed.cdf(w.wind_speed_mps)));
        assert_autoregression("wind speed", &wind, 0.93);

        let speeds: Vec<f64> = drawn.iter().map(|w| w[0].wind_speed_mps).collect();
        assert_mean("wind speed", &speeds, 4.0);
        assert_follows("wind speed", speeds, |w| speed.cdf(w));
        let products: Vec<f64> = wind.iter().zip(&direction).map(|(s, d)| s[0] * d[0]).collect();
        assert_mean("wind speed and direction", &products, 0.0);
    }
}

#[test]
fn rain_comes_in_spells() {
    let model = field_truck_model().weather;
    let amount = Gamma::new(0.7, 0.7 / 2.2222e-7).unwrap();
    let hours = 240;
    for seed in SEEDS {
        let (mut wet_at_start, mut after_dry, mut after_wet) = (0, (0, 0), (0, 0));
        let (mut spells, mut amounts) = (Vec::new(), Vec::new());
        for cycle_id in 0..2000 {
            let streams = Streams::new(seed, cycle_id);
            let series = model.sample(100.0, 0.0, 3600.0 * hours as f64, &streams);
            let rain = |h: usize| series.at(3600.0 * h as f64).precipitation_mps;
            let wet: Vec<bool> = (0..hours).map(|h| rain(h) > 0.0).collect();
            wet_at_start += usize::from(wet[0]);
            for pair in wet.windows(2) {
                let after = if pair[0] { &mut after_wet } else { &mut after_dry };
                after.0 += usize::from(pair[1]);
                after.1 += 1;
            }
            spells.extend(spells_from(&wet, 0..hours / 2).into_iter().map(|n| n as f64));
            amounts.extend((0..hours).map(rain).filter(|a| *a > 0.0));
        }
        assert_share("wet", wet_at_start, 2000, 0.125);
        assert_share("wet after dry", after_dry.0, after_dry.1, 0.05);
        assert_share("wet after wet", after_wet.0, after_wet.1, 0.65);
        assert_mean("length of a spell", &spells, 1.0 / 0.35);
        assert_mean("rain of a wet hour", &amounts, 2.2222e-7);
        assert_follows("rain of a wet hour", amounts, |a| amount.cdf(a));
    }
}

/// Lengths of the wet spells that begin in a range of hours, all long over before the end.
fn spells_from(wet: &[bool], begin: Range<usize>) -> Vec<usize> {
    begin
        .filter(|&h| h > 0 && wet[h] && !wet[h - 1])
        .map(|h| wet[h..].iter().take_while(|w| **w).count())
        .collect()
}

#[test]
fn factors_of_the_weather_are_independent() {
    // two cycles in a row, and two variables of one cycle
    for seed in SEEDS {
        let drawn = SEASONS[0].sample(seed);
        let score = |w: &[Weather; 2]| SEASONS[0].temperature_score(&w[0], 0);
        let rows: Vec<f64> = drawn.windows(2).map(|w| score(&w[0]) * score(&w[1])).collect();
        assert_mean("temperatures of neighbours", &rows, 0.0);
        let wind: Vec<f64> = drawn.iter().map(|w| score(w) * (w[0].wind_speed_mps - 4.0)).collect();
        assert_mean("temperature and wind", &wind, 0.0);
        let wet = drawn.iter().filter(|w| w[0].precipitation_mps > 0.0).count();
        let warm = drawn.iter().filter(|w| score(w) > 0.0).count();
        let both = drawn.iter().filter(|w| score(w) > 0.0 && w[0].precipitation_mps > 0.0).count();
        let wanted = wet as f64 * warm as f64 / CYCLES as f64;
        assert_count("warm and wet", both, wanted);
        assert!(mean_and_error(&rows).1 < 0.01);
    }
}
