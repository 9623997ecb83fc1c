//! Tables of numbers, such as tracks and time series, as CSV and JSON.

use ocmc_core::kernel::trace::TableColumn;
use std::io::{self, Write};

/// Writes a table as comma-separated values: shortest decimals that read back as the same numbers,
/// an empty cell for NaN and for what a shorter column lacks.
pub fn write_csv(out: &mut impl Write, columns: &[TableColumn]) -> io::Result<()> {
    let names: Vec<&str> = columns.iter().map(|column| column.name).collect();
    writeln!(out, "{}", names.join(","))?;
    let rows = columns.iter().map(|column| column.values.len()).max().unwrap_or(0);
    for row in 0..rows {
        for (k, column) in columns.iter().enumerate() {
            if k > 0 {
                out.write_all(b",")?;
            }
            if let Some(value) = column.values.get(row).filter(|value| !value.is_nan()) {
                write!(out, "{value:?}")?;
            }
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// A table as a JSON object: a list for each column, null for what is not finite.
pub fn to_json(columns: &[TableColumn]) -> serde_json::Value {
    let lists =
        columns.iter().map(|column| (column.name.to_owned(), column.values.as_slice().into()));
    serde_json::Value::Object(lists.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> [TableColumn; 2] {
        [
            TableColumn { name: "time_s", values: vec![0.0, 0.2, 1e-7] },
            TableColumn { name: "speed_mps", values: vec![f64::NAN, 0.30000000000000004] },
        ]
    }

    #[test]
    fn csv_reads_back_exactly() {
        let mut text = Vec::new();
        write_csv(&mut text, &columns()).expect("memory");
        let text = String::from_utf8(text).expect("ASCII");
        assert_eq!(text, "time_s,speed_mps\n0.0,\n0.2,0.30000000000000004\n1e-7,\n");
    }

    #[test]
    fn json_has_null_for_nan() {
        let json = to_json(&columns()).to_string();
        assert_eq!(json, r#"{"time_s":[0.0,0.2,1e-7],"speed_mps":[null,0.30000000000000004]}"#);
    }
}
