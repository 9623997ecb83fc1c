//! The roads of `simulator-study`: the paper's Table I, one route a driver, in balanced order.
//!
//! The files in `configs/` are what this makes; `OCMC_WRITE_DOCS=1` writes them anew.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const DRIVERS: usize = 8;
/// Way behind the start, of an event, between two, of a curve, and behind the last event, in m.
const RUN_UP_M: usize = 2500;
const EVENT_M: usize = 375;
const GAP_M: usize = 350;
const CURVE_M: usize = 250;
const RUN_OUT_M: usize = 1000;

/// One of the 16 events of Table I.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Event {
    /// Slope, in %.
    Slope(f64),
    /// New limit, in km/h.
    Limit(f64),
    /// Radius, in m, negative to the right.
    Curve(f64),
}

/// Two events that belong together: both ways, or away from 70 km/h and back.
const BLOCKS: [[Event; 2]; DRIVERS] = {
    use Event::{Curve, Limit, Slope};
    [
        [Slope(5.5), Slope(-5.5)],
        [Curve(125.0), Curve(-125.0)],
        [Limit(40.0), Limit(70.0)],
        [Slope(3.5), Slope(-3.5)],
        [Curve(175.0), Curve(-175.0)],
        [Limit(60.0), Limit(70.0)],
        [Slope(1.5), Slope(-1.5)],
        [Curve(250.0), Curve(-250.0)],
    ]
};

/// The order of the blocks: a Williams square, row d is the first row with d added (modulo 8).
/// Source: Williams, E. J. (1949), Experimental designs balanced for the estimation of residual
/// effects of treatments, Australian Journal of Scientific Research A 2, 149-168.
const FIRST_ROW: [usize; DRIVERS] = [0, 1, 7, 2, 6, 3, 5, 4];

/// Masks of the drivers who meet the events of a block in the other order: those with an odd number
/// of bits in common with this. Each of the numbers 1 to 7 divides eight drivers into halves.
const TURNED: [usize; DRIVERS] = [1, 2, 0, 3, 4, 0, 5, 6];

fn blocks(driver: usize) -> [usize; DRIVERS] {
    FIRST_ROW.map(|block| (block + driver) % DRIVERS)
}

fn events(driver: usize) -> Vec<Event> {
    let of = |block: usize| {
        let [first, second] = BLOCKS[block];
        // a limit has to change before it changes back
        let turned = (driver & TURNED[block]).count_ones() % 2 == 1;
        if turned { [second, first] } else { [first, second] }
    };
    blocks(driver).into_iter().flat_map(of).collect()
}

/// The route of a driver as `ocmc cycle` would write it.
fn route(driver: usize) -> String {
    let (mut limits, mut curves) = (vec![(0, 70.0 / 3.6)], vec![(0, 0.0)]);
    let (mut altitudes, mut altitude_m) = (vec![(0, 0.0), (RUN_UP_M, 0.0)], 0.0);
    let mut at_m = RUN_UP_M;
    for event in events(driver) {
        match event {
            Event::Limit(limit_kmh) => limits.push((at_m, limit_kmh / 3.6)),
            Event::Curve(radius_m) => {
                curves.extend([(at_m, 1.0 / radius_m), (at_m + CURVE_M, 0.0)]);
            }
            Event::Slope(percent) => {
                altitudes.push((at_m, altitude_m));
                altitude_m += percent / 100.0 * EVENT_M as f64;
                altitudes.push((at_m + EVENT_M, altitude_m));
            }
        }
        at_m += EVENT_M + GAP_M;
    }
    altitudes.push((at_m - GAP_M + RUN_OUT_M, altitude_m));
    altitudes.dedup();
    let mut text = format!(
        "# Route {} of {DRIVERS} of the driving simulator: all events of the paper's Table I; see \
         simulator-study.toml\n\
         track,rule,position_m,value\nroad_type,constant,0,rural\n",
        driver + 1
    );
    for (track, rule, points) in [
        ("speed_limit_mps", "constant", limits),
        ("curvature_per_m", "constant", curves),
        ("altitude_m", "linear", altitudes),
    ] {
        for (at_m, value) in points {
            writeln!(text, "{track},{rule},{at_m},{value:.7}").unwrap();
        }
    }
    text + "roughness_m3,constant,0,7.603e-6\nground,constant,0,asphalt\n"
}

fn file(driver: usize) -> PathBuf {
    let name = format!("simulator-route-{}.csv", driver + 1);
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs").join(name)
}

#[test]
fn the_files_hold_the_routes() {
    for driver in 0..DRIVERS {
        if std::env::var_os("OCMC_WRITE_DOCS").is_some() {
            std::fs::write(file(driver), route(driver)).unwrap();
        }
        let written = std::fs::read_to_string(file(driver)).unwrap();
        assert_eq!(written, route(driver), "OCMC_WRITE_DOCS=1 writes route {} anew", driver + 1);
    }
}

#[test]
fn every_driver_meets_every_event_once_and_orders_are_balanced() {
    let rows: Vec<_> = (0..DRIVERS).map(blocks).collect();
    let mut behind = BTreeMap::new();
    for row in &rows {
        let mut sorted = *row;
        sorted.sort_unstable();
        assert_eq!(sorted, [0, 1, 2, 3, 4, 5, 6, 7]);
        for pair in row.windows(2) {
            *behind.entry((pair[0], pair[1])).or_insert(0) += 1;
        }
    }
    // each block once in each place, and once behind each other one
    for place in 0..DRIVERS {
        let mut column: Vec<usize> = rows.iter().map(|row| row[place]).collect();
        column.sort_unstable();
        assert_eq!(column, [0, 1, 2, 3, 4, 5, 6, 7]);
    }
    assert_eq!(behind.len(), 56);
    assert!(behind.values().all(|count| *count == 1));
    // half of the drivers climb first, and turn left first
    for (block, [first, _]) in BLOCKS.into_iter().enumerate() {
        let place = |driver: &usize| events(*driver).iter().position(|event| *event == first);
        let straight = (0..DRIVERS).filter(|driver| place(driver).unwrap() % 2 == 0).count();
        let wanted = if matches!(first, Event::Limit(_)) { 8 } else { 4 };
        assert_eq!(straight, wanted, "block {block}");
    }
}

#[test]
fn cycle_k_drives_route_k_in_every_repetition() {
    let study = ocmc_io::study::load::<&str>("simulator-study", &[]).unwrap().study;
    for cycle_id in 0..24 {
        let road = study.sample(5, cycle_id).cycle.road;
        let mut found: Vec<(f64, Event)> = Vec::new();
        let curve = |c: &ocmc_core::operating_cycle::road::curvature::Curve| {
            (c.start_m, Event::Curve(1.0 / c.curvature_per_m()))
        };
        found.extend(road.curves.iter().map(curve));
        let sign = |s: &ocmc_core::operating_cycle::road::speed_sign::SpeedSign| {
            (s.start_m, Event::Limit(3.6 * s.speed_mps))
        };
        found.extend(road.signs.iter().skip(1).map(sign));
        for (k, slope) in road.slopes.iter().enumerate() {
            if *slope != 0.0 && (k == 0 || road.slopes[k - 1] == 0.0) {
                found.push((k as f64 * road.slope_step_m, Event::Slope(100.0 * slope)));
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let wanted = events(cycle_id as usize % DRIVERS);
        assert_eq!(found.len(), 16);
        for (k, ((at_m, event), wanted)) in found.into_iter().zip(wanted).enumerate() {
            assert_eq!(at_m, (RUN_UP_M + k * (EVENT_M + GAP_M)) as f64);
            let near = |a: f64, b: f64| ((a - b) / b).abs() < 1e-4;
            let same = match (event, wanted) {
                (Event::Slope(a), Event::Slope(b))
                | (Event::Limit(a), Event::Limit(b))
                | (Event::Curve(a), Event::Curve(b)) => near(a, b),
                _ => false,
            };
            assert!(same, "{event:?} in place of {wanted:?}");
        }
    }
}
