//! Checks a study file: every number within its range, and what the rules beside the models say of
//! numbers that have to fit one another.

use super::StudyModel;
use super::fleet::FleetModel;
use super::keys::{Bounds, Key, declarations};
use crate::charging::ChargingPolicy;
use crate::cost::CostModel;
use crate::distribution::Quantity;
use crate::rest::RestModel;
use crate::validation::{Problem, Problems};
use crate::vehicle::VehicleModel;
use serde::Deserialize;
use serde_json::Value;

/// Everything that is wrong with a study.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}", problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("\n"))]
pub struct StudyError {
    /// The problems, at least one.
    pub problems: Vec<Problem>,
}

pub(super) fn check(model: &StudyModel) -> Result<(), StudyError> {
    let tree = model.to_tree();
    let mut problems = outside_bounds(&tree);
    if problems.is_empty() {
        problems = rules(model, &tree);
    }
    if problems.is_empty() { Ok(()) } else { Err(StudyError { problems }) }
}

/// Values outside the range that is declared of their key, in a [tree](super::tree) of a study.
pub fn outside_bounds(tree: &Value) -> Vec<Problem> {
    let mut problems = Problems::default();
    within_bounds(tree, Key(declarations()), &mut problems);
    problems.into_problems()
}

/// Problems by the rules beside the models, of numbers that are each within their range.
fn rules(model: &StudyModel, tree: &Value) -> Vec<Problem> {
    let StudyModel { mission, road, traffic, driver, vehicle, fleet, .. } = model;
    let mut problems = Problems::default();
    problems.part("road", |problems| road.validate(mission.length_m.centre(), problems));
    problems.part("traffic", |problems| traffic.validate(road, problems));
    problems.part("mission", |problems| mission.validate(problems));
    problems.part("mission", |problems| in_time(model, problems));
    problems.part("driver", |problems| driver.validate(problems));
    problems.part("vehicle", |problems| vehicle.validate(problems));
    problems.part("fleet", |problems| fleet.validate(problems));
    problems.part("mission", |problems| loads_within(model, problems));
    FleetModel::validate_levels(tree, &mut problems);
    problems.part("uncertainty", |problems| model.validate_uncertainty(tree, problems));
    let chains = fleet.calendar.as_ref().is_some_and(|calendar| calendar.chain);
    if chains && vehicle.powertrain.plugs_in() {
        let depot = model.charging.as_ref().is_some_and(|charging| charging.depot.is_some());
        let allowed = "true with a table `charging.depot`, that charges the trucks between trips";
        problems.part("fleet", |problems| {
            problems.require(depot, "calendar.chain", true, allowed);
        });
    }
    problems.part_if("cost", model.cost.as_ref(), CostModel::validate);
    problems.part_if("rest", model.rest.as_ref(), RestModel::validate);
    if let Some(charging) = &model.charging {
        problems.part("charging", |problems| charging.validate(problems));
        problems.part("charging", |problems| chargers_within(model, charging, problems));
        problems.part("charging", |problems| departs_above(model, charging, problems));
    }
    draws_within(model, &mut problems);
    problems.into_problems()
}

/// Payloads that are given as numbers are legal, and the engine has the power that a body is to
/// take.
fn loads_within(model: &StudyModel, problems: &mut Problems) {
    let StudyModel { mission, vehicle, .. } = model;
    let most_kg = vehicle.most_payload_kg();
    let allowed = format!(
        "at most {most_kg}: vehicle.gross_mass_limit_kg less vehicle.curb_mass_kg; a law of the \
         payload is cut there"
    );
    let mut require_legal = |key: &str, payload: &Quantity| {
        if let Quantity::Number(payload_kg) = *payload {
            problems.require(payload_kg <= most_kg, key, payload_kg, &allowed);
        }
    };
    require_legal("payload_kg", &mission.payload_kg);
    let stops = mission.stops.as_ref();
    let cargo = stops.and_then(|stops| stops.cargo.as_ref()?.payload_kg.as_ref());
    if let Some(payload) = cargo {
        require_legal("stops.cargo.payload_kg", payload);
    }
    let power = stops.and_then(|stops| stops.power_take_off.as_ref()).map(|body| &body.power_w);
    let most_w = || power_take_off_w(vehicle).map(libm::floor);
    if let Some((Quantity::Number(power_w), left_w)) = power.zip(most_w()) {
        let allowed = format!(
            "at most {left_w}: the full load of the engine at \
             `vehicle.powertrain.combustion.engine.power_take_off_speed_radps` (that of idling \
             where it is absent) less its auxiliaries; a law is cut there"
        );
        problems.require(*power_w <= left_w, "stops.power_take_off.power_w", power_w, &allowed);
    }
}

/// The most that an engine gives a body, in W; none without an engine, and where something is wrong
/// with the truck.
fn power_take_off_w(vehicle: &VehicleModel) -> Option<f64> {
    let mut problems = Problems::default();
    vehicle.validate(&mut problems);
    if !problems.into_problems().is_empty() {
        return None;
    }
    vehicle.prepare().powertrain.power_take_off_w(vehicle.auxiliary_power_w.centre())
}

/// Given chargers lie on a drawn road of one length; given roads are looked at with them.
fn chargers_within(model: &StudyModel, charging: &ChargingPolicy, problems: &mut Problems) {
    if let (Some(public), true, Quantity::Number(length_m)) =
        (&charging.public, model.mission.routes.is_empty(), &model.mission.length_m)
    {
        problems.part("public", |problems| public.require_within(*length_m, problems));
    }
}

/// Where there is no public charger a truck stops with its reserve, and has to depart with more.
fn departs_above(model: &StudyModel, charging: &ChargingPolicy, problems: &mut Problems) {
    let battery = model.vehicle.powertrain.battery().filter(|_| charging.public.is_none());
    if let Some((key, battery)) = battery {
        let least = battery.initial_charge.practical_range().0;
        let allowed =
            format!("below {least}, the least of `vehicle.powertrain.{key}.initial_charge`");
        problems.require(charging.reserve < least, "reserve", charging.reserve, &allowed);
    }
}

/// The last step before a truck stops draws what its battery holds: at the highest power half of
/// what the store loses comes out.
fn draws_within(model: &StudyModel, problems: &mut Problems) {
    let Some((key, battery)) = model.vehicle.powertrain.battery() else { return };
    let step_j = 2.0 * battery.discharge_power_w * model.simulation.step_s;
    // as it is printed, so that what is printed is allowed
    let least = libm::ceil(1e6 * step_j / battery.aged().capacity_j) / 1e6;
    let allowed = format!("at least {least}: what the last step before it can take of the store");
    problems.part(&format!("vehicle.powertrain.{key}"), |problems| {
        let holds = battery.minimum_charge >= least;
        problems.require(holds, "minimum_charge", battery.minimum_charge, &allowed);
    });
}

/// A mission that no driver ends in the time that a cycle has would always be given up.
fn in_time(model: &StudyModel, problems: &mut Problems) {
    let StudyModel { mission, driver, simulation, vehicle, .. } = model;
    let length_m = mission.length_m.centre();
    let highest_mps = driver.speed_limit.highest_mps(vehicle.limiter_speed_mps);
    let longest_m = simulation.longest_duration_s * highest_mps;
    let allowed = format!(
        "at most {longest_m:.0}: so far does `driver.speed_limit.maximum_speed_mps` lead in \
         `simulation.longest_duration_s`"
    );
    let holds = !mission.routes.is_empty() || length_m <= longest_m;
    problems.require(holds, "length_m", length_m, &allowed);
}

/// Checks every number of a value against what is declared of its key; serde writes what is not
/// finite as null.
fn within_bounds(value: &Value, key: Key, problems: &mut Problems) {
    match value {
        Value::Object(table) if table.contains_key("distribution") => law(value, key, problems),
        Value::Object(table) => {
            for (name, value) in table {
                let below = key.below(name).unwrap_or(Key(&Value::Null));
                problems.part(name, |problems| within_bounds(value, below, problems));
            }
        }
        Value::Array(items) => items.iter().for_each(|item| within_bounds(item, key, problems)),
        Value::Number(number) => {
            number_within(number.as_f64().unwrap_or(f64::NAN), key, problems);
        }
        Value::Null => number_within(f64::NAN, key, problems),
        Value::Bool(_) | Value::String(_) => {}
    }
}

fn number_within(value: f64, key: Key, problems: &mut Problems) {
    let Bounds { minimum, maximum } = key.bounds().unwrap_or(Bounds::FINITE);
    if !(value >= minimum && value <= maximum) {
        let shown =
            if value.is_nan() { "not a finite number".to_owned() } else { value.to_string() };
        problems.require(false, "", shown, &format!("{minimum} to {maximum}"));
    }
}

/// A number, or the centre of a law, outside the range that is usual for its key.
#[derive(Clone, Debug, PartialEq)]
pub struct Unusual {
    /// The key.
    pub path: String,
    /// The number.
    pub value: f64,
    /// The range that is usual.
    pub usual: Bounds,
}

/// Values outside the range that is usual for their key, in a [tree](super::tree) of a study. A
/// zero is none, where zero is allowed.
pub fn outside_usual(tree: &Value) -> Vec<Unusual> {
    let mut unusual = Vec::new();
    collect_unusual(tree, Key(declarations()), &mut String::new(), &mut unusual);
    unusual
}

fn collect_unusual(value: &Value, key: Key, path: &mut String, unusual: &mut Vec<Unusual>) {
    let number = match value {
        Value::Object(table) if table.contains_key("distribution") => {
            Quantity::deserialize(value).ok().map(|law| law.centre())
        }
        Value::Object(table) => {
            for (name, value) in table {
                let above = path.len();
                if above > 0 {
                    path.push('.');
                }
                path.push_str(name);
                let below = key.below(name).unwrap_or(Key(&Value::Null));
                collect_unusual(value, below, path, unusual);
                path.truncate(above);
            }
            None
        }
        Value::Array(items) => {
            for item in items {
                collect_unusual(item, key, path, unusual);
            }
            None
        }
        _ => value.as_f64(),
    };
    if let (Some(value), Some(usual)) = (number, key.usual())
        && value != 0.0
        && !(usual.minimum..=usual.maximum).contains(&value)
    {
        unusual.push(Unusual { path: path.clone(), value, usual });
    }
}

/// Checks a law's own parameters, then that it draws, but for one in a million on each side, within
/// the key's range.
fn law(value: &Value, key: Key, problems: &mut Problems) {
    let finite = Quantity::deserialize(value).ok().filter(|_| !has_null(value));
    let Some(law) = finite else {
        // a NaN parameter has become null: it does not read back, or as an absent optional end
        let shown = "a distribution with a parameter that is not a finite number";
        return problems.require(false, "", shown, "finite numbers");
    };
    if let Some((name, value, allowed)) = law.fault() {
        return problems.require(false, name, value, allowed);
    }
    let Bounds { minimum, maximum } = key.bounds().unwrap_or(Bounds::FINITE);
    let (low, high) = law.practical_range();
    let allowed =
        format!("{minimum} to {maximum}: give the law a `lower` or an `upper` end, or less spread");
    let shown = format!("a distribution that draws {low} to {high}");
    problems.require(low >= minimum && high <= maximum, "", shown, &allowed);
}

fn has_null(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::Array(items) => items.iter().any(has_null),
        Value::Object(table) => table.values().any(has_null),
        _ => false,
    }
}
