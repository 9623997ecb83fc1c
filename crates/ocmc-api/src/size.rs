//! How large a battery has to be for a share of the trips to arrive.

use crate::answer::Answer;
use crate::error::Error;
use crate::progress::Progress;
use crate::text::{fact, table, took};
use crate::watch::{Watch, watched};
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::range::SEASONS;
use ocmc_fleet::run::RunPlan;
use ocmc_fleet::size::{SizeFor, Sizing, TriedSize, drive_some, of_season};
use ocmc_io::number_text::{count_of, grouped};
use ocmc_io::study::LoadedStudy;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use std::time::Instant;

/// Trips that have to arrive.
#[derive(Clone, Debug)]
pub struct SizeRequest<'a> {
    /// The study, and what the answer calls it.
    pub study: (String, &'a LoadedStudy),
    /// Shares of the trips, each above 0 and below 1.
    pub arrive: Vec<f64>,
    /// Mass of the truck that a kWh of battery adds, in kg; 0: all batteries weigh the same.
    pub kg_per_kwh: f64,
    /// The season of the north in which trips depart that count; none: all of them.
    pub season: Option<Season>,
    /// The cycles.
    pub plan: RunPlan,
}

/// A season of the north.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Season {
    /// December, January and February.
    Winter,
    /// March to May.
    Spring,
    /// June to August.
    Summer,
    /// September to November.
    Autumn,
}

impl Season {
    /// All of them, in the order of the months.
    pub const ALL: [Self; 4] = [Self::Winter, Self::Spring, Self::Summer, Self::Autumn];

    /// Its name.
    pub fn name(self) -> &'static str {
        SEASONS[self as usize]
    }
}

/// How large the battery has to be.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct SizeAnswer {
    /// Name of the study.
    pub source: String,
    /// Trips on which sizes were tried.
    pub trips: u64,
    /// The season in which they depart; all of the year where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub season: Option<Season>,
    /// Trips that were given up for another reason than the battery: they do not count.
    pub given_up: u64,
    /// Mass of the truck that a kWh of battery adds, in kg.
    pub kg_per_kwh: f64,
    /// The battery of the study, in J.
    pub study_capacity_j: f64,
    /// The answers, in the order of the shares that were asked for.
    pub sizes: Vec<SizeFor>,
    /// The sizes that were tried, from the smallest, with the share that arrives.
    pub tried: Vec<TriedSize>,
    #[serde(skip)]
    driven: (RunPlan, f64, u64),
}

/// J of a kWh.
const J_PER_KWH: f64 = 3.6e6;

/// Finds the batteries with which shares of a study's trips arrive. Sizes are tried on the same
/// trips; nothing but the battery's energy differs, and the mass where that is asked for.
///
/// ```
/// use ocmc_api::{RunPlan, SizeRequest, go_on, size, study};
/// let study = study::load("battery-truck", &["mission.length_m=20000"])?;
/// let (study, plan) = (("trips".to_owned(), &study), RunPlan::new(1, 0, 40, None, None));
/// let request = SizeRequest { study, arrive: vec![0.5], kg_per_kwh: 0.0, season: None, plan };
/// let answer = size(&request, &mut go_on)?;
/// let capacity_j = answer.sizes[0].capacity_j.expect("a battery is enough");
/// assert!(capacity_j > 3e7 && capacity_j < 3e8, "{capacity_j}");
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::NoBattery`], [`Error::NoTripInSeason`] where no trip departs in the season,
/// [`Error::Share`], [`Error::Mass`], [`Error::Study`] where a battery's mass does not fit the
/// truck, and [`Error::Interrupted`].
pub fn size(request: &SizeRequest, watch: &mut Watch) -> Result<SizeAnswer, Error> {
    let SizeRequest { study: (name, study), arrive, kg_per_kwh, season, plan } = request;
    let Some(electric) = study.model.vehicle.powertrain.battery_electric() else {
        return Err(Error::NoBattery(name.clone()));
    };
    if let Some(share) = arrive.iter().find(|share| !(**share > 0.0 && **share < 1.0)) {
        return Err(Error::Share(*share));
    }
    if !(*kg_per_kwh >= 0.0 && *kg_per_kwh <= MOST_KG_PER_KWH) {
        return Err(Error::Mass(*kg_per_kwh));
    }
    let (own_j, own_kg) = (electric.battery.capacity_j, study.model.vehicle.curb_mass_kg);
    let clock = Instant::now();
    let places: Vec<u64> = match season {
        None => (0..plan.cycles).collect(),
        Some(season) => watched(plan.cycles, watch, |look| {
            of_season(&study.study, plan, *season as usize, look)
        })?,
    };
    if let (Some(season), true) = (season, places.is_empty()) {
        return Err(Error::NoTripInSeason { season: season.name(), cycles: plan.cycles });
    }
    let batch = Dependence::of(&study.model, plan.seed).batch.max(1);
    let clusters = places.iter().map(|place| place / batch).collect();
    let mut sizing = Sizing::new(clusters, own_j);
    let mut progress = Progress { what: "trips", done: 0, total: places.len() as u64 };
    let mut drive = |capacity_j: f64, trips: &[u64]| {
        let trips: Vec<u64> = trips.iter().map(|k| places[*k as usize]).collect();
        let mass_kg = own_kg + kg_per_kwh * (capacity_j - own_j) / J_PER_KWH;
        let sets = [
            format!("vehicle.powertrain.battery_electric.battery.capacity_j={capacity_j:e}"),
            format!("vehicle.curb_mass_kg={mass_kg:e}"),
        ];
        let sized = match study.set(&sets) {
            Ok(sized) => sized,
            Err(error) => return ControlFlow::Break(Error::from(error)),
        };
        let before = progress.done;
        progress.total = progress.total.max(before + trips.len() as u64);
        drive_some(&sized.study, plan, &trips, |done| {
            progress.done = before + done;
            watch(progress).map_break(|()| Error::Interrupted(progress))
        })
    };
    let mut sizes = Vec::with_capacity(arrive.len());
    for share in arrive {
        match sizing.size_for(*share, &mut drive) {
            ControlFlow::Continue(size) => sizes.push(size),
            ControlFlow::Break(error) => return Err(error),
        }
    }
    Ok(SizeAnswer {
        source: name.clone(),
        trips: places.len() as u64,
        season: *season,
        given_up: sizing.given_up(),
        kg_per_kwh: *kg_per_kwh,
        study_capacity_j: own_j,
        sizes,
        tried: sizing.tried().to_vec(),
        driven: (*plan, clock.elapsed().as_secs_f64(), sizing.drives),
    })
}

/// Most that a kWh of battery may add, in kg: lead-acid batteries add some 40.
const MOST_KG_PER_KWH: f64 = 100.0;
/// Widths of the tables.
const WIDTHS: [usize; 4] = [10, 10, 10, 18];
/// Rows of the table of what was tried, about.
const TRIED_ROWS: usize = 16;

fn kwh(capacity_j: Option<f64>) -> String {
    capacity_j.map_or("-".to_owned(), |j| format!("{:.0}", j / J_PER_KWH))
}

impl Answer for SizeAnswer {
    fn text(&self) -> String {
        let (plan, wall_s, drives) = self.driven;
        let mut text = fact("study", &self.source);
        text.push_str(&fact("seed", plan.seed));
        let trips = match self.season {
            None => count_of(self.trips, "trip"),
            Some(season) => format!("{} in {}", count_of(self.trips, "trip"), season.name()),
        };
        text.push_str(&fact("tried on", format!("{trips}, {} drives in all", grouped(drives))));
        text.push_str(&took(wall_s, plan.threads, drives));
        if self.given_up > 0 {
            let trips = count_of(self.given_up, "trip");
            text.push_str(&fact("given up", format!("{trips} that stalled or timed out")));
        }
        let own = format!("{} kWh", kwh(Some(self.study_capacity_j)));
        text.push_str(&fact("battery", format!("{own} in the study")));
        text.push_str("\nThe battery with which so many of the trips arrive, in kWh\n");
        let head = ["arrive", "battery", "", "95 % interval"];
        let rows = self.sizes.iter().map(|size| {
            let [low, high] = size.ci95_j.map(kwh);
            let share = format!("{:.1} %", 100.0 * size.share);
            vec![share, kwh(size.capacity_j), String::new(), format!("{low} to {high}")]
        });
        text.push_str(&table(&WIDTHS, &head, rows));
        text.push_str("\nTrips that arrive with the batteries that were tried\n");
        let step = self.tried.len().div_ceil(TRIED_ROWS).max(1);
        for TriedSize { capacity_j, share } in self.tried.iter().step_by(step) {
            let bar = "█".repeat((40.0 * share).round() as usize);
            let line = format!("{:>7} kWh {:>6.1} %  {bar}", kwh(Some(*capacity_j)), 100.0 * share);
            text.push_str(line.trim_end());
            text.push('\n');
        }
        if self.sizes.iter().any(|size| size.capacity_j.is_none()) {
            text.push_str(
                "\n-: no battery is enough: the trips need chargers on the way, or time.\n",
            );
        }
        text.push_str(if self.kg_per_kwh > 0.0 { WITH_MASS } else { SAME_MASS });
        text
    }
}

/// Scope of the figures, and the effects left out.
const SAME_MASS: &str = "
Batteries differ in energy alone: mass, power and resistance are the study's.
Intervals are of the chance of trips alone, not of how right the study is.
";
const WITH_MASS: &str = "
Batteries differ in energy and mass: power and resistance are the study's.
Intervals are of the chance of trips alone, not of how right the study is.
";
