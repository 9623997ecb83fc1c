//! Drives given to replace a study's own roads: routes, for the study's drivers, or a speed to
//! follow.

use crate::given_cycle::{Account, RouteOptions, account};
use crate::intake::FileAccount;
use crate::intake::table::given::GivenTable;
use crate::intake::table::{Mapping, Source, TableError};
use crate::study::{LoadedStudy, StudyFileError};
use crate::{drive_cycle, given_cycle};
use ocmc_core::kernel::drive::scheduler::Deliver;
use ocmc_core::operating_cycle::drawn_part::Draw;
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::route::{Keep, RouteModel};
use ocmc_core::prescribed::{DriveCycle, follow_planned, follow_study};
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_fleet::run::{Ranges, RunPlan, replay, run, run_with};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// How a speed is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Follow {
    /// By a driver of the study: its speeds are limits along the road, its standstills are stops.
    Driver,
    /// Without a driver: the exact force balance of the prescribed speed.
    Exact,
}

impl Follow {
    /// Both ways.
    pub const ALL: [Self; 2] = [Self::Driver, Self::Exact];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Driver => "driver",
            Self::Exact => "exact",
        }
    }
}

/// Drive cycle that the trucks of a run follow, as its manifest keeps it: with the study, enough to
/// follow it again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Followed {
    /// How.
    pub how: Follow,
    /// The file that it was read from, or the name of the table.
    pub file: String,
    /// The drive cycle, a table in CSV; absent where it is the speed that drivers plan on the
    /// study's routes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cycle: Option<String>,
}

/// Why nothing can be driven.
#[derive(Debug, Error)]
pub enum GivenDriveError {
    /// Several files where one can be followed.
    #[error("a speed is followed of one file; give one")]
    Several,
    /// A route, which has a driver anyway.
    #[error(
        "`driver` takes a drive cycle over time; a route is driven by a driver when no speed is \
         followed"
    )]
    Route,
    /// A drive cycle, from which nothing can be kept.
    #[error(
        "`{}` is a drive cycle over time, which has no weather, traffic or mission to keep: leave \
         `keep` out",
        .0.display()
    )]
    Keep(PathBuf),
    /// A drive cycle, of which nothing can be drawn.
    #[error(
        "`{}` is a drive cycle over time, which is followed as it is: leave `draw` out",
        .0.display()
    )]
    Draw(PathBuf),
    /// A stop plan that is no route's.
    #[error("a stop plan is driven on one route: give one, and follow no speed")]
    StopPlan,
    /// A drive cycle or a route that is not one.
    #[error(transparent)]
    File(#[from] TableError),
}

/// Drive that is given.
#[derive(Clone, Debug)]
pub struct GivenDrive {
    files: Vec<PathBuf>,
    mappings: Vec<Mapping>,
    keep: Vec<Keep>,
    draw: Vec<Draw>,
    stop_plan: Option<PathBuf>,
    /// Content of the route, in CSV, where it is no file but a table of a calling program.
    table: Option<String>,
    how: How,
    /// Account of a drive cycle that was read.
    read: Option<FileAccount>,
}

#[derive(Clone, Debug)]
enum How {
    /// Drivers on the study's roads, or on the routes.
    Driven,
    /// A driver on the road that a drive cycle makes.
    CycleAsRoute(Box<GivenCycle>, DriveCycle),
    /// The speed of a drive cycle.
    Cycle(DriveCycle),
    /// The speed that drivers plan along a route.
    Planned,
}

impl GivenDrive {
    /// Nothing is given: the study's own roads are driven.
    pub fn nothing() -> Self {
        Self {
            files: Vec::new(),
            mappings: Vec::new(),
            keep: Vec::new(),
            draw: Vec::new(),
            stop_plan: None,
            table: None,
            how: How::Driven,
            read: None,
        }
    }

    /// Reads what has to be known before a study is. Routes are read with the study.
    ///
    /// # Errors
    /// [`GivenDriveError`] names the file, the place and what is allowed.
    pub fn read(
        files: Vec<PathBuf>,
        mappings: Vec<Mapping>,
        keep: Vec<Keep>,
        mut draw: Vec<Draw>,
        stop_plan: Option<PathBuf>,
        follow: Option<Follow>,
    ) -> Result<Self, GivenDriveError> {
        // the order in which parts are named makes no other run
        draw.sort_by_key(|part| Draw::ALL.iter().position(|known| known == part));
        draw.dedup();
        if stop_plan.is_some() && (files.len() != 1 || follow.is_some()) {
            return Err(GivenDriveError::StopPlan);
        }
        let (how, read) = match follow {
            None => (How::Driven, None),
            Some(follow) => {
                let [file] = files.as_slice() else { return Err(GivenDriveError::Several) };
                let options =
                    RouteOptions { mappings: &mappings, draw: &draw, ..RouteOptions::default() };
                followed(Source::File(file), options, follow)?
            }
        };
        Self { files, mappings, keep, draw, stop_plan, table: None, how, read }.checked()
    }

    /// A route, or a drive cycle over time, that a calling program holds as a table.
    ///
    /// # Errors
    /// As [`GivenDrive::read`].
    pub fn of_table(
        table: &GivenTable,
        mappings: Vec<Mapping>,
        keep: Vec<Keep>,
        draw: Vec<Draw>,
        stop_plan: Option<PathBuf>,
        follow: Option<Follow>,
    ) -> Result<Self, GivenDriveError> {
        let source = Source::Given(table);
        let files = vec![table.path().to_owned()];
        if follow.is_some() && stop_plan.is_some() {
            return Err(GivenDriveError::StopPlan);
        }
        // a route is part of the study that a manifest keeps
        let is_route = follow.is_none() || !drive_cycle::is_one(source, &mappings);
        let written = is_route.then(|| table.written()).transpose()?;
        let text = written.as_ref().map(GivenTable::to_csv).transpose()?;
        let given = Self { files, mappings, keep, draw, stop_plan, table: text, ..Self::nothing() };
        let (how, read) = if let Some(follow) = follow {
            followed(source, given.options(), follow)?
        } else {
            given_cycle::read_route(table.path(), given.options()).map_err(|error| {
                let (mappings, draw) = (&given.mappings, &given.draw);
                let check = |table| given_cycle::check_table(table, mappings, draw).err();
                written.as_ref().and_then(check).unwrap_or(error)
            })?;
            (How::Driven, None)
        };
        Self { how, read, ..given }.checked()
    }

    /// A drive cycle says nothing that a route could keep, and lacks nothing.
    fn checked(self) -> Result<Self, GivenDriveError> {
        match (&self.how, self.files.first()) {
            (How::CycleAsRoute(..) | How::Cycle(_), Some(path)) if !self.keep.is_empty() => {
                Err(GivenDriveError::Keep(path.clone()))
            }
            (How::CycleAsRoute(..) | How::Cycle(_), Some(path)) if !self.draw.is_empty() => {
                Err(GivenDriveError::Draw(path.clone()))
            }
            _ => Ok(self),
        }
    }

    /// Content of it that a manifest keeps. The routes of a run are in its study.
    pub fn followed(&self) -> Option<Followed> {
        let (how, cycle) = match &self.how {
            How::Driven => return None,
            How::CycleAsRoute(_, cycle) => (Follow::Driver, Some(cycle)),
            How::Cycle(cycle) => (Follow::Exact, Some(cycle)),
            How::Planned => (Follow::Exact, None),
        };
        let file = self.files.first().map(|file| file.display().to_string());
        let cycle = cycle.map(drive_cycle::to_csv);
        Some(Followed { how, file: file.unwrap_or_default(), cycle })
    }

    /// Name of a run of it: the study's, and that of the drive that is driven instead of the
    /// study's roads.
    pub fn name_of_run(&self, study: &str) -> String {
        if let Some(Followed { how, file, .. }) = self.followed() {
            return format!("{study} following {file} ({})", how.name());
        }
        let files: Vec<_> = self.files.iter().map(|file| file.display()).collect();
        match files.as_slice() {
            [] => study.to_owned(),
            [file] => format!("{study} on {file}"),
            [first, second] => format!("{study} on {first}, {second}"),
            [first, others @ ..] => format!("{study} on {first} and {} more", others.len()),
        }
    }

    /// Drive that was given to the run of a manifest.
    ///
    /// # Errors
    /// [`GivenDriveError`], where it is not what [`GivenDrive::followed`] gives.
    pub fn of_followed(followed: Option<&Followed>) -> Result<Self, GivenDriveError> {
        let Some(Followed { how, file, cycle: text }) = followed else {
            return Ok(Self::nothing());
        };
        let file = PathBuf::from(file);
        let how = match (text, how) {
            (Some(text), how) => cycle(Source::Text(&file, text), &[], *how)?.0,
            (None, Follow::Exact) => How::Planned,
            (None, Follow::Driver) => return Err(GivenDriveError::Route),
        };
        Ok(Self { files: vec![file], how, ..Self::nothing() })
    }

    /// How its routes are read.
    fn options(&self) -> RouteOptions<'_> {
        let (stop_plan, table) = (self.stop_plan.as_deref(), self.table.as_deref());
        RouteOptions { mappings: &self.mappings, draw: &self.draw, stop_plan, table }
    }

    /// Whether nothing is given.
    pub fn is_nothing(&self) -> bool {
        self.files.is_empty()
    }

    /// Whether files are given that a study's routes are made of.
    pub fn has_routes(&self) -> bool {
        matches!(self.how, How::Driven | How::Planned) && !self.files.is_empty()
    }

    /// Warnings about it: missions that are kept of files that hold no departure.
    pub fn warnings(&self) -> Vec<String> {
        if !self.keep.contains(&Keep::Mission) {
            return Vec::new();
        }
        // what cannot be read is said when the study is made
        let without = |file: &&PathBuf| {
            let read = given_cycle::read_route(file, self.options());
            read.is_ok_and(|(cycle, _)| cycle.departure.is_none() && cycle.planned.is_none())
        };
        let message = |file: &PathBuf| {
            format!(
                "`{}` holds no departure, which is drawn from the study: of what `ocmc cycle` \
                 writes only the .json has it",
                file.display()
            )
        };
        self.files.iter().filter(without).map(message).collect()
    }

    /// Why a key of the study has no effect on what is driven; none where it may have one.
    pub fn without_effect(&self, key: &str) -> Option<&'static str> {
        let is_below = |tables: &[&str]| {
            tables.iter().any(|table| {
                key.strip_prefix(table).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
            })
        };
        // what is drawn hangs on the study's numbers
        let road: &[&str] = if self.draw.contains(&Draw::Hills) {
            &["mission.length_m"]
        } else {
            &["road.climb_rule", "road.net_climb_m", "mission.length_m"]
        };
        match &self.how {
            How::Cycle(_)
                if is_below(&["driver", "traffic", "road", "mission.stops"]) || is_below(road) =>
            {
                Some("the speed of the file is followed, without a driver or a road")
            }
            How::CycleAsRoute(..) | How::Driven | How::Planned
                if self.has_files() && is_below(road) =>
            {
                Some("the road is that of the file")
            }
            _ => None,
        }
    }

    fn has_files(&self) -> bool {
        !self.files.is_empty()
    }

    /// Account of a drive cycle that was read.
    pub fn cycle_account(&self) -> Option<&FileAccount> {
        self.read.as_ref()
    }

    /// Accounts of all files that are driven.
    pub fn inputs(&self) -> Vec<FileAccount> {
        let routes = self.accounts().into_iter().map(|account| account.read);
        self.read.iter().cloned().chain(routes).collect()
    }

    /// Accounts of the routes, and the parts of them that are hardly a road. A file that cannot be
    /// read is said when the study is made.
    pub fn accounts(&self) -> Vec<Account> {
        let files = if self.has_routes() { self.files.as_slice() } else { &[] };
        let read = |file: &PathBuf| {
            let (cycle, read) = given_cycle::read_route(file, self.options()).ok()?;
            Some(account(file, &cycle, read))
        };
        files.iter().filter_map(read).collect()
    }

    /// Whether this is what a run was given that followed this and had these routes; names of files
    /// do not matter.
    ///
    /// # Errors
    /// Names the file that cannot be read.
    pub fn is_that_of(
        &self,
        run_followed: Option<&Followed>,
        run_routes: &[RouteModel],
    ) -> Result<bool, TableError> {
        let essence = |followed: Option<Followed>| followed.map(|f| (f.how, f.cycle));
        if essence(self.followed()) != essence(run_followed.cloned()) {
            return Ok(false);
        }
        if !self.has_routes() {
            return Ok(true);
        }
        let mut same = run_routes.len() == self.files.len();
        for (file, route) in self.files.iter().zip(run_routes) {
            same &= route.sha256.as_ref()
                == Some(&given_cycle::file_hash(file, self.table.as_deref())?);
            same &= route.keep == self.keep && route.draw == self.draw;
            same &= route.columns == Mapping::columns(&self.mappings);
            let plan = self.stop_plan.as_deref();
            let plan = plan.map(|plan| given_cycle::file_hash(plan, None)).transpose()?;
            same &= route.stop_plan_sha256 == plan;
        }
        Ok(same)
    }

    /// Whether there is no driver.
    fn is_exact(&self) -> bool {
        matches!(self.how, How::Cycle(_) | How::Planned)
    }

    /// The study as it is driven.
    ///
    /// # Errors
    /// As [`LoadedStudy::on_routes`].
    pub fn study(&self, loaded: LoadedStudy) -> Result<LoadedStudy, StudyFileError> {
        if self.has_routes() {
            return loaded.on_routes(&self.files, &self.keep, self.options());
        }
        self.study_again(loaded)
    }

    /// The study of a manifest as it was driven: its routes are in it.
    ///
    /// # Errors
    /// As [`LoadedStudy::on_routes`].
    pub fn study_again(&self, loaded: LoadedStudy) -> Result<LoadedStudy, StudyFileError> {
        match &self.how {
            How::CycleAsRoute(route, _) => {
                // the speeds that are followed are signs of the route, and stand where they stand
                let loaded = loaded.with_signs_in_place();
                loaded.on_route(&self.files[0], (**route).clone(), &[Keep::Traffic])
            }
            How::Driven | How::Cycle(_) | How::Planned => Ok(loaded),
        }
    }

    /// The record of one cycle without a driver.
    fn record(&self, study: &Study, seed: u64, cycle_id: u64) -> Record {
        match &self.how {
            How::Cycle(cycle) => follow_study(study, seed, cycle_id, cycle).0,
            _ => follow_planned(study, seed, cycle_id).0,
        }
    }

    /// Drives the plan, as [`run`] does.
    pub fn run<B>(
        &self,
        study: &Study,
        plan: &RunPlan,
        sink: impl FnMut(Vec<Record>) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        if !self.is_exact() {
            return run(study, plan, sink);
        }
        let each = |ranges: Ranges, stop: &AtomicBool, deliver: Deliver| {
            let ids = ranges.flatten().take_while(|_| !stop.load(Ordering::Relaxed));
            ids.for_each(|cycle_id| deliver(self.record(study, plan.seed, cycle_id)));
        };
        run_with(plan, &each, sink)
    }

    /// Drives the plan and returns the records; `progress` receives the number of cycles driven so
    /// far, and may end it.
    pub fn records<B>(
        &self,
        study: &Study,
        plan: &RunPlan,
        mut progress: impl FnMut(u64) -> ControlFlow<B>,
    ) -> ControlFlow<B, Vec<Record>> {
        let mut all = Vec::new();
        self.run(study, plan, |records| {
            all.extend(records);
            progress(all.len() as u64)
        })?;
        ControlFlow::Continue(all)
    }

    /// Drives single cycles again, as [`replay`] does.
    pub fn replay(&self, study: &Study, seed: u64, cycle_ids: &[u64]) -> Vec<Record> {
        if !self.is_exact() {
            return replay(study, seed, cycle_ids);
        }
        cycle_ids.iter().map(|cycle_id| self.record(study, seed, *cycle_id)).collect()
    }
}

fn followed(
    source: Source,
    options: RouteOptions,
    follow: Follow,
) -> Result<(How, Option<FileAccount>), GivenDriveError> {
    if !drive_cycle::is_one(source, options.mappings) {
        if follow == Follow::Driver {
            return Err(GivenDriveError::Route);
        }
        given_cycle::read_route(source.path(), options)?;
        return Ok((How::Planned, None));
    }
    let (how, read) = cycle(source, options.mappings, follow)?;
    Ok((how, Some(read)))
}

fn cycle(
    source: Source,
    mappings: &[Mapping],
    follow: Follow,
) -> Result<(How, FileAccount), TableError> {
    let (cycle, read) = drive_cycle::read_with_account(source, mappings)?;
    let how = match follow {
        Follow::Driver => {
            How::CycleAsRoute(Box::new(drive_cycle::as_route(source.path(), &cycle)?), cycle)
        }
        Follow::Exact => How::Cycle(cycle),
    };
    Ok((how, read))
}
