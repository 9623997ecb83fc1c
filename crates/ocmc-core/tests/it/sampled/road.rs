//! Signs, curves, junction turns, ground and heading of the default study.

use crate::common::statistics::{SEEDS, assert_count, assert_follows, assert_near, assert_share};
use crate::common::{field_truck, field_truck_model};
use ocmc_core::operating_cycle::road::road_type::Section;
use ocmc_core::operating_cycle::road::surface::Ground;
use ocmc_core::random::{Draws, Stream};
use statrs::distribution::{ContinuousCDF, Exp, LogNormal};
use std::f64::consts::{FRAC_PI_2, TAU};

#[test]
fn sojourns_of_signs_are_exponential_with_the_printed_means() {
    // mean lengths between changes of the sign, as the solver of the chain has to find them
    let printed: [(&str, &[f64]); 3] = [
        ("urban", &[658.0, 456.0, 711.0, 464.0, 735.0]),
        ("rural", &[3737.0, 2085.0, 2516.0, 2431.0, 2422.0]),
        ("motorway", &[14922.0, 6770.0, 8584.0, 6909.0]),
    ];
    let types = field_truck_model().road.types;
    for (name, means) in printed {
        let model = &types[name].speed_signs;
        for seed in SEEDS {
            let end_m = 20_000.0 * model.mean_length_m;
            let section = Section { start_m: 0.0, end_m, road_type: 0 };
            let mut signs = Vec::new();
            let mut draws = Draws::new(seed, 0, Stream::SpeedSign);
            model.chain().sample(&section, &mut draws, &mut signs);
            for (face, mean) in model.speed_kmh.iter().zip(means) {
                // the last sojourn is cut off by the end of the road
                let sojourns: Vec<f64> = signs
                    .windows(2)
                    .filter(|pair| (3.6 * pair[0].speed_mps - face).abs() < 1e-9)
                    .map(|pair| pair[1].start_m - pair[0].start_m)
                    .collect();
                let n = sojourns.len() as f64;
                assert_near(name, sojourns.iter().sum::<f64>() / n, *mean, mean / n.sqrt());
                let law = Exp::new(1.0 / mean).unwrap();
                assert_follows(name, sojourns, |x| law.cdf(x));
            }
        }
    }
}

#[test]
fn curves_of_each_sign_follow_their_law() {
    let types = field_truck_model().road.types;
    // curves by the sign: per km and median radius at 70 km/h, smallest radius, and the motorway's
    for (name, per_km, median_m, turn_m, log_sd, length_m, length_sd) in [
        ("urban", 1.5, 120.0, 15.0, 0.9, 40.0, 0.6),
        ("rural", 1.0, 250.0, 15.0, 0.9, 120.0, 0.6),
        ("motorway", 0.3, 900.0, 300.0, 0.6, 350.0, 0.5),
    ] {
        let mut model = types[name].curves.clone();
        // lengths as they are drawn; the bound on the heading has a test of its own
        model.maximum_heading_rad = f64::INFINITY;
        for face in &types[name].speed_signs.speed_kmh {
            let (rate, scale) = if name == "motorway" {
                (per_km, 1.0)
            } else {
                (f64::min(per_km * (70.0 / face).powf(2.5), 4.0), face / 70.0)
            };
            let radius = LogNormal::new((median_m * scale).ln(), log_sd).unwrap();
            let length = LogNormal::new(f64::ln(length_m), length_sd).unwrap();
            for seed in SEEDS {
                let mut curves = Vec::new();
                let mut draws = Draws::new(seed, *face as u64, Stream::Curve);
                let end_m = 5.0e6 / rate;
                model.sample(0.0, end_m, face / 3.6, &mut draws, &mut curves);
                assert_count(name, curves.len(), 5000.0);
                let radii = curves.iter().map(|c| c.radius_m - turn_m).collect();
                assert_follows(&format!("{name} radius"), radii, |x| radius.cdf(x));
                let lengths = curves.iter().map(|c| c.end_m - c.start_m).collect();
                assert_follows(&format!("{name} length"), lengths, |x| length.cdf(x));
                let left = curves.iter().filter(|c| c.left).count();
                assert_share(name, left, curves.len(), 0.5);
            }
        }
    }
}

#[test]
fn junction_turns_follow_their_law() {
    let model = field_truck_model().road.junction_turn;
    let radius = LogNormal::new(12f64.ln(), 0.6).unwrap();
    for seed in SEEDS {
        let mut draws = Draws::new(seed, 0, Stream::JunctionTurn);
        let turns: Vec<_> = (0..20_000).map(|_| model.sample(500.0, &mut draws)).collect();
        let radii = turns.iter().map(|t| t.radius_m - 12.0).collect();
        assert_follows("radius", radii, |x| radius.cdf(x));
        let angles = turns.iter().map(|t| (t.end_m - t.start_m) / t.radius_m).collect();
        assert_follows("angle", angles, |x| (x / FRAC_PI_2 - 0.5) / 0.5);
        let left = turns.iter().filter(|t| t.left).count();
        assert_share("left", left, turns.len(), 0.5);
    }
}

#[test]
fn grounds_and_headings() {
    let study = field_truck(|_| ());
    for seed in SEEDS {
        let (mut concrete, mut sections, mut headings) = (0, 0, Vec::new());
        for cycle_id in 0..500 {
            let road = study.sample(seed, cycle_id).cycle.road;
            concrete += road.grounds.iter().filter(|g| **g == Ground::Concrete).count();
            sections += road.grounds.len();
            headings.push(road.heading_rad);
            assert!(road.climb_reached && road.grounds.len() == road.sections.len());
        }
        assert_share("concrete", concrete, sections, 0.05);
        assert_follows("heading", headings, |x| x / TAU);
    }
}

#[test]
fn junction_turns_and_curves_do_not_overlap_on_whole_roads() {
    let study = field_truck(|_| ());
    for cycle_id in 0..200 {
        let road = study.sample(1, cycle_id).cycle.road;
        assert!(road.curves.windows(2).all(|pair| pair[0].end_m <= pair[1].start_m));
        assert!(road.curves.iter().all(|c| c.start_m < c.end_m && c.end_m <= road.length_m));
        let events = &road.events;
        assert!(events.windows(2).all(|pair| pair[1].position_m - pair[0].position_m >= 30.0));
    }
}
