//! Cost of a fleet's trips and of a truck over its life, and the cheaper of two fleets.

use crate::answer::Answer;
use crate::error::Error;
use crate::study_difference::beside_comparison;
use crate::text::{fact, table, took};
use crate::watch::{Watch, watched};
use ocmc_core::cost::costing::{Costing, Trip};
use ocmc_core::cost::emissions::TripEmissions;
use ocmc_core::record::Record;
use ocmc_fleet::comparison::AdjustedDifference;
use ocmc_fleet::cost::{CostSpread, FleetCost, FleetOfTrucks, InputShare, ItemCost, Percentiles};
use ocmc_fleet::cost_difference::{BreakEven, CostDifference, Fleet, Side};
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::run::{RunPlan, records};
use ocmc_io::number_text::{count_of, grouped, percent, rounded, share_text};
use ocmc_io::study::{KeyDifference, LoadedStudy, differences, study_hash};
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Instant;

/// Studies to be costed.
#[derive(Clone, Debug)]
pub struct CostRequest<'a> {
    /// The study, A, and how the answer calls it.
    pub study: (String, &'a LoadedStudy),
    /// The study that it is compared with, B.
    pub against: Option<(String, &'a LoadedStudy)>,
    /// The cycles that each of them drives.
    pub plan: RunPlan,
}

/// Costs of one study or of two.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct CostAnswer {
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// Number of cycles of each study.
    pub cycles: u64,
    /// The study or the studies.
    #[serde(flatten)]
    pub costed: Costed,
    /// How long it took, in s.
    pub wall_s: f64,
    /// Threads that it took.
    pub threads: usize,
}

/// One study, or two and their difference.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Costed {
    /// One.
    Study(Box<CostedStudy>),
    /// Two.
    Against {
        /// A.
        a: Box<CostedStudy>,
        /// B.
        b: Box<CostedStudy>,
        /// Difference in cost.
        difference: Box<CostDifference>,
        /// The keys in which they differ, what differs most first.
        differing_keys: Vec<KeyDifference>,
    },
}

/// Cost of a study.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct CostedStudy {
    /// Name of the study.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Cost of its fleet.
    #[serde(flatten)]
    pub cost: FleetCost,
    /// Commodities that the trucks use and that have no price.
    #[serde(skip)]
    pub(crate) unpriced: Vec<String>,
}

/// A study whose cycles were driven.
struct Driven {
    costing: Costing,
    trips: Vec<Trip>,
    costed: CostedStudy,
}

/// Drives the cycles of one or two studies, and costs them.
///
/// ```
/// use ocmc_api::{Costed, CostRequest, RunPlan, cost, go_on, study};
/// let prices = ["mission.length_m=5000", "cost.currency=EUR", "cost.driver_per_h=30"];
/// let loaded = study::load("field-truck", &prices)?;
/// let plan = RunPlan::new(1, 0, 20, None, None);
/// let request = CostRequest { study: ("mine".to_owned(), &loaded), against: None, plan };
/// let answer = cost(&request, &mut go_on)?;
/// let Costed::Study(mine) = &answer.costed else { panic!("one study") };
/// assert_eq!(mine.cost.items[0].item, "driver");
/// assert!(mine.cost.total.per_km > 0.0);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::NoPrices`], [`Error::Currencies`], [`Error::NothingToCost`]; [`Error::Interrupted`].
pub fn cost(request: &CostRequest, watch: &mut Watch) -> Result<CostAnswer, Error> {
    let CostRequest { study, against, plan } = request;
    let clock = Instant::now();
    let named = std::iter::once(study).chain(against);
    let costings =
        named.map(|(name, loaded)| costing(loaded).ok_or_else(|| Error::NoPrices(name.clone())));
    let mut costings = costings.collect::<Result<Vec<_>, _>>()?;
    if let [a, b] = costings.as_slice()
        && a.currency != b.currency
    {
        return Err(Error::Currencies(a.currency.clone(), b.currency.clone()));
    }
    let total = plan.cycles.saturating_mul(costings.len() as u64);
    let first = costings.remove(0);
    let second = against.as_ref().zip(costings.pop());
    let (a, b) = watched(total, watch, |look| {
        let a = records(&study.1.study, plan, &mut *look)?;
        let b = match &against {
            Some((_, loaded)) => {
                Some(records(&loaded.study, plan, |done| look(plan.cycles + done))?)
            }
            None => None,
        };
        std::ops::ControlFlow::Continue((a, b))
    })?;
    let a = costed(study, first, &a, plan)?;
    let costed = match second.zip(b) {
        None => Costed::Study(Box::new(a.costed)),
        Some(((named, costing), b)) => {
            let ids: Vec<u64> = b.iter().map(|record| record.cycle_id).collect();
            let b = costed(named, costing, &b, plan)?;
            let sides = [&a, &b].map(|side| Fleet { costing: &side.costing, trips: &side.trips });
            let difference = between(sides, [study.1, named.1], plan, &ids);
            let difference = difference.ok_or_else(|| Error::NothingToCost {
                study: format!("{} and {}", study.0, named.0),
                cycles: plan.cycles,
            })?;
            Costed::Against {
                a: Box::new(a.costed),
                b: Box::new(b.costed),
                difference: Box::new(difference),
                differing_keys: differences(&study.1.model, &named.1.model),
            }
        }
    };
    Ok(CostAnswer {
        seed: plan.seed,
        first_cycle: plan.first_cycle,
        cycles: plan.cycles,
        costed,
        wall_s: clock.elapsed().as_secs_f64(),
        threads: plan.threads,
    })
}

/// Difference in cost of two studies, from the records of the same cycles; none where one of them
/// has no prices, where their currencies differ, and where no trip was completed by both.
pub(crate) fn difference(
    sides: [(&LoadedStudy, &[Record]); 2],
    plan: &RunPlan,
) -> Option<CostDifference> {
    let (a, b) = (costing(sides[0].0)?, costing(sides[1].0)?);
    if a.currency != b.currency {
        return None;
    }
    let (of_a, of_b) = (trips(&a, sides[0].1), trips(&b, sides[1].1));
    let fleets = [Fleet { costing: &a, trips: &of_a }, Fleet { costing: &b, trips: &of_b }];
    let ids: Vec<u64> = sides[0].1.iter().map(|record| record.cycle_id).collect();
    between(fleets, sides.map(|(loaded, _)| loaded), plan, &ids)
}

/// The difference of two fleets that have both driven these cycles of the plan.
fn between(
    fleets: [Fleet; 2],
    studies: [&LoadedStudy; 2],
    plan: &RunPlan,
    ids: &[u64],
) -> Option<CostDifference> {
    let [a, b] = studies.map(|loaded| Dependence::of(&loaded.model, plan.seed));
    let difference = CostDifference::of(fleets[0], fleets[1], plan.seed, a.of_pairs(b))?;
    let studies = studies.map(|loaded| &loaded.study);
    Some(difference.with_adjusted(fleets, studies, plan.seed, ids))
}

/// Costing of a trip of a study, where it has prices.
pub(crate) fn costing(loaded: &LoadedStudy) -> Option<Costing> {
    let prices = loaded.model.cost.as_ref()?;
    Some(Costing::of(prices, &loaded.model.vehicle))
}

fn trips(costing: &Costing, records: &[Record]) -> Vec<Trip> {
    records.iter().filter_map(|record| costing.trip(record)).collect()
}

/// Costs the records of a study.
fn costed(
    (name, loaded): &(String, &LoadedStudy),
    costing: Costing,
    records: &[Record],
    plan: &RunPlan,
) -> Result<Driven, Error> {
    let trips = trips(&costing, records);
    let factors = loaded.study.emission_factors();
    let emitted: Vec<TripEmissions> =
        records.iter().filter_map(|record| factors.of_trip(record)).collect();
    let failed = (records.len() - trips.len()) as u64;
    let dependence = Dependence::of(&loaded.model, plan.seed);
    let cost = FleetCost::of(&costing, &trips, &emitted, failed, plan.seed, dependence);
    let cost =
        cost.ok_or_else(|| Error::NothingToCost { study: name.clone(), cycles: plan.cycles })?;
    let has = |item: &str| cost.items.iter().any(|known| known.item == item);
    let charged = records.iter().any(charged_on_the_way);
    let powertrain = &loaded.model.vehicle.powertrain;
    let filled = powertrain.carriers().iter().filter_map(|carrier| carrier.declaration().filled);
    let depot = powertrain.plugs_in().then_some(("depot_charging", "depot_charging_per_kwh"));
    let used = filled.map(|keys| ("fuel", keys.price)).chain(depot);
    let on_the_way = charged.then_some(("public_charging", "public_charging_per_kwh"));
    let unpriced = used.chain(on_the_way).filter(|(item, _)| !has(item));
    let unpriced = unpriced
        .map(|(_, key)| format!("{name} uses energy without a price: `cost.{key}` is not there"));
    let unpriced = unpriced.collect();
    let costed =
        CostedStudy { study: name.clone(), study_hash: study_hash(&loaded.model), cost, unpriced };
    Ok(Driven { costing, trips, costed })
}

/// Whether a truck was charged elsewhere than in its depot. Where a study has no `[charging]`, all
/// charging is at stops.
fn charged_on_the_way(record: &Record) -> bool {
    let depot_j = record.charged_energy_depot_j.unwrap_or(0.0);
    let on_the_way_j = match (record.charged_energy_public_j, record.charged_energy_stop_j) {
        (Some(public_j), Some(stop_j)) => public_j + stop_j,
        _ => record.charged_energy_j.unwrap_or(0.0) - depot_j,
    };
    on_the_way_j > 0.0
}

impl Costed {
    fn studies(&self) -> Vec<&CostedStudy> {
        match self {
            Self::Study(study) => vec![study],
            Self::Against { a, b, .. } => vec![a, b],
        }
    }
}

/// Items that a comparison has to count on both sides.
const COUNTED_ON_BOTH_SIDES: [&str; 6] =
    ["driver", "toll", "maintenance", "purchase", "residual", "insurance"];

impl Answer for CostAnswer {
    fn warnings(&self) -> Vec<String> {
        let studies = self.costed.studies();
        let mut warnings: Vec<String> =
            studies.iter().flat_map(|study| study.unpriced.clone()).collect();
        if let Costed::Against { a, b, .. } = &self.costed {
            for item in COUNTED_ON_BOTH_SIDES {
                let [in_a, in_b] =
                    [a, b].map(|side| side.cost.items.iter().any(|known| known.item == item));
                if in_a != in_b {
                    let with = if in_a { &a.study } else { &b.study };
                    warnings.push(format!("{item} has a price in {with} alone"));
                }
            }
        }
        warnings
    }

    fn text(&self) -> String {
        let studies = self.costed.studies();
        let mut text = String::new();
        for (study, name) in studies.iter().zip(["A", "B"]) {
            let name = if studies.len() == 1 { "study" } else { name };
            text.push_str(&fact(name, &study.study));
        }
        text.push_str(&fact("seed", self.seed));
        let (first, last) = (self.first_cycle, self.first_cycle + (self.cycles - 1));
        text.push_str(&fact("cycles", format!("{}, ids {first} to {last}", grouped(self.cycles))));
        text.push_str(&took(self.wall_s, self.threads, self.cycles * studies.len() as u64));
        for (study, name) in studies.iter().zip(["A", "B"]) {
            text.push('\n');
            if studies.len() > 1 {
                text.push_str(&fact(name, &study.study));
            }
            text.push_str(&study_text(&study.cost));
        }
        if let Costed::Against { difference, differing_keys, .. } = &self.costed {
            text.push('\n');
            text.push_str(&difference_text(difference));
            text.push_str(&beside_comparison(differing_keys));
        }
        text
    }
}

/// Widths of the table of items.
const ITEM_WIDTHS: [usize; 6] = [17, 11, 11, 11, 14, 15];

fn study_text(cost: &FleetCost) -> String {
    let failed = if cost.failed > 0 {
        format!(", {} not completed, left out", grouped(cost.failed))
    } else {
        String::new()
    };
    let mut text = fact(
        "trips",
        format!(
            "{} of {} km with {} t{failed}",
            grouped(cost.trips),
            rounded(cost.km_per_trip),
            rounded(cost.mean_payload_t)
        ),
    );
    let first = if cost.fleet.is_some() { "fleet" } else { "trip" };
    let head = [cost.currency.as_str(), first, "km", "tkm", "truck-year", "whole life"];
    let money = |value: Option<f64>| value.map_or("-".to_owned(), rounded);
    let row = |item: &ItemCost| {
        let name = item.item.replace('_', " ");
        let first = if cost.fleet.is_some() { item.all_trips } else { item.per_trip };
        let values = [Some(first), Some(item.per_km), item.per_tkm, item.per_a];
        let values = values.into_iter().chain([item.whole_life]).map(money);
        std::iter::once(name).chain(values).collect::<Vec<String>>()
    };
    let centres = if cost.spread.is_some() { "\nAt the centres of the prices:\n\n" } else { "\n" };
    text.push_str(centres);
    let rows = cost.items.iter().chain([&cost.total]).map(row);
    text.push_str(&table(&ITEM_WIDTHS, &head, rows));
    if let Some(FleetOfTrucks { trucks, trips_per_truck, cost: total }) = cost.fleet {
        let [trucks, trips] =
            [(trucks, "truck"), (trips_per_truck, "trip")].map(|(n, word)| count_of(n, word));
        let other = total.prediction95.map_or_else(String::new, |[low, high]| {
            format!("; another such fleet {} to {}", rounded(low), rounded(high))
        });
        text.push_str(&below(&format!("fleet: {trucks}, {trips} each{other}")));
    }
    if let Some([low, high]) = cost.total.per_km_ci95 {
        let interval = format!("{} to {} per km", rounded(low), rounded(high));
        text.push_str(&below(&format!("{interval}, 95 % interval over the trips")));
    }
    let [low, middle, high] =
        [cost.over_trips.p5, cost.over_trips.p50, cost.over_trips.p95].map(rounded);
    let trips = format!("P5 {low}, P50 {middle}, P95 {high} per trip, over the trips");
    text.push_str(&below(&trips));
    if let Some(spread) = &cost.spread {
        text.push_str(&spread_text(spread));
    }
    text.push_str(&inputs_text(&cost.inputs, "cost per km"));
    let emissions = &cost.emissions;
    let half = |ci95: Option<[f64; 2]>| {
        ci95.map_or("-".to_owned(), |[low, high]| format!("{:.4}", 0.5 * (high - low)))
    };
    let tank = format!(
        "{:.4} ± {} from tank to wheel",
        emissions.tank_to_wheel_kg_per_km,
        half(emissions.tank_to_wheel_ci95)
    );
    text.push('\n');
    text.push_str(&fact("kg CO2/km", tank));
    if let Some(well) = emissions.well_to_wheel_kg_per_km {
        let interval = half(emissions.well_to_wheel_ci95);
        text.push_str(&fact("", format!("{well:.4} ± {interval} from well to wheel")));
    }
    text
}

/// A line below the table of items.
fn below(text: &str) -> String {
    format!("{:width$}{text}\n", "", width = ITEM_WIDTHS[0])
}

/// How states of the world differ.
fn spread_text(spread: &CostSpread) -> String {
    let head = format!("\nOver {} states of the prices:\n\n", grouped(spread.states));
    let line = |name: &str, percentiles: Option<Percentiles>| {
        let Percentiles { mean, p5, p50, p95, .. } = percentiles?;
        let [mean, p5, p50, p95] = [mean, p5, p50, p95].map(rounded);
        Some([name.to_owned(), mean, p5, p50, p95])
    };
    let rows = [
        line("trip", Some(spread.per_trip)),
        line("km", Some(spread.per_km)),
        line("tkm", spread.per_tkm),
        line("truck-year", spread.per_a),
        line("whole life", spread.whole_life),
    ];
    let widths = [17, 13, 13, 13, 13];
    let rows = rows.into_iter().flatten();
    format!("{head}{}", table(&widths, &["", "mean", "P5", "P50", "P95"], rows))
}

/// Table of the inputs that decide.
fn inputs_text(inputs: &[InputShare], quantity: &str) -> String {
    if inputs.is_empty() {
        return String::new();
    }
    let head =
        format!("\nShares of the variance of the {quantity} in %, over states of the prices:\n\n");
    let row = |input: &InputShare| {
        let first = share_text(input.first, input.first_ci95);
        [input.key.clone(), first, share_text(input.total, input.total_ci95)]
    };
    let rows = inputs.iter().map(row);
    format!("{head}{}", table(&[34, 22, 22], &["", "first-order", "total effect"], rows))
}

fn difference_text(difference: &CostDifference) -> String {
    let mut text = fact("pairs", grouped(difference.pairs));
    if difference.left_out > 0 {
        let trips = format!("{} trips that one of them did not complete", difference.left_out);
        text.push_str(&fact("left out", trips));
    }
    text.push_str(&sides_text(difference));
    let share = percent(difference.share_of_trips_a_cheaper);
    text.push_str(&fact("", format!("A cheaper in {share} % of the trips, at the central prices")));
    text.push_str("\nBreak-even, where both cost the same over a km:\n\n");
    let distance = difference.break_even_distance_km_per_a.as_ref();
    let distance = distance.map(|break_even| even_row("distance, km per year", break_even));
    let prices = difference.break_even_prices.iter();
    let prices = prices.map(|even| even_row(even.key.trim_start_matches("cost."), &even.price));
    let head = ["", "value", "95 % interval", "P5 to P95", "states"];
    text.push_str(&table(&[24, 9, 20, 20, 7], &head, distance.into_iter().chain(prices)));
    text.push_str(&inputs_text(&difference.inputs, "difference"));
    text
}

/// Both sides over km and tkm, and how likely A is cheaper.
pub(crate) fn sides_text(difference: &CostDifference) -> String {
    let currency = &difference.currency;
    let per_tkm = difference.per_tkm.as_ref();
    let per_tkm = per_tkm.map(|per_tkm| side_text(&format!("{currency}/tkm"), per_tkm));
    side_text(&format!("{currency}/km"), &difference.per_km) + &per_tkm.unwrap_or_default()
}

fn side_text(unit: &str, side: &Side) -> String {
    let interval = side
        .difference_ci95
        .map_or(String::new(), |[low, high]| format!(" ({} to {})", rounded(low), rounded(high)));
    let line = format!(
        "A {}, B {}, B - A {}{interval}",
        rounded(side.a),
        rounded(side.b),
        rounded(side.difference)
    );
    let adjusted =
        side.adjusted.map_or(String::new(), |AdjustedDifference { difference, ci95 }| {
            let [low, high] = ci95.map(rounded);
            fact(
                "",
                format!(
                    "B - A adjusted for what was drawn {} ({low} to {high})",
                    rounded(difference)
                ),
            )
        });
    let probability = percent(side.probability_a_cheaper);
    let within = side
        .probability_ci95
        .map_or(String::new(), |[low, high]| format!(" ({} to {})", percent(low), percent(high)));
    let cheaper = format!("P(A cheaper) {probability} %{within}");
    fact(unit, line) + &adjusted + &fact("", cheaper)
}

fn even_row(name: &str, break_even: &BreakEven) -> [String; 5] {
    let range = |low: f64, high: f64| format!("{} to {}", rounded(low), rounded(high));
    let none = || "-".to_owned();
    [
        name.to_owned(),
        break_even.value.map_or_else(|| "none".to_owned(), rounded),
        break_even.ci95.map_or_else(none, |[low, high]| range(low, high)),
        break_even.states.map_or_else(none, |states| range(states.p5, states.p95)),
        break_even.share_of_states.map_or_else(none, |share| format!("{:.0} %", 100.0 * share)),
    ]
}
