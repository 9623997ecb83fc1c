//! KML 2.2: lines (`LineString`) and tracks with times (`gx:Track`); each placemark is a drive.

use super::points::{Point, Points};
use super::xml::{self, Piece};
use super::{Content, Format, contains, text_of};
use std::path::Path;

/// The format.
pub(super) const KML: Format = Format {
    name: "KML",
    is_track: true,
    is_one: |start| start.trim_ascii_start().starts_with(b"<") && contains(start, b"<kml"),
    read,
};

/// The place of some numbers: longitude, latitude and, where there is one, altitude.
fn point_of(numbers: &mut dyn Iterator<Item = &str>) -> Point {
    let mut next = || numbers.next().map_or(f64::NAN, xml::number);
    let (longitude_deg, latitude_deg, altitude_m) = (next(), next(), next());
    Point { latitude_deg, longitude_deg, altitude_m, ..Point::default() }
}

fn read(path: &Path, bytes: &[u8]) -> Result<Content, String> {
    let text = text_of(bytes);
    let mut points = Points::default();
    let (mut in_line, mut in_place, mut in_track) = (false, false, false);
    let mut times: Vec<String> = Vec::new();
    let mut first = 0;
    xml::walk(&text, |piece| {
        match piece {
            Piece::Begin("Placemark", _) => {
                points.begin("");
                in_place = true;
            }
            Piece::Begin("LineString", _) => in_line = true,
            Piece::Begin("Track", _) => (in_track, first) = (true, points.len()),
            Piece::End("LineString", _) => in_line = false,
            Piece::End("Placemark", _) => in_place = false,
            Piece::End("Track", _) => {
                in_track = false;
                let taken = &mut points.points_mut()[first..];
                // a track lists all times, and then all places
                for (point, time) in taken.iter_mut().zip(times.drain(..)) {
                    point.time = Some(time);
                }
            }
            Piece::End("when", text) if in_track => times.push(text.trim().to_owned()),
            Piece::End("coord", text) if in_track => {
                points.add(point_of(&mut text.split_ascii_whitespace()))?;
            }
            Piece::End("coordinates", text) if in_line => {
                for place in text.split_ascii_whitespace() {
                    points.add(point_of(&mut place.split(',')))?;
                }
            }
            Piece::End("coordinates", _) => {
                *points.left_out.entry("place or area").or_default() += 1;
            }
            Piece::End("name", text) if in_place => points.name(text),
            Piece::Begin(..) | Piece::End(..) => {}
        }
        Ok(())
    })?;
    points.table(path)
}
