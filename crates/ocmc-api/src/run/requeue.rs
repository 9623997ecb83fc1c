//! One request for the first start of a run and for every restart, as a requeued job makes it.

use super::{
    CpuLevel, Manifest, Precision, RecordFormat, ResumeRequest, RunAnswer, RunDirectoryError,
    RunPlan, RunRequest, read_manifest, resume, run,
};
use crate::error::Error;
use crate::study::{Files, Given, LoadedStudy, open};
use crate::watch::Watch;
use ocmc_io::given_drive::GivenDrive;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// Trucks of a run where nothing is said of their number.
const LEAST_TRUCKS: u64 = 20;

/// Stated properties of a run. A property that is not stated is that of the run that is there, or
/// the default.
#[derive(Clone, Debug, Default)]
pub struct Asked<'a> {
    /// Name of a built-in study, or a study file; `field-truck` by default.
    pub study: Option<&'a Path>,
    /// A study that was read already, in its place.
    pub loaded: Option<&'a LoadedStudy>,
    /// The files that it may name.
    pub files: Files,
    /// Keys that are set in it.
    pub sets: &'a [String],
    /// Master seed; 1 by default.
    pub seed: Option<u64>,
    /// Id of the first cycle; 0 by default.
    pub first_cycle: Option<u64>,
    /// Number of cycles; 1000 by default, and at most 1 000 000 with a precision; then rounded up
    /// to whole trucks, at least 20 of them.
    pub cycles: Option<u64>,
    /// Number of trucks, in place of cycles.
    pub trucks: Option<u64>,
    /// At which precision the run may end before its last cycle.
    pub precision: Option<Precision>,
    /// Format of the records; Parquet by default.
    pub format: Option<RecordFormat>,
}

impl Asked<'_> {
    /// The study.
    ///
    /// # Errors
    /// [`Error::Study`].
    pub fn load(&self) -> Result<LoadedStudy, Error> {
        match self.loaded {
            Some(loaded) if self.sets.is_empty() => return Ok(loaded.clone()),
            Some(loaded) => return Ok(loaded.set(self.sets)?),
            None => {}
        }
        let study = Given::Named(self.study.unwrap_or(Path::new("field-truck")));
        Ok(open(&study, &self.files, self.sets)?)
    }

    /// The cycles, and on what they are driven.
    pub fn plan(
        &self,
        study: &LoadedStudy,
        threads: Option<usize>,
        chunk: Option<u64>,
        level: CpuLevel,
    ) -> RunPlan {
        let trips = study.study.nesting().trips_per_truck;
        let cycles: u64 = if self.precision.is_some() { 1_000_000 } else { 1000 };
        let cycles = match trips {
            1 => cycles,
            trips => cycles.next_multiple_of(trips).max(LEAST_TRUCKS * trips),
        };
        let first_cycle = self.first_cycle.unwrap_or(0);
        let cycles = self.asked_cycles(trips).unwrap_or(cycles);
        RunPlan {
            level,
            ..RunPlan::new(self.seed.unwrap_or(1), first_cycle, cycles, threads, chunk)
        }
    }

    /// The number of cycles that is said, where a truck makes so many trips.
    fn asked_cycles(&self, trips_per_truck: u64) -> Option<u64> {
        self.trucks.map(|trucks| trucks.saturating_mul(trips_per_truck)).or(self.cycles)
    }

    /// Properties that are stated otherwise than in a run that is there.
    fn differences(&self, manifest: &Manifest, given: &GivenDrive) -> Result<Vec<String>, Error> {
        let mut differences = Vec::new();
        let mut compare = |name: &str, asked: Option<u64>, has: u64| match asked {
            Some(asked) if asked != has => {
                differences.push(format!("--{name} is {asked}, and {has} in the run"));
            }
            _ => (),
        };
        compare("seed", self.seed, manifest.seed);
        compare("first-cycle", self.first_cycle, manifest.first_cycle);
        // a run that knew its answer precisely enough has ended with fewer cycles
        let has_all = manifest.completed == manifest.cycles;
        let reached = self.precision.is_some() && has_all;
        let cycles = self.asked_cycles(manifest.dependence().trips_per_truck);
        if !(reached && cycles.is_none_or(|cycles| manifest.cycles <= cycles)) {
            compare("cycles", cycles, manifest.cycles);
            if self.precision.is_some() && self.precision != manifest.precision {
                differences.push("--precision is another one than that of the run".to_owned());
            }
        }
        if let Some(format) = self.format
            && format.file_name() != manifest.records
        {
            let (asked, has) = (format.file_name(), &manifest.records);
            differences.push(format!("--format makes `{asked}`, and the run has `{has}`"));
        }
        if self.study.is_some() || self.loaded.is_some() || !self.sets.is_empty() {
            let stored = Given::Text("manifest.json", &manifest.resolved_study);
            let stored = |sets: &[String]| open(&stored, &self.files, sets);
            let asked = match (self.study, self.loaded) {
                (None, None) => stored(self.sets)?,
                _ => given.study(self.load()?)?,
            };
            differences.extend(different_keys(&asked, &stored(&[])?));
        }
        Ok(differences)
    }
}

/// Keys of a study that say another thing in another one.
fn different_keys(asked: &LoadedStudy, run: &LoadedStudy) -> Vec<String> {
    let keys = |study: &LoadedStudy| {
        let mut keys = BTreeMap::new();
        leaves(&study.model.to_tree(), "", &mut keys);
        keys
    };
    let (asked, run) = (keys(asked), keys(run));
    let shown = |value: Option<&Value>| value.map_or("absent".to_owned(), Value::to_string);
    let names = asked.keys().chain(run.keys().filter(|name| !asked.contains_key(*name)));
    let different = names.filter(|name| asked.get(*name) != run.get(*name)).map(|name| {
        let (asked, run) = (shown(asked.get(name)), shown(run.get(name)));
        format!("`{name}` is {asked}, and {run} in the run")
    });
    different.collect()
}

/// The values of a tree that are no tables, by their paths.
fn leaves(value: &Value, path: &str, values: &mut BTreeMap<String, Value>) {
    let Value::Object(table) = value else {
        values.insert(path.to_owned(), value.clone());
        return;
    };
    for (key, value) in table {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        leaves(value, &path, values);
    }
}

/// A run that is begun where there is none, and finished where there is one.
#[derive(Clone, Debug)]
pub struct RequeueRequest<'a> {
    /// Its directory.
    pub directory: &'a Path,
    /// Stated properties of the run.
    pub asked: Asked<'a>,
    /// Drives that replace the study's roads.
    pub given: &'a GivenDrive,
    /// Threads; one for each CPU where there is no number.
    pub threads: Option<usize>,
    /// Cycles that a thread drives at a time.
    pub chunk: Option<u64>,
    /// Instructions to use.
    pub level: CpuLevel,
}

/// Begins a run where there is none, and finishes it where there is one.
///
/// ```
/// use ocmc_api::{Asked, CpuLevel, Error, GivenDrive, RequeueRequest, RunEnd, go_on, requeue};
/// let folder = tempfile::tempdir().expect("a directory");
/// let directory = &folder.path().join("a");
/// let sets = &["mission.length_m=3000".to_owned()];
/// let asked = Asked { sets, cycles: Some(4), ..Asked::default() };
/// let (given, level) = (&GivenDrive::nothing(), CpuLevel::best());
/// let request = RequeueRequest { directory, asked, given, threads: None, chunk: None, level };
/// assert_eq!(requeue(&request, &mut go_on)?.ended, RunEnd::Complete);
/// assert_eq!(requeue(&request, &mut go_on)?.ended, RunEnd::WasComplete);
/// let asked = Asked { seed: Some(2), ..request.asked.clone() };
/// let refused = requeue(&RequeueRequest { asked, ..request }, &mut go_on);
/// assert!(matches!(refused, Err(Error::Differs { .. })));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Differs`] where the run is another one than is said, and those of [`run`] and of
/// [`resume`].
pub fn requeue(request: &RequeueRequest, watch: &mut Watch) -> Result<RunAnswer, Error> {
    let RequeueRequest { directory, asked, given, threads, chunk, level } = request;
    let (threads, chunk, level) = (*threads, *chunk, *level);
    let manifest = match read_manifest(directory) {
        Err(RunDirectoryError::NotARun { .. }) => {
            let study = &asked.load()?;
            let plan = asked.plan(study, threads, chunk, level);
            let out = Some((directory.to_path_buf(), asked.format.unwrap_or_default()));
            let precision = asked.precision.clone();
            let request = RunRequest { study, given, plan, precision, out };
            return run(&request, &mut |_| (), watch);
        }
        read => read?,
    };
    let differences = asked.differences(&manifest, given)?;
    if !differences.is_empty() {
        return Err(Error::Differs { directory: directory.to_path_buf(), differences });
    }
    let files = &asked.files;
    resume(&ResumeRequest { directory, files, given, threads, chunk, level }, watch)
}
