//! Automated gearbox, axle and retarder: ratios, losses and the shifting strategy.
//!
//! Losses by VECTO's generic maps: gearbox T_loss = c₀ + c₂ w + c₁ max(|T|, T_floor) at its input
//! (direct or indirect gear), retarder drag r₀ + r₂ w_p² at the propeller shaft, axle
//! T_loss = a₀ + a₁|T| at its input.
//!
//! Strategy by load-dependent lines (upshift line, downshift line), without a look at a noisy power
//! demand: up, by at most three gears, to the highest gear with w ≥ 95 + 32 a_p, with a reserve of
//! power over what the road asks for, and with some acceleration left after the shift; no opposite
//! shift for some time, no upshift just before the driver brakes (shift look-ahead); down when w <
//! 88 + 20 a_p or when the pedal is down for 2 s and the truck slows below 136 rad/s; up when
//! w > 219. Added here: both downshifts need a slowing truck, otherwise a truck that has just
//! started in third gear shifts down while it accelerates through 84-108 rad/s.
//!
//! Checked: steady torque through axle, retarder and gearbox equals its closed form to 1e-6. In
//! `tests/it/closed_loop.rs`: a truck of 40 t starts again on a climb of 6 %, in first gear, with a
//! slipping clutch, and a constant climb does not hunt. In `tests/it/shift_strategy.rs`: each line
//! of the strategy, and no opposite shifts within 10 s at 30 km/h on 4 % for K_P from 0.2 to 1 s/m.

use crate::lanes::{Bounded, Flags, Lanes, UNBOUNDED, one};
use crate::validation::Problems;
use fearless_simd::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Gearbox, axle and retarder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GearboxModel {
    /// Ratios from first to top gear.
    #[schemars(inner(range(min = 0.1, max = 30.0)))]
    pub ratio: Vec<f64>,
    /// Constant loss torque at the input, in Nm.
    #[schemars(range(min = 0.0, max = 500.0))]
    pub loss_torque_nm: f64,
    /// Loss torque for each rad/s of the input, in Nm s; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 5.0))]
    pub loss_torque_nms: Option<f64>,
    /// Input torque, without sign, below which the loss falls no further, in Nm; absent: 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 2000.0))]
    pub loss_floor_nm: Option<f64>,
    /// Share of the input torque lost in a direct gear (ratio 1).
    #[schemars(range(min = 0.0, max = 0.5))]
    pub direct_loss_share: f64,
    /// Share of the input torque lost in other gears.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub indirect_loss_share: f64,
    /// Retarder drag at the propeller shaft, in Nm.
    #[schemars(range(min = 0.0, max = 500.0))]
    pub retarder_torque_nm: f64,
    /// Growth of that drag with the square of the shaft's speed in rad/s, in Nm s²; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 0.1))]
    pub retarder_torque_nms2: Option<f64>,
    /// Ratio of the axle.
    #[schemars(range(min = 0.5, max = 20.0))]
    pub axle_ratio: f64,
    /// Constant loss torque at the axle's input, in Nm.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub axle_loss_torque_nm: f64,
    /// Share of the axle's input torque lost.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub axle_loss_share: f64,
    /// Shifting.
    pub shift: ShiftModel,
}

impl GearboxModel {
    /// Falling ratios, starting gears among the launching ones, and a clutch that slips above the
    /// idle speed, in rad/s.
    pub fn validate(&self, idle_radps: f64, problems: &mut Problems) {
        validate_ratios(&self.ratio, problems);
        let shift = &self.shift;
        for (key, gear) in [
            ("shift.start_gear", shift.start_gear),
            ("shift.steep_start_gear", shift.steep_start_gear),
            ("shift.launch_gears", shift.launch_gears),
        ] {
            let there = gear as usize <= self.ratio.len();
            problems.require(there, key, gear, "at most the number of gears");
        }
        let start = shift.start_gear.max(shift.steep_start_gear);
        problems.require(
            start <= shift.launch_gears,
            "shift.start_gear",
            start,
            "at most launch_gears: only there the clutch slips",
        );
        problems.require(
            shift.launch_speed_radps >= shift.open_share * idle_radps,
            "shift.launch_speed_radps",
            shift.launch_speed_radps,
            "at least open_share times the idle speed",
        );
    }

    /// Losses on the way to the wheels; `axle_per_m`: axle ratio over wheel radius, in 1/m.
    pub fn losses(&self, axle_per_m: f64) -> DrivelineLosses {
        DrivelineLosses {
            gearbox_nm: self.loss_torque_nm,
            gearbox_nms: self.loss_torque_nms.unwrap_or(0.0),
            floor_nm: self.loss_floor_nm.unwrap_or(0.0),
            retarder_n: self.retarder_torque_nm * axle_per_m,
            retarder_kgpm: self.retarder_torque_nms2.unwrap_or(0.0) * libm::pow(axle_per_m, 3.0),
            axle_n: self.axle_loss_torque_nm * axle_per_m,
            axle_share: self.axle_loss_share,
            per_kept_by_axle: 1.0 / (1.0 - self.axle_loss_share),
        }
    }

    /// Drag of the retarder at the wheels at a speed in m/s, in N.
    pub fn retarder_n(&self, axle_per_m: f64, speed_mps: f64) -> f64 {
        let shaft_radps = axle_per_m * speed_mps;
        let growth_nm = self.retarder_torque_nms2.unwrap_or(0.0) * shaft_radps * shaft_radps;
        (self.retarder_torque_nm + growth_nm) * axle_per_m
    }

    /// Torque at the gearbox's input, in Nm, for a force at the wheels, in N: the inverse of
    /// [`DrivelineLosses::wheel_and_lost_n`].
    pub fn input_torque_nm(
        &self,
        gear: &Gear,
        axle_per_m: f64,
        speed_mps: f64,
        wheel_n: f64,
    ) -> f64 {
        // x - share |x| = y has one solution, of the sign of y
        let undo =
            |y: f64, share: f64| if y >= 0.0 { y / (1.0 - share) } else { y / (1.0 + share) };
        let shaft = undo(wheel_n / axle_per_m + self.axle_loss_torque_nm, self.axle_loss_share);
        let retarder_nm = self.retarder_n(axle_per_m, speed_mps) / axle_per_m;
        let input_radps = gear.speed_ratio_per_m * speed_mps;
        let turning_nm = self.loss_torque_nm + self.loss_torque_nms.unwrap_or(0.0) * input_radps;
        let behind_nm = (shaft + retarder_nm) / gear.ratio + turning_nm;
        let torque_nm = undo(behind_nm, gear.loss_share);
        let floor_nm = self.loss_floor_nm.unwrap_or(0.0);
        if torque_nm.abs() < floor_nm { behind_nm + gear.loss_share * floor_nm } else { torque_nm }
    }

    /// The gears over a wheel.
    pub fn gears(&self, wheel_radius_m: f64) -> Vec<Gear> {
        let gear = |(k, &ratio): (usize, &f64)| {
            let direct = (ratio - 1.0_f64).abs() < 1e-9;
            Gear {
                speed_ratio_per_m: ratio * self.axle_ratio / wheel_radius_m,
                ratio,
                loss_share: if direct { self.direct_loss_share } else { self.indirect_loss_share },
                launches: (k as u32) < self.shift.launch_gears,
            }
        };
        self.ratio.iter().enumerate().map(gear).collect()
    }
}

/// The gears of a box, from first to top.
pub fn validate_ratios(ratio: &[f64], problems: &mut Problems) {
    let falls = ratio.windows(2).all(|pair| pair[0] > pair[1]);
    let fits = falls && (1..=24).contains(&ratio.len());
    problems.require(fits, "ratio", format!("{ratio:?}"), "1 to 24 falling ratios");
}

/// The shifting strategy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShiftModel {
    /// Time without torque, in s.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub duration_s: f64,
    /// Shortest time from shift to shift, in s.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub interval_s: f64,
    /// Shortest time from an upshift to a downshift and from a downshift to an upshift, in s.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub opposite_interval_s: f64,
    /// Time before a braking ramp without upshifts, in s.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub before_ramp_s: f64,
    /// Acceleration that an upshift has to leave, after its time without torque, in m/s².
    #[schemars(range(min = -10.0, max = 5.0))]
    pub minimum_acceleration_mps2: f64,
    /// Speed below which there is no shift, in m/s.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub minimum_speed_mps: f64,
    /// Engine speed of the upshift line at zero pedal, in rad/s.
    #[schemars(range(min = 20.0, max = 1024.0))]
    pub up_speed_radps: f64,
    /// Its rise with the pedal, in rad/s.
    #[schemars(range(min = 0.0, max = 1024.0))]
    pub up_pedal_radps: f64,
    /// Engine speed of the downshift line at zero pedal, in rad/s.
    #[schemars(range(min = 20.0, max = 1024.0))]
    pub down_speed_radps: f64,
    /// Its rise with the pedal, in rad/s.
    #[schemars(range(min = 0.0, max = 1024.0))]
    pub down_pedal_radps: f64,
    /// Engine speed above which the box shifts up in any case, in rad/s.
    #[schemars(range(min = 50.0, max = 1024.0))]
    pub overspeed_radps: f64,
    /// Share of full load that counts after an upshift.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub power_share: f64,
    /// Power demanded after an upshift over the road's.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub power_reserve: f64,
    /// Most gears in one upshift.
    #[schemars(range(min = 1.0, max = 20.0))]
    pub most_steps: u32,
    /// Highest gear (from 1) in which an upshift of a truck that gathers speed waits until it can
    /// skip the next gear; none where it is left out.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 24.0))]
    pub skip_gears: u32,
    /// Pedal from which a kick-down is asked for.
    #[schemars(range(min = 0.1, max = 1.0))]
    pub kickdown_pedal: f64,
    /// Time for which it has to be there, in s.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub kickdown_s: f64,
    /// Engine speed above which there is no kick-down, in rad/s.
    #[schemars(range(min = 20.0, max = 1024.0))]
    pub kickdown_speed_radps: f64,
    /// Gear in which a truck starts (from 1).
    #[schemars(range(min = 1.0, max = 24.0))]
    pub start_gear: u32,
    /// Gear in which it starts on a steep climb.
    #[schemars(range(min = 1.0, max = 24.0))]
    pub steep_start_gear: u32,
    /// Slope from which a climb is steep.
    #[schemars(range(min = 0.0, max = 0.3))]
    pub steep_slope: f64,
    /// Highest gear in which the clutch slips at a start.
    #[schemars(range(min = 1.0, max = 24.0))]
    pub launch_gears: u32,
    /// Engine speed while it slips, in rad/s.
    #[schemars(range(min = 20.0, max = 1024.0))]
    pub launch_speed_radps: f64,
    /// Share of the idle speed below which the clutch opens.
    #[schemars(range(min = 0.1, max = 1.0))]
    pub open_share: f64,
}

/// Whether no gear is skipped: what a vehicle does not say.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde lends the value")]
fn is_zero(number: &u32) -> bool {
    *number == 0
}

/// One gear, prepared for the hot loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gear {
    /// Engine speed for each m/s, in rad/m.
    pub speed_ratio_per_m: f64,
    /// Gearbox ratio.
    pub ratio: f64,
    /// Share of the input torque lost in the box.
    pub loss_share: f64,
    /// Whether the clutch may slip in it.
    pub launches: bool,
}

impl Gear {
    /// Engine speed below which the clutch may slip, in rad/s; 0 where it may not.
    pub fn slips_below_radps(&self, shift: &ShiftModel) -> f64 {
        if self.launches { shift.launch_speed_radps } else { 0.0 }
    }
}

/// The gears of a block.
#[derive(Clone, Debug)]
pub struct GearLanes<S: Simd> {
    /// Engine speed for each m/s, in rad/m.
    pub speed_ratio: Lanes<S>,
    /// The same in the next higher gear; 0 in the top gear.
    pub speed_ratio_up: Lanes<S>,
    /// The same in the gear that an upshift waits for while the truck gathers speed.
    pub speed_ratio_skip: Lanes<S>,
    /// The same in the next lower gear; unbounded in first gear.
    pub speed_ratio_down: Lanes<S>,
    /// Share of the input torque that the gearbox loses.
    pub loss_share: Lanes<S>,
    /// Engine speed below which the clutch may slip, in rad/s; 0 where it may not.
    pub slips_below: Lanes<S>,
    /// Torque for each N at the wheels without losses, in m.
    pub torque_per_n: Lanes<S>,
    /// Torque at the gearbox's input for each Nm of it that is left behind its share of loss.
    pub per_kept: Lanes<S>,
    /// Speed above which the engine turns too fast, in m/s; unbounded in the top gear.
    pub too_fast: Lanes<S>,
}

impl<S: Simd> GearLanes<S> {
    /// All in first gear, for trucks that stand for ever.
    pub fn parked(simd: S, gears: &[Gear]) -> Self {
        let all = |value| Lanes::splat(simd, value);
        Self {
            speed_ratio: all(gears[0].speed_ratio_per_m),
            speed_ratio_up: all(0.0),
            speed_ratio_skip: all(0.0),
            speed_ratio_down: all(UNBOUNDED),
            loss_share: all(gears[0].loss_share),
            slips_below: all(0.0),
            torque_per_n: all(1.0 / gears[0].speed_ratio_per_m),
            per_kept: all(1.0 / (1.0 - gears[0].loss_share)),
            too_fast: all(UNBOUNDED),
        }
    }

    /// Engine speed for each m/s in the gear that the next upshift waits for, in rad/m.
    #[inline(always)]
    pub fn upshift_ratio(&self, gathers: Flags<S>) -> Lanes<S> {
        gathers.select(self.speed_ratio_skip, self.speed_ratio_up)
    }

    /// Engages a gear, from 0, in a lane.
    pub fn engage(&mut self, lane: usize, gear: usize, gears: &[Gear], shift: &ShiftModel) {
        let ratio = |gear: usize| gears.get(gear).map(|gear| gear.speed_ratio_per_m);
        let down = gear.checked_sub(1).and_then(ratio);
        let (here, up) = (&gears[gear], ratio(gear + 1));
        self.speed_ratio[lane] = here.speed_ratio_per_m;
        self.speed_ratio_up[lane] = up.unwrap_or(0.0);
        let skips = gear < shift.skip_gears as usize && shift.most_steps > 1;
        let skip = if skips { ratio(gear + 2).or(up) } else { up };
        self.speed_ratio_skip[lane] = skip.unwrap_or(0.0);
        self.speed_ratio_down[lane] = down.unwrap_or(UNBOUNDED);
        self.loss_share[lane] = here.loss_share;
        self.slips_below[lane] = here.slips_below_radps(shift);
        self.torque_per_n[lane] = 1.0 / here.speed_ratio_per_m;
        self.per_kept[lane] = 1.0 / (1.0 - here.loss_share);
        let too_fast = shift.overspeed_radps / here.speed_ratio_per_m;
        self.too_fast[lane] = if up.is_some() { too_fast } else { UNBOUNDED };
    }
}

/// Losses on the way from the gearbox's input to the wheels, those behind the gearbox as forces at
/// the wheels.
#[derive(Clone, Copy, Debug)]
pub struct DrivelineLosses {
    gearbox_nm: f64,
    gearbox_nms: f64,
    floor_nm: f64,
    retarder_n: f64,
    retarder_kgpm: f64,
    axle_n: f64,
    axle_share: f64,
    /// Force behind the gearbox for each N behind the axle's share of loss.
    per_kept_by_axle: f64,
}

impl DrivelineLosses {
    /// Torques at the gearbox's input, in Nm, for forces that drive the wheels, in N: the inverse
    /// of [`DrivelineLosses::wheel_and_lost_forces_n`] where the torque is above the floor of its
    /// share of loss.
    #[inline(always)]
    pub fn driving_torques_nm<S: Simd>(
        &self,
        gear: &GearLanes<S>,
        speed_mps: Lanes<S>,
        wheel_n: Lanes<S>,
    ) -> Lanes<S> {
        let retarder_n = speed_mps * speed_mps * self.retarder_kgpm + self.retarder_n;
        let shaft_n = (wheel_n + self.axle_n) * self.per_kept_by_axle + retarder_n;
        let turning_nm = gear.speed_ratio * speed_mps * self.gearbox_nms + self.gearbox_nm;
        (shaft_n * gear.torque_per_n + turning_nm) * gear.per_kept
    }

    /// Forces at the wheels for torques at the gearbox's input, and what gearbox, retarder and axle
    /// take on the way, in N.
    ///
    /// `per_m`: engine speed for each m/s in the gear, in rad/m; `loss_share`: what the gear loses;
    /// `speed_mps`: of the truck.
    #[inline(always)]
    pub fn wheel_and_lost_forces_n<S: Simd>(
        &self,
        per_m: Lanes<S>,
        loss_share: Lanes<S>,
        speed_mps: Lanes<S>,
        torque_nm: Lanes<S>,
    ) -> [Lanes<S>; 2] {
        let turning_nm = per_m * speed_mps * self.gearbox_nms + self.gearbox_nm;
        let gearbox_nm = loss_share * torque_nm.abs().at_least(self.floor_nm) + turning_nm;
        let retarder_n = speed_mps * speed_mps * self.retarder_kgpm + self.retarder_n;
        let shaft_n = per_m * (torque_nm - gearbox_nm) - retarder_n;
        let axle_n = shaft_n.abs() * self.axle_share + self.axle_n;
        [shaft_n - axle_n, per_m * gearbox_nm + axle_n + retarder_n]
    }

    /// [`Self::wheel_and_lost_forces_n`] of one truck in a gear.
    pub fn wheel_and_lost_n(&self, gear: &Gear, speed_mps: f64, torque_nm: f64) -> [f64; 2] {
        let (per_m, share) = (one(gear.speed_ratio_per_m), one(gear.loss_share));
        let forces = self.wheel_and_lost_forces_n(per_m, share, one(speed_mps), one(torque_nm));
        forces.map(|forces| forces[0])
    }
}

/// Inputs of the shift strategy.
#[derive(Clone, Copy, Debug)]
pub struct ShiftInputs {
    /// Gear, from 0.
    pub gear: usize,
    /// Speed, in m/s.
    pub speed_mps: f64,
    /// Accelerator pedal.
    pub pedal: f64,
    /// Whether the truck slows.
    pub slowing: bool,
    /// Whether the pedal has been down long enough for a kick-down.
    pub kickdown: bool,
    /// Whether the clutch is closed.
    pub closed: bool,
    /// Steady power that the road asks for, in W.
    pub road_power_w: f64,
    /// Whether an upshift is allowed but for the lines.
    pub may_up: bool,
    /// Whether a downshift is allowed but for the lines.
    pub may_down: bool,
    /// Idle speed, in rad/s: an engine below it is shifted down in any case.
    pub idle_radps: f64,
    /// Moving mass without the engine, in kg.
    pub mass_kg: f64,
    /// Inertia of the engine, in kg m².
    pub inertia_kgm2: f64,
}

impl ShiftModel {
    /// Shortest times from a shift to the next one up and down, in s.
    pub fn intervals_s(&self, upwards: bool) -> [f64; 2] {
        let opposite_s = self.opposite_interval_s.max(self.interval_s);
        if upwards { [self.interval_s, opposite_s] } else { [opposite_s, self.interval_s] }
    }

    /// The gear (from 0) that the strategy wants now.
    pub fn wanted_gear(
        &self,
        inputs: &ShiftInputs,
        gears: &[Gear],
        full_load_nm: impl Fn(f64) -> f64,
    ) -> usize {
        let gear = inputs.gear;
        let speed = |g: usize| gears[g].speed_ratio_per_m * inputs.speed_mps;
        let cannot_launch = !inputs.closed && !gears[gear].launches && inputs.pedal > 0.0;
        if inputs.speed_mps <= self.minimum_speed_mps {
            // a truck that has rolled to rest in a high gear
            return if cannot_launch { 0 } else { gear };
        }
        let up_line = self.up_speed_radps + self.up_pedal_radps * inputs.pedal;
        let power_w = |w: f64| self.power_share * full_load_nm(w) * w;
        let strong = |g: usize| power_w(speed(g)) >= self.power_reserve * inputs.road_power_w;
        // while no torque passes the road slows the truck
        let road_n = inputs.road_power_w / inputs.speed_mps;
        let after_mps = inputs.speed_mps - self.duration_s * road_n.max(0.0) / inputs.mass_kg;
        let accelerates = |g: usize| {
            let per_m = gears[g].speed_ratio_per_m;
            let mass_kg = inputs.mass_kg + inputs.inertia_kgm2 * per_m * per_m;
            let wanted_n = road_n + self.minimum_acceleration_mps2 * mass_kg;
            after_mps > 0.0 && power_w(per_m * after_mps) >= wanted_n * after_mps
        };
        let top = (gear + self.most_steps as usize).min(gears.len() - 1);
        let fits = |g: &usize| speed(*g) >= up_line && strong(*g) && accelerates(*g);
        if let Some(up) = (gear + 1..=top).rev().find(fits).filter(|_| inputs.may_up) {
            return up;
        }
        if gear + 1 < gears.len() && speed(gear) > self.overspeed_radps {
            return gear + 1;
        }
        let urgent = speed(gear) < inputs.idle_radps;
        if gear == 0 || !inputs.slowing || !(inputs.may_down || urgent) {
            return gear;
        }
        let low = speed(gear) < self.down_speed_radps + self.down_pedal_radps * inputs.pedal;
        if low && (inputs.closed || cannot_launch) {
            // the highest gear that is above the upshift line, otherwise first gear
            let fits = (0..gear).rev().find(|&g| speed(g) >= up_line);
            return fits.unwrap_or(0);
        }
        if inputs.kickdown
            && speed(gear) < self.kickdown_speed_radps
            && speed(gear - 1) < self.overspeed_radps
        {
            return gear - 1;
        }
        gear
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One to launch in and one that is direct.
    fn two_gears() -> GearboxModel {
        serde_json::from_value(serde_json::json!({
            "ratio": [14.94, 1.0], "loss_torque_nm": 5.1,
            "loss_torque_nms": 0.1, "loss_floor_nm": 200.0, "retarder_torque_nms2": 2e-4,
            "direct_loss_share": 0.005, "indirect_loss_share": 0.02,
            "retarder_torque_nm": 10.0, "axle_ratio": 2.64,
            "axle_loss_torque_nm": 40.0, "axle_loss_share": 0.015,
            "shift": { "duration_s": 1.0, "interval_s": 2.0, "minimum_speed_mps": 0.5,
                "opposite_interval_s": 10.0, "before_ramp_s": 4.0,
                "minimum_acceleration_mps2": 0.1,
                "up_speed_radps": 95.0, "up_pedal_radps": 32.0, "down_speed_radps": 88.0,
                "down_pedal_radps": 20.0, "overspeed_radps": 219.0, "power_share": 0.95,
                "power_reserve": 1.1, "most_steps": 3, "kickdown_pedal": 0.99, "kickdown_s": 2.0,
                "kickdown_speed_radps": 136.0, "start_gear": 1, "steep_start_gear": 1,
                "steep_slope": 0.05, "launch_gears": 1, "launch_speed_radps": 84.0,
                "open_share": 0.9 }
        }))
        .unwrap()
    }

    #[test]
    fn a_truck_at_rest_in_a_high_gear_is_driven_in_first() {
        let model = two_gears();
        let gears = model.gears(0.492);
        let wanted = |pedal, closed| {
            let (speed_mps, road_power_w) = (0.0, 0.0);
            let inputs = ShiftInputs {
                gear: 1,
                speed_mps,
                pedal,
                slowing: false,
                kickdown: false,
                closed,
                road_power_w,
                may_up: true,
                may_down: true,
                idle_radps: 60.0,
                mass_kg: 20_000.0,
                inertia_kgm2: 5.0,
            };
            model.shift.wanted_gear(&inputs, &gears, |_| 1000.0)
        };
        // without a pedal the truck is not to go, and a motor on the wheels needs no clutch
        assert_eq!([wanted(0.5, false), wanted(0.0, false), wanted(0.5, true)], [0, 1, 1]);
    }

    #[test]
    fn the_torque_behind_a_force_gives_that_force() {
        let model = two_gears();
        let losses = model.losses(2.64 / 0.492);
        for gear in model.gears(0.492) {
            for force_n in [-50_000.0, -300.0, -80.0, 0.0, 10.0, 4000.0, 90_000.0] {
                let torque = model.input_torque_nm(&gear, 2.64 / 0.492, 12.0, force_n);
                let [back, lost] = losses.wheel_and_lost_n(&gear, 12.0, torque);
                let given = gear.speed_ratio_per_m * torque;
                assert!((given - back - lost).abs() < 1e-9 * given.abs().max(100.0), "{force_n}");
                assert!((back - force_n).abs() < 1e-9 * force_n.abs().max(100.0), "{force_n}");
            }
        }
    }
}
