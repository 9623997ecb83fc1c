//! Stop signs, give ways, lights and bumps of each road type of the default study, before events
//! are spaced out.

use crate::common::field_truck_model;
use crate::common::statistics::{SEEDS, assert_count, assert_follows, assert_share};
use ocmc_core::operating_cycle::road::RoadTypeModel;
use ocmc_core::operating_cycle::road::point_event::{EventKind, PointEvent};
use ocmc_core::operating_cycle::road::road_type::Section;
use ocmc_core::random::{Draws, Stream};
use statrs::distribution::{ContinuousCDF, Exp};

/// Mean number of events that a test draws.
const EVENTS: f64 = 5000.0;

/// Draws the events of one kind on a section that is long enough, and checks their number and gaps.
fn events(
    what: &str,
    per_m: f64,
    seed: u64,
    sample: impl FnOnce(&Section, &mut Draws, &mut Vec<PointEvent>),
) -> Vec<PointEvent> {
    let end_m = if per_m > 0.0 { EVENTS / per_m } else { 1.0e8 };
    let section = Section { start_m: 1000.0, end_m: 1000.0 + end_m, road_type: 0 };
    let mut events = Vec::new();
    sample(&section, &mut Draws::new(seed, 7, Stream::StopSign), &mut events);
    assert_count(what, events.len(), per_m * end_m);
    assert!(events.iter().all(|e| (1000.0..section.end_m).contains(&e.position_m)));
    if per_m > 0.0 {
        // given their number, the places are uniform
        let places: Vec<f64> = events.iter().map(|e| e.position_m).collect();
        assert_follows(what, places.clone(), |x| (x - 1000.0) / end_m);
        let gap = Exp::new(per_m).unwrap();
        let gaps = places.windows(2).map(|p| p[1] - p[0]).collect();
        assert_follows(what, gaps, |x| gap.cdf(x));
    }
    events
}

fn uniform(lower: f64, upper: f64) -> impl Fn(f64) -> f64 {
    move |x| ((x - lower) / (upper - lower)).clamp(0.0, 1.0)
}

fn assert_turns(what: &str, events: &[PointEvent], share: f64) {
    let turns = events.iter().filter(|e| e.turns).count();
    assert_share(what, turns, events.len(), share);
}

/// Road types with the events per km of the guide: stop, give way, light, bump.
fn types() -> Vec<(RoadTypeModel, [f64; 4])> {
    let types = field_truck_model().road.types;
    [("urban", [0.15, 0.5, 1.0, 0.4]), ("rural", [0.03, 0.08, 0.03, 0.02]), ("motorway", [0.0; 4])]
        .map(|(name, per_km)| (types[name].clone(), per_km))
        .to_vec()
}

#[test]
fn stop_signs() {
    for (model, [per_km, ..]) in types() {
        for seed in SEEDS {
            let drawn = events("stop signs", per_km / 1000.0, seed, |section, draws, events| {
                model.stop_signs.sample(section, draws, events);
            });
            if per_km > 0.0 {
                let waits = drawn.iter().filter_map(|e| e.kind.standstill_s()).collect();
                assert_follows("standstill", waits, uniform(2.0, 8.0));
                assert_turns("turns at stop signs", &drawn, 0.5);
            }
        }
    }
}

#[test]
fn give_ways() {
    let wait = Exp::new(1.0 / 6.0).unwrap();
    for (model, [_, per_km, ..]) in types() {
        for seed in SEEDS {
            let drawn = events("give ways", per_km / 1000.0, seed, |section, draws, events| {
                model.give_ways.sample(section, draws, events);
            });
            if per_km > 0.0 {
                let waits: Vec<f64> = drawn.iter().filter_map(|e| e.kind.standstill_s()).collect();
                assert_share("stops", waits.len(), drawn.len(), 0.3);
                assert_follows("wait", waits, |x| wait.cdf(x));
                let speeds = drawn
                    .iter()
                    .filter_map(|e| match e.kind {
                        EventKind::GiveWayPass { speed_mps } => Some(speed_mps),
                        _ => None,
                    })
                    .collect();
                assert_follows("passing speed", speeds, uniform(20.0 / 3.6, 25.0 / 3.6));
                assert_turns("turns at give ways", &drawn, 1.0);
            }
        }
    }
}

#[test]
fn traffic_lights() {
    for (model, [_, _, per_km, _]) in types() {
        for seed in SEEDS {
            let drawn = events("lights", per_km / 1000.0, seed, |section, draws, events| {
                model.traffic_lights.sample(section, draws, events);
            });
            if per_km > 0.0 {
                let waits: Vec<f64> = drawn.iter().filter_map(|e| e.kind.standstill_s()).collect();
                assert_share("red", waits.len(), drawn.len(), 0.45);
                assert_follows("wait", waits, uniform(0.0, 40.0));
                assert_turns("turns at lights", &drawn, 0.25);
            }
        }
    }
}

#[test]
fn speed_bumps() {
    for (model, [.., per_km]) in types() {
        for seed in SEEDS {
            let drawn = events("bumps", per_km / 1000.0, seed, |section, draws, events| {
                model.speed_bumps.sample(section, draws, events);
            });
            let (lengths, heights): (Vec<f64>, Vec<f64>) = drawn
                .iter()
                .map(|e| match e.kind {
                    EventKind::SpeedBump { length_m, height_m } => (length_m, height_m),
                    _ => panic!("a bump"),
                })
                .unzip();
            if per_km > 0.0 {
                assert_follows("length", lengths, uniform(3.0, 5.0));
                assert_follows("height", heights, uniform(0.075, 0.1));
                assert_turns("turns at bumps", &drawn, 0.0);
            }
        }
    }
}
