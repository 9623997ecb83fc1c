//! Parts of a mission: cargo that changes at stops, and bodies that work there.

use crate::common::{GivenRoad, balance, diesel, electric_balance, run, study, typical};
use ocmc_core::energy::Carrier;
use ocmc_core::kernel::drive::cpu::CpuLevel;
use ocmc_core::kernel::drive::scheduler::{drive, drive_scenario};
use ocmc_core::kernel::drive::trace::{trace, trace_scenario};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::mission_part::MissionPart;
use ocmc_core::operating_cycle::road::point_event::{EventKind, PointEvent};
use ocmc_core::record::Record;
use ocmc_core::study::{Load, Scenario, Study};

const ROUND: [&str; 3] =
    ["mission.payload_kg=12000", "mission.stops.spacing_m=4000", "mission.stops.dwell_s=300"];

/// A study of rounds with further settings.
fn rounds(base: &str, sets: &[&str]) -> Study {
    study(base, &[&ROUND, sets].concat())
}

/// Gives a scenario a stop of the mission, from which on it carries another payload.
fn unload(study: &Study, scenario: &mut Scenario, start_m: f64, dwell_s: f64, payload_kg: f64) {
    let kind = EventKind::MissionStop { standstill_s: dwell_s };
    scenario.cycle.road.events.push(PointEvent { position_m: start_m, kind, turns: false });
    let part = MissionPart { start_m, payload_kg, ..MissionPart::default() };
    let vehicle = study.vehicle().model.loaded(&scenario.vehicle, payload_kg);
    scenario.loads.push(Load { part, vehicle });
}

#[test]
fn a_round_takes_what_its_legs_take_one_by_one() {
    let study = typical(&[]);
    let legs = [(6000.0, 24_300.0), (4000.0, 12_000.0), (5000.0, 0.0)];
    let road = |length_m, payload_kg| GivenRoad {
        payload_kg,
        ..GivenRoad::flat(length_m, 70.0 / 3.6).slope(0.004)
    };
    let mut round = road(15_000.0, 24_300.0).scenario(&study);
    unload(&study, &mut round, 6000.0, 120.0, 12_000.0);
    unload(&study, &mut round, 10_000.0, 60.0, 0.0);
    let round = drive_scenario(&study, round);
    let alone = legs.map(|(length_m, payload_kg)| {
        drive_scenario(&study, road(length_m, payload_kg).scenario(&study))
    });
    let sum = |of: fn(&Record) -> f64| alone.iter().map(of).sum::<f64>();
    let diesel = diesel(&study);
    let idle_radps = diesel.engine_model.idle_speed_radps;
    let auxiliary_w = study.sample(1, 0).vehicle.auxiliary_power_w;
    let idle_kgps = diesel.engine.fuel_kgps(idle_radps, auxiliary_w / idle_radps);
    let close = |have: f64, want: f64| {
        assert!((have / want - 1.0).abs() < 1e-3, "{have} for {want}");
    };
    // at the end of a trip the engine idles on for nothing: legs differ by the metre of the lines
    close(
        round.amount(Carrier::LiquidFuel).unwrap(),
        sum(|r| r.amount(Carrier::LiquidFuel).unwrap()) + 180.0 * idle_kgps,
    );
    close(round.rolling_energy_j, sum(|r| r.rolling_energy_j));
    close(round.potential_change_j, sum(|r| r.potential_change_j));
    close(round.wheel_energy_j, sum(|r| r.wheel_energy_j));
    close(round.duration_s, sum(|r| r.duration_s) + 180.0);
    assert!(balance(&round).abs() < 1e-9);
    // what rolls and climbs is what is carried
    let heavy = drive_scenario(&study, road(15_000.0, 24_300.0).scenario(&study));
    assert!(round.amount(Carrier::LiquidFuel) < heavy.amount(Carrier::LiquidFuel));
    let mean_kg = round.mean_payload_kg;
    assert!((mean_kg - (6.0 * 24_300.0 + 4.0 * 12_000.0) / 15.0).abs() < 5.0, "{mean_kg}");
    assert_eq!(round.payload_kg, 24_300.0);
    let per_tkm = round.consumption_per_tonne(Carrier::LiquidFuel).unwrap() * mean_kg / 1000.0;
    close(per_tkm, round.consumption(Carrier::LiquidFuel).unwrap());
}

#[test]
fn cargo_is_delivered_in_equal_parts_or_drawn_for_each_stop() {
    let study_of = |sets: &[&str]| rounds("urban-delivery", sets);
    let loads = |study: &Study| -> Vec<f64> {
        study.sample(3, 5).loads.iter().map(|load| load.part.payload_kg).collect()
    };
    let delivered = loads(&study_of(&["mission.stops.cargo.delivered_share=0.9"]));
    assert_eq!(delivered.len(), 9);
    for (k, payload_kg) in delivered.iter().enumerate() {
        let said_kg = 12_000.0 * (1.0 - 0.1 * (k + 1) as f64);
        assert!((payload_kg - said_kg).abs() < 1e-9, "{delivered:?}");
    }
    let law = "mission.stops.cargo.payload_kg={ distribution = \"uniform\", lower = 0.0, \
               upper = 40000.0 }";
    let drawn = study_of(&[law, "vehicle.gross_mass_limit_kg=40000"]);
    let most_kg = drawn.model().vehicle.most_payload_kg();
    let payloads = loads(&drawn);
    assert!(payloads.contains(&most_kg) && payloads.iter().any(|kg| *kg < 20e3));
    assert!(payloads.windows(2).all(|pair| pair[0] != pair[1] || pair[0] == most_kg));
    // the typical truck carries the mean
    let mean = study_of(&[law, "simulation.without=[\"payload_spread\"]"]);
    assert!(loads(&mean).iter().all(|kg| *kg == 20_000.0));
    // the same roads, stops and drivers as without: only what is said differs
    let plain = run(&study_of(&[]), 6);
    assert!(plain == run(&study_of(&["mission.stops.cargo.delivered_share=0"]), 6));
}

#[test]
fn books_close_and_a_trace_is_the_record_with_parts_on_all_processors() {
    let sets = [
        "mission.stops.cargo.delivered_share=1",
        "mission.stops.power_take_off.power_w=8000",
        "mission.stops.power_take_off.duration_s=240",
    ];
    let looks = "driver.look_ahead.engine_stop=true";
    let both = vec![
        rounds("urban-delivery", &[&sets[..], &[looks]].concat()),
        study("electric-regional", &[&ROUND[..], &sets[..]].concat()),
    ];
    for study in both {
        let records = run(&study, 24);
        for record in &records {
            let is_electric = record.amount(Carrier::Electricity).is_some();
            let open = if is_electric { electric_balance(record) } else { balance(record) };
            assert!(open.abs() < 1e-9, "{open} {record:?}");
            let works = record.power_take_off_energy_j.unwrap() / (8000.0 * 240.0);
            assert!((works - works.round()).abs() < 1e-9 && works >= 1.0, "{works}");
            assert!(record.auxiliary_energy_j > record.power_take_off_energy_j.unwrap());
        }
        assert!(trace(&study, 1, 7).record == records[7]);
        for level in CpuLevel::ALL.into_iter().filter(|level| level.is_available()) {
            let again = drive(&study, 1, 0..24, level);
            assert!(again == records, "{level:?}");
        }
    }
}

#[test]
fn a_body_takes_its_power_from_the_engine_at_its_speed_and_is_cut_at_full_load() {
    let fuel_kg = |sets: &[&str]| {
        let mut all = vec!["mission.stops.cargo.delivered_share=0"];
        all.extend_from_slice(sets);
        let study = rounds("urban-delivery", &all);
        (trace(&study, 1, 0).record, study)
    };
    let (plain, _) = fuel_kg(&[]);
    let speed = "vehicle.powertrain.combustion.engine.power_take_off_speed_radps=105";
    let (works, study) = fuel_kg(&["mission.stops.power_take_off.power_w=30000", speed]);
    let diesel = diesel(&study);
    let truck = study.sample(1, 0).vehicle;
    let auxiliary_w = truck.auxiliary_power_w;
    let rate = |speed_radps: f64, power_w: f64| {
        truck.map_factor * diesel.engine.fuel_kgps(speed_radps, power_w / speed_radps)
    };
    let idle_radps = diesel.engine_model.idle_speed_radps;
    let stands_s = 9.0 * 300.0;
    let more_kg = stands_s * (rate(105.0, auxiliary_w + 30e3) - rate(idle_radps, auxiliary_w));
    let found_kg =
        works.amount(Carrier::LiquidFuel).unwrap() - plain.amount(Carrier::LiquidFuel).unwrap();
    assert!((found_kg / more_kg - 1.0).abs() < 1e-9, "{found_kg} {more_kg}");
    assert_eq!(works.power_take_off_energy_j, Some(stands_s * 30e3));
    assert_eq!(works.duration_s, plain.duration_s);
    // a law beyond the engine's power gets what it has
    let law = "mission.stops.power_take_off.power_w={ distribution = \"uniform\", lower = 290e3, \
               upper = 300e3 }";
    let (cut, study) = fuel_kg(&[law]);
    let most_w = crate::common::diesel(&study).power_take_off_w(auxiliary_w);
    assert!((cut.power_take_off_energy_j.unwrap() / (stands_s * most_w) - 1.0).abs() < 1e-12);
    let sets = [&ROUND[..], &["mission.stops.power_take_off.power_w=290e3"]].concat();
    let refused = ocmc_io::study::load("urban-delivery", &sets).unwrap_err().to_string();
    assert!(refused.contains("mission.stops.power_take_off.power_w"), "{refused}");
    let auxiliary_w = study.model().vehicle.auxiliary_power_w.centre();
    let most_w = crate::common::diesel(&study).power_take_off_w(auxiliary_w);
    assert!(refused.contains(&format!("at most {}:", most_w.floor())), "{refused}");
}

#[test]
fn a_body_draws_from_the_battery_and_the_forecast_of_a_driver_knows_it() {
    let of = |power: &str| {
        let power = format!("mission.stops.power_take_off.power_w={power}");
        let without = "simulation.without=[\"traffic\", \"weather\"]";
        let sets = [&ROUND[..], &[power.as_str(), without]].concat();
        trace(&study("electric-regional", &sets), 1, 0).record
    };
    let (plain, works) = (of("0"), of("20000"));
    let work_j = works.power_take_off_energy_j.unwrap();
    let more_j =
        works.amount(Carrier::Electricity).unwrap() - plain.amount(Carrier::Electricity).unwrap();
    assert!(work_j > 0.0 && plain.power_take_off_energy_j == Some(0.0));
    assert!((1.0..1.05).contains(&(more_j / work_j)), "{more_j} {work_j}");
    // what a way takes whatever its consumption: mass times climb, leg by leg, and the work
    let study = typical(&[]);
    let mut scenario = GivenRoad::flat(9000.0, 20.0).slope(0.01).scenario(&study);
    unload(&study, &mut scenario, 3000.0, 60.0, 10_000.0);
    let [part, empty] = [&mut scenario.loads[0].part, &mut MissionPart::default()];
    (part.power_take_off_w, part.power_take_off_s) = (5000.0, 100.0);
    assert_eq!(empty.power_take_off_j(), 0.0);
    let [full_kg, part_kg] = [scenario.vehicle.mass_kg, scenario.loads[0].vehicle.mass_kg];
    let climbs = scenario.fixed_energy_j([1000.0, 7000.0], 60.0);
    let said = 9.80665 * (full_kg * 20.0 + part_kg * 40.0) + 500e3;
    assert!((climbs / said - 1.0).abs() < 1e-9, "{climbs} {said}");
    assert_eq!(scenario.vehicle_at(2999.0).mass_kg, full_kg);
    assert_eq!(scenario.vehicle_at(3000.0).mass_kg, part_kg);
}

#[test]
fn a_cycle_that_is_written_is_driven_again_with_its_parts() {
    let study = rounds(
        "urban-delivery",
        &[
            "mission.stops.cargo.delivered_share=0.8",
            "mission.stops.power_take_off.power_w={ distribution = \"uniform\", lower = 5000.0, \
             upper = 20000.0 }",
            "mission.stops.power_take_off.duration_s=200",
        ],
    );
    let scenario = study.sample(2, 1);
    let types = study.operating_cycle().road().types();
    let tracks = scenario.cycle.tracks(study.road_types(), types);
    let given = GivenCycle::from_tracks(&tracks, Some(scenario.cycle.road.length_m)).unwrap();
    assert_eq!(given.parts, scenario.cycle.mission.parts);
    assert_eq!(GivenCycle::from_tracks(&given.tracks(), None).unwrap().parts, given.parts);
    let keep = vec![ocmc_core::operating_cycle::route::Keep::Mission];
    // a study that says nothing of stops takes what the file says; one that keeps its own payload
    // has the work of the body alone
    let base = self::study("urban-delivery", &["mission.payload_kg=3000"]);
    let again = base
        .clone()
        .with_routes(vec![(given.clone(), 1.0, keep, Vec::new())])
        .unwrap()
        .sample(9, 9);
    assert_eq!(again.cycle.mission.parts, given.parts);
    assert_eq!(again.loads.len(), given.parts.len());
    let own =
        base.with_routes(vec![(given.clone(), 1.0, Vec::new(), Vec::new())]).unwrap().sample(9, 9);
    assert!(own.cycle.mission.parts.iter().all(|part| part.payload_kg == 3000.0));
    let works =
        |parts: &[MissionPart]| parts.iter().map(MissionPart::power_take_off_j).sum::<f64>();
    assert_eq!(works(&own.cycle.mission.parts), works(&given.parts));
    let driven = trace_scenario(&study, again).record;
    assert_eq!(driven.power_take_off_energy_j.unwrap(), works(&given.parts));
}

#[test]
fn faults_are_named() {
    let refusal = |sets: &[&str]| {
        let sets = [&ROUND[..], sets].concat();
        ocmc_io::study::load("urban-delivery", &sets).unwrap_err().to_string()
    };
    let share = "mission.stops.cargo.delivered_share=1";
    let text = refusal(&[share, "mission.stops.cargo.payload_kg=1000"]);
    assert!(text.contains("`mission.stops.cargo` is with 2 of its keys"), "{text}");
    assert!(refusal(&["mission.stops.cargo.delivered_share=1.5"]).contains("0 to 1"));
    let text = refusal(&["mission.stops.cargo.payload_kg=90000"]);
    assert!(text.contains("mission.stops.cargo.payload_kg") && text.contains("at most"), "{text}");
    let bound = ocmc_fleet::bound::bound(
        &rounds("urban-delivery", &[share]),
        1,
        0,
        ocmc_fleet::bound::Fineness::default(),
    );
    assert!(bound.unwrap_err().to_string().contains("cycle 0 changes its load"));
}
