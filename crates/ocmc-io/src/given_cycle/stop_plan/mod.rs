//! A stop plan, as a planner's spreadsheet has it: places in their order, how long a truck stands
//! at each, what it loads and unloads there, and when it departs. Alone it is a route of which the
//! places are known; on a track or another route it is the mission there.
//!
//! The first place is the start, the last one the end. Places closer than 50 m are one.

mod place;
mod table;

use super::route::{self, Points};
use crate::intake::table::error::Fault;
use crate::intake::table::given::{GivenTable, RowPlace};
use crate::intake::table::{Mapping, Source, TableError};
use crate::intake::{FileAccount, Finding};
use crate::number_text::{count_of, rounded};
use arrow_array::{ArrayRef, Float64Array};
use ocmc_core::operating_cycle::drawn_part::Draw;
use ocmc_core::operating_cycle::given::{GivenCycle, PlannedMission};
use ocmc_core::operating_cycle::mission_part::MissionPart;
use ocmc_core::operating_cycle::road::point_event::{EventKind, PointEvent};
use place::{Spot, on_track};
use std::path::PathBuf;
use std::sync::Arc;

pub(super) use table::{is_of_plan, is_one};

/// Places closer than this are one, in m.
const SAME_PLACE_M: f64 = 50.0;
/// Most that the end of a plan and that of its route differ, as a share of the length.
const MOST_APART: f64 = 0.02;
/// Most payload, in kg.
const MOST_KG: f64 = 1.0e5;
const DAY_S: f64 = 86_400.0;
/// A stop plan.
pub(super) struct StopPlan {
    file: PathBuf,
    halts: Vec<Halt>,
    /// Payload at departure, in kg; none where the plan says nothing of cargo.
    payload_kg: Option<f64>,
    departure: PlannedMission,
    has_dwell: bool,
    pub(super) account: FileAccount,
}

/// A place of a plan.
#[derive(Clone, Debug)]
struct Halt {
    row: RowPlace,
    order: f64,
    name: String,
    position_m: Option<f64>,
    leg_m: Option<f64>,
    spot: Option<Spot>,
    altitude_m: Option<f64>,
    dwell_s: f64,
    loaded_kg: Option<f64>,
    unloaded_kg: Option<f64>,
    /// Payload behind it, in kg.
    payload_kg: Option<f64>,
    arrival: String,
    departure: String,
}

impl Halt {
    /// Name in messages.
    fn called(&self) -> String {
        let Self { row, name, .. } = self;
        if name.is_empty() { row.to_string() } else { format!("{row}, {name}") }
    }
}

/// Reads a stop plan that is a route by itself.
pub(super) fn read_alone(
    source: Source,
    mappings: &[Mapping],
    draw: &[Draw],
) -> Result<(GivenCycle, FileAccount), TableError> {
    let mut plan = StopPlan::read(source, mappings)?;
    let places = plan.as_route()?;
    let (mut cycle, route, points) = route::read(Source::Given(&places), &[], draw)?;
    plan.account.extent = route.extent;
    plan.account.findings.extend(route.findings);
    let account = plan.put_on(&mut cycle, points.as_ref())?;
    Ok((cycle, account))
}

impl StopPlan {
    /// The error of the plan.
    fn wrong(&self, text: String) -> TableError {
        TableError::of(&self.file, Fault::OfFormat(text))
    }

    /// The route that the places are, as a table of a route by rows: where the first one is behind
    /// kilometre 0 the route begins there.
    pub(super) fn as_route(&mut self) -> Result<GivenTable, TableError> {
        let known = self.halts.iter().filter(|halt| halt.position_m.is_some()).count();
        let has_spots = self.halts.iter().all(|halt| halt.spot.is_some());
        if known < self.halts.len() && (known > 0 || !has_spots) {
            let without = self.halts.iter().find(|halt| halt.position_m.is_none());
            let called = without.map_or_else(String::new, Halt::called);
            return Err(self.wrong(format!(
                "{called}: no kilometre; say of each place how far it is from the start"
            )));
        }
        let first_m = self.halts.first().and_then(|halt| halt.position_m).unwrap_or(0.0);
        let last_m = self.halts.last().and_then(|halt| halt.position_m).unwrap_or(0.0);
        let begins_before = first_m >= SAME_PLACE_M;
        if begins_before && first_m > last_m - first_m {
            return Err(self.wrong(format!(
                "begins at kilometre {}: is it an odometer's? Count from the start of the trip",
                rounded(first_m / 1000.0)
            )));
        }
        if begins_before {
            let text = format!(
                "the plan begins at kilometre {}: the trip starts at kilometre 0",
                rounded(first_m / 1000.0)
            );
            self.account.findings.push(Finding::noted("stop-plan", [first_m, 0.0], text, ""));
        }
        // places closer together are one: the second one has no row of its own
        let mut rows: Vec<&Halt> = Vec::new();
        for halt in &self.halts {
            let is_same = |before: &&Halt| match (before.position_m, halt.position_m) {
                (Some(a), Some(b)) => (0.0..SAME_PLACE_M).contains(&(b - a)),
                _ => false,
            };
            if !rows.last().is_some_and(is_same) {
                rows.push(halt);
            }
        }
        let mut names = Vec::new();
        let mut columns: Vec<ArrayRef> = Vec::new();
        let mut add = |name: &str, values: Vec<f64>| {
            names.push(name.to_owned());
            columns.push(Arc::new(Float64Array::from(values)));
        };
        if known > 0 {
            let start = begins_before.then_some(0.0);
            let positions = rows.iter().filter_map(|halt| halt.position_m);
            add("position_m", start.into_iter().chain(positions).collect());
        }
        if !begins_before {
            let spots: Option<Vec<Spot>> = rows.iter().map(|halt| halt.spot).collect();
            if let Some(spots) = spots {
                add("latitude_deg", spots.iter().map(|spot| spot.latitude_deg).collect());
                add("longitude_deg", spots.iter().map(|spot| spot.longitude_deg).collect());
            }
            let altitudes: Option<Vec<f64>> = rows.iter().map(|halt| halt.altitude_m).collect();
            if let Some(altitudes_m) = altitudes {
                add("altitude_m", altitudes_m);
            }
        }
        Ok(GivenTable::new(&self.file.display().to_string(), names, vec![columns]))
    }

    /// Puts the mission on a road. `points`: the points of the road, where it has coordinates.
    pub(super) fn put_on(
        mut self,
        cycle: &mut GivenCycle,
        points: Option<&Points>,
    ) -> Result<FileAccount, TableError> {
        let mut positions = self.positions(points)?;
        if let Some(last_m) = positions.last_mut()
            && (*last_m - cycle.length_m).abs() <= MOST_APART * cycle.length_m
        {
            *last_m = cycle.length_m;
        }
        for (k, position_m) in positions.iter().enumerate() {
            let before_m = if k > 0 { positions[k - 1] } else { 0.0 };
            if *position_m > cycle.length_m || *position_m < before_m {
                let (km, before_km) = (position_m / 1000.0, before_m / 1000.0);
                return Err(self.wrong(format!(
                    "{}: kilometre {}; allowed is {} to {}, from the place before it to the end \
                     of the route",
                    self.halts[k].called(),
                    rounded(km),
                    rounded(before_km),
                    rounded(cycle.length_m / 1000.0)
                )));
            }
        }
        // the trip begins before its first place: when, that place does not tell
        if positions.first().is_some_and(|first_m| *first_m >= SAME_PLACE_M) {
            self.departure.departure_s = None;
        }
        self.load()?;
        let payload_kg = self.payload_kg;
        cycle.events.retain(|event| !matches!(event.kind, EventKind::MissionStop { .. }));
        cycle.parts.clear();
        let mut stops: Vec<PointEvent> = Vec::new();
        let mut at_start_kg = payload_kg;
        for (halt, &position_m) in self.halts.iter().zip(&positions) {
            let changes =
                halt.loaded_kg.unwrap_or(0.0) > 0.0 || halt.unloaded_kg.unwrap_or(0.0) > 0.0;
            if position_m < SAME_PLACE_M {
                at_start_kg = halt.payload_kg.or(at_start_kg);
                continue;
            }
            if position_m > cycle.length_m - SAME_PLACE_M {
                continue;
            }
            if halt.dwell_s == 0.0 && !changes && self.has_dwell {
                continue;
            }
            let before = stops.last_mut();
            if let Some(before) = before.filter(|last| position_m - last.position_m < SAME_PLACE_M)
            {
                let standstill_s = before.kind.standstill_s().unwrap_or(0.0) + halt.dwell_s;
                before.kind = EventKind::MissionStop { standstill_s };
            } else {
                let kind = EventKind::MissionStop { standstill_s: halt.dwell_s };
                stops.push(PointEvent { position_m, kind, turns: false });
            }
            if let Some((payload_kg, stop)) = halt.payload_kg.zip(stops.last()) {
                let start_m = stop.position_m;
                cycle.parts.retain(|part| part.start_m != start_m);
                cycle.parts.push(MissionPart { start_m, payload_kg, ..MissionPart::default() });
            }
        }
        self.tell(&stops, at_start_kg);
        cycle.payload_kg = at_start_kg;
        cycle.planned = Some(self.departure);
        cycle.events.extend(stops);
        cycle.events.sort_by(|a, b| a.position_m.total_cmp(&b.position_m));
        Ok(self.account)
    }

    /// Where the places are along the road, in m.
    fn positions(&mut self, points: Option<&Points>) -> Result<Vec<f64>, TableError> {
        let known: Option<Vec<f64>> = self.halts.iter().map(|halt| halt.position_m).collect();
        if let Some(known) = known {
            return Ok(known);
        }
        let spots: Option<Vec<Spot>> = self.halts.iter().map(|halt| halt.spot).collect();
        let (Some(spots), Some(points)) = (spots, points) else {
            return Err(self.wrong(
                "has places without a kilometre, and they or the route have no coordinates: give \
                 each place its kilometre from the start"
                    .to_owned(),
            ));
        };
        let called = |k: usize| self.halts[k].called();
        let (positions, finding) =
            on_track(&spots, points, called).map_err(|text| self.wrong(text))?;
        self.account.findings.extend(finding);
        Ok(positions)
    }

    /// Payload behind each place, where the plan says something of cargo.
    fn load(&mut self) -> Result<(), TableError> {
        if self.halts.iter().any(|halt| halt.payload_kg.is_some()) {
            let mut payload_kg = self.halts.iter().find_map(|halt| halt.payload_kg);
            self.payload_kg = payload_kg;
            for halt in &mut self.halts {
                payload_kg = halt.payload_kg.or(payload_kg);
                halt.payload_kg = payload_kg;
            }
            return Ok(());
        }
        let says = |halt: &Halt| halt.loaded_kg.is_some() || halt.unloaded_kg.is_some();
        if !self.halts.iter().any(says) {
            return Ok(());
        }
        let change = |halt: &Halt| halt.loaded_kg.unwrap_or(0.0) - halt.unloaded_kg.unwrap_or(0.0);
        let mut sum_kg = 0.0;
        let lowest_kg = self.halts.iter().fold(0.0, |lowest: f64, halt| {
            sum_kg += change(halt);
            lowest.min(sum_kg)
        });
        let at_start_kg = -lowest_kg;
        let loads_first =
            self.halts.first().is_some_and(|halt| halt.loaded_kg.unwrap_or(0.0) > 0.0);
        // what rounding leaves is nothing
        if loads_first && at_start_kg > 0.5 {
            return Err(self.wrong(format!(
                "unloads {} kg more than has been loaded: correct a number, or leave the load of \
                 the first place empty, and it is what is unloaded behind it",
                rounded(at_start_kg)
            )));
        }
        let mut payload_kg = if loads_first { 0.0 } else { at_start_kg };
        self.payload_kg = Some(payload_kg);
        for k in 0..self.halts.len() {
            payload_kg = (payload_kg + change(&self.halts[k])).max(0.0);
            if payload_kg > MOST_KG {
                return Err(self.wrong(format!(
                    "{}: {} kg on board; allowed is 0 to {}",
                    self.halts[k].called(),
                    rounded(payload_kg),
                    rounded(MOST_KG)
                )));
            }
            self.halts[k].payload_kg = Some(payload_kg);
        }
        if !loads_first && at_start_kg > 0.0 {
            let text = format!(
                "nothing is loaded at the first place: {} kg are on board at departure, all that \
                 is unloaded before it is loaded",
                rounded(at_start_kg)
            );
            self.account.findings.push(Finding::noted(
                "stop-plan-load",
                [at_start_kg, 0.0],
                text,
                "",
            ));
        }
        Ok(())
    }

    /// Says what the mission is.
    fn tell(&mut self, stops: &[PointEvent], at_start_kg: Option<f64>) {
        let dwell_s: f64 = stops.iter().filter_map(|stop| stop.kind.standstill_s()).sum();
        let mut parts = vec![format!(
            "{} between start and end, {} min of standing",
            count_of(stops.len() as u64, "stop"),
            rounded(dwell_s / 60.0)
        )];
        parts.push(match at_start_kg {
            Some(payload_kg) => format!("{} kg on board at departure", rounded(payload_kg)),
            None => "payload drawn from the study".to_owned(),
        });
        parts.push(match self.departure.departure_s {
            Some(at_s) => {
                let minutes = (at_s / 60.0).round();
                format!("departure at {:02}:{:02}", (minutes / 60.0).floor() % 24.0, minutes % 60.0)
            }
            None => "departure drawn from the study".to_owned(),
        });
        let text = format!("a stop plan: {}", parts.join(", "));
        let figures = [stops.len() as f64, 0.0];
        self.account.findings.push(Finding::noted("stop-plan", figures, text, ""));
        let at_once = stops.iter().filter(|stop| stop.kind.standstill_s() == Some(0.0)).count();
        if at_once > 0 {
            let text = format!(
                "no dwell at {}: the truck stops there and drives on at once",
                count_of(at_once as u64, "place")
            );
            let remedy = "add a column `dwell_min`";
            let figures = [at_once as f64, 0.0];
            self.account.findings.push(Finding::warned("stop-plan-dwell", figures, text, remedy));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const GERMAN: &str = "Reihenfolge;Ort;Kilometer [km];Standzeit [min];Beladung [kg];Entladung \
                          [kg];Abfahrt\n\
                          2;Kunde A;38,5;25;;4000;\n\
                          1;Depot;0;;12400;;2024-03-04 06:30\n\
                          3;Kunde B;61,2;40;;5400;\n\
                          4;Kunde C;90;30;1000;3000;\n\
                          5;Depot;142,7;;;1000;\n";

    fn read(text: &str) -> Result<(GivenCycle, FileAccount), TableError> {
        read_alone(Source::Text(Path::new("p.csv"), text), &[], &Draw::ALL)
    }

    fn refused(text: &str) -> String {
        read(text).map(|_| ()).unwrap_err().to_string()
    }

    /// Positions and dwells of the stops.
    fn stops(cycle: &GivenCycle) -> Vec<(f64, f64)> {
        let stop = |event: &PointEvent| match event.kind {
            EventKind::MissionStop { standstill_s } => Some((event.position_m, standstill_s)),
            _ => None,
        };
        cycle.events.iter().filter_map(stop).collect()
    }

    fn loads(cycle: &GivenCycle) -> Vec<f64> {
        cycle.parts.iter().map(|part| part.payload_kg).collect()
    }

    #[test]
    fn a_spreadsheet_becomes_a_mission_and_a_route() {
        let (cycle, account) = read(GERMAN).unwrap();
        assert_eq!(cycle.length_m, 142_700.0);
        assert_eq!(stops(&cycle), [(38_500.0, 1500.0), (61_200.0, 2400.0), (90_000.0, 1800.0)]);
        assert_eq!(
            (cycle.payload_kg, loads(&cycle)),
            (Some(12_400.0), vec![8400.0, 3000.0, 1000.0])
        );
        // 4 March is the 63rd day of a year without a leap day, counted from 1
        let planned = PlannedMission { departure_s: Some(23_400.0), day_of_year: Some(62.0) };
        assert_eq!(cycle.planned, Some(planned));
        assert!(cycle.limits.is_empty() && cycle.lacks_curves);
        let told = account.told().join("\n");
        for words in ["3 stops", "95.00 min of standing", "12,400 kg", "departure at 06:30"] {
            assert!(told.contains(words), "{told}");
        }
    }

    #[test]
    fn ways_from_place_to_place_and_times_of_arrival_and_departure() {
        let (cycle, _) = read(
            "place,leg_km,arrival,departure\nDepot,,,23:10\nA,38.5,23:55,00:20\nB,22.7,1:00,1:40\n\
             Depot,52,2:30,\n",
        )
        .unwrap();
        assert_eq!(cycle.length_m, 113_200.0);
        let wanted = [(38_500.0, 1500.0), (61_200.0, 2400.0)];
        for (stop, wanted) in stops(&cycle).iter().zip(wanted) {
            assert!((stop.0 - wanted.0).abs() < 1e-6 && stop.1 == wanted.1, "{stop:?}");
        }
        assert_eq!((cycle.payload_kg, cycle.parts.len()), (None, 0));
        assert_eq!(cycle.planned.and_then(|planned| planned.departure_s), Some(83_400.0));
        let (cycle, _) =
            read("place,km,dwell_min\nA,0,\nB,20,1:30\nC,40,00:25:00\nD,60,\n").unwrap();
        assert_eq!(stops(&cycle), [(20_000.0, 5400.0), (40_000.0, 1500.0)]);
    }

    #[test]
    fn a_sheet_with_title_town_and_address_is_one() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("tour.csv");
        let text = "Nr,Ort,Adresse,Kilometer,Standzeit [min],Entladung [t],Ankunft,Abfahrt\n\
                    1,Depot,Hannover,0,,,,06:30:00\n2,Kunde A,Celle,38.5,25,4,07:20,07:45\n\
                    3,Depot,Hannover,80,,,08:45,\n";
        std::fs::write(&file, text).unwrap();
        assert!(is_one(Source::File(&file), &[]));
        let (cycle, account) = read(text).unwrap();
        assert_eq!((stops(&cycle), cycle.payload_kg), (vec![(38_500.0, 1500.0)], Some(4000.0)));
        assert!(account.told()[0].contains("`Ort` as place"), "{account:?}");
        // routes by rows, and tracks, are none
        for names in ["position_m,speed_limit_kmh,stop_s", "lat,lon,altitude_m", "track,rule"] {
            std::fs::write(&file, format!("{names}\n")).unwrap();
            assert!(!is_one(Source::File(&file), &[]), "{names}");
        }
    }

    #[test]
    fn what_is_unloaded_was_on_board() {
        let rows = "place,km,dwell_min,unload_t\nDepot,0,,\nA,10,5,2\nB,20,5,1.5\nC,30,,\n";
        let (cycle, account) = read(rows).unwrap();
        assert_eq!((cycle.payload_kg, loads(&cycle)), (Some(3500.0), vec![1500.0, 0.0]));
        let told = account.told().join("\n");
        assert!(told.contains("3,500 kg are on board at departure"), "{told}");
        let text = "place,km,dwell_min,load_t,unload_t\nDepot,0,,1,\nA,10,5,,2\nB,20,5,,1.5\n";
        let fault = refused(text);
        assert!(fault.contains("unloads 2,500 kg more than has been loaded"), "{fault}");
        // payloads that are said hold to the next one
        let (cycle, _) =
            read("place,km,dwell_min,payload_t\nA,0,,8\nB,10,5,\nC,20,5,3\nD,30,,\n").unwrap();
        assert_eq!((cycle.payload_kg, loads(&cycle)), (Some(8000.0), vec![8000.0, 3000.0]));
    }

    #[test]
    fn places_at_one_gate_are_one_stop_and_a_place_without_dwell_is_passed() {
        let (cycle, _) = read(
            "place,km,dwell_min,unload_kg\nDepot,0,20,\nA,10,5,100\nB,10.02,7,200\nVia,15,,\n\
             C,20,,300\n\
             Depot,30,60,\n",
        )
        .unwrap();
        assert_eq!(stops(&cycle), [(10_000.0, 720.0), (20_000.0, 0.0)]);
        assert_eq!((cycle.payload_kg, loads(&cycle)), (Some(600.0), vec![300.0, 0.0]));
        let (cycle, account) = read("Ort;Kilometer\nA;0\nB;20,5\nC;61\n").unwrap();
        assert_eq!(stops(&cycle), [(20_500.0, 0.0)]);
        assert!(account.warnings()[0].contains("no dwell at 1 place"), "{account:?}");
    }

    #[test]
    fn a_plan_that_begins_on_the_way_starts_at_kilometre_0() {
        let (cycle, account) =
            read("place,km,dwell_min,departure\nA,12,5,07:30\nB,30,5,\nC,50,,\n").unwrap();
        // that is when it leaves A
        assert_eq!(cycle.planned.and_then(|planned| planned.departure_s), None);
        assert_eq!((cycle.length_m, stops(&cycle).len()), (50_000.0, 2));
        assert!(account.told().join("\n").contains("begins at kilometre 12"), "{account:?}");
        let fault = refused("place,km,dwell_min\nA,81200,5\nB,81230,5\n");
        assert!(fault.contains("is it an odometer's"), "{fault}");
    }

    #[test]
    fn what_is_wrong_is_said_with_its_place() {
        for (text, message) in [
            ("place,dwell_min\nA,5\nB,5\n", "no column for the place: name it `position_km`"),
            ("place,km,dwell\nA,0,5\nB,9,5\n", "(`dwell` has no known unit): name it `dwell_s`"),
            ("order,km,dwell_min\n1,0,\n1,9,5\n", "the order 1 twice, in line 2 and line 3"),
            ("place,km,dwell_min\nA,0,\nB,9,5\nC,7,\n", "does not lie behind the one before it"),
            ("place,km,dwell_min,departure\nA,0,,soon\nB,9,5,\n", "line 2, A: `soon` is no time"),
            ("place,km,dwell_min\nA,0,\nB,,5\nC,9,\n", "line 3, B: no kilometre"),
            ("place,km,dwell_min\nA,0,\nB,9,-5\nC,19,\n", "column `dwell_min`: `-5`; allowed is 0"),
            ("place,km,load_t\nA,0,60\nB,5,60\nC,9,\n", "line 3, B: 120,000 kg on board"),
        ] {
            let fault = refused(text);
            assert!(fault.contains(message), "{fault}");
        }
    }
}
