//! Summary of a fleet's cycles: consumption, speed, duration and stops, over the cycles that were
//! completed and, of what they drove, those that a battery cut short.

use super::adjustment::{Adjusted, Adjuster, Adjustment};
use super::charging::ChargingSummary;
use super::clustering::Clusters;
use super::cost::TripPrices;
use super::dependence::Dependence;
use super::load::{LoadBuilder, LoadCurves};
pub use super::outcomes::Outcomes;
use super::parts::{FleetPart, PartSums, add_known};
use super::quantile::{interval_of_clusters, quantile};
use super::quantity::{
    CONSUMPTIONS, Extent, QUANTITIES, RecordQuantity, WHOLE_TRIP, Weight, quantity,
};
use super::ratio::Ratio;
use super::route_summary::RouteSummary;
use super::run::RunPlan;
use super::statistic::{Statistic, by_name, consumption_of};
use super::truck_arrivals::{TruckArrivalBuilder, TruckArrivals};
use super::truck_year::{TripTotals, TruckSummary, TruckYearBuilder};
use super::uncertainty::{Effects, ParameterUncertainty};
use ocmc_core::record::{Outcome, Record};
use ocmc_core::study::Study;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::sync::Arc;

/// The fleet's answers.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Summary {
    /// Cycles driven.
    pub cycles: u64,
    /// How they ended.
    pub outcomes: Outcomes,
    /// Distance driven in all cycles, in m.
    pub distance_m: f64,
    /// Time integrated in all cycles, in s.
    pub simulated_s: f64,
    /// The quantities, over the cycles that count ([`RecordQuantity::of_cycle`]).
    #[serde(serialize_with = "by_name")]
    #[schemars(with = "BTreeMap<String, Statistic>")]
    pub statistics: Vec<Statistic>,
    /// Part of the mean's uncertainty that comes from uncertain numbers of the study. It takes
    /// drives of its own: see [`Summary::add_uncertainty`].
    pub parameter_uncertainty: Option<ParameterUncertainty>,
    /// Change that the cycles that stalled or timed out could make; none where they are at most 0.1
    /// %.
    pub worst_case: Option<WorstCase>,
    /// Where powertrains came to their limits and left their maps.
    pub saturation: Saturation,
    /// Summary of the trucks; none where each trip has a truck of its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trucks: Option<TruckSummary>,
    /// Totals of road types and event kinds; none where cycles are not broken down.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<FleetPart>,
    /// Summaries of the routes; empty where there are not several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub routes: Vec<RouteSummary>,
    /// Cycles whose payload was cut at the legal gross mass.
    #[serde(skip_serializing_if = "is_zero")]
    pub payloads_cut: u64,
    /// Charging of the trips; none where the study has no policy for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub charging: Option<ChargingSummary>,
    /// Power that chargers draw from the grid by quarter of an hour; none where nothing was charged
    /// by a policy.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loads: Option<LoadCurves>,
    /// Trucks whose trips arrive, of battery trucks that make several; empty where there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub truck_arrivals: Vec<TruckArrivals>,
}

/// Where powertrains left their maps, or could not hold a speed that was followed, over all cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Saturation {
    /// Cycles with either.
    pub cycles: u64,
    /// Time at the limit, in s; none where a driver model drives.
    pub limited_s: Option<f64>,
    /// Work at the wheels that was missing then, in J; none where a driver model drives.
    pub missing_energy_j: Option<f64>,
    /// Energy that the stores gave beyond the points of the map, in J.
    pub outside_map_energy_j: f64,
    /// Energy that the stores gave in all, in J.
    pub stored_energy_j: f64,
}

/// Share of the energy from which what was taken beyond the maps is worth a line (judgement: lines
/// beyond the points of public maps are 1 to 3 % off there, so less than 0.2 % of the whole).
pub const OUTSIDE_MAP_SHARE: f64 = 0.05;

impl Saturation {
    /// Share of the energy that was given beyond the points of the map.
    pub fn outside_map_share(&self) -> f64 {
        let share = self.outside_map_energy_j / self.stored_energy_j;
        if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }
    }

    fn add(&mut self, record: &Record) {
        let outside_j = record.outside_map_energy_j.unwrap_or(0.0);
        self.cycles += u64::from(record.limited_s.unwrap_or(0.0) + outside_j > 0.0);
        add_known(&mut self.limited_s, record.limited_s);
        add_known(&mut self.missing_energy_j, record.missing_energy_j);
        self.outside_map_energy_j += outside_j;
        self.stored_energy_j += record.stored_energy_j().unwrap_or(0.0);
    }
}

/// The mean of the fleet if each cycle that stalled or timed out had been as long as the mean
/// counted one and had consumed, per distance, as much as the worst counted one; as much as its
/// own record shows, where that is more. A record holds what was driven until the cycle failed: one
/// that failed within its first metres shows a large value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct WorstCase {
    /// Name of the quantity: the fleet's consumption.
    pub column: &'static str,
    /// Cycles that stalled or timed out.
    pub cycles: u64,
    /// The mean with them.
    pub mean: f64,
}

/// Share of such cycles above which the worst case is worth a line.
pub const WORST_CASE_SHARE: f64 = 1e-3;

/// Counted cycles below which intervals of skewed quantities cover too little: about 85 % instead
/// of 95 %, as the normal law of a mean is far then.
const FEW_CYCLES: u64 = 50;

impl Summary {
    /// Whether there are cycles, and so few that intervals are to be read with care.
    pub fn has_few_cycles(&self) -> bool {
        (1..FEW_CYCLES).contains(&self.outcomes.counted())
    }

    /// The statistic of that name.
    pub fn statistic(&self, column: &str) -> Option<&Statistic> {
        self.statistics.iter().find(|statistic| statistic.column == column)
    }

    /// The statistics that say something of their own: that of the whole trips is that of the
    /// driven ones where no battery ran empty.
    pub fn told(&self) -> impl Iterator<Item = &Statistic> {
        let cut_short = self.outcomes.of(Outcome::Depleted) > 0;
        let own = move |statistic: &&Statistic| cut_short || statistic.column != WHOLE_TRIP;
        self.statistics.iter().filter(own)
    }

    /// The consumption that the fleet is judged by: fuel, else electricity, else the work at the
    /// wheels.
    pub fn consumption(&self) -> Option<&Statistic> {
        consumption_of(&self.statistics)
    }

    /// Drives the study on both sides of its uncertain numbers, and keeps what the mean consumption
    /// owes to them. The plan is that of the summary's own cycles.
    pub fn add_uncertainty<B>(
        &mut self,
        study: &Study,
        plan: &RunPlan,
        drive: impl FnMut(&Study, &RunPlan) -> ControlFlow<B, Vec<Record>>,
    ) -> ControlFlow<B> {
        let own = self.consumption();
        let Some(own) = own.and_then(|own| quantity(own.column)) else {
            return ControlFlow::Continue(());
        };
        let effects = Effects::drive(study, plan, own, drive)?;
        self.know_effects(study, effects.as_ref());
        ControlFlow::Continue(())
    }

    /// Keeps what the mean consumption owes to the effects of uncertain numbers on it.
    pub fn know_effects(&mut self, study: &Study, effects: Option<&Effects>) {
        let known = self.consumption().and_then(|own| Some((own.mean?, own.ci95?)));
        let replicates = study.model().driver.curve_speed.uncertain_replicates();
        self.parameter_uncertainty = known
            .zip(effects)
            .map(|((mean, ci95), effects)| effects.around(mean, ci95, replicates));
    }
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "the form that serde calls")]
fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// Collects records in the order of their cycle ids, and keeps of each only what the summary needs:
/// 8 bytes a value.
#[derive(Clone, Debug, Default)]
pub struct SummaryBuilder {
    cycles: u64,
    outcomes: Outcomes,
    distance_m: f64,
    simulated_s: f64,
    saturation: Saturation,
    parts: PartSums,
    payloads_cut: u64,
    /// Cycles that count.
    rows: usize,
    /// Per cycle that does not count, the consumptions that its record shows.
    failed: Vec<[Option<f64>; CONSUMPTIONS.len()]>,
    /// Per counted cycle.
    extents: Vec<Extent>,
    /// Dependence between cycles.
    dependence: Dependence,
    /// Months and years of trucks, where they make several trips.
    trucks: TruckYearBuilder,
    /// Prices of the trips; none where the study has none, or is not known.
    prices: Option<TripPrices>,
    charging: ChargingSummary,
    loads: LoadBuilder,
    truck_arrivals: TruckArrivalBuilder,
    /// Ids of the counted cycles, where cycles depend on one another.
    cycle_ids: Vec<u64>,
    /// Routes of the counted cycles, where they have some.
    route_ids: Vec<u32>,
    /// Expectations of what the cycles have; none where they are not known.
    adjuster: Option<Adjuster>,
    /// Places of the counted cycles among all, where there is an adjuster.
    places: Vec<usize>,
    /// Per quantity and counted cycle, NaN where there is none; empty while no cycle has the
    /// quantity.
    values: [Vec<f64>; QUANTITIES.len()],
}

impl SummaryBuilder {
    /// For cycles that depend on one another like this.
    pub fn new(dependence: Dependence) -> Self {
        Self { dependence, ..Self::default() }
    }

    /// For the cycles of a study under a seed, adjusted by what they are expected to have.
    pub fn of(study: &Arc<Study>, seed: u64) -> Self {
        let adjuster = Adjuster::new(Arc::clone(study), seed);
        let fleet = Self::new(Dependence::of(study.model(), seed));
        Self { adjuster, ..fleet.priced(TripPrices::of(study.model())) }
    }

    /// The same cycles with prices.
    #[must_use]
    pub fn priced(self, prices: Option<TripPrices>) -> Self {
        Self { prices, ..self }
    }

    /// The same cycles with plain means alone, which are there at once.
    #[must_use]
    pub fn plain(self) -> Self {
        Self { adjuster: None, ..self }
    }

    /// Adds the next records.
    pub fn add(&mut self, records: &[Record]) {
        for record in records {
            self.cycles += 1;
            self.outcomes.add(record.outcome);
            self.distance_m += record.distance_m;
            self.simulated_s += record.simulated_s;
            self.saturation.add(record);
            self.payloads_cut += u64::from(record.payload_cut_kg > 0.0);
            self.charging.add(record);
            self.loads.add(record, &self.dependence);
            if self.dependence.has_trucks() {
                let cost = self.prices.as_ref().and_then(|prices| prices.cost(record));
                self.trucks.add(record, cost, self.dependence);
                self.truck_arrivals.add(record, &self.dependence);
            }
            if let Some(adjuster) = &mut self.adjuster {
                adjuster.add(record.cycle_id);
                if record.outcome.counts() {
                    self.places.push(self.cycles as usize - 1);
                }
            }
            if record.outcome.counts() {
                self.parts.add(record);
                self.add_counted(record);
            } else {
                self.failed.push(CONSUMPTIONS.map(|column| shown(column, record)));
            }
        }
    }

    fn add_counted(&mut self, record: &Record) {
        self.extents.push(Extent::of(record));
        if self.dependence != Dependence::default() {
            self.cycle_ids.push(record.cycle_id);
        }
        self.route_ids.extend(record.route_id);
        for (quantity, values) in QUANTITIES.iter().zip(&mut self.values) {
            if let Some(value) = quantity.of_cycle(record) {
                values.resize(self.rows, f64::NAN);
                values.push(value);
            }
        }
        self.rows += 1;
    }

    /// Number of cycles added.
    pub fn cycles(&self) -> u64 {
        self.cycles
    }

    /// Half of the 95 % interval of the fleet's consumption, or of its quantile of that level,
    /// relative to it: of the adjusted one where there is one.
    pub fn relative_half_width(&mut self, level: Option<f64>) -> Option<f64> {
        let column = CONSUMPTIONS.into_iter().find(|column| !self.values_of(column).is_empty())?;
        let own = quantity(column)?;
        if let Some(adjustment) = self.adjustment()
            && let Some(Adjusted { value, ci95: [low, high] }) = match level {
                None => adjustment.ratio(&self.totals_of_all(own)),
                Some(level) => adjustment
                    .own_values(self.values_of_all(own))
                    .and_then(|values| adjustment.quantile(&values, level)),
            }
        {
            return (value != 0.0).then(|| libm::fabs((high - low) / 2.0 / value));
        }
        let clusters = self.clusters();
        let (value, ci95) = match level {
            None => {
                let mean = self.mean(own, &clusters)?;
                (mean.ratio, mean.ci95)
            }
            Some(level) => {
                let cycles = self.cycles_with(self.values_of(column));
                let mut values: Vec<f64> = cycles.clone().map(|(_, value)| value).collect();
                values.sort_unstable_by(f64::total_cmp);
                let ci95 = interval_of_clusters(&values, level, &clusters, cycles);
                (quantile(&values, level)?, ci95)
            }
        };
        let [low, high] = ci95?;
        (value != 0.0).then(|| libm::fabs((high - low) / 2.0 / value))
    }

    /// Sums up.
    pub fn finish(mut self) -> Summary {
        for values in &mut self.values {
            if !values.is_empty() {
                values.resize(self.rows, f64::NAN);
            }
        }
        let clusters = self.clusters();
        let means = std::array::from_fn(|k| self.mean(&QUANTITIES[k], &clusters));
        let worst_case = self.worst_case(&means);
        let adjustment = self.adjustment();
        let statistics = self.statistics(&means, &clusters, adjustment.as_ref());
        let trucks = std::mem::take(&mut self.trucks);
        let totals = |k: usize| self.totals(&QUANTITIES[k]).collect();
        let totals = TripTotals { clusters: &clusters, cycle_ids: &self.cycle_ids, parts: &totals };
        let currency = self.prices.as_ref().map(TripPrices::currency);
        let trucks = trucks.finish(self.dependence, &totals, currency);
        Summary {
            cycles: self.cycles,
            outcomes: self.outcomes,
            distance_m: self.distance_m,
            simulated_s: self.simulated_s,
            statistics,
            parameter_uncertainty: None,
            worst_case,
            saturation: self.saturation,
            routes: self.routes(),
            parts: std::mem::take(&mut self.parts).finish(),
            payloads_cut: self.payloads_cut,
            trucks,
            charging: (self.charging.trips > 0).then_some(self.charging),
            loads: std::mem::take(&mut self.loads).finish(&self.dependence),
            truck_arrivals: std::mem::take(&mut self.truck_arrivals).finish(),
        }
    }

    fn statistics(
        &self,
        means: &[Option<Ratio>; QUANTITIES.len()],
        clusters: &Clusters,
        adjustment: Option<&Adjustment>,
    ) -> Vec<Statistic> {
        let all = QUANTITIES.iter().zip(means).zip(&self.values);
        let one = |((quantity, mean), values): ((&'static RecordQuantity, &_), &Vec<f64>)| {
            let cycles = self.cycles_with(values);
            let adjusted = adjustment.filter(|_| !values.is_empty());
            let adjusted = adjusted.and_then(|adjustment| {
                let totals = self.totals_of_all(quantity);
                adjustment.statistic(&totals, self.values_of_all(quantity))
            });
            Statistic { adjusted, ..Statistic::new(quantity.column, *mean, &cycles, clusters) }
        };
        all.map(one).collect()
    }

    /// Summaries of the routes, where there are several.
    fn routes(&self) -> Vec<RouteSummary> {
        let ids: BTreeSet<u32> = self.route_ids.iter().copied().collect();
        let several = ids.len() > 1 && self.route_ids.len() == self.rows;
        let summary = |route_id: u32| {
            let own = self.of_route(route_id);
            let clusters = own.clusters();
            let means = std::array::from_fn(|k| own.mean(&QUANTITIES[k], &clusters));
            RouteSummary {
                route_id,
                file: None,
                cycles: own.rows as u64,
                distance_m: own.extents.iter().map(|extent| extent.distance_m).sum(),
                statistics: own.statistics(&means, &clusters, None),
            }
        };
        ids.into_iter().filter(|_| several).map(summary).collect()
    }

    /// The counted cycles of a route.
    fn of_route(&self, route_id: u32) -> Self {
        let rows = || (0..self.rows).filter(|row| self.route_ids[*row] == route_id);
        let values = self
            .values
            .each_ref()
            .map(|values| rows().filter(|_| !values.is_empty()).map(|row| values[row]).collect());
        Self {
            rows: rows().count(),
            extents: rows().map(|row| self.extents[row]).collect(),
            cycle_ids: rows().filter_map(|row| self.cycle_ids.get(row).copied()).collect(),
            values,
            ..Self::new(self.dependence)
        }
    }

    /// The adjustment of the cycles so far.
    fn adjustment(&mut self) -> Option<Adjustment> {
        let column = CONSUMPTIONS.into_iter().find(|column| !self.values_of(column).is_empty())?;
        let mut adjuster = self.adjuster.take()?;
        let adjustment = adjuster.adjustment(&self.totals_of_all(quantity(column)?));
        self.adjuster = Some(adjuster);
        adjustment
    }

    /// Additions of each cycle to the two totals of a quantity's mean: nothing where it does not
    /// count.
    fn totals_of_all(&self, quantity: &RecordQuantity) -> Vec<(f64, f64)> {
        let (times, over) = (quantity.times, quantity.over);
        let mut totals = vec![(0.0, 0.0); self.cycles as usize];
        for (row, value) in self.values_of(quantity.of).iter().enumerate() {
            if !value.is_nan() {
                let y = value * self.weight(times, row);
                totals[self.places[row]] = (y, self.weight(over, row));
            }
        }
        totals
    }

    /// The value of each cycle, NaN where it has none.
    fn values_of_all(&self, quantity: &RecordQuantity) -> Vec<f64> {
        let mut values = vec![f64::NAN; self.cycles as usize];
        for (row, value) in self.values_of(quantity.column).iter().enumerate() {
            values[self.places[row]] = *value;
        }
        values
    }

    /// Values of the quantity of that name.
    fn values_of(&self, column: &str) -> &[f64] {
        let place = QUANTITIES.iter().position(|quantity| quantity.column == column);
        place.map_or(&[], |k| &self.values[k])
    }

    fn weight(&self, weight: Weight, row: usize) -> f64 {
        weight.of(self.extents[row])
    }

    /// Id of the cycle in a row; the row itself where all cycles are independent.
    fn id(&self, row: usize) -> u64 {
        self.cycle_ids.get(row).copied().unwrap_or(row as u64)
    }

    /// The cycles that have a value, with their ids.
    fn cycles_with(&self, values: &[f64]) -> impl Iterator<Item = (u64, f64)> + Clone {
        let values = values.iter().enumerate().filter(|(_, value)| !value.is_nan());
        values.map(|(row, value)| (self.id(row), *value))
    }

    /// In which clusters the counted cycles are.
    fn clusters(&self) -> Clusters {
        Clusters::of(self.dependence, self.cycle_ids.iter().copied())
    }

    fn mean(&self, quantity: &RecordQuantity, clusters: &Clusters) -> Option<Ratio> {
        let mean = clusters.ratio(self.totals(quantity))?;
        let ci95 = mean.ci95.map(|[low, high]| [low.max(quantity.least()), high]);
        Some(Ratio { ci95, ..mean })
    }

    /// Contributions of each counted cycle that has the quantity to the two totals of its mean,
    /// after the cycle's id.
    fn totals(&self, quantity: &RecordQuantity) -> impl Iterator<Item = (u64, f64, f64)> + Clone {
        let (times, over) = (quantity.times, quantity.over);
        let values = self.values_of(quantity.of).iter().enumerate();
        let values = values.filter(|(_, value)| !value.is_nan());
        values.map(move |(row, value)| {
            (self.id(row), value * self.weight(times, row), self.weight(over, row))
        })
    }

    fn worst_case(&self, means: &[Option<Ratio>; QUANTITIES.len()]) -> Option<WorstCase> {
        let failed = self.outcomes.uncounted();
        if failed as f64 <= WORST_CASE_SHARE * self.cycles as f64 {
            return None;
        }
        let choice = CONSUMPTIONS.iter().position(|column| !self.values_of(column).is_empty())?;
        let column = CONSUMPTIONS[choice];
        let place = QUANTITIES.iter().position(|quantity| quantity.column == column)?;
        let worst = self.values[place].iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let own = |shown: &[Option<f64>; CONSUMPTIONS.len()]| shown[choice].unwrap_or(worst);
        let others: f64 = self.failed.iter().map(|shown| own(shown).max(worst)).sum();
        let (counted, cycles) = (self.rows as f64, self.cycles as f64);
        let mean = (counted * means[place]?.ratio + others) / cycles;
        Some(WorstCase { column, cycles: failed, mean })
    }
}

/// The finite value that a record shows, however its cycle ended.
fn shown(column: &str, record: &Record) -> Option<f64> {
    quantity(column)?.value.get(record).filter(|value| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::super::quantity::LITRES;
    use super::*;
    use ocmc_core::energy::Carrier;

    fn record(cycle_id: u64, distance_km: f64, litres_per_100km: f64) -> Record {
        let distance_m = 1000.0 * distance_km;
        let duration_s = distance_m / 20.0;
        Record {
            cycle_id,
            distance_m,
            duration_s,
            simulated_s: duration_s,
            mean_speed_mps: 20.0,
            n_stops: 2,
            payload_kg: 10_000.0,
            mean_payload_kg: 10_000.0,
            wheel_kwh_per_km: 1.0,
            ..Record::default().with(
                Carrier::LiquidFuel,
                [None, Some(litres_per_100km), Some(litres_per_100km / 10.0)],
            )
        }
    }

    fn summary(records: &[Record]) -> Summary {
        let mut builder = SummaryBuilder::default();
        builder.add(records);
        builder.finish()
    }

    #[test]
    fn mean_is_the_fleets_and_quantiles_are_the_cycles() {
        let summary = summary(&[record(0, 10.0, 20.0), record(1, 30.0, 40.0)]);
        let litres = summary.statistic(LITRES).expect("reported");
        // (2 + 12) l over 40 km
        assert_eq!(litres.mean, Some(35.0));
        assert_eq!(litres.quantiles[2].value, Some(30.0));
        assert!((litres.sd.expect("two cycles") - 14.142135623730951).abs() < 1e-12);
        assert_eq!(summary.statistic("mean_speed_mps").expect("reported").mean, Some(20.0));
        assert_eq!(summary.statistic("stops_per_km").expect("reported").mean, Some(0.1));
        assert_eq!(summary.statistic("duration_s").expect("reported").mean, Some(1000.0));
        assert_eq!(summary.statistic("consumption_kwh_per_km").expect("reported").mean, None);
        assert_eq!(summary.consumption().expect("fuel").column, LITRES);
        assert_eq!((summary.cycles, summary.distance_m), (2, 40_000.0));
    }

    #[test]
    fn empty_trips_burn_fuel_but_carry_nothing() {
        let mut empty = record(1, 10.0, 20.0);
        (empty.payload_kg, empty.mean_payload_kg) = (0.0, 0.0);
        empty.of_carrier_mut(Carrier::LiquidFuel)[2] = None;
        let summary = summary(&[record(0, 10.0, 30.0), empty]);
        let statistic = summary.statistic("consumption_l_per_100tkm").expect("reported");
        // (3 + 2) l over 100 tkm
        assert_eq!(statistic.mean, Some(5.0));
        assert_eq!(statistic.n, 1);
    }

    #[test]
    fn no_cycles_and_one_cycle() {
        let none = summary(&[]);
        assert_eq!(none.cycles, 0);
        assert!(none.statistics.iter().all(|s| s.mean.is_none() && s.sd.is_none() && s.n == 0));
        let one = summary(&[record(5, 10.0, 30.0)]);
        let litres = one.statistic(LITRES).expect("reported");
        assert_eq!((litres.mean, litres.ci95, litres.sd), (Some(30.0), None, None));
        assert_eq!(litres.quantiles[5].value, Some(30.0));
        assert_eq!(litres.quantiles[5].ci95, None);
    }

    #[test]
    fn cycles_not_completed_are_counted_and_bounded() {
        let mut stalled = record(2, 1.0, 900.0);
        stalled.outcome = Outcome::Stalled;
        let summary = summary(&[record(0, 10.0, 20.0), record(1, 10.0, 40.0), stalled]);
        assert_eq!(summary.outcomes.of(Outcome::Stalled), 1);
        assert_eq!(summary.outcomes.failed(), 1);
        assert_eq!(summary.statistic(LITRES).expect("reported").mean, Some(30.0));
        // (2 × 30 + 1 × 900) / 3
        let worst = summary.worst_case.expect("a third has failed");
        assert_eq!((worst.column, worst.cycles), (LITRES, 1));
        assert!((worst.mean - 320.0).abs() < 1e-12, "{worst:?}");
    }

    #[test]
    fn the_worst_case_is_no_better_than_what_the_failed_cycles_show() {
        let failed = |id, litres: Option<f64>| Record {
            outcome: Outcome::TimedOut,
            ..record(id, 5.0, 0.0).with(Carrier::LiquidFuel, [None, litres, None])
        };
        let shown = [Some(35.0), Some(60.0), Some(f64::INFINITY), None];
        let mut records = vec![record(0, 10.0, 20.0), record(1, 10.0, 40.0)];
        records.extend((2..).zip(shown).map(|(id, litres)| failed(id, litres)));
        let worst = summary(&records).worst_case.expect("four of six have failed");
        // the worst completed one, 40, for each of them but the one that shows more: (2 × 30 + 3 ×
        // 40 + 60) / 6
        assert_eq!(worst.cycles, 4);
        assert!((worst.mean - 40.0).abs() < 1e-12, "{worst:?}");
    }

    #[test]
    fn routes_add_up_to_the_fleet_and_are_what_each_is_alone() {
        let on = |route_id, record: Record| Record { route_id: Some(route_id), ..record };
        let a = [on(0, record(0, 10.0, 20.0)), on(0, record(3, 30.0, 30.0))];
        let b = [on(2, record(1, 20.0, 40.0)), on(2, record(2, 20.0, 45.0))];
        let both = [a[0].clone(), b[0].clone(), b[1].clone(), a[1].clone()];
        let (alone, both) = ([summary(&a), summary(&b)], summary(&both));
        assert!(alone.iter().all(|one| one.routes.is_empty()));
        assert_eq!(both.routes.iter().map(|route| route.route_id).collect::<Vec<_>>(), [0, 2]);
        for (route, alone) in both.routes.iter().zip(&alone) {
            assert_eq!(route.statistics, alone.statistics);
        }
        let sum: f64 = both.routes.iter().map(|route| route.distance_m).sum();
        assert_eq!(sum, both.distance_m);
        // by hand: (2 + 9) L over 40 km, (8 + 9) L over 40 km
        let means = both.routes.iter().map(|route| route.consumption().and_then(|s| s.mean));
        assert!(means.eq([Some(27.5), Some(42.5)]));
    }

    #[test]
    fn chunks_do_not_matter() {
        let records: Vec<Record> =
            (0..500).map(|k| record(k, 10.0 + (k % 7) as f64, 30.0 + (k % 11) as f64)).collect();
        let mut builder = SummaryBuilder::default();
        for chunk in records.chunks(17) {
            builder.add(chunk);
        }
        assert_eq!(builder.finish(), summary(&records));
    }

    #[test]
    fn serialises_as_the_reference_says() {
        let json =
            serde_json::to_value(summary(&[record(0, 10.0, 30.0)])).expect("numbers and names");
        assert_eq!(json["outcomes"]["completed"], 1);
        let litres = &json["statistics"][LITRES];
        assert_eq!(litres["mean"], 30.0);
        assert!(litres["ci95"].is_null() && litres["p99_ci95"].is_null());
        assert_eq!(litres["p50"], 30.0);
    }
}
