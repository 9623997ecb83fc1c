//! The tables of the reference pages are those that the declarations make.
//!
//! `OCMC_WRITE_DOCS=1 cargo test -p ocmc-io --test it reference` writes them anew.

use ocmc_core::energy::carrier::{ALL_STORES, CARRIERS, Named};
use ocmc_core::energy::ledger::{Extent, Mode, Recorded, TERMS};
use ocmc_core::kernel::drive::trace::trace;
use ocmc_core::record::{COLUMNS, Record};
use ocmc_core::study::Study;
use ocmc_core::study::keys::{Bounds, Key};
use ocmc_fleet::truck_column::TRUCK_COLUMNS;
use ocmc_io::study::{self, init_text};
use serde_json::{Map, Value};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A region begins with this and what it is made from, and ends with [`END`].
const BEGIN: &str = "<!-- generated: begin ";
const END: &str = "<!-- generated: end -->";
/// The unit of a name, by its suffix; a longer suffix stands before a shorter one.
const UNITS: [(&str, &str); 44] = [
    ("_l_per_100km", "L/100 km"),
    ("_l_per_100tkm", "L/100 tkm"),
    ("_kwh_per_km", "kWh/km"),
    ("_kwh_per_tkm", "kWh/tkm"),
    ("_g_per_km", "g/km"),
    ("_g_per_tkm", "g/tkm"),
    ("_per_truck", "per truck"),
    ("_per_kwh", "per kWh"),
    ("_per_tkm", "per tkm"),
    ("_per_km", "per km"),
    ("_per_kw", "per kW"),
    ("_per_l", "per L"),
    ("_per_h", "per h"),
    ("_per_a", "per a"),
    ("_w_per_k", "W/K"),
    ("_j_per_k", "J/K"),
    ("_per_k", "K"),
    ("_j_per_m", "J/m"),
    ("_per_m", "per m"),
    ("_kgpm3", "kg/m³"),
    ("_jpkg", "J/kg"),
    ("_kgm2", "kg m²"),
    ("_kgps", "kg/s"),
    ("_radps", "rad/s"),
    ("_mps2", "m/s²"),
    ("_mps", "m/s"),
    ("_kmh", "km/h"),
    ("_rad", "rad"),
    ("_deg", "degrees"),
    ("_ohm", "Ω"),
    ("_m2", "m²"),
    ("_m3", "m³"),
    ("_nm", "Nm"),
    ("_kg", "kg"),
    ("_pa", "Pa"),
    ("_n", "N"),
    ("_w", "W"),
    ("_j", "J"),
    ("_k", "K"),
    ("_v", "V"),
    ("_h", "h"),
    ("_s", "s"),
    ("_m", "m"),
    ("_a", "a"),
];
/// Longest list whose entries are shown.
const MOST_ENTRIES: usize = 12;
/// Value of a key that the example lacks.
const ABSENT: &str = "absent";
/// In place of a longer text.
const LONG: &str = "–";
/// Longest text that is shown.
const MOST_CHARACTERS: usize = 24;

fn path_of(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src/reference").join(name)
}

fn read(name: &str) -> String {
    std::fs::read_to_string(path_of(name)).unwrap()
}

/// Compares the regions of a page with what is made for them, or writes them.
fn page(name: &str, render: impl Fn(&str) -> String) {
    let old = read(name);
    let mut parts = old.split(BEGIN);
    let mut new = parts.next().unwrap().to_owned();
    for part in parts {
        let (what, rest) = part.split_once("-->").unwrap();
        let what = what.trim_end();
        let (_, prose) = rest.split_once(END).unwrap();
        write!(new, "{BEGIN}{what} -->\n\n{}\n\n{END}{prose}", render(what).trim()).unwrap();
    }
    assert_ne!(new, old.replace(BEGIN, ""), "{name} has no generated region");
    if std::env::var_os("OCMC_WRITE_DOCS").is_some() {
        std::fs::write(path_of(name), new).unwrap();
    } else {
        let remedy = "OCMC_WRITE_DOCS=1 cargo test -p ocmc-io --test it reference";
        assert!(new == old, "{name} is not what the declarations say; `{remedy}` writes it");
    }
}

#[test]
fn the_pages_of_the_study_file_are_made_from_its_keys() {
    let schema = study::schema();
    let all = RefCell::new(String::new());
    for name in [
        "mission",
        "road",
        "weather-traffic",
        "driver",
        "vehicle",
        "simulation",
        "uncertainty",
        "cost",
        "fleet",
        "rest",
        "charging",
    ] {
        page(&format!("study-{name}.md"), |what| {
            let (path, example) = what.split_once(" of ").unwrap();
            let model = study::load::<&str>(example, &[]).unwrap().model;
            let example = Example {
                values: serde_json::to_value(model).unwrap(),
                standings: if example == "field-truck" { standings() } else { BTreeMap::new() },
            };
            let mut text = String::new();
            let key = Key(&schema).at(path).unwrap();
            example.table(path, &path.replace('*', "NAME"), key, &mut text);
            all.borrow_mut().push_str(&text);
            text
        });
    }
    // what the examples lack has a region of its own
    let all = all.into_inner();
    let tables = schema["properties"].as_object().unwrap().iter();
    // ranges of judged numbers have no keys of their own: `study-file.md` tells their form
    for table in tables.filter(|(name, _)| *name != "judged") {
        let named = Key(table.1).any_name().map(|any| (format!("{}.NAME", table.0), any));
        let (path, key) = named.unwrap_or((table.0.clone(), Key(table.1)));
        assert_has_tables(&path, key, &all);
    }
}

fn assert_has_tables(path: &str, key: Key, all: &str) {
    // a part that two powertrains share is described with one of them
    let shared = path.rmatch_indices('.').nth(1).map(|(at, _)| format!("{}]", &path[at..]));
    let is_there = all.contains(&format!("[{path}]"))
        || shared.is_some_and(|ending| path.contains(".electric.") && all.contains(&ending));
    assert!(is_there, "`{path}` is on no page");
    for (name, key) in key.entry().0["properties"].as_object().unwrap() {
        match Key(key).any_name().filter(|_| is_table(Key(key))) {
            Some(any) => assert_has_tables(&format!("{path}.{name}.NAME"), any, all),
            None if is_table(Key(key)) => {
                assert_has_tables(&format!("{path}.{name}"), Key(key), all);
            }
            None => {}
        }
    }
}

#[test]
fn the_page_of_the_records_is_made_from_their_columns() {
    let schema = schemars::schema_for!(Record).to_value();
    let fields = Key(&schema);
    let shown = RefCell::new(BTreeSet::new());
    page("records.md", |what| {
        let mut text = "| column | meaning |\n|---|---|\n".to_owned();
        if what == "truck-years" {
            for column in &TRUCK_COLUMNS {
                let meaning = column.meaning.trim_end_matches('.');
                writeln!(text, "| `{}` | {meaning}. |", column.name).unwrap();
            }
            return text;
        }
        for name in what.split_whitespace() {
            let of_terms = TERMS.iter().filter_map(|declared| match declared.recorded {
                Recorded::Column { name, meaning, .. } => Some(Named { name, meaning }),
                Recorded::Field | Recorded::ByPowertrain => None,
            });
            let of_carriers = CARRIERS
                .iter()
                .flat_map(|declared| [declared.amount, declared.consumption, declared.per_tonne]);
            let mut declared = of_carriers.chain([ALL_STORES]).chain(of_terms);
            let own = declared.find(|own| own.name == name).map(|own| own.meaning.to_owned());
            let meaning = own.or_else(|| Some(meaning(fields.below(name)?)));
            let meaning = meaning.unwrap_or_else(|| panic!("no column `{name}`"));
            assert_names_unit(name, &meaning);
            writeln!(text, "| `{name}` | {meaning} |").unwrap();
            assert!(shown.borrow_mut().insert(name.to_owned()), "`{name}` is there twice");
        }
        text
    });
    let all: BTreeSet<String> = COLUMNS.iter().map(|column| column.name.to_owned()).collect();
    assert_eq!(shown.into_inner(), all);
}

#[test]
fn the_page_of_the_trace_has_its_columns() {
    page("trace.md", |what| {
        assert_eq!(what, "terms of the ledger");
        let mut text = "| column | record |\n|---|---|\n".to_owned();
        for declared in
            TERMS.iter().filter(|declared| declared.extent != Extent::Only(Mode::Followed))
        {
            let (stem, unit) = declared.trace.split_once("_added").unwrap();
            let mut names = COLUMNS.iter().map(|column| column.name);
            let recorded =
                names.find(|name| name.starts_with(stem) && name.ends_with(unit)).unwrap();
            writeln!(text, "| `{}` | `{recorded}` |", declared.trace).unwrap();
        }
        text
    });
    let mut shown: BTreeSet<String> = BTreeSet::new();
    for line in read("trace.md").lines().filter(|line| line.starts_with("| `")) {
        shown.extend(
            line.split('|').nth(1).unwrap().split('`').skip(1).step_by(2).map(str::to_owned),
        );
    }
    let mut all = BTreeSet::new();
    for name in ["field-truck", "battery-truck", "fuel-cell-truck"] {
        let model = study::load(name, &["mission.length_m=500"]).unwrap().model;
        let columns = trace(&Study::new(model).unwrap(), 1, 0).columns;
        all.extend(columns.into_iter().map(|column| column.name.to_owned()));
    }
    assert_eq!(shown, all);
}

/// Sources of the default values, by path: the tags of the comments of `ocmc study init`.
fn standings() -> BTreeMap<String, String> {
    let (mut standings, mut table, mut above) = (BTreeMap::new(), String::new(), String::new());
    for line in init_text().lines() {
        if let Some(header) = line.strip_prefix('[') {
            header.trim_end_matches(']').clone_into(&mut table);
        } else if let Some((key, rest)) = line.split_once(" = ")
            && !line.starts_with([' ', '#'])
        {
            let own = rest.rsplit_once("# ").map_or("", |(_, comment)| comment);
            let tag = standing(own).or_else(|| standing(&above));
            standings.extend(tag.map(|tag| (format!("{table}.{key}"), tag)));
        }
        above = if line.starts_with('#') { line.to_owned() } else { String::new() };
    }
    standings
}

/// The tags in brackets of a comment, such as `EJ` of `[EJ: road design]`.
fn standing(comment: &str) -> Option<String> {
    let tags = comment.split('[').skip(1).filter_map(|text| {
        let end = text.find([']', ':', ';']).unwrap_or(text.len());
        let known = |tag: &&str| ["S", "F", "D", "EJ", "PK", "PK?"].contains(tag);
        let tags: Vec<&str> = text[..end].split(", ").filter(known).collect();
        (!tags.is_empty()).then(|| tags.join(", "))
    });
    tags.reduce(|all, tag| format!("{all}, {tag}"))
}

/// A study whose values the tables show.
struct Example {
    values: Value,
    standings: BTreeMap<String, String>,
}

impl Example {
    /// A table of the study and those below it; `path` has the names of the example in place of
    /// `shown`'s.
    fn table(&self, path: &str, shown: &str, key: Key, text: &mut String) {
        let is_list = key.0["type"] == "array";
        let header = if is_list { format!("[[{shown}]]") } else { format!("[{shown}]") };
        writeln!(text, "## `{header}`\n\n{}\n", meaning(key)).unwrap();
        let names = names_of(&self.values, path);
        let defaults = names.as_ref().map_or("default".to_owned(), |names| names.join(" | "));
        let columns = names.as_ref().map_or(1, Vec::len);
        let keys = key.entry().0["properties"].as_object().unwrap();
        let (tables, plain): (Vec<_>, Vec<_>) =
            keys.iter().partition(|(_, key)| is_table(Key(key)));
        if !plain.is_empty() {
            let rule = "---|".repeat(4 + columns);
            writeln!(text, "| key | {defaults} | standing | range | meaning |\n|{rule}").unwrap();
        }
        for (name, key) in plain {
            let key = Key(key);
            assert_names_unit(name, &meaning(key));
            let law = if key.0.get("anyOf").is_some() { " ⁎" } else { "" };
            let paths: Vec<String> = match &names {
                Some(names) => {
                    names.iter().map(|n| format!("{}.{name}", path.replace('*', n))).collect()
                }
                None => vec![format!("{path}.{name}")],
            };
            let values: Vec<String> = paths.iter().map(|path| self.value(path)).collect();
            let mut standings: Vec<&str> = paths
                .iter()
                .filter_map(|path| self.standings.get(path))
                .map(String::as_str)
                .collect();
            standings.dedup();
            let (values, standings) = (values.join(" | "), standings.join("; "));
            let (range, meaning) = (range(key), meaning(key).replace('|', "\\|"));
            writeln!(text, "| `{name}`{law} | {values} | {standings} | {range} | {meaning} |")
                .unwrap();
        }
        text.push('\n');
        for (name, key) in tables {
            let (path, shown) = (format!("{path}.{name}"), format!("{shown}.{name}"));
            match Key(key).any_name() {
                Some(any) => self.table(&format!("{path}.*"), &format!("{shown}.NAME"), any, text),
                None if self.value(&path) != ABSENT => self.table(&path, &shown, Key(key), text),
                None => {}
            }
        }
    }

    /// The value at a path.
    fn value(&self, path: &str) -> String {
        let mut entries = vec![&self.values];
        for name in path.split('.') {
            let tables = entries.into_iter().flat_map(|value| match value {
                Value::Array(items) => items.iter().collect(),
                value => vec![value],
            });
            entries = match name {
                "*" => tables.filter_map(Value::as_object).flat_map(Map::values).collect(),
                name => tables.filter_map(|table| table.get(name)).collect(),
            };
        }
        let mut shown: Vec<String> = entries.into_iter().map(in_words).collect();
        shown.dedup();
        if shown.is_empty() { ABSENT.to_owned() } else { shown.join(", ") }
    }
}

/// Names that the example gives to the tables at a path with a `*`.
fn names_of(values: &Value, path: &str) -> Option<Vec<String>> {
    let (above, _) = path.split_once(".*")?;
    let table = above.split('.').try_fold(values, |value, name| value.get(name));
    Some(table?.as_object()?.keys().cloned().collect())
}

/// Whether a key has keys of its own that are declared.
fn is_table(key: Key) -> bool {
    let has_keys = |key: Key| key.entry().0.get("properties").is_some();
    has_keys(key) || key.any_name().is_some_and(has_keys)
}

/// The unit is declared by the suffix, and the meaning says it again.
fn assert_names_unit(name: &str, meaning: &str) {
    let Some((_, unit)) = UNITS.iter().find(|(suffix, _)| name.ends_with(suffix)) else { return };
    let text = format!("{meaning} ");
    let ends = [' ', ',', ';', ':', '.', ')'];
    let named = ends.iter().any(|end| text.contains(&format!(" {unit}{end}")));
    assert!(named, "`{name}` is in {unit}: {meaning}");
}

fn meaning(key: Key) -> String {
    key.0["description"].as_str().unwrap().replace('\n', " ")
}

/// The range of numbers, or the words.
fn range(key: Key) -> String {
    let any = key.any_name().unwrap_or(key);
    if let Some(Bounds { minimum, maximum }) = any.bounds() {
        return format!("{} to {}", number(minimum), number(maximum));
    }
    let entry = any.entry().0;
    let words = |keyword: &str| entry.get(keyword).and_then(Value::as_array);
    let one_of = words("oneOf").into_iter().flatten().map(|word| &word["const"]);
    let all = words("enum").into_iter().flatten().chain(one_of);
    let words: Vec<String> = all.filter_map(|word| Some(format!("`{}`", word.as_str()?))).collect();
    match entry["type"].as_str() {
        _ if !words.is_empty() => words.join(", "),
        Some("boolean") => "true, false".to_owned(),
        _ => String::new(),
    }
}

fn number(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e6).contains(&size) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

/// A value of the example, where it is not too long.
fn in_words(value: &Value) -> String {
    match value {
        Value::Number(value) => number(value.as_f64().unwrap()),
        Value::String(text) if text.len() > MOST_CHARACTERS => LONG.to_owned(),
        Value::String(text) => format!("`\"{text}\"`"),
        Value::Array(items) => {
            let shown: Vec<String> = items.iter().map(in_words).collect();
            let is_long = |item: &Value| item.is_array() || in_words(item) == LONG;
            if items.len() > MOST_ENTRIES || items.iter().any(is_long) {
                return format!("{} entries", items.len());
            }
            format!("[{}]", shown.join(", "))
        }
        Value::Object(law) => match law.get("distribution").and_then(Value::as_str) {
            Some("mixture") => mixture(law),
            Some(name) => format!("{name}, {}", named(law)),
            None => named(law),
        },
        value => value.to_string(),
    }
}

fn named(table: &Map<String, Value>) -> String {
    let keys = table.iter().filter(|(key, _)| *key != "distribution");
    keys.map(|(key, value)| format!("{key} {}", in_words(value))).collect::<Vec<_>>().join(", ")
}

fn mixture(law: &Map<String, Value>) -> String {
    let (weights, parts) =
        (law["weights"].as_array().unwrap(), law["components"].as_array().unwrap());
    let part = |(weight, part)| format!("{}: {}", in_words(weight), in_words(part));
    weights.iter().zip(parts).map(part).collect::<Vec<_>>().join("; ")
}
