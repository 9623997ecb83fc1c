//! Charging at rest: how long it takes, and what becomes of the energy.
//!
//! Along the state of charge s the charger gives P(s), the least of its own power, of the charge
//! curve and of the battery's limit, which fades out: a current, then a voltage that is kept. With
//! the store's gain G(s) = P − R I² the time is ∫ E dt, dt = E ds / G(s), E the battery's energy.
//! Between the corners of P, which is piecewise linear, the integrals are those of Gauss with
//! three points on each of up to 64 pieces, fewer where the power changes less: exact to 1e-7 even
//! where it falls to a twentieth.

use crate::charging::ChargeCourse;
use crate::powertrain::component::battery::BatteryModel;
use crate::powertrain::{Charge, Plug};

/// Share of the battery's highest power at which charging is over, as its current has faded out:
/// a twentieth, as is usual for cells (judgement).
const CUT_OFF: f64 = 0.05;
/// Pieces between two corners.
const FEWEST_PIECES: f64 = 4.0;
const MOST_PIECES: f64 = 64.0;
/// By how much the power changes along a piece, over the lower one: between the ends of pieces the
/// course is a straight line.
const CHANGE: f64 = 0.05;
/// Steps of Newton, of which four are taken.
const STEPS: u32 = 20;
/// Newton has found the end where his step is shorter.
const SAME_CHARGE: f64 = 1e-9;
/// Nodes and weights of Gauss on (0, 1): 1/2 ± √0.15.
const GAUSS: [[f64; 2]; 3] = [
    [0.112_701_665_379_258_3, 5.0 / 18.0],
    [0.5, 8.0 / 18.0],
    [0.887_298_334_620_741_7, 5.0 / 18.0],
];

impl BatteryModel {
    /// Highest state of charge to which it is charged at rest.
    fn full_charge(&self) -> f64 {
        self.maximum_charge - CUT_OFF * self.charge_fade
    }

    /// Charge by a charger from a state of charge on; `course` gets how it goes on.
    pub fn charged_by(&self, plug: &Plug, charge: f64, course: &mut ChargeCourse) -> Charge {
        let end = plug.end_at.min(self.full_charge());
        let mut done = Charge::default();
        if !(charge < end && plug.power_w > 0.0 && self.charge_power_w > 0.0) {
            return done;
        }
        let mut from = charge;
        for corner in self.corners(plug, charge, end) {
            let pieces = self.pieces(plug, from, corner);
            let width = (corner - from) / f64::from(pieces);
            for piece in 0..pieces {
                let [start, stop] = [piece, piece + 1].map(|k| from + width * f64::from(k));
                let added = self.between(plug, start, stop);
                if done.time_s + added.time_s > plug.longest_s {
                    let left_s = plug.longest_s - done.time_s;
                    done.add(&self.within(plug, start, stop, left_s));
                    course.push(done.time_s, done.supplied_j);
                    return done;
                }
                done.add(&added);
                course.push(done.time_s, done.supplied_j);
            }
            from = corner;
        }
        done
    }

    /// Power at the terminals, in W: of the charger, by the curve, by the battery's own limit.
    fn powers_w(&self, plug: &Plug, charge: f64) -> [f64; 3] {
        let curve_w = plug.curve.map_or(f64::INFINITY, |curve| curve.power_w(charge));
        [plug.power_w, curve_w, self.charge_limit_w(charge)]
    }

    fn power_w(&self, plug: &Plug, charge: f64) -> f64 {
        self.powers_w(plug, charge).into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Pieces between two corners.
    fn pieces(&self, plug: &Plug, start: f64, stop: f64) -> u32 {
        let [from_w, to_w] = [start, stop].map(|charge| self.power_w(plug, charge));
        let changes = (from_w - to_w).abs() / (CHANGE * from_w.min(to_w));
        libm::ceil(changes).clamp(FEWEST_PIECES, MOST_PIECES) as u32
    }

    /// Where the slope of the power changes between two states of charge, in order, the last one
    /// among them.
    fn corners(&self, plug: &Plug, start: f64, end: f64) -> Vec<f64> {
        let knots = plug.curve.map_or(&[][..], |curve| &curve.charge);
        let mut corners: Vec<f64> = knots.to_vec();
        corners.extend([start, self.maximum_charge - self.charge_fade, end]);
        corners.retain(|at| *at >= start && *at <= end);
        corners.sort_unstable_by(f64::total_cmp);
        let mut crossings = Vec::new();
        for pair in corners.windows(2) {
            let [low, high] = [pair[0], pair[1]].map(|at| self.powers_w(plug, at));
            for (first, second) in [(0, 1), (0, 2), (1, 2)] {
                let [before, behind] =
                    [low, high].map(|powers_w| powers_w[first] - powers_w[second]);
                if before * behind < 0.0 && (before - behind).is_finite() {
                    crossings.push(pair[0] + (pair[1] - pair[0]) * before / (before - behind));
                }
            }
        }
        corners.extend(crossings);
        corners.sort_unstable_by(f64::total_cmp);
        corners
    }

    /// From one state of charge to another between two corners.
    fn between(&self, plug: &Plug, start: f64, stop: f64) -> Charge {
        let width = stop - start;
        let mut sum = Charge { gained_j: width * self.capacity_j, ..Charge::default() };
        for [place, weight] in GAUSS {
            let charge = start + width * place;
            let power_w = self.power_w(plug, charge);
            let flow = self.flow(charge, -power_w);
            let time_s = weight * sum.gained_j / -flow.store_w;
            sum.time_s += time_s;
            sum.loss_j += flow.loss_w * time_s;
            sum.supplied_j += power_w * time_s;
        }
        sum
    }

    /// As far as a time leads that is too short for the whole piece.
    fn within(&self, plug: &Plug, start: f64, stop: f64, time_s: f64) -> Charge {
        let mut end = start;
        let mut done = Charge::default();
        for _ in 0..STEPS {
            let gain_w = -self.flow(end, -self.power_w(plug, end)).store_w;
            let next = end + (time_s - done.time_s) * gain_w / self.capacity_j;
            let next = next.clamp(start, stop);
            if next == end {
                break;
            }
            let is_close = (next - end).abs() < SAME_CHARGE;
            end = next;
            done = self.between(plug, start, end);
            if is_close {
                break;
            }
        }
        done
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::charging::ChargeCurve;
    use crate::powertrain::component::battery::tests::pack;

    /// A battery without resistance, as far as 1e-6 allows one.
    fn ideal() -> BatteryModel {
        BatteryModel { resistance_ohm: 1e-6, ..pack() }
    }

    fn plug(power_w: f64, end_at: f64, longest_s: f64) -> Plug<'static> {
        Plug { power_w, curve: None, end_at, longest_s }
    }

    fn curve(charge: &[f64], power_w: &[f64]) -> ChargeCurve {
        let (charge, power_w) = (charge.to_vec(), power_w.to_vec());
        ChargeCurve { charge, power_w, by_temperature: Vec::new() }
    }

    #[test]
    fn constant_power_takes_energy_over_power() {
        let pack = ideal();
        let done =
            pack.charged_by(&plug(100e3, 0.8, f64::INFINITY), 0.2, &mut ChargeCourse::default());
        let closed_s = 0.6 * pack.capacity_j / 100e3;
        assert!((done.time_s / closed_s - 1.0).abs() < 1e-6, "{} {closed_s}", done.time_s);
        assert!((done.gained_j / (0.6 * pack.capacity_j) - 1.0).abs() < 1e-12);
        // half of the time, half of the energy
        let half =
            pack.charged_by(&plug(100e3, 0.8, 0.5 * closed_s), 0.2, &mut ChargeCourse::default());
        assert!((half.gained_j / (0.3 * pack.capacity_j) - 1.0).abs() < 1e-6);
        assert!((half.time_s / (0.5 * closed_s) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_linear_taper_takes_a_logarithm() {
        // 300 kW up to 0.85, then P = 300 kW (0.9 − s) / 0.05: t = E 0.05 / 300 kW ln(0.05 / (0.9 −
        // s))
        let pack = ideal();
        let seconds = pack.capacity_j / 300e3;
        let closed_s = |from: f64, to: f64| seconds * 0.05 * ((0.9 - from) / (0.9 - to)).ln();
        let done =
            pack.charged_by(&plug(1e6, 0.895, f64::INFINITY), 0.5, &mut ChargeCourse::default());
        let said_s = seconds * 0.35 + closed_s(0.85, 0.895);
        assert!((done.time_s / said_s - 1.0).abs() < 1e-6, "{} {said_s}", done.time_s);
        // beyond a twentieth of the power it is over
        let full =
            pack.charged_by(&plug(1e6, 0.9, f64::INFINITY), 0.87, &mut ChargeCourse::default());
        assert!((full.time_s / closed_s(0.87, 0.8975) - 1.0).abs() < 1e-6);
        // a curve that meets the charger's power between its points
        let curve = curve(&[0.2, 0.7], &[200e3, 50e3]);
        let tapered = Plug { curve: Some(&curve), ..plug(140e3, 0.8, f64::INFINITY) };
        let slope_w = 300e3; // for each unit of the charge; 140 kW at 0.4
        let said_s =
            pack.capacity_j * (0.2 / 140e3 + (140.0f64 / 50.0).ln() / slope_w + 0.1 / 50e3);
        let done = pack.charged_by(&tapered, 0.2, &mut ChargeCourse::default());
        assert!((done.time_s / said_s - 1.0).abs() < 1e-6, "{} {said_s}", done.time_s);
    }

    #[test]
    fn what_the_terminals_take_is_gained_or_heat() {
        let curve = curve(&[0.1, 0.5, 0.8], &[400e3, 350e3, 90e3]);
        for resistance_ohm in [0.001, 0.05, 0.3] {
            let pack = BatteryModel { resistance_ohm, ..pack() };
            for longest_s in [10.0, 1000.0, f64::INFINITY] {
                for curve in [None, Some(&curve)] {
                    let plug = Plug { curve, ..plug(350e3, 0.88, longest_s) };
                    let done = pack.charged_by(&plug, 0.3, &mut ChargeCourse::default());
                    let open_j = done.supplied_j - done.gained_j - done.loss_j;
                    assert!(open_j.abs() < 1e-9 * done.supplied_j, "{done:?}");
                    assert!(done.time_s <= longest_s * (1.0 + 1e-12) && done.loss_j > 0.0);
                }
            }
        }
    }

    #[test]
    fn where_there_is_nothing_to_charge_nothing_is() {
        let pack = pack();
        for (power_w, end_at, longest_s, charge) in
            [(0.0, 0.8, 1e3, 0.2), (1e5, 0.8, 1e3, 0.8), (1e5, 0.8, 0.0, 0.2), (1e5, 1.0, 1e3, 0.9)]
        {
            let done = pack.charged_by(
                &plug(power_w, end_at, longest_s),
                charge,
                &mut ChargeCourse::default(),
            );
            assert_eq!(done.gained_j, 0.0, "{power_w} {end_at} {longest_s}");
        }
    }
}
