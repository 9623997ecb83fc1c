//! The page about judged numbers: what their plausible ranges do to the fleet's mean.

use super::opening::lead;
use super::svg::{Scale, begin, escaped, label as word};
use super::tables::{self, cells, repeated};
use super::{FOOT, STYLE, folded, page_head};
use crate::label::label;
use crate::number_text::decimals;
use crate::study::share_words;
use std::fmt::Write;

/// Bars of the picture.
const DRAWN: usize = 20;
/// Entries that the first sentence names.
const NAMED: usize = 3;

/// An answer about judged numbers, as far as its page needs it.
#[derive(Clone, Copy, Debug)]
pub struct DoubtPage<'a> {
    /// Name of the study.
    pub study: &'a str,
    /// Name of the other one, of a difference.
    pub against: Option<&'a str>,
    /// Name of the quantity.
    pub column: &'static str,
    /// Mean of the fleet, or the difference of two.
    pub mean: Option<f64>,
    /// Root of the sum of squares of the effects on it.
    pub together: f64,
    /// The entries, the largest effect first.
    pub bars: &'a [DoubtBar<'a>],
    /// Facts about it.
    pub facts: &'a [(&'static str, String)],
    /// The command that repeats it, in the directory of the page.
    pub command: &'a str,
}

/// Effect of the numbers of one entry.
#[derive(Clone, Copy, Debug)]
pub struct DoubtBar<'a> {
    /// Name of the entry.
    pub name: &'a str,
    /// Why they lie within their ranges.
    pub reason: &'a str,
    /// The command whose data would replace them.
    pub replaced_by: Option<&'static str>,
    /// Change of the mean at each end.
    pub ends: [Option<f64>; 2],
    /// Share of the sum of squares.
    pub share: f64,
}

/// The page: HTML that opens offline.
pub fn doubt_html(page: &DoubtPage) -> String {
    let (unit, factor) = label(page.column);
    let scale = if page.against.is_some() { page.together } else { page.mean.unwrap_or(1.0) };
    let digits = decimals(factor * scale);
    let what = match page.against {
        None => page.study.to_owned(),
        Some(other) => format!("{other} less {}", page.study),
    };
    let names: Vec<String> =
        page.bars.iter().take(NAMED).map(|bar| share_words(bar.name, bar.share)).collect();
    let mean = page.mean.map_or("–".to_owned(), |mean| format!("{:.digits$}", factor * mean));
    let said = format!(
        "{mean} ± {:.digits$} {unit} hang on numbers that are judged: {}.",
        factor * page.together,
        names.join(", ")
    );
    let mut text = lead(&said);
    text.push_str(
        "<p class=\"soft\">Each number was driven at both ends of its plausible range, on the same \
         cycles. ± is the root of the sum of squares of the effects; it is no confidence \
         interval.</p>\n",
    );
    text.push_str(&picture(page, unit, factor, digits));
    text.push_str(&table(page, factor, digits));
    text.push_str(&repeated("analysis", "the study", page.command, page.facts));
    let title = format!("What {what} owes to judged numbers");
    let top = page_head(&escaped(&format!("{title}, by ocmc")), STYLE);
    format!("{top}<h1>{}</h1>\n{}{FOOT}", escaped(&title), folded(&text))
}

/// Bars from the unmoved mean to both ends.
fn picture(page: &DoubtPage, unit: &str, factor: f64, digits: usize) -> String {
    let bars = &page.bars[..page.bars.len().min(DRAWN)];
    let (width, step, left, right) = (760.0, 26.0, 330.0, 680.0);
    let largest = bars.iter().flat_map(|bar| bar.ends).flatten().map(f64::abs);
    let largest = largest.fold(1e-12, f64::max);
    let x = Scale { from: [-largest, largest], to: [left, right] };
    let height = step * bars.len() as f64 + 28.0;
    let mut text = begin(width, height, "What the ends of the ranges do to the mean");
    for (k, bar) in bars.iter().enumerate() {
        let top = step * k as f64 + 22.0;
        word(&mut text, [left - 84.0, top + 14.0], "end", "name", &bar.name.replace('_', " "));
        for (class, end) in ["band", "bar"].iter().zip(bar.ends) {
            let Some(change) = end else { continue };
            let (from, to) = (x.at(0.0).min(x.at(change)), x.at(0.0).max(x.at(change)));
            let _ = writeln!(
                text,
                "<rect class=\"{class}\" x=\"{from:.1}\" y=\"{top:.1}\" width=\"{:.1}\" \
                 height=\"{}\"/>",
                to - from,
                step - 8.0
            );
        }
        let low = bar.ends.iter().flatten().copied().fold(0.0, f64::min);
        let high = bar.ends.iter().flatten().copied().fold(0.0, f64::max);
        for (change, anchor, beside) in [(low, "end", -6.0), (high, "start", 6.0)] {
            if change != 0.0 {
                let words = format!("{:+.digits$}", factor * change);
                word(&mut text, [x.at(change) + beside, top + 14.0], anchor, "", &words);
            }
        }
    }
    let middle = x.at(0.0);
    let _ = writeln!(
        text,
        "<line class=\"axis\" x1=\"{middle}\" x2=\"{middle}\" y1=\"18\" y2=\"{height:.1}\"/>"
    );
    word(&mut text, [middle, 12.0], "middle", "", "unmoved");
    format!(
        "<h2>Effects on the mean</h2>\n<figure>{text}</svg>\n\
         <figcaption>Change of the mean, in {}: light at the first end of the range, dark at the \
         other.</figcaption></figure>\n",
        escaped(unit)
    )
}

fn table(page: &DoubtPage, factor: f64, digits: usize) -> String {
    let change = |end: Option<f64>| {
        end.map_or("–".to_owned(), |change| format!("{:+.digits$}", factor * change))
    };
    let rows = page.bars.iter().map(|bar| {
        let numbers = cells(&[
            escaped(&bar.name.replace('_', " ")),
            change(bar.ends[0]),
            change(bar.ends[1]),
            format!("{:.0} %", 100.0 * bar.share),
        ]);
        let command = match bar.replaced_by {
            Some(command) => format!("<code>{command}</code>"),
            None => "<code>--set</code>".to_owned(),
        };
        numbers.replace(
            "</tr>",
            &format!(
                "<td class=\"words\">{command}</td><td class=\"words\">{}</td></tr>",
                escaped(bar.reason)
            ),
        )
    });
    let head = ["numbers", "first end", "other end", "share", "replaced by", "why in this range"];
    format!("<h2>All judged numbers</h2>\n{}", tables::table(&head, rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_begin_at_the_unmoved_mean_and_every_entry_has_a_row() {
        let bar =
            |name, ends, share| DoubtBar { name, reason: "a < b", replaced_by: None, ends, share };
        let page = doubt_html(&DoubtPage {
            study: "a & b",
            against: None,
            column: "consumption_l_per_100km",
            mean: Some(35.0),
            together: 4.0,
            bars: &[
                bar("payload_law", [Some(-4.0), Some(2.0)], 0.9),
                bar("slopes", [None, Some(1.0)], 0.1),
            ],
            facts: &[("seed", "1".to_owned())],
            command: "ocmc doubt",
        });
        let said = "35.00 ± 4.00 L/100 km hang on numbers that are judged: payload law 90 %, \
                    slopes 10 %.";
        assert!(page.replace('\u{a0}', " ").contains(said), "{page}");
        // 215 px to the left for −4, half as far to the right for 2, a quarter for 1
        assert!(page.contains("x=\"330.0\" y=\"22.0\" width=\"175.0\""), "{page}");
        assert!(page.contains("x=\"505.0\" y=\"22.0\" width=\"87.5\""), "{page}");
        assert!(page.contains("x=\"505.0\" y=\"48.0\" width=\"43.8\""), "{page}");
        assert!(page.contains("a &lt; b") && page.contains("a &amp; b") && page.contains("–"));
    }
}
