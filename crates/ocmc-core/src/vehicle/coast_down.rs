//! Coast-down: from F = A + B v + C v² to a drag area and a rolling coefficient.
//!
//! The model here has no linear term. A and C are refitted so that A' + C' v² is next to A + B v +
//! C v² in the least squares over the speeds of the test; then CdA = 2 C'/ρ and c_r = A'/(m g).
//! Everything that rolls and does not brake (bearings, drive shafts) is in A', as in every
//! coast-down.

use super::resistance::GRAVITY_MPS2;
use serde::Deserialize;

/// A coast-down, as it is reported.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoastDown {
    /// A, in N.
    pub constant_n: f64,
    /// B, in N s/m.
    #[serde(default)]
    pub linear_ns_per_m: f64,
    /// C, in N s²/m².
    pub quadratic_ns2_per_m2: f64,
    /// Mass in the test, in kg.
    pub mass_kg: f64,
    /// Density of the air in the test, in kg/m³.
    pub air_density_kgpm3: f64,
    /// Lowest speed of the test, in m/s.
    pub from_mps: f64,
    /// Highest speed of the test, in m/s.
    pub to_mps: f64,
}

impl CoastDown {
    /// Drag area, in m², and rolling coefficient.
    pub fn resistance(&self) -> (f64, f64) {
        // B v ≈ α + β v² over [a, b]: the normal equations with the moments of v over that range
        let (a, b) = (self.from_mps, self.to_mps);
        let moment = |n: i32| {
            let power = f64::from(n + 1);
            (libm::pow(b, power) - libm::pow(a, power)) / (power * (b - a))
        };
        let (m1, m2, m3, m4) = (moment(1), moment(2), moment(3), moment(4));
        let beta = (m3 - m1 * m2) / (m4 - m2 * m2);
        let alpha = m1 - beta * m2;
        let constant = self.constant_n + self.linear_ns_per_m * alpha;
        let quadratic = self.quadratic_ns2_per_m2 + self.linear_ns_per_m * beta;
        (2.0 * quadratic / self.air_density_kgpm3, constant / (self.mass_kg * GRAVITY_MPS2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEST: CoastDown = CoastDown {
        constant_n: 0.006 * 40_000.0 * GRAVITY_MPS2,
        linear_ns_per_m: 0.0,
        quadratic_ns2_per_m2: 0.5 * 1.2 * 5.3,
        mass_kg: 40_000.0,
        air_density_kgpm3: 1.2,
        from_mps: 4.0,
        to_mps: 25.0,
    };

    #[test]
    fn without_a_linear_term_it_is_exact() {
        let (drag_area, rolling) = TEST.resistance();
        assert!((drag_area - 5.3).abs() < 1e-12 && (rolling - 0.006).abs() < 1e-15);
    }

    #[test]
    fn a_linear_term_is_shared_out_between_both() {
        let test = CoastDown { linear_ns_per_m: 8.0, ..TEST };
        let (drag_area, rolling) = test.resistance();
        let mut worst: f64 = 0.0;
        for k in 0..=100 {
            let v = 4.0 + 0.21 * f64::from(k);
            let wanted = test.constant_n + 8.0 * v + test.quadratic_ns2_per_m2 * v * v;
            let have = rolling * 40_000.0 * GRAVITY_MPS2 + 0.6 * drag_area * v * v;
            worst = worst.max((have - wanted).abs());
        }
        // the best straight line in v² through 8 v is off by at most 8 times (b - a)²/(8 (a + b))
        // at the ends, and less here
        assert!(worst < 25.0, "{worst}");
        assert!(rolling > 0.006 && drag_area > 5.3);
    }
}
