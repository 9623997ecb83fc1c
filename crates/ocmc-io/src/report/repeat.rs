//! How a run is repeated exactly: its study as a command names it, and the commands.

use super::svg::escaped;
use super::{Reported, tables};
use crate::given_drive::Followed;
use crate::records::RecordFormat;
use crate::run_directory::Manifest;
use crate::shell_word::{quoted, shell_word};
use crate::study::{self, settings_from};
use std::fmt::Write;
use std::path::Path;

/// Most settings, and their length in characters, beyond which a file is easier to handle.
const MOST_SETTINGS: usize = 6;
const MOST_CHARACTERS: usize = 300;

/// The file that a study has to be saved to where no name and no settings stand for it.
const FILE: &str = "study.toml";

/// How a command names the study of a run.
pub(super) struct Repeat {
    /// A built-in study, with settings; none where its text has to be saved to a file.
    built_in: Option<(String, Vec<String>)>,
}

impl Repeat {
    /// Looks for the built-in study that becomes that of the run by a few settings.
    pub(super) fn of(manifest: &Manifest) -> Self {
        let own = manifest.value("study.name");
        let own = own.as_ref().and_then(|name| name.as_str()).unwrap_or_default();
        let named = study::list().iter().find(|built_in| built_in.name == own);
        let sets = named.and_then(|named| settings_from(named.name, &manifest.resolved_study));
        let sets = sets.filter(|sets| {
            let characters: usize = sets.iter().map(String::len).sum();
            sets.len() <= MOST_SETTINGS && characters <= MOST_CHARACTERS
        });
        let is_same = |sets: &Vec<String>| {
            let again = study::load(own, sets);
            again.is_ok_and(|again| study::study_hash(&again.model) == manifest.study_hash)
        };
        Self { built_in: sets.filter(is_same).map(|sets| (own.to_owned(), sets)) }
    }

    /// Whether the study has to be saved first.
    pub(super) fn takes_file(&self) -> bool {
        self.built_in.is_none()
    }

    /// The options that name the study.
    pub(super) fn options(&self) -> String {
        let Some((name, sets)) = &self.built_in else { return format!("--study {FILE}") };
        let sets = sets.iter().map(|set| format!(" --set {}", quoted(set)));
        format!("--study {name}{}", sets.collect::<String>())
    }

    /// The command that drives the run again, with what has to be done before.
    pub(super) fn section(&self, run: &Reported) -> String {
        let manifest = &run.manifest;
        let mut command = match &manifest.followed {
            None => "ocmc".to_owned(),
            Some(Followed { how, file, .. }) => {
                let file = shell_word(Path::new(file));
                format!("ocmc drive {file} --follow-speed {}", how.name())
            }
        };
        let _ = write!(command, " {} --seed {}", self.options(), manifest.seed);
        if manifest.first_cycle > 0 {
            let _ = write!(command, " --first-cycle {}", manifest.first_cycle);
        }
        let _ = write!(command, " --cycles {}", manifest.cycles);
        if manifest.records == RecordFormat::Csv.file_name() {
            command.push_str(" --format csv");
        }
        command.push_str(" --out again");
        let first = if self.takes_file() { Self::first(manifest) } else { String::new() };
        format!(
            "<h2>Repeat this run</h2>\n{first}<pre class=\"command\" tabindex=\"0\">{}</pre>\n<p \
             class=\"soft\">It gives the same bytes of records, on any machine and with any \
             number of threads, with the same version of the program ({}).</p>\n",
            escaped(&command),
            escaped(&manifest.program_version)
        )
    }

    /// Steps before a command of this page is typed.
    pub(super) fn first(manifest: &Manifest) -> String {
        let there = if manifest.routes().iter().all(|route| route.table.is_some()) {
            ""
        } else {
            " in the folder in which the run was started: that is where its routes are named from"
        };
        format!("<p>Save {} as <code>{FILE}</code> first{there}.</p>\n", tables::THE_WHOLE_STUDY)
    }
}

/// The command that shows one cycle of this run step by step, where the study alone gives it.
pub(super) fn trace_command(run: &Reported, repeat: &Repeat, cycle_id: u64) -> String {
    if run.manifest.followed.is_some() {
        return "–".to_owned();
    }
    let (seed, options) = (run.manifest.seed, escaped(&repeat.options()));
    format!(
        "<code>ocmc trace {options} --seed {seed} --cycle-id {cycle_id} --out \
         cycle-{cycle_id}.csv</code>"
    )
}
