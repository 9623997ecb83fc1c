//! Battery-electric vehicles in the closed loop: the energy balance, the closed form, the limits of
//! what comes back, and an empty battery.

use crate::common::{GivenRoad, column, electric_balance, run};
use ocmc_core::energy::Carrier;
use ocmc_core::kernel::drive::cpu::CpuLevel;
use ocmc_core::kernel::drive::scheduler::{drive, drive_scenario};
use ocmc_core::kernel::drive::trace::{Trace, trace, trace_scenario};
use ocmc_core::operating_cycle::road::point_event::EventKind;
use ocmc_core::powertrain::PowertrainKind;
use ocmc_core::powertrain::battery_electric::BatteryElectricPowertrain;
use ocmc_core::record::{COLUMNS, Cell, Outcome, Record};
use ocmc_core::study::Study;
use ocmc_fleet::run::replay;
use ocmc_fleet::summary::SummaryBuilder;
use ocmc_io::study::{load, load_text};

const VEHICLES: [&str; 3] = ["tractor-electric-40t", "city-bus-electric-12m", "car-electric"];

fn with_vehicle(study: &str, vehicle: &str, sets: &[&str]) -> Study {
    let text = format!(
        "[study]\nname = \"e\"\ndescription = \"d\"\nbase = \"{study}\"\n[vehicle]\n\
         base = \"{vehicle}\"\n"
    );
    load_text("e.toml", &text, sets).unwrap().study
}

/// The tractor with the typical driver, without spread.
fn tractor(sets: &[&str]) -> Study {
    let mut all = vec![
        "driver.pedals.pid_share=1.0",
        "simulation.without=[\"driver_spread\", \"vehicle_spread\"]",
    ];
    all.extend_from_slice(sets);
    with_vehicle("field-truck", "tractor-electric-40t", &all)
}

fn electric(study: &Study) -> &BatteryElectricPowertrain {
    match &study.vehicle().powertrain {
        PowertrainKind::BatteryElectric(drive) => drive,
        _ => panic!("a battery-electric vehicle"),
    }
}

/// A road of 21.3 t of payload: 40 t.
fn road(length_m: f64, sign_kmh: f64, slopes: &[(f64, f64)]) -> GivenRoad {
    let mut road = GivenRoad { payload_kg: 21_300.0, ..GivenRoad::flat(length_m, sign_kmh / 3.6) };
    road.slopes.clear();
    for (from_m, slope) in slopes {
        road.slopes.resize((from_m / 25.0) as usize, *road.slopes.last().unwrap_or(&0.0));
        road.slopes.push(*slope);
    }
    road
}

fn driven(study: &Study, road: &GivenRoad) -> Record {
    drive_scenario(study, road.scenario(study))
}

#[test]
fn motor_and_auxiliaries_together_stay_within_the_battery() {
    // 25 kW of auxiliaries beside a battery of 200 kW and a charging limit of 100 kW
    let limits = [
        "vehicle.auxiliary_power_w=25000",
        "vehicle.powertrain.battery_electric.climate.maximum_w=0",
        "vehicle.powertrain.battery_electric.battery.discharge_power_w=200e3",
        "vehicle.powertrain.battery_electric.battery.charge_power_w=100e3",
    ];
    // a motor far stronger than the battery, and one that alone stays within its limits
    let weak = ["vehicle.powertrain.battery_electric.motor.power_w=175e3"];
    for motor in [&[][..], &weak] {
        let study = tractor(&[&limits[..], motor, &["simulation.step_s=0.1"]].concat());
        let road = road(6000.0, 80.0, &[(0.0, 0.03), (3000.0, -0.06)]);
        let trace = trace_scenario(&study, road.scenario(&study));
        let power = column(&trace, "battery_power_w");
        let most = power.iter().copied().fold(0.0, f64::max);
        let least = power.iter().copied().fold(0.0, f64::min);
        // the power at the step's mean is not the mean of the powers, by a little
        assert!((most / 200e3 - 1.0).abs() < 2e-3, "{motor:?}: {most}");
        assert!((least / -100e3 - 1.0).abs() < 2e-3, "{motor:?}: {least}");
        // at the limit of either sign, motor and auxiliaries have it to themselves
        let drive = electric(&study);
        let charge = 0.5;
        for (speed, torque) in
            [(100.0, 2400.0), (250.0, 2000.0), (300.0, -1500.0), (150.0, -2400.0)]
        {
            let held = drive.within_battery_nm(charge, 25e3, speed, torque);
            let terminals = drive.motor.terminals_w(speed, held) + 25e3;
            let limit = if torque > 0.0 { 200e3 } else { -100e3 };
            assert!((terminals / limit - 1.0).abs() < 1e-9, "{speed} {torque}: {terminals}");
        }
    }
}

#[test]
fn energy_closes_to_1e_9_with_every_electric_vehicle_and_nothing_is_nan() {
    for study in ["field-truck", "regional", "urban-delivery"] {
        for vehicle in VEHICLES {
            let prepared = with_vehicle(study, vehicle, &["mission.payload_kg=400"]);
            for record in run(&prepared, 60) {
                let open = electric_balance(&record);
                assert!(open.abs() < 1e-9, "{study} {vehicle}: {open} {record:?}");
                for column in COLUMNS {
                    if let Cell::Number(Some(value)) = column.get(&record) {
                        assert!(value.is_finite(), "{study} {vehicle} {}", column.name);
                    }
                }
                assert!(record.regenerated_energy_j.unwrap() > 0.0);
                assert!(
                    record.amount(Carrier::LiquidFuel).is_none() && record.co2_g_per_km.is_none()
                );
                assert!(record.engine_brake_energy_j.is_none() && record.clutch_loss_j.is_none());
            }
        }
    }
}

#[test]
fn the_trace_sums_up_to_the_record_exactly() {
    let study = with_vehicle("regional", "tractor-electric-40t", &[]);
    let records = drive(&study, 1, 0..8, CpuLevel::best());
    for id in [0, 5] {
        let trace = trace(&study, 1, id);
        let record = &records[id as usize];
        assert_eq!(&trace.record, record);
        let sum = |name| column(&trace, name).iter().fold(0.0, |sum, value| sum + value);
        assert!(sum("distance_added_m") == record.distance_m);
        assert!(sum("auxiliary_energy_added_j") == record.auxiliary_energy_j);
        assert!(sum("transmission_loss_added_j") == record.transmission_loss_j);
        assert!(sum("shift_loss_added_j") == record.shift_loss_j.unwrap());
        assert!(sum("service_brake_energy_added_j") == record.service_brake_energy_j);
        assert!(sum("wheel_energy_added_j") == record.wheel_energy_j);
        assert!(sum("battery_energy_added_j") == record.amount(Carrier::Electricity).unwrap());
        assert!(sum("battery_loss_added_j") == record.battery_loss_j.unwrap());
        assert!(sum("motor_loss_added_j") == record.motor_loss_j.unwrap());
        assert!(sum("regenerated_energy_added_j") == record.regenerated_energy_j.unwrap());
        assert!(*column(&trace, "state_of_charge").last().unwrap() == record.final_charge.unwrap());
        let diesel = ["fuel_added_kg", "clutch_closed", "engine_speed_radps"];
        assert!(trace.columns.iter().all(|column| !diesel.contains(&column.name)));
    }
}

/// Rows of a trace between two places.
fn rows(trace: &Trace, from_m: f64, to_m: f64) -> std::ops::Range<usize> {
    let position = column(trace, "position_m");
    let at = |place: f64| position.iter().position(|x| *x > place).unwrap();
    at(from_m)..at(to_m)
}

#[test]
fn constant_speed_is_the_closed_form_to_1e_6() {
    let study = tractor(&[]);
    let BatteryElectricPowertrain { motor, model, .. } = electric(&study);
    // 48 m of climb: beyond 50 m the air density would be taken anew
    for (slope, kmh) in [(0.0, 80.0), (0.0, 50.0), (0.0008, 70.0)] {
        let scenario = road(60_000.0, kmh, &[(0.0, slope)]).scenario(&study);
        let vehicle = scenario.vehicle;
        let trace = trace_scenario(&study, scenario);
        let range = rows(&trace, 50_000.0, 55_000.0);
        let v = kmh / 3.6;
        let speed = column(&trace, "speed_mps");
        assert!(speed[range.clone()].iter().all(|s| (s / v - 1.0).abs() < 1e-9), "steady");

        let weather = ocmc_core::operating_cycle::weather::STANDARD_WEATHER;
        let crr = vehicle.rolling_coefficient
            * ocmc_core::vehicle::resistance::rolling_temperature_factor(288.15, 0.006);
        let cosine = (1.0f64 - slope * slope).sqrt();
        let force = vehicle.mass_kg * 9.80665 * (crr * cosine + slope)
            + 0.5 * weather.air_density_kgpm3(0.0) * vehicle.drag_area_m2 * v * v;
        // standard air has 15 °C: nothing is heated
        let auxiliary = vehicle.auxiliary_power_w;
        let gear = column(&trace, "gear")[range.start] as usize - 1;
        let per_m = model.ratio[gear] / study.model().vehicle.wheel_radius_m;
        let torque = force / (model.gear_efficiency * per_m);
        let power = torque * per_m * v + motor.loss_w(per_m * v, torque) + auxiliary;
        let terminals = column(&trace, "battery_power_w");
        let (charge, step) = (column(&trace, "state_of_charge"), column(&trace, "step_s"));
        let store = column(&trace, "battery_energy_added_j");
        for k in range {
            assert!((terminals[k] / power - 1.0).abs() < 1e-6, "{} {power}", terminals[k]);
            // the circuit P = U I − R I², solved the other way round
            let u = model.battery.empty_voltage_v
                + charge[k - 1] * (model.battery.full_voltage_v - model.battery.empty_voltage_v);
            let current = store[k] / step[k] / u;
            let back = u * current - model.battery.resistance_ohm * current * current;
            assert!((back / power - 1.0).abs() < 1e-6, "{back} {power}");
        }
    }
}

/// The battery's power stays within limits.
///
/// They hold at both stages of a step, over which speed changes by the share δ. The product of mean
/// speed and mean torque, of a step that may be cut between them, is beyond the stages' by at most
/// δ of the shaft's power.
fn assert_within(trace: &Trace, least_w: f64, most_w: f64) {
    let (speed, acceleration) = (column(trace, "speed_mps"), column(trace, "acceleration_mps2"));
    let (shaft, torque) = (column(trace, "motor_speed_radps"), column(trace, "motor_torque_nm"));
    let step = column(trace, "step_s");
    for (k, power) in column(trace, "battery_power_w").iter().enumerate().skip(1) {
        let change = acceleration[k].abs() * step[k] / speed[k].min(speed[k - 1]).max(1e-9);
        let slack = (shaft[k] * torque[k]).abs() * change + 1e-6;
        let within = (least_w - slack..=most_w + slack).contains(power);
        assert!(within, "row {k}: {power} W at {} m/s", speed[k]);
    }
}

#[test]
fn what_comes_back_downhill_is_limited_by_power_and_by_a_full_battery() {
    let downhill = road(14_000.0, 80.0, &[(0.0, 0.0), (1000.0, -0.05), (13_000.0, 0.0)]);
    let traced = |sets: &[&str]| {
        let study = tractor(sets);
        let trace = trace_scenario(&study, downhill.scenario(&study));
        assert!(electric_balance(&trace.record).abs() < 1e-9);
        let lowest = column(&trace, "battery_power_w").iter().copied().fold(0.0, f64::min);
        let least = -electric(&study).model.battery.charge_power_w;
        assert_within(&trace, least, electric(&study).model.battery.discharge_power_w);
        (trace.record, lowest)
    };
    // 40 t on 5 % give 360 kW at 80 km/h
    let (free, lowest) =
        traced(&["vehicle.powertrain.battery_electric.battery.initial_charge=0.5"]);
    assert!(lowest < -200e3, "{lowest}");
    assert!(free.service_brake_energy_j < 0.2 * free.regenerated_energy_j.unwrap(), "{free:?}");
    let half = [
        "vehicle.powertrain.battery_electric.motor.brake_power_w=100e3",
        "vehicle.powertrain.battery_electric.battery.initial_charge=0.5",
    ];
    let (motor, lowest) = traced(&half);
    // the motor's limit is one of its shaft
    assert!(lowest > -101e3, "{lowest}");
    let weak = [
        "vehicle.powertrain.battery_electric.battery.charge_power_w=50e3",
        "vehicle.powertrain.battery_electric.battery.initial_charge=0.5",
    ];
    let (battery, lowest) = traced(&weak);
    assert!(lowest < -49e3, "{lowest}");
    let (full, _) = traced(&["vehicle.powertrain.battery_electric.battery.initial_charge=0.9"]);
    assert!(full.final_charge.unwrap() <= 0.9);
    let back = |record: &Record| record.regenerated_energy_j.unwrap();
    assert!(back(&free) > back(&motor) && back(&motor) > back(&battery));
    // what the start has taken may come back
    assert!(back(&full) < 0.2 * back(&free), "{} {}", back(&full), back(&free));
    for less in [&motor, &battery, &full] {
        assert!(less.service_brake_energy_j > free.service_brake_energy_j);
        assert!(
            less.amount(Carrier::Electricity).unwrap() > free.amount(Carrier::Electricity).unwrap()
        );
    }
}

#[test]
fn up_and_down_is_never_below_flat() {
    let study = tractor(&["driver.pedals.overspeed_band_mps=0"]);
    let store = |slope: f64| {
        let hill = [(0.0, 0.0), (2000.0, slope), (5000.0, -slope), (8000.0, 0.0)];
        let record = driven(&study, &road(10_000.0, 70.0, &hill));
        assert_eq!(record.outcome, Outcome::Completed);
        assert!(record.potential_change_j.abs() < 40_000.0 * 9.81 * 0.1);
        record.amount(Carrier::Electricity).unwrap()
    };
    let mut before = store(0.0);
    for slope in [0.005, 0.01, 0.02, 0.03, 0.04] {
        let now = store(slope);
        assert!(now >= before, "{slope}: {now} {before}");
        before = now;
    }
}

#[test]
fn an_empty_battery_is_an_outcome_and_charging_at_a_stop_fills_it() {
    let low = "vehicle.powertrain.battery_electric.battery.initial_charge=0.12";
    let ramp = "charging={ reserve = 0.1, efficiency = 1.0, stop = { power_w = 350e3, \
                begin_below = 0.5, end_at = 0.8, shortest_s = 600.0 } }";
    let flat = || road(30_000.0, 80.0, &[(0.0, 0.0)]);
    let study = tractor(&[low, ramp]);
    let record = driven(&study, &flat());
    assert_eq!(record.outcome, Outcome::Depleted);
    // 10.8 kWh: some 5 for 80 km/h, the rest for 1.2 to 1.5 kWh/km
    assert!((3000.0..7000.0).contains(&record.distance_m), "{}", record.distance_m);
    assert!((record.final_charge.unwrap() - 0.1).abs() < 1e-4);
    assert!(electric_balance(&record).abs() < 1e-9, "{}", electric_balance(&record));
    let at_ramp = |study: &Study, standstill_s: f64| {
        let mut scenario = flat().stop(1500.0, standstill_s).scenario(study);
        scenario.cycle.road.events[0].kind = EventKind::MissionStop { standstill_s };
        drive_scenario(study, scenario)
    };
    // the same truck stops for half an hour after 1.5 km
    let charged = at_ramp(&study, 1800.0);
    assert_eq!(charged.outcome, Outcome::Completed);
    let gained = charged.charged_energy_j.unwrap();
    // half an hour of 350 kW, less the auxiliaries and the heat: U/(U + R I) of it arrives, about
    // 631 V and 533 A over 0.05 Ω
    let auxiliary_w = charged.auxiliary_energy_j / charged.moving_s;
    let arrives = (350e3 - auxiliary_w) * 1800.0 * 631.0 / (631.0 + 0.05 * 533.0);
    assert!((gained / arrives - 1.0).abs() < 0.01, "{gained} {arrives}");
    let capacity = electric(&study).model.battery.capacity_j;
    let end = 0.12 + (gained - charged.amount(Carrier::Electricity).unwrap()) / capacity;
    assert!((charged.final_charge.unwrap() - end).abs() < 1e-9);
    assert!(electric_balance(&charged).abs() < 1e-9);
    assert!(charged.charging_loss_j.unwrap() > 0.0);
    // too short a stop, and a battery that is full enough, are not used
    let short = at_ramp(&study, 60.0);
    assert_eq!((short.outcome, short.charged_energy_j), (Outcome::Depleted, Some(0.0)));
    let enough = tractor(&["vehicle.powertrain.battery_electric.battery.initial_charge=0.7", ramp]);
    assert_eq!(at_ramp(&enough, 1800.0).charged_energy_j, Some(0.0));
}

#[test]
fn cold_air_takes_what_the_climate_says() {
    let at = |kelvin: f64| {
        let sets = [
            format!("weather.temperature.mean_k={kelvin}"),
            "weather.temperature.annual_amplitude_k=0".to_owned(),
            "weather.temperature.winter_daily_amplitude_k=0".to_owned(),
            "weather.temperature.summer_daily_amplitude_k=0".to_owned(),
            "weather.temperature.winter_sd_k=0".to_owned(),
            "weather.temperature.summer_sd_k=0".to_owned(),
        ];
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        let record = drive(&tractor(&sets), 1, 0..1, CpuLevel::best()).remove(0);
        record.auxiliary_energy_j / record.duration_s
    };
    // 150 W for each K below 15 °C
    let (mild, cold) = (at(288.15), at(268.15));
    assert!((cold - mild - 3000.0).abs() < 1e-6, "{mild} {cold}");
}

#[test]
fn a_limit_of_the_battery_slows_the_truck() {
    let climb = road(8000.0, 80.0, &[(0.0, 0.0), (1000.0, 0.04)]);
    let quick = driven(&tractor(&[]), &climb);
    let weak = tractor(&["vehicle.powertrain.battery_electric.battery.discharge_power_w=150e3"]);
    let trace = trace_scenario(&weak, climb.scenario(&weak));
    assert!(trace.record.mean_speed_mps < 0.6 * quick.mean_speed_mps);
    let most = column(&trace, "battery_power_w").iter().copied().fold(0.0, f64::max);
    assert!(most > 149e3, "{most}");
    assert_within(&trace, -400e3, 150e3);
    assert!(electric_balance(&trace.record).abs() < 1e-9);
}

#[test]
fn records_are_the_same_on_every_cpu_and_in_every_order() {
    let study = with_vehicle("regional", "tractor-electric-40t", &[]);
    let reference = drive(&study, 1, 0..40, CpuLevel::Baseline);
    for level in CpuLevel::ALL.into_iter().filter(|level| level.is_available()) {
        assert_eq!(drive(&study, 1, 0..40, level), reference, "{}", level.name());
        let mut parts = drive(&study, 1, 0..7, level);
        parts.extend(drive(&study, 1, 7..40, level));
        assert_eq!(parts, reference, "{} in parts", level.name());
    }
}

#[test]
fn a_study_has_one_powertrain() {
    let none: &[&str] = &[];
    let two = "[study]\nname = \"a\"\ndescription = \"b\"\nbase = \"field-truck\"\n\
               [vehicle.powertrain.battery_electric]\nratio = [20.0]\n\
               gear_efficiency = 0.9\n[vehicle.powertrain.battery_electric.battery]\n\
               capacity_j = 1e9\nempty_voltage_v = 500.0\nfull_voltage_v = 600.0\n\
               resistance_ohm = 0.1\ndischarge_power_w = 1e5\ncharge_power_w = 1e5\n\
               minimum_charge = 0.1\nmaximum_charge = 0.9\n\
               charge_fade = 0.1\ninitial_charge = 0.8\n\
               [vehicle.powertrain.battery_electric.motor]\ntorque_nm = 500.0\npower_w = 1e5\n\
               brake_torque_nm = 500.0\n\
               brake_power_w = 1e5\nbrake_share = 0.9\nbrake_fade_mps = 1.0\n\
               maximum_speed_radps = 900.0\ninertia_kgm2 = 0.1\n\
               map_speed_radps = [0.0, 900.0]\nmap_torque_nm = [0.0, 500.0]\n\
               map_loss_w = [[100.0, 900.0], [400.0, 2000.0]]\n";
    let error = load_text("a.toml", two, none).unwrap_err().to_string();
    assert!(
        error.contains("battery_electric and combustion") && error.contains("study.drop"),
        "{error}"
    );
    let dropped = two.replace(
        "base = \"field-truck\"\n",
        "base = \"field-truck\"\ndrop = [\"vehicle.powertrain.combustion\"]\n",
    );
    let study = load_text("a.toml", &dropped, none).unwrap().study;
    assert!(matches!(study.vehicle().powertrain, PowertrainKind::BatteryElectric(_)));
    let neither =
        "[study]\nbase = \"field-truck\"\ndrop = [\"vehicle.powertrain.combustion.gearbox\"]\n";
    let error = load_text("a.toml", neither, none).unwrap_err().to_string();
    assert!(error.contains("`vehicle.powertrain.combustion.gearbox`"), "{error}");
}

#[test]
fn a_trip_cut_short_is_driven_to_its_end_with_a_battery_that_never_empties() {
    let records = |capacity_j: f64| {
        let capacity =
            format!("vehicle.powertrain.battery_electric.battery.capacity_j={capacity_j}");
        let sets = ["mission.length_m=60000", &capacity];
        let study = load("battery-truck", &sets).expect("a study").study;
        let all = drive(&study, 11, 0..120, CpuLevel::best());
        (study, all)
    };
    let own_j = 360e6;
    let ((study, own), (_, deep)) = (records(own_j), records(3.0 * own_j));
    let cut_short = |r: &&Record| r.outcome == Outcome::Depleted;
    let n = own.iter().filter(cut_short).count();
    assert!((20..100).contains(&n), "{n} of 120 are cut short");
    assert!(deep.iter().all(|r| r.outcome == Outcome::Completed));
    for (own, deep) in own.iter().zip(&deep) {
        if own.outcome == Outcome::Depleted {
            assert!(own.distance_m < deep.distance_m);
            assert_eq!(own.whole_trip_m, Some(deep.distance_m));
            assert_eq!(own.whole_trip_kwh_per_km, deep.consumption(Carrier::Electricity));
        } else {
            assert_eq!(own.whole_trip_m, Some(own.distance_m));
            assert_eq!(own.whole_trip_kwh_per_km, own.consumption(Carrier::Electricity));
        }
    }
    // alone, and in a trace, it is the same record
    let short = own.iter().find(cut_short).expect("some are");
    assert_eq!(replay(&study, 11, &[short.cycle_id]), std::slice::from_ref(short));
    assert_eq!(trace(&study, 11, short.cycle_id).record, *short);
    // the fleet's figures: over the kilometres that were driven, and of the whole trips
    let mut builder = SummaryBuilder::default();
    builder.add(&own);
    let summary = builder.finish();
    let mean = |column| summary.statistic(column).expect("a quantity").mean.expect("cycles");
    let over = |kwh: &dyn Fn(&Record) -> f64, m: &dyn Fn(&Record) -> f64| {
        let total = |f: &dyn Fn(&Record) -> f64| own.iter().map(f).sum::<f64>();
        total(&|r| kwh(r) * m(r)) / total(m)
    };
    let driven = over(&|r| r.consumption(Carrier::Electricity).unwrap(), &|r| r.distance_m);
    let whole = over(&|r| r.whole_trip_kwh_per_km.unwrap(), &|r| r.whole_trip_m.unwrap());
    assert!((mean("consumption_kwh_per_km") - driven).abs() < 1e-12);
    assert!((mean("whole_trip_kwh_per_km") - whole).abs() < 1e-12);
    assert_eq!(summary.statistic("duration_s").expect("a quantity").n, 120 - n as u64);
    assert!(summary.worst_case.is_none());
}
