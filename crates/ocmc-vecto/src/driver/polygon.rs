//! Shift polygons: the engine speeds of downshift and upshift by torque.

use super::truck::RPM;
use ocmc_core::powertrain::combustion::CombustionPowertrain;

/// Share of the greatest power that marks the lowest useful speed.
const LOW_POWER_SHARE: f64 = 0.55;
/// Share of the greatest power that marks the highest useful speed.
const HIGH_POWER_SHARE: f64 = 0.95;
/// Share of the torque's integral over speed up to the preferred speed.
const PREFERRED_SHARE: f64 = 0.51;

/// A line of engine speed over torque, continued beyond its ends; with rising torques.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShiftLine {
    /// Torques, in Nm.
    pub torque_nm: Vec<f64>,
    /// Engine speeds, in rad/s.
    pub speed_radps: Vec<f64>,
}

/// Both lines of a gear.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShiftPolygon {
    /// At and below it the gearbox shifts down.
    pub down: ShiftLine,
    /// Above it the gearbox shifts up.
    pub up: ShiftLine,
}

/// The polygons of the gears of a truck.
#[derive(Clone, Debug)]
pub(super) struct ShiftPolygons(Vec<ShiftPolygon>);

impl ShiftPolygons {
    /// Polygons that are given; the generic one where there is none.
    pub(super) fn new(given: &[ShiftPolygon], powertrain: &CombustionPowertrain) -> Self {
        let generic = given.is_empty().then(|| ShiftPolygon::generic(powertrain));
        Self(given.iter().cloned().chain(generic).collect())
    }

    /// Polygon of a gear; the last one holds for all that follow.
    pub(super) fn of(&self, gear: usize) -> &ShiftPolygon {
        &self.0[gear.min(self.0.len() - 1)]
    }
}

impl ShiftLine {
    /// The engine speed at a torque in Nm, in rad/s; 0 where there is no point.
    pub fn at_radps(&self, torque_nm: f64) -> f64 {
        let points = self.torque_nm.len().min(self.speed_radps.len());
        if points < 2 {
            return self.speed_radps.first().copied().unwrap_or(0.0);
        }
        let above = self.torque_nm[..points].partition_point(|knot| *knot < torque_nm);
        let k = above.clamp(1, points - 1);
        let (x, y) = (&self.torque_nm, &self.speed_radps);
        let span_nm = x[k] - x[k - 1];
        if span_nm <= 0.0 {
            return y[k];
        }
        y[k - 1] + (y[k] - y[k - 1]) * (torque_nm - x[k - 1]) / span_nm
    }
}

impl ShiftPolygon {
    /// Polygon that VECTO takes in declaration mode, where no polygon is given: from the full load
    /// alone.
    pub fn generic(powertrain: &CombustionPowertrain) -> Self {
        let model = &powertrain.engine_model;
        let idle = model.idle_speed_radps;
        let last = model.full_load_speed_radps.last().copied().unwrap_or(idle).max(idle);
        let steps = libm::floor((last - idle) / RPM).clamp(1.0, 20_000.0) as usize;
        let speed = |k: usize| idle + k as f64 * (last - idle) / steps as f64;
        let torque = |w: f64| powertrain.engine.full_load_nm(w);
        let power = |k: usize| torque(speed(k)) * speed(k);
        let most_w = (0..=steps).map(power).fold(0.0, f64::max);
        let reaches = |share: f64| move |k: &usize| power(*k) >= share * most_w;
        let low = (0..=steps).find(reaches(LOW_POWER_SHARE)).map_or(idle, speed);
        let high = (0..=steps).rev().find(reaches(HIGH_POWER_SHARE)).map_or(last, speed);
        let preferred = preferred_radps(&torque, idle, high);
        let most_nm = powertrain.engine.peak_torque_nm();
        let bend_down_nm = most_nm * idle / (preferred + low - idle);
        let bend_up_nm = most_nm * (preferred - idle) / (high - idle).max(1e-9);
        Self {
            down: ShiftLine {
                torque_nm: vec![0.0, bend_down_nm, most_nm],
                speed_radps: vec![idle, idle, 0.5 * (preferred + low)],
            },
            up: ShiftLine {
                torque_nm: vec![0.0, bend_up_nm, most_nm],
                speed_radps: vec![preferred, preferred, high],
            },
        }
    }
}

/// The speed up to which a share of the torque's integral lies.
fn preferred_radps(torque: &impl Fn(f64) -> f64, idle: f64, high: f64) -> f64 {
    let steps = libm::ceil((high - idle) / RPM).clamp(1.0, 20_000.0) as usize;
    let step = (high - idle) / steps as f64;
    let pieces: Vec<f64> =
        (0..steps).map(|k| torque(idle + (k as f64 + 0.5) * step) * step).collect();
    let wanted = PREFERRED_SHARE * pieces.iter().sum::<f64>();
    let mut sum = 0.0;
    for (k, piece) in pieces.iter().enumerate() {
        if sum + piece >= wanted {
            return idle + (k as f64 + (wanted - sum) / piece) * step;
        }
        sum += piece;
    }
    high
}
