//! The files of a folder, read by what they are.

use super::{LearnRequest, LearntFile};
use crate::error::Error;
use crate::source::Source;
use crate::watch::{Progress, Watch};
use ocmc_estimation::log::road::{MissingLimits, RoadOptions};
use ocmc_io::export::{ExportKind, drawn, files, has_limits, kind_of};
use ocmc_io::file_error::FileError;
use ocmc_io::given_cycle;
use ocmc_io::intake::FileAccount;
use ocmc_io::log::LoggedTrip;
use ocmc_io::log::roads::{FoundRoads, RoadsApart, told_once};
use ocmc_io::table::Quantity;
use ocmc_io::trip_totals::{self, TripTotal, TripTotals};
use std::path::{Path, PathBuf};

const SECONDS_PER_DAY: f64 = 86_400.0;

/// Roads of the drives that are not held back, and of those that are.
#[derive(Clone, Default)]
pub(super) struct ReadRoads {
    others: FoundRoads,
    held_back: FoundRoads,
}

impl ReadRoads {
    /// All of them, or without those that are held back.
    pub(super) fn joined(&self, all: bool) -> FoundRoads {
        let mut roads = self.others.clone();
        if all {
            roads.append(self.held_back.clone());
        }
        roads
    }
}

/// Accounts of the files that were read.
pub(super) struct Read {
    pub(super) files: Vec<LearntFile>,
    /// Roads with limits of their own.
    pub(super) limited: ReadRoads,
    /// Roads without them.
    pub(super) unlimited: ReadRoads,
    /// Totals, and where they are from.
    pub(super) totals: Option<(TripTotals, PathBuf)>,
    pub(super) inputs: Vec<FileAccount>,
    pub(super) warnings: Vec<String>,
    /// Trips whose drawn number is below it are held back.
    bound: f64,
}

impl Read {
    pub(super) fn of(request: &LearnRequest, watch: &mut Watch) -> Result<Self, Error> {
        let LearnRequest { folder, mappings, .. } = request;
        let paths = files(folder).map_err(FileError::read(folder))?;
        let mut read = Self {
            files: Vec::new(),
            limited: ReadRoads::default(),
            unlimited: ReadRoads::default(),
            totals: None,
            inputs: Vec::new(),
            warnings: Vec::new(),
            bound: request.hold_back,
        };
        let mut of_logs: Option<TripTotals> = None;
        let mut kinds: Vec<_> = paths.iter().map(|path| (path, kind_of(path, mappings))).collect();
        // totals first: they say which trips are held back
        kinds.sort_by_key(|(_, kind)| !matches!(kind, Ok(Some(ExportKind::Totals))));
        for (done, (path, kind)) in kinds.into_iter().enumerate() {
            Progress::of_logs(done, paths.len()).look(watch)?;
            let (kind, left_out) = match kind {
                Ok(Some(kind)) => {
                    let result = read.take(request, kind, path, &mut of_logs);
                    (Some(kind), result.err())
                }
                Ok(None) => (None, Some("no table or track that tells of trips".to_owned())),
                Err(error) => (None, Some(error.to_string())),
            };
            let path = path.strip_prefix(folder).unwrap_or(path).to_owned();
            read.files.push(LearntFile { path, kind, left_out });
        }
        read.files.sort_by(|a, b| a.path.cmp(&b.path));
        if read.totals.is_none() {
            read.totals = of_logs.map(|totals| (totals, folder.clone()));
        }
        let heaps = [&read.limited, &read.unlimited];
        let heaps = heaps.map(|roads| [&roads.others, &roads.held_back]).concat();
        let of_roads = heaps.iter().flat_map(|roads| &roads.notes).cloned();
        let of_files = read.inputs.iter().flat_map(FileAccount::warnings);
        let left_out = heaps.iter().flat_map(|roads| &roads.left_out);
        let left_out = left_out.map(|(place, fault)| format!("{place} is left out: {fault}"));
        read.warnings = told_once(of_roads.chain(left_out).chain(of_files));
        Ok(read)
    }

    /// Reads a file; the reason where it is not used.
    fn take(
        &mut self,
        request: &LearnRequest,
        kind: ExportKind,
        path: &Path,
        of_logs: &mut Option<TripTotals>,
    ) -> Result<(), String> {
        let mappings = &request.mappings;
        let source = Source::File(path.to_owned());
        match kind {
            ExportKind::Totals => {
                let (totals, account) =
                    trip_totals::read(source.lent(), mappings).map_err(|e| e.to_string())?;
                self.inputs.push(account);
                self.join(totals, path)?;
                self.bound = self.bound(request);
                Ok(())
            }
            ExportKind::Log => {
                let options = RoadOptions {
                    missing_limits: MissingLimits::OfSpeed,
                    curb_mass_kg: Some(request.base.1.model.vehicle.curb_mass_kg),
                    ..RoadOptions::default()
                };
                let is_held_back = |drive: &LoggedTrip| self.is_held_back(request, drive);
                let apart =
                    FoundRoads::of_log_apart(source.lent(), mappings, &options, &is_held_back);
                let RoadsApart { mut others, held_back, totals } =
                    apart.map_err(|error| error.to_string())?;
                self.inputs.append(&mut others.inputs);
                let is_limited = has_limits(path, mappings);
                let heap = if is_limited { &mut self.limited } else { &mut self.unlimited };
                heap.others.append(others);
                heap.held_back.append(held_back);
                for (amount, total) in totals {
                    let all = of_logs
                        .get_or_insert_with(|| TripTotals { amount, ..TripTotals::default() });
                    if all.amount == amount {
                        all.rows.push(total);
                    }
                }
                Ok(())
            }
            ExportKind::OperatingCycle => {
                let (cycle, account) =
                    given_cycle::read_with_account(path, &[]).map_err(|e| e.to_string())?;
                self.limited.others.add_cycle(cycle);
                self.inputs.push(account);
                Ok(())
            }
            // read by their fits
            ExportKind::Weather
            | ExportKind::Traffic
            | ExportKind::Curves
            | ExportKind::SpeedChanges => Ok(()),
        }
    }

    /// Adds a table of totals to those before, where it is one of the same kind.
    fn join(&mut self, mut more: TripTotals, path: &Path) -> Result<(), String> {
        let Some((all, first)) = &mut self.totals else {
            self.totals = Some((more, path.to_owned()));
            return Ok(());
        };
        if all.amount != more.amount || all.of_fills != more.of_fills {
            return Err(format!(
                "its rows are of another kind than those of `{}`",
                first.display()
            ));
        }
        all.rows.append(&mut more.rows);
        all.left_out += more.left_out;
        Ok(())
    }

    /// The rows that are held back, and the others.
    pub(super) fn apart(
        &self,
        request: &LearnRequest,
        table: &TripTotals,
    ) -> (Vec<TripTotal>, Vec<TripTotal>) {
        table.rows.iter().cloned().partition(|row| drawn_of(request, row) < self.bound)
    }

    /// The number below which a row is held back: so that the share of the rows is.
    fn bound(&self, request: &LearnRequest) -> f64 {
        let rows = self.totals.iter().flat_map(|(table, _)| &table.rows);
        let mut all: Vec<f64> = rows.map(|row| drawn_of(request, row)).collect();
        all.sort_by(f64::total_cmp);
        let count = libm::round(request.hold_back * all.len() as f64) as usize;
        all.get(count).copied().unwrap_or(request.hold_back)
    }

    /// Whether the trip of a drive is held back: drives without a truck or a day are not.
    fn is_held_back(&self, request: &LearnRequest, drive: &LoggedTrip) -> bool {
        let first = drive.column(Quantity::DayOfYear).and_then(|days| days.first().copied());
        let (Some(day), Some(truck)) = (first, &drive.truck) else { return false };
        drawn(request.seed, truck, day, "") < self.bound
    }

    /// Files of a kind.
    pub(super) fn of_kind(&self, folder: &Path, kind: ExportKind) -> Vec<Source> {
        let files = self.files.iter();
        let files = files.filter(|file| file.kind == Some(kind) && file.left_out.is_none());
        files.map(|file| Source::File(folder.join(&file.path))).collect()
    }
}

/// The number that is drawn for a row.
fn drawn_of(request: &LearnRequest, row: &TripTotal) -> f64 {
    drawn(request.seed, &row.truck, row.s_of_year / SECONDS_PER_DAY, &row.place.to_string())
}
