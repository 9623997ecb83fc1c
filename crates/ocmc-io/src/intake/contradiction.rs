//! Two sources of one quantity are compared: speed and way, altitude and slope, course and yaw
//! rate, speed and limit.
//!
//! Each pair is compared over stretches that are long enough for the noise of sensors: ways over
//! 200 m, slopes over 1 km, turns over 8 s. What differs by more than a sensor explains is refused,
//! with both figures and the unit that would explain it; a smaller difference is warned of.

use super::Finding;
use crate::intake::table::Quantity;
use crate::number_text::rounded;
use ocmc_core::operating_cycle::road::route_geometry::Path2d;
use ocmc_core::operating_cycle::road::route_noise::noise_of_altitudes;
use std::f64::consts::{SQRT_2, TAU};

/// Columns in SI, by their quantities; NaN where a number is missing.
pub type Columns<'a> = &'a dyn Fn(Quantity) -> Option<&'a [f64]>;

/// Ratios that a unit explains, and what was probably meant.
const UNITS: [(f64, &str); 13] = [
    (3.6, "km/h taken for m/s"),
    (1.0 / 3.6, "m/s taken for km/h"),
    (2.2369, "mph taken for m/s"),
    (1.609_344, "km/h taken for mph, or miles for km"),
    (1.0 / 1.609_344, "mph taken for km/h, or km for miles"),
    (57.296, "degrees taken for rad"),
    (1.0 / 57.296, "rad taken for degrees"),
    (100.0, "per cent taken for a ratio"),
    (0.01, "a ratio taken for per cent"),
    (9.806_65, "m/s² taken for g"),
    (1.0 / 9.806_65, "g taken for m/s²"),
    (1000.0, "m taken for km"),
    (0.001, "km taken for m"),
];
/// How near a ratio is to that of a unit.
const NEAR_UNIT: f64 = 0.1;
/// Stretches over which ways and displacements are compared, in m, and their least number.
const STRETCH_M: f64 = 200.0;
const FEWEST_STRETCHES: usize = 5;
/// Rows farther apart tell no way, in s.
const LONGEST_STEP_S: f64 = 60.0;
/// Ways that differ by more are refused, and warned of.
const WAYS_REFUSED: f64 = 1.3;
const WAYS_WARNED: f64 = 1.12;
/// Stretches over which slopes are compared, in m.
const SLOPES_M: f64 = 1000.0;
/// Differences of slopes that are refused, and warned of: root of the mean square, and over that of
/// the steeper source.
const SLOPES_REFUSED: f64 = 0.01;
/// At least, and over what the scatter of altitudes makes of it.
const SLOPES_WARNED: f64 = 0.0025;
const SLOPES_WARNED_SD: f64 = 3.0;
const SLOPES_SHARE: f64 = 0.5;
/// Time over which turns are compared, in s; slower ones in m/s, and smaller ones in rad are not.
const TURNS_S: f64 = 8.0;
const TURNS_MPS: f64 = 3.0;
const TURNS_RAD: f64 = 0.1;
const FEWEST_TURNS: usize = 8;
/// Correlation from which on a slope of a line through turns is one.
const CORRELATED: f64 = 0.8;
/// Stretches over which the turns of a route are compared, in m.
const BENDS_M: f64 = 100.0;
/// Smaller lateral accelerations are not compared, in m/s², and the ratio that is refused.
const LATERAL_MPS2: f64 = 0.3;
const LATERAL_REFUSED: f64 = 2.0;
/// Ratio of turns that is refused, or its inverse.
const TURNS_REFUSED: f64 = 1.5;
/// Median speed over the limit that is refused, and that is warned of, above and below (judgement:
/// trucks drive at 0.8 to 1.05 of it, in dense traffic at half of it).
const FAST_REFUSED: f64 = 1.5;
const FAST_WARNED: f64 = 1.25;
const SLOW_WARNED: f64 = 0.35;
/// Slower rows are not compared with limits, in m/s, and fewer rows tell nothing.
const DRIVING_MPS: f64 = 3.0;
const FEWEST_ROWS: usize = 60;

/// Contradictions in a drive over time.
pub fn of_drive(column: Columns) -> Vec<Finding> {
    let Some((time_s, speed_mps)) = column(Quantity::Time).zip(column(Quantity::Speed)) else {
        return Vec::new();
    };
    let way_m = integral(time_s, speed_mps);
    let mut findings = Vec::new();
    if let Some(position_m) = column(Quantity::Position) {
        let displacement = |from: usize, to: usize| position_m[to] - position_m[from];
        let ratio = ratio_of_ways(&way_m, displacement);
        findings.extend(ratio.and_then(|ratio| ways("speed", "position", ratio)));
    }
    let path = column(Quantity::Latitude).zip(column(Quantity::Longitude));
    if let Some((latitude, longitude)) = path {
        let displacement = |from: usize, to: usize| {
            let [lat, lon] = [latitude, longitude].map(|values| [values[from], values[to]]);
            let known = lat.iter().chain(&lon).all(|degrees| degrees.is_finite());
            if known { Path2d::new(&lat, &lon).position_m[1] } else { f64::NAN }
        };
        let ratio = ratio_of_ways(&way_m, displacement);
        findings.extend(ratio.and_then(|ratio| ways("speed", "latitude and longitude", ratio)));
    }
    if let Some((altitude_m, grade)) = column(Quantity::Altitude).zip(column(Quantity::Grade)) {
        // the slope of a row of a log is that since the row before
        let ahead: Vec<f64> = grade[1.min(grade.len())..].iter().copied().chain([0.0]).collect();
        findings.extend(slopes(&way_m, altitude_m, &ahead));
    }
    if let Some((course_rad, yaw_rate)) = column(Quantity::Course).zip(column(Quantity::YawRate)) {
        findings.extend(turning([time_s, speed_mps, course_rad, yaw_rate]));
    }
    if let Some((lateral_mps2, yaw_rate)) =
        column(Quantity::LateralAcceleration).zip(column(Quantity::YawRate))
    {
        findings.extend(lateral(speed_mps, lateral_mps2, yaw_rate));
    }
    if let Some(limit_mps) = column(Quantity::Limit) {
        findings.extend(limits(speed_mps, limit_mps));
    }
    findings
}

/// Contradictions in a route: positions in m, altitudes, and slopes and curvatures from their rows
/// on.
pub fn of_route(
    position_m: Option<&[f64]>,
    path: Option<&Path2d>,
    altitude_m: &[f64],
    grade: &[f64],
    curvature: &[f64],
) -> Vec<Finding> {
    let mut findings = Vec::new();
    if let Some((position_m, path)) = position_m.zip(path) {
        let (x_m, y_m) = path.points_m();
        let displacement =
            |from: usize, to: usize| chord_m([x_m[from], y_m[from]], [x_m[to], y_m[to]]);
        let ratio = ratio_of_ways(position_m, displacement);
        findings.extend(ratio.and_then(|ratio| ways("position", "latitude and longitude", ratio)));
    }
    if let Some(path) = path
        && !curvature.is_empty()
    {
        findings.extend(bends(path, curvature));
    }
    let way_m = position_m.or(path.map(|path| path.position_m.as_slice()));
    if let Some(way_m) = way_m
        && !altitude_m.is_empty()
        && !grade.is_empty()
    {
        findings.extend(slopes(way_m, altitude_m, grade));
    }
    findings
}

fn chord_m([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    ((bx - ax) * (bx - ax) + (by - ay) * (by - ay)).sqrt()
}

/// An angle, in rad, the short way around.
fn short_way(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// Way by the speed up to each row, in m; rows that are missing or far apart add nothing.
fn integral(time_s: &[f64], speed_mps: &[f64]) -> Vec<f64> {
    let mut sum_m = 0.0;
    let mut way_m = vec![0.0];
    for k in 1..time_s.len().min(speed_mps.len()) {
        let step_m = 0.5 * (speed_mps[k - 1] + speed_mps[k]) * (time_s[k] - time_s[k - 1]);
        let near = (0.0..LONGEST_STEP_S).contains(&(time_s[k] - time_s[k - 1]));
        sum_m += if near && step_m > 0.0 { step_m } else { 0.0 };
        way_m.push(sum_m);
    }
    way_m
}

/// Way over displacement. Bends only make the way longer: of stretches on which it is, the
/// straighter quarter counts, and otherwise the median.
fn ratio_of_ways(way_m: &[f64], displacement: impl Fn(usize, usize) -> f64) -> Option<f64> {
    let mut ratios = Vec::new();
    let mut first = 0;
    for k in 1..way_m.len() {
        let (way_m, displacement_m) = (way_m[k] - way_m[first], displacement(first, k));
        if !displacement_m.is_finite() {
            continue;
        }
        if way_m.max(displacement_m) >= STRETCH_M {
            if displacement_m > 0.0 && way_m > 0.0 {
                ratios.push(way_m / displacement_m);
            }
            first = k;
        }
    }
    ratios.sort_by(f64::total_cmp);
    let middle = ratios.get(ratios.len() / 2).copied();
    let straight = ratios.get(ratios.len() / 4).copied();
    let middle = middle.filter(|_| ratios.len() >= FEWEST_STRETCHES)?;
    if middle < 1.0 { Some(middle) } else { straight.map(|ratio| ratio.max(1.0)) }
}

fn ways(one: &str, other: &str, ratio: f64) -> Option<Finding> {
    let (text, figures) = (
        format!(
            "the way by its {one} is {} times that by its {other}{}",
            rounded(ratio),
            unit_of(ratio)
        ),
        [ratio, WAYS_REFUSED],
    );
    let off = ratio.max(1.0 / ratio);
    let remedy = "see which of the two has another unit than its name says, and leave it out or \
                  rename it";
    if off > WAYS_REFUSED {
        Some(Finding::refused("way", figures, text, remedy))
    } else if off > WAYS_WARNED {
        let remedy = "the consumption over the distance hangs on it: see which of the two is right";
        Some(Finding::warned("way", [ratio, WAYS_WARNED], text, remedy))
    } else {
        None
    }
}

/// The unit that explains a ratio.
fn unit_of(ratio: f64) -> String {
    let near = |(factor, _): &&(f64, &str)| (ratio / factor - 1.0).abs() < NEAR_UNIT;
    UNITS.iter().find(near).map_or(String::new(), |(_, meant)| format!(" ({meant}?)"))
}

/// Compares slopes; `grade` holds from each row on.
fn slopes(way_m: &[f64], altitude_m: &[f64], grade: &[f64]) -> Option<Finding> {
    let length_m = way_m.last()? - way_m.first()?;
    let (mut first, mut climb_m) = (None::<usize>, 0.0);
    let [mut both, mut by_altitude, mut by_grade, mut apart, mut compared_m] = [0.0; 5];
    let least_m = SLOPES_M.min(length_m);
    for k in 0..way_m.len() {
        let known = altitude_m[k].is_finite() && (grade[k].is_finite() || k + 1 == way_m.len());
        if let Some(from) = first {
            climb_m += grade[k - 1] * (way_m[k] - way_m[k - 1]);
            let dx_m = way_m[k] - way_m[from];
            if dx_m >= least_m && dx_m > 0.0 && altitude_m[k].is_finite() {
                let (a, g) = ((altitude_m[k] - altitude_m[from]) / dx_m, climb_m / dx_m);
                both += dx_m * a * g;
                by_altitude += dx_m * a * a;
                by_grade += dx_m * g * g;
                apart += dx_m * (a - g) * (a - g);
                compared_m += dx_m;
                first = None;
            }
        }
        if !known {
            first = None;
        } else if first.is_none() {
            (first, climb_m) = (Some(k), 0.0);
        }
    }
    if compared_m < 0.5 * length_m || compared_m <= 0.0 {
        return None;
    }
    let [a, g, apart] = [by_altitude, by_grade, apart].map(|sum| (sum / compared_m).sqrt());
    let rows = way_m.iter().zip(altitude_m).filter(|(_, altitude_m)| altitude_m.is_finite());
    let (at_m, known_m): (Vec<f64>, Vec<f64>) = rows.map(|(at_m, z)| (*at_m, *z)).unzip();
    let noise = SQRT_2 * noise_of_altitudes(&at_m, &known_m) / least_m;
    let bound = SLOPES_WARNED.max(SLOPES_WARNED_SD * noise);
    if apart < bound || apart < SLOPES_SHARE * a.max(g) {
        return None;
    }
    let ratio = if by_altitude > 0.0 { both / by_altitude } else { 0.0 };
    let meant = if ratio < -0.5 { " (another sign?)".to_owned() } else { unit_of(ratio) };
    let text = format!(
        "its altitudes climb by {} % in the mean, its slopes by {} %, and they differ by {} \
         %{meant}",
        rounded(100.0 * a),
        rounded(100.0 * g),
        rounded(100.0 * apart)
    );
    let remedy = "leave out the one that is wrong: what a slope is taken for is worth more than \
                  any other column";
    Some(if apart > SLOPES_REFUSED {
        Finding::refused("slope", [apart, SLOPES_REFUSED], text, remedy)
    } else {
        Finding::warned("slope", [apart, bound], text, remedy)
    })
}

/// Compares turns by the course, which grows clockwise, and by the yaw rate, to the left.
fn turning([time_s, speed_mps, course_rad, yaw_rate]: [&[f64]; 4]) -> Option<Finding> {
    let mut pairs: Vec<[f64; 2]> = Vec::new();
    let (mut from_s, mut by_course, mut by_yaw) = (None::<f64>, 0.0, 0.0);
    for k in 1..time_s.len() {
        let dt_s = time_s[k] - time_s[k - 1];
        let turn = short_way(course_rad[k] - course_rad[k - 1]);
        let yaw = 0.5 * (yaw_rate[k] + yaw_rate[k - 1]) * dt_s;
        let usable = turn.is_finite()
            && yaw.is_finite()
            && (0.0..TURNS_S).contains(&dt_s)
            && speed_mps[k] > TURNS_MPS;
        if !usable {
            from_s = None;
            continue;
        }
        let start_s = *from_s.get_or_insert_with(|| {
            (by_course, by_yaw) = (0.0, 0.0);
            time_s[k - 1]
        });
        by_course -= turn;
        by_yaw += yaw;
        if time_s[k] - start_s >= TURNS_S {
            pairs.push([by_course, by_yaw]);
            from_s = None;
        }
    }
    pairs.retain(|pair| pair[0].abs() > TURNS_RAD);
    let ratio = slope_of(&pairs)?;
    if ratio > 0.0 && ratio.max(1.0 / ratio) < TURNS_REFUSED {
        return None;
    }
    let meant =
        if ratio < 0.0 { " (is it positive to the right?)".to_owned() } else { unit_of(ratio) };
    let text =
        format!("its yaw rate turns it by {} times what its course does{meant}", rounded(ratio));
    let remedy =
        "rename the yaw rate to its unit, or turn its sign, as in --map yaw_rate_degps=-gyro";
    Some(Finding::refused("turn", [ratio, TURNS_REFUSED], text, remedy))
}

/// The slope of a line through pairs, where they are enough and correlated.
fn slope_of(pairs: &[[f64; 2]]) -> Option<f64> {
    let sum = |term: fn(&[f64; 2]) -> f64| pairs.iter().map(term).sum::<f64>();
    let [xx, yy, xy] = [sum(|p| p[0] * p[0]), sum(|p| p[1] * p[1]), sum(|p| p[0] * p[1])];
    let is_line = pairs.len() >= FEWEST_TURNS && xy.abs() >= CORRELATED * (xx * yy).sqrt();
    is_line.then(|| xy / xx)
}

/// Compares the turns of the curvature of a route with those of its points, to whichever side it is
/// positive.
fn bends(path: &Path2d, curvature: &[f64]) -> Option<Finding> {
    let way_m = &path.position_m;
    let (mut pairs, mut first, mut turned) = (Vec::new(), 0, 0.0);
    for k in 1..way_m.len().min(curvature.len()) {
        turned += curvature[k - 1] * (way_m[k] - way_m[k - 1]);
        if way_m[k] - way_m[first] >= BENDS_M {
            let [from, to] = [first, k].map(|k| path.course_rad(way_m[k]));
            pairs.push([short_way(to - from), turned]);
            (first, turned) = (k, 0.0);
        }
    }
    pairs.retain(|pair| pair[0].abs() > TURNS_RAD);
    let ratio = slope_of(&pairs)?.abs();
    if ratio.max(1.0 / ratio) < TURNS_REFUSED {
        return None;
    }
    let text = format!(
        "its curvature turns it by {} times what its latitude and longitude do{}",
        rounded(ratio),
        unit_of(ratio)
    );
    let remedy = "leave out the one that is wrong: curves slow a truck down";
    Some(Finding::refused("turn", [ratio, TURNS_REFUSED], text, remedy))
}

/// Compares the lateral acceleration with speed and yaw rate.
fn lateral(speed_mps: &[f64], lateral_mps2: &[f64], yaw_rate: &[f64]) -> Option<Finding> {
    let rows = speed_mps.iter().zip(yaw_rate).zip(lateral_mps2);
    let pairs = rows.map(|((speed, yaw), lateral)| [speed * yaw, *lateral]);
    let usable = |pair: &[f64; 2]| pair[0].abs() > LATERAL_MPS2 && pair[1].is_finite();
    let ratio = slope_of(&pairs.filter(usable).collect::<Vec<_>>())?;
    let off = ratio.abs().max(1.0 / ratio.abs());
    if ratio > 0.0 && off < LATERAL_REFUSED {
        return None;
    }
    let meant =
        if ratio < 0.0 { " (is it positive to the right?)".to_owned() } else { unit_of(ratio) };
    let text = format!(
        "its lateral acceleration is {} times its speed times its yaw rate{meant}",
        rounded(ratio)
    );
    let remedy = "rename it to its unit, or turn its sign, as in --map lateral_acceleration_g=-ay";
    Some(Finding::refused("turn", [ratio, LATERAL_REFUSED], text, remedy))
}

/// Compares the speed with the limit.
fn limits(speed_mps: &[f64], limit_mps: &[f64]) -> Option<Finding> {
    let rows = speed_mps.iter().zip(limit_mps);
    let rows = rows.filter(|(speed, limit)| **speed > DRIVING_MPS && **limit > 0.0);
    let mut ratios: Vec<f64> = rows.map(|(speed, limit)| speed / limit).collect();
    ratios.sort_by(f64::total_cmp);
    let ratio = ratios.get(ratios.len() / 2).copied().filter(|_| ratios.len() >= FEWEST_ROWS)?;
    if (SLOW_WARNED..=FAST_WARNED).contains(&ratio) {
        return None;
    }
    let meant = if ratio > 3.0 {
        " (is the limit in m/s, or the speed in km/h?)"
    } else if ratio > 1.0 {
        " (is the limit in mph, or the speed in km/h?)"
    } else {
        " (is the limit in km/h, or the speed in m/s?)"
    };
    let text =
        format!("half of its rows are driven at {} times the limit or more{meant}", rounded(ratio));
    let remedy = "rename the column to the unit that it has";
    Some(match ratio {
        FAST_REFUSED.. => Finding::refused("limit", [ratio, FAST_REFUSED], text, remedy),
        FAST_WARNED.. => Finding::warned("limit", [ratio, FAST_WARNED], text, remedy),
        _ => Finding::warned("limit", [ratio, SLOW_WARNED], text, remedy),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intake::End;
    use ocmc_core::random::{Draws, Stream};
    use std::collections::BTreeMap;

    /// A drive of 30 min on a winding and hilly road, with noise.
    fn drive(seed: u64) -> BTreeMap<Quantity, Vec<f64>> {
        let mut draws = Draws::new(seed, 0, Stream::Pedals);
        let mut columns: BTreeMap<Quantity, Vec<f64>> = BTreeMap::new();
        let [mut x, mut y, mut way_m, mut course] = [0.0, 0.0, 0.0, 1.0];
        for second in 0..1800 {
            let speed = 15.0 + 7.0 * f64::sin(0.01 * f64::from(second));
            let curvature = 0.004 * f64::sin(way_m / 300.0);
            course -= curvature * speed;
            way_m += speed;
            x += speed * f64::sin(course);
            y += speed * f64::cos(course);
            let per_degree = 111_195.0;
            let mut put = |quantity, value| columns.entry(quantity).or_default().push(value);
            put(Quantity::Time, f64::from(second));
            put(Quantity::Speed, speed + 0.1 * draws.normal());
            put(Quantity::Position, way_m);
            put(Quantity::Latitude, (y + 3.0 * draws.normal()) / per_degree);
            put(Quantity::Longitude, (x + 3.0 * draws.normal()) / per_degree);
            put(Quantity::Course, course + 0.02 * draws.normal());
            put(Quantity::YawRate, curvature * speed + 0.005 * draws.normal());
            put(Quantity::LateralAcceleration, curvature * speed * speed + 0.1 * draws.normal());
            put(Quantity::Altitude, 60.0 * f64::sin(way_m / 900.0) + 3.0 * draws.normal());
            put(Quantity::Grade, 60.0 / 900.0 * f64::cos(way_m / 900.0));
            put(Quantity::Limit, 16.0);
        }
        columns
    }

    fn found(columns: &BTreeMap<Quantity, Vec<f64>>) -> Vec<Finding> {
        of_drive(&|quantity| columns.get(&quantity).map(Vec::as_slice))
    }

    #[test]
    fn clean_drives_agree_and_a_wrong_unit_is_named() {
        for seed in 1..=10 {
            let clean = drive(seed);
            assert_eq!(found(&clean), [], "{seed}");
            for (quantity, factor, check, word) in [
                (Quantity::Speed, 3.6, "way", "km/h"),
                (Quantity::Speed, 1.0 / 3.6, "way", "m/s"),
                (Quantity::Position, 1000.0, "way", "km"),
                (Quantity::Position, 0.7, "way", "1.4"),
                (Quantity::Grade, 100.0, "slope", "per cent"),
                (Quantity::Grade, -1.0, "slope", "sign"),
                (Quantity::Grade, 0.0, "slope", "0"),
                (Quantity::YawRate, 57.296, "turn", "degrees"),
                (Quantity::YawRate, -1.0, "turn", "right"),
                (Quantity::LateralAcceleration, 1.0 / 9.80665, "turn", "g taken"),
                (Quantity::Limit, 1.0 / 1.609_344, "limit", "mph"),
                (Quantity::Limit, 1.0 / 3.6, "limit", "m/s"),
                (Quantity::Limit, 3.6, "limit", "km/h"),
            ] {
                let mut wrong = clean.clone();
                let values = wrong.get_mut(&quantity).expect("is there");
                for value in values {
                    *value *= factor;
                }
                let findings = found(&wrong);
                let named = findings.iter().find(|finding| finding.check == check);
                let named = named.unwrap_or_else(|| panic!("{quantity:?} {factor} {findings:?}"));
                assert!(named.text.contains(word), "{quantity:?} {factor}: {named}");
                assert!(named.end != End::Mended && !named.remedy.is_empty());
            }
        }
    }

    #[test]
    fn curvatures_agree_with_points_or_are_refused() {
        let (mut x_m, mut y_m, mut curvature) = (vec![0.0], vec![0.0], Vec::new());
        let mut course = 0.0_f64;
        for k in 0..600 {
            let bend = 0.005 * f64::sin(f64::from(k) / 20.0);
            curvature.push(bend);
            course += 10.0 * bend;
            x_m.push(x_m[k as usize] + 10.0 * course.cos());
            y_m.push(y_m[k as usize] + 10.0 * course.sin());
        }
        curvature.push(0.0);
        let path = Path2d::of_points(x_m, y_m);
        assert_eq!(of_route(None, Some(&path), &[], &[], &curvature), []);
        let small: Vec<f64> = curvature.iter().map(|bend| 0.001 * bend).collect();
        let findings = of_route(None, Some(&path), &[], &[], &small);
        assert!(findings[0].is_refusal() && findings[0].check == "turn", "{findings:?}");
    }

    #[test]
    fn routes_with_two_slopes_or_ways_are_refused() {
        let findings = of_route(Some(&[0.0, 20_000.0]), None, &[100.0, 700.0], &[0.0, 0.0], &[]);
        assert!(findings[0].is_refusal() && findings[0].text.contains("3.000 %"), "{findings:?}");
        assert_eq!(of_route(Some(&[0.0, 20_000.0]), None, &[100.0, 700.0], &[0.03, 0.0], &[]), []);
        let x_m: Vec<f64> = (0..100).map(|k| 100.0 * f64::from(k)).collect();
        let path = Path2d::of_points(x_m.clone(), vec![0.0; 100]);
        assert_eq!(of_route(Some(&x_m), Some(&path), &[], &[], &[]), []);
        let km: Vec<f64> = x_m.iter().map(|x_m| 0.001 * x_m).collect();
        let findings = of_route(Some(&km), Some(&path), &[], &[], &[]);
        assert!(findings[0].is_refusal() && findings[0].text.contains("km taken for m"));
    }
}
