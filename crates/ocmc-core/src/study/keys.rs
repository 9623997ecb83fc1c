//! Declarations of the keys of a study: meaning, words and range, on the fields of the models'
//! structs.
//!
//! A field is the only place that says it: the check of a study, the schema for editors, the
//! comments of `ocmc study init` and the reference pages are made from the fields' schema. Ranges
//! are physical or sanity limits (judgement); within them anything runs.

use super::StudyModel;
use crate::distribution::Law;
use crate::random::nesting::Level;
use schemars::Schema;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use serde_json::{Map, Value, json};
use std::sync::LazyLock;

/// The allowed range of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest allowed value.
    pub minimum: f64,
    /// Largest allowed value.
    pub maximum: f64,
}

impl Bounds {
    /// Bounds of a key without bounds: it has to be finite.
    pub const FINITE: Self = Self { minimum: f64::MIN, maximum: f64::MAX };
}

/// Declaration of a key, and of the keys below it: a part of the schema.
#[derive(Clone, Copy, Debug)]
pub struct Key<'a>(pub &'a Value);

impl Key<'_> {
    /// The key at a path below this one, without indices of lists; a name that a study is free to
    /// choose leads to what all such names share.
    pub fn at(self, path: &str) -> Option<Self> {
        path.split('.').try_fold(self, Self::below)
    }

    /// A key of this table, or of each table of this list.
    pub fn below(self, name: &str) -> Option<Self> {
        let Self(table) = self.entry();
        let named = table.get("properties").and_then(|keys| keys.get(name));
        named.map(Key).or_else(|| self.any_name())
    }

    /// Part that all keys of a table share whose names a study is free to choose.
    pub fn any_name(self) -> Option<Self> {
        self.entry().0.get("additionalProperties").filter(|any| any.is_object()).map(Key)
    }

    /// The range of the key's number, of each number of its lists, or of what its law draws.
    pub fn bounds(self) -> Option<Bounds> {
        let Self(entry) = self.entry();
        // of a quantity the number stands first
        let number = entry.get("anyOf").map_or(entry, |kinds| &kinds[0]);
        let bound = |keyword| number.get(keyword).and_then(Value::as_f64);
        Some(Bounds { minimum: bound("minimum")?, maximum: bound("maximum")? })
    }

    /// The range that the key's number usually has: others may be slips.
    pub fn usual(self) -> Option<Bounds> {
        let Value::Array(ends) = self.entry().0.get("usual")? else { return None };
        let [minimum, maximum] = [0, 1].map(|k| ends.get(k).and_then(Value::as_f64));
        Some(Bounds { minimum: minimum?, maximum: maximum? })
    }

    /// The innermost entry of a list of lists; what is no list is its own entry.
    #[must_use]
    pub fn entry(self) -> Self {
        self.0.get("items").map_or(self, |items| Key(items).entry())
    }
}

/// The declarations of all keys: the JSON schema of a study, without references but to the laws.
///
/// No key is required in it, because any key may be inherited: what a table needs that inherits
/// nothing stands under `needed`.
///
/// They are made once a process: a calibration checks thousands of studies.
pub fn declarations() -> &'static Value {
    static DECLARATIONS: LazyLock<Value> = LazyLock::new(declared);
    &DECLARATIONS
}

fn declared() -> Value {
    let settings =
        SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    let mut generator = settings.with_transform(RecursiveTransform(as_written)).into_generator();
    let mut law = generator.subschema_for::<Law>();
    add_levels(&mut law, &generator.subschema_for::<Level>());
    let mut schema = generator.into_root_schema_for::<StudyModel>();
    schema.insert("$defs".to_owned(), json!({ "Law": law }));
    schema.to_value()
}

/// Puts the keys of a level beside those of each law.
fn add_levels(law: &mut Schema, level: &Schema) {
    let said = "Where it is drawn, if not where other quantities of its kind are";
    let mut level = level.clone();
    level.insert("description".to_owned(), said.into());
    let sd = |what: &str| {
        json!({ "type": "number", "minimum": 0.0,
            "description": format!("Standard deviation between trucks {what}") })
    };
    let laws = law.get_mut("oneOf").and_then(Value::as_array_mut).into_iter().flatten();
    for keys in laws.filter_map(|law| law.get_mut("properties")?.as_object_mut()) {
        keys.insert("level".to_owned(), level.clone().to_value());
        keys.insert("truck_sd".to_owned(), sd("in the law's unit"));
        keys.insert("truck_log_sd".to_owned(), sd("of the logarithm"));
    }
}

/// Makes of a choice between tables, each with a name of its own, a table of which one is there.
fn one_table_of(schema: &mut Schema) {
    let mut choices = Map::new();
    for choice in schema.get("oneOf").and_then(Value::as_array).into_iter().flatten() {
        let Some(keys) = choice.get("properties").and_then(Value::as_object) else { return };
        let mut keys = keys.iter().filter(|(_, key)| key.get("const").is_none());
        let (Some((name, key)), None) = (keys.next(), keys.next()) else { return };
        choices.insert(name.clone(), key.clone());
    }
    if !choices.is_empty() && choices.values().all(|key| key.get("properties").is_some()) {
        schema.remove("oneOf");
        schema.insert("type".to_owned(), "object".into());
        schema.insert("properties".to_owned(), choices.into());
        schema.insert("additionalProperties".to_owned(), false.into());
    }
}

/// Makes of the schema of a Rust type that of what is written in a file.
fn as_written(schema: &mut Schema) {
    // a study may inherit any key; a table that nothing is inherited for needs these
    if let Some(names) = schema.remove("required") {
        schema.insert("needed".to_owned(), names);
    }
    one_table_of(schema);
    // a file has no null: what may be absent is described as what it is where it is there
    if let Some(Value::Array(kinds)) = schema.get_mut("type") {
        kinds.retain(|kind| kind != "null");
        if let [kind] = kinds.as_slice() {
            let kind = kind.clone();
            schema.insert("type".to_owned(), kind);
        }
    }
    // the range of a quantity is that of its number
    if schema.get("anyOf").is_some() {
        schema.remove("type");
        for keyword in ["minimum", "maximum"] {
            if let Some(bound) = schema.remove(keyword) {
                schema.ensure_object()["anyOf"][0][keyword] = bound;
            }
        }
    }
}
