//! Objects of a map that a route by rows has: traffic lights, stop signs and others, with the
//! standstill there, or without one where it is only known that they are there.

use ocmc_core::operating_cycle::given::{GivenCycle, GivenCycleError};
use ocmc_core::operating_cycle::road::point_event::{KINDS, PointEvent};

/// The objects of a route, and the standstills that belong to none of them.
pub(super) struct Objects {
    events: Vec<PointEvent>,
    open: Vec<(f64, &'static str)>,
    /// Standstills of the rows, in s; 0 where an object explains it.
    pub(super) other_stop_s: Vec<f64>,
}

impl Objects {
    /// Reads the columns of a route, each of them empty where it is not there.
    pub(super) fn of(
        position_m: &[f64],
        map_object: &[String],
        stop_s: &[f64],
    ) -> Result<Self, GivenCycleError> {
        let mut objects =
            Self { events: Vec::new(), open: Vec::new(), other_stop_s: stop_s.to_vec() };
        for (k, word) in map_object.iter().enumerate().filter(|(_, word)| !word.is_empty()) {
            let position_m = position_m[k];
            let kind = KINDS.into_iter().find(|kind| kind.map_object == word);
            let kind = kind.ok_or_else(|| GivenCycleError::Word {
                track: "map_object".to_owned(),
                position_m,
                value: word.clone(),
                allowed: KINDS.map(|kind| kind.map_object).join(", "),
            })?;
            match objects.other_stop_s.get_mut(k).filter(|stop_s| kind.stops && **stop_s > 0.0) {
                Some(stop_s) => {
                    let kind = (kind.of_log)(Some(std::mem::take(stop_s)), f64::NAN);
                    objects.events.push(PointEvent { position_m, kind, turns: false });
                }
                None => objects.open.push((position_m, kind.map_object)),
            }
        }
        Ok(objects)
    }

    /// Puts them on a road; a vehicle starts and ends at rest.
    pub(super) fn put_into(self, cycle: &mut GivenCycle) {
        if self.events.is_empty() && self.open.is_empty() {
            return;
        }
        let is_between = |at_m: f64| at_m > 0.0 && at_m < cycle.length_m;
        cycle.events.extend(self.events.into_iter().filter(|event| is_between(event.position_m)));
        cycle.events.sort_by(|a, b| a.position_m.total_cmp(&b.position_m));
        cycle.open_places = self.open.into_iter().filter(|place| is_between(place.0)).collect();
    }
}

#[cfg(test)]
mod tests {
    use crate::given_cycle::route::read;
    use crate::intake::table::{Source, TableError};
    use ocmc_core::operating_cycle::drawn_part::Draw;
    use ocmc_core::operating_cycle::given::GivenCycle;
    use ocmc_core::operating_cycle::road::point_event::EventKind;
    use std::path::Path;

    fn parse(text: &str, draw: &[Draw]) -> Result<GivenCycle, TableError> {
        read(Source::Text(Path::new("r.csv"), text), &[], draw).map(|(cycle, ..)| cycle)
    }

    #[test]
    fn objects_have_their_standstills_or_none() {
        let text = "position_m,speed_limit_kmh,stop_s,map_object\n0,50,,stop_sign\n\
                    100,50,12,traffic_light\n200,50,,traffic_light\n300,50,9,\n\
                    400,50,5,speed_bump\n500,50,60,mission_stop\n600,50,,\n";
        let cycle = parse(text, &[]).unwrap();
        let kinds: Vec<(f64, EventKind)> =
            cycle.events.iter().map(|event| (event.position_m, event.kind)).collect();
        let wanted = [
            (100.0, EventKind::RedLight { standstill_s: 12.0 }),
            (300.0, EventKind::StopSign { standstill_s: 9.0 }),
            // nobody stops for a bump: a stop line beside it
            (400.0, EventKind::StopSign { standstill_s: 5.0 }),
            (500.0, EventKind::MissionStop { standstill_s: 60.0 }),
        ];
        assert_eq!(kinds, wanted);
        assert_eq!(cycle.open_places, [(200.0, "traffic_light"), (400.0, "speed_bump")]);
        let fault = parse(&text.replace(",speed_bump", ",gate"), &[]).unwrap_err().to_string();
        assert!(fault.contains("`gate`") && fault.contains("railway_crossing"), "{fault}");
    }

    #[test]
    fn a_plan_of_places_needs_no_limits_where_they_are_drawn() {
        let plan = "position_m\n0\n62000\n";
        let fault = parse(plan, &[Draw::Stops]).unwrap_err();
        assert!(fault.to_string().contains("speed limit"), "{fault}");
        assert!(fault.help().is_some_and(|help| help.contains("--draw limits")), "{fault:?}");
        let cycle = parse(plan, &Draw::ALL).unwrap();
        assert!(cycle.limits.is_empty() && cycle.lacks_curves && cycle.length_m == 62_000.0);
        // places far apart, with the way between them: no curves, and no beelines
        let places = "lat,lon,position_m\n52.0,9.0,0\n52.1,9.1,17000\n52.3,9.1,42000\n\
                      52.3,9.5,76000\n52.6,9.4,115000\n52.9,9.4,152000\n53.0,9.9,190000\n";
        let cycle = parse(places, &Draw::ALL).unwrap();
        assert!(cycle.lacks_curves && cycle.curves.is_empty() && cycle.length_m == 190_000.0);
        assert!(cycle.heading_rad.is_some());
        let without_way: String = places
            .lines()
            .map(|line| line.rsplit_once(',').map_or(line, |parts| parts.0).to_owned() + "\n")
            .collect();
        let fault = parse(&without_way, &Draw::ALL).unwrap_err().to_string();
        assert!(fault.contains("beelines") && fault.contains("position_m"), "{fault}");
    }
}
