//! Tables on their way between processes: as an Arrow stream with a checksum, for the library ends
//! some damaged streams by a panic.

use arrow_array::RecordBatch;
use arrow_ipc::reader::StreamReader;
use arrow_ipc::writer::StreamWriter;
use arrow_schema::{Schema, SchemaRef};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sha2::{Digest, Sha256};
use std::fmt::Display;

/// Error of a pickle that is not whole, or not of this program.
pub(crate) fn broken(error: impl Display) -> PyErr {
    PyValueError::new_err(format!("no pickle of ocmc: {error}"))
}

/// A table of such batches as a stream.
pub(crate) fn stream_of(schema: &Schema, batches: &[RecordBatch]) -> PyResult<Vec<u8>> {
    let written = || {
        let mut writer = StreamWriter::try_new(Vec::new(), schema)?;
        batches.iter().try_for_each(|batch| writer.write(batch))?;
        writer.into_inner()
    };
    written().map_err(broken)
}

/// The checksum of a text and a stream.
pub(crate) fn checksum(text: &str, stream: &[u8]) -> Vec<u8> {
    Sha256::new().chain_update(text).chain_update(stream).finalize().to_vec()
}

/// Schema and batches of a stream, after its checksum was looked at.
pub(crate) fn read(
    text: &str,
    stream: &[u8],
    sum: &[u8],
) -> PyResult<(SchemaRef, Vec<RecordBatch>)> {
    if checksum(text, stream) != sum {
        return Err(broken("its checksum is another one"));
    }
    let reader = StreamReader::try_new(stream, None).map_err(broken)?;
    let schema = reader.schema();
    Ok((schema, reader.collect::<Result<_, _>>().map_err(broken)?))
}
