//! VECTO's results beside what is computed here, as tables.

use crate::answer::Answer;
use crate::error::Error;
use crate::text::{fact, row};
use ocmc_vecto::comparison::{
    self, Attribution, TABLE, VectoAnswer, VectoComparison, VectoRequest,
};

/// Width of a column of values, and of one of differences.
const WIDTH: usize = 24;

/// Least value, in the unit of its row, of which a difference is shown as a share.
const LEAST: f64 = 0.2;

/// Compares.
///
/// # Errors
/// [`Error`] names a file that cannot be used, and what is allowed.
pub fn vecto(request: &VectoRequest) -> Result<VectoAnswer, Error> {
    Ok(comparison::vecto(request)?)
}

impl Answer for VectoAnswer {
    fn text(&self) -> String {
        let each: Vec<String> = self.comparisons.iter().map(comparison).collect();
        each.join("\n")
    }

    fn warnings(&self) -> Vec<String> {
        self.notes.clone()
    }
}

fn comparison(compared: &VectoComparison) -> String {
    let mut text = fact("mission", &compared.mission);
    text.push_str(&fact("mass", format!("{:.0} kg", compared.gross_mass_kg)));
    text.push_str(&fact("auxiliary", format!("{:.0} W", compared.auxiliary_power_w)));
    text.push('\n');
    let widths: Vec<usize> =
        [28, 10].into_iter().chain(compared.runs.iter().map(|_| WIDTH)).collect();
    let mut head = vec![String::new(), "VECTO".to_owned()];
    head.extend(compared.runs.iter().map(|run| run.driven.clone()));
    text.push_str(&row("", &widths, &head));
    for (name, unit, value) in TABLE {
        let Some(theirs) = value(&compared.vecto) else { continue };
        let name = if unit.is_empty() { name.to_owned() } else { format!("{name}, {unit}") };
        let mut cells = vec![name, number(theirs)];
        cells.extend(compared.runs.iter().map(|run| match value(&run.terms) {
            Some(ours) => {
                // what is nearly nothing has no share
                let difference = if theirs.abs() < LEAST {
                    String::new()
                } else {
                    format!("({:+.2} %)", 100.0 * (ours / theirs - 1.0))
                };
                format!("{} {difference:>11}", number(ours))
            }
            None => String::new(),
        }));
        text.push_str(&row("", &widths, &cells));
    }
    for run in &compared.runs {
        if let Some(speed) = run.speed {
            let short = if speed.covers { "" } else { ", and does not cover the distance" };
            let apart = format!("{:.2} km/h RMS of v(s) from VECTO's{short}", speed.rms_kmh);
            text.push_str(&row("", &[28, 0], &[run.driven.clone(), apart]));
        }
    }
    text.push_str(&compared.attribution.as_ref().map(attribution).unwrap_or_default());
    text
}

/// Where the difference in fuel comes from.
fn attribution(shares: &Attribution) -> String {
    let parts = [
        ("air", shares.air),
        ("rolling", shares.rolling),
        ("gearbox, axle, retarder", shares.transmission),
        ("auxiliaries", shares.auxiliaries),
        ("brakes", shares.brakes),
        ("engine map", shares.engine_map),
        ("rest", shares.rest),
        ("on its speed with its gears", shares.with_its_gears),
        ("our gears instead", shares.gear_choice),
    ];
    let mut text = "\nfuel by cause, % of VECTO's\n".to_owned();
    for (name, share) in parts {
        text.push_str(&row("", &[28, 10], &[name.to_owned(), format!("{:+.3}", 100.0 * share)]));
    }
    text
}

fn number(value: f64) -> String {
    if value.abs() >= 1000.0 { format!("{value:.0}") } else { format!("{value:.3}") }
}
