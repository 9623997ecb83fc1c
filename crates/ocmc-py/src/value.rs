//! Values of Python on their way into a study or a plan, hostile ones included: endless, huge or
//! broken ones are errors.

use ocmc_api::{PlaceClock, Word};
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFloat, PyInt, PyList, PyMapping, PyString, PyTuple};
use serde_json::{Number, Value};

/// Deepest nesting of tables and lists, as in a study file.
const MOST_DEPTH: usize = 64;
/// Most values in a dictionary: about what fits in the largest study file.
const MOST_VALUES: usize = 1_000_000;
/// Longest value that a message shows, in characters.
const SHOWN_VALUE: usize = 60;

/// The clock of a place, by the hours by which its standard time is ahead of UTC, or by its zone.
pub(crate) fn place_clock(
    utc_offset_h: Option<f64>,
    zone: Option<&str>,
) -> PyResult<Option<PlaceClock>> {
    let (name, clock, shown) = match (utc_offset_h, zone) {
        (None, None) => return Ok(None),
        (Some(_), Some(_)) => {
            return Err(PyValueError::new_err("give `utc_offset_h` or `zone`, not both"));
        }
        (Some(hours), None) => ("utc_offset_h", PlaceClock::ahead(hours), hours.to_string()),
        (None, Some(zone)) => ("zone", PlaceClock::zone(zone), zone.to_owned()),
    };
    let message = |allowed| PyValueError::new_err(format!("`{name}` is {shown}, {allowed}"));
    clock.map(Some).map_err(message)
}

/// A dictionary, a list or a scalar as a value of a study. `key` is its path in messages.
pub(crate) fn study_value(value: &Bound<PyAny>, key: &str) -> PyResult<Value> {
    convert(value, key, 0, &mut 0)
}

fn convert(value: &Bound<PyAny>, key: &str, depth: usize, count: &mut usize) -> PyResult<Value> {
    *count += 1;
    if depth > MOST_DEPTH {
        let text = format!("tables are nested more than {MOST_DEPTH} deep");
        return Err(PyValueError::new_err(text));
    }
    if *count > MOST_VALUES {
        let text = format!("a study with more than {MOST_VALUES} values");
        return Err(PyValueError::new_err(text));
    }
    if let Ok(word) = value.cast::<PyString>() {
        return Ok(Value::String(word.extract()?));
    }
    if let Ok(truth) = value.cast::<PyBool>() {
        return Ok(Value::Bool(truth.is_true()));
    }
    if value.is_instance_of::<PyInt>()
        && let Ok(integer) = value.extract::<i64>()
    {
        return Ok(Value::Number(integer.into()));
    }
    if value.is_instance_of::<PyInt>() || value.is_instance_of::<PyFloat>() {
        let number = value.extract::<f64>().ok().and_then(Number::from_f64);
        let number = number.ok_or_else(|| not_allowed(value, key, "a finite number"))?;
        return Ok(Value::Number(number));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let items = value.try_iter()?.enumerate();
        let items =
            items.map(|(k, item)| convert(&item?, &format!("{key}[{k}]"), depth + 1, count));
        return Ok(Value::Array(items.collect::<PyResult<_>>()?));
    }
    if let Ok(mapping) = value.cast::<PyMapping>() {
        let mut table = serde_json::Map::new();
        for pair in mapping.items()? {
            let (name, below) = pair.extract::<(Bound<PyAny>, Bound<PyAny>)>()?;
            let Ok(name) = name.extract::<String>() else {
                let place = if key.is_empty() { "the dictionary" } else { key };
                return Err(not_allowed(&name, &format!("a key of {place}"), "a text"));
            };
            let path = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
            table.insert(name, convert(&below, &path, depth + 1, count)?);
        }
        return Ok(Value::Object(table));
    }
    // arrays and scalars of numpy
    if let Ok(method) = value.getattr("tolist") {
        return convert(&method.call0()?, key, depth + 1, count);
    }
    let allowed = "a number, a text, true or false, a list or a table";
    Err(not_allowed(value, key, allowed))
}

/// A whole number within a range. `name` is the argument.
pub(crate) fn whole_number(
    value: &Bound<PyAny>,
    name: &str,
    lowest: u64,
    highest: u64,
) -> PyResult<u64> {
    let allowed = || format!("a whole number from {lowest} to {highest}");
    match value.extract::<u64>() {
        Ok(number) if (lowest..=highest).contains(&number) => Ok(number),
        Err(error) if !error.is_instance_of::<PyOverflowError>(value.py()) => {
            Err(wrong_type(value, name, &allowed()))
        }
        _ => Err(not_allowed(value, name, &allowed())),
    }
}

/// A share that is neither nothing nor all.
pub(crate) fn inner_share(share: f64, argument: &str) -> PyResult<f64> {
    if share > 0.0 && share < 1.0 {
        return Ok(share);
    }
    let text = format!("`{argument}` is {share}, allowed is a number above 0 and below 1");
    Err(PyValueError::new_err(text))
}

/// Value that a word stands for.
pub(crate) fn one_of<T: Clone>(argument: &str, word: &str, known: &[Word<T>]) -> PyResult<T> {
    let names: Vec<String> = known.iter().map(|(name, ..)| name.replace('-', "_")).collect();
    if let Some(place) = names.iter().position(|name| name == word) {
        return Ok(known[place].2.clone());
    }
    let (word, allowed) = (cut(word), names.join(", "));
    let text = format!("`{argument}` is {word:?}, allowed is one of: {allowed}");
    Err(PyValueError::new_err(text))
}

/// A number, or a sequence of numbers.
pub(crate) fn one_or_more(value: &Bound<PyAny>) -> PyResult<Vec<f64>> {
    value.extract::<f64>().map_or_else(|_| value.extract(), |number| Ok(vec![number]))
}

/// A value of a type that is not taken.
pub(crate) fn wrong_type(value: &Bound<PyAny>, key: &str, allowed: &str) -> PyErr {
    PyTypeError::new_err(text(value, key, allowed))
}

fn not_allowed(value: &Bound<PyAny>, key: &str, allowed: &str) -> PyErr {
    PyValueError::new_err(text(value, key, allowed))
}

fn text(value: &Bound<PyAny>, key: &str, allowed: &str) -> String {
    format!("`{}` is {}, allowed is {allowed}", cut(key), shown(value))
}

/// A value as Python writes it, where it can.
pub(crate) fn shown(value: &Bound<PyAny>) -> String {
    let written = value.repr().and_then(|repr| repr.extract::<String>());
    written.map_or_else(|_| "a value that cannot be shown".to_owned(), |text| cut(&text))
}

fn cut(text: &str) -> String {
    let mut characters = text.chars();
    let mut cut: String = characters.by_ref().take(SHOWN_VALUE).collect();
    if characters.next().is_some() {
        cut.push('…');
    }
    cut
}
