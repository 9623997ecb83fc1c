//! Groups of trucks of one kind within a fleet: `[[fleet.group]]`, each a study of its own.
//!
//! A group has a name, a number of trucks, and tables of a study that are laid over those of the
//! file, as a study is over its base. `study` names another base. Where a group has a `study` or
//! a vehicle with a base, the vehicle of the file does not count.

use super::error::{Cause, Fault, StudyFileError};
use super::node::{Content, Node};
use super::{Files, LoadedStudy, Origin, finish};
use std::collections::BTreeMap;

/// Most trucks of a group.
const MOST_TRUCKS: u64 = 1_000_000;
/// Longest name of a group, which names a folder, in characters.
const LONGEST_NAME: usize = 60;

/// A group of a fleet.
#[derive(Clone, Debug)]
pub struct FleetGroup {
    /// Name of the group.
    pub name: String,
    /// Number of its trucks.
    pub trucks: u64,
    /// Study that they drive.
    pub study: LoadedStudy,
}

/// A study file that was read.
#[derive(Clone, Debug)]
pub enum Opened {
    /// One study.
    Study(Box<LoadedStudy>),
    /// A fleet of groups.
    Fleet(Vec<FleetGroup>),
}

impl Opened {
    /// The one study.
    ///
    /// # Errors
    /// [`StudyFileError`] where it is a fleet of groups.
    pub fn one(self) -> Result<LoadedStudy, StudyFileError> {
        match self {
            Self::Study(study) => Ok(*study),
            Self::Fleet(groups) => {
                let names: Vec<&str> = groups.iter().map(|group| group.name.as_str()).collect();
                let help = format!(
                    "choose one of them: --set fleet.group={}; `ocmc --study FILE` drives all",
                    names.first().unwrap_or(&"")
                );
                Err(Fault::new(Cause::SeveralGroups(names.join(", "))).help(help).into())
            }
        }
    }
}

/// Reads the groups of a file's own tree; one study where there are none, or where a setting
/// chooses one of them.
pub(super) fn open_groups<S: AsRef<str>>(
    mut own: Node,
    files: &Files,
    sets: &[S],
    origin: &Origin,
) -> Result<Opened, StudyFileError> {
    let (chosen, sets): (Vec<&str>, Vec<&str>) =
        sets.iter().map(AsRef::as_ref).partition(|set| chosen_group(set).is_some());
    let list = own.get_mut("fleet").and_then(Node::entries_mut);
    let Some(list) = list.and_then(|fleet| fleet.remove("group")) else {
        if let Some(set) = chosen.first() {
            let allowed = "the name of a group, and this study has no `[[fleet.group]]`";
            return Err(Fault::not_allowed("fleet.group", *set, allowed).into());
        }
        return Ok(Opened::Study(Box::new(finish(own, files.clone(), &sets, origin.clone())?)));
    };
    let wrong = || {
        let allowed = "a list of tables `[[fleet.group]]`, each with `name` and `trucks`";
        Fault::not_allowed("fleet.group", list.shown(), allowed).at(list.any_place())
    };
    let Content::List(items) = &list.content else { return Err(wrong().into()) };
    if items.is_empty() {
        return Err(wrong().into());
    }
    let mut groups: Vec<FleetGroup> = Vec::new();
    let mut names: Vec<String> = Vec::new();
    let chosen = chosen.last().and_then(|set| chosen_group(set));
    for (k, item) in items.iter().enumerate() {
        let Content::Table(entries) = &item.content else { return Err(wrong().into()) };
        let mut entries = entries.clone();
        let name = name_of(&mut entries, item, k, &names)?;
        let trucks = trucks_of(&mut entries, item, k)?;
        names.push(name.clone());
        if chosen.is_some_and(|chosen| chosen != name) {
            continue;
        }
        let tree = tree_of(&own, entries, &name, k)?;
        let study = finish(tree, files.clone(), &sets, origin.clone())?;
        groups.push(FleetGroup { name, trucks, study });
    }
    let Some(chosen) = chosen else { return Ok(Opened::Fleet(groups)) };
    if let Some(group) = groups.pop() {
        return Ok(Opened::Study(Box::new(group.study)));
    }
    let fault = Fault::not_allowed("fleet.group", chosen, "the name of a group");
    Err(fault.suggest(chosen, &names).into())
}

/// The group that a setting chooses.
fn chosen_group(set: &str) -> Option<&str> {
    let (key, name) = set.split_once('=')?;
    let name = name.trim().trim_matches(['"', '\'']);
    (key.trim() == "fleet.group" && !name.starts_with(['[', '{'])).then_some(name)
}

fn key(k: usize, name: &str) -> String {
    format!("fleet.group.{k}.{name}")
}

fn name_of(
    entries: &mut BTreeMap<String, Node>,
    item: &Node,
    k: usize,
    before: &[String],
) -> Result<String, Box<Fault>> {
    let allowed = "a name of letters, digits, `-`, `_` and blanks that no other group has";
    let Some(node) = entries.remove("name") else {
        let missing =
            Cause::Missing { key: key(k, "name"), allowed: format!(", allowed is {allowed}") };
        return Err(Fault::new(missing).at(item.any_place()));
    };
    let is_fine = |name: &&str| {
        let letters = name.chars().all(|c| c.is_alphanumeric() || "-_ ".contains(c));
        let short = !name.is_empty() && name.chars().count() <= LONGEST_NAME;
        letters && short && name.trim() == *name && !before.iter().any(|other| other == name)
    };
    let name = node.as_str().filter(is_fine).map(str::to_owned);
    name.ok_or_else(|| {
        Fault::not_allowed(key(k, "name"), node.shown(), allowed).at(node.any_place())
    })
}

fn trucks_of(
    entries: &mut BTreeMap<String, Node>,
    item: &Node,
    k: usize,
) -> Result<u64, Box<Fault>> {
    let allowed = format!("a whole number from 1 to {MOST_TRUCKS}");
    let Some(node) = entries.remove("trucks") else {
        let missing =
            Cause::Missing { key: key(k, "trucks"), allowed: format!(", allowed is {allowed}") };
        return Err(Fault::new(missing).at(item.any_place()));
    };
    let number = match &node.content {
        Content::Scalar(value) => value.as_integer(),
        _ => None,
    };
    let number = number.and_then(|n| u64::try_from(n).ok());
    number.filter(|n| (1..=MOST_TRUCKS).contains(n)).ok_or_else(|| {
        Fault::not_allowed(key(k, "trucks"), node.shown(), allowed).at(node.any_place())
    })
}

/// The study of a group as a tree.
fn tree_of(
    own: &Node,
    mut entries: BTreeMap<String, Node>,
    name: &str,
    k: usize,
) -> Result<Node, Box<Fault>> {
    let mut tree = own.clone();
    let base = match entries.get("study") {
        Some(node) if node.as_str().is_some() => entries.remove("study"),
        Some(node) if !matches!(node.content, Content::Table(_)) => {
            let allowed = "the name of a study, or of its file";
            let fault = Fault::not_allowed(key(k, "study"), node.shown(), allowed);
            return Err(fault.at(node.any_place()));
        }
        _ => None,
    };
    let vehicle = entries.get("vehicle").is_some_and(|vehicle| vehicle.get("base").is_some());
    if let Some(tables) = tree.entries_mut() {
        if base.is_some() || vehicle {
            tables.remove("vehicle");
        }
        let table = || Node::new(Content::Table(BTreeMap::new()), None);
        let study = tables.entry("study".to_owned()).or_insert_with(table);
        if let Some(study) = study.entries_mut() {
            let fleet = study.get("name").and_then(Node::as_str).unwrap_or("fleet").to_owned();
            let named = Content::Scalar(format!("{fleet}, {name}").into());
            study.insert("name".to_owned(), Node::new(named, None));
            study.extend(base.map(|base| ("base".to_owned(), base)));
        }
    }
    tree.overlay(Node::new(Content::Table(entries), None))?;
    Ok(tree)
}
