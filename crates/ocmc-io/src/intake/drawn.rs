//! Parts of a route that are drawn from the study: which of them, and which are asked for in vain.

use super::Finding;
use crate::number_text::count_of;
use ocmc_core::operating_cycle::drawn_part::{Draw, lacking};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::road::point_event::KINDS;

const NAME: &str = "drawn";

/// Says what of a cycle is drawn, where that is asked for.
pub fn told(cycle: &GivenCycle, draw: &[Draw]) -> Option<Finding> {
    let lacking = lacking(cycle);
    let named = |is_lacking: bool| -> Vec<&str> {
        let asked = Draw::ALL.into_iter().filter(|part| draw.contains(part));
        asked.filter(|part| lacking.contains(part) == is_lacking).map(Draw::name).collect()
    };
    let (drawn, own) = (named(true), named(false));
    let mut texts = Vec::new();
    if !drawn.is_empty() {
        texts.push(format!(
            "{}: drawn from the study's laws of each road type, anew in each cycle",
            drawn.join(", ")
        ));
        if cycle.road_types.is_none() {
            let by = if cycle.limits.is_empty() { "by their chain" } else { "given its limits" };
            texts.push(format!("its road types are drawn, too, {by}"));
        }
    }
    if draw.contains(&Draw::Stops) {
        let is_given = |object: &str| {
            let kind = KINDS.into_iter().find(|kind| kind.map_object == object);
            let of_kind =
                |kind: &ocmc_core::operating_cycle::road::point_event::EventDeclaration| {
                    cycle.events.iter().any(|event| kind.includes(&event.kind))
                };
            kind.is_some_and(of_kind) || cycle.open_places.iter().any(|place| place.1 == object)
        };
        let objects = KINDS.iter().map(|kind| kind.map_object);
        let given: Vec<&str> = objects.filter(|object| is_given(object)).collect();
        if !given.is_empty() {
            texts.push(format!("of stops it has its own {}, and no others", given.join(", ")));
        }
        if !cycle.open_places.is_empty() {
            let places = count_of(cycle.open_places.len() as u64, "place");
            texts.push(format!("what happens at {places} of objects is drawn"));
        }
    }
    if !own.is_empty() {
        texts.push(format!("{}: not drawn, it has its own", own.join(", ")));
    }
    let figures = [drawn.len() as f64, 0.0];
    (!texts.is_empty()).then(|| Finding::noted(NAME, figures, texts.join("; "), ""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_drawn_and_what_is_not_is_said() {
        let cycle = GivenCycle {
            length_m: 1000.0,
            limits: vec![(0.0, 20.0)],
            lacks_curves: true,
            open_places: vec![(500.0, "traffic_light")],
            ..GivenCycle::default()
        };
        assert_eq!(told(&cycle, &[]), None);
        let text = told(&cycle, &Draw::ALL).map(|finding| finding.text).unwrap();
        for words in [
            "stops, hills, curves: drawn from the study's laws of each road type",
            "road types are drawn, too, given its limits",
            "its own traffic_light",
            "at 1 place of objects",
            "limits: not drawn, it has its own",
        ] {
            assert!(text.contains(words), "{text}");
        }
        let whole = GivenCycle { has_slopes: true, lacks_curves: false, ..cycle };
        let text = told(&whole, &[Draw::Hills, Draw::Curves]).map(|finding| finding.text);
        assert_eq!(text.as_deref(), Some("hills, curves: not drawn, it has its own"));
    }
}
