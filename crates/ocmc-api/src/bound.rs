//! The best that is possible: the least energy for the same road, truck and trip time, and how far
//! drivers are from it.

use crate::answer::Answer;
use crate::error::Error;
use crate::text::{fact, table, took};
use crate::trace::TimeSeries;
use crate::watch::{Watch, watched};
use ocmc_core::kernel::drive::trace::TableColumn;
use ocmc_core::powertrain::GearOrder;
use ocmc_core::prescribed::DriveCycle;
use ocmc_fleet::bound::{Bound, Fineness, Kind, Potential, TripBound, bounds};
use ocmc_fleet::ratio::Ratio;
use ocmc_fleet::run::RunPlan;
use ocmc_io::number_text::{count_of, grouped, rounded};
use ocmc_io::study::{LoadedStudy, study_hash};
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Instant;

/// Cycles to be bounded.
#[derive(Clone, Debug)]
pub struct BoundRequest<'a> {
    /// The study.
    pub study: &'a LoadedStudy,
    /// The cycles.
    pub plan: RunPlan,
}

/// How far the drivers are from what is possible.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct BoundAnswer {
    /// Name of the study.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// Number of cycles.
    pub cycles: u64,
    /// Cycles whose drivers did not arrive: they have no bound.
    pub failed: u64,
    /// Cycles in which nothing better than the driver was found.
    pub not_better: u64,
    /// Part of the drivers' energy that was not needed: in total, and by parts.
    pub potential: Vec<PotentialShare>,
    /// All of it by road type, of the fleet's whole energy.
    pub by_road_type: Vec<PotentialShare>,
    /// The cycles, in order of their ids.
    pub bounds: Vec<CycleBound>,
    /// Speed and gear of the optimum, where one cycle alone was asked for.
    #[serde(skip)]
    pub optimum: Option<TimeSeries>,
    /// How long it took, in s.
    pub wall_s: f64,
    /// Threads that it took.
    pub threads: usize,
}

/// A part of the potential.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct PotentialShare {
    /// Name of the part: `all`, `gears`, a kind of road, `remainder`, or a road type.
    pub name: String,
    /// Its share of the drivers' energy; none where no cycle counts.
    pub share: Option<f64>,
    /// 95 % interval of the share; none from a single cycle.
    pub ci95: Option<[f64; 2]>,
    /// Share of the road that is of this kind.
    pub road_share: Option<f64>,
}

/// One cycle.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct CycleBound {
    /// Its id.
    pub cycle_id: u64,
    /// Simulated energy, with wind, roughness and all of the driver's behaviour, in J of fuel or of
    /// the battery.
    pub simulated_energy_j: Option<f64>,
    /// The driver's speed and gears in the backward mode, in J.
    pub driver_energy_j: f64,
    /// The least that was found, in J.
    pub bound_energy_j: f64,
    /// Duration of the driver's trip, in s.
    pub driver_duration_s: f64,
    /// Duration of the optimum, in s.
    pub bound_duration_s: f64,
    /// The driver's shifts.
    pub driver_gear_shifts: u32,
    /// The optimum's shifts.
    pub bound_gear_shifts: u32,
    /// Worth of a second more or less to the optimum, in W.
    pub time_price_w: Option<f64>,
    /// Whether something better than the driver was found.
    pub better: bool,
}

/// One cycle while the answer is put together.
struct CyclePotential {
    bound: CycleBound,
    parts_j: Vec<f64>,
    lengths_m: Vec<f64>,
    by_road_type_j: Vec<f64>,
    optimum: Option<TimeSeries>,
}

/// Finds the least energy of some cycles.
///
/// ```
/// use ocmc_api::{Answer, BoundRequest, RunPlan, bound, go_on, study};
/// let study = study::load("field-truck", &["mission.length_m=3000"])?;
/// let request = BoundRequest { study: &study, plan: RunPlan::new(1, 0, 2, None, None) };
/// let answer = bound(&request, &mut go_on)?;
/// assert!(answer.bounds[0].bound_energy_j < answer.bounds[0].driver_energy_j);
/// assert_eq!(answer.potential[0].name, "all");
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Bound`] where no driver arrives; [`Error::Interrupted`].
pub fn bound(request: &BoundRequest, watch: &mut Watch) -> Result<BoundAnswer, Error> {
    let BoundRequest { study, plan } = request;
    let clock = Instant::now();
    let alone = plan.cycles == 1;
    let potential_of = |answer: TripBound| {
        answer.map(|(bound, potential)| cycle_potential(&bound, potential, alone))
    };
    let fineness = Fineness::default();
    let answers = watched(plan.cycles, watch, |look| {
        bounds(&study.study, plan, fineness, &potential_of, look)
    })?;
    let (bounded, failures): (Vec<_>, Vec<_>) = answers.into_iter().partition(Result::is_ok);
    let mut cycles: Vec<CyclePotential> = bounded.into_iter().flatten().collect();
    let failed = failures.len() as u64;
    if let (true, Some(Err(error))) = (cycles.is_empty(), failures.into_iter().next()) {
        return Err(error.into());
    }
    let optimum = cycles.first_mut().and_then(|cycle| cycle.optimum.take());
    let names = part_names();
    let road_m: f64 = cycles.iter().flat_map(|cycle| &cycle.lengths_m).sum();
    let part = |(k, name): (usize, String)| {
        let lengths = cycles.iter().filter_map(|cycle| cycle.lengths_m.get(k.checked_sub(2)?));
        let is_kind = k >= 2 && k < 2 + Kind::ALL.len();
        let road_share = is_kind.then(|| lengths.sum::<f64>() / road_m);
        share(
            name,
            cycles.iter().map(|cycle| (cycle.parts_j[k], cycle.bound.driver_energy_j)),
            road_share,
        )
    };
    let potential = names.into_iter().enumerate().map(part).collect();
    let of_type = |(k, name): (usize, &String)| {
        let pairs =
            cycles.iter().map(|cycle| (cycle.by_road_type_j[k], cycle.bound.driver_energy_j));
        share(name.clone(), pairs, None)
    };
    let by_road_type = study.study.road_types().iter().enumerate().map(of_type).collect();
    Ok(BoundAnswer {
        study: study.model.study.name.clone(),
        study_hash: study_hash(&study.model),
        seed: plan.seed,
        first_cycle: plan.first_cycle,
        cycles: plan.cycles,
        failed,
        not_better: cycles.iter().filter(|cycle| !cycle.bound.better).count() as u64,
        potential,
        by_road_type,
        bounds: cycles.into_iter().map(|cycle| cycle.bound).collect(),
        optimum,
        wall_s: clock.elapsed().as_secs_f64(),
        threads: plan.threads,
    })
}

/// The names of the parts: all, gears, the kinds of road, remainder.
fn part_names() -> Vec<String> {
    let kinds = Kind::ALL.iter().map(|kind| kind.name());
    let names = ["all", "gears"].into_iter().chain(kinds).chain(["remainder"]);
    names.map(str::to_owned).collect()
}

fn share(
    name: String,
    pairs: impl Iterator<Item = (f64, f64)> + Clone,
    road_share: Option<f64>,
) -> PotentialShare {
    let ratio = Ratio::estimate(pairs);
    PotentialShare {
        name,
        share: ratio.map(|ratio| ratio.ratio),
        ci95: ratio.and_then(|ratio| ratio.ci95),
        road_share,
    }
}

fn cycle_potential(bound: &Bound, potential: Option<Potential>, alone: bool) -> CyclePotential {
    let Bound { driver, optimum, record, .. } = bound;
    let all_j = driver.energy_j - optimum.energy_j;
    let (mut parts_j, mut lengths_m) = (vec![all_j], Vec::new());
    let mut by_road_type_j = vec![0.0; driver.by_road_type_j.len()];
    if let Some(potential) = potential {
        parts_j.push(potential.gears_j);
        parts_j.extend(potential.by_kind_j);
        parts_j.push(potential.remainder_j);
        lengths_m.extend(potential.length_m);
        by_road_type_j = potential.by_road_type_j;
    }
    let cycle = CycleBound {
        cycle_id: bound.cycle_id,
        simulated_energy_j: record.stored_energy_j(),
        driver_energy_j: driver.energy_j,
        bound_energy_j: optimum.energy_j,
        driver_duration_s: driver.duration_s,
        bound_duration_s: optimum.duration_s,
        driver_gear_shifts: driver.n_gear_shifts,
        bound_gear_shifts: optimum.n_gear_shifts,
        time_price_w: bound.price_w,
        better: bound.is_better,
    };
    let optimum = alone.then(|| series(&bound.cycle));
    CyclePotential { bound: cycle, parts_j, lengths_m, by_road_type_j, optimum }
}

/// A drive cycle as columns. The gear is 0 where the clutch is open, and nothing where the
/// powertrain chooses.
fn series(cycle: &DriveCycle) -> TimeSeries {
    let points: Vec<[f64; 3]> = cycle.points().collect();
    let column = |k: usize| -> Vec<f64> { points.iter().map(|point| point[k]).collect() };
    let mut position = Vec::with_capacity(points.len());
    let mut now_m = 0.0;
    for (k, point) in points.iter().enumerate() {
        if let Some(before) = k.checked_sub(1).map(|k| points[k]) {
            now_m += 0.5 * (before[1] + point[1]) * (point[0] - before[0]);
        }
        position.push(now_m);
    }
    let gear = cycle.gears().iter().map(|order| match order {
        GearOrder::Free => f64::NAN,
        GearOrder::Open => 0.0,
        GearOrder::Engaged(gear) => *gear as f64 + 1.0,
    });
    let columns = vec![
        TableColumn { name: "time_s", values: column(0) },
        TableColumn { name: "position_m", values: position },
        TableColumn { name: "speed_mps", values: column(1) },
        TableColumn { name: "grade", values: column(2) },
        TableColumn { name: "gear", values: gear.collect() },
    ];
    TimeSeries { columns }
}

/// Width of the columns of the table.
const WIDTHS: [usize; 3] = [16, 20, 10];

impl Answer for BoundAnswer {
    fn text(&self) -> String {
        let mut text = fact("study", &self.study);
        text.push_str(&fact("seed", self.seed));
        let (first, last) = (self.first_cycle, self.first_cycle + (self.cycles - 1));
        text.push_str(&fact("cycles", format!("{}, ids {first} to {last}", grouped(self.cycles))));
        if self.failed > 0 {
            let failed = format!("{} without a bound, left out", count_of(self.failed, "cycle"));
            text.push_str(&fact("failed", failed));
        }
        text.push_str(&took(self.wall_s, self.threads, self.cycles));
        if let [only] = self.bounds.as_slice() {
            text.push('\n');
            let mega = |energy_j: f64| rounded(1e-6 * energy_j);
            let line = |energy_j: f64, duration_s: f64, shifts: u32| {
                let hours = rounded(duration_s / 3600.0);
                format!("{} MJ, {hours} h, {}", mega(energy_j), count_of(shifts.into(), "shift"))
            };
            if let Some(simulated_j) = only.simulated_energy_j {
                text.push_str(&fact("simulated", format!("{} MJ", mega(simulated_j))));
            }
            let driver =
                line(only.driver_energy_j, only.driver_duration_s, only.driver_gear_shifts);
            text.push_str(&fact("driver", format!("{driver}, in the backward mode")));
            let least = line(only.bound_energy_j, only.bound_duration_s, only.bound_gear_shifts);
            text.push_str(&fact("least", least));
        }
        text.push('\n');
        let head = ["potential", "% of the energy", "% of road"];
        text.push_str(&shares(head, &self.potential, "  "));
        text.push('\n');
        text.push_str(&shares(["by road type", "% of the energy", ""], &self.by_road_type, ""));
        if self.not_better > 0 {
            let cycles = count_of(self.not_better, "cycle");
            text.push('\n');
            text.push_str(&fact("note", format!("nothing better than the driver in {cycles}")));
        }
        text
    }
}

/// A table of parts; those after the first one are indented.
fn shares(head: [&str; 3], parts: &[PotentialShare], indent: &str) -> String {
    let rows = parts.iter().enumerate().map(|(k, part)| {
        let percent = |share: f64| format!("{:.2}", 100.0 * share);
        let half = part.ci95.map(|[low, high]| percent(0.5 * (high - low)));
        let half = half.unwrap_or_else(|| "-".to_owned());
        let share =
            part.share.map_or("-".to_owned(), |share| format!("{} ± {half:>5}", percent(share)));
        let name = if k > 0 { format!("{indent}{}", part.name) } else { part.name.clone() };
        let road = part.road_share.map_or(String::new(), |share| format!("{:.1}", 100.0 * share));
        [name, share, road]
    });
    table(&WIDTHS, &head, rows)
}
