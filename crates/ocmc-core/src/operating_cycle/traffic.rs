//! Traffic: density as an autoregression around a daily profile, and the speed that it leaves.
//!
//! logit x(t) = logit m_r(H) + u, x = ρ/ρ_jam, u AR(1) on steps of five minutes; m_r(H) = off +
//! (peak − off) min(1, exp(−½((H − 7.5)/1)²) + exp(−½((H − 16.5)/1.2)²)), on every day of the week.
//! Speed by Drake's law, v_t = v_f exp(−½ (ρ/ρ_c)²) (J. L. Drake, J. L. Schofer, A. D. May, 1967),
//! with v_f the free speed of cars (the sign), not the truck's cap: Greenshields' law caps a truck
//! below the sign all day (traffic by the sign).
//!
//! The operating-cycle papers say "macroscopic density by a simple autoregressive process"; the
//! rest is ours. No car following, no queue at signals, no overtaking; stop-and-go is outside a
//! macroscopic model.
//!
//! Checked: variance and lag-1 product of u lie within four standard errors, for seeds 1, 2 and 3.
//! The rush hour is slower than the night, in whole runs, too (`tests/it/parts.rs`); an empty road
//! is free, and a jam is at the floor.

use crate::operating_cycle::road::RoadModel;
use crate::random::{Stream, Streams};
use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Statistical description of traffic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrafficModel {
    /// Time over which the density holds, in s.
    #[schemars(range(min = 10.0, max = 3600.0))]
    pub step_s: f64,
    /// Correlation of the deviation u over one step.
    #[schemars(range(min = 0.0, max = 0.9999))]
    pub step_correlation: f64,
    /// Stationary standard deviation of u.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub logit_sd: f64,
    /// Density at standstill, in vehicles per m and lane.
    #[schemars(range(min = 0.02, max = 0.5))]
    pub jam_density_per_m: f64,
    /// Critical density of Drake's law as a share of the jam density.
    #[schemars(range(min = 0.05, max = 1.0))]
    pub critical_share: f64,
    /// Lowest traffic speed, in m/s.
    #[schemars(range(min = 2.0, max = 20.0))]
    pub minimum_speed_mps: f64,
    /// Centre of the morning peak, in h.
    #[schemars(range(min = 0.0, max = 24.0))]
    pub morning_peak_h: f64,
    /// Width of the morning peak, in h.
    #[schemars(range(min = 0.05, max = 12.0))]
    pub morning_width_h: f64,
    /// Centre of the evening peak, in h.
    #[schemars(range(min = 0.0, max = 24.0))]
    pub evening_peak_h: f64,
    /// Width of the evening peak, in h.
    #[schemars(range(min = 0.05, max = 12.0))]
    pub evening_width_h: f64,
    /// Density by road type.
    pub types: BTreeMap<String, TrafficTypeModel>,
}

/// Traffic density of one road type, as a share of the jam density.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrafficTypeModel {
    /// Typical share off peak.
    #[schemars(range(min = 0.0, max = 0.99))]
    pub off_peak_share: f64,
    /// Typical share at the peak.
    #[schemars(range(min = 0.0, max = 0.99))]
    pub peak_share: f64,
}

/// The deviation u of each step from departure on.
#[derive(Clone, Debug, Default)]
pub struct TrafficSeries {
    deviation: Vec<f64>,
}

impl TrafficModel {
    /// One entry for each road type, and no other.
    pub fn validate(&self, road: &RoadModel, problems: &mut Problems) {
        for name in road.types.keys().filter(|name| !self.types.contains_key(*name)) {
            let shown = format!("without `{name}`");
            problems.require(false, "types", shown, "an entry for each road type");
        }
        for name in self.types.keys().filter(|name| !road.types.contains_key(*name)) {
            problems.require(false, "types", format!("`{name}`"), "a road type of this study");
        }
    }

    /// Draws the deviations of `duration_s` from a departure on, which is counted from midnight.
    pub fn sample(&self, departure_s: f64, duration_s: f64, streams: &Streams) -> TrafficSeries {
        let count = libm::ceil(duration_s / self.step_s) as usize + 1;
        let mut draws = streams.open(Stream::Traffic);
        let innovation = (1.0 - self.step_correlation * self.step_correlation).sqrt();
        let mut state = draws.normal();
        // what a day's trucks share begins at midnight
        let is_shared = streams.is_shared_by_day(Stream::Traffic);
        let before = if is_shared { (departure_s / self.step_s) as usize } else { 0 };
        let mut deviation = Vec::with_capacity(count);
        for step in 0..before + count {
            if step >= before {
                deviation.push(self.logit_sd * state);
            }
            state = self.step_correlation * state + innovation * draws.normal();
        }
        TrafficSeries { deviation }
    }

    /// Typical density share of a road type at an hour of the day.
    pub fn typical_share(&self, model: &TrafficTypeModel, hour: f64) -> f64 {
        let peak = self.peak(hour);
        model.off_peak_share + (model.peak_share - model.off_peak_share) * peak
    }

    /// Height of the day's peaks at an hour, 0 to 1.
    pub fn peak(&self, hour: f64) -> f64 {
        let bell = |centre: f64, width: f64| {
            // the day's end is the next one's beginning
            let away = hour - centre;
            let z = (away - 24.0 * libm::round(away / 24.0)) / width;
            libm::exp(-0.5 * z * z)
        };
        let peak = bell(self.morning_peak_h, self.morning_width_h)
            + bell(self.evening_peak_h, self.evening_width_h);
        peak.min(1.0)
    }

    /// Density `time_s` after departure, in vehicles per m and lane.
    pub fn density_per_m(
        &self,
        model: &TrafficTypeModel,
        series: &TrafficSeries,
        departure_s: f64,
        time_s: f64,
    ) -> f64 {
        let step = ((time_s / self.step_s) as usize).min(series.deviation.len() - 1);
        // the profile, too, holds over a step, at the step's middle
        let middle_s = departure_s + (step as f64 + 0.5) * self.step_s;
        let hour = middle_s / 3600.0 - 24.0 * libm::floor(middle_s / 86_400.0);
        let share = self.typical_share(model, hour);
        let odds = share / (1.0 - share) * libm::exp(series.deviation[step]);
        self.jam_density_per_m * odds / (1.0 + odds)
    }

    /// Speed of traffic of a density where cars would drive `free_speed_mps`, in m/s.
    pub fn speed_mps(&self, density_per_m: f64, free_speed_mps: f64) -> f64 {
        let ratio = density_per_m / (self.critical_share * self.jam_density_per_m);
        (free_speed_mps * libm::exp(-0.5 * ratio * ratio)).max(self.minimum_speed_mps)
    }

    /// Density, as a share of the jam density, at which traffic has a share of its free speed:
    /// Drake's law, inverted. Traffic that stands, or is slower than the law at the jam density,
    /// has that density.
    pub fn share_at(&self, speed_ratio: f64) -> f64 {
        // clamp keeps what is missing, min and max would not
        let ratio = speed_ratio.clamp(0.0, 1.0);
        (self.critical_share * (-2.0 * libm::log(ratio)).sqrt()).clamp(0.0, 1.0)
    }
}

impl TrafficTypeModel {
    /// No cars at all.
    pub const EMPTY: Self = Self { off_peak_share: 0.0, peak_share: 0.0 };
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> TrafficModel {
        TrafficModel {
            step_s: 300.0,
            step_correlation: 0.8,
            logit_sd: 0.6,
            jam_density_per_m: 0.13,
            critical_share: 0.35,
            minimum_speed_mps: 3.0,
            morning_peak_h: 7.5,
            morning_width_h: 1.0,
            evening_peak_h: 16.5,
            evening_width_h: 1.2,
            types: BTreeMap::new(),
        }
    }

    #[test]
    fn deviations_have_the_wanted_moments() {
        let model = model();
        for seed in 1..=3 {
            let (mut squares, mut products) = (Vec::new(), Vec::new());
            for cycle_id in 0..500 {
                let streams = Streams::new(seed, cycle_id);
                let u = model.sample(0.0, 86_400.0, &streams).deviation;
                let n = u.len() as f64;
                squares.push(u.iter().map(|x| x * x).sum::<f64>() / n);
                products.push(u.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (n - 1.0));
            }
            for (values, wanted) in [(squares, 0.36), (products, 0.8 * 0.36)] {
                let n = values.len() as f64;
                let mean = values.iter().sum::<f64>() / n;
                let var = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
                assert!((mean - wanted).abs() < 4.0 * (var / n).sqrt(), "{mean} {wanted}");
            }
        }
    }

    #[test]
    fn rush_hour_is_slower_than_night_and_an_empty_road_is_free() {
        let model = model();
        let urban = TrafficTypeModel { off_peak_share: 0.12, peak_share: 0.3 };
        let series = TrafficSeries { deviation: vec![0.0] };
        let at = |hour: f64| model.density_per_m(&urban, &series, hour * 3600.0, 0.0);
        assert!(model.speed_mps(at(7.5), 14.0) < model.speed_mps(at(2.0), 14.0));
        assert!((model.speed_mps(0.0, 14.0) - 14.0).abs() < 1e-12);
        assert!((model.speed_mps(0.13, 14.0) - 3.0).abs() < 1e-12);
        // the density's law, written out again; the profile holds over five minutes, at their
        // middle
        for (off, peak) in [(0.12, 0.3), (0.06, 0.12), (0.08, 0.25)] {
            let road_type = TrafficTypeModel { off_peak_share: off, peak_share: peak };
            for hour in [0.0, 5.5, 6.5, 7.5, 9.0, 12.0, 15.3, 16.5, 18.9] {
                let middle: f64 = hour + 2.5 / 60.0;
                let morning = (-0.5 * (middle - 7.5).powi(2)).exp();
                let evening = (-0.5 * ((middle - 16.5) / 1.2).powi(2)).exp();
                let share = off + (peak - off) * (morning + evening).min(1.0);
                let density_share =
                    model.density_per_m(&road_type, &series, hour * 3600.0, 0.0) / 0.13;
                assert!((density_share - share).abs() < 1e-9, "{hour} h: {density_share} {share}");
            }
        }
        // what an evening just before midnight has left over, the next day begins with
        let late = TrafficModel { evening_peak_h: 23.9, ..self::tests::model() };
        assert!((late.peak(0.0) - late.peak(23.8)).abs() < 1e-12);
        assert!((late.peak(0.1) - late.peak(24.1)).abs() < 1e-12);
        // off peak, zero deviation: the share itself
        assert!((at(2.0) / 0.13 - 0.12).abs() < 1e-3);
    }
}
