//! Traffic and weather along a cycle are written down by a clock that runs through the changes of
//! the road; here each place from its section and its own passing time alone.

use crate::common::study;
use ocmc_core::operating_cycle::traffic::TrafficTypeModel;
use ocmc_core::random::Streams;
use ocmc_core::study::{Scenario, Study};

const SEED: u64 = 1;

/// The index of the last of some positions at or before a place.
fn index_at(x_m: f64, starts: impl Iterator<Item = f64>) -> usize {
    starts.take_while(|start_m| *start_m <= x_m).count() - 1
}

/// Free-flow time from departure to a place, waits at the stops before it included, in s.
fn passing_time_s(x_m: f64, study: &Study, scenario: &Scenario) -> f64 {
    let road = &scenario.cycle.road;
    let ends = road.signs.iter().skip(1).map(|sign| sign.start_m).chain([road.length_m]);
    let driven = road.signs.iter().zip(ends).map(|(sign, end_m)| {
        let section = index_at(sign.start_m, road.sections.iter().map(|s| s.start_m));
        let types = study.operating_cycle().road();
        let speed_mps = sign.speed_mps.min(types.legal_mps(road.sections[section].road_type));
        (end_m.min(x_m) - sign.start_m).max(0.0) / speed_mps
    });
    let passed = road.events.iter().filter(|event| event.position_m <= x_m);
    driven.sum::<f64>() + passed.filter_map(|event| event.kind.standstill_s()).sum::<f64>()
}

/// Compares what stands along one cycle with its section and passing time at many places; how many
/// were compared.
fn assert_along(name: &str, study: &Study, cycle_id: u64) -> usize {
    let scenario = study.sample(SEED, cycle_id);
    let (cycle, road) = (&scenario.cycle, &scenario.cycle.road);
    let (mission, models) = (&cycle.mission, study.model());
    let streams = Streams::new(SEED, cycle_id);
    let weather = models.weather.sample(
        mission.day_of_year,
        mission.departure_s,
        cycle.free_flow_s,
        &streams,
    );
    let traffic = &models.traffic;
    let series = traffic.sample(cycle.mission.departure_s, cycle.free_flow_s, &streams);
    // at even odds the density is the series alone
    let even = TrafficTypeModel { off_peak_share: 0.5, peak_share: 0.5 };
    let odds = |middle_s: f64| {
        let share =
            traffic.density_per_m(&even, &series, 0.0, middle_s) / traffic.jam_density_per_m;
        share / (1.0 - share)
    };
    assert!((passing_time_s(road.length_m, study, &scenario) - cycle.free_flow_s).abs() < 1e-6);
    let mut compared = 0;
    for k in 0..2000 {
        let x_m = road.length_m * (f64::from(k) + 0.5) / 2000.0;
        let blocks = passing_time_s(x_m, study, &scenario) / traffic.step_s;
        // next to the end of a block rounding decides
        if (blocks - blocks.round()).abs() < 1e-6 {
            continue;
        }
        let middle_s = (blocks.floor() + 0.5) * traffic.step_s;
        let section = &road.sections[index_at(x_m, road.sections.iter().map(|s| s.start_m))];
        let model = &traffic.types[&study.road_types()[section.road_type]];
        let hour = (mission.departure_s + middle_s) / 3600.0 % 24.0;
        let share = traffic.typical_share(model, hour);
        let odds = odds(middle_s) * share / (1.0 - share);
        let wanted = traffic.jam_density_per_m * odds / (1.0 + odds);
        let here = &cycle.traffic[index_at(x_m, cycle.traffic.iter().map(|t| t.start_m))];
        let place = format!("{name}, cycle {cycle_id}, {x_m} m");
        let found = here.density_per_m;
        assert!((found - wanted).abs() < 1e-9 * wanted, "{place}: density {found} {wanted}");
        let here = &cycle.weather[index_at(x_m, cycle.weather.iter().map(|w| w.start_m))];
        assert_eq!(here.weather, weather.at(middle_s), "{place}: weather");
        compared += 1;
    }
    compared
}

#[test]
fn traffic_and_weather_are_those_of_the_section_and_the_middle_of_the_clocks_block() {
    for (name, sets) in [
        ("field-truck", &[][..]),
        // unloading lasts for several blocks of the clock, lights and signs for parts of one
        ("urban-delivery", &[]),
        // blocks shorter than a wait at a light
        ("urban-delivery", &["traffic.step_s=10"]),
        // road types that change all the time
        ("regional", &["road.types.rural.mean_length_m=600", "road.types.urban.mean_length_m=600"]),
    ] {
        let study = study(name, sets);
        let compared: usize = (0..5).map(|id| assert_along(name, &study, id)).sum();
        assert!(compared > 9900, "{name}: {compared}");
    }
}
