//! Course of one cycle, step by step.

use ocmc_core::kernel::drive::trace::{TableColumn, trace as drive};
use ocmc_io::study::LoadedStudy;
use serde::{Serialize, Serializer};
use std::io::{self, Write};

/// The time series of one cycle. Its JSON is a list for each column, null for what is not finite.
#[derive(Clone, Debug)]
pub struct TimeSeries {
    /// The columns, one row a step.
    pub columns: Vec<TableColumn>,
}

/// Drives one cycle and keeps every step.
///
/// ```
/// use ocmc_api::{study, trace};
/// let study = study::load("field-truck", &["mission.length_m=3000"])?;
/// let series = trace(&study, 1, 17);
/// assert_eq!(series.columns[0].name, "time_s");
/// assert!(series.columns[0].values.is_sorted());
/// # Ok::<(), ocmc_api::Error>(())
/// ```
pub fn trace(study: &LoadedStudy, seed: u64, cycle_id: u64) -> TimeSeries {
    TimeSeries { columns: drive(&study.study, seed, cycle_id).columns }
}

impl TimeSeries {
    /// Writes the series as comma-separated values: shortest decimals that read back as the same
    /// numbers, an empty cell for NaN and for what a shorter column lacks.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_csv(&self, out: &mut impl Write) -> io::Result<()> {
        let names: Vec<&str> = self.columns.iter().map(|column| column.name).collect();
        writeln!(out, "{}", names.join(","))?;
        let rows = self.columns.iter().map(|column| column.values.len()).max().unwrap_or(0);
        for row in 0..rows {
            for (k, column) in self.columns.iter().enumerate() {
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
}

impl Serialize for TimeSeries {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.columns.iter().map(|column| (column.name, &column.values)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series() -> TimeSeries {
        let columns = vec![
            TableColumn { name: "time_s", values: vec![0.0, 0.2, 1e-7] },
            TableColumn { name: "speed_mps", values: vec![f64::NAN, 0.30000000000000004] },
        ];
        TimeSeries { columns }
    }

    #[test]
    fn csv_reads_back_exactly() {
        let mut text = Vec::new();
        series().write_csv(&mut text).expect("memory");
        let text = String::from_utf8(text).expect("ASCII");
        assert_eq!(text, "time_s,speed_mps\n0.0,\n0.2,0.30000000000000004\n1e-7,\n");
    }

    #[test]
    fn json_has_null_for_nan() {
        let json = serde_json::to_string(&series()).expect("numbers");
        assert_eq!(json, r#"{"time_s":[0.0,0.2,1e-7],"speed_mps":[null,0.30000000000000004]}"#);
    }
}
