//! A resolved study as people read it: a law is one line, long lists are wrapped, and behind each
//! key stand its meaning and the allowed range; and the same as a file to start from, or as
//! settings.

use super::error::StudyFileError;
use super::init::{COMMENT_COLUMN, ranges_in};
use super::node::{Content, Node, PROBABILITIES};
use super::source::{Source, SourceKind};
use super::{load, resolved_toml};
use ocmc_core::study::keys::{Key, declarations};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

/// Longest line of a value, in characters.
const WIDTH: usize = 96;

/// A key of a study with its value: a number, a word, a list, or a table that is one thing, as a
/// law is.
struct Leaf<'a> {
    path: Vec<&'a str>,
    value: &'a Node,
}

/// The text of a resolved study with a comment behind each key: its meaning and, behind a bar, the
/// allowed range. It loads to the same study. What is no TOML stays as it is.
pub fn commented(resolved: &str) -> String {
    let Some(root) = tree(resolved) else { return resolved.to_owned() };
    let declared = declarations();
    let (mut text, mut table): (String, Option<Vec<&str>>) = (String::new(), None);
    for Leaf { path, value } in leaves(&root) {
        let (name, parents) = path.split_last().expect("a leaf has a key");
        if table.as_deref() != Some(parents) && !parents.is_empty() {
            let gap = if text.is_empty() { "" } else { "\n" };
            let _ = writeln!(text, "{gap}[{}]", dotted(parents));
            table = Some(parents.to_vec());
        }
        let lines = value_lines(value, key_word(name).chars().count() + 3, 0);
        let note = note(value, &path, Key(declared));
        let _ = writeln!(text, "{} = {}", key_word(name), with_note(lines, &note, name));
    }
    text
}

/// A key of a resolved study, for a table.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct KeyValue {
    /// Its dotted path.
    pub(crate) key: String,
    /// Its value; a law or a list as the text of a study file.
    pub(crate) value: toml::Value,
    /// Its meaning and, behind a bar, the allowed range.
    pub(crate) note: String,
}

/// The keys of a resolved study, in the order in which they are written; none of what is no TOML.
pub(crate) fn keys_of(resolved: &str) -> Vec<KeyValue> {
    let Some(root) = tree(resolved) else { return Vec::new() };
    let declared = declarations();
    let row = |Leaf { path, value }: Leaf| KeyValue {
        key: dotted(&path),
        value: match &value.content {
            Content::Scalar(scalar) => scalar.clone(),
            _ => toml::Value::String(inline(value)),
        },
        note: note(value, &path, Key(declared)),
    };
    leaves(&root).into_iter().map(row).collect()
}

/// A study file that inherits all of a built-in study: every key with the value that it has there,
/// as a comment, its meaning and its allowed range.
///
/// # Errors
/// Where there is no such built-in study.
pub fn init_text_of(base: &str) -> Result<String, StudyFileError> {
    let none: &[&str] = &[];
    super::show(base)?;
    let resolved = resolved_toml(&load(base, none)?.model);
    let mut text = format!(
        "# Written by `ocmc study init --base {base}`: all that `{base}` says holds here, too. \
         Remove the\n\
         # `#` in front of a key and change its value; `ocmc study check FILE` tells whether it \
         fits.\n\
         # Behind the bar of a comment stands the allowed range.\n\n\
         study.base = \"{base}\"\nstudy.name = \"my-{base}\"\n"
    );
    let root = tree(&resolved).expect("a resolved study is TOML");
    let declared = declarations();
    let mut table = Vec::new();
    for Leaf { path, value } in leaves(&root).into_iter().filter(|leaf| leaf.path[0] != "study") {
        let parents = &path[..path.len() - 1];
        if table != parents {
            text.push('\n');
            table = parents.to_vec();
        }
        let setting = format!("#{} = {}", dotted(&path), inline(value));
        let note = note(value, &path, Key(declared));
        let _ = writeln!(text, "{}", beside(&setting, &note));
    }
    Ok(text)
}

/// The settings with which a built-in study becomes a resolved one; none where it takes more than
/// settings.
pub(crate) fn settings_from(base: &str, resolved: &str) -> Option<Vec<String>> {
    let none: &[&str] = &[];
    let from = resolved_toml(&load(base, none).ok()?.model);
    let (from, to) = (tree(&from)?, tree(resolved)?);
    let by_path = |root: &Node| -> BTreeMap<String, String> {
        let leaves = leaves(root).into_iter();
        leaves.map(|leaf| (dotted(&leaf.path), inline(leaf.value))).collect()
    };
    let (from, to) = (by_path(&from), by_path(&to));
    if from.keys().any(|path| !to.contains_key(path)) {
        return None;
    }
    let changed = to.into_iter().filter(|(path, value)| from.get(path) != Some(value));
    Some(changed.map(|(path, value)| format!("{path}={value}")).collect())
}

/// A value of a study in words: a law by its name, its numbers behind it.
pub(crate) fn in_words(value: &toml::Value) -> String {
    let list = |items: &[toml::Value]| items.iter().map(in_words).collect::<Vec<_>>().join(", ");
    match value {
        toml::Value::String(word) => word.clone(),
        toml::Value::Array(items) if items.is_empty() => "none".to_owned(),
        toml::Value::Array(items) => list(items),
        toml::Value::Float(number) => number.to_string(),
        toml::Value::Table(table) => {
            let law = table.get("distribution").map(in_words);
            let numbers = table.iter().filter(|(name, _)| *name != "distribution");
            let numbers = numbers.map(|(name, value)| match value {
                toml::Value::Array(_) => format!("{name} [{}]", in_words(value)),
                _ => format!("{name} {}", in_words(value)),
            });
            let numbers = numbers.collect::<Vec<_>>().join(", ");
            match law {
                Some(law) => format!("{} ({numbers})", law.replace('_', "-")),
                None => format!("({numbers})"),
            }
        }
        other => other.to_string(),
    }
}

fn tree(text: &str) -> Option<Node> {
    let source = Source { kind: SourceKind::File, name: String::new(), text: text.to_owned() };
    Node::parse(&Arc::new(source)).ok()
}

/// The keys in the order in which they are written; those of a table stand before its tables.
fn leaves(root: &Node) -> Vec<Leaf<'_>> {
    let mut leaves = Vec::new();
    add_leaves(root, &[], &mut leaves);
    leaves
}

fn add_leaves<'a>(table: &'a Node, above: &[&'a str], leaves: &mut Vec<Leaf<'a>>) {
    let entries = written(table);
    let path = |name: &'a str| [above, &[name]].concat();
    let whole = |name: &str, node: &Node| match &node.content {
        Content::Table(entries) => {
            entries.is_empty()
                || entries.contains_key("distribution")
                || PROBABILITIES.contains(&name)
        }
        _ => true,
    };
    for (name, value) in entries.iter().filter(|(name, value)| whole(name, value)) {
        leaves.push(Leaf { path: path(name), value });
    }
    for (name, value) in entries.iter().filter(|(name, value)| !whole(name, value)) {
        add_leaves(value, &path(name), leaves);
    }
}

/// Contents of a table, in the order in which they are written.
fn written(table: &Node) -> Vec<(&str, &Node)> {
    let Content::Table(entries) = &table.content else { return Vec::new() };
    let mut entries: Vec<(&str, &Node)> =
        entries.iter().map(|(name, node)| (name.as_str(), node)).collect();
    entries.sort_by_key(|(_, node)| node.any_place().map(|place| place.span.start));
    entries
}

/// A key as TOML writes it.
fn key_word(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(bare) {
        return name.to_owned();
    }
    toml::Value::from(name).to_string()
}

fn dotted(path: &[&str]) -> String {
    path.iter().map(|name| key_word(name)).collect::<Vec<_>>().join(".")
}

/// A value on one line.
fn inline(node: &Node) -> String {
    match &node.content {
        Content::Table(_) => {
            let mut entries = written(node);
            // a law is known by its name
            entries.sort_by_key(|(name, _)| *name != "distribution");
            let entries = entries
                .iter()
                .map(|(name, value)| format!("{} = {}", key_word(name), inline(value)));
            match entries.collect::<Vec<_>>().join(", ").as_str() {
                "" => "{}".to_owned(),
                entries => format!("{{ {entries} }}"),
            }
        }
        Content::List(items) => {
            format!("[{}]", items.iter().map(inline).collect::<Vec<_>>().join(", "))
        }
        Content::Scalar(value) => value.to_string(),
    }
}

/// A value on one line where it fits behind so many characters, a list otherwise on several.
fn value_lines(node: &Node, before: usize, indent: usize) -> Vec<String> {
    let whole = inline(node);
    let items = match &node.content {
        Content::List(items) if before + whole.chars().count() > WIDTH => items,
        _ => return vec![whole],
    };
    let blank = " ".repeat(indent + 2);
    let mut lines = vec!["[".to_owned()];
    for item in items {
        let item = value_lines(item, indent + 3, indent + 2);
        let fits = |line: &String| line.chars().count() + item[0].chars().count() + 2 <= WIDTH;
        let single = item.len() == 1 && !item[0].starts_with(['[', '{']);
        if let Some(line) = lines.last_mut().filter(|line| single && *line != "[" && fits(line)) {
            let _ = write!(line, " {},", item[0]);
            continue;
        }
        let last = item.len() - 1;
        for (k, line) in item.iter().enumerate() {
            let (before, behind) =
                (if k == 0 { blank.as_str() } else { "" }, if k == last { "," } else { "" });
            lines.push(format!("{before}{line}{behind}"));
        }
    }
    lines.push(format!("{}]", " ".repeat(indent)));
    lines
}

/// Meaning of a key, and the range of its numbers.
fn note(value: &Node, path: &[&str], root: Key) -> String {
    let Some(key) = path.iter().try_fold(root, |key, name| key.below(name)) else {
        return String::new();
    };
    let said = key.0.get("description").and_then(serde_json::Value::as_str).unwrap_or_default();
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    let first = said.split_once(". ").map_or(said.as_str(), |(first, _)| first);
    let ranges = ranges_in(value, key).join("; ");
    let bar = if ranges.is_empty() { String::new() } else { format!(" | {ranges}") };
    format!("{}{bar}", first.trim_end_matches('.')).trim_start().to_owned()
}

/// A line with a note behind it.
fn beside(line: &str, note: &str) -> String {
    if note.is_empty() {
        return line.to_owned();
    }
    let gap = COMMENT_COLUMN.saturating_sub(line.chars().count()).max(2);
    format!("{line}{}# {note}", " ".repeat(gap))
}

/// The lines of a value, with a note behind the first one.
fn with_note(mut lines: Vec<String>, note: &str, name: &str) -> String {
    let head = key_word(name).chars().count() + 3;
    // counted from the begin of the line, on which the key stands
    let first = beside(&format!("{}{}", " ".repeat(head), lines[0]), note);
    lines[0] = first.chars().skip(head).collect();
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::super::builtin::STUDIES;
    use super::*;
    use crate::study::{load_text, study_hash};

    const NONE: &[&str] = &[];

    #[test]
    fn a_commented_study_is_the_same_study_and_says_what_its_keys_mean() {
        for built_in in STUDIES {
            let model = load(built_in.name, NONE).expect("built in").model;
            let text = commented(&resolved_toml(&model));
            let again = load_text("commented.toml", &text, NONE).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(again.model, model, "{}", built_in.name);
            let code = |line: &str| line.split(" # ").next().unwrap_or_default().trim_end().len();
            let long = text.lines().filter(|line| code(line) > 130 && !line.contains('{'));
            let long: Vec<&str> = long.filter(|line| !line.contains('"')).collect();
            assert!(long.is_empty(), "{long:?}");
        }
        let text = commented(&resolved_toml(&load("field-truck", NONE).expect("built in").model));
        let line = |key: &str| text.lines().find(|line| line.starts_with(key)).expect("a key");
        assert!(line("curb_mass_kg").ends_with("| 500 to 100000"), "{}", line("curb_mass_kg"));
        assert!(line("length_m = 100000.0").contains("# "), "{}", line("length_m"));
        assert!(line("payload_kg").contains("{ distribution = \"beta\", alpha"));
    }

    #[test]
    fn what_is_no_study_stays_as_it_is() {
        assert_eq!(commented("no = [toml"), "no = [toml");
    }

    #[test]
    fn a_file_to_start_from_holds_every_key_of_its_base() {
        for base in ["long-haul", "battery-truck"] {
            let text = init_text_of(base).expect("built in");
            let own = load_text("new.toml", &text, NONE).unwrap_or_else(|e| panic!("{e}")).model;
            assert_eq!(own.study.name, format!("my-{base}"));
            // with every key let in, nothing changes
            let all: String = text
                .lines()
                .map(|line| match line.strip_prefix('#') {
                    Some(key) if !key.starts_with(' ') => format!("{key}\n"),
                    _ => format!("{line}\n"),
                })
                .collect();
            let all = load_text("all.toml", &all, NONE).unwrap_or_else(|e| panic!("{e}")).model;
            assert_eq!(study_hash(&all), study_hash(&own), "{base}");
        }
        let error = init_text_of("long-hual").expect_err("no such study").to_string();
        assert!(error.contains("did you mean `long-haul`?"), "{error}");
    }

    #[test]
    fn settings_lead_from_a_built_in_study_to_another_one() {
        let sets = [
            "mission.length_m=20000.0",
            "vehicle.drag_area_m2=5.0",
            "simulation.without=[\"curves\"]",
        ];
        let to = load("field-truck", &sets).expect("a study").model;
        let settings = settings_from("field-truck", &resolved_toml(&to)).expect("settings");
        assert_eq!(settings.len(), 3, "{settings:?}");
        let again = load("field-truck", &settings).expect("the same").model;
        assert_eq!(study_hash(&again), study_hash(&to));
        let same = resolved_toml(&load("field-truck", NONE).expect("built in").model);
        assert_eq!(settings_from("field-truck", &same), Some(Vec::new()));
    }

    #[test]
    fn laws_in_words() {
        let value = |text: &str| text.parse::<toml::Table>().expect("TOML")["x"].clone();
        for (text, words) in [
            ("x = 100000.0", "100000"),
            ("x = \"calibrated\"", "calibrated"),
            ("x = []", "none"),
            ("x = [\"a\", \"b\"]", "a, b"),
            (
                "x = { distribution = \"log_normal\", median = 5.3, log_sd = 0.04 }",
                "log-normal (log_sd 0.04, median 5.3)",
            ),
        ] {
            assert_eq!(in_words(&value(text)), words);
        }
    }
}
