//! `ocmc completions`, `ocmc man`: what shells and `man` know of the command.

use crate::failure::Failure;
use clap::{Arg, ArgAction, Command};
use clap_complete::Shell;
use ocmc_api::study::list;
use std::fs;
use std::path::Path;

/// The script that completes the command line of a shell. Where a study is asked for it offers the
/// built-in ones beside files, which the generator, knowing either names or files, cannot.
pub(crate) fn completions(shell: Shell, mut command: Command) -> String {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut command, "ocmc", &mut script);
    let script = String::from_utf8_lossy(&script).into_owned();
    let names: Vec<&str> = list().iter().map(|study| study.name).collect();
    let names = names.join(" ");
    match shell {
        Shell::Bash => bash(&script, &names),
        Shell::Zsh => zsh(&script, &names),
        Shell::Fish => fish(&script, &names),
        _ => script,
    }
}

/// Options that take a study.
const STUDY_OPTIONS: [&str; 2] = ["study", "against"];

/// Sub-commands whose argument is a study.
const POSITIONAL: [&str; 4] = ["compare", "show", "check", "birds-eye"];

fn bash(script: &str, names: &str) -> String {
    let files = r#"COMPREPLY=($(compgen -f "${cur}"))"#;
    let both =
        format!(r#"COMPREPLY=($(compgen -W "{names}" -- "${{cur}}") $(compgen -f -- "${{cur}}"))"#);
    let (mut of_study, mut takes_study) = (false, false);
    let lines = script.lines().map(|line| {
        let word = line.trim();
        if let Some(command) = word.strip_prefix("ocmc__").and_then(|word| word.strip_suffix(')')) {
            let ends = |name: &&str| command.ends_with(&name.replace('-', "__subcmd__"));
            takes_study = !command.contains("help__") && POSITIONAL.iter().any(ends);
        }
        let here = of_study && word == files;
        of_study = STUDY_OPTIONS.iter().any(|name| word == format!("--{name})"));
        match () {
            () if here => line.replace(files, &both),
            // a positional argument is among the words that may come next
            () if takes_study && word.starts_with("opts=") => {
                format!("{} {names}\"", line.trim_end_matches('"'))
            }
            () => line.to_owned(),
        }
    });
    lines.map(|line| line + "\n").collect()
}

fn zsh(script: &str, names: &str) -> String {
    // an action of its own: within one of `_arguments` the colons would end it
    let both = format!(
        "_ocmc_studies() {{\n    _alternative \"studies:study:({names})\" \"files:file:_files\"\n\
         }}\n"
    );
    let lines = script.lines().map(|line| {
        let option = line.contains(":NAME|FILE:_files'");
        let positional = line.contains("':study -- ") || line.contains("::studies -- ");
        // with two colons no option is offered behind the first of several arguments
        let line = line.strip_prefix("'*::").map_or(line.to_owned(), |rest| format!("'*:{rest}"));
        match line.as_str() {
            "_ocmc() {" => format!("{both}\n{line}"),
            _ if option || positional => line.replace(":_files'", ":_ocmc_studies'"),
            _ => line,
        }
    });
    lines.map(|line| line + "\n").collect()
}

fn fish(script: &str, names: &str) -> String {
    let of_study =
        |line: &&str| STUDY_OPTIONS.iter().any(|name| line.contains(&format!(" -l {name} ")));
    let lines = script.lines().map(|line| match line.strip_suffix(" -r -F") {
        Some(_) if of_study(&line) => format!("{line} -a \"{names}\"\n"),
        _ => format!("{line}\n"),
    });
    // the generator leaves positional arguments out
    let positional = POSITIONAL.map(|command| {
        format!("complete -c ocmc -n \"__fish_seen_subcommand_from {command}\" -a \"{names}\"\n")
    });
    lines.chain(positional).collect()
}

/// Writes manual pages, one for each sub-command, to a directory, which is created where it does
/// not exist.
pub(crate) fn man(directory: &Path, mut command: Command) -> Result<(), Failure> {
    command.build();
    fs::create_dir_all(directory)
        .and_then(|()| clap_mangen::generate_to(with_synopsis(command, "ocmc"), directory))
        .map_err(|source| Failure::File { path: directory.to_owned(), source })
}

/// A command whose synopsis names the values of its options, and those of its sub-commands.
fn with_synopsis(command: Command, name: &str) -> Command {
    let shown = command.get_arguments().filter(|argument| !argument.is_hide_set());
    let mut usage: Vec<String> = [name.to_owned()].into_iter().chain(shown.map(synopsis)).collect();
    if command.has_subcommands() {
        usage.push("[COMMAND]".to_owned());
    }
    let usage = usage.join(" ");
    let name = name.to_owned();
    let below = move |below: Command| {
        let name = format!("{name} {}", below.get_name());
        with_synopsis(below, &name)
    };
    command.override_usage(usage).mut_subcommands(below)
}

/// An argument with the names of its values.
fn synopsis(argument: &Arg) -> String {
    let repeated = matches!(argument.get_action(), ArgAction::Append) && !argument.is_positional();
    let more = if repeated { "..." } else { "" };
    if argument.is_required_set() {
        format!("{argument}{more}")
    } else {
        format!("[{argument}]{more}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Arguments;
    use clap::CommandFactory;
    use std::process::Command as Process;

    #[test]
    fn studies_are_offered_beside_files() {
        let script = |shell| completions(shell, Arguments::command());
        let zsh = script(Shell::Zsh);
        let both = "_ocmc_studies() {\n    _alternative \"studies:study:(field-truck ";
        assert_eq!(zsh.matches(both).count(), 1, "{zsh}");
        assert!(zsh.matches(":_ocmc_studies'").count() > 10, "{zsh}");
        assert!(!zsh.contains("NAME|FILE:_files") && !zsh.contains("\n'*::"), "{zsh}");
        assert!(zsh.contains("'*:studies -- "), "{zsh}");
        let fish = script(Shell::Fish);
        let is_it = |line: &&str| line.contains("subcommand cost\" -l against ");
        let line = fish.lines().find(is_it).expect("an option");
        assert!(line.contains("-r -F -a \"field-truck "), "{line}");
        assert!(script(Shell::Elvish).contains("ocmc"));
    }

    #[test]
    fn bash_offers_the_names_of_studies() {
        if Process::new("bash").arg("--version").output().is_err() {
            eprintln!("skipped: there is no bash");
            return;
        }
        let script = completions(Shell::Bash, Arguments::command());
        for (words, at) in
            [("ocmc --study lon", 2), ("ocmc cost --against lon", 3), ("ocmc compare lon", 2)]
        {
            let ask = format!(
                "{script}\nCOMP_WORDS=({words}); COMP_CWORD={at}\n\
                 _ocmc ocmc \"${{COMP_WORDS[$COMP_CWORD]}}\" \
                 \"${{COMP_WORDS[$((COMP_CWORD-1))]}}\"\necho \"${{COMPREPLY[@]}}\"\n"
            );
            let asked = Process::new("bash").args(["-c", &ask]).output().expect("bash starts");
            let said = String::from_utf8_lossy(&asked.stdout).into_owned();
            assert!(
                said.contains("long-haul"),
                "{words}: {said}{}",
                String::from_utf8_lossy(&asked.stderr)
            );
        }
    }
}
