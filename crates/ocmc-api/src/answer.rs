//! Parts that all answers have in common.

use serde::Serialize;

/// An answer, in the forms for programs and for people.
pub trait Answer: Serialize {
    /// For people, with a line end.
    fn text(&self) -> String;

    /// Warnings: facts that do not stop the answer and have to be known.
    fn warnings(&self) -> Vec<String> {
        Vec::new()
    }

    /// Notes on the inputs that were read, in a few lines.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// For programs: JSON on one line.
    fn to_json(&self) -> String {
        serde_json::to_string(self).expect("numbers, and keys that are words")
    }

    /// For programs and people: indented JSON, with a line end.
    fn to_indented_json(&self) -> String {
        let text = serde_json::to_string_pretty(self).expect("numbers, and keys that are words");
        format!("{text}\n")
    }
}
