//! Resistance of the road and the air: rolling, drag and grade.
//!
//! Checked: the rolling coefficient at 40 t, and the tangent polynomial within 0.0015 m² of the
//! cubic on 0 to 20°. Cold, wet and rough roads roll worse. Steady driving equals the closed form
//! to 1e-6 (`tests/it/closed_form.rs`).

use crate::lanes::{Bounded, Lanes, UNBOUNDED, one};
use fearless_simd::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Gravity, in m/s² (standard value).
pub const GRAVITY_MPS2: f64 = 9.80665;
/// Temperature at which rolling coefficients are measured, in K (ISO 28580: 25 °C).
const ROLLING_REFERENCE_K: f64 = 298.15;
/// Distance from it beyond which the temperature coefficient is halved, in K: running tyres heat
/// themselves (judgement).
const ROLLING_FULL_RANGE_K: f64 = 15.0;
/// Distance from it beyond which nothing changes, in K: without an end the factor has a pole
/// (judgement).
const ROLLING_WIDEST_RANGE_K: f64 = 60.0;
/// Rain at which the wet term is complete, in m/s of water: 1 mm/h.
const WET_RAIN_MPS: f64 = 1e-3 / 3600.0;
/// Keeps the points apart by which the increment of cross wind becomes a polynomial.
const LEAST_TANGENT: f64 = 0.01;
/// Directions of the wind in half a turn over which VECTO takes the mean.
const MEAN_DIRECTIONS: u32 = 18;
/// Speeds at which it does, in km/h.
const MEAN_SPEEDS_KMH: [f64; 9] = [60.0, 65.0, 70.0, 75.0, 80.0, 85.0, 90.0, 95.0, 100.0];
/// Degrees in a radian.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// One axle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxleModel {
    /// Share of the weight of the loaded vehicle.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub load_share: f64,
    /// Share of the weight of the empty vehicle; absent: as loaded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub empty_load_share: Option<f64>,
    /// Whether the axle is driven.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub driven: bool,
    /// Rolling coefficient by ISO 28580, at the test load.
    #[schemars(range(min = 0.0005, max = 0.05))]
    pub iso_rolling_coefficient: f64,
    /// Test load of one tyre, in N.
    #[schemars(range(min = 500.0, max = 100_000.0))]
    pub iso_load_n: f64,
    /// Number of tyres on the axle.
    #[schemars(range(min = 1.0, max = 16.0))]
    pub tyres: f64,
}

/// Growth of the drag area with the angle of the relative wind, β in degrees:
/// ΔCdA = a₁ β + a₂ β² + a₃ β³, in m², up to the largest angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrossWindModel {
    /// a₁, a₂, a₃, in m² per degree, degree² and degree³.
    #[schemars(inner(range(min = -1.0, max = 1.0)))]
    pub coefficients: [f64; 3],
    /// Angle at which the increment ends, in degrees: the cubic of a tractor-semitrailer turns over
    /// at 14.3°.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub maximum_angle_deg: f64,
}

/// The cross-wind increment as a polynomial in t = tan β, for the hot loop, which has no arc
/// tangent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossWind {
    /// Coefficients of t to t⁴, in m².
    pub coefficients_m2: [f64; 4],
    /// Largest t.
    pub maximum_tangent: f64,
}

/// Change of the drag area with speed: A (1 + b u + c u²), u = v − v₀ ≥ 0, up to the vertex. So a
/// tool that has no wind counts its mean: VECTO's correction for cross wind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DragBySpeedModel {
    /// Speed up to which it is the drag area, in m/s.
    #[schemars(range(min = 0.0, max = 70.0))]
    pub from_mps: f64,
    /// Linear growth above that speed, in s per m.
    #[schemars(range(min = -0.2, max = 0.2))]
    pub linear_s_per_m: f64,
    /// Quadratic growth above that speed, in s² per m².
    #[schemars(range(min = 0.0, max = 0.01))]
    pub quadratic_s2_per_m2: f64,
}

/// The same, prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DragBySpeed {
    from_mps: f64,
    span_mps: f64,
    linear_s_per_m: f64,
    quadratic_s2_per_m2: f64,
}

impl DragBySpeed {
    /// The drag area is the same at all speeds.
    pub const NONE: Self =
        Self { from_mps: 0.0, span_mps: UNBOUNDED, linear_s_per_m: 0.0, quadratic_s2_per_m2: 0.0 };

    /// Factors on the drag area at speeds in m/s.
    #[inline(always)]
    pub fn factors<S: Simd>(&self, speed_mps: Lanes<S>) -> Lanes<S> {
        let above = (speed_mps - self.from_mps).at_least(0.0).at_most(self.span_mps);
        above * (above * self.quadratic_s2_per_m2 + self.linear_s_per_m) + 1.0
    }

    /// The factor at one speed in m/s.
    pub fn factor(&self, speed_mps: f64) -> f64 {
        self.factors(one(speed_mps))[0]
    }
}

impl DragBySpeedModel {
    /// Prepares it.
    pub fn prepare(&self) -> DragBySpeed {
        let Self { from_mps, linear_s_per_m, quadratic_s2_per_m2 } = *self;
        // a parabola that falls at first has its vertex ahead
        let falls = linear_s_per_m < 0.0 && quadratic_s2_per_m2 > 0.0;
        let span_mps =
            if falls { -linear_s_per_m / (2.0 * quadratic_s2_per_m2) } else { UNBOUNDED };
        DragBySpeed { from_mps, span_mps, linear_s_per_m, quadratic_s2_per_m2 }
    }
}

/// Drag, in N, against the motion: F = ½ ρ A ((v + w)² + c²), with the sign of v + w.
///
/// `half_density`: ½ ρ, in kg/m³; `relative_mps`: speed plus headwind, v + w; `cross_mps`: cross
/// wind c; `area_m2`: drag area A at this angle of the wind.
#[inline(always)]
pub fn drag_forces_n<S: Simd>(
    half_density: Lanes<S>,
    relative_mps: Lanes<S>,
    cross_mps: Lanes<S>,
    area_m2: Lanes<S>,
) -> Lanes<S> {
    let pressure = half_density * (relative_mps * relative_mps + cross_mps * cross_mps);
    relative_mps.simd_lt(0.0).select(-pressure, pressure) * area_m2
}

/// [`drag_forces_n`] of one vehicle.
pub fn drag_force_n(half_density: f64, relative_mps: f64, cross_mps: f64, area_m2: f64) -> f64 {
    drag_forces_n(one(half_density), one(relative_mps), one(cross_mps), one(area_m2))[0]
}

/// Masses of the empty vehicle and of the one to which the load shares belong, in kg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadRange {
    /// Without payload.
    pub empty_kg: f64,
    /// Loaded; none where the shares are the same for every load.
    pub full_kg: Option<f64>,
}

impl AxleModel {
    /// Share of the weight of a vehicle with this mass: what is loaded comes down on the axles in
    /// the same proportions, from the empty to the full vehicle and beyond.
    pub fn share_at(&self, mass_kg: f64, range: LoadRange) -> f64 {
        let (Some(empty_share), Some(full_kg)) = (self.empty_load_share, range.full_kg) else {
            return self.load_share;
        };
        let empty_kg = empty_share * range.empty_kg;
        let loaded = (mass_kg - range.empty_kg) / (full_kg - range.empty_kg);
        let carried_kg = empty_kg + loaded * (self.load_share * full_kg - empty_kg);
        (carried_kg / mass_kg).max(0.0)
    }
}

/// Rolling coefficient of a vehicle with this mass on smooth, dry asphalt at 25 °C: RRC = Σ s_i
/// RRC_i (s_i m g / (w_i F_i))^(β − 1), β = 0.9 (VECTO user manual, rolling resistance).
pub fn rolling_coefficient(
    axles: &[AxleModel],
    mass_kg: f64,
    range: LoadRange,
    load_exponent: f64,
) -> f64 {
    let shares = axles.iter().map(|axle| (axle, axle.share_at(mass_kg, range)));
    // an axle that is lifted carries nothing: nothing to a negative power would be no number
    shares
        .filter(|(_, share)| *share > 0.0)
        .map(|(axle, share)| {
            let load = share * mass_kg * GRAVITY_MPS2 / (axle.tyres * axle.iso_load_n);
            share * axle.iso_rolling_coefficient * libm::pow(load, load_exponent - 1.0)
        })
        .sum()
}

/// Factor of temperature on rolling resistance, 1 / (1 + K (T − 25 °C)), with K halved beyond ±15 K
/// and no change beyond ±60 K.
///
/// K = 0.006 1/K for truck tyres (ISO 28580, load index 122 and more; recalled). At 7 °C this is
/// +11 %, an extrapolation of a correction meant for a few kelvin.
pub fn rolling_temperature_factor(temperature_k: f64, coefficient_per_k: f64) -> f64 {
    let difference = (temperature_k - ROLLING_REFERENCE_K)
        .clamp(-ROLLING_WIDEST_RANGE_K, ROLLING_WIDEST_RANGE_K);
    let near = difference.clamp(-ROLLING_FULL_RANGE_K, ROLLING_FULL_RANGE_K);
    1.0 / (1.0 + coefficient_per_k * (near + 0.5 * (difference - near)))
}

/// Factor of rain or snow on rolling resistance: water is displaced, snow compacted (judgement).
pub fn rolling_wet_factor(precipitation_mps: f64, snow: bool) -> f64 {
    if precipitation_mps <= 0.0 {
        1.0
    } else if snow {
        1.25
    } else {
        1.0 + 0.05 * (precipitation_mps / WET_RAIN_MPS).min(1.0)
    }
}

/// Factor of roughness on rolling resistance, 1 + 0.004 (IRI − 1.5)(v / 20 m/s), between 0.95 and
/// 1.3 (judgement; slope relative to 0.0068 as in VTI rapport 748A, recalled).
pub fn rolling_roughness_factor(iri_mm_per_m: f64, speed_mps: f64) -> f64 {
    (1.0 + 0.004 * (iri_mm_per_m - 1.5) * (speed_mps * (1.0 / 20.0))).clamp(0.95, 1.3)
}

/// Resistance of tyres that hold a lateral acceleration, over the vehicle's mass, in m/s².
///
/// Tyres of stiffness C = c F_z roll at the slip angle α = F_y / C, and F_y sin α points backwards:
/// F = F_y² / C for small angles, m a_y² / (c g) for the vehicle (Gillespie, Fundamentals of
/// Vehicle Dynamics, chapter 6). Without bank: a banked bend costs less.
pub fn cornering_resistance_mps2(lateral_mps2: f64, stiffness_per_rad: f64) -> f64 {
    lateral_mps2 * lateral_mps2 / (stiffness_per_rad * GRAVITY_MPS2)
}

/// Least friction that traction finds (judgement: hills are gritted, differentials locked): with
/// the 0.25 of braking on snow one in eight trips with snow would end on a hill.
pub const LEAST_TRACTION_FRICTION: f64 = 0.4;

/// Friction that braking can use: 0.8 dry, 0.5 wet, 0.25 on snow (judgement).
pub fn braking_friction(precipitation_mps: f64, snow: bool) -> f64 {
    if precipitation_mps <= 0.0 {
        0.8
    } else if snow {
        0.25
    } else {
        0.5
    }
}

impl CrossWindModel {
    /// ΔCdA at an angle in degrees, in m².
    pub fn increment_m2(&self, angle_deg: f64) -> f64 {
        self.cubic_m2(angle_deg.min(self.maximum_angle_deg))
    }

    fn cubic_m2(&self, angle_deg: f64) -> f64 {
        let [a1, a2, a3] = self.coefficients;
        angle_deg * (a1 + angle_deg * (a2 + angle_deg * a3))
    }

    /// The drag area and its change with speed that stand for a wind of this speed from all
    /// directions: the mean over directions of A(β) (x² + y²)/v² at v = 60, 65, …, 100 km/h, x and
    /// y the relative wind along and across the road; constant below 60 km/h. So VECTO's
    /// declaration mode counts, with 3 m/s (read in vecto-sim, tag milestones/2.2, `cVEH.vb`;
    /// described in docs/decisions). The parabola through the nine points is within 0.2 % of them
    /// (tested).
    pub fn mean_over_directions(&self, area_m2: f64, wind_mps: f64) -> (f64, DragBySpeedModel) {
        let area_at = |speed_mps: f64| {
            let half_turn = f64::from(MEAN_DIRECTIONS);
            let weighted = |k: u32| {
                let around = std::f64::consts::PI * f64::from(k) / half_turn;
                let along = speed_mps + wind_mps * libm::cos(around);
                let across = wind_mps * libm::sin(around);
                let angle_deg = libm::atan(across / along) * DEGREES;
                let weight = if k == 0 || k == MEAN_DIRECTIONS { 0.5 } else { 1.0 };
                weight
                    * (area_m2 + self.increment_m2(angle_deg))
                    * (along * along + across * across)
            };
            let sum: f64 = (0..=MEAN_DIRECTIONS).map(weighted).sum();
            sum / (half_turn * speed_mps * speed_mps)
        };
        let from_mps = MEAN_SPEEDS_KMH[0] / 3.6;
        let base_m2 = area_at(from_mps);
        // least squares of b u + c u²
        let (mut uu, mut uuu, mut uuuu, mut ur, mut uur) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for speed_kmh in MEAN_SPEEDS_KMH {
            let u = speed_kmh / 3.6 - from_mps;
            let r = area_at(speed_kmh / 3.6) / base_m2 - 1.0;
            uu += u * u;
            uuu += u * u * u;
            uuuu += u * u * u * u;
            ur += u * r;
            uur += u * u * r;
        }
        let determinant = uu * uuuu - uuu * uuu;
        let linear_s_per_m = (ur * uuuu - uur * uuu) / determinant;
        let quadratic_s2_per_m2 = ((uu * uur - uuu * ur) / determinant).max(0.0);
        (base_m2, DragBySpeedModel { from_mps, linear_s_per_m, quadratic_s2_per_m2 })
    }

    /// The polynomial in t = tan β, through zero and four points that make the largest error
    /// between them small: the extrema of the Chebyshev polynomial. For the tractor-semitrailer it
    /// is within 0.0015 m² of the cubic (tested).
    pub fn in_tangent(&self) -> CrossWind {
        let maximum_tangent = libm::tan(self.maximum_angle_deg / DEGREES);
        // ΔCdA / t is a cubic through the points: by divided differences, then from Newton's form
        // to powers of t
        let mut points = [0.0; 4];
        let mut differences = [0.0; 4];
        for (k, (t, difference)) in points.iter_mut().zip(&mut differences).enumerate() {
            let around = libm::cos(std::f64::consts::PI * k as f64 / 4.0);
            *t = maximum_tangent.max(LEAST_TANGENT) * 0.5 * (1.0 + around);
            *difference = self.cubic_m2(libm::atan(*t) * DEGREES) / *t;
        }
        for order in 1..4 {
            for k in (order..4).rev() {
                differences[k] =
                    (differences[k] - differences[k - 1]) / (points[k] - points[k - order]);
            }
        }
        let mut coefficients_m2 = [0.0; 4];
        for k in (0..4).rev() {
            // times (t − point), plus the next difference
            for power in (0..4).rev() {
                let lower = if power > 0 { coefficients_m2[power - 1] } else { differences[k] };
                coefficients_m2[power] = lower - points[k] * coefficients_m2[power];
            }
        }
        CrossWind { coefficients_m2, maximum_tangent }
    }
}

impl CrossWind {
    /// ΔCdA at t = tan β, in m². The powertrain divides for it: with the same reciprocal of the
    /// speed it finds the engine's.
    #[inline(always)]
    pub fn increment_m2<S: Simd>(&self, tangent: Lanes<S>) -> Lanes<S> {
        let t = tangent.at_most(self.maximum_tangent);
        let [c1, c2, c3, c4] = self.coefficients_m2;
        (((t * c4 + c3) * t + c2) * t + c1) * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tangent_polynomial_follows_the_cubic() {
        let model = CrossWindModel {
            coefficients: [0.034767, 0.039367, -0.001897],
            maximum_angle_deg: 14.0,
        };
        let none = CrossWindModel { maximum_angle_deg: 0.0, ..model.clone() }.in_tangent();
        assert_eq!(none.increment_m2(one(0.1))[0], 0.0);
        let fast = model.in_tangent();
        let mut worst: f64 = 0.0;
        for k in 0..=2000 {
            let angle = 20.0 * f64::from(k) / 2000.0;
            let tangent = (angle / DEGREES).tan();
            let increment_m2 = fast.increment_m2(one(tangent))[0];
            worst = worst.max((increment_m2 - model.increment_m2(angle)).abs());
        }
        assert!(worst < 0.0015, "{worst}");
    }

    #[test]
    fn the_mean_over_directions_is_what_vecto_counts() {
        // VECTO 2.2 for a drag area of 6.2985 m² (docs/decisions, how VECTO computes)
        let model = CrossWindModel {
            coefficients: [0.034767, 0.039367, -0.001897],
            maximum_angle_deg: 14.0,
        };
        let (area_m2, by_speed) = model.mean_over_directions(6.2985, 3.0);
        let by_speed = by_speed.prepare();
        let stated = [7.9553, 7.7834, 7.6352, 7.5075, 7.3964, 7.2995, 7.2150, 7.1411, 7.0761];
        for (speed_kmh, stated_m2) in MEAN_SPEEDS_KMH.into_iter().zip(stated) {
            let found_m2 = area_m2 * by_speed.factor(speed_kmh / 3.6);
            assert!((found_m2 / stated_m2 - 1.0).abs() < 0.002, "{speed_kmh}: {found_m2}");
        }
        assert_eq!(by_speed.factor(5.0), 1.0);
        // beyond the vertex the area stays
        assert_eq!(by_speed.factor(60.0), by_speed.factor(70.0));
        assert_eq!(DragBySpeed::NONE.factor(20.0), 1.0);
    }

    #[test]
    fn rolling_of_the_default_truck() {
        let axle = |load_share, iso_rolling_coefficient, iso_load_n, tyres| AxleModel {
            load_share,
            empty_load_share: None,
            driven: false,
            iso_rolling_coefficient,
            iso_load_n,
            tyres,
        };
        let range = LoadRange { empty_kg: 15_700.0, full_kg: None };
        let rolling_coefficient =
            |axles: &[AxleModel], mass_kg| super::rolling_coefficient(axles, mass_kg, range, 0.9);
        let axles = [
            axle(0.20, 0.0055, 33_350.0, 2.0),
            axle(0.25, 0.0065, 33_350.0, 4.0),
            axle(0.55 / 3.0, 0.0055, 37_500.0, 2.0),
            axle(0.55 / 3.0, 0.0055, 37_500.0, 2.0),
            axle(0.55 / 3.0, 0.0055, 37_500.0, 2.0),
        ];
        // the quasi-static runs of this truck took 0.0058
        assert!((rolling_coefficient(&axles, 40_000.0) - 0.0058).abs() < 5e-5);
        assert!(rolling_coefficient(&axles, 16_000.0) > 0.0058);
        // the last axle is lifted: the other two of the semitrailer carry its share
        let mut lifted = axles.clone();
        (lifted[2].load_share, lifted[3].load_share, lifted[4].load_share) = (0.275, 0.275, 0.0);
        let more = rolling_coefficient(&lifted, 16_000.0) / rolling_coefficient(&axles, 16_000.0);
        assert!((0.97..1.0).contains(&more), "tyres with more load roll better: {more}");
    }

    #[test]
    fn payload_loads_the_axles_in_proportion() {
        let axle = |load_share, empty_load_share| AxleModel {
            load_share,
            empty_load_share: Some(empty_load_share),
            driven: false,
            iso_rolling_coefficient: 0.006,
            iso_load_n: 30_000.0,
            tyres: 2.0,
        };
        let axles = [axle(0.2, 0.4), axle(0.8, 0.6)];
        let range = LoadRange { empty_kg: 10_000.0, full_kg: Some(30_000.0) };
        // 4 and 6 t empty, 6 and 24 t full, 5 and 15 t at half the load
        for (mass_kg, tonnes) in [(10e3, [4.0, 6.0]), (30e3, [6.0, 24.0]), (20e3, [5.0, 15.0])] {
            for (axle, wanted) in axles.iter().zip(tonnes) {
                let carried = axle.share_at(mass_kg, range) * mass_kg / 1000.0;
                assert!((carried - wanted).abs() < 1e-12, "{mass_kg} {carried}");
            }
        }
        // without the mass that the shares belong to they are the same at every load
        let any = LoadRange { full_kg: None, ..range };
        assert_eq!(axles[0].share_at(10e3, any), 0.2);
    }

    #[test]
    fn cold_wet_and_rough_roads_roll_worse() {
        assert!((rolling_temperature_factor(298.15, 0.006) - 1.0).abs() < 1e-15);
        // the coldest weather and the largest coefficient that a study may have
        let coldest = rolling_temperature_factor(150.0, 0.02);
        assert!((coldest - 4.0).abs() < 1e-9, "{coldest}");
        // rolling in the cold: about +11 % at 7 degC
        assert!((rolling_temperature_factor(280.15, 0.006) - 1.11).abs() < 0.005);
        // in numbers: rain of 0.5 and 2 mm/h, snow
        let mm_per_h = 1e-3 / 3600.0;
        let wet = |rain: f64, snow| rolling_wet_factor(rain * mm_per_h, snow);
        let factors = [wet(0.0, false), wet(0.5, false), wet(2.0, false), wet(2.0, true)];
        for (factor, wanted) in factors.into_iter().zip([1.0, 1.025, 1.05, 1.25]) {
            assert!((factor - wanted).abs() < 1e-12, "{factor} {wanted}");
        }
        let friction =
            [(0.0, false), (1e-7, false), (1e-7, true)].map(|(p, snow)| braking_friction(p, snow));
        assert_eq!(friction, [0.8, 0.5, 0.25]);
        // 1 + 0.004 (IRI - 1.5)(v / 20), from 0.95 to 1.3
        for (iri, v, wanted) in [
            (1.5, 20.0, 1.0),
            (4.0, 20.0, 1.01),
            (4.0, 10.0, 1.005),
            (0.0, 60.0, 0.982),
            (90.0, 20.0, 1.3),
        ] {
            let factor = rolling_roughness_factor(iri, v);
            assert!((factor - wanted).abs() < 1e-12, "{iri} {v}: {factor}");
        }
    }
}
