//! The simulated trips of one road, and the scores of measured drives among them.

use super::passage::{Passage, Places};
use super::score::{Sample, Score, covers};
use ocmc_core::random::{Draws, Stream};
use serde::{Serialize, Serializer};

/// Levels of the bands over the way.
pub const LEVELS: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];
/// Bins of a histogram of ranks.
pub const BINS: usize = 10;
/// Places over which the speed counts as one value for a person, fewest.
const FEWEST_PLACES: usize = 2;

/// Quantity that is compared once a trip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Time between the first and the last place, in s.
    Duration,
    /// The same without standstills, in s.
    Moving,
    /// Standstill, in s.
    Standstill,
    /// Number of standstills.
    Stops,
    /// Speed at a place that is drawn for each trip, in m/s.
    SpeedAtAPlace,
    /// Fuel in kg, or energy of the battery in J.
    Energy,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Duration,
        Self::Moving,
        Self::Standstill,
        Self::Stops,
        Self::SpeedAtAPlace,
        Self::Energy,
    ];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Duration => "duration",
            Self::Moving => "moving",
            Self::Standstill => "standstill",
            Self::Stops => "stops",
            Self::SpeedAtAPlace => "speed_at_a_place",
            Self::Energy => "energy",
        }
    }
}

/// The simulated trips of one road.
#[derive(Clone, Debug)]
pub struct Ensemble {
    places: Places,
    trips: Vec<Passage>,
    /// Speeds at each place; none where too few trips reach it.
    speeds: Vec<Option<Sample>>,
}

/// A measured drive on the road of an ensemble.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Name of the quantity.
    pub name: String,
    /// Over the places of the road.
    pub passage: Passage,
    /// The part of the road that is scored, in m.
    pub part_m: [f64; 2],
    /// Seed and number of the drive: with them the draws of its scores are fixed.
    pub draw: (u64, u64),
}

/// The speed of a drive over all places.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SpeedScore {
    /// Number of places.
    pub places: usize,
    /// Mean of simulated mean less measured, in m/s.
    pub mean_error_mps: f64,
    /// Root of the mean square of that, in m/s.
    pub rmse_mps: f64,
    /// Mean continuous ranked probability score, in m/s.
    pub crps_mps: f64,
    /// Share of the places at which the band of half of the trips covers the drive.
    pub coverage50: f64,
    /// Share of the places at which the band of 90 % of the trips covers it.
    pub coverage90: f64,
    /// Ranks at all places, in tenths.
    pub pit: [u64; BINS],
}

/// The scores of one drive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriveScore {
    /// Name of the drive.
    pub drive: String,
    /// From where it is scored, in m.
    pub from_m: f64,
    /// To where, in m.
    pub to_m: f64,
    /// The speed over the way.
    pub speed: SpeedScore,
    /// The place of the speed that is scored once, in m.
    pub place_m: f64,
    /// One value a trip, by quantity.
    #[serde(serialize_with = "by_name")]
    pub values: Vec<(Quantity, Score)>,
}

impl DriveScore {
    /// The score of a quantity.
    pub fn value(&self, quantity: Quantity) -> Option<&Score> {
        self.values.iter().find(|(known, _)| *known == quantity).map(|(_, score)| score)
    }
}

impl Ensemble {
    /// Ensemble of trips over the places of one road.
    pub fn new(places: Places, trips: Vec<Passage>) -> Self {
        let at = |place: usize| Sample::new(trips.iter().map(|t| f64::from(t.speed_mps[place])));
        let speeds = (0..places.count).map(at).collect();
        Self { places, trips, speeds }
    }

    /// Number of trips.
    pub fn size(&self) -> usize {
        self.trips.len()
    }

    /// The places.
    pub fn places(&self) -> Places {
        self.places
    }

    /// Speeds at the levels of the bands, at each place, in m/s; NaN where no trip comes.
    pub fn bands(&self) -> Vec<[f64; LEVELS.len()]> {
        let quantiles = |sample: &Option<Sample>| {
            LEVELS.map(|level| sample.as_ref().map_or(f64::NAN, |sample| sample.quantile(level)))
        };
        self.speeds.iter().map(quantiles).collect()
    }

    /// Scores a drive; none where fewer than two places of its part are passed by it and the trips.
    pub fn score(&self, drive: &Measured) -> Option<DriveScore> {
        let Measured { name, passage, part_m, draw } = drive;
        let mut draws = Draws::of_second_sample(draw.0, draw.1, Stream::Route);
        let passed = |place: &usize| passage.speed_mps[*place].is_finite();
        let places: Vec<usize> = self.places.within(part_m[0], part_m[1]).filter(passed).collect();
        let (&first, &last) = (places.first()?, places.last()?);
        let mut speed = SpeedScore::default();
        let (mut errors, mut squares, mut crps, mut covered) = (0.0, 0.0, 0.0, [0.0, 0.0]);
        for &place in &places {
            let Some(sample) = &self.speeds[place] else { continue };
            let measured = f64::from(passage.speed_mps[place]);
            let error = sample.mean() - measured;
            let pit = sample.pit(measured, draws.uniform());
            speed.places += 1;
            errors += error;
            squares += error * error;
            crps += sample.crps(measured);
            for (covered, share) in covered.iter_mut().zip([0.5, 0.9]) {
                *covered += f64::from(u8::from(covers(share, pit)));
            }
            speed.pit[bin(pit)] += 1;
        }
        if speed.places < FEWEST_PLACES || first == last {
            return None;
        }
        let n = speed.places as f64;
        let mean = |sum: f64| sum / n;
        (speed.mean_error_mps, speed.rmse_mps) = (mean(errors), mean(squares).sqrt());
        (speed.crps_mps, speed.coverage50) = (mean(crps), mean(covered[0]));
        speed.coverage90 = mean(covered[1]);
        let drawn =
            places[((draws.uniform() * places.len() as f64) as usize).min(places.len() - 1)];
        let (from_m, to_m) = (self.places.at(first), self.places.at(last));
        let mut values = Vec::new();
        for quantity in Quantity::ALL {
            let value_of = |trip: &Passage| match quantity {
                Quantity::Duration => trip.duration_s(first, last),
                Quantity::Moving => trip.duration_s(first, last) - trip.stood(from_m, to_m).1,
                Quantity::Standstill => trip.stood(from_m, to_m).1,
                Quantity::Stops => trip.stood(from_m, to_m).0,
                Quantity::SpeedAtAPlace => f64::from(trip.speed_mps[drawn]),
                Quantity::Energy => trip.energy(first, last),
            };
            let (measured, v) = (value_of(passage), draws.uniform());
            let sample = Sample::new(self.trips.iter().map(value_of));
            if let Some(sample) = sample.filter(|_| measured.is_finite()) {
                values.push((quantity, sample.score(measured, v)));
            }
        }
        let (drive, place_m) = (name.clone(), self.places.at(drawn));
        Some(DriveScore { drive, from_m, to_m, speed, place_m, values })
    }
}

/// Scores as an object, by the names of their quantities.
fn by_name<S: Serializer>(values: &[(Quantity, Score)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(values.iter().map(|(quantity, score)| (quantity.name(), score)))
}

/// The bin of a rank.
pub(super) fn bin(pit: f64) -> usize {
    ((pit * BINS as f64) as usize).min(BINS - 1)
}

#[cfg(test)]
mod tests {
    use super::super::passage::Rows;
    use super::*;

    /// A trip at an even speed over 2 km.
    fn trip(places: Places, speed_mps: f64, energy_per_m: f64) -> Passage {
        let way: Vec<f64> = (0..=200).map(|k| 10.0 * f64::from(k)).collect();
        let time: Vec<f64> = way.iter().map(|at_m| at_m / speed_mps).collect();
        let energy: Vec<f64> = way.iter().map(|at_m| at_m * energy_per_m).collect();
        let speed = vec![speed_mps; way.len()];
        let (time_s, position_m, speed_mps) = (&time[..], &way[..], &speed[..]);
        Passage::new(places, &Rows { time_s, position_m, speed_mps, energy: &energy }, Vec::new())
    }

    #[test]
    fn drives_of_the_population_are_covered_and_others_are_not() {
        let places = Places::of(2000.0);
        let mut draws = Draws::new(7, 0, Stream::Heading);
        let mut speed = || 20.0 + 2.0 * draws.normal();
        let trips = (0..500).map(|_| trip(places, speed(), 1e-4)).collect();
        let ensemble = Ensemble::new(places, trips);
        assert_eq!((ensemble.size(), ensemble.bands().len()), (500, 199));
        let scored = |speed_mps: f64, part_m, number| {
            let passage = trip(places, speed_mps, 1e-4);
            let name = "a".to_owned();
            ensemble.score(&Measured { name, passage, part_m, draw: (1, number) })
        };
        let all = [0.0, 2000.0];
        let typical = scored(20.0, all, 0).unwrap();
        assert_eq!((typical.speed.places, typical.from_m, typical.to_m), (199, 10.0, 1990.0));
        assert_eq!((typical.speed.coverage50, typical.speed.coverage90), (1.0, 1.0));
        let time = typical.value(Quantity::Duration).unwrap();
        assert!((time.measured - 99.0).abs() < 1e-3 && time.crps < 5.0, "{time:?}");
        let energy = typical.value(Quantity::Energy).unwrap();
        assert!((energy.measured - 0.198).abs() < 1e-6 && (energy.simulated - 0.198).abs() < 1e-6);
        let fast = scored(30.0, all, 1).unwrap();
        assert!(fast.speed.coverage90 == 0.0 && fast.speed.mean_error_mps < -9.0);
        assert!(fast.value(Quantity::Duration).unwrap().pit < 0.01);
        assert_eq!(fast.speed.pit[BINS - 1], 199);
        let part = scored(20.0, [500.0, 1000.0], 2).unwrap();
        assert_eq!((part.from_m, part.to_m), (500.0, 1000.0));
        assert!((500.0..=1000.0).contains(&part.place_m));
        assert!(scored(20.0, [1500.0, 1000.0], 3).is_none());
    }
}
