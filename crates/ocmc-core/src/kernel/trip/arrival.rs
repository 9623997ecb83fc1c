//! The arrival of a trip: the road goes back to its task, and the totals become a record.

use super::lane_task::{LaneTask, Progress};
use crate::charging::ChargeCourse;
use crate::energy::ledger::{Mode, Term};
use crate::kernel::step::state::Lane;
use crate::powertrain::{Plug, Powertrain};
use crate::record::{Outcome, Record};
use crate::study::Study;
use fearless_simd::Simd;
use std::mem::swap;

impl LaneTask {
    /// Takes the road back from a lane whose cycle has ended, as it was before.
    pub(crate) fn leave<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>) {
        // a row between two lines was taken off twice: what it was at first comes last
        for (at, row) in self.served.drain(..).rev() {
            lane.state.motion.roads[lane.number][at] = row;
        }
        swap(&mut lane.state.motion.roads[lane.number], &mut self.road.rows);
    }

    /// The mean payload along the way so far.
    fn mean_payload_kg(&self, way_m: f64) -> f64 {
        let Progress { payload_kg, carried_kgm, carried_to_m, .. } = self.progress;
        match payload_kg {
            Some(payload_kg) if way_m > 0.0 => {
                (carried_kgm + payload_kg * (way_m - carried_to_m)) / way_m
            }
            _ => self.scenario.cycle.mission.payload_kg,
        }
    }

    /// The record of the cycle as it stands.
    pub(crate) fn record<S: Simd, P: Powertrain>(
        &self,
        study: &Study,
        lane: &Lane<S, P>,
        outcome: Outcome,
    ) -> Record {
        let ledger = lane.state.ledger.lane(lane.number);
        let (cycle, driver, vehicle) =
            (&self.scenario.cycle, &self.scenario.driver, &self.scenario.vehicle);
        let road = &cycle.road;
        let share = |name: &str| {
            let wanted = study.road_types().iter().position(|n| n == name)?;
            let sections = road.sections.iter().filter(|s| s.road_type == wanted);
            // not `sum`: that of nothing is -0
            let length_m = sections.fold(0.0, |sum, s| sum + (s.end_m - s.start_m));
            Some(length_m / road.length_m)
        };
        let mut limit_sum = 0.0;
        for (k, sign) in road.signs.iter().enumerate() {
            let end_m = road.signs.get(k + 1).map_or(road.length_m, |next| next.start_m);
            limit_sum += sign.speed_mps * (end_m - sign.start_m);
        }
        let is_pid = driver.pedals.threshold_mps.is_none();
        let known = Record {
            cycle_id: self.scenario.cycle_id,
            outcome,
            truck_id: self.scenario.trip.truck_id,
            driver_id: Some(self.scenario.trip.driver_id),
            trip: self.scenario.trip.trip,
            route_id: cycle.road.route.map(|route| route.get() - 1),
            duration_s: ledger[Term::Time] + self.progress.standstill_s,
            standstill_s: self.progress.standstill_s,
            n_stops: self.progress.n_stops,
            n_gear_shifts: self.progress.n_gear_shifts,
            climb_m: self.road.climb_m,
            payload_kg: cycle.mission.payload_kg,
            mean_payload_kg: self.mean_payload_kg(ledger[Term::Distance]),
            power_take_off_energy_j: Some(self.progress.power_take_off_j),
            payload_cut_kg: self.scenario.payload_cut_kg,
            air_temperature_k: self.road.air_temperature_k,
            head_wind_mps: self.road.head_wind_mps,
            driver_curve_speed_mps: Some(driver.curve_speed.reference_speed_mps),
            driver_curve_exponent: Some(driver.curve_speed.exponent),
            driver_effect: Some(driver.curve_speed.driver_effect),
            driver_deceleration_mps2: Some(driver.speed_change.deceleration_mps2),
            driver_acceleration_mps2: Some(driver.speed_change.acceleration_mps2),
            driver_compliance: Some(driver.speed_limit.compliance),
            driver_kp: Some(driver.pedals.proportional),
            driver_ki: is_pid.then_some(driver.pedals.integral),
            driver_kd: is_pid.then_some(driver.pedals.derivative),
            driver_switch_threshold_mps: driver.pedals.threshold_mps,
            driver_gain_redraws: Some(driver.pedals.redraws),
            kinetic_change_j: lane.kinetic_energy_j() - self.initial_energy_j,
            departure_s_of_year: cycle.mission.day_of_year * 86_400.0 + cycle.mission.departure_s,
            urban_share: share("urban"),
            rural_share: share("rural"),
            motorway_share: share("motorway"),
            mean_limit_mps: Some(limit_sum / road.length_m),
            n_curves: Some(road.curves.len() as u32),
            drag_area_m2: vehicle.drag_area_m2,
            rolling_coefficient: vehicle.rolling_coefficient,
            departure_charge: vehicle.initial_charge,
            rest_s: self.rests.as_ref().map(|rests| rests.added_s),
            n_rests: self.rests.as_ref().map(|rests| rests.taken),
            breakdown: self.parts.breakdown(study, lane, self.progress.standstill_s),
            ..Record::default()
        };
        let mut record = Record::from_ledger(known, &ledger, Mode::Driven, P::TERMS);
        lane.parameters.powertrain.record(
            &lane.state.powertrain,
            lane.number,
            &ledger,
            &mut record,
        );
        record.take_all(Mode::Driven);
        if let (Some(stops), Some(policy)) = (&self.charging, lane.parameters.charging) {
            let powertrain = lane.parameters.powertrain;
            let charged_by = |plug: &Plug, charge, course: &mut ChargeCourse| {
                let charge = powertrain.charged_by(plug, charge, course)?;
                Some((charge, powertrain.rise(charge.gained_j)))
            };
            stops.fill(policy, &self.scenario, charged_by, &mut record);
        }
        if let (Some(rests), Some(_)) = (&self.rests, &self.scenario.handover) {
            record.clock_at_end = Some(rests.clock_at_end(ledger[Term::Time]));
        }
        study.emission_factors().fill(&mut record);
        record
    }
}
