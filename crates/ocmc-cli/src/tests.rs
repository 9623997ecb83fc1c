//! The definitions of the command, and the reference page that is made from them.
//!
//! `OCMC_WRITE_DOCS=1 cargo test -p ocmc-cli reference` writes its regions anew.

use crate::{Arguments, GROUPS, command};
use clap::{Arg, Command, CommandFactory};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// A region begins with this and the command that it shows, and ends with [`END`].
const BEGIN: &str = "<!-- generated: begin ";
const END: &str = "<!-- generated: end -->";
/// The region that lists all commands.
const LIST: &str = "commands";

/// Commands that do something, by what is typed, in the order of the help.
fn commands(command: &Command, typed: &str, all: &mut Vec<(String, Command)>) {
    if !command.is_subcommand_required_set() {
        all.push((typed.to_owned(), command.clone()));
    }
    for below in command.get_subcommands().filter(|below| below.get_name() != "help") {
        commands(below, &format!("{typed} {}", below.get_name()), all);
    }
}

fn list(all: &[(String, Command)]) -> String {
    let row = |(typed, command): &(String, Command)| {
        format!("| [`{typed}`](#{}) | {} |\n", typed.replace(' ', "-"), about(command))
    };
    format!("| command | what it does |\n|---|---|\n{}", all.iter().map(row).collect::<String>())
}

fn about(command: &Command) -> String {
    let about = command.get_long_about().filter(|_| command.get_name() == "ocmc");
    let about = about.or(command.get_about()).expect("each command says what it does").to_string();
    in_markdown(about.split("\n\n").last().expect("a paragraph").trim_end_matches('.'))
}

fn section(typed: &str, command: &Command) -> String {
    let usage = command.clone().render_usage().to_string();
    let usage = usage.trim_start_matches("Usage: ").replace("\n       ", "\n");
    let mut text = format!("## `{typed}`\n\n{}.\n\n```text\n{usage}\n```\n", about(command));
    let rows = command.get_arguments().filter(|argument| {
        !argument.is_hide_set() && !["help", "version"].contains(&argument.get_id().as_str())
    });
    let mut rows: Vec<&Arg> = rows.collect();
    let help = command.clone().render_help().to_string();
    rows.sort_by_key(|argument| help.find(&argument.to_string()));
    let rows: String = rows.into_iter().map(row).collect();
    if !rows.is_empty() {
        write!(text, "\n| argument or option | default | meaning |\n|---|---|---|\n{rows}")
            .expect("memory");
    }
    if let Some(after) = command.get_after_help() {
        write!(text, "\n```text\n{after}\n```\n").expect("memory");
    }
    text
}

fn row(argument: &Arg) -> String {
    let help = argument.get_help().expect("each argument says what it is").to_string();
    let (help, told) = help.split_once(" [default: ").unwrap_or((&help, ""));
    let takes_values = argument.get_action().takes_values();
    let default: Vec<_> =
        argument.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    let default = match told.trim_end_matches(']') {
        _ if argument.is_required_set() => "required".to_owned(),
        "" if !takes_values => "off".to_owned(),
        "" if default.is_empty() => "–".to_owned(),
        "" => format!("`{}`", default.join(" ")),
        told if told.contains(' ') => in_markdown(told),
        told => format!("`{told}`"),
    };
    let shows_words = takes_values && !argument.is_hide_possible_values_set();
    let words = argument.get_possible_values().into_iter().filter(|_| shows_words);
    // each with what it says on a line of its own, and one behind the other where they say nothing
    let words: Vec<String> = words
        .enumerate()
        .map(|(k, word)| match word.get_help() {
            Some(help) => format!("<br>`{}`: {}", word.get_name(), in_markdown(&help.to_string())),
            None => format!("{}`{}`", if k == 0 { "<br>" } else { ", " }, word.get_name()),
        })
        .collect();
    let name = argument.to_string().replace('|', "\\|");
    format!("| `{name}` | {default} | {}{} |\n", in_markdown(help), words.concat())
}

/// Help as Markdown of a table's cell: options, names of columns and settings are code.
fn in_markdown(help: &str) -> String {
    let word = |word: &str| {
        let bare = word.trim_matches(|c| ",;:.()".contains(c));
        if bare.starts_with("--") || bare.contains(['_', '=']) {
            word.replace(bare, &format!("`{bare}`"))
        } else {
            word.to_owned()
        }
    };
    let words = |text: &str| text.split(' ').map(word).collect::<Vec<_>>().join(" ");
    let parts = help.split('`').enumerate();
    let parts = parts.map(|(k, part)| if k % 2 == 0 { words(part) } else { part.to_owned() });
    parts.collect::<Vec<_>>().join("`").replace('|', "\\|").replace('\n', " ")
}

#[test]
fn the_definitions_are_consistent() {
    Arguments::command().debug_assert();
}

#[test]
fn the_reference_page_is_made_from_the_definitions() {
    let mut program = Arguments::command();
    program.build();
    let mut all = Vec::new();
    commands(&program, "ocmc", &mut all);
    let mut sections: BTreeMap<&str, String> =
        all.iter().map(|(typed, command)| (typed.as_str(), section(typed, command))).collect();
    sections.insert(LIST, list(&all));
    let path = "../../docs/src/reference/command-line.md";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    let old = std::fs::read_to_string(&path).expect("the page");
    let mut parts = old.split(BEGIN);
    let mut new = parts.next().expect("a head").to_owned();
    for part in parts {
        let (typed, rest) = part.split_once(" -->").expect("a region has a name");
        let (_, prose) = rest.split_once(END).expect("a region ends");
        let text = sections.remove(typed).unwrap_or_else(|| panic!("no command `{typed}`"));
        write!(new, "{BEGIN}{typed} -->\n\n{}\n\n{END}{prose}", text.trim()).expect("memory");
    }
    assert!(sections.is_empty(), "commands without a region: {:?}", sections.keys());
    if std::env::var_os("OCMC_WRITE_DOCS").is_some() {
        std::fs::write(&path, &new).expect("space");
    }
    let written = std::fs::read_to_string(&path).expect("the page");
    assert_eq!(written, new, "`OCMC_WRITE_DOCS=1 cargo test -p ocmc-cli reference` writes it anew");
}

#[test]
fn each_command_is_in_one_group_of_the_help() {
    let grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| *names).copied().collect();
    let program = Arguments::command();
    for command in program.get_subcommands() {
        let times = grouped.iter().filter(|name| **name == command.get_name()).count();
        assert_eq!(times, 1, "{}", command.get_name());
    }
    assert_eq!(grouped.len(), program.get_subcommands().count());
    let help = command().render_help().to_string();
    assert!(help.lines().all(|line| line.chars().count() <= 100), "{help}");
    assert!(help.contains("Ask:\n  drive") && help.contains("--cycles"), "{help}");
}

/// Commands that do not take one of the options that all take, and why.
const WITHOUT: [(&str, &str, &[&str]); 10] = [
    ("json", "print what is written, as it is", &["study show", "completions"]),
    ("json", "is JSON", &["study schema", "ask"]),
    ("threads", "has them in the question", &["ask"]),
    ("threads", "uses all, and answers in a browser", &["page"]),
    ("json", "answers in a browser", &["page"]),
    ("json", "write files, and have no answer", &["study init", "report", "man"]),
    (
        "threads",
        "drive nothing",
        &[
            "study list",
            "study vehicles",
            "study show",
            "study init",
            "study check",
            "study diff",
            "study birds-eye",
            "study schema",
            "cycle",
            "merge",
            "report",
            "verify",
            "completions",
            "man",
        ],
    ),
    ("threads", "drive one trip at a time", &["trace", "vecto"]),
    ("threads", "find what a log shows, file by file", &["curves", "road"]),
    (
        "threads",
        "fit tables, in moments",
        &[
            "fit curve-speed",
            "fit speed-change",
            "fit operating-cycle",
            "fit weather",
            "fit traffic",
            "fit fleet",
        ],
    ),
];

#[test]
fn all_commands_take_quiet_json_and_threads_where_they_make_sense() {
    let mut program = Arguments::command();
    program.build();
    let mut all = Vec::new();
    commands(&program, "ocmc", &mut all);
    let mut without: Vec<(&str, &str)> = Vec::new();
    for (option, _, names) in WITHOUT {
        without.extend(names.iter().map(|name| (option, *name)));
    }
    for (typed, command) in &all {
        let name = typed.trim_start_matches("ocmc").trim();
        for option in ["quiet", "json", "threads"] {
            let takes = command.get_arguments().any(|argument| argument.get_id() == option);
            let place = without.iter().position(|exception| *exception == (option, name));
            assert_ne!(takes, place.is_some(), "`{typed}` and --{option}");
            place.map(|place| without.remove(place));
        }
    }
    assert!(without.is_empty(), "no such commands: {without:?}");
}

#[test]
fn the_readme_has_a_question_for_every_command() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../README.md");
    let readme = std::fs::read_to_string(path).expect("the page");
    let rows: String = readme.lines().filter(|line| line.starts_with("| ")).collect();
    for command in Arguments::command().get_subcommands() {
        let typed = format!("`ocmc {}", command.get_name());
        let asked = [' ', '`'].iter().any(|end| rows.contains(&format!("{typed}{end}")));
        assert!(asked, "{typed}");
    }
}
