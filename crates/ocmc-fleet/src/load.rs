//! Load curves: the power that a fleet's chargers draw from the grid in each quarter of an hour of
//! a day, and how it differs from day to day.
//!
//! P(d, q) is the energy that the meters of all chargers of a kind count on day d in quarter q,
//! over 900 s. Mean and quantiles of a quarter are over the days: all days of the calendar in whole
//! weeks, days without trips among them; where trips draw their days, all trips lie in one year of
//! 365 days. What is charged after the last day is put on the first one, as if the calendar went
//! round. So the energy below the curves is what the meters have counted.

use super::dependence::Dependence;
use super::quantile::quantile;
use ocmc_core::charging::event::{ChargingPlace, QUARTER_HOUR_S};
use ocmc_core::random::nesting::DAYS_OF_YEAR;
use ocmc_core::record::Record;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// Quarters of an hour of a day.
pub const QUARTER_HOURS: usize = 96;

/// Seconds of a day.
const DAY_S: f64 = 86_400.0;

/// One quarter of an hour of the load curve of one kind of chargers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Load {
    /// The chargers.
    pub place: ChargingPlace,
    /// Number of the quarter, from 0 at midnight.
    pub quarter_hour: u64,
    /// Mean power over the days, in W.
    pub mean_power_w: f64,
    /// Power that half of the days stay below, in W.
    pub p50_power_w: f64,
    /// Power that 19 of 20 days stay below, in W.
    pub p95_power_w: f64,
    /// Power of the highest day, in W.
    pub highest_power_w: f64,
    /// The days.
    pub days: u64,
}

/// The load curves of a fleet.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(transparent)]
pub struct LoadCurves {
    /// Load of each kind of chargers that was used, in the order of [`ChargingPlace::ALL`].
    #[serde(skip)]
    pub rows: Vec<Load>,
    /// Load at each place.
    pub places: Vec<LoadOfPlace>,
}

/// Load curve of a kind of chargers in a few numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct LoadOfPlace {
    /// The chargers.
    pub place: ChargingPlace,
    /// Energy that their meters count on the mean day, in J.
    pub energy_per_day_j: f64,
    /// Highest power of a quarter of an hour that 19 of 20 days stay below, in W.
    pub p95_power_w: f64,
    /// Number of that quarter of an hour.
    pub p95_quarter_hour: u64,
    /// Highest power of a quarter of an hour of all days, in W.
    pub highest_power_w: f64,
    /// The days.
    pub days: u64,
}

/// Collects what trips charged, in the order of their cycles.
#[derive(Clone, Debug, Default)]
pub struct LoadBuilder {
    /// Energy by day, from the first one on, and quarter, in J.
    energies_j: [BTreeMap<u64, Vec<f64>>; ChargingPlace::ALL.len()],
}

impl LoadBuilder {
    /// Adds what a trip charged.
    pub fn add(&mut self, record: &Record, dependence: &Dependence) {
        let Some(events) = &record.charging_events else { return };
        let departure_s = departure_s(record, dependence);
        for event in events {
            let first = (departure_s + event.begin_s) / QUARTER_HOUR_S;
            let first = libm::floor(first) as u64;
            let days = &mut self.energies_j[event.place as usize];
            for (quarter, energy_j) in (first..).zip(&event.quarter_hours_j) {
                let (day, of_day) =
                    (quarter / QUARTER_HOURS as u64, quarter % QUARTER_HOURS as u64);
                let day = days.entry(day).or_insert_with(|| vec![0.0; QUARTER_HOURS]);
                day[of_day as usize] += energy_j;
            }
        }
    }

    /// The curves; none where nothing was charged.
    pub fn finish(mut self, dependence: &Dependence) -> Option<LoadCurves> {
        let days = days(dependence);
        let mut curves = LoadCurves { rows: Vec::new(), places: Vec::new() };
        for place in ChargingPlace::ALL {
            let energies_j = &mut self.energies_j[place as usize];
            for (day, beyond) in energies_j.split_off(&days) {
                let around = energies_j.entry(day % days);
                let sums = around.or_insert_with(|| vec![0.0; QUARTER_HOURS]);
                sums.iter_mut().zip(&beyond).for_each(|(sum, more)| *sum += more);
            }
            if energies_j.is_empty() {
                continue;
            }
            let of_quarter = |quarter| Load::of(place, quarter, energies_j, days);
            let rows: Vec<Load> = (0..QUARTER_HOURS).map(of_quarter).collect();
            curves.places.push(LoadOfPlace::of(place, &rows));
            curves.rows.extend(rows);
        }
        (!curves.rows.is_empty()).then_some(curves)
    }
}

/// The departure of a trip, in s from the first day of the calendar.
fn departure_s(record: &Record, dependence: &Dependence) -> f64 {
    let Some(days) = dependence.days else { return record.departure_s_of_year };
    // the year of the calendar is not in the departure
    let day = days.day_of(record.cycle_id % dependence.trips_per_truck);
    let years = (day / DAYS_OF_YEAR * DAYS_OF_YEAR) as f64;
    years * DAY_S + record.departure_s_of_year
}

/// Days of the calendar, in whole weeks; those of a year where there is none.
fn days(dependence: &Dependence) -> u64 {
    let last = |trips: u64| dependence.days.map(|days| days.day_of(trips.saturating_sub(1)));
    last(dependence.trips_per_truck).map_or(DAYS_OF_YEAR, |last| (last / 7 + 1) * 7)
}

impl Load {
    /// Load of a quarter, from the energies of the days on which something was charged.
    fn of(
        place: ChargingPlace,
        quarter: usize,
        energies_j: &BTreeMap<u64, Vec<f64>>,
        days: u64,
    ) -> Self {
        let mut powers_w: Vec<f64> =
            energies_j.values().map(|day| day[quarter] / QUARTER_HOUR_S).collect();
        let sum_w = powers_w.iter().fold(0.0, |sum_w, power_w| sum_w + power_w);
        powers_w.resize(days as usize, 0.0);
        powers_w.sort_unstable_by(f64::total_cmp);
        let level = |level| quantile(&powers_w, level).unwrap_or(0.0);
        Self {
            place,
            quarter_hour: quarter as u64,
            mean_power_w: sum_w / days as f64,
            p50_power_w: level(0.5),
            p95_power_w: level(0.95),
            highest_power_w: level(1.0),
            days,
        }
    }
}

impl LoadOfPlace {
    fn of(place: ChargingPlace, rows: &[Load]) -> Self {
        let mut totals = Self {
            place,
            energy_per_day_j: 0.0,
            p95_power_w: 0.0,
            p95_quarter_hour: 0,
            highest_power_w: 0.0,
            days: rows[0].days,
        };
        for row in rows {
            totals.energy_per_day_j += row.mean_power_w * QUARTER_HOUR_S;
            totals.highest_power_w = totals.highest_power_w.max(row.highest_power_w);
            if row.p95_power_w > totals.p95_power_w {
                (totals.p95_power_w, totals.p95_quarter_hour) = (row.p95_power_w, row.quarter_hour);
            }
        }
        totals
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::charging::ChargingEvent;
    use ocmc_core::random::nesting::OperatingDays;

    fn trip(cycle_id: u64, departure_s_of_year: f64, begin_s: f64, parts_j: &[f64]) -> Record {
        let event = ChargingEvent {
            place: ChargingPlace::Depot,
            position_m: 0.0,
            arrival_s: begin_s,
            wait_s: 0.0,
            begin_s,
            charging_s: 900.0 * parts_j.len() as f64,
            begin_charge: 0.5,
            end_charge: 0.6,
            charged_energy_j: 0.0,
            grid_energy_j: parts_j.iter().sum(),
            peak_power_w: 0.0,
            quarter_hours_j: parts_j.to_vec(),
        };
        let charging_events = Some(vec![event]);
        Record { cycle_id, departure_s_of_year, charging_events, ..Record::default() }
    }

    #[test]
    fn energy_lies_in_the_quarters_of_its_days_and_goes_round() {
        let days = Some(OperatingDays { per_week: 5, trips: 1, departure_interval_s: 0.0 });
        // trucks of 10 trips: two weeks
        let dependence = Dependence { trips_per_truck: 10, days, ..Dependence::default() };
        let mut builder = LoadBuilder::default();
        let seven = 7.0 * 3600.0;
        // 90 and 180 kW from 7:00 on, on the first day
        builder.add(&trip(0, seven, 0.0, &[81.0e6, 162.0e6]), &dependence);
        // another truck at 7:15 on that day
        builder.add(&trip(10, seven, 950.0, &[81.0e6]), &dependence);
        // the last trip's is behind the last Sunday: on the first Monday
        let last = 11.0 * DAY_S + seven;
        builder.add(&trip(9, last, 3.0 * DAY_S - 100.0, &[9.0e6, 9.0e6]), &dependence);
        let curves = builder.finish(&dependence).expect("charged");
        assert_eq!((curves.rows.len(), curves.rows[0].days), (QUARTER_HOURS, 14));
        let load = |quarter: usize| curves.rows[quarter];
        assert_eq!(load(27).mean_power_w, 10e3 / 14.0);
        assert_eq!(load(28).mean_power_w, 100e3 / 14.0);
        assert_eq!((load(29).highest_power_w, load(29).p50_power_w), (270e3, 0.0));
        // 13 days without and one of 270 kW: 0.35 of the way from the 13th to the 14th
        assert!((load(29).p95_power_w - 0.35 * 270e3).abs() < 1e-6);
        let place = curves.places[0];
        assert!((14.0 * place.energy_per_day_j / 342.0e6 - 1.0).abs() < 1e-12);
        assert_eq!((place.p95_quarter_hour, place.highest_power_w), (29, 270e3));
        assert!(LoadBuilder::default().finish(&dependence).is_none());
    }

    #[test]
    fn without_a_calendar_trips_lie_in_a_year() {
        let dependence = Dependence::default();
        let mut builder = LoadBuilder::default();
        builder.add(&trip(7, 364.0 * DAY_S, DAY_S, &[900.0]), &dependence);
        let curves = builder.finish(&dependence).expect("charged");
        assert_eq!((curves.rows[0].days, curves.rows[0].highest_power_w), (365, 1.0));
    }
}
