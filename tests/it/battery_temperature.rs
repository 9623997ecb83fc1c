//! The temperature of a battery: where it does nothing the records are those without it, its heat
//! is kept, and what is cold drives and charges worse.

use crate::common::{GivenRoad, column, electric_balance, run};
use ocmc_core::energy::Carrier;
use ocmc_core::kernel::drive::scheduler::drive_scenario;
use ocmc_core::kernel::drive::trace::{trace, trace_scenario};
use ocmc_core::record::{Outcome, Record};
use ocmc_core::study::Study;
use ocmc_io::study::load_text;

/// A node that has no effect.
const NEUTRAL: &str = "vehicle.powertrain.battery_electric.battery.thermal={ heat_capacity_j_per_k \
                       = 3e6, air_w_per_k = 42, heat_below_k = 283.15, heater_w = 0, heater_ratio \
                       = 1, cool_above_k = 306.15, cooler_w = 0, cooler_ratio = 3, temperature_k = \
                       [293.15], charge = [0.5], resistance_factor = [[1]], discharge_share = [1], \
                       charge_share = [1] }";
/// Properties of a battery of the built-in electric studies.
const REAL: [&str; 8] = [
    NEUTRAL,
    "vehicle.powertrain.battery_electric.battery.thermal.heater_w=11200",
    "vehicle.powertrain.battery_electric.battery.thermal.cooler_w=10000",
    "vehicle.powertrain.battery_electric.battery.thermal.temperature_k=[273.15, 293.15, 313.15]",
    "vehicle.powertrain.battery_electric.battery.thermal.charge=[0.1, 0.5]",
    "vehicle.powertrain.battery_electric.battery.thermal.resistance_factor=[[2.4, 1.6], [1.3, \
     1.0], [0.9, 0.8]]",
    "vehicle.powertrain.battery_electric.battery.thermal.discharge_share=[0.7, 1, 1]",
    "vehicle.powertrain.battery_electric.battery.thermal.charge_share=[0.35, 1, 1]",
];
const PUBLIC: &str = "charging={ reserve = 0.15, forecast = { consumption_j_per_m = 4500, margin = \
                      0.1 }, efficiency = 0.94, connection_s = 120, public = { spacing_m = 40000, \
                      power_w = 350000, wait_s = 300, end_at = 0.8 } }";
const COLD: &str = "weather.temperature.mean_k=263.15";
const STEADY: &str = "simulation.without=[\"driver_spread\", \"vehicle_spread\"]";

fn study(sets: &[&str]) -> Study {
    let text = "[study]\nname = \"t\"\ndescription = \"d\"\nbase = \"battery-truck\"\n";
    load_text("t.toml", text, sets).unwrap().study
}

fn with(sets: &[&str]) -> Study {
    study(&[&REAL[..], sets].concat())
}

/// A level road at 80 km/h in air of a temperature, with a charger each 40 km.
fn level(study: &Study, length_m: f64, air_k: f64) -> Record {
    let mut scenario = GivenRoad::flat(length_m, 80.0 / 3.6).scenario(study);
    for stretch in &mut scenario.cycle.weather {
        stretch.weather.temperature_k = air_k;
    }
    let streams = ocmc_core::random::Streams::new(1, 0);
    let public = study.model().charging.as_ref().and_then(|charging| charging.public.as_ref());
    scenario.chargers = public.map_or(Vec::new(), |public| public.sample(length_m, &[], &streams));
    drive_scenario(study, scenario)
}

#[test]
fn a_temperature_without_effect_changes_nothing_but_its_columns() {
    let sets = ["mission.length_m=400000", PUBLIC, "rest.law=\"eu_561\""];
    let plain = run(&study(&sets), 16);
    let neutral = run(&study(&[&sets[..], &[NEUTRAL]].concat()), 16);
    let charged: u32 = plain.iter().map(|record| record.n_charging_stops.unwrap()).sum();
    assert!(charged > 8, "{charged}");
    for (plain, neutral) in plain.into_iter().zip(neutral) {
        assert_eq!(neutral.battery_conditioning_energy_j, Some(0.0));
        assert!(neutral.final_battery_temperature_k.unwrap() > 283.0);
        let same = Record {
            battery_conditioning_energy_j: None,
            final_battery_temperature_k: None,
            // charging is integrated slice by slice
            ..neutral.clone()
        };
        if plain.n_charging_stops == Some(0) {
            assert_eq!(same, plain);
        }
        assert!((same.duration_s / plain.duration_s - 1.0).abs() < 1e-6, "{plain:?}");
        let pair = [neutral.amount(Carrier::Electricity), plain.amount(Carrier::Electricity)]
            .map(Option::unwrap);
        assert!((pair[0] / pair[1] - 1.0).abs() < 1e-6, "{pair:?}");
    }
}

#[test]
fn the_heat_of_a_battery_that_is_closed_stays_in_it() {
    let closed =
        study(&[NEUTRAL, "vehicle.powertrain.battery_electric.battery.thermal.air_w_per_k=0"]);
    for id in 0..6 {
        let trace = trace(&closed, 1, id);
        let heat_j: f64 = column(&trace, "battery_loss_added_j").iter().sum();
        let air_k = trace.record.air_temperature_k;
        let risen_k = trace.record.final_battery_temperature_k.unwrap() - air_k.max(283.15);
        assert!((risen_k * 3e6 / heat_j - 1.0).abs() < 1e-6, "{risen_k} {heat_j}");
        assert!(risen_k > 0.3, "{risen_k}");
    }
}

#[test]
fn on_cold_trips_the_balance_closes_and_heating_is_a_part_of_the_auxiliaries() {
    let sets = ["mission.length_m=400000", PUBLIC, COLD, "rest.law=\"eu_561\""];
    let ahead = "vehicle.powertrain.battery_electric.battery.thermal.precondition={ up_to_k = \
                 303.15, ahead_m = 30000 }";
    let (cold, without) = (run(&with(&[&sets[..], &[ahead]].concat()), 16), run(&study(&sets), 16));
    assert!(cold.iter().any(|record| record.n_rests > Some(0)));
    let mut more = 0.0;
    for (record, without) in cold.iter().zip(&without) {
        assert!(electric_balance(record).abs() < 1e-9, "{record:?}");
        assert_eq!(record.outside_map_energy_j, without.outside_map_energy_j);
        let heating_j = record.battery_conditioning_energy_j.unwrap();
        let stops = record.n_charging_stops.unwrap();
        assert!(heating_j < record.auxiliary_energy_j && (stops == 0 || heating_j > 0.0));
        assert!(record.final_battery_temperature_k.unwrap() > 280.0, "{record:?}");
        assert!(without.battery_conditioning_energy_j.is_none());
        more += record.consumption(Carrier::Electricity).unwrap()
            - without.consumption(Carrier::Electricity).unwrap();
    }
    // up to a third more resistance, where 3 % were lost, and the heater
    let more = more / 16.0;
    assert!(more > 0.005 && more < 0.2, "{more}");
}

#[test]
fn what_the_auxiliaries_take_without_heater_and_cooler_is_as_it_was() {
    let (steady, sets) = (with(&[STEADY]), study(&[STEADY]));
    for air_k in [263.15, 283.15, 308.15] {
        let [warm, plain] = [&steady, &sets].map(|study| level(study, 90e3, air_k));
        let own_j = warm.auxiliary_energy_j - warm.battery_conditioning_energy_j.unwrap();
        let per_s = own_j / warm.duration_s;
        assert!((per_s * plain.duration_s / plain.auxiliary_energy_j - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_cold_battery_charges_slower_and_one_that_was_prepared_faster() {
    let ahead = "vehicle.powertrain.battery_electric.battery.thermal.precondition={ up_to_k = \
                 298.15, ahead_m = 80000 }";
    // a battery that the air cools down, and a heater that is stronger
    let sets = [
        PUBLIC,
        STEADY,
        "vehicle.powertrain.battery_electric.battery.thermal.heater_ratio=3",
        "vehicle.powertrain.battery_electric.battery.thermal.air_w_per_k=300",
    ];
    let [warm, cold, prepared] = [
        level(&with(&sets), 400e3, 298.15),
        level(&with(&sets), 400e3, 258.15),
        level(&with(&[&sets[..], &[ahead]].concat()), 400e3, 258.15),
    ];
    for record in [&warm, &cold, &prepared] {
        assert_eq!((record.outcome, record.n_charging_stops), (Outcome::Completed, Some(1)));
        assert!(electric_balance(record).abs() < 1e-9, "{record:?}");
    }
    let pace =
        |record: &Record| record.charged_energy_public_j.unwrap() / record.charging_s.unwrap();
    // the charger carries what heats a battery, of the cold one for longer
    let paces = [pace(&warm), pace(&prepared), pace(&cold)];
    assert!(paces[0] > 0.99 * paces[1] && paces[1] > 1.02 * paces[2], "{paces:?}");
    let heating = [&cold, &prepared].map(|record| record.battery_conditioning_energy_j.unwrap());
    assert!(heating[1] > heating[0], "{heating:?}");
}

#[test]
fn a_curve_for_cold_batteries_holds_for_them() {
    let curve = "charging.curve={ charge = [0.1, 0.9], power_w = [300000, 300000], by_temperature \
                 = [{ temperature_k = 283.15, power_w = [100000, 100000] }, { temperature_k = \
                 290.15, power_w = [300000, 300000] }] }";
    let cold = study(&[
        NEUTRAL,
        PUBLIC,
        STEADY,
        curve,
        "vehicle.powertrain.battery_electric.battery.thermal.air_w_per_k=10000",
    ]);
    // a battery of 10 °C, and one of 25 °C: air that holds them there
    let [slow, fast] = [283.0, 298.15].map(|air_k| level(&cold, 400e3, air_k));
    let pace =
        |record: &Record| record.charged_energy_public_j.unwrap() / record.charging_s.unwrap();
    let share = pace(&slow) / pace(&fast);
    assert!(share > 0.3 && share < 0.6, "{share}");
}

#[test]
fn traces_are_the_same_and_wrong_temperatures_are_refused_by_name() {
    let study = with(&["mission.length_m=300000", PUBLIC, COLD]);
    let records = run(&study, 4);
    for id in [0, 3] {
        assert_eq!(trace(&study, 1, id).record, records[id as usize]);
    }
    let scenario = study.sample(1, 2);
    assert_eq!(trace_scenario(&study, scenario).record, records[2]);
    let named = |set: &str, words: &[&str]| {
        let text = "[study]\nname = \"t\"\ndescription = \"d\"\nbase = \"battery-truck\"\n";
        let error = load_text("t.toml", text, &[&REAL[..], &[set]].concat()).unwrap_err();
        let error = error.to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    let key = |name: &str| format!("vehicle.powertrain.battery_electric.battery.thermal.{name}");
    named(&key("cool_above_k=280"), &["thermal.cool_above_k", "280", "283.15"]);
    named(&key("temperature_k=[293, 283, 303]"), &["thermal.temperature_k", "rising"]);
    named(&key("resistance_factor=[[1.0, 1.0]]"), &["resistance_factor", "3 rows of 2"]);
    named(&key("charge_share=[1.0]"), &["charge_share", "1 numbers", "3"]);
    named(&key("discharge_share=[1.2, 1, 1]"), &["discharge_share", "1.2"]);
}
