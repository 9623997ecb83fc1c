//! The pictures of charging: a range curve, the state of charge over the distance, load curves, and
//! a waterfall, as SVG that takes its colours from the page.

use super::panel::Panel;
use super::svg::{self, begin, label, rounded_short};
use std::fmt::Write;

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 312.0;
/// Left, top, width and height of the panel within it.
const PANEL: [f64; 4] = [68.0, 26.0, 636.0, 224.0];

/// A step of a waterfall.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Step {
    pub(super) name: String,
    pub(super) change: f64,
}

/// Round numbers from 0 up to one.
fn ticks(end: f64) -> Vec<f64> {
    let step = svg::step(end);
    let last = (end * (1.0 + 1e-9) / step).floor() as u32;
    (0..=last).map(|k| f64::from(k) * step).collect()
}

fn words(ticks: Vec<f64>) -> Vec<(f64, String)> {
    ticks.into_iter().map(|tick| (tick, rounded_short(tick))).collect()
}

/// A band between two lines over x.
fn band(panel: &Panel, text: &mut String, points: &[(f64, [f64; 2])], class: &str) {
    let place = |x: f64, y: f64| (panel.x.at(x), panel.y.at(y));
    let upper = points.iter().map(|(x, [_, high])| place(*x, *high));
    let lower = points.iter().rev().map(|(x, [low, _])| place(*x, *low));
    let path = svg::points(upper.chain(lower));
    let _ = writeln!(text, "<polygon class=\"{class}\" points=\"{path}\"/>");
}

/// Shares in percent over km, with their intervals.
pub(super) fn range_curve(points: &[(f64, f64, [f64; 2])]) -> String {
    let end = points.last().map_or(1.0, |point| point.0).max(1.0);
    let panel = Panel::new([0.0, end], [0.0, 100.0], PANEL);
    let mut text = begin(WIDTH, HEIGHT, "Share of the trucks that are not empty over the distance");
    panel.across(&mut text, &[0.0, 25.0, 50.0, 75.0, 100.0], "trucks not empty, %");
    let point = |(km, _, ends): &(f64, f64, [f64; 2])| (*km, ends.map(|end| 100.0 * end));
    band(&panel, &mut text, &points.iter().map(point).collect::<Vec<_>>(), "band");
    let line = points.iter().map(|(km, share, _)| (*km, 100.0 * share));
    panel.line(&mut text, line, "class=\"line\"");
    panel.along_with_room(&mut text, &words(ticks(end)), "distance, km");
    text + "</svg>\n"
}

/// States of charge over km: P5, P50 and P95.
pub(super) fn state_of_charge(bands: &[(f64, [f64; 3])], reserve: Option<f64>) -> String {
    let end = bands.last().map_or(1.0, |band| band.0).max(1.0);
    let panel = Panel::new([0.0, end], [0.0, 100.0], PANEL);
    let mut text = begin(WIDTH, HEIGHT, "State of charge over the distance");
    panel.across(&mut text, &[0.0, 25.0, 50.0, 75.0, 100.0], "state of charge, %");
    let outer: Vec<(f64, [f64; 2])> =
        bands.iter().map(|(km, [low, _, high])| (*km, [100.0 * low, 100.0 * high])).collect();
    band(&panel, &mut text, &outer, "band");
    panel.line(&mut text, bands.iter().map(|(km, b)| (*km, 100.0 * b[1])), "class=\"line\"");
    if let Some(reserve) = reserve {
        let level = [(0.0, 100.0 * reserve), (end, 100.0 * reserve)];
        panel.line(&mut text, level, "class=\"mark\" stroke-dasharray=\"5 4\"");
    }
    panel.along_with_room(&mut text, &words(ticks(end)), "distance, km");
    text + "</svg>\n"
}

/// Powers of the quarters of an hour of a day, in kW: median, mean, P95 and highest.
pub(super) fn load_curve(rows: &[[f64; 4]], name: &str) -> String {
    let top = rows.iter().map(|row| row[2].max(row[1])).fold(0.0, f64::max).max(1e-3);
    let numbers = ticks(1.25 * top);
    let most = numbers.last().copied().unwrap_or(top).max(top);
    let panel = Panel::new([0.0, 24.0], [0.0, most], PANEL);
    let mut text = begin(WIDTH, HEIGHT, &format!("Power of {name} over the day"));
    panel.across(&mut text, &numbers, &format!("{name}, kW"));
    // each quarter is level
    let hours = |k: usize| [k, k + 1].map(|k| k as f64 / 4.0);
    let outer =
        rows.iter().enumerate().flat_map(|(k, row)| hours(k).map(|h| (h, [row[0], row[2]])));
    band(&panel, &mut text, &outer.collect::<Vec<_>>(), "band");
    let mean = rows.iter().enumerate().flat_map(|(k, row)| hours(k).map(|h| (h, row[1])));
    panel.line(&mut text, mean, "class=\"line\"");
    let hours: Vec<(f64, String)> =
        (0..=4).map(|k| (6.0 * f64::from(k), format!("{}:00", 6 * k))).collect();
    panel.along_with_room(&mut text, &hours, "time of the day");
    text + "</svg>\n"
}

/// From one value to another by steps.
pub(super) fn waterfall([from, to]: [f64; 2], steps: &[Step]) -> String {
    let (row, left, right) = (28.0, 216.0, 552.0);
    let height = row * (steps.len() + 2) as f64 + 8.0;
    let mut level = from;
    let mut levels = vec![from, to];
    levels.extend(steps.iter().map(|step| {
        level += step.change;
        level
    }));
    let high = levels.iter().copied().fold(0.0, f64::max);
    let x = super::svg::Scale { from: [0.0, high], to: [left, right] };
    let mut text = begin(WIDTH, height, "Consumption from summer to winter by kinds of loss");
    let mut bar = |k: usize, name: &str, ends: [f64; 2], class: &str, words: &str| {
        let top = row * k as f64 + 4.0;
        let [begin, end] = [ends[0].min(ends[1]), ends[0].max(ends[1])].map(|value| x.at(value));
        label(&mut text, [left - 8.0, top + 15.0], "end", "name", name);
        let _ = writeln!(
            text,
            "<rect class=\"{class}\" x=\"{begin:.1}\" y=\"{top:.1}\" width=\"{:.1}\" \
             height=\"{}\"/>",
            (end - begin).max(1.0),
            row - 8.0
        );
        label(&mut text, [end + 8.0, top + 15.0], "start", "", words);
    };
    bar(0, "summer", [0.0, from], "bar", &format!("{from:.3} kWh/km"));
    let mut level = from;
    for (k, step) in steps.iter().enumerate() {
        let ends = [level, level + step.change];
        let class = if step.change < 0.0 { "band" } else { "mark-bar" };
        bar(k + 1, &step.name, ends, class, &format!("{:+.3}", step.change));
        level = ends[1];
    }
    bar(steps.len() + 1, "winter", [0.0, to], "bar", &format!("{to:.3} kWh/km"));
    text + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_round_numbers() {
        assert_eq!(ticks(500.0), [0.0, 100.0, 200.0, 300.0, 400.0, 500.0]);
        assert_eq!(ticks(1.1), [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]);
        assert!(ticks(1234.0).len() < 9);
    }

    #[test]
    fn pictures_hold_numbers_alone() {
        let steps = [0.1, -0.04].map(|change| Step { name: "drag".to_owned(), change });
        let pictures = [
            range_curve(&[(0.0, 1.0, [1.0; 2]), (400.0, 0.6, [0.5, 0.7])]),
            state_of_charge(&[(0.0, [0.9; 3]), (300.0, [0.2, 0.4, 0.5])], Some(0.15)),
            load_curve(&vec![[0.0, 10.0, 30.0, 60.0]; 96], "depots"),
            waterfall([1.1, 1.16], &steps),
        ];
        for picture in pictures {
            assert!(!picture.contains("NaN") && !picture.contains("inf"), "{picture}");
            assert!(picture.contains("</svg>"));
        }
        let waterfall = waterfall([1.1, 1.16], &steps);
        assert!(waterfall.contains("-0.040"));
        // bars begin at zero: their lengths are as the values
        let bars = waterfall.split("class=\"bar\"").skip(1);
        let widths = bars.map(|bar| {
            let width = bar.split("width=\"").nth(1).and_then(|text| text.split('"').next());
            width.and_then(|text| text.parse::<f64>().ok()).expect("a width")
        });
        let widths: Vec<f64> = widths.collect();
        assert!((widths[1] / widths[0] - 1.16 / 1.1).abs() < 1e-3, "{widths:?}");
    }
}
