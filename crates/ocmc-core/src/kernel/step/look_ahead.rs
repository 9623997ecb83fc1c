//! Decision by looking ahead for a step: whether the truck coasts, in gear or with an open clutch.
//!
//! Checked in `tests/it/look_ahead.rs`: each switch saves on the default fleet, paired, with its
//! interval, and the energy balance of every cycle closes to 1e-9. The clutch opens on −1.25 % and
//! not on −0.6 %, and a crest before −4 % is passed more slowly, one before −1.1 % is not. With all
//! switches off every record is the same, bit for bit, as before there were any.

use super::control::DesiredSpeed;
use super::forecast::Forecast;
use super::road_row::{RoadRowLanes, coasting_target, is_limited_by_sign};
use super::state::{KernelParameters, State};
use crate::lanes::{Bounded, Flags, Lanes, UNBOUNDED, clip};
use crate::powertrain::Powertrain;
use fearless_simd::prelude::*;

/// VECTO's decision factor is 1 before changes of speed that end above 52 km/h and are smaller than
/// 9 km/h; between these and 48 and 11 km/h it goes over to that of the study [F: VECTO 3, user
/// manual, look-ahead coasting].
const SLOW_END_MPS: f64 = 48.0 / 3.6;
const LARGE_CHANGE_MPS: f64 = 11.0 / 3.6;
const PER_SLOW_RANGE: f64 = 3.6 / 4.0;
const PER_CHANGE_RANGE: f64 = 3.6 / 2.0;
/// Deceleration that an open clutch takes before it closes again, in m/s² (judgement: a crest is
/// over).
const ROLLED_OUT_MPS2: f64 = 0.05;

/// Decision of looking ahead.
#[derive(Clone, Copy)]
pub(super) struct LookAhead<S: Simd> {
    /// Flag: the accelerator stays closed.
    pub coasts: Flags<S>,
    /// Flag: the clutch stays open.
    pub rolls: Flags<S>,
}

impl<S: Simd, P: Powertrain> State<S, P> {
    /// Rises through zero where a truck begins to coast before a lower speed: from where the
    /// deceleration that the speed asks for is the decision factor times that of coasting.
    #[inline(always)]
    pub(super) fn coasting_function(
        &self,
        row: &RoadRowLanes<S>,
        speed: Lanes<S>,
        desired: &DesiredSpeed<S>,
        forecast: &Forecast<S>,
        parameters: &KernelParameters<P>,
    ) -> Lanes<S> {
        let model = parameters.look_ahead;
        let target = coasting_target(row, Lanes::splat(speed.simd, parameters.stop_target));
        let too_fast = speed * speed - target;
        let way = desired.backward - target;
        let end = target.at_most(UNBOUNDED).sqrt();
        let fast_end = clip((end - SLOW_END_MPS) * PER_SLOW_RANGE, 0.0, 1.0);
        let small = clip((end - speed + LARGE_CHANGE_MPS) * PER_CHANGE_RANGE, 0.0, 1.0);
        let factor = model.decision_factor - fast_end * small * (model.decision_factor - 1.0);
        let twice = self.constants.twice_deceleration;
        let late = twice * too_fast - factor * forecast.coasting * way * 2.0;
        let seen = twice * speed * model.preview_s - way;
        let may = speed.simd_gt(model.minimum_speed_mps) & too_fast.simd_gt(0.0);
        may.select(late.at_most(seen), Lanes::splat(speed.simd, -1.0))
    }

    /// For the trucks of a block; `ramps`: flag, a braking ramp lies under the truck or just before
    /// it.
    #[inline(always)]
    pub(super) fn look_ahead(
        &self,
        row: &RoadRowLanes<S>,
        desired: &DesiredSpeed<S>,
        forecast: &Forecast<S>,
        ramps: Flags<S>,
        parameters: &KernelParameters<P>,
    ) -> LookAhead<S> {
        let model = parameters.look_ahead;
        let speed = self.motion.speed;
        let never = Flags::splat(speed.simd, false);
        if !parameters.looks_ahead {
            return LookAhead { coasts: never, rolls: never };
        }
        let fast = speed.simd_gt(model.minimum_speed_mps);

        let before = self.coasting_function(row, speed, desired, forecast, parameters).simd_gt(0.0);

        // on a descent that gives speed
        let by_sign = is_limited_by_sign(row);
        let slow = (desired.speed - speed).simd_gt(model.underspeed_mps);
        let level = fast & by_sign & !slow & !ramps;
        let falls = level & forecast.coasting.simd_lt(0.0);
        let coasts = if model.predictive_cruise { before | falls } else { before };

        // with the clutch open: from where gravity keeps the speed to the edges of its bands
        let was_rolling = self.motion.rolling.simd_gt(0.0);
        let edge = parameters.pedals.overspeed_band_mps;
        // a clutch that has closed at the band's edge does not open again before its middle
        let over = speed - desired.speed;
        let in_band = !over.simd_gt(0.5 * edge) | was_rolling & !over.simd_gt(edge);
        let keeps =
            forecast.neutral.simd_lt(0.0) | was_rolling & forecast.neutral.simd_lt(ROLLED_OUT_MPS2);
        let rolls = level & in_band & keeps & !before;
        let rolls = if model.eco_roll { rolls } else { never };
        LookAhead { coasts: coasts | rolls, rolls }
    }
}
