//! The report's part about charging: how far trips come, the state of charge along the way, what
//! chargers draw from the grid, and how winter differs from summer.

use super::charging_pictures::{
    Step, load_curve, range_curve, state_of_charge, waterfall as waterfall_picture,
};
use super::gathered::Sums;
use super::{Gathered, Reported};
use crate::label::{charger_name, clock};
use crate::number_text::{grouped, short};
use ocmc_core::charging::ChargingPlace;
use ocmc_core::record::Record;
use ocmc_fleet::quantile::quantile;
use ocmc_fleet::range::{RangeSummary, SEASONS, summarise};
use ocmc_fleet::summary::Summary;
use std::fmt::Write;

/// Trips whose state of charge is kept, from the first on.
const MOST_COURSES: usize = 2000;
/// Places along the way at which the state of charge is looked at.
const PLACES: usize = 80;
/// Fewest trips of which a band is drawn, and of a season.
const FEWEST: usize = 20;
/// Parts of the waterfall that are smaller than this share of the whole stand together.
const SMALL: f64 = 0.004;

/// States of charge of a trip, each with where it was, in m: at departure, before and behind each
/// charging, and at the end.
pub(super) type Course = Vec<[f64; 2]>;

/// Course of a trip that was charged by a policy.
fn course_of(record: &Record) -> Option<Course> {
    let events = record.charging_events.as_ref()?;
    let mut course = vec![[0.0, record.departure_charge?]];
    for event in events.iter().filter(|event| event.place != ChargingPlace::Depot) {
        course.push([event.position_m, event.begin_charge]);
        course.push([event.position_m, event.end_charge]);
    }
    course.push([record.distance_m, record.final_charge?]);
    Some(course)
}

/// Keeps the courses of the first trips.
pub(super) fn keep(courses: &mut Vec<Course>, record: &Record) {
    if courses.len() < MOST_COURSES && record.outcome.counts() {
        courses.extend(course_of(record));
    }
}

/// Nothing where no trip was charged by a policy.
pub(super) fn charging(run: &Reported) -> String {
    let summary = &run.summary.summary;
    if summary.charging.is_none() {
        return String::new();
    }
    let mut text = "<h2>Charging and range</h2>\n".to_owned();
    text.push_str(&stops(summary));
    text.push_str(&trucks(summary));
    text.push_str(&range(run));
    text.push_str(&along_the_way(run));
    text.push_str(&loads(summary));
    text
}

/// How often trips are charged on the way.
fn stops(summary: &Summary) -> String {
    let Some(charging) = &summary.charging else { return String::new() };
    let percent = |n: u64| format!("{:.1}", 100.0 * n as f64 / charging.trips.max(1) as f64);
    let without = charging.arrived_with_stops[0];
    let (trips, arrived) = (grouped(charging.trips), percent(charging.arrived()));
    if without == charging.arrived() {
        return format!(
            "<p>Of {trips} trips {arrived} % arrive, all without a charging stop.</p>\n"
        );
    }
    format!(
        "<p>Of {trips} trips {arrived} % arrive, {} % of all without a charging stop. Those that \
         arrive are charged on the way for {} min in the mean and wait {} min for chargers.</p>\n",
        percent(without),
        short(charging.charging_s / 60.0 / charging.arrived().max(1) as f64),
        short(charging.charging_wait_s / 60.0 / charging.arrived().max(1) as f64),
    )
}

/// Numbers of trucks whose trips arrive.
fn trucks(summary: &Summary) -> String {
    let [all, most] = &summary.truck_arrivals[..] else { return String::new() };
    let range = |ci95: [f64; 2]| format!("{:.0} to {:.0} %", 100.0 * ci95[0], 100.0 * ci95[1]);
    format!(
        "<p>Of {} trucks {} make all of their trips ({} of such trucks would, 95 % interval), and \
         {} at least {:.0} % of them ({}).</p>\n",
        grouped(all.of),
        grouped(all.trucks),
        range(all.ci95),
        grouped(most.trucks),
        100.0 * most.share_of_trips,
        range(most.ci95),
    )
}

/// The share of the trips that still drive, over the distance.
fn range(run: &Reported) -> String {
    let trips = &run.gathered.range_trips;
    let summary = summarise(trips, run.manifest.dependence());
    let Some(RangeSummary { all, curve, .. }) = summary else { return String::new() };
    if all.depleted == 0 {
        return "<p>No trip came down to its reserve: how much farther the trucks would come is not \
                in these records. <code>ocmc range --study …</code> drives them until they are \
                empty.</p>\n"
            .to_owned();
    }
    let points: Vec<(f64, f64, [f64; 2])> =
        curve.iter().map(|point| (point.distance_m / 1000.0, point.share, point.ci95)).collect();
    format!(
        "<figure>{}<figcaption>Share of the trucks that are not empty yet over the distance, \
         charging on the way included, with its 95 % interval (Kaplan and Meier: a trip that \
         arrives tells only that its truck comes farther). {} of {} trips ended at the \
         reserve.</figcaption></figure>\n",
        range_curve(&points),
        grouped(all.depleted),
        grouped(all.trips),
    )
}

/// The state of charge over the distance, of the trips that come so far.
fn along_the_way(run: &Reported) -> String {
    let courses = &run.gathered.courses;
    let end_m = courses.iter().filter_map(|course| course.last()).map(|end| end[0]);
    let end_m = end_m.fold(0.0, f64::max);
    let mut bands: Vec<(f64, [f64; 3])> = Vec::new();
    for k in 0..=PLACES {
        let at_m = end_m * k as f64 / PLACES as f64;
        let mut charges: Vec<f64> =
            courses.iter().filter_map(|course| charge_at(course, at_m)).collect();
        if charges.len() < FEWEST {
            break;
        }
        charges.sort_unstable_by(f64::total_cmp);
        let level = |level| quantile(&charges, level).unwrap_or(f64::NAN);
        bands.push((at_m / 1000.0, [level(0.05), level(0.5), level(0.95)]));
    }
    if bands.len() < 2 {
        return String::new();
    }
    let reserve = run.manifest.value("charging.reserve").and_then(|value| value.as_float());
    format!(
        "<figure>{}<figcaption>State of charge over the distance: median, and the band in which 90 \
         % of the trips lie that come so far ({} trips). It is known at departure, before and \
         behind each charging and at the end, and drawn straight between: a hill on the way is not \
         in it. Dashed: the reserve.\
         </figcaption></figure>\n",
        state_of_charge(&bands, reserve),
        grouped(courses.len() as u64),
    )
}

/// The state of charge at a distance; none behind the end of the trip.
fn charge_at(course: &[[f64; 2]], at_m: f64) -> Option<f64> {
    let after = course.iter().position(|point| point[0] >= at_m)?;
    let [end_m, end] = course[after];
    let Some([begin_m, begin]) = after.checked_sub(1).map(|k| course[k]) else { return Some(end) };
    let share = if end_m > begin_m { (at_m - begin_m) / (end_m - begin_m) } else { 1.0 };
    Some(begin + (end - begin) * share)
}

/// Load of chargers on the grid over the day.
fn loads(summary: &Summary) -> String {
    let Some(loads) = &summary.loads else { return String::new() };
    let mut text = String::new();
    for place in &loads.places {
        let rows: Vec<[f64; 4]> = loads
            .rows
            .iter()
            .filter(|row| row.place == place.place)
            .map(|row| {
                [row.p50_power_w, row.mean_power_w, row.p95_power_w, row.highest_power_w]
                    .map(|power_w| power_w / 1000.0)
            })
            .collect();
        let name = charger_name(place.place);
        let period = if summary.trucks.is_some() {
            "over the days of the fleet's calendar, those without trips among them"
        } else {
            "over the days of one year that holds all trips"
        };
        let _ = writeln!(
            text,
            "<figure>{}<figcaption>Power that {name} draw from the grid, kW, means of quarters of \
             an hour, {period} ({} days): the line is the mean, the band reaches from the median \
             day up to the one that 19 of 20 stay below. There it is highest at {}, {} kW; on the \
             highest day {} kW. On the mean day {} kWh are charged.</figcaption></figure>",
            load_curve(&rows, name),
            grouped(place.days),
            clock(place.p95_quarter_hour),
            short(place.p95_power_w / 1000.0),
            short(place.highest_power_w / 1000.0),
            grouped((place.energy_per_day_j / 3.6e6).round() as u64),
        );
    }
    text
}

/// Consumption from summer to winter by kinds of loss, of battery trucks; nothing where one of the
/// seasons has few trips.
pub(super) fn waterfall(gathered: &Gathered) -> String {
    let [winter, _, summer, _] = &gathered.by_season;
    let km = |sums: &Sums| sums.distance_m.unwrap_or(0.0) / 1000.0;
    let whole = |sums: &Sums| sums.charge_j.map(|j| j / 3.6e6 / km(sums));
    let (Some(from), Some(to)) = (whole(summer), whole(winter)) else { return String::new() };
    if summer.trips < FEWEST as u64 || winter.trips < FEWEST as u64 {
        return String::new();
    }
    let mut steps: Vec<Step> = Vec::new();
    let mut other = 0.0;
    for (k, (name, _)) in summer.losses_j.iter().enumerate() {
        let loss_kwh_per_km = |sums: &Sums| sums.losses_j[k].1.unwrap_or(0.0) / 3.6e6 / km(sums);
        let change = loss_kwh_per_km(winter) - loss_kwh_per_km(summer);
        if change.abs() < SMALL * from {
            other += change;
        } else {
            steps.push(Step { name: (*name).to_owned(), change });
        }
    }
    steps.sort_by(|a, b| b.change.abs().total_cmp(&a.change.abs()));
    steps.push(Step { name: "all others".to_owned(), change: other });
    format!(
        "<h2>From {} to {}</h2>\n<figure>{}<figcaption>Electricity from the battery over the \
         distance, kWh/km, of the completed trips that depart in summer ({}) and in winter ({}), \
         and what the difference is made of. The trips are different ones: chance is in it, \
         too.</figcaption></figure>\n",
        SEASONS[2],
        SEASONS[0],
        waterfall_picture([from, to], &steps),
        grouped(summer.trips),
        grouped(winter.trips),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::charging::ChargingEvent;

    #[test]
    fn the_course_of_a_trip_has_its_stops() {
        let event = |place, position_m: f64| ChargingEvent {
            place,
            position_m,
            arrival_s: 0.0,
            wait_s: 0.0,
            begin_s: 0.0,
            charging_s: 100.0,
            begin_charge: 0.2,
            end_charge: 0.8,
            charged_energy_j: 60.0,
            grid_energy_j: 60.0,
            peak_power_w: 1.0,
            quarter_hours_j: vec![60.0],
        };
        let record = Record {
            distance_m: 2000.0,
            departure_charge: Some(0.9),
            final_charge: Some(0.5),
            charging_events: Some(vec![
                event(ChargingPlace::Public, 1000.0),
                event(ChargingPlace::Depot, 2000.0),
            ]),
            ..Record::default()
        };
        let charges = course_of(&record).expect("charged");
        assert_eq!(charges, [[0.0, 0.9], [1000.0, 0.2], [1000.0, 0.8], [2000.0, 0.5]]);
        let at = |m: f64| charge_at(&charges, m);
        assert!((at(500.0).expect("there") - 0.55).abs() < 1e-12);
        assert!((at(1500.0).expect("there") - 0.65).abs() < 1e-12);
        assert_eq!((at(0.0), at(2001.0)), (Some(charges[0][1]), None));
    }
}
