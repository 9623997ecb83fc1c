//! Demand of each metre of road on a driver: a stop, a curve, a limit, a hill or cruising.

/// A kind of road.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From the onset of braking for a stop to it, and behind it until the speed is regained.
    Stop,
    /// The same of a curve that the driver slows for, and the curve itself.
    Curve,
    /// The same of a lower limit, of traffic and of a bump; driving at it is none.
    Limit,
    /// Steeper than 2 %, up or down.
    Hill,
    /// All other road.
    Cruise,
}

impl Kind {
    /// All kinds; where a metre is of several, the first one counts.
    pub const ALL: [Self; 5] = [Self::Stop, Self::Curve, Self::Limit, Self::Hill, Self::Cruise];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stop => "stop",
            Self::Curve => "curve",
            Self::Limit => "limit",
            Self::Hill => "hill",
            Self::Cruise => "cruise",
        }
    }
}

/// Slope from which a road is a hill.
const HILL_SLOPE: f64 = 0.02;
/// A plan that falls by more, in m/s², brakes.
const BRAKES_MPS2: f64 = 0.05;
/// Limits that rise by less are the same, in m/s.
const SAME_MPS: f64 = 0.3;
/// Share of a limit at which it is regained.
const REGAINED: f64 = 0.95;

/// A place of a way, as far as kinds depend on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Way since its start, in m.
    pub way_m: f64,
    /// Height over the road's start, in m.
    pub height_m: f64,
    /// Planned speed, in m/s.
    pub planned_mps: f64,
    /// Driven speed, in m/s.
    pub driven_mps: f64,
    /// Static limit behind the place, in m/s.
    pub limit_mps: f64,
    /// Whether a curve makes that limit.
    pub in_curve: bool,
    /// Whether the truck starts there from rest.
    pub is_start: bool,
    /// Whether it comes to rest there.
    pub is_stop: bool,
}

/// Whether a truck is so slow that it still regains its speed. Squares, in m²/s².
pub fn regains(speed_squared: f64, limit_squared: f64) -> bool {
    speed_squared < REGAINED * REGAINED * limit_squared
}

/// The kinds of the pieces between the points of a way.
pub fn kinds(places: &[Point]) -> Vec<Kind> {
    let pieces = places.len() - 1;
    let slope = |k: usize| {
        let (a, b) = (&places[k], &places[k + 1]);
        (b.height_m - a.height_m) / (b.way_m - a.way_m)
    };
    let flat = |k: usize| if slope(k).abs() > HILL_SLOPE { Kind::Hill } else { Kind::Cruise };
    let mut kinds: Vec<Kind> = (0..pieces).map(flat).collect();
    let mark = |kinds: &mut Vec<Kind>, k: usize, kind: Kind| {
        if (kind as usize) < kinds[k] as usize {
            kinds[k] = kind;
        }
    };
    let brakes = |k: usize| {
        let (a, b) = (&places[k], &places[k + 1]);
        let fall = a.planned_mps * a.planned_mps - b.planned_mps * b.planned_mps;
        fall > 2.0 * BRAKES_MPS2 * (b.way_m - a.way_m)
    };
    // what a piece is braked for
    let cause = |k: usize| match places.get(k) {
        Some(place) if place.is_stop => Kind::Stop,
        Some(place) if place.in_curve => Kind::Curve,
        _ => Kind::Limit,
    };
    let mut k = 0;
    while k < pieces {
        if places[k].in_curve {
            mark(&mut kinds, k, Kind::Curve);
        }
        if brakes(k) {
            let first = k;
            while k < pieces && brakes(k) {
                k += 1;
            }
            for braked in first..k {
                mark(&mut kinds, braked, cause(k));
            }
        } else {
            k += 1;
        }
    }
    // from where it may go faster until it does
    for start in 0..pieces {
        let rises = start > 0 && places[start].limit_mps > places[start - 1].limit_mps + SAME_MPS;
        let kind = match start {
            _ if places[start].is_start => Kind::Stop,
            _ if !rises => continue,
            _ if places[start - 1].in_curve => Kind::Curve,
            _ => Kind::Limit,
        };
        let slow = |place: &Point| {
            let (driven_mps, limit_mps) = (place.driven_mps, place.limit_mps);
            regains(driven_mps * driven_mps, limit_mps * limit_mps)
        };
        let mut k = start;
        while k < pieces && !brakes(k) && slow(&places[k]) {
            mark(&mut kinds, k, kind);
            k += 1;
        }
    }
    kinds
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(way_m: f64, limit_mps: f64, planned_mps: f64, driven_mps: f64) -> Point {
        let (height_m, is_start, is_stop) = (0.0, way_m == 0.0, false);
        let in_curve = false;
        Point { way_m, height_m, planned_mps, driven_mps, limit_mps, in_curve, is_start, is_stop }
    }

    #[test]
    fn a_leg_with_a_curve_a_lower_limit_and_a_hill() {
        use Kind::{Cruise, Curve, Hill, Limit, Stop};
        let mut places = vec![
            place(0.0, 20.0, 0.0, 0.0),
            place(100.0, 20.0, 14.0, 13.0),
            place(200.0, 20.0, 20.0, 19.5),
            place(300.0, 20.0, 20.0, 20.0),
            place(400.0, 10.0, 10.0, 10.0), // a curve
            place(450.0, 20.0, 10.0, 10.0),
            place(600.0, 20.0, 20.0, 20.0),
            place(700.0, 20.0, 20.0, 20.0), // the hill
            place(800.0, 20.0, 20.0, 20.0),
            place(900.0, 15.0, 15.0, 15.0),
            place(1000.0, 15.0, 15.0, 15.0),
            place(1100.0, 15.0, 0.0, 0.0),
        ];
        places[4].in_curve = true;
        places[11].is_stop = true;
        for place in &mut places[8..] {
            place.height_m = 3.0;
        }
        let wanted = [Stop, Stop, Cruise, Curve, Curve, Curve, Cruise, Hill, Limit, Cruise, Stop];
        assert_eq!(kinds(&places), wanted);
    }
}
