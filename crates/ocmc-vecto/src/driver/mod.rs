//! VECTO's drivers as planners: from a mission over distance to the speed and the gears of each
//! second.
//!
//! The plan lies on a lattice of nodes a second apart; what holds in a second is that at its mean
//! speed. VECTO 2.2's driver: first the mission becomes the nodes of a driver without limits but
//! those of braking (`mission.rs`), then overspeed and look-ahead coasting change them
//! (`coasting.rs`), then the truck drives along them, second by second, with acceleration, full
//! load, gears and gaps (`drive.rs`, `gears.rs`), and seconds are repeated or left out so that
//! places stay those of the mission. VECTO 3's decides each second from where the truck is
//! (`ahead.rs`). Road forces, losses and curves are those of the core.
//!
//! What was found by reading VECTO, and what it reproduces, is in
//! `docs/decisions/2026-11-23-how-vecto-computes.md`.

mod ahead;
mod clutch;
mod coasting;
mod correction;
mod drive;
mod gears;
mod mission;
mod polygon;
#[cfg(test)]
mod tests;
mod truck;

pub use mission::{Mission, MissionRow};
pub use polygon::{ShiftLine, ShiftPolygon};

use ocmc_core::powertrain::GearOrder;
use ocmc_core::powertrain::combustion::CombustionPowertrain;
use ocmc_core::prescribed::{Body, DriveCycle, DriveCycleError};
use thiserror::Error;

/// Error of a mission.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MissionError {
    /// Too few rows.
    #[error("{rows} rows, allowed are 2 and more")]
    Short {
        /// Number of rows.
        rows: usize,
    },
    /// A value out of range.
    #[error("in row {row}, `{name}` is {value}, allowed is {minimum} to {maximum}")]
    Range {
        /// Number of the row, from 1.
        row: usize,
        /// Name of the value.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Smallest allowed value.
        minimum: f64,
        /// Largest allowed value.
        maximum: f64,
    },
}

/// Largest acceleration and deceleration by speed, linear between the rows, constant beyond.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AccelerationTable {
    /// Rising speeds, in m/s.
    pub speed_mps: Vec<f64>,
    /// Accelerations, in m/s².
    pub acceleration_mps2: Vec<f64>,
    /// Decelerations (negative), in m/s².
    pub deceleration_mps2: Vec<f64>,
}

impl AccelerationTable {
    /// Largest acceleration at a speed in m/s, in m/s².
    pub fn acceleration_mps2(&self, speed_mps: f64) -> f64 {
        held(&self.speed_mps, &self.acceleration_mps2, speed_mps).unwrap_or(1.0).max(1e-3)
    }

    /// Largest deceleration (negative) at a speed in m/s, in m/s².
    pub fn deceleration_mps2(&self, speed_mps: f64) -> f64 {
        held(&self.speed_mps, &self.deceleration_mps2, speed_mps).unwrap_or(-1.0).min(-1e-3)
    }
}

/// Look-ahead coasting: rolling with a closed clutch before a braking ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LookAhead {
    /// VECTO 2.2: the window in which it may begin is that of a fixed deceleration.
    Window {
        /// Deceleration there (negative), in m/s².
        deceleration_mps2: f64,
        /// Least speed, in m/s.
        minimum_speed_mps: f64,
    },
    /// VECTO 3: it begins where the deceleration that the target needs is large enough against that
    /// of coasting, within a preview of 10 m for each km/h.
    DecisionFactor {
        /// Least speed, in m/s.
        minimum_speed_mps: f64,
    },
}

/// Overspeed: downhill the truck may roll above its target before it is braked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overspeed {
    /// Least speed, in m/s.
    pub minimum_speed_mps: f64,
    /// How much above the target, in m/s.
    pub above_mps: f64,
}

/// The driver.
#[derive(Clone, Debug, PartialEq)]
pub struct VectoDriver {
    /// Largest acceleration and deceleration.
    pub acceleration: AccelerationTable,
    /// Look-ahead coasting.
    pub look_ahead: Option<LookAhead>,
    /// Overspeed.
    pub overspeed: Option<Overspeed>,
    /// One polygon for each gear; the last one holds for all that follow. None: the generic one
    /// ([`ShiftPolygon::generic`]).
    pub shift_polygons: Vec<ShiftPolygon>,
    /// Share of full load that an upshift leaves.
    pub torque_reserve: f64,
    /// Share of full load that the gear of a start leaves.
    pub start_torque_reserve: f64,
    /// Speed for which the gear of a start is chosen, in m/s.
    pub start_speed_mps: f64,
    /// Acceleration for which it is chosen, in m/s².
    pub start_acceleration_mps2: f64,
    /// Time after a shift without another one, in s.
    pub shift_time_s: f64,
    /// Time after a shift without one in the other direction, in s; VECTO 2.2 has none.
    pub opposite_shift_time_s: f64,
    /// Whether a shift may skip gears.
    pub skip_gears: bool,
    /// Whether the gearbox shifts up before the upshift line where the next gear has the reserve.
    pub early_upshift: bool,
    /// Time of a shift without torque, in whole s.
    pub gap_s: u32,
}

impl VectoDriver {
    /// An automated manual gearbox in declaration mode, without look-ahead and overspeed.
    pub fn new(acceleration: AccelerationTable) -> Self {
        Self {
            acceleration,
            look_ahead: None,
            overspeed: None,
            shift_polygons: Vec::new(),
            torque_reserve: 0.2,
            start_torque_reserve: 0.2,
            start_speed_mps: 2.0,
            start_acceleration_mps2: 0.6,
            shift_time_s: 2.0,
            opposite_shift_time_s: 0.0,
            skip_gears: true,
            early_upshift: true,
            gap_s: 1,
        }
    }
}

/// One second of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedSecond {
    /// Gradient over the second: the tangent of the road's angle, that of the place where it ends.
    pub gradient: f64,
    /// Its gear; open at rest, in gaps and where the engine would stall.
    pub gear: GearOrder,
    /// Mean target speed, in m/s.
    pub target_mps: f64,
    /// Power of all auxiliaries, in W.
    pub auxiliary_w: f64,
}

/// Plan of the driver for each second.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Speeds a second apart, one more than seconds, in m/s.
    pub speed_mps: Vec<f64>,
    /// The seconds.
    pub seconds: Vec<PlannedSecond>,
}

impl Plan {
    /// Distance, in m.
    pub fn distance_m(&self) -> f64 {
        self.speed_mps.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).sum()
    }

    /// Number of gears that are engaged after another one.
    pub fn shifts(&self) -> usize {
        let gears = self.seconds.iter().filter_map(|second| match second.gear {
            GearOrder::Engaged(gear) => Some(gear),
            _ => None,
        });
        let gears: Vec<usize> = gears.collect();
        gears.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }

    /// The same as a drive cycle with gears.
    ///
    /// # Errors
    /// [`DriveCycleError`] where the plan has no second.
    pub fn drive_cycle(&self) -> Result<DriveCycle, DriveCycleError> {
        let points = self.speed_mps.len();
        let time_s = (0..points).map(|k| k as f64).collect();
        let slopes = self.seconds.iter().map(|second| sine(second.gradient));
        let gears = self.seconds.iter().map(|second| second.gear);
        // a point has what holds over the second that ends there
        let slope = std::iter::once(0.0).chain(slopes).collect();
        let gears: Vec<GearOrder> = std::iter::once(GearOrder::Free).chain(gears).collect();
        Ok(DriveCycle::new(time_s, self.speed_mps.clone(), slope)?.with_gears(gears))
    }
}

/// Plans the drive of a truck along a mission. `auxiliary_w`: power of the auxiliaries that always
/// run, in W.
pub fn plan(
    mission: &Mission,
    body: &Body,
    powertrain: &CombustionPowertrain,
    auxiliary_w: f64,
    driver: &VectoDriver,
) -> Plan {
    let truck = truck::Truck::new(body, powertrain);
    let drive = drive::Drive::new(mission, &truck, driver, auxiliary_w);
    if let Some(LookAhead::DecisionFactor { minimum_speed_mps }) = driver.look_ahead {
        return drive.run_ahead(ahead::Ahead::new(mission, &truck, driver, minimum_speed_mps));
    }
    let mut nodes = mission.nodes(&driver.acceleration);
    coasting::prepare(&mut nodes, mission, &truck, driver, auxiliary_w);
    drive.run(nodes)
}

/// Climb per metre of road for a gradient.
fn sine(gradient: f64) -> f64 {
    gradient / (1.0 + gradient * gradient).sqrt()
}

/// Linear between points, constant beyond them; none where there is no point.
fn held(xs: &[f64], ys: &[f64], x: f64) -> Option<f64> {
    let points = xs.len().min(ys.len());
    let k = xs[..points].partition_point(|knot| *knot <= x);
    if k == 0 || k == points {
        return ys[..points].get(k.saturating_sub(usize::from(k == points))).copied();
    }
    Some(ys[k - 1] + (ys[k] - ys[k - 1]) * (x - xs[k - 1]) / (xs[k] - xs[k - 1]))
}
