//! Quantile of the standard normal distribution, of one number and of many.
#![allow(clippy::excessive_precision, reason = "coefficients as printed in the source")]

use crate::lanes::{Lanes, WIDTH, ln};
use fearless_simd::{Level, dispatch, prelude::*};

/// Quantile of the standard normal distribution, Φ⁻¹(p), for p in (0, 1).
///
/// Relative accuracy about 1e-16: algorithm AS 241 (PPND16), M. J. Wichura, "The percentage points
/// of the normal distribution", Applied Statistics 37 (1988) 477-484.
#[inline]
pub fn normal_quantile(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= CENTRE {
        let r = CENTRE_SQUARE - q * q;
        return q * ratio(&CENTRE_NUMERATOR, &CENTRE_DENOMINATOR, r);
    }
    tail_quantile(p)
}

/// Replaces probabilities by their quantiles: the numbers of [`normal_quantile`], eight at a time.
pub fn normal_quantiles(values: &mut [f64]) {
    dispatch!(Level::new(), simd => quantiles(simd, values));
}

/// Probabilities of a batch.
const BATCH: usize = 64;

#[inline(always)]
fn quantiles<S: Simd>(simd: S, values: &mut [f64]) {
    for batch in values.chunks_mut(BATCH) {
        // tails wait until eight of them have come together
        let (mut waiting, mut places) = ([0.5; BATCH + WIDTH], [0; BATCH]);
        let mut count = 0;
        let (blocks, rest) = batch.as_chunks_mut();
        for (b, block) in blocks.iter_mut().enumerate() {
            let probabilities: [f64; WIDTH] = *block;
            let q = Lanes::load_array(simd, probabilities) - 0.5;
            let r = CENTRE_SQUARE - q * q;
            let centre = q * (horners(&CENTRE_NUMERATOR, r) / horners(&CENTRE_DENOMINATOR, r));
            *block = centre.into();
            let mut tails = q.abs().simd_gt(CENTRE).to_bitmask();
            while tails != 0 {
                let lane = tails.trailing_zeros() as usize % WIDTH;
                tails &= tails - 1;
                waiting[count] = probabilities[lane];
                places[count] = b * WIDTH + lane;
                count += 1;
            }
        }
        for value in rest {
            *value = normal_quantile(*value);
        }
        for first in (0..count).step_by(WIDTH) {
            let probabilities = std::array::from_fn(|lane| waiting[first + lane]);
            let quantiles = tail_quantiles(simd, probabilities);
            for (place, value) in places[first..count].iter().zip(quantiles) {
                batch[*place] = value;
            }
        }
    }
}

#[inline(always)]
fn tail_quantiles<S: Simd>(simd: S, probabilities: [f64; WIDTH]) -> [f64; WIDTH] {
    let p = Lanes::load_array(simd, probabilities);
    let below = (p - 0.5).simd_lt(0.0);
    let r = (-ln(below.select(p, 1.0 - p))).sqrt();
    if r.simd_gt(MIDDLE).any_true() {
        return probabilities.map(tail_quantile);
    }
    let s = r - 1.6;
    let z = horners(&MIDDLE_NUMERATOR, s) / horners(&MIDDLE_DENOMINATOR, s);
    below.select(-z, z).into()
}

fn tail_quantile(p: f64) -> f64 {
    let q = p - 0.5;
    let tail = if q < 0.0 { p } else { 1.0 - p };
    let r = (-libm::log(tail)).sqrt();
    let z = if r <= MIDDLE {
        ratio(&MIDDLE_NUMERATOR, &MIDDLE_DENOMINATOR, r - 1.6)
    } else {
        ratio(&FAR_NUMERATOR, &FAR_DENOMINATOR, r - 5.0)
    };
    if q < 0.0 { -z } else { z }
}

/// Where the middle of a tail ends, as the root of minus its logarithm.
const MIDDLE: f64 = 5.0;
/// Half the width of the centre, where one ratio of polynomials serves.
const CENTRE: f64 = 0.425;
/// Its square.
const CENTRE_SQUARE: f64 = 0.180625;

#[inline]
fn ratio(numerator: &[f64; 8], denominator: &[f64; 8], r: f64) -> f64 {
    horner(numerator, r) / horner(denominator, r)
}

#[inline]
fn horner(coefficients: &[f64; 8], r: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * r + c)
}

#[inline(always)]
fn horners<S: Simd>(coefficients: &[f64; 8], r: Lanes<S>) -> Lanes<S> {
    let [lower @ .., highest] = coefficients;
    let mut sum = Lanes::splat(r.simd, *highest);
    for c in lower.iter().rev() {
        sum = sum * r + *c;
    }
    sum
}

const CENTRE_NUMERATOR: [f64; 8] = [
    3.3871328727963666080e0,
    1.3314166789178437745e2,
    1.9715909503065514427e3,
    1.3731693765509461125e4,
    4.5921953931549871457e4,
    6.7265770927008700853e4,
    3.3430575583588128105e4,
    2.5090809287301226727e3,
];
const CENTRE_DENOMINATOR: [f64; 8] = [
    1.0,
    4.2313330701600911252e1,
    6.8718700749205790830e2,
    5.3941960214247511077e3,
    2.1213794301586595867e4,
    3.9307895800092710610e4,
    2.8729085735721942674e4,
    5.2264952788528545610e3,
];
const MIDDLE_NUMERATOR: [f64; 8] = [
    1.42343711074968357734e0,
    4.63033784615654529590e0,
    5.76949722146069140550e0,
    3.64784832476320460504e0,
    1.27045825245236838258e0,
    2.41780725177450611770e-1,
    2.27238449892691845833e-2,
    7.74545014278341407640e-4,
];
const MIDDLE_DENOMINATOR: [f64; 8] = [
    1.0,
    2.05319162663775882187e0,
    1.67638483018380384940e0,
    6.89767334985100004550e-1,
    1.48103976427480074590e-1,
    1.51986665636164571966e-2,
    5.47593808499534494600e-4,
    1.05075007164441684324e-9,
];
const FAR_NUMERATOR: [f64; 8] = [
    6.65790464350110377720e0,
    5.46378491116411436990e0,
    1.78482653991729133580e0,
    2.96560571828504891230e-1,
    2.65321895265761230930e-2,
    1.24266094738807843860e-3,
    2.71155556874348757815e-5,
    2.01033439929228813265e-7,
];
const FAR_DENOMINATOR: [f64; 8] = [
    1.0,
    5.99832206555887937690e-1,
    1.36929880922735805310e-1,
    1.48753612908506148525e-2,
    7.86869131145613259100e-4,
    1.84631831751005468180e-5,
    1.42151175831644588870e-7,
    2.04426310338993978564e-15,
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Φ(x) from the complementary error function, an independent route.
    fn cdf(x: f64) -> f64 {
        0.5 * libm::erfc(-x / std::f64::consts::SQRT_2)
    }

    #[test]
    fn inverts_the_error_function() {
        for x in [-8.0, -5.5, -3.0, -1.0, -0.1, 0.0, 0.3, 2.0, 4.0] {
            assert!((normal_quantile(cdf(x)) - x).abs() < 1e-9 * (1.0 + f64::abs(x)), "{x}");
        }
    }

    #[test]
    fn printed_check_values_of_the_algorithm() {
        // Wichura 1988, table of checks
        assert!((normal_quantile(0.25) - -0.6744897501960817).abs() < 1e-15);
        assert!((normal_quantile(0.001) - -3.090232306167814).abs() < 1e-14);
        assert!((normal_quantile(1e-20) - -9.262340089798408).abs() < 1e-14);
    }

    #[test]
    fn many_are_the_same_bits_as_one_by_one() {
        let mut values: Vec<f64> = (1..1000).map(|k| f64::from(k) / 1000.0).collect();
        values.extend([1e-300, 1e-17, 0.075, 0.925, 0.5, 1.0 - 1e-16]);
        for length in [0, 1, 7, 8, 64, values.len()] {
            let wanted: Vec<u64> =
                values[..length].iter().map(|p| normal_quantile(*p).to_bits()).collect();
            let mut quantiles = values[..length].to_vec();
            normal_quantiles(&mut quantiles);
            assert_eq!(quantiles.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), wanted);
        }
    }
}
