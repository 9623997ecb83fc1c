//! The clutch: whether it slips, and in which gear it can be closed.

use super::truck::{Motion, Truck};

/// Power at the wheels from which an open clutch is closed, in W.
pub(super) const ENGAGING_W: f64 = 200.0;
/// Speed below which first gear is released by a truck that slows, in m/s.
const RELEASE_MPS: f64 = 5.0 / 3.6;

/// Whether the clutch slips.
pub(super) fn slips(truck: &Truck, turns_radps: f64, wheel_w: f64, motion: &Motion) -> bool {
    let drives = wheel_w > 0.0 && motion.acceleration_mps2 >= 0.0;
    drives && turns_radps < truck.slips_below_radps()
}

/// Gear that is left of a chosen one: none where the engine would stall.
pub(super) fn closed_gear(
    truck: &Truck,
    gear: usize,
    motion: &Motion,
    wheel_w: f64,
) -> Option<usize> {
    let turns = |gear: usize| truck.speed_radps(gear, motion.speed_mps);
    let mut closed = Some(gear);
    if gear == 0 && wheel_w < 0.0 && motion.speed_mps <= RELEASE_MPS {
        closed = None;
    }
    // without power a clutch that would slip in a truck that does not slow does not hold
    let slows = motion.acceleration_mps2 < 0.0;
    let least_radps = if slows { truck.idle_radps } else { truck.slips_below_radps() };
    while let Some(gear) = closed {
        if turns(gear) >= least_radps || slips(truck, turns(gear), wheel_w, motion) {
            break;
        }
        closed = gear.checked_sub(1);
    }
    if closed.is_none() && wheel_w > ENGAGING_W {
        closed = Some(0);
    }
    let top = truck.powertrain.gears.len() - 1;
    closed.map(|gear| if turns(gear) > truck.fast_radps() { (gear + 1).min(top) } else { gear })
}
