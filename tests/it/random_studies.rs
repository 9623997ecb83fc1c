//! Random studies of battery-electric trucks over charging, rests, chains and stops: whatever a
//! study asks for, no truck has less than no charge or more than all, no number is missing or
//! endless, energy adds up, and no interval stands without its estimate. `OCMC_RANDOM_STUDIES=5000`
//! tries so many.

use crate::common::{column, electric_balance};
use ocmc_core::kernel::drive::trace::trace;
use ocmc_core::random::{Draws, Stream};
use ocmc_core::record::{COLUMNS, Outcome, Record};
use ocmc_core::study::Study;
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::run::{RunPlan, records};
use ocmc_fleet::summary::SummaryBuilder;
use ocmc_io::study::load_text;
use serde_json::Value;
use std::convert::Infallible;
use std::ops::ControlFlow;

/// Cycles of each study.
const CYCLES: u64 = 8;

/// Numbers and choices of a study.
pub(crate) struct Chance(pub(crate) Draws);

impl Chance {
    fn is(&mut self, share: f64) -> bool {
        self.0.uniform() < share
    }

    pub(crate) fn below(&mut self, end: usize) -> usize {
        (self.0.uniform() * end as f64) as usize
    }

    pub(crate) fn one<'a>(&mut self, words: &[&'a str]) -> &'a str {
        words[self.below(words.len())]
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }

    /// Any size from one end to the other is as likely.
    pub(crate) fn size(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.0.uniform())
    }
}

/// Base of a study, and its settings.
fn settings(chance: &mut Chance) -> (&'static str, Vec<String>) {
    let base = chance.one(&["battery-truck", "electric-regional", "electric-long-haul"]);
    let battery = "vehicle.powertrain.battery_electric.battery";
    let minimum = chance.between(0.01, 0.3);
    let reserve = minimum + chance.between(0.0, 0.3);
    let (has_public, has_depot) = (chance.is(0.6), chance.is(0.5));
    let initial = chance.between(if has_public { minimum } else { reserve }, 1.0);
    let length_m = chance.size(2e3, 200e3);
    let mut sets = vec![
        format!("mission.length_m={length_m}"),
        format!("{battery}.minimum_charge={minimum}"),
        format!("{battery}.initial_charge={initial}"),
        format!("{battery}.capacity_j={}", chance.size(5e7, 3e9)),
        format!("vehicle.auxiliary_power_w={}", chance.size(100.0, 2e4)),
        format!("weather.temperature.mean_k={}", chance.between(250.0, 305.0)),
    ];
    let mut charging = vec![format!(
        "reserve = {reserve}, efficiency = {}, connection_s = {}",
        chance.between(0.5, 1.0),
        chance.between(0.0, 600.0)
    )];
    if has_public {
        let (consumption, margin) = (chance.size(1e3, 1e4), chance.between(0.0, 0.5));
        charging.push(format!(
            "forecast = {{ consumption_j_per_m = {consumption}, margin = {margin} }}"
        ));
        charging.push(format!(
            "public = {{ spacing_m = {}, power_w = {}, wait_s = {}, end_at = {} }}",
            chance.size(2e3, 1e5),
            chance.size(1e3, 1e6),
            chance.size(1.0, 2e4),
            chance.between(reserve, 1.0)
        ));
    }
    if has_depot {
        let (power_w, parked_s) = (chance.size(1e3, 3e5), chance.size(60.0, 5e4));
        charging.push(format!("depot = {{ power_w = {power_w}, parked_s = {parked_s} }}"));
    }
    if chance.is(0.5) {
        let (spacing_m, dwell_s) = (chance.size(1e3, 1e5), chance.size(1.0, 86_400.0));
        sets.push(format!("mission.stops={{ spacing_m = {spacing_m}, dwell_s = {dwell_s} }}"));
        if chance.is(0.6) {
            charging.push(format!(
                "stop = {{ power_w = {}, begin_below = {}, end_at = 1.0, shortest_s = {} }}",
                chance.size(1e3, 4e5),
                chance.between(0.3, 1.0),
                chance.size(1.0, 3600.0)
            ));
        }
    }
    sets.push(format!("charging={{ {} }}", charging.join(", ")));
    if chance.is(0.4) {
        sets.push(format!("rest.law=\"{}\"", chance.one(&["eu_561", "us_395_3"])));
    }
    if chance.is(0.4) {
        let trips = if chance.is(0.5) { 1 } else { 2 };
        sets.push(format!("fleet.trips_per_truck={}", if chance.is(0.5) { 4 } else { 8 }));
        sets.push(format!(
            "fleet.calendar={{ operating_days_per_week = {}, trips_per_day = {trips}, \
             departure_interval_s = {}, chain = {} }}",
            if chance.is(0.5) { 5 } else { 7 },
            if trips == 1 { 0.0 } else { chance.size(60.0, 43_200.0) },
            has_depot && chance.is(0.7)
        ));
    }
    (base, sets)
}

/// A study; none where one of its rules refuses the settings, which is said in words.
fn study(base: &str, sets: &[String]) -> Option<Study> {
    let drop = match base {
        "electric-long-haul" => "\"charging\", \"rest\"",
        "electric-regional" => "\"charging\", \"mission.stops\"",
        _ => "",
    };
    let text =
        format!("[study]\nname = \"r\"\ndescription = \"d\"\nbase = \"{base}\"\ndrop = [{drop}]\n");
    match load_text("r.toml", &text, sets) {
        Ok(loaded) => Some(loaded.study),
        Err(error) => {
            let said = error.to_string();
            assert!(said.contains("allowed"), "{said}");
            None
        }
    }
}

/// Every number is one, and every charge between none and all.
pub(crate) fn check_numbers(record: &Record) {
    for column in COLUMNS {
        let number = column.get(record).number();
        assert!(number.is_none_or(f64::is_finite), "{}: {record:?}", column.name);
        let is_charge = column.name.ends_with("_charge") && !column.name.starts_with("n_");
        let is_share = number.is_none_or(|charge| (0.0..=1.0).contains(&charge));
        assert!(!is_charge || is_share, "{}: {record:?}", column.name);
    }
    for event in record.charging_events.iter().flatten() {
        for charge in [event.begin_charge, event.end_charge] {
            assert!((0.0..=1.0).contains(&charge), "{event:?}");
        }
    }
}

fn check(record: &Record) {
    check_numbers(record);
    if matches!(record.outcome, Outcome::Completed | Outcome::Depleted) {
        assert!(electric_balance(record).abs() < 1e-9, "{record:?}");
    }
}

/// An interval stands beside a number that it is of.
pub(crate) fn check_intervals(value: &Value) {
    if let Value::Object(items) = value {
        let interval = items.get("ci95").filter(|ci95| ci95.is_array());
        let estimate = |(name, value): (&String, &Value)| name != "ci95" && value.is_number();
        assert!(interval.is_none() || items.iter().any(estimate), "{value}");
    }
    match value {
        Value::Object(items) => items.values().for_each(check_intervals),
        Value::Array(items) => items.iter().for_each(check_intervals),
        _ => {}
    }
}

#[test]
fn charge_energy_and_intervals_of_random_studies() {
    let asked = std::env::var("OCMC_RANDOM_STUDIES");
    let wanted: u64 = asked.map_or(200, |number| number.parse().expect("a number"));
    let mut driven = 0;
    for seed in 0..wanted {
        let (base, sets) = settings(&mut Chance(Draws::new(seed, 0, Stream::Vehicle)));
        println!("{seed}: {base} {sets:?}");
        let Some(study) = study(base, &sets) else { continue };
        driven += 1;
        let plan = RunPlan::new(seed, 0, CYCLES, Some(1), None);
        let ControlFlow::Continue(records) =
            records(&study, &plan, |_| ControlFlow::<Infallible>::Continue(()));
        records.iter().for_each(check);
        let mut fleet = SummaryBuilder::new(Dependence::of(study.model(), seed));
        fleet.add(&records);
        check_intervals(&serde_json::to_value(fleet.finish()).expect("numbers and words"));
        // a trip that stands alone can be traced
        if study.chains() {
            continue;
        }
        let trace = trace(&study, seed, seed % CYCLES);
        for signal in &trace.columns {
            let missing = signal.values.iter().position(|value| !value.is_finite());
            assert_eq!(missing, None, "{}", signal.name);
        }
        let charges = column(&trace, "state_of_charge");
        assert!(charges.iter().all(|charge| (0.0..=1.0).contains(charge)), "{:?}", trace.record);
    }
    // most settings are a study
    assert!(10 * driven >= 6 * wanted, "{driven} of {wanted}");
    println!("{driven} of {wanted} were driven");
}
