//! Temperatures of the batteries of a block, outside of the hot loop: what their trucks' sums have
//! gained since they were looked at last warms them, and sets what they can give and take.

use super::BatteryElectricPowertrain;
use super::powertrain::{BatteryState, charged_beside};
use crate::charging::ChargeCourse;
use crate::energy::ledger::{Ledger, Term};
use crate::lanes::Lanes;
use crate::powertrain::component::battery::BatteryModel;
use crate::powertrain::component::thermal::ThermalModel;
use crate::powertrain::{Charge, Plug};
use crate::record::Record;
use fearless_simd::prelude::*;
use std::borrow::Cow;

/// Longest time at rest for which one temperature holds, in s.
const SLICE_S: f64 = 300.0;
/// A slice that ends so much before its time has charged all that there was to charge.
const WHOLE: f64 = 1.0 - 1e-9;

/// Temperatures, and what has changed them.
#[derive(Clone, Debug)]
pub(super) struct Temperatures<S: Simd> {
    /// Temperature of the batteries, in K.
    battery: Lanes<S>,
    /// Temperature of the air, in K.
    air: Lanes<S>,
    /// Power of the auxiliaries without heater and cooler, in W.
    pub(super) auxiliary: Lanes<S>,
    /// Heat that heater and cooler bring now, in W.
    heat: Lanes<S>,
    /// Energy that they have taken, in J.
    taken: Lanes<S>,
    /// Driving time, in s, and heat of the battery, in J, that have been seen.
    seen_s: Lanes<S>,
    seen_j: Lanes<S>,
}

impl<S: Simd> Temperatures<S> {
    /// Temperatures of batteries that have none.
    pub(super) fn none(simd: S) -> Self {
        let zero = Lanes::splat(simd, 0.0);
        Self {
            battery: zero,
            air: zero,
            auxiliary: zero,
            heat: zero,
            taken: zero,
            seen_s: zero,
            seen_j: zero,
        }
    }

    /// The columns.
    pub(super) fn memory(&mut self) -> [&mut Lanes<S>; 7] {
        [
            &mut self.battery,
            &mut self.air,
            &mut self.auxiliary,
            &mut self.heat,
            &mut self.taken,
            &mut self.seen_s,
            &mut self.seen_j,
        ]
    }
}

impl BatteryElectricPowertrain {
    fn thermal(&self) -> Option<&ThermalModel> {
        self.model.battery.thermal.as_ref()
    }

    /// A truck departs.
    pub(super) fn enter_temperature<S: Simd>(
        &self,
        state: &mut BatteryState<S>,
        lane: usize,
        air_temperature_k: f64,
    ) {
        let Some(thermal) = self.thermal() else { return };
        for column in state.temperatures.memory() {
            column[lane] = 0.0;
        }
        state.temperatures.air[lane] = air_temperature_k;
        state.temperatures.battery[lane] = thermal.departure_k(air_temperature_k);
        state.temperatures.auxiliary[lane] = state.auxiliary_power[lane];
        self.condition(state, lane, false);
    }

    /// The battery of one lane as it is now.
    pub(super) fn battery_of<S: Simd>(
        &self,
        state: &BatteryState<S>,
        lane: usize,
    ) -> Cow<'_, BatteryModel> {
        let battery = &self.model.battery;
        self.thermal().map_or(Cow::Borrowed(battery), |thermal| {
            let temperature_k = state.temperatures.battery[lane];
            Cow::Owned(thermal.at(battery, temperature_k, state.charge[lane]))
        })
    }

    /// Temperature and what heater and cooler have taken, in J, after the truck has been driven on.
    fn driven_on<S: Simd>(
        thermal: &ThermalModel,
        state: &BatteryState<S>,
        lane: usize,
        ledger: &Ledger<f64>,
    ) -> [f64; 2] {
        let now = &state.temperatures;
        let (before_k, taken_j) = (now.battery[lane], now.taken[lane]);
        let time_s = ledger[Term::Time] - now.seen_s[lane];
        if !(time_s > 0.0) {
            return [before_k, taken_j];
        }
        let own_w = (ledger[Term::BatteryLoss] - now.seen_j[lane]) / time_s;
        let after_k = thermal.after_k(before_k, now.air[lane], own_w + now.heat[lane], time_s);
        let conditioning_w = state.auxiliary_power[lane] - now.auxiliary[lane];
        [after_k, taken_j + conditioning_w * time_s]
    }

    /// The truck has been driven on since its temperature was looked at.
    pub(super) fn pass_temperature<S: Simd>(
        &self,
        state: &mut BatteryState<S>,
        lane: usize,
        ledger: &Ledger<f64>,
    ) {
        let Some(thermal) = self.thermal() else { return };
        let [after_k, taken_j] = Self::driven_on(thermal, state, lane, ledger);
        let now = &mut state.temperatures;
        (now.battery[lane], now.taken[lane]) = (after_k, taken_j);
        now.seen_s[lane] = ledger[Term::Time];
        now.seen_j[lane] = ledger[Term::BatteryLoss];
    }

    /// Turns heater and cooler on and off, and sets what the battery can give and take.
    pub(super) fn condition<S: Simd>(
        &self,
        state: &mut BatteryState<S>,
        lane: usize,
        preconditions: bool,
    ) {
        let Some(thermal) = self.thermal() else { return };
        let temperature_k = state.temperatures.battery[lane];
        let [electric_w, heat_w] = thermal.conditioning_w(temperature_k, preconditions);
        state.auxiliary_power[lane] = state.temperatures.auxiliary[lane] + electric_w;
        state.temperatures.heat[lane] = heat_w;
        let charge = state.charge[lane];
        let limits = thermal.limits_at(&self.model.battery, temperature_k, charge);
        state.limits.set(lane, limits);
    }

    /// Charges one lane, slice by slice: its temperature changes meanwhile.
    pub(super) fn charge_by_temperature<S: Simd>(
        &self,
        state: &mut BatteryState<S>,
        lane: usize,
        plug: &Plug,
        course: &mut ChargeCourse,
    ) -> Charge {
        let mut done = Charge::default();
        let Some(thermal) = self.thermal() else { return done };
        loop {
            let temperature_k = state.temperatures.battery[lane];
            let curve = plug.curve.map(|curve| curve.at(temperature_k));
            let longest_s = SLICE_S.min(plug.longest_s - done.time_s);
            let slice = Plug { curve: curve.as_deref(), longest_s, ..*plug };
            let mut slice_course = ChargeCourse::default();
            // at a charger it is heated as ahead of one
            let [electric_w, heat_w] = thermal.conditioning_w(temperature_k, true);
            let auxiliary_w = state.temperatures.auxiliary[lane] + electric_w;
            let charge = state.charge[lane] + done.gained_j / self.model.battery.capacity_j;
            let battery = thermal.at(&self.model.battery, temperature_k, charge);
            let part = charged_beside(&battery, &slice, auxiliary_w, charge, &mut slice_course);
            if !(part.time_s > 0.0) {
                break;
            }
            course.append(&slice_course);
            let flow_w = part.loss_j / part.time_s + heat_w;
            let now = &mut state.temperatures;
            now.battery[lane] = thermal.after_k(temperature_k, now.air[lane], flow_w, part.time_s);
            now.taken[lane] += electric_w * part.time_s;
            done.add(&part);
            if part.time_s < WHOLE * longest_s {
                break;
            }
        }
        done
    }

    /// Power of the auxiliaries at rest, in W: heater and cooler run only while the truck is
    /// charged.
    pub(super) fn auxiliary_at_rest_w<S: Simd>(&self, state: &BatteryState<S>, lane: usize) -> f64 {
        match self.thermal() {
            Some(_) => state.temperatures.auxiliary[lane],
            None => state.auxiliary_power[lane],
        }
    }

    /// The truck has stood for some time, in s, in which a heat of the battery, in J, warmed it.
    pub(super) fn stand_temperature<S: Simd>(
        &self,
        state: &mut BatteryState<S>,
        lane: usize,
        [time_s, loss_j]: [f64; 2],
    ) {
        let Some(thermal) = self.thermal() else { return };
        let now = &mut state.temperatures;
        let loss_w = if time_s > 0.0 { loss_j / time_s } else { 0.0 };
        now.battery[lane] = thermal.after_k(now.battery[lane], now.air[lane], loss_w, time_s);
        // it has been seen
        now.seen_j[lane] += loss_j;
        self.condition(state, lane, false);
    }

    /// Fills in the columns of the temperature.
    pub(super) fn record_temperature<S: Simd>(
        &self,
        state: &BatteryState<S>,
        lane: usize,
        ledger: &Ledger<f64>,
        record: &mut Record,
    ) {
        let Some(thermal) = self.thermal() else { return };
        let [after_k, taken_j] = Self::driven_on(thermal, state, lane, ledger);
        record.final_battery_temperature_k = Some(after_k);
        record.battery_conditioning_energy_j = Some(taken_j);
    }
}
