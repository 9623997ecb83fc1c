//! The tree of a study file, in which every value knows where it was written.

use super::error::{Cause, DECIMAL_POINT, Fault, NO_UNIT};
use super::source::{Place, Source, SourceKind, cut};
use ocmc_core::study::tree::Step;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use toml::de::{DeTable, DeValue};

/// Deepest nesting of tables and lists.
pub(super) const MOST_DEPTH: usize = 64;
/// Longest value that a message shows, in characters.
const SHOWN_VALUE: usize = 60;

/// Keys of tables whose numbers are the probabilities of names, so that one of them alone says
/// nothing.
pub(super) const PROBABILITIES: [&str; 2] = ["next", "ground"];

/// A value of a study file.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) content: Content,
    /// The value's text.
    pub(super) place: Option<Place>,
    /// The text of the key in front of it.
    pub(super) key_place: Option<Place>,
}

/// Content of a [`Node`].
#[derive(Clone, Debug)]
pub(super) enum Content {
    Table(BTreeMap<String, Node>),
    List(Vec<Node>),
    Scalar(toml::Value),
}

impl Node {
    pub(super) fn new(content: Content, place: Option<Place>) -> Self {
        Self { content, place, key_place: None }
    }

    /// Reads a TOML document.
    pub(super) fn parse(source: &Arc<Source>) -> Result<Self, Box<Fault>> {
        let text = Text { source, offset: 0 };
        let document = DeTable::parse(&source.text).map_err(|error| text.syntax(&error, 0..0))?;
        let content = Content::Table(text.entries(document.get_ref(), 0)?);
        Ok(Self::new(content, Some(text.place(0..0))))
    }

    /// Reads one TOML value, which begins `offset` bytes into the source.
    pub(super) fn parse_value(source: &Arc<Source>, offset: usize) -> Result<Self, Box<Fault>> {
        let text = Text { source, offset };
        let written = source.text[offset..].trim_end();
        let value =
            DeValue::parse(written).map_err(|error| text.syntax(&error, 0..written.len()))?;
        text.node(value.get_ref(), text.place(value.span()), 0)
    }

    /// Reads a dictionary of the same shape as a study file.
    pub(super) fn from_json(value: &serde_json::Value) -> Result<Self, Box<Fault>> {
        let node = json(value, "", 0)?;
        if matches!(node.content, Content::Table(_)) {
            return Ok(node);
        }
        Err(Fault::not_allowed("a study", node.shown(), "a table"))
    }

    /// The value as a study is read from it.
    pub(super) fn to_json(&self) -> serde_json::Value {
        match &self.content {
            Content::Table(entries) => {
                let pairs = entries.iter().map(|(key, node)| (key.clone(), node.to_json()));
                serde_json::Value::Object(pairs.collect())
            }
            Content::List(items) => {
                serde_json::Value::Array(items.iter().map(Self::to_json).collect())
            }
            // what no key takes, so that a date is refused as any other value of a wrong kind
            Content::Scalar(toml::Value::Datetime(_)) => serde_json::json!([null]),
            Content::Scalar(value) => serde_json::to_value(value).expect("one value"),
        }
    }

    pub(super) fn get(&self, key: &str) -> Option<&Self> {
        match &self.content {
            Content::Table(entries) => entries.get(key),
            _ => None,
        }
    }

    pub(super) fn get_mut(&mut self, key: &str) -> Option<&mut Self> {
        self.entries_mut()?.get_mut(key)
    }

    pub(super) fn entries_mut(&mut self) -> Option<&mut BTreeMap<String, Node>> {
        match &mut self.content {
            Content::Table(entries) => Some(entries),
            _ => None,
        }
    }

    pub(super) fn as_str(&self) -> Option<&str> {
        match &self.content {
            Content::Scalar(value) => value.as_str(),
            _ => None,
        }
    }

    /// Children of a table or a list, each with the step that leads to it.
    pub(super) fn children(&self) -> Vec<(Step, &Self)> {
        match &self.content {
            Content::Table(entries) => {
                entries.iter().map(|(key, node)| (Step::Key(key.clone()), node)).collect()
            }
            Content::List(items) => {
                items.iter().enumerate().map(|(k, node)| (Step::Index(k), node)).collect()
            }
            Content::Scalar(_) => Vec::new(),
        }
    }

    fn below(&self, step: &Step) -> Option<&Self> {
        match (&self.content, step) {
            (Content::Table(entries), Step::Key(key)) => entries.get(key),
            (Content::List(items), Step::Index(index)) => items.get(*index),
            _ => None,
        }
    }

    fn below_mut(&mut self, step: &Step) -> Option<&mut Self> {
        match (&mut self.content, step) {
            (Content::Table(entries), Step::Key(key)) => entries.get_mut(key),
            (Content::List(items), Step::Index(index)) => items.get_mut(*index),
            _ => None,
        }
    }

    /// Follows the steps as far as they lead: the last value reached, and whether it is the wanted
    /// one.
    pub(super) fn follow(&self, steps: &[Step]) -> (&Self, bool) {
        let mut here = self;
        for step in steps {
            let Some(next) = here.below(step) else { return (here, false) };
            here = next;
        }
        (here, true)
    }

    /// Puts a content at the end of the steps, where they lead to a value.
    pub(super) fn put(&mut self, steps: &[Step], content: Content) {
        if let Some(end) = steps.iter().try_fold(self, |node, step| node.below_mut(step)) {
            end.content = content;
        }
    }

    /// The value as it was written, for a message.
    pub(super) fn shown(&self) -> String {
        match (&self.content, &self.place) {
            (Content::Table(_), _) => "a table".to_owned(),
            (Content::Scalar(value @ toml::Value::String(_)), _) => {
                cut(&value.to_string(), SHOWN_VALUE)
            }
            (_, Some(place)) if !place.span.is_empty() => place.text(SHOWN_VALUE),
            (Content::List(_), _) => "a list".to_owned(),
            (Content::Scalar(value), _) => cut(&value.to_string(), SHOWN_VALUE),
        }
    }

    /// Where the value was written; its key, where the value itself has no text of its own.
    pub(super) fn any_place<'a>(&'a self) -> Option<&'a Place> {
        match &self.content {
            Content::Table(entries) => {
                let own = self.key_place.as_ref().or(self.place.as_ref());
                own.or_else(|| {
                    let key = |node: &'a Self| node.key_place.as_ref().or_else(|| node.any_place());
                    entries.values().find_map(key)
                })
            }
            _ => self.place.as_ref().or(self.key_place.as_ref()),
        }
    }

    /// Lays another tree over this one. Tables are merged key by key; a law (a table with the key
    /// `distribution`), probabilities (a table whose numbers add up to one), a list and a scalar
    /// replace what is below. Numbers as keys over a list change its entries.
    ///
    /// # Errors
    /// [`Cause::NoEntry`] where a list has no such entry.
    pub(super) fn overlay(&mut self, over: Self) -> Result<(), Box<Fault>> {
        self.overlay_at(over, &mut Vec::new())
    }

    /// As [`Node::overlay`], of a tree that these steps lead to.
    fn overlay_at(&mut self, over: Self, steps: &mut Vec<Step>) -> Result<(), Box<Fault>> {
        let shares = over.is_written() && is_probabilities(steps);
        let merged = match (&self.content, &over.content) {
            (Content::List(below), Content::Table(above)) if over.names_entries() => {
                check_entries(below.len(), above, steps)?;
                true
            }
            (Content::Table(below), Content::Table(above)) => {
                // an empty table would leave a law as it is
                let empties = above.is_empty() && below.contains_key("distribution");
                !(shares || above.contains_key("distribution") || empties)
            }
            _ => false,
        };
        let (place, key_place) = (over.place, over.key_place);
        match over.content {
            Content::Table(above) if merged => {
                for (key, node) in above {
                    let step = match self.content {
                        Content::List(_) => Step::Index(key.parse().unwrap_or_default()),
                        _ => Step::Key(key.clone()),
                    };
                    if let Some(below) = self.below_mut(&step) {
                        steps.push(step);
                        below.overlay_at(node, steps)?;
                        steps.pop();
                    } else if let Some(entries) = self.entries_mut() {
                        entries.insert(key, node);
                    }
                }
                // the tables of a setting have no place and leave that of the file
                self.place = place.or(self.place.take());
                self.key_place = key_place.or(self.key_place.take());
            }
            content => *self = Self { content, place, key_place },
        }
        Ok(())
    }

    /// Whether this table is written, and does not stand for the steps of a setting.
    fn is_written(&self) -> bool {
        self.place.is_some() || self.key_place.is_some()
    }

    /// Whether the keys of a table can only mean entries of a list: all are numbers, or the table
    /// stands for the steps of a setting.
    fn names_entries(&self) -> bool {
        let Content::Table(entries) = &self.content else { return false };
        let numbers = entries.keys().all(|key| key.parse::<usize>().is_ok());
        let steps = !self.is_written()
            && self.any_place().is_some_and(|place| place.source.kind == SourceKind::Setting);
        !entries.is_empty() && (numbers || steps)
    }
}

/// Checks that a list of so many entries, to which the steps lead, has an entry for each key.
fn check_entries(
    length: usize,
    keys: &BTreeMap<String, Node>,
    steps: &[Step],
) -> Result<(), Box<Fault>> {
    let is_entry = |key: &String| key.parse::<usize>().is_ok_and(|k| k < length);
    let Some((index, node)) = keys.iter().find(|(key, _)| !is_entry(key)) else { return Ok(()) };
    let (key, index) = (path_of(steps), cut(index, SHOWN_VALUE));
    let cause = Cause::NoEntry { key, index, entries: length };
    Err(Fault::new(cause).at(node.key_place.as_ref().or(node.any_place())))
}

/// Whether the steps lead to a table of probabilities, one for each name: where a road goes on,
/// what its ground is.
fn is_probabilities(steps: &[Step]) -> bool {
    matches!(steps.last(), Some(Step::Key(key)) if PROBABILITIES.contains(&key.as_str()))
}

/// A source whose parsed part begins at an offset.
struct Text<'a> {
    source: &'a Arc<Source>,
    offset: usize,
}

impl Text<'_> {
    /// Fault of a text that is not TOML: at its place, or in the whole of what was parsed.
    fn syntax(&self, error: &toml::de::Error, whole: Range<usize>) -> Box<Fault> {
        let place = self.place(error.span().unwrap_or(whole));
        let fault = Fault::new(Cause::Syntax(error.message().to_owned())).at(Some(&place));
        let (before, after) =
            self.source.text.split_at_checked(place.span.start).unwrap_or_default();
        let digit = |letter: Option<char>| letter.is_some_and(|letter| letter.is_ascii_digit());
        // the place of a number with its unit behind it is its first digit, or what follows the
        // last
        let in_word = |letter: &char| letter.is_alphanumeric() || matches!(letter, ' ' | '.');
        let word: String = after.chars().take_while(in_word).collect();
        let word = word.trim();
        let mut after = after.chars();
        let (next, second, last) = (after.next(), after.next(), before.chars().last());
        if next == Some(',') && digit(second) && digit(last) {
            return fault.help(DECIMAL_POINT);
        }
        let letter = |letter: Option<char>| letter.is_some_and(char::is_alphabetic);
        let from_digit = digit(word.chars().next()) && letter(word.chars().last());
        if from_digit || letter(next) && digit(last) { fault.help(NO_UNIT) } else { fault }
    }
    fn place(&self, span: Range<usize>) -> Place {
        Place::new(self.source, span.start + self.offset..span.end + self.offset)
    }

    fn entries(&self, table: &DeTable, depth: usize) -> Result<BTreeMap<String, Node>, Box<Fault>> {
        let mut entries = BTreeMap::new();
        for (key, value) in table {
            let mut child = self.node(value.get_ref(), self.place(value.span()), depth + 1)?;
            child.key_place = Some(self.place(key.span()));
            entries.insert(key.get_ref().to_string(), child);
        }
        Ok(entries)
    }

    fn node(&self, value: &DeValue, place: Place, depth: usize) -> Result<Node, Box<Fault>> {
        if depth > MOST_DEPTH {
            return Err(Fault::new(Cause::TooDeep(MOST_DEPTH)).at(Some(&place)));
        }
        let content = match value {
            DeValue::Table(table) => Content::Table(self.entries(table, depth)?),
            DeValue::Array(items) => {
                let items =
                    items.iter().map(|v| self.node(v.get_ref(), self.place(v.span()), depth + 1));
                Content::List(items.collect::<Result<_, _>>()?)
            }
            DeValue::String(text) => Content::Scalar(text.as_ref().into()),
            DeValue::Boolean(value) => Content::Scalar((*value).into()),
            DeValue::Datetime(value) => Content::Scalar((*value).into()),
            DeValue::Integer(integer) => {
                Content::Scalar(match i64::from_str_radix(integer.as_str(), integer.radix()) {
                    Ok(integer) => integer.into(),
                    // too many digits for an integer: still a number
                    Err(_) => integer.as_str().parse().unwrap_or(f64::INFINITY).into(),
                })
            }
            // a float beyond the range of doubles reads as infinite and is refused as such
            DeValue::Float(float) => {
                Content::Scalar(float.as_str().parse().unwrap_or(f64::NAN).into())
            }
        };
        Ok(Node::new(content, Some(place)))
    }
}

fn json(value: &serde_json::Value, key: &str, depth: usize) -> Result<Node, Box<Fault>> {
    use serde_json::Value;
    if depth > MOST_DEPTH {
        return Err(Fault::new(Cause::TooDeep(MOST_DEPTH)));
    }
    let below = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
    let content = match value {
        Value::Object(table) => {
            let mut entries = BTreeMap::new();
            for (name, value) in table {
                entries.insert(name.clone(), json(value, &below(name), depth + 1)?);
            }
            Content::Table(entries)
        }
        Value::Array(items) => {
            let item = |(k, item)| json(item, &format!("{key}[{k}]"), depth + 1);
            let items = items.iter().enumerate().map(item);
            Content::List(items.collect::<Result<_, _>>()?)
        }
        Value::String(text) => Content::Scalar(text.as_str().into()),
        Value::Bool(value) => Content::Scalar((*value).into()),
        Value::Number(number) => match number.as_i64() {
            Some(integer) => Content::Scalar(integer.into()),
            None => Content::Scalar(number.as_f64().unwrap_or(f64::NAN).into()),
        },
        Value::Null => {
            let allowed = "a value; leave the key out where there is none";
            return Err(Fault::not_allowed(key, "null or nan", allowed));
        }
    };
    Ok(Node::new(content, None))
}

/// Steps as one path, such as `vehicle.axles[1].tyres`.
pub(super) fn path_of(steps: &[Step]) -> String {
    let mut path = String::new();
    for step in steps {
        match step {
            Step::Key(key) => {
                if !path.is_empty() {
                    path.push('.');
                }
                let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
                if !key.is_empty() && key.chars().all(bare) {
                    path.push_str(key);
                } else {
                    path.push_str(&cut(&format!("{key:?}"), SHOWN_VALUE));
                }
            }
            Step::Index(index) => path.extend(["[", &index.to_string(), "]"]),
        }
    }
    path
}
