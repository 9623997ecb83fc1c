//! Ageing: what is left of a battery's energy after some years, and by how much its resistance has
//! risen.
//!
//! The law is that of Schmalstieg, Käbitz, Ecker and Sauer, *A holistic aging model for
//! Li(NiMnCo)O2 based 18650 lithium-ion batteries*, J. Power Sources 257 (2014) 325, for cells of
//! 2.05 Ah, as public restatements give it, NREL's BLAST-Lite among them \[F second hand\]. With t
//! in days, Q in Ah that went through a cell in both directions, V in V, T in K and the depth of
//! discharge D:
//!
//! ```text
//! energy      1 − (7.543 V − 23.75) 10⁶ exp(−6976 / T) t^0.75
//!               − (7.348·10⁻³ (V − 3.667)² + 7.6·10⁻⁴ + 4.081·10⁻³ D) √Q
//! resistance  1 + (5.270 V − 16.32) 10⁵ exp(−5986 / T) t^0.75
//!               + max(1.5·10⁻⁵, 2.153·10⁻⁴ (V − 3.725)² − 1.521·10⁻⁵ + 2.798·10⁻⁴ D) Q
//! ```
//!
//! V is the voltage at which a cell is kept, and around which it is cycled: one here. The cells
//! were bought in 2010 and aged at 35 to 50 °C: those of today last longer.

use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Charge of a full cell, in Ah.
const CELL_AH: f64 = 2.05;
const DAYS_OF_A_YEAR: f64 = 365.25;
/// Least share of its energy with which a battery still drives a truck (judgement).
const LEAST_ENERGY: f64 = 0.3;

/// How old a battery is, and how it was used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AgeingModel {
    /// Law of the loss of energy and of the rise of resistance.
    pub law: AgeingLaw,
    /// Age, in years.
    #[schemars(range(min = 0.0, max = 30.0))]
    pub years: f64,
    /// Full cycles per a (year): energy drawn over the energy of the new battery.
    #[schemars(range(min = 0.0, max = 2000.0))]
    pub full_cycles_per_a: f64,
    /// Depth of discharge of a usual day.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub depth_of_discharge: f64,
    /// Mean temperature of the pack, in K.
    #[schemars(range(min = 253.15, max = 333.15))]
    pub temperature_k: f64,
    /// Voltage of a cell at its mean state of charge, in V.
    #[schemars(range(min = 3.2, max = 4.2))]
    pub cell_voltage_v: f64,
}

/// A law of ageing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AgeingLaw {
    /// Schmalstieg and others (2014), cells of nickel, manganese and cobalt.
    #[serde(rename = "schmalstieg_2014")]
    Schmalstieg2014,
}

impl AgeingModel {
    /// A battery that is not worn out.
    pub fn validate(&self, problems: &mut Problems) {
        let left = self.energy_share();
        let allowed = format!(
            "fewer years: by then {:.0} % of the energy would be left, and at least {:.0} % are \
             needed",
            100.0 * left,
            100.0 * LEAST_ENERGY
        );
        problems.require(left >= LEAST_ENERGY, "years", self.years, &allowed);
    }

    /// Days to the power of 0.75, and charge through a cell in Ah.
    fn exposure(&self) -> [f64; 2] {
        let days = DAYS_OF_A_YEAR * self.years;
        let throughput_ah = 2.0 * CELL_AH * self.full_cycles_per_a * self.years;
        [libm::pow(days, 0.75), throughput_ah]
    }

    /// Share of the energy that is left.
    pub fn energy_share(&self) -> f64 {
        let Self { temperature_k, cell_voltage_v: voltage_v, depth_of_discharge, .. } = *self;
        let [time, throughput_ah] = self.exposure();
        let calendar = (7.543 * voltage_v - 23.75) * 1.0e6 * libm::exp(-6976.0 / temperature_k);
        let off_v = voltage_v - 3.667;
        let cycles = 7.348e-3 * off_v * off_v + 7.6e-4 + 4.081e-3 * depth_of_discharge;
        1.0 - calendar * time - cycles * throughput_ah.sqrt()
    }

    /// Resistance over that of the new battery.
    pub fn resistance_factor(&self) -> f64 {
        let Self { temperature_k, cell_voltage_v: voltage_v, depth_of_discharge, .. } = *self;
        let [time, throughput_ah] = self.exposure();
        let calendar = (5.270 * voltage_v - 16.32) * 1.0e5 * libm::exp(-5986.0 / temperature_k);
        let off_v = voltage_v - 3.725;
        let cycles = 2.153e-4 * off_v * off_v - 1.521e-5 + 2.798e-4 * depth_of_discharge;
        1.0 + calendar * time + cycles.max(1.5e-5) * throughput_ah
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn truck(years: f64, full_cycles_per_a: f64) -> AgeingModel {
        AgeingModel {
            law: AgeingLaw::Schmalstieg2014,
            years,
            full_cycles_per_a,
            depth_of_discharge: 0.6,
            temperature_k: 298.15,
            cell_voltage_v: 3.7,
        }
    }

    #[test]
    fn the_shares_are_those_of_the_law_by_hand() {
        let new = truck(0.0, 200.0);
        assert_eq!((new.energy_share(), new.resistance_factor()), (1.0, 1.0));
        // kept only: (27.9091 − 23.75) 10⁶ e^(−23.3976) = 2.8708e-4 a day^0.75; 1461^0.75 = 236.31
        let kept = truck(4.0, 0.0).energy_share();
        assert!((kept - (1.0 - 2.8708e-4 * 236.31)).abs() < 1e-4, "{kept}");
        // cycled, too: 8.0e-6 + 7.6e-4 + 2.4486e-3 = 3.2166e-3 times √(2 · 2.05 · 800)
        let used = truck(4.0, 200.0).energy_share();
        assert!((kept - used - 3.2166e-3 * 3280.0f64.sqrt()).abs() < 1e-4, "{kept} {used}");
        // 1.5279e-4 for each Ah
        let risen = truck(4.0, 200.0).resistance_factor() - truck(4.0, 0.0).resistance_factor();
        assert!((risen - 1.5279e-4 * 3280.0).abs() < 1e-3, "{risen}");
    }

    #[test]
    fn warmer_fuller_deeper_and_older_batteries_have_less_left() {
        let middle = truck(6.0, 150.0);
        for worse in [
            AgeingModel { temperature_k: 308.15, ..middle.clone() },
            AgeingModel { cell_voltage_v: 3.9, ..middle.clone() },
            AgeingModel { depth_of_discharge: 0.9, ..middle.clone() },
            AgeingModel { years: 7.0, ..middle.clone() },
            AgeingModel { full_cycles_per_a: 200.0, ..middle.clone() },
        ] {
            assert!(worse.energy_share() < middle.energy_share(), "{worse:?}");
            assert!(worse.resistance_factor() > middle.resistance_factor(), "{worse:?}");
        }
    }
}
