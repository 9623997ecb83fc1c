//! The file of a workbook (Office Open XML, ECMA-376): an archive of parts in XML, without a date.

use super::sheet::{HEAD, MAIN, Sheet};
use std::fmt::Write as _;
use std::io::{self, Seek, Write};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// Bytes of a part, from which on the archive needs long lengths.
const LARGE: u64 = u32::MAX as u64;

/// Names of relations.
const RELATION: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
/// Their file format.
const RELATIONS: &str = "http://schemas.openxmlformats.org/package/2006/relationships";
/// Media types of the parts.
const TYPE: &str = "application/vnd.openxmlformats-officedocument.spreadsheetml";
/// Their list.
const TYPES: &str = "http://schemas.openxmlformats.org/package/2006/content-types";

/// A workbook that is being written.
pub(super) struct Package<W: Write + Seek> {
    archive: ZipWriter<W>,
    /// Names of the sheets, in the order in which they were written.
    sheets: Vec<&'static str>,
}

impl<W: Write + Seek> Package<W> {
    pub(super) fn new(out: W) -> Self {
        Self { archive: ZipWriter::new(out), sheets: Vec::new() }
    }

    /// Begins a sheet of at most so many bytes.
    pub(super) fn sheet<'a>(
        mut self,
        name: &'static str,
        columns: impl IntoIterator<Item = &'a str>,
        widths: &[usize],
        bytes: u64,
    ) -> io::Result<Sheet<Self>> {
        self.sheets.push(name);
        let part = format!("xl/worksheets/sheet{}.xml", self.sheets.len());
        self.begin(&part, bytes)?;
        Sheet::begin(self, columns, widths, name == super::ANSWER)
    }

    /// Writes the parts that say what the sheets are, and ends the file. The sheets are shown in
    /// this order.
    pub(super) fn finish(mut self, order: &[&str]) -> io::Result<W> {
        let place = |name: &&str| self.sheets.iter().position(|sheet| sheet == name);
        let shown: Vec<(usize, &str)> =
            order.iter().filter_map(|name| Some((place(name)? + 1, *name))).collect();
        let count = self.sheets.len();
        let (mut types, mut sheets, mut relations) = (String::new(), String::new(), String::new());
        for k in 1..=count {
            let _ = write!(
                types,
                "<Override PartName=\"/xl/worksheets/sheet{k}.xml\" \
                 ContentType=\"{TYPE}.worksheet+xml\"/>"
            );
            let _ = write!(
                relations,
                "<Relationship Id=\"rId{k}\" Type=\"{RELATION}/worksheet\" \
                 Target=\"worksheets/sheet{k}.xml\"/>"
            );
        }
        for (k, name) in shown {
            let _ = write!(sheets, "<sheet name=\"{name}\" sheetId=\"{k}\" r:id=\"rId{k}\"/>");
        }
        let styles = count + 1;
        let parts = [
            (
                "xl/workbook.xml",
                format!(
                    "<workbook xmlns=\"{MAIN}\" xmlns:r=\"{RELATION}\"><sheets>{sheets}</sheets>\
                     </workbook>"
                ),
            ),
            (
                "xl/_rels/workbook.xml.rels",
                format!(
                    "<Relationships xmlns=\"{RELATIONS}\">{relations}<Relationship \
                     Id=\"rId{styles}\" Type=\"{RELATION}/styles\" Target=\"styles.xml\"/>\
                     </Relationships>"
                ),
            ),
            ("xl/styles.xml", format!("<styleSheet xmlns=\"{MAIN}\">{STYLES}</styleSheet>")),
            (
                "_rels/.rels",
                format!(
                    "<Relationships xmlns=\"{RELATIONS}\"><Relationship Id=\"rId1\" \
                     Type=\"{RELATION}/officeDocument\" Target=\"xl/workbook.xml\"/>\
                     </Relationships>"
                ),
            ),
            (
                "[Content_Types].xml",
                format!(
                    "<Types xmlns=\"{TYPES}\"><Default Extension=\"rels\" ContentType=\
                     \"application/vnd.openxmlformats-package.relationships+xml\"/><Default \
                     Extension=\"xml\" ContentType=\"application/xml\"/><Override \
                     PartName=\"/xl/workbook.xml\" ContentType=\"{TYPE}.sheet.main+xml\"/>\
                     <Override PartName=\"/xl/styles.xml\" ContentType=\"{TYPE}.styles+xml\"/>\
                     {types}</Types>"
                ),
            ),
        ];
        for (name, text) in parts {
            self.begin(name, 0)?;
            self.archive.write_all(format!("{HEAD}{text}").as_bytes())?;
        }
        Ok(self.archive.finish()?)
    }

    fn begin(&mut self, part: &str, bytes: u64) -> io::Result<()> {
        // the time of a part is the first that an archive knows
        let options = SimpleFileOptions::DEFAULT.large_file(bytes >= LARGE);
        Ok(self.archive.start_file(part, options)?)
    }
}

impl<W: Write + Seek> Write for Package<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.archive.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.archive.flush()
    }
}

/// Cells, and a header in bold.
const STYLES: &str = "<fonts count=\"2\"><font><sz val=\"11\"/><name val=\"Calibri\"/></font>\
    <font><b/><sz val=\"11\"/><name val=\"Calibri\"/></font></fonts><fills count=\"2\"><fill>\
    <patternFill patternType=\"none\"/></fill><fill><patternFill patternType=\"gray125\"/></fill>\
    </fills><borders count=\"1\"><border><left/><right/><top/><bottom/><diagonal/></border>\
    </borders><cellStyleXfs count=\"1\"><xf numFmtId=\"0\" fontId=\"0\" fillId=\"0\" \
    borderId=\"0\"/></cellStyleXfs><cellXfs count=\"2\"><xf numFmtId=\"0\" fontId=\"0\" \
    fillId=\"0\" borderId=\"0\" xfId=\"0\"/><xf numFmtId=\"0\" fontId=\"1\" fillId=\"0\" \
    borderId=\"0\" xfId=\"0\" applyFont=\"1\"/></cellXfs><cellStyles count=\"1\"><cellStyle \
    name=\"Normal\" xfId=\"0\" builtinId=\"0\"/></cellStyles>";
