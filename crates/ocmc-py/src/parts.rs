//! Runs on their way between processes: pickled ones, and parts that are put together again.

use crate::run::PyRun;
use crate::table::Table;
use arrow_ipc::reader::StreamReader;
use arrow_ipc::writer::StreamWriter;
use ocmc_core::fleet::summary::SummaryBuilder;
use ocmc_io::records::arrow::{records, schema};
use ocmc_io::run_directory::Manifest;
use ocmc_io::run_summary::RunSummary;
use ocmc_io::study::Origin;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use sha2::{Digest, Sha256};
use std::fmt::Display;

fn broken(error: impl Display) -> PyErr {
    PyValueError::new_err(format!("no pickled run: {error}"))
}

/// What tells a pickled run that is whole from one that is not: arrow-ipc panics on some broken streams.
pub(crate) fn checksum(manifest: &str, stream: &[u8]) -> Vec<u8> {
    Sha256::new().chain_update(manifest).chain_update(stream).finalize().to_vec()
}

/// The records as a stream of Arrow.
pub(crate) fn to_bytes<'py>(py: Python<'py>, table: &Table) -> PyResult<Bound<'py, PyBytes>> {
    let written = py.detach(|| {
        let mut writer = StreamWriter::try_new(Vec::new(), &schema())?;
        for batch in table.batches() {
            writer.write(batch)?;
        }
        writer.into_inner()
    });
    Ok(PyBytes::new(py, &written.map_err(broken)?))
}

/// A pickled run: its manifest (JSON), what was measured, its records, and the checksum of all that.
#[pyfunction]
pub(crate) fn unpickled(
    py: Python,
    manifest: &str,
    wall_s: f64,
    threads: usize,
    stream: &[u8],
    sum: &[u8],
) -> PyResult<PyRun> {
    if checksum(manifest, stream) != sum {
        return Err(broken("its checksum is another one"));
    }
    let manifest: Manifest = serde_json::from_str(manifest).map_err(broken)?;
    py.detach(|| {
        let mut fleet = SummaryBuilder::new(manifest.dependence());
        let mut batches = Vec::new();
        for batch in StreamReader::try_new(stream, None).map_err(broken)? {
            let batch = batch.map_err(broken)?;
            if batch.schema() != schema() {
                return Err(broken("its records have other columns"));
            }
            fleet.add(&records(&batch).map_err(broken)?);
            batches.push(batch);
        }
        let summary = RunSummary::new(&manifest, fleet.finish(), wall_s, threads);
        let records = Table::new(schema(), batches);
        Ok(PyRun { manifest, summary, records, origin: Origin::Dictionary })
    })
}

/// One run of consecutive parts of it, as if it had been driven in one go.
///
/// # Errors
/// Where the parts are of different studies or seeds, or leave a gap.
#[pyfunction]
pub(crate) fn joined(
    py: Python,
    parts: Vec<Bound<PyRun>>,
    wall_s: f64,
    threads: usize,
) -> PyResult<PyRun> {
    let parts: Vec<&PyRun> = parts.iter().map(Bound::get).collect();
    let Some(first) = parts.first() else {
        return Err(PyValueError::new_err("a run has at least one part"));
    };
    let mut manifest = first.manifest.clone();
    manifest.cycles = 0;
    manifest.completed = 0;
    for part in &parts {
        let Manifest { study_hash, seed, first_cycle, cycles, followed, .. } = &part.manifest;
        if (study_hash, seed, followed)
            != (&manifest.study_hash, &manifest.seed, &manifest.followed)
        {
            let text = "the parts are not of one study and seed";
            return Err(PyValueError::new_err(text));
        }
        let due = manifest.first_cycle + manifest.cycles;
        if *first_cycle != due {
            let text =
                format!("a part begins with cycle {first_cycle}, the one before ends before {due}");
            return Err(PyValueError::new_err(text));
        }
        manifest.cycles += cycles;
        manifest.completed += part.manifest.completed;
    }
    let origin = first.origin.clone();
    py.detach(|| {
        let mut fleet = SummaryBuilder::new(manifest.dependence());
        let mut batches = Vec::new();
        for batch in parts.iter().flat_map(|part| part.records.batches()) {
            fleet.add(&records(batch).map_err(broken)?);
            batches.push(batch.clone());
        }
        let summary = RunSummary::new(&manifest, fleet.finish(), wall_s, threads);
        Ok(PyRun { manifest, summary, records: Table::new(schema(), batches), origin })
    })
}
