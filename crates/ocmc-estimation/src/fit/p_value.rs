//! Tail probabilities of the F, t and chi-square laws, in logarithms where they underflow, and
//! quantiles for intervals.
//!
//! P(F > f) with d₁ and d₂ degrees of freedom is the regularised incomplete beta function I_x(d₂/2,
//! d₁/2) at x = d₂/(d₂ + d₁ f). Its continued fraction (Lentz's method; Abramowitz and Stegun,
//! 26.5.8) is multiplied by a power of x that underflows below 1e-308, so the power stays a
//! logarithm.

use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF, StudentsT};
use std::f64::consts::{PI, SQRT_2};

/// Most terms of the continued fraction: about √a are needed for parameters of size a.
const MOST_TERMS: usize = 100_000;

/// Number below which the continued fraction's denominators count as zero.
const TINY: f64 = 1e-300;

/// Natural logarithm of P(F > f) for the F law with `d1` and `d2` degrees of freedom; NaN for NaN.
pub fn ln_f_tail(f: f64, d1: f64, d2: f64) -> f64 {
    if f.is_nan() {
        return f64::NAN;
    }
    if f <= 0.0 {
        return 0.0;
    }
    if f.is_infinite() {
        return f64::NEG_INFINITY;
    }
    let ratio = d1 * f / d2;
    // ln x and ln (1 - x), neither of which cancels
    let (ln_x, ln_y) = (-libm::log1p(ratio), -libm::log1p(1.0 / ratio));
    ln_incomplete_beta(ln_x, ln_y, 0.5 * d2, 0.5 * d1)
}

/// Natural logarithm of P(|T| > |t|) for Student's law with `df` degrees of freedom.
pub fn ln_t_tails(t: f64, df: f64) -> f64 {
    ln_f_tail(t * t, 1.0, df)
}

/// The t of an interval: P(|T| < t) = `level`.
///
/// Infinite without a degree of freedom.
pub fn t_of_interval(level: f64, df: f64) -> f64 {
    let Ok(law) = StudentsT::new(0.0, 1.0, df) else {
        return f64::INFINITY;
    };
    // the crate's quantile is good to seven digits: Newton's method on the logarithm gives the rest
    let mut t = law.inverse_cdf(0.5 + 0.5 * level);
    for _ in 0..2 {
        let ln_p = ln_t_tails(t, df);
        let slope = -2.0 * libm::exp(law.ln_pdf(t) - ln_p);
        t -= (ln_p - libm::log1p(-level)) / slope;
    }
    t
}

/// Φ(x): the probability that a standard normal number is below `x`.
pub(crate) fn normal_probability(x: f64) -> f64 {
    0.5 * libm::erfc(-x / SQRT_2)
}

/// The interval of an estimate that reaches `t` standard errors to either side.
pub fn around(estimate: f64, standard_error: f64, t: f64) -> [f64; 2] {
    [estimate - t * standard_error, estimate + t * standard_error]
}

/// The normal quantile of 97.5 %.
pub const NORMAL_975: f64 = 1.959_963_984_540_054;

/// The interval at `level` of a standard deviation that was estimated with `df` degrees of freedom:
/// √(df s²/χ²).
///
/// None without a degree of freedom.
pub fn sd_interval(sd: f64, df: f64, level: f64) -> Option<[f64; 2]> {
    let law = ChiSquared::new(df).ok()?;
    let at = |p: f64| sd * libm::sqrt(df / law.inverse_cdf(p));
    Some([at(0.5 + 0.5 * level), at(0.5 - 0.5 * level)])
}

/// ln I_x(a, b) from ln x and ln y, y = 1 − x.
fn ln_incomplete_beta(ln_x: f64, ln_y: f64, a: f64, b: f64) -> f64 {
    let x = libm::exp(ln_x);
    if x > (a + 1.0) / (a + b + 2.0) {
        // the other tail is the smaller one: its logarithm is safe, and 1 minus it does not cancel
        return libm::log1p(-libm::exp(ln_incomplete_beta_small(ln_y, ln_x, b, a)));
    }
    ln_incomplete_beta_small(ln_x, ln_y, a, b)
}

fn ln_incomplete_beta_small(ln_x: f64, ln_y: f64, a: f64, b: f64) -> f64 {
    let front = a * ln_x + b * ln_y - libm::log(a) - ln_beta(a, b);
    front + libm::log(continued_fraction(libm::exp(ln_x), a, b))
}

/// 1/(1+ d₁/(1+ d₂/(1+ ...))), by Lentz's method.
fn continued_fraction(x: f64, a: f64, b: f64) -> f64 {
    let nonzero = |value: f64| if value.abs() < TINY { TINY } else { value };
    let mut c = 1.0;
    let mut d = 1.0 / nonzero(1.0 - (a + b) * x / (a + 1.0));
    let mut fraction = d;
    for m in 1..=MOST_TERMS {
        let m = m as f64;
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut change = 1.0;
        for coefficient in [even, odd] {
            d = 1.0 / nonzero(1.0 + coefficient * d);
            c = nonzero(1.0 + coefficient / c);
            change *= c * d;
        }
        fraction *= change;
        if (change - 1.0).abs() < 1e-16 {
            break;
        }
    }
    fraction
}

/// ln B(a, b). Where an argument is large, the difference of its two log-gammas is taken in
/// Stirling's series, where the large terms cancel on paper.
fn ln_beta(a: f64, b: f64) -> f64 {
    let (small, large) = if a < b { (a, b) } else { (b, a) };
    if large < 10.0 {
        return libm::lgamma(small) + libm::lgamma(large) - libm::lgamma(small + large);
    }
    let sum = small + large;
    let difference = small - (large - 0.5) * libm::log1p(small / large) - small * libm::log(sum)
        + stirling(large)
        - stirling(sum);
    libm::lgamma(small) + difference
}

/// Rest of ln Γ(x) after Stirling's formula, x ≥ 10: 1/(12x) − 1/(360x³) + ...
fn stirling(x: f64) -> f64 {
    let s = 1.0 / (x * x);
    (1.0 / 12.0 - s * (1.0 / 360.0 - s * (1.0 / 1260.0 - s * (1.0 / 1680.0 - s / 1188.0)))) / x
}

/// Natural logarithm of P(Z > z) for the standard normal law.
pub fn ln_normal_tail(z: f64) -> f64 {
    if z < 30.0 {
        return libm::log(0.5 * libm::erfc(z / SQRT_2));
    }
    let s = 1.0 / (z * z);
    let series = 1.0 - s * (1.0 - 3.0 * s * (1.0 - 5.0 * s));
    -0.5 * z * z - libm::log(z * libm::sqrt(2.0 * PI)) + libm::log(series)
}

/// Density over upper tail of the standard normal law, φ(z) / P(Z > z).
pub fn normal_hazard(z: f64) -> f64 {
    libm::exp(-0.5 * z * z - 0.5 * libm::log(2.0 * PI) - ln_normal_tail(z))
}

/// A probability from its natural logarithm, in words for people: `0.768`, `2.05e-11`,
/// `1.3e-21429`.
pub fn p_text(ln_p: f64) -> String {
    if ln_p.is_nan() {
        return "-".to_owned();
    }
    if ln_p > libm::log(1e-3) {
        return format!("{:.4}", libm::exp(ln_p));
    }
    if ln_p == f64::NEG_INFINITY {
        return "0".to_owned();
    }
    let decimal = ln_p / std::f64::consts::LN_10;
    let mut exponent = libm::floor(decimal);
    let mut mantissa = libm::exp((decimal - exponent) * std::f64::consts::LN_10);
    if mantissa >= 9.995 {
        (mantissa, exponent) = (1.0, exponent + 1.0);
    }
    format!("{mantissa:.2}e{exponent}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::FisherSnedecor;

    #[track_caller]
    fn assert_close(a: f64, b: f64, relative: f64) {
        assert!((a - b).abs() <= relative * b.abs(), "{a} {b}");
    }

    #[test]
    fn closed_forms() {
        // d1 = 2: P(F > f) = (1 + 2 f / d2)^(-d2/2); also far beyond the smallest number
        for (f, d2) in [(0.1, 3.0), (5.0, 38.0), (3.0e5, 49_283.0), (1e8, 1e6)] {
            assert_close(ln_f_tail(f, 2.0, d2), -0.5 * d2 * libm::log1p(2.0 * f / d2), 1e-12);
        }
        // one degree of freedom: Cauchy, P(|T| > t) = 1 - 2 atan(t)/pi = 2 atan(1/t)/pi
        for t in [0.2f64, 1.0, 30.0, 1e6] {
            assert_close(ln_t_tails(t, 1.0), (2.0 * (1.0 / t).atan() / PI).ln(), 1e-12);
        }
        // d2 = 2: P(F > f) = 1 - (1 + 2/(d1 f))^(-d1/2)
        for (f, d1) in [(0.5, 7.0), (200.0, 7.0)] {
            let exact = -libm::expm1(-0.5 * d1 * libm::log1p(2.0 / (d1 * f)));
            assert_close(ln_f_tail(f, d1, 2.0).exp(), exact, 1e-12);
        }
    }

    #[test]
    fn agrees_with_another_implementation_where_it_does_not_underflow() {
        for (f, d1, d2) in
            [(87.6916, 1.0, 38.0), (65.7463, 7.0, 38.0), (0.0882, 1.0, 38.0), (6.27, 1.0, 49_283.0)]
        {
            let other = FisherSnedecor::new(d1, d2).unwrap().sf(f);
            assert_close(ln_f_tail(f, d1, d2).exp(), other, 1e-9);
        }
    }

    #[test]
    fn the_papers_tails() {
        // the paper's simulator and field tables
        assert_eq!(p_text(ln_f_tail(87.6916, 1.0, 38.0)), "2.05e-11");
        assert_eq!(p_text(ln_f_tail(0.0882, 1.0, 38.0)), "0.7681");
        assert_eq!(p_text(ln_f_tail(6.27, 1.0, 49_283.0)), "0.0123");
    }

    #[test]
    fn ends() {
        assert_eq!(ln_f_tail(0.0, 3.0, 4.0), 0.0);
        assert_eq!(ln_f_tail(f64::INFINITY, 3.0, 4.0), f64::NEG_INFINITY);
        assert!(ln_f_tail(f64::NAN, 3.0, 4.0).is_nan());
        assert_eq!(p_text(-1.0e5), "3.56e-43430");
        assert_eq!(p_text(f64::NEG_INFINITY), "0");
    }

    #[test]
    fn normal_tails() {
        // Abramowitz and Stegun, table 26.2: Q(5) = 2.8665157e-7; -log10 Q(40) = 349.43701
        assert_close(ln_normal_tail(5.0).exp(), 2.8665157e-7, 1e-7);
        assert_close(-ln_normal_tail(40.0) / std::f64::consts::LN_10, 349.43701, 1e-7);
        // both branches meet
        assert_close(ln_normal_tail(30.0 - 1e-9), ln_normal_tail(30.0), 1e-9);
        // the hazard is minus the slope of the logarithm
        for z in [-3.0, 0.0, 2.0, 20.0, 35.0] {
            let slope = (ln_normal_tail(z + 1e-4) - ln_normal_tail(z - 1e-4)) / 2e-4;
            assert_close(normal_hazard(z), -slope, 1e-6);
        }
    }

    #[test]
    fn quantiles_invert_tails() {
        for df in [1.0, 3.0, 38.0, 49_283.0] {
            let t = t_of_interval(0.95, df);
            assert_close(ln_t_tails(t, df).exp(), 0.05, 1e-11);
        }
        // chi-square with 2 degrees of freedom: quantile -2 ln(1 - p)
        let [low, high] = sd_interval(1.0, 2.0, 0.9).unwrap();
        assert_close(low, libm::sqrt(2.0 / (-2.0 * 0.05f64.ln())), 1e-6);
        assert_close(high, libm::sqrt(2.0 / (-2.0 * 0.95f64.ln())), 1e-6);
        // wide: 95 % interval of an SD is about sd (1 ± 1.96/√(2 df))
        let [low, high] = sd_interval(1.0, 49_283.0, 0.95).unwrap();
        assert_close(high - low, 2.0 * 1.959964 / libm::sqrt(2.0 * 49_283.0), 1e-3);
        assert!(sd_interval(1.0, 0.0, 0.9).is_none());
    }
}
