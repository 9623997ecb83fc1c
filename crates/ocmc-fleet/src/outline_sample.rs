//! Expectations of the numbers of a run's cycles: outlines of the second sample, of the same study
//! and the same trips of its calendar ([`ocmc_core::study::outline`]).
//!
//! They come in batches that spread evenly, and batches are independent: their means tell how sure
//! the expectations are. Payload and road types are put in as they are known, and not as drawn.

use nalgebra::{DMatrix, DVector};
use ocmc_core::random::sampling::BATCH;
use ocmc_core::study::Study;
use rayon::prelude::*;

/// Fewest outlines, and most: 64 MB of them at most.
const FEWEST: u64 = 1 << 13;
const MOST: u64 = 1 << 17;
/// Outlines for each cycle of the run, between the two.
const FOR_EACH_CYCLE: u64 = 4;

/// Names of the numbers that are multiplied by the payload.
const SHARE: &str = "_share";

/// Outlines of the second sample, as terms of a regression.
#[derive(Clone, Debug)]
pub(super) struct OutlineSample {
    /// Outlines as they are drawn, a row each.
    pub(super) drawn: Vec<Vec<f64>>,
    /// The same, with what is known in place of what was drawn.
    known: Vec<Vec<f64>>,
}

/// The terms of a regression on outlines: their numbers around the expected ones, the shares of
/// road types times the payload among them.
#[derive(Clone, Debug)]
pub(super) struct Terms {
    /// A number, or two of them multiplied.
    places: Vec<(usize, Option<usize>)>,
    centre: Vec<f64>,
    scale: Vec<f64>,
    /// Expectations of the terms, which are zero but for products.
    expected: Vec<f64>,
}

/// Outlines that a run of so many cycles is adjusted by.
pub(super) fn outlines_for(cycles: u64) -> u64 {
    (FOR_EACH_CYCLE * cycles).next_power_of_two().clamp(FEWEST, MOST)
}

impl OutlineSample {
    /// Draws so many, evenly over the trips of a truck.
    pub(super) fn draw(study: &Study, seed: u64, count: u64) -> Self {
        let batches = count / BATCH;
        let trips = study.nesting().trips_per_truck;
        let batch = |b: u64| {
            let trip = u128::from(2 * b + 1) * u128::from(trips) / u128::from(2 * batches);
            study.outlines_of_second_sample(seed, b, trip as u64)
        };
        let drawn: Vec<Vec<f64>> = (0..batches).into_par_iter().flat_map_iter(batch).collect();
        let expectation = study.outline_expectation();
        let mut known = drawn.clone();
        for outline in &mut known {
            expectation.put_into(outline);
        }
        Self { drawn, known }
    }

    /// Outlines that a test has made up.
    #[cfg(test)]
    pub(super) fn of(drawn: Vec<Vec<f64>>) -> Self {
        Self { known: drawn.clone(), drawn }
    }

    /// How many there are.
    pub(super) fn len(&self) -> u64 {
        self.drawn.len() as u64
    }

    /// The first terms of outlines, the most telling ones first, as many as are allowed: those that
    /// differ between the rows of a run. None where nothing does.
    pub(super) fn terms(&self, names: &[String], rows: &[Vec<f64>], most: usize) -> Option<Terms> {
        let n = rows.len() as f64;
        let numbers = names.len();
        let mean = |rows: &[Vec<f64>], k: usize| {
            rows.iter().map(|row| row[k]).sum::<f64>() / rows.len() as f64
        };
        let centre: Vec<f64> = (0..numbers).map(|k| mean(&self.known, k)).collect();
        let scale_of = |k: usize| {
            let squares = rows.iter().map(|row| (row[k] - centre[k]) * (row[k] - centre[k]));
            libm::sqrt(squares.sum::<f64>() / n)
        };
        let scale: Vec<f64> = (0..numbers).map(scale_of).collect();
        let varies = |k: &usize| scale[*k] > VARIES * libm::fabs(centre[*k]);
        let shares: Vec<usize> =
            (0..numbers).filter(|k| names[*k].ends_with(SHARE)).filter(varies).collect();
        let payload = [0].into_iter().filter(varies);
        let others = (1..numbers).filter(|k| !names[*k].ends_with(SHARE)).filter(varies);
        let single = |k: usize| (k, None);
        let mut places: Vec<(usize, Option<usize>)> = payload.clone().map(single).collect();
        places.extend(shares.iter().copied().map(single));
        places.extend(payload.flat_map(|p| shares.iter().map(move |k| (p, Some(*k)))));
        places.extend(others.map(single));
        places.truncate(most);
        let mut terms = Terms { expected: vec![0.0; places.len()], places, centre, scale };
        let count = self.known.len() as f64;
        let mut sums = vec![0.0; terms.len()];
        for outline in &self.known {
            for (sum, term) in sums.iter_mut().zip(terms.of(outline)) {
                *sum += term;
            }
        }
        terms.expected = sums.into_iter().map(|sum| sum / count).collect();
        (terms.len() > 0).then_some(terms)
    }

    /// Means over each batch of what the coefficients, the constant first, make of the terms.
    pub(super) fn means_of_batches(&self, terms: &Terms, beta: &DVector<f64>) -> Vec<f64> {
        let predict = |outline: &Vec<f64>| {
            let terms = terms.of(outline);
            terms.iter().zip(beta.iter().skip(1)).map(|(z, b)| z * b).sum::<f64>()
        };
        let batches = self.known.chunks_exact(BATCH as usize);
        batches.map(|batch| batch.iter().map(predict).sum::<f64>() / BATCH as f64).collect()
    }

    /// Covariance of the errors of the terms' expectations.
    pub(super) fn error(&self, terms: &Terms) -> DMatrix<f64> {
        let p = terms.len();
        let batches = self.known.chunks_exact(BATCH as usize);
        let count = batches.len() as f64;
        let mut sum = DMatrix::zeros(p, p);
        for batch in batches {
            let mut mean = DVector::zeros(p);
            for outline in batch {
                mean += DVector::from_vec(terms.of(outline)) / BATCH as f64;
            }
            sum.syger(1.0, &mean, &mean, 1.0);
        }
        sum.fill_upper_triangle_with_lower_triangle();
        sum / (count * (count - 1.0).max(1.0))
    }
}

/// Standard deviation, relative to the mean, above which a number varies.
const VARIES: f64 = 1e-9;

impl Terms {
    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    /// The terms of an outline, each less its expectation.
    pub(super) fn of(&self, outline: &[f64]) -> Vec<f64> {
        let score = |k: usize| (outline[k] - self.centre[k]) / self.scale[k];
        let term = |(a, b): &(usize, Option<usize>)| score(*a) * b.map_or(1.0, score);
        let terms = self.places.iter().map(term);
        terms.zip(&self.expected).map(|(term, expected)| term - expected).collect()
    }
}
