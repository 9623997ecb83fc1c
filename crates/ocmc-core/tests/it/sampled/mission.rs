//! Payload and departure of the default study.

use super::{CYCLES, cycles};
use crate::common::field_truck_model;
use crate::common::statistics::{SEEDS, assert_count, assert_follows, assert_mean, assert_share};
use ocmc_core::operating_cycle::mission::Mission;
use statrs::distribution::{Beta, ContinuousCDF, Normal};

fn missions(seed: u64) -> Vec<Mission> {
    let model = field_truck_model().mission;
    cycles(seed).map(|streams| model.sample(None, &streams, &[])).collect()
}

#[test]
fn one_in_five_runs_is_empty_and_the_others_are_limited_by_volume() {
    let share = Beta::new(4.0, 2.0).unwrap();
    for seed in SEEDS {
        let payloads: Vec<f64> = missions(seed).iter().map(|m| m.payload_kg).collect();
        assert_mean("payload", &payloads, 0.8 * 24_300.0 * 4.0 / 6.0);
        let loads: Vec<f64> = payloads.iter().copied().filter(|p| *p > 0.0).collect();
        assert_share("empty", payloads.len() - loads.len(), payloads.len(), 0.2);
        assert_follows("load", loads, |x| share.cdf(x / 24_300.0));
    }
}

#[test]
fn departures_are_three_shifts_wrapped_into_the_day() {
    let (early, late) = (Normal::new(6.0, 1.0).unwrap(), Normal::new(13.0, 2.0).unwrap());
    // probability of all the hours that wrap to below h
    let wrapped = |law: &Normal, h: f64| -> f64 {
        (-2..=2).map(|day| 24.0 * f64::from(day)).map(|d| law.cdf(d + h) - law.cdf(d)).sum()
    };
    for seed in SEEDS {
        let missions = missions(seed);
        assert!(missions.iter().all(|m| (0.0..86_400.0).contains(&m.departure_s)));
        let hours = missions.iter().map(|m| m.departure_s / 3600.0).collect();
        assert_follows("departure", hours, |h| {
            0.6 * wrapped(&early, h) + 0.3 * wrapped(&late, h) + 0.1 * h / 24.0
        });
        // whole days, each as likely
        let mut days = [0; 365];
        for mission in &missions {
            assert!(mission.day_of_year.fract() == 0.0);
            days[mission.day_of_year as usize] += 1;
        }
        for quarter in days.chunks(73) {
            assert_count("days", quarter.iter().sum(), CYCLES as f64 / 5.0);
        }
        assert!(days.iter().all(|n| *n > 0));
    }
}

#[test]
fn all_missions_are_100_km_without_stops() {
    assert!(missions(1).iter().all(|m| m.length_m == 100_000.0 && m.stops.is_empty()));
}
