//! Columns that are not used although their reader uses all that it knows.

use super::Finding;
use crate::intake::table::Quantity;
use crate::intake::table::formats::LOG;

/// Name of the check.
const NAME: &str = "unused-column";
/// Columns without an effect on a drive, as cycles of FASTSim and VECTO have them.
const WITHOUT_EFFECT: [&str; 12] = [
    "cycroadtype",
    "road_type",
    "cyclename",
    "cycle",
    "name",
    "id",
    "index",
    "comment",
    "note",
    "eor",
    "phase",
    "gear",
];
/// A column of a trace of this program, which has many that follow from the drive.
const OF_A_TRACE: &str = "desired_speed_mps";
/// Quantities of a log that matter to a cycle.
const MATTER: [Quantity; 4] =
    [Quantity::Grade, Quantity::Gradient, Quantity::Altitude, Quantity::Payload];
/// Beginnings of such names: auxiliaries, engine and wind of VECTO's cycles.
const BEGINNINGS: [&str; 6] = ["aux_", "padd", "vair", "n_eng", "pe_", "unnamed"];

/// Looks at the columns that were left out; `allowed` are the names that are read.
pub fn judge(left_out: &[String], allowed: &str) -> Option<Finding> {
    if left_out.iter().any(|name| name == OF_A_TRACE) {
        return None;
    }
    let matters = |name: &&String| {
        // what logs and traces have besides is known, and has no part in a cycle
        if LOG.means(name).is_some_and(|quantity| !MATTER.contains(&quantity)) {
            return false;
        }
        let name = name.to_lowercase();
        let name = name.trim_matches(['<', '>']);
        !name.is_empty()
            && !WITHOUT_EFFECT.contains(&name)
            && !BEGINNINGS.iter().any(|beginning| name.starts_with(beginning))
    };
    let names: Vec<&str> = left_out.iter().filter(matters).map(String::as_str).collect();
    if names.is_empty() {
        return None;
    }
    let what = if names.len() == 1 { "column is" } else { "columns are" };
    let text = format!("unknown {what} not used: `{}`", names.join("`, `"));
    let remedy = format!("allowed are {allowed}; --map says which column is what");
    Some(Finding::warned(NAME, [names.len() as f64, 0.0], text, &remedy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_that_may_matter_is_named() {
        let names =
            |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        assert!(judge(&names(&["cycRoadType", "<Padd>", "", "Aux_HVAC"]), "time_s").is_none());
        let finding = judge(&names(&["note", "uphill"]), "time_s").unwrap();
        assert!(finding.text.contains("`uphill`") && !finding.text.contains("note"), "{finding}");
    }
}
