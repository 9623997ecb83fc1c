//! Fitted values as a study file that differs from another one in them alone.

use super::StudyFileError;
use super::load_text;
use ocmc_core::study::StudyModel;
use serde::Serialize;
use std::path::Path;
use toml::{Table, Value};

/// Significant digits of written numbers: more than any fit determines, and enough for shares to sum up to 1.
const DIGITS: usize = 8;

/// Fitted values under their keys, such as `[driver.curve_speed]`, as TOML to paste into a study.
///
/// Numbers are rounded to eight digits.
pub fn fitted_text(path: &[&str], value: &impl Serialize) -> String {
    toml::to_string(&fitted(path, value)).expect("a study is tables, lists, numbers and words")
}

/// As [`fitted_text`], as JSON.
pub fn fitted_json(path: &[&str], value: &impl Serialize) -> serde_json::Value {
    serde_json::to_value(fitted(path, value)).expect("a study is tables, lists, numbers and words")
}

fn fitted(path: &[&str], value: &impl Serialize) -> Table {
    let mut value = Value::try_from(value).expect("a study is tables, lists, numbers and words");
    round(&mut value);
    for key in path.iter().rev() {
        value = Value::Table(Table::from_iter([((*key).to_owned(), value)]));
    }
    match value {
        Value::Table(table) => table,
        _ => Table::new(),
    }
}

/// A whole study file: `base` with fitted values laid over it, `note` on top.
///
/// # Errors
/// [`StudyFileError`] where the values do not make a study, such as a fitted value out of its range.
pub fn fitted_study(
    base: &str,
    name: &str,
    note: &str,
    values: &str,
) -> Result<(String, StudyModel), StudyFileError> {
    let base = match Path::new(base).canonicalize() {
        Ok(file) if super::builtin::STUDIES.iter().all(|built_in| built_in.name != base) => {
            file.to_string_lossy().into_owned()
        }
        _ => base.to_owned(),
    };
    let study = Table::from_iter([
        ("base".to_owned(), Value::String(base)),
        ("name".to_owned(), Value::String(name.to_owned())),
    ]);
    let head = Table::from_iter([("study".to_owned(), Value::Table(study))]);
    let head = toml::to_string(&head).expect("a table of words");
    let text = format!("# {note}\n\n{head}\n{values}");
    let loaded = load_text("the fitted study", &text, &[] as &[&str])?;
    Ok((text, loaded.model))
}

fn round(value: &mut Value) {
    match value {
        Value::Float(number) => {
            *number = format!("{number:.*e}", DIGITS - 1).parse().unwrap_or(*number);
        }
        Value::Array(values) => values.iter_mut().for_each(round),
        Value::Table(table) => table.iter_mut().for_each(|(_, value)| round(value)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fitted_value_is_laid_over_its_base() {
        let text = fitted_text(
            &["driver", "curve_speed"],
            &Table::from_iter([("exponent".to_owned(), Value::Float(0.123456789))]),
        );
        assert_eq!(text, "[driver.curve_speed]\nexponent = 0.12345679\n");
        let (study, model) = fitted_study("field-truck", "mine", "a note", &text).unwrap();
        assert_eq!(model.driver.curve_speed.exponent, 0.12345679);
        assert_eq!(model.study.name, "mine");
        assert!(study.starts_with("# a note\n\n[study]\nbase = \"field-truck\""), "{study}");
        let wild = text.replace("0.12345679", "-7.0");
        let error = fitted_study("field-truck", "mine", "a note", &wild).unwrap_err();
        assert!(error.to_string().contains("exponent"), "{error}");
    }
}
