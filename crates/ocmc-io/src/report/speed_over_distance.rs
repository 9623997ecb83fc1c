//! The picture of drives over simulated ones: speed over distance, with the bands of the trips.

use super::svg::{Scale, begin, escaped, label, level, points, rounded_short};
use std::fmt::Write;

/// Metres a second in kilometres an hour.
const KMH: f64 = 3.6;
/// Most drives that are drawn: more cannot be told apart.
const MOST_DRAWN: usize = 12;
/// Most points of a line.
const MOST_POINTS: usize = 500;
/// Style of a picture that stands alone and takes none from a page.
const STYLE: &str = "<style>text{fill:#5b6570;font:12px sans-serif}.band{fill:#9fc3e6}\
                     .inner{fill:#5f9bd4}.line{fill:none;stroke:#1f4e80;stroke-width:1.5}\
                     .mark{fill:none;stroke:#b3452f;stroke-width:1.5}.axis{stroke:#d6dbe1}\
                     .limit{fill:none;stroke:#5b6570;stroke-dasharray:4 3}\
                     svg{background:#fff}.name{fill:#1b1f24}.bar{fill:#2f6fb3}</style>";

/// The drives on one road.
#[derive(Clone, Debug, PartialEq)]
pub struct RoadPicture {
    /// Name of the road.
    pub name: String,
    /// Places, in m.
    pub position_m: Vec<f64>,
    /// Speeds of 5, 25, 50, 75 and 95 % of the trips there, in m/s.
    pub bands_mps: Vec<[f64; 5]>,
    /// Where limits begin, in m, and the limits, in m/s.
    pub limits_mps: Vec<(f64, f64)>,
    /// The drives: name, and speed at each place, NaN where it was not.
    pub drives: Vec<(String, Vec<f64>)>,
}

impl RoadPicture {
    /// Where the road ends that is shown, in m.
    fn end_m(&self) -> f64 {
        self.position_m.last().copied().unwrap_or(1.0)
    }

    /// The limit at a position, in m/s.
    pub fn limit_mps(&self, at_m: f64) -> f64 {
        let k = self.limits_mps.partition_point(|limit| limit.0 <= at_m);
        self.limits_mps.get(k.saturating_sub(1)).map_or(f64::NAN, |limit| limit.1)
    }

    /// As SVG that takes its colours from the page.
    pub(super) fn svg(&self) -> String {
        let (width, height, left, foot) = (960.0, 320.0, 44.0, 40.0);
        let drawn = &self.drives[..self.drives.len().min(MOST_DRAWN)];
        let speeds = self.bands_mps.iter().flatten().chain(drawn.iter().flat_map(|d| &d.1));
        let limits = self.limits_mps.iter().map(|limit| limit.1);
        let fastest = speeds.copied().chain(limits).filter(|v| v.is_finite()).fold(0.0, f64::max);
        let top_kmh = (KMH * fastest / 20.0).ceil().max(1.0) * 20.0;
        let x = Scale { from: [0.0, self.end_m()], to: [left, width - 10.0] };
        let y = Scale { from: [0.0, top_kmh], to: [height - foot, 12.0] };
        let mut text = begin(width, height, &format!("Speed over distance: {}", self.name));
        let mut tick_kmh = 0.0;
        while tick_kmh <= top_kmh {
            let place = y.at(tick_kmh);
            let _ = writeln!(
                text,
                "<line class=\"axis\" x1=\"{left}\" x2=\"{:.1}\" y1=\"{place:.1}\" \
                 y2=\"{place:.1}\"/>",
                width - 10.0
            );
            label(&mut text, [left - 6.0, place + 4.0], "end", "", &format!("{tick_kmh:.0}"));
            tick_kmh += 20.0;
        }
        let step_m = tick_step(self.end_m());
        for tick in 0..=(self.end_m() / step_m).floor() as usize {
            let at_m = tick as f64 * step_m;
            let words = rounded_short(at_m / 1000.0);
            label(&mut text, [x.at(at_m), height - 24.0], "middle", "", &words);
        }
        for (class, low, high) in [("band", 0, 4), ("inner", 1, 3)] {
            let there = |k: &usize| self.bands_mps[*k].iter().all(|v| v.is_finite());
            let places: Vec<usize> = self.shown().filter(there).collect();
            let point = |k: &usize, level: usize| {
                (x.at(self.position_m[*k]), y.at(KMH * self.bands_mps[*k][level]))
            };
            let back = places.iter().rev().map(|k| point(k, low));
            let outline = points(places.iter().map(|k| point(k, high)).chain(back));
            let _ = writeln!(text, "<polygon class=\"{class}\" points=\"{outline}\"/>");
        }
        let line = |values: &dyn Fn(usize) -> f64| {
            let all = self.shown().map(|k| (x.at(self.position_m[k]), y.at(KMH * values(k))));
            points(all.filter(|point| point.1.is_finite()))
        };
        let mut draw = |class: &str, line: String, title: &str| {
            let title = escaped(title);
            let _ = writeln!(
                text,
                "<polyline class=\"{class}\" points=\"{line}\"><title>{title}</title></polyline>"
            );
        };
        draw("limit", line(&|k| self.limit_mps(self.position_m[k])), "limit");
        draw("line", line(&|k| self.bands_mps[k][2]), "median of the trips");
        for (name, speeds) in drawn {
            draw("mark", line(&|k| speeds[k]), name);
        }
        label(&mut text, [width / 2.0, height - 6.0], "middle", "name", "km");
        label(&mut text, [left + 4.0, 10.0], "start", "name", "km/h");
        text + "</svg>\n"
    }

    /// As SVG that stands alone.
    pub fn standalone(&self) -> String {
        standalone(&self.svg())
    }

    /// The places that are drawn.
    fn shown(&self) -> impl DoubleEndedIterator<Item = usize> + '_ {
        let every = self.position_m.len().div_ceil(MOST_POINTS).max(1);
        (0..self.position_m.len()).step_by(every)
    }
}

/// A picture of a page as SVG that stands alone.
pub(super) fn standalone(svg: &str) -> String {
    let (open, rest) = svg.split_once('>').unwrap_or((svg, ""));
    let open = open.replacen("<svg", "<svg xmlns=\"http://www.w3.org/2000/svg\"", 1);
    format!("{open}>\n{STYLE}{rest}")
}

/// A histogram of ranks in tenths over what uniform ranks would give.
pub(super) fn ranks(counts: &[u64], name: &str) -> String {
    let (width, height, foot) = (320.0, 150.0, 34.0);
    let all: u64 = counts.iter().sum();
    let even = all as f64 / counts.len() as f64;
    let largest = counts.iter().copied().max().unwrap_or(0) as f64;
    let x = Scale { from: [0.0, 1.0], to: [10.0, width - 10.0] };
    let y = Scale { from: [0.0, largest.max(2.0 * even).max(1.0)], to: [height - foot, 6.0] };
    let mut text = begin(width, height, &format!("Ranks of {name} in tenths"));
    for (k, count) in counts.iter().enumerate() {
        let edge = |k: usize| x.at(k as f64 / counts.len() as f64);
        let top = y.at(*count as f64);
        let _ = writeln!(
            text,
            "<rect class=\"bar\" x=\"{:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
            edge(k) + 0.5,
            edge(k + 1) - edge(k) - 1.0,
            height - foot - top
        );
    }
    level(&mut text, "mark", [10.0, width - 10.0], y.at(even));
    for (at, words) in [(0.0, "0"), (0.5, "0.5"), (1.0, "1")] {
        label(&mut text, [x.at(at), height - 18.0], "middle", "", words);
    }
    label(&mut text, [width / 2.0, height - 3.0], "middle", "name", "rank among the trips");
    text + "</svg>\n"
}

/// Distance of the labels along a way, in m: 1, 2 or 5 times a power of ten, four to ten of them.
fn tick_step(length_m: f64) -> f64 {
    let power = 10f64.powf((length_m.max(1.0) / 4.0).log10().floor());
    let fits = |times: &&f64| *times * power * 4.0 <= length_m;
    [5.0, 2.0, 1.0].iter().find(fits).copied().unwrap_or(1.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_stand_at_round_places() {
        for (length_m, step_m) in [(8000.0, 2000.0), (400.0, 100.0), (108_000.0, 20_000.0)] {
            assert_eq!(tick_step(length_m), step_m);
        }
    }

    #[test]
    fn a_picture_holds_no_number_that_is_none() {
        let picture = RoadPicture {
            name: "a < b".to_owned(),
            position_m: vec![10.0, 20.0, 30.0],
            bands_mps: vec![[1.0, 2.0, 3.0, 4.0, 5.0], [f64::NAN; 5], [2.0, 3.0, 4.0, 5.0, 6.0]],
            limits_mps: vec![(0.0, 13.9), (25.0, 8.3)],
            drives: vec![("c & d".to_owned(), vec![f64::NAN, 3.0, 4.0])],
        };
        let svg = picture.standalone();
        assert!(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\""));
        assert!(!svg.contains("NaN") && svg.contains("a &lt; b") && svg.contains("c &amp; d"));
        assert_eq!((picture.limit_mps(24.0), picture.limit_mps(25.0)), (13.9, 8.3));
    }
}
