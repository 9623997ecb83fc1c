//! How uncertain the numbers of a study are: standard errors of estimates, and how the errors go
//! together.
//!
//! Any number of a study may be an estimate. `[uncertainty.NAME]` lists the keys of one estimation
//! with their standard errors and the correlation of their errors; errors of different estimations
//! are independent. The law of curve speeds has keys of its own for it, because its forms `table`
//! and `bivariate` are uncertain as their trucks are few: the errors of the mean exponent and the
//! mean speed of n trucks have the covariance of the trucks, divided by n.
//!
//! One of several shares whose sum stays the same moves along the simplex: the others give way in
//! proportion. A whole list of shares is moved by its first one.

use super::{Study, StudyError, StudyModel};
use crate::driver::curve_speed::CurveSpeedModel;
use crate::validation::Problems;
use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Number, Value};
use std::collections::BTreeSet;

/// Numbers of the study that were estimated together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Estimates {
    /// Paths of the keys, such as `driver.curve_speed.driver_sd`; a list of numbers is uncertain as
    /// a whole.
    pub keys: Vec<String>,
    /// Standard error of each key, in its unit.
    #[schemars(inner(range(min = 0.0, max = 1.0e12)))]
    pub standard_errors: Vec<f64>,
    /// Correlation of the errors, a row for each key; independent where it is left out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(inner(inner(range(min = -1.0, max = 1.0))))]
    pub correlation: Vec<Vec<f64>>,
}

/// One uncertain number.
#[derive(Clone, Debug, PartialEq)]
pub struct UncertainKey {
    /// Path of the key.
    pub key: String,
    /// Standard error, in the unit of the key.
    pub standard_error: f64,
}

/// All uncertain numbers of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Uncertainty {
    /// The numbers.
    pub keys: Vec<UncertainKey>,
    /// Correlation of their errors.
    pub correlation: DMatrix<f64>,
}

const CURVE_SPEED: &str = "driver.curve_speed";

/// Tables of a study whose numbers describe no road, driver or truck.
const NO_MODELS: [&str; 5] = ["study", "simulation", "uncertainty", "cost", "emissions"];

/// Numbers of a study's models that have no standard error, counted by table: a list counts once.
/// `known` has the paths of those that have one.
pub fn numbers_without_error(study: &Value, known: &[&str]) -> Vec<(String, usize)> {
    let tables = study.as_object().into_iter().flatten();
    let models = tables.filter(|(name, _)| !NO_MODELS.contains(&name.as_str()));
    let counted = models.map(|(name, table)| (name.clone(), without_error(table, name, known)));
    counted.filter(|(_, count)| *count > 0).collect()
}

fn without_error(value: &Value, path: &str, known: &[&str]) -> usize {
    if is_number(value) {
        return usize::from(known.iter().all(|key| !same_or_part(key, path)));
    }
    let below = |name: &str, value: &Value| without_error(value, &format!("{path}.{name}"), known);
    match value {
        Value::Object(items) => items.iter().map(|(name, value)| below(name, value)).sum(),
        Value::Array(items) => {
            items.iter().enumerate().map(|(k, value)| below(&k.to_string(), value)).sum()
        }
        _ => 0,
    }
}

impl Estimates {
    fn validate(&self, study: &Value, seen: &mut BTreeSet<String>, problems: &mut Problems) {
        let n = self.keys.len();
        problems.require(n > 0, "keys", "an empty list", "at least one key of the study");
        for key in &self.keys {
            let head = key.split('.').next().unwrap_or_default();
            let model = !NO_MODELS.contains(&head);
            let path = model && !key.contains(['/', '~']);
            let number = path && study.pointer(&pointer(key)).is_some_and(is_number);
            let allowed = "a path to a number of the study's models, or to a list of numbers; of a \
                           law name one of its numbers, such as `mission.payload_kg.mean`";
            problems.require(number, "keys", format!("`{key}`"), allowed);
            let known = seen.iter().any(|other| same_or_part(key, other));
            let allowed = "each key once: its standard error is given elsewhere, too";
            problems.require(!known, "keys", format!("`{key}`"), allowed);
            seen.insert(key.clone());
        }
        let m = self.standard_errors.len();
        let allowed = format!("one of each key: {n}");
        problems.require(m == n, "standard_errors", format!("{m} numbers"), &allowed);
        if self.correlation.is_empty() {
            return;
        }
        let rows = &self.correlation;
        let square = rows.len() == n && rows.iter().all(|row| row.len() == n);
        let allowed = format!("{n} rows of {n} numbers, one of each key");
        problems.require(square, "correlation", "a list of another shape", &allowed);
        if square {
            let r = DMatrix::from_fn(n, n, |i, j| rows[i][j]);
            let one = (0..n).all(|i| r[(i, i)] == 1.0);
            let allowed = "1 on the diagonal, the same on both sides of it, and possible: no \
                           combination of the keys with a negative variance";
            let possible = || r.clone().symmetric_eigenvalues().iter().all(|l| *l > -1e-9);
            let holds = one && r == r.transpose() && possible();
            problems.require(holds, "correlation", "no correlation of errors", allowed);
        }
    }
}

/// The errors of the law of curve speeds, in order of their keys.
fn of_curve_speed(law: &CurveSpeedModel) -> Estimates {
    let own = |key: &str| format!("{CURVE_SPEED}.{key}");
    if let Some((errors, correlation)) = law.errors_of_table() {
        return Estimates {
            keys: vec![own("table.exponent"), own("table.reference_speed_mps")],
            standard_errors: errors.to_vec(),
            correlation: vec![vec![1.0, correlation], vec![correlation, 1.0]],
        };
    }
    let speed = law.reference_speed_mps * law.reference_speed_log_standard_error;
    Estimates {
        keys: vec![own("exponent"), own("reference_speed_mps")],
        standard_errors: vec![law.exponent_standard_error, speed],
        correlation: match law.error_correlation {
            0.0 => Vec::new(),
            r => vec![vec![1.0, r], vec![r, 1.0]],
        },
    }
}

impl StudyModel {
    /// Uncertain numbers of the study; none where it takes all for certain.
    pub fn uncertain(&self) -> Option<Uncertainty> {
        let law = &self.driver.curve_speed;
        let law = law.parameter_uncertainty.then(|| of_curve_speed(law));
        let estimates: Vec<&Estimates> = law.iter().chain(self.uncertainty.values()).collect();
        let mut keys = Vec::new();
        let n = estimates.iter().map(|estimate| estimate.keys.len()).sum();
        let mut correlation = DMatrix::identity(n, n);
        for estimate in estimates {
            let first = keys.len();
            for (i, row) in estimate.correlation.iter().enumerate() {
                for (j, r) in row.iter().enumerate() {
                    correlation[(first + i, first + j)] = *r;
                }
            }
            let pairs = estimate.keys.iter().zip(&estimate.standard_errors);
            keys.extend(
                pairs.map(|(key, &standard_error)| UncertainKey {
                    key: key.clone(),
                    standard_error,
                }),
            );
        }
        keys.iter().any(|key| key.standard_error > 0.0).then_some(Uncertainty { keys, correlation })
    }

    /// Checks what the study says of its uncertain numbers.
    pub(super) fn validate_uncertainty(&self, tree: &Value, problems: &mut Problems) {
        let law = &self.driver.curve_speed;
        let mut seen = BTreeSet::new();
        if law.parameter_uncertainty {
            seen.extend(of_curve_speed(law).keys);
        }
        for (name, estimates) in &self.uncertainty {
            problems.part(name, |problems| estimates.validate(tree, &mut seen, problems));
        }
    }
}

/// A study on both sides of one of its uncertain numbers.
#[derive(Clone, Debug)]
pub struct Sides {
    /// With the number smaller by one standard error, or by what is allowed of it.
    pub low: Study,
    /// With it larger.
    pub high: Study,
    /// How far the sides are apart, in standard errors: 2 where both may be a whole one away.
    pub apart: f64,
}

/// How often a side comes half as near where it is not allowed.
const MOST_HALVINGS: i32 = 10;

impl Study {
    /// Checks that each uncertain number of the study has another value that is allowed.
    ///
    /// # Errors
    /// [`StudyError`] where one has none, as one of several shares whose sum is 1.
    pub fn check_sides(&self) -> Result<(), StudyError> {
        let keys = self.model.uncertain().map_or(Vec::new(), |uncertain| uncertain.keys);
        let mut uncertain = keys.iter().filter(|key| key.standard_error > 0.0);
        uncertain.try_for_each(|key| self.sides(key).map(|_| ()))
    }

    /// The study on both sides of one of its uncertain numbers; the number itself is a side where a
    /// bound leaves no room.
    ///
    /// # Errors
    /// [`StudyError`] where no other number is allowed.
    pub fn sides(
        &self,
        UncertainKey { key, standard_error }: &UncertainKey,
    ) -> Result<Sides, StudyError> {
        let nearest = |sign: f64| {
            let steps = (0..MOST_HALVINGS).map(|k| sign * libm::ldexp(1.0, -k));
            let mut sides = steps.map(|step| Ok((self.shifted(key, step * standard_error)?, step)));
            sides.find(Result::is_ok)
        };
        match (nearest(-1.0), nearest(1.0)) {
            (None, None) => Err(self
                .shifted(key, *standard_error)
                .err()
                .unwrap_or(StudyError { problems: Vec::new() })),
            (low, high) => {
                let itself = || Ok((self.shifted(key, 0.0)?, 0.0));
                let (low, a): (Study, f64) = low.unwrap_or_else(itself)?;
                let (high, b): (Study, f64) = high.unwrap_or_else(itself)?;
                Ok(Sides { low, high, apart: b - a })
            }
        }
    }

    /// The study with one of its numbers, or all numbers of one of its lists, larger by so much,
    /// and its law of curve speeds taken for certain.
    ///
    /// # Errors
    /// [`StudyError`] where such a number is not allowed.
    fn shifted(&self, key: &str, by: f64) -> Result<Self, StudyError> {
        let mut tree = self.model().to_tree();
        if let Some(share) = Share::of(key).filter(|share| share.number_in(&tree) > 0) {
            share.shift(&mut tree, by);
        } else {
            let value = tree.pointer_mut(&pointer(key));
            shift(value.expect("checked: the study has the key"), by);
        }
        let mut model = StudyModel::from_tree(&tree).expect("a number in the place of another");
        model.driver.curve_speed.parameter_uncertainty = false;
        self.with_model(model)
    }
}

/// Lists and tables of shares whose sum stays the same.
const SHARES: [&str; 4] = ["weights", "next", "ground", "share"];

/// One of several shares.
struct Share<'a> {
    /// Path of the list or table.
    around: &'a str,
    /// Place or name in it; of a list as a whole the first place.
    place: &'a str,
}

impl<'a> Share<'a> {
    /// The share of a path; none where the path leads to something else.
    fn of(key: &'a str) -> Option<Self> {
        let is_around =
            |path: &str| SHARES.contains(&path.rsplit_once('.').map_or(path, |(_, name)| name));
        if is_around(key) {
            return Some(Self { around: key, place: "0" });
        }
        let (around, place) = key.rsplit_once('.')?;
        is_around(around).then_some(Self { around, place })
    }

    /// How many shares there are; 0 where this is no list or table of them.
    fn number_in(&self, tree: &Value) -> usize {
        match tree.pointer(&pointer(self.around)) {
            Some(Value::Array(items)) => items.len(),
            Some(Value::Object(items)) => items.len(),
            _ => 0,
        }
    }

    /// Makes the share larger by so much; the others give way in proportion.
    fn shift(&self, tree: &mut Value, by: f64) {
        let mut shares: Vec<(String, &mut Value)> = match tree.pointer_mut(&pointer(self.around)) {
            Some(Value::Array(items)) => {
                items.iter_mut().enumerate().map(|(k, item)| (k.to_string(), item)).collect()
            }
            Some(Value::Object(items)) => {
                items.iter_mut().map(|(name, item)| (name.clone(), item)).collect()
            }
            _ => Vec::new(),
        };
        let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
        let own = shares.iter().find(|(name, _)| *name == self.place);
        let own = own.map_or(f64::NAN, |(_, value)| number(value));
        let rest = shares.iter().map(|(_, value)| number(value)).sum::<f64>() - own;
        for (name, value) in &mut shares {
            let less = if *name == self.place { -by } else { by * number(value) / rest };
            shift(value, -less);
        }
    }
}

/// The list or table of shares to one of which a path leads, and how many there are; none
/// elsewhere.
pub fn shares_around<'a>(study: &Value, key: &'a str) -> Option<(&'a str, usize)> {
    let share = Share::of(key)?;
    let count = share.number_in(study);
    (count > 0).then_some((share.around, count))
}

/// Whether two paths lead to the same numbers, or one to a part of the other's.
fn same_or_part(a: &str, b: &str) -> bool {
    let below = |long: &str, short: &str| {
        long.strip_prefix(short).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    below(a, b) || below(b, a)
}

/// The JSON pointer of a dotted path.
fn pointer(path: &str) -> String {
    format!("/{}", path.replace('.', "/"))
}

/// Whether this is a number with a fraction, or a list of them.
fn is_number(value: &Value) -> bool {
    match value {
        Value::Number(number) => number.is_f64(),
        Value::Array(items) => !items.is_empty() && items.iter().all(is_number),
        _ => false,
    }
}

fn shift(value: &mut Value, by: f64) {
    match value {
        Value::Number(number) => {
            let sum = number.as_f64().unwrap_or(f64::NAN) + by;
            // what is not finite is refused as a number out of its bounds
            *value = Number::from_f64(sum).map_or(Value::from(f64::MAX), Value::Number);
        }
        Value::Array(items) => items.iter_mut().for_each(|item| shift(item, by)),
        _ => {}
    }
}
