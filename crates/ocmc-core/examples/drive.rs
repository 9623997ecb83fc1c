//! The engine alone: drives cycles of a study whose resolved keys come as JSON on standard input,
//! and writes all numbers of the records to standard output, as little-endian values, row by row.
//!
//! It needs nothing but the core. Compiled for the tab of a browser it says how large that is:
//! `scripts/build-tab --core`.

use ocmc_core::kernel::drive::cpu::CpuLevel;
use ocmc_core::kernel::drive::scheduler::drive;
use ocmc_core::record::{COLUMNS, Cell};
use ocmc_core::study::{Study, StudyModel};
use std::error::Error;
use std::io::{Write, stdin, stdout};

fn main() -> Result<(), Box<dyn Error>> {
    let model: StudyModel = serde_json::from_reader(stdin())?;
    let study = Study::new(model)?;
    let mut out = stdout().lock();
    for record in drive(&study, 1, 0..200, CpuLevel::best()) {
        for column in COLUMNS {
            match column.get(&record) {
                Cell::Integer(Some(number)) => out.write_all(&number.to_le_bytes())?,
                Cell::Number(Some(number)) => out.write_all(&number.to_le_bytes())?,
                Cell::Outcome(outcome) => out.write_all(&[outcome as u8])?,
                Cell::Integer(None) | Cell::Number(None) => (),
            }
        }
    }
    Ok(())
}
