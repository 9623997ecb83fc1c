//! `ocmc man`: manual pages, one for each sub-command.

use crate::arguments::Arguments;
use crate::failure::Failure;
use clap::CommandFactory;
use std::fs;
use std::path::Path;

/// Writes the pages to a directory, which is created where it does not exist.
pub(crate) fn man(directory: &Path) -> Result<(), Failure> {
    fs::create_dir_all(directory)
        .and_then(|()| clap_mangen::generate_to(Arguments::command(), directory))
        .map_err(|source| Failure::File { path: directory.to_owned(), source })
}
