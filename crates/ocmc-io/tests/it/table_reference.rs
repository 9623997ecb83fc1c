//! The page of the guide on the columns of tables is the vocabulary of the program.
//! `OCMC_WRITE_DOCS=1` writes it anew.

use ocmc_io::table::formats::SCHEMAS;
use ocmc_io::table::quantity::{Entry, VOCABULARY};
use std::fmt::Write;
use std::path::Path;

const HEAD: &str = include_str!("table_reference_head.md");

/// A quantity's row: its names, its units, its meaning, and where it is.
fn row(entry: &Entry) -> String {
    let names: Vec<String> = entry.names.iter().map(|name| format!("`{name}`")).collect();
    let units = entry.units.iter().map(|unit| match unit.suffix {
        _ if entry.quantity.is_text() => "text".to_owned(),
        "" => "none".to_owned(),
        suffix => format!("`_{suffix}`"),
    });
    let units: Vec<String> = units.collect();
    let meaning =
        if entry.meaning.is_empty() { String::new() } else { format!(": {}", entry.meaning) };
    format!("| {} | {} | {}{meaning} |", names.join(", "), units.join(" "), entry.noun)
}

/// All names of the vocabulary for a quantity.
fn names(entry: &Entry) -> Vec<String> {
    let with_units = |name: &&'static str| {
        let name = *name;
        entry.units.iter().map(move |unit| match unit.suffix {
            "" => name.to_owned(),
            suffix => format!("{name}_{suffix}"),
        })
    };
    entry.names.iter().flat_map(with_units).collect()
}

/// The columns of each format, with the names of its own.
fn formats() -> String {
    let mut text = String::new();
    for schema in SCHEMAS {
        let columns = schema.fields.iter().map(|field| {
            let of_vocabulary = names(field.quantity.entry());
            let own = field.own.iter().flat_map(|(_, names)| *names);
            let own = own.map(|own| (*own).to_owned()).filter(|own| !of_vocabulary.contains(own));
            let own: Vec<String> = own.map(|own| format!("`{own}`")).collect();
            let own = if own.is_empty() { String::new() } else { format!(" ({})", own.join(", ")) };
            format!("{}{own}", field.quantity.noun())
        });
        let columns: Vec<String> = columns.collect();
        writeln!(text, "| {} | {} |", schema.what, columns.join("; ")).expect("memory");
    }
    text
}

fn page() -> String {
    let rows: Vec<String> = VOCABULARY.iter().map(row).collect();
    format!(
        "{HEAD}\n## Quantities\n\n| name | units | meaning |\n|---|---|---|\n{}\n\n## Formats\n\n\
         In brackets the names that a format has of its own, beside those above.\n\n\
         | table | columns |\n|---|---|\n{}",
        rows.join("\n"),
        formats()
    )
}

#[test]
fn the_page_on_tables_is_the_vocabulary() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src/reference/tables.md");
    if std::env::var_os("OCMC_WRITE_DOCS").is_some() {
        std::fs::write(&file, page()).expect("space");
    }
    let written = std::fs::read_to_string(&file).expect("the page");
    assert_eq!(written, page(), "OCMC_WRITE_DOCS=1 writes {} anew", file.display());
}
