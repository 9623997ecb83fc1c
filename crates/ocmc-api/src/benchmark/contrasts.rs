//! Before and after a date, or one group beside another.

use super::BenchmarkContrast;
use crate::error::Error;
use ocmc_estimation::fit::contrast::contrast;
use ocmc_io::trip_totals::{TripTotal, time_of};
use serde::Serialize;
use std::collections::BTreeMap;

/// Most groups that are compared.
const MOST_GROUPS: usize = 20;

/// One kind of trips beside another.
#[derive(Clone, Debug, Serialize)]
pub struct Compared {
    /// The kind: `since 2024-03-01`, or a group.
    pub what: String,
    /// The other side of the comparison: `before`, or the group with most trips.
    pub against: String,
    /// Trips of what it is compared with, and of the kind.
    pub trips: [usize; 2],
    /// Trucks with trips of both.
    pub trucks_of_both: usize,
    /// Whether the difference is within trucks, or between trucks.
    pub is_within_trucks: bool,
    /// Whether routes are adjusted for.
    pub is_of_same_routes: bool,
    /// Change of the consumption, all else equal, as a share; none where it cannot be told from
    /// what else differs.
    pub change: Option<f64>,
    /// Its 95 % interval.
    pub ci95: Option<[f64; 2]>,
    /// Degrees of freedom of its error.
    pub degrees: Option<f64>,
}

/// The comparison.
pub(super) struct Rows<'a> {
    pub(super) of_table: &'a [TripTotal],
    /// Whether the columns tell routes apart.
    pub(super) has_routes: bool,
    pub(super) ln_ratio: &'a [f64],
    pub(super) columns: &'a [Vec<f64>],
    pub(super) truck: &'a [usize],
}

impl Rows<'_> {
    /// Compares what was asked for.
    pub(super) fn compared(&self, asked: &BenchmarkContrast) -> Result<Vec<Compared>, Error> {
        match asked {
            BenchmarkContrast::Since(date) => {
                let since = time_of(date).ok_or_else(|| Error::NotADate(date.clone()))?;
                let kinds: Vec<Option<bool>> = (self.of_table.iter())
                    .map(|row| row.time_s.is_finite().then_some(row.time_s >= since))
                    .collect();
                let names = [format!("since {date}"), "before".to_owned()];
                Ok(vec![self.one(names, &kinds)])
            }
            BenchmarkContrast::Group => {
                let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
                for row in self.of_table.iter().filter(|row| !row.group.is_empty()) {
                    *counts.entry(&row.group).or_default() += 1;
                }
                let mut groups: Vec<(&str, usize)> = counts.into_iter().collect();
                groups.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
                let Some(((base, _), others)) = groups.split_first() else {
                    return Err(Error::NoGroups(0));
                };
                if others.is_empty() || others.len() >= MOST_GROUPS {
                    return Err(Error::NoGroups(groups.len()));
                }
                let one = |(group, _): &(&str, usize)| {
                    let kind = |row: &TripTotal| match row.group.as_str() {
                        name if name == *group => Some(true),
                        name if name == *base => Some(false),
                        _ => None,
                    };
                    let kinds: Vec<Option<bool>> = self.of_table.iter().map(kind).collect();
                    self.one([(*group).to_owned(), (*base).to_owned()], &kinds)
                };
                Ok(others.iter().map(one).collect())
            }
        }
    }

    fn one(&self, [what, against]: [String; 2], kinds: &[Option<bool>]) -> Compared {
        let kept: Vec<usize> = (0..kinds.len()).filter(|k| kinds[*k].is_some()).collect();
        let is_of: Vec<bool> = kept.iter().map(|k| kinds[*k] == Some(true)).collect();
        let kept_values =
            |values: &[f64]| -> Vec<f64> { kept.iter().map(|k| values[*k]).collect() };
        let columns: Vec<Vec<f64>> =
            self.columns.iter().map(|column| kept_values(column)).collect();
        let truck: Vec<usize> = kept.iter().map(|k| self.truck[*k]).collect();
        let contrast = contrast(&kept_values(self.ln_ratio), &is_of, &columns, &truck);
        let with = is_of.iter().filter(|is| **is).count();
        let share = |ln: f64| libm::exp(ln) - 1.0;
        Compared {
            what,
            against,
            trips: [kept.len() - with, with],
            trucks_of_both: contrast.as_ref().map_or(0, |contrast| contrast.clusters_of_both),
            is_within_trucks: contrast.as_ref().is_some_and(|contrast| contrast.is_within),
            is_of_same_routes: self.has_routes,
            change: contrast.as_ref().map(|contrast| share(contrast.difference)),
            ci95: contrast.as_ref().map(|contrast| contrast.ci95.map(share)),
            degrees: contrast.map(|contrast| contrast.degrees),
        }
    }
}
