//! Events of one lane, handled outside of the hot loop: shifts, stops and checks of progress.

use super::lane_task::LaneTask;
use super::rest_stops::until_look_s;
use crate::energy::ledger::{Ledger, Term};
use crate::kernel::step::LaneEvent;
use crate::kernel::step::one_step::FAST_STEP;
use crate::kernel::step::road_row::RoadRow;
use crate::kernel::step::state::Lane;
use crate::lanes::UNBOUNDED;
use crate::powertrain::Powertrain;
use crate::powertrain::component::gearbox::ShiftInputs;
use crate::record::Outcome;
use crate::study::Load;
use fearless_simd::prelude::*;

/// Steps, as they are counted, for each whole step's time that cuts can make of it before a cycle
/// is given up.
const MOST_CUTS: f64 = 10.0;

impl LaneTask {
    /// Handles the event of a lane; returns the outcome where the cycle has ended.
    #[cold]
    pub(crate) fn handle_event<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        event: LaneEvent,
    ) -> Option<Outcome> {
        self.added_by_event = Ledger::EMPTY;
        let mark = self.marks.at(lane.state.motion.at[lane.number]);
        if let Some(mark) = mark.filter(|_| lane.is_at_end()) {
            self.marks.pass();
            if mark.decides {
                self.decide(lane, mark.end_m, lane.state.motion.at[lane.number] + 1);
            }
            if mark.looks {
                self.look_at_temperature(lane, mark.end_m);
            }
        }
        let ends_part = self.parts.pass(lane, self.progress.standstill_s);
        if !ends_part && mark.is_none() && lane.is_captured() {
            self.stop(lane);
            let ends = lane.stop_row() + 1 == lane.state.motion.roads[lane.number].len();
            if !ends {
                self.dwell(lane);
            }
            lane.state.ledger.add_to_lane(lane.number, &self.added_by_event);
            if ends {
                return Some(Outcome::Completed);
            }
            self.parts.pass(lane, self.progress.standstill_s);
        } else if event.wants_shift {
            self.shift(lane, event);
        }
        if lane.parameters.powertrain.depleted(&lane.state.powertrain).test(lane.number) {
            return Some(Outcome::Depleted);
        }
        if lane.state.motion.steps_left[lane.number] <= 0.0 { self.check(lane) } else { None }
    }

    /// The truck comes to rest: its kinetic energy goes into the service brakes, the engine returns
    /// to idle (shift loss).
    fn stop<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>) {
        let speed = lane.state.motion.speed[lane.number];
        let inertia = lane.parameters.engine_inertia_kgm2;
        let engine_speed = lane.state.motion.engine_speed[lane.number];
        let mut braked = lane.translational_j();
        let idle = lane.parameters.idle_radps;
        // a closed clutch brakes the engine with the wheels; it is restarted to idle
        let closed = engine_speed == speed * lane.state.gear.speed_ratio[lane.number];
        let left_over = if closed {
            braked += 0.5 * inertia * engine_speed * engine_speed;
            0.0
        } else {
            engine_speed
        };
        self.added_by_event[Term::ServiceBrake] += braked;
        self.added_by_event[Term::Shift] += 0.5 * inertia * (left_over * left_over - idle * idle);
        lane.state.motion.speed[lane.number] = 0.0;
        lane.state.motion.engine_speed[lane.number] = idle;
    }

    /// Stands for the drawn time with the engine idling, then prepares to start.
    fn dwell<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>) {
        let row = lane.stop_row();
        let planned_s = lane.state.motion.roads[lane.number][row].dwell_s().unwrap_or(0.0);
        let has_temperature = lane.parameters.has_temperature;
        if has_temperature {
            // the charger is here: nothing is prepared for it any more
            self.look_at_temperature(lane, f64::INFINITY);
        }
        let standing = self.standing(row);
        let load = standing.as_ref().and_then(|at| self.scenario.load_from(at.position_m)).copied();
        self.work(lane, load.as_ref(), planned_s);
        let (dwell_s, rests) = match &standing {
            Some(standing) => self.stand(lane, standing, planned_s),
            None => (planned_s, false),
        };
        let mut idles_s = (dwell_s - self.progress.stood_s).max(0.0);
        idles_s -= self.stay_plugged(lane, idles_s);
        let added = &mut self.added_by_event;
        let (powertrain, model) = (lane.parameters.powertrain, lane.parameters.look_ahead);
        let (own, number) = (&mut lane.state.powertrain, lane.number);
        let stops_engine = model.engine_stop || rests;
        let delay_s = if stops_engine { model.engine_stop_delay_s } else { f64::INFINITY };
        powertrain.stand(own, number, idles_s.min(delay_s), added);
        if idles_s > delay_s {
            let power_w = model.engine_stop_power_w;
            powertrain.stand_stopped(own, number, idles_s - delay_s, power_w, added);
        }
        self.progress.standstill_s += dwell_s;
        self.progress.n_stops += 1;
        self.leave_line(lane);
        if let Some(load) = load {
            self.take_load(lane, &load);
        }
        self.start(lane);
        self.progress.checked_at_s = lane.state.ledger[Term::Time][lane.number];
        self.progress.checked_at_m = lane.state.ledger[Term::Distance][lane.number];
        if let Some(standing) = &standing {
            self.decide(lane, standing.position_m, row + 1);
        }
    }

    /// The body of a truck works first, where it does, and no longer than the truck stands.
    fn work<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        load: Option<&Load>,
        planned_s: f64,
    ) {
        self.progress.stood_s = 0.0;
        let Some(part) = load.map(|load| load.part) else { return };
        if part.power_take_off_j() > 0.0 {
            let (works_s, power_w) = (part.power_take_off_s.min(planned_s), part.power_take_off_w);
            let (powertrain, own) = (lane.parameters.powertrain, &mut lane.state.powertrain);
            let added = &mut self.added_by_event;
            self.progress.power_take_off_j +=
                powertrain.stand_working(own, lane.number, works_s, power_w, added);
            self.progress.stood_s = works_s;
        }
    }

    /// The truck leaves a stop of its mission with another payload.
    fn take_load<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>, load: &Load) {
        let way_m = lane.state.ledger[Term::Distance][lane.number];
        let progress = &mut self.progress;
        let before_kg = progress.payload_kg.unwrap_or(self.scenario.cycle.mission.payload_kg);
        if load.part.payload_kg != before_kg {
            progress.carried_kgm += before_kg * (way_m - progress.carried_to_m);
            progress.carried_to_m = way_m;
            progress.payload_kg = Some(load.part.payload_kg);
            Self::carry(lane, &load.vehicle, &self.scenario.driver.speed_change);
        }
    }

    /// Takes a line that has been served off the road: up to it the driver accelerates.
    fn leave_line<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>) {
        let (here, line) = (lane.state.motion.at[lane.number], lane.stop_row());
        for (k, row) in lane.state.motion.roads[lane.number][here..=line].iter_mut().enumerate() {
            self.served.push((here + k, *row));
            row.0[RoadRow::BACKWARD] = UNBOUNDED;
            row.0[RoadRow::TO_STOP] = UNBOUNDED;
            row.set_coasting(0.0);
        }
        self.parts.unhide(line, &mut lane.state.motion.roads[lane.number]);
    }

    fn shift<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>, event: LaneEvent) {
        let (shift, motion) = (&lane.parameters.vehicle.shift, &lane.state.motion);
        let inputs = ShiftInputs {
            gear: self.progress.gear,
            speed_mps: motion.speed[lane.number],
            pedal: event.accelerator,
            slowing: event.slowing,
            kickdown: motion.kick_left[lane.number] <= 0.0,
            closed: event.closed,
            road_power_w: event.road_power_w,
            may_up: motion.up_left[lane.number] <= 0.0 && !event.brakes,
            may_down: motion.down_left[lane.number] <= 0.0,
            idle_radps: lane.parameters.idle_radps,
            mass_kg: lane.state.constants.moving_mass_open[lane.number],
            inertia_kgm2: lane.parameters.engine_inertia_kgm2,
        };
        let full_load_nm = |w| lane.parameters.powertrain.full_load_nm(w);
        let gear = shift.wanted_gear(&inputs, &lane.parameters.vehicle.gears, full_load_nm);
        if gear != self.progress.gear {
            let [up_s, down_s] = shift.intervals_s(gear > self.progress.gear);
            self.progress.gear = gear;
            self.progress.n_gear_shifts += 1;
            lane.state.set_gear(lane.number, gear, lane.parameters);
            lane.state.motion.shift_left[lane.number] = shift.duration_s;
            lane.state.motion.up_left[lane.number] = up_s;
            lane.state.motion.down_left[lane.number] = down_s;
            // torque comes back after the shift: only then a pressed pedal tells that it is not
            // enough
            lane.state.motion.kick_left[lane.number] = shift.duration_s + shift.kickdown_s;
            lane.state.motion.longest[lane.number] = lane.parameters.short_step_s;
        }
    }

    /// Checks whether the truck makes progress (stall) and whether its time is over.
    fn check<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>) -> Option<Outcome> {
        let simulation = lane.parameters.simulation;
        let ledger = &lane.state.ledger;
        let (time, way) = (ledger[Term::Time][lane.number], ledger[Term::Distance][lane.number]);
        self.progress.counted += self.progress.until_check;
        let most = MOST_CUTS * simulation.longest_duration_s / simulation.step_s;
        if time > simulation.longest_duration_s || self.progress.counted > most {
            return Some(Outcome::TimedOut);
        }
        let passed = time - self.progress.checked_at_s;
        self.schedule_check(lane);
        self.rest_on_the_spot(lane);
        // steps that were cut are shorter: wait until the whole time has passed
        if passed >= simulation.stall_time_s * (1.0 - 1e-9) {
            if way - self.progress.checked_at_m < simulation.stall_distance_m {
                return Some(Outcome::Stalled);
            }
            self.progress.checked_at_s = time;
            self.progress.checked_at_m = way;
        }
        None
    }

    /// The next check is due when a truck that makes no progress has been standing long enough, and
    /// no later than the longest duration.
    pub(super) fn schedule_check<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>) {
        let simulation = lane.parameters.simulation;
        let left_s =
            (simulation.longest_duration_s - lane.state.ledger[Term::Time][lane.number]).max(0.0);
        let steps = |time_s: f64| libm::ceil(time_s / simulation.step_s);
        let at_end = (steps(left_s) * FAST_STEP).max(FAST_STEP);
        self.progress.until_check = steps(simulation.stall_time_s).min(at_end);
        if let Some(rests) = &mut self.rests {
            rests.drive_to(lane.state.ledger[Term::Time][lane.number]);
            let most = libm::floor(until_look_s(rests.left_s()) / simulation.step_s);
            self.progress.until_check =
                self.progress.until_check.min((most * FAST_STEP).max(FAST_STEP));
        }
        lane.state.motion.steps_left[lane.number] = self.progress.until_check;
    }

    /// Looks at the temperature of the powertrain at a place.
    pub(super) fn look_at_temperature<S: Simd, P: Powertrain>(
        &self,
        lane: &mut Lane<S, P>,
        position_m: f64,
    ) {
        let (powertrain, number) = (lane.parameters.powertrain, lane.number);
        let ledger = lane.state.ledger.lane(number);
        let to_m = position_m + powertrain.preconditions_from_m();
        let charging = self.charging.as_ref();
        let preconditions = charging.is_some_and(|stops| stops.are_within(position_m, to_m));
        powertrain.look_at_temperature(&mut lane.state.powertrain, number, &ledger, preconditions);
    }

    /// Where the truck is, in m.
    pub(super) fn position_m<S: Simd, P: Powertrain>(lane: &Lane<S, P>) -> f64 {
        let (motion, number) = (&lane.state.motion, lane.number);
        let passed = &motion.roads[number][..=motion.at[number]];
        let end_m: f64 = passed.iter().map(|row| row.0[RoadRow::LENGTH]).sum();
        end_m - motion.left[number]
    }
}
