//! Costs against T3CO's published results, closed forms, brute force, and refused numbers.

use crate::common::field_truck_model;
use crate::common::statistics::assert_share;
use ocmc_core::cost::CostModel;
use ocmc_core::cost::costing::{Costing, Trip};
use ocmc_core::cost::emissions::EmissionFactors;
use ocmc_core::cost::levelised::{Levelised, Life};
use ocmc_core::cost::state::State;
use ocmc_core::energy::Carrier;
use ocmc_core::energy::emission_model::EmissionModel;
use ocmc_core::powertrain::Sizes;
use ocmc_core::random::{Draws, Stream};
use ocmc_core::record::{Outcome, Record};
use ocmc_core::study::Study;
use ocmc_core::study::keys::{Key, declarations};
use ocmc_fleet::cost::{FleetCost, STATES};
use ocmc_fleet::cost_difference::{CostDifference, Fleet};
use ocmc_fleet::dependence::Dependence;
use serde_json::{Value, json};

fn model(table: Value) -> CostModel {
    serde_json::from_value(table).unwrap()
}

const DIESEL: Sizes = Sizes {
    engine_kw: Some(300.0),
    motor_kw: None,
    battery_kwh: None,
    cell_kw: None,
    carriers: &[Carrier::LiquidFuel],
    plugs_in: false,
};
const ELECTRIC: Sizes = Sizes {
    engine_kw: None,
    motor_kw: Some(300.0),
    battery_kwh: Some(500.0),
    cell_kw: None,
    carriers: &[Carrier::Electricity],
    plugs_in: true,
};

/// The costs of a fleet of records, with seed 1.
fn costed(costing: &Costing, records: &[Record]) -> FleetCost {
    let trips = trips(costing, records);
    let factors = EmissionFactors::default();
    let emitted: Vec<_> = records.iter().filter_map(|r| factors.of_trip(r)).collect();
    FleetCost::of(costing, &trips, &emitted, 0, 1, Dependence::default()).unwrap()
}

fn trips(costing: &Costing, records: &[Record]) -> Vec<Trip> {
    records.iter().filter_map(|record| costing.trip(record)).collect()
}

fn of_item(cost: &FleetCost, name: &str) -> [f64; 2] {
    let item = cost.items.iter().find(|item| item.item == name);
    let item = item.unwrap_or_else(|| panic!("no item {name}"));
    [item.whole_life.unwrap(), item.whole_life_paid.unwrap()]
}

fn assert_within(what: &str, found: f64, expected: f64, relative: f64) {
    let off = (found - expected).abs() / expected.abs();
    println!("{what}: {found:.2}, expected {expected:.2}, off {:.4} %", 100.0 * off);
    assert!(off <= relative, "{what}: {found} {expected}");
}

const KM_PER_MILE: f64 = 1.609344;
const L_PER_GALLON: f64 = 3.785411784;
/// T3CO's energy of a gallon of gasoline and of diesel, in kWh.
const GASOLINE_KWH: f64 = 33.7;
const DIESEL_KWH: f64 = 37.95;

/// One trip of 100 miles.
fn hundred_miles() -> Record {
    let distance_m = 1000.0 * 100.0 * KM_PER_MILE;
    Record { distance_m, duration_s: 7200.0, payload_kg: 16_329.0, ..Record::default() }
}

/// Inputs that both trucks of T3CO's test share: its file TCO_SCENARIO_TEST_INPUTS.csv.
fn t3co_shared(table: &Value) -> Costing {
    let mut all = json!({
        "currency": "USD",
        "purchase_per_truck": 121918.9997,
        "life_a": 7.0,
        "discount_rate_per_a": 0.041,
        "distance_km_per_a": 100_000.0 * KM_PER_MILE,
    });
    all.as_object_mut().unwrap().extend(table.as_object().unwrap().clone());
    let battery_kwh = all["battery_per_kwh"].is_number().then_some(2430.789183);
    let motor_kw = battery_kwh.map(|_| 302.6701539);
    let engine_kw = battery_kwh.is_none().then_some(340.0);
    let of = if engine_kw.is_some() { DIESEL } else { ELECTRIC };
    let sizes = Sizes { engine_kw, motor_kw, battery_kwh, ..of };
    Costing::new(&model(all), sizes, 14_000.0)
}

/// The static results of T3CO's own test and the inputs that belong to them: National Renewable
/// Energy Laboratory, T3CO 1.0 (repository NREL/T3CO, commit 85017ca of 2024, BSD-3 licence),
/// `t3co/tests/test_tcos.py` (`c8_long_haul_control_values`, `ev_2020_values`),
/// `t3co/tests/tco_tests/TCO_*_TEST_INPUTS.csv` (selections 1 and 22) and
/// `t3co/resources/auxiliary/FuelPrices.csv` (United States, 2020 to 2026). Its test allows 1 %.
#[test]
fn a_diesel_truck_costs_what_t3co_publishes() {
    let dollars_per_gallon =
        [2.54226434, 2.53451309, 2.641683529, 2.860466274, 2.953921224, 3.02171182, 3.080664452];
    let costing = t3co_shared(&json!({
        "fuel_per_l": dollars_per_gallon.map(|price| price / L_PER_GALLON),
        "combustion_maintenance_per_km": 0.35 / KM_PER_MILE,
        "engine_per_kw": 1.5 * 47.3,
        "tank_per_truck": 1.5 * 0.07 * 3953.275174,
    }));
    let miles_per_gasoline_gallon = 7.498430055950212;
    let gallons = 100.0 / miles_per_gasoline_gallon * GASOLINE_KWH / DIESEL_KWH;
    let per_100km = gallons * L_PER_GALLON / KM_PER_MILE;
    let record =
        Record { ..hundred_miles().with(Carrier::LiquidFuel, [None, Some(per_100km), None]) };
    let cost = costed(&costing, &[record]);
    let exact = 1e-6;
    for (item, published, allowed) in [
        ("purchase", 121918.9997, exact),
        // T3CO subtracts 0.45 dollars from its engine
        ("engine", 24122.324999999997, 1e-4),
        ("tank", 415.0938932700001, exact),
    ] {
        assert_within(item, of_item(&cost, item)[0], published, allowed);
    }
    let [maintained, maintained_paid] = of_item(&cost, "maintenance");
    let purchase = 146456.41859327;
    let bought: f64 =
        ["purchase", "engine", "tank"].map(|item| of_item(&cost, item)[1]).iter().sum();
    assert_within("msrp", bought, purchase, 1e-4);
    let (all_paid, all) = (623988.9138875754, 569899.8836666911);
    // what T3CO's total leaves for fuel
    assert_within("maintenance, paid", maintained_paid, 7.0 * 35_000.0, exact);
    let [fuel, fuel_paid] = of_item(&cost, "fuel");
    assert_within("fuel, paid", fuel_paid, all_paid - purchase - 245_000.0, 1e-5);
    assert_within("fuel", fuel, all - purchase - maintained, 1e-5);
    assert_within("total, paid", cost.total.whole_life_paid.unwrap(), all_paid, 1e-5);
    assert_within("total", cost.total.whole_life.unwrap(), all, 1e-5);
}

#[test]
fn a_battery_truck_costs_what_t3co_publishes() {
    let costing = t3co_shared(&json!({
        "depot_charging_per_kwh": [
            0.237768062, 0.248335114, 0.243064981, 0.238469355, 0.234950988, 0.234850111,
            0.236372996,
        ],
        "charging_efficiency": 0.86,
        "electric_maintenance_per_km": 0.0,
        "motor_per_kw": 8.0,
        "battery_per_kwh": 1.5 * 197.0,
        "charger_per_truck": 1.5 * 125.0,
    }));
    // what leaves the battery
    let kwh_per_mile = 2.377024334961005;
    let battery_energy_j = Some(100.0 * kwh_per_mile * 3.6e6);
    let record = Record {
        charged_energy_j: Some(0.0),
        ..hundred_miles().with(Carrier::Electricity, [battery_energy_j, None, None])
    };
    let cost = costed(&costing, &[record]);
    for (item, published) in [
        ("purchase", 121918.9997),
        ("battery", 718298.2035765),
        ("motor", 2421.3612312),
        ("charger", 187.5),
    ] {
        assert_within(item, of_item(&cost, item)[0], published, 1e-6);
    }
    let (all_paid, all, purchase) = (1305464.5441249725, 1254634.9894996588, 842826.0645076999);
    let [energy, energy_paid] = of_item(&cost, "depot_charging");
    assert_within("electricity, paid", energy_paid, all_paid - purchase, 1e-5);
    assert_within("electricity", energy, all - purchase, 1e-5);
    assert_within("total, paid", cost.total.whole_life_paid.unwrap(), all_paid, 1e-5);
    assert_within("total", cost.total.whole_life.unwrap(), all, 1e-5);
}

/// Items of T3CO 2.0.0 (Python package `t3co`, BSD-3 licence), which we ran on its demo inputs
/// FY22, selections 4 (diesel) and 34 (battery), paid in cash, 110,000 miles in each of 4 years, 8
/// and 20 miles per gallon of gasoline equivalent, prices of its `FuelPrices.csv` for 2025 to 2028.
/// It discounts to the end of each year, this program to its start: what is paid by year is worth
/// 1.03 times as much here.
#[test]
fn items_are_those_of_t3co_2_but_for_when_a_year_is_paid() {
    let shared = json!({
        "currency": "USD", "purchase_per_truck": 1.2 * 112_759.0, "life_a": 4.0,
        "discount_rate_per_a": 0.03, "distance_km_per_a": 110_000.0 * KM_PER_MILE,
        // 9 % less in each of 4 years, which it takes twice
        "residual_share": 0.91_f64.powi(8),
    });
    let costs = |own: Value, sizes: Sizes, record: Record| {
        let mut table = shared.clone();
        table.as_object_mut().unwrap().extend(own.as_object().unwrap().clone());
        costed(&Costing::new(&model(table), sizes, 15_000.0), &[record])
    };
    // the energy equivalent of its conversion of gallons, 0.888
    let dollars = [3.156189792, 3.152807315, 3.161005456, 3.185832617].map(|p| p * 0.888);
    let msrp = 163_627.14;
    let insured = [0.03, 0.035, 0.04, 0.045];
    let gallons_per_100km = 100.0 / KM_PER_MILE / 8.0;
    let diesel = costs(
        json!({
            "fuel_per_l": dollars.map(|price| price / L_PER_GALLON),
            "combustion_maintenance_per_km": 0.15 / KM_PER_MILE,
            "engine_per_kw": 1.2 * (50.0 + 6250.0 / 331.0),
            "tank_per_truck": 1.2 * 0.07 * 11_385.0,
            "insurance_per_a": insured.map(|rate| rate * msrp),
        }),
        Sizes { engine_kw: Some(331.0), ..DIESEL },
        Record {
            ..hundred_miles()
                .with(Carrier::LiquidFuel, [None, Some(gallons_per_100km * L_PER_GALLON), None])
        },
    );
    let msrp = 517_238.508;
    let kwh_per_mile = GASOLINE_KWH / 20.0;
    let battery = costs(
        json!({
            "depot_charging_per_kwh": [0.253963369, 0.256065732, 0.256788553, 0.257331383],
            "charging_efficiency": 1.0,
            "electric_maintenance_per_km": 0.15 / KM_PER_MILE,
            "motor_per_kw": 1.2 * (23.0 + 500.0 / 344.63),
            "charger_per_truck": 1.2 * 500.0,
            "battery_per_kwh": 1.2 * 190.0,
            "insurance_per_a": insured.map(|rate| rate * msrp),
        }),
        Sizes { motor_kw: Some(344.63), battery_kwh: Some(1628.14), ..ELECTRIC },
        Record {
            ..hundred_miles()
                .with(Carrier::Electricity, [Some(100.0 * kwh_per_mile * 3.6e6), None, None])
        },
    );
    let later = 1.03;
    for (cost, item, found, factor) in [
        (&diesel, "purchase", 135310.8, 1.0),
        (&diesel, "engine", 27360.0, 1.0),
        (&diesel, "tank", 956.34, 1.0),
        (&diesel, "fuel", 143584.27138550417, later),
        (&diesel, "maintenance", 61332.123646371096, later),
        (&diesel, "insurance", 22695.845829259568, later),
        (&diesel, "residual", -68365.592066257, 1.0),
        (&battery, "motor", 10111.787999999999, 1.0),
        (&battery, "charger", 600.0, 1.0),
        (&battery, "battery", 371215.92000000004, 1.0),
        (&battery, "depot_charging", 176372.83083791836, later),
        (&battery, "maintenance", 61332.123646371096, later),
        (&battery, "insurance", 71743.38825774405, later),
        (&battery, "residual", -216109.11758824004, 1.0),
    ] {
        assert_within(item, of_item(cost, item)[0], factor * found, 1e-4);
    }
}

#[test]
fn a_life_is_an_annuity() {
    // Σ v^i, i = 0 to n − 1, is (1 − v^n)/(1 − v)
    let v: f64 = 1.0 / 1.07;
    let life = Life::new(12.0, 0.07, 100_000.0);
    assert!((life.discounted_a - (1.0 - v.powi(12)) / (1.0 - v)).abs() < 1e-12);
    assert!((life.at_end - v.powi(12)).abs() < 1e-12 && life.years_a == 12.0);
    // half a year more is half of the thirteenth
    let longer = Life::new(12.5, 0.07, 100_000.0);
    assert!((longer.discounted_a - life.discounted_a - 0.5 * v.powi(12)).abs() < 1e-12);
    let undiscounted = Life::new(3.25, 0.0, 1.0);
    assert_eq!((undiscounted.years_a, undiscounted.discounted_a), (3.25, 3.25));
}

/// A truck that costs 100000, of which a tenth is left, over 5 years of 50000 km at 4 %.
fn simple(more: &Value) -> Costing {
    let mut table = json!({
        "currency": "EUR",
        "purchase_per_truck": 100_000.0,
        "residual_share": 0.1,
        "insurance_per_a": [2000.0, 1000.0],
        "driver_per_h": 30.0,
        "life_a": 5.0,
        "discount_rate_per_a": 0.04,
        "distance_km_per_a": 50_000.0,
    });
    table.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    Costing::new(&model(table), DIESEL, 15_000.0)
}

/// Trips that differ in length, load and consumption.
fn fleet(n: u64, seed: u64, litres: f64) -> Vec<Record> {
    let trip = |cycle_id| {
        let mut draws = Draws::new(seed, cycle_id, Stream::Curve);
        let distance_m = 80_000.0 * libm::exp(0.3 * draws.normal());
        let own = 1.0 + 0.1 * draws.normal();
        Record {
            cycle_id,
            distance_m,
            duration_s: distance_m / 20.0,
            payload_kg: 20_000.0 * draws.uniform(),
            urban_share: Some(0.25),
            motorway_share: Some(0.5),
            ..Record::default().with(Carrier::LiquidFuel, [None, Some(litres * own), None])
        }
    };
    (0..n).map(trip).collect()
}

#[test]
fn capital_insurance_and_hours_by_hand() {
    let cost = costed(&simple(&json!({})), &fleet(50, 1, 30.0));
    let v: f64 = 1.0 / 1.04;
    let years = (0..5).map(|i| v.powi(i)).sum::<f64>();
    let km = 50_000.0 * years;
    assert_within("residual", of_item(&cost, "residual")[0], -10_000.0 * v.powi(5), 1e-12);
    let insurance = 2000.0 + 1000.0 * (years - 1.0);
    assert_within("insurance", of_item(&cost, "insurance")[0], insurance, 1e-12);
    // 20 m/s throughout: 72 km an hour
    assert_within("driver", of_item(&cost, "driver")[0], km * 30.0 / 72.0, 1e-12);
    let total = 100_000.0 - 10_000.0 * v.powi(5) + insurance + km * 30.0 / 72.0;
    assert_within("total", cost.total.whole_life.unwrap(), total, 1e-12);
    assert_within("per km", cost.total.per_km, total / km, 1e-12);
    assert_within("per year", cost.total.per_a.unwrap(), 50_000.0 * total / km, 1e-12);
    let sum: f64 = cost.items.iter().map(|item| item.per_trip).sum();
    assert_within("items", sum, cost.total.per_trip, 1e-12);
    assert_within("trip", cost.total.per_trip, cost.total.per_km * cost.km_per_trip, 1e-12);
    let per_tkm = cost.total.per_km / cost.mean_payload_t;
    assert_within("tkm", cost.total.per_tkm.unwrap(), per_tkm, 1e-12);
    assert!(cost.spread.is_none() && cost.inputs.is_empty(), "no price is a law");
    assert_within("mean trip", cost.over_trips.mean, cost.total.per_trip, 1e-12);
    assert!(cost.over_trips.p5 < 0.8 * cost.over_trips.p50, "{:?}", cost.over_trips);
}

#[test]
fn tolls_count_where_and_for_whom_they_are_taken() {
    let toll = |from: Value, below: Value| {
        let mut toll = json!({ "road_types": ["urban", "motorway"], "toll_per_km": 0.2 });
        for (key, value) in [("from_kg", from), ("below_kg", below)] {
            if value.is_number() {
                toll[key] = value;
            }
        }
        toll
    };
    let records = fleet(20, 1, 30.0);
    let per_km = |table: Value| {
        let costing = Costing::new(&model(table), DIESEL, 15_000.0);
        costed(&costing, &records).total.per_km
    };
    let all = per_km(json!({ "currency": "EUR", "toll": [toll(Value::Null, Value::Null)] }));
    assert_within("urban and motorway", all, 0.75 * 0.2, 1e-12);
    // by the mass of the trip, 15 t and the payload; then by a class of its own
    let heavy = json!({ "currency": "EUR", "toll": [toll(json!(25_000.0), Value::Null)] });
    let km = |of: &dyn Fn(&Record) -> bool| -> f64 {
        records.iter().filter(|r| of(r)).map(|r| r.distance_m).sum()
    };
    let share = km(&|r| r.payload_kg >= 10_000.0) / km(&|_| true);
    assert!(share > 0.1 && share < 0.9, "{share}");
    assert_within("heavy trips", per_km(heavy.clone()), share * 0.75 * 0.2, 1e-12);
    let mut classed = heavy;
    classed["toll_mass_kg"] = json!(40_000.0);
    assert_within("by class", per_km(classed), 0.75 * 0.2, 1e-12);
    let light = json!({
        "currency": "EUR", "toll_mass_kg": 40_000.0, "toll": [toll(json!(0.0), json!(12_000.0))],
    });
    assert_eq!(per_km(light), 0.0);
}

#[test]
fn electricity_is_paid_where_it_was_charged() {
    let table = json!({
        "currency": "EUR", "charging_efficiency": 0.9,
        "depot_charging_per_kwh": 0.2, "public_charging_per_kwh": 0.5,
    });
    let costing = Costing::new(&model(table), ELECTRIC, 18_000.0);
    let record = Record {
        distance_m: 100_000.0,
        duration_s: 5000.0,
        charged_energy_j: Some(45.0 * 3.6e6),
        charging_loss_j: Some(2.0 * 3.6e6),
        ..Record::default().with(Carrier::Electricity, [Some(120.0 * 3.6e6), None, None])
    };
    let cost = costed(&costing, std::slice::from_ref(&record));
    let of = |name: &str| cost.items.iter().find(|item| item.item == name).unwrap().per_trip;
    assert_within("depot", of("depot_charging"), 75.0 / 0.9 * 0.2, 1e-12);
    assert_within("public", of("public_charging"), 47.0 / 0.9 * 0.5, 1e-12);
    assert!(cost.total.per_a.is_none() && cost.total.per_tkm.is_none(), "no life, no payload");
    // where a study charges by a policy, what meters counted is paid
    let metered = Record {
        grid_energy_depot_j: Some(80.0 * 3.6e6),
        grid_energy_public_j: Some(40.0 * 3.6e6),
        grid_energy_stop_j: Some(10.0 * 3.6e6),
        ..record
    };
    let cost = costed(&costing, &[metered]);
    let of = |name: &str| cost.items.iter().find(|item| item.item == name).unwrap().per_trip;
    assert_within("metered depot", of("depot_charging"), 80.0 * 0.2, 1e-12);
    assert_within("metered public", of("public_charging"), 50.0 * 0.5, 1e-12);
}

#[test]
fn electricity_emits_what_its_meters_count_times_the_factors_of_the_study() {
    let emissions: EmissionModel = serde_json::from_value(json!({
        "electricity_well_to_wheel_kg_per_kwh": 0.3, "electricity_generation_kg_per_kwh": 0.2,
        "charging_efficiency": 0.8,
    }))
    .unwrap();
    let cost = model(json!({ "currency": "EUR", "charging_efficiency": 0.9 }));
    let alone = EmissionFactors::of(Some(&emissions), None, None, true);
    let with_cost = EmissionFactors::of(Some(&emissions), Some(&cost), None, true);
    let record = Record {
        distance_m: 50_000.0,
        payload_kg: 10_000.0,
        mean_payload_kg: 10_000.0,
        ..Record::default().with(Carrier::Electricity, [Some(72.0 * 3.6e6), None, None])
    };
    let filled = |factors: &EmissionFactors, record: &Record| {
        let mut record = record.clone();
        factors.fill(&mut record);
        record
    };
    // 72 kWh of the battery over 50 km are 90 kWh of the meter, or 80 by the efficiency of the
    // costs
    for (factors, kwh) in [(&alone, 90.0), (&with_cost, 80.0)] {
        let found = filled(factors, &record);
        assert_within("grid", found.grid_co2_g_per_km.unwrap(), kwh * 200.0 / 50.0, 1e-12);
        let well = found.well_to_wheel_g_per_km.unwrap();
        assert_within("well", well, kwh * 300.0 / 50.0, 1e-12);
        assert_within("tkm", found.well_to_wheel_g_per_tkm.unwrap(), well / 10.0, 1e-12);
    }
    // a battery that no charger charges has nothing from the grid
    let fed = filled(&EmissionFactors::of(Some(&emissions), None, None, false), &record);
    assert_eq!((fed.grid_co2_g_per_km, fed.well_to_wheel_g_per_km), (None, None));
    let metered = Record {
        grid_energy_depot_j: Some(60.0 * 3.6e6),
        grid_energy_public_j: Some(20.0 * 3.6e6),
        grid_energy_stop_j: Some(20.0 * 3.6e6),
        ..record.clone()
    };
    let found = filled(&alone, &metered).grid_co2_g_per_km.unwrap();
    assert_within("metered", found, 100.0 * 200.0 / 50.0, 1e-12);
    // an empty truck has no tonnes, a cycle that stalled was not driven, and no factor is no number
    let empty = filled(&alone, &Record { payload_kg: 0.0, mean_payload_kg: 0.0, ..record.clone() });
    assert!(empty.well_to_wheel_g_per_km.is_some() && empty.well_to_wheel_g_per_tkm.is_none());
    let stalled = Record { outcome: Outcome::Stalled, ..record.clone() };
    assert_eq!(filled(&alone, &stalled), stalled);
    assert_eq!(filled(&EmissionFactors::default(), &record), record);
}

#[test]
fn trips_that_were_not_completed_have_no_cost() {
    let mut records = fleet(3, 1, 30.0);
    records[1].outcome = Outcome::Stalled;
    assert_eq!(trips(&simple(&json!({})), &records).len(), 2);
}

fn uncertain() -> Costing {
    simple(&json!({
        "fuel_per_l": { "distribution": "normal", "mean": 1.5, "sd": 0.2, "lower": 0.0 },
        "driver_per_h": { "distribution": "normal", "mean": 30.0, "sd": 2.0, "lower": 0.0 },
    }))
}

#[test]
fn shares_of_the_inputs_are_those_of_a_sum() {
    let records = fleet(100, 1, 30.0);
    let cost = costed(&uncertain(), &records);
    // litres and hours over km times the SD of their prices
    let km: f64 = records.iter().map(|r| r.distance_m / 1000.0).sum();
    let litres: f64 = records
        .iter()
        .map(|r| r.consumption(Carrier::LiquidFuel).unwrap() * r.distance_m / 1e5)
        .sum();
    let parts = [(0.2 * litres / km), (2.0 / 72.0)].map(|sd| sd * sd);
    let variance = parts[0] + parts[1];
    for (key, part) in [("cost.fuel_per_l", parts[0]), ("cost.driver_per_h", parts[1])] {
        let share = cost.inputs.iter().find(|input| input.key == key).unwrap();
        let known = part / variance;
        for (estimate, ci95) in [(share.first, share.first_ci95), (share.total, share.total_ci95)] {
            let [low, high] = ci95.unwrap();
            let error = (high - low) / 3.92;
            assert!((estimate - known).abs() < 4.0 * error, "{key}: {estimate} {known} {error}");
            assert!(error < 0.05, "{error}");
        }
    }
    let spread = cost.spread.unwrap().per_km;
    let sd = (spread.p95 - spread.p5) / (2.0 * 1.6448536);
    assert!((sd / variance.sqrt() - 1.0).abs() < 0.06, "{sd} {}", variance.sqrt());
    let error = variance.sqrt() / (STATES as f64).sqrt();
    assert!((spread.mean - cost.total.per_km).abs() < 4.0 * error, "{spread:?}");
}

#[test]
fn a_price_is_the_same_for_all_trips_and_in_both_studies() {
    let (a, b) = (uncertain(), uncertain());
    let states = [&a, &b].map(|costing| State::drawn(costing, 1, 7, |_| false));
    assert_eq!(states[0], states[1]);
    assert_ne!(states[0], State::drawn(&a, 1, 8, |_| false));
    assert_ne!(states[0], State::drawn(&a, 1, 7, |_| true));
    // a key more moves no other one
    let more = simple(&json!({
        "battery_per_kwh": 100.0,
        "combustion_maintenance_per_km": { "distribution": "uniform", "lower": 0.1, "upper": 0.2 },
        "driver_per_h": { "distribution": "normal", "mean": 30.0, "sd": 2.0, "lower": 0.0 },
    }));
    let other = State::drawn(&more, 1, 7, |_| false);
    let driver = |costing: &Costing, state: &State| {
        state.constant(costing.input("cost.driver_per_h").unwrap())
    };
    assert_eq!(driver(&a, &states[0]), driver(&more, &other));
}

/// A diesel truck that is cheap to buy, and one that is cheap to drive.
fn two(more: &Value) -> [Costing; 2] {
    let with = |own: Value| {
        let mut table = more.clone();
        table.as_object_mut().unwrap().extend(own.as_object().unwrap().clone());
        simple(&table)
    };
    [with(json!({})), with(json!({ "purchase_per_truck": 160_000.0 }))]
}

fn difference(costings: &[Costing; 2], records: [&[Record]; 2]) -> CostDifference {
    let [a, b] = [0, 1].map(|k| trips(&costings[k], records[k]));
    let side = |costing, trips| Fleet { costing, trips };
    let dependence = Dependence::default();
    CostDifference::of(side(&costings[0], &a), side(&costings[1], &b), 1, dependence).unwrap()
}

#[test]
fn the_break_even_is_the_root_that_brute_force_finds() {
    let (thirsty, thrifty) = (fleet(60, 1, 32.0), fleet(60, 1, 24.0));
    let prices = json!({ "fuel_per_l": [1.5, 1.6, 1.7] });
    let found = difference(&two(&prices), [&thirsty, &thrifty]);
    // costs anew at each distance and each price, the sign changes at the root
    let less = |more: Value| {
        let costings = two(&more);
        let cost = |k: usize, records: &[Record]| costed(&costings[k], records).total.per_km;
        cost(1, &thrifty) - cost(0, &thirsty)
    };
    let root = |of: &dyn Fn(f64) -> f64, mut low: f64, mut high: f64| {
        assert!(of(low) * of(high) < 0.0, "{} {}", of(low), of(high));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if of(middle) * of(low) > 0.0 { low = middle } else { high = middle }
        }
        low
    };
    let at_distance =
        |km: f64| less(json!({ "fuel_per_l": [1.5, 1.6, 1.7], "distance_km_per_a": km }));
    let distance = found.break_even_distance_km_per_a.unwrap();
    let brute = root(&at_distance, 1_000.0, 1e6);
    assert_within("distance", distance.value.unwrap(), brute, 1e-9);
    let at_price = |price: f64| less(json!({ "fuel_per_l": price }));
    let price = &found.break_even_prices[0];
    assert_eq!((price.key.as_str(), found.break_even_prices.len()), ("cost.fuel_per_l", 1));
    let brute = root(&at_price, 0.1, 1000.0);
    assert_within("price", price.price.value.unwrap(), brute, 1e-9);
    let [low, high] = distance.ci95.unwrap();
    assert!(low < distance.value.unwrap() && distance.value.unwrap() < high);
    assert!(distance.states.is_none() && distance.share_of_states.is_none(), "no price is a law");
}

#[test]
fn a_truck_that_is_never_cheaper_has_no_break_even() {
    let (thirsty, thrifty) = (fleet(20, 1, 32.0), fleet(20, 1, 24.0));
    // dearer to buy and to drive
    let found = difference(&two(&json!({ "fuel_per_l": 1.5 })), [&thrifty, &thirsty]);
    assert_eq!(found.break_even_distance_km_per_a.unwrap().value, None);
    assert_eq!(found.break_even_prices[0].price.value, None);
    assert_eq!(found.per_km.probability_a_cheaper, 1.0);
    assert_eq!(found.per_km.probability_ci95, Some([1.0, 1.0]));
    assert_eq!(found.share_of_trips_a_cheaper, 1.0);
}

#[test]
fn the_probability_is_that_of_the_law_of_the_price() {
    let (thirsty, thrifty) = (fleet(60, 1, 32.0), fleet(60, 1, 24.0));
    let even = difference(&two(&json!({ "fuel_per_l": 1.5 })), [&thirsty, &thrifty]);
    let even = even.break_even_prices[0].price.value.unwrap();
    // A, the cheap one to buy, is cheaper below the break-even price
    let law = json!({ "distribution": "normal", "mean": even + 0.15, "sd": 0.3 });
    let found = difference(&two(&json!({ "fuel_per_l": law })), [&thirsty, &thrifty]);
    let known = 0.5 * libm::erfc(0.5 / std::f64::consts::SQRT_2);
    let count = (found.per_km.probability_a_cheaper * STATES as f64).round() as usize;
    assert_share("A cheaper", count, STATES as usize, known);
    let only = &found.inputs[0];
    assert_eq!((only.key.as_str(), found.inputs.len()), ("cost.fuel_per_l", 1));
    assert!((only.total - 1.0).abs() < 0.05, "{only:?}");
    let distance = found.break_even_distance_km_per_a.unwrap();
    let spread = distance.states.unwrap();
    assert!(spread.p5 < distance.value.unwrap() && distance.value.unwrap() < spread.p95);
    assert!(distance.share_of_states > Some(0.99));
}

#[test]
fn what_both_pay_alike_does_not_decide() {
    let (thirsty, thrifty) = (fleet(30, 1, 32.0), fleet(30, 1, 24.0));
    let law = json!({ "distribution": "uniform", "lower": 20.0, "upper": 40.0 });
    // the same hours, so that the wage cancels
    let costings = two(&json!({ "driver_per_h": law.clone(), "fuel_per_l": 1.5 }));
    let found = difference(&costings, [&thirsty, &thrifty]);
    let states = found.per_km.difference_of_states.unwrap();
    assert!((states.p95 - states.p5).abs() < 1e-12, "{states:?}");
    assert!(costed(&costings[0], &thirsty).spread.unwrap().per_km.p5 > 0.0);
}

#[test]
fn the_interval_of_the_difference_is_that_of_paired_ratios() {
    let (thirsty, thrifty) = (fleet(400, 1, 32.0), fleet(400, 1, 24.0));
    let costings = two(&json!({ "fuel_per_l": 1.5 }));
    let found = difference(&costings, [&thirsty, &thrifty]);
    // linearised: residuals of both ratios, paired
    let states = costings.each_ref().map(State::central);
    let at = [0, 1].map(|k| Levelised::of(&costings[k], &states[k]));
    let all = [0, 1].map(|k| trips(&costings[k], [&thirsty[..], &thrifty][k]));
    let km: f64 = all[0].iter().map(|trip| trip.km).sum();
    let per_km = [found.per_km.a, found.per_km.b];
    let residual = |k: usize, i: usize| at[k].cost(&all[k][i]) - per_km[k] * all[k][i].km;
    let squares: f64 = (0..400).map(|i| (residual(1, i) - residual(0, i)).powi(2)).sum();
    let half_width = 1.966 * (400.0 / 399.0 * squares).sqrt() / km;
    let [low, high] = found.per_km.difference_ci95.unwrap();
    // an SD of 200 bootstrap samples is known to 5 %, percentiles of theirs less well
    let ratio = 0.5 * (high - low) / half_width;
    assert!((0.75..1.25).contains(&ratio), "{ratio}");
}

#[test]
fn the_walk_over_all_keys_finds_a_unit_in_each() {
    const UNITS: [&str; 11] = [
        "_per_l",
        "_per_kg",
        "_per_kwh",
        "_per_h",
        "_per_km",
        "_per_tkm",
        "_per_a",
        "_per_truck",
        "_per_kw",
        "_kg",
        "_a",
    ];
    // shares and ratios, and what is no number
    const WITHOUT: [&str; 5] =
        ["currency", "charging_efficiency", "residual_share", "road_types", "toll"];
    fn walk(key: Key, units: &[&str], without: &[&str], seen: &mut usize) {
        for (name, below) in key.entry().0["properties"].as_object().unwrap() {
            *seen += 1;
            let has_unit = units.iter().any(|unit| name.ends_with(unit));
            assert!(has_unit != without.contains(&name.as_str()), "`{name}`");
            if Key(below).entry().0.get("properties").is_some() {
                walk(Key(below), units, without, seen);
            } else if has_unit {
                let bounds = Key(below).bounds().unwrap_or_else(|| panic!("`{name}`: no range"));
                assert!(bounds.minimum >= 0.0, "`{name}` may be negative");
            }
        }
    }
    let schema = declarations();
    let mut seen = 0;
    walk(Key(schema).at("cost").unwrap(), &UNITS, &WITHOUT, &mut seen);
    assert!(seen > 25, "{seen}");
    let without = ["charging_efficiency"];
    let units = ["_kg_per_l", "_kg_per_kg", "_kg_per_kwh"];
    walk(Key(schema).at("emissions").unwrap(), &units, &without, &mut seen);
}

fn problems(table: Value) -> Vec<String> {
    let mut study = field_truck_model();
    study.cost = Some(model(table));
    let error = Study::new(study).err();
    error.map_or(Vec::new(), |e| e.problems.iter().map(ToString::to_string).collect())
}

#[test]
fn negative_prices_are_refused_by_name() {
    let valid = json!({
        "currency": "EUR", "fuel_per_l": 1.5, "depot_charging_per_kwh": 0.2,
        "public_charging_per_kwh": 0.5, "charging_efficiency": 0.9, "driver_per_h": 30.0,
        "combustion_maintenance_per_km": 0.1, "electric_maintenance_per_km": 0.1,
        "lost_payload_kg": 1000.0, "lost_payload_per_tkm": 0.1, "purchase_per_truck": 1e5,
        "tank_per_truck": 1e3, "charger_per_truck": 1e3, "engine_per_kw": 70.0, "motor_per_kw": 8.0,
        "battery_per_kwh": 200.0, "residual_share": 0.1, "insurance_per_a": 1000.0, "life_a": 7.0,
        "discount_rate_per_a": 0.04, "distance_km_per_a": 1e5, "toll_mass_kg": 40_000.0,
        "toll": [{ "toll_per_km": 0.2 }],
    });
    assert_eq!(problems(valid.clone()), Vec::<String>::new());
    for key in valid.as_object().unwrap().keys().filter(|key| *key != "currency" && *key != "toll")
    {
        let mut table = valid.clone();
        table[key] = json!(-1.0);
        let found = problems(table);
        let path = format!("`cost.{key}` is -1, allowed is ");
        assert!(found.len() == 1 && found[0].starts_with(&path), "{key}: {found:?}");
    }
    let mut table = valid.clone();
    table["toll"][0]["toll_per_km"] = json!(-0.2);
    assert!(problems(table)[0].starts_with("`cost.toll.toll_per_km` is -0.2"), "a toll");
    let mut table = valid.clone();
    table["fuel_per_l"] = json!([1.5, -1.5]);
    assert!(problems(table)[0].starts_with("`cost.fuel_per_l` is -1.5"), "in one year");
    let mut table = valid;
    table["fuel_per_l"] = json!({ "distribution": "normal", "mean": 1.0, "sd": 0.5 });
    let found = problems(table);
    assert!(found[0].contains("`cost.fuel_per_l` is a distribution that draws -1"), "{found:?}");
}

#[test]
fn keys_that_need_one_another_are_asked_for() {
    for (table, piece) in [
        (json!({ "currency": "euro" }), "`cost.currency` is `euro`, allowed is three capital"),
        (json!({ "currency": "EUR", "purchase_per_truck": 1.0 }), "`cost.life_a` is not there"),
        (json!({ "currency": "EUR", "life_a": 7.0 }), "given where `life_a` is"),
        (json!({ "currency": "EUR", "fuel_per_l": [1.0] }), "given where `fuel_per_l` is"),
        (
            json!({ "currency": "EUR", "depot_charging_per_kwh": 0.2 }),
            "`cost.charging_efficiency` is not there",
        ),
        (
            json!({ "currency": "EUR", "lost_payload_kg": 1.0 }),
            "`cost.lost_payload_per_tkm` is not there",
        ),
        (
            json!({ "currency": "EUR", "toll": [{ "toll_per_km": 0.1, "road_types": ["city"] }] }),
            "`cost.toll.road_types` is `city`, allowed is one of urban, rural, motorway",
        ),
        (
            json!({
                "currency": "EUR",
                "toll": [{ "toll_per_km": 0.1, "from_kg": 7500.0, "below_kg": 3500.0 }],
            }),
            "`cost.toll.below_kg` is 3500",
        ),
        (
            json!({
                "currency": "EUR", "driver_per_h": [], "life_a": 7.0, "discount_rate_per_a": 0.0,
                "distance_km_per_a": 1e5,
            }),
            "`cost.driver_per_h` is an empty list",
        ),
    ] {
        let found = problems(table);
        assert!(found.iter().any(|problem| problem.contains(piece)), "{piece}: {found:?}");
    }
}
