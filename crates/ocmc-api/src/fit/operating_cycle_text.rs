//! The fit of roads as text: what they look like from above, and the estimates of each road type.

use super::parameter_table::parameter_table;
use crate::birds_eye::text::birds_eye_text;
use ocmc_estimation::fit::operating_cycle::RoadFit;
use ocmc_io::number_text::count_of;
use std::fmt::Write;

/// The whole answer; `values` is the part of a study.
pub(crate) fn roads_text(fit: &RoadFit, values: &str) -> String {
    let mut text = format!(
        "{}, {:.1} km\n",
        count_of(fit.cycles as u64, "operating cycle"),
        fit.length_m / 1000.0
    );
    text.push_str(&birds_eye_text(&fit.birds_eye));
    for of_type in &fit.types {
        let _ = writeln!(text, "\n{}, {:.1} km", of_type.road_type, of_type.length_m / 1000.0);
        text.push_str(&parameter_table("", &of_type.parameters));
    }
    for (title, parameters) in
        [("turns at junctions", &fit.junction_turn), ("mission", &fit.mission)]
    {
        if !parameters.is_empty() {
            let _ = writeln!(text);
            text.push_str(&parameter_table(title, parameters));
        }
    }
    let _ = write!(text, "\nTo paste into a study:\n\n{values}");
    text
}
