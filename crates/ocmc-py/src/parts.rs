//! Runs on their way between processes: pickled ones, and parts that are put together again.

use crate::run::PyRun;
use crate::stream::{broken, checksum};
use crate::table::Table;
use arrow_ipc::reader::StreamReader;
use ocmc_api::study::Origin;
use ocmc_api::{Manifest, joined as whole, records, schema, summed_up};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

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
        let mut batches = Vec::new();
        let groups = StreamReader::try_new(stream, None).map_err(broken)?.map(|batch| {
            let batch = batch.map_err(broken)?;
            if batch.schema() != schema() {
                return Err(broken("its records have other columns"));
            }
            batches.push(batch.clone());
            records(&batch).map_err(broken)
        });
        let answer = summed_up(manifest, Origin::Dictionary, (wall_s, threads), groups)?;
        Ok(PyRun { answer, records: Table::new(schema(), batches) })
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
    let manifests: Vec<&Manifest> = parts.iter().map(|part| &part.answer.manifest).collect();
    let manifest = whole(&manifests).map_err(|error| PyValueError::new_err(error.to_string()))?;
    let origin = parts[0].answer.origin.clone();
    py.detach(|| {
        let batches = parts.iter().flat_map(|part| part.records.batches());
        let batches: Vec<_> = batches.cloned().collect();
        let groups = batches.iter().map(|batch| records(batch).map_err(broken));
        let answer = summed_up(manifest, origin, (wall_s, threads), groups)?;
        Ok(PyRun { answer, records: Table::new(schema(), batches) })
    })
}
