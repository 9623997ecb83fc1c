//! Study files: the built-in ones and those of a user, from a name to a checked study or to an
//! error for people.
//!
//! ```
//! use ocmc_io::study;
//! let loaded = study::load("field-truck", &["driver.curve_speed.exponent=0.5"])?;
//! assert!(loaded.model.driver.curve_speed.exponent == 0.5);
//! let error = study::load("field-truk", &[] as &[&str]).unwrap_err();
//! assert!(error.to_string().contains("did you mean `field-truck`?"));
//! # Ok::<(), study::StudyFileError>(())
//! ```
//!
//! A study may hold only what differs from another one:
//!
//! - `study.base`: a built-in name or a file beside this one. Tables are merged key by key; a list,
//!   a number, a law (a table with the key `distribution`) and the probabilities of `next` and
//!   `ground` replace what was inherited.
//! - `study.drop`: a list of inherited paths that go before that, such as
//!   `["road.types.rural", "traffic.types.rural"]`.
//! - `vehicle.base`: a built-in vehicle or a file with the keys of `[vehicle]`, instead of an
//!   inherited vehicle.
//!
//! Groups of a fleet, `[[fleet.group]]`, are a study each.
//!
//! Settings (`--set key.path=VALUE`) win over the file; numbers in their path are places in a list,
//! from 0.

mod base;
pub mod builtin;
mod commented;
mod difference;
mod error;
mod fastsim;
mod fault;
mod files;
mod fitted;
mod groups;
mod init;
mod judged;
mod judged_effect;
mod judged_scale;
mod node;
mod routes;
mod schema;
mod setting;
mod source;
mod vehicle_input;

pub use builtin::{BuiltIn, list, show, text, vehicles};
use builtin::{STANDARD_INPUT, STUDY, Text, read, standard_input};
pub(crate) use commented::{KeyValue, in_words, keys_of, settings_from};
pub use commented::{commented, init_text_of};
pub use difference::{KeyDifference, differences, differences_text};
pub use error::{Cause, Fault, StudyFileError, nearest};
pub use files::{Files, ForeignVehicle, VehicleReader};
pub use fitted::{Estimate, FittedPart, StudyPart, fitted_study, study_of_parts};
pub use groups::{FleetGroup, Opened};
pub use init::init_text;
use judged::Judged;
pub use judged::{End, JudgedKey, JudgedNumbers, ReplacedNumber};
pub(crate) use judged_effect::share_words;
pub use judged_effect::{JudgedDoubt, NumbersShare, StoredDoubt};
pub use judged_scale::MovedNumber;
pub use schema::schema;
pub use setting::{alternatives, value_of};
pub use source::{Place, Source, SourceKind};

use crate::given_cycle::{self, RouteOptions};
use crate::intake::table::Mapping;
use crate::intake::{Finding, study_value};
use crate::sha256;
use node::Node;
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::route::{Keep, RouteModel};
use ocmc_core::study::tree::Step;
use ocmc_core::study::{Study, StudyModel};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A study that has been read and checked.
#[derive(Clone, Debug)]
pub struct LoadedStudy {
    /// The study as it is written, bases resolved.
    pub model: StudyModel,
    /// The study, prepared for sampling.
    pub study: Study,
    /// Where it comes from.
    pub origin: Origin,
    /// The study's own tree, settings included, bases not resolved.
    own: Node,
    /// Where the files lie that it names.
    files: Files,
    /// Values of the file of a vehicle of another program that are not used.
    notes: Vec<String>,
    /// Between which values its judged numbers lie.
    judged: Judged,
}

impl LoadedStudy {
    /// Between which values its judged numbers plausibly lie: those that nobody has changed.
    pub fn judged(&self) -> &[JudgedNumbers] {
        &self.judged.numbers
    }

    /// Numbers that were judged and that others have replaced.
    pub fn replaced(&self) -> &[ReplacedNumber] {
        &self.judged.replaced
    }

    /// Effect of the judged numbers on the mean consumption, as far as it is known without driving;
    /// none where all of them have been replaced.
    pub fn judged_doubt(&self) -> Option<JudgedDoubt> {
        let on_routes = !self.model.mission.routes.is_empty();
        judged_effect::of(&self.judged, &study_hash(&self.model), on_routes)
    }

    /// Entries of its judged numbers, those first that do most to the mean consumption, as far as
    /// effects are stored: by the study that it derives from, or else by any.
    pub fn judged_by_effect(&self) -> Vec<&JudgedNumbers> {
        judged_effect::sorted(&self.judged)
    }

    /// Its own keys, settings included, bases not resolved.
    pub fn own(&self) -> serde_json::Value {
        self.own.to_json()
    }

    /// The files that it may name.
    pub fn files(&self) -> &Files {
        &self.files
    }

    /// Warnings of checks: of unusual numbers, of what is not used of another program's vehicle,
    /// and of the files of its routes.
    pub fn warnings(&self) -> Vec<String> {
        let numbers = study_value::judge(&self.model);
        let mut warnings: Vec<String> = numbers.iter().map(Finding::to_string).collect();
        warnings.extend(self.notes.iter().cloned());
        for route in &self.model.mission.routes {
            let path = Path::new(&route.file);
            let of_file = || {
                let mappings = Mapping::of_columns(&route.columns).ok()?;
                let stop_plan = route.stop_plan.as_deref().map(Path::new);
                let (draw, table) = (&route.draw, route.table.as_deref());
                let options = RouteOptions { mappings: &mappings, draw, stop_plan, table };
                given_cycle::read_route(path, options).ok()
            };
            // a route that is built in has been read by us
            let read = if given_cycle::built_in(path).is_some() { None } else { of_file() };
            warnings.extend(read.into_iter().flat_map(|(_, account)| account.warnings()));
        }
        warnings.extend(self.above_law());
        warnings
    }

    /// Warning of signs of given routes above what the law allows the vehicle.
    pub fn above_law(&self) -> Option<String> {
        let [way_m, sign_mps, legal_mps] = self.study.operating_cycle().above_law()?;
        let [sign_kmh, legal_kmh] = [sign_mps, legal_mps].map(|mps| 3.6 * mps);
        Some(format!(
            "limits of up to {sign_kmh:.0} km/h on {:.1} km of the given roads are above what the \
             law lets a {} drive there, {legal_kmh:.0} km/h, which holds: `vehicle.class` is the \
             class, `road.types` has its limits [limit-above-class]",
            way_m / 1000.0,
            self.model.vehicle.class
        ))
    }

    /// The study with more settings, as if [`load`] had met them behind those that it has.
    ///
    /// # Errors
    /// As [`load`].
    pub fn set<S: AsRef<str>>(&self, sets: &[S]) -> Result<Self, StudyFileError> {
        finish(self.own.clone(), self.files.clone(), sets, self.origin.clone())
    }

    /// The study on given routes instead of its own roads: files as
    /// [`crate::given_cycle::read_route`] reads them. A file that the study lists under
    /// `mission.routes` keeps its weight, others weigh 1; `keep` is what they all keep.
    ///
    /// # Errors
    /// [`StudyFileError`] says what is wrong with which file.
    pub fn on_routes(
        mut self,
        files: &[PathBuf],
        keep: &[Keep],
        options: RouteOptions,
    ) -> Result<Self, StudyFileError> {
        let columns = Mapping::columns(options.mappings);
        let listed = std::mem::take(&mut self.model.mission.routes);
        let weight = |file: &Path| {
            let same = |route: &&RouteModel| Path::new(&route.file).file_name() == file.file_name();
            listed.iter().find(same).map_or(1.0, |route| route.weight)
        };
        let route = |file: &PathBuf| RouteModel {
            file: file.display().to_string(),
            weight: weight(file),
            keep: keep.to_vec(),
            draw: options.draw.to_vec(),
            columns: columns.clone(),
            sha256: None,
            stop_plan: options.stop_plan.map(|plan| plan.display().to_string()),
            stop_plan_sha256: None,
            table: options.table.map(str::to_owned),
        };
        self.model.mission.routes = files.iter().map(route).collect();
        let study = routes::attach(self.study, &mut self.model, &Files::here());
        let study = study.map_err(|(_, fault)| fault)?;
        Ok(Self { study, ..self })
    }

    /// The study whose drivers take every sign at its place.
    pub(crate) fn with_signs_in_place(mut self) -> Self {
        let mut model = self.study.model().clone();
        if model.driver.speed_limit.sign_offset_m.take().is_some() {
            self.study = self.study.with_model(model).expect("a study without one of its laws");
        }
        self
    }

    /// The study on one given cycle, which was made from a file that is not itself a route; `keep`
    /// is what is taken from it instead of being drawn.
    ///
    /// # Errors
    /// As [`LoadedStudy::on_routes`].
    pub fn on_route(
        self,
        file: &Path,
        cycle: GivenCycle,
        keep: &[Keep],
    ) -> Result<Self, StudyFileError> {
        let study = self.study.with_routes(vec![(cycle, 1.0, keep.to_vec(), Vec::new())]);
        let study =
            study.map_err(|(_, error)| routes::fault(&given_cycle::in_file(file)(error)))?;
        Ok(Self { study, ..self })
    }
}

/// Where a study comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Part of the program.
    BuiltIn(String),
    /// A file.
    File(PathBuf),
    /// A dictionary of a calling program.
    Dictionary,
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::BuiltIn(name) => f.write_str(name),
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Dictionary => f.write_str("the dictionary"),
        }
    }
}

/// Reads and checks a built-in study or a file, with settings laid over it. A built-in name wins
/// over a file.
///
/// # Errors
/// [`StudyFileError`] says what is wrong, where, and what is allowed.
pub fn load<S: AsRef<str>>(name_or_path: &str, sets: &[S]) -> Result<LoadedStudy, StudyFileError> {
    open(&Given::Named(Path::new(name_or_path)), &Files::here(), sets)
}

/// A study that is given.
#[derive(Clone, Copy, Debug)]
pub enum Given<'a> {
    /// By the name of a built-in one, by that of a file, or as `-`, which is standard input.
    Named(&'a Path),
    /// As the text of a study file, with what it is called in messages.
    Text(&'a str, &'a str),
    /// As a dictionary of the same shape as a study file, `base` and `drop` included.
    Dictionary(&'a serde_json::Value),
}

/// Reads and checks a study that may name files in a folder, or none at all.
///
/// ```
/// use ocmc_io::study::{Files, Given, open};
/// let study = "vehicle.base = \"/etc/passwd\"\nstudy.base = \"field-truck\"";
/// let error = open(&Given::Text("a", study), &Files::Refused, &[] as &[&str]).unwrap_err();
/// assert!(error.to_string().contains("`vehicle.base` names a file"));
/// ```
///
/// # Errors
/// As [`load`].
pub fn open<S: AsRef<str>>(
    given: &Given,
    files: &Files,
    sets: &[S],
) -> Result<LoadedStudy, StudyFileError> {
    open_all(given, files, sets)?.one()
}

/// As [`open`], of a study or of all groups of a fleet.
///
/// # Errors
/// As [`load`].
pub fn open_all<S: AsRef<str>>(
    given: &Given,
    files: &Files,
    sets: &[S],
) -> Result<Opened, StudyFileError> {
    let (own, files, origin) = match *given {
        Given::Named(name) if name == Path::new(STANDARD_INPUT) && files.take_standard_input() => {
            let source = Arc::new(standard_input()?);
            (Node::parse(&source)?, files.clone(), Origin::File(source.name.clone().into()))
        }
        Given::Named(name) => {
            let Text { source, file } = read(name, "study", STUDY, files)?;
            let files = files.beside(file.as_deref());
            let origin = file.map_or_else(|| Origin::BuiltIn(source.name.clone()), Origin::File);
            (Node::parse(&source)?, files, origin)
        }
        Given::Text(name, text) => {
            let source = Source { kind: SourceKind::File, name: name.into(), text: text.into() };
            let own = Node::parse(&Arc::new(source))?;
            (own, files.clone(), Origin::File(name.into()))
        }
        Given::Dictionary(tree) => (Node::from_json(tree)?, files.clone(), Origin::Dictionary),
    };
    groups::open_groups(own, &files, sets, &origin)
}

/// Reads and checks the text of a study file that is called `name` in messages.
///
/// # Errors
/// As [`load`].
pub fn load_text<S: AsRef<str>>(
    name: &str,
    text: &str,
    sets: &[S],
) -> Result<LoadedStudy, StudyFileError> {
    open(&Given::Text(name, text), &Files::here(), sets)
}

/// Checks a dictionary of the same shape as a study file, `base` and `drop` included.
///
/// # Errors
/// As [`load`].
pub fn load_json<S: AsRef<str>>(
    dictionary: &serde_json::Value,
    sets: &[S],
) -> Result<LoadedStudy, StudyFileError> {
    open(&Given::Dictionary(dictionary), &Files::here(), sets)
}

fn finish<S: AsRef<str>>(
    mut own: Node,
    files: Files,
    sets: &[S],
    origin: Origin,
) -> Result<LoadedStudy, StudyFileError> {
    let mut settings = sets.iter().map(|set| setting::parse(set.as_ref()));
    let laid = settings.try_for_each(|set| own.overlay(set?)).map_err(StudyFileError::from);
    let checked = laid.and_then(|()| check(&own, &files));
    let Checked { model, study, notes, judged } = checked.map_err(|mut error| {
        fault::note_inherited(&mut error, Some(&origin.to_string()));
        error
    })?;
    Ok(LoadedStudy { model, study, origin, own, files, notes, judged })
}

/// The study of a tree, bases resolved.
struct Checked {
    model: StudyModel,
    study: Study,
    /// Values of another program's vehicle that are not used.
    notes: Vec<String>,
    judged: Judged,
}

fn check(own: &Node, files: &Files) -> Result<Checked, StudyFileError> {
    let mut notes = Vec::new();
    let mut tree = base::resolve(own.clone(), files, 0, &mut notes)?;
    vehicle_input::expand(&mut tree, files)?;
    let judged = judged::take(&mut tree)?;
    let faults = [fault::hidden_letters(&tree), fault::not_finite(&tree)].concat();
    if !faults.is_empty() {
        return Err(StudyFileError { faults });
    }
    let mut model =
        StudyModel::from_tree(&tree.to_json()).map_err(|error| fault::from_serde(&tree, error))?;
    let study = Study::new(model.clone())
        .and_then(|study| study.check_sides().map(|()| study))
        .map_err(|error| StudyFileError { faults: fault::from_core(&tree, error) })?;
    let study = routes::attach(study, &mut model, files).map_err(|(k, fault)| {
        let steps = ["mission", "routes"].map(|key| Step::Key(key.to_owned()));
        let (node, _) = tree.follow(&[&steps[..], &[Step::Index(k)]].concat());
        StudyFileError::from(fault.at(node.any_place()))
    })?;
    Ok(Checked { model, study, notes, judged })
}

/// The text of a study file with these keys.
pub fn study_text(keys: &serde_json::Value) -> String {
    toml::to_string(keys).expect("a study is tables, lists, numbers and words")
}

/// The fully resolved study as TOML; it loads to the same study.
pub fn resolved_toml(model: &StudyModel) -> String {
    toml::to_string(&model.to_tree()).expect("a study is tables, lists, numbers and words")
}

/// SHA-256, in hexadecimal digits, of the resolved study: of its JSON without blanks, keys in the
/// order of their names.
///
/// Two studies with the same hash give the same records under the same seed and program version.
pub fn study_hash(model: &StudyModel) -> String {
    hash_of_tree(model.to_tree())
}

/// The hash of a resolved study by its TOML; none where it is no TOML.
pub fn hash_of_resolved(text: &str) -> Option<String> {
    let tree: toml::Table = text.parse().ok()?;
    Some(hash_of_tree(serde_json::to_value(tree).ok()?))
}

fn hash_of_tree(mut tree: serde_json::Value) -> String {
    tree.sort_all_objects();
    sha256::of_bytes(tree.to_string().as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_SETS: &[&str] = &[];

    #[test]
    fn a_resolved_study_loads_to_the_same_study() {
        for built_in in builtin::STUDIES {
            let model = load(built_in.name, NO_SETS).unwrap().model;
            let text = resolved_toml(&model);
            assert!(!text.contains("base ="), "{text}");
            assert_eq!(load_text("resolved.toml", &text, NO_SETS).unwrap().model, model);
            assert_eq!(hash_of_resolved(&text), Some(study_hash(&model)));
        }
    }

    #[test]
    fn the_hash_tells_studies_apart_and_nothing_else() {
        let hash = |set: &[&str]| study_hash(&load("field-truck", set).unwrap().model);
        let default = hash(&[]);
        assert_eq!(default.len(), 64);
        assert_eq!(default, hash(&["simulation.step_s=1.5"]));
        assert_ne!(default, hash(&["simulation.step_s=0.1"]));
        assert_ne!(default, hash(&["study.name=other"]));
    }
}
