//! Measured trips beside a study: trucks that are known to differ are found, trucks that do not are
//! not ranked, a known saving is found, and no driver is named.

use crate::program::ocmc;
use ocmc_api::{
    Answer, BenchmarkAnswer, BenchmarkContrast, BenchmarkRequest, Error, RunPlan, Source,
    benchmark, go_on, study,
};
use ocmc_core::random::{Draws, Stream};
use ocmc_fleet::run::records;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::Path;
use tempfile::tempdir;

const LENGTH: &str = "mission.length_m=8000";
const TRUCKS: usize = 10;
const TRIPS: usize = 24;

/// Trips of a fleet whose trucks have effects of this size, -1, 0 and 1 in turn, and a change since
/// 2024, noise of 3 % and one trip with the fuel of three.
fn table(effect: f64, change: f64) -> String {
    let fleet = study::load("field-truck", &[LENGTH]).unwrap();
    let plan = RunPlan::new(5, 0, (TRUCKS * TRIPS) as u64, None, None);
    let driven = records(&fleet.study, &plan, |_| ControlFlow::<()>::Continue(()));
    let ControlFlow::Continue(driven) = driven else { panic!("ended") };
    let mut draws = Draws::new(11, 0, Stream::Bootstrap);
    let mut text = "truck,driver,date,km,litres,gross_weight_kg,driving_time_h,tyre\n".to_owned();
    for (k, trip) in driven.iter().enumerate() {
        let (truck, year) = (k % TRUCKS, 2023 + k / TRUCKS % 2);
        let km = trip.distance_m / 1000.0;
        let column = ocmc_core::record::column("consumption_l_per_100km").unwrap();
        let litres = column.get(trip).number().unwrap() * km / 100.0;
        let after = if year == 2024 { change } else { 0.0 };
        let own = effect * ((truck % 3) as f64 - 1.0);
        let times = (own + after + 0.03 * draws.normal()).exp();
        let times = if k == 77 { 3.0 * times } else { times };
        let month = 1 + k % 12;
        let (gross, hours) = (15_250.0 + trip.payload_kg, trip.duration_s / 3600.0);
        let driver = ["Anna Zett", "Bela Ypsilon"][k / 7 % 2];
        let tyre = ["old", "new"][year - 2023];
        writeln!(
            text,
            "t{truck},{driver},{year}-{month:02}-11,{km},{},{gross},{hours},{tyre}",
            litres * times
        )
        .unwrap();
    }
    // the last row is written down again
    let last = text.lines().last().unwrap().to_owned();
    text + &last + "\n"
}

fn asked(
    file: &Path,
    threads: usize,
    contrast: Option<BenchmarkContrast>,
) -> Result<BenchmarkAnswer, Error> {
    let request = BenchmarkRequest {
        trips: Source::File(file.to_owned()),
        mappings: ocmc_api::mappings(&["group=tyre".to_owned()]).unwrap(),
        study: ("field-truck".to_owned(), &study::load("field-truck", &[] as &[&str]).unwrap()),
        contrast,
        names: false,
        speed: true,
        cycles: 640,
        seed: 1,
        threads: Some(threads),
    };
    benchmark(&request, &mut go_on)
}

#[test]
fn known_trucks_and_a_known_saving_are_found_and_no_driver_is_named() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("trips.csv");
    std::fs::write(&file, table(0.08, -0.05)).unwrap();
    let since = BenchmarkContrast::Since("2024-01-01".to_owned());
    let answer = asked(&file, 2, Some(since)).unwrap();
    assert_eq!((answer.rows, answer.trucks, answer.drivers), (239, Some(10), Some(2)));
    assert_eq!(answer.doubled, 1);
    assert!(answer.far.len() == 1 && answer.far[0].place.contains("79"), "{:?}", answer.far);
    let trucks = answer.levels.iter().find(|level| level.level == "truck").unwrap();
    assert!(trucks.differ && trucks.members.len() == TRUCKS, "{trucks:?}");
    let thrifty: Vec<&str> = trucks.members[..4].iter().map(|m| m.name.as_str()).collect();
    assert!(["t0", "t3", "t6", "t9"].iter().all(|name| thrifty.contains(name)), "{thrifty:?}");
    for member in &trucks.members {
        // drawn to the mean, within the interval, and better if it stands before
        assert!((member.ratio - 1.0).abs() <= (member.raw_ratio - 1.0).abs() + 0.05);
        assert!(member.ci95[0] < member.ratio && member.ratio < member.ci95[1]);
    }
    let better: Vec<f64> = trucks.members.iter().map(|m| m.better_than_median).collect();
    assert!(better[0] > 0.9 && better[TRUCKS - 1] < 0.1, "{better:?}");
    let change = &answer.compared[0];
    let [low, high] = change.ci95.unwrap();
    let true_change = (-0.05_f64).exp() - 1.0;
    assert!(change.is_within_trucks && low < true_change && true_change < high, "{change:?}");
    let told = answer.text() + &answer.to_json();
    assert!(!told.contains("Anna") && !told.contains("Ypsilon"), "{told}");
    assert!(answer.text().lines().all(|line| line.chars().count() <= 80), "{}", answer.text());
    let numbers = |answer: &BenchmarkAnswer| {
        let mut json: serde_json::Value = serde_json::from_str(&answer.to_json()).unwrap();
        for key in ["wall_s", "compared"] {
            json[key] = 0.into();
        }
        json.to_string()
    };
    let groups = asked(&file, 1, Some(BenchmarkContrast::Group)).unwrap();
    assert_eq!(numbers(&answer), numbers(&groups));
    assert!(groups.compared.len() == 1 && groups.compared[0].change.is_some());
}

#[test]
fn trucks_that_do_not_differ_are_not_ranked_and_a_page_names_nobody() {
    let folder = tempdir().unwrap();
    let (file, out) = (folder.path().join("trips.csv"), folder.path().join("out"));
    std::fs::write(&file, table(0.0, 0.0)).unwrap();
    let paths = [&file, &out].map(|path| path.to_str().unwrap());
    let told = ocmc(&["benchmark", paths[0], "--cycles", "640", "--out", paths[1]]).assert();
    let told = String::from_utf8_lossy(&told.success().get_output().stdout).into_owned();
    assert!(told.contains("No differences between the 10 trucks beyond chance"), "{told}");
    for name in ["benchmark.json", "trips.csv", "report.html"] {
        let text = std::fs::read_to_string(out.join(name)).unwrap();
        assert!(!text.contains("Anna"), "{name}");
        assert!(name != "report.html" || text.contains("No ranking of trucks"));
    }
}

#[test]
fn what_cannot_be_compared_is_said() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("trips.csv");
    let line = "t,30,100,x\n".repeat(12);
    std::fs::write(&file, format!("truck,litres,km,tyre\n{line}")).unwrap();
    let says = |contrast, words: &str| {
        let error = asked(&file, 2, Some(contrast)).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    let since = |date: &str| BenchmarkContrast::Since(date.to_owned());
    says(since("2024-01-01"), "no row has a date");
    says(since("soon"), "allowed is a date");
    says(BenchmarkContrast::Group, "1 values in the rows that count");
}
