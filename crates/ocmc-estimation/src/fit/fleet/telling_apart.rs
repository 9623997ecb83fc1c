//! How many trips it takes to tell two trucks, or two drivers, apart.
//!
//! The means of m trips each differ by δ plus an error of variance 2 (σ_o²/k + σ²/m): σ is the SD
//! of a trip, σ_o that of what else differs between the two, such as drivers of which each truck
//! has k. The test is two-sided and normal with known variances, so that its power is Φ(δ/s − z) +
//! Φ(−δ/s − z), s² that variance. Where 2 σ_o²/k alone is too much no number of trips is enough:
//! more drivers are needed, not more trips.
//!
//! Source: J. Cohen, Statistical Power Analysis for the Behavioral Sciences (1988), chapter 2
//! \[PK\]; the floor by σ_o \[D\].

use super::trips::{FleetDesign, Trips};
use super::{FleetOptions, components::Components};
use crate::fit::p_value::normal_probability;
use ocmc_core::special_functions::normal_quantile;
use serde::Serialize;

/// Trips that tell two members of a level apart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TellingApart {
    /// `truck`, `driver` or `truck_and_driver`.
    pub level: &'static str,
    /// Levels that the two do not share beside themselves: `nothing`, or so many drivers or trucks
    /// each.
    pub apart: &'static str,
    /// How many of these each has; 0 of nothing.
    pub others: usize,
    /// The difference.
    pub difference: f64,
    /// Variance of the difference of both means that trips do not lower.
    pub floor_variance: f64,
    /// Variance of a trip.
    pub trip_variance: f64,
    /// Trips of each of the two; none where no number is enough.
    pub trips: Option<u64>,
    /// Power with so many trips.
    pub power: Option<f64>,
    /// Trips of a member in the records, in the mean.
    pub trips_in_records: f64,
    /// The difference that so many tell apart; none where there is none.
    pub difference_in_records: f64,
}

/// The power of a two-sided test at `significance` of a difference whose estimate has this
/// variance.
pub fn power_of(difference: f64, variance: f64, significance: f64) -> f64 {
    let z = -normal_quantile(0.5 * significance);
    let size = difference.abs() / libm::sqrt(variance);
    normal_probability(size - z) + normal_probability(-size - z)
}

/// The difference that has this power, where the estimate has this variance.
pub fn difference_with(variance: f64, power: f64, significance: f64) -> f64 {
    (normal_quantile(power) - normal_quantile(0.5 * significance)) * libm::sqrt(variance)
}

/// The trips of each of two members for a power; none where no number is enough. The estimate of
/// the difference has the variance `floor_variance` + 2 `trip_variance`/trips.
pub fn trips_to_tell(
    difference: f64,
    floor_variance: f64,
    trip_variance: f64,
    power: f64,
    significance: f64,
) -> Option<u64> {
    let factor = difference_with(1.0, power, significance);
    let allowed = difference * difference / (factor * factor) - floor_variance;
    let trips = libm::ceil(2.0 * trip_variance / allowed).max(1.0);
    (allowed > 0.0 && trips < 1e15).then_some(trips as u64)
}

/// The questions that the records allow.
pub(crate) fn telling_apart(
    trips: &Trips,
    components: &Components,
    mean: f64,
    options: &FleetOptions,
) -> Vec<TellingApart> {
    let [truck, driver, trip] = components.sd;
    let difference = options.differ * mean.abs();
    let ask = |level: &'static str, family: usize, apart, others: usize, other_sd: f64| {
        let floor = if others == 0 { 0.0 } else { 2.0 * other_sd * other_sd / others as f64 };
        let variance = trip * trip;
        let needed =
            trips_to_tell(difference, floor, variance, options.power, options.significance);
        let in_records = trips.n as f64 / trips.families[family].len() as f64;
        let variance_of = |trips: f64| floor + 2.0 * variance / trips;
        TellingApart {
            level,
            apart,
            others,
            difference,
            floor_variance: floor,
            trip_variance: variance,
            trips: needed,
            power: needed
                .map(|n| power_of(difference, variance_of(n as f64), options.significance)),
            trips_in_records: in_records,
            difference_in_records: difference_with(
                variance_of(in_records),
                options.power,
                options.significance,
            ),
        }
    };
    let mean_of = |family: usize| {
        let per = trips.pairs as f64 / trips.families[family].len() as f64;
        (libm::round(per) as usize).max(1)
    };
    match trips.design {
        FleetDesign::TrucksOnly => vec![ask("truck", 0, "nothing", 0, 0.0)],
        FleetDesign::TruckAndDriver => vec![ask("truck_and_driver", 0, "nothing", 0, 0.0)],
        _ => vec![
            ask("truck", 0, "nothing", 0, 0.0),
            ask("truck", 0, "drivers", mean_of(0), driver),
            ask("driver", 1, "nothing", 0, 0.0),
            ask("driver", 1, "trucks", mean_of(1), truck),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    const TESTS: u64 = 4000;

    #[test]
    fn the_textbooks_sixteen() {
        // 2 (z.975 + z.8)² = 15.698: two groups that differ by an SD need 16 each
        assert_eq!(trips_to_tell(1.0, 0.0, 1.0, 0.8, 0.05), Some(16));
        assert_eq!(trips_to_tell(0.5, 0.0, 1.0, 0.8, 0.05), Some(63));
        assert!((difference_with(1.0, 0.8, 0.05) - 2.801_585).abs() < 1e-6);
        // drivers that differ by more than the trucks do: never
        assert_eq!(trips_to_tell(1.0, 0.2, 1.0, 0.8, 0.05), None);
        assert_eq!(trips_to_tell(0.0, 0.0, 1.0, 0.8, 0.05), None);
        assert!(trips_to_tell(1.0, 0.05, 1.0, 0.8, 0.05) > Some(16));
        assert!((power_of(0.0, 1.0, 0.05) - 0.05).abs() < 1e-12);
    }

    #[test]
    fn simulated_tests_have_the_power() {
        // trucks 0.3 apart; trips with an SD of 1, drivers of 0.08, two to a truck
        let floor = 2.0 * 0.08 * 0.08 / 2.0;
        let trips = trips_to_tell(0.3, floor, 1.0, 0.8, 0.05).unwrap();
        let variance = floor + 2.0 / trips as f64;
        let power = power_of(0.3, variance, 0.05);
        assert!((0.8..0.81).contains(&power), "{trips} {power}");
        let mut significant = 0;
        for test in 0..TESTS {
            let mut draws = Draws::new(3, test, Stream::Bootstrap);
            let mut mean = |level: f64| {
                let drivers = [0.08 * draws.normal(), 0.08 * draws.normal()];
                let half = trips / 2;
                let sum = |driver: f64, n: u64, draws: &mut Draws| {
                    (0..n).map(|_| level + driver + draws.normal()).sum::<f64>()
                };
                (sum(drivers[0], half, &mut draws) + sum(drivers[1], trips - half, &mut draws))
                    / trips as f64
            };
            let difference = mean(0.3) - mean(0.0);
            significant += u32::from(difference.abs() > 1.959_964 * variance.sqrt());
        }
        let error = (power * (1.0 - power) / TESTS as f64).sqrt();
        let share = f64::from(significant) / TESTS as f64;
        assert!((share - power).abs() < 4.0 * error, "{share} {power}");
    }
}
