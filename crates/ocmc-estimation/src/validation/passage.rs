//! A drive over places of a road: when it passes each, how fast, and what energy it has taken until
//! then.
//!
//! Between two rows the acceleration is even: the square of the speed is linear over the way. Time
//! and energy of a place are those of its first passage; a standstill lies behind the place at
//! which it is.

use crate::log::standstill::Standstill;
use std::ops::Range;

/// Smallest distance between places, in m.
const SHORTEST_STEP_M: f64 = 10.0;
/// Most places on a road.
const MOST_PLACES: f64 = 2000.0;

/// Places at which the drives on a road are compared: every 10 m, or 2000 on a longer road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Places {
    /// Distance between them, in m; the first one is so far behind the start.
    pub step_m: f64,
    /// How many.
    pub count: usize,
}

impl Places {
    /// Places of a road; the last one is a step before its end at least.
    pub fn of(length_m: f64) -> Self {
        let step_m = (length_m / MOST_PLACES).max(SHORTEST_STEP_M);
        let count = libm::floor(length_m / step_m - 1.0).max(0.0) as usize;
        Self { step_m, count }
    }

    /// Where a place is, in m.
    pub fn at(&self, place: usize) -> f64 {
        (place + 1) as f64 * self.step_m
    }

    /// The places from one position to another.
    pub fn within(&self, from_m: f64, to_m: f64) -> Range<usize> {
        let from = libm::ceil(from_m / self.step_m - 1.0).max(0.0) as usize;
        let to = libm::floor(to_m / self.step_m).max(0.0) as usize;
        let to = to.min(self.count);
        from.min(to)..to
    }
}

/// The rows of a drive on a road.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    /// Time, in s.
    pub time_s: &'a [f64],
    /// Position on the road, in m; it never falls.
    pub position_m: &'a [f64],
    /// Speed, in m/s.
    pub speed_mps: &'a [f64],
    /// Energy or fuel from the first row on; empty where it is not known.
    pub energy: &'a [f64],
}

/// A drive over the places of a road; NaN at places that it does not reach.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Passage {
    /// Time since the first row, in s.
    pub time_s: Vec<f32>,
    /// Speed, in m/s.
    pub speed_mps: Vec<f32>,
    /// Energy or fuel since the first row; empty where it is not known.
    pub energy: Vec<f32>,
    /// Where the vehicle stood.
    pub stops: Vec<Standstill>,
}

impl Passage {
    /// Passage by some rows, with the standstills on the road.
    pub fn new(places: Places, rows: &Rows, stops: Vec<Standstill>) -> Self {
        let Rows { time_s, position_m, speed_mps, energy } = *rows;
        let knows_energy = energy.len() == time_s.len() && !energy.is_empty();
        let mut passage = Self {
            time_s: vec![f32::NAN; places.count],
            speed_mps: vec![f32::NAN; places.count],
            energy: vec![f32::NAN; if knows_energy { places.count } else { 0 }],
            stops,
        };
        let mut row = 1;
        for place in 0..places.count {
            let at_m = places.at(place);
            while row < position_m.len() && position_m[row] < at_m {
                row += 1;
            }
            if row >= position_m.len() {
                break;
            }
            let (from_m, to_m) = (position_m[row - 1], position_m[row]);
            if !(from_m <= at_m && to_m > from_m) {
                continue;
            }
            let share = (at_m - from_m) / (to_m - from_m);
            let (v0, v1) = (speed_mps[row - 1], speed_mps[row]);
            let speed = (v0 * v0 + share * (v1 * v1 - v0 * v0)).max(0.0).sqrt();
            // the share of the time that an even acceleration takes up to here
            let part = share * (v0 + v1) / (v0 + speed);
            let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { share };
            let between = |values: &[f64]| {
                values[row - 1] - values[0] + part * (values[row] - values[row - 1])
            };
            passage.time_s[place] = between(time_s) as f32;
            passage.speed_mps[place] = speed as f32;
            if knows_energy {
                passage.energy[place] = between(energy) as f32;
            }
        }
        passage
    }

    /// Time between two places, in s.
    pub fn duration_s(&self, from: usize, to: usize) -> f64 {
        f64::from(self.time_s[to]) - f64::from(self.time_s[from])
    }

    /// Energy or fuel between two places; NaN where it is not known.
    pub fn energy(&self, from: usize, to: usize) -> f64 {
        let at = |place: usize| self.energy.get(place).map_or(f64::NAN, |value| f64::from(*value));
        at(to) - at(from)
    }

    /// How often the vehicle stood between two positions, and for how long, in s.
    pub fn stood(&self, from_m: f64, to_m: f64) -> (f64, f64) {
        let here = self.stops.iter().filter(|s| s.position_m >= from_m && s.position_m < to_m);
        here.fold((0.0, 0.0), |(count, time_s), stop| (count + 1.0, time_s + stop.duration_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_lie_inside_the_road() {
        let short = Places::of(1000.0);
        assert_eq!((short.step_m, short.count, short.at(0)), (10.0, 99, 10.0));
        assert_eq!(short.within(0.0, 1000.0), 0..99);
        assert_eq!(short.within(95.0, 200.0), 9..20);
        assert!(short.within(990.0, 200.0).is_empty());
        let long = Places::of(100_000.0);
        assert_eq!((long.step_m, long.count), (50.0, 1999));
        assert_eq!(Places::of(5.0).count, 0);
    }

    #[test]
    fn an_even_acceleration_is_read_exactly() {
        // 2 m/s² from rest, a row a second, 3 s at rest at 100 m
        let mut rows: Vec<[f64; 3]> =
            (0..=10).map(f64::from).map(|t| [t, t * t, 2.0 * t]).collect();
        rows.push([11.0, 100.0, 0.0]);
        rows.push([14.0, 100.0, 0.0]);
        rows.push([24.0, 200.0, 20.0]);
        let column = |k: usize| rows.iter().map(move |row| row[k] + if k == 0 { 1e9 } else { 0.0 });
        let [time, way, speed] = [0, 1, 2].map(|k| column(k).collect::<Vec<f64>>());
        let energy: Vec<f64> = time.iter().map(|t| 3.0 * t).collect();
        let rows = Rows { time_s: &time, position_m: &way, speed_mps: &speed, energy: &energy };
        let stop = Standstill { position_m: 100.0, duration_s: 4.0 };
        let passage = Passage::new(Places::of(230.0), &rows, vec![stop]);
        for (place, at_m) in [(0, 10f64), (4, 50.0), (9, 100.0)] {
            let (time_s, speed_mps) = (at_m.sqrt(), 2.0 * at_m.sqrt());
            assert!((f64::from(passage.time_s[place]) - time_s).abs() < 1e-5, "{at_m}");
            assert!((f64::from(passage.speed_mps[place]) - speed_mps).abs() < 1e-5, "{at_m}");
            assert!((f64::from(passage.energy[place]) - 3.0 * time_s).abs() < 1e-4, "{at_m}");
        }
        // the stop lies behind the place
        assert!((passage.duration_s(9, 19) - 14.0).abs() < 1e-5);
        assert!((passage.energy(9, 19) - 42.0).abs() < 1e-4);
        assert_eq!(passage.stood(100.0, 200.0), (1.0, 4.0));
        assert_eq!(passage.stood(50.0, 100.0), (0.0, 0.0));
        assert!(passage.time_s[20].is_nan() && passage.speed_mps[21].is_nan());
    }
}
