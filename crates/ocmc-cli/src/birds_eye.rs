//! `ocmc study birds-eye`: the roads that a study draws, in coarse classes.

use crate::answer::Answer;
use crate::arguments::BirdsEyeArguments;
use crate::failure::Failure;
use crate::number_text::{grouped, rounded};
use crate::output;
use crate::request::check_range;
use ocmc_estimation::fit::operating_cycle::{BirdsEye, birds_eye_of_study};
use ocmc_io::study::{self, LoadedStudy, study_hash};
use serde_json::json;
use std::convert::Infallible;
use std::fmt::Write;
use std::ops::{ControlFlow, Range};

/// Draws the roads and prints what they look like from above.
pub(crate) fn birds_eye(arguments: &BirdsEyeArguments) -> Result<(), Failure> {
    let loaded = study::load(&arguments.study.study, &arguments.study.set)?;
    let BirdsEyeArguments { seed, first_cycle, cycles, .. } = *arguments;
    check_range(first_cycle, cycles)?;
    let ids = first_cycle..first_cycle + cycles;
    let go_on = |_| ControlFlow::<Infallible>::Continue(());
    let ControlFlow::Continue(view) = birds_eye_of_study(&loaded.study, seed, ids.clone(), go_on);
    let answer = birds_eye_answer(&loaded, seed, &ids, &view);
    if arguments.json {
        return output::answer(&format!("{:#}\n", answer.json));
    }
    output::answer(&answer.text)
}

/// What the roads of a study look like.
pub fn birds_eye_answer(
    study: &LoadedStudy,
    seed: u64,
    cycle_ids: &Range<u64>,
    view: &BirdsEye,
) -> Answer {
    let cycles = cycle_ids.end - cycle_ids.start;
    let name = &study.model.study.name;
    let json = json!({
        "study": name,
        "study_hash": study_hash(&study.model),
        "seed": seed,
        "first_cycle": cycle_ids.start,
        "cycles": cycles,
        "birds_eye": view,
    });
    let text = format!(
        "{name}: {} operating cycles, {} km\n{}",
        grouped(cycles),
        rounded(view.length_m / 1000.0),
        birds_eye_text(view)
    );
    Answer { json, text, warnings: Vec::new() }
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
