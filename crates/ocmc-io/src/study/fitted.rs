//! Fitted values as a part of a study, and as a study file that differs from another one in them
//! alone.

use super::builtin::STUDIES;
use super::judged::{FITTED, FITTED_FROM, FITTED_KEYS, TABLE};
use super::node::Node;
use super::source::{Source, SourceKind};
use super::{StudyFileError, load_text, resolved_toml};
use ocmc_core::study::uncertainty::{Estimates, shares_around};
use ocmc_core::study::{Problem, Study, StudyModel, outside_bounds};
use serde::Serialize;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use toml::{Table, Value};

/// Significant digits of written numbers: more than any fit determines, and enough for shares to
/// sum up to 1.
const DIGITS: usize = 8;

/// Significant digits of standard errors: no fit knows them better.
const ERROR_DIGITS: usize = 4;

/// Relative difference between an estimate and what is written of it.
const SAME: f64 = 1e-6;

/// An estimated number of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Path of its key.
    pub key: String,
    /// The number.
    pub value: f64,
    /// Its standard error, in its unit.
    pub standard_error: f64,
}

/// Fitted values under their keys, such as `[driver.curve_speed]`, to be laid over a study: those
/// that a study takes.
///
/// Numbers are rounded to eight digits.
#[derive(Clone, Debug)]
pub struct FittedPart {
    values: Table,
    left_out: Vec<Problem>,
}

impl FittedPart {
    /// The values below `path`. What a study would refuse beside the rest of `base` is left out, so
    /// that it stays that of the base, and with it the other numbers of its table: they were
    /// estimated together.
    pub fn new(base: &StudyModel, path: &[&str], value: &impl Serialize) -> Self {
        let mut value =
            Value::try_from(value).expect("a study is tables, lists, numbers and words");
        round(&mut value);
        for key in path.iter().rev() {
            value = Value::Table(Table::from_iter([((*key).to_owned(), value)]));
        }
        let values = if let Value::Table(values) = value { values } else { Table::new() };
        let mut part = Self { values, left_out: Vec::new() };
        // what depends on what was left out is refused only then
        loop {
            let refused = part.refused(base);
            let taken_out =
                refused.iter().filter(|problem| remove(&mut part.values, &problem.path));
            let done = taken_out.count() == 0;
            part.left_out.extend(refused);
            if done {
                return part;
            }
        }
    }

    /// Adds the standard errors as `[uncertainty.NAME]`: those of the numbers that are among the
    /// values, and that a study takes on either side. Of two shares whose sum is 1 the first one
    /// has it; of more the errors go together, and none has one.
    #[must_use]
    pub fn with_errors(
        self,
        base: &StudyModel,
        name: &str,
        estimates: impl IntoIterator<Item = Estimate>,
    ) -> Self {
        self.with_correlated_errors(base, name, estimates, &|_, _| 0.0)
    }

    /// As [`Self::with_errors`], of errors that go together: the correlation of those of two keys.
    #[must_use]
    pub fn with_correlated_errors(
        mut self,
        base: &StudyModel,
        name: &str,
        estimates: impl IntoIterator<Item = Estimate>,
        correlation: &dyn Fn(&str, &str) -> f64,
    ) -> Self {
        let tree = self.tree(base);
        let mut model = Self::study(&tree);
        model.uncertainty.remove(name);
        let mut shares = Vec::new();
        let values = serde_json::to_value(&self.values).expect("tables, lists, numbers and words");
        let is_there = |estimate: &Estimate| {
            let value = values.pointer(&format!("/{}", estimate.key.replace('.', "/")));
            let value = value.and_then(serde_json::Value::as_f64);
            value.is_some_and(|value| (value - estimate.value).abs() <= SAME * value.abs())
        };
        let mut all = Estimates { keys: vec![], standard_errors: vec![], correlation: vec![] };
        for estimate in estimates.into_iter().filter(|e| e.standard_error > 0.0).filter(is_there) {
            let Estimate { key, standard_error, .. } = estimate;
            if let Some((around, count)) = shares_around(&tree, &key) {
                if count > 2 || shares.iter().any(|known| known == around) {
                    continue;
                }
                shares.push(around.to_owned());
            }
            let (keys, standard_errors) = (vec![key], vec![rounded(standard_error, ERROR_DIGITS)]);
            let one = Estimates { keys, standard_errors, correlation: vec![] };
            let with = BTreeMap::from([(name.to_owned(), one.clone())]);
            let uncertainty = with.into_iter().chain(model.uncertainty.clone()).collect();
            let sides = Study::new(StudyModel { uncertainty, ..model.clone() });
            if sides.and_then(|study| study.check_sides()).is_ok() {
                all.keys.extend(one.keys);
                all.standard_errors.extend(one.standard_errors);
            }
        }
        let row = |a: &String| -> Vec<f64> {
            let one =
                |b: &String| if a == b { 1.0 } else { rounded(correlation(a, b), ERROR_DIGITS) };
            all.keys.iter().map(one).collect()
        };
        let rows: Vec<Vec<f64>> = all.keys.iter().map(row).collect();
        let independent = rows.iter().flatten().filter(|r| **r != 0.0).count() == rows.len();
        all.correlation = if independent { Vec::new() } else { rows };
        if !all.keys.is_empty() {
            let errors = Value::try_from(BTreeMap::from([(name, all)]));
            let errors = errors.expect("lists of words and numbers");
            self.values.insert("uncertainty".to_owned(), errors);
        }
        self
    }

    /// The base with these values.
    fn tree(&self, base: &StudyModel) -> serde_json::Value {
        let mut tree = tree(resolved_toml(base));
        tree.overlay(self::tree(self.text())).expect("a fit replaces lists as a whole");
        tree.to_json()
    }

    /// The study that a tree of these values describes.
    fn study(tree: &serde_json::Value) -> StudyModel {
        StudyModel::from_tree(tree).expect("keys of a study over a study")
    }

    /// Problems for which a study with these values would be refused.
    fn refused(&self, base: &StudyModel) -> Vec<Problem> {
        let tree = self.tree(base);
        let outside = outside_bounds(&tree);
        if !outside.is_empty() {
            return outside;
        }
        Study::new(Self::study(&tree)).err().map_or_else(Vec::new, |error| error.problems)
    }

    /// As TOML, to paste into a study.
    pub fn text(&self) -> String {
        toml::to_string(&self.values).expect("a study is tables, lists, numbers and words")
    }

    /// As JSON.
    pub fn json(&self) -> serde_json::Value {
        serde_json::to_value(&self.values).expect("a study is tables, lists, numbers and words")
    }

    /// Parts that were left out, in words.
    pub fn warnings(&self) -> impl Iterator<Item = String> + '_ {
        self.left_out.iter().map(|problem| {
            format!(
                "{problem}: no study takes the estimate; it and the numbers that were estimated \
                 with it stay those of the base study"
            )
        })
    }
}

/// The tree of a study's text that was written here.
fn tree(text: String) -> Node {
    let source = Source { kind: SourceKind::File, name: "fitted".into(), text };
    Node::parse(&Arc::new(source)).expect("a study as it is written")
}

/// Takes a key out, or the law or the table of lists that it belongs to, with a number all numbers
/// of its table; whether it was there.
fn remove(values: &mut Table, path: &str) -> bool {
    let (first, rest) = path.split_once('.').unwrap_or((path, ""));
    match values.get_mut(first) {
        None => false,
        Some(Value::Table(below)) if !rest.is_empty() && !is_whole(below) => remove(below, rest),
        Some(Value::Float(_) | Value::Integer(_)) => {
            values.retain(|_, value| !matches!(value, Value::Float(_) | Value::Integer(_)));
            true
        }
        Some(_) => values.remove(first).is_some(),
    }
}

/// A part of a study, which command has fitted it, and from what.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyPart {
    /// The command.
    pub command: &'static str,
    /// Names of its sources.
    pub sources: String,
    /// The values ([`FittedPart::json`]).
    pub values: serde_json::Value,
}

/// The paths of the values of a part of a study: laws and lists as a whole.
fn paths(values: &serde_json::Value) -> Vec<String> {
    let serde_json::Value::Object(table) = values else { return Vec::new() };
    let below = |(key, value): (&String, &serde_json::Value)| match value {
        serde_json::Value::Object(below) if !below.contains_key("distribution") => {
            paths(value).into_iter().map(|path| format!("{key}.{path}")).collect()
        }
        _ => vec![key.clone()],
    };
    table.iter().flat_map(below).collect()
}

/// A study file that several commands have written a part of, the last one over those before. The
/// note on top is `command`'s.
///
/// # Errors
/// As [`fitted_study`].
pub fn study_of_parts(
    base: &str,
    name: &str,
    (command, sources): (&str, &str),
    parts: &[StudyPart],
) -> Result<(String, StudyModel), StudyFileError> {
    let mut values = tree(String::new());
    let mut fitted = serde_json::Map::new();
    for part in parts {
        values.overlay(Node::from_json(&part.values)?)?;
        let keys = paths(&part.values);
        let entry = json!({ FITTED_FROM: part.sources, FITTED_KEYS: keys });
        // what a later part writes is no longer of one before
        for earlier in fitted.values_mut() {
            let kept = earlier[FITTED_KEYS].as_array_mut().expect("a list of keys");
            kept.retain(|key| !keys.iter().any(|own| key == own));
        }
        fitted.insert(part.command.to_owned(), entry);
    }
    written(
        base,
        name,
        (command, sources),
        &values.to_json(),
        &json!({ TABLE: { FITTED: fitted } }),
    )
}

/// A whole study file: `base` with fitted values ([`FittedPart::json`]) laid over it. A note on top
/// and `judged.fitted` say which command has fitted them from what.
///
/// # Errors
/// [`StudyFileError`] where the values do not make a study, such as a fitted value out of its
/// range.
pub fn fitted_study(
    base: &str,
    name: &str,
    (command, sources): (&str, &str),
    values: &serde_json::Value,
) -> Result<(String, StudyModel), StudyFileError> {
    let fitted = json!({ TABLE: { FITTED: { command: sources } } });
    written(base, name, (command, sources), values, &fitted)
}

fn written(
    base: &str,
    name: &str,
    (command, sources): (&str, &str),
    values: &serde_json::Value,
    fitted: &serde_json::Value,
) -> Result<(String, StudyModel), StudyFileError> {
    let base = match Path::new(base).canonicalize() {
        Ok(file) if STUDIES.iter().all(|built_in| built_in.name != base) => {
            file.to_string_lossy().into_owned()
        }
        _ => base.to_owned(),
    };
    let head = toml::to_string(&json!({ "study": { "base": base, "name": name } }));
    let head = head.expect("a table of words");
    let values = toml::to_string(values).expect("a study is tables, lists, numbers and words");
    let fitted = toml::to_string(fitted).expect("a table of words");
    let note = format!("# Written by `ocmc {command}` from {sources}.");
    let text = format!("{note}\n\n{head}\n{values}\n{fitted}");
    let loaded = load_text("the fitted study", &text, &[] as &[&str])?;
    Ok((text, loaded.model))
}

/// Whether a table makes sense as a whole only: a law, or lists with a row in common.
fn is_whole(table: &Table) -> bool {
    table.contains_key("distribution") || table.values().all(Value::is_array)
}

/// A number with so many significant digits.
fn rounded(number: f64, digits: usize) -> f64 {
    format!("{number:.*e}", digits - 1).parse().unwrap_or(number)
}

fn round(value: &mut Value) {
    match value {
        Value::Float(number) => {
            *number = rounded(*number, DIGITS);
        }
        Value::Array(values) => values.iter_mut().for_each(round),
        Value::Table(table) => table.iter_mut().for_each(|(_, value)| round(value)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::distribution::{Law, Quantity};

    const BY: (&str, &str) = ("fit something", "203 rows of `curves.csv`");

    fn field_truck() -> StudyModel {
        crate::study::load("field-truck", &[] as &[&str]).unwrap().model
    }

    #[test]
    fn a_fitted_value_is_laid_over_its_base() {
        let value = Table::from_iter([("exponent".to_owned(), Value::Float(0.123456789))]);
        let part = FittedPart::new(&field_truck(), &["driver", "curve_speed"], &value);
        let (text, mut json) = (part.text(), part.json());
        assert_eq!(text, "[driver.curve_speed]\nexponent = 0.12345679\n");
        let (study, model) = fitted_study("field-truck", "mine", BY, &json).unwrap();
        assert_eq!(model.driver.curve_speed.exponent, 0.12345679);
        assert_eq!(model.study.name, "mine");
        let head = "# Written by `ocmc fit something` from 203 rows of `curves.csv`.\n\n[study]\n\
                    base = \"field-truck\"";
        assert!(study.starts_with(head), "{study}");
        assert!(study.contains("[judged.fitted]\n\"fit something\" = \"203 rows"), "{study}");
        json["driver"]["curve_speed"]["exponent"] = (-7.0).into();
        let error = fitted_study("field-truck", "mine", BY, &json).unwrap_err();
        assert!(error.to_string().contains("exponent"), "{error}");
    }
    #[test]
    fn errors_of_numbers_that_are_written_and_have_two_sides_are_written() {
        let base = field_truck();
        let mut weather = base.weather.clone();
        weather.temperature.mean_k = 281.5;
        let estimate = |key: &str, value: f64, standard_error: f64| Estimate {
            key: key.to_owned(),
            value,
            standard_error,
        };
        let mean_k = estimate("weather.temperature.mean_k", 281.5, 0.123456);
        let part = FittedPart::new(&base, &["weather"], &weather).with_errors(
            &base,
            "weather",
            [
                mean_k,
                // of another number, without an error, of none, and not among the values
                estimate("weather.temperature.daily_sd_k", -1.0, 0.1),
                estimate("weather.wind.speed_shape", weather.wind.speed_shape, 0.0),
                estimate("weather.nothing, mean", 1.0, 0.1),
                estimate("traffic.step_correlation", 1.0, 0.1),
            ],
        );
        let (_, model) = fitted_study("field-truck", "mine", BY, &part.json()).unwrap();
        let uncertain = model.uncertain().expect("one number");
        let errors: Vec<(&str, f64)> =
            uncertain.keys.iter().map(|key| (key.key.as_str(), key.standard_error)).collect();
        assert_eq!(errors, [("weather.temperature.mean_k", 0.1235)]);

        // of two shares whose sum is 1 one says it all, of five none does
        let road = &base.road.types;
        let (next, signs) = (&road["urban"].next, &road["urban"].speed_signs.share);
        let part = FittedPart::new(&base, &["road", "types"], road);
        let shares = [
            estimate("road.types.urban.next.motorway", next["motorway"], 0.05),
            estimate("road.types.urban.next.rural", next["rural"], 0.05),
            estimate("road.types.urban.speed_signs.share.0", signs[0], 0.02),
        ];
        let part = part.with_errors(&base, "road", shares);
        let keys = &part.json()["uncertainty"]["road"]["keys"];
        assert_eq!(*keys, json!(["road.types.urban.next.motorway"]));
    }

    #[test]
    fn what_a_study_refuses_is_left_out_and_named() {
        let base = field_truck();
        let mut weather = base.weather.clone();
        weather.temperature.mean_k = 281.5;
        weather.temperature.summer_sd_k = -1.0;
        weather.wind.speed_shape = f64::NAN;
        let part = FittedPart::new(&base, &["weather"], &weather);
        let message: Vec<String> = part.warnings().collect();
        assert_eq!(message.len(), 2, "{message:?}");
        assert!(
            message[0].starts_with("`weather.temperature.summer_sd_k` is -1, allowed is 0 to 20")
        );
        assert!(message[1].starts_with("`weather.wind.speed_shape` is not a finite number"));
        // the numbers beside it were estimated with it; those of other tables were not
        let left = &part.json()["weather"];
        assert!(left["temperature"].get("summer_sd_k").is_none());
        assert!(left["temperature"].get("mean_k").is_none());
        assert_eq!(left["pressure"]["sd"], base.weather.pressure.sd);
        fitted_study("field-truck", "mine", BY, &part.json()).unwrap();

        // a table of lists is left out as a whole
        let mut driver = base.driver.curve_speed.clone();
        driver.table.as_mut().unwrap().exponent[0] = -0.1;
        let part = FittedPart::new(&base, &["driver", "curve_speed"], &driver);
        let message: Vec<String> = part.warnings().collect();
        assert!(
            message.len() == 1 && message[0].contains("table.exponent` is -0.1"),
            "{message:?}"
        );
        assert!(part.json()["driver"]["curve_speed"].get("table").is_none());

        // a law is left out as a whole, and so is what does not fit the rest of the study
        let mut road = base.road.types.clone();
        let rural = road.get_mut("rural").unwrap();
        rural.stop_signs.standstill_s = Quantity::Law(Law::Exponential { mean: 1e5 });
        rural.topography.hill_length_m = 80.0;
        let part = FittedPart::new(&base, &["road", "types"], &road);
        let message: Vec<String> = part.warnings().collect();
        assert!(
            message.len() == 2
                && message[0].contains("draws")
                && message[1].contains("above 4 times"),
            "{message:?}"
        );
        let left = &part.json()["road"]["types"]["rural"];
        assert!(left["stop_signs"].get("standstill_s").is_none());
        assert!(left["topography"].get("hill_length_m").is_none());
        assert!(left["topography"].get("slope_sd").is_none());
        assert!(left["curves"].get("per_m").is_some());
    }
}
