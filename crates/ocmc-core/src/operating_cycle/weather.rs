//! Weather along a mission: temperature, pressure, humidity, precipitation and wind on hours
//! counted from departure.
//!
//! Equations are ours, in the tradition of weather generators (occurrence by a Markov chain, gamma
//! amounts, autoregressions for the rest); the operating-cycle papers publish only the list of
//! variables. With day of year d, local hour H and autoregressions ξ of lag one hour:
//!
//! - temperature  T = T₀ − A_y cos(2π(d − 20)/365) − A_d(d) cos(2π(H − 3)/24) + ξ_T
//! - pressure     p = p₀(1 − 2.2558e-5 z)^5.2559 + ξ_p   (standard atmosphere)
//! - humidity     logit RH = b₀ + b₁ cos(2π(d − 20)/365) + b₂ cos(2π(H − 3)/24) − 0.06 ξ_T + ξ_h
//! - rain or snow two-state chain by hour, gamma intensity; snow below 0.5 °C
//! - wind speed   w = F⁻¹(Φ(g)), g AR(1), F Weibull; direction θ = θ₀ + AR(1)
//!
//! A mission is short, so it starts in the stationary state: the spread between missions is the
//! stationary spread. One climate, one place: a mission of 500 km crosses weather systems, and this
//! does not know it.
//!
//! Checked: air density at 20 °C, −10 °C and of the standard atmosphere, pressure at 1000 m, and
//! the signs of head and tail wind. In whole runs January differs from July (`tests/it/parts.rs`).
//! Exposure and heading are applied in `kernel/step/road_row.rs`.

use crate::random::{Draws, Stream, Streams};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Statistical description of the weather.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeatherModel {
    /// Altitude of the start above the sea, in m.
    #[schemars(range(min = -500.0, max = 5000.0))]
    pub altitude_m: f64,
    /// Air temperature.
    pub temperature: TemperatureModel,
    /// Air pressure.
    pub pressure: PressureModel,
    /// Relative humidity.
    pub humidity: HumidityModel,
    /// Rain and snow.
    pub precipitation: PrecipitationModel,
    /// Wind.
    pub wind: WindModel,
}

/// Air pressure: a Gaussian autoregression of lag one hour around the standard pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureModel {
    /// Correlation over one hour.
    #[schemars(range(min = 0.0, max = 0.9999))]
    pub hourly_correlation: f64,
    /// Stationary standard deviation, in Pa.
    #[schemars(range(min = 0.0, max = 5000.0))]
    pub sd: f64,
}

/// Air temperature, in K and differences of K.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TemperatureModel {
    /// Mean over the year, in K.
    #[schemars(range(min = 220.0, max = 320.0))]
    pub mean_k: f64,
    /// Amplitude of the year, in K.
    #[schemars(range(min = 0.0, max = 40.0))]
    pub annual_amplitude_k: f64,
    /// Amplitude of the day in January, in K.
    #[schemars(range(min = 0.0, max = 30.0))]
    pub winter_daily_amplitude_k: f64,
    /// Amplitude of the day in July, in K.
    #[schemars(range(min = 0.0, max = 30.0))]
    pub summer_daily_amplitude_k: f64,
    /// Correlation over one hour.
    #[schemars(range(min = 0.0, max = 0.9999))]
    pub hourly_correlation: f64,
    /// Stationary standard deviation in January, in K.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub winter_sd_k: f64,
    /// Stationary standard deviation in July, in K.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub summer_sd_k: f64,
    /// Standard deviation between trucks of the year's mean where they are at home, in K; absent:
    /// all have the same climate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 20.0))]
    pub truck_sd_k: Option<f64>,
}

/// Relative humidity, on the logit scale.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HumidityModel {
    /// Mean b₀ of logit(RH).
    #[schemars(range(min = -10.0, max = 10.0))]
    pub mean_logit: f64,
    /// Amplitude b₁ of the year.
    #[schemars(range(min = -5.0, max = 5.0))]
    pub annual_amplitude: f64,
    /// Amplitude b₂ of the day.
    #[schemars(range(min = -5.0, max = 5.0))]
    pub daily_amplitude: f64,
    /// Change of logit(RH) for each K that it is warmer than usual.
    #[schemars(range(min = -1.0, max = 1.0))]
    pub temperature_slope_per_k: f64,
    /// Correlation over one hour.
    #[schemars(range(min = 0.0, max = 0.9999))]
    pub hourly_correlation: f64,
    /// Stationary standard deviation.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub sd: f64,
}

/// Rain and snow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrecipitationModel {
    /// Probability that a wet hour follows a dry one.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wet_after_dry: f64,
    /// Probability that a wet hour follows a wet one.
    #[schemars(range(min = 0.0, max = 0.9999))]
    pub wet_after_wet: f64,
    /// Shape of the gamma intensity.
    #[schemars(range(min = 0.05, max = 50.0))]
    pub intensity_shape: f64,
    /// Mean intensity of a wet hour, in m/s of water (0.8 mm/h = 2.2e-7 m/s).
    #[schemars(range(min = 0.0, max = 1.0e-4))]
    pub mean_intensity_mps: f64,
    /// Temperature below which it snows, in K.
    #[schemars(range(min = 200.0, max = 290.0))]
    pub snow_below_k: f64,
}

/// Wind at 10 m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WindModel {
    /// Mean speed, in m/s.
    #[schemars(range(min = 0.0, max = 30.0))]
    pub mean_speed_mps: f64,
    /// Weibull shape of the speed.
    #[schemars(range(min = 0.5, max = 20.0))]
    pub speed_shape: f64,
    /// Correlation over one hour of the normal score of the speed.
    #[schemars(range(min = 0.0, max = 0.9999))]
    pub speed_hourly_correlation: f64,
    /// Direction that the wind usually comes from, in rad from north, clockwise.
    #[schemars(range(min = -6.3, max = 6.3))]
    pub prevailing_direction_rad: f64,
    /// The direction's departure from it, in rad.
    pub direction: WindDirectionModel,
}

/// Direction of the wind: a Gaussian autoregression of lag one hour around the prevailing one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WindDirectionModel {
    /// Correlation over one hour.
    #[schemars(range(min = 0.0, max = 0.9999))]
    pub hourly_correlation: f64,
    /// Stationary standard deviation, in rad.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub sd: f64,
}

/// The weather at one time and place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weather {
    /// Air temperature, in K.
    pub temperature_k: f64,
    /// Pressure, in Pa, at the altitude of the start.
    pub pressure_pa: f64,
    /// Relative humidity, 0 to 1.
    pub relative_humidity: f64,
    /// Precipitation, in m/s of water.
    pub precipitation_mps: f64,
    /// Whether it falls as snow.
    pub snow: bool,
    /// Wind speed at 10 m, in m/s.
    pub wind_speed_mps: f64,
    /// Direction that the wind comes from, in rad from north, clockwise.
    pub wind_direction_rad: f64,
}

/// Still, dry air at 15 °C and the standard pressure: the weather of a study without weather.
pub const STANDARD_WEATHER: Weather = Weather {
    temperature_k: 288.15,
    pressure_pa: 101_325.0,
    relative_humidity: 0.0,
    precipitation_mps: 0.0,
    snow: false,
    wind_speed_mps: 0.0,
    wind_direction_rad: 0.0,
};

/// Hourly weather from departure on.
#[derive(Clone, Debug, Default)]
pub struct WeatherSeries {
    hours: Vec<Weather>,
}

/// Day (of the amplitude's extreme) and period of the annual harmonic.
const COLDEST_DAY: f64 = 20.0;
const DAYS_OF_YEAR: f64 = 365.0;
/// Hour of the day's minimum temperature.
const COLDEST_HOUR: f64 = 3.0;

impl WeatherModel {
    /// Draws the weather of `duration_s` from a departure on.
    ///
    /// `day_of_year` counts from 0 and `departure_s` from midnight.
    pub fn sample(
        &self,
        day_of_year: f64,
        departure_s: f64,
        duration_s: f64,
        streams: &Streams,
    ) -> WeatherSeries {
        let count = libm::ceil(duration_s / 3600.0) as usize + 2;
        let mut temperature = streams.open(Stream::Temperature);
        let mut pressure = streams.open(Stream::Pressure);
        let mut humidity = streams.open(Stream::Humidity);
        let mut precipitation = streams.open(Stream::Precipitation);
        let mut wind = streams.open(Stream::Wind);

        let mut xi_t = temperature.normal();
        let mut xi_p = pressure.normal();
        let mut xi_h = humidity.normal();
        let mut g = wind.normal();
        let mut turn = wind.normal();
        let rain = &self.precipitation;
        let wet_share = rain.wet_after_dry / (1.0 - rain.wet_after_wet + rain.wet_after_dry);
        let mut wet = precipitation.happens(wet_share);

        // what a day's trucks share begins at midnight
        let is_shared = streams.is_shared_by_day(Stream::Temperature);
        let before = if is_shared { (departure_s / 3600.0) as usize } else { 0 };
        let home_k = self.home_climate_k(streams);
        let mut hours = Vec::with_capacity(count);
        for h in 0..before + count {
            if h > 0 {
                advance(&mut xi_t, self.temperature.hourly_correlation, &mut temperature);
                advance(&mut xi_p, self.pressure.hourly_correlation, &mut pressure);
                advance(&mut xi_h, self.humidity.hourly_correlation, &mut humidity);
                advance(&mut g, self.wind.speed_hourly_correlation, &mut wind);
                advance(&mut turn, self.wind.direction.hourly_correlation, &mut wind);
                let share = if wet { rain.wet_after_wet } else { rain.wet_after_dry };
                wet = precipitation.happens(share);
            }
            let time_s = departure_s + 3600.0 * (h as f64 - before as f64);
            let day = day_of_year + time_s / 86_400.0;
            let hour = time_s / 3600.0;
            let deviation_k = self.temperature_sd_k(day) * xi_t;
            let temperature_k = self.mean_temperature_k(day, hour) + deviation_k + home_k;
            let logit = self.humidity.mean_logit
                + self.humidity.annual_amplitude * season(day)
                + self.humidity.daily_amplitude * night(hour)
                + self.humidity.temperature_slope_per_k * deviation_k
                + self.humidity.sd * xi_h;
            let amount = rain.mean_intensity_mps / rain.intensity_shape
                * crate::distribution::standard_gamma(&mut precipitation, rain.intensity_shape);
            if h < before {
                continue;
            }
            hours.push(Weather {
                temperature_k,
                pressure_pa: standard_pressure_pa(self.altitude_m) + self.pressure.sd * xi_p,
                relative_humidity: 1.0 / (1.0 + libm::exp(-logit)),
                precipitation_mps: if wet { amount } else { 0.0 },
                snow: temperature_k < rain.snow_below_k,
                wind_speed_mps: self.wind.speed_mps(g),
                wind_direction_rad: self.wind.prevailing_direction_rad
                    + self.wind.direction.sd * turn,
            });
        }
        WeatherSeries { hours }
    }

    /// By how much the climate at home of this cycle's truck is warmer than the fleet's, in K.
    fn home_climate_k(&self, streams: &Streams) -> f64 {
        self.temperature.truck_sd_k.map_or(0.0, |sd_k| {
            let stream = Stream::Temperature;
            sd_k * streams.truck_effect(stream, &streams.open(stream))
        })
    }

    fn mean_temperature_k(&self, day: f64, hour: f64) -> f64 {
        let t = &self.temperature;
        let daily = seasonal(t.winter_daily_amplitude_k, t.summer_daily_amplitude_k, day);
        t.mean_k - t.annual_amplitude_k * season(day) - daily * night(hour)
    }

    fn temperature_sd_k(&self, day: f64) -> f64 {
        seasonal(self.temperature.winter_sd_k, self.temperature.summer_sd_k, day)
    }
}

impl WindModel {
    /// Weibull speed of a normal score.
    fn speed_mps(&self, score: f64) -> f64 {
        let above = 0.5 * libm::erfc(score / std::f64::consts::SQRT_2);
        let scale = self.mean_speed_mps / libm::tgamma(1.0 + 1.0 / self.speed_shape);
        scale * libm::pow(-libm::log(above.max(f64::MIN_POSITIVE)), 1.0 / self.speed_shape)
    }
}

impl WeatherSeries {
    /// The weather `time_s` after departure: linear between the hours, precipitation by the hour.
    pub fn at(&self, time_s: f64) -> Weather {
        let last = self.hours.len() - 1;
        let position = (time_s / 3600.0).clamp(0.0, last as f64);
        let k = (position as usize).min(last - 1);
        let share = position - k as f64;
        let (a, b) = (&self.hours[k], &self.hours[k + 1]);
        let between = |x: f64, y: f64| x + share * (y - x);
        Weather {
            temperature_k: between(a.temperature_k, b.temperature_k),
            pressure_pa: between(a.pressure_pa, b.pressure_pa),
            relative_humidity: between(a.relative_humidity, b.relative_humidity),
            precipitation_mps: a.precipitation_mps,
            snow: a.snow,
            wind_speed_mps: between(a.wind_speed_mps, b.wind_speed_mps),
            wind_direction_rad: between(a.wind_direction_rad, b.wind_direction_rad),
        }
    }
}

/// One step of a standardised autoregression.
fn advance(state: &mut f64, correlation: f64, draws: &mut Draws) {
    *state = correlation * *state + (1.0 - correlation * correlation).sqrt() * draws.normal();
}

/// A value that swings between January and July.
fn seasonal(winter: f64, summer: f64, day: f64) -> f64 {
    0.5 * (winter + summer) + 0.5 * (winter - summer) * season(day)
}

/// The annual harmonic: 1 on the coldest day of the year.
pub fn season(day: f64) -> f64 {
    libm::cos(TAU * (day - COLDEST_DAY) / DAYS_OF_YEAR)
}

/// The daily harmonic: 1 in the coldest hour.
pub fn night(hour: f64) -> f64 {
    libm::cos(TAU * (hour - COLDEST_HOUR) / 24.0)
}

/// Pressure of the standard atmosphere at an altitude, in Pa. Valid in the troposphere.
pub fn standard_pressure_pa(altitude_m: f64) -> f64 {
    101_325.0 * libm::pow(1.0 - 2.2558e-5 * altitude_m, 5.2559)
}

impl Weather {
    /// Density of the moist air, in kg/m³, `climb_m` above the start.
    ///
    /// ρ = p_d/(287.05 T) + p_v/(461.5 T), p_v = RH · 610.94 exp(17.625 t/(t + 243.04)) (Magnus
    /// form), t in °C.
    pub fn air_density_kgpm3(&self, climb_m: f64) -> f64 {
        let celsius = self.temperature_k - 273.15;
        let saturation_pa = 610.94 * libm::exp(17.625 * celsius / (celsius + 243.04));
        let vapour_pa = self.relative_humidity * saturation_pa;
        // hydrostatic change over the few hundred metres of a mission
        let pressure_pa =
            self.pressure_pa * libm::exp(-9.80665 * climb_m / (287.05 * self.temperature_k));
        (pressure_pa - vapour_pa) / (287.05 * self.temperature_k)
            + vapour_pa / (461.5 * self.temperature_k)
    }

    /// Head-wind and cross-wind components at 10 m for a heading, in m/s; headwind positive.
    pub fn wind_components_mps(&self, heading_rad: f64) -> (f64, f64) {
        let angle = self.wind_direction_rad - heading_rad;
        let (sine, cosine) = libm::sincos(angle);
        (self.wind_speed_mps * cosine, self.wind_speed_mps * sine)
    }

    /// Direction wrapped to (-π, π].
    pub fn wrapped_direction_rad(&self) -> f64 {
        let turns = libm::round(self.wind_direction_rad / TAU);
        let wrapped = self.wind_direction_rad - TAU * turns;
        if wrapped <= -PI { wrapped + TAU } else { wrapped }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn air_density_of_the_sources() {
        // 20 degC, 101.3 kPa -> 1.20; -10 degC -> 1.34 (+11.5 %)
        let air = |celsius: f64| Weather {
            temperature_k: 273.15 + celsius,
            pressure_pa: 101_300.0,
            ..STANDARD_WEATHER
        };
        let (warm, cold) = (air(20.0).air_density_kgpm3(0.0), air(-10.0).air_density_kgpm3(0.0));
        assert!((warm - 1.204).abs() < 0.001 && (cold - 1.341).abs() < 0.001);
        assert!((STANDARD_WEATHER.air_density_kgpm3(0.0) - 1.225).abs() < 0.0005);
        assert!((standard_pressure_pa(1000.0) - 89_875.0).abs() < 10.0);
        // dry air of one temperature: exp(-9.80665 x 1000 / (287.05 x 288.15)) = 0.8882
        let dry = Weather { temperature_k: 288.15, relative_humidity: 0.0, ..STANDARD_WEATHER };
        let part = dry.air_density_kgpm3(1000.0) / dry.air_density_kgpm3(0.0);
        assert!((part - 0.8882).abs() < 1e-4, "{part}");
    }

    #[test]
    fn pressure_falls_more_slowly_in_warm_air() {
        // exp(-9806.65 / (287.05 T)): 0.876043 at -15 degC, 0.893423 at 30 degC
        for (celsius, wanted) in [(-15.0, 0.876_043), (30.0, 0.893_423)] {
            let dry = Weather { temperature_k: 273.15 + celsius, ..STANDARD_WEATHER };
            let part = dry.air_density_kgpm3(1000.0) / dry.air_density_kgpm3(0.0);
            assert!((part - wanted).abs() < 2e-6, "{celsius} degC: {part}");
        }
    }

    #[test]
    fn a_wind_from_the_front_is_a_headwind() {
        let wind = Weather { wind_speed_mps: 5.0, wind_direction_rad: 1.0, ..STANDARD_WEATHER };
        let (head, cross) = wind.wind_components_mps(1.0);
        assert!((head - 5.0).abs() < 1e-12 && cross.abs() < 1e-12);
        let (head, _) = wind.wind_components_mps(1.0 + PI);
        assert!((head + 5.0).abs() < 1e-12);
    }
}
