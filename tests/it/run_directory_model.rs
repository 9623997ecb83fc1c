//! Random sequences of actions on run directories against a simple model of what each of them
//! holds: run, kill, resume, extend, merge, flip, verify, report, read, remove. A sequence that
//! fails is shrunk to its shortest form. `OCMC_SEQUENCES=500` tries so many.

use crate::program::ocmc;
use ocmc_fleet::run::RunPlan;
use ocmc_io::given_drive::GivenDrive;
use ocmc_io::records::RecordFormat;
use ocmc_io::run_directory::{CHUNK_ROWS, Manifest, RunDirectory, read, verify};
use ocmc_io::study;
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};
use serde_json::Value;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// The shortest cycles that a study may have.
const TINY: &str = "mission.length_m=200";
/// Directories of a sequence.
const DIRECTORIES: usize = 6;
/// Cycles between places where parts begin and end: not at the ends of chunks.
const STRIDE: u64 = 700;

/// Range and format of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Part {
    first: u64,
    cycles: u64,
    is_csv: bool,
}

impl Part {
    fn format(self) -> RecordFormat {
        if self.is_csv { RecordFormat::Csv } else { RecordFormat::Parquet }
    }

    fn end(self) -> u64 {
        self.first + self.cycles
    }

    fn arguments(self) -> Vec<String> {
        let format = if self.is_csv { "csv" } else { "parquet" };
        let numbers = [("--first-cycle", self.first), ("--cycles", self.cycles)];
        let mut arguments = vec!["--set".to_owned(), TINY.to_owned()];
        arguments.extend(["--format".to_owned(), format.to_owned()]);
        arguments.extend(numbers.iter().flat_map(|(name, n)| [(*name).to_owned(), n.to_string()]));
        arguments
    }
}

/// One action; `at` and `to` are numbers of directories. Most actions take the next directory that
/// holds a run, or the next free one; number 0 is taken as it is.
#[derive(Clone, Debug)]
enum Action {
    Run {
        at: usize,
        part: Part,
    },
    Kill {
        at: usize,
        part: Part,
        chunks: Index,
    },
    Resume {
        at: usize,
        part: Part,
    },
    ResumeWithOtherSeed {
        at: usize,
    },
    Extend {
        at: usize,
        to: usize,
        strides: u64,
    },
    /// Merges a part, those that continue it, and perhaps one more.
    Merge {
        at: usize,
        links: usize,
        more: Option<usize>,
        is_reversed: bool,
        to: usize,
    },
    Flip {
        at: usize,
        file: Index,
        byte: Index,
        bit: u8,
    },
    Verify {
        at: usize,
    },
    Report {
        at: usize,
    },
    Read {
        at: usize,
    },
    Remove {
        at: usize,
    },
}

fn part() -> impl Strategy<Value = Part> {
    (0..3_u64, 1..4_u64, any::<bool>()).prop_map(|(first, cycles, is_csv)| Part {
        first: first * STRIDE,
        cycles: cycles * STRIDE,
        is_csv,
    })
}

fn action() -> impl Strategy<Value = Action> {
    let at = || 0..DIRECTORIES;
    prop_oneof![
        3 => (at(), part()).prop_map(|(at, part)| Action::Run { at, part }),
        2 => (at(), part(), any::<Index>())
            .prop_map(|(at, part, chunks)| Action::Kill { at, part, chunks }),
        3 => (at(), part()).prop_map(|(at, part)| Action::Resume { at, part }),
        1 => at().prop_map(|at| Action::ResumeWithOtherSeed { at }),
        8 => (at(), at(), 1..3_u64)
            .prop_map(|(at, to, strides)| Action::Extend { at, to, strides }),
        4 => (at(), 0..4_usize, option::weighted(0.3, at()), any::<bool>(), at()).prop_map(
            |(at, links, more, is_reversed, to)| Action::Merge { at, links, more, is_reversed, to }
        ),
        2 => (at(), any::<Index>(), any::<Index>(), 0..8_u8)
            .prop_map(|(at, file, byte, bit)| Action::Flip { at, file, byte, bit }),
        2 => at().prop_map(|at| Action::Verify { at }),
        2 => at().prop_map(|at| Action::Report { at }),
        2 => at().prop_map(|at| Action::Read { at }),
        1 => at().prop_map(|at| Action::Remove { at }),
    ]
}

/// A run directory as the model has it.
#[derive(Clone, Debug)]
struct Held {
    part: Part,
    is_complete: bool,
    /// Places of flipped bits, by file.
    flips: BTreeMap<String, BTreeSet<(usize, u8)>>,
}

impl Held {
    /// Files whose bits are not those that were written, but for the report, which nothing reads.
    fn damaged(&self) -> Vec<&str> {
        self.flips.keys().map(String::as_str).filter(|name| *name != "report.html").collect()
    }

    fn is_usable(&self) -> bool {
        self.is_complete && self.damaged().is_empty()
    }
}

/// Bytes of a run that nothing disturbed.
#[derive(Clone)]
struct Undisturbed {
    records: Vec<u8>,
    manifest: Vec<u8>,
    statistics: Value,
}

fn undisturbed(directory: &Path, part: Part) -> Undisturbed {
    let file = |name: &str| fs::read(directory.join(name)).expect("a file of a run");
    let summary: Value = serde_json::from_slice(&file("summary.json")).expect("JSON");
    Undisturbed {
        records: file(part.format().file_name()),
        manifest: file("manifest.json"),
        statistics: summary["statistics"].clone(),
    }
}

/// Files of a folder and of the folders in it, with their bytes.
fn bytes(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let Ok(entries) = fs::read_dir(folder) else { return files };
    for path in entries.map(|entry| entry.expect("an entry").path()) {
        if path.is_dir() {
            files.extend(bytes(&path));
        } else {
            files.insert(path.clone(), fs::read(&path).expect("a file"));
        }
    }
    files
}

/// Directories on the disk, and beside them the model.
struct World<'a> {
    folder: tempfile::TempDir,
    held: [Option<Held>; DIRECTORIES],
    undisturbed: &'a RefCell<BTreeMap<Part, Undisturbed>>,
    /// How often each kind of thing came to pass.
    counts: &'a RefCell<BTreeMap<&'static str, usize>>,
}

impl World<'_> {
    fn path(&self, at: usize) -> PathBuf {
        self.folder.path().join(format!("run-{at}"))
    }

    /// Exit status, and both outputs in one text.
    fn call(&self, words: &[&str], more: &[String]) -> (i32, String) {
        let output = ocmc(words)
            .args(more)
            .current_dir(self.folder.path())
            .output()
            .expect("the program starts");
        let text = [output.stdout, output.stderr].concat();
        let text = String::from_utf8(text).expect("UTF-8");
        assert!(!text.contains("panicked"), "{text}");
        (output.status.code().expect("not killed"), text)
    }

    fn has(&self, at: usize) -> bool {
        self.held[at].is_some()
    }

    /// The next directory, from one on, of which something holds; number 0 is taken as it is.
    fn next(&self, at: usize, holds: impl Fn(Option<&Held>) -> bool) -> usize {
        let mut numbers = (at..DIRECTORIES).chain(0..at);
        let next = numbers.find(|number| holds(self.held[*number].as_ref()));
        next.filter(|_| at > 0).unwrap_or(at)
    }

    fn next_run(&self, at: usize) -> usize {
        self.next(at, |held| held.is_some())
    }

    fn next_whole(&self, at: usize) -> usize {
        self.next(at, |held| held.is_some_and(Held::is_usable))
    }

    fn next_free(&self, at: usize) -> usize {
        self.next(at, |held| held.is_none())
    }

    /// A directory, and up to so many that continue it.
    fn continued(&self, at: usize, links: usize) -> Vec<usize> {
        let mut parts = vec![at];
        let mut end = self.held[at].as_ref().map(|held| held.part.end());
        for _ in 0..links {
            let begins = |held: &Held| held.is_usable() && Some(held.part.first) == end;
            let next = self.held.iter().position(|held| held.as_ref().is_some_and(begins));
            let Some(next) = next else { break };
            end = self.held[next].as_ref().map(|held| held.part.end());
            parts.push(next);
        }
        parts
    }

    fn count(&self, what: &'static str) {
        *self.counts.borrow_mut().entry(what).or_default() += 1;
    }

    /// An action that has to fail, changes nothing and says one of some words.
    fn refused(&self, words: &[&str], more: &[String], one_of: &[&str]) {
        let before = bytes(self.folder.path());
        let (status, text) = self.call(words, more);
        assert!(status != 0, "{words:?} {more:?} was not refused: {text}");
        assert!(one_of.iter().any(|word| text.contains(word)), "none of {one_of:?}: {text}");
        assert!(before == bytes(self.folder.path()), "{words:?} was refused and changed files");
    }

    /// A directory that now has to hold a whole run, by the bytes of one that nothing disturbed.
    fn is_whole_run(&mut self, at: usize, part: Part) {
        let mut known = self.undisturbed.borrow_mut();
        let expected = known.entry(part).or_insert_with(|| {
            let parent = tempfile::tempdir().expect("a directory");
            let out = parent.path().join("whole");
            ocmc(&["--quiet", "--out"]).arg(&out).args(part.arguments()).assert().success();
            undisturbed(&out, part)
        });
        let path = self.path(at);
        let got = undisturbed(&path, part);
        assert!(expected.manifest == got.manifest, "manifest of {part:?}");
        assert!(expected.records == got.records, "records of {part:?}");
        assert_eq!(expected.statistics, got.statistics, "statistics of {part:?}");
        assert!(!path.join("chunks").exists(), "no remnants");
        self.held[at] = Some(Held { part, is_complete: true, flips: BTreeMap::new() });
    }

    fn run(&mut self, at: usize, part: Part) {
        let arguments = part.arguments();
        let out = format!("run-{at}");
        if self.has(at) {
            self.count("runs over another");
            self.refused(&["--quiet", "--out", &out], &arguments, &[&out]);
            return;
        }
        let (status, text) = self.call(&["--quiet", "--out", &out], &arguments);
        assert_eq!(status, 0, "{text}");
        self.is_whole_run(at, part);
    }

    /// A run that is ended by force once so many chunks are on the disk.
    fn kill(&mut self, at: usize, part: Part, chunks: Index) {
        if self.has(at) {
            return;
        }
        let loaded = study::load("field-truck", &[TINY]).expect("a study");
        let given = GivenDrive::nothing();
        let plan = |cycles| RunPlan::new(1, part.first, cycles, None, None);
        let manifest = Manifest::new(&loaded, &plan(part.cycles), &given);
        let mut run = RunDirectory::create(&self.path(at), part.format(), manifest).expect("free");
        let chunk = CHUNK_ROWS as u64;
        let chunks = chunks.index(part.cycles.div_ceil(chunk) as usize) as u64;
        let ended = given.run(&loaded.study, &plan(chunks * chunk), |records| {
            run.add(&records).expect("space");
            ControlFlow::<()>::Continue(())
        });
        assert!(ended.is_continue());
        run.settle().expect("space");
        self.held[at] = Some(Held { part, is_complete: false, flips: BTreeMap::new() });
    }

    fn resume(&mut self, at: usize, part: Part) {
        let out = format!("run-{at}");
        let Some(held) = self.held[at].clone() else {
            // the same command begins a run
            let words = ["--quiet", "--resume", "--out", &out];
            let (status, text) = self.call(&words, &part.arguments());
            assert_eq!(status, 0, "{text}");
            return self.is_whole_run(at, part);
        };
        let words = ["--quiet", "--resume", "--out", &out];
        let damaged = held.damaged();
        if !damaged.is_empty() {
            self.count("resumed though damaged");
            return self.refused(&words, &[], &damaged);
        }
        let before = held.is_complete.then(|| bytes(&self.path(at)));
        let (status, text) = self.call(&words, &[]);
        assert_eq!(status, 0, "{text}");
        if let Some(before) = before {
            assert!(before == bytes(&self.path(at)), "a whole run was changed");
        } else {
            self.count("resumed");
            self.is_whole_run(at, held.part);
        }
    }

    fn resume_with_other_seed(&self, at: usize) {
        if self.has(at) {
            let out = format!("run-{at}");
            let words = ["--quiet", "--resume", "--seed", "2", "--out", &out];
            self.refused(&words, &[], &["--seed", "checksum", "manifest"]);
        }
    }

    fn extend(&mut self, at: usize, to: usize, strides: u64) {
        if let (Some(held), false) = (&self.held[at], self.has(to)) {
            let part = Part { first: held.part.end(), cycles: strides * STRIDE, ..held.part };
            self.run(to, part);
        }
    }

    fn merge(&mut self, parts: &[usize], to: usize) {
        let names: Vec<String> = parts.iter().map(|at| format!("run-{at}")).collect();
        let out = format!("run-{to}");
        let words = ["merge", "--quiet", "--out", &out];
        if self.has(to) {
            return self.refused(&words, &names, &[&out]);
        }
        let held: Option<Vec<&Held>> = parts.iter().map(|at| self.held[*at].as_ref()).collect();
        let usable = held.filter(|held| held.iter().all(|held| held.is_usable()));
        let Some(usable) = usable else {
            self.count("merges of what is not whole");
            let one_of: Vec<&str> = names.iter().map(String::as_str).collect();
            return self.refused(&words, &names, &one_of);
        };
        let mut ranges: Vec<Part> = usable.iter().map(|held| held.part).collect();
        let is_csv = ranges[0].is_csv;
        ranges.sort();
        if ranges.windows(2).any(|pair| pair[0].end() != pair[1].first) {
            self.count("merges of what does not fit");
            return self.refused(&words, &names, &["missing", "overlap"]);
        }
        let first = ranges[0].first;
        let cycles = ranges.iter().map(|part| part.cycles).sum();
        let (status, text) = self.call(&words, &names);
        assert_eq!(status, 0, "{text}");
        self.count(if parts.len() > 1 { "merges" } else { "merges of one part" });
        self.is_whole_run(to, Part { first, cycles, is_csv });
    }

    fn flip(&mut self, at: usize, file: Index, byte: Index, bit: u8) {
        let path = self.path(at);
        let Some(held) = &mut self.held[at] else { return };
        let is_kept =
            |path: &Path, bytes: &[u8]| !bytes.is_empty() && !path.ends_with("checksums.sha256");
        let files: Vec<(PathBuf, Vec<u8>)> =
            bytes(&path).into_iter().filter(|(path, bytes)| is_kept(path, bytes)).collect();
        let (file, mut bytes) = files[file.index(files.len())].clone();
        let byte = byte.index(bytes.len());
        bytes[byte] ^= 1 << bit;
        fs::write(&file, bytes).expect("space");
        let name = file.strip_prefix(&path).expect("below it").to_str().expect("UTF-8").to_owned();
        let flips = held.flips.entry(name.clone()).or_default();
        // a second flip of the same bit mends it
        if !flips.insert((byte, bit)) {
            flips.remove(&(byte, bit));
        }
        if flips.is_empty() {
            held.flips.remove(&name);
        }
    }

    fn verify(&self, at: usize) {
        let out = format!("run-{at}");
        let (status, text) = self.call(&["verify", &out], &[]);
        let Some(held) = &self.held[at] else {
            assert!(status != 0 && text.contains(&out), "{text}");
            return;
        };
        assert_eq!(status == 0, held.flips.is_empty(), "{held:?}: {text}");
        let answer = verify(&self.path(at)).expect("a run");
        let faulty = answer.files.into_iter().filter(|file| file.fault.is_some());
        let faulty: BTreeSet<String> = faulty.map(|file| file.name).collect();
        if !held.flips.contains_key("manifest.json") {
            assert_eq!(faulty, held.flips.keys().cloned().collect(), "{text}");
        }
        assert!(held.flips.keys().all(|name| text.contains(name.as_str())), "{held:?}: {text}");
    }

    fn report(&mut self, at: usize) {
        let out = format!("run-{at}");
        let words = ["report", "--quiet", &out];
        match &mut self.held[at] {
            Some(held) if held.is_usable() => {
                // it is written anew
                held.flips.remove("report.html");
                let (status, text) = self.call(&words, &[]);
                assert_eq!(status, 0, "{text}");
                assert!(self.path(at).join("report.html").exists());
            }
            _ => self.refused(&words, &[], &[&out]),
        }
    }

    fn read(&self, at: usize) {
        let answer = read(&self.path(at));
        match &self.held[at] {
            Some(held) if held.is_usable() => {
                let stored = answer.expect("a whole run");
                let ids: Vec<u64> = stored.records.iter().map(|record| record.cycle_id).collect();
                assert_eq!(ids, (held.part.first..held.part.end()).collect::<Vec<_>>());
                let is_complete = stored.manifest.completed == held.part.cycles;
                assert!(is_complete, "{} cycles", stored.manifest.completed);
            }
            held => {
                let error = answer.expect_err("not whole").to_string();
                assert!(error.contains(&format!("run-{at}")), "{held:?}: {error}");
            }
        }
    }

    fn apply(&mut self, action: &Action) {
        match *action {
            Action::Run { at, part } => self.run(self.next_free(at), part),
            Action::Kill { at, part, chunks } => self.kill(self.next_free(at), part, chunks),
            Action::Resume { at, part } => self.resume(self.next_run(at), part),
            Action::ResumeWithOtherSeed { at } => self.resume_with_other_seed(self.next_run(at)),
            Action::Extend { at, to, strides } => {
                self.extend(self.next_whole(at), self.next_free(to), strides);
            }
            Action::Merge { at, links, more, is_reversed, to } => {
                let mut parts = self.continued(self.next_whole(at), links);
                parts.extend(more.map(|at| self.next_whole(at)));
                if is_reversed {
                    parts.reverse();
                }
                self.merge(&parts, self.next_free(to));
            }
            Action::Flip { at, file, byte, bit } => self.flip(self.next_run(at), file, byte, bit),
            Action::Verify { at } => self.verify(self.next_run(at)),
            Action::Report { at } => self.report(self.next_run(at)),
            Action::Read { at } => self.read(self.next_run(at)),
            Action::Remove { at } => {
                if self.held[at].take().is_some() {
                    fs::remove_dir_all(self.path(at)).expect("there");
                }
            }
        }
    }
}

#[test]
fn run_directories_are_what_a_simple_model_says() {
    let asked = std::env::var("OCMC_SEQUENCES");
    let cases = asked.map_or(12, |number| number.parse().expect("a number"));
    let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
    // the same sequences in each run of the tests
    let random = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let (undisturbed, counts) = (RefCell::default(), RefCell::default());
    let result = TestRunner::new_with_rng(config, random).run(&vec(action(), 12..28), |actions| {
        let folder = tempfile::tempdir().expect("a directory");
        let mut world =
            World { folder, held: Default::default(), undisturbed: &undisturbed, counts: &counts };
        for action in &actions {
            world.apply(action);
        }
        Ok(())
    });
    result.expect("every sequence as the model has it");
    let counts = counts.into_inner();
    println!("{counts:?}");
    assert_eq!(counts.len(), 7, "a kind that never came to pass: {counts:?}");
}
