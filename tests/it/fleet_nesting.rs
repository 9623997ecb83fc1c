//! Trips within trucks: whose draws a trip takes, what a fleet of trucks adds up to, and what its
//! files hold.

use crate::common::study;
use crate::program::{ocmc, run_into};
use ocmc_core::record::{COLUMNS, Cell, Record};
use ocmc_core::study::Study;
use ocmc_estimation::fit::fleet::{FleetOptions, FleetTable, fit};
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::run::{RunPlan, records};
use ocmc_fleet::sensitivity::Over;
use ocmc_fleet::shapley::shapley;
use ocmc_fleet::summary::{Summary, SummaryBuilder};
use std::convert::Infallible;
use std::fs;
use std::ops::ControlFlow;
use std::process::Output;

const ROAD: &str = "mission.length_m=4000";

fn output(arguments: &[&str]) -> Output {
    ocmc(arguments).output().expect("it starts")
}

fn driven(study: &Study, first_cycle: u64, cycles: u64) -> Vec<Record> {
    let plan = RunPlan::new(1, first_cycle, cycles, None, None);
    let ControlFlow::Continue(driven) =
        records::<Infallible>(study, &plan, |_| ControlFlow::Continue(()));
    driven
}

fn fleet(sets: &[&str]) -> Study {
    study("field-truck", &[&[ROAD], sets].concat())
}

fn summary(study: &Study, driven: &[Record]) -> Summary {
    let mut fleet = SummaryBuilder::new(Dependence::of(study.model(), 1));
    fleet.add(driven);
    fleet.finish()
}

/// Columns in which two records differ, their cycles' numbers left aside.
fn differences(a: &Record, b: &Record) -> Vec<&'static str> {
    let ours = ["cycle_id", "trip", "truck_id"];
    let columns = COLUMNS.iter().filter(|column| !ours.contains(&column.name));
    let differ = |a: Cell, b: Cell| match (a, b) {
        (Cell::Number(Some(a)), Cell::Number(Some(b))) => a.to_bits() != b.to_bits(),
        _ => a != b,
    };
    let found = columns.filter(|column| differ(column.get(a), column.get(b)));
    found.map(|column| column.name).collect()
}

#[test]
fn a_pool_and_shared_days_widen_the_intervals_and_are_said() {
    let calendar = "fleet.calendar={ operating_days_per_week = 5, trips_per_day = 2, \
                    departure_interval_s = 3600.0, shared_weather = true }";
    let half = |summary: &Summary| {
        let [low, high] = summary.consumption().expect("fuel").ci95.expect("trucks");
        high - low
    };
    let note = |summary: &Summary| summary.trucks.as_ref().expect("trucks").note;
    for (set, said) in [("fleet.driver_pool=6", "the pool"), (calendar, "the days")] {
        let study = fleet(&["fleet.trips_per_truck=10", set]);
        let records = driven(&study, 0, 300);
        let own = Dependence::of(study.model(), 1);
        let found = summary(&study, &records);
        assert!(note(&found).expect("they share").contains(said), "{set}");
        let mut by_trucks =
            SummaryBuilder::new(Dependence { pool: None, shares_days: false, ..own });
        by_trucks.add(&records);
        let by_trucks = by_trucks.finish();
        assert_eq!(note(&by_trucks), None);
        assert!(half(&found) > half(&by_trucks), "{set}");
        // only intervals differ
        let mean = |summary: &Summary| summary.consumption().expect("fuel").mean;
        assert!((mean(&found).expect("trips") - mean(&by_trucks).expect("trips")).abs() < 1e-9);
        // a driver whom the summary takes for one of the pool is he who drove
        if let Some(pool) = own.pool {
            for record in &records {
                let driver = pool.driver_of(record.cycle_id / 10, record.cycle_id % 10);
                assert_eq!(record.driver_id, Some(driver));
            }
        }
    }
}

#[test]
fn a_run_of_trucks_says_all_that_it_wrote() {
    let parent = tempfile::tempdir().expect("a directory");
    let out = parent.path().join("fleet");
    let arguments = ["--trucks", "3", "--trips", "4", "--set", ROAD, "--out"];
    let done = ocmc(&arguments).arg(&out).assert().success().get_output().clone();
    let said = String::from_utf8(done.stderr).expect("UTF-8");
    assert!(said.contains(": records.parquet, trucks.parquet, manifest.json"), "{said}");
    assert!(out.join("trucks.parquet").is_file());
}

#[test]
fn more_trips_and_more_trucks_change_no_trip_that_was_there() {
    let alone = driven(&fleet(&[]), 0, 6);
    let five = driven(&fleet(&["fleet.trips_per_truck=5"]), 0, 30);
    let nine = driven(&fleet(&["fleet.trips_per_truck=9"]), 0, 54);
    for truck in 0..6 {
        // the first trip is the cycle of a truck that makes no other
        assert_eq!(differences(&alone[truck], &five[5 * truck]), Vec::<&str>::new());
        for trip in 0..5 {
            let (a, b) = (&five[5 * truck + trip], &nine[9 * truck + trip]);
            assert_eq!(differences(a, b), Vec::<&str>::new(), "truck {truck}, trip {trip}");
            assert_eq!((b.truck_id, b.trip), (truck as u64, trip as u64));
        }
    }
}

#[test]
fn a_truck_keeps_its_driver_and_itself_and_meets_other_roads() {
    let driven = driven(&fleet(&["fleet.trips_per_truck=6", "fleet.drivers_per_truck=2"]), 0, 60);
    for truck in driven.chunks(6) {
        assert!(truck.iter().all(|trip| trip.drag_area_m2 == truck[0].drag_area_m2));
        for (k, trip) in truck.iter().enumerate() {
            // two drivers, in turn
            let same = &truck[k % 2];
            assert_eq!(trip.driver_id, same.driver_id);
            assert_eq!(trip.driver_effect, same.driver_effect);
            assert_eq!(trip.driver_kp, same.driver_kp);
            assert_eq!(trip.driver_compliance, same.driver_compliance);
        }
        assert!(truck[0].driver_effect != truck[1].driver_effect);
        let climbs = truck.iter().map(|trip| trip.climb_m.to_bits());
        let mut climbs: Vec<u64> = climbs.collect();
        climbs.sort_unstable();
        climbs.dedup();
        assert_eq!(climbs.len(), 6, "another road each trip");
    }
    let trucks: Vec<f64> = driven.chunks(6).map(|truck| truck[0].drag_area_m2).collect();
    assert!(trucks.windows(2).all(|two| two[0] != two[1]));
}

#[test]
fn a_pool_of_drivers_is_shared_by_all_trucks() {
    let driven = driven(&fleet(&["fleet.trips_per_truck=10", "fleet.driver_pool=4"]), 0, 200);
    let mut of_driver = [None; 4];
    for trip in &driven {
        let driver = trip.driver_id.expect("there") as usize;
        let effect = of_driver[driver].get_or_insert(trip.driver_effect);
        assert_eq!(*effect, trip.driver_effect, "driver {driver}");
    }
    assert!(of_driver.iter().all(Option::is_some));
    // trucks are not independent of one another, and the answer says so
    let pool = fleet(&["fleet.trips_per_truck=10", "fleet.driver_pool=4"]);
    assert!(summary(&pool, &driven).trucks.expect("trucks").note.is_some());
    let own = fleet(&["fleet.trips_per_truck=10"]);
    assert!(summary(&own, &driven).trucks.expect("trucks").note.is_none());
}

#[test]
fn levels_move_quantities_between_trips_and_trucks() {
    let levels = [
        "fleet.trips_per_truck=5",
        "fleet.levels.payload=truck",
        "fleet.levels.pedals=trip",
        "fleet.levels.vehicle=trip",
    ];
    let found = driven(&fleet(&levels), 0, 50);
    for truck in found.chunks(5) {
        assert!(truck.iter().all(|trip| trip.payload_kg == truck[0].payload_kg));
        assert!(truck.windows(2).all(|two| two[0].drag_area_m2 != two[1].drag_area_m2));
        assert!(truck.windows(2).any(|two| two[0].driver_kp != two[1].driver_kp));
        assert!(truck.iter().all(|trip| trip.driver_effect == truck[0].driver_effect));
    }
    // a level of one law alone
    let law = "vehicle.auxiliary_power_w={distribution=\"log_normal\",median=2000.0,log_sd=0.3,\
               level=\"trip\"}";
    let found = driven(&fleet(&["fleet.trips_per_truck=5", law]), 0, 10);
    let power = |trip: &Record| trip.auxiliary_energy_j / trip.duration_s;
    for truck in found.chunks(5) {
        assert!(truck.iter().all(|trip| trip.drag_area_m2 == truck[0].drag_area_m2));
        assert!(truck.windows(2).all(|two| power(&two[0]) != power(&two[1])));
    }
}

#[test]
fn trips_follow_the_calendar_and_share_its_weather() {
    let calendar = "fleet.calendar={operating_days_per_week=5,trips_per_day=2,\
                    departure_interval_s=21600.0,shared_weather=true}";
    let clock = "mission.departure_s_of_day=28800.0";
    let found = driven(&fleet(&["fleet.trips_per_truck=40", calendar, clock]), 0, 80);
    for trip in &found {
        let number = trip.trip;
        let day = number / 2 / 5 * 7 + number / 2 % 5;
        let second = 28_800 + 21_600 * (number % 2);
        assert_eq!(trip.departure_s_of_year, (86_400 * day + second) as f64, "trip {number}");
    }
    // the same hour of the same day: the same air for both trucks, whatever their roads
    for (a, b) in found[..40].iter().zip(&found[40..]) {
        let apart = (a.air_temperature_k - b.air_temperature_k).abs();
        // along a trip of minutes the hour's slope is met
        assert!(apart < 0.5, "{} {}", a.air_temperature_k, b.air_temperature_k);
    }
    let own = calendar.replace("shared_weather=true", "shared_weather=false");
    let own = driven(&fleet(&["fleet.trips_per_truck=40", &own, clock]), 0, 80);
    let far = own[..40].iter().zip(&own[40..]);
    let far = far.filter(|(a, b)| (a.air_temperature_k - b.air_temperature_k).abs() > 0.5);
    assert!(far.count() > 20);
}

#[test]
fn home_climate_and_mix_of_roads_differ_between_trucks() {
    let climate = ["fleet.trips_per_truck=30", "weather.temperature.truck_sd_k=8.0"];
    let mix = ["fleet.trips_per_truck=30", "road.truck_mix_log_sd=1.5", "mission.length_m=20000"];
    let between = |sets: &[&str], value: fn(&Record) -> f64| {
        let found = driven(&fleet(sets), 0, 30 * 30);
        let means = found.chunks(30).map(|truck| truck.iter().map(value).sum::<f64>() / 30.0);
        let means: Vec<f64> = means.collect();
        let mean = means.iter().sum::<f64>() / 30.0;
        (means.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 29.0).sqrt()
    };
    let air: fn(&Record) -> f64 = |trip| trip.air_temperature_k;
    let urban: fn(&Record) -> f64 = |trip| trip.urban_share.expect("a type of roads");
    // the year and the hours: about 9 K / √30 = 1.6 K without, √(8² + 1.6²) with; 29 degrees of
    // freedom: ± 4 · 13 %
    let (same, other) = (between(&climate[..1], air), between(&climate, air));
    assert!(same < 2.7 && (3.9..12.5).contains(&other), "{same} {other}");
    let same = between(&[mix[0], mix[2]], urban);
    let other = between(&mix, urban);
    assert!(other > 1.8 * same, "{same} {other}");
}

#[test]
fn clustered_intervals_are_wider_where_trucks_differ() {
    let nested = fleet(&["fleet.trips_per_truck=20"]);
    let driven = driven(&nested, 0, 2000);
    let clustered = summary(&nested, &driven);
    let mut alone = SummaryBuilder::default();
    alone.add(&driven);
    let alone = alone.finish();
    let width = |summary: &Summary| {
        let [low, high] = summary.consumption().and_then(|own| own.ci95).expect("2000 trips");
        high - low
    };
    // fewer and fewer of the trips' spread is the trips': the design effect is 1 + 19 ρ
    let rho = clustered.trucks.as_ref().and_then(|trucks| trucks.components.as_ref());
    let rho = rho.expect("100 trucks").share_of_trips;
    let effect = (width(&clustered) / width(&alone)).powi(2);
    assert!(rho > 0.02, "{rho}");
    // relative errors: of ρ about 25 %, of a variance of 100 trucks 14 %, twice
    assert!((effect / (1.0 + 19.0 * rho) - 1.0).abs() < 0.5, "{effect} {rho}");
    let trucks = clustered.trucks.expect("trucks");
    assert_eq!((trucks.trucks, trucks.years, trucks.rows.len()), (100, 1, 100));
    // totals of the rows are those of the records
    let km: f64 = trucks.rows.iter().map(|row| row.distance_m).sum();
    let all: f64 = driven.iter().map(|trip| trip.distance_m).sum();
    assert!((km / all - 1.0).abs() < 1e-12);
    assert_eq!(trucks.rows.iter().map(|row| row.n_trips + row.n_failed).sum::<u64>(), 2000);
}

#[test]
fn trucks_and_trips_are_typed_and_written() {
    let folder = tempfile::tempdir().expect("a directory");
    let out = folder.path().join("a");
    let options = ["--set", ROAD, "--trucks", "12", "--trips", "5", "--threads"];
    let out_option = ["1", "--out", out.to_str().expect("a name")];
    let told = output(&[&options[..], &out_option].concat());
    let text = String::from_utf8_lossy(&told.stdout);
    assert!(text.contains("12 trucks, 5 trips each: totals"), "{text}");
    assert!(out.join("trucks.parquet").is_file());
    let sums = fs::read_to_string(out.join("checksums.sha256")).expect("written");
    assert!(sums.contains("trucks.parquet"), "{sums}");
    // other threads, and parts of whole trucks: the same bytes
    let part = |name: &str, first: &str, trucks: &str| {
        let out = folder.path().join(name);
        let range = ["--first-cycle", first, "--trucks", trucks, "--trips", "5"];
        run_into(&out, &[&["--set", ROAD, "--threads", "2"], &range[..]].concat());
        out
    };
    let parts = [part("b", "0", "7"), part("c", "35", "5")];
    let merged = folder.path().join("d");
    let [b, c] = parts.each_ref().map(|part| part.to_str().expect("a name"));
    let merge = output(&["merge", b, c, "--out", merged.to_str().expect("a name")]);
    assert_eq!(merge.status.code(), Some(0), "{}", String::from_utf8_lossy(&merge.stderr));
    for file in ["records.parquet", "manifest.json", "trucks.parquet"] {
        let [a, d] = [&out, &merged].map(|of| fs::read(of.join(file)).expect("written"));
        assert!(a == d, "{file}");
    }
}

#[test]
fn bad_fleets_are_refused_by_name() {
    for (sets, wanted) in [
        (&["fleet.trips_per_truck=0"][..], "fleet.trips_per_truck"),
        (&["fleet.levels.payload=lorry"], "lorry"),
        (&["fleet.levels.bootstrap=truck"], "fleet.levels.bootstrap"),
        (&["fleet.drivers_per_truck=2", "fleet.driver_pool=9"], "fleet.drivers_per_truck"),
        (
            &["fleet.calendar={operating_days_per_week=5,trips_per_day=2}"],
            "fleet.calendar.departure_interval_s",
        ),
        (&["fleet.calendar={operating_days_per_week=8,trips_per_day=1}"], "operating_days"),
        (
            &["mission.payload_kg={distribution=\"normal\",mean=5000.0,sd=10.0,truck_sd=-1.0}"],
            "mission.payload_kg",
        ),
        (
            &["mission.payload_kg={distribution=\"uniform\",lower=0.0,upper=1.0,level=\"lorry\"}"],
            "lorry",
        ),
        (
            &["road.net_climb_m={distribution=\"normal\",mean=0.0,sd=1.0,level=\"truck\"}"],
            "road.net_climb_m.level",
        ),
    ] {
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
        let refused = output(&[&["--cycles", "2"], &sets[..]].concat());
        let text = String::from_utf8_lossy(&refused.stderr);
        assert_eq!(refused.status.code(), Some(1), "{sets:?}: {text}");
        assert!(text.contains(wanted), "{sets:?}: {text}");
    }
    // a run holds whole trucks
    let refused = output(&["--cycles", "7", "--trips", "5"]);
    let text = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{text}");
    assert!(text.contains("`cycles` is 7") && text.contains("such as 10"), "{text}");
}

#[test]
fn the_report_shows_the_trucks() {
    let folder = tempfile::tempdir().expect("a directory");
    let out = folder.path().join("a");
    run_into(&out, &["--set", ROAD, "--trucks", "12", "--trips", "6"]);
    let path = out.to_str().expect("a name");
    assert_eq!(output(&["report", path]).status.code(), Some(0));
    let page = fs::read_to_string(out.join("report.html")).expect("written");
    let part = page.split("<h2>Trucks: 12</h2>").nth(1).expect("a part about trucks");
    let part = part.split("<h2>").next().expect("it ends");
    assert_eq!(part.matches("<circle").count(), 12, "a point for each truck");
    assert!(part.contains("another fleet") && part.contains("by month"), "{part}");
    // a run without trucks has no such part
    let alone = folder.path().join("b");
    run_into(&alone, &["--set", ROAD, "--cycles", "12"]);
    assert_eq!(output(&["report", alone.to_str().expect("a name")]).status.code(), Some(0));
    let page = fs::read_to_string(alone.join("report.html")).expect("written");
    assert!(!page.contains("<h2>Trucks"));
}

/// Loads of trucks and of their trips whose SDs are set, driven, and laid before the fit of
/// records. Bounds lie 5 SDs away and more.
const LOADS: &str = "mission.payload_kg={distribution=\"normal\",mean=12000.0,sd=2000.0,\
     truck_sd=1000.0,lower=0.0,upper=24000.0}";

/// SDs between trucks and between trips that the fit finds in the loads of driven trips.
fn fitted_sds(driven: &[&Record]) -> [f64; 2] {
    let table = FleetTable {
        truck: driven.iter().map(|trip| trip.truck_id.to_string()).collect(),
        driver: None,
        value: driven.iter().map(|trip| trip.payload_kg).collect(),
        weight: None,
        covariates: Vec::new(),
        departure_s_of_year: None,
        completed: None,
    };
    let found = fit(&table, &FleetOptions::default()).expect("two levels").components;
    let sd = |level| found.iter().find(|one| one.level == level).expect("a level").sd;
    [sd("truck"), sd("trip")]
}

#[test]
fn the_fit_of_driven_records_returns_the_sds_that_were_set() {
    let study = fleet(&["fleet.trips_per_truck=10", "mission.length_m=200", LOADS]);
    let mut whole: Vec<[f64; 2]> = Vec::new();
    let mut thinned: Vec<[f64; 2]> = Vec::new();
    for seed in 101..121 {
        let plan = RunPlan::new(seed, 0, 2000, None, None);
        let ControlFlow::Continue(driven) =
            records::<Infallible>(&study, &plan, |_| ControlFlow::Continue(()));
        whole.push(fitted_sds(&driven.iter().collect::<Vec<_>>()));
        // two to ten trips of a truck
        let few = driven.iter().filter(|trip| trip.trip < 2 + trip.truck_id * 5 % 9);
        thinned.push(fitted_sds(&few.collect::<Vec<_>>()));
    }
    for (design, fitted) in [("even", whole), ("uneven", thinned)] {
        for (level, set) in [1000.0, 2000.0].into_iter().enumerate() {
            let n = fitted.len() as f64;
            let mean = fitted.iter().map(|sds| sds[level]).sum::<f64>() / n;
            let spread = fitted.iter().map(|sds| (sds[level] - mean).powi(2)).sum::<f64>();
            let error = (spread / (n - 1.0) / n).sqrt();
            println!("{design}, level {level}: {mean:.1} ± {error:.1} for {set}");
            assert!((mean - set).abs() < 4.0 * error, "{design} {level}: {mean} ± {error}");
            assert!(error < 0.02 * set, "{design} {level}: {error} tells nothing");
        }
    }
}

#[test]
fn shapley_shares_of_trucks_add_up_and_what_does_not_act_has_none() {
    // loads differ by truck and by trip; how often a truck stops is the road's matter alone, but
    // for the millimetres that a trip's end overshoots
    let study = fleet(&["fleet.trips_per_truck=4", LOADS]);
    let stops = ocmc_fleet::quantity::quantity("stops_per_km");
    for (quantity, over) in [(None, Over::Truck), (stops, Over::Truck), (stops, Over::Trip)] {
        let plan = RunPlan::new(5, 0, 64, None, None);
        let ControlFlow::Continue(found) =
            shapley::<Infallible>(&study, &plan, quantity, over, |_| ControlFlow::Continue(()));
        let effects = found.expect("trucks differ");
        let sum: f64 = effects.factors.iter().map(|factor| factor.share).sum();
        assert!((sum - 1.0).abs() < 1e-12, "{over:?}: {sum}");
        for factor in &effects.factors {
            let acts = quantity.is_none() || factor.factor == "road";
            assert_eq!(factor.share.abs() > 1e-6, acts, "{over:?}: {factor:?}");
        }
    }
}
