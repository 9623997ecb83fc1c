//! Railway crossings: their law, what vehicles do there, and that a study without them stays the
//! same.

use crate::common::field_truck;
use crate::common::statistics::{SEEDS, assert_count, assert_follows, assert_share};
use ocmc_core::distribution::{Law, Quantity};
use ocmc_core::kernel::drive::cpu::CpuLevel;
use ocmc_core::kernel::drive::scheduler::drive;
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::road::point_event::{
    EventKind, Passage, PointEvent, RailwayCrossingModel,
};
use ocmc_core::operating_cycle::road::road_type::Section;
use ocmc_core::random::{Draws, Stream};
use ocmc_core::record::Record;
use ocmc_core::study::{Scenario, Study, StudyModel};
use ocmc_core::switch::ModelSwitch;
use ocmc_core::tactical::{SpeedProfile, plan};

const SEED: u64 = 1;
const CYCLES: std::ops::Range<u64> = 0..12;

fn uniform(lower: f64, upper: f64) -> Quantity {
    Quantity::Law(Law::Uniform { lower, upper })
}

fn driven(study: &Study, cycle_id: u64) -> Vec<Record> {
    drive(study, SEED, cycle_id..cycle_id + 1, CpuLevel::best())
}

fn crossings() -> RailwayCrossingModel {
    RailwayCrossingModel {
        per_m: 1.0e-3,
        closed_probability: 0.2,
        wait_s: uniform(30.0, 180.0),
        pass_speed_mps: uniform(5.0, 10.0),
        stop_s: uniform(3.0, 6.0),
    }
}

/// The default study with crossings on every road type, events at any distance.
fn study(change: impl FnOnce(&mut StudyModel)) -> Study {
    field_truck(|model| {
        model.road.event_spacing_m = 0.0;
        for road_type in model.road.types.values_mut() {
            road_type.railway_crossings = Some(crossings());
        }
        change(model);
    })
}

fn is_crossing(event: &PointEvent) -> bool {
    matches!(event.kind, EventKind::OpenCrossing { .. } | EventKind::ClosedCrossing { .. })
}

fn bits(value: &impl std::fmt::Debug) -> String {
    format!("{value:?}")
}

#[test]
fn a_section_has_crossings_at_the_rate_and_with_the_marks_of_its_model() {
    let section = Section { start_m: 0.0, end_m: 5.0e6, road_type: 0 };
    let between =
        |lower: f64, upper: f64| move |x: f64| ((x - lower) / (upper - lower)).clamp(0.0, 1.0);
    for seed in SEEDS {
        let mut drawn = Vec::new();
        let mut draws = Draws::new(seed, 7, Stream::RailwayCrossing);
        crossings().sample(&section, &mut draws, &mut drawn);
        assert_count("crossings", drawn.len(), 5000.0);
        assert_follows("places", drawn.iter().map(|e| e.position_m).collect(), between(0.0, 5.0e6));
        let waits: Vec<f64> = drawn.iter().filter_map(|e| e.kind.standstill_s()).collect();
        assert_share("closed", waits.len(), drawn.len(), 0.2);
        assert_follows("wait", waits, between(30.0, 180.0));
        let (speeds, stops): (Vec<f64>, Vec<f64>) = drawn
            .iter()
            .filter_map(|e| match e.kind {
                EventKind::OpenCrossing { speed_mps, standstill_s } => {
                    Some((speed_mps, standstill_s))
                }
                _ => None,
            })
            .unzip();
        assert_follows("passing speed", speeds, between(5.0, 10.0));
        assert_follows("stop", stops, between(3.0, 6.0));
    }
}

#[test]
fn a_fleet_meets_crossings_at_the_rate_of_its_roads() {
    let study = study(|_| ());
    let free_m = 2.0 * study.model().road.event_free_end_m;
    let (mut count, mut length_m) = (0, 0.0);
    for cycle_id in 0..60 {
        let road = study.sample(SEED, cycle_id).cycle.road;
        count += road.events.iter().filter(|event| is_crossing(event)).count();
        length_m += road.length_m - free_m;
    }
    assert_count("crossings", count, 1.0e-3 * length_m);
}

#[test]
fn crossings_move_nothing_else_and_a_study_without_them_is_as_before() {
    let (with, without) = (study(|_| ()), field_truck(|m| m.road.event_spacing_m = 0.0));
    let off = study(|m| m.simulation.without = vec![ModelSwitch::RailwayCrossings]);
    for cycle_id in CYCLES {
        let (mut a, b) = (with.sample(SEED, cycle_id), without.sample(SEED, cycle_id));
        let all = a.cycle.road.events.len();
        a.cycle.road.events.retain(|event| !is_crossing(event));
        assert!(a.cycle.road.events.len() < all, "cycle {cycle_id} has crossings");
        let road = |s: &Scenario| bits(&(&s.cycle.road, &s.driver, &s.vehicle, &s.cycle.mission));
        assert_eq!(road(&a), road(&b));
        assert_eq!(bits(&off.sample(SEED, cycle_id)), bits(&b));
    }
    assert_eq!(bits(&driven(&off, 3)), bits(&driven(&without, 3)));
}

#[test]
fn a_truck_slows_at_an_open_crossing_and_a_bus_stops() {
    let [truck, bus] = [false, true].map(|stops| {
        study(|model| {
            // stops that are less than the capture distance apart are one
            model.road.event_spacing_m = 50.0;
            model.vehicle.stops_at_railway_crossings = stops;
        })
    });
    let mut open = 0;
    for cycle_id in CYCLES {
        let mut stops_s = [0.0; 2];
        for (k, study) in [&truck, &bus].into_iter().enumerate() {
            let scenario = study.sample(SEED, cycle_id);
            let mut profile = SpeedProfile::default();
            plan(study, &scenario, &mut profile);
            let places = profile.segments.iter().enumerate();
            for (i, event) in places.filter_map(|(i, segment)| Some((i, segment.event()?))) {
                // at the end of the segment before
                let planned_mps = profile.speed_mps(i - 1, profile.segments[i - 1].length_m);
                match (scenario.cycle.road.events[event].kind, scenario.passage(event)) {
                    (EventKind::OpenCrossing { speed_mps, .. }, Passage::Slow { .. }) => {
                        assert!(k == 0 && planned_mps > 0.0 && planned_mps <= speed_mps + 1e-9);
                        open += 1;
                    }
                    (EventKind::OpenCrossing { .. }, passage) => {
                        assert!(k == 1 && matches!(passage, Passage::Stop { .. }));
                    }
                    (EventKind::ClosedCrossing { standstill_s }, passage) => {
                        assert_eq!(passage, Passage::Stop { standstill_s });
                    }
                    _ => {}
                }
            }
            let events = 0..scenario.cycle.road.events.len();
            stops_s[k] = events.filter_map(|e| scenario.passage(e).standstill_s()).sum::<f64>();
            let driven = &driven(study, cycle_id)[0];
            assert!((driven.standstill_s - stops_s[k]).abs() < 1e-6, "{driven:?}");
        }
        assert!(stops_s[1] > stops_s[0], "cycle {cycle_id}");
    }
    assert!(open > 100, "{open}");
}

#[test]
fn tracks_hold_crossings_and_give_them_back() {
    let study = study(|_| ());
    let cycle = study.sample(SEED, 0).cycle;
    let tracks = |cycle: &ocmc_core::operating_cycle::OperatingCycle| {
        cycle.tracks(study.road_types(), study.operating_cycle().road().types())
    };
    let given = GivenCycle::from_tracks(&tracks(&cycle), Some(cycle.road.length_m)).unwrap();
    let crossings = |events: &[PointEvent]| {
        events.iter().filter(|event| is_crossing(event)).map(bits).collect::<Vec<_>>()
    };
    // events less than 1 m apart act at one place
    let lonely: Vec<PointEvent> = cycle
        .road
        .events
        .iter()
        .filter(|a| {
            let near = |b: &&PointEvent| (a.position_m - b.position_m).abs() < 2.0;
            cycle.road.events.iter().filter(near).count() == 1
        })
        .copied()
        .collect();
    let (wanted, found) = (crossings(&lonely), crossings(&given.events));
    assert!(wanted.len() > 10 && wanted.iter().all(|event| found.contains(event)));
    // a study without crossings writes the tracks that it always wrote
    let plain = field_truck(|_| ()).sample(SEED, 0).cycle;
    assert!(tracks(&plain).iter().all(|track| !track.name.starts_with("railway_crossing")));
}
