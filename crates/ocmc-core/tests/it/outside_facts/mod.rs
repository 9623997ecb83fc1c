//! The default road beside facts from outside: curves of an OpenStreetMap extract, and radii of the
//! field study.
//!
//! Prints the table of `docs/src/outside-facts.md`: `cargo test -p ocmc-core --test it
//! outside_facts -- --nocapture`.

mod curve_detector;
mod curve_table;
mod default_road;
mod open_street_map;

use crate::common::field_truck;
use curve_detector::{STEP_M, curvature, detect};
use curve_table::{CurveTable, head};
use ocmc_core::study::Study;

/// Half width of the moving average of positions, in steps: 45 m in all.
const HALF_WINDOW: usize = 4;
/// Roads of the default study.
const CYCLES: u64 = 500;

/// Curves of the main roads of Lower Saxony.
#[derive(Default)]
struct LowerSaxony {
    /// Radii of the middle third.
    all: CurveTable,
    /// Radii of the whole curve.
    whole: CurveTable,
    motorways: CurveTable,
    others: CurveTable,
}

/// The curves of the extract; none where the data are absent.
fn lower_saxony(half: usize) -> Option<LowerSaxony> {
    let file = open_street_map::extract()?;
    let mut tables = LowerSaxony::default();
    for line in open_street_map::join(&open_street_map::read(file)) {
        let road = line.profile();
        let kind = if line.is_motorway() { &mut tables.motorways } else { &mut tables.others };
        for limit_kmh in &road.limit_kmh {
            for table in [&mut tables.all, &mut tables.whole, &mut *kind] {
                table.add_length(*limit_kmh, STEP_M);
            }
        }
        for curve in detect(&curvature(&road.x, &road.y, half)) {
            let limit_kmh = road.limit_kmh[curve.middle()];
            tables.all.add_curve(limit_kmh, curve.radius_m);
            tables.whole.add_curve(limit_kmh, curve.whole_radius_m);
            kind.add_curve(limit_kmh, curve.radius_m);
        }
    }
    Some(tables)
}

/// The default road: drawn without and with turns at junctions, then both as detected.
fn default_roads(study: &Study, cycles: u64) -> [CurveTable; 4] {
    let mut tables: [CurveTable; 4] = Default::default();
    for cycle_id in 0..cycles {
        let road = study.sample(1, cycle_id).cycle.road;
        for table in &mut tables {
            default_road::add_length(&road, table);
        }
        for (k, turns) in [false, true].into_iter().enumerate() {
            let curves = default_road::curves(&road, turns);
            default_road::add_drawn(&road, &curves, &mut tables[k]);
            default_road::add_detected(&road, &curves, HALF_WINDOW, &mut tables[k + 2]);
        }
    }
    tables
}

#[test]
fn default_road_beside_the_facts() {
    let [drawn, drawn_turns, found, found_turns] = default_roads(&field_truck(|_| ()), CYCLES);
    println!("{}", head());
    println!("{}", drawn.row("default road as drawn, without junction turns"));
    println!("{}", drawn_turns.row("the same with junction turns"));
    println!("{}", found.row("default road as detected, without junction turns"));
    println!("{}", found_turns.row("the same with junction turns"));

    // field trucks (from the tables of the paper): 116 m and 0.97; 113 m and 0.87 were expected
    let (mean_m, sd) = drawn_turns.field_moments();
    assert!((95.0..135.0).contains(&mean_m), "{mean_m}");
    assert!((0.80..1.05).contains(&sd), "{sd}");

    // curves follow the sign
    let independent = field_truck(|model| {
        for road_type in model.road.types.values_mut() {
            road_type.curves.reference_sign_mps = None;
        }
    });
    let [_, _, _, independent] = default_roads(&independent, CYCLES / 5);
    println!("{}", independent.row("the last, if curves did not follow the sign"));
    let contrast = |table: &CurveTable| table.per_km_of(0) / table.per_km_of(1);
    let (with, without) = (contrast(&found_turns), contrast(&independent));
    assert!(with > 3.0 && with > 1.3 * without, "{with} {without}");

    let Some(map) = lower_saxony(HALF_WINDOW) else {
        return;
    };
    println!("{}", map.all.row("Lower Saxony, radius of the middle third"));
    println!("{}", map.motorways.row("of it motorways"));
    println!("{}", map.others.row("of it other roads"));
    println!("{}", map.whole.row("Lower Saxony, radius of the whole curve"));
    for half in [2, 3, 5] {
        if let Some(map) = lower_saxony(half) {
            println!("{}", map.all.row(&format!("the first, averaged over {} m", 10 * half + 5)));
        }
    }
    for (what, table) in [("drawn", &drawn_turns), ("detected", &found_turns)] {
        println!("on the lengths of Lower Saxony, {what}: {:.2} per km", table.per_km_on(&map.all));
    }
    // curves by the sign: 1.44 per km, 173 m, and 2.75, 1.0, 0.5 per km by limit
    assert!((1.2..1.7).contains(&map.all.per_km()));
    assert!((120.0..200.0).contains(&map.all.geometric_mean_m()));
    for (class, fact) in [2.75, 1.0, 0.5].into_iter().enumerate() {
        let rate = map.all.per_km_of(class);
        assert!((0.75..1.33).contains(&(rate / fact)), "{class}: {rate}, the extract {fact}");
    }
    // where trucks slow down for curves the default road has about as many
    for class in 0..2 {
        let (model, rate) = (found_turns.per_km_of(class), map.all.per_km_of(class));
        assert!((0.5..2.0).contains(&(model / rate)), "{class}: {model}, map {rate}");
    }
}
