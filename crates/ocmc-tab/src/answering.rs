//! A question from standard input, its answer on standard output.
//!
//! Without an argument the question is answered. `parts WORKERS` says in which parts that many
//! workers may drive its cycles, `drive FIRST CYCLES NAME` drives one of them and writes its
//! records to files whose names begin so, and `answer FILES…` answers of the files of all parts.

use ocmc_api::Error;
use ocmc_api::ask::part::{self, Part};
use ocmc_api::ask::{Ask, Message, ask};
use ocmc_api::study::Files;
use serde_json::json;
use std::env;
use std::io::{Read, Write, stdin, stdout};
use std::ops::ControlFlow;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Time between two messages of how far the work is.
const TICK: Duration = Duration::from_millis(100);

/// Does what the arguments ask for, one message a line.
pub(crate) fn answer() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = read().and_then(|question| asked(&question, &arguments));
    done.unwrap_or_else(|reason| {
        say(&Message::Refused { reason });
        ExitCode::FAILURE
    })
}

/// Does what is asked for, or says why not.
fn asked(question: &Ask, arguments: &[&str]) -> Result<ExitCode, String> {
    let files = &Files::here();
    let mut spoken = Instant::now();
    let watch = &mut |progress| {
        if spoken.elapsed() >= TICK {
            spoken = Instant::now();
            say(&Message::Progress(progress));
        }
        ControlFlow::Continue(())
    };
    let number = |text: &str| text.parse().map_err(|_| format!("`{text}` is no number"));
    let failed = |error: Error| error.to_string();
    match arguments {
        [] => {
            let reply = ask(question, files, watch).map_err(failed)?;
            say(&Message::Answer(Box::new(reply)));
        }
        ["answer", written @ ..] => {
            let written: Vec<_> = written.iter().map(Into::into).collect();
            let reply = part::answer(question, files, &written, watch).map_err(failed)?;
            say(&Message::Answer(Box::new(reply)));
        }
        ["parts", workers] => {
            let parts = part::parts(question, files, number(workers)?).map_err(failed)?;
            say(&json!({"message": "parts", "parts": parts}));
        }
        ["drive", first, cycles, name] => {
            let part = Part { first_cycle: number(first)?, cycles: number(cycles)? };
            let written = part::drive(question, files, part, Path::new(name), watch);
            say(&json!({"message": "driven", "files": written.map_err(failed)?}));
        }
        _ => return Err(format!("no command: {}", arguments.join(" "))),
    }
    Ok(ExitCode::SUCCESS)
}

fn read() -> Result<Ask, String> {
    let mut text = String::new();
    stdin().read_to_string(&mut text).map_err(|error| error.to_string())?;
    serde_json::from_str(&text).map_err(|error| format!("no question: {error}"))
}

fn say(message: &impl serde::Serialize) {
    let mut text = serde_json::to_string(message).expect("numbers, and keys that are words");
    text.push('\n');
    stdout().write_all(text.as_bytes()).expect("the caller takes each line");
}
