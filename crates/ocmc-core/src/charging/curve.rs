//! The charge curve: the most power that a battery takes by its state of charge.

use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The most power by state of charge, linear between its points and level beyond them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChargeCurve {
    /// States of charge, rising.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub charge: Vec<f64>,
    /// Power at the battery's terminals there, in W; it may not rise.
    #[schemars(inner(range(min = 100.0, max = 1.0e7)))]
    pub power_w: Vec<f64>,
    /// The same at temperatures of the battery, rising, where it has one; level beyond them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by_temperature: Vec<CurveAtTemperature>,
}

/// Power by state of charge at a temperature of the battery.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurveAtTemperature {
    /// Temperature of the battery, in K.
    #[schemars(range(min = 233.15, max = 343.15))]
    pub temperature_k: f64,
    /// Power at the battery's terminals at the states of charge of the curve, in W; it may not
    /// rise.
    #[schemars(inner(range(min = 100.0, max = 1.0e7)))]
    pub power_w: Vec<f64>,
}

impl ChargeCurve {
    /// As many powers as charges, in order, and no power that rises.
    pub fn validate(&self, problems: &mut Problems) {
        let wrong = |values: &[f64], holds: fn(f64, f64) -> bool| {
            let mut pairs = values.windows(2).enumerate();
            pairs.find(|(_, pair)| !holds(pair[0], pair[1])).map(|(k, pair)| (k + 2, pair.to_vec()))
        };
        if let Some((entry, pair)) = wrong(&self.charge, |before, here| before < here) {
            let shown = format!("{} after {} (entry {entry})", pair[1], pair[0]);
            problems.require(false, "charge", shown, "states of charge that rise");
        }
        let check = |power_w: &[f64], problems: &mut Problems| {
            let (charges, powers) = (self.charge.len(), power_w.len());
            let pairs = charges == powers && charges > 0;
            let counts = format!("{powers} powers for {charges} charges");
            problems.require(pairs, "power_w", counts, "one power for each charge, at least one");
            if let Some((entry, pair)) = wrong(power_w, |before, here| before >= here) {
                let shown = format!("{} after {} (entry {entry})", pair[1], pair[0]);
                let allowed = "powers that do not rise with the charge";
                problems.require(false, "power_w", shown, allowed);
            }
        };
        check(&self.power_w, problems);
        for (k, at) in self.by_temperature.iter().enumerate() {
            problems.part(&format!("by_temperature.{k}"), |problems| check(&at.power_w, problems));
        }
        let temperatures_k: Vec<f64> =
            self.by_temperature.iter().map(|at| at.temperature_k).collect();
        let rises = temperatures_k.windows(2).all(|pair| pair[0] < pair[1]);
        let shown = format!("temperatures of {temperatures_k:?}");
        problems.require(rises, "by_temperature", shown, "temperatures that rise");
    }

    /// The curve at a temperature of the battery, in K.
    pub fn at(&self, temperature_k: f64) -> Cow<'_, Self> {
        let curves = &self.by_temperature;
        let above = curves.partition_point(|at| at.temperature_k <= temperature_k);
        let (Some(low), Some(high)) =
            (curves.get(above.saturating_sub(1)), curves.get(above).or(curves.last()))
        else {
            return Cow::Borrowed(self);
        };
        let width_k = high.temperature_k - low.temperature_k;
        let share = if width_k > 0.0 { (temperature_k - low.temperature_k) / width_k } else { 0.0 };
        let pairs = low.power_w.iter().zip(&high.power_w);
        let power_w = pairs.map(|(low_w, high_w)| low_w + (high_w - low_w) * share).collect();
        Cow::Owned(Self { charge: self.charge.clone(), power_w, by_temperature: Vec::new() })
    }

    /// The most power at a state of charge, in W.
    pub fn power_w(&self, charge: f64) -> f64 {
        let (charges, powers) = (&self.charge, &self.power_w);
        let above = charges.partition_point(|at| *at <= charge);
        match (above.checked_sub(1), powers.get(above)) {
            (Some(k), Some(next_w)) => {
                let share = (charge - charges[k]) / (charges[above] - charges[k]);
                powers[k] + (next_w - powers[k]) * share
            }
            (Some(k), None) => powers[k],
            (None, Some(first_w)) => *first_w,
            (None, None) => f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_temperatures_powers_are_their_means() {
        let at = |temperature_k, power_w: f64| CurveAtTemperature {
            temperature_k,
            power_w: vec![power_w, 0.5 * power_w],
        };
        let curve = ChargeCurve {
            charge: vec![0.2, 0.8],
            power_w: vec![400e3, 300e3],
            by_temperature: vec![at(273.15, 100e3), at(293.15, 300e3)],
        };
        for (temperature_k, said_w) in
            [(250.0, 100e3), (273.15, 100e3), (283.15, 200e3), (293.15, 300e3), (320.0, 300e3)]
        {
            let now = curve.at(temperature_k);
            assert!((now.power_w(0.1) / said_w - 1.0).abs() < 1e-9, "{temperature_k}");
            assert!((now.power_w(0.5) / (0.75 * said_w) - 1.0).abs() < 1e-9, "{temperature_k}");
        }
        let plain = ChargeCurve { by_temperature: Vec::new(), ..curve };
        assert_eq!(*plain.at(250.0), plain);
    }
}
