//! Coverage of a road by its source: all tracks of a cycle, and of a measured log what its columns
//! hold.

use serde::Serialize;

/// Tracks write a turn at the position of its event; a curve that begins elsewhere is none.
const TURN_WITHIN_M: f64 = 0.01;

/// Parts of a road that are known. A part that is not known is not absent: it may not be counted as
/// zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Coverage {
    /// Speed limits.
    pub signs: bool,
    /// Point events with their kinds.
    pub events: bool,
    /// Slopes.
    pub slopes: bool,
    /// Curves.
    pub curves: CurveCoverage,
    /// A curve that begins this close to an event is a turn at it, in m.
    pub turn_within_m: f64,
    /// Stops of the mission that are shorter than this are not known, in s.
    pub mission_stop_s: f64,
}

/// Spans of one road in which something is not known that its source determines elsewhere; from and
/// to, in m, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UnobservedSpans {
    /// Without slope.
    pub slope_m: Vec<[f64; 2]>,
    /// Without anything that determines curves.
    pub curves_m: Vec<[f64; 2]>,
}

/// Curves that are known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CurveCoverage {
    /// None.
    None,
    /// All.
    All,
    /// Curves within a window; the others are there and not seen.
    Within(CurveWindow),
}

/// The curves that a detector sees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CurveWindow {
    /// Smallest and largest radius, in m.
    pub radius_m: [f64; 2],
    /// Shortest curve, in m.
    pub shortest_m: f64,
    /// Smallest heading change, in rad.
    pub smallest_turn_rad: f64,
}

impl Coverage {
    /// Everything, as the tracks of an operating cycle do.
    pub const ALL: Self = Self {
        signs: true,
        events: true,
        slopes: true,
        curves: CurveCoverage::All,
        turn_within_m: TURN_WITHIN_M,
        mission_stop_s: 0.0,
    };

    /// Coverage that roads of two sources share. Signs, slopes and curves that one of them does not
    /// know are left out road by road ([`UnobservedSpans`]); events count where both know them.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self {
            signs: self.signs || other.signs,
            events: self.events && other.events,
            slopes: self.slopes || other.slopes,
            curves: self.curves.with(other.curves),
            turn_within_m: self.turn_within_m.max(other.turn_within_m),
            mission_stop_s: self.mission_stop_s.max(other.mission_stop_s),
        }
    }
}

impl CurveCoverage {
    fn with(self, other: Self) -> Self {
        match (self, other) {
            (Self::Within(a), Self::Within(b)) => Self::Within(CurveWindow {
                radius_m: [a.radius_m[0].max(b.radius_m[0]), a.radius_m[1].min(b.radius_m[1])],
                shortest_m: a.shortest_m.max(b.shortest_m),
                smallest_turn_rad: a.smallest_turn_rad.max(b.smallest_turn_rad),
            }),
            (known @ Self::Within(_), _) | (_, known @ Self::Within(_)) => known,
            (Self::All, _) | (_, Self::All) => Self::All,
            (Self::None, Self::None) => Self::None,
        }
    }
}

/// The part of a span, in m, that lies within other spans.
pub fn overlap_m(ways: &[[f64; 2]], from_m: f64, to_m: f64) -> f64 {
    ways.iter().map(|[from, to]| (to.min(to_m) - from.max(from_m)).max(0.0)).sum()
}

impl CurveWindow {
    /// Whether a curve of this radius, in m, and length, in m, is seen.
    pub fn sees(&self, radius_m: f64, length_m: f64) -> bool {
        (self.radius_m[0]..=self.radius_m[1]).contains(&radius_m)
            && length_m >= self.least_length_m(radius_m)
    }

    /// Length from which on a curve of this radius is seen, in m.
    pub fn least_length_m(&self, radius_m: f64) -> f64 {
        self.shortest_m.max(self.smallest_turn_rad * radius_m)
    }
}
