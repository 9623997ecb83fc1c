//! `ocmc ask`: answers a question that is JSON, for pages and other programs.

use crate::arguments::FileOptions;
use crate::failure::Failure;
use crate::interrupt::{self, Patience};
use crate::output;
use clap::Args;
use ocmc_api::Error;
use ocmc_api::ask::{Ask, Message, ask};
use std::io::Read;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Time between two messages of how far the work is.
const TICK: Duration = Duration::from_millis(200);

/// Largest question, in bytes: a study with its parameters is a hundredth of it.
const LARGEST: u64 = 16 << 20;

/// A question as JSON.
#[derive(Clone, Debug, Args)]
pub(crate) struct AskArguments {
    /// File with the question, one object of JSON, or `-` for standard input
    #[arg(value_name = "FILE", default_value = "-")]
    file: PathBuf,
    #[command(flatten)]
    files: FileOptions,
    /// No messages of how far the work is
    #[arg(long)]
    quiet: bool,
}

/// Answers it on standard output, one message a line.
pub(crate) fn ask_question(arguments: &AskArguments) -> Result<(), Failure> {
    let AskArguments { file, files, quiet } = arguments;
    interrupt::listen(Patience::Short);
    let question = match read(file) {
        Ok(question) => question,
        Err(reason) => return refused(Failure::NoQuestion(reason)),
    };
    let mut told = Instant::now();
    let mut watch = |progress| {
        if !quiet && told.elapsed() >= TICK {
            told = Instant::now();
            // a reader who has gone wants no answer
            if say(&Message::Progress(progress)).is_err() {
                return ControlFlow::Break(());
            }
        }
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    match ask(&question, &files.files(), &mut watch) {
        Ok(reply) => say(&Message::Answer(Box::new(reply))),
        Err(Error::Interrupted(progress)) => {
            say(&Message::Interrupted(progress))?;
            Err(Error::Interrupted(progress).into())
        }
        Err(error) => refused(error.into()),
    }
}

/// The question of a file, or what is wrong with it.
fn read(file: &Path) -> Result<Ask, String> {
    let name = file.display();
    let mut text = String::new();
    let fault = |error: std::io::Error| format!("`{name}`: {error}");
    let read = if file.as_os_str() == "-" {
        std::io::stdin().take(LARGEST).read_to_string(&mut text)
    } else {
        let file = std::fs::File::open(file).map_err(fault)?;
        file.take(LARGEST).read_to_string(&mut text)
    };
    read.map_err(fault)?;
    serde_json::from_str(&text).map_err(|error| format!("`{name}`: no question: {error}"))
}

/// The last message of a question without an answer; people find the same on standard error.
fn refused(failure: Failure) -> Result<(), Failure> {
    say(&Message::Refused { reason: failure.to_string() })?;
    Err(failure)
}

fn say(message: &Message) -> Result<(), Failure> {
    let text = serde_json::to_string(message).expect("numbers, and keys that are words");
    output::answer(&format!("{text}\n"))
}
