//! Inheritance of a study: `study.base`, `study.drop` and `vehicle.base`, which core knows nothing
//! of.
//!
//! A study inherits another by `study.base`, a vehicle by `vehicle.base`; both are a built-in name
//! or a file beside the one that names it; a vehicle may be another program's, too. What is
//! inherited loses the paths in `study.drop`, then the study's own keys are laid over it.

use super::builtin::{Kind, STUDY, Text, VEHICLE, read};
use super::error::{Cause, Fault};
use super::files::{Files, ForeignVehicle};
use super::node::{Content, Node, path_of};
use super::source::Place;
use ocmc_core::study::tree::Step;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Longest chain of studies that derive from one another.
const MOST_BASES: usize = 8;

/// Resolves the bases of a study that names such files. `notes`: what a vehicle of another program
/// says and is not used.
pub(super) fn resolve(
    mut own: Node,
    files: &Files,
    depth: usize,
    notes: &mut Vec<String>,
) -> Result<Node, Box<Fault>> {
    let study_base = take(&mut own, "study", "base");
    let drop = take(&mut own, "study", "drop");
    let vehicle_base = take(&mut own, "vehicle", "base");

    let mut inherited = Node::new(Content::Table(BTreeMap::new()), None);
    if let Some(base) = study_base {
        let (tree, file) = parse_base(&base, "study.base", STUDY, files, depth, notes)?;
        inherited = resolve(tree, &files.beside(file.as_deref()), depth + 1, notes)?;
    }
    if let Some(base) = vehicle_base {
        // a vehicle that is replaced has nothing to say
        notes.clear();
        let (mut vehicle, _) = parse_base(&base, "vehicle.base", VEHICLE, files, depth, notes)?;
        vehicle.key_place.clone_from(&base.key_place);
        if let Some(entries) = inherited.entries_mut() {
            entries.insert("vehicle".to_owned(), vehicle);
        }
    }
    if let Some(drop) = drop {
        remove_all(&mut inherited, &drop)?;
    }
    inherited.overlay(own)?;
    Ok(inherited)
}

fn take(node: &mut Node, table: &str, key: &str) -> Option<Node> {
    node.get_mut(table)?.entries_mut()?.remove(key)
}

fn parse_base(
    base: &Node,
    key: &'static str,
    kind: Kind,
    files: &Files,
    depth: usize,
    notes: &mut Vec<String>,
) -> Result<(Node, Option<PathBuf>), Box<Fault>> {
    let Some(name) = base.as_str() else {
        let fault = Fault::not_allowed(key, base.shown(), "a name or a file, in quotation marks");
        return Err(fault.at(base.any_place()));
    };
    if depth >= MOST_BASES {
        let cause = Cause::BaseChain { key, name: name.to_owned(), limit: MOST_BASES };
        return Err(Fault::new(cause).at(base.any_place()));
    }
    if kind.is_vehicle()
        && let Some((vehicle, path)) = files.foreign(name)
    {
        return Ok((foreign(vehicle, base, notes)?, Some(path)));
    }
    let Text { source, file } =
        read(Path::new(name), key, kind, files).map_err(|fault| fault.at(base.any_place()))?;
    let tree = Node::parse(&source);
    let tree = if file.is_some() { tree.map_err(|fault| unquoted(&fault, base)) } else { tree };
    Ok((tree?, file))
}

/// A vehicle of another program; what its file does not say is that of a built-in vehicle.
fn foreign(
    vehicle: Result<ForeignVehicle, String>,
    base: &Node,
    notes: &mut Vec<String>,
) -> Result<Node, Box<Fault>> {
    let fault = |error| Fault::new(Cause::File(error)).at(base.any_place());
    let ForeignVehicle { keys, base, notes: of_vehicle } = vehicle.map_err(fault)?;
    notes.extend(of_vehicle);
    let beneath = read(Path::new(base), "vehicle.base", VEHICLE, &Files::Refused)?;
    let mut vehicle = Node::parse(&beneath.source)?;
    vehicle.overlay(Node::from_json(&keys)?)?;
    Ok(vehicle)
}

/// Fault of a file that is no TOML, without a line of it: it may be any file, and the study a
/// stranger's.
fn unquoted(fault: &Fault, base: &Node) -> Box<Fault> {
    let place = fault.place.as_ref().map_or_else(String::new, Place::label);
    let ending = base.as_str().map(Path::new).and_then(Path::extension);
    if let (Cause::Syntax(_), Some(ending)) = (&fault.cause, ending.filter(|end| *end != "toml")) {
        let message = format!(
            "{place}: a base is a study in TOML, and this file ends in `.{}`; a vehicle of VECTO \
             or FASTSim is named by `vehicle.base`",
            ending.display()
        );
        return Fault::new(Cause::File(message)).at(base.any_place());
    }
    Fault::new(Cause::File(format!("{place}: {}", fault.message()))).at(base.any_place())
}

fn remove_all(inherited: &mut Node, drop: &Node) -> Result<(), Box<Fault>> {
    let wrong_type = |node: &Node| {
        let allowed = "a list of inherited paths, such as [\"road.types.rural\"]";
        Fault::not_allowed("study.drop", node.shown(), allowed).at(node.any_place())
    };
    let Content::List(paths) = &drop.content else {
        return Err(wrong_type(drop));
    };
    for node in paths {
        let path = node.as_str().ok_or_else(|| wrong_type(node))?;
        remove(inherited, path).map_err(|(wrong, names)| {
            let fault = Fault::new(Cause::NothingToDrop(path.to_owned()));
            fault.at(node.any_place()).suggest(&wrong, &names)
        })?;
    }
    Ok(())
}

/// Removes a path; otherwise the step that leads nowhere, and those that were possible.
fn remove(node: &mut Node, path: &str) -> Result<(), (String, Vec<String>)> {
    let (first, rest) = path.split_once('.').map_or((path, None), |(a, b)| (a, Some(b)));
    let none = || (first.to_owned(), Vec::new());
    let entries = node.entries_mut().ok_or_else(none)?;
    if !entries.contains_key(first) {
        let names = entries.keys().map(|key| path_of(&[Step::Key(key.clone())]));
        return Err((first.to_owned(), names.collect()));
    }
    match (rest, entries.get_mut(first)) {
        (Some(rest), Some(below)) => remove(below, rest),
        _ => entries.remove(first).map(drop).ok_or_else(none),
    }
}
