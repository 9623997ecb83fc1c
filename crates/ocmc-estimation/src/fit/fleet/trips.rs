//! Trips of a fleet, reduced to what their likelihood needs: sums by truck and by driver, and who
//! drove what.
//!
//! Trucks and drivers that are connected by trips form a block; blocks have nothing to do with each
//! other. Of each block the larger side is eliminated, whose part of the equations is diagonal, and
//! a dense matrix as large as the smaller side is left: of drivers that are each in one truck a
//! single number.

use super::{Dropped, FleetFitError, FleetOptions};
use nalgebra::DMatrix;
use std::collections::BTreeMap;

/// Most levels of the smaller side of a block: its matrix takes 32 MB, its factor seconds.
const MOST_DENSE: usize = 2000;
/// Days of the months of a year without a leap day.
const MONTH_DAYS: [f64; 12] =
    [31.0, 28.0, 31.0, 30.0, 31.0, 30.0, 31.0, 31.0, 30.0, 31.0, 30.0, 31.0];
const DAY_S: f64 = 86_400.0;

/// Trips as columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FleetTable {
    /// Name of the truck; empty where it is missing.
    pub truck: Vec<String>,
    /// Name of the driver; empty where it is missing.
    pub driver: Option<Vec<String>>,
    /// The quantity, NaN where it is missing.
    pub value: Vec<f64>,
    /// How much a trip counts, such as its length: its variance is inverse to that.
    pub weight: Option<Vec<f64>>,
    /// Columns whose effects are the same for all: part of the model, as the months are.
    pub covariates: Vec<Vec<f64>>,
    /// Departure, in s from the beginning of the year.
    pub departure_s_of_year: Option<Vec<f64>>,
    /// Whether it was completed.
    pub completed: Option<Vec<bool>>,
}

/// Assignment of drivers to trucks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FleetDesign {
    /// Drivers are not known, or not told apart from trips.
    TrucksOnly,
    /// Each truck has one driver and each driver one truck.
    TruckAndDriver,
    /// Each driver has one truck, some trucks several drivers.
    DriversInTrucks,
    /// Each truck has one driver, some drivers several trucks.
    TrucksOfDrivers,
    /// Some drivers have several trucks, and some trucks several drivers.
    Crossed,
}

/// All trucks, or all drivers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Family {
    pub(crate) labels: Vec<String>,
    /// Number of trips of each.
    pub(crate) trips: Vec<usize>,
    /// Sum of their weights.
    pub(crate) weights: Vec<f64>,
    /// Weighted sums of \[X y\] of each, one behind the other.
    pub(crate) sums: Vec<f64>,
}

impl Family {
    pub(crate) fn len(&self) -> usize {
        self.labels.len()
    }
}

/// Trucks and drivers that are connected.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// The family of the smaller side: 0 trucks, 1 drivers.
    pub(crate) kept_family: usize,
    pub(crate) kept: Vec<usize>,
    pub(crate) eliminated: Vec<usize>,
    /// Kept levels (by their places) with which each eliminated level drove, and the weight.
    pub(crate) cells: Vec<Vec<(usize, f64)>>,
}

/// The trips that count, reduced.
#[derive(Clone, Debug)]
pub(crate) struct Trips {
    pub(crate) n: usize,
    pub(crate) design: FleetDesign,
    /// Fixed effects: 1, the months but for the first, and the covariates.
    pub(crate) width: usize,
    /// The months that occur, from 0; empty where they are no part of the model.
    pub(crate) months: Vec<usize>,
    /// Subtracted from the values.
    pub(crate) shift: f64,
    /// Weighted cross products of \[X y\].
    pub(crate) gram: DMatrix<f64>,
    /// Trucks and drivers; no drivers where they are no level.
    pub(crate) families: [Family; 2],
    pub(crate) blocks: Vec<Block>,
    /// Sum of the logarithms of the weights.
    pub(crate) log_weights: f64,
    /// Degrees of freedom of the trips' residuals, all effects fixed.
    pub(crate) residual_df: usize,
    /// Trucks and drivers of the table, whether or not they are levels.
    pub(crate) counted: [usize; 2],
    /// Pairs of a truck and a driver.
    pub(crate) pairs: usize,
    pub(crate) dropped: Dropped,
}

/// The month of a departure, from 0.
fn month(departure_s_of_year: f64) -> Option<usize> {
    if !(0.0..366.0 * DAY_S).contains(&departure_s_of_year) {
        return None;
    }
    let mut end_s = 0.0;
    for (month, days) in MONTH_DAYS.iter().enumerate() {
        end_s += days * DAY_S;
        if departure_s_of_year < end_s {
            return Some(month);
        }
    }
    Some(11)
}

/// A trip that counts.
struct CountedTrip {
    /// Its place in the table.
    place: usize,
    truck: usize,
    driver: usize,
    month: usize,
    value: f64,
    weight: f64,
}

/// Numbers labels in the order in which they come.
#[derive(Default)]
struct Labels {
    numbers: BTreeMap<String, usize>,
    names: Vec<String>,
}

impl Labels {
    fn number(&mut self, name: String) -> usize {
        let Self { numbers, names } = self;
        *numbers.entry(name).or_insert_with_key(|name| {
            names.push(name.clone());
            names.len() - 1
        })
    }
}

/// Fault of a row, if any.
fn fault(table: &FleetTable, k: usize, with_months: bool) -> Option<&'static str> {
    let weight = table.weight.as_ref().map_or(1.0, |weight| weight[k]);
    let departure = table.departure_s_of_year.as_ref().map_or(f64::NAN, |all| all[k]);
    match () {
        () if table.completed.as_ref().is_some_and(|completed| !completed[k]) => {
            Some("not_completed")
        }
        () if table.truck[k].is_empty() => Some("no_truck"),
        () if table.driver.as_ref().is_some_and(|driver| driver[k].is_empty()) => Some("no_driver"),
        () if !table.value[k].is_finite() => Some("no_value"),
        () if table.covariates.iter().any(|column| !column[k].is_finite()) => Some("no_covariate"),
        () if !(weight > 0.0 && weight.is_finite()) => Some("no_weight_above_0"),
        () if with_months && month(departure).is_none() => Some("no_departure_of_the_year"),
        () => None,
    }
}

impl Trips {
    /// Takes the trips that count, and says who drives what.
    pub(crate) fn of(table: &FleetTable, options: &FleetOptions) -> Result<Self, FleetFitError> {
        let (mut trucks, mut drivers) = (Labels::default(), Labels::default());
        let mut dropped = Dropped::new();
        let mut trips: Vec<CountedTrip> = Vec::new();
        for k in 0..table.value.len() {
            if let Some(reason) = fault(table, k, options.month) {
                *dropped.entry(reason).or_default() += 1;
                continue;
            }
            let truck = trucks.number(table.truck[k].clone());
            let driver = table.driver.as_ref().map_or(0, |driver| {
                drivers.number(if options.own_drivers {
                    format!("{} / {}", table.truck[k], driver[k])
                } else {
                    driver[k].clone()
                })
            });
            let departure = table.departure_s_of_year.as_ref().map_or(0.0, |all| all[k]);
            let month = if options.month { month(departure).unwrap_or(0) } else { 0 };
            let weight = table.weight.as_ref().map_or(1.0, |weight| weight[k]);
            trips.push(CountedTrip {
                place: k,
                truck,
                driver,
                month,
                value: table.value[k],
                weight,
            });
        }
        let n = trips.len();
        if trucks.names.len() < 2 {
            let trucks = trucks.names.len();
            return Err(FleetFitError::FewTrucks { trucks, trips: n, dropped });
        }
        if table.weight.is_some() {
            let mean = trips.iter().map(|trip| trip.weight).sum::<f64>() / n as f64;
            for trip in &mut trips {
                trip.weight /= mean;
            }
        }
        let mut pairs: BTreeMap<[usize; 2], f64> = BTreeMap::new();
        for trip in &trips {
            *pairs.entry([trip.truck, trip.driver]).or_default() += trip.weight;
        }
        let counted = [trucks.names.len(), drivers.names.len()];
        let design = design(&pairs, counted, n);
        let mut families = [trucks, drivers].map(|labels| Family {
            trips: vec![0; labels.names.len()],
            labels: labels.names,
            ..Family::default()
        });
        if design == FleetDesign::TruckAndDriver {
            for [truck, driver] in pairs.keys() {
                let [trucks, drivers] = &mut families;
                let label = &mut trucks.labels[*truck];
                if *label != drivers.labels[*driver] {
                    *label = format!("{label} & {}", drivers.labels[*driver]);
                }
            }
        }
        if matches!(design, FleetDesign::TrucksOnly | FleetDesign::TruckAndDriver) {
            families[1] = Family::default();
        }
        let blocks = blocks(&pairs, [families[0].len(), families[1].len()])?;
        let mut reduced = Self {
            n,
            design,
            width: 1,
            months: months(&trips, options.month),
            shift: 0.0,
            gram: DMatrix::zeros(0, 0),
            families,
            blocks,
            log_weights: trips.iter().map(|trip| libm::log(trip.weight)).sum(),
            residual_df: 0,
            counted,
            pairs: pairs.len(),
            dropped,
        };
        reduced.width += reduced.months.len().saturating_sub(1) + table.covariates.len();
        let effects = reduced.families[0].len() + reduced.families[1].len() - reduced.blocks.len();
        let used = effects.max(1) + reduced.width - usize::from(effects > 0);
        if used >= n || reduced.families[0].trips.len() >= n {
            return Err(FleetFitError::NoRepeats { trips: n, trucks: counted[0] });
        }
        reduced.residual_df = n - used;
        reduced.sum(&trips, &table.covariates);
        Ok(reduced)
    }

    /// Sums the trips up.
    fn sum(&mut self, trips: &[CountedTrip], covariates: &[Vec<f64>]) {
        let q = self.width + 1;
        let total: f64 = trips.iter().map(|trip| trip.weight).sum();
        self.shift = trips.iter().map(|trip| trip.weight * trip.value).sum::<f64>() / total;
        self.gram = DMatrix::zeros(q, q);
        for family in &mut self.families {
            family.weights = vec![0.0; family.labels.len()];
            family.sums = vec![0.0; q * family.labels.len()];
        }
        let has_drivers = self.families[1].len() > 0;
        let mut x = vec![0.0; q];
        for trip in trips {
            x.fill(0.0);
            x[0] = 1.0;
            if let Some(place) = self.months.iter().skip(1).position(|month| *month == trip.month) {
                x[place + 1] = 1.0;
            }
            for (x, column) in x[q - 1 - covariates.len()..].iter_mut().zip(covariates) {
                *x = column[trip.place];
            }
            x[q - 1] = trip.value - self.shift;
            for a in 0..q {
                for b in 0..q {
                    self.gram[(a, b)] += trip.weight * x[a] * x[b];
                }
            }
            let levels = [Some(trip.truck), has_drivers.then_some(trip.driver)];
            for (family, level) in self.families.iter_mut().zip(levels) {
                if let Some(level) = level {
                    family.trips[level] += 1;
                    family.weights[level] += trip.weight;
                    for (sum, x) in family.sums[level * q..].iter_mut().zip(&x) {
                        *sum += trip.weight * x;
                    }
                }
            }
        }
    }

    /// Mean predictors of a level.
    pub(crate) fn predictors(&self, family: usize, level: usize) -> Vec<f64> {
        let (q, totals) = (self.width + 1, &self.families[family]);
        totals.sums[level * q..][..self.width]
            .iter()
            .map(|sum| sum / totals.weights[level])
            .collect()
    }

    /// Mean predictors of all trips.
    pub(crate) fn mean_predictors(&self) -> Vec<f64> {
        (0..self.width).map(|j| self.gram[(0, j)] / self.gram[(0, 0)]).collect()
    }

    /// Mean of a level's trips.
    pub(crate) fn mean_of(&self, family: usize, level: usize) -> f64 {
        let (q, totals) = (self.width + 1, &self.families[family]);
        self.shift + totals.sums[level * q + q - 1] / totals.weights[level]
    }

    /// Degrees of freedom between the levels of a family, beside the other one.
    pub(crate) fn df_between(&self, family: usize) -> usize {
        let levels = self.families[family].len();
        let outer = match self.design {
            FleetDesign::TrucksOnly | FleetDesign::TruckAndDriver => true,
            FleetDesign::DriversInTrucks => family == 0,
            FleetDesign::TrucksOfDrivers => family == 1,
            FleetDesign::Crossed => false,
        };
        (levels - if outer { 1 } else { self.blocks.len() }).max(1)
    }

    /// Shares of a truck's weight that its drivers have.
    pub(crate) fn drivers_of_trucks(&self) -> Vec<Vec<(usize, f64)>> {
        let mut of_trucks = vec![Vec::new(); self.families[0].len()];
        for block in &self.blocks {
            for (level, cells) in block.eliminated.iter().zip(&block.cells) {
                for (place, weight) in cells {
                    let kept = block.kept[*place];
                    let (truck, driver) =
                        if block.kept_family == 0 { (kept, *level) } else { (*level, kept) };
                    of_trucks[truck].push((driver, weight / self.families[0].weights[truck]));
                }
            }
        }
        of_trucks
    }
}

/// The months that occur, in order; none where they are no part of the model.
fn months(trips: &[CountedTrip], with_months: bool) -> Vec<usize> {
    let mut months: Vec<usize> =
        if with_months { trips.iter().map(|trip| trip.month).collect() } else { Vec::new() };
    months.sort_unstable();
    months.dedup();
    months
}

/// Assignment of drivers to trucks in the records.
fn design(
    pairs: &BTreeMap<[usize; 2], f64>,
    [trucks, drivers]: [usize; 2],
    n: usize,
) -> FleetDesign {
    // a driver of one trip is that trip
    if drivers < 2 || drivers == n {
        return FleetDesign::TrucksOnly;
    }
    match (pairs.len() == trucks, pairs.len() == drivers) {
        (true, true) => FleetDesign::TruckAndDriver,
        (false, true) => FleetDesign::DriversInTrucks,
        (true, false) => FleetDesign::TrucksOfDrivers,
        (false, false) => FleetDesign::Crossed,
    }
}

/// The connected parts of trucks and drivers.
fn blocks(
    pairs: &BTreeMap<[usize; 2], f64>,
    [trucks, drivers]: [usize; 2],
) -> Result<Vec<Block>, FleetFitError> {
    let mut root: Vec<usize> = (0..trucks + drivers).collect();
    let find = |root: &mut Vec<usize>, mut node: usize| {
        while root[node] != node {
            root[node] = root[root[node]];
            node = root[node];
        }
        node
    };
    if drivers > 0 {
        for [truck, driver] in pairs.keys() {
            let (a, b) = (find(&mut root, *truck), find(&mut root, trucks + driver));
            root[a.max(b)] = a.min(b);
        }
    }
    let mut number = vec![usize::MAX; trucks + drivers];
    let mut members: Vec<[Vec<usize>; 2]> = Vec::new();
    for node in 0..trucks + drivers {
        let root = find(&mut root, node);
        if number[root] == usize::MAX {
            number[root] = members.len();
            members.push([Vec::new(), Vec::new()]);
        }
        number[node] = number[root];
        let (family, level) = if node < trucks { (0, node) } else { (1, node - trucks) };
        members[number[node]][family].push(level);
    }
    let mut place = [vec![0; trucks], vec![0; drivers]];
    let mut blocks = Vec::with_capacity(members.len());
    for sides in members {
        for (family, side) in sides.iter().enumerate() {
            side.iter().enumerate().for_each(|(k, level)| place[family][*level] = k);
        }
        let kept_family = usize::from(!sides[1].is_empty() && sides[1].len() < sides[0].len());
        let [trucks, drivers] = sides;
        let (kept, eliminated) =
            if kept_family == 0 { (trucks, drivers) } else { (drivers, trucks) };
        if kept.len() > MOST_DENSE {
            return Err(FleetFitError::Entangled { levels: kept.len(), most: MOST_DENSE });
        }
        let cells = vec![Vec::new(); eliminated.len()];
        blocks.push(Block { kept_family, kept, eliminated, cells });
    }
    if drivers > 0 {
        for ([truck, driver], weight) in pairs {
            let block = &mut blocks[number[*truck]];
            let (kept, eliminated) = if block.kept_family == 0 {
                (place[0][*truck], place[1][*driver])
            } else {
                (place[1][*driver], place[0][*truck])
            };
            block.cells[eliminated].push((kept, *weight));
        }
    }
    Ok(blocks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn months_are_those_of_the_calendar() {
        let day = |day: f64| month(day * DAY_S);
        assert_eq!([day(0.0), day(30.99), day(31.0), day(58.99)], [0, 0, 1, 1].map(Some));
        assert_eq!([day(59.0), day(364.0), day(365.5)], [2, 11, 11].map(Some));
        assert_eq!([day(-1.0), day(366.0), month(f64::NAN)], [None; 3]);
    }

    #[test]
    fn who_drives_what() {
        let design_and_blocks = |pairs: &[[usize; 2]], levels| {
            let pairs: BTreeMap<_, _> = pairs.iter().map(|pair| (*pair, 1.0)).collect();
            let design = design(&pairs, levels, 100);
            let blocks = blocks(&pairs, levels).unwrap();
            (design, blocks.iter().map(|block| block.kept.len()).collect::<Vec<_>>())
        };
        assert_eq!(
            design_and_blocks(&[[0, 1], [1, 0]], [2, 2]),
            (FleetDesign::TruckAndDriver, vec![1, 1])
        );
        assert_eq!(
            design_and_blocks(&[[0, 0], [0, 1], [1, 2]], [2, 3]),
            (FleetDesign::DriversInTrucks, vec![1, 1])
        );
        assert_eq!(
            design_and_blocks(&[[0, 0], [1, 0], [2, 1]], [3, 2]),
            (FleetDesign::TrucksOfDrivers, vec![1, 1])
        );
        // two depots
        let depots = [[0, 0], [0, 1], [1, 0], [1, 1], [2, 2], [3, 2], [2, 3], [3, 3], [3, 4]];
        assert_eq!(design_and_blocks(&depots, [4, 5]), (FleetDesign::Crossed, vec![2, 2]));
    }
}
