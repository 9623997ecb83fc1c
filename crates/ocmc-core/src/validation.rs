//! Faults of a part of a study, collected by the rules beside its model.

use std::fmt;

/// One thing that is wrong with a study.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{path}` is {value}, allowed is {allowed}")]
pub struct Problem {
    /// Full path of the key.
    pub path: String,
    /// Its value.
    pub value: String,
    /// Allowed values.
    pub allowed: String,
}

/// Collects the problems of a study, part by part.
#[derive(Debug, Default)]
pub struct Problems {
    /// Path of the part whose rules are applied.
    part: String,
    problems: Vec<Problem>,
}

impl Problems {
    /// Applies the rules of a part; the keys that they name lie below `key`.
    pub fn part(&mut self, key: &str, rules: impl FnOnce(&mut Self)) {
        let above = self.part.len();
        self.part = path(&self.part, key);
        rules(self);
        self.part.truncate(above);
    }

    /// Looks at a part that may be absent.
    pub fn part_if<T>(&mut self, key: &str, part: Option<&T>, rules: impl FnOnce(&T, &mut Self)) {
        if let Some(part) = part {
            self.part(key, |problems| rules(part, problems));
        }
    }

    /// Notes a key whose rule does not hold.
    pub fn require(&mut self, holds: bool, key: &str, value: impl fmt::Display, allowed: &str) {
        if !holds {
            self.problems.push(Problem {
                path: path(&self.part, key),
                value: value.to_string(),
                allowed: allowed.to_owned(),
            });
        }
    }

    /// Notes shares whose sum, which is given, is not one.
    pub fn require_sum_of_one(&mut self, key: &str, sum: f64) {
        self.require((sum - 1.0).abs() < 1e-6, key, format!("a sum of {sum}"), "a sum of 1");
    }

    /// Problems that were found.
    pub fn into_problems(self) -> Vec<Problem> {
        self.problems
    }
}

/// Path of a key of a part; the study itself and a part itself have an empty one.
fn path(part: &str, key: &str) -> String {
    if part.is_empty() || key.is_empty() {
        return format!("{part}{key}");
    }
    format!("{part}.{key}")
}

/// Whether numbers rise.
pub fn rises(numbers: &[f64]) -> bool {
    numbers.windows(2).all(|pair| pair[0] < pair[1])
}
