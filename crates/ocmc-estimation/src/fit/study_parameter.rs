//! The numbers of a study that measurements determine.

use serde::Serialize;
use std::fmt::Display;

/// One estimated number of the study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudyParameterFit {
    /// Path of the key below the road type, such as `curves.per_m`.
    pub key: String,
    /// Estimate.
    pub value: f64,
    /// Standard error; none where it has no simple form.
    pub standard_error: Option<f64>,
    /// Number of stretches, signs, events, curves, steps or blocks that were counted.
    pub n: usize,
}

/// Estimates while they are made.
#[derive(Debug, Default)]
pub(super) struct Estimates<'a> {
    pub parameters: Vec<StudyParameterFit>,
    /// Facts that do not stop the fit and have to be known.
    pub warnings: Vec<String>,
    /// Name of what is estimated now: the head of its warnings.
    pub name: &'a str,
}

impl Estimates<'_> {
    pub(super) fn push(&mut self, key: &str, value: f64, standard_error: Option<f64>, n: usize) {
        self.parameters.push(StudyParameterFit { key: key.to_owned(), value, standard_error, n });
    }

    /// An estimate that replaces the base study's number.
    pub(super) fn set(
        &mut self,
        key: &str,
        into: &mut f64,
        value: f64,
        standard_error: Option<f64>,
        n: usize,
    ) {
        *into = value;
        self.push(key, value, standard_error, n);
    }

    /// A share of `n` trials.
    pub(super) fn share(&mut self, key: &str, into: &mut f64, count: usize, n: usize) {
        let share = count as f64 / n as f64;
        let error = libm::sqrt(share * (1.0 - share) / n as f64);
        self.set(key, into, share, Some(error), n);
    }

    pub(super) fn warn(&mut self, message: impl Display) {
        self.warnings.push(format!("{}: {message}", self.name));
    }

    /// Says why the base study's numbers stay.
    pub(super) fn stays(&mut self, why: impl Display) {
        self.warn(format!("{why}; it stays that of the base study"));
    }
}

/// Why nothing was estimated.
pub(super) fn reasons(warnings: &[String]) -> String {
    warnings.join("; ").replace("; it stays that of the base study", "")
}
