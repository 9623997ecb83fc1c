//! The split of the electric demand between fuel cell and battery.
//!
//! P = min(max(F + E/T (s* − s), 0), P_max, A + C), where F is the electric demand of motor and
//! auxiliaries behind a first-order filter of time constant τ, E the battery's energy, s its charge
//! and s* the target, T the time in which a deviation is brought back, A the power of the
//! auxiliaries and C what the battery takes at most. It is decided at the start of a step and held
//! over it. With a steady demand the deviation of the charge decays with T and nothing overshoots,
//! as F does not depend on the charge. The battery gives less near its lowest charge: above the
//! cell's power a truck slows on a long climb, and goes on. Derived, in place of VECTO's window
//! over the whole finished trip, which no truck can know.

use crate::lanes::{Bounded, Lanes, clip};
use crate::powertrain::component::battery::{BatteryLimits, BatteryModel};
use fearless_simd::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the demand is split.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SplitModel {
    /// Charge to which the battery is brought back.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub target_charge: f64,
    /// Time in which a deviation from it is brought back, in s.
    #[schemars(range(min = 60.0, max = 86_400.0))]
    pub charge_time_s: f64,
    /// Time constant with which the cell follows the demand, in s.
    #[schemars(range(min = 1.0, max = 3600.0))]
    pub demand_time_s: f64,
}

impl SplitModel {
    /// Power of the cell, in W: `demand` behind its filter and `auxiliary`, in W, `power_w` the
    /// cell's highest.
    #[inline(always)]
    pub fn cell_powers_w<S: Simd>(
        &self,
        [charge, demand, auxiliary]: [Lanes<S>; 3],
        battery: &BatteryModel,
        limits: &BatteryLimits<S>,
        power_w: f64,
    ) -> Lanes<S> {
        let gain = battery.capacity_j / self.charge_time_s;
        let wanted = demand + (self.target_charge - charge) * gain;
        let most = (auxiliary + battery.charge_limits_w(charge, limits)).at_most(power_w);
        wanted.at_least(0.0).at_most(most)
    }

    /// The filtered demand after some time, in s, with a demand, in W: the implicit step of the
    /// filter, which no length makes unstable.
    #[inline(always)]
    pub fn followed_w<S: Simd>(
        &self,
        filtered: Lanes<S>,
        demand: Lanes<S>,
        dt: Lanes<S>,
    ) -> Lanes<S> {
        filtered + (demand - filtered) * (dt / (dt + self.demand_time_s))
    }
}

/// Share of its power that a battery gives near its lowest charge.
#[inline(always)]
pub(super) fn given_share<S: Simd>(battery: &BatteryModel, charge: Lanes<S>) -> Lanes<S> {
    clip((charge - battery.minimum_charge) * (1.0 / battery.charge_fade), 0.0, 1.0)
}
