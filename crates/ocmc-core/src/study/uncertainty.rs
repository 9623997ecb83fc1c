//! How uncertain the numbers of a study are: standard errors of estimates, and how the errors go
//! together.
//!
//! Any number of a study may be an estimate. `[uncertainty.NAME]` lists the keys of one estimation
//! with their standard errors and the correlation of their errors; errors of different estimations
//! are independent. The law of curve speeds has keys of its own for it, because its forms `table`
//! and `bivariate` are uncertain as their trucks are few: the errors of the mean exponent and the
//! mean speed of n trucks have the covariance of the trucks, divided by n.

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

impl Estimates {
    fn validate(&self, study: &Value, seen: &mut BTreeSet<String>, problems: &mut Problems) {
        let n = self.keys.len();
        problems.require(n > 0, "keys", "an empty list", "at least one key of the study");
        for key in &self.keys {
            let model = !["simulation.", "uncertainty.", "cost.", "emissions."]
                .iter()
                .any(|head| key.starts_with(head));
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
        correlation: Vec::new(),
    }
}

impl StudyModel {
    /// What the study says of its uncertain numbers; none where it takes all for certain.
    pub fn uncertain(&self) -> Option<Uncertainty> {
        let law = &self.driver.curve_speed;
        let law = law.parameter_uncertainty.then(|| of_curve_speed(law));
        let estimates: Vec<&Estimates> = law.iter().chain(self.uncertainty.values()).collect();
        let mut keys = Vec::new();
        let n = estimates.iter().map(|of| of.keys.len()).sum();
        let mut correlation = DMatrix::identity(n, n);
        for of in estimates {
            let first = keys.len();
            for (i, row) in of.correlation.iter().enumerate() {
                for (j, r) in row.iter().enumerate() {
                    correlation[(first + i, first + j)] = *r;
                }
            }
            let pairs = of.keys.iter().zip(&of.standard_errors);
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
        let value = tree.pointer_mut(&pointer(key)).expect("checked: the study has the key");
        shift(value, by);
        let mut model = StudyModel::from_tree(&tree).expect("a number in the place of another");
        model.driver.curve_speed.parameter_uncertainty = false;
        self.with_model(model)
    }
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
