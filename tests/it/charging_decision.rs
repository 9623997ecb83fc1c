//! Drivers decide on their way where they charge and rest: by hand on a level road, more battery
//! never makes more stops of it, and nobody drives on beyond the law.

use crate::common::{GivenRoad, column, run};
use ocmc_core::kernel::drive::scheduler::drive_scenario;
use ocmc_core::kernel::drive::trace::trace_scenario;
use ocmc_core::record::{Outcome, Record};
use ocmc_core::study::{Scenario, Study};
use ocmc_io::study::load_text;

const SPACING_M: f64 = 40e3;
const CAPACITY_J: f64 = 540.0 * 3.6e6;

fn study(sets: &[&str]) -> Study {
    let text = "[study]\nname = \"c\"\ndescription = \"d\"\nbase = \"battery-truck\"\n";
    let policy = ["charging.reserve=0.15", "charging.efficiency=0.94"];
    load_text("c.toml", text, &[&policy[..], sets].concat()).unwrap().study
}

fn charging(consumption_j_per_m: f64, margin: f64, sets: &[&str]) -> Study {
    let forecast = format!(
        "charging.forecast={{ consumption_j_per_m = {consumption_j_per_m}, margin = {margin} }}"
    );
    let public = format!(
        "charging.public={{ spacing_m = {SPACING_M}, power_w = 350000, wait_s = 0, end_at = 0.8 }}"
    );
    study(&[&[forecast.as_str(), public.as_str()][..], sets].concat())
}

fn on_level_road(study: &Study, length_m: f64) -> Scenario {
    let mut scenario = GivenRoad::flat(length_m, 80.0 / 3.6).scenario(study);
    let streams = ocmc_core::random::Streams::new(1, 0);
    let public = study.model().charging.as_ref().and_then(|charging| charging.public.as_ref());
    scenario.chargers = public.map_or(Vec::new(), |public| public.sample(length_m, &[], &streams));
    scenario
}

/// Where a trip was charged, in m, and its record.
fn charged_at(study: &Study, length_m: f64) -> (Vec<f64>, Record) {
    let record = drive_scenario(study, on_level_road(study, length_m));
    let events = record.charging_events.clone().unwrap();
    (events.iter().map(|event| event.position_m).collect(), record)
}

#[test]
fn on_a_level_road_the_chargers_are_those_of_the_closed_form() {
    // it takes e for each metre, from 0.88 down to the reserve of 0.15
    let alone = study(&[]);
    let alone = drive_scenario(&alone, on_level_road(&alone, 500e3));
    assert_eq!(alone.outcome, Outcome::Depleted);
    let per_m = 0.73 * CAPACITY_J / alone.distance_m;
    let mut chosen = Vec::new();
    for margin in [0.0, 0.1, 0.5, 1.0, 2.0] {
        let (places, record) = charged_at(&charging(per_m, margin, &[]), 500e3);
        assert_eq!(record.outcome, Outcome::Completed, "{margin}");
        // the first charger from which (1 + margin) e 40 km are not left
        let left_m = alone.distance_m - (1.0 + margin) * SPACING_M;
        let first_m = SPACING_M * (left_m / SPACING_M).ceil();
        assert!((places[0] - first_m).abs() < 1.0, "{margin} {places:?} {first_m}");
        let lowest = record.lowest_charge.unwrap();
        assert!(lowest > 0.15, "{margin} {lowest}");
        chosen.push(first_m);
    }
    assert!(chosen.is_sorted_by(|a, b| a >= b) && chosen[0] > chosen[4], "{chosen:?}");
}

#[test]
fn who_forecasts_too_little_uses_his_reserve_and_the_record_tells() {
    // he counts with next to nothing, and learns; hills make no difference to a level road
    let (places, record) = charged_at(&charging(100.0, 0.0, &[]), 500e3);
    let (_, careful) = charged_at(&charging(100.0, 1.5, &[]), 500e3);
    assert!(!places.is_empty() && record.outcome == Outcome::Completed);
    let events = record.charging_events.as_ref().unwrap();
    let arrivals = events.iter().map(|event| event.begin_charge);
    let lowest = arrivals.fold(record.final_charge.unwrap(), f64::min);
    assert_eq!(record.lowest_charge, Some(lowest));
    assert!(lowest < careful.lowest_charge.unwrap(), "{lowest}");
}

#[test]
fn more_battery_makes_no_more_stops_and_more_trips_arrive() {
    let counts = [1.0, 0.8, 0.6, 0.4].map(|share| {
        let battery = format!(
            "vehicle.powertrain.battery_electric.battery.capacity_j={}",
            share * CAPACITY_J
        );
        let records = run(&charging(4500.0, 0.1, &["mission.length_m=300000", &battery]), 40);
        let stops: u32 = records.iter().filter_map(|record| record.n_charging_stops).sum();
        let arrived = records.iter().filter(|record| record.outcome == Outcome::Completed).count();
        for record in &records {
            let lowest = record.lowest_charge.unwrap();
            let is_empty = record.outcome == Outcome::Depleted;
            assert_eq!(lowest <= 0.1, is_empty, "{record:?}");
        }
        (stops, arrived)
    });
    assert!(
        counts.is_sorted_by_key(|(stops, _)| *stops) && counts[0].0 < counts[3].0,
        "{counts:?}"
    );
    assert!(counts.is_sorted_by(|a, b| a.1 >= b.1), "{counts:?}");
}

#[test]
fn who_finds_no_charger_rests_on_the_spot_within_the_law() {
    let sets =
        ["vehicle.powertrain.battery_electric.battery.capacity_j=9e9", "rest.law=\"eu_561\""];
    let none = [&sets[..], &["charging.public.available_share=0"]].concat();
    let study = charging(4500.0, 0.1, &none);
    let trace = trace_scenario(&study, on_level_road(&study, 750e3));
    assert_eq!((trace.record.outcome, trace.record.n_rests), (Outcome::Completed, Some(2)));
    assert_eq!(trace.record.rest_s, Some(5400.0));
    let [step, moved] = ["step_s", "distance_added_m"].map(|name| column(&trace, name));
    let (mut driven_s, mut longest_s) = (0.0, 0.0);
    for (step_s, moved_m) in step.iter().zip(moved) {
        if *step_s >= 2700.0 && *moved_m == 0.0 {
            driven_s = 0.0;
        } else {
            driven_s += step_s;
            longest_s = f64::max(longest_s, driven_s);
        }
    }
    assert!(longest_s <= 4.5 * 3600.0 && longest_s > 4.4 * 3600.0, "{longest_s}");
    // with chargers he rests at them, within the law, too
    let study = charging(4500.0, 0.1, &sets);
    let (places, record) = charged_at(&study, 750e3);
    assert_eq!((places.len(), record.n_rests), (2, Some(2)), "{places:?}");
}

#[test]
fn a_road_that_is_cut_at_chargers_has_the_same_hills() {
    let road = ["mission.length_m=200000"];
    let (with, without) = (run(&charging(4500.0, 0.1, &road), 5), run(&study(&road), 5));
    for (with, without) in with.iter().zip(&without) {
        assert!(without.climb_m > 100.0, "{}", without.climb_m);
        assert!((with.climb_m / without.climb_m - 1.0).abs() < 1e-9, "{}", with.climb_m);
    }
}

#[test]
fn a_road_that_is_cut_is_the_same_road() {
    let cycle = study(&["mission.length_m=60000"]).sample(1, 0).cycle;
    let (mut whole, mut runs) = (Vec::new(), Vec::new());
    cycle.segments(0.0, &mut whole, &mut runs);
    let places_m = vec![0.0, 1000.0, 1000.25, 20_000.5, 20_003.0, 60_000.0];
    let (mut parts, mut runs_of_parts) = (Vec::new(), Vec::new());
    cycle.segments_cut(0.0, &places_m, &mut parts, &mut runs_of_parts);
    let starts = |at_m: f64| parts.iter().any(|part| (part.start_m - at_m).abs() < 1.1e-3);
    assert!(places_m[..5].iter().all(|at_m| starts(*at_m)));
    assert!(parts.len() <= whole.len() + 4);
    let mut part = parts.iter();
    for (k, one) in whole.iter().enumerate() {
        let (mut at_m, mut is_first) = (one.start_m, true);
        while at_m < one.start_m + one.length_m - 1e-6 {
            let piece = part.next().unwrap();
            assert!((piece.start_m - at_m).abs() < 1e-6 && piece.length_m > 0.9e-3, "{k}");
            assert_eq!(piece.event(), one.event().filter(|_| is_first));
            assert_eq!(
                (piece.sign, piece.slope, piece.curve()),
                (one.sign, one.slope, one.curve())
            );
            (at_m, is_first) = (at_m + piece.length_m, false);
        }
    }
    assert!(part.next().is_none());
    // a cut begins a run, and all others begin where they began
    let places = |runs: &[usize], of: &[ocmc_core::operating_cycle::segments::Segment]| {
        runs.iter().filter_map(|k| of.get(*k).map(|one| one.start_m)).collect::<Vec<_>>()
    };
    let of_parts = places(&runs_of_parts, &parts);
    assert!(places(&runs, &whole).iter().all(|at_m| of_parts.contains(at_m)));
}
