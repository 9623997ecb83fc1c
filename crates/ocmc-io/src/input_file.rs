//! The files that are read: those on a disk, and what the shell hands over.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// Paths that need not be plain files: a descriptor from a shell is open already, and an empty
/// source ends, so that nobody waits for a writer.
const ALLOWED: [&str; 4] = ["/dev/stdin", "/dev/fd", "/proc/self/fd", "/dev/null"];

/// Opens a file to read it. A pipe, a socket or a device is refused without being opened: it might
/// never end, or never begin.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    let kind = fs::metadata(path)?.file_type();
    let is_allowed = || ALLOWED.iter().any(|place| path.starts_with(place));
    // the system says itself what is wrong with reading a directory
    if kind.is_file() || kind.is_dir() || is_allowed() {
        return File::open(path);
    }
    let reason = "it is a pipe, a socket or a device; allowed is a file, or what the shell hands \
                  over (/dev/stdin, <(command)): save it to a file";
    Err(io::Error::new(io::ErrorKind::InvalidInput, reason))
}

/// Longest text that is read as a whole, in bytes: a manifest with a drive cycle of years.
const MOST_BYTES: u64 = 64 << 20;

/// The text of a file.
pub(crate) fn read_to_string(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    let read = open(path)?.take(MOST_BYTES + 1).read_to_string(&mut text)?;
    if read as u64 > MOST_BYTES {
        let reason = format!("it has more than {MOST_BYTES} bytes");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, reason));
    }
    Ok(text)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::process::Command;

    #[test]
    fn pipes_sockets_and_devices_are_refused_without_being_opened() {
        let folder = tempfile::tempdir().expect("a directory");
        let (pipe, socket) = (folder.path().join("pipe"), folder.path().join("socket"));
        assert!(Command::new("mkfifo").arg(&pipe).status().expect("mkfifo").success());
        let _socket = std::os::unix::net::UnixListener::bind(&socket).expect("a socket");
        for path in [&pipe, &socket, Path::new("/dev/zero"), Path::new("/dev/tty")] {
            let error = open(path).expect_err("no file").to_string();
            assert!(error.contains("a pipe, a socket or a device"), "{path:?}: {error}");
        }
        open(Path::new("/dev/null")).expect("it is empty");
        fs::write(folder.path().join("a"), "1").expect("space");
        open(&folder.path().join("a")).expect("a file");
    }
}
