//! A truck at a line: the stops that its driver has decided on, where it stands, and for how long
//! it charges and rests there. What it draws it draws in the order of the clock: it waits for the
//! charger, is plugged in and charged, stays plugged in as long as it stands, and is unplugged.

use super::charging_stops::{Arrival, Charged};
use super::lane_task::LaneTask;
use super::rest_stops::is_mission_stop;
use super::stop_ahead::{Standing, StopAhead, put_in};
use crate::charging::ChargeCourse;
use crate::energy::ledger::Term;
use crate::kernel::step::state::Lane;
use crate::powertrain::Powertrain;
use fearless_simd::Simd;

impl LaneTask {
    /// The driver decides to stop at the end of a row. He is where the row `from` begins.
    pub(super) fn stop_ahead<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        from: usize,
        stop: StopAhead,
    ) {
        let number = lane.number;
        let near_m = lane.parameters.simulation.creep_distance_m;
        let coasts = lane.parameters.look_ahead.coasting;
        let twice_deceleration = lane.state.constants.twice_deceleration[number];
        let rows = &mut lane.state.motion.roads[number];
        let span = [from, stop.row];
        let changed = put_in(rows, span, twice_deceleration, coasts, near_m, &mut self.served);
        self.marks.hide(changed.reach_from..=stop.row);
        self.parts.stop_within(&changed, stop.row, rows);
        self.stops_ahead.push(stop);
    }

    /// Whether the truck is on its way to a stop that its driver has decided on.
    pub(super) fn has_stop_ahead(&self, here_m: f64) -> bool {
        self.stops_ahead.iter().any(|stop| stop.position_m > here_m)
    }

    /// Where a truck stands that stands at the line at the end of a row; none at the road's end.
    pub(super) fn standing(&self, row: usize) -> Option<Standing> {
        if let Some(stop) = self.stops_ahead.iter().find(|stop| stop.row == row) {
            let StopAhead { position_m, rests, .. } = *stop;
            return Some(Standing { position_m, of_mission: false, is_rest: true, rests });
        }
        let event = self.road.event_after(row)?;
        let stop = &self.scenario.cycle.road.events[event];
        let (position_m, of_mission) = (stop.position_m, is_mission_stop(stop));
        Some(Standing { position_m, of_mission, is_rest: of_mission, rests: false })
    }

    /// The truck stands at a line for a time that was planned: charges there and rests, and returns
    /// for how long it does then, in s, and whether the law on rests asked for it.
    pub(super) fn stand<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        at: &Standing,
        planned_s: f64,
    ) -> (f64, bool) {
        let mut dwell_s = planned_s;
        let mut added_s = 0.0;
        let stays = self.charges_at(at.position_m);
        if !stays {
            let asked_s = self.rest_asked_s(lane, at, planned_s);
            (dwell_s, added_s) = (planned_s.max(asked_s), asked_s - planned_s);
        }
        dwell_s = self.charge(lane, at, dwell_s);
        if stays {
            // it stands as long as charging takes
            let asked_s = self.rest_asked_s(lane, at, dwell_s);
            (dwell_s, added_s) = (dwell_s.max(asked_s), asked_s - dwell_s);
        }
        let driven_s = lane.state.ledger[Term::Time][lane.number];
        let Some(rests) = &mut self.rests else { return (dwell_s, false) };
        rests.drive_to(driven_s);
        rests.stand(at, dwell_s, added_s);
        (dwell_s, added_s > 0.0)
    }

    /// Whether the driver has decided to charge at a place.
    fn charges_at(&self, position_m: f64) -> bool {
        self.charging.as_ref().is_some_and(|charging| charging.planned.contains(&position_m))
    }

    /// Charges at a stop line, where that is worth while, while the truck stands for some time;
    /// returns for how long it does then, in s.
    fn charge<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        at: &Standing,
        dwell_s: f64,
    ) -> f64 {
        let enough = self.enough_charge(lane, at);
        let (Some(stops), Some(policy)) = (&mut self.charging, lane.parameters.charging) else {
            return dwell_s;
        };
        let (powertrain, number) = (lane.parameters.powertrain, lane.number);
        let own = &mut lane.state.powertrain;
        let Some(comes_with) = powertrain.charge_of(own, number) else { return dwell_s };
        let worked_s = self.progress.stood_s;
        let offer = stops.offer(policy, &self.scenario, at, dwell_s - worked_s, enough);
        let Some(offer) = offer.filter(|offer| offer.is_used(comes_with)) else { return dwell_s };
        powertrain.stand(own, number, offer.before_s(), &mut self.added_by_event);
        let arrival = Arrival {
            position_m: at.position_m,
            time_s: lane.state.ledger[Term::Time][number] + self.progress.standstill_s + worked_s,
            departure_s: self.scenario.cycle.mission.departure_s,
            charge: powertrain.charge_of(own, number).unwrap_or(comes_with),
        };
        let mut course = ChargeCourse::default();
        let charge = powertrain.charge(own, number, &offer.plug, &mut course);
        self.added_by_event[Term::Charged] += charge.gained_j;
        self.added_by_event[Term::ChargingLoss] += charge.loss_j;
        self.progress.stood_s += offer.before_s() + charge.time_s;
        let rise = powertrain.rise(charge.gained_j);
        let stands_s = stops.charged(&offer, Charged { charge, course, rise }, arrival);
        dwell_s.max(worked_s + stands_s)
    }

    /// The truck stays plugged in as long as it stands, this time in s; returns for how long it
    /// does.
    pub(super) fn stay_plugged<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        stands_s: f64,
    ) -> f64 {
        let Some(stops) = &mut self.charging else { return 0.0 };
        let Some(unplugging_s) = stops.unplugging_s() else { return 0.0 };
        let (powertrain, number) = (lane.parameters.powertrain, lane.number);
        let own = &mut lane.state.powertrain;
        let plugged_s = (stands_s - unplugging_s).max(0.0);
        powertrain.stand(own, number, plugged_s, &mut self.added_by_event);
        stops.unplug(plugged_s, powertrain.unplug(own, number));
        plugged_s
    }
}
