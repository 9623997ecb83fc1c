//! Points of tracks, which GPX, KML and GeoJSON have in common.

use super::Content;
use crate::intake::Finding;
use crate::intake::table::given::GivenTable;
use crate::number_text::count_of;
use arrow_array::{ArrayRef, Float64Array, StringArray};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// A point of a track; NaN or nothing where the file does not tell.
#[derive(Clone, Debug)]
pub(super) struct Point {
    pub(super) time: Option<String>,
    pub(super) latitude_deg: f64,
    pub(super) longitude_deg: f64,
    pub(super) altitude_m: f64,
    pub(super) speed_mps: f64,
    pub(super) course_deg: f64,
}

impl Default for Point {
    fn default() -> Self {
        let unknown = f64::NAN;
        Self {
            time: None,
            latitude_deg: unknown,
            longitude_deg: unknown,
            altitude_m: unknown,
            speed_mps: unknown,
            course_deg: unknown,
        }
    }
}

/// A column of numbers: its name, and its value at a point.
pub(super) type Number = (&'static str, fn(&Point) -> f64);

/// Columns of a place.
pub(super) const PLACES: [Number; 3] = [
    ("latitude_deg", |point| point.latitude_deg),
    ("longitude_deg", |point| point.longitude_deg),
    ("altitude_m", |point| point.altitude_m),
];

/// Columns of a motion.
const MOTION: [Number; 2] =
    [("speed_mps", |point| point.speed_mps), ("course_deg", |point| point.course_deg)];

/// Tracks with their points.
#[derive(Default)]
pub(super) struct Points {
    /// Name of each track; empty where the file has none.
    tracks: Vec<String>,
    /// Track of each point.
    track_of: Vec<usize>,
    all: Vec<Point>,
    /// Points or lines that were not taken, each with what they are.
    pub(super) left_out: BTreeMap<&'static str, usize>,
}

impl Points {
    /// Begins a track.
    pub(super) fn begin(&mut self, name: &str) {
        self.tracks.push(name.trim().to_owned());
    }

    /// Names the track that was begun last.
    pub(super) fn name(&mut self, name: &str) {
        if let Some(last) = self.tracks.last_mut().filter(|last| last.is_empty()) {
            name.trim().clone_into(last);
        }
    }

    /// Adds a point to the track that was begun last.
    ///
    /// # Errors
    /// Where it lies nowhere.
    pub(super) fn add(&mut self, point: Point) -> Result<(), String> {
        let (latitude, longitude) = (point.latitude_deg, point.longitude_deg);
        let is_place = latitude.abs() <= 90.0 && (-180.0..=360.0).contains(&longitude);
        if !is_place {
            return Err(format!(
                "has a point at latitude {latitude}, longitude {longitude}; allowed are -90 to 90 \
                 and -180 to 360"
            ));
        }
        self.track_of.push(self.tracks.len().saturating_sub(1));
        self.all.push(point);
        Ok(())
    }

    /// Number of points.
    pub(super) fn len(&self) -> usize {
        self.all.len()
    }

    /// The points so far.
    pub(super) fn points_mut(&mut self) -> &mut [Point] {
        &mut self.all
    }

    /// A table of all points, a row a point; what no point tells has no column.
    ///
    /// # Errors
    /// Where there is no point.
    pub(super) fn table(self, path: &Path) -> Result<Content, String> {
        if self.all.is_empty() {
            return Err("has no track with points".to_owned());
        }
        let with_points: Vec<usize> = {
            let mut tracks = self.track_of.clone();
            tracks.dedup();
            tracks.sort_unstable();
            tracks.dedup();
            tracks
        };
        let (mut names, mut columns): (Vec<String>, Vec<ArrayRef>) = (Vec::new(), Vec::new());
        if with_points.len() > 1 {
            let labels = labels(&self.tracks, &with_points);
            let of_point = self.track_of.iter().map(|track| labels[track].as_str());
            names.push("drive".to_owned());
            columns.push(Arc::new(StringArray::from_iter_values(of_point)));
        }
        if self.all.iter().any(|point| point.time.is_some()) {
            names.push("time".to_owned());
            let times: StringArray = self.all.iter().map(|point| point.time.clone()).collect();
            columns.push(Arc::new(times));
        }
        for (name, value_of) in PLACES.into_iter().chain(MOTION) {
            if self.all.iter().any(|point| !value_of(point).is_nan()) {
                names.push(name.to_owned());
                let values = self.all.iter().map(value_of);
                columns.push(Arc::new(Float64Array::from_iter_values(values)));
            }
        }
        let tracks = count_of(with_points.len() as u64, "track");
        let points = count_of(self.all.len() as u64, "point");
        let others: Vec<String> = self
            .left_out
            .iter()
            .map(|(what, count)| format!("{} left out", count_of(*count as u64, what)))
            .collect();
        let others = others.iter().fold(String::new(), |text, other| text + ", " + other);
        let text = format!("{tracks}, {points}{others}");
        let count = self.all.len() as f64;
        let findings = vec![Finding::noted("track", [count, 0.0], text, "")];
        let table = GivenTable::export(&path.to_string_lossy(), names, vec![columns]);
        Ok(Content::Columns(table, findings))
    }
}

/// A label for each of these tracks, by its number: its name, with a number where two have the
/// same.
fn labels(tracks: &[String], with_points: &[usize]) -> BTreeMap<usize, String> {
    let mut taken = BTreeMap::<&str, usize>::new();
    let mut labels = BTreeMap::new();
    for (number, track) in with_points.iter().enumerate() {
        let name = tracks.get(*track).map_or("", String::as_str);
        let again = taken.entry(name).or_default();
        *again += 1;
        let label = match (name, *again) {
            ("", _) => format!("track {}", number + 1),
            (name, 1) => name.to_owned(),
            (name, again) => format!("{name} ({again})"),
        };
        labels.insert(*track, label);
    }
    labels
}
