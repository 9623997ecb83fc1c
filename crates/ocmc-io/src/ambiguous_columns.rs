//! Two columns of a table for one quantity.

use std::path::{Path, PathBuf};
use thiserror::Error;

/// Two columns, one of which is to be read.
#[derive(Debug, Error)]
#[error(
    "`{}` has the columns `{}` and `{}`, and nothing says which of them is meant; allowed is one of them",
    path.display(),
    columns[0],
    columns[1]
)]
pub struct AmbiguousColumns {
    /// The file.
    pub path: PathBuf,
    /// Both columns.
    pub columns: [String; 2],
}

/// The place of the only column among those that could be meant, given with their places and names; none where there is none.
pub(crate) fn the_only<'a>(
    path: &Path,
    mut meant: impl Iterator<Item = (usize, &'a str)>,
) -> Result<Option<usize>, AmbiguousColumns> {
    match (meant.next(), meant.next()) {
        (Some((_, one)), Some((_, other))) => {
            let columns = [one.to_owned(), other.to_owned()];
            Err(AmbiguousColumns { path: path.to_owned(), columns })
        }
        (one, _) => Ok(one.map(|(place, _)| place)),
    }
}
