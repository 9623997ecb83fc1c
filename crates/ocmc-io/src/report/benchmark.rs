//! The page of a benchmark: which trucks and drivers take more or less than was expected of them.

use super::opening::lead;
use super::svg::{Scale, begin, escaped, label as word};
use super::tables::{self, cells, rows};
use super::{FOOT, STYLE, folded, page_head};
use std::fmt::Write;

/// Members at each end of a ranking that are drawn.
const DRAWN: usize = 30;

/// A benchmark, as far as its page needs it.
#[derive(Clone, Copy, Debug)]
pub struct BenchmarkPage<'a> {
    /// Name of the study.
    pub study: &'a str,
    /// Unit of the consumption.
    pub unit: &'a str,
    /// Measured over expected.
    pub ratio: f64,
    /// Trips that count.
    pub trips: usize,
    /// Trips that are far off, and do not.
    pub far: usize,
    /// Trucks and drivers.
    pub rankings: &'a [BenchmarkRanking],
    /// Changes by a date or a group: the kind, what it is compared with, trips of both, and the
    /// change with its 95 % interval.
    pub changes: &'a [BenchmarkChange],
    /// The answer as text.
    pub text: &'a str,
    /// Facts about it.
    pub facts: &'a [(&'static str, String)],
}

/// One kind of trips beside another: see [`BenchmarkPage::changes`].
pub type BenchmarkChange = (String, String, [usize; 2], Option<(f64, [f64; 2])>);

/// Trucks, or drivers.
#[derive(Clone, Debug)]
pub struct BenchmarkRanking {
    /// Their meaning.
    pub what: &'static str,
    /// How many there are.
    pub count: usize,
    /// Probability of as large differences where there are none.
    pub p: f64,
    /// The members, the thriftiest first; none where they do not differ beyond chance.
    pub bars: Vec<BenchmarkBar>,
}

/// A truck or a driver.
#[derive(Clone, Debug)]
pub struct BenchmarkBar {
    /// Its name.
    pub name: String,
    /// Trips.
    pub trips: usize,
    /// Ratio of its trips, not shrunken.
    pub raw: f64,
    /// Ratio to the mean member.
    pub ratio: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
    /// Probability that it is better than the median.
    pub better: f64,
}

/// The page: HTML that opens offline.
pub fn benchmark_html(page: &BenchmarkPage) -> String {
    let mut text = lead(&sentence(page));
    for ranking in page.rankings {
        text.push_str(&of_ranking(ranking));
    }
    if !page.changes.is_empty() {
        let change = |(what, against, trips, change): &BenchmarkChange| {
            let percent = |share: f64| format!("{:+.2}", 100.0 * share);
            let shown = change.map_or("not told apart".to_owned(), |(by, [low, high])| {
                format!("{} ({} to {})", percent(by), percent(low), percent(high))
            });
            let trips = format!("{} / {}", trips[0], trips[1]);
            cells(&[escaped(what), escaped(against), shown, trips])
        };
        let head = ["trips", "against", "change, %, with its 95 % interval", "trips of both"];
        let _ = write!(
            text,
            "<h2>Before and after, or by group</h2>\n{}",
            tables::table(&head, page.changes.iter().map(change))
        );
    }
    let _ = write!(
        text,
        "<h2>In numbers</h2>\n<pre tabindex=\"0\">{}</pre>\n<h2>Provenance</h2>\n\
         <div class=\"wide\" tabindex=\"0\"><table><tbody>\n{}</tbody></table></div>\n",
        escaped(page.text),
        rows(page.facts)
    );
    let title = "Measured trips beside what was expected of them";
    let top = page_head(&format!("{title}, by ocmc"), STYLE);
    format!("{top}<h1>{title}</h1>\n{}{FOOT}", folded(&text))
}

fn sentence(page: &BenchmarkPage) -> String {
    let parts: Vec<String> = (page.rankings.iter())
        .map(|ranking| {
            let not = if ranking.bars.is_empty() { "do not differ" } else { "differ" };
            format!("the {} {} {not} beyond chance", ranking.count, ranking.what)
        })
        .collect();
    let differ = if parts.is_empty() { String::new() } else { format!("; {}", parts.join(", ")) };
    format!(
        "{} trips took {:.1} % of the {} that {} expects of them{differ}. {} were far off and do \
         not count.",
        page.trips,
        100.0 * page.ratio,
        page.unit,
        page.study,
        page.far
    )
}

fn of_ranking(ranking: &BenchmarkRanking) -> String {
    let BenchmarkRanking { what, bars, p, .. } = ranking;
    if bars.is_empty() {
        return format!(
            "<h2>No ranking of {what}</h2>\n<p>They differ by no more than by chance (P = \
             {p:.2}).</p>\n"
        );
    }
    let line = |bar: &BenchmarkBar| {
        cells(&[
            escaped(&bar.name),
            bar.trips.to_string(),
            format!("{:.3}", bar.raw),
            format!("{:.3} ({:.3} to {:.3})", bar.ratio, bar.ci95[0], bar.ci95[1]),
            format!("{:.2}", bar.better),
        ])
    };
    let head = ["name", "trips", "raw ratio", "ratio, 95 %", "P(better than median)"];
    format!(
        "<h2>Ratios of {what}</h2>\n<figure>{}<figcaption>Consumption over that of the mean of \
         all, adjusted for what trips differ in, shrunken, with its 95 % \
         interval.</figcaption></figure>\
         \n{}",
        picture(what, bars),
        tables::table(&head, bars.iter().map(line))
    )
}

/// Intervals under each other, the thriftiest first; of many both ends.
fn picture(what: &str, bars: &[BenchmarkBar]) -> String {
    let n = bars.len();
    let drawn = |place: &usize| n <= 2 * DRAWN || *place < DRAWN || *place >= n - DRAWN;
    let shown: Vec<&BenchmarkBar> = (0..n).filter(drawn).map(|place| &bars[place]).collect();
    let (width, step, left, right, head) = (760.0, 26.0, 240.0, 720.0, 28.0);
    let low = shown.iter().map(|bar| bar.ci95[0]).fold(1.0, f64::min);
    let high = shown.iter().map(|bar| bar.ci95[1]).fold(1.0, f64::max);
    let x = Scale { from: [low, high], to: [left, right] };
    let height = head + step * shown.len() as f64 + 8.0;
    let mut text = begin(width, height, &format!("Ratios of {what} with their intervals"));
    let middle = x.at(1.0);
    let _ = writeln!(
        text,
        "<line class=\"axis\" x1=\"{middle:.1}\" x2=\"{middle:.1}\" y1=\"{head}\" \
         y2=\"{height:.1}\"/>"
    );
    for (value, anchor) in [(low, "start"), (1.0, "middle"), (high, "end")] {
        word(&mut text, [x.at(value), 18.0], anchor, "", &format!("{value:.3}"));
    }
    for (k, bar) in shown.iter().enumerate() {
        let y = head + step * (k as f64 + 0.5);
        let [from, to] = bar.ci95.map(|ratio| x.at(ratio));
        word(&mut text, [left - 12.0, y + 4.0], "end", "name", &bar.name);
        let _ = writeln!(
            text,
            "<rect class=\"band\" x=\"{from:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"6\"/>\
             <rect class=\"bar\" x=\"{:.1}\" y=\"{:.1}\" width=\"4\" height=\"12\"/>",
            y - 3.0,
            (to - from).max(1.0),
            x.at(bar.ratio) - 2.0,
            y - 6.0
        );
    }
    text + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_are_drawn_and_silence_is_kept() {
        let bar = |name: &str, ratio: f64| BenchmarkBar {
            name: name.to_owned(),
            trips: 30,
            raw: ratio,
            ratio,
            ci95: [ratio - 0.01, ratio + 0.01],
            better: 0.5,
        };
        let ranking = |what, bars| BenchmarkRanking { what, count: 2, p: 0.4, bars };
        let rankings =
            [ranking("trucks", vec![bar("<a>", 0.98), bar("b", 1.03)]), ranking("drivers", vec![])];
        let page = benchmark_html(&BenchmarkPage {
            study: "field-truck",
            unit: "L/100 km",
            ratio: 1.04,
            trips: 60,
            far: 1,
            rankings: &rankings,
            changes: &[("since x".to_owned(), "before".to_owned(), [3, 4], None)],
            text: "numbers",
            facts: &[("seed", "1".to_owned())],
        });
        assert!(page.contains("&lt;a&gt;") && page.contains("No ranking of drivers"), "{page}");
        assert_eq!(page.matches("class=\"band\"").count(), 2);
        assert!(page.contains("not told apart"));
    }
}
