//! The road between points that are far apart.
//!
//! Points that are farther apart than curvature is averaged over (45 m) tell how much a road turns
//! near each of them and not how sharply. As a chain of chords it would turn at its points only, so
//! that each became a sharp curve. The turn of such a point is spread instead: an arc touches both
//! edges, a share of the shorter one away from the point, at most in proportion to the turns at
//! both ends of an edge, so that the arcs of a bend that is several chords long have about one
//! radius.
//!
//! A point that turns by more than 45° while the points beside it do not turn along with it is a
//! corner, as at a junction, and stays one: of a bend with one radius the points within turn alike.
//!
//! Where arcs of half the edges would have a radius of 600 m or more, they are these: such a bend
//! limits nobody, and a sharper one would. The share of [`Rounding::LIKELY`] is the one for which
//! the consumption on random roads with radii of 50 to 2000 m, thinned by 1 to 20 m or to a point
//! each 50 to 500 m, came out nearest to that of the whole road (`scripts/thinned_roads.py`).

/// Points with a shorter edge stay as they are, in m: curvature is averaged over so much.
const SHORT_M: f64 = 45.0;
/// Turns that are not worth an arc, in rad: averaged over 45 m they have a radius of 4500 m.
const STRAIGHT_RAD: f64 = 0.01;
/// Turns about which no arc is laid, in rad: the way goes back.
const BACK_RAD: f64 = 2.6;
/// Turn that the points beside one need along with it, over its own turn, for a bend.
const ALONG: f64 = 0.5;
/// Points beside one count that are not farther away than the nearer one, times this.
const NEAR: f64 = 1.5;
/// Steps along an arc, in m.
const STEP_M: f64 = 5.0;

/// How the turns of points that are far apart are spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounding {
    /// From a point to where its arc begins, over the shorter edge; at most 0.5.
    pub share: f64,
    /// Turn from which on a point without company is a corner, in rad.
    pub corner_rad: f64,
    /// Radii of arcs over half the edges between which the share grows to 0.5, in m.
    pub wide_m: [f64; 2],
}

impl Rounding {
    /// The likeliest one.
    pub const LIKELY: Self =
        Self { share: 0.32, corner_rad: std::f64::consts::FRAC_PI_4, wide_m: [500.0, 600.0] };
    /// Sharper bends, which may be hidden between the points.
    pub const SHARP: Self = Self { share: 0.2, ..Self::LIKELY };
    /// The widest bends that the points allow: only turns of more than 60° are corners for certain.
    pub const WIDE: Self =
        Self { share: 0.5, corner_rad: std::f64::consts::FRAC_PI_3, ..Self::LIKELY };
    /// The likeliest ones where no point is a corner.
    pub const BENDS: Self = Self { corner_rad: std::f64::consts::PI, ..Self::LIKELY };
}

/// Points on a plane with rounded bends.
#[derive(Clone, Debug)]
pub struct RoundedPath {
    /// To the east, in m.
    pub x_m: Vec<f64>,
    /// To the north, in m.
    pub y_m: Vec<f64>,
    /// Index of the point that each given one became: of an arc, its middle.
    pub given: Vec<usize>,
    /// How many points were rounded.
    pub rounded: usize,
}

/// Turn at each point, in rad, to the left, and the length of each edge, in m.
pub fn turns(x_m: &[f64], y_m: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let edge = |k: usize| (x_m[k + 1] - x_m[k], y_m[k + 1] - y_m[k]);
    let edges: Vec<(f64, f64)> = (0..x_m.len().saturating_sub(1)).map(edge).collect();
    let lengths_m = edges.iter().map(|(dx, dy)| libm::hypot(*dx, *dy)).collect();
    let mut turns = vec![0.0; x_m.len()];
    for (k, pair) in edges.windows(2).enumerate() {
        let [(ax, ay), (bx, by)] = [pair[0], pair[1]];
        turns[k + 1] = libm::atan2(ax * by - ay * bx, ax * bx + ay * by);
    }
    (turns, lengths_m)
}

/// Rounds the bends of points that are far apart.
pub fn rounded(x_m: &[f64], y_m: &[f64], how: Rounding) -> RoundedPath {
    let (turns, lengths_m) = turns(x_m, y_m);
    let mut path = RoundedPath {
        x_m: Vec::with_capacity(x_m.len()),
        y_m: Vec::with_capacity(x_m.len()),
        given: Vec::with_capacity(x_m.len()),
        rounded: 0,
    };
    for k in 0..x_m.len() {
        let Some(tangent_m) = tangent_m(k, &turns, &lengths_m, how) else {
            path.given.push(path.x_m.len());
            path.push(x_m[k], y_m[k]);
            continue;
        };
        let (back_x, back_y) = (x_m[k - 1] - x_m[k], y_m[k - 1] - y_m[k]);
        let share = tangent_m / lengths_m[k - 1];
        let from = [x_m[k] + share * back_x, y_m[k] + share * back_y];
        path.arc(from, libm::atan2(-back_y, -back_x), turns[k], tangent_m);
    }
    path
}

/// From a point to where its arc begins, in m; none of a point that stays.
fn tangent_m(k: usize, turns: &[f64], lengths_m: &[f64], how: Rounding) -> Option<f64> {
    if k == 0 || k + 1 >= turns.len() {
        return None;
    }
    let (turn, [before_m, after_m]) = (turns[k].abs(), [lengths_m[k - 1], lengths_m[k]]);
    let short_m = before_m.min(after_m);
    if short_m <= SHORT_M || !(STRAIGHT_RAD..=BACK_RAD).contains(&turn) {
        return None;
    }
    if turn > how.corner_rad && stands_alone(k, turns, lengths_m) {
        return None;
    }
    let [from_m, to_m] = how.wide_m;
    let widest_m = 0.5 * short_m / libm::tan(0.5 * turn);
    let wide = ((widest_m - from_m) / (to_m - from_m)).clamp(0.0, 1.0);
    let share = how.share + wide * (0.5 - how.share);
    let part = |n: usize| share.min(turn / (turn + turns[n].abs()));
    Some((before_m * part(k - 1)).min(after_m * part(k + 1)))
}

/// Whether the points beside one do not turn along with it.
fn stands_alone(k: usize, turns: &[f64], lengths_m: &[f64]) -> bool {
    let beside = [(k - 1, lengths_m[k - 1]), (k + 1, lengths_m[k])];
    let most_m = NEAR * lengths_m[k - 1].min(lengths_m[k]);
    let near = beside.into_iter().filter(|(_, length_m)| *length_m <= most_m);
    let along: f64 = near.map(|(n, _)| (turns[n] * turns[k].signum()).max(0.0)).sum();
    along < ALONG * turns[k].abs()
}

/// The points that are corners for certain: that turn by more than 60°, alone, between long edges.
pub fn corners(turns: &[f64], lengths_m: &[f64]) -> Vec<usize> {
    let is_corner = |k: &usize| {
        turns[*k].abs() > Rounding::WIDE.corner_rad
            && lengths_m[k - 1].min(lengths_m[*k]) > SHORT_M
            && stands_alone(*k, turns, lengths_m)
    };
    (1..lengths_m.len()).filter(is_corner).collect()
}

impl RoundedPath {
    fn push(&mut self, x_m: f64, y_m: f64) {
        self.x_m.push(x_m);
        self.y_m.push(y_m);
    }

    /// Adds an arc that begins at a point with a heading, in rad from the x-axis.
    fn arc(&mut self, [x_m, y_m]: [f64; 2], heading: f64, turn: f64, tangent_m: f64) {
        let radius_m = tangent_m / libm::tan(0.5 * turn);
        let pieces = libm::ceil(radius_m * turn / STEP_M).max(2.0) as usize;
        let pieces = pieces + pieces % 2;
        let (cx, cy) = (x_m - radius_m * libm::sin(heading), y_m + radius_m * libm::cos(heading));
        let first = self.x_m.len();
        for piece in 0..=pieces {
            let at = heading + turn * piece as f64 / pieces as f64;
            self.push(cx + radius_m * libm::sin(at), cy - radius_m * libm::cos(at));
        }
        self.given.push(first + pieces / 2);
        self.rounded += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(turns_deg: &[f64], edge_m: f64) -> (Vec<f64>, Vec<f64>) {
        let (mut x, mut y, mut heading) = (vec![0.0], vec![0.0], 0.0);
        for turn in std::iter::once(&0.0).chain(turns_deg) {
            heading += f64::to_radians(*turn);
            x.push(x[x.len() - 1] + edge_m * libm::cos(heading));
            y.push(y[y.len() - 1] + edge_m * libm::sin(heading));
        }
        (x, y)
    }

    #[test]
    fn a_bend_of_chords_gets_about_its_radius() {
        // chords of 100 m of a bend of 300 m radius turn by 19° each
        let turn = 2.0 * libm::asin(50.0_f64 / 300.0).to_degrees();
        let (x, y) = chain(&[0.5 * turn, turn, turn, turn, 0.5 * turn], 100.0);
        let path = rounded(&x, &y, Rounding::WIDE);
        assert_eq!((path.rounded, path.given.len()), (5, x.len()));
        let middle = path.given[3];
        let (turns, lengths) = turns(&path.x_m, &path.y_m);
        let radius_m = lengths[middle] / turns[middle];
        assert!((radius_m / 300.0 - 1.0).abs() < 0.05, "{radius_m}");
        // no turn is lost
        let total: f64 = turns.iter().sum();
        assert!((total.to_degrees() - 4.0 * turn).abs() < 1e-6);
    }

    #[test]
    fn corners_and_short_edges_stay() {
        let (x, y) = chain(&[0.0, 90.0, 0.0], 300.0);
        assert_eq!(rounded(&x, &y, Rounding::LIKELY).rounded, 0);
        assert_eq!(rounded(&x, &y, Rounding::WIDE).rounded, 0);
        assert_eq!(rounded(&x, &y, Rounding::BENDS).rounded, 1);
        let (turns, lengths_m) = turns(&x, &y);
        assert_eq!(corners(&turns, &lengths_m), [2]);
        let (x, y) = chain(&[0.0, 50.0, 0.0], 300.0);
        assert_eq!(rounded(&x, &y, Rounding::LIKELY).rounded, 0);
        assert_eq!(rounded(&x, &y, Rounding::WIDE).rounded, 1);
        let (x, y) = chain(&[20.0, 20.0], 40.0);
        assert_eq!(rounded(&x, &y, Rounding::LIKELY).rounded, 0);
        let (x, y) = chain(&[180.0], 300.0);
        assert_eq!(rounded(&x, &y, Rounding::WIDE).rounded, 0);
    }
}
