//! A fleet of groups of trucks: each group drives its own study, and what they use adds up.
//!
//! The trucks of a fleet are numbered through, so that no two have the same draws: a group begins
//! with the first truck behind those before it whose first trip is behind theirs, too. A group is
//! a run of its own, with the records that its study alone would have from there on.
//!
//! Total of the fleet: Σ T_g over its groups; another fleet of as many trucks lies within
//! ± √Σ h_g², h_g that of a group. Where trucks share drivers or days these are drawn alike in all
//! groups: ± Σ h_g then, which is at least as wide.

mod page;

use crate::answer::Answer;
use crate::error::Error;
use crate::named_total::{NamedTotal, named_totals, totals_text};
use crate::run::{
    Asked, CpuLevel, RecordFormat, RequeueRequest, RunAnswer, RunEnd, RunPlan, RunRequest, WIDTH,
    judged, requeue, run,
};
use crate::study::FleetGroup;
use crate::text::{fact, table, threads_text};
use crate::watch::{Progress, Watch, watched};
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::run::records;
use ocmc_fleet::summary::SummaryBuilder;
use ocmc_fleet::truck_arrivals::TruckArrivals;
use ocmc_fleet::truck_year::Total;
use ocmc_io::fleet_total::place;
use ocmc_io::given_drive::GivenDrive;
use ocmc_io::label::label;
use ocmc_io::number_text::{count_of, grouped, rough, short};
use ocmc_io::run_directory::check_free_of_groups;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Instant;

/// A fleet that is to drive.
#[derive(Clone, Debug)]
pub struct MixedFleetRequest<'a> {
    /// Groups of it.
    pub groups: &'a [FleetGroup],
    /// Master seed.
    pub seed: u64,
    /// Threads; one for each CPU where there is no number.
    pub threads: Option<usize>,
    /// Instructions to use.
    pub level: CpuLevel,
    /// Directory in which each group has its run, and the whole its answer and page; and the format
    /// of the records.
    pub out: Option<(PathBuf, RecordFormat)>,
    /// Whether runs of groups that are there are finished.
    pub resume: bool,
}

/// Totals of a fleet, and its groups.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct MixedFleetAnswer {
    /// Study, or its file.
    pub study: String,
    /// Master seed.
    pub seed: u64,
    /// Trucks of all groups.
    pub trucks: u64,
    /// Totals of the fleet.
    pub totals: Vec<NamedTotal>,
    /// Groups, in the order of the file.
    pub groups: Vec<GroupAnswer>,
    /// Trucks of groups without a battery that those of a group with one could replace.
    pub replaceable: Vec<Replaceable>,
    /// How long it took, in s.
    pub wall_s: f64,
    /// Threads that it took.
    pub threads: usize,
}

/// A group of a fleet, and what it adds up to.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct GroupAnswer {
    /// Name of the group.
    pub group: String,
    /// Trucks of it.
    pub trucks: u64,
    /// The first of them.
    pub first_truck: u64,
    /// Trips that each makes.
    pub trips_per_truck: u64,
    /// Totals of the group.
    pub totals: Vec<NamedTotal>,
    /// Answer of its run.
    pub run: RunAnswer,
}

/// Trucks of a group whose trips arrive with the truck of another one.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Replaceable {
    /// Name of the group whose trips are driven.
    pub group: String,
    /// Name of the group whose truck drives them.
    pub vehicle_of: String,
    /// Trucks by the share of their trips that has to arrive.
    pub arrivals: Vec<TruckArrivals>,
}

/// Drives the groups of a fleet.
///
/// # Errors
/// [`Error::GroupWithoutTrips`] where trucks of a group make no more than one trip each,
/// [`Error::RunDirectory`] where the folder or a group of it has a run, before any is driven,
/// those of [`run`], and [`Error::Interrupted`]: what was finished of a directory is kept.
pub fn mixed_fleet(
    request: &MixedFleetRequest,
    watch: &mut Watch,
) -> Result<MixedFleetAnswer, Error> {
    let clock = Instant::now();
    let plans = plans(request)?;
    if let (Some((folder, _)), false) = (&request.out, request.resume) {
        let names: Vec<&str> = request.groups.iter().map(|group| &*group.name).collect();
        check_free_of_groups(folder, &names)?;
    }
    let others: u64 = pairs(request.groups).map(|(group, _)| plans[group].cycles).sum();
    let total = others + plans.iter().map(|plan| plan.cycles).sum::<u64>();
    let mut before = 0;
    let mut groups = Vec::new();
    for (group, plan) in request.groups.iter().zip(&plans) {
        let mut look = |progress: Progress| {
            watch(Progress { done: before + progress.done, total, ..progress })
        };
        let answer = driven(request, group, plan, &mut look)?;
        if answer.ended == RunEnd::Interrupted {
            let done = before + answer.summary.summary.cycles;
            return Err(Error::Interrupted(Progress { what: "cycles", done, total }));
        }
        before += plan.cycles;
        groups.push(GroupAnswer {
            group: group.name.clone(),
            trucks: group.trucks,
            first_truck: plan.first_cycle / trips(group),
            trips_per_truck: trips(group),
            totals: named_totals(&answer.summary.summary),
            run: answer,
        });
    }
    let mut replaceable = Vec::new();
    for (group, by) in pairs(request.groups) {
        let mut look = |progress: Progress| {
            watch(Progress { done: before + progress.done, total, ..progress })
        };
        let [of_group, by_group] = [group, by].map(|k| &request.groups[k]);
        replaceable.extend(replaced(of_group, by_group, &plans[group], &mut look)?);
        before += plans[group].cycles;
    }
    let shared = request.groups.iter().any(|group| dependence(group, request.seed).is_shared());
    let study = request.groups.first().map(|group| group.study.origin.to_string());
    let answer = MixedFleetAnswer {
        study: study.unwrap_or_default(),
        seed: request.seed,
        trucks: request.groups.iter().map(|group| group.trucks).sum(),
        totals: summed(&groups, shared),
        groups,
        replaceable,
        wall_s: clock.elapsed().as_secs_f64(),
        threads: plans.first().map_or(1, |plan| plan.threads),
    };
    if let Some((directory, _)) = &request.out {
        answer.save(directory)?;
    }
    Ok(answer)
}

fn trips(group: &FleetGroup) -> u64 {
    group.study.study.nesting().trips_per_truck
}

fn dependence(group: &FleetGroup, seed: u64) -> Dependence {
    Dependence::of(&group.study.model, seed)
}

/// Cycles of each group: ids that no other group has, of trucks and of trips.
fn plans(request: &MixedFleetRequest) -> Result<Vec<RunPlan>, Error> {
    let (mut truck, mut cycle) = (0_u64, 0_u64);
    let mut plans = Vec::new();
    for group in request.groups {
        let trips = trips(group);
        if trips < 2 {
            return Err(Error::GroupWithoutTrips(group.name.clone()));
        }
        let first_truck = truck.max(cycle.div_ceil(trips));
        let (first_cycle, cycles) = (first_truck * trips, group.trucks * trips);
        (truck, cycle) = (first_truck + group.trucks, first_cycle + cycles);
        let plan = RunPlan::new(request.seed, first_cycle, cycles, request.threads, None);
        plans.push(RunPlan { level: request.level, ..plan });
    }
    Ok(plans)
}

/// The run of a group.
fn driven(
    request: &MixedFleetRequest,
    group: &FleetGroup,
    plan: &RunPlan,
    watch: &mut Watch,
) -> Result<RunAnswer, Error> {
    let given = &GivenDrive::nothing();
    let out = request.out.as_ref().map(|(path, format)| (path.join(&group.name), *format));
    if let (Some((directory, format)), true) = (&out, request.resume) {
        let asked = Asked {
            loaded: Some(&group.study),
            files: group.study.files().clone(),
            seed: Some(plan.seed),
            first_cycle: Some(plan.first_cycle),
            cycles: Some(plan.cycles),
            format: Some(*format),
            ..Asked::default()
        };
        let (threads, level) = (request.threads, request.level);
        let request = RequeueRequest { directory, asked, given, threads, chunk: None, level };
        return requeue(&request, watch);
    }
    let request = RunRequest { study: &group.study, given, plan: *plan, precision: None, out };
    run(&request, &mut |_| (), watch)
}

/// Pairs of a group without a battery and one with one.
fn pairs(groups: &[FleetGroup]) -> impl Iterator<Item = (usize, usize)> {
    let plugs_in = |k: &usize| groups[*k].study.model.vehicle.powertrain.plugs_in();
    let with: Vec<usize> = (0..groups.len()).filter(plugs_in).collect();
    let without: Vec<usize> = (0..groups.len()).filter(|k| !with.contains(k)).collect();
    without.into_iter().flat_map(move |group| with.clone().into_iter().map(move |by| (group, by)))
}

/// Trucks of a group whose trips arrive with the truck, and the charging, of another one; none
/// where that truck cannot drive its study.
fn replaced(
    group: &FleetGroup,
    by: &FleetGroup,
    plan: &RunPlan,
    watch: &mut Watch,
) -> Result<Option<Replaceable>, Error> {
    let mut model = group.study.model.clone();
    model.vehicle.clone_from(&by.study.model.vehicle);
    model.charging.clone_from(&by.study.model.charging);
    model.uncertainty.clear();
    let Ok(study) = group.study.study.with_model(model) else { return Ok(None) };
    let mut fleet = SummaryBuilder::new(dependence(group, plan.seed));
    let driven = watched(plan.cycles, watch, |look| records(&study, plan, look))?;
    fleet.add(&driven);
    let arrivals = fleet.finish().truck_arrivals;
    let (group, vehicle_of) = (group.name.clone(), by.name.clone());
    Ok(Some(Replaceable { group, vehicle_of, arrivals }))
}

/// Totals of all groups. Costs in two currencies stay apart.
fn summed(groups: &[GroupAnswer], shared: bool) -> Vec<NamedTotal> {
    let mut sums: Vec<(NamedTotal, Vec<Option<f64>>)> = Vec::new();
    for of_group in groups.iter().flat_map(|group| &group.totals) {
        let half = of_group.total.prediction95.map(|[low, high]| (high - low) / 2.0);
        let same = |(sum, _): &&mut (NamedTotal, Vec<_>)| {
            (&sum.name, &sum.unit) == (&of_group.name, &of_group.unit)
        };
        if let Some((sum, halves)) = sums.iter_mut().find(same) {
            sum.total.total += of_group.total.total;
            halves.push(half);
        } else {
            sums.push((of_group.clone(), vec![half]));
        }
    }
    let with_interval = |(sum, halves): (NamedTotal, Vec<Option<f64>>)| {
        let halves: Option<Vec<f64>> = halves.into_iter().collect();
        let half = halves.map(|halves| {
            let squares = halves.iter().map(|half| half * half).sum();
            if shared { halves.iter().sum() } else { libm::sqrt(squares) }
        });
        let total = sum.total.total;
        let prediction95 = half.map(|half: f64| [total - half, total + half]);
        NamedTotal { total: Total { total, prediction95 }, ..sum }
    };
    sums.sort_by_key(|(sum, _)| place(&sum.name));
    sums.into_iter().map(with_interval).collect()
}

impl Answer for MixedFleetAnswer {
    fn warnings(&self) -> Vec<String> {
        self.groups.iter().flat_map(|group| group.run.warnings()).collect()
    }

    fn text(&self) -> String {
        let cycles: u64 = self.groups.iter().map(|group| group.run.summary.summary.cycles).sum();
        let count = count_of(self.groups.len() as u64, "group");
        let mut text = fact("study", &self.study)
            + &fact("seed", self.seed)
            + &fact("trips", grouped(cycles))
            + &fact("took", format!("{} s on {}", short(self.wall_s), threads_text(self.threads)));
        let trucks = count_of(self.trucks, "truck");
        let _ = writeln!(
            text,
            "\n{trucks} in {count}: totals ± where another fleet of as many would lie"
        );
        text += &totals_text(&self.totals);
        for GroupAnswer { group, trucks, trips_per_truck, totals, .. } in &self.groups {
            let each = count_of(*trips_per_truck, "trip");
            let _ = writeln!(text, "\n{group}: {}, {each} each", count_of(*trucks, "truck"));
            text += &totals_text(totals);
        }
        let consumptions = table(&[20, 14, 18, 9, 9, 9], &CONSUMPTIONS, self.consumptions());
        let _ = write!(text, "\n{consumptions}{}", self.doubts());
        let arrivals = self.arrivals();
        if !arrivals.is_empty() {
            text.push_str(
                "\nHow many can be electric: trucks of which all trips, or 95 %, arrive\n",
            );
            text += &table(&[20, 20, 9, 13, 13], &ARRIVALS, arrivals);
        }
        text
    }
}

impl MixedFleetAnswer {
    /// The consumption of each group: its name, the unit, mean, P5, P50 and P95.
    fn consumptions(&self) -> Vec<[String; 6]> {
        let line_of = |GroupAnswer { group, run, .. }: &GroupAnswer| {
            let own = run.summary.summary.consumption()?;
            let (name, factor) = label(own.column);
            let half = own.ci95.map(|[low, high]| rough(factor * (high - low) / 2.0));
            let mean = own.mean.map_or("-".to_owned(), |mean| short(factor * mean));
            let mean = half.map_or_else(|| mean.clone(), |half| format!("{mean} ± {half}"));
            let at =
                |k: usize| own.quantiles[k].value.map_or("-".to_owned(), |q| short(factor * q));
            Some([group.clone(), name.to_owned(), mean, at(0), at(2), at(4)])
        };
        self.groups.iter().filter_map(line_of).collect()
    }

    /// Contributions of judged numbers to the uncertainty of each group, a line each.
    fn doubts(&self) -> String {
        let doubts = self.groups.iter().map(|GroupAnswer { group, run, .. }| {
            let judged = judged(&run.summary, WIDTH - group.chars().count() - 2);
            if judged.is_empty() { judged } else { format!("{group}: {judged}") }
        });
        doubts.collect()
    }

    /// How many trucks could have a battery: of which group, driven by the truck of which group, of
    /// how many trucks, and of how many all trips, or 95 % of them, arrive.
    fn arrivals(&self) -> Vec<[String; 5]> {
        let own = self.groups.iter().filter_map(|group| {
            let arrivals = &group.run.summary.summary.truck_arrivals;
            (!arrivals.is_empty()).then_some((group.group.as_str(), "itself", arrivals))
        });
        let others = self.replaceable.iter();
        let others = others
            .map(|answer| (answer.group.as_str(), answer.vehicle_of.as_str(), &answer.arrivals));
        own.chain(others)
            .map(|(group, by, arrivals)| {
                let at = |k: usize| arrivals.get(k).map_or("-".to_owned(), |a| grouped(a.trucks));
                let trucks = arrivals.first().map_or("-".to_owned(), |a| grouped(a.of));
                [group.to_owned(), by.to_owned(), trucks, at(0), at(1)]
            })
            .collect()
    }
}

/// Names of the columns of [`MixedFleetAnswer::consumptions`].
const CONSUMPTIONS: [&str; 6] = ["of trips", "", "mean ± 95 %", "P5", "P50", "P95"];
/// Names of the columns of [`MixedFleetAnswer::arrivals`].
const ARRIVALS: [&str; 5] = ["trips of", "driven by", "trucks", "all arrive", "95 % arrive"];
