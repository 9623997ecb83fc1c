//! Account of a given operating cycle that was read, in words, and the parts of it that are hardly
//! a road.

use crate::intake::{FileAccount, scatter, unlike_a_road};
use crate::number_text::{count_of, rounded};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::road::route_noise::LEAST_NOISE_M;
use serde::Serialize;
use std::path::Path;

/// Radii that part the curves that are told, in m.
const RADII_M: [f64; 3] = [50.0, 150.0, 500.0];
/// Account of a cycle that was read.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Account {
    /// The file, or what else it was read from.
    pub file: String,
    /// Account of the file.
    pub read: FileAccount,
    /// Length, in m.
    pub length_m: f64,
    /// Sum of the climbs, in m.
    pub climb_m: f64,
    /// Steepest slope, up or down.
    pub steepest_grade: f64,
    /// Number of curves.
    pub n_curves: usize,
    /// Number of places at which a truck stands.
    pub n_stops: usize,
    /// Lowest and highest limit, in m/s; none where they are drawn.
    pub limits_mps: Option<[f64; 2]>,
    /// How much its positions scatter, in m; below 0.5 m they are taken as they are.
    pub position_noise_m: f64,
    /// How much its altitudes scatter, in m, likewise.
    pub altitude_noise_m: f64,
    /// All of that in words.
    pub told: Vec<String>,
    /// Parts that are hardly a road.
    pub warnings: Vec<String>,
}

/// The account of a cycle that was read from a file.
pub fn account(path: &Path, cycle: &GivenCycle, read: FileAccount) -> Account {
    let km = cycle.length_m / 1000.0;
    let file = path.display();
    let slopes = unlike_a_road::slopes(cycle);
    let climb_m =
        slopes.iter().fold(0.0, |sum: f64, (way_m, slope)| sum + (way_m * slope).max(0.0));
    let steepest = slopes.iter().fold(0.0, |most: f64, (_, slope)| most.max(slope.abs()));
    let stops = cycle.events.iter().filter(|event| event.kind.standstill_s().is_some()).count();
    let limits = cycle.limits.iter().map(|limit| limit.1);
    let (low_mps, high_mps) = limits
        .fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), limit| {
            (low.min(limit), high.max(limit))
        });
    let [low, high] = [low_mps, high_mps].map(|limit| 3.6 * limit);
    let percent = |share: f64| rounded(100.0 * share);
    let limits = if cycle.limits.is_empty() {
        "no limits".to_owned()
    } else if high > low {
        format!("limits of {} to {} km/h", rounded(low), rounded(high))
    } else {
        format!("a limit of {} km/h", rounded(low))
    };
    let mut told = vec![format!(
        "`{file}`: {} km, {} m of climb, at most {} % steep, {}, {}, {limits}",
        rounded(km),
        rounded(climb_m),
        percent(steepest),
        curves(cycle),
        count_of(stops as u64, "stop"),
    )];
    told.extend(read.told());
    let warnings = read.warnings();
    // of a route it is said where it is read; of the road of a log here
    let noise = [("positions", cycle.noise.positions_m), ("altitudes", cycle.noise.altitudes_m)];
    for (what, noise_m) in noise {
        let is_said = read.findings.iter().any(|known| known.text.contains(what));
        if noise_m >= LEAST_NOISE_M && !is_said {
            told.push(format!("`{file}`: {}", scatter::smoothed(what, noise_m)));
        }
    }
    Account {
        file: file.to_string(),
        read,
        length_m: cycle.length_m,
        climb_m,
        steepest_grade: steepest,
        n_curves: cycle.curves.len(),
        n_stops: stops,
        limits_mps: (high_mps > 0.0).then_some([low_mps, high_mps]),
        position_noise_m: cycle.noise.positions_m,
        altitude_noise_m: cycle.noise.altitudes_m,
        told,
        warnings,
    }
}

/// Its curves, by their radii.
fn curves(cycle: &GivenCycle) -> String {
    let count = |from_m: f64, to_m: f64| {
        let within = |radius_m: f64| (from_m..to_m).contains(&radius_m);
        cycle.curves.iter().filter(|curve| within(curve.radius_m)).count()
    };
    let [sharp, middle, wide] = RADII_M;
    let ranges = [
        (count(0.0, sharp), format!("below {sharp} m")),
        (count(sharp, middle), format!("of {sharp} to {middle} m")),
        (count(middle, wide), format!("of {middle} to {wide} m")),
        (count(wide, f64::INFINITY), format!("above {wide} m")),
    ];
    let radii = ranges.iter().filter(|(count, _)| *count > 0);
    let radii: Vec<String> = radii.map(|(count, range)| format!("{count} {range}")).collect();
    let all = count_of(cycle.curves.len() as u64, "curve");
    if radii.is_empty() { all } else { format!("{all} (radii: {})", radii.join(", ")) }
}
