//! A fuel-cell system: hydrogen over net electric power.
//!
//! Between a point of its map and none at all the system can be switched on and off, and between
//! two points it can change to and fro: what it takes in the mean is the lower convex envelope of
//! its map, a maximum of straight lines. That is VECTO's splitting of time below the best point,
//! for the whole map. What pumps and compressors take is in the map.

use crate::distribution::Quantity;
use crate::energy::Carrier;
use crate::lanes::{Bounded, Lanes, one};
use crate::validation::{Problems, rises};
use fearless_simd::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Most points of a map.
const MOST_POINTS: usize = 16;

/// A fuel-cell system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CellModel {
    /// Net powers of the map, from 0 to the highest, in W.
    #[schemars(inner(range(min = 0.0, max = 5.0e6)))]
    pub map_power_w: Vec<f64>,
    /// Hydrogen taken there, by its heating value, in W.
    #[schemars(inner(range(min = 0.0, max = 2.0e7)))]
    pub map_hydrogen_w: Vec<f64>,
    /// Lower heating value of the hydrogen, in J/kg.
    #[schemars(range(min = 1.0e6, max = 2.0e8))]
    pub heating_value_jpkg: f64,
    /// Factor on the map: the spread between systems, and their age.
    #[schemars(range(min = 0.5, max = 2.0))]
    pub hydrogen_factor: Quantity,
}

impl CellModel {
    /// A map that rises from zero power and gives less than it takes.
    pub fn validate(&self, problems: &mut Problems) {
        let (powers, taken) = (&self.map_power_w, &self.map_hydrogen_w);
        let fits = rises(powers) && (2..=MOST_POINTS).contains(&powers.len());
        let from_zero = powers.first() == Some(&0.0);
        let allowed = "2 to 16 rising powers that begin with 0";
        problems.require(fits && from_zero, "map_power_w", format!("{powers:?}"), allowed);
        let same = powers.len() == taken.len();
        let gives_less = taken.iter().zip(powers).all(|(taken, power)| taken >= power);
        problems.require(
            same && rises(taken) && gives_less,
            "map_hydrogen_w",
            format!("{taken:?}"),
            "as many as map_power_w, rising, none below the power that it gives",
        );
        let range = Carrier::Hydrogen.declaration().heating_value_jpkg;
        let known =
            range.is_none_or(|[least, most]| (least..=most).contains(&self.heating_value_jpkg));
        let allowed = "1.19e8 to 1.21e8: the lower heating value of hydrogen";
        problems.require(known, "heating_value_jpkg", self.heating_value_jpkg, allowed);
    }
}

/// A system prepared for the hot loop.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Highest net power, in W.
    pub power_w: f64,
    /// Lines whose maximum is the hydrogen, as value at 0, in W, and slope.
    pub lines: Vec<[f64; 2]>,
    /// Hydrogen for each J of its heating value, in kg/J.
    pub kg_per_j: f64,
}

impl Cell {
    /// Prepares a checked model.
    pub fn new(model: &CellModel) -> Self {
        let points: Vec<[f64; 2]> =
            model.map_power_w.iter().zip(&model.map_hydrogen_w).map(|(p, h)| [*p, *h]).collect();
        let mut hull: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., before, last] = hull[..]
                && slope(before, point) <= slope(before, last)
            {
                hull.pop();
            }
            hull.push(point);
        }
        let line = |pair: &[[f64; 2]]| {
            let slope = slope(pair[0], pair[1]);
            [pair[0][1] - slope * pair[0][0], slope]
        };
        Self {
            power_w: hull.last().map_or(0.0, |last| last[0]),
            lines: hull.windows(2).map(line).collect(),
            kg_per_j: 1.0 / model.heating_value_jpkg,
        }
    }

    /// Hydrogen that net powers take, by its heating value, in W.
    #[inline(always)]
    pub fn hydrogens_w<S: Simd>(&self, power_w: Lanes<S>) -> Lanes<S> {
        let mut most = Lanes::splat(power_w.simd, 0.0);
        for [at_zero, slope] in &self.lines {
            most = most.at_least(power_w * *slope + *at_zero);
        }
        most
    }

    /// The same for one power.
    pub fn hydrogen_w(&self, power_w: f64) -> f64 {
        self.hydrogens_w(one(power_w))[0]
    }
}

fn slope(from: [f64; 2], to: [f64; 2]) -> f64 {
    (to[1] - from[1]) / (to[0] - from[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(powers: &[f64], taken: &[f64]) -> CellModel {
        CellModel {
            map_power_w: powers.to_vec(),
            map_hydrogen_w: taken.to_vec(),
            heating_value_jpkg: 120e6,
            hydrogen_factor: Quantity::Number(1.0),
        }
    }

    #[test]
    fn the_envelope_has_the_points_of_a_convex_map_and_lies_below_others() {
        let convex = Cell::new(&model(&[0.0, 60e3, 150e3, 300e3], &[0.0, 100e3, 290e3, 715e3]));
        for (power, taken) in [(0.0, 0.0), (60e3, 100e3), (150e3, 290e3), (300e3, 715e3)] {
            assert!((convex.hydrogen_w(power) - taken).abs() < 1e-6, "{power}");
        }
        assert!((convex.hydrogen_w(30e3) - 50e3).abs() < 1e-6);
        // a point above the line between its neighbours is left out
        let dented = Cell::new(&model(&[0.0, 30e3, 60e3, 300e3], &[0.0, 67e3, 100e3, 715e3]));
        assert!((dented.hydrogen_w(30e3) - 50e3).abs() < 1e-6);
        assert_eq!((dented.lines.len(), dented.power_w), (2, 300e3));
    }

    #[test]
    fn a_map_that_gives_more_than_it_takes_is_refused() {
        let mut problems = Problems::default();
        model(&[0.0, 100e3], &[0.0, 90e3]).validate(&mut problems);
        model(&[10.0, 100e3], &[20.0, 190e3]).validate(&mut problems);
        assert_eq!(problems.into_problems().len(), 2);
    }
}
