//! Places of a stop plan on a track: each at the point of the track that is near, in their order.

use crate::given_cycle::route::Points;
use crate::intake::Finding;
use crate::number_text::{count_of, rounded};
use ocmc_core::operating_cycle::road::route_geometry::Path2d;

/// Places farther beside a track than this are refused, in m.
const MOST_M: f64 = 2000.0;
/// Places farther beside a track than this are named, in m: a yard is that large.
const YARD_M: f64 = 200.0;
/// Passages of a place that are farther from it than its nearest one are considered, in m.
const MARGIN_M: f64 = 50.0;

/// A place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub(super) latitude_deg: f64,
    pub(super) longitude_deg: f64,
}

/// A passage of a place.
#[derive(Clone, Copy)]
struct Passage {
    position_m: f64,
    beside_m: f64,
}

/// Where the places lie along a track, in m, and which of them lie beside it. Of several passages
/// those are taken that are nearest in sum, each behind the one before; of equals the first.
/// `called` is the name of a place.
///
/// # Errors
/// The fault, to stand behind the name of the plan.
pub(super) fn on_track(
    spots: &[Spot],
    points: &Points,
    called: impl Fn(usize) -> String,
) -> Result<(Vec<f64>, Option<Finding>), String> {
    let path = Path2d::new(&points.latitude_deg, &points.longitude_deg);
    let passages: Vec<Vec<Passage>> =
        spots.iter().map(|spot| passages(*spot, points, &path)).collect();
    for (k, near) in passages.iter().enumerate() {
        let beside_m = near.iter().map(|passage| passage.beside_m).fold(f64::INFINITY, f64::min);
        if beside_m > MOST_M {
            return Err(format!(
                "{}: {} km beside the track; allowed are {} km",
                called(k),
                rounded(beside_m / 1000.0),
                MOST_M / 1000.0
            ));
        }
    }
    let chosen = in_order(&passages).ok_or_else(|| {
        "has places that the track does not pass in this order: is the order right, and the track \
         the one of this trip?"
            .to_owned()
    })?;
    let far: Vec<usize> = (0..chosen.len()).filter(|k| chosen[*k].beside_m > YARD_M).collect();
    let most_m = chosen.iter().map(|passage| passage.beside_m).fold(0.0, f64::max);
    let finding = far.first().map(|first| {
        let text = format!(
            "{} farther than {YARD_M} m beside the track, at most {} m (first: {}): the truck \
             stops on the track",
            count_of(far.len() as u64, "place"),
            rounded(most_m),
            called(*first)
        );
        Finding::warned("stop-place", [most_m, YARD_M], text, "check the coordinates")
    });
    Ok((chosen.iter().map(|passage| passage.position_m).collect(), finding))
}

/// The passages of a place: where the track is nearest in a neighbourhood.
fn passages(spot: Spot, points: &Points, path: &Path2d) -> Vec<Passage> {
    let plane = Path2d::new(
        &[points.latitude_deg[0], spot.latitude_deg],
        &[points.longitude_deg[0], spot.longitude_deg],
    );
    let (x_m, y_m) = (plane.points_m().0[1], plane.points_m().1[1]);
    let (path_x, path_y) = path.points_m();
    let near = |k: usize| {
        let (dx, dy) = (path_x[k + 1] - path_x[k], path_y[k + 1] - path_y[k]);
        let length2 = dx * dx + dy * dy;
        let along = (x_m - path_x[k]) * dx + (y_m - path_y[k]) * dy;
        let share = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
        let (from_m, to_m) = (points.position_m[k], points.position_m[k + 1]);
        let beside_m = libm::hypot(path_x[k] + share * dx - x_m, path_y[k] + share * dy - y_m);
        Passage { position_m: from_m + share * (to_m - from_m), beside_m }
    };
    let all: Vec<Passage> = (0..path_x.len().saturating_sub(1)).map(near).collect();
    let nearest_m = all.iter().map(|passage| passage.beside_m).fold(f64::INFINITY, f64::min);
    let is_near = |passage: &Passage| passage.beside_m <= nearest_m + MARGIN_M;
    // of each stretch of the track that is near its nearest point
    let mut passages: Vec<Passage> = Vec::new();
    let mut was_near = false;
    for passage in all {
        let is_near = is_near(&passage);
        match passages.last_mut() {
            Some(last) if is_near && was_near => {
                *last = if passage.beside_m < last.beside_m { passage } else { *last };
            }
            _ if is_near => passages.push(passage),
            _ => {}
        }
        was_near = is_near;
    }
    passages
}

/// One passage of each place, each behind the one before, nearest in the sum of squares.
fn in_order(passages: &[Vec<Passage>]) -> Option<Vec<Passage>> {
    // cost up to each passage of the places so far, and which passage came before
    let mut steps: Vec<Vec<(f64, usize)>> = Vec::with_capacity(passages.len());
    for (k, near) in passages.iter().enumerate() {
        let cost = |passage: &Passage| {
            let own = passage.beside_m * passage.beside_m;
            if k == 0 {
                return (own, 0);
            }
            let before = passages[k - 1].iter().zip(&steps[k - 1]).enumerate();
            let behind = before.filter(|(_, (other, _))| other.position_m <= passage.position_m);
            let costs = behind.map(|(number, (_, (cost, _)))| (*cost, number));
            let best = costs.reduce(|a, b| if b.0 < a.0 { b } else { a });
            best.map_or((f64::INFINITY, 0), |(cost, number)| (cost + own, number))
        };
        steps.push(near.iter().map(cost).collect());
    }
    let costs = steps.last()?.iter().enumerate();
    let (mut number, (cost, _)) = costs.reduce(|a, b| if b.1.0 < a.1.0 { b } else { a })?;
    if !cost.is_finite() {
        return None;
    }
    let mut chosen = vec![Passage { position_m: 0.0, beside_m: 0.0 }; passages.len()];
    for k in (0..passages.len()).rev() {
        chosen[k] = passages[k][number];
        number = steps[k][number].1;
    }
    Some(chosen)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A way out to the north and back, with a branch to the east at its end.
    fn points() -> Points {
        let north: Vec<f64> = (0..=100).map(f64::from).collect();
        let back = north.iter().rev().skip(1);
        let all: Vec<f64> = north.iter().chain(back).copied().collect();
        Points {
            latitude_deg: all.iter().map(|k| k * 0.001).collect(),
            longitude_deg: vec![0.0; all.len()],
            position_m: (0..all.len()).map(|k| 111.195 * k as f64).collect(),
        }
    }

    fn spot(latitude_deg: f64) -> Spot {
        Spot { latitude_deg, longitude_deg: 0.0001 }
    }

    #[test]
    fn places_are_found_on_the_way_out_or_back_as_their_order_says() {
        let at = |spots: &[Spot]| {
            on_track(spots, &points(), |k| format!("row {k}")).map(|matched| matched.0)
        };
        let km = |places: Vec<f64>| -> Vec<i64> {
            places.iter().map(|m| (m / 1111.95).round() as i64).collect()
        };
        assert_eq!(km(at(&[spot(0.0), spot(0.05), spot(0.08)]).unwrap()), [0, 5, 8]);
        // behind the turn they can only be passed on the way back
        assert_eq!(
            km(at(&[spot(0.0), spot(0.1), spot(0.08), spot(0.05)]).unwrap()),
            [0, 10, 12, 15]
        );
        assert_eq!(km(at(&[spot(0.05), spot(0.08), spot(0.05)]).unwrap()), [5, 8, 15]);
        let fault = at(&[spot(0.05), spot(0.08), spot(0.05), spot(0.08)]).unwrap_err();
        assert!(fault.contains("in this order"), "{fault}");
        let fault = at(&[Spot { latitude_deg: 0.05, longitude_deg: 0.1 }]).unwrap_err();
        assert!(fault.contains("11.12 km beside the track"), "{fault}");
    }

    #[test]
    fn places_beside_the_track_are_named() {
        let aside = Spot { latitude_deg: 0.05, longitude_deg: 0.005 };
        let (places, finding) =
            on_track(&[spot(0.0), aside], &points(), |k| format!("row {k}")).unwrap();
        assert!((places[1] - 50.0 * 111.195).abs() < 1.0, "{places:?}");
        let text = finding.map(|finding| finding.text).unwrap();
        assert!(text.contains("1 place") && text.contains("first: row 1"), "{text}");
    }
}
