//! Where a driver stops at a charger, to charge or to rest: he decides at the place where he would
//! have to brake for it, or to heat his battery for it, by a forecast.
//!
//! He stops where the next place at which he could charge is out of reach with his reserve, and
//! where the next place at which he could rest is out of reach by the law
//! ([`super::rest_decision`]). What he gets wrong uses up his reserve, or makes him rest on the
//! spot. Nothing is driven twice.

use super::charging_site::Site;
use super::lane_task::LaneTask;
use super::stop_ahead::{Standing, StopAhead};
use crate::charging::{Driven, Goal};
use crate::energy::ledger::Term;
use crate::kernel::step::state::Lane;
use crate::powertrain::Powertrain;
use fearless_simd::Simd;

/// Places closer than this are one, in m.
const SAME_M: f64 = 1e-3;

impl LaneTask {
    /// The trip up to a place, as its driver knows it. `altitude_m`: how high he is above its
    /// start.
    pub(super) fn driven<S: Simd, P: Powertrain>(
        &self,
        lane: &Lane<S, P>,
        position_m: f64,
        altitude_m: f64,
    ) -> Driven {
        let (ledger, number) = (&lane.state.ledger, lane.number);
        Driven {
            way_m: ledger[Term::Distance][number],
            time_s: ledger[Term::Time][number],
            drawn_j: ledger[Term::Battery][number],
            fixed_j: self.scenario.fixed_energy_j([0.0, position_m], altitude_m),
        }
    }

    /// Decides at all chargers at which it is time to, where the truck is. `from`: the row that
    /// begins there.
    pub(super) fn decide<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        here_m: f64,
        from: usize,
    ) {
        loop {
            let waits = self.has_stop_ahead(here_m + SAME_M);
            let Some(charging) = &mut self.charging else { return };
            let Some(site) = charging.sites.get(charging.progress.next_site).copied() else {
                return;
            };
            let is_here = site.decided_at_m.max(site.after_m) <= here_m + SAME_M;
            if waits || !is_here {
                return;
            }
            charging.progress.next_site += 1;
            if site.row < from {
                continue;
            }
            let [charges, rests] = self.needs(lane, here_m, &site);
            if charges && let Some(charging) = &mut self.charging {
                charging.planned.push(site.position_m);
            }
            if charges || rests {
                let (row, position_m) = (site.row, site.position_m);
                self.stop_ahead(lane, from, StopAhead { row, position_m, rests });
            }
        }
    }

    /// Whether a driver stops at a charger, to charge and to rest.
    fn needs<S: Simd, P: Powertrain>(
        &mut self,
        lane: &Lane<S, P>,
        here_m: f64,
        site: &Site,
    ) -> [bool; 2] {
        let climb_m = self.scenario.cycle.road.climb_m([here_m, site.position_m]);
        let driven = self.driven(lane, here_m, site.altitude_m - climb_m);
        let powertrain = lane.parameters.powertrain;
        let known = lane.parameters.charging.and_then(|policy| {
            let (public, forecast) = (policy.public.as_ref()?, policy.forecast.as_ref()?);
            let charge = powertrain.charge_of(&lane.state.powertrain, lane.number)?;
            Some((policy, public, forecast, charge, powertrain.store()?))
        });
        let Some((policy, public, forecast, charge, store)) = known else { return [false; 2] };
        let takes = |[from_m, to_m]: [f64; 2], climb_m: f64| {
            let fixed_j = self.scenario.fixed_energy_j([from_m, to_m], climb_m);
            forecast.energy_j(&driven, to_m - from_m, fixed_j) / store.capacity_j
        };
        let arrives = charge - takes([here_m, site.position_m], climb_m);
        let reaches = arrives - takes([site.position_m, site.reach_m], site.reach_climb_m);
        let keeps = store.lowest_charge.max(policy.reserve);
        let charges = reaches < keeps && arrives < public.end_at;
        let with_margin = 1.0 + forecast.margin;
        let way_s = with_margin * driven.time_s(site.position_m - here_m);
        let next_s = with_margin * driven.time_s(site.pause_m - site.position_m);
        let rests = self.rests.as_mut().is_some_and(|rests| {
            rests.drive_to(driven.time_s);
            rests.has_to_rest_at(way_s, next_s)
        });
        [charges, rests]
    }

    /// State of charge with which the goal of a truck that is charged at a place comes within its
    /// reach, by its driver's forecast; infinite where it is to be charged to the end.
    pub(super) fn enough_charge<S: Simd, P: Powertrain>(
        &self,
        lane: &Lane<S, P>,
        at: &Standing,
    ) -> f64 {
        let known = lane.parameters.charging.and_then(|policy| {
            let (public, forecast) = (policy.public.as_ref()?, policy.forecast.as_ref()?);
            let enough = public.enough.as_ref()?;
            let stops = self.charging.as_ref()?;
            stops.planned.contains(&at.position_m).then_some(())?;
            let site = stops.sites.iter().find(|site| site.position_m == at.position_m)?;
            Some((policy, enough, forecast, lane.parameters.powertrain.store()?, site))
        });
        let Some((policy, enough, forecast, store, site)) = known else { return f64::INFINITY };
        let driven = self.driven(lane, site.position_m, site.altitude_m);
        let road = &self.scenario.cycle.road;
        let next = self.scenario.chargers.iter().find(|next| next.position_m > site.position_m);
        let to_m = match enough.reach {
            Goal::Destination => road.length_m,
            Goal::NextCharger => next.map_or(road.length_m, |next| next.position_m),
        };
        let climb_m = road.climb_m([site.position_m, to_m]);
        let fixed_j = self.scenario.fixed_energy_j([site.position_m, to_m], climb_m);
        let way_m = (1.0 + enough.margin) * (to_m - site.position_m);
        let takes_j = forecast.energy_j(&driven, way_m, fixed_j);
        store.lowest_charge.max(policy.reserve) + takes_j.max(0.0) / store.capacity_j
    }
}
