//! The report's pictures: a histogram, bands, and horizontal bars, as SVG that takes its colours
//! from the page.

use crate::number_text::{grouped, rounded};
use ocmc_fleet::association::{Association, Band};
use ocmc_fleet::histogram::Histogram;
use std::fmt::Write;

/// Text that may hold anything, as text of HTML and of attributes.
pub(super) fn escaped(text: &str) -> String {
    let codes = [('&', "&amp;"), ('<', "&lt;"), ('>', "&gt;"), ('"', "&quot;"), ('\'', "&#39;")];
    codes.into_iter().fold(text.to_owned(), |text, (letter, code)| text.replace(letter, code))
}

/// Maps a range of values to a range of places.
#[derive(Clone, Copy)]
pub(super) struct Scale {
    pub(super) from: [f64; 2],
    pub(super) to: [f64; 2],
}

impl Scale {
    pub(super) fn at(self, value: f64) -> f64 {
        let [a, b] = self.from;
        let share = if b > a { (value - a) / (b - a) } else { 0.5 };
        self.to[0] + share * (self.to[1] - self.to[0])
    }
}

pub(super) fn begin(width: f64, height: f64, what: &str) -> String {
    // on narrow screens letters of broad pictures grow, and panoramas are moved sideways
    let class = match width {
        ..=400.0 => "",
        ..=800.0 => " class=\"broad\"",
        _ => " class=\"panorama\"",
    };
    format!(
        "<svg{class} viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">\n",
        escaped(what)
    )
}

/// The points of a line, as SVG takes them.
pub(super) fn points(line: impl IntoIterator<Item = (f64, f64)>) -> String {
    let place = |(x, y)| format!("{x:.1},{y:.1}");
    line.into_iter().map(place).collect::<Vec<_>>().join(" ")
}

/// A level line.
pub(super) fn level(text: &mut String, class: &str, [left, right]: [f64; 2], y: f64) {
    let _ = writeln!(
        text,
        "<line class=\"{class}\" x1=\"{left}\" x2=\"{right}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>"
    );
}

/// A round step between numbers of an axis: 1, 2 or 5 times a power of ten, four to eight of them.
pub(super) fn step(span: f64) -> f64 {
    let wanted = (span / 4.0).max(f64::MIN_POSITIVE);
    let power = 10_f64.powf(wanted.log10().floor());
    [5.0, 2.0, 1.0].map(|times| times * power).into_iter().find(|s| *s <= wanted).unwrap_or(power)
}

/// Round numbers within a range, two to four of them.
fn round_within([low, high]: [f64; 2]) -> Vec<f64> {
    let step = step(2.0 * (high - low));
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    // of a range without a width the one value
    if high > low { (first..=last).map(|k| k as f64 * step).collect() } else { vec![low] }
}

/// Level lines at round numbers of a scale.
pub(super) fn levels(text: &mut String, y: Scale, [left, right]: [f64; 2]) {
    for value in round_within(y.from) {
        let place = y.at(value);
        level(text, "axis", [left, right], place);
        label(text, [left - 4.0, place + 4.0], "end", "", &rounded_short(value));
    }
}

pub(super) fn label(text: &mut String, [x, y]: [f64; 2], anchor: &str, class: &str, words: &str) {
    let words = escaped(words);
    let _ = writeln!(
        text,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" class=\"{class}\">{words}</text>"
    );
}

/// A line at a value of a histogram, with its name.
pub(super) struct Mark {
    value: f64,
    name: String,
    is_mean: bool,
}

impl Mark {
    pub(super) fn quantile(value: f64, name: String) -> Self {
        Self { value, name, is_mean: false }
    }

    /// Dashed, with its name in a row of its own: a mean lies close to the middle.
    pub(super) fn mean(value: f64, name: String) -> Self {
        Self { value, name, is_mean: true }
    }
}

/// Round numbers up to the largest count, at most five of them, nothing left out.
fn count_ticks(largest: u64) -> Vec<u64> {
    let wanted = largest.div_ceil(5).max(1);
    let power = 10_u64.pow(wanted.ilog10());
    let step = [1, 2, 5, 10].into_iter().map(|factor| factor * power).find(|step| *step >= wanted);
    let step = step.unwrap_or(largest.max(1));
    (1..=largest / step).map(|k| k * step).collect()
}

/// Marks whose names have no room beside each other share one, as in "P5, P50".
fn named_once(marks: &[Mark], x: Scale) -> Vec<Mark> {
    let mut named: Vec<Mark> = Vec::new();
    for mark in marks {
        match named.last_mut() {
            Some(before)
                if !mark.is_mean
                    && !before.is_mean
                    && (x.at(mark.value) - x.at(before.value)).abs() < 46.0 =>
            {
                let name = format!("{}, {}", std::mem::take(&mut before.name), mark.name);
                named.push(Mark { name, ..*mark });
            }
            _ => named.push(Mark { name: mark.name.clone(), ..*mark }),
        }
    }
    named
}

/// The first of some edges, one step apart, that is a multiple of so many steps: what is counted on
/// from it is round. The very first where none is.
fn first_round(edges: &[f64], every: usize) -> usize {
    let step = (edges[1] - edges[0]) * every as f64;
    let is_multiple = |edge: &f64| (edge / step - (edge / step).round()).abs() < 1e-6;
    edges.iter().take(every).position(is_multiple).unwrap_or(0)
}

/// A histogram, with lines at some values; `what` is what is counted.
pub(super) fn histogram(histogram: &Histogram, marks: &[Mark], unit: &str, what: &str) -> String {
    let (width, height, left, head, foot) = (720.0, 324.0, 64.0, 52.0, 56.0);
    let right = width - 30.0;
    let edges = &histogram.edges;
    let x = Scale { from: [edges[0], edges[edges.len() - 1]], to: [left, right] };
    let largest = histogram.counts.iter().copied().max().unwrap_or(1).max(1);
    let y = Scale { from: [0.0, largest as f64], to: [height - foot, head] };
    let mut text = begin(width, height, &format!("Histogram of {unit} over the {what}"));
    for tick in count_ticks(largest) {
        let place = y.at(tick as f64);
        level(&mut text, "axis", [left, right], place);
        // not beside the names of the lines, nor at the numbers below
        if (head + 13.0..height - foot - 8.0).contains(&place) {
            label(&mut text, [left - 6.0, place + 4.0], "end", "", &grouped(tick));
        }
    }
    for (edge, count) in edges.windows(2).zip(&histogram.counts) {
        let (left, right, top) = (x.at(edge[0]), x.at(edge[1]), y.at(*count as f64));
        let _ = writeln!(
            text,
            "<rect class=\"bar\" x=\"{:.1}\" y=\"{top:.1}\" width=\"{:.1}\" \
             height=\"{:.1}\"><title>{:.d$} to {:.d$}: {} {what}</title></rect>",
            left + 0.5,
            (right - left - 1.0).max(0.5),
            height - foot - top,
            edge[0],
            edge[1],
            grouped(*count),
            d = histogram.decimals,
        );
    }
    let marks = named_once(marks, x);
    for Mark { value, name, is_mean } in &marks {
        if !(x.from[0]..=x.from[1]).contains(value) {
            continue;
        }
        let place = x.at(*value);
        let (class, row) = if *is_mean { ("mark mean", 42.0) } else { ("mark", 14.0) };
        let _ = writeln!(
            text,
            "<line class=\"{class}\" x1=\"{place:.1}\" x2=\"{place:.1}\" y1=\"{}\" y2=\"{}\"/>",
            row + 6.0,
            height - foot
        );
        // on the side on which no other line is close
        let close = marks.iter().filter(|mark| !mark.is_mean).map(|mark| x.at(mark.value) - place);
        let nearest = close.min_by(|a, b| a.abs().total_cmp(&b.abs()));
        let (shift, anchor) = match nearest {
            Some(gap) if *is_mean && (0.0..60.0).contains(&gap) => (-5.0, "end"),
            Some(gap) if *is_mean && (-60.0..0.0).contains(&gap) => (5.0, "start"),
            _ => (0.0, "middle"),
        };
        label(&mut text, [place + shift, row], anchor, "", name);
    }
    let every = edges.len().div_ceil(9);
    for edge in edges.iter().skip(first_round(edges, every)).step_by(every) {
        let words = format!("{edge:.*}", histogram.decimals);
        label(&mut text, [x.at(*edge), height - 34.0], "middle", "", &words);
    }
    label(&mut text, [width / 2.0, height - 6.0], "middle", "", unit);
    text + "</svg>\n"
}

/// Bands of y over x: the middle of each tenth, and where its inner 80 % lie.
pub(super) fn bands(
    association: &Association,
    [what, name]: [&str; 2],
    factor: f64,
    y_range: [f64; 2],
) -> String {
    let (width, height, left, foot) = (320.0, 190.0, 40.0, 36.0);
    // by rank: tenths of a quantity that many cycles do not have at all would lie on top of one
    // another
    let all = association.bands.iter().map(|band| band.n).sum::<u64>() as f64;
    let mut before = 0.0;
    let xs: Vec<f64> = association
        .bands
        .iter()
        .map(|band| {
            let n = band.n as f64;
            before += n;
            (before - 0.5 * n) / all
        })
        .collect();
    let x = Scale { from: [0.0, 1.0], to: [left + 8.0, width - 12.0] };
    let y = Scale { from: y_range, to: [height - foot, 10.0] };
    let mut text = begin(width, height, &format!("{what} over {name}"));
    levels(&mut text, y, [left, width]);
    let places = |k: usize| {
        let bands = association.bands.iter().zip(&xs);
        bands.map(move |(band, at)| (x.at(*at), y.at(band.y[k])))
    };
    let outline = points(places(2).chain(places(0).rev()));
    let _ = writeln!(text, "<polygon class=\"band\" points=\"{outline}\"/>");
    let _ = writeln!(text, "<polyline class=\"line\" points=\"{}\"/>", points(places(1)));
    // records have K
    let zero = if name.ends_with("°C") { 273.15 } else { 0.0 };
    let value = |band: &Band| rounded_short(factor * f64::midpoint(band.x[0], band.x[1]) - zero);
    let last = association.bands.len() - 1;
    let middle = xs.partition_point(|at| *at < 0.5).min(last);
    // where the middle one lies beside an end, it has no room
    let has_room = |band: &usize| *band == 0 || *band == last || (0.25..0.75).contains(&xs[*band]);
    for band in [0, middle, last].into_iter().filter(has_room) {
        let words = value(&association.bands[band]);
        label(&mut text, [x.at(xs[band]), height - 20.0], "middle", "", &words);
    }
    label(&mut text, [f64::midpoint(left, width), height - 5.0], "middle", "name", name);
    text + "</svg>\n"
}

/// Horizontal bars of shares, each with its name and its text.
pub(super) fn bars(rows: &[(String, f64, String)], what: &str) -> String {
    let (width, step, left) = (720.0, 28.0, 250.0);
    let height = step * rows.len() as f64 + 6.0;
    let largest = rows.iter().map(|row| row.1.abs()).fold(0.0, f64::max).max(1e-12);
    let mut text = begin(width, height, what);
    for (k, (name, value, words)) in rows.iter().enumerate() {
        let top = step * k as f64 + 4.0;
        let length = (width - left - 264.0) * value.abs() / largest;
        label(&mut text, [left - 8.0, top + 15.0], "end", "name", name);
        let _ = writeln!(
            text,
            "<rect class=\"{}\" x=\"{left}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{}\"/>",
            if *value < 0.0 { "band" } else { "bar" },
            length.max(1.0),
            step - 8.0
        );
        label(&mut text, [left + length + 8.0, top + 15.0], "start", "", words);
    }
    text + "</svg>\n"
}

/// A number for an axis.
pub(super) fn rounded_short(value: f64) -> String {
    let text = rounded(value);
    match text.as_str() {
        // what rounds to nothing has no sign
        text if text.trim_start_matches(['-', '0', '.']).is_empty() => "0".to_owned(),
        text if text.contains('.') => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_histogram_counts_from_a_round_edge_and_close_marks_share_a_name() {
        let edges: Vec<f64> = (-3..16).map(|k| 0.01 * f64::from(k)).collect();
        assert_eq!(first_round(&edges, 3), 0);
        assert_eq!(first_round(&edges, 2), 1);
        assert_eq!(first_round(&[0.3, 1.3, 2.3], 2), 0);
        let x = Scale { from: [0.0, 100.0], to: [0.0, 100.0] };
        let mark = |value, name: &str| Mark::quantile(value, name.to_owned());
        let marks = [mark(0.0, "P5"), mark(20.0, "P50"), mark(90.0, "P95")];
        let names: Vec<String> = named_once(&marks, x).into_iter().map(|mark| mark.name).collect();
        assert_eq!(names, ["", "P5, P50", "P95"]);
    }

    #[test]
    fn levels_stand_at_round_numbers() {
        assert_eq!(round_within([31.7, 48.2]), [35.0, 40.0, 45.0]);
        assert_eq!(round_within([0.0, 100.0]), [0.0, 50.0, 100.0]);
        assert_eq!(round_within([-1.0, 1.0]), [-1.0, 0.0, 1.0]);
        assert_eq!(round_within([5.0, 5.0]), [5.0]);
        for span in 1..2000 {
            let count = round_within([0.37, 0.37 + f64::from(span) / 7.0]).len();
            assert!((1..=5).contains(&count), "{span}: {count}");
        }
    }
}
