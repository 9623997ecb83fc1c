//! The least energy on a level road from one speed to the same speed, in the time that this speed
//! takes: what a closed form knows. An engine whose fuel is affine in power does best at constant
//! speed; another one may do better by turns of pulse and glide.

use super::driven::{DrivenLeg, Heights};
use super::grid::{Fineness, Place};
use super::moves::Truck;
use super::solve::{FROM_NOTHING, PRICES, Problem, Question};
use ocmc_core::powertrain::{GearOrder, InversePowertrain};
use ocmc_core::prescribed::Body;
use std::sync::atomic::AtomicBool;

/// Assumed price of a joule for the speed of a new gear, in J of the source.
const JUMP_PRICE: f64 = 2.5;
/// Price of time, in W, as a range of multiples of the power at constant speed.
const PRICE_RANGE: [f64; 2] = [0.05, 20.0];

/// Energy on a level road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelRoad {
    /// At constant speed in the best gear, in J.
    pub constant_j: f64,
    /// The least that was found, in J.
    pub least_j: f64,
    /// Its duration, in s.
    pub time_s: f64,
}

/// The least for a level road of some length in m at a mean speed in m/s, at both ends of which
/// the truck has that speed, and in between at most another one; none where no gear holds it.
pub fn level_road(
    body: Body,
    inverse: &dyn InversePowertrain,
    length_m: f64,
    [speed_mps, most_mps]: [f64; 2],
    fineness: Fineness,
) -> Option<LevelRoad> {
    let truck = Truck::new(body, inverse, JUMP_PRICE);
    let pieces = libm::ceil(length_m / fineness.piece_m).max(2.0);
    let heights = Heights::level();
    let mut leg = DrivenLeg::begin();
    leg.speed_mps[0] = speed_mps;
    leg.push(length_m / speed_mps, speed_mps, GearOrder::Free);
    leg.road_m = [0.0, length_m];
    let place = |k: usize| Place {
        way_m: length_m * k as f64 / pieces,
        height_m: 0.0,
        most_mps,
        driven_mps: speed_mps,
        planned_mps: most_mps,
        limit_mps: most_mps,
        in_curve: false,
        section: 0,
    };
    let places: Vec<Place> = (0..=pieces as usize).map(place).collect();
    let gears = (0..truck.gears()).filter(|gear| truck.holds(*gear, speed_mps, false));
    let costs = gears.map(|gear| truck.steady_j(gear, speed_mps, length_m));
    let constant_j = costs.min_by(f64::total_cmp)?;
    let most_s = length_m / speed_mps;
    let legs = vec![Problem { leg: &leg, places: &places, free: vec![true; places.len()] }];
    let prices_w = PRICE_RANGE.map(|share| share * constant_j / most_s);
    let (truck, heights, stop) = (&truck, &heights, &AtomicBool::new(false));
    let stages = &FROM_NOTHING;
    let question = Question { truck, heights, legs, most_s, prices_w, stages, fineness, stop };
    let answer = question.answer::<PRICES>(None)?;
    Some(LevelRoad { constant_j, least_j: answer.energy_j(), time_s: answer.time_s() })
}
