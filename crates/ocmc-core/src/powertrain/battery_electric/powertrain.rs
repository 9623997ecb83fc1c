//! A battery and a motor, in the step of the kernel.
//!
//! The motor's torque follows the pedals at once: accelerator times the highest torque, less the
//! motor's share of what the brake pedal asks for. Where the battery cannot give or take so much,
//! the torque is brought back to what it can. At rest and in a shift there is none. State of charge
//! is frozen over a step. Of a step the motor's loss is the map at the step's mean speed and
//! torque, the battery's the circuit at its mean power: shaft work, losses and auxiliaries are
//! integrated each on its own.

use super::BatteryElectricPowertrain;
use super::inverse::InverseBatteryElectric;
use super::temperature::Temperatures;
use crate::charging::ChargeCourse;
use crate::energy::Carrier;
use crate::energy::ledger::{Ledger, Mode, StepLedger, Term};
use crate::first_order_lag::FirstOrderLag;
use crate::lanes::{Bounded, Flags, Lanes, WIDTH, masked};
use crate::powertrain::component::battery::{BatteryLimits, BatteryModel};
use crate::powertrain::component::gearbox::GearLanes;
use crate::powertrain::{
    Charge, Coupling, Demand, InversePowertrain, PedalForces, Plug, Powertrain,
    PowertrainConstants, ShaftStep, SignalNames, Store, TractiveEffort, TruckInputs,
};
use crate::record::{Outcome, Record};
use fearless_simd::prelude::*;

/// Energy of the battery that never empties, over that of the truck's own: deep enough that its
/// voltage stays near that of a charged battery on trips as long as a day (judgement). Below its
/// lowest charge the voltage of an empty battery is held.
const NEVER_EMPTYING_DEPTH: f64 = 3.0;

/// The batteries of a block.
#[derive(Clone, Debug)]
pub struct BatteryState<S: Simd> {
    /// State of charge; without end in a parked lane.
    pub charge: Lanes<S>,
    /// Power of the auxiliaries, in W.
    pub auxiliary_power: Lanes<S>,
    /// The most that a charger gives them at rest, in W, and what it has given since the truck was
    /// charged, in J.
    plug_power: Lanes<S>,
    carried: Lanes<S>,
    /// Limits of power that they can give and take now.
    pub(in crate::powertrain) limits: BatteryLimits<S>,
    /// Their temperatures, where they have any.
    pub(super) temperatures: Temperatures<S>,
}

impl BatteryElectricPowertrain {
    /// The torques within the battery's limits, in Nm.
    #[inline(always)]
    fn within_battery<S: Simd>(
        &self,
        state: &BatteryState<S>,
        speed: Lanes<S>,
        torque: Lanes<S>,
    ) -> Lanes<S> {
        let battery = &self.model.battery;
        let drawn = speed * torque + self.motor.losses_w(speed, torque) + state.auxiliary_power;
        let most = battery.discharge_limits_w(state.charge, &state.limits);
        let least = -battery.charge_limits_w(state.charge, &state.limits);
        let beyond = drawn.simd_gt(most) | drawn.simd_lt(least);
        if beyond.any_true() {
            return self.limited_torques(state, beyond.to_bitmask(), speed.into(), torque);
        }
        torque
    }

    /// Draws a step of the shaft from the battery, and books `auxiliary` as the power of the
    /// auxiliaries, in W, of which another source may feed a part. Returns the torque and the power
    /// at the battery's terminals.
    #[inline(always)]
    pub(in crate::powertrain) fn draw<S: Simd>(
        &self,
        state: &mut BatteryState<S>,
        shaft: &ShaftStep<S>,
        auxiliary: Lanes<S>,
        ledger: &mut StepLedger<S>,
    ) -> [Lanes<S>; 2] {
        let (battery, dt, torque) = (&self.model.battery, shaft.dt, shaft.gearbox_torque);
        let loss = self.motor.losses_w(shaft.speed, torque);
        let motor = shaft.speed * torque + loss;
        let terminals = motor + state.auxiliary_power;
        let charge = state.charge;
        let (store, heat) = battery.flows(charge, terminals, &state.limits);
        let back = masked(torque.simd_lt(0.0), (-motor).at_least(0.0));
        ledger.add(Term::Crankshaft, torque * shaft.angle);
        ledger.add(Term::Battery, store * dt);
        ledger.add(Term::BatteryLoss, heat * dt);
        ledger.add(Term::MotorLoss, loss * dt);
        ledger.add(Term::Auxiliary, auxiliary * dt);
        ledger.add(Term::Regenerated, back * dt);
        state.charge -= store * dt * (1.0 / battery.capacity_j);
        let covered = self.model.motor.maps_cover(shaft.speed, torque)
            & !battery.overdrawn(charge, terminals, &state.limits);
        ledger.add(Term::OutsideMap, masked(!covered, (store * dt).at_least(0.0)));
        [torque, terminals]
    }

    /// Stands for some time, in s, while a power is drawn beside that of the auxiliaries, in W;
    /// returns for how long there was energy for both.
    fn stand_drawing<S: Simd>(
        &self,
        state: &mut BatteryState<S>,
        lane: usize,
        time_s: f64,
        power_w: f64,
        ledger: &mut Ledger<f64>,
    ) -> f64 {
        let taken_w = self.auxiliary_at_rest_w(state, lane) + power_w;
        let carried_w = state.plug_power[lane].min(taken_w);
        state.carried[lane] += carried_w * time_s;
        let (charge, drawn_w) = (state.charge[lane], taken_w - carried_w);
        let battery = &*self.battery_of(state, lane);
        let flow = battery.flow(charge, drawn_w);
        let drawn_s = battery.lasts_s(charge, flow.store_w, time_s);
        ledger[Term::Battery] += flow.store_w * drawn_s;
        ledger[Term::BatteryLoss] += flow.loss_w * drawn_s;
        ledger[Term::Auxiliary] += drawn_w * drawn_s;
        if battery.is_overdrawn(charge, drawn_w) {
            ledger[Term::OutsideMap] += (flow.store_w * drawn_s).max(0.0);
        }
        let empties = drawn_s < time_s;
        let after = charge - flow.store_w * drawn_s / battery.capacity_j;
        state.charge[lane] = if empties { charge.min(battery.minimum_charge) } else { after };
        self.stand_temperature(state, lane, [time_s, flow.loss_w * drawn_s]);
        drawn_s
    }

    #[cold]
    #[inline(never)]
    fn limited_torques<S: Simd>(
        &self,
        state: &BatteryState<S>,
        lanes: u64,
        speed: [f64; WIDTH],
        mut torque: Lanes<S>,
    ) -> Lanes<S> {
        let (battery, auxiliary) = (&self.model.battery, state.auxiliary_power);
        let most = battery.discharge_limits_w(state.charge, &state.limits) - auxiliary;
        let least = -battery.charge_limits_w(state.charge, &state.limits) - auxiliary;
        for lane in (0..WIDTH).filter(|lane| lanes >> lane & 1 != 0) {
            torque[lane] = self.motor.within_nm(speed[lane], torque[lane], least[lane], most[lane]);
        }
        torque
    }

    /// Fills in the columns of the battery that are no terms of the ledger.
    pub(super) fn record_battery(
        charge: f64,
        ledger: &Ledger<f64>,
        mode: Mode,
        record: &mut Record,
    ) {
        let drawn_j = ledger[Term::Battery];
        record.take(Carrier::Electricity, drawn_j, drawn_j, mode);
        record.final_charge = Some(charge);
        if record.outcome == Outcome::Completed {
            let consumption = record.consumption(Carrier::Electricity);
            record.drove_whole_trip(record.distance_m, consumption);
        }
    }
}

/// Charges a battery with what a charger has left beside the power of auxiliaries, in W.
pub(super) fn charged_beside(
    battery: &BatteryModel,
    plug: &Plug,
    auxiliary_w: f64,
    charge: f64,
    course: &mut ChargeCourse,
) -> Charge {
    let left = Plug { power_w: plug.power_w - auxiliary_w, ..*plug };
    let mut charged = battery.charged_by(&left, charge, course);
    charged.carried_j = auxiliary_w * charged.time_s;
    course.raise(auxiliary_w);
    charged
}

impl Powertrain for BatteryElectricPowertrain {
    type State<S: Simd> = BatteryState<S>;
    type Stage<S: Simd> = ();
    type Predicted<S: Simd> = ();

    const SOURCES: &'static [Term] = &[Term::Battery];
    const STORES: &'static [Term] = &[Term::Battery];
    const TERMS: &'static [Term] = &[
        Term::Battery,
        Term::BatteryLoss,
        Term::MotorLoss,
        Term::Regenerated,
        Term::Charged,
        Term::ChargingLoss,
    ];
    const SIGNALS: SignalNames = SignalNames {
        speed: "motor_speed_radps",
        torque: "motor_torque_nm",
        source_rate: "battery_power_w",
        state: "state_of_charge",
    };

    fn carriers(&self) -> &'static [Carrier] {
        Carrier::Electricity.alone()
    }

    fn constants(&self) -> PowertrainConstants {
        PowertrainConstants {
            inertia_kgm2: self.model.motor.inertia_kgm2,
            idle_radps: 0.0,
            peak_torque_nm: self.model.motor.torque_nm,
            torque_lag_s: None,
        }
    }

    fn full_load_nm(&self, speed_radps: f64) -> f64 {
        self.model.motor.drive_limit_nm(speed_radps)
    }

    fn climate_w(&self, air_temperature_k: f64) -> f64 {
        let climate = self.model.climate.as_ref();
        climate.map_or(0.0, |climate| climate.power_w(air_temperature_k))
    }

    fn parked<S: Simd>(&self, simd: S) -> BatteryState<S> {
        BatteryState {
            charge: Lanes::splat(simd, f64::INFINITY),
            auxiliary_power: Lanes::splat(simd, 0.0),
            plug_power: Lanes::splat(simd, 0.0),
            carried: Lanes::splat(simd, 0.0),
            limits: BatteryLimits::of(simd, &self.model.battery),
            temperatures: Temperatures::none(simd),
        }
    }

    fn park<S: Simd>(&self, state: &mut BatteryState<S>, lane: usize) {
        state.charge[lane] = f64::INFINITY;
    }

    fn enter<S: Simd>(
        &self,
        state: &mut BatteryState<S>,
        lane: usize,
        truck: &TruckInputs,
        air_temperature_k: f64,
    ) {
        state.auxiliary_power[lane] = truck.auxiliary_power_w;
        state.charge[lane] = truck.initial_charge.unwrap_or(0.0);
        self.unplug(state, lane);
        self.enter_temperature(state, lane, air_temperature_k);
    }

    fn stand<S: Simd>(
        &self,
        state: &mut BatteryState<S>,
        lane: usize,
        time_s: f64,
        ledger: &mut Ledger<f64>,
    ) {
        self.stand_drawing(state, lane, time_s, 0.0, ledger);
    }

    /// The body draws from the battery, as the auxiliaries do.
    fn stand_working<S: Simd>(
        &self,
        state: &mut BatteryState<S>,
        lane: usize,
        time_s: f64,
        power_w: f64,
        ledger: &mut Ledger<f64>,
    ) -> f64 {
        power_w * self.stand_drawing(state, lane, time_s, power_w, ledger)
    }

    #[inline(always)]
    fn couple<S: Simd>(
        &self,
        _state: &mut BatteryState<S>,
        gear: &GearLanes<S>,
        speed: Lanes<S>,
        shifting: Flags<S>,
        _opens: Flags<S>,
        _accelerator: Lanes<S>,
    ) -> Coupling<S> {
        let simd = speed.simd;
        Coupling {
            closed: Flags::splat(simd, true),
            engaged: !shifting,
            free_speed: Lanes::splat(simd, 0.0),
            start_speed: speed * gear.speed_ratio,
        }
    }

    /// Motors and brakes share what the brake pedal asks for: a released accelerator does nothing.
    #[inline(always)]
    fn pedal_forces<S: Simd>(
        &self,
        _state: &BatteryState<S>,
        gear: &GearLanes<S>,
        speed: Lanes<S>,
    ) -> PedalForces<S> {
        let torque = self.model.motor.drive_limits_nm(speed * gear.speed_ratio);
        let [pressed, _] = self.model.wheel_and_lost_forces_n(gear.speed_ratio, torque);
        let nothing = Lanes::splat(speed.simd, 0.0);
        let per_force = 1.0 / pressed.at_least(PedalForces::<S>::LEAST_SPAN_N);
        PedalForces { coasting: nothing, released: nothing, per_force }
    }

    #[inline(always)]
    fn tractive_effort<S: Simd>(
        &self,
        state: &BatteryState<S>,
        gear: &GearLanes<S>,
        coupling: &Coupling<S>,
        demand: &Demand<S>,
        _predicted: Option<&()>,
    ) -> TractiveEffort<S, ()> {
        let model = &self.model;
        let motor = &model.motor;
        let speed = demand.shaft_speed;
        let traction = demand.traction * gear.torque_per_n;
        let driving = (demand.accelerator * motor.drive_limits_nm(speed)).at_most(traction);
        let braking = model
            .braking_torques_nm(gear.speed_ratio, demand.brake)
            .at_most(motor.brake_limits_nm(speed, demand.speed));
        let wanted = masked(coupling.engaged, driving - braking);
        let torque = self.within_battery(state, speed, wanted);
        let [wheel, lost] = model.wheel_and_lost_forces_n(gear.speed_ratio, torque);
        TractiveEffort {
            gearbox_torque: torque,
            wheel,
            lost,
            // the service brakes do what the motor does not
            brake: (demand.brake + wheel.at_most(0.0)).at_least(0.0),
            engine_brake: Lanes::splat(speed.simd, 0.0),
            wind_tangent: demand.cross / demand.air,
            own: (),
        }
    }

    #[inline(always)]
    fn predict<S: Simd>(&self, _state: &BatteryState<S>, _lag: FirstOrderLag<S>, _first: &()) {}

    #[inline(always)]
    fn consume<S: Simd>(
        &self,
        state: &mut BatteryState<S>,
        shaft: &ShaftStep<S>,
        _first: &(),
        _second: &(),
        ledger: &mut StepLedger<S>,
    ) -> [Lanes<S>; 2] {
        let auxiliary = state.auxiliary_power;
        self.draw(state, shaft, auxiliary, ledger)
    }

    /// A deeper battery at the same mass, driven on below its lowest charge.
    fn never_emptying(&self) -> Option<Self> {
        let mut deep = self.clone();
        deep.model.battery.capacity_j *= NEVER_EMPTYING_DEPTH;
        deep.model.battery.minimum_charge = f64::NEG_INFINITY;
        Some(deep)
    }

    fn store(&self) -> Option<Store> {
        let BatteryModel { capacity_j, minimum_charge, .. } = self.model.battery;
        Some(Store { capacity_j, lowest_charge: minimum_charge })
    }

    fn charged_by(&self, plug: &Plug, charge: f64, course: &mut ChargeCourse) -> Option<Charge> {
        Some(self.model.battery.charged_by(plug, charge, course))
    }

    fn charge_of<S: Simd>(&self, state: &BatteryState<S>, lane: usize) -> Option<f64> {
        Some(state.charge[lane])
    }

    fn rise(&self, gained_j: f64) -> f64 {
        gained_j / self.model.battery.capacity_j
    }

    fn charge<S: Simd>(
        &self,
        state: &mut BatteryState<S>,
        lane: usize,
        plug: &Plug,
        course: &mut ChargeCourse,
    ) -> Charge {
        let charge = if self.model.battery.thermal.is_some() {
            self.charge_by_temperature(state, lane, plug, course)
        } else {
            let auxiliary_w = state.auxiliary_power[lane];
            let battery = &self.model.battery;
            charged_beside(battery, plug, auxiliary_w, state.charge[lane], course)
        };
        state.charge[lane] += self.rise(charge.gained_j);
        // a truck that gains nothing is not plugged in
        state.plug_power[lane] = if charge.gained_j > 0.0 { plug.power_w } else { 0.0 };
        charge
    }

    fn unplug<S: Simd>(&self, state: &mut BatteryState<S>, lane: usize) -> f64 {
        state.plug_power[lane] = 0.0;
        std::mem::take(&mut state.carried[lane])
    }

    fn preconditions_from_m(&self) -> f64 {
        let thermal = self.model.battery.thermal.as_ref();
        let ahead = thermal.and_then(|thermal| thermal.precondition.as_ref());
        ahead.map_or(0.0, |ahead| ahead.ahead_m)
    }

    fn look_at_temperature<S: Simd>(
        &self,
        state: &mut BatteryState<S>,
        lane: usize,
        ledger: &Ledger<f64>,
        preconditions: bool,
    ) {
        self.pass_temperature(state, lane, ledger);
        self.condition(state, lane, preconditions);
    }

    #[inline(always)]
    fn depleted<S: Simd>(&self, state: &BatteryState<S>) -> Flags<S> {
        !state.charge.simd_gt(self.model.battery.minimum_charge)
    }

    fn state_signal<S: Simd>(&self, state: &BatteryState<S>, lane: usize, _closed: bool) -> f64 {
        state.charge[lane]
    }

    fn standing_signals(&self, added: &Ledger<f64>, time_s: f64, _speed_radps: f64) -> [f64; 2] {
        [0.0, if time_s > 0.0 { added[Term::Auxiliary] / time_s } else { 0.0 }]
    }

    fn record<S: Simd>(
        &self,
        state: &BatteryState<S>,
        lane: usize,
        ledger: &Ledger<f64>,
        record: &mut Record,
    ) {
        Self::record_battery(state.charge[lane], ledger, Mode::Driven, record);
        self.record_temperature(state, lane, ledger, record);
    }

    fn inverse<'a>(&'a self, truck: &TruckInputs) -> Box<dyn InversePowertrain + 'a> {
        Box::new(InverseBatteryElectric::new(self, truck))
    }
}
