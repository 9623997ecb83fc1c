//! Wish of the driver, and his action on the pedals: the desired speed under the truck, and the
//! operational module at one stage.

use super::forecast::Forecast;
use super::look_ahead::LookAhead;
use super::road_row::{RoadRow, RoadRowLanes, is_limited_by_sign, static_limit};
use super::state::{KernelParameters, State};
use crate::lanes::{Bounded, Flags, Lanes, clip, masked};
use crate::powertrain::Powertrain;
use fearless_simd::prelude::*;

/// The desired speed at one place.
#[derive(Clone, Copy)]
pub(super) struct DesiredSpeed<S: Simd> {
    /// In m/s.
    pub speed: Lanes<S>,
    /// Its square on a braking ramp, in m²/s².
    pub backward: Lanes<S>,
    /// Its square where there is no ramp, in m²/s²: the static limit, or what the driver's
    /// acceleration has come to.
    level: Lanes<S>,
    /// Rises through zero where the driver's acceleration has come to the plan, in m²/s².
    pub rise_function: Lanes<S>,
}

impl<S: Simd> DesiredSpeed<S> {
    /// Its square, in m²/s².
    #[inline(always)]
    pub(super) fn squared(&self) -> Lanes<S> {
        self.level.at_most(self.backward)
    }

    /// Rises through zero where a driver prepares for a braking ramp; `lead`: difference of v² from
    /// there to the ramp, in m²/s². Without lead it is where the ramp begins, and zero along it.
    #[inline(always)]
    pub(super) fn ramp_function(&self, lead: Lanes<S>) -> Lanes<S> {
        self.level + lead - self.backward
    }
}

/// Decision of a driver for a step.
#[derive(Clone, Copy)]
pub(super) struct Stance<S: Simd> {
    pub forecast: Forecast<S>,
    /// Flag: the desired speed rises with the driver's acceleration.
    pub rises: Flags<S>,
    /// Flag: a braking ramp lies under the truck, or just before it.
    pub ramps: Flags<S>,
    /// Flag: the driver follows it with feed-forward.
    pub feeds: Flags<S>,
    /// Flag: the driver follows a rise of the desired speed with feed-forward.
    pub gathers: Flags<S>,
    /// Flag: a switched driver holds.
    pub hold: Flags<S>,
    /// Output that he holds.
    pub held: Lanes<S>,
    /// Action for what lies ahead.
    pub look_ahead: LookAhead<S>,
}

/// Action of the driver in one stage.
#[derive(Clone, Copy)]
pub(super) struct Control<S: Simd> {
    pub desired: Lanes<S>,
    /// The controller's output, and what the brakes see of it.
    pub output: Lanes<S>,
    pub demand: Lanes<S>,
    pub accelerator: Lanes<S>,
    pub brake: Lanes<S>,
    /// Part of the controller's output that the brakes realise, without its sign.
    pub braking: Lanes<S>,
    pub integral_rate: Lanes<S>,
}

impl<S: Simd, P: Powertrain> State<S, P> {
    /// The desired speed; `ceiling`: what the driver's acceleration has come to, squared.
    #[inline(always)]
    pub(super) fn desired(
        &self,
        row: &RoadRowLanes<S>,
        left: Lanes<S>,
        ceiling: Lanes<S>,
    ) -> DesiredSpeed<S> {
        let backward = row[RoadRow::BACKWARD] + self.constants.twice_deceleration * left;
        let level = row[RoadRow::LIMIT].at_most(ceiling);
        let rise_function = ceiling - row[RoadRow::LIMIT].at_most(backward);
        DesiredSpeed { speed: level.at_most(backward).sqrt(), backward, level, rise_function }
    }

    /// The ceiling of the desired speed, squared, some time later: the inverse acceleration g grows
    /// as g² = g₀² + 2 t dg/dv.
    #[inline(always)]
    pub(super) fn ceiling_after(&self, desired: Lanes<S>, dt: Lanes<S>) -> Lanes<S> {
        let (from_rest, per_mps) = (self.constants.rise_from_rest, self.constants.rise_per_mps);
        let twice = dt + dt;
        let before = from_rest + per_mps * desired;
        let after = (before * before + per_mps * twice).sqrt();
        let risen = desired + twice / (before + after);
        risen * risen
    }

    /// Decision of the driver for a step.
    #[inline(always)]
    pub(super) fn stance(
        &self,
        row: &RoadRowLanes<S>,
        desired: &DesiredSpeed<S>,
        parameters: &KernelParameters<P>,
    ) -> Stance<S> {
        let (motion, constants) = (&self.motion, &self.constants);
        let forecast = self.forecast(row, parameters);
        let ramps = !desired.ramp_function(desired.speed * constants.lead).simd_lt(0.0);
        let foresees = constants.feeds.simd_gt(0.0);
        let feeds = ramps & foresees;
        // while the desired speed rises there is nothing to hold
        let rises = desired.rise_function.simd_lt(0.0);
        let was_holding = motion.holding.simd_gt(0.0);
        let threshold = was_holding.select(constants.threshold, constants.entry_threshold);
        let error = desired.speed - motion.speed;
        // whose truck has come to rest wants to go on, however slowly
        let within = error.abs().simd_lt(threshold) & motion.speed.simd_gt(0.0);
        let look_ahead = self.look_ahead(row, desired, &forecast, ramps, parameters);
        let hold = within & !feeds & !rises & !look_ahead.coasts;
        // what is held is the output at the moment when holding began, or the pedal that keeps the
        // speed then
        let effort = constants.proportional * error;
        let begun = constants.balances.simd_gt(0.0).select(forecast.holding, effort);
        let held = was_holding.select(motion.held, begun);
        // held throttle: a held brake is released when e >= 0, unless the driver holds as printed
        // in the paper
        let held = error.simd_lt(0.0).select(held, held.at_least(constants.lowest_held));
        let gathers = rises & foresees & !feeds;
        Stance { forecast, rises, ramps, feeds, gathers, hold, held, look_ahead }
    }

    /// The operational module at one stage; `rise`: accelerator that gives the driver's
    /// acceleration.
    #[inline(always)]
    pub(super) fn control(
        &self,
        row: &RoadRowLanes<S>,
        speed: Lanes<S>,
        desired: Lanes<S>,
        integral: Lanes<S>,
        filtered: Lanes<S>,
        rise: Lanes<S>,
        stance: &Stance<S>,
        parameters: &KernelParameters<P>,
    ) -> Control<S> {
        let (pedals, constants) = (parameters.pedals, &self.constants);
        let error = desired - speed;
        let lag = speed - filtered;
        let effort = constants.proportional * error;
        // around the pedal that keeps the speed, held or not, a driver in balance corrects what is
        // more than the error at which he begins to hold
        let balances = constants.balances.simd_gt(0.0);
        let free = constants.dead_zone;
        let corrected = constants.proportional * (error - error.at_most(free).at_least(-free));
        let around = balances.select(stance.forecast.holding, integral);
        let continuous = corrected + around - constants.derivative_over_filter * lag;
        let held = stance.held + masked(balances, corrected);
        // the accelerator stays closed while a ramp asks for less
        let follows = stance.forecast.ramp.at_most(0.0) + constants.ramp_gain * error;
        let gathers = rise + effort;
        let output = stance.hold.select(held, stance.gathers.select(gathers, continuous));
        let output = stance.feeds.select(follows, output);
        // who coasts leaves the accelerator
        let output = stance.look_ahead.coasts.select(output.at_most(0.0), output);

        // speed limiter: above its speed the pedal goes down less and less far
        let vehicle = &parameters.vehicle.model;
        let end_mps = vehicle.limiter_speed_mps + vehicle.limiter_range_mps;
        let allowed = (end_mps - speed) * parameters.per_limiter_range;
        let allowed = allowed.at_most(stance.forecast.peak);
        let accelerator = clip(output.at_most(allowed), 0.0, 1.0);

        // overspeed band: above a sign's limit the driver lets the truck run up to its edge; where
        // there is neither ramp nor band, up to his tolerance
        let in_band =
            speed.simd_gt(pedals.overspeed_from_mps) & !stance.ramps & is_limited_by_sign(row);
        let slack = in_band.select(constants.band_output, constants.tolerance_output);
        // at the beginning of a ramp nobody brakes yet: a small one is coasted
        let yet = (desired - static_limit(row) * parameters.braked_share).at_least(0.0);
        let begun = output + constants.ramp_gain * yet;
        let edge = stance.feeds.select(begun, effort + slack);
        let demand = output.at_least(edge);
        // who gathers speed is not pushed harder by a descent than he lets the engine
        let demand = stance.rises.select(demand.at_most(stance.forecast.holding_back), demand);
        let braking = clip(-demand, 0.0, parameters.per_brake_scale);
        let realised = accelerator - braking;
        Control {
            desired,
            output,
            demand,
            accelerator,
            brake: (braking * pedals.brake_scale).at_most(1.0),
            braking,
            // behind a rise the integral part goes on from the pedal that keeps the speed
            integral_rate: stance.gathers.select(
                constants.tracking * (stance.forecast.holding - integral),
                constants.integral_gain * error + constants.tracking * (realised - output),
            ),
        }
    }
}

/// The integral part within its bounds (integral clamp). Zero is within, and stays there for a
/// driver without an integral part.
#[inline(always)]
pub(super) fn clamp_integral<S: Simd, P: Powertrain>(
    integral: Lanes<S>,
    parameters: &KernelParameters<P>,
) -> Lanes<S> {
    let pid = &parameters.pedals.pid;
    clip(integral, pid.integral_minimum, pid.integral_maximum)
}
