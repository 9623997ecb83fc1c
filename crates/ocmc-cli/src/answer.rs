//! What a command answers: the same for the command line and for a calling program.

use serde_json::Value;

/// An answer in both forms, and what has to be known beside it.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// For programs.
    pub json: Value,
    /// For people.
    pub text: String,
    /// What does not stop the answer and has to be known.
    pub warnings: Vec<String>,
}
