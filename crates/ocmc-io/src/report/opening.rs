//! Opening of a report: the answer in plain sentences, each of them only where it was computed, and
//! in large print.

use super::energy::largest_losses;
use super::svg::escaped;
use super::{Explaining, Reported, shown};
use crate::fleet_total::{FleetTotal, fleet_totals};
use crate::label::{label, saturation};
use crate::number_text::{count_of, decimals, grouped, rough, rounded, two_digits};
use crate::run_directory::JudgedMean;
use crate::study::NumbersShare;
use ocmc_fleet::statistic::Statistic;
use ocmc_fleet::summary::Summary;
use std::fmt::Write;

/// Fewest cycles of which a twentieth is one.
const FEWEST: u64 = 20;
/// Shares below this are not worth a sentence.
const LEAST_SHARE: f64 = 0.05;

/// The sentences, and what has to be known of the run.
pub(super) fn opening(run: &Reported, explaining: &[Explaining]) -> String {
    let summary = &run.summary.summary;
    let mut sentences = Vec::new();
    if let Some(statistic) = summary.consumption() {
        sentences.extend(spread(statistic));
        sentences.extend(explaining.first().and_then(Explaining::sentence));
        sentences.extend(energy(run));
    }
    sentences.push(done(summary));
    let mut text = lead(&sentences.join(" "));
    if let Some(saturation) = saturation(summary) {
        let saturation = escaped(&saturation.replace('\n', " "));
        let _ = writeln!(text, "<p class=\"warning\"><b>Warning.</b> {saturation}</p>");
    }
    text
}

/// The effect of judged numbers on the mean, in large print.
fn half_of(judged: &JudgedMean, factor: f64) -> String {
    judged.plus_minus.map_or("± ?".to_owned(), |h| format!("± {}", two_digits(factor * h)))
}

/// Phrase that names these numbers.
fn of_judged(judged: &JudgedMean) -> String {
    let Some(stored) = &judged.doubt.stored else {
        let why = match judged.doubt.entries {
            0 => "the study does not say which they are",
            _ => "ocmc doubt finds it",
        };
        return format!("from judged numbers, not known: {why}");
    };
    let shares = stored.largest.iter().take(LARGEST_JUDGED).map(NumbersShare::words);
    let about = if stored.is_same { "" } else { ", about" };
    format!(
        "from judged numbers{about} ({}, ...): ocmc doubt",
        shares.collect::<Vec<_>>().join(", ")
    )
}

/// Entries of judged numbers that are named.
const LARGEST_JUDGED: usize = 2;

/// The answer in large print.
pub(super) fn key_numbers(run: &Reported) -> String {
    let summary = &run.summary.summary;
    let mut text = "<div class=\"key\">\n".to_owned();
    let mut key = |number: &str, words: &str| {
        let (number, words) = (escaped(number), escaped(words));
        let _ = writeln!(text, "<div><b>{number}</b>{words}</div>");
    };
    if let Some(trucks) = &summary.trucks {
        let of_trucks = format!("of {}", count_of(trucks.trucks, "truck"));
        let each = count_of(summary.cycles / trucks.trucks.max(1), "trip");
        // what a fleet uses, emits and costs; how far it drives is below
        let totals = fleet_totals(trucks).into_iter();
        for FleetTotal { name, unit, factor, total } in totals.filter(FleetTotal::is_answer) {
            let half = total
                .prediction95
                .map_or("–".to_owned(), |[low, high]| rough(factor * (high - low) / 2.0));
            key(
                &format!("{} ± {half} {unit}", rounded(factor * total.total)),
                &format!("{name} {of_trucks}, {each} each"),
            );
        }
    }
    if let Some(statistic) = summary.consumption() {
        let (unit, factor) = label(statistic.column);
        let half_width = statistic.ci95.map(|[low, high]| (high - low) / 2.0);
        let digits = statistic.mean.map_or(2, |mean| decimals(factor * mean));
        let half_width =
            half_width.map_or("–".to_owned(), |h| format!("{:.digits$}", factor * h));
        let plain = format!("{} ± {half_width}", shown(statistic.mean, factor));
        match &statistic.adjusted {
            Some(adjusted) => {
                let half = (adjusted.ci95[1] - adjusted.ci95[0]) / 2.0;
                key(
                    &format!("{:.digits$} ± {:.digits$}", factor * adjusted.mean, factor * half),
                    &format!(
                        "{unit}, mean of the fleet, adjusted for what was drawn, with its 95 % \
                         interval; {plain} plain"
                    ),
                );
            }
            None => key(&plain, &format!("{unit}, mean of the fleet with its 95 % interval")),
        }
        if let Some(judged) = &run.summary.judged {
            key(&half_of(judged, factor), &format!("{unit} {}", of_judged(judged)));
        }
        key(&shown(statistic.sd, factor), &format!("{unit}, standard deviation between cycles"));
    }
    if let Some(speed) = summary.statistic("mean_speed_mps") {
        key(&shown(speed.mean, 3.6), "km/h, mean speed");
    }
    key(&grouped(summary.cycles), "cycles");
    key(&format!("{} km", rounded(summary.distance_m / 1000.0)), "driven");
    text.push_str("</div>\n");
    text
}

/// A paragraph that a page opens with. No line breaks between a number and its sign of per cent.
pub(super) fn lead(said: &str) -> String {
    format!("<p class=\"lead\">{}</p>\n", escaped(&said.replace(" %", "\u{a0}%")))
}

/// How many trips use less than what, and where the middle half of them lies.
fn spread(statistic: &Statistic) -> Option<String> {
    let value = |name: &str| statistic.quantiles.iter().find(|q| q.name == name)?.value;
    let [p25, p75, p95] = [value("p25")?, value("p75")?, value("p95")?];
    if statistic.n < FEWEST {
        return None;
    }
    let (unit, factor) = label(statistic.column);
    let [p25, p75, p95] = [p25, p75, p95].map(|value| three_digits(factor * value));
    Some(format!(
        "19 of 20 trips use less than {p95} {unit}, half of them between {p25} and {p75}."
    ))
}

/// A number with three digits.
pub(super) fn three_digits(value: f64) -> String {
    if value.abs() >= 1000.0 {
        return crate::number_text::rounded(value);
    }
    format!("{value:.*}", decimals(value).saturating_sub(1))
}

/// Where most of the energy went.
fn energy(run: &Reported) -> Option<String> {
    let (store, losses) = largest_losses(&run.gathered.sums);
    let parts = losses.iter().map(|(name, share)| format!("{name} {:.0} %", 100.0 * share));
    let parts = parts.collect::<Vec<_>>().join(", ");
    (!parts.is_empty()).then(|| format!("The largest parts of the energy {store}: {parts}."))
}

/// Whether all trips came to their end.
fn done(summary: &Summary) -> String {
    match (summary.outcomes.failed(), summary.cycles) {
        (0, cycles) => format!("All {} were completed.", count_of(cycles, "trip")),
        (failed, cycles) => {
            format!("{} of {} trips were not completed.", grouped(failed), grouped(cycles))
        }
    }
}

impl Explaining {
    /// Sentence on the input that the spread goes with most; none where it goes with little.
    fn sentence(&self) -> Option<String> {
        let share = self.association.share;
        let what = self.name.split(',').next().unwrap_or_default().replace(": ", "'s ");
        (share >= LEAST_SHARE).then(|| {
            format!(
                "The {what} goes with {} of the variance between trips, more than all else that \
                 was looked at.",
                fraction(share)
            )
        })
    }
}

/// A share as people say it.
fn fraction(share: f64) -> String {
    const SAID: [(f64, &str); 9] = [
        (0.2, "a fifth"),
        (0.25, "a quarter"),
        (1.0 / 3.0, "a third"),
        (0.4, "two fifths"),
        (0.5, "half"),
        (0.6, "three fifths"),
        (2.0 / 3.0, "two thirds"),
        (0.75, "three quarters"),
        (0.8, "four fifths"),
    ];
    let near = SAID.iter().find(|(value, _)| (value - share).abs() < 0.015);
    near.map_or_else(|| format!("{:.0} %", 100.0 * share), |(_, words)| (*words).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_as_people_say_them() {
        for (share, words) in [(0.741, "three quarters"), (0.81, "four fifths"), (0.7, "70 %")] {
            assert_eq!(fraction(share), words);
        }
    }

    #[test]
    fn three_digits_whatever_the_size() {
        for (value, text) in [(46.31, "46.3"), (1.4467, "1.45"), (992.5, "992"), (1234.4, "1,234")]
        {
            assert_eq!(three_digits(value), text);
        }
    }
}
