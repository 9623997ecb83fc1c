//! Limits that hold under every policy of charging: the state of charge, and what a larger battery,
//! a lighter load and warmer air do to who arrives.

use crate::common::{column, electric_balance, run};
use ocmc_core::kernel::drive::trace::trace;
use ocmc_core::record::{Outcome, Record};
use ocmc_core::study::Study;
use ocmc_io::study::load_text;
use proptest::prelude::*;

/// A step draws no more than this of any battery here.
const STEP: f64 = 1e-3;

fn study(base: &str, sets: &[String]) -> Study {
    let queue = if base == "electric-long-haul" { "\"charging.public.queue\"" } else { "" };
    let text = format!(
        "[study]\nname = \"l\"\ndescription = \"d\"\nbase = \"{base}\"\n\
         drop = [{queue}]\n"
    );
    load_text("l.toml", &text, sets).unwrap().study
}

#[derive(Clone, Debug)]
struct Policy {
    base: &'static str,
    reserve: f64,
    spacing_m: f64,
    power_w: f64,
    end_at: f64,
    enough: Option<(&'static str, f64)>,
    stops: bool,
    dwell_s: f64,
    stop_power_w: f64,
    rests: bool,
    initial_charge: f64,
    cycle_id: u64,
}

impl Policy {
    fn study(&self) -> Study {
        let Self { reserve, spacing_m, power_w, end_at, initial_charge, .. } = self;
        let mut sets = vec![
            "mission.length_m=350000".to_owned(),
            format!("vehicle.powertrain.battery_electric.battery.initial_charge={initial_charge}"),
            format!(
                "charging={{ reserve = {reserve}, forecast = {{ consumption_j_per_m = 4500, margin \
                 = 0.1 }}, efficiency = 0.93, connection_s = 100, public = {{ spacing_m = \
                 {spacing_m}, power_w = {power_w}, wait_s = 60, end_at = {end_at} }} }}"
            ),
        ];
        if let Some((reach, margin)) = self.enough {
            let enough = format!("{{ reach = \"{reach}\", margin = {margin} }}");
            sets.push(format!("charging.public.enough={enough}"));
        }
        if self.stops {
            let Self { dwell_s, stop_power_w, .. } = self;
            sets.push(format!("mission.stops={{ spacing_m = 90000, dwell_s = {dwell_s} }}"));
            sets.push(format!(
                "charging.stop={{ power_w = {stop_power_w}, begin_below = 0.95, end_at = 1.0, \
                 shortest_s = 600 }}"
            ));
        }
        if self.rests {
            sets.push("rest.law=\"us_395_3\"".to_owned());
        }
        study(self.base, &sets)
    }
}

fn policies() -> impl Strategy<Value = Policy> {
    let base = prop_oneof![Just("battery-truck"), Just("electric-long-haul")];
    let enough = prop_oneof![
        Just(None),
        (0.0..0.5).prop_map(|margin| Some(("destination", margin))),
        (0.0..0.5).prop_map(|margin| Some(("next_charger", margin))),
    ];
    let power_w = prop_oneof![1e3..1e4, 5e4..1e6];
    let stop = (prop_oneof![1500.0..2000.0, 2000.0..86_400.0], prop_oneof![1e3..1e4, 5e4..2e5]);
    let numbers = (0.0..0.4, 20e3..120e3, power_w, 0.45..1.0, 0.5..1.0);
    (base, enough, numbers, any::<bool>(), stop, any::<bool>(), 0_u64..1000).prop_map(
        |(base, enough, numbers, stops, (dwell_s, stop_power_w), rests, cycle_id)| {
            let (reserve, spacing_m, power_w, end_at, initial_charge) = numbers;
            Policy {
                base,
                reserve,
                spacing_m,
                power_w,
                end_at,
                enough,
                stops,
                dwell_s,
                stop_power_w,
                rests,
                initial_charge,
                cycle_id,
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 40, failure_persistence: None, ..ProptestConfig::default()
    })]

    #[test]
    fn the_charge_keeps_its_bounds_whatever_the_policy(policy in policies()) {
        let study = policy.study();
        let trace = trace(&study, 1, policy.cycle_id);
        let record = &trace.record;
        // the battery's own lowest charge: a wrong forecast uses the reserve
        let lowest = 0.1;
        let charges = column(&trace, "state_of_charge");
        for charge in charges {
            prop_assert!(*charge <= 1.0 && *charge > lowest - STEP, "{charge} {record:?}");
        }
        let last = record.final_charge.unwrap();
        match record.outcome {
            Outcome::Completed => prop_assert!(last > lowest - STEP, "{record:?}"),
            Outcome::Depleted => prop_assert!(last <= lowest, "{record:?}"),
            outcome => prop_assert!(false, "{outcome:?}"),
        }
        let below = charges[..charges.len() - 1].iter().any(|charge| *charge <= lowest);
        prop_assert!(!below, "{record:?}");
        // and the record tells
        let arrivals = record.charging_events.iter().flatten().map(|event| event.begin_charge);
        prop_assert_eq!(record.lowest_charge.unwrap(), arrivals.fold(last, f64::min));
        prop_assert!(electric_balance(record).abs() < 1e-9, "{record:?}");
    }
}

/// Share of the trips that arrive.
fn arrive(sets: &[String]) -> usize {
    let depot = "charging={ reserve = 0.12, efficiency = 0.94 }".to_owned();
    let study = study("electric-regional", &[&[depot][..], sets].concat());
    run(&study, 60).iter().filter(|record| record.outcome == Outcome::Completed).count()
}

#[test]
fn more_trips_arrive_with_a_larger_battery_a_lighter_load_and_in_warmer_air() {
    let battery = |kwh: f64| {
        format!("vehicle.powertrain.battery_electric.battery.capacity_j={}", kwh * 3.6e6)
    };
    let load = |kg: f64| format!("mission.payload_kg={kg}");
    let air = |kelvin: f64| format!("weather.temperature.mean_k={kelvin}");
    let ladders = [
        [250.0, 300.0, 350.0, 400.0, 450.0].map(|kwh| arrive(&[battery(kwh), load(10e3)])),
        [19e3, 14e3, 9e3, 4e3, 0.0].map(|kg| arrive(&[battery(330.0), load(kg)])),
        [253.15, 261.15, 269.15, 277.15, 285.15]
            .map(|k| arrive(&[battery(350.0), load(10e3), air(k)])),
    ];
    for counts in ladders {
        assert!(counts.is_sorted() && counts[0] < counts[4], "{counts:?}");
    }
}

fn enough(sets: &[&str]) -> Vec<Record> {
    let policy = "charging={ reserve = 0.15, forecast = { consumption_j_per_m = 4500, margin = 0.1 \
                  }, efficiency = 0.94, public = { spacing_m = 40000, power_w = 350000, end_at = \
                  0.8 } }";
    // a thirsty truck, on old tyres: it has to charge more than once
    let truck = ["vehicle.rolling_factor=1.3", "vehicle.drag_area_m2=5.3"];
    let all: Vec<String> = ["mission.length_m=400000", policy, truck[0], truck[1]]
        .iter()
        .chain(sets)
        .map(|set| (*set).to_owned())
        .collect();
    run(&study("battery-truck", &all), 40)
}

#[test]
fn who_charges_no_more_than_enough_arrives_sooner_and_with_little_more_than_the_reserve() {
    let full = enough(&[]);
    let goal = enough(&["charging.public.enough={ reach = \"destination\", margin = 0.1 }"]);
    let next = enough(&["charging.public.enough={ reach = \"next_charger\", margin = 0.1 }"]);
    let sum = |records: &[Record], of: fn(&Record) -> f64| records.iter().map(of).sum::<f64>();
    let charged = |record: &&Record| record.n_charging_stops > Some(0);
    let arrived = |records: &[Record]| {
        records.iter().filter(|record| record.outcome == Outcome::Completed).count()
    };
    assert_eq!([arrived(&goal), arrived(&next)], [arrived(&full); 2]);
    let duration = |record: &Record| record.duration_s;
    assert!(sum(&goal, duration) < sum(&full, duration));
    // who needs a charger needs one with either; of those that needed none nothing changes
    for (full, goal) in full.iter().zip(&goal) {
        if full.n_charging_stops == Some(0) {
            assert_eq!(full, goal);
        }
        assert!(goal.n_charging_stops >= full.n_charging_stops);
    }
    let left = |records: &[Record]| {
        let with = records.iter().filter(charged);
        let charges: Vec<f64> = with.map(|record| record.final_charge.unwrap()).collect();
        charges.iter().sum::<f64>() / charges.len() as f64
    };
    assert!(
        left(&goal) > 0.1 && left(&goal) < left(&full) - 0.05,
        "{} {}",
        left(&goal),
        left(&full)
    );
    let stops = |record: &Record| f64::from(record.n_charging_stops.unwrap());
    assert!(sum(&next, stops) > 1.2 * sum(&goal, stops));
}
