//! The backward and forward sweeps equal brute force over all constraints.

use crate::common::study;
use ocmc_core::operating_cycle::road::point_event::EventKind;
use ocmc_core::study::{Scenario, Study};
use ocmc_core::tactical::{SpeedProfile, plan};

/// Speed squared that an event allows, written out again from its definition.
fn event_limit(kind: &EventKind, scenario: &Scenario) -> f64 {
    match kind {
        EventKind::GiveWayPass { speed_mps } => speed_mps * speed_mps,
        EventKind::GreenLight => f64::INFINITY,
        EventKind::SpeedBump { length_m, height_m } => {
            scenario.driver.speed_limit.bump_speed_mps(*length_m, *height_m).powi(2)
        }
        _ => 0.0,
    }
}

/// The last of some stretches that begins before a place.
fn at<T>(stretches: &[T], begin: impl Fn(&T) -> f64, x: f64) -> &T {
    stretches.iter().rev().find(|s| begin(s) <= x).expect("the first begins with the road")
}

/// The lower of sign and the road type's truck limit at a place, and the sign, in m/s.
fn legal_and_sign(x: f64, study: &Study, scenario: &Scenario) -> (f64, f64) {
    let road = &scenario.cycle.road;
    let sign = at(&road.signs, |sign| sign.start_m, x).speed_mps;
    let road_type = at(&road.sections, |section| section.start_m, x).road_type;
    (study.operating_cycle().road().legal_mps(road_type).min(sign), sign)
}

/// Speed squared that sign, traffic and curve allow at a place, written out again from the models:
/// what holds is searched by position, traffic by the sign, and the driver by the lower of sign and
/// truck limit (sign speed).
fn static_limit(x: f64, study: &Study, scenario: &Scenario) -> f64 {
    let (road, driver, models) = (&scenario.cycle.road, &scenario.driver, study.model());
    let (legal, sign) = legal_and_sign(x, study, scenario);
    let wanted = driver.speed_limit.compliance * legal;
    let mut lowest = wanted.min(driver.speed_limit.maximum_speed_mps);

    let traffic = &models.traffic;
    let here = at(&scenario.cycle.traffic, |stretch| stretch.start_m, x);
    let ratio = here.density_per_m / (traffic.critical_share * traffic.jam_density_per_m);
    lowest = lowest.min((sign * (-0.5 * ratio * ratio).exp()).max(traffic.minimum_speed_mps));

    let curve = road.curves.iter().zip(&scenario.curve_residuals);
    if let Some((curve, z)) = curve.clone().find(|(c, _)| c.start_m <= x && x < c.end_m) {
        let (d, fit) = (&driver.curve_speed, &models.driver.curve_speed);
        let side = if curve.left { d.direction_effect } else { -d.direction_effect };
        let typical = d.reference_speed_mps
            * (curve.radius_m / fit.reference_radius_m).powf(d.exponent)
            * (side + d.residual_sd * z).exp();
        let guard = (fit.guard_lateral_mps2 * curve.radius_m).sqrt();
        let is_guarded = curve.radius_m < fit.guard_radius_m;
        if curve.radius_m <= fit.maximum_radius_m {
            lowest = lowest.min(if is_guarded { typical.min(guard) } else { typical });
        }
    }
    lowest * lowest
}

#[test]
fn static_limits_are_those_of_sign_traffic_and_curve() {
    let mut profile = SpeedProfile::default();
    let (mut checked, mut by_curve) = (0, 0);
    for name in ["field-truck", "simulator-truck"] {
        let study = study(name, &["mission.length_m=20000"]);
        for cycle_id in 0..10 {
            let scenario = study.sample(1, cycle_id);
            plan(&study, &scenario, &mut profile);
            for (segment, branch) in profile.segments.iter().zip(&profile.branches) {
                let middle = segment.start_m + 0.5 * segment.length_m;
                let want = static_limit(middle, &study, &scenario);
                let got = branch.limit;
                assert!(
                    (got - want).abs() < 1e-9 * want,
                    "{name} {cycle_id} {middle} {got} {want}"
                );
                by_curve += usize::from(segment.curve().is_some());
                checked += 1;
            }
        }
    }
    assert!(checked > 10_000 && by_curve > 500, "{checked} {by_curve}");
}

#[test]
fn the_free_flow_clock_counts_signs_and_standstills() {
    // one metre at a time at what the sign and the truck's limit allow there, and all waits
    for name in ["field-truck", "urban-delivery"] {
        let study = study(name, &["mission.length_m=10000"]);
        let mut waits = 0;
        for cycle_id in 0..10 {
            let scenario = study.sample(1, cycle_id);
            let (cycle, road) = (&scenario.cycle, &scenario.cycle.road);
            let waited: f64 = road.events.iter().filter_map(|e| e.kind.standstill_s()).sum();
            let speed_at = |x: f64| legal_and_sign(x, &study, &scenario).0;
            let driven = (0..10_000).map(|k| 1.0 / speed_at(f64::from(k) + 0.5)).sum::<f64>();
            let want = driven + waited;
            // a metre with a sign in it is counted wrong by a tenth of a second at most
            let allowed = 0.1 * (road.signs.len() + road.sections.len()) as f64;
            let got = cycle.free_flow_s;
            assert!((got - want).abs() < allowed, "{name} {cycle_id}: {got} {want}");
            waits += usize::from(waited > allowed);
        }
        assert!(waits > 1, "standstills count in {waits} cycles only");
    }
}

/// All places where something holds: (from, to, v²).
fn constraints(study: &Study, scenario: &Scenario, profile: &SpeedProfile) -> Vec<(f64, f64, f64)> {
    let mut all: Vec<(f64, f64, f64)> = profile
        .segments
        .iter()
        .map(|s| {
            let middle = s.start_m + 0.5 * s.length_m;
            (s.start_m, s.start_m + s.length_m, static_limit(middle, study, scenario))
        })
        .collect();
    for event in &scenario.cycle.road.events {
        let limit = event_limit(&event.kind, scenario);
        all.push((event.position_m, event.position_m, limit));
    }
    let end = scenario.cycle.road.length_m;
    all.push((end, end, 0.0));
    all
}

/// Lowest of what is demanded here, of what lies ahead under braking, and of what lies behind under
/// acceleration.
fn brute_force(x: f64, all: &[(f64, f64, f64)], braking: &[f64], profile: &SpeedProfile) -> f64 {
    let mut lowest = f64::INFINITY;
    for ((from, to, limit), braked) in all.iter().zip(braking) {
        if x < *from {
            lowest = lowest.min(limit + profile.twice_deceleration * (from - x));
        } else if x <= *to && to > from {
            lowest = lowest.min(*limit);
        } else {
            // behind: the truck leaves it at the speed that braking for everything later allowed
            // there
            let left_at = braked.min(*limit);
            let risen = profile.acceleration.squared_after(left_at, x - to);
            lowest = lowest.min(risen.max(profile.launch));
        }
    }
    // the start is a standing start
    let risen = profile.acceleration.squared_after(0.0, x);
    lowest.min(risen.max(profile.launch))
}

/// Lowest v² at each constraint's end under braking for everything that comes after.
fn braking_at_ends(all: &[(f64, f64, f64)], profile: &SpeedProfile) -> Vec<f64> {
    all.iter()
        .map(|(_, end, _)| {
            all.iter()
                .filter(|(from, _, _)| from >= end)
                .map(|(from, _, limit)| limit + profile.twice_deceleration * (from - end))
                .fold(f64::INFINITY, f64::min)
        })
        .collect()
}

#[test]
fn sweeps_equal_brute_force() {
    // crests, which limit too, are those of look_ahead
    let sets = ["mission.length_m=6000", "driver.look_ahead.predictive_cruise=false"];
    let study: Study = study("field-truck", &sets);
    let mut profile = SpeedProfile::default();
    let mut checked = 0;
    for cycle_id in 0..30 {
        let scenario = study.sample(1, cycle_id);
        plan(&study, &scenario, &mut profile);
        let all = constraints(&study, &scenario, &profile);
        let braking = braking_at_ends(&all, &profile);
        for (i, segment) in profile.segments.iter().enumerate() {
            for share in [0.07, 0.5, 0.93] {
                let behind = share * segment.length_m;
                let got = profile.speed_mps(i, behind).powi(2);
                let want = brute_force(segment.start_m + behind, &all, &braking, &profile);
                assert!(
                    (got - want).abs() < 1e-6 * (1.0 + want),
                    "cycle {cycle_id}, {} m: {got} {want}",
                    segment.start_m + behind
                );
                checked += 1;
            }
        }
    }
    assert!(checked > 10_000);
}

#[test]
fn looking_only_at_the_next_change_would_be_wrong() {
    // a low limit shortly after a mild one needs braking before the mild one
    let study = study("field-truck", &["mission.length_m=6000"]);
    let mut profile = SpeedProfile::default();
    let mut wrong = 0;
    for cycle_id in 0..30 {
        let scenario = study.sample(1, cycle_id);
        plan(&study, &scenario, &mut profile);
        for i in 0..profile.segments.len() - 1 {
            let next_only = profile.branches[i + 1].limit;
            wrong += usize::from(profile.branches[i].backward_end < next_only - 1e-9);
        }
    }
    assert!(wrong > 100);
}

#[test]
fn the_desired_speed_is_continuous_but_for_events_and_never_above_the_limiter() {
    let study = study("field-truck", &[]);
    let mut profile = SpeedProfile::default();
    let scenario = study.sample(1, 4);
    plan(&study, &scenario, &mut profile);
    for i in 0..profile.segments.len() - 1 {
        let end = profile.speed_mps(i, profile.segments[i].length_m);
        let start = profile.speed_mps(i + 1, 0.0);
        let floor = profile.launch.sqrt();
        assert!((end - start).abs() < 1e-6 || end.min(start) <= floor + 1e-9, "{end} {start}");
        assert!(end <= 89.0 / 3.6 + 1e-9);
    }
}

#[test]
fn the_papers_rise_jumps_at_a_higher_limit() {
    let ramp = study("field-truck", &["mission.length_m=20000"]);
    let paper = study("field-truck", &["mission.length_m=20000", "driver.speed_change.rise=paper"]);
    let (mut a, mut b) = (SpeedProfile::default(), SpeedProfile::default());
    plan(&ramp, &ramp.sample(1, 1), &mut a);
    plan(&paper, &paper.sample(1, 1), &mut b);
    let mean = |p: &SpeedProfile| {
        let speeds = (0..p.segments.len()).map(|i| p.speed_mps(i, 0.5 * p.segments[i].length_m));
        speeds.sum::<f64>() / p.segments.len() as f64
    };
    assert!(mean(&b) > mean(&a));
}

#[test]
fn a_driver_who_reacts_late_drives_the_road_whose_signs_stand_later() {
    let profile_of = |study: &Study, scenario: &Scenario| {
        let mut profile = SpeedProfile::default();
        plan(study, scenario, &mut profile);
        profile
    };
    let [plain, late, early] = ["", "35.0", "-35.0"].map(|offset_m| {
        let set = format!("driver.speed_limit.sign_offset_m={offset_m}");
        let more: &[&str] = if offset_m.is_empty() { &[] } else { &[&set] };
        study("field-truck", &[&["mission.length_m=20000"], more].concat())
    });
    let mut differ = 0;
    for id in 0..10 {
        for (study, offset_m) in [(&late, 35.0), (&early, -35.0)] {
            let shifted = study.sample(1, id);
            let mut moved = plain.sample(1, id);
            let unmoved = profile_of(&plain, &moved);
            moved.cycle.road.signs.iter_mut().skip(1).for_each(|sign| sign.start_m += offset_m);
            let (found, wanted) = (profile_of(study, &shifted), profile_of(&plain, &moved));
            assert_eq!(found.segments, wanted.segments, "cycle {id}");
            assert_eq!(found.branches, wanted.branches, "cycle {id}");
            differ += usize::from(found.branches != unmoved.branches);
        }
    }
    assert!(differ >= 15, "most roads have signs behind their start: {differ}");
}
