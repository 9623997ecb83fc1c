//! Roads from above as text: their classes, and what these come from.

use super::BirdsEyeAnswer;
use ocmc_estimation::fit::operating_cycle::BirdsEye;
use ocmc_io::number_text::{grouped, rounded};
use serde_json::json;
use std::fmt::Write;

/// The whole answer.
pub(super) fn answer(answer: &BirdsEyeAnswer) -> String {
    let view = &answer.birds_eye;
    format!(
        "{}: {} operating cycles, {} km\n{}",
        answer.study,
        grouped(answer.cycles),
        rounded(view.length_m / 1000.0),
        birds_eye_text(view)
    )
}

/// A class in words.
fn words(class: &serde_json::Value) -> String {
    class.as_str().unwrap_or_default().replace('_', " ")
}

/// The classes and what they come from.
pub(crate) fn birds_eye_text(view: &BirdsEye) -> String {
    let unknown = || "not known".to_owned();
    let hilliness = view.share_below.map_or_else(unknown, |shares| {
        let [three, six, nine] = shares.map(|share| 100.0 * share);
        let class = words(&json!(view.hilliness));
        format!("{class}: below 3, 6, 9 % on {three:.1}, {six:.1}, {nine:.1} %")
    });
    let curves = view.curves_per_km.map_or_else(unknown, |per_km| {
        format!("{}, {per_km:.2} per km", words(&json!(view.curve_density)))
    });
    let mut text = format!(
        "hilliness        {hilliness}\n\
         transport cycle  {}\n\
         stops            {}, {:.2} per km\n\
         curves < 500 m   {curves}\n",
        words(&json!(view.transport_cycle)),
        words(&json!(view.stop_density)),
        view.stops_per_km,
    );
    for (name, share) in &view.road_type_share {
        let _ = writeln!(text, "{name:15}  {:.1} % of the way", 100.0 * share);
    }
    text
}
