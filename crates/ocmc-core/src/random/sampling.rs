//! How a run's cycles share out the values that describe a whole cycle: each by itself, or evenly
//! over a batch.
//!
//! With [`Sampling::Sobol`] the cycles b·[`BATCH`] to (b + 1)·[`BATCH`] − 1 are batch b; where
//! trucks make several trips, so many trucks, drivers, or trips of one truck. They take
//! the first four draws of each stream that describes a whole cycle ([`Stream::is_spread`]) from an
//! Owen-scrambled Sobol sequence, so that among them every sixteenth of the values occurs once.
//! Each batch and each stream has a scrambling of its own: batches are independent of one another,
//! and alike, which is what intervals rest on (the module `fleet::dependence`). Each draw alone is
//! uniform, as ever:
//!
//! u = 0.s ⊕ d …, the 23 binary digits s of the Sobol point shifted by random digits d of the
//! batch, followed by the digits of the cycle's own draw.
//!
//! Sources: A. B. Owen, *Annals of Statistics* 25 (1997) 1541, for scrambled nets \[PK\]; B.
//! Burley, *Journal of Computer Graphics Techniques* 9 (2020) 1, for scrambling by hashes, as in
//! the crate `sobol_burley`, and for sets of four dimensions that are scrambled apart.

use crate::random::Stream;
use rand_chacha::ChaCha8Rng;
use rand_core::Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Cycles of a batch, a power of two: few, so that short runs have batches enough for an interval.
pub const BATCH: u64 = 16;

/// How the cycles of a run share out the values that describe a whole cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// Each cycle is independent of all others.
    #[default]
    Independent,
    /// The cycles of a batch spread evenly.
    Sobol,
}

impl Sampling {
    /// Cycles that depend on one another: those with the same quotient of their id by this.
    pub fn batch(self) -> u64 {
        match self {
            Self::Independent => 1,
            Self::Sobol => BATCH,
        }
    }
}

impl Stream {
    /// Whether its first draws describe a whole cycle: mission, driver, truck, first hours of
    /// weather, and the first stretches of road.
    pub fn is_spread(self) -> bool {
        use Stream as S;
        matches!(
            self,
            S::MissionLength
                | S::Payload
                | S::Departure
                | S::Route
                | S::CurveSpeed
                | S::SpeedChange
                | S::Compliance
                | S::Pedals
                | S::BumpComfort
                | S::Vehicle
                | S::Electric
                | S::Temperature
                | S::Pressure
                | S::Humidity
                | S::Precipitation
                | S::Wind
                | S::Traffic
                | S::RoadType
        )
    }
}

/// Draws of a stream that come from the point.
const DIMENSIONS: usize = 4;

/// Binary digits of a coordinate.
const DIGITS: u32 = 23;

/// Remaining coordinates of the point of one cycle and stream.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    coordinates: [u32; DIMENSIONS],
    used: usize,
}

impl Point {
    /// No point: every draw is the stream's own.
    pub(crate) const NONE: Self = Self { coordinates: [0; DIMENSIONS], used: DIMENSIONS };

    /// The point of that index in its batch, scrambled by the generator of the batch and stream.
    pub(crate) fn new(mut scrambling: ChaCha8Rng, index: u64) -> Self {
        let index = index as u32;
        let scale = f64::from(1_u32 << DIGITS);
        let point = sobol_burley::sample_4d(index, 0, scrambling.next_u32());
        let coordinates = point.map(|x| {
            let shift = scrambling.next_u32() >> (u32::BITS - DIGITS);
            (f64::from(x) * scale) as u32 ^ shift
        });
        Self { coordinates, used: 0 }
    }

    /// Whether the next draw comes from it.
    #[inline]
    pub(crate) fn is_left(&self) -> bool {
        self.used < DIMENSIONS
    }

    /// Leaves out what so many draws took; a stream without a point has none left anyway.
    pub(crate) fn go_to(&mut self, drawn: u64) {
        self.used = self.used.max(drawn.min(DIMENSIONS as u64) as usize);
    }

    /// A word of the stream, its leading digits replaced by those of the next coordinate.
    #[cold]
    pub(crate) fn lead(&mut self, word: u64) -> u64 {
        let coordinate = u64::from(self.coordinates[self.used]);
        self.used += 1;
        (coordinate << (u64::BITS - DIGITS)) | (word >> DIGITS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Draws, Factor, PickFreeze, StreamSet, Streams};
    use crate::statistics::{SEEDS, assert_follows, assert_mean};

    fn streams(seed: u64, cycle_id: u64) -> Streams<'static> {
        Streams { sampling: Sampling::Sobol, ..Streams::new(seed, cycle_id) }
    }

    fn first<const N: usize>(mut draws: Draws) -> [f64; N] {
        std::array::from_fn(|_| draws.uniform())
    }

    /// Points of the cycles of one batch.
    fn batch(seed: u64, batch: u64, stream: Stream) -> Vec<[f64; DIMENSIONS]> {
        (0..BATCH).map(|k| first(streams(seed, batch * BATCH + k).open(stream))).collect()
    }

    #[test]
    fn the_cycles_of_a_batch_spread_evenly() {
        let part = |x: f64, parts: f64| (x * parts) as usize;
        for stream in Stream::ALL.into_iter().filter(|stream| stream.is_spread()) {
            let points = batch(1, 3, stream);
            for d in 0..DIMENSIONS {
                let mut parts: Vec<usize> = points.iter().map(|p| part(p[d], 16.0)).collect();
                parts.sort_unstable();
                assert_eq!(parts, (0..16).collect::<Vec<_>>(), "{stream:?} {d}");
            }
            // the first two dimensions of a Sobol sequence: one point in each of 4 by 4 boxes, too
            let mut boxes: Vec<usize> =
                points.iter().map(|p| 4 * part(p[0], 4.0) + part(p[1], 4.0)).collect();
            boxes.sort_unstable();
            assert_eq!(boxes, (0..16).collect::<Vec<_>>(), "{stream:?}");
        }
    }

    #[test]
    fn each_draw_alone_is_uniform_over_batches() {
        for seed in SEEDS {
            for (index, d) in [(0, 0), (0, 3), (5, 1), (15, 2)] {
                let draw = |b: u64| {
                    first::<DIMENSIONS>(streams(seed, b * BATCH + index).open(Stream::Payload))[d]
                };
                let values: Vec<f64> = (0..20_000).map(draw).collect();
                assert_follows("a draw", values, |x| x);
            }
        }
    }

    #[test]
    fn batches_and_streams_do_not_go_together() {
        let correlations: Vec<f64> = (0..400)
            .map(|b| {
                let deviations = |k: u64, stream| -> Vec<f64> {
                    batch(1, k, stream).iter().map(|point| point[0] - 0.5).collect()
                };
                let (x, y) = match b % 2 {
                    0 => (deviations(b, Stream::Payload), deviations(b + 1, Stream::Payload)),
                    _ => (deviations(b, Stream::Payload), deviations(b, Stream::Pedals)),
                };
                let sum = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
                sum(&x, &y) / (sum(&x, &x) * sum(&y, &y)).sqrt()
            })
            .collect();
        assert_mean("correlation", &correlations, 0.0);
        // as spread as those of few points are: of 16 by themselves 1/15, of 8 pairs that go
        // together 1/7
        let squares = correlations.iter().map(|c| c * c).sum::<f64>() / 400.0;
        assert!(squares < 1.0 / 7.0, "{squares}");
    }

    #[test]
    fn what_is_not_spread_and_what_comes_later_stay_as_they_are() {
        let plain = Streams::new(1, 37);
        for stream in Stream::ALL {
            let (own, spread): ([f64; 8], [f64; 8]) =
                (first(plain.open(stream)), first(streams(1, 37).open(stream)));
            assert!(own[DIMENSIONS..] == spread[DIMENSIONS..], "{stream:?}");
            assert_eq!(own[..DIMENSIONS] == spread[..DIMENSIONS], !stream.is_spread());
        }
        let shared = streams(1, 37).open_replicate(Stream::CurveSpeed, 64);
        assert!(first::<8>(shared) == first::<8>(plain.open(Stream::CurveSpeed)));
    }

    #[test]
    fn frozen_factors_and_the_second_sample_spread_alike() {
        let frozen = Streams { frozen: &[Factor::Mission], ..streams(1, 37) };
        let at_zero: [f64; 8] = first(streams(1, 0).open(Stream::Payload));
        assert!(first::<8>(frozen.open(Stream::Payload)) == at_zero);
        let pick_freeze = PickFreeze { streams: StreamSet::ALL, cycle_id: None };
        let points: Vec<[f64; DIMENSIONS]> = (0..BATCH)
            .map(|k| first(Streams { pick_freeze, ..streams(1, k) }.open(Stream::Payload)))
            .collect();
        assert!(points != batch(1, 0, Stream::Payload), "another sample");
        let mut parts: Vec<usize> = points.iter().map(|p| (16.0 * p[0]) as usize).collect();
        parts.sort_unstable();
        assert_eq!(parts, (0..16).collect::<Vec<_>>());
    }

    #[test]
    fn trucks_drivers_and_trips_of_a_truck_spread_evenly() {
        use crate::random::nesting::{Drivers, Nesting};
        let nesting =
            Nesting { trips_per_truck: 32, drivers: Drivers::OfTruck(2), ..Nesting::NONE };
        let first = |cycle_id: u64, stream: Stream| {
            Streams { nesting: &nesting, ..streams(5, cycle_id) }.open(stream).uniform()
        };
        let each_sixteenth_once = |values: Vec<f64>| {
            let mut strata: Vec<u64> = values.iter().map(|u| (u * 16.0) as u64).collect();
            strata.sort_unstable();
            assert_eq!(strata, (0..16).collect::<Vec<_>>());
        };
        for batch in 0..3 {
            let trucks = (0..16).map(|k| 32 * (16 * batch + k));
            each_sixteenth_once(trucks.clone().map(|id| first(id, Stream::Vehicle)).collect());
            // two drivers of eight trucks, who take turns
            let drivers = (0..16).map(|k| 32 * (8 * batch + k / 2) + k % 2);
            each_sixteenth_once(drivers.map(|id| first(id, Stream::CurveSpeed)).collect());
            // sixteen trips of one truck, and the next sixteen
            for start in [0, 16] {
                let trips = (0..16).map(|k| 32 * batch + start + k);
                each_sixteenth_once(trips.map(|id| first(id, Stream::Payload)).collect());
            }
        }
        // batches of trips are scrambled apart
        let trips = |truck: u64, start: u64| {
            (0..16).map(|k| first(32 * truck + start + k, Stream::Payload)).collect::<Vec<_>>()
        };
        assert!(trips(0, 0) != trips(0, 16) && trips(0, 0) != trips(1, 0));
    }
}
