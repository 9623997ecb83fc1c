//! A finding of a check, and how it ends.

use schemars::JsonSchema;
use serde::Serialize;
use std::fmt;

/// How a check ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// The file is not used.
    Refused,
    /// The file is used as it is, and the answer may be wrong.
    Warned,
    /// The file is used as it is, and what is found is worth knowing.
    Noted,
    /// The file is made up for what was found, and the answer is right.
    Mended,
}

/// A finding of a check in a file.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Finding {
    /// Name of the check, such as `sparse-points`.
    pub check: &'static str,
    /// How it ends.
    pub end: End,
    /// The figure that is compared, in the unit that the text has.
    pub figure: f64,
    /// The bound that it is compared with.
    pub bound: f64,
    /// The finding in words, with its figures.
    pub text: String,
    /// The remedy in words; empty where there is nothing to do.
    pub remedy: String,
}

impl Finding {
    /// A finding that warns.
    pub fn warned(
        check: &'static str,
        [figure, bound]: [f64; 2],
        text: String,
        remedy: &str,
    ) -> Self {
        Self { check, end: End::Warned, figure, bound, text, remedy: remedy.to_owned() }
    }

    /// A finding that was made up for.
    pub fn mended(check: &'static str, [figure, bound]: [f64; 2], text: String) -> Self {
        Self { check, end: End::Mended, figure, bound, text, remedy: String::new() }
    }

    /// A finding that is worth knowing.
    pub fn noted(
        check: &'static str,
        [figure, bound]: [f64; 2],
        text: String,
        remedy: &str,
    ) -> Self {
        Self { check, end: End::Noted, figure, bound, text, remedy: remedy.to_owned() }
    }

    /// A finding for which the file is refused.
    pub fn refused(
        check: &'static str,
        [figure, bound]: [f64; 2],
        text: String,
        remedy: &str,
    ) -> Self {
        Self { check, end: End::Refused, figure, bound, text, remedy: remedy.to_owned() }
    }

    /// Whether the file is refused.
    pub fn is_refusal(&self) -> bool {
        self.end == End::Refused
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}", self.text)?;
        if !self.remedy.is_empty() {
            write!(f, ": {}", self.remedy)?;
        }
        write!(f, " [{}]", self.check)
    }
}
