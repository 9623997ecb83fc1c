//! Where a driver's potential lies: in his gears, and in his speed near stops, in curves, at
//! limits, on hills and elsewhere.
//!
//! First his gears alone are chosen anew, at his speed. Then, beside the gears, his speed is freed
//! inside the stretches of one kind alone. A second that this takes or saves has the price at which
//! the optimum trades time between all stretches. What is won so does not add up to the whole,
//! because a stretch that begins and ends at his speed is less free than one beside other free
//! ones: the remainder is shown. What is freed is searched for between and around his own speed and
//! the optimum's.

use super::grid::points;
use super::moves::Truck;
use super::solve::Track;
use super::{Bound, Figure, Trip};
use ocmc_core::event_kind::{Kind, kinds};

/// How a driver's energy falls short of the optimum, in J of tank or battery.
#[derive(Clone, Debug, PartialEq)]
pub struct Potential {
    /// All of it.
    pub total_j: f64,
    /// By other gears at his speed; 0 where there are none to order.
    pub gears_j: f64,
    /// By another speed in the stretches of each kind.
    pub by_kind_j: [f64; Kind::ALL.len()],
    /// The rest of the whole.
    pub remainder_j: f64,
    /// All of it by road type, in the order of the study.
    pub by_road_type_j: Vec<f64>,
    /// Length of the stretches of each kind, in m.
    pub length_m: [f64; Kind::ALL.len()],
}

impl Trip<'_> {
    /// Takes a bound apart; `best`: the tracks of its optimum.
    pub(super) fn potential(&self, bound: &Bound, best: Option<Vec<Track>>) -> Potential {
        let price = bound.driver.source_j / bound.driver.wheel_j.max(1.0);
        let inverse = (self.fresh)();
        let truck = Truck::new(self.body, &*inverse, price);
        let power_w = bound.driver.energy_j / bound.driver.duration_s;
        let price_w = bound.price_w.unwrap_or(power_w);
        let legs: Vec<Vec<Kind>> =
            self.places.iter().map(|places| kinds(&points(places))).collect();
        // a place is free between two pieces of the kind
        let free = |kind: Option<Kind>| -> Vec<Vec<bool>> {
            let is = |piece: Option<&Kind>| kind.is_some() && piece.copied() == kind;
            let interior = |kinds: &Vec<Kind>| {
                let inside = |k: usize| k > 0 && is(kinds.get(k - 1)) && is(kinds.get(k));
                (0..=kinds.len()).map(inside).collect()
            };
            legs.iter().map(interior).collect()
        };
        let taken = |free: Vec<Vec<bool>>, around: Option<Vec<[Track; 2]>>| {
            let prices_w = [price_w; 2];
            let answer = self.answer::<1>(&truck, f64::INFINITY, prices_w, free, around)?;
            let ways = self.legs_of(&answer, &truck);
            let mut figure = self.figure(&self.driven.cycle_of(&ways, &self.heights), &ways);
            figure.pay(price);
            Some((figure, answer.tracks(&self.places)))
        };
        let mut length_m = [0.0; Kind::ALL.len()];
        for (kinds, places) in legs.iter().zip(&self.places) {
            for (kind, pair) in kinds.iter().zip(places.windows(2)) {
                length_m[*kind as usize] += pair[1].way_m - pair[0].way_m;
            }
        }
        let total_j = bound.driver.energy_j - bound.optimum.energy_j;
        let mut gears_j = 0.0;
        let mut by_kind_j = [0.0; Kind::ALL.len()];
        if let Some((gears, tracks)) = taken(free(None), None) {
            let around: Option<Vec<[Track; 2]>> =
                best.map(|best| tracks.into_iter().zip(best).map(<[Track; 2]>::from).collect());
            let saved_j = |from: &Figure, to: &Figure| {
                from.energy_j - to.energy_j + price_w * (from.duration_s - to.duration_s)
            };
            gears_j = saved_j(&bound.driver, &gears);
            for (kind, by_kind_j) in Kind::ALL.iter().zip(&mut by_kind_j) {
                if let Some((freed, _)) = taken(free(Some(*kind)), around.clone()) {
                    *by_kind_j = saved_j(&gears, &freed);
                }
            }
        }
        let remainder_j = total_j - gears_j - by_kind_j.iter().sum::<f64>();
        let by_type = bound.driver.by_road_type_j.iter().zip(&bound.optimum.by_road_type_j);
        let by_road_type_j = by_type.map(|(driver, optimum)| driver - optimum).collect();
        Potential { total_j, gears_j, by_kind_j, remainder_j, by_road_type_j, length_m }
    }
}
