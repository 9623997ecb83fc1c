//! Checks a study file: every number within its bound, and the numbers that have to fit one another.

use super::{StudyModel, bound_of};
use crate::distribution::{Law, Quantity};
use crate::driver::curve_speed::CurveSpeedForm;
use crate::operating_cycle::mission::{MINIMUM_SPACING_M, MissionStopModel};
use crate::operating_cycle::road::topography::ClimbRule;
use crate::powertrain::battery_electric::ElectricModel;
use crate::powertrain::diesel::engine::{EngineModel, MOST_KNOTS};
use crate::powertrain::gearbox::GearboxModel;
use nalgebra::Matrix3;
use serde::Deserialize;
use serde_json::Value;
use std::fmt;

/// One thing that is wrong with a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Full path of the key.
    pub path: String,
    /// Its value.
    pub value: String,
    /// What is allowed.
    pub allowed: String,
}

/// Everything that is wrong with a study.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct StudyError {
    /// The problems, at least one.
    pub problems: Vec<Problem>,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "`{}` is {}, allowed is {}", self.path, self.value, self.allowed)
    }
}

impl fmt::Display for StudyError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for (k, problem) in self.problems.iter().enumerate() {
            if k > 0 {
                writeln!(f)?;
            }
            write!(f, "{problem}")?;
        }
        Ok(())
    }
}

pub(super) fn check(model: &StudyModel) -> Result<(), StudyError> {
    let mut problems = Vec::new();
    let tree = serde_json::to_value(model).expect("a study model serialises");
    walk("", &tree, &mut problems);
    if problems.is_empty() {
        consistency(model, &mut problems);
    }
    if problems.is_empty() { Ok(()) } else { Err(StudyError { problems }) }
}

/// Checks every number under `path`; serde writes what is not finite as null.
fn walk(path: &str, value: &Value, problems: &mut Vec<Problem>) {
    match value {
        Value::Object(table) if table.contains_key("distribution") => law(path, value, problems),
        Value::Object(table) => {
            for (key, value) in table {
                let below = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                walk(&below, value, problems);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| walk(path, item, problems)),
        Value::Number(number) => {
            number_in_bounds(path, number.as_f64().unwrap_or(f64::NAN), problems);
        }
        Value::Null => number_in_bounds(path, f64::NAN, problems),
        Value::Bool(_) | Value::String(_) => {}
    }
}

fn number_in_bounds(path: &str, value: f64, problems: &mut Vec<Problem>) {
    let (minimum, maximum) =
        bound_of(path).map_or((f64::MIN, f64::MAX), |b| (b.minimum, b.maximum));
    if !(value >= minimum && value <= maximum) {
        let value =
            if value.is_nan() { "not a finite number".to_owned() } else { value.to_string() };
        problems.push(Problem {
            path: path.to_owned(),
            value,
            allowed: format!("{minimum} to {maximum}"),
        });
    }
}

/// Checks a law's own parameters, then that it draws, but for one in a million on each side, within the key's bound.
fn law(path: &str, value: &Value, problems: &mut Vec<Problem>) {
    let finite = Law::deserialize(value).ok().filter(|_| !has_null(value));
    let Some(law) = finite else {
        // a NaN parameter has become null: it does not read back, or as an absent optional end
        problems.push(Problem {
            path: path.to_owned(),
            value: "a distribution with a parameter that is not a finite number".to_owned(),
            allowed: "finite numbers".to_owned(),
        });
        return;
    };
    if let Some((name, value, allowed)) = law.fault() {
        problems.push(Problem {
            path: format!("{path}.{name}"),
            value: value.to_string(),
            allowed: allowed.to_owned(),
        });
        return;
    }
    let (minimum, maximum) =
        bound_of(path).map_or((f64::MIN, f64::MAX), |b| (b.minimum, b.maximum));
    let (low, high) = law.practical_range();
    if !(low >= minimum && high <= maximum) {
        problems.push(Problem {
            path: path.to_owned(),
            value: format!("a distribution that draws {low} to {high}"),
            allowed: format!(
                "{minimum} to {maximum}: give the law a `lower` or an `upper` end, or less spread"
            ),
        });
    }
}

fn has_null(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::Array(items) => items.iter().any(has_null),
        Value::Object(table) => table.values().any(has_null),
        _ => false,
    }
}

/// What no single number can tell.
fn consistency(model: &StudyModel, problems: &mut Vec<Problem>) {
    let mut require = |holds: bool, path: &str, value: String, allowed: &str| {
        if !holds {
            let (path, allowed) = (path.to_owned(), allowed.to_owned());
            problems.push(Problem { path, value, allowed });
        }
    };
    let types = &model.road.types;
    require(!types.is_empty(), "road.types", "empty".to_owned(), "at least one road type");
    for (name, road_type) in types {
        let at = |key: &str| format!("road.types.{name}.{key}");
        let total: f64 = road_type.next.values().sum();
        let right = if types.len() > 1 { (total - 1.0).abs() < 1e-6 } else { total == 0.0 };
        require(
            right,
            &at("next"),
            format!("a sum of {total}"),
            "a sum of 1 over the other road types (empty where there is only one)",
        );
        for (next, share) in &road_type.next {
            let known = types.contains_key(next) && (next != name || *share == 0.0);
            require(known, &at("next"), format!("`{next}`"), "another road type of this study");
        }
        let (minimum, mean) = (road_type.minimum_length_m, road_type.mean_length_m);
        require(
            minimum < mean,
            &at("minimum_length_m"),
            minimum.to_string(),
            "below mean_length_m",
        );
        let signs = &road_type.speed_signs;
        require(
            !signs.speed_kmh.is_empty(),
            &at("speed_signs.speed_kmh"),
            "empty".to_owned(),
            "at least one sign",
        );
        require(
            signs.share.len() == signs.speed_kmh.len(),
            &at("speed_signs.share"),
            format!("{} numbers", signs.share.len()),
            "one share for each sign of speed_kmh",
        );
        let total: f64 = signs.share.iter().sum();
        require(
            (total - 1.0).abs() < 1e-6,
            &at("speed_signs.share"),
            format!("a sum of {total}"),
            "a sum of 1",
        );
        let total: f64 = road_type.ground.values().sum();
        require(
            (total - 1.0).abs() < 1e-6,
            &at("ground"),
            format!("a sum of {total}"),
            "a sum of 1",
        );
        let hill = road_type.topography.hill_length_m;
        require(
            hill > 4.0 * model.road.slope_step_m,
            &at("topography.hill_length_m"),
            hill.to_string(),
            "above 4 times road.slope_step_m",
        );
        require(
            model.traffic.types.contains_key(name),
            "traffic.types",
            format!("without `{name}`"),
            "an entry for each road type",
        );
    }
    for name in model.traffic.types.keys() {
        require(
            types.contains_key(name),
            "traffic.types",
            format!("`{name}`"),
            "a road type of this study",
        );
    }

    mission(model, &mut require);
    let curve = &model.driver.curve_speed;
    if curve.form != CurveSpeedForm::Pooled {
        let rows = curve.table.as_ref().map_or(0, |t| t.exponent.len());
        require(
            rows >= 3,
            "driver.curve_speed.table",
            format!("{rows} trucks"),
            "at least 3 trucks, for the forms `table` and `bivariate`",
        );
    }
    if let Some(table) = &curve.table {
        let equal = table.exponent.len() == table.reference_speed_mps.len()
            && table.truck.len() == table.exponent.len();
        require(
            equal,
            "driver.curve_speed.table",
            "lists of different lengths".to_owned(),
            "one truck, exponent and reference_speed_mps a row",
        );
    }
    let limit = &model.driver.speed_limit;
    require(
        limit.bump_minimum_mps <= limit.bump_maximum_mps,
        "driver.speed_limit.bump_minimum_mps",
        limit.bump_minimum_mps.to_string(),
        "at most bump_maximum_mps",
    );
    let pid = &model.driver.pedals.pid;
    require(
        pid.proportional_minimum <= pid.proportional_maximum,
        "driver.pedals.pid.proportional_minimum",
        pid.proportional_minimum.to_string(),
        "at most proportional_maximum",
    );
    let [pi, pd, id] = pid.correlation;
    let definite = Matrix3::new(1.0, pi, pd, pi, 1.0, id, pd, id, 1.0).cholesky().is_some();
    require(
        definite,
        "driver.pedals.pid.correlation",
        format!("{:?}", pid.correlation),
        "a positive definite correlation matrix",
    );
    vehicle(model, &mut require);
}

fn mission(model: &StudyModel, require: &mut impl FnMut(bool, &str, String, &str)) {
    let (mission, road) = (&model.mission, &model.road);
    if let Some(MissionStopModel { spacing_m: Quantity::Number(spacing_m), .. }) = mission.stops {
        require(
            spacing_m >= MINIMUM_SPACING_M,
            "mission.stops.spacing_m",
            spacing_m.to_string(),
            "50 to 5000000; the draws of a law below 50 are put there",
        );
    }
    let limits = road.types.values().map(|road_type| road_type.topography.slope_limit);
    let steepest = limits.fold(0.0, f64::max);
    let (climb_m, length_m) = (road.net_climb_m.centre().abs(), mission.length_m.centre());
    require(
        road.climb_rule == ClimbRule::Free || climb_m <= steepest * length_m,
        "road.net_climb_m",
        climb_m.to_string(),
        "at most the largest slope_limit of the road types times mission.length_m",
    );
}

fn electric_vehicle(electric: &ElectricModel, require: &mut impl FnMut(bool, &str, String, &str)) {
    let (battery, motor) = (&electric.battery, &electric.motor);
    let mut below = |low: f64, high: f64, key: &str, what: &str| {
        require(low < high, &format!("vehicle.electric.{key}"), low.to_string(), what);
    };
    let (empty, full) = (battery.empty_voltage_v, battery.full_voltage_v * (1.0 + 1e-9));
    below(empty, full, "battery.empty_voltage_v", "at most full_voltage_v");
    let (low, high) = (battery.minimum_charge, battery.maximum_charge);
    below(low, high, "battery.minimum_charge", "below maximum_charge");
    let rising = |xs: &[f64]| xs.len() >= 2 && xs.windows(2).all(|w| w[0] < w[1]);
    for (key, xs) in
        [("map_speed_radps", &motor.map_speed_radps), ("map_torque_nm", &motor.map_torque_nm)]
    {
        let (path, shown) = (format!("vehicle.electric.motor.{key}"), format!("{xs:?}"));
        require(rising(xs), &path, shown, "2 and more rising numbers");
    }
    let rows = motor.map_loss_w.len() == motor.map_speed_radps.len()
        && motor.map_loss_w.iter().all(|row| row.len() == motor.map_torque_nm.len());
    require(
        rows,
        "vehicle.electric.motor.map_loss_w",
        "a map of another size".to_owned(),
        "a row for each of map_speed_radps, with a column for each of map_torque_nm",
    );
    for (key, xs) in
        [("map_speed_radps", &motor.map_speed_radps), ("map_torque_nm", &motor.map_torque_nm)]
    {
        require(
            xs.len() <= MOST_KNOTS,
            &format!("vehicle.electric.motor.{key}"),
            format!("{} numbers", xs.len()),
            "at most 16 numbers",
        );
    }
    require(
        electric.ratio.len() < 2 || electric.shift.is_some(),
        "vehicle.electric.shift",
        "not there".to_owned(),
        "when to shift, where there is more than one gear",
    );
    let falling = electric.ratio.windows(2).all(|w| w[0] > w[1]);
    require(
        falling && (1..=24).contains(&electric.ratio.len()),
        "vehicle.electric.ratio",
        format!("{:?}", electric.ratio),
        "1 to 24 falling ratios",
    );
}

fn vehicle(model: &StudyModel, require: &mut impl FnMut(bool, &str, String, &str)) {
    let vehicle = &model.vehicle;
    let total = vehicle.axles.iter().fold(0.0, |sum, axle| sum + axle.load_share);
    require(
        (total - 1.0).abs() < 1e-3,
        "vehicle.axles",
        format!("load shares with a sum of {total}"),
        "load shares with a sum of 1",
    );

    match (&vehicle.engine, &vehicle.gearbox, &vehicle.electric) {
        (Some(engine), Some(gearbox), None) => diesel_vehicle(engine, gearbox, require),
        (None, None, Some(electric)) => electric_vehicle(electric, require),
        (None, Some(_), None) => {
            require(false, "vehicle.engine", "not there".to_owned(), "an engine for the gearbox");
        }
        (Some(_), None, None) => {
            require(false, "vehicle.gearbox", "not there".to_owned(), "a gearbox for the engine");
        }
        (None, None, None) => require(
            false,
            "vehicle",
            "without a powertrain".to_owned(),
            "`engine` and `gearbox`, or `electric`",
        ),
        (_, _, Some(_)) => require(
            false,
            "vehicle.electric",
            "there beside `engine` or `gearbox`".to_owned(),
            "one powertrain: leave an inherited one out by study.drop = [\"vehicle.engine\", \"vehicle.gearbox\"]",
        ),
    }
}

fn diesel_vehicle(
    engine: &EngineModel,
    gearbox: &GearboxModel,
    require: &mut impl FnMut(bool, &str, String, &str),
) {
    let rising = |xs: &[f64]| xs.windows(2).all(|w| w[0] < w[1]);
    for (key, xs) in [
        ("full_load_speed_radps", &engine.full_load_speed_radps),
        ("map_speed_radps", &engine.map_speed_radps),
        ("map_torque_nm", &engine.map_torque_nm),
    ] {
        let fits = rising(xs) && (2..=MOST_KNOTS).contains(&xs.len());
        require(
            fits,
            &format!("vehicle.engine.{key}"),
            format!("{xs:?}"),
            "2 to 16 rising numbers",
        );
    }
    let same = |key: &str,
                have: usize,
                want: usize,
                what: &str,
                require: &mut dyn FnMut(bool, &str, String, &str)| {
        require(have == want, &format!("vehicle.engine.{key}"), format!("{have} entries"), what);
    };
    same(
        "full_load_torque_nm",
        engine.full_load_torque_nm.len(),
        engine.full_load_speed_radps.len(),
        "as many as full_load_speed_radps",
        require,
    );
    same(
        "drag_torque_nm",
        engine.drag_torque_nm.len(),
        engine.map_speed_radps.len(),
        "as many as map_speed_radps",
        require,
    );
    same(
        "map_fuel_kgps",
        engine.map_fuel_kgps.len(),
        engine.map_speed_radps.len(),
        "a row for each of map_speed_radps",
        require,
    );
    require(
        engine.map_torque_nm.first() == Some(&0.0),
        "vehicle.engine.map_torque_nm",
        format!("{:?}", engine.map_torque_nm),
        "torques that begin with 0",
    );
    let rows =
        engine.map_fuel_kgps.iter().all(|r| (2..=engine.map_torque_nm.len()).contains(&r.len()));
    require(
        rows,
        "vehicle.engine.map_fuel_kgps",
        "a row of another length".to_owned(),
        "2 to as many columns as map_torque_nm in each row",
    );

    let falling = gearbox.ratio.windows(2).all(|w| w[0] > w[1]);
    let gears = gearbox.ratio.len();
    require(
        falling && (1..=24).contains(&gears),
        "vehicle.gearbox.ratio",
        format!("{:?}", gearbox.ratio),
        "1 to 24 falling ratios",
    );
    for (key, gear) in [
        ("start_gear", gearbox.shift.start_gear),
        ("steep_start_gear", gearbox.shift.steep_start_gear),
        ("launch_gears", gearbox.shift.launch_gears),
    ] {
        require(
            gear as usize <= gears,
            &format!("vehicle.gearbox.shift.{key}"),
            gear.to_string(),
            "at most the number of gears",
        );
    }
    let start = gearbox.shift.start_gear.max(gearbox.shift.steep_start_gear);
    require(
        start <= gearbox.shift.launch_gears,
        "vehicle.gearbox.shift.start_gear",
        start.to_string(),
        "at most launch_gears: only there the clutch slips",
    );
    let idle = engine.idle_speed_radps;
    require(
        gearbox.shift.launch_speed_radps >= gearbox.shift.open_share * idle,
        "vehicle.gearbox.shift.launch_speed_radps",
        gearbox.shift.launch_speed_radps.to_string(),
        "at least open_share times the idle speed",
    );
}
