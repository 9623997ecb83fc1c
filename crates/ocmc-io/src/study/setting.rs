//! One `--set key.path=VALUE`: a value of TOML, or a bare word, laid over the study file.

use super::error::{Cause, Fault, StudyFileError};
use super::node::{Content, Node};
use super::source::{Place, Source, SourceKind, cut};
use std::sync::Arc;
use toml::de::{DeTable, DeValue};

/// Reads a setting as a tree with one leaf.
pub(super) fn parse(setting: &str) -> Result<Node, Box<Fault>> {
    let name = setting.to_owned();
    let source = Arc::new(Source { kind: SourceKind::Setting, name, text: setting.to_owned() });
    let whole = Place::new(&source, 0..setting.len());
    let lacks = |part| {
        let fault = Fault::new(Cause::Setting { setting: cut(setting, 120), part });
        let example = "the form is KEY=VALUE, such as driver.curve_speed.exponent=0.5";
        fault.at(Some(&whole)).help(example)
    };
    let Some((key, value)) = setting.split_once('=') else {
        return Err(lacks("`=`"));
    };
    let steps = steps_of(key).ok_or_else(|| lacks("dotted key in front of the `=`"))?;
    if value.trim().is_empty() {
        return Err(lacks("value behind the `=`"));
    }
    let start = setting.len() - value.trim_start().len();
    let mut node = match Node::parse_value(&source, start) {
        Ok(node) => node,
        // a bare word is a string; what begins like a list, table or string was meant to be one
        Err(fault) if value.trim_start().starts_with(['[', '{', '"', '\'']) => return Err(fault),
        Err(_) => {
            let place = Place::new(&source, start..setting.trim_end().len());
            Node::new(Content::Scalar(value.trim().into()), Some(place))
        }
    };
    if matches!(&node.content, Content::Table(entries) if entries.is_empty()) {
        return Err(lacks("key in its table: an empty table changes nothing"));
    }
    node.key_place = Some(Place::new(&source, 0..key.trim_end().len()));
    for step in steps.into_iter().rev() {
        node = Node::new(Content::Table([(step, node)].into()), None);
    }
    Ok(node)
}

/// The keys of a dotted key, as TOML reads it.
fn steps_of(key: &str) -> Option<Vec<String>> {
    if key.contains(['\n', '\r', '#', '[']) {
        return None;
    }
    let text = format!("{key} = 0");
    let document = DeTable::parse(&text).ok()?;
    let mut table = document.get_ref();
    let mut steps = Vec::new();
    loop {
        let (key, value) = table.iter().next()?;
        steps.push(key.get_ref().to_string());
        match value.get_ref() {
            DeValue::Table(below) => table = below,
            _ => return Some(steps),
        }
    }
}

/// The value of a setting.
///
/// # Errors
/// [`StudyFileError`] where it has no key or no value, or begins like TOML and is none.
pub fn value_of(setting: &str) -> Result<serde_json::Value, StudyFileError> {
    let mut node = parse(setting)?;
    // the key's own place stands on its value
    while node.key_place.is_none()
        && let Content::Table(entries) = &mut node.content
        && let Some((_, below)) = entries.pop_first()
    {
        node = below;
    }
    Ok(node.to_json())
}

/// A key and the values that it is to take one by one, as in `vehicle.base=tractor-40t,rigid-12t`.
/// Commas within lists, tables and strings do not separate values.
///
/// ```
/// use ocmc_io::study::alternatives;
/// let (key, values) = alternatives("a.b=[1, 2], \"x,y\", z")?;
/// assert_eq!(key, "a.b");
/// assert_eq!(values, ["[1, 2]", "\"x,y\"", "z"]);
/// # Ok::<(), ocmc_io::study::StudyFileError>(())
/// ```
///
/// # Errors
/// As [`value_of`], of each value.
pub fn alternatives(setting: &str) -> Result<(String, Vec<String>), StudyFileError> {
    let Some((key, values)) = setting.split_once('=') else {
        parse(setting)?;
        return Ok((setting.to_owned(), Vec::new()));
    };
    let values: Vec<String> = split(values).into_iter().map(|v| v.trim().to_owned()).collect();
    values.iter().try_for_each(|value| parse(&format!("{key}={value}")).map(drop))?;
    Ok((key.trim().to_owned(), values))
}

/// The pieces between the commas outside of lists, tables and strings.
fn split(values: &str) -> Vec<&str> {
    let mut pieces = Vec::new();
    let (mut start, mut depth, mut quote) = (0, 0_usize, None);
    // a word may hold brackets and apostrophes, but not begin with them
    let (mut has_begun, mut is_escaped) = (false, false);
    for (place, letter) in values.char_indices() {
        match (quote, letter) {
            (Some(_), _) if is_escaped => is_escaped = false,
            (Some('"'), '\\') => is_escaped = true,
            (Some(mark), letter) if mark == letter => quote = None,
            (None, ',') if depth == 0 => {
                pieces.push(&values[start..place]);
                (start, has_begun) = (place + 1, false);
                continue;
            }
            (None, '"' | '\'') if depth > 0 || !has_begun => quote = Some(letter),
            (None, '[' | '{') if depth > 0 || !has_begun => depth += 1,
            (None, ']' | '}') => depth = depth.saturating_sub(1),
            _ => {}
        }
        has_begun |= !letter.is_whitespace();
    }
    pieces.push(&values[start..]);
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::study::tree::Step;

    fn leaf(setting: &str) -> (String, serde_json::Value) {
        let mut node = parse(setting).unwrap();
        let mut steps = Vec::new();
        while let Content::Table(entries) = node.content {
            let (key, below) = entries.into_iter().next().unwrap();
            steps.push(Step::Key(key));
            node = below;
        }
        (crate::study::node::path_of(&steps), node.to_json())
    }

    #[test]
    fn values_are_toml_and_bare_words_are_strings() {
        assert_eq!(leaf("a.b=1.5"), ("a.b".into(), 1.5.into()));
        assert_eq!(leaf("a = 3 "), ("a".into(), 3.into()));
        assert_eq!(leaf("a.b=table"), ("a.b".into(), "table".into()));
        assert_eq!(leaf("a=\"x y\""), ("a".into(), "x y".into()));
        assert_eq!(leaf("a=[1, 2]"), ("a".into(), vec![1, 2].into()));
        assert_eq!(leaf("a.\"b c\"=true"), ("a.\"b c\"".into(), true.into()));
        assert_eq!(leaf("a.b=x=y"), ("a.b".into(), "x=y".into()));
    }

    #[test]
    fn values_of_a_key_end_at_commas_that_are_no_part_of_one() {
        let values = |setting: &str| alternatives(setting).unwrap().1;
        assert_eq!(values("a=1, 2.5,x"), ["1", "2.5", "x"]);
        assert_eq!(values("a=[1, [2, 3]], [4]"), ["[1, [2, 3]]", "[4]"]);
        assert_eq!(values(r#"a={ b = "x,}", c = 'y,"' },2"#), [r#"{ b = "x,}", c = 'y,"' }"#, "2"]);
        assert_eq!(values(r#"a="x\",y",'\',z"#), [r#""x\",y""#, r"'\'", "z"]);
        assert_eq!(values("a=driver's,b[1,c]"), ["driver's", "b[1", "c]"]);
        for setting in ["a=1,,2", "a=1,", "a", "a=[1,2", "=1,2", "a=\"x,y"] {
            assert!(alternatives(setting).is_err(), "{setting}");
        }
        let value = value_of("a.b={ distribution = \"uniform\", lower = 1 }").unwrap();
        assert_eq!(value, serde_json::json!({ "distribution": "uniform", "lower": 1 }));
        assert_eq!(value_of("a.b=x").unwrap(), "x");
    }

    #[test]
    fn a_setting_without_key_or_value_is_refused() {
        for (setting, message) in [
            ("abc", "`--set abc` has no `=`"),
            ("=1", "has no dotted key"),
            ("a..b=1", "has no dotted key"),
            ("a=", "has no value"),
            ("", "has no `=`"),
            ("a=[1", "not valid TOML"),
            ("a={", "not valid TOML"),
            ("a={}", "has no key in its table"),
        ] {
            let text = parse(setting).unwrap_err().to_string();
            assert!(text.contains(message), "{setting}: {text}");
        }
    }

    #[test]
    fn settings_of_a_loaded_study_are_as_if_they_had_come_last() {
        let settings =
            ["mission.length_m=5000", "vehicle.base=tractor-40t", "mission.length_m=6000"];
        let at_once = crate::study::load("field-truck", &settings).unwrap();
        let one_by_one = crate::study::load("field-truck", &settings[..1]).unwrap();
        let one_by_one = one_by_one.set(&settings[1..2]).unwrap().set(&settings[2..]).unwrap();
        assert_eq!(one_by_one.model, at_once.model);
        assert_eq!(one_by_one.origin, at_once.origin);
    }

    #[test]
    fn the_value_knows_its_place() {
        let node = parse("mission.length_m=1e999").unwrap();
        let node = node.get("mission").and_then(|node| node.get("length_m")).unwrap();
        assert_eq!(node.shown(), "1e999");
        assert_eq!(node.place.as_ref().unwrap().column(), 18);
    }
}
