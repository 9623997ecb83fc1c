//! How much trucks, drivers and trips of a fleet differ, from its records.

use super::no_fit;
use crate::answer::Answer;
use crate::error::Error;
use crate::source::{Mapping, Source};
use crate::text::table;
use ocmc_core::energy::carrier::CARRIERS;
use ocmc_estimation::fit::fleet::{
    Best, Expected, FleetDesign, FleetFit, FleetOptions, FleetTable, League, TellingApart,
    VarianceComponent, fit,
};
use ocmc_io::fleet_table::{self, is_over_distance};
use ocmc_io::intake::FileAccount;
use ocmc_io::label::label;
use ocmc_io::number_text::{count_of, grouped, percent, rounded};
use ocmc_io::run_directory::{directory_of, records_file};
use ocmc_io::table::TableError;
use serde::Serialize;
use std::fmt::Write;

/// Most trucks or drivers that are printed one by one; the JSON has them all.
const MOST_MEMBERS: usize = 20;

/// Records of a fleet, and what is asked of them.
#[derive(Clone, Debug)]
pub struct FleetRequest {
    /// One row a trip, or the directory of a run.
    pub records: Source,
    /// Columns of the quantities.
    pub mappings: Vec<Mapping>,
    /// The column that is compared; where none is named, the consumption: that of fuel, or where
    /// no trip has one, that of electricity.
    pub column: Option<String>,
    /// The column that says how much a trip counts: its variance is inverse to that.
    pub weight: Option<String>,
    /// Criteria of the records that count, and the question.
    pub options: FleetOptions,
}

/// Results from the records of a fleet.
#[derive(Clone, Debug, Serialize)]
pub struct FleetAnswer {
    /// The column that was compared.
    pub column: String,
    /// The column of weights.
    pub weight: Option<String>,
    /// The estimates.
    #[serde(flatten)]
    pub fit: FleetFit,
    /// Files that were read.
    pub inputs: Vec<FileAccount>,
    /// The difference that was to be told apart, as a share of the mean.
    pub differ: f64,
    /// The power that was asked for.
    pub power: f64,
    /// The significance of the test, two-sided.
    pub significance: f64,
}

/// The weight that is none.
const NO_WEIGHT: &str = "none";

/// Fits the records of a fleet: variance components, leagues, power, and the year to come.
///
/// ```
/// use ocmc_api::{Answer, FleetOptions, FleetRequest, Source, fit_fleet};
/// let folder = tempfile::tempdir().expect("a directory");
/// let file = folder.path().join("records.csv");
/// let records = "truck_id,consumption_l_per_100km\na,30.1\na,31.9\na,30.8\nb,33.5\nb,32.0\n\
///                b,33.1\nc,29.0\nc,30.2\nc,28.1\n";
/// std::fs::write(&file, records).expect("space");
/// let request = FleetRequest {
///     records: Source::File(file),
///     mappings: Vec::new(),
///     column: None,
///     weight: None,
///     options: FleetOptions::default(),
/// };
/// let answer = fit_fleet(&request)?;
/// // balanced: (mean square of trucks - mean square of trips)/3
/// assert!((answer.fit.components[0].sd - 1.807).abs() < 0.001);
/// assert_eq!(answer.fit.leagues[0].members[0].label, "c");
/// assert!(answer.text().contains("between trucks"));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where the records cannot be read, [`Error::RunDirectory`] where a directory is
/// not that of a run, [`Error::Fit`] where they do not determine the components.
pub fn fit_fleet(request: &FleetRequest) -> Result<FleetAnswer, Error> {
    let FleetRequest { records, mappings, column, weight, options } = request;
    let of_run = match records {
        Source::File(path) if path.is_dir() || directory_of(path) != path => {
            Some(Source::File(records_file(path)?))
        }
        _ => None,
    };
    let records = of_run.as_ref().unwrap_or(records);
    let distance = match weight.as_deref() {
        None => fleet_table::distance_column(records.lent(), mappings)?,
        Some(_) => None,
    };
    // of an amount over the distance a long trip knows more than a short one
    let weight_of = |column: &str| match weight.as_deref() {
        Some(NO_WEIGHT) => None,
        None if is_over_distance(column) => distance.clone(),
        given => given.map(str::to_owned),
    };
    let read = |column: &str| {
        let weight = weight_of(column);
        fleet_table::read(records.lent(), mappings, column, weight.as_deref(), options.month)
    };
    let (column, (rows, read)) = match column {
        Some(column) => (column.clone(), read(column)?),
        None => match fleet_table::consumption_column(records.lent(), mappings)? {
            Some(only) if !assigns(mappings, "response") => (only.clone(), read(&only)?),
            _ => consumption(read)?,
        },
    };
    let fit = fit(&rows, options).map_err(|error| no_fit(records.path(), error))?;
    let FleetOptions { differ, power, significance, .. } = *options;
    let weight = weight_of(&column);
    Ok(FleetAnswer { column, weight, fit, inputs: vec![read], differ, power, significance })
}

/// Whether a user says which column a name is.
fn assigns(mappings: &[Mapping], name: &str) -> bool {
    Mapping::columns(mappings).contains_key(name)
}

/// The first consumption of a carrier in which there are numbers, and its records.
fn consumption(
    read: impl Fn(&str) -> Result<(FleetTable, FileAccount), TableError>,
) -> Result<(String, (FleetTable, FileAccount)), TableError> {
    let has_numbers =
        |(rows, _): &(FleetTable, FileAccount)| rows.value.iter().any(|value| value.is_finite());
    let names = || CARRIERS.iter().map(|declared| declared.consumption.name);
    let mut read_all = names().map(|name| (name, read(name)));
    let first = read_all.next().expect("a carrier");
    let is_there = |(_, rows): &(_, Result<(FleetTable, FileAccount), _>)| {
        rows.as_ref().is_ok_and(has_numbers)
    };
    // a column that a check refuses is there, too
    let is_meant = |read: &(_, Result<_, TableError>)| {
        is_there(read) || read.1.as_ref().is_err_and(TableError::is_of_check)
    };
    let (name, rows) =
        if is_meant(&first) { first } else { read_all.find(is_meant).unwrap_or(first) };
    Ok((name.to_owned(), rows?))
}

impl Answer for FleetAnswer {
    fn warnings(&self) -> Vec<String> {
        self.inputs.iter().flat_map(FileAccount::warnings).collect()
    }

    fn notes(&self) -> Vec<String> {
        self.inputs.iter().flat_map(FileAccount::told).collect()
    }

    fn text(&self) -> String {
        let (name, factor) = label(&self.column);
        let fit = &self.fit;
        let mut text = format!("{}; {name}\n", self.who());
        for (reason, rows) in &fit.dropped {
            let reason = reason.replace('_', " ");
            let _ = writeln!(text, "left out: {}, {reason}", count_of(*rows as u64, "trip"));
        }
        let mean = with_interval(fit.mean, fit.mean_ci95, factor);
        let _ = writeln!(text, "mean over trucks and drivers {mean}");
        text.push_str(&self.components(factor));
        for note in &fit.notes {
            let _ = writeln!(text, "Note: {note}.");
        }
        text.push_str(&self.months(factor));
        text.push_str(&self.telling_apart(factor));
        for league in &fit.leagues {
            text.push_str(&league_text(league, factor));
        }
        text.push_str(&self.next_year(factor));
        text
    }
}

/// A number with its interval, in units for people.
fn with_interval(value: f64, [low, high]: [f64; 2], factor: f64) -> String {
    let [value, low, high] = [value, low, high].map(|number| rounded(factor * number));
    format!("{value} ({low} ; {high})")
}

/// Plural of a level's name.
fn plural(level: &str) -> &str {
    match level {
        "truck" => "trucks",
        "driver" => "drivers",
        "truck_and_driver" => "trucks, each with its driver",
        _ => "trips",
    }
}

impl FleetAnswer {
    /// How many of what, and who drives what.
    fn who(&self) -> String {
        let fit = &self.fit;
        let trips = count_of(fit.n as u64, "trip");
        let trucks = count_of(fit.trucks as u64, "truck");
        let drivers = fit.drivers.map(|drivers| count_of(drivers as u64, "driver"));
        let Some(drivers) = drivers else { return format!("{trips} of {trucks}") };
        let how = match fit.design {
            FleetDesign::TrucksOnly => "",
            FleetDesign::TruckAndDriver => ", each with one truck",
            FleetDesign::DriversInTrucks => ", each in one truck",
            FleetDesign::TrucksOfDrivers => ", each truck with one of them",
            FleetDesign::Crossed => ", who change trucks",
        };
        format!("{trips} of {trucks} by {drivers}{how}")
    }

    fn components(&self, factor: f64) -> String {
        let cell = |value: Option<f64>| value.map_or("-".to_owned(), |v| rounded(factor * v));
        let row = |component: &VarianceComponent| {
            let interval = match component.ci95 {
                Some([low, high]) if high.is_finite() => {
                    format!("({} ; {})", rounded(factor * low), rounded(factor * high))
                }
                Some([low, _]) => format!("({} ; -)", rounded(factor * low)),
                None => "-".to_owned(),
            };
            [
                format!("between {}", plural(component.level)),
                grouped(component.groups as u64),
                rounded(factor * component.sd),
                cell(component.standard_error),
                interval,
                component.relative.map_or("-".to_owned(), percent),
                percent(component.share),
            ]
        };
        let head = ["", "number", "SD", "error", "95 %", "% of mean", "variance, %"];
        let width = if self.fit.design == FleetDesign::TruckAndDriver { 37 } else { 17 };
        let rows = self.fit.components.iter().map(row);
        let weighted = match &self.weight {
            Some(weight) => format!(
                "Trips count by {weight}; the SD between trips is that of a trip of mean \
                 {weight}.\n"
            ),
            None => "Each trip counts once.\n".to_owned(),
        };
        format!("\n{}{weighted}", table(&[width, 9, 9, 9, 19, 11, 13], &head, rows))
    }

    fn months(&self, factor: f64) -> String {
        if self.fit.months.is_empty() {
            return String::new();
        }
        let rows = self.fit.months.iter().map(|month| {
            let effect = format!("{:+.3}", factor * month.effect);
            [month.month.to_string(), effect, rounded(factor * month.standard_error)]
        });
        format!("\n{}", table(&[6, 10, 9], &["month", "effect", "error"], rows))
    }

    fn telling_apart(&self, factor: f64) -> String {
        let Some(first) = self.fit.telling_apart.first() else { return String::new() };
        let mut text = format!(
            "\nTrips of each that tell two apart that differ by {} % ({}), power {} %, {} % \
             two-sided\n",
            short_percent(self.differ),
            rounded(factor * first.difference),
            short_percent(self.power),
            short_percent(self.significance)
        );
        let row = |case: &TellingApart| {
            let trips = case.trips.map_or("never".to_owned(), grouped);
            let mean = self.fit.mean.abs();
            let difference = if mean > 0.0 {
                format!("{:.2} %", 100.0 * case.difference_in_records / mean)
            } else {
                rounded(factor * case.difference_in_records)
            };
            [
                question(case, self.fit.telling_apart.len() > 1),
                trips,
                rounded(case.trips_in_records),
                difference,
            ]
        };
        let head = ["", "trips", "in the records", "tell apart"];
        let rows = self.fit.telling_apart.iter().map(row);
        text.push_str(&table(&[46, 10, 16, 13], &head, rows));
        if self.fit.telling_apart.iter().any(|case| case.trips.is_none()) {
            text.push_str(
                "never: what the two do not share differs too much; trips do not lower that, more\n\
                 drivers or trucks do.\n",
            );
        }
        text
    }

    fn next_year(&self, factor: f64) -> String {
        let next = &self.fit.next_year;
        let line = |name: &str, expected: &Expected| {
            let trips = grouped(expected.trips);
            [name.to_owned(), trips, with_interval(expected.mean, expected.ci95, factor)]
        };
        let mut rows = vec![line("the fleet", &next.fleet), line("a new truck", &next.new_truck)];
        let shown = next.trucks.iter().take(MOST_MEMBERS);
        rows.extend(shown.map(|truck| line(&cut(&truck.label), truck)));
        let head = ["", "trips", "mean, 95 % prediction"];
        let text = table(&[26, 9, 29], &head, rows);
        format!(
            "\nThe mean of next year's trips, drivers as in the records\n{text}{}",
            more(next.trucks.len())
        )
    }
}

/// A share in per cent without needless digits.
fn short_percent(share: f64) -> String {
    format!("{}", (1e6 * share).round() / 1e4)
}

/// Two levels that are told apart; `both` where trucks and drivers are two levels.
fn question(case: &TellingApart, both: bool) -> String {
    let two = match case.level {
        "truck" => "two trucks",
        "driver" => "two drivers",
        _ => "two trucks, each with its driver",
    };
    let others = case.others;
    match case.apart {
        "drivers" if others == 1 => format!("{two}, each with a driver of its own"),
        "drivers" => format!("{two}, each with {others} drivers of its own"),
        "trucks" if others == 1 => format!("{two}, each with a truck of his own"),
        "trucks" => format!("{two}, each with {others} trucks of his own"),
        _ if case.level == "driver" => format!("{two} on the same trucks"),
        _ if both => format!("{two} with the same drivers"),
        _ => two.to_owned(),
    }
}

/// A label that fits into a table.
fn cut(label: &str) -> String {
    label.chars().take(24).collect()
}

/// Remark that there are more.
fn more(count: usize) -> String {
    let more = count.saturating_sub(MOST_MEMBERS);
    if more == 0 {
        String::new()
    } else {
        format!("... and {} more: --json has all\n", grouped(more as u64))
    }
}

fn league_text(league: &League, factor: f64) -> String {
    let first = match league.best {
        Best::Lowest => "the lowest first",
        Best::Highest => "the highest first",
    };
    let mut text = format!("\nLeague of {}, {first}\n", plural(league.level));
    let rows = league.members.iter().take(MOST_MEMBERS).enumerate().map(|(place, member)| {
        [
            format!("{} {}", place + 1, cut(&member.label)),
            grouped(member.trips as u64),
            rounded(factor * member.mean),
            rounded(factor * member.predicted),
            rounded(factor * member.standard_error),
            format!("{:.2}", member.reliability),
            format!("{:.1}", member.expected_rank),
            format!("{:.3}", member.is_first),
            member.before_next.map_or("-".to_owned(), |p| format!("{p:.3}")),
        ]
    });
    let head =
        ["", "trips", "mean", "predicted", "error", "reliable", "rank", "P first", "P before next"];
    text.push_str(&table(&[26, 8, 9, 11, 9, 10, 7, 9, 15], &head, rows));
    text.push_str(&more(league.members.len()));
    let _ = write!(text, "P(the first is truly first) {:.3}", league.first_is_first);
    if let Some(three) = league.three_are_three {
        let _ = write!(text, ", P(the first three are truly the first three) {three:.3}");
    }
    text.push('\n');
    text
}
