//! Stand-in for the reader of workbooks in a program that is built without: each of them is
//! refused.

use super::Content;

/// Refuses a workbook.
pub(super) fn read(_bytes: &[u8]) -> Result<Content, String> {
    Err("is a workbook, which the engine of a tab does not read: save the sheet as CSV".to_owned())
}
