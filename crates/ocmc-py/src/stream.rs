//! Records as a stream of Arrow, and what tells one that is whole.

use crate::table::Table;
use arrow_ipc::writer::StreamWriter;
use ocmc_api::schema;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use sha2::{Digest, Sha256};
use std::fmt::Display;

/// What is no pickled run.
pub(crate) fn broken(error: impl Display) -> PyErr {
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
