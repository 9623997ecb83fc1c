//! A panel of a picture: two axes, and what is drawn between them, as SVG.

use super::svg::{Scale, escaped, label, points, rounded_short};
use std::fmt::Write;

/// Colours of up to eight drivers, which a colour-blind reader tells apart, on white and on black.
/// Source: Okabe and Ito (2008), Color universal design, but for the last two.
pub(super) const COLOURS: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6bb1", "#8a8a8a"];

/// The colour of a driver, from 0.
pub(super) fn colour(driver: usize) -> &'static str {
    COLOURS[driver % COLOURS.len()]
}

/// Mark at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    Circle,
    Cross,
    Dot,
}

/// Two axes and what is drawn between them.
#[derive(Clone, Copy)]
pub(super) struct Panel {
    pub(super) x: Scale,
    pub(super) y: Scale,
}

impl Panel {
    /// A panel of these values, at left, top, width and height.
    pub(super) fn new(x: [f64; 2], y: [f64; 2], [left, top, width, height]: [f64; 4]) -> Self {
        Self {
            x: Scale { from: x, to: [left, left + width] },
            y: Scale { from: y, to: [top + height, top] },
        }
    }

    /// Lines across at values of y, with their numbers, and what they count.
    pub(super) fn across(&self, text: &mut String, ticks: &[f64], name: &str) {
        let [left, right] = self.x.to;
        for tick in ticks {
            let y = self.y.at(*tick);
            let _ = writeln!(
                text,
                "<line class=\"axis\" x1=\"{left:.1}\" x2=\"{right:.1}\" y1=\"{y:.1}\" \
                 y2=\"{y:.1}\"/>"
            );
            label(text, [left - 6.0, y + 4.0], "end", "", &rounded_short(*tick));
        }
        label(text, [left, self.y.to[1] - 6.0], "start", "name", name);
    }

    /// Words below places of x, and what they are.
    pub(super) fn along(&self, text: &mut String, ticks: &[(f64, String)], name: &str) {
        self.below(text, ticks, name, [15.0, 31.0]);
    }

    /// The same with room for the large letters of narrow screens, and without a first place at the
    /// axis of y, which has words of its own there.
    pub(super) fn along_with_room(&self, text: &mut String, ticks: &[(f64, String)], name: &str) {
        let at_axis = usize::from(ticks.first().is_some_and(|tick| tick.0 <= self.x.from[0]));
        self.below(text, &ticks[at_axis..], name, [21.0, 49.0]);
    }

    /// Words and the name so far below the panel.
    fn below(&self, text: &mut String, ticks: &[(f64, String)], name: &str, [near, far]: [f64; 2]) {
        let bottom = self.y.to[0];
        for (tick, words) in ticks {
            let place = self.x.at(*tick);
            // within the picture at its right edge
            let anchor = if place > self.x.to[1] - 4.0 { "end" } else { "middle" };
            label(text, [place, bottom + near], anchor, "", words);
        }
        let middle = f64::midpoint(self.x.to[0], self.x.to[1]);
        label(text, [middle, bottom + far], "middle", "name", name);
    }

    /// A line through points; those that are no numbers are left out.
    pub(super) fn line(
        &self,
        text: &mut String,
        points: impl IntoIterator<Item = (f64, f64)>,
        how: &str,
    ) {
        let known = points.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite());
        let path = self.path(known);
        let _ = writeln!(text, "<polyline fill=\"none\" {how} points=\"{path}\"/>");
    }

    /// Area between points and 0; they are numbers, from left to right.
    pub(super) fn area(
        &self,
        text: &mut String,
        points: impl IntoIterator<Item = (f64, f64)>,
        how: &str,
    ) {
        let line: Vec<(f64, f64)> = points.into_iter().collect();
        let ([(first, _), ..], [.., (last, _)]) = (&line[..], &line[..]) else { return };
        let ground = |x: &f64| std::iter::once((*x, 0.0));
        let path = self.path(ground(first).chain(line.iter().copied()).chain(ground(last)));
        let _ = writeln!(text, "<polygon {how} points=\"{path}\"/>");
    }

    /// Places of a picture, one behind the other.
    fn path(&self, line: impl Iterator<Item = (f64, f64)>) -> String {
        points(line.map(|(x, y)| (self.x.at(x), self.y.at(self.within(y)))))
    }

    /// A mark at a point, with a title.
    pub(super) fn mark(
        &self,
        text: &mut String,
        (x, y): (f64, f64),
        mark: Mark,
        colour: &str,
        title: &str,
    ) {
        if !(x.is_finite() && y.is_finite()) {
            return;
        }
        let (x, y, title) = (self.x.at(x), self.y.at(self.within(y)), escaped(title));
        let _ = match mark {
            Mark::Circle => writeln!(
                text,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"none\" stroke=\"{colour}\" \
                 stroke-width=\"1.6\"><title>{title}</title></circle>"
            ),
            Mark::Dot => writeln!(
                text,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\" \
                 fill=\"{colour}\"><title>{title}</title></circle>"
            ),
            Mark::Cross => writeln!(
                text,
                "<path d=\"M{:.1} {y:.1}h9M{x:.1} {:.1}v9\" stroke=\"{colour}\" \
                 stroke-width=\"1.8\"><title>{title}</title></path>",
                x - 4.5,
                y - 4.5
            ),
        };
    }

    /// A filled stretch, within the panel.
    pub(super) fn filled(&self, text: &mut String, x: [f64; 2], y: [f64; 2], how: &str) {
        if y.iter().any(|y| y.is_nan()) {
            return;
        }
        let [left, right] = x.map(|x| self.x.at(x.clamp(self.x.from[0], self.x.from[1])));
        let [bottom, top] = y.map(|y| self.y.at(self.within(y)));
        let _ = writeln!(
            text,
            "<rect {how} x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
            right - left,
            (bottom - top).max(0.6)
        );
    }

    /// Clamps a value outside the panel to its edge.
    fn within(&self, y: f64) -> f64 {
        y.clamp(self.y.from[0], self.y.from[1])
    }
}
