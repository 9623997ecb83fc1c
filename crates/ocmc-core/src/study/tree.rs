//! A study as a tree of tables, lists, numbers and words, and the study that such a tree describes.
//!
//! Whatever its file was written in, a study is read and written here, so that the code that serde
//! derives for its some hundred tables is compiled once.

use super::StudyModel;
use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{
    Deserialize, DeserializeSeed, Deserializer, Error, Expected, IntoDeserializer, MapAccess,
    SeqAccess, Unexpected, Visitor,
};
use serde::forward_to_deserialize_any;
use serde_json::{Map, Value};
use std::fmt::Display;

impl StudyModel {
    /// The study as a tree; a number that is not finite is null there.
    pub fn to_tree(&self) -> Value {
        serde_json::to_value(self).expect("a study is tables, lists, numbers and words")
    }

    /// The study that a tree describes; its numbers are not checked yet.
    ///
    /// # Errors
    /// [`TreeError`] where a key is missing or unknown, or its value of another kind.
    pub fn from_tree(tree: &Value) -> Result<Self, TreeError> {
        Self::deserialize(Tree(tree))
    }
}

/// A step down a tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// Into the value of a key.
    Key(String),
    /// Into an entry of a list.
    Index(usize),
}

/// Error of a tree that is no study.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct TreeError {
    /// Steps from the root; they end at the table around a missing key, and at a law for what is
    /// wrong within.
    pub steps: Vec<Step>,
    /// Fault there, in the words of serde.
    pub message: String,
}

impl TreeError {
    #[cold]
    #[inline(never)]
    fn below(mut self, step: Step) -> Self {
        self.steps.insert(0, step);
        self
    }
}

impl Error for TreeError {
    fn custom<T: Display>(message: T) -> Self {
        Self { steps: Vec::new(), message: message.to_string() }
    }
}

/// A value to be read.
#[derive(Clone, Copy)]
struct Tree<'a>(&'a Value);

impl Tree<'_> {
    #[cold]
    #[inline(never)]
    fn is_no(self, expected: &dyn Expected) -> TreeError {
        let unexpected = match self.0 {
            Value::Null => Unexpected::Unit,
            Value::Bool(value) => Unexpected::Bool(*value),
            Value::Number(number) => match (number.as_i64(), number.as_f64()) {
                (Some(number), _) => Unexpected::Signed(number),
                (None, number) => Unexpected::Float(number.unwrap_or(f64::NAN)),
            },
            Value::String(text) => Unexpected::Str(text),
            Value::Array(_) => Unexpected::Seq,
            Value::Object(_) => Unexpected::Map,
        };
        TreeError::invalid_type(unexpected, expected)
    }
}

impl<'de> Deserializer<'de> for Tree<'de> {
    type Error = TreeError;

    #[inline(never)]
    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, TreeError> {
        match self.0 {
            Value::Null => visitor.visit_unit(),
            Value::Bool(value) => visitor.visit_bool(*value),
            // signed where it can be: serde takes an unsigned number for the name of a law, too
            Value::Number(number) => match (number.as_i64(), number.as_u64()) {
                (Some(number), _) => visitor.visit_i64(number),
                (None, Some(number)) => visitor.visit_u64(number),
                (None, None) => visitor.visit_f64(number.as_f64().unwrap_or(f64::NAN)),
            },
            Value::String(text) => visitor.visit_borrowed_str(text),
            Value::Array(_) => self.deserialize_seq(visitor),
            Value::Object(_) => self.deserialize_map(visitor),
        }
    }

    #[inline(never)]
    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, TreeError> {
        let Value::Array(list) = self.0 else { return Err(self.is_no(&visitor)) };
        let mut entries = Entries { list, next: 0 };
        let value = visitor.visit_seq(&mut entries)?;
        if entries.next < list.len() {
            return Err(TreeError::invalid_length(list.len(), &"fewer entries"));
        }
        Ok(value)
    }

    #[inline(never)]
    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        _: usize,
        visitor: V,
    ) -> Result<V::Value, TreeError> {
        self.deserialize_seq(visitor)
    }

    #[inline(never)]
    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, TreeError> {
        let Value::Object(table) = self.0 else { return Err(self.is_no(&visitor)) };
        visitor.visit_map(Keys::of(table))
    }

    #[inline(never)]
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, TreeError> {
        self.deserialize_map(visitor)
    }

    #[inline(never)]
    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        names: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, TreeError> {
        match self.0 {
            Value::String(word) => visitor.visit_enum(text(word)),
            Value::Object(table) if table.len() == 1 => {
                visitor.visit_enum(MapAccessDeserializer::new(Keys::of(table)))
            }
            Value::Object(table) => {
                let there: Vec<&str> = table.keys().map(String::as_str).collect();
                let there = if there.is_empty() { "none".to_owned() } else { there.join(" and ") };
                Err(TreeError::custom(format_args!(
                    "one of the tables {}; there is {there}: leave an inherited one out by \
                     study.drop",
                    names.join(", ")
                )))
            }
            _ => Err(self.is_no(&"string or map")),
        }
    }

    #[inline(never)]
    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, TreeError> {
        if self.0.is_null() { visitor.visit_none() } else { visitor.visit_some(self) }
    }

    #[inline(never)]
    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, TreeError> {
        visitor.visit_newtype_struct(self)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit
        unit_struct tuple_struct identifier ignored_any
    }
}

fn text(word: &str) -> StrDeserializer<'_, TreeError> {
    word.into_deserializer()
}

/// A list while it is read.
struct Entries<'de> {
    list: &'de [Value],
    next: usize,
}

impl<'de> SeqAccess<'de> for &mut Entries<'de> {
    type Error = TreeError;

    #[inline(never)]
    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, TreeError> {
        let k = self.next;
        self.next += 1;
        let entry = self.list.get(k).map(|entry| seed.deserialize(Tree(entry)));
        entry.transpose().map_err(|error| error.below(Step::Index(k)))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.list.len().saturating_sub(self.next))
    }
}

/// A table while it is read.
struct Keys<'de> {
    left: serde_json::map::Iter<'de>,
    now: Option<(&'de String, &'de Value)>,
}

impl<'de> Keys<'de> {
    fn of(table: &'de Map<String, Value>) -> Self {
        Self { left: table.iter(), now: None }
    }
}

impl<'de> MapAccess<'de> for Keys<'de> {
    type Error = TreeError;

    #[inline(never)]
    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, TreeError> {
        self.now = self.left.next();
        let key = self.now.map(|(key, _)| {
            seed.deserialize(text(key)).map_err(|error| error.below(Step::Key(key.clone())))
        });
        key.transpose()
    }

    #[inline(never)]
    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, TreeError> {
        let (key, value) = self.now.ok_or_else(|| TreeError::custom("a value before its key"))?;
        seed.deserialize(Tree(value)).map_err(|error| error.below(Step::Key(key.clone())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use std::collections::BTreeMap;

    #[derive(Debug, PartialEq, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Table {
        number: Option<f64>,
        #[serde(default)]
        pairs: Vec<[u32; 2]>,
        #[serde(default)]
        words: BTreeMap<Word, bool>,
    }

    #[derive(Debug, PartialEq, Eq, PartialOrd, Ord, serde::Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Word {
        One,
        Two { after: i64 },
    }

    fn read<'de, T: Deserialize<'de>>(value: &'de Value) -> Result<T, String> {
        T::deserialize(Tree(value)).map_err(|TreeError { steps, message }| {
            let steps = steps.into_iter().map(|step| match step {
                Step::Key(key) => key,
                Step::Index(k) => k.to_string(),
            });
            format!("{}: {message}", steps.collect::<Vec<_>>().join("."))
        })
    }

    #[test]
    fn a_tree_is_read_as_serde_json_reads_it() {
        for tree in [
            json!({ "number": 3, "pairs": [[1, 2], [3, 4]], "words": { "one": true } }),
            json!({ "number": -0.5 }),
            json!({ "number": null }),
            json!({}),
        ] {
            let read = read::<Table>(&tree).unwrap();
            assert_eq!(read, serde_json::from_value(tree).unwrap());
        }
        assert_eq!(read::<Word>(&json!({ "two": { "after": -1 } })), Ok(Word::Two { after: -1 }));
    }

    #[test]
    fn what_is_wrong_is_told_with_the_path_to_it() {
        let wrong = |tree: Value| read::<Table>(&tree).unwrap_err();
        let list = |tree: Value| wrong(json!({ "pairs": tree }));
        assert_eq!(
            list(json!([[1, 2], [3, -4]])),
            "pairs.1.1: invalid value: integer `-4`, expected u32"
        );
        assert_eq!(list(json!([[1, 2, 3]])), "pairs.0: invalid length 3, expected fewer entries");
        assert_eq!(list(json!([[1]])), "pairs.0: invalid length 1, expected an array of length 2");
        assert_eq!(list(json!({})), "pairs: invalid type: map, expected a sequence");
        assert_eq!(
            wrong(json!({ "number": "3" })),
            "number: invalid type: string \"3\", expected f64"
        );
        assert!(wrong(json!({ "numbr": 1 })).starts_with("numbr: unknown field `numbr`, expected"));
        assert!(
            wrong(json!({ "words": { "ten": true } }))
                .starts_with("words.ten: unknown variant `ten`, expected `one` or `two`")
        );
        // a list is no table, though its entries were in the order of the keys
        assert_eq!(wrong(json!([1])), ": invalid type: sequence, expected struct Table");
    }

    #[test]
    fn a_study_without_a_key_is_told_where_it_lacks_it() {
        let error = StudyModel::from_tree(&json!({ "study": { "name": "mine" } })).unwrap_err();
        assert_eq!(error.steps, [Step::Key("study".to_owned())]);
        assert_eq!(error.to_string(), "missing field `description`");
    }
}
