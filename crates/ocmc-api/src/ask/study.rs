//! Contents of a study: its keys, the text of its file, and its differences from another one.

use super::opened;
use super::question::AskedStudy;
use crate::error::Error;
use crate::study::{Files, LoadedStudy};
use ocmc_io::study::{KeyDifference, differences, study_text};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};

/// A law of a study is one value.
const LAW: &str = "distribution";

/// Contents of a study.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct StudyAnswer {
    /// Its name.
    pub name: String,
    /// Its description.
    pub description: String,
    /// Text of a study file that answers the same, beside the files that it names.
    pub toml: String,
    /// Its resolved keys by their dotted paths; a law is one value.
    pub values: Map<String, Value>,
    /// Keys in which it differs from the study that it is compared with, what differs most first.
    pub differences: Vec<KeyDifference>,
}

/// Reads a study, and compares it with another one.
///
/// # Errors
/// [`Error::Study`] where one of them is none.
pub fn study_answer(
    study: &AskedStudy,
    against: Option<&AskedStudy>,
    files: &Files,
) -> Result<StudyAnswer, Error> {
    let loaded = opened(study, files)?;
    let LoadedStudy { model, .. } = &loaded;
    let against = against.map(|other| opened(other, files)).transpose()?;
    let mut values = Map::new();
    flatten("", model.to_tree(), &mut values);
    Ok(StudyAnswer {
        name: model.study.name.clone(),
        description: model.study.description.clone(),
        toml: study_text(&loaded.own()),
        values,
        differences: against.map_or(Vec::new(), |other| differences(&other.model, model)),
    })
}

/// The values of a tree by their paths.
fn flatten(path: &str, value: Value, into: &mut Map<String, Value>) {
    match value {
        Value::Object(table) if !table.contains_key(LAW) => {
            for (key, value) in table {
                let path = if path.is_empty() { key } else { format!("{path}.{key}") };
                flatten(&path, value, into);
            }
        }
        value => drop(into.insert(path.to_owned(), value)),
    }
}

/// A study's keys with others laid over them, table by table; laws and lists are replaced.
pub(super) fn laid_over(own: &mut Value, part: &Value) {
    match (own, part) {
        (Value::Object(own), Value::Object(part))
            if !own.contains_key(LAW) && !part.contains_key(LAW) =>
        {
            for (key, value) in part {
                laid_over(own.entry(key).or_insert(Value::Null), value);
            }
        }
        (own, part) => own.clone_from(part),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn laws_are_one_value_and_replaced_as_a_whole() {
        let mut values = Map::new();
        let law = json!({"distribution": "normal", "mean": 1.0});
        flatten("", json!({"a": {"b": 1, "c": law}, "d": [1]}), &mut values);
        assert_eq!(Value::Object(values), json!({"a.b": 1, "a.c": law, "d": [1]}));
        let mut own = json!({"a": {"b": 1, "c": law}});
        laid_over(&mut own, &json!({"a": {"c": {"distribution": "constant", "value": 2}}, "e": 3}));
        let constant = json!({"distribution": "constant", "value": 2});
        assert_eq!(own, json!({"a": {"b": 1, "c": constant}, "e": 3}));
    }
}
