//! A simulated trip over the places of a road, from its trace: the same way of reading it as of a
//! measured drive.

use super::passage::{Passage, Places, Rows};
use crate::log::signal::{longest_interval_s, median};
use crate::log::standstill::standstills;
use ocmc_core::kernel::drive::trace::Trace;
use ocmc_core::record::Outcome;

/// A trip over the places; none where it did not arrive. `rate`: the column of the trace whose
/// integral over time is its energy.
pub fn passage(places: Places, trace: &Trace, rate: &str) -> Option<Passage> {
    if trace.record.outcome != Outcome::Completed {
        return None;
    }
    let column = |name: &str| {
        let column = trace.columns.iter().find(|column| column.name == name);
        column.map_or(&[][..], |column| column.values.as_slice())
    };
    let [time_s, step_s, position_m] = ["time_s", "step_s", "position_m"].map(column);
    let (speed_mps, rates) = (column("speed_mps"), column(rate));
    let mut sum = 0.0;
    let energy = rates.iter().zip(step_s).map(|(rate, step_s)| {
        sum += rate * step_s;
        sum
    });
    let energy: Vec<f64> = energy.collect();
    // a row of a standstill is as long as the truck stood: as in a log, nothing was seen meanwhile
    let longest_s = longest_interval_s(median(step_s.to_vec()));
    let stood = |k: usize| k > 0 && step_s[k] > longest_s && position_m[k] <= position_m[k - 1];
    let unseen: Vec<bool> = (0..time_s.len()).map(stood).collect();
    let stops = standstills(time_s, speed_mps, position_m, &unseen);
    Some(Passage::new(places, &Rows { time_s, position_m, speed_mps, energy: &energy }, stops))
}
