//! The clutch between engine and gearbox: open below a share of the idle speed (open clutch),
//! slipping at a start (launch clutch), closed otherwise.

use super::gearbox::ShiftModel;
use crate::lanes::{Flags, Lanes, one};
use fearless_simd::prelude::*;

/// A clutch and the engine speeds at which it opens and slips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clutch {
    /// Engine speed while it slips, in rad/s.
    pub launch_radps: f64,
    /// Engine speed while it is open, in rad/s.
    pub idle_radps: f64,
    /// Engine speed below which it opens, in rad/s.
    pub open_radps: f64,
}

/// State of a clutch in a step.
#[derive(Clone, Copy)]
pub struct Engagement<S: Simd> {
    /// Flag: it is closed.
    pub closed: Flags<S>,
    /// Flag: it slips.
    pub slips: Flags<S>,
    /// Speed of the engine where it is not closed, in rad/s.
    pub free_speed: Lanes<S>,
}

impl Clutch {
    /// Clutch of a gearbox and an engine with that idle speed.
    pub fn new(shift: &ShiftModel, idle_radps: f64) -> Self {
        Self {
            launch_radps: shift.launch_speed_radps,
            idle_radps,
            open_radps: shift.open_share * idle_radps,
        }
    }

    /// Engagement at engine speeds that closed clutches would have, in rad/s. `slips_below`: the
    /// speed below which it may slip in the gear; `drives`: flag, there is torque to slip for.
    #[inline(always)]
    pub fn engage<S: Simd>(
        &self,
        speed: Lanes<S>,
        slips_below: Lanes<S>,
        drives: Flags<S>,
    ) -> Engagement<S> {
        let simd = speed.simd;
        let slips = speed.simd_lt(slips_below) & drives;
        let slow = speed.simd_lt(self.open_radps);
        let free_speed = slips
            .select(Lanes::splat(simd, self.launch_radps), Lanes::splat(simd, self.idle_radps));
        Engagement { closed: !(slips | slow), slips, free_speed }
    }

    /// The same for one engine: whether the clutch is closed, whether it slips, and the speed of
    /// the engine where it is not closed.
    pub fn engage_one(&self, speed: f64, slips_below: f64, drives: bool) -> (bool, bool, f64) {
        let drives = Flags::splat(one(speed).simd, drives);
        let does = self.engage(one(speed), one(slips_below), drives);
        (does.closed.test(0), does.slips.test(0), does.free_speed[0])
    }
}
