//! Curves that no vehicle drives.

use super::Finding;
use super::table::given::RowPlace;
use crate::number_text::{count_of, rounded};

/// Lateral acceleration that no vehicle of a log has, in m/s²: the tyres of cars end there.
const MOST_LATERAL_MPS2: f64 = 10.0;

/// Lateral acceleration in a curve, in m/s², where it is more than any vehicle has.
pub fn impossible_mps2(speed_mps: f64, radius_m: f64) -> Option<f64> {
    let lateral_mps2 = speed_mps * speed_mps / radius_m;
    (lateral_mps2 > MOST_LATERAL_MPS2).then_some(lateral_mps2)
}

/// Names curves that were left out, with their lateral accelerations.
pub fn impossible(curves: &[(RowPlace, f64)]) -> Option<Finding> {
    let (place, lateral_mps2) = curves.first()?;
    let text = format!(
        "{} driven at more than {MOST_LATERAL_MPS2} m/s² to the side, left out, first {} m/s² in \
         {place}",
        count_of(curves.len() as u64, "curve"),
        rounded(*lateral_mps2)
    );
    let figures = [*lateral_mps2, MOST_LATERAL_MPS2];
    let remedy = "no road vehicle does that: correct the row, or the unit of the speed";
    Some(Finding::warned("impossible-curve", figures, text, remedy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_above_the_grip_of_tyres_is_named() {
        assert_eq!(impossible_mps2(20.0, 100.0), None);
        assert_eq!(impossible_mps2(f64::NAN, 100.0), None);
        let lateral_mps2 = impossible_mps2(250.0, 100.0).unwrap();
        let finding = impossible(&[(RowPlace::Line(7), lateral_mps2)]).unwrap();
        assert!(finding.text.contains("1 curve") && finding.text.contains("625.0 m/s² in line 7"));
        assert!(impossible(&[]).is_none());
    }
}
