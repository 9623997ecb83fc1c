//! Learning from a folder: what each file is, what is fitted and calibrated, the check on trips
//! that were held back, and the standing of each number in the study that is written.

use crate::program::ocmc;
use ocmc_api::{Answer, Error, LearnAnswer, LearnRequest, Noise, RunPlan, go_on, learn, study};
use ocmc_fleet::run::records;
use ocmc_io::export::ExportKind;
use std::fmt::Write;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use tempfile::tempdir;

/// A fleet of short trips that takes more than the base.
const FLEET: [&str; 2] =
    ["mission.length_m=5000", "vehicle.powertrain.combustion.engine.fuel_factor=1.2"];
const TRIPS: u64 = 60;

/// Totals of trips of six trucks on days of their own.
fn trips() -> String {
    let fleet = study::load("field-truck", &FLEET).unwrap();
    let plan = RunPlan::new(5, 0, TRIPS, None, None);
    let driven = records(&fleet.study, &plan, |_| ControlFlow::<()>::Continue(()));
    let ControlFlow::Continue(driven) = driven else { panic!("ended") };
    let column = ocmc_core::record::column("consumption_l_per_100km").unwrap();
    let mut text = "truck,date,km,litres,gross_weight_kg,driving_time_h\n".to_owned();
    for (k, trip) in driven.iter().enumerate() {
        let km = trip.distance_m / 1000.0;
        let litres = column.get(trip).number().unwrap() * km / 100.0;
        let (gross, hours) = (15_250.0 + trip.payload_kg, trip.duration_s / 3600.0);
        let day = format!("2024-{:02}-{:02}", 1 + k / 20, 1 + k % 20);
        writeln!(text, "truck-{},{day},{km},{litres},{gross},{hours}", k % 6).unwrap();
    }
    text
}

/// Hours of a place whose mean temperature is 276 K.
fn weather() -> String {
    // what is beside the two waves fades over some hours, from draws without end
    let (mut state, mut other) = (1_u64, 0.0);
    let mut row = |k: u32| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let uniform = (state >> 11) as f64 / 2.0_f64.powi(53);
        other = 0.97 * other + 3.0 * (uniform - 0.5);
        // warmest in July, and at two o'clock
        let wave =
            |at_h: f64, of_h: f64| (std::f64::consts::TAU * (f64::from(k) - at_h) / of_h).cos();
        let kelvin = 276.0 + 9.0 * wave(4500.0, 8760.0) + 3.0 * wave(14.0, 24.0) + other;
        format!("{},{kelvin:.2}\n", 3600 * k)
    };
    let timed: String = (0..8760).map(&mut row).collect();
    format!("time_s,temperature_k\n{timed}")
}

fn learnt(folder: &Path, seed: u64) -> Result<LearnAnswer, Error> {
    let base = &study::load("field-truck", &FLEET[..1]).unwrap();
    let request = LearnRequest {
        folder: folder.to_owned(),
        mappings: Vec::new(),
        base: ("field-truck".to_owned(), base),
        name: "mine".to_owned(),
        noise: Noise { amount: 0.0, weight: 0.0 },
        hold_back: 0.2,
        seed,
        threads: None,
    };
    learn(&request, &mut go_on)
}

#[test]
fn a_study_is_learnt_from_a_folder_and_says_of_each_number_where_it_is_from() {
    let folder = tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    fs::create_dir(place("weather")).unwrap();
    fs::write(place("trips.csv"), trips()).unwrap();
    fs::write(place("weather/hours.csv"), weather()).unwrap();
    fs::write(place("notes.txt"), "a note").unwrap();
    let answer = learnt(folder.path(), 1).unwrap();
    let kinds: Vec<_> = answer.files.iter().map(|f| f.kind.map(ExportKind::words)).collect();
    assert_eq!(kinds, [None, Some("totals of trips"), Some("weather")]);
    assert!(answer.files[0].left_out.is_some());
    assert!(answer.parts.iter().all(|part| part.refused.is_none()), "{:?}", answer.parts);
    // the table's mean, and less doubt than before
    let totals = answer.totals.as_ref().unwrap();
    assert!((totals.simulated.mean / totals.table.mean - 1.0).abs() < 1e-9);
    assert!(answer.doubt[1].together < answer.doubt[0].together, "{:?}", answer.doubt);
    // trips that it was not learnt from, some 15 % each beside what is expected
    let held = answer.held_back.as_ref().unwrap();
    let (within, n) = (held.within as f64, held.trips.len() as f64);
    assert!(held.learnt_from + held.trips.len() == TRIPS as usize && (10.0..=12.0).contains(&n));
    assert!(within >= 0.9 * n - 3.0 * (0.09 * n).sqrt(), "{within} of {n}");
    let off = held.expected / held.measured - 1.0;
    assert!(off.abs() < 4.0 * 0.15 / n.sqrt(), "{held:?}");
    // each number says where it is from
    let mine = study::load_text("mine.toml", &answer.study_toml, &[] as &[&str]).unwrap();
    let standing = |key: &str| {
        let number = mine.replaced().iter().find(|number| number.key.starts_with(key));
        number.map(|number| number.standing.clone()).unwrap_or_default()
    };
    for (key, from) in [
        ("weather.temperature.mean_k", "fitted from `weather/hours.csv`"),
        ("mission.payload_kg", "calibrated on 60 trips of 6 trucks"),
    ] {
        assert!(standing(key).starts_with(from), "{key}: {}", standing(key));
    }
    assert!(mine.model.uncertain().is_some());
    assert!(answer.text().contains("held back"), "{}", answer.text());
    // neither names of drivers nor places
    let page = folder.path().join("page.html");
    answer.save_page(&page).unwrap();
    let page = fs::read_to_string(page).unwrap();
    assert!(page.contains("Trips that were held back") && !page.contains("truck-3"), "{page}");
}

#[test]
fn a_folder_without_anything_says_what_is_allowed() {
    let folder = tempdir().unwrap();
    fs::write(folder.path().join("invoice.csv"), "number,amount_eur\n1,5\n").unwrap();
    let error = learnt(folder.path(), 1).unwrap_err().to_string();
    assert!(error.contains("nothing in it can be learnt from"), "{error}");
    let told = ocmc(&["learn", folder.path().join("none").to_str().unwrap()]).assert().failure();
    let told = String::from_utf8_lossy(&told.get_output().stderr).into_owned();
    assert!(told.contains("cannot read"), "{told}");
}
