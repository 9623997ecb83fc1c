//! Sampled densities come back as the model that drew them.

use crate::common::field_truck_model;
use ocmc_core::operating_cycle::traffic::TrafficModel;
use ocmc_core::random::Streams;
use ocmc_estimation::fit::traffic::{TrafficFitError, TrafficRecord, fit};

const DAY_S: f64 = 86_400.0;

/// Records of detectors of each road type in 20 days, one record every `every` steps.
fn detected(truth: &TrafficModel, seed: u64, every: usize) -> Vec<TrafficRecord> {
    let mut records = Vec::new();
    for (site, (road_type, model)) in truth.types.iter().enumerate() {
        let series = truth.sample(0.0, 20.0 * DAY_S, &Streams::new(seed, site as u64));
        for step in (0..20 * 288).step_by(every) {
            let time_s = (step as f64 + 0.5) * truth.step_s;
            records.push(TrafficRecord {
                site: site.to_string(),
                road_type: road_type.clone(),
                time_s,
                share: truth.density_per_m(model, &series, 0.0, time_s) / truth.jam_density_per_m,
            });
        }
    }
    records
}

#[test]
fn a_sampled_road_comes_back() {
    let truth = field_truck_model().traffic;
    let mut base = truth.clone();
    base.step_correlation = 0.1;
    base.logit_sd = 2.0;
    for of_type in base.types.values_mut() {
        (of_type.off_peak_share, of_type.peak_share) = (0.5, 0.6);
    }
    for every in [1, 2] {
        let mut found: Vec<Vec<(String, f64, f64)>> = Vec::new();
        for seed in 1..=20 {
            let fit = fit(&detected(&truth, seed, every), &base).unwrap();
            assert_eq!(fit.parameters.len(), 2 * truth.types.len() + 2, "{:?}", fit.warnings);
            let mut numbers = vec![
                ("step_correlation".to_owned(), fit.model.step_correlation, truth.step_correlation),
                ("logit_sd".to_owned(), fit.model.logit_sd, truth.logit_sd),
            ];
            for (name, of_type) in &fit.model.types {
                let wanted = &truth.types[name];
                numbers.push((
                    format!("{name}, off"),
                    of_type.off_peak_share,
                    wanted.off_peak_share,
                ));
                numbers.push((format!("{name}, peak"), of_type.peak_share, wanted.peak_share));
            }
            found.push(numbers);
        }
        let n = found.len() as f64;
        for (k, (name, _, wanted)) in found[0].iter().enumerate() {
            let values: Vec<f64> = found.iter().map(|numbers| numbers[k].1).collect();
            let mean = values.iter().sum::<f64>() / n;
            let sd = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
            let off = (mean - wanted).abs();
            assert!(off < 4.0 * sd / n.sqrt(), "{name}: {mean} ± {sd}, sampled with {wanted}");
        }
    }
}

#[test]
fn speeds_tell_densities() {
    let truth = field_truck_model().traffic;
    for share in [0.01, 0.1, 0.3] {
        let speed = truth.speed_mps(share * truth.jam_density_per_m, 30.0);
        assert!((truth.share_at(speed / 30.0) - share).abs() < 1e-9);
    }
    assert!(truth.share_at(1.2) == 0.0 && truth.share_at(0.0) == 1.0);
    assert!(truth.share_at(f64::NAN).is_nan());
}

#[test]
fn what_says_nothing_is_told() {
    let truth = field_truck_model().traffic;
    let mut records = detected(&truth, 1, 1);
    let few = fit(&records[..9], &truth).unwrap_err();
    assert!(matches!(few, TrafficFitError::Nothing { records: 9, .. }));
    assert!(few.to_string().contains("densities, at least 48"), "{few}");
    // one hour of the day determines no peak, however many days there are
    let mut night: Vec<_> = records.iter().filter(|r| r.time_s % DAY_S < 600.0).cloned().collect();
    let later = |r: &TrafficRecord| TrafficRecord { time_s: r.time_s + 100.0 * DAY_S, ..r.clone() };
    night.extend(night.clone().iter().map(later));
    let message = fit(&night, &truth).unwrap_err().to_string();
    assert!(message.contains("do not tell peak and off peak apart"), "{message}");
    records[0].share = f64::NAN;
    records[1].share = 0.0;
    records[3].road_type.clear();
    let some = fit(&records, &truth).unwrap();
    for words in ["1 records have no density", "1 densities beyond", "1 records have no road type"]
    {
        assert!(some.warnings.iter().any(|w| w.contains(words)), "{:?}", some.warnings);
    }
    records[2].road_type = "lane".to_owned();
    let message = fit(&records, &truth).unwrap_err().to_string();
    assert!(message.contains("`lane`") && message.contains("motorway"), "{message}");
}

#[test]
fn noise_of_floating_cars_does_not_bias_the_traffic() {
    use ocmc_core::random::{Draws, Stream};
    use ocmc_estimation::fit::traffic::fit_speeds;
    let truth = field_truck_model().traffic;
    let mut covered = (0, 0);
    for seed in 1..=12 {
        let mut draws = Draws::new(seed, 99, Stream::Traffic);
        let mut records = detected(&truth, seed, 1);
        let ratios: Vec<f64> = records
            .iter()
            .map(|record| {
                let speed = (-0.5 * (record.share / truth.critical_share).powi(2)).exp();
                speed + 0.05 * draws.normal()
            })
            .collect();
        let found = fit_speeds(&records, &ratios, &truth).unwrap();
        let noise = found.speed_noise_sd.unwrap();
        assert!((noise - 0.05).abs() < 0.005, "{noise}");
        for parameter in &found.parameters {
            let model = serde_json::to_value(&truth).unwrap();
            let wanted = parameter.key.split('.').fold(&model, |value, part| &value[part]);
            let off = (parameter.value - wanted.as_f64().unwrap()).abs();
            let error = parameter.standard_error.unwrap();
            assert!(off < 5.0 * error, "seed {seed}: {parameter:?}, {wanted}");
            covered = (covered.0 + usize::from(off < 1.96 * error), covered.1 + 1);
        }
        // a density that is worked out of each speed has the noise
        for (record, ratio) in records.iter_mut().zip(&ratios) {
            record.share = truth.share_at(*ratio);
        }
        let naive = fit(&records, &truth).unwrap();
        assert!(naive.model.logit_sd > 1.5 * truth.logit_sd, "{}", naive.model.logit_sd);
    }
    // 12 fits of 8 numbers
    assert!(covered.1 == 96 && covered.0 >= 83, "{covered:?}");
}
