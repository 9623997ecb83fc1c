//! The books of every cycle close, and the fuel is the map's.

use crate::common::{balance, column, diesel, electric_balance, run, start_speeds_radps, study};
use fearless_simd::{Level, dispatch, prelude::*};
use ocmc_core::energy::Carrier;
use ocmc_core::energy::ledger::{Ledger, Place, Recorded, TERMS, Term};
use ocmc_core::kernel::drive::trace::trace;
use ocmc_core::lanes::Lanes;
use ocmc_core::powertrain::component::engine::Engine;
use ocmc_core::powertrain::{Powertrain, PowertrainTask};
use ocmc_core::record::{self, COLUMNS, Cell, Outcome};

/// The sources of a powertrain in the balance.
struct Sources;

impl PowertrainTask for Sources {
    type Answer = &'static [Term];

    fn run<P: Powertrain>(self, _powertrain: &P) -> &'static [Term] {
        P::SOURCES
    }
}

#[test]
fn energy_closes_to_1e_9_in_every_built_in_study_and_nothing_is_nan() {
    for built_in in ocmc_io::study::list() {
        let study = study(built_in.name, &[]);
        for record in run(&study, 200) {
            let open = if record.amount(Carrier::Electricity).is_some() {
                electric_balance(&record)
            } else {
                balance(&record)
            };
            assert!(open.abs() < 1e-9, "{}: {record:?}", built_in.name);
            for column in COLUMNS {
                if let Cell::Number(Some(value)) = column.get(&record) {
                    assert!(value.is_finite(), "{} {}", built_in.name, column.name);
                }
            }
        }
    }
}

#[test]
fn shift_and_clutch_losses_are_needed_for_the_balance() {
    // shift loss: without the jumps of the engine's kinetic energy the balance does not close
    let study = study("regional", &[]);
    let records = run(&study, 50);
    let share = |loss: fn(&ocmc_core::record::Record) -> f64| {
        records.iter().map(loss).sum::<f64>()
            / records.iter().map(|r| r.wheel_energy_j).sum::<f64>()
    };
    assert!(share(|r| r.shift_loss_j.unwrap().abs()) > 1e-4);
    assert!(share(|r| r.clutch_loss_j.unwrap()) > 1e-5);
}

#[test]
fn the_declared_terms_close_the_balance_and_sum_up_to_the_record() {
    for built_in in ocmc_io::study::list() {
        let study = study(built_in.name, &[]);
        let trace = trace(&study, 1, 0);
        let mut ledger = Ledger::EMPTY;
        for declared in TERMS {
            let column = trace.columns.iter().find(|column| column.name == declared.trace);
            // one by one, as the record was summed
            let sum = column.map(|column| column.values.iter().fold(0.0, |sum, x| sum + x));
            ledger[declared.term] = sum.unwrap_or(0.0);
            if let (Recorded::Column { name, .. }, Some(sum)) = (declared.recorded, sum) {
                let recorded = record::column(name).unwrap().get(&trace.record);
                assert_eq!(recorded, Cell::Number(Some(sum)), "{name}");
            }
        }
        let sources = study.vehicle().powertrain.dispatch(Sources);
        let given_j: f64 = sources.iter().map(|source| ledger[*source]).sum();
        let open_j = ledger.open_balance_j(sources, trace.record.kinetic_change_j);
        assert!((open_j / given_j).abs() < 1e-9, "{}: {open_j}", built_in.name);
        // each term of the balance is needed
        for declared in TERMS.iter().filter(|declared| declared.place == Place::Loss) {
            let mut without = ledger;
            without[declared.term] = 0.0;
            let open_j = without.open_balance_j(sources, trace.record.kinetic_change_j);
            let share = ledger[declared.term] / given_j;
            assert!((open_j / given_j - share).abs() < 1e-9, "{:?}", declared.term);
        }
        assert!((0.0..ledger[Term::Distance]).contains(&ledger[Term::Coasting]));
    }
}

#[test]
fn a_truck_that_rolls_downhill_without_pedals_coasts() {
    let study = study("long-haul", &[]);
    for record in run(&study, 20) {
        let Cell::Number(Some(coasting_m)) =
            record::column("coasting_distance_m").unwrap().get(&record)
        else {
            panic!("a driven cycle has it");
        };
        assert!(coasting_m > 0.0 && coasting_m < 0.5 * record.distance_m, "{coasting_m}");
    }
}

#[test]
fn potential_energy_is_that_of_the_net_climb() {
    // the road's net climb is zero; a truck stops up to half a metre short of its end
    let study = study("field-truck", &[]);
    for record in run(&study, 50) {
        if record.outcome == Outcome::Completed {
            let mass_kg = study.model().vehicle.curb_mass_kg + record.payload_kg;
            let most = mass_kg * 9.80665 * 0.12 * 3.0;
            assert!(record.potential_change_j.abs() < most, "{record:?}");
            assert!(record.kinetic_change_j == 0.0);
        }
    }
}

#[test]
fn the_trace_sums_up_to_the_record_exactly() {
    let study = study("field-truck", &[]);
    let records = run(&study, 20);
    for id in [0, 3, 17] {
        let trace = trace(&study, 1, id);
        let record = &records[id as usize];
        assert_eq!(&trace.record, record);
        let sum = |name| column(&trace, name).iter().fold(0.0, |sum, value| sum + value);
        assert!(sum("fuel_added_kg") == record.amount(Carrier::LiquidFuel).unwrap());
        assert!(sum("distance_added_m") == record.distance_m);
        assert!(sum("simulated_added_s") == record.simulated_s);
        assert!(sum("crankshaft_work_added_j") == record.crankshaft_work_j.unwrap());
        assert!(sum("auxiliary_energy_added_j") == record.auxiliary_energy_j);
        assert!(sum("clutch_loss_added_j") == record.clutch_loss_j.unwrap());
        assert!(sum("transmission_loss_added_j") == record.transmission_loss_j);
        assert!(sum("shift_loss_added_j") == record.shift_loss_j.unwrap());
        assert!(sum("drag_energy_added_j") == record.drag_energy_j);
        assert!(sum("rolling_energy_added_j") == record.rolling_energy_j);
        assert!(sum("potential_added_j") == record.potential_change_j);
        assert!(sum("service_brake_energy_added_j") == record.service_brake_energy_j);
        assert!(sum("engine_brake_energy_added_j") == record.engine_brake_energy_j.unwrap());
        assert!(sum("wheel_energy_added_j") == record.wheel_energy_j);
    }
}

fn fuel_kgps(engine: &Engine, speed_radps: f64, torque_nm: f64, drag_torque_nm: f64) -> f64 {
    dispatch!(Level::baseline(), simd => {
        let all = |number| Lanes::splat(simd, number);
        engine.fuel_rates(all(speed_radps), all(torque_nm), all(drag_torque_nm))[0]
    })
}

/// The step keeps the piece of the drag curve on which it starts.
fn drag_torque_nm(engine: &Engine, start_radps: f64, speed_radps: f64) -> f64 {
    let [_, _, drag, slope] = dispatch!(Level::baseline(), simd => {
        engine.curves_at(Lanes::splat(simd, start_radps)).lines.map(|line| line[0])
    });
    drag + slope * speed_radps
}

#[test]
fn fuel_is_the_map_evaluated_again_on_the_trace() {
    let study = study("field-truck", &[]);
    let engine = &diesel(&study).engine;
    for id in [1, 5] {
        let factor = study.sample(1, id).vehicle.map_factor;
        let trace = trace(&study, 1, id);
        let speed = column(&trace, "engine_speed_radps");
        let torque = column(&trace, "engine_torque_nm");
        let step = column(&trace, "step_s");
        let fuel = column(&trace, "fuel_added_kg");
        let start = start_speeds_radps(&study, &trace);
        let mut again = 0.0;
        for k in 0..speed.len() {
            let drag_torque = drag_torque_nm(engine, start[k], speed[k]);
            let rate = factor * fuel_kgps(engine, speed[k], torque[k], drag_torque);
            let slack = 1e-12 * (fuel[k] + 1e-6);
            let close = (rate * step[k] - fuel[k]).abs() <= slack;
            assert!(close, "row {k}: {} {}", rate * step[k], fuel[k]);
            again += rate * step[k];
        }
        assert!((again / trace.record.amount(Carrier::LiquidFuel).unwrap() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn work_at_the_hubs_is_what_moves_the_truck_without_the_engine() {
    for name in ["field-truck", "battery-truck"] {
        let study = study(name, &["mission.length_m=20000"]);
        let scenario = study.sample(1, 3);
        // what is behind the hubs: the truck and its wheels, no engine and no motor
        let mass_kg = scenario.vehicle.mass_kg + study.vehicle().model.wheel_mass_kg();
        let trace = trace(&study, 1, 3);
        let terms = [
            "drag_energy_added_j",
            "rolling_energy_added_j",
            "potential_added_j",
            "service_brake_energy_added_j",
        ]
        .map(|name| column(&trace, name));
        let [hub, speed] = ["wheel_energy_added_j", "speed_mps"].map(|name| column(&trace, name));
        let (mut driven, mut same, mut sum_j, mut hub_j, mut kinetic_j) = (0, 0, 0.0, 0.0, 0.0);
        for k in (1..hub.len()).filter(|k| hub[*k] > 0.0 && terms[3][*k] == 0.0) {
            let gained_j = 0.5 * mass_kg * (speed[k] * speed[k] - speed[k - 1] * speed[k - 1]);
            let needed_j = gained_j + terms[..3].iter().map(|term| term[k]).sum::<f64>();
            // where the force turns within the step it is positive in a part of it alone
            assert!(
                hub[k] >= needed_j - 1e-6 * hub[k].max(1.0),
                "{name} {k}: {} {needed_j}",
                hub[k]
            );
            if gained_j > 0.0 {
                (driven, sum_j, kinetic_j) = (driven + 1, sum_j + needed_j, kinetic_j + gained_j);
                hub_j += hub[k];
                same += usize::from((hub[k] - needed_j).abs() <= 1e-6 * hub[k].max(1.0));
            }
        }
        assert!(driven > 100 && kinetic_j > 0.1 * sum_j, "{name}: {driven} {kinetic_j} {sum_j}");
        // it turns where torque comes back after a shift
        assert!(20 * same >= 19 * driven, "{name}: {same} of {driven}");
        assert!((hub_j / sum_j - 1.0).abs() < 1e-3, "{name}: {hub_j} {sum_j}");
    }
}
