//! The rows of a road are written from what holds over many segments; here each one from its
//! segment alone.

use crate::common::study;
use ocmc_core::kernel::step::road_row::{RoadRow, RoadRows};
use ocmc_core::lanes::UNBOUNDED;
use ocmc_core::operating_cycle::road::surface::iri_mm_per_m;
use ocmc_core::study::{Scenario, Study};
use ocmc_core::tactical::{SpeedProfile, plan};
use ocmc_core::vehicle::resistance::{
    GRAVITY_MPS2, braking_friction, rolling_roughness_factor, rolling_temperature_factor,
    rolling_wet_factor,
};

/// Dwell time at the end of a segment; none where there is no stop.
fn dwell_s(scenario: &Scenario, profile: &SpeedProfile, i: usize) -> Option<f64> {
    let Some(next) = profile.segments.get(i + 1) else { return Some(0.0) };
    scenario.cycle.road.events[next.event()?].kind.standstill_s()
}

/// From the end of a segment to the stop line, where it is near.
fn to_stop_m(near_m: f64, scenario: &Scenario, profile: &SpeedProfile, i: usize) -> f64 {
    let mut way_m = 0.0;
    for k in i..profile.segments.len() {
        if dwell_s(scenario, profile, k).is_some() {
            return way_m;
        }
        way_m += profile.segments[k + 1].length_m;
        if way_m > near_m {
            break;
        }
    }
    UNBOUNDED
}

fn assert_rows(study: &Study, scenario: &Scenario) {
    let (mut profile, mut rows) = (SpeedProfile::default(), RoadRows::default());
    plan(study, scenario, &mut profile);
    rows.fill(study, scenario, &profile);
    let (cycle, road) = (&scenario.cycle, &scenario.cycle.road);
    let near_m = study.model().simulation.creep_distance_m;
    let coefficient = study.vehicle().model.rolling_temperature_coefficient_per_k;
    let (mut heading, mut climb_m, mut temperature, mut wind) = (road.heading_rad, 0.0, 0.0, 0.0);
    let mut altitude_m = 0.0;
    assert_eq!(rows.rows.len(), profile.segments.len());
    for (i, (segment, row)) in profile.segments.iter().zip(&rows.rows).enumerate() {
        let weather = &cycle.weather[segment.weather as usize].weather;
        let sine = road.slopes[segment.slope as usize];
        let level = GRAVITY_MPS2 * (1.0 - sine * sine).sqrt();
        let limit_mps = profile.branches[i].limit.sqrt();
        let iri = iri_mm_per_m(road.roughness_m3[segment.roughness as usize]);
        let rolling = level
            * scenario.vehicle.rolling_coefficient
            * rolling_temperature_factor(weather.temperature_k, coefficient)
            * rolling_wet_factor(weather.precipitation_mps, weather.snow)
            * road.grounds[segment.section as usize].rolling_factor()
            * rolling_roughness_factor(iri, limit_mps);
        let turn = segment.curve().map_or(0.0, |k| road.curves[k].curvature_per_m());
        // in bends the tyres roll at a slip angle, within what they hold
        let friction = braking_friction(weather.precipitation_mps, weather.snow);
        let lateral = (limit_mps * limit_mps * turn.abs()).min(GRAVITY_MPS2 * friction);
        let stiffness = study.vehicle().model.cornering_stiffness_per_rad;
        let cornering = stiffness.map_or(0.0, |c| lateral * lateral / (c * GRAVITY_MPS2));
        let rolling = rolling + level / GRAVITY_MPS2 * cornering;
        let (head, cross) = weather.wind_components_mps(heading - 0.5 * turn * segment.length_m);
        heading -= turn * segment.length_m;
        let road_type = road.sections[segment.section as usize].road_type;
        let exposure = study.operating_cycle().road().types()[road_type].wind_exposure;
        let mut wanted = *row;
        match dwell_s(scenario, &profile, i) {
            Some(dwell_s) => wanted.set_stop(dwell_s),
            None => wanted.set_coasting(UNBOUNDED),
        }
        assert_eq!(*row, wanted, "{i}");
        let RoadRow(row) = row;
        for (column, wanted) in [
            (RoadRow::LENGTH, segment.length_m),
            (RoadRow::GRADE, GRAVITY_MPS2 * sine),
            (RoadRow::ROLLING, rolling),
            (RoadRow::HEAD_WIND, exposure * head),
            (RoadRow::CROSS_WIND, exposure * cross.abs()),
            (RoadRow::GRIP, level * braking_friction(weather.precipitation_mps, weather.snow)),
            (RoadRow::TO_STOP, to_stop_m(near_m, scenario, &profile, i)),
        ] {
            let error = (row[column] - wanted).abs();
            assert!(
                error < 1e-9 * wanted.abs().max(1.0),
                "{i}, {column}: {} {wanted}",
                row[column]
            );
        }
        // 50 m of climb are 0.6 % of the density
        let air = row[RoadRow::HALF_DENSITY] / (0.5 * weather.air_density_kgpm3(altitude_m));
        assert!((air - 1.0).abs() < 0.008, "{i}: {air} at {altitude_m} m");
        altitude_m += sine * segment.length_m;
        climb_m += sine.max(0.0) * segment.length_m;
        temperature += weather.temperature_k * segment.length_m / road.length_m;
        wind += exposure * head * segment.length_m / road.length_m;
    }
    for (found, wanted) in
        [(rows.climb_m, climb_m), (rows.air_temperature_k, temperature), (rows.head_wind_mps, wind)]
    {
        assert!((found - wanted).abs() < 1e-9 * wanted.abs().max(1.0), "{found} {wanted}");
    }
}

#[test]
fn each_row_says_what_its_segment_is() {
    for (name, sets) in [
        ("field-truck", &[] as &[&str]),
        ("urban-delivery", &[]),
        // a pass road: the air gets thinner
        ("field-truck", &["mission.length_m=40000", "road.net_climb_m=1000"]),
        // stops close to one another, all of them near the rows before
        ("urban-delivery", &["road.event_spacing_m=5", "simulation.creep_distance_m=10"]),
    ] {
        // crests, to which a truck coasts, are those of look_ahead
        let sets = [sets, &["driver.look_ahead.predictive_cruise=false"]].concat();
        let study = study(name, &sets);
        for cycle_id in 0..10 {
            assert_rows(&study, &study.sample(1, cycle_id));
        }
    }
}
