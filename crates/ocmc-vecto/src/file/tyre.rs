//! The dynamic radius of a tyre by its size, as VECTO's declaration mode has it.

/// Sizes of tyres of trucks, without blanks: diameter in mm, and the factor that makes it the way
/// of a turn [F: VECTO 3, `Declaration/Wheels.csv`].
const SIZES: [(&str, f64, f64); 48] = [
    ("9.00R20", 1018.0, 3.05),
    ("9R22.5", 970.0, 3.05),
    ("9.5R17.5", 842.0, 3.05),
    ("10R17.5", 858.0, 3.05),
    ("10R22.5", 1020.0, 3.05),
    ("10.00R20", 1052.0, 3.05),
    ("11R22.5", 1050.0, 3.05),
    ("11.00R20", 1082.0, 3.05),
    ("12R22.5", 1084.0, 3.05),
    ("12.00R20", 1122.0, 3.05),
    ("12.00R24", 1226.0, 3.05),
    ("13R22.5", 1124.0, 3.05),
    ("205/75R17.5", 753.0, 3.05),
    ("215/75R17.5", 767.0, 3.05),
    ("225/70R17.5", 761.0, 3.05),
    ("225/75R17.5", 783.0, 3.05),
    ("235/75R17.5", 797.0, 3.05),
    ("245/70R17.5", 789.0, 3.05),
    ("245/70R19.5", 839.0, 3.05),
    ("255/70R22.5", 930.0, 3.05),
    ("265/70R17.5", 817.0, 3.05),
    ("265/70R19.5", 867.0, 3.05),
    ("275/70R22.5", 958.0, 3.05),
    ("275/80R22.5", 1012.0, 3.05),
    ("285/60R22.5", 914.0, 3.03),
    ("285/70R19.5", 895.0, 3.05),
    ("295/55R22.5", 896.0, 3.03),
    ("295/60R22.5", 926.0, 3.03),
    ("295/80R22.5", 1044.0, 3.05),
    ("305/60R22.5", 938.0, 3.03),
    ("305/70R19.5", 923.0, 3.05),
    ("305/70R22.5", 1000.0, 3.05),
    ("305/75R24.5", 1080.0, 3.05),
    ("315/45R22.5", 856.0, 3.03),
    ("315/60R22.5", 950.0, 3.03),
    ("315/70R22.5", 1014.0, 3.05),
    ("315/80R22.5", 1076.0, 3.05),
    ("325/95R24", 1228.0, 3.05),
    ("355/50R22.5", 928.0, 3.03),
    ("365/70R22.5", 1084.0, 3.05),
    ("365/85R20", 1128.0, 3.05),
    ("375/50R22.5", 948.0, 3.03),
    ("375/90R22.5", 1248.0, 3.05),
    ("385/55R22.5", 996.0, 3.03),
    ("385/65R22.5", 1072.0, 3.03),
    ("395/85R20", 1180.0, 3.05),
    ("425/65R22.5", 1124.0, 3.03),
    ("495/45R22.5", 1018.0, 3.03),
];

/// The dynamic radius in m of a tyre that VECTO's table has.
pub(super) fn dynamic_radius_m(size: &str) -> Option<f64> {
    let plain: String = size.chars().filter(|c| !c.is_whitespace()).collect();
    let tyre = SIZES.iter().find(|(size, ..)| size.eq_ignore_ascii_case(&plain));
    tyre.map(|(_, diameter_mm, factor)| factor * diameter_mm / 1000.0 / std::f64::consts::TAU)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_radius_is_the_way_of_a_turn_over_a_full_angle() {
        // 492.2 mm: the radius that speeds and engine speeds of a series of VECTO 3 have
        assert!((dynamic_radius_m("315/70 R 22.5").unwrap() - 0.4922).abs() < 5e-5);
        assert!((dynamic_radius_m("215/75 R17.5").unwrap() - 0.3723).abs() < 5e-5);
        assert!(dynamic_radius_m("-").is_none() && dynamic_radius_m("315/71 R22.5").is_none());
    }

    #[test]
    fn every_size_is_that_of_its_name() {
        for (size, diameter_mm, factor) in SIZES {
            let rim = size.rsplit('R').next().unwrap().parse::<f64>().unwrap();
            let inside = (diameter_mm - 25.4 * rim) / diameter_mm;
            assert!((0.25..0.65).contains(&inside) && (3.0..3.1).contains(&factor), "{size}");
        }
    }
}
