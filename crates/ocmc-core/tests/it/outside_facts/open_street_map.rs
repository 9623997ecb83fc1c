//! Main roads of an OpenStreetMap extract, and their curvature.
//!
//! © OpenStreetMap contributors, ODbL 1.0. The data are not part of this project: they are read
//! from `OCMC_DATA`, or from `../shared/data` beside the checkout.

use super::curve_detector::STEP_M;
use crate::others_data::shared;
use flate2::read::GzDecoder;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;

/// Limit in km/h where there is no sign, and where it is unknown.
const NO_LIMIT: f64 = f64::INFINITY;
const UNKNOWN: f64 = f64::NAN;

/// One way, or several that continue one another.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    /// Node at each point.
    nodes: Vec<u64>,
    /// Position of each point, in m to the east and north.
    points: Vec<[f64; 2]>,
    /// Limit from each point to the next, in km/h.
    limits: Vec<f64>,
    /// Values that have to be equal for two ways to be one road.
    road: (String, String, bool),
}

/// A road on steps of [`STEP_M`].
#[derive(Default)]
pub(crate) struct Profile {
    /// Position to the east, in m.
    pub(crate) x: Vec<f64>,
    /// Position to the north, in m.
    pub(crate) y: Vec<f64>,
    /// Limit, in km/h.
    pub(crate) limit_kmh: Vec<f64>,
}

/// The file of the extract; none where the data are absent.
pub(crate) fn extract() -> Option<PathBuf> {
    shared("roads/osm_testfeld_nds_main_roads.csv.gz")
}

/// Reads the ways of the extract, roundabouts left out.
pub(crate) fn read(file: PathBuf) -> Vec<Line> {
    let reader = BufReader::new(GzDecoder::new(File::open(file).unwrap()));
    let mut ways: Vec<(String, Line)> = Vec::new();
    for row in reader.lines().skip(1) {
        let row = row.unwrap();
        let field: Vec<&str> = row.split(',').collect();
        let [id, highway, name, limit, oneway, junction, _lanes, _seq, node, lat, lon] = field[..]
        else {
            panic!("a row of eleven columns: {row}");
        };
        if !junction.is_empty() {
            continue;
        }
        if ways.last().is_none_or(|(last, _)| last != id) {
            let road = (highway.to_owned(), name.to_owned(), oneway == "yes");
            let line = Line { nodes: vec![], points: vec![], limits: vec![], road };
            ways.push((id.to_owned(), line));
        }
        let line = &mut ways.last_mut().unwrap().1;
        line.nodes.push(node.parse().unwrap());
        line.points.push(metres(lat.parse().unwrap(), lon.parse().unwrap()));
        line.limits.push(match limit {
            "none" => NO_LIMIT,
            "DE:urban" => 50.0,
            other => other.parse().unwrap_or(UNKNOWN),
        });
    }
    // a way that leaves the extract at once has one point only
    ways.into_iter().map(|(_, line)| line).filter(|line| line.points.len() > 1).collect()
}

/// Local metres: equirectangular around the middle of the extract, 52.4° N (scale right to 1 %).
fn metres(latitude: f64, longitude: f64) -> [f64; 2] {
    let degree = 6_371_008.8 * std::f64::consts::PI / 180.0;
    [longitude * degree * latitude.to_radians().cos(), latitude * degree]
}

/// Joins ways of one road where exactly two of its ends meet.
pub(crate) fn join(ways: &[Line]) -> Vec<Line> {
    // ends by (road, node): (way, whether it is the way's last node)
    let mut ends: BTreeMap<_, Vec<(usize, bool)>> = BTreeMap::new();
    for (k, way) in ways.iter().enumerate() {
        ends.entry((&way.road, way.nodes[0])).or_default().push((k, false));
        ends.entry((&way.road, way.nodes[way.nodes.len() - 1])).or_default().push((k, true));
    }
    let next = |k: usize, at_last: bool| -> Option<(usize, bool)> {
        let way = &ways[k];
        let node = if at_last { way.nodes[way.nodes.len() - 1] } else { way.nodes[0] };
        let meet = &ends[&(&way.road, node)];
        let other = meet.iter().copied().find(|end| *end != (k, at_last))?;
        let against_one_way = way.road.2 && other.1 == at_last;
        let (out, into) = (way.direction_out(at_last), ways[other.0].direction_out(other.1));
        // outward directions of a straight road are opposite; where carriageways part they are not
        let straight = out[0] * into[0] + out[1] * into[1] < 0.0;
        (meet.len() == 2 && other.0 != k && !against_one_way && straight).then_some(other)
    };
    let mut used = vec![false; ways.len()];
    let mut lines = Vec::new();
    for start in 0..ways.len() {
        if used[start] {
            continue;
        }
        // back to the beginning of the road (or once around it)
        let (mut k, mut entered_at_last) = (start, false);
        while let Some((other, at_last)) = next(k, entered_at_last) {
            (k, entered_at_last) = (other, !at_last);
            if k == start || used[k] {
                break;
            }
        }
        // and forward again
        let mut line: Option<Line> = None;
        loop {
            used[k] = true;
            let mut way = ways[k].clone();
            if entered_at_last {
                way.nodes.reverse();
                way.points.reverse();
            }
            match &mut line {
                None => line = Some(way),
                Some(line) => {
                    line.nodes.extend(&way.nodes[1..]);
                    line.points.extend(&way.points[1..]);
                    line.limits.pop();
                    line.limits.extend(&way.limits);
                }
            }
            match next(k, !entered_at_last) {
                Some((other, at_last)) if !used[other] => (k, entered_at_last) = (other, at_last),
                _ => break,
            }
        }
        lines.extend(line);
    }
    lines
}

impl Line {
    /// Direction in which the road leaves this line at an end.
    fn direction_out(&self, at_last: bool) -> [f64; 2] {
        let n = self.points.len();
        let (from, to) = if at_last { (n - 2, n - 1) } else { (1, 0) };
        [self.points[to][0] - self.points[from][0], self.points[to][1] - self.points[from][1]]
    }

    /// Whether this is a motorway.
    pub(crate) fn is_motorway(&self) -> bool {
        self.road.0 == "motorway"
    }

    /// Positions every [`STEP_M`] from the beginning on.
    pub(crate) fn profile(&self) -> Profile {
        let mut profile = Profile::default();
        let mut ahead_m = 0.0;
        for (k, pair) in self.points.windows(2).enumerate() {
            let (dx, dy) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
            let length_m = dx.hypot(dy);
            while ahead_m < length_m {
                profile.x.push(pair[0][0] + dx * ahead_m / length_m);
                profile.y.push(pair[0][1] + dy * ahead_m / length_m);
                profile.limit_kmh.push(self.limits[k]);
                ahead_m += STEP_M;
            }
            ahead_m -= length_m;
        }
        profile
    }
}
