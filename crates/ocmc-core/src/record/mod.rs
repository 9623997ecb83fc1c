//! The record: the scalars of one driven cycle, and the columns in which they are written.

mod column;

pub use column::{COLUMNS, Cell, Column, column, own_columns};

use crate::breakdown::{Amount, Breakdown};
use crate::charging::ChargingEvent;
use crate::energy::carrier::{CARRIERS, Carrier, Declaration};
use crate::energy::ledger::{Ledger, Mode, Recorded, TERMS, Term};
use crate::rest::DutyClock;
use column::{OF_CARRIER, OF_CARRIERS, OWN_COLUMNS};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a cycle ended.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Driven to its end.
    #[default]
    Completed,
    /// No progress outside a dwell.
    Stalled,
    /// Driven for longer than the study allows.
    TimedOut,
    /// The battery ran empty.
    Depleted,
}

impl Outcome {
    /// Whether what was driven counts: to the end, or until the battery was empty.
    pub fn counts(self) -> bool {
        matches!(self, Self::Completed | Self::Depleted)
    }

    /// All outcomes, the good one first.
    pub const ALL: [Self; 4] = [Self::Completed, Self::Stalled, Self::TimedOut, Self::Depleted];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Completed => "completed",
            Self::Stalled => "stalled",
            Self::TimedOut => "timed_out",
            Self::Depleted => "depleted",
        }
    }
}

/// Scalars of one cycle. A quantity that does not exist is `None`, never 0, and null in files. The
/// text on a field is what the reference says of its column.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Record {
    /// Id of the cycle in the run.
    pub cycle_id: u64,
    /// How the cycle ended.
    pub outcome: Outcome,
    /// Distance driven, in m; a truck stops up to half a metre short of the road's end.
    pub distance_m: f64,
    /// Driving and standstill, in s.
    pub duration_s: f64,
    /// Dwell at stops, in s: stop signs, red lights, give ways, stops of the mission.
    pub standstill_s: f64,
    /// Time that was integrated, in s: dwell is not.
    pub simulated_s: f64,
    /// Distance over duration, in m/s.
    pub mean_speed_mps: f64,
    /// Stops with a dwell; the final one is not counted. Of a drive cycle that a driver follows,
    /// rests at its start and its end count.
    pub n_stops: u32,
    /// Gear shifts; the choice of a starting gear is none.
    pub n_gear_shifts: u32,
    /// Positive work at the hubs of the driven wheels, in J: the wheel force without what speeds up
    /// the engine or the motor, where it is positive, over distance. Not part of the balance.
    pub wheel_energy_j: f64,
    /// Service and engine brake together, in J; of a battery-electric vehicle the service brakes.
    pub brake_energy_j: f64,
    /// Energy that braking by the motor brought back to the battery's terminals, in J; null for a
    /// diesel truck.
    pub regenerated_energy_j: Option<f64>,
    /// Work of the auxiliaries, in J, standstill included.
    pub auxiliary_energy_j: f64,
    /// Positive work at the hubs of the driven wheels over distance, in kWh/km.
    pub wheel_kwh_per_km: f64,
    /// Carbon dioxide from burning the fuel over distance, in g/km.
    pub co2_g_per_km: Option<f64>,
    /// Sum of the climbs of the road, in m.
    pub climb_m: f64,
    /// Payload at departure, in kg.
    pub payload_kg: f64,
    /// Mean air temperature along the road, in K.
    pub air_temperature_k: f64,
    /// Mean headwind beside the truck along the road, in m/s, exposure included; negative from
    /// behind.
    pub head_wind_mps: f64,
    /// Speed in a curve of the reference radius, in m/s, driver effect included.
    pub driver_curve_speed_mps: Option<f64>,
    /// Exponent δ.
    pub driver_curve_exponent: Option<f64>,
    /// Driver effect α: ln of this driver's reference speed over the study's.
    pub driver_effect: Option<f64>,
    /// Deceleration for changes of the desired speed, in m/s².
    pub driver_deceleration_mps2: Option<f64>,
    /// Acceleration for changes of the desired speed, in m/s².
    pub driver_acceleration_mps2: Option<f64>,
    /// Factor on limits.
    pub driver_compliance: Option<f64>,
    /// Proportional gain K_P, in s/m.
    pub driver_kp: Option<f64>,
    /// Integral gain K_I, in 1/m; null for a switched driver.
    pub driver_ki: Option<f64>,
    /// Derivative gain K_D, in s²/m; null for a switched driver.
    pub driver_kd: Option<f64>,
    /// Threshold of a switched driver, in m/s; null for a PID.
    pub driver_switch_threshold_mps: Option<f64>,
    /// Gains drawn again because they were out of bounds.
    pub driver_gain_redraws: Option<u32>,
    /// Fuel times lower heating value, in J.
    pub fuel_energy_j: Option<f64>,
    /// Fuel energy less crankshaft work, in J.
    pub engine_loss_j: Option<f64>,
    /// Work of the engine at the crankshaft, in J; negative torque in overrun counts negative.
    pub crankshaft_work_j: Option<f64>,
    /// Loss of gearbox, retarder at rest and axle, in J.
    pub transmission_loss_j: f64,
    /// Kinetic energy of the engine lost where its speed jumps (shifts, clutch), in J, signed.
    pub shift_loss_j: Option<f64>,
    /// Loss of the slipping clutch, in J.
    pub clutch_loss_j: Option<f64>,
    /// Work against the air, in J; wind from behind can make it negative.
    pub drag_energy_j: f64,
    /// Work against rolling resistance, in J.
    pub rolling_energy_j: f64,
    /// Work of the service brakes, in J, the capture at a stop line included.
    pub service_brake_energy_j: f64,
    /// Work of the engine brake beyond the engine's drag torque, in J.
    pub engine_brake_energy_j: Option<f64>,
    /// Kinetic energy at the end less at the start, in J, rotating parts included.
    pub kinetic_change_j: f64,
    /// Potential energy at the end less at the start, in J.
    pub potential_change_j: f64,
    /// Duration less standstill, in s.
    pub moving_s: f64,
    /// Departure, in s from the start of the year.
    pub departure_s_of_year: f64,
    /// Share of roads of the type `urban` by length; null where a study has no type of that name,
    /// and where a speed is followed exactly.
    pub urban_share: Option<f64>,
    /// Share of roads of the type `rural` by length, as `urban_share`.
    pub rural_share: Option<f64>,
    /// Share of roads of the type `motorway` by length, as `urban_share`.
    pub motorway_share: Option<f64>,
    /// Mean of the signs along the road by length, in m/s; null where a speed is followed exactly.
    pub mean_limit_mps: Option<f64>,
    /// Curves on the road, junction turns included; null where a speed is followed exactly.
    pub n_curves: Option<u32>,
    /// CdA of this truck without cross wind, in m².
    pub drag_area_m2: f64,
    /// Rolling coefficient of this loaded truck on smooth, dry asphalt at 25 °C.
    pub rolling_coefficient: f64,
    /// Heat in the battery, in J; null for a diesel truck.
    pub battery_loss_j: Option<f64>,
    /// Losses of motor and inverter, in J; null for a diesel truck.
    pub motor_loss_j: Option<f64>,
    /// Energy that charging put into the store, in J, at stops, and in the depot where a study has
    /// one; null for a diesel truck.
    pub charged_energy_j: Option<f64>,
    /// Heat in the battery while it was charged, in J, not part of the balance; null for a
    /// diesel truck.
    pub charging_loss_j: Option<f64>,
    /// State of charge at the end; null for a diesel truck.
    pub final_charge: Option<f64>,
    /// Time at which a speed that is followed exactly asked for more than the powertrain can give,
    /// in s; null where somebody drives.
    pub limited_s: Option<f64>,
    /// Work at the wheels that was missing then, in J: a source in the energy balance; null where
    /// somebody drives.
    pub missing_energy_j: Option<f64>,
    /// Energy that the store gave beyond the points of the map of engine or motor, in J, where a
    /// motor's map is held and an engine's goes on with its last slope. With it counts what was
    /// drawn beyond what the battery has at any current. To a step where an edge is crossed.
    pub outside_map_energy_j: Option<f64>,
    /// Its truck; where each trip has a truck of its own, the id of the cycle.
    pub truck_id: u64,
    /// Its driver: one of the truck's, or of the pool; null where a speed is followed exactly.
    pub driver_id: Option<u64>,
    /// Number of the trip among those of its truck, from 0.
    pub trip: u64,
    /// Distance of the whole trip, in m. Where the battery emptied on the way, it is of the same
    /// trip driven again with a battery that never empties. Null for a diesel truck, and where the
    /// trip was not driven to its end then, either.
    pub whole_trip_m: Option<f64>,
    /// Energy that left the battery's store over the whole trip, over its distance, in kWh/km.
    pub whole_trip_kwh_per_km: Option<f64>,
    /// Standstill that the law on rests added, in s; null where a study has no such law.
    pub rest_s: Option<f64>,
    /// Rests that this law asked for; null as `rest_s`.
    pub n_rests: Option<u32>,
    /// Part of the drawn payload that the legal gross mass took off, in kg.
    pub payload_cut_kg: f64,
    /// Energy that depots, `charging.depot`, put into the store after the trip, in J, a part of
    /// `charged_energy_j`; null where a study has none.
    pub charged_energy_depot_j: Option<f64>,
    /// Energy that public chargers put into it on the way, in J; null where a study has no
    /// `[charging]`, and for a diesel truck.
    pub charged_energy_public_j: Option<f64>,
    /// Energy that chargers at stops of the mission put into it, in J; null as
    /// `charged_energy_public_j`.
    pub charged_energy_stop_j: Option<f64>,
    /// Energy that a depot's meter counts for it, in J, the losses of charger and battery included;
    /// null as `charged_energy_depot_j`.
    pub grid_energy_depot_j: Option<f64>,
    /// Energy that the meters of public chargers count, in J, likewise; null as
    /// `charged_energy_public_j`.
    pub grid_energy_public_j: Option<f64>,
    /// Energy that the meters of chargers at stops of the mission count, in J, likewise; null as
    /// `charged_energy_public_j`.
    pub grid_energy_stop_j: Option<f64>,
    /// Stops on the way at which the battery was charged; null as `charged_energy_public_j`.
    pub n_charging_stops: Option<u32>,
    /// Time for which it was charged on the way, in s; null as `charged_energy_public_j`.
    pub charging_s: Option<f64>,
    /// Time that the truck waited for free chargers, in s; null as `charged_energy_public_j`.
    pub charging_wait_s: Option<f64>,
    /// Time for which it was charged in the depot after the trip, in s; null as
    /// `charged_energy_depot_j`.
    pub depot_charging_s: Option<f64>,
    /// State of charge at departure; null for a diesel truck.
    pub departure_charge: Option<f64>,
    /// Greenhouse gases from generating the electricity that the meters of chargers count, over
    /// distance, in g/km of CO2 equivalents; null for a diesel truck, for a cycle that stalled or
    /// timed out, and where a study has no factor.
    pub grid_co2_g_per_km: Option<f64>,
    /// Greenhouse gases from the well to the wheel over distance, in g/km of CO2 equivalents; null
    /// for a cycle that stalled or timed out, and where a study has no factor.
    pub well_to_wheel_g_per_km: Option<f64>,
    /// Greenhouse gases from the well to the wheel over distance and tonne of payload, in g/tkm of
    /// CO2 equivalents; null for an empty truck, else as `well_to_wheel_g_per_km`.
    pub well_to_wheel_g_per_tkm: Option<f64>,
    /// Energy of the auxiliaries that heated and cooled the battery, in J; null where its
    /// temperature is not looked at.
    pub battery_conditioning_energy_j: Option<f64>,
    /// Temperature of the battery at the end, in K.
    pub final_battery_temperature_k: Option<f64>,
    /// Lowest state of charge with which the truck came to a charger on the way or to the end of
    /// its trip; null as `charged_energy_public_j`.
    pub lowest_charge: Option<f64>,
    /// Mean payload along the driven way, in kg: that at departure where no stop changes it.
    pub mean_payload_kg: f64,
    /// Work that the truck's body took at stops of the mission, in J, a part of
    /// `auxiliary_energy_j`; null where a speed is followed exactly.
    pub power_take_off_energy_j: Option<f64>,
    /// Energy that the chargers on the way gave the auxiliaries while the truck was plugged in, in
    /// J: no part of `auxiliary_energy_j`; null as `charged_energy_public_j`.
    pub charger_auxiliary_energy_j: Option<f64>,
    /// Its route, from 0 in the order in which a study or a command names them; null where the road
    /// is drawn.
    pub route_id: Option<u32>,
    /// Columns that are declared elsewhere: those of the carriers, then the terms of the ledger
    /// that have a column of their own.
    #[serde(skip)]
    pub own_columns: [Option<f64>; OWN_COLUMNS],
    /// Amounts that road types and event kinds took, in columns that the study names.
    #[serde(skip)]
    pub breakdown: Breakdown,
    /// Each charging of a trip, in order; none where a study has no `[charging]`, and for a diesel
    /// truck.
    #[serde(skip)]
    pub charging_events: Option<Vec<ChargingEvent>>,
    /// The driver's clock at the end, on its way to the next trip of a chain alone.
    #[serde(skip)]
    pub clock_at_end: Option<DutyClock>,
}

/// Payload below which a truck counts as empty, in kg: litres over tonnes say nothing then. A
/// judgement: a load is weighed to a kilogram.
const LEAST_PAYLOAD_KG: f64 = 1.0;

impl Record {
    /// The record of a cycle from its ledger. `known`: what is known beside it, duration and
    /// standstill among it; `terms`: those that the powertrain names.
    pub fn from_ledger(known: Self, ledger: &Ledger<f64>, mode: Mode, terms: &[Term]) -> Self {
        let mut record = known;
        let mut column = OF_CARRIERS;
        for declared in TERMS {
            let value = ledger[declared.term];
            let is_in = declared.term.is_in(mode, terms);
            match declared.recorded {
                Recorded::Field if is_in => record.set(declared.term, value),
                Recorded::Field | Recorded::ByPowertrain => {}
                Recorded::Column { .. } => {
                    record.own_columns[column] = is_in.then_some(value);
                    column += 1;
                }
            }
        }
        let (distance_m, duration_s) = (record.distance_m, record.duration_s);
        record.mean_speed_mps = if duration_s > 0.0 { distance_m / duration_s } else { 0.0 };
        record.moving_s = duration_s - record.standstill_s;
        record.brake_energy_j = ledger[Term::ServiceBrake] + ledger[Term::EngineBrake];
        // a column without null
        let wheel_per_m = record.per_distance(record.wheel_energy_j, mode).unwrap_or(0.0);
        record.wheel_kwh_per_km = wheel_per_m / 3600.0;
        record
    }

    /// Amount of the whole cycle, of those that are broken down.
    pub fn whole(&self, amount: Amount) -> Option<f64> {
        match amount {
            Amount::Distance => Some(self.distance_m),
            Amount::Duration => Some(self.duration_s),
            Amount::Wheel => Some(self.wheel_energy_j),
            Amount::Taken(carrier) => self.amount(carrier),
        }
    }

    /// Amount of a carrier that the cycle took, in its unit; none where its truck does not store
    /// it.
    pub fn amount(&self, carrier: Carrier) -> Option<f64> {
        self.of_carrier(carrier)[0]
    }

    /// Amount over distance.
    pub fn consumption(&self, carrier: Carrier) -> Option<f64> {
        self.of_carrier(carrier)[1]
    }

    /// Amount over distance and tonne of payload; none for an empty truck.
    pub fn consumption_per_tonne(&self, carrier: Carrier) -> Option<f64> {
        self.of_carrier(carrier)[2]
    }

    /// Energy from all stores over distance, in kWh/km; none where the truck stores one carrier.
    pub fn all_kwh_per_km(&self) -> Option<f64> {
        self.own_columns[OF_CARRIERS - 1]
    }

    /// Energy from the stores over distance, in kWh/km: from all where the truck stores several
    /// carriers, else from the battery.
    pub fn drawn_kwh_per_km(&self) -> Option<f64> {
        self.all_kwh_per_km().or(self.consumption(Carrier::Electricity))
    }

    /// Energy that the truck's stores gave, in J, that of fuels by their heating value; none where
    /// nothing is known of them.
    pub fn stored_energy_j(&self) -> Option<f64> {
        let charge = self.amount(Carrier::Electricity);
        let fuel = self.fuel_energy_j;
        if charge.is_none() { fuel } else { Some(charge? + fuel.unwrap_or(0.0)) }
    }

    /// The carriers of which the cycle took something.
    pub fn carriers(&self) -> impl Iterator<Item = &'static Declaration> {
        CARRIERS.iter().filter(|declared| self.amount(declared.carrier).is_some())
    }

    /// Notes what the cycle took of a carrier: `amount` in the unit of its column, `sold` in the
    /// unit in which it is sold.
    pub fn take(&mut self, carrier: Carrier, amount: f64, sold: f64, mode: Mode) {
        let consumption = self.per_distance(sold, mode).map(carrier.declaration().per_m);
        let per_tonne = self.per_tonne(consumption);
        *self.of_carrier_mut(carrier) = [Some(amount), consumption, per_tonne];
    }

    /// The same record with amount, consumption and consumption by tonne of a carrier.
    #[must_use]
    pub fn with(mut self, carrier: Carrier, of_carrier: [Option<f64>; OF_CARRIER]) -> Self {
        *self.of_carrier_mut(carrier) = of_carrier;
        self
    }

    /// Notes what all stores gave together, where there are several.
    pub fn take_all(&mut self, mode: Mode) {
        let all_j = self.stored_energy_j().filter(|_| self.carriers().nth(1).is_some());
        let per_m = all_j.and_then(|all_j| self.per_distance(all_j, mode));
        self.own_columns[OF_CARRIERS - 1] = per_m.map(Carrier::Electricity.declaration().per_m);
    }

    /// Amount, consumption and consumption by tonne of a carrier.
    pub fn of_carrier(&self, carrier: Carrier) -> &[Option<f64>; OF_CARRIER] {
        let (columns, _) = self.own_columns.as_chunks();
        &columns[carrier as usize]
    }

    /// The same, to be written.
    pub fn of_carrier_mut(&mut self, carrier: Carrier) -> &mut [Option<f64>; OF_CARRIER] {
        let (columns, _) = self.own_columns.as_chunks_mut();
        &mut columns[carrier as usize]
    }

    /// Notes what the whole trip took: its distance, in m, and its electricity over distance.
    pub fn drove_whole_trip(&mut self, distance_m: f64, kwh_per_km: Option<f64>) {
        self.whole_trip_m = Some(distance_m);
        self.whole_trip_kwh_per_km = kwh_per_km;
    }

    /// An amount per metre. Where nothing moved it is none, in closed loop 0.
    pub fn per_distance(&self, amount: f64, mode: Mode) -> Option<f64> {
        let at_rest = match mode {
            Mode::Driven => Some(0.0),
            Mode::Followed => None,
        };
        if self.distance_m > 0.0 { Some(amount / self.distance_m) } else { at_rest }
    }

    /// A quantity over the tonnes of the mean payload; none for an empty truck.
    pub fn per_tonne(&self, value: Option<f64>) -> Option<f64> {
        let payload_kg = self.mean_payload_kg;
        value.filter(|_| payload_kg >= LEAST_PAYLOAD_KG).map(|value| value / (payload_kg / 1000.0))
    }

    /// Sets the field of a term.
    fn set(&mut self, term: Term, value: f64) {
        let optional = match term {
            Term::Time => return self.simulated_s = value,
            Term::Distance => return self.distance_m = value,
            Term::Auxiliary => return self.auxiliary_energy_j = value,
            Term::Transmission => return self.transmission_loss_j = value,
            Term::Drag => return self.drag_energy_j = value,
            Term::Rolling => return self.rolling_energy_j = value,
            Term::Grade => return self.potential_change_j = value,
            Term::ServiceBrake => return self.service_brake_energy_j = value,
            Term::Wheel => return self.wheel_energy_j = value,
            Term::Crankshaft => &mut self.crankshaft_work_j,
            Term::Clutch => &mut self.clutch_loss_j,
            Term::Shift => &mut self.shift_loss_j,
            Term::EngineBrake => &mut self.engine_brake_energy_j,
            Term::BatteryLoss => &mut self.battery_loss_j,
            Term::MotorLoss => &mut self.motor_loss_j,
            Term::Regenerated => &mut self.regenerated_energy_j,
            Term::Charged => &mut self.charged_energy_j,
            Term::ChargingLoss => &mut self.charging_loss_j,
            Term::OutsideMap => &mut self.outside_map_energy_j,
            Term::Limited => &mut self.limited_s,
            Term::Missing => &mut self.missing_energy_j,
            // the powertrain writes it, or it has a column of its own
            _ => return,
        };
        *optional = Some(value);
    }
}
