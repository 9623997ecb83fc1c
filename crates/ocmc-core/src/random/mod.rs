//! Random numbers: one independent stream for each sampled factor of each cycle.
//!
//! Everything random in cycle `k` is a pure function of (seed, k, stream). No generator is shared
//! or stored, so a cycle is replayed alone, parts of a run come from many machines, one factor is
//! frozen while another varies, and a new draw in the weather moves no curve in the road. Where
//! trucks make several trips, [`nesting`] says whose draws a trip takes.
//!
//! The generator is ChaCha with 8 rounds (D. J. Bernstein, 2008), whose 64-bit stream number is `64
//! k + stream`, so ids go up to [`LAST_CYCLE_ID`]; its key is the seed, and the number of the trip.
//! Transcendental functions come from `libm`, so that the draws have the same bits on every
//! platform.
//!
//! Checked: turning a part off changes only what it must, bit for bit, and freezing takes a factor
//! from cycle 0. The first draws of each primitive and law are pinned. Points of a batch fill every
//! sixteenth once, and each draw alone is uniform over batches. The normal quantile inverts the
//! error function and meets printed check values.

pub mod nesting;
pub mod sampling;
mod stream;

use crate::random::nesting::{Drivers, Ids, Level, Nesting, Pool, Trip};
use crate::random::sampling::{Point, Sampling};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

pub use stream::{Factor, Stream};

/// The last cycle id that has streams of its own.
pub const LAST_CYCLE_ID: u64 = u64::MAX / 64;

/// A set of streams.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StreamSet(u64);

impl StreamSet {
    /// No stream.
    pub const NONE: Self = Self(0);
    /// Every stream.
    pub const ALL: Self = Self(u64::MAX);

    /// These streams.
    pub fn of(streams: &[Stream]) -> Self {
        Self(streams.iter().fold(0, |set, stream| set | 1 << *stream as u8))
    }

    /// The streams of a factor.
    pub fn of_factor(factor: Factor) -> Self {
        let all = Stream::ALL.into_iter().filter(|stream| stream.factor() == Some(factor));
        Self::of(&all.collect::<Vec<_>>())
    }

    /// All other streams.
    #[must_use]
    pub fn complement(self) -> Self {
        Self(!self.0)
    }

    /// These streams and those.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether it holds a stream.
    pub fn contains(self, stream: Stream) -> bool {
        self.0 & 1 << stream as u8 != 0
    }
}

/// Streams that cycles take from a second sample, which is independent of the first: the same seed,
/// with one bit of the generator's key inverted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PickFreeze {
    /// Streams that are picked.
    pub streams: StreamSet,
    /// The cycle of the second sample that they come from; none for the cycle's own id.
    pub cycle_id: Option<u64>,
}

impl PickFreeze {
    /// Every stream comes from the first sample.
    pub const NONE: Self = Self { streams: StreamSet::NONE, cycle_id: None };
}

/// Each cycle has a truck and a driver of its own.
static NO_NESTING: Nesting = Nesting::NONE;

/// Where the draws of one cycle come from.
#[derive(Clone, Debug)]
pub struct Streams<'a> {
    /// Master seed of the run.
    pub seed: u64,
    /// Index of the cycle in the run.
    pub cycle_id: u64,
    /// Factors that every cycle takes from cycle 0.
    pub frozen: &'a [Factor],
    /// Streams that come from the second sample. A frozen factor stays where it is.
    pub pick_freeze: PickFreeze,
    /// Whether the first draws are spread evenly over a batch of cycles.
    pub sampling: Sampling,
    /// How cycles belong to trucks, drivers and days.
    pub nesting: &'a Nesting,
}

impl<'a> Streams<'a> {
    /// The streams of one cycle, nothing frozen, all from the first sample.
    pub fn new(seed: u64, cycle_id: u64) -> Streams<'a> {
        let (sampling, nesting) = (Sampling::Independent, &NO_NESTING);
        Self { seed, cycle_id, frozen: &[], pick_freeze: PickFreeze::NONE, sampling, nesting }
    }

    /// Opens the stream of one factor of this cycle, at its level.
    pub fn open(&self, stream: Stream) -> Draws {
        self.open_at(stream, self.nesting.level_of(stream))
    }

    /// Opens a stream at a level.
    fn open_at(&self, stream: Stream, level: Level) -> Draws {
        let (sample, cycle_id) = self.source(stream);
        let ids = self.ids(level, cycle_id);
        let draws = Draws::of(self.seed, sample, ids, stream);
        let is_spread = self.sampling == Sampling::Sobol && stream.is_spread() && !ids.is_day;
        if is_spread {
            draws.spread(self.seed, sample, self.place(level, ids), stream)
        } else {
            draws
        }
    }

    /// A stream at another level, as far on as these draws of it are.
    pub fn open_beside(&self, stream: Stream, level: Level, draws: &Draws) -> Draws {
        let mut beside = self.open_at(stream, level);
        beside.go_to(draws);
        beside
    }

    /// A standard normal of this cycle's truck that belongs to what the next draw of a stream
    /// gives.
    pub fn truck_effect(&self, stream: Stream, draws: &Draws) -> f64 {
        let (sample, cycle_id) = self.source(stream);
        let ids = self.ids(Level::Truck, cycle_id);
        let place = (stream as u64) << 32 | draws.drawn();
        Draws::of(self.seed, sample, ids, Stream::TruckEffect).at(place).normal()
    }

    /// Opens a stream that is shared by all trucks of one replicate (`truck_id mod replicates`).
    /// What a fit does not know belongs to no factor and cannot be frozen.
    pub fn open_replicate(&self, stream: Stream, replicates: u64) -> Draws {
        let (sample, id) = Streams { frozen: &[], ..self.clone() }.source(stream);
        let (truck_id, _) = self.nesting.truck_and_trip(id);
        Draws::of(self.seed, sample, Ids::of_cycle(truck_id % replicates.max(1)), stream)
    }

    /// The cycle whose draws a stream gives.
    pub fn cycle_of(&self, stream: Stream) -> u64 {
        self.source(stream).1
    }

    /// The cycle's place in its fleet.
    pub fn trip(&self) -> Trip {
        let (truck_id, trip) = self.nesting.truck_and_trip(self.cycle_id);
        Trip { truck_id, driver_id: self.driver_id(self.cycle_id), trip }
    }

    /// Day of the year of this trip, from 0, where trucks drive on given days.
    pub fn day_of_year(&self) -> Option<f64> {
        let days = self.nesting.days?;
        let (_, trip) = self.nesting.truck_and_trip(self.cycle_of(Stream::Departure));
        Some((days.day_of(trip) % nesting::DAYS_OF_YEAR) as f64)
    }

    /// How much later than the day's first trip this one departs, in s.
    pub fn departure_offset_s(&self) -> f64 {
        let (_, trip) = self.nesting.truck_and_trip(self.cycle_of(Stream::Departure));
        self.nesting
            .days
            .map_or(0.0, |days| days.departure_of(trip) as f64 * days.departure_interval_s)
    }

    /// Whether all trucks that drive on a day share what a stream draws.
    pub fn is_shared_by_day(&self, stream: Stream) -> bool {
        self.nesting.level_of(stream) == Level::Day
    }

    /// The sample and the cycle that a stream comes from.
    fn source(&self, stream: Stream) -> (Sample, u64) {
        if stream.factor().is_some_and(|factor| self.frozen.contains(&factor)) {
            (Sample::First, 0)
        } else if self.pick_freeze.streams.contains(stream) {
            (Sample::Second, self.pick_freeze.cycle_id.unwrap_or(self.cycle_id))
        } else {
            (Sample::First, self.cycle_id)
        }
    }

    /// Ids on which the draws of a cycle depend at a level.
    fn ids(&self, level: Level, cycle_id: u64) -> Ids {
        let (truck_id, trip) = self.nesting.truck_and_trip(cycle_id);
        match level {
            Level::Trip => Ids { id: truck_id, trip, is_day: false },
            Level::Driver => Ids::of_cycle(self.driver_id(cycle_id)),
            Level::Truck => Ids::of_cycle(truck_id),
            Level::Day => Ids { id: self.nesting.day_of(trip), trip: 0, is_day: true },
        }
    }

    /// Driver of a cycle.
    fn driver_id(&self, cycle_id: u64) -> u64 {
        let (truck_id, trip) = self.nesting.truck_and_trip(cycle_id);
        match self.nesting.drivers {
            Drivers::OfTruck(drivers) => truck_id * drivers + trip % drivers,
            Drivers::OfPool(drivers) => Pool { seed: self.seed, drivers }.driver_of(truck_id, trip),
        }
    }

    /// Batch and index in it of what is spread evenly: trucks, drivers, or the trips of a truck.
    fn place(&self, level: Level, ids: Ids) -> Place {
        let batch = Sampling::Sobol.batch();
        if level == Level::Trip && self.nesting.trips_per_truck > 1 {
            let whole = Ids { trip: ids.trip / batch, ..ids };
            return Place { batch: whole, is_of_truck: true, index: ids.trip % batch };
        }
        let whole = Ids::of_cycle(ids.id / batch);
        Place { batch: whole, is_of_truck: false, index: ids.id % batch }
    }
}

/// A batch, and the index in it.
#[derive(Clone, Copy, Debug)]
struct Place {
    batch: Ids,
    /// Whether it is a batch of trips of one truck.
    is_of_truck: bool,
    index: u64,
}

/// Sample of a seed, one of two: bits of the generator's key that are inverted.
#[derive(Clone, Copy, Debug)]
#[repr(u8)]
enum Sample {
    First = 0,
    Second = 0x80,
}

/// The bit of the key that is inverted for the scrambling of points.
const SCRAMBLING: u8 = 0x40;
/// The bit that is inverted for what all trucks share that drive on a day.
const DAY: u8 = 0x20;
/// The bit that is inverted for the scrambling of the trips of one truck.
const OF_TRUCK: u8 = 0x10;

/// The uniform of a word: its upper 53 bits and a half, so that it is neither 0 nor 1.
#[inline(always)]
fn uniform_of(word: u64) -> f64 {
    ((word >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
}

/// A stream of draws.
#[derive(Clone, Debug)]
pub struct Draws {
    generator: ChaCha8Rng,
    point: Point,
}

impl Draws {
    /// The stream of (seed, cycle, stream).
    pub fn new(seed: u64, cycle_id: u64, stream: Stream) -> Self {
        Self::of(seed, Sample::First, Ids::of_cycle(cycle_id), stream)
    }

    /// The stream of (seed, cycle, stream) of the second sample.
    pub fn of_second_sample(seed: u64, cycle_id: u64, stream: Stream) -> Self {
        Self::of(seed, Sample::Second, Ids::of_cycle(cycle_id), stream)
    }

    fn of(seed: u64, sample: Sample, ids: Ids, stream: Stream) -> Self {
        let flipped = sample as u8 | if ids.is_day { DAY } else { 0 };
        Self { generator: generator(seed, flipped, ids, stream), point: Point::NONE }
    }

    /// Its first draws spread evenly over a batch.
    fn spread(self, seed: u64, sample: Sample, place: Place, stream: Stream) -> Self {
        let flipped = sample as u8 | SCRAMBLING | if place.is_of_truck { OF_TRUCK } else { 0 };
        let scrambling = generator(seed, flipped, place.batch, stream);
        Self { point: Point::new(scrambling, place.index), ..self }
    }

    /// Number of uniforms that were drawn.
    fn drawn(&self) -> u64 {
        (self.generator.get_word_pos() / 2) as u64
    }

    /// Goes on behind as many uniforms as those of another stream.
    fn go_to(&mut self, other: &Self) {
        self.generator.set_word_pos(other.generator.get_word_pos());
        self.point.go_to(other.drawn());
    }

    /// Continues with the draws that belong to a place: whatever was drawn before, the next ones
    /// are a function of (seed, cycle, stream, place) alone. Places are 8 uniforms apart.
    pub fn at(&mut self, place: u64) -> &mut Self {
        self.generator.set_word_pos(u128::from(place) * 16);
        self.point = Point::NONE;
        self
    }

    /// Uniform on the open interval (0, 1), on a grid of 2⁻⁵³ shifted by half a step.
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        let mut word = self.generator.next_u64();
        if self.point.is_left() {
            word = self.point.lead(word);
        }
        uniform_of(word)
    }

    /// The next uniforms: those that [`Self::uniform`] would give, faster.
    fn uniforms(&mut self, values: &mut [f64]) {
        if self.point.is_left() {
            values.fill_with(|| self.uniform());
            return;
        }
        let mut bytes = [0; 512];
        for values in values.chunks_mut(64) {
            let bytes = &mut bytes[..8 * values.len()];
            self.generator.fill_bytes(bytes);
            for (value, word) in values.iter_mut().zip(bytes.as_chunks().0) {
                *value = uniform_of(u64::from_le_bytes(*word));
            }
        }
    }

    /// Uniform on (`lower`, `upper`).
    #[inline]
    pub fn uniform_between(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.uniform()
    }

    /// Standard normal, by inversion.
    #[inline]
    pub fn normal(&mut self) -> f64 {
        crate::special_functions::normal_quantile(self.uniform())
    }

    /// The next standard normals: those that [`Self::normal`] would give, faster.
    pub fn normals(&mut self, values: &mut [f64]) {
        self.uniforms(values);
        crate::special_functions::normal_quantiles(values);
    }

    /// Exponential with mean 1.
    #[inline]
    pub fn exponential(&mut self) -> f64 {
        -libm::log(self.uniform())
    }

    /// True with probability `p`.
    #[inline]
    pub fn happens(&mut self, p: f64) -> bool {
        self.uniform() < p
    }

    /// Index drawn with the given weights, which need not sum to one; the last index with a
    /// positive weight where rounding leaves a remainder.
    pub fn index(&mut self, weights: &[f64]) -> usize {
        let total: f64 = weights.iter().sum();
        let mut left = self.uniform() * total;
        let mut chosen = 0;
        for (i, &weight) in weights.iter().enumerate() {
            if weight > 0.0 {
                chosen = i;
                if left < weight {
                    break;
                }
                left -= weight;
            }
        }
        chosen
    }
}

/// The generator of (seed, ids, stream), these bits of its key inverted.
fn generator(seed: u64, flipped: u8, ids: Ids, stream: Stream) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    if flipped != 0 || ids.trip != 0 {
        let mut key = generator.get_seed();
        key[31] ^= flipped;
        for (byte, of_trip) in key.iter_mut().zip(ids.trip.to_le_bytes()) {
            *byte ^= of_trip;
        }
        generator = ChaCha8Rng::from_seed(key);
    }
    generator.set_stream(ids.id.wrapping_mul(64).wrapping_add(stream as u64));
    generator
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_of_cycles_and_factors_differ_and_repeat() {
        let first = |seed, id, stream| Draws::new(seed, id, stream).uniform();
        let a = first(1, 2, Stream::Curve);
        assert!(a == first(1, 2, Stream::Curve));
        assert!(a != first(1, 2, Stream::Wind));
        assert!(a != first(1, 3, Stream::Curve));
        assert!(a != first(2, 2, Stream::Curve));
    }

    #[test]
    fn freezing_a_factor_takes_it_from_cycle_zero_and_leaves_the_others() {
        let frozen = Streams { frozen: &[Factor::Road], ..Streams::new(1, 5) };
        let free = Streams::new(1, 5);
        assert!(frozen.open(Stream::Curve).uniform() == Draws::new(1, 0, Stream::Curve).uniform());
        assert!(frozen.open(Stream::Wind).uniform() == free.open(Stream::Wind).uniform());
    }

    #[test]
    fn what_a_fit_does_not_know_varies_between_replicates_of_a_frozen_driver() {
        let first = |cycle_id, frozen| {
            let streams = Streams { frozen, ..Streams::new(1, cycle_id) };
            streams.open_replicate(Stream::CurveSpeedParameters, 64).uniform()
        };
        let driver = &[Factor::Driver];
        assert_ne!(first(0, driver), first(1, driver));
        assert_eq!(first(1, driver), first(65, driver));
        assert_eq!(first(1, driver), first(1, &[]));
    }

    #[test]
    fn the_list_of_streams_is_in_the_order_of_their_numbers() {
        for (number, stream) in Stream::ALL.into_iter().enumerate() {
            assert_eq!(stream as usize, number);
        }
    }

    #[test]
    fn a_picked_stream_is_that_of_the_second_sample_and_the_others_stay() {
        let streams = StreamSet::of_factor(Factor::Driver);
        let own =
            Streams { pick_freeze: PickFreeze { streams, cycle_id: None }, ..Streams::new(1, 5) };
        let other = Streams {
            pick_freeze: PickFreeze { streams, cycle_id: Some(9) },
            ..Streams::new(1, 5)
        };
        let first = |mut draws: Draws| draws.uniform();
        let plain = |stream| first(Streams::new(1, 5).open(stream));
        for stream in Stream::ALL {
            let (a, b) = (first(own.open(stream)), first(other.open(stream)));
            if stream.factor() == Some(Factor::Driver) {
                assert!(a == first(Draws::of_second_sample(1, 5, stream)) && a != plain(stream));
                assert!(b == first(Draws::of_second_sample(1, 9, stream)) && b != a);
            } else {
                assert!(a == plain(stream) && b == plain(stream), "{stream:?}");
            }
        }
        let frozen = Streams { frozen: &[Factor::Driver], ..own };
        assert!(
            first(frozen.open(Stream::Pedals)) == first(Draws::new(1, 0, Stream::Pedals)),
            "what is frozen does not vary"
        );
    }

    #[test]
    fn many_uniforms_at_once_are_those_that_come_one_by_one() {
        for (behind, count) in [(0, 64), (1, 64), (5, 130), (63, 1), (130, 7)] {
            let mut one_by_one = Draws::new(1, 2, Stream::Topography);
            // an odd number of words before, too
            one_by_one.generator.next_u32();
            (0..behind).for_each(|_| _ = one_by_one.uniform());
            let (mut at_once, mut values) = (one_by_one.clone(), vec![0.0; count]);
            at_once.uniforms(&mut values);
            let wanted: Vec<f64> = (0..count).map(|_| one_by_one.uniform()).collect();
            assert_eq!(values, wanted, "{count} behind {behind}");
            assert!(at_once.uniform() == one_by_one.uniform(), "{count} behind {behind}");
        }
    }

    #[test]
    fn draws_of_a_place_do_not_depend_on_what_was_drawn_before() {
        let mut draws = Draws::new(1, 2, Stream::Curve);
        let here = draws.at(700).uniform();
        let next = draws.at(701).uniform();
        assert!(here != next);
        assert!(draws.at(700).uniform() == here);
        // place 0 is the beginning, and 8 uniforms fill a place
        let mut plain = Draws::new(1, 2, Stream::Curve);
        assert!(plain.clone().uniform() == draws.at(0).uniform());
        for _ in 0..8 {
            plain.uniform();
        }
        assert!(plain.uniform() == draws.at(1).uniform());
    }

    #[test]
    fn index_follows_the_weights() {
        let mut draws = Draws::new(1, 0, Stream::Payload);
        let mut counts = [0.0; 3];
        for _ in 0..30_000 {
            counts[draws.index(&[1.0, 0.0, 3.0])] += 1.0;
        }
        assert!(counts[1] == 0.0);
        // 4 standard errors of a proportion of 0.25 over 30,000 draws
        assert!(
            (counts[0] / 30_000.0_f64 - 0.25).abs() < 4.0 * (0.25_f64 * 0.75 / 30_000.0).sqrt()
        );
    }
}
