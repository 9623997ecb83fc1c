//! Speed and direction of the wind.

use super::{FEWEST, Hours};
use crate::fit::autocorrelated::{hermite, inflation, long_run};
use crate::fit::p_value::ln_normal_tail;
use nalgebra::Matrix2;
use ocmc_core::distribution::{Law, gamma, weibull};
use ocmc_core::operating_cycle::weather::{Weather, WindModel};
use ocmc_core::special_functions::normal_quantile;
use std::f64::consts::SQRT_2;

impl Hours<'_> {
    pub(super) fn wind_speed(&mut self, model: &mut WindModel) {
        let recorded = self.recorded("wind speed", |w| w.wind_speed_mps);
        let Some(places) = recorded else { return };
        let value = |place: usize| self.records[place].weather.wind_speed_mps;
        let moving: Vec<f64> =
            places.iter().map(|place| value(*place)).filter(|speed| *speed > 0.0).collect();
        let Some(Law::Weibull { mean, shape }) = weibull::fit(&moving) else {
            return self.estimates.stays("the speeds have no spread");
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
        let (n, calm) = (moving.len(), places.len() - moving.len());
        if calm > 0 {
            self.estimates.warn(format_args!(
                "{calm} calm hours have no part in its law, nor in that of the direction"
            ));
        }
        let phi = self.hourly_correlation(&scores).map_or(0.0, |(phi, _)| phi);
        let moving = places.iter().filter(|place| value(**place) > 0.0);
        let times_h: Vec<f64> = moving.map(|place| self.time_h(*place)).collect();
        let [mean_error, shape_error] = weibull_errors(mean, shape, phi, &times_h).map(Some);
        let into = &mut model.mean_speed_mps;
        self.estimates.set("wind.mean_speed_mps", into, mean, mean_error, n);
        self.estimates.set("wind.speed_shape", &mut model.speed_shape, shape, shape_error, n);
        let into = &mut model.speed_hourly_correlation;
        self.correlate("wind.speed_hourly_correlation", &scores, into);
    }

    pub(super) fn wind_direction(&mut self, model: &mut WindModel) {
        let recorded = self.recorded("wind direction", |w| w.wind_direction_rad);
        let Some(mut places) = recorded else { return };
        // a calm has no direction, whatever stands there
        let value = |place: usize| {
            let Weather { wind_speed_mps, wind_direction_rad, .. } = self.records[place].weather;
            if wind_speed_mps == 0.0 { f64::NAN } else { wind_direction_rad }
        };
        places.retain(|place| value(*place).is_finite());
        let n = places.len() as f64;
        let north = places.iter().map(|place| libm::cos(value(*place))).sum::<f64>() / n;
        let east = places.iter().map(|place| libm::sin(value(*place))).sum::<f64>() / n;
        let length = libm::hypot(north, east);
        let turns = self.hour_pairs().iter().map(|[a, b]| libm::cos(value(*b) - value(*a)));
        let turns: Vec<f64> = turns.filter(|cosine| cosine.is_finite()).collect();
        // a mean direction is distinguished from none where its length is beyond that of
        // independent directions
        if !(length * length * n > 9.0) || length >= 1.0 || turns.len() < FEWEST {
            return self.estimates.stays(
                "it has no prevailing direction, no spread, or no hours that follow each other",
            );
        }
        let variance = -2.0 * libm::log(length);
        let together = turns.iter().sum::<f64>() / turns.len() as f64;
        let phi = 1.0 + libm::log(together.max(f64::MIN_POSITIVE)) / variance;
        self.estimates.name = "wind.direction.hourly_correlation";
        let phi = self.remembered(phi);
        let prevailing_rad = libm::atan2(east, north);
        let errors = direction_errors(variance, phi, n);
        let mut set = |key, into: &mut f64, value, error, n| {
            self.estimates.set(&format!("wind.{key}"), into, value, Some(error), n);
        };
        let into = &mut model.prevailing_direction_rad;
        set("prevailing_direction_rad", into, prevailing_rad, errors[0], places.len());
        set("direction.sd", &mut model.direction.sd, variance.sqrt(), errors[1], places.len());
        let into = &mut model.direction.hourly_correlation;
        set("direction.hourly_correlation", into, phi, errors[2], turns.len());
    }
}

/// Standard errors of mean and shape of a Weibull law from speeds whose normal scores remember.
///
/// With u = (w/λ)^k, which is exponential, the derivatives of the log-likelihood by ln λ and ln k
/// are k (u − 1) and 1 + ln u − u ln u; their covariances follow from Hermite coefficients.
fn weibull_errors(mean: f64, shape: f64, phi: f64, times_h: &[f64]) -> [f64; 2] {
    let derivatives = |g: f64| {
        // u = −ln P(Z > g), without cancellation where it is small
        let u =
            if g < 0.0 { -libm::log1p(-0.5 * libm::erfc(-g / SQRT_2)) } else { -ln_normal_tail(g) };
        [shape * (u - 1.0), 1.0 + libm::log(u) - u * libm::log(u)]
    };
    let n = times_h.len() as f64;
    let (mut information, mut spread) = (Matrix2::zeros(), Matrix2::zeros());
    for (m, [a, b]) in hermite(derivatives).into_iter().enumerate() {
        let products = Matrix2::new(a * a, a * b, a * b, b * b);
        let phi = libm::pow(phi.max(0.0), (m + 1) as f64);
        information += products;
        spread += products * long_run(times_h.iter().map(|t| (*t, [1.0])), phi)[(0, 0)] / n;
    }
    let Some(inverse) = information.try_inverse() else { return [f64::NAN; 2] };
    let covariance = inverse * spread * inverse / n;
    // ln mean = ln λ + ln Γ(1 + 1/k)
    let slope = -gamma::digamma(1.0 + 1.0 / shape) / shape;
    let of_mean =
        covariance[(0, 0)] + slope * slope * covariance[(1, 1)] + 2.0 * slope * covariance[(0, 1)];
    [mean * libm::sqrt(of_mean), shape * libm::sqrt(covariance[(1, 1)])]
}

/// Standard errors of prevailing direction, SD and correlation over an hour of `n` directions, by
/// the moments that they are taken from.
///
/// Deviations δ are normal with variance V: cov(sin δ, sin δ') = e^−V sinh(V ρ), cov(cos δ, cos δ')
/// = e^−V (cosh(V ρ) − 1), and those of the hourly turns alike.
fn direction_errors(variance: f64, phi: f64, n: f64) -> [f64; 3] {
    // Σ V^m/m! Σ_k φ^(m |k|) over odd or even m
    let series = |first: usize| {
        let (mut term, mut sum) = (1.0, 0.0);
        for m in 1..200 {
            term *= variance / m as f64;
            if m >= first && (m - first).is_multiple_of(2) {
                sum += term * inflation(libm::pow(phi, m as f64));
            }
            if term < 1e-16 * sum {
                break;
            }
        }
        sum
    };
    let (of_sine, of_cosine) = (series(1) / n, series(2) / n);
    let sd = libm::sqrt(variance);
    // relative variance of the mean cosine of the turns, and its covariance with that of cos δ
    let (turn, forgotten) = (2.0 * variance * (1.0 - phi), 1.0 - phi);
    let (mut own, mut both) = (libm::cosh(turn) - 1.0, 0.0);
    let mut kept = 1.0;
    for _ in 0..100_000 {
        own += 2.0 * (libm::cosh(variance * kept * forgotten * forgotten) - 1.0);
        let more = libm::cosh(variance * kept * forgotten) - 1.0;
        both += 2.0 * more;
        kept *= phi;
        if !(more > 1e-12 * both) {
            break;
        }
    }
    let (own, both) = (own / n, both / n);
    // φ = 1 + ln T/V with V = −2 ln C: dφ = (dT/T − 2 (1 − φ) dC/C)/V
    let of_phi = own + 4.0 * forgotten * forgotten * of_cosine - 4.0 * forgotten * both;
    [libm::sqrt(of_sine), libm::sqrt(of_cosine) / sd, libm::sqrt(of_phi.max(0.0)) / variance]
}
