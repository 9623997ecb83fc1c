//! Files of text as others write them: compressed by gzip or not, their cells between commas, semicolons or tabulators.

use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};

/// The text of a file that may be compressed.
pub(crate) fn decompressed(file: File) -> std::io::Result<Box<dyn Read>> {
    let mut file = BufReader::new(file);
    let compressed = file.fill_buf()?.starts_with(&[0x1f, 0x8b]);
    Ok(if compressed { Box::new(MultiGzDecoder::new(file)) } else { Box::new(file) })
}

/// What separates the names of a table that begins so: a comma, unless there are more semicolons or tabulators. The names stand in the
/// first line that is neither blank nor a comment (`#`).
pub(crate) fn delimiter(start: &[u8]) -> u8 {
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
    let mut lines = start.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    let line = lines.find(|line| !line.is_empty() && !line.starts_with(b"#")).unwrap_or_default();
    let count = |wanted: u8| line.split(|byte| *byte == wanted).count();
    // of equal counts the last one wins
    [b'\t', b';', b','].into_iter().max_by_key(|separator| count(*separator)).unwrap_or(b',')
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column_file::ColumnFile;
    use crate::delimited::DelimitedTable;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write;

    #[test]
    fn tables_are_read_compressed_and_with_every_separator() {
        let directory = tempfile::tempdir().expect("a directory");
        for (k, text) in
            ["a,b\n1,x\n2,y\n", "# a, b, c\n a;b\n1;x\n2;y, z\n", "a\tb\n1\tx\n2\t;,\n"]
                .into_iter()
                .enumerate()
        {
            let path = directory.path().join(format!("{k}.csv.gz"));
            let mut zipped = GzEncoder::new(Vec::new(), Compression::fast());
            zipped.write_all(text.as_bytes()).expect("memory");
            std::fs::write(&path, zipped.finish().expect("memory")).expect("a file");
            let mut file = ColumnFile::open(&path).expect("a table");
            let column = file.need_numbers(&["a"]).expect("a column");
            let mut values = Vec::new();
            file.for_each(|row| {
                values.push(row.number(column)?);
                Ok(())
            })
            .expect("rows");
            assert_eq!(values, [1.0, 2.0], "{text}");
            let table = DelimitedTable::read(&path).expect("a table");
            assert_eq!(table.numbers(0).expect("numbers"), values, "{text}");
        }
    }

    #[test]
    fn the_header_tells_the_separator() {
        for (start, separator) in [
            ("a,b,c\n1;2;3;4\n", b','),
            ("\u{feff}a;b (x, y);c\n", b';'),
            ("# a, b, c\n\n a\tb\n1,2,3\n", b'\t'),
            ("a\n1;2\n", b','),
            ("", b','),
        ] {
            assert_eq!(delimiter(start.as_bytes()), separator, "{start}");
        }
    }
}
