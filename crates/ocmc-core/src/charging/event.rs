//! One charging: its time and place, and the meter's count in each quarter of an hour.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A quarter of an hour, in s.
pub const QUARTER_HOUR_S: f64 = 900.0;

/// Where a truck is charged.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum ChargingPlace {
    /// In the depot, after the trip.
    Depot,
    /// At a public charger along the way.
    Public,
    /// At a stop of the mission.
    Stop,
}

impl ChargingPlace {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Depot, Self::Public, Self::Stop];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Depot => "depot",
            Self::Public => "public",
            Self::Stop => "stop",
        }
    }
}

/// One charging of a trip. Times are those after its departure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChargingEvent {
    /// Where the truck was charged.
    pub place: ChargingPlace,
    /// How far it had come, in m.
    pub position_m: f64,
    /// Arrival at the charger, in s.
    pub arrival_s: f64,
    /// Wait for a free charger, in s.
    pub wait_s: f64,
    /// Begin of the charging, in s: after the wait, and half of the time for the plug.
    pub begin_s: f64,
    /// Its time, in s.
    pub charging_s: f64,
    /// State of charge at its begin.
    pub begin_charge: f64,
    /// State of charge at its end.
    pub end_charge: f64,
    /// Energy that the store gained, in J.
    pub charged_energy_j: f64,
    /// Energy that the meter counted while the truck was plugged in, its auxiliaries among it, in
    /// J.
    pub grid_energy_j: f64,
    /// Highest power at the meter, in W.
    pub peak_power_w: f64,
    /// Energy that the meter counted in each quarter of an hour of the clock, in J, from that of
    /// the begin on.
    pub quarter_hours_j: Vec<f64>,
}

/// The course of a charging: times since its begin, in s, and the energy at the terminals up to
/// them, in J; linear between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChargeCourse(Vec<[f64; 2]>);

impl ChargeCourse {
    /// Adds the energy at the terminals up to a time.
    pub fn push(&mut self, time_s: f64, supplied_j: f64) {
        self.0.push([time_s, supplied_j]);
    }

    /// Adds a power that was supplied all the time, in W.
    pub fn raise(&mut self, power_w: f64) {
        for [time_s, supplied_j] in &mut self.0 {
            *supplied_j += power_w * *time_s;
        }
    }

    /// Goes on for some time, in s, in which an energy is supplied, in J.
    pub fn go_on(&mut self, time_s: f64, supplied_j: f64) {
        let mut next = Self::default();
        next.push(time_s, supplied_j);
        self.append(&next);
    }

    /// Goes on as another charging does from its begin.
    pub fn append(&mut self, next: &Self) {
        let [end_s, end_j] = self.0.last().copied().unwrap_or_default();
        self.0
            .extend(next.0.iter().map(|[time_s, supplied_j]| [end_s + time_s, end_j + supplied_j]));
    }

    /// Highest mean power between two of its points, in W.
    pub fn peak_power_w(&self) -> f64 {
        let mut before = [0.0; 2];
        self.0.iter().fold(0.0, |peak_w, point| {
            let [time_s, energy_j] = [0, 1].map(|k| point[k] - before[k]);
            before = *point;
            if time_s > 0.0 { f64::max(peak_w, energy_j / time_s) } else { peak_w }
        })
    }

    /// Energy at the terminals in each quarter of an hour, in J. `clock_s`: the time of the clock
    /// at which the charging begins, in s from a full hour.
    pub fn by_quarter_hour_j(&self, clock_s: f64) -> Vec<f64> {
        let Some(last) = self.0.last() else { return Vec::new() };
        let into_s = clock_s - QUARTER_HOUR_S * libm::floor(clock_s / QUARTER_HOUR_S);
        let (mut parts, mut counted_j, mut end_s) = (Vec::new(), 0.0, QUARTER_HOUR_S - into_s);
        let mut before = [0.0; 2];
        for point in &self.0 {
            while point[0] > end_s {
                let share = (end_s - before[0]) / (point[0] - before[0]);
                let up_to_j = before[1] + (point[1] - before[1]) * share;
                parts.push(up_to_j - counted_j);
                (counted_j, end_s) = (up_to_j, end_s + QUARTER_HOUR_S);
            }
            before = *point;
        }
        parts.push(last[1] - counted_j);
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_is_cut_at_the_quarters_of_the_clock() {
        let mut course = ChargeCourse::default();
        // 100 kW for 20 minutes, then 50 kW for 20
        course.push(1200.0, 120.0e6);
        course.push(2400.0, 180.0e6);
        assert_eq!(course.peak_power_w(), 100e3);
        // from 7:05 on: 10 min, 10 + 5 min, 15 min
        let parts = course.by_quarter_hour_j(7.0 * 3600.0 + 300.0);
        assert_eq!(parts.len(), 3);
        for (part, said) in parts.iter().zip([60.0e6, 60.0e6 + 15.0e6, 45.0e6]) {
            assert!((part - said).abs() < 1e-3, "{parts:?}");
        }
        // within a quarter, at its very end, and nothing at all
        let mut short = ChargeCourse::default();
        short.push(600.0, 6.0e6);
        assert_eq!(short.by_quarter_hour_j(300.0), [6.0e6]);
        assert_eq!(short.by_quarter_hour_j(0.0), [6.0e6]);
        assert_eq!(short.by_quarter_hour_j(600.0).len(), 2);
        assert!(ChargeCourse::default().by_quarter_hour_j(5.0).is_empty());
    }
}
