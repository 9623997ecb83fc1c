//! Words as a shell reads them, for commands that are suggested.

use crate::printable::is_hidden;
use std::fmt::Write;
use std::path::Path;

/// Characters beside letters and digits that no shell parts or changes.
const PLAIN: &str = "/._-+,:@%=";

/// A path as one word of a command: between single quotes where a shell would part or change it.
pub fn shell_word(path: &Path) -> String {
    let text = match path.to_str() {
        Some(text) if !text.chars().any(is_hidden) => text,
        _ => return escaped(path.as_os_str().as_encoded_bytes()),
    };
    // behind a dash a program looks for an option
    if text.starts_with('-') { quoted(&format!("./{text}")) } else { quoted(text) }
}

/// A text as one word of a command.
pub fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || PLAIN.contains(c) || (cfg!(windows) && c == '\\');
    if !text.is_empty() && text.chars().all(plain) {
        return text.to_owned();
    }
    format!("'{}'", text.replace('\'', r"'\''"))
}

/// Bytes that are no text, or hold letters that a terminal obeys, as a word of bash, zsh and ksh.
fn escaped(bytes: &[u8]) -> String {
    let mut word = "$'".to_owned();
    for byte in bytes {
        match byte {
            b'\'' | b'\\' => word.extend(['\\', char::from(*byte)]),
            b' '..=b'~' => word.push(char::from(*byte)),
            _ => write!(word, "\\x{byte:02x}").expect("a string takes any text"),
        }
    }
    word.push('\'');
    word
}

/// The command that finishes the run of a directory.
pub fn resume_command(directory: &Path) -> String {
    format!("ocmc --out {} --resume", shell_word(directory))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_a_shell_would_change_is_quoted() {
        for (path, word) in [
            ("runs/a-1_b.csv", "runs/a-1_b.csv"),
            ("straße/ä", "straße/ä"),
            ("a b/run", "'a b/run'"),
            ("it's", r"'it'\''s'"),
            ("a;b", "'a;b'"),
            ("$HOME", "'$HOME'"),
            ("~x", "'~x'"),
            ("", "''"),
            ("-x", "./-x"),
            ("a\nb'", r"$'a\x0ab\''"),
        ] {
            assert_eq!(shell_word(Path::new(path)), word);
        }
    }
}
