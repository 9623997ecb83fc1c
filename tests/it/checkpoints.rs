//! A trip into which a rest is put goes on from a checkpoint on its way: its record is, to the bit,
//! that of a trip that is driven again from its start, and fewer steps are driven. Of a trip that
//! charges nothing is driven again: its driver decides on his way.

use fearless_simd::prelude::*;
use ocmc_core::kernel::lane_task::LaneTask;
use ocmc_core::kernel::scheduler::{Observer, drive_observed, sampled};
use ocmc_core::kernel::state::{KernelParameters, State};
use ocmc_core::kernel::step_view::StepView;
use ocmc_core::powertrain::{Powertrain, PowertrainTask};
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_io::study::load_text;

const CYCLES: u64 = 24;
const EU: &str = "rest.law=\"eu_561\"";
const PUBLIC: &str = "charging={ reserve = 0.15, forecast = { consumption_j_per_m = 4500, margin = 0.1 }, efficiency = 0.94, connection_s = 120, public = { spacing_m = { distribution = \"exponential\", mean = 30000 }, power_w = 350000, wait_s = 300, end_at = 0.8 }, stop = { power_w = 150000, begin_below = 0.7, end_at = 0.9, shortest_s = 600 } }";
const STOPS: &str = "mission.stops={ spacing_m = 150000, dwell_s = 1800 }";
/// A battery that lasts.
const LARGE: &str = "vehicle.electric.battery.capacity_j=6e9";
const LONG: &str = "mission.length_m=600000";

/// Counts the steps of all trucks.
struct Steps<const FROM_START: bool>(usize);

impl<const FROM_START: bool> Observer for Steps<FROM_START> {
    const FROM_START: bool = FROM_START;

    fn after_step<S: Simd, P: Powertrain>(
        &mut self,
        _parameters: &KernelParameters<P>,
        _state: &State<S, P>,
        _view: &StepView<S>,
        tasks: &[Option<LaneTask>],
    ) {
        self.0 += tasks.iter().flatten().count();
    }
}

/// Drives the first cycles; the records, and the steps that they took.
struct Driven<'a, const FROM_START: bool>(&'a Study);

impl<const FROM_START: bool> PowertrainTask for Driven<'_, FROM_START> {
    type Answer = (Vec<Record>, usize);

    fn run<P: Powertrain>(self, powertrain: &P) -> Self::Answer {
        let mut steps = Steps::<FROM_START>(0);
        let next = &mut sampled(self.0, 1, 0..CYCLES);
        (drive_observed(self.0, powertrain, next, &mut steps), steps.0)
    }
}

/// The steps from checkpoints over those from the start, and the records of both.
fn compare(base: &str, drop: &str, sets: &[&str]) -> (f64, Vec<Record>) {
    let text =
        format!("[study]\nname = \"c\"\ndescription = \"d\"\nbase = \"{base}\"\ndrop = [{drop}]\n");
    let study = load_text("c.toml", &text, sets).unwrap().study;
    let powertrain = &study.vehicle().powertrain;
    let (again, all) = powertrain.dispatch(Driven::<true>(&study));
    let (records, steps) = powertrain.dispatch(Driven::<false>(&study));
    for (record, again) in records.iter().zip(&again) {
        assert_eq!(record, again, "{base} {sets:?}");
    }
    assert_eq!(records.len(), CYCLES as usize);
    (steps as f64 / all as f64, records)
}

const OWN: &str = "\"vehicle.electric.charging\"";

#[test]
fn nothing_of_charging_trips_is_driven_again() {
    let (share, records) = compare("battery-truck", OWN, &[LONG, PUBLIC, STOPS, EU]);
    let stops: u32 = records.iter().map(|record| record.n_charging_stops.unwrap()).sum();
    assert!(stops > 2 * CYCLES as u32, "{stops}");
    assert_eq!(share, 1.0);
}

#[test]
fn trips_with_rests_go_on_as_if_they_had_begun_at_their_start() {
    let kinds = "simulation.columns_by=[\"road_type\", \"event_kind\"]";
    let coasting = "driver.look_ahead.coasting=true";
    let (share, records) = compare("battery-truck", OWN, &[LONG, LARGE, EU, kinds, coasting]);
    assert!(records.iter().all(|record| record.n_rests.unwrap() > 0));
    assert!(share < 0.75, "{share}");
}

#[test]
fn so_do_those_of_diesel_trucks_with_rests() {
    let eco = "driver.look_ahead.eco_roll=true";
    let stops = "mission.stops={ spacing_m = 150000, dwell_s = 600 }";
    for sets in [&[LONG, EU, eco][..], &[LONG, EU, stops]] {
        let (share, records) = compare("long-haul", "", sets);
        assert!(records.iter().all(|record| record.n_rests.unwrap() > 0));
        assert!(share < 0.75, "{share}");
    }
}

#[test]
fn so_do_those_whose_battery_has_a_temperature() {
    let sets = [LONG, LARGE, STOPS, EU, "weather.temperature.mean_k=268.15"];
    let (share, records) = compare("electric-regional", "\"charging\"", &sets);
    let heating_j: f64 =
        records.iter().map(|record| record.battery_conditioning_energy_j.unwrap()).sum();
    assert!(share < 0.75 && heating_j > 1e7, "{share} {heating_j}");
}
