//! The page of a study that was learnt from the files of a fleet.

use super::opening::lead;
use super::svg::{Scale, begin, escaped, label as word, levels};
use super::tables::{cells, table};
use super::{FOOT, STYLE, folded, page_head};
use crate::label::label;
use std::fmt::Write;

/// A learnt study, as far as its page needs it.
#[derive(Clone, Copy, Debug)]
pub struct LearnPage<'a> {
    /// Name of the study.
    pub study: &'a str,
    /// Name of the consumption; empty where no trip was held back.
    pub column: &'a str,
    /// The answer as text.
    pub text: &'a str,
    /// The trips that were held back: expected, measured, and the ends of the interval.
    pub points: &'a [[f64; 4]],
    /// Numbers that were judged and no longer are: key, entry, standing.
    pub standings: &'a [[String; 3]],
    /// Accounts of the files, a line each.
    pub accounts: &'a [String],
}

/// The page: HTML that opens offline.
pub fn learn_html(page: &LearnPage) -> String {
    let mut text = match page.points {
        [] => lead("No trip was held back: nothing says how well the study foretells one."),
        points => {
            let (unit, factor) = label(page.column);
            let sums = points.iter().fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
            let within = points.iter().filter(|p| (p[2]..=p[3]).contains(&p[1])).count();
            let n = points.len() as f64;
            let said = format!(
                "Of {} trips that it was not learnt from it expected {:.1} {unit} in the mean; \
                 {:.1} were measured. {within} of them lie within the interval that should hold 90 \
                 %.",
                points.len(),
                factor * sums[0] / n,
                factor * sums[1] / n,
            );
            lead(&said) + &picture(points, unit, factor)
        }
    };
    let _ = writeln!(
        text,
        "<h2>What was learnt</h2>\n<pre tabindex=\"0\">{}</pre>",
        escaped(page.text)
    );
    if !page.standings.is_empty() {
        let rows = page.standings.iter().map(|[key, name, standing]| {
            let key = format!("<code>{}</code>", escaped(key));
            cells(&[key, escaped(name), escaped(standing)])
        });
        let _ = writeln!(
            text,
            "<h2>Numbers that are no longer judged</h2>\n{}",
            table(&["key", "entry", "standing"], rows)
        );
    }
    text.push_str("<h2>What was read</h2>\n<ul>\n");
    for line in page.accounts {
        let _ = writeln!(text, "<li>{}</li>", escaped(line));
    }
    text.push_str("</ul>\n");
    let title = format!("{}, learnt from a fleet's files", page.study);
    let top = page_head(&escaped(&format!("{title}, by ocmc")), STYLE);
    format!("{top}<h1>{}</h1>\n{}{FOOT}", escaped(&title), folded(&text))
}

/// Measured over expected, with the intervals.
fn picture(points: &[[f64; 4]], unit: &str, factor: f64) -> String {
    let (width, height, left, foot) = (720.0, 420.0, 64.0, 46.0);
    let all = || points.iter().flatten().map(|value| factor * value);
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
    let x = Scale { from: [low, high], to: [left, width - 14.0] };
    let y = Scale { from: [low, high], to: [height - foot, 14.0] };
    let mut text = begin(width, height, "Measured over expected consumption of trips held back");
    levels(&mut text, y, [left, width - 14.0]);
    let _ = writeln!(
        text,
        "<line class=\"axis\" x1=\"{left}\" x2=\"{}\" y1=\"{}\" y2=\"14\"/>",
        width - 14.0,
        height - foot
    );
    for point in points {
        let [expected, measured, from, to] = point.map(|value| factor * value);
        let _ = writeln!(
            text,
            "<line class=\"axis\" x1=\"{0:.1}\" x2=\"{0:.1}\" y1=\"{1:.1}\" y2=\"{2:.1}\"/>\n\
             <circle class=\"bar\" cx=\"{0:.1}\" cy=\"{3:.1}\" r=\"4\"><title>expected {4:.1}, \
             measured {5:.1}</title></circle>",
            x.at(expected),
            y.at(from),
            y.at(to),
            y.at(measured),
            expected,
            measured
        );
    }
    for (value, anchor) in [(low, "start"), (f64::midpoint(low, high), "middle"), (high, "end")] {
        word(&mut text, [x.at(value), height - foot + 18.0], anchor, "", &format!("{value:.0}"));
    }
    let middle = f64::midpoint(left, width - 14.0);
    word(&mut text, [middle, height - 8.0], "middle", "name", &format!("expected, {unit}"));
    format!(
        "<figure>{text}</svg>\n<figcaption>Trips that were held back: measured over expected, in \
         {}. Each line is the interval that holds 90 % of such trips.</figcaption></figure>\n",
        escaped(unit)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trips_stand_at_their_places_and_names_are_text() {
        let page = learn_html(&LearnPage {
            study: "a < b",
            column: "consumption_l_per_100km",
            text: "x < y",
            points: &[[30e-8, 31e-8, 28e-8, 33e-8], [20e-8, 30e-8, 18e-8, 23e-8]],
            standings: &[["road.x".into(), "hills".into(), "fitted from <1>".into()]],
            accounts: &["`trips.csv`: 60 rows".to_owned()],
        });
        assert!(page.contains("a &lt; b, learnt") && page.contains("x &lt; y"), "{page}");
        assert!(page.contains("1 of them lie within") && page.contains("fitted from &lt;1&gt;"));
        // the bar of 20 to 30 spans the picture of 18 to 33
        assert!(page.matches("<circle").count() == 2);
    }
}
