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
