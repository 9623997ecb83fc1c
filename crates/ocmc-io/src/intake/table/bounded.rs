//! A text that is read piece by piece, and does not take more memory or time than its file can
//! mean: a log is streamed, but a line is held as a whole, and a small compressed file may hold
//! anything.

use std::io::{self, Read};

/// Longest line of a table that is streamed, in bytes: a thousand columns of a thousand digits.
pub(super) const LONGEST_LINE: usize = 1 << 20;

/// Most that a compressed file may expand to, as a multiple of its length: logs of constant values
/// come to a hundred.
pub(super) const LARGEST_RATIO: u64 = 500;

/// Size to which a compressed file may expand in any case, in bytes.
const ALWAYS_ALLOWED: u64 = 64 << 20;

/// A text with bounds.
pub(super) struct Bounded<R> {
    text: R,
    /// Bytes of the line that is being read.
    line: usize,
    read: u64,
    most: u64,
}

impl<R: Read> Bounded<R> {
    /// A text from a file of so many bytes, which are compressed or not.
    pub(super) fn new(text: R, file_bytes: u64, is_compressed: bool) -> Self {
        let expanded = file_bytes.saturating_mul(LARGEST_RATIO).max(ALWAYS_ALLOWED);
        Self { text, line: 0, read: 0, most: if is_compressed { expanded } else { u64::MAX } }
    }
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.text.read(buffer)?;
        self.read += n as u64;
        let is_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
        for piece in buffer[..n].split_inclusive(is_end) {
            self.line += piece.len();
            if self.line > LONGEST_LINE {
                return Err(refused(&format!("a line has more than {LONGEST_LINE} bytes")));
            }
            if piece.last().is_some_and(is_end) {
                self.line = 0;
            }
        }
        if self.read > self.most {
            return Err(refused(&format!(
                "it expands to more than {LARGEST_RATIO} times its length; decompress it first, if \
                 it is right"
            )));
        }
        Ok(n)
    }
}

fn refused(reason: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: impl Read, file_bytes: u64, is_compressed: bool) -> Result<u64, String> {
        io::copy(&mut Bounded::new(text, file_bytes, is_compressed), &mut io::sink())
            .map_err(|error| error.to_string())
    }

    #[test]
    fn an_endless_line_is_refused_and_long_lines_are_not() {
        let line = |bytes: usize| [vec![b'x'; bytes - 1], b"\n".to_vec()].concat();
        let lines = [line(LONGEST_LINE), line(LONGEST_LINE), b"no end".to_vec()].concat();
        assert_eq!(read(&lines[..], 0, false), Ok(lines.len() as u64));
        let error = read(io::repeat(b'x'), 0, false).expect_err("endless");
        assert_eq!(error, "a line has more than 1048576 bytes");
    }

    #[test]
    fn a_small_file_does_not_expand_to_a_large_one() {
        let error = read(io::repeat(b'\n'), 1000, true).expect_err("a bomb");
        assert!(error.contains("500 times its length"), "{error}");
        let lines = io::repeat(b'\n').take(100 << 20);
        assert_eq!(read(lines, 1 << 20, true), Ok(100 << 20));
    }
}
