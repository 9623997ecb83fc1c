//! Where measurements come from.

use crate::error::Error;
use ocmc_core::threads::CAN_START;
use ocmc_estimation::log::road::RoadOptions;
use ocmc_io::log::curves::Steering;
use ocmc_io::log::roads::{FoundRoads, NEEDS};
use ocmc_io::log::{LogFile, Need, read};
use ocmc_io::table;
use ocmc_vecto::comparison::ComparisonError;
use ocmc_vecto::file::vmod;
use std::path::{Path, PathBuf};

pub use ocmc_io::table::Mapping;
pub use ocmc_io::table::given::GivenTable;

/// Where measurements come from.
#[derive(Clone, Debug)]
pub enum Source {
    /// A file.
    File(PathBuf),
    /// A table of a calling program.
    Table(GivenTable),
}

impl Source {
    /// Path of the source in messages.
    pub fn path(&self) -> &Path {
        match self {
            Self::File(path) => path,
            Self::Table(table) => table.path(),
        }
    }

    /// As the reader of tables takes it.
    pub(crate) fn lent(&self) -> table::Source<'_> {
        match self {
            Self::File(path) => table::Source::File(path),
            Self::Table(table) => table::Source::Given(table),
        }
    }

    /// Reads it as a log, and warns of what is odd in it.
    pub(crate) fn log(
        &self,
        mappings: &[Mapping],
        needs: &[Need],
        warn: &mut dyn FnMut(&str),
    ) -> Result<LogFile, Error> {
        let file = self.quiet_log(mappings, needs)?;
        file.read.warnings().iter().for_each(|warning| warn(warning));
        Ok(file)
    }

    /// Reads it as a log, and finds the roads of its drives.
    pub(crate) fn roads(
        &self,
        mappings: &[Mapping],
        options: &RoadOptions,
        steering: Option<Steering>,
    ) -> Result<FoundRoads, Error> {
        if matches!(self, Self::File(path) if vmod::is_one(path)) {
            let mut found_roads = FoundRoads::default();
            found_roads.add(self.quiet_log(mappings, &NEEDS)?, options, steering);
            return Ok(found_roads);
        }
        Ok(FoundRoads::of_log(self.lent(), mappings, options, steering)?)
    }

    /// Reads it as a log.
    pub(crate) fn quiet_log(&self, mappings: &[Mapping], needs: &[Need]) -> Result<LogFile, Error> {
        Ok(match self {
            Self::File(path) if vmod::is_one(path) => {
                vmod::read(path).map_err(ComparisonError::from)?
            }
            _ => read(self.lent(), mappings, needs)?,
        })
    }
}

/// Reads each of some things, as many at once as there are threads, and gives them in their order.
pub(crate) fn read_at_once<T: Sync, R: Send>(
    things: &[T],
    read: impl Fn(&T) -> R + Sync,
) -> impl Iterator<Item = R> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    things.chunks(threads).flat_map(move |batch| {
        if !CAN_START {
            return batch.iter().map(&read).collect::<Vec<R>>();
        }
        std::thread::scope(|scope| {
            let read = &read;
            let running: Vec<_> =
                batch.iter().map(|thing| scope.spawn(move || read(thing))).collect();
            let ended = running.into_iter().map(std::thread::ScopedJoinHandle::join);
            // a panic of a thread goes on here
            ended
                .map(|ended| ended.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
                .collect::<Vec<R>>()
        })
    })
}

/// Reads `NAME=COLUMN`, each of which says which column of a table is what.
///
/// ```
/// assert!(ocmc_api::mappings(&["speed_mph=gps_speed".to_owned()]).is_ok());
/// assert!(ocmc_api::mappings(&["speed_parsec=gps_speed".to_owned()]).is_err());
/// ```
///
/// # Errors
/// [`Error::Table`] where a name means nothing.
pub fn mappings(assignments: &[String]) -> Result<Vec<Mapping>, Error> {
    Ok(assignments.iter().map(|text| Mapping::parse(text)).collect::<Result<_, _>>()?)
}
