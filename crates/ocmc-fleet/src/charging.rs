//! Charging of a fleet's trips: how often on the way, for how long, and what meters counted.

use super::parts::add_known;
use ocmc_core::record::{Outcome, Record};
use schemars::JsonSchema;
use serde::Serialize;

/// Charging stops from which on trips are counted together.
const MOST_STOPS: usize = 5;

/// Charging of a fleet's trips, where its study says how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct ChargingSummary {
    /// Trips with a battery and a policy.
    pub trips: u64,
    /// Trips that arrived, by their charging stops: without, with one, and so on; the last with
    /// five or more.
    pub arrived_with_stops: [u64; MOST_STOPS + 1],
    /// Trips whose battery was empty, or without public chargers down to the reserve.
    pub depleted: u64,
    /// Time for which trips that arrived were charged on the way, in s, all together.
    pub charging_s: f64,
    /// Time for which they waited for chargers, in s, all together.
    pub charging_wait_s: f64,
    /// Lowest state of charge with which one of them came to a charger or to its end.
    pub lowest_charge: Option<f64>,
    /// Energy that depots' meters counted, in J, all together; none where the study has none.
    pub grid_energy_depot_j: Option<f64>,
    /// Energy that the meters of public chargers counted, in J.
    pub grid_energy_public_j: f64,
    /// Energy that the meters of chargers at stops of the mission counted, in J.
    pub grid_energy_stop_j: f64,
}

impl ChargingSummary {
    /// Adds a trip, where it was charged by a policy.
    pub fn add(&mut self, record: &Record) {
        let Some(stops) = record.n_charging_stops else { return };
        self.trips += 1;
        self.depleted += u64::from(record.outcome == Outcome::Depleted);
        self.grid_energy_public_j += record.grid_energy_public_j.unwrap_or(0.0);
        self.grid_energy_stop_j += record.grid_energy_stop_j.unwrap_or(0.0);
        add_known(&mut self.grid_energy_depot_j, record.grid_energy_depot_j);
        if record.outcome == Outcome::Completed {
            self.arrived_with_stops[(stops as usize).min(MOST_STOPS)] += 1;
            self.charging_s += record.charging_s.unwrap_or(0.0);
            self.charging_wait_s += record.charging_wait_s.unwrap_or(0.0);
            let lowest = self.lowest_charge.into_iter().chain(record.lowest_charge);
            self.lowest_charge = lowest.reduce(f64::min);
        }
    }

    /// Trips that arrived.
    pub fn arrived(&self) -> u64 {
        self.arrived_with_stops.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trips_count_by_their_stops_and_those_without_a_policy_do_not() {
        let trip = |n_charging_stops, outcome| Record {
            n_charging_stops,
            outcome,
            charging_s: n_charging_stops.map(f64::from),
            grid_energy_public_j: Some(7.0),
            ..Record::default()
        };
        let mut summary = ChargingSummary::default();
        for record in [
            trip(Some(0), Outcome::Completed),
            trip(Some(2), Outcome::Completed),
            trip(Some(9), Outcome::Completed),
            trip(Some(1), Outcome::Depleted),
            trip(None, Outcome::Completed),
        ] {
            summary.add(&record);
        }
        assert_eq!((summary.trips, summary.arrived(), summary.depleted), (4, 3, 1));
        assert_eq!(summary.arrived_with_stops, [1, 0, 1, 0, 0, 1]);
        assert_eq!((summary.charging_s, summary.grid_energy_public_j), (11.0, 28.0));
        assert_eq!(summary.grid_energy_depot_j, None);
    }
}
