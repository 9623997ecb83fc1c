//! Charging on trips: a stop is made where the next charger is out of reach, as long as it takes,
//! and nothing is charged that no meter counted.

use crate::common::{GivenRoad, column, electric_balance, run};
use ocmc_core::energy::Carrier;
use ocmc_core::kernel::drive::cpu::CpuLevel;
use ocmc_core::kernel::drive::scheduler::{drive, drive_scenario};
use ocmc_core::kernel::drive::trace::{trace, trace_scenario};
use ocmc_core::record::{Outcome, Record};
use ocmc_core::study::{Scenario, Study};
use ocmc_io::study::load_text;

const BASE: [&str; 5] = [
    "charging.reserve=0.15",
    "charging.forecast={ consumption_j_per_m = 4500, margin = 0.1 }",
    "charging.efficiency=0.94",
    "charging.connection_s=120",
    "charging.public={ spacing_m = 40000, power_w = 350000, wait_s = 300, end_at = 0.8 }",
];
const DEPOT: &str = "charging.depot={ power_w = 150000, parked_s = 36000 }";
const EU: &str = "rest.law=\"eu_561\"";

fn study(sets: &[&str]) -> Study {
    let text = "[study]\nname = \"c\"\ndescription = \"d\"\nbase = \"battery-truck\"\n";
    load_text("c.toml", text, sets).unwrap().study
}

fn charging(sets: &[&str]) -> Study {
    study(&[&BASE[..], sets].concat())
}

/// A level road at 80 km/h, with the chargers that the study draws for one so long.
fn scenario(study: &Study, length_m: f64) -> Scenario {
    let mut scenario = GivenRoad::flat(length_m, 80.0 / 3.6).scenario(study);
    let streams = ocmc_core::random::Streams::new(1, 0);
    let public = study.model().charging.as_ref().and_then(|charging| charging.public.as_ref());
    scenario.chargers = public.map_or(Vec::new(), |public| public.sample(length_m, &[], &streams));
    scenario
}

/// Stands of more than two minutes: where, how long, charge at arrival and at departure.
fn stands(study: &Study, scenario: Scenario) -> (Vec<[f64; 4]>, Record) {
    let trace = trace_scenario(study, scenario);
    let names = ["step_s", "position_m", "distance_added_m", "state_of_charge"];
    let [step, position, moved, charge] = names.map(|name| column(&trace, name));
    let long = (1..step.len()).filter(|k| moved[*k] == 0.0 && step[*k] > 120.0);
    let stands = long.map(|k| [position[k], step[k], charge[k - 1], charge[k]]).collect();
    (stands, trace.record)
}

/// Energy that no meter counted, over what was charged.
fn open(record: &Record, efficiency: f64) -> f64 {
    let metered =
        [record.grid_energy_depot_j, record.grid_energy_public_j, record.grid_energy_stop_j];
    let metered_j: f64 = metered.into_iter().flatten().sum();
    let charged_j = record.charged_energy_j.unwrap();
    let beside_j = record.charging_loss_j.unwrap() + record.charger_auxiliary_energy_j.unwrap();
    let open_j = metered_j * efficiency - charged_j - beside_j;
    open_j / charged_j.max(1.0)
}

#[test]
fn a_truck_charges_at_the_last_charger_before_it_would_need_its_reserve() {
    // a forecast without a margin, as good as knowing it
    let (with, without) = (charging(&["charging.forecast.margin=0"]), study(&BASE[..4]));
    let length_m = 500e3;
    let alone = drive_scenario(&without, scenario(&without, length_m));
    assert_eq!(alone.outcome, Outcome::Depleted);
    assert!((alone.final_charge.unwrap() - 0.15).abs() < 1e-3, "{alone:?}");
    let (stands, record) = stands(&with, scenario(&with, length_m));
    assert_eq!(record.outcome, Outcome::Completed);
    // sites lie 40 km apart
    let reached_m = 40e3 * (alone.distance_m / 40e3).floor();
    let [at_m, stood_s, arrives, departs] = stands[0];
    assert!((at_m - reached_m).abs() < 1.0, "{stands:?} {alone:?}");
    assert!(arrives > 0.15 && arrives < 0.15 + 1.1 * 40.0 * 1.3 / 540.0, "{stands:?}");
    let n = stands.len() as u32;
    // it is charged up to 0.8; before and behind the plug the auxiliaries draw
    let auxiliary_w = record.auxiliary_energy_j / (record.moving_s + 420.0 * f64::from(n));
    let capacity_j = 540.0 * 3.6e6;
    let unplugging = 60.0 * auxiliary_w / capacity_j;
    assert!((0.8 - departs - unplugging).abs() < 0.01 * unplugging, "{stands:?}");
    // a constant 329 kW less the auxiliaries into 0.05 Ω at about 680 V, wait and plug beside it
    let terminals_w = 329e3 - auxiliary_w;
    let gained_j = (0.8 - arrives) * capacity_j + 360.0 * auxiliary_w;
    let said_s = 420.0 + gained_j / (terminals_w - 0.05 * (terminals_w / 680.0).powi(2));
    assert!((stood_s / said_s - 1.0).abs() < 0.005, "{stood_s} {said_s}");
    let carried_j = auxiliary_w * record.charging_s.unwrap();
    let meant_j = record.charger_auxiliary_energy_j.unwrap();
    assert!((meant_j / carried_j - 1.0).abs() < 1e-9, "{meant_j} {carried_j}");
    assert_eq!(
        (record.n_charging_stops, record.charging_wait_s),
        (Some(n), Some(300.0 * f64::from(n)))
    );
    let standing_s: f64 = stands.iter().map(|stand| stand[1]).sum();
    assert!((record.charging_s.unwrap() + 420.0 * f64::from(n) - standing_s).abs() < 1e-6);
    assert!((record.standstill_s - standing_s).abs() < 1e-6);
    assert!(electric_balance(&record).abs() < 1e-9 && open(&record, 0.94).abs() < 1e-9);
}

#[test]
fn where_no_charger_helps_the_truck_stops_with_its_reserve() {
    let far = "charging.public.spacing_m=400000";
    let record = drive_scenario(&charging(&[far]), scenario(&charging(&[far]), 500e3));
    assert_eq!((record.outcome, record.n_charging_stops), (Outcome::Depleted, Some(0)));
    // the whole trip is known nevertheless
    assert!((record.whole_trip_m.unwrap() - 500e3).abs() < 1.0);
    let none = charging(&["charging.public.available_share=0"]);
    assert_eq!(drive_scenario(&none, none.sample(1, 0)).n_charging_stops, Some(0));
}

#[test]
fn on_sampled_trips_the_charge_keeps_its_bounds_and_the_energy_its_balance() {
    let study = study(&[
        BASE[0],
        BASE[1],
        BASE[2],
        BASE[3],
        "mission.length_m=600000",
        "charging.public={ spacing_m = { distribution = \"exponential\", mean = 30000 }, power_w = \
         350000, end_at = 0.8, queue = { chargers = 4, arrivals_per_s = 0.0018, mean_charging_s = \
         1500 } }",
        "charging.stop={ power_w = 150000, begin_below = 0.7, end_at = 0.9, shortest_s = 600 }",
        "mission.stops={ spacing_m = 150000, dwell_s = 1800 }",
        DEPOT,
        EU,
    ]);
    let records = run(&study, 24);
    let (capacity_j, initial) = (1.944e9, 0.88);
    let mut arrived = 0;
    for record in &records {
        assert!(electric_balance(record).abs() < 1e-9, "{record:?}");
        assert!(open(record, 0.94).abs() < 1e-9, "{record:?}");
        let parts = [
            record.charged_energy_depot_j,
            record.charged_energy_public_j,
            record.charged_energy_stop_j,
        ];
        let [depot_j, public_j, stop_j] = parts.map(Option::unwrap);
        let total_j = record.charged_energy_j.unwrap();
        assert!((depot_j + public_j + stop_j - total_j).abs() < 1e-9 * total_j);
        let way_j = public_j + stop_j - record.amount(Carrier::Electricity).unwrap();
        let charge = record.final_charge.unwrap();
        assert!((initial + way_j / capacity_j - charge).abs() < 1e-9, "{record:?}");
        if record.outcome == Outcome::Completed {
            arrived += 1;
            assert!(charge > 0.1 && record.n_charging_stops.unwrap() > 0, "{record:?}");
            // ten hours at 141 kW fill any battery
            assert!((depot_j / capacity_j + charge - initial).abs() < 1e-9);
            assert!(record.depot_charging_s.unwrap() > 1000.0, "{record:?}");
        }
    }
    assert!(arrived > 15, "{arrived} of 24");
    for id in [0, 5] {
        let trace = trace(&study, 1, id);
        assert_eq!(trace.record, records[id as usize]);
        for charge in column(&trace, "state_of_charge") {
            assert!(*charge <= 0.9 && *charge > 0.099, "{charge}");
        }
    }
}

/// A truck that is plugged in for a day draws nothing from its battery: the meter counts its
/// auxiliaries.
#[test]
fn a_charger_carries_the_auxiliaries_as_long_as_the_truck_is_plugged_in() {
    let stop = |power_w: f64| {
        let sets = [
            "mission.length_m=90000",
            "vehicle.auxiliary_power_w=5000.0",
            "vehicle.powertrain.battery_electric.battery.initial_charge=0.7",
            "mission.stops={ spacing_m = 40000, dwell_s = 86400 }",
            "charging.public={ spacing_m = 4000000, power_w = 350000, wait_s = 0, end_at = 0.8 }",
            &format!(
                "charging.stop={{ power_w = {power_w}, begin_below = 0.95, end_at = 0.8, \
                 shortest_s = 600 }}"
            ),
        ];
        trace(&charging(&sets), 1, 0).record
    };
    let record = stop(100e3);
    let events = record.charging_events.as_ref().unwrap();
    assert!(!events.is_empty() && record.outcome == Outcome::Completed, "{record:?}");
    let n = events.len() as f64;
    let auxiliary_w = record.auxiliary_energy_j / (record.moving_s + 120.0 * n);
    let carried_j = record.charger_auxiliary_energy_j.unwrap();
    let said_j = auxiliary_w * (86_400.0 - 120.0) * n;
    assert!((carried_j / said_j - 1.0).abs() < 1e-9, "{carried_j} {said_j}");
    for event in events {
        assert!((event.end_charge - 0.8).abs() < 1e-9, "{event:?}");
        // the meter counts all of the day, and no more than the charger gives
        let quarters_j: f64 = event.quarter_hours_j.iter().sum();
        assert!((quarters_j / event.grid_energy_j - 1.0).abs() < 1e-9, "{event:?}");
        assert!(event.quarter_hours_j.len() >= 95 && event.peak_power_w * 0.94 <= 100e3 + 1e-6);
    }
    assert!(open(&record, 0.94).abs() < 1e-9 && electric_balance(&record).abs() < 1e-9);
    // weaker than the auxiliaries it charges nothing, and the truck stands until it is empty
    let weak = stop(4000.0);
    assert_eq!((weak.outcome, weak.final_charge), (Outcome::Depleted, Some(0.1)), "{weak:?}");
    assert!(electric_balance(&weak).abs() < 1e-9);
}

#[test]
fn a_rest_is_taken_at_the_last_charger_before_the_limit_and_the_truck_is_charged_in_it() {
    // a battery that need not be charged on the way
    let large = "vehicle.powertrain.battery_electric.battery.capacity_j=6.0e9";
    let study = charging(&[large, EU]);
    let (stands, record) = stands(&study, scenario(&study, 450e3));
    assert_eq!((stands.len(), record.n_rests), (1, Some(1)), "{stands:?}");
    let [at_m, stood_s, arrives, departs] = stands[0];
    // 4.5 h lead some 359 km far; sites lie 40 km apart
    assert!((at_m - 320e3).abs() < 1.0 && stood_s == 2700.0, "{stands:?}");
    assert!(departs > arrives + 0.05 && record.n_charging_stops == Some(1), "{stands:?}");
    // of the rest, 420 s are wait and plug
    assert!((record.charging_s.unwrap() - 2280.0).abs() < 1e-6, "{record:?}");
    // a stop that charges for 45 min is the rest
    let small = "vehicle.powertrain.battery_electric.battery.capacity_j=1.67e9";
    let study = charging(&["charging.public.power_w=250000", small, EU]);
    let (stands, record) = self::stands(&study, scenario(&study, 480e3));
    assert!(stands.iter().all(|stand| stand[1] >= 2700.0), "{stands:?}");
    assert_eq!((record.outcome, record.rest_s), (Outcome::Completed, Some(0.0)), "{stands:?}");
}

#[test]
fn records_are_the_same_on_every_cpu_in_every_order_and_alone() {
    let study = charging(&["mission.length_m=450000", DEPOT, EU]);
    let reference = drive(&study, 3, 0..24, CpuLevel::Baseline);
    assert!(reference.iter().any(|record| record.n_charging_stops.unwrap() > 0));
    for level in CpuLevel::ALL.into_iter().filter(|level| level.is_available()) {
        let mut parts = drive(&study, 3, 0..5, level);
        parts.extend(drive(&study, 3, 5..24, level));
        assert_eq!(parts, reference, "{}", level.name());
    }
    for record in reference.iter().step_by(7) {
        assert_eq!(&drive_scenario(&study, study.sample(3, record.cycle_id)), record);
    }
}

#[test]
fn chargers_belong_to_the_road_and_keep_their_places() {
    let own = charging(&[]);
    let other = charging(&[
        "charging.public.power_w={ distribution = \"uniform\", lower = 150000, upper = 400000 }",
        "vehicle.powertrain.battery_electric.battery.capacity_j=1e9",
        "charging.public.available_share=0.5",
    ]);
    for id in 0..20 {
        let (all, some) = (own.sample(2, id), other.sample(2, id));
        assert!(some.chargers.len() <= all.chargers.len());
        for charger in &some.chargers {
            assert!(all.chargers.iter().any(|one| one.position_m == charger.position_m));
        }
        assert_eq!(all.cycle.road.events, some.cycle.road.events);
    }
    // a diesel truck has no use of them
    let text = "[study]\nname = \"c\"\ndescription = \"d\"\nbase = \"field-truck\"\n";
    let diesel = load_text("c.toml", text, &BASE).unwrap().study;
    let plain = load_text::<&str>("c.toml", text, &[]).unwrap().study;
    assert_eq!(run(&diesel, 12), run(&plain, 12));
}

#[test]
fn without_chargers_a_policy_changes_nothing_but_its_columns() {
    let plain = run(&study(&[]), 12);
    let policy = run(&study(&["charging.reserve=0.1", "charging.efficiency=0.9"]), 12);
    for (plain, policy) in plain.into_iter().zip(policy) {
        let same = Record {
            charged_energy_public_j: None,
            charged_energy_stop_j: None,
            grid_energy_public_j: None,
            grid_energy_stop_j: None,
            n_charging_stops: None,
            charging_s: None,
            charging_wait_s: None,
            charging_events: None,
            lowest_charge: None,
            charger_auxiliary_energy_j: None,
            // the meter counts the charger's losses
            grid_co2_g_per_km: plain.grid_co2_g_per_km,
            well_to_wheel_g_per_km: plain.well_to_wheel_g_per_km,
            well_to_wheel_g_per_tkm: plain.well_to_wheel_g_per_tkm,
            ..policy
        };
        assert_eq!((same, policy.n_charging_stops), (plain, Some(0)));
    }
}

#[test]
fn wrong_charging_is_refused_by_name() {
    let refused = |sets: &[&str]| {
        let text = "[study]\nname = \"c\"\ndescription = \"d\"\nbase = \"battery-truck\"\n";
        load_text("c.toml", text, &[&BASE[..], sets].concat()).unwrap_err().to_string()
    };
    let named = |sets: &[&str], words: &[&str]| {
        let error = refused(sets);
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    named(&["charging.public.power_w=-1"], &["charging.public.power_w", "-1"]);
    named(&["charging.reserve=1.5"], &["charging.reserve", "1.5"]);
    named(&["charging.forecast.margin=-0.1"], &["charging.forecast.margin", "-0.1"]);
    named(&["charging.public.end_at=0.1"], &["charging.public.end_at", "charging.reserve"]);
    let beyond = "charging.public={ positions_m = [1000, 90000], power_w = 3e5, end_at = 0.8 }";
    named(&[beyond, "mission.length_m=80000"], &["charging.public.positions_m", "90000", "80000"]);
    let rises = "charging.curve={ charge = [0.2, 0.8], power_w = [1e5, 2e5] }";
    named(&[rises], &["charging.curve.power_w", "200000 after 100000"]);
    let unpaired = "charging.curve={ charge = [0.2, 0.8], power_w = [1e5] }";
    named(&[unpaired], &["charging.curve.power_w", "1 powers for 2 charges"]);
    let both = "charging.public.positions_m=[1000]";
    named(&[both], &["charging.public.positions_m", "spacing_m"]);
    let text = "[study]\nname = \"c\"\ndescription = \"d\"\nbase = \"electric-long-haul\"\n\
                drop = [\"charging.forecast\"]\n";
    let error = load_text::<&str>("c.toml", text, &[]).unwrap_err().to_string();
    assert!(error.contains("charging.forecast") && error.contains("absent"), "{error}");
    let queue =
        "charging.public.queue={ chargers = 1, arrivals_per_s = 0.1, mean_charging_s = 60 }";
    named(&[queue], &["charging.public.queue", "wait_s", "arrivals_per_s"]);
}
