//! From what serde and the core say about a study to faults with a place.

use super::error::{Cause, DECIMAL_POINT, Fault, NO_UNIT, StudyFileError};
use super::init::range;
use super::node::{Content, Node, path_of};
use super::source::{Place, SourceKind};
use crate::number_text::{has_decimal_comma, has_unit};
use crate::printable::is_hidden;
use ocmc_core::study::keys::{Key, declarations};
use ocmc_core::study::tree::{Step, TreeError};
use ocmc_core::study::{Problem, StudyError, StudyModel};

/// Keys of earlier studies that have gone, and where what they said is said now.
const MOVED: [(&str, &str); 5] = [
    ("base", "study.base"),
    ("vehicle.powertrain.battery_electric.charging", "charging.stop"),
    ("vehicle.engine", "vehicle.powertrain.combustion.engine"),
    ("vehicle.gearbox", "vehicle.powertrain.combustion.gearbox"),
    ("vehicle.electric", "vehicle.powertrain.battery_electric"),
];

/// Characters that a name is made of.
const NO_HIDDEN: &str = "letters that are shown: no control characters, none that turn the \
                         direction of writing";

/// The range of a number at a path with `[index]`es, as a text behind "a number".
fn range_of(path: &str) -> Option<String> {
    let plain: String = path.split('[').map(|p| p.split_once(']').map_or(p, |(_, q)| q)).collect();
    Key(declarations()).at(&plain).and_then(Key::bounds).map(range)
}

/// The keys that a table has to have, and that are not there.
fn needed_of(here: &Node, table: &[Step]) -> Vec<String> {
    let declared = declarations();
    let names = table.iter().filter_map(|step| match step {
        Step::Key(key) => Some(key.as_str()),
        Step::Index(_) => None,
    });
    let entry = names.clone().try_fold(Key(declared), Key::below).map(|key| key.entry().0.clone());
    let needed = entry.as_ref().and_then(|entry| entry["needed"].as_array());
    let names = needed.into_iter().flatten().filter_map(|name| name.as_str());
    let missing = names.filter(|name| here.get(name).is_none());
    missing.map(|name| format!("`{name}`")).collect()
}

/// Numbers that are infinite or none, each with its place.
pub(super) fn not_finite(root: &Node) -> Vec<Fault> {
    let mut faults = Vec::new();
    walk(root, &mut Vec::new(), &mut |steps, node| {
        if let Content::Scalar(toml::Value::Float(number)) = &node.content
            && !number.is_finite()
        {
            let key = path_of(steps);
            let range = range_of(&key).map_or_else(String::new, |range| format!(", {range}"));
            let allowed = format!("a finite number{range}");
            faults.push(*Fault::not_allowed(key, node.shown(), allowed).at(node.any_place()));
        }
    });
    faults
}

/// Names with letters that are not shown: every key, and the name and description of the study.
pub(super) fn hidden_letters(root: &Node) -> Vec<Fault> {
    let mut faults = Vec::new();
    walk(root, &mut Vec::new(), &mut |steps, node| {
        let has_hidden = |text: &str, more: &[char]| {
            text.chars().any(|letter| is_hidden(letter) && !more.contains(&letter))
        };
        let key = path_of(steps);
        let in_key = matches!(steps.last(), Some(Step::Key(key)) if has_hidden(key, &[]));
        let in_text = node.as_str().is_some_and(|text| match key.as_str() {
            "study.name" => has_hidden(text, &[]),
            "study.description" => has_hidden(text, &['\n', '\r', '\t']),
            _ => false,
        });
        if in_key || in_text {
            let value =
                if in_key { "a key with hidden letters" } else { "a text with hidden letters" };
            let fault = Fault::not_allowed(key, value, NO_HIDDEN);
            faults.push(*fault.at(node.key_place.as_ref().or(node.any_place())));
        }
    });
    faults
}

fn walk(node: &Node, steps: &mut Vec<Step>, visit: &mut impl FnMut(&[Step], &Node)) {
    visit(steps, node);
    for (step, below) in node.children() {
        steps.push(step);
        walk(below, steps, visit);
        steps.pop();
    }
}

/// The fault behind serde's refusal of a tree.
pub(super) fn from_serde(root: &Node, TreeError { mut steps, message }: TreeError) -> Box<Fault> {
    let names = quoted(&message);
    let (about, expected) = message.split_once(", expected ").unwrap_or((&message, ""));
    if about.starts_with("missing field") {
        let key = names.first().copied().unwrap_or_default();
        return missing(root, steps, key);
    }
    if about.starts_with("unknown field") || about.starts_with("unknown variant") {
        return unknown(root, steps, about, &quoted(expected));
    }
    // within a law serde loses the path: look for the law without a name, or for the value that is
    // no number
    let names_law = expected.starts_with("variant identifier");
    let (node, _) = root.follow(&steps);
    let is_name = |steps: &[Step]| steps.last() == Some(&Step::Key("distribution".to_owned()));
    let below = if names_law {
        first_below(node, &|steps, node| is_name(steps) && node.as_str().is_none())
    } else {
        let is_number = |value: &toml::Value| value.is_integer() || value.is_float();
        let law = node.get("distribution").map(|_| node);
        law.and_then(|law| {
            first_below(law, &|steps, node| {
                matches!(&node.content, Content::Scalar(value) if !is_number(value))
                    && !is_name(steps)
            })
        })
    };
    steps.extend(below.into_iter().flatten());
    let (node, _) = root.follow(&steps);
    let key = path_of(&steps);
    if names_law || expected.starts_with("string") {
        let words = words_of(root, &steps);
        let cause = Cause::UnknownWord { key, value: node.shown() };
        return Fault::new(cause).at(node.any_place()).suggest("", &words);
    }
    let allowed = match range_of(&key) {
        Some(range) if expected.starts_with("a number, or") => {
            format!("{expected}, within {range}")
        }
        Some(range) if expected.starts_with("an array") => {
            format!("{}, each {range}", in_words(expected))
        }
        Some(range) => format!("{}, {range}", in_words(expected)),
        None if expected.is_empty() => message.clone(),
        None => in_words(expected),
    };
    let fault = Fault::not_allowed(key, node.shown(), allowed).at(node.any_place());
    // `--set` takes what is no TOML as a text
    match node.as_str() {
        Some(text) if has_decimal_comma(text) => fault.help(DECIMAL_POINT),
        Some(text) if has_unit(text) => fault.help(NO_UNIT),
        _ => fault,
    }
}

fn missing(root: &Node, mut steps: Vec<Step>, key: &str) -> Box<Fault> {
    let (parent, _) = root.follow(&steps);
    let place = parent.any_place().cloned();
    steps.push(Step::Key(key.to_owned()));
    let key = path_of(&steps);
    let allowed = range_of(&key).map_or_else(String::new, |range| format!(", allowed is {range}"));
    let fault = Fault::new(Cause::Missing { key, allowed }).at(place.as_ref());
    let all = steps.split_last().map(|(_, table)| needed_of(parent, table)).unwrap_or_default();
    match steps.as_slice() {
        [Step::Key(table), Step::Key(key)] if table == "cost" && key == "currency" => {
            fault.help("the code of the currency of all prices: cost.currency = \"EUR\"")
        }
        [_] => fault.help("`study.base = \"field-truck\"` inherits what a study does not say"),
        [Step::Key(table), _] if table == "vehicle" => {
            fault.help("`vehicle.base = \"tractor-40t\"` inherits what a vehicle does not say")
        }
        _ if !inherits(root) => fault.help(
            "a study without a base has to say everything: `study.base = \"field-truck\"` \
             inherits what it does not say",
        ),
        _ if all.len() > 1 => fault.help(format!("all that is missing there: {}", all.join(", "))),
        _ => fault,
    }
}

/// An unknown key or word, with the nearest allowed one.
fn unknown(root: &Node, mut steps: Vec<Step>, about: &str, names: &[&str]) -> Box<Fault> {
    let wrong = about.split_once('`').map_or("", |(_, rest)| rest.trim_end_matches('`'));
    let (node, reached) = root.follow(&steps);
    if about.starts_with("unknown field") {
        // serde's path ends at the unknown key, or in a law at the table around it
        let is_key = reached && steps.last() == Some(&Step::Key(wrong.to_owned()));
        let key = Step::Key(wrong.to_owned());
        if !is_key {
            let below = first_below(node, &|steps, _| steps.last() == Some(&key));
            steps.extend(below.unwrap_or_else(|| vec![key.clone()]));
        }
        let (node, _) = root.follow(&steps);
        let place = node.key_place.as_ref().or(node.any_place()).cloned();
        let path = path_of(&steps);
        let moved = MOVED.iter().find(|(old, _)| *old == path);
        let fault = Fault::new(Cause::UnknownKey(path)).at(place.as_ref());
        if let Some((_, new)) = moved {
            return fault.help(format!("it has moved to `{new}`"));
        }
        return match inherited_law(root, &steps, place.as_ref()) {
            Some(law) => fault.help(format!(
                "the law there is inherited, a `{law}`, of which this changes one key; a law of \
                 your own begins with `distribution`"
            )),
            None => fault.suggest(wrong, names),
        };
    }
    if node.get(wrong).is_some() {
        // the keys of the table are words
        steps.push(Step::Key(wrong.to_owned()));
        let place = root.follow(&steps).0.key_place.as_ref();
        let cause = Cause::UnknownKey(path_of(&steps));
        return Fault::new(cause).at(place).suggest(wrong, names);
    }
    if steps.last() == Some(&Step::Key(wrong.to_owned())) && node.as_str() != Some(wrong) {
        // serde's path ends at such a key, too
        let place = node.key_place.as_ref().or(node.any_place());
        return Fault::new(Cause::UnknownKey(path_of(&steps))).at(place).suggest(wrong, names);
    }
    // a word within a law and its parts
    let below = first_below(node, &|_, node| node.as_str() == Some(wrong));
    steps.extend(below.into_iter().flatten());
    let (node, _) = root.follow(&steps);
    let (key, value) = (path_of(&steps), node.shown());
    Fault::new(Cause::UnknownWord { key, value }).at(node.any_place()).suggest(wrong, names)
}

/// Whether anything of a study comes from a built-in one.
fn inherits(root: &Node) -> bool {
    let built_in = |place: &Place| place.source.kind == SourceKind::BuiltIn;
    first_below(root, &|_, node| node.place.as_ref().is_some_and(built_in)).is_some()
}

/// The distribution of the law that the last step leads into, where it is inherited.
fn inherited_law(root: &Node, steps: &[Step], place: Option<&Place>) -> Option<String> {
    let (_, law) = steps.split_last()?;
    let word = root.follow(law).0.get("distribution")?;
    let elsewhere = word.place.as_ref()?.source.label() != place?.source.label();
    elsewhere.then(|| word.as_str().map(str::to_owned)).flatten()
}

/// The words that a key allows: those that serde lists when it meets a wrong one.
fn words_of(root: &Node, steps: &[Step]) -> Vec<String> {
    let mut probe = root.clone();
    probe.put(steps, Content::Scalar("".into()));
    let probed = StudyModel::from_tree(&probe.to_json());
    let message = probed.err().map_or_else(String::new, |error| error.message);
    let (_, expected) = message.split_once(", expected ").unwrap_or_default();
    quoted(expected).into_iter().map(str::to_owned).collect()
}

/// The steps to the first value that is wanted.
fn first_below(node: &Node, wanted: &impl Fn(&[Step], &Node) -> bool) -> Option<Vec<Step>> {
    let mut first = None;
    walk(node, &mut Vec::new(), &mut |steps, node| {
        if first.is_none() && wanted(steps, node) {
            first = Some(steps.to_vec());
        }
    });
    first
}

/// The words between backticks.
fn quoted(message: &str) -> Vec<&str> {
    message.split('`').skip(1).step_by(2).collect()
}

/// Rust's names of types in words.
fn in_words(expected: &str) -> String {
    match expected {
        "f64" => "a number".to_owned(),
        "u32" | "u64" | "usize" => "a whole number".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a string" => "a text in quotation marks".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a map" => "a table".to_owned(),
        other if other.starts_with("struct ") => "a table".to_owned(),
        other => other.replace("an array of length", "a list of length"),
    }
}

/// The faults behind the core's refusal of a study.
pub(super) fn from_core(root: &Node, error: StudyError) -> Vec<Fault> {
    error.problems.into_iter().map(|problem| *from_problem(root, problem)).collect()
}

fn from_problem(root: &Node, problem: Problem) -> Box<Fault> {
    let Problem { path, value, allowed } = problem;
    // the core's paths have no indices: look for the number itself first
    let number: Option<f64> = value.parse().ok();
    let first = first_below(root, &|steps, node| {
        let keys = steps.iter().filter_map(|step| match step {
            Step::Key(key) => Some(key.as_str()),
            Step::Index(_) => None,
        });
        let same = match &node.content {
            Content::Scalar(toml::Value::Integer(have)) => Some(*have as f64) == number,
            Content::Scalar(toml::Value::Float(have)) => Some(*have) == number,
            _ => false,
        };
        same && keys.collect::<Vec<_>>().join(".") == path
    });
    let steps = first.unwrap_or_else(|| path.split('.').map(|k| Step::Key(k.to_owned())).collect());
    let (node, _) = root.follow(&steps);
    Fault::not_allowed(path_of(&steps), value, allowed).at(node.any_place())
}

/// Says of each fault whether the user wrote its value.
pub(super) fn note_inherited(error: &mut StudyFileError, own: Option<&str>) {
    for fault in &mut error.faults {
        let Some(place) = &fault.place else { continue };
        let inherited = place.source.kind != SourceKind::Setting
            && own.is_some_and(|own| own != place.source.name);
        if inherited && fault.note.is_none() {
            let (from, own) = (place.source.label(), own.unwrap_or_default());
            fault.note = Some(format!("inherited from {from}; {own} does not say it"));
        }
    }
}
