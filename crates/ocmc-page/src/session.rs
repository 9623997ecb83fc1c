//! Session of a person at the page: files, in a folder of their own, and the questions that are
//! under way.

use crate::http::Refusal;
use ocmc_api::ask::{Ask, AskRun, Message, ask, keep_run, study_answer};
use ocmc_api::study::Files;
use ocmc_api::{Error, Progress, Reported, Watch, report, stored_workbook};
use std::collections::HashMap;
use std::fs;
use std::mem::{Discriminant, discriminant};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use tempfile::TempDir;

/// Longest name of a file, in bytes.
const MOST_NAME: usize = 200;
/// Most files, and most bytes of all of them.
const MOST_FILES: usize = 500;
const MOST_BYTES: u64 = 1 << 30;

/// Kind of a question, whether its answer is saved, and the tab that asks.
type Kind = (Discriminant<Ask>, bool, String);

/// The files of a person, and the questions under way.
#[derive(Debug)]
pub(crate) struct Session {
    folder: TempDir,
    /// Lengths of the files by their names.
    lengths: Mutex<HashMap<String, u64>>,
    /// Numbers of the newest question of each kind of each tab.
    newest: Mutex<HashMap<Kind, u64>>,
    asked: AtomicU64,
    ended: AtomicBool,
}

impl Session {
    /// # Errors
    /// Where the system has no room for files.
    pub(crate) fn new() -> std::io::Result<Self> {
        Ok(Self {
            folder: tempfile::Builder::new().prefix("ocmc-page-").tempdir()?,
            lengths: Mutex::default(),
            newest: Mutex::default(),
            asked: AtomicU64::new(0),
            ended: AtomicBool::new(false),
        })
    }

    /// The folder of the files.
    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Ends all questions.
    pub(crate) fn end(&self) {
        self.ended.store(true, Ordering::Relaxed);
    }

    pub(crate) fn is_ended(&self) -> bool {
        self.ended.load(Ordering::Relaxed)
    }

    /// Takes a file.
    ///
    /// # Errors
    /// The refusal of a name that leads elsewhere, or of too much.
    pub(crate) fn put(&self, name: &str, bytes: &[u8]) -> Result<(), Refusal> {
        let path = self.path(name)?;
        let mut lengths = self.lengths.lock().expect("nobody panics with it");
        let others = lengths.iter().filter(|(other, _)| *other != name);
        let (count, total) =
            others.fold((1, bytes.len() as u64), |(n, sum), (_, length)| (n + 1, sum + length));
        if count > MOST_FILES || total > MOST_BYTES {
            return Err(Refusal(413, "more than 500 files, or 1 GB in all"));
        }
        fs::write(path, bytes).map_err(|_| Refusal(500, "the file cannot be kept"))?;
        lengths.insert(name.to_owned(), bytes.len() as u64);
        Ok(())
    }

    /// Forgets a file.
    ///
    /// # Errors
    /// The refusal of a name that leads elsewhere, or of none of the files.
    pub(crate) fn remove(&self, name: &str) -> Result<(), Refusal> {
        let path = self.path(name)?;
        let mut lengths = self.lengths.lock().expect("nobody panics with it");
        lengths.remove(name).ok_or(Refusal(404, "no such file"))?;
        fs::remove_file(path).map_err(|_| Refusal(500, "the file cannot be removed"))
    }

    fn path(&self, name: &str) -> Result<PathBuf, Refusal> {
        let is_plain = !name.is_empty()
            && name.len() <= MOST_NAME
            && !name.starts_with('.')
            && !name.chars().any(|c| c.is_control() || "/\\:*?\"<>|".contains(c));
        let path = || self.folder.path().join(name);
        is_plain.then(path).ok_or(Refusal(400, "not a plain name of a file"))
    }

    /// The files that a study may name: those of the person, which lie in the folder that the
    /// server runs in, so that answers name them as the person does.
    fn files() -> Files {
        Files::Within(PathBuf::new())
    }

    /// Answers a question, line by line. A newer question of its kind from the same tab, a peer
    /// that is gone and the end of the server end it.
    pub(crate) fn ask(
        &self,
        tab: &str,
        question: &[u8],
        say: &mut dyn FnMut(&Message) -> bool,
        is_gone: &mut dyn FnMut() -> bool,
    ) {
        let asked = match question_of(question) {
            Ok(asked) => asked,
            Err(reason) => {
                say(&Message::Refused { reason });
                return;
            }
        };
        let message = {
            let mut look = |progress| {
                if is_gone() || !say(&Message::Progress(progress)) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            };
            let watch = &mut self.watched((discriminant(&asked), false, tab.to_owned()), &mut look);
            match ask(&asked, &Self::files(), watch) {
                Ok(reply) => Message::Answer(Box::new(reply)),
                Err(Error::Interrupted(progress)) => Message::Interrupted(progress),
                Err(error) => Message::Refused { reason: error.to_string() },
            }
        };
        say(&message);
    }

    /// A watch that breaks where a newer question of the kind has come, or all are to end.
    fn watched<'a>(
        &'a self,
        kind: Kind,
        look: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> impl FnMut(Progress) -> ControlFlow<()> + 'a {
        let own = self.asked.fetch_add(1, Ordering::Relaxed);
        self.newest.lock().expect("nobody panics with it").insert(kind.clone(), own);
        move |progress| {
            let newest = self.newest.lock().expect("nobody panics with it")[&kind];
            if newest != own || self.is_ended() { ControlFlow::Break(()) } else { look(progress) }
        }
    }

    /// The file that a run is saved as.
    ///
    /// # Errors
    /// The reason for people where there is none.
    pub(crate) fn save(
        &self,
        name: &str,
        tab: &str,
        question: &[u8],
        is_gone: &mut dyn FnMut() -> bool,
    ) -> Result<Vec<u8>, String> {
        let asked = question_of(question)?;
        let kind = (discriminant(&asked), true, tab.to_owned());
        let Ask::Run(asked) = asked else {
            return Err("a run is saved, and this is another question".to_owned());
        };
        let mut look =
            |_| if is_gone() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let watch = &mut self.watched(kind, &mut look);
        saved(name, &asked, watch)
    }
}

fn saved(name: &str, asked: &AskRun, watch: &mut Watch) -> Result<Vec<u8>, String> {
    if name == "study.toml" {
        let study = study_answer(&asked.study, None, &Session::files());
        return study.map(|study| study.toml.into_bytes()).map_err(|error| error.to_string());
    }
    let room = tempfile::tempdir().map_err(|error| error.to_string())?;
    let directory = room.path().join("run");
    let run = keep_run(asked, &Session::files(), &directory, watch);
    run.map_err(|error| error.to_string())?;
    if name == "report.html" {
        let run = Reported::read(&directory).map_err(|error| error.to_string())?;
        return Ok(report(&run).into_bytes());
    }
    let path = stored_workbook(&directory, None).map_err(|error| error.to_string())?;
    fs::read(path).map_err(|error| error.to_string())
}

fn question_of(text: &[u8]) -> Result<Ask, String> {
    serde_json::from_slice(text).map_err(|error| format!("no question: {error}"))
}
