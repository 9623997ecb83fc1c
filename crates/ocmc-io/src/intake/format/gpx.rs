//! GPX 1.0 and 1.1: tracks, and routes where there are no tracks.
//!
//! A track is a drive. Its segments are pieces between which the receiver was lost
//! (topografix.com/gpx/1/1: a new segment where reception was lost or the receiver was off): they
//! end no drive. Speeds and courses are those of GPX 1.0 and of the extensions of receivers
//! (TrackPointExtension: m/s and degrees).

use super::points::{Point, Points};
use super::xml::{self, Piece};
use super::{Content, Format, contains, text_of};
use std::path::Path;

/// The format.
pub(super) const GPX: Format = Format {
    name: "GPX",
    is_track: true,
    is_one: |start| start.trim_ascii_start().starts_with(b"<") && contains(start, b"<gpx"),
    read,
};

fn read(path: &Path, bytes: &[u8]) -> Result<Content, String> {
    let text = text_of(bytes);
    let (mut tracks, mut routes) = (Points::default(), Points::default());
    let mut point: Option<Point> = None;
    let mut ways = 0;
    xml::walk(&text, |piece| {
        match piece {
            Piece::Begin("trk", _) => tracks.begin(""),
            Piece::Begin("rte", _) => routes.begin(""),
            Piece::Begin("trkpt" | "rtept", place) => {
                point = Some(Point {
                    latitude_deg: place.number("lat"),
                    longitude_deg: place.number("lon"),
                    ..Point::default()
                });
            }
            Piece::Begin("wpt", _) => ways += 1,
            Piece::Begin(..) => {}
            Piece::End("trkpt", _) => point.take().map_or(Ok(()), |point| tracks.add(point))?,
            Piece::End("rtept", _) => point.take().map_or(Ok(()), |point| routes.add(point))?,
            Piece::End(name, text) => match (&mut point, name) {
                (Some(point), "ele") => point.altitude_m = xml::number(text),
                (Some(point), "time") => point.time = Some(text.trim().to_owned()),
                (Some(point), "speed") => point.speed_mps = xml::number(text),
                (Some(point), "course") => point.course_deg = xml::number(text),
                (None, "name") => {
                    tracks.name(text);
                    routes.name(text);
                }
                _ => {}
            },
        }
        Ok(())
    })?;
    let (mut taken, other, what) = if tracks.len() > 0 {
        (tracks, routes, "point of routes")
    } else {
        (routes, tracks, "point")
    };
    for (what, count) in [("waypoint", ways), (what, other.len())] {
        if count > 0 {
            taken.left_out.insert(what, count);
        }
    }
    taken.table(path)
}
