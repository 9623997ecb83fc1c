//! The table of a stop plan: its places in their order, with what happens there.

use super::place::Spot;
use super::{DAY_S, Halt, StopPlan};
use crate::intake::table::date::{second_of_day, second_of_year};
use crate::intake::table::formats::{ROUTE, STOP_PLAN, TRACKS};
use crate::intake::table::given::RowPlace;
use crate::intake::table::{Mapping, Quantity, Row, Source, Table, TableError};
use ocmc_core::operating_cycle::given::PlannedMission;

/// Columns of which any makes a table a stop plan.
const MARKS: [Quantity; 5] =
    [Quantity::Place, Quantity::Leg, Quantity::Dwell, Quantity::Loaded, Quantity::Unloaded];
/// Columns that have a unit.
const WITH_UNIT: [Quantity; 6] = [
    Quantity::Position,
    Quantity::Leg,
    Quantity::Dwell,
    Quantity::Loaded,
    Quantity::Unloaded,
    Quantity::Payload,
];

/// Whether a table is a stop plan: by its names, or by what is assigned.
pub(in super::super) fn is_one(source: Source, mappings: &[Mapping]) -> bool {
    let Ok(table) = Table::open(source, &TRACKS, &[]) else { return false };
    let any = |is: &dyn Fn(&String) -> bool| table.names().iter().any(is);
    let is_marked = any(&|name| STOP_PLAN.means(name).is_some_and(|mark| MARKS.contains(&mark)));
    let is_assigned = mappings.iter().any(is_of_plan);
    (is_marked || is_assigned) && !any(&|name| ROUTE.means(name) == Some(Quantity::Limit))
}

/// Whether only a stop plan has what is assigned.
pub(in super::super) fn is_of_plan(mapping: &Mapping) -> bool {
    mapping.is_of(&STOP_PLAN) && !mapping.is_of(&ROUTE)
}

/// The assignments of columns that a stop plan has.
fn own(mappings: &[Mapping]) -> Vec<Mapping> {
    mappings.iter().filter(|mapping| mapping.is_of(&STOP_PLAN)).cloned().collect()
}

impl StopPlan {
    /// Reads a stop plan.
    pub(in super::super) fn read(source: Source, mappings: &[Mapping]) -> Result<Self, TableError> {
        let table = Table::open(source, &STOP_PLAN, &own(mappings))?;
        let file = table.path().to_owned();
        for quantity in WITH_UNIT {
            let lacks = |name: &String| STOP_PLAN.means(name) == Some(quantity);
            if table.column(quantity).is_none() && table.names().iter().any(lacks) {
                return Err(table.missing(quantity.noun(), &[quantity]));
            }
        }
        let has_spots = table.column(Quantity::Latitude).is_some()
            || table.column(Quantity::Longitude).is_some();
        if has_spots {
            table.need(&[Quantity::Latitude, Quantity::Longitude])?;
        } else {
            table.need_any("place", &[Quantity::Position, Quantity::Leg, Quantity::Latitude])?;
        }
        let has_dwell = table.column(Quantity::Dwell).is_some();
        let mut halts = Vec::new();
        let account = table.for_each(|row| {
            halts.push(halt(row, has_dwell)?);
            Ok(())
        })?;
        let mut plan = Self {
            file,
            halts,
            payload_kg: None,
            departure: PlannedMission::default(),
            has_dwell,
            account,
        };
        plan.sort()?;
        plan.add_legs();
        plan.read_clock()?;
        Ok(plan)
    }

    /// Puts the places into their order.
    fn sort(&mut self) -> Result<(), TableError> {
        self.halts.sort_by(|a, b| a.order.total_cmp(&b.order));
        let twice = self.halts.windows(2).find(|pair| pair[0].order == pair[1].order);
        if let Some([first, second]) = twice {
            return Err(self.wrong(format!(
                "has the order {} twice, in {} and {}: each place has a number of its own",
                first.order, first.row, second.row
            )));
        }
        Ok(())
    }

    /// Makes positions of the ways from place to place.
    fn add_legs(&mut self) {
        let has_legs = self.halts.iter().any(|halt| halt.leg_m.is_some());
        let mut position_m = 0.0;
        for (k, halt) in self.halts.iter_mut().enumerate() {
            // no way leads to the start
            let leg_m = halt.leg_m.or((k == 0 && has_legs).then_some(0.0));
            if let Some(leg_m) = leg_m.filter(|_| halt.position_m.is_none()) {
                position_m += leg_m;
                halt.position_m = Some(position_m);
            }
        }
    }

    /// Reads the departure, and dwells that the times tell.
    fn read_clock(&mut self) -> Result<(), TableError> {
        for k in 0..self.halts.len() {
            let [arrival, departure] =
                [&self.halts[k].arrival, &self.halts[k].departure].map(|text| stamp(text));
            for (text, read) in
                [(&self.halts[k].arrival, arrival), (&self.halts[k].departure, departure)]
            {
                if read.is_none() && !text.is_empty() {
                    return Err(self.wrong(format!(
                        "{}: `{text}` is no time; allowed are times such as 06:30 and \
                         2024-03-01T06:30",
                        self.halts[k].called()
                    )));
                }
            }
            if let (false, Some((from_s, _)), Some((to_s, _))) =
                (self.has_dwell, arrival, departure)
            {
                self.halts[k].dwell_s = (to_s - from_s).rem_euclid(DAY_S);
            }
        }
        let at_start = self.halts.first().and_then(|halt| {
            stamp(&halt.departure)
                .or_else(|| stamp(&halt.arrival).map(|(at_s, day)| (at_s + halt.dwell_s, day)))
        });
        if let Some((second, day)) = at_start {
            self.departure = PlannedMission { departure_s: Some(second % DAY_S), day_of_year: day };
        }
        let has_times =
            self.halts.iter().any(|halt| !halt.arrival.is_empty() && !halt.departure.is_empty());
        self.has_dwell |= has_times;
        Ok(())
    }
}

/// One row of a plan.
fn halt(row: &Row, has_dwell: bool) -> Result<Halt, TableError> {
    let number = |quantity: Quantity| -> Result<Option<f64>, TableError> {
        if row.text(quantity).is_empty() { Ok(None) } else { row.optional(quantity) }
    };
    // a sheet may have it as hours and minutes
    let dwell_s = match second_of_day(row.text(Quantity::Dwell)) {
        _ if !has_dwell => None,
        Some(dwell_s) => Some(dwell_s),
        None => number(Quantity::Dwell)?,
    };
    let spot = number(Quantity::Latitude)?.zip(number(Quantity::Longitude)?);
    let order = number(Quantity::Order)?;
    let place = row.place();
    let (RowPlace::Line(in_file) | RowPlace::Row(in_file)) = place;
    Ok(Halt {
        row: place,
        order: order.unwrap_or(in_file as f64),
        name: row.text(Quantity::Place).to_owned(),
        position_m: number(Quantity::Position)?,
        leg_m: number(Quantity::Leg)?,
        spot: spot.map(|(latitude_deg, longitude_deg)| Spot { latitude_deg, longitude_deg }),
        altitude_m: number(Quantity::Altitude)?,
        dwell_s: dwell_s.unwrap_or(0.0),
        loaded_kg: number(Quantity::Loaded)?,
        unloaded_kg: number(Quantity::Unloaded)?,
        payload_kg: number(Quantity::Payload)?,
        arrival: row.text(Quantity::Arrival).to_owned(),
        departure: row.text(Quantity::Date).to_owned(),
    })
}

/// Second of the day of a time, and the day of the year where it has one.
fn stamp(text: &str) -> Option<(f64, Option<f64>)> {
    second_of_day(text).map(|second| (second, None)).or_else(|| {
        let second = second_of_year(text)?;
        Some((second % DAY_S, Some((second / DAY_S).floor())))
    })
}
