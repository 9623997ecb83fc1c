//! Parts that a route lacks, and what they are worth.
//!
//! A route has a limit; altitudes, curves and stops are driven where they are given, and where not
//! they are drawn if that is asked for and absent otherwise, while traffic, weather and payload are
//! drawn from the study. What is absent was driven on the roads of the default study, whole and
//! without the tracks in question (`scripts/what_routes_lack.py`, 200 roads of the study
//! `field-truck`, seed 1, 10 trips each): the mean says by how much the consumption is too low, the
//! 95th percentile how far it may be on one road.

use super::Finding;
use crate::intake::table::Quantity;
use ocmc_core::operating_cycle::drawn_part::Draw;

/// Parts that a route can lack, with the quantities any one of which tells it.
const PARTS: [Part; 3] = [
    Part {
        name: "altitudes",
        told_by: &[Quantity::Altitude, Quantity::Grade],
        columns: "`altitude_m`",
        draw: Draw::Hills,
    },
    Part {
        name: "curves",
        told_by: &[Quantity::Latitude, Quantity::Curvature],
        columns: "`curvature_per_m` or `lat` and `lon`",
        draw: Draw::Curves,
    },
    Part {
        name: "stops",
        told_by: &[Quantity::Stop, Quantity::MapObject],
        columns: "`stop_s`",
        draw: Draw::Stops,
    },
];

/// A part of a route.
struct Part {
    name: &'static str,
    told_by: &'static [Quantity],
    /// Columns to add, in words.
    columns: &'static str,
    draw: Draw,
}

/// Consumption without some parts, over that with all, less 1, in %: mean and 95th percentile of
/// the magnitude, by the parts that are lacking, the first one in the lowest bit.
const WORTH_PERCENT: [[f64; 2]; 8] = [
    [0.0, 0.0],
    [-11.0, 15.4],
    [-3.5, 8.0],
    [-15.4, 20.4],
    [-2.4, 5.8],
    [-13.6, 17.2],
    [-9.2, 18.3],
    [-22.0, 31.0],
];
/// Mean change beyond which it is warned of, in %: a road without stops may well be right.
const BOUND_PERCENT: f64 = 3.0;

/// Names the parts that a route with these columns lacks and that are not drawn.
pub fn lacks(quantities: &[Quantity], draw: &[Draw]) -> Option<Finding> {
    let missing = |part: &Part| {
        !part.told_by.iter().any(|q| quantities.contains(q)) && !draw.contains(&part.draw)
    };
    let bits = PARTS.iter().enumerate().map(|(k, part)| usize::from(missing(part)) << k);
    let [mean, most] = WORTH_PERCENT[bits.sum::<usize>()];
    let missed = || PARTS.iter().filter(|part| missing(part));
    let names: Vec<&str> = missed().map(|part| part.name).collect();
    if names.is_empty() {
        return None;
    }
    let text = format!(
        "it has no {}: they count as absent (traffic, weather and payload are drawn from the \
         study). Trips on the roads of the default study take {:.0} % less without them in the \
         mean, and differ by up to {most:.0} %",
        names.join(", no "),
        -mean
    );
    let columns: Vec<&str> = missed().map(|part| part.columns).collect();
    let can_be_drawn = |draw: &Draw| missed().any(|part| part.draw == *draw);
    let draws = Draw::ALL.into_iter().filter(can_be_drawn).map(Draw::name);
    let draws: Vec<&str> = draws.collect();
    let remedy = format!(
        "add {} where there are any; a column of zeros says that there are none; or have them \
         drawn from the study, `--draw {}`",
        columns.join(", "),
        draws.join(",")
    );
    let figures = [-mean, BOUND_PERCENT];
    let make = if -mean > BOUND_PERCENT { Finding::warned } else { Finding::noted };
    Some(make("lacks", figures, text, &remedy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_named_with_its_worth() {
        use Quantity::{Altitude, Curvature, Grade, Latitude, Limit, Longitude, Position, Stop};
        for full in [
            &[Position, Limit, Altitude, Curvature, Stop][..],
            &[Latitude, Longitude, Limit, Grade, Stop],
        ] {
            assert_eq!(lacks(full, &[]), None);
        }
        let without_all = lacks(&[Position, Limit], &[]).expect("lacks three parts");
        for part in ["no altitudes", "no curves", "no stops"] {
            assert!(without_all.text.contains(part), "{without_all}");
        }
        let with_altitude = lacks(&[Position, Limit, Altitude], &[]).expect("lacks two parts");
        assert!(!with_altitude.text.contains("altitudes,"), "{with_altitude}");
        let stops_only = lacks(&[Position, Limit, Altitude, Curvature], &[]).expect("lacks one");
        assert_eq!(stops_only.end, crate::intake::End::Noted);
        assert!(stops_only.remedy.contains("stop_s") && !stops_only.remedy.contains("altitude"));
        assert!(with_altitude.figure < without_all.figure);
        // what is drawn is not lacking
        assert!(without_all.remedy.contains("`--draw stops,hills,curves`"), "{without_all}");
        assert_eq!(lacks(&[Position, Limit], &Draw::ALL), None);
        let flat = lacks(&[Position, Limit], &[Draw::Stops, Draw::Curves]).expect("lacks one");
        assert!(flat.text.contains("no altitudes:") && flat.remedy.contains("`--draw hills`"));
    }
}
