//! Parts that a route lacks and has drawn: what is given stays, and what is drawn is the study's.

use crate::common::field_truck;
use crate::common::statistics::SEEDS;
use ocmc_core::operating_cycle::drawn_part::Draw;
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::road::point_event::{EventKind, PointEvent};
use ocmc_core::operating_cycle::road::road_type::Section;
use ocmc_core::operating_cycle::road::surface::Ground;
use ocmc_core::operating_cycle::road::{Road, RoadSampler};
use ocmc_core::random::Streams;
use ocmc_core::study::Study;

const LENGTH_M: f64 = 100_000.0;

/// A route of which nothing is known but its length.
fn bare() -> GivenCycle {
    GivenCycle { length_m: LENGTH_M, lacks_curves: true, ..GivenCycle::default() }
}

fn study() -> Study {
    field_truck(|_| ())
}

fn on(cycle: GivenCycle, draw: &[Draw]) -> Study {
    study().with_routes(vec![(cycle, 1.0, Vec::new(), draw.to_vec())]).unwrap()
}

fn refusal(cycle: GivenCycle, draw: &[Draw]) -> String {
    let refused = study().with_routes(vec![(cycle, 1.0, Vec::new(), draw.to_vec())]);
    refused.unwrap_err().1.to_string()
}

/// A road, without saying which route it is.
fn road(study: &Study, cycle_id: u64) -> Road {
    Road { route: None, ..study.sample(1, cycle_id).cycle.road }
}

/// Known parts of a drawn road, where others are lacking.
fn given(road: &Road, names: &[String]) -> GivenCycle {
    let types = road.sections.iter().map(|s| (s.start_m, names[s.road_type].clone()));
    let limits = road.signs.iter().map(|sign| (sign.start_m, sign.speed_mps)).collect();
    GivenCycle { road_types: Some(types.collect()), limits, ..bare() }
}

fn text(value: &impl std::fmt::Debug) -> String {
    format!("{value:?}")
}

#[test]
fn a_route_of_which_nothing_is_known_is_the_road_of_the_study() {
    let (own, drawn) = (study(), on(bare(), &Draw::ALL));
    for cycle_id in 0..20 {
        assert_eq!(text(&road(&own, cycle_id)), text(&road(&drawn, cycle_id)), "{cycle_id}");
        // and so is what is expected of it
        let (a, b) = (own.outline(1, cycle_id), drawn.outline(1, cycle_id));
        assert_eq!(a, b, "{cycle_id}");
    }
}

#[test]
fn drawn_parts_are_those_of_the_studys_streams() {
    let own = study();
    for cycle_id in 0..10 {
        let whole = road(&own, cycle_id);
        let draw = [Draw::Stops, Draw::Hills, Draw::Curves];
        let drawn = road(&on(given(&whole, own.road_types()), &draw), cycle_id);
        assert_eq!(text(&whole), text(&drawn), "{cycle_id}");
        // one part alone is the same one; what is neither given nor drawn is absent
        let hills = road(&on(given(&whole, own.road_types()), &[Draw::Hills]), cycle_id);
        assert_eq!(hills.slopes, whole.slopes);
        assert!(hills.events.is_empty() && hills.curves.is_empty());
        // without the types, and without any road type in doubt, too
        let named = GivenCycle { limits: Vec::new(), ..given(&whole, own.road_types()) };
        let signed = road(&on(named, &[Draw::Limits]), cycle_id);
        assert_eq!((signed.signs, signed.sections), (whole.signs, whole.sections));
    }
}

#[test]
fn slopes_between_known_altitudes_meet_them() {
    // dense up to 1 km, then far apart, at the steps' places and between them
    let mut altitude: Vec<(f64, f64)> =
        (0..=40_u32).map(|k| (25.0 * f64::from(k), 0.02 * f64::from(k * k % 50))).collect();
    let far = [(2000.0, 12.0), (2500.0, 14.0), (3333.3, 30.0), (4017.0, 25.0), (9000.0, 25.0)];
    altitude.extend(far);
    altitude.push((9100.0, 27.0));
    // too steep for the limits of slopes
    altitude.push((9400.0, 63.0));
    let cycle = GivenCycle { altitude, limits: vec![(0.0, 20.0)], ..bare() };
    let cycle = GivenCycle { length_m: 20_000.0, ..cycle };
    let (drawn, known) = (on(cycle.clone(), &[Draw::Hills]), on(cycle, &[]));
    let mut slopes: Vec<f64> = Vec::new();
    for cycle_id in 0..20 {
        let (road, linear) = (road(&drawn, cycle_id), road(&known, cycle_id));
        assert_eq!(road.slopes[..40], linear.slopes[..40], "close altitudes are taken as they are");
        let start = (1000.0, 0.02 * f64::from(40 * 40 % 50));
        for pair in [&[start][..], &far].concat().windows(2) {
            let climb_m = road.climb_m([pair[0].0, pair[1].0]);
            assert!(
                (climb_m - (pair[1].1 - pair[0].1)).abs() < 1e-6,
                "{cycle_id} {pair:?} {climb_m}"
            );
        }
        assert!((road.climb_m([9100.0, 9400.0]) - 36.0).abs() < 1e-6);
        let steep = &road.slopes[364..376];
        assert!(steep.iter().all(|slope| (slope - 0.12).abs() < 1e-9), "evenly: {steep:?}");
        slopes.push(road.slopes[60]);
    }
    slopes.sort_by(f64::total_cmp);
    slopes.dedup();
    assert_eq!(slopes.len(), 20, "anew in each cycle");
}

#[test]
fn given_events_stay_and_push_others_away() {
    let event = |position_m, kind| PointEvent { position_m, kind, turns: false };
    let stop = EventKind::StopSign { standstill_s: 7.0 };
    // within the free ends, too
    let events: Vec<PointEvent> =
        (0..200).map(|k| event(10.0 + 250.0 * f64::from(k), stop)).collect();
    let cycle = GivenCycle { events: events.clone(), limits: vec![(0.0, 13.9)], ..bare() };
    let study = on(cycle, &[Draw::Stops]);
    let spacing_m = study.model().road.event_spacing_m;
    let mut others = 0;
    for cycle_id in 0..10 {
        let road = road(&study, cycle_id);
        let is_given = |event: &&PointEvent| matches!(event.kind, EventKind::StopSign { .. });
        let kept: Vec<PointEvent> = road.events.iter().filter(is_given).copied().collect();
        assert_eq!(kept, events, "those of the file, and no other stop signs");
        for pair in road.events.windows(2) {
            let apart_m = pair[1].position_m - pair[0].position_m;
            assert!(apart_m >= spacing_m, "{pair:?}");
        }
        others += road.events.len() - kept.len();
    }
    assert!(others > 50, "{others}");
}

#[test]
fn what_happens_at_known_places_is_drawn() {
    let places: Vec<(f64, &'static str)> =
        (1..100).map(|k| (500.0 * f64::from(k), "traffic_light")).collect();
    let cycle = GivenCycle { open_places: places.clone(), limits: vec![(0.0, 13.9)], ..bare() };
    let message = refusal(cycle.clone(), &[Draw::Hills]);
    assert!(message.contains("`traffic_light` at 500 m") && message.contains("--draw stops"));
    let study = on(cycle, &[Draw::Stops]);
    let (mut red, mut all) = (0.0, 0.0);
    for cycle_id in 0..40 {
        let road = road(&study, cycle_id);
        let is_red = |event: &PointEvent| matches!(event.kind, EventKind::RedLight { .. });
        let lights: Vec<&PointEvent> =
            road.events.iter().filter(|e| is_red(e) || e.kind == EventKind::GreenLight).collect();
        let at_m: Vec<f64> = lights.iter().map(|light| light.position_m).collect();
        assert_eq!(at_m, places.iter().map(|place| place.0).collect::<Vec<_>>());
        red += lights.iter().filter(|light| is_red(light)).count() as f64;
        all += lights.len() as f64;
    }
    // the same law on each road type
    let error = (0.45 * 0.55 / all).sqrt();
    assert!((red / all - 0.45).abs() < 4.0 * error, "{red} of {all}");
    let stop = GivenCycle {
        open_places: vec![(500.0, "mission_stop")],
        limits: vec![(0.0, 13.9)],
        ..bare()
    };
    let message = refusal(stop, &Draw::ALL);
    assert!(message.contains("`stop_s`") && !message.contains("--draw"), "{message}");
}

#[test]
fn what_is_neither_given_nor_drawn_is_refused_or_absent() {
    let message = refusal(bare(), &[Draw::Stops, Draw::Hills, Draw::Curves]);
    assert!(message.contains("`speed_limit_mps`") && message.contains("`--draw limits`"));
    // types by the limit, as without any drawing, where there is nothing to draw
    let cycle = GivenCycle { limits: vec![(0.0, 22.2)], has_slopes: true, ..bare() };
    let (plain, drawn) = (on(cycle.clone(), &[]), on(cycle, &[Draw::Limits, Draw::Hills]));
    assert_eq!(text(&road(&plain, 3)), text(&road(&drawn, 3)));
}

#[test]
fn grounds_of_the_file_hold_on_types_that_are_drawn() {
    let grounds = vec![(0.0, Ground::Asphalt), (30_000.0, Ground::Gravel)];
    let road = road(&on(GivenCycle { grounds: Some(grounds), ..bare() }, &Draw::ALL), 5);
    for (section, ground) in road.sections.iter().zip(&road.grounds) {
        assert_eq!(*ground == Ground::Gravel, section.start_m >= 30_000.0, "{section:?}");
        assert!(section.end_m <= 30_000.0 || section.start_m >= 30_000.0);
        assert!(road.signs.iter().any(|sign| sign.start_m == section.start_m));
    }
    assert_eq!(road.sections.len(), road.grounds.len());
}

/// Way of each type under each sign, in km, and the number of stretches of each type.
fn ways(sections: &[Section], limits: &[(f64, f64)]) -> Vec<f64> {
    let mut ways = vec![0.0; 3 * 14 + 3];
    for section in sections {
        ways[42 + section.road_type] += 1.0;
        for (k, limit) in limits.iter().enumerate() {
            let end_m = limits.get(k + 1).map_or(LENGTH_M, |next| next.0);
            let way_m = end_m.min(section.end_m) - limit.0.max(section.start_m);
            let face = (limit.1 * 0.36).round() as usize;
            ways[14 * section.road_type + face] += way_m.max(0.0) / 1000.0;
        }
    }
    ways
}

#[test]
fn types_drawn_given_the_signs_have_the_law_of_the_types() {
    let study = study();
    let sampler: &RoadSampler = study.operating_cycle().road();
    for seed in SEEDS {
        let mut differences: Vec<Vec<f64>> = Vec::new();
        for cycle_id in 0..600 {
            let streams = Streams::new(seed, cycle_id);
            let sections = sampler.sample_sections(LENGTH_M, &streams);
            let mut road = Road { sections, length_m: LENGTH_M, ..Road::default() };
            sampler.sample_signs(&streams, &mut road);
            let mut limits: Vec<(f64, f64)> =
                road.signs.iter().map(|sign| (sign.start_m, sign.speed_mps)).collect();
            limits.dedup_by(|b, a| a.1 == b.1);
            let others = Streams::new(seed + 100, cycle_id);
            let drawn = sampler.sample_types_of_signs(None, &limits, LENGTH_M, &others);
            assert_eq!((drawn[0].start_m, drawn[drawn.len() - 1].end_m), (0.0, LENGTH_M));
            for pair in drawn.windows(2) {
                assert!(pair[0].end_m == pair[1].start_m && pair[0].road_type != pair[1].road_type);
            }
            // the shortest stretch holds but at the end of the road
            assert!(drawn[..drawn.len() - 1].iter().all(|s| s.end_m - s.start_m > 249.9));
            let (own, drawn) = (ways(&road.sections, &limits), ways(&drawn, &limits));
            differences.push(own.iter().zip(&drawn).map(|(own, drawn)| drawn - own).collect());
        }
        let n = differences.len() as f64;
        for k in 0..differences[0].len() {
            let mean = differences.iter().map(|row| row[k]).sum::<f64>() / n;
            let variance = differences.iter().map(|row| (row[k] - mean).powi(2)).sum::<f64>();
            let error = (variance / n / (n - 1.0)).sqrt();
            assert!(mean.abs() <= 4.0 * error + 0.02, "seed {seed}, number {k}: {mean} of {error}");
        }
    }
}

#[test]
fn types_without_a_sign_in_common_are_found() {
    let study = study();
    let sampler = study.operating_cycle().road();
    // urban, motorway, urban; the last face is none of the study's, and 30 the nearest
    let limits = [(0.0, 40.0 / 3.6), (6000.0, 120.0 / 3.6), (70_000.0, 10.0 / 3.6)];
    let names = study.road_types();
    for cycle_id in 0..50 {
        let streams = Streams::new(1, cycle_id);
        let drawn = sampler.sample_types_of_signs(None, &limits, LENGTH_M, &streams);
        let at = |x: f64| names[drawn.iter().find(|s| x < s.end_m).unwrap().road_type].as_str();
        assert_eq!([at(3000.0), at(40_000.0), at(90_000.0)], ["urban", "motorway", "urban"]);
    }
}
