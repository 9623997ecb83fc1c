//! Judged numbers of a study from the totals of a fleet's trips: an emulator of simulated fleets,
//! and the numbers that are most probable with it (Laplace's approximation).
//!
//! Members of a design are fleets whose judged numbers have scores z; their trips are regressed on
//! what a table knows of a trip and on z ([`Emulator`]). The rows of a table then have a
//! likelihood, z has the prior N(0, 1), and the discrepancy between any study and a real fleet has
//! one, too ([`Posterior`]). Emulators of simulations with a discrepancy: M. C. Kennedy, A.
//! O'Hagan, Bayesian calibration of computer models, Journal of the Royal Statistical Society B 63
//! (2001) \[PK\].

mod breaks;
mod emulator;
mod posterior;
mod ridge;

pub use breaks::sign_of_breaks;
pub use emulator::{Emulator, Known};
pub use posterior::{Posterior, Shared, expected, posterior};
pub use ridge::MemberEmulator;

/// Responses of a trip, in the order in which one is given those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Response {
    /// ln of the climb over the distance.
    Climb,
    /// ln of the speed.
    Speed,
    /// ln of the consumption.
    Consumption,
}

impl Response {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Climb, Self::Speed, Self::Consumption];

    /// Smallest SD of what a real fleet differs by from every study, of ln: 1 % in consumption and
    /// 2 % in speed (judgement); of climbs, which maps and barometers count in ways of their own,
    /// 10 % (judgement).
    pub fn least_discrepancy(self) -> f64 {
        match self {
            Self::Climb => 0.1,
            Self::Speed => 0.02,
            Self::Consumption => 0.01,
        }
    }
}

/// A trip, simulated or of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct TotalsRow {
    /// Gross weight, in kg.
    pub gross_kg: f64,
    /// Length, in m.
    pub length_m: f64,
    /// The responses, in the order of [`Response::ALL`]; NaN where one is not known.
    pub responses: [f64; 3],
    /// Trips that it holds, in the mean: above 1 of a way between two fills.
    pub trips: f64,
}

/// A simulated fleet.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Scores of its judged numbers.
    pub scores: Vec<f64>,
    /// Its trips.
    pub trips: Vec<TotalsRow>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use ocmc_core::random::{Draws, Stream};

    const NOISE: f64 = 0.1;

    /// A trip of a model that is linear in the scores: the third does nothing.
    fn trip(scores: &[f64], draws: &mut Draws) -> TotalsRow {
        let (g, e, f) = (draws.normal(), draws.normal(), draws.normal());
        let speed = 3.0 + 0.05 * scores[1] + 0.1 * f;
        let ln = 3.4 + 0.2 * g + 0.06 * scores[0] + 0.03 * g * scores[1] + NOISE * e;
        TotalsRow {
            gross_kg: 25e3 + 8e3 * g,
            length_m: 1e5,
            responses: [f64::NAN, speed, ln],
            trips: 1.0,
        }
    }

    fn members() -> Vec<Member> {
        let member = |m: u64| {
            let mut draws = Draws::new(1, m, Stream::Calibration);
            let scores: Vec<f64> = (0..3).map(|_| draws.uniform_between(-2.0, 2.0)).collect();
            let trips = (0..100).map(|_| trip(&scores, &mut draws)).collect();
            Member { scores, trips }
        };
        (0..80).map(member).collect()
    }

    fn fitted(responses: &[Response]) -> Emulator {
        let known = Known { gross: true, responses: responses.to_vec() };
        Emulator::fit(&members(), &known).unwrap()
    }

    fn rows(truth: &[f64], seed: u64) -> Vec<TotalsRow> {
        let mut draws = Draws::new(seed, 0, Stream::Calibration);
        (0..100).map(|_| trip(truth, &mut draws)).collect()
    }

    fn found(emulator: &Emulator, rows: &[TotalsRow], weight: f64) -> Posterior {
        let shared = Shared { discrepancies: emulator.discrepancies(), weight };
        posterior(emulator, rows, &shared, 3)
    }

    #[test]
    fn scores_come_back_within_their_errors_and_what_does_nothing_keeps_its_prior() {
        let emulator = fitted(&[Response::Speed, Response::Consumption]);
        let truth = [1.0, -1.0, 1.5];
        for seed in 101..104 {
            let posterior = found(&emulator, &rows(&truth, seed), 1.0);
            let sd: Vec<f64> = (0..3).map(|k| posterior.covariance[(k, k)].sqrt()).collect();
            for k in 0..2 {
                let off = (posterior.scores[k] - truth[k]) / sd[k];
                assert!(off.abs() < 3.0 && sd[k] < 0.6, "{seed} {k}: {off} of {sd:?}");
            }
            // what moves it is the noise that its small rest of information has: √(1 − 0.97²) =
            // 0.24
            assert!(
                posterior.scores[2].abs() < 0.6 && sd[2] > 0.95,
                "{:?} {sd:?}",
                posterior.scores
            );
        }
    }

    #[test]
    fn errors_are_those_of_the_linear_model_in_closed_form() {
        // the mean of n rows has the variance σ²/n beside the shift's d²; a score moves it by 0.06:
        // 1/(1 + 0.06²/(σ²/n + d²)), where nothing else is asked of the rows
        let emulator = fitted(&[Response::Consumption]);
        let rows = rows(&[0.5, 0.0, 0.0], 104);
        for weight in [1.0, 0.25] {
            let posterior = found(&emulator, &rows, weight);
            let d = emulator.discrepancies()[0];
            let of_mean = NOISE * NOISE / (weight * rows.len() as f64) + d * d;
            let expected = 1.0 / (1.0 + 0.06 * 0.06 / of_mean);
            let variance = posterior.covariance[(0, 0)];
            assert!((variance / expected - 1.0).abs() < 0.15, "{weight}: {variance} {expected}");
        }
    }

    #[test]
    fn moved_scores_give_the_numbers_asked_for_by_the_nearest_way() {
        // by hand: covariance diag(4, 1), the same slopes: a step is shared as 4 to 1
        let covariance = DMatrix::from_diagonal(&DVector::from_vec(vec![4.0, 1.0, 9.0]));
        let (shifts, residuals) = (Vec::new(), Vec::new());
        let posterior = Posterior { scores: vec![0.0; 3], covariance, shifts, residuals };
        let scores: Vec<Vec<f64>> = members().into_iter().map(|member| member.scores).collect();
        let sums: Vec<f64> = scores.iter().map(|s| s.iter().sum()).collect();
        let number = [MemberEmulator::fit(&scores, &sums)];
        let from = [0.5, 0.0, 0.25];
        let moved = posterior.moved(&from, &number, &[5.0], &[0.0], |k| k < 2);
        let gained = number[0].at(&moved).0 - number[0].at(&from).0;
        assert!((gained - 5.0).abs() < 1e-9 && moved[2] == from[2], "{moved:?}");
        let shared = (moved[0] - from[0]) / (moved[1] - from[1]);
        assert!((shared - 4.0).abs() < 0.2, "{shared}");
        assert_eq!(posterior.moved(&from, &number, &[5.0], &[0.0], |_| false), from);
        // as far off as the spread of the number, 4 + 1: half of the way
        let halfway = posterior.moved(&from, &number, &[5.0], &[libm::sqrt(5.0)], |k| k < 2);
        let gained = number[0].at(&halfway).0 - number[0].at(&from).0;
        assert!((gained - 2.5).abs() < 0.2, "{gained}");
    }

    #[test]
    fn one_row_in_twenty_that_is_two_trips_moves_little() {
        let emulator = fitted(&[Response::Consumption]);
        let clean = rows(&[0.0, 0.0, 0.0], 105);
        let mut spoilt = clean.clone();
        for row in spoilt.iter_mut().step_by(20) {
            row.responses[2] += std::f64::consts::LN_2;
        }
        let (clean, spoilt) = (found(&emulator, &clean, 1.0), found(&emulator, &spoilt, 1.0));
        // five rows at 2.5 SDs of 0.1 move the mean by 1.3 %, a score of 0.06 by 0.22, and the
        // score of the slope beside it; at ln 2 they would move it by 0.58
        let moved = (clean.scores[0] - spoilt.scores[0]).abs();
        assert!(moved < 0.4, "{moved}");
        let far = spoilt.residuals.iter().filter(|r| r[0] > 4.0).count();
        assert!((4..=6).contains(&far), "{far}");
    }

    #[test]
    fn more_that_is_known_leaves_smaller_errors() {
        let (few, more) =
            (fitted(&[Response::Consumption]), fitted(&[Response::Speed, Response::Consumption]));
        let rows = rows(&[0.0; 3], 106);
        let sd = |emulator: &Emulator| {
            let shared = Shared { discrepancies: emulator.discrepancies(), weight: 1.0 };
            expected(emulator, &rows, &shared, &[0.0; 3]).covariance[(1, 1)].sqrt()
        };
        assert!(sd(&more) < 0.8 * sd(&few), "{} {}", sd(&more), sd(&few));
    }
}
