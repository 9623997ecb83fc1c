//! Published figures of tractor-semitrailers, beside which a level is read.

use ocmc_core::energy::Carrier;

/// A published figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Source: the measurement or declaration, and its date.
    pub what: &'static str,
    /// Payload or gross mass.
    pub load: &'static str,
    /// Road, speed, season.
    pub road: &'static str,
    /// Carrier that it consumes.
    pub carrier: Carrier,
    /// The figure with its unit.
    pub figure: &'static str,
    /// F: the source was opened; F2: another author states it; D: derived.
    pub standing: &'static str,
}

impl Anchor {
    /// Its cells: what, load, road, figure, standing.
    pub fn cells(&self) -> [&'static str; 5] {
        [self.what, self.load, self.road, self.figure, self.standing]
    }
}

/// The figures, diesel before electric (`docs/src/outside-consumption.md` says what follows from
/// them).
pub const ANCHORS: [Anchor; 15] = [
    Anchor {
        what: "VECTO 3, generic tractor of 2016",
        load: "19.3 t",
        road: "LongHaul, 78.7 km/h",
        carrier: Carrier::LiquidFuel,
        figure: "35.1 L/100 km",
        standing: "F",
    },
    Anchor {
        what: "VECTO 3, generic tractor of 2016",
        load: "24.3 t",
        road: "LongHaul, 78.3 km/h",
        carrier: Carrier::LiquidFuel,
        figure: "37.6 L/100 km",
        standing: "F",
    },
    Anchor {
        what: "mean of the new 5-LH 4x2 tractors, 2019 and 2020",
        load: "19.3 t",
        road: "LongHaul, declared",
        carrier: Carrier::LiquidFuel,
        figure: "32.4 L/100 km",
        standing: "F2: EEA, in TUMFTM/TechnoEconomicCellSelection",
    },
    Anchor {
        what: "mean of the new 5-LH 4x2 tractors, 2019 and 2020",
        load: "2.6 t",
        road: "LongHaul, declared",
        carrier: Carrier::LiquidFuel,
        figure: "24.7 L/100 km",
        standing: "F2",
    },
    Anchor {
        what: "new 5-LH tractors, second half of 2019",
        load: "13.8 t, weighted",
        road: "long haul and regional",
        carrier: Carrier::LiquidFuel,
        figure: "56.5 g/tkm, 29.9 L/100 km",
        standing: "F: ACEA 2020; litres D, 2.617 kg/L",
    },
    Anchor {
        what: "ICCT and TU Graz, chassis dynamometer, 2018: typical, best",
        load: "regulatory",
        road: "LongHaul",
        carrier: Carrier::LiquidFuel,
        figure: "32.6, 29.9 L/100 km",
        standing: "F",
    },
    Anchor {
        what: "bestof9, nine tractors over a year, 2013",
        load: "own freight",
        road: "nine tenths motorway",
        carrier: Carrier::LiquidFuel,
        figure: "28.8 L/100 km",
        standing: "F",
    },
    Anchor {
        what: "European Truck Challenge 2023",
        load: "33.6 t gross",
        road: "hilly motorway",
        carrier: Carrier::LiquidFuel,
        figure: "25.5 to 26.8 L/100 km",
        standing: "F: test drivers",
    },
    Anchor {
        what: "Green Truck 2018, the winner",
        load: "40 t gross",
        road: "Munich to Nuremberg, 79.9 km/h",
        carrier: Carrier::LiquidFuel,
        figure: "24.9 L/100 km",
        standing: "F: a lower bound",
    },
    Anchor {
        what: "lastauto omnibus, 2020 to 2023",
        load: "40 t gross",
        road: "hilly, set to 85 km/h",
        carrier: Carrier::LiquidFuel,
        figure: "33.3 to 34.7 L/100 km",
        standing: "F",
    },
    Anchor {
        what: "fleets of the EU, review of 2015",
        load: "mixed",
        road: "real traffic",
        carrier: Carrier::LiquidFuel,
        figure: "about 31 L/100 km",
        standing: "F2: ICCT",
    },
    Anchor {
        what: "Run on Less, US 2017",
        load: "25.2 t gross",
        road: "87 km/h",
        carrier: Carrier::LiquidFuel,
        figure: "23.3 L/100 km",
        standing: "F: selected trucks",
    },
    Anchor {
        what: "eActros 600, 2024",
        load: "40 t gross",
        road: "22 countries, summer",
        carrier: Carrier::Electricity,
        figure: "1.03 kWh/km",
        standing: "F: its maker",
    },
    Anchor {
        what: "Volvo FH Electric, 2022",
        load: "40 t gross",
        road: "Munich to Nuremberg, 80 km/h",
        carrier: Carrier::Electricity,
        figure: "1.1 kWh/km",
        standing: "F",
    },
    Anchor {
        what: "91 electric tractors of fleets, 2025",
        load: "above 30 t gross",
        road: "regional",
        carrier: Carrier::Electricity,
        figure: "0.92 to 1.50 kWh/km",
        standing: "F2: ICCT",
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_guide_has_the_same_figures() {
        let page = include_str!("../../../docs/src/outside-consumption.md");
        for anchor in &ANCHORS {
            let row = format!("| {} |", anchor.cells().join(" | "));
            assert!(page.contains(&row), "{row}");
        }
        let rows = page.split("## The default truck").next().unwrap_or_default();
        let rows = rows.lines().filter(|line| line.starts_with("| ")).count();
        assert_eq!(rows, ANCHORS.len() + 1);
    }
}
