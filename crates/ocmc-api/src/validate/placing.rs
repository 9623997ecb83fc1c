//! Where a measured drive lies on a road that is given, and which part of it is scored.

use ocmc_estimation::log::way::DrivenWay;

/// Lengths of drive and road that differ by less are those of one road, as a share (judgement: what
/// the speeds of two vehicles differ by).
const SAME_LENGTH: f64 = 0.05;
/// Positions may lie so far outside the road, in m: rows are some metres apart.
const OUTSIDE_M: f64 = 1.0;
/// A drive that begins or ends so close to an end of the road, and as slowly, does so at rest.
const AT_END_M: f64 = 20.0;
const AT_REST_MPS: f64 = 2.0;

/// A drive on a road.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Placed {
    /// Position of each row, in m.
    pub(super) position_m: Vec<f64>,
    /// The factor by which its way was stretched to the road's length.
    pub(super) stretched: f64,
    /// The part that is scored, in m.
    pub(super) part_m: [f64; 2],
}

/// Places a drive on a road of this length: by its positions where they are the road's, otherwise
/// the whole way on the whole road; why it cannot be placed.
pub(super) fn place(way: &DrivenWay, length_m: f64, run_in_m: f64) -> Result<Placed, String> {
    let own_m = way.length_m();
    let inside = |first_m: &f64| *first_m >= -OUTSIDE_M && first_m + own_m <= length_m + OUTSIDE_M;
    let (position_m, stretched) = if let Some(first_m) = way.position_m.filter(inside) {
        (way.way_m.iter().map(|way_m| first_m + way_m).collect::<Vec<f64>>(), 1.0)
    } else {
        let factor = length_m / own_m;
        if !((factor - 1.0).abs() <= SAME_LENGTH) {
            return Err(format!(
                "the drive is {:.3} km long and the road {:.3} km: allowed are 5 % of difference, \
                 or a column of positions on the road",
                own_m / 1000.0,
                length_m / 1000.0
            ));
        }
        (way.way_m.iter().map(|way_m| factor * way_m).collect(), factor)
    };
    let last = position_m.len() - 1;
    let (from_m, to_m) = (position_m[0], position_m[last]);
    let slow = |row: usize| way.speed_mps[row] < AT_REST_MPS;
    // simulated trips begin and end at rest, at the ends of the road
    let begin_m = match (slow(0), from_m < AT_END_M) {
        (true, true) => 0.0,
        (true, false) => from_m + run_in_m,
        (false, _) => from_m.max(run_in_m),
    };
    let end_m = match (slow(last), to_m > length_m - AT_END_M) {
        (true, true) => length_m,
        (true, false) => to_m - run_in_m,
        (false, _) => to_m.min(length_m - run_in_m),
    };
    Ok(Placed { position_m, stretched, part_m: [begin_m, end_m] })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn way(length_m: f64, position_m: Option<f64>, ends_mps: [f64; 2]) -> DrivenWay {
        DrivenWay {
            row: vec![0, 1],
            time_s: vec![0.0, 100.0],
            speed_mps: ends_mps.to_vec(),
            way_m: vec![0.0, length_m],
            position_m,
            unseen: vec![false; 2],
        }
    }

    #[test]
    fn drives_lie_where_they_were() {
        let part = |way: &DrivenWay| {
            place(way, 5000.0, 500.0).map(|placed| (placed.stretched, placed.part_m))
        };
        // the whole road, by the integral of the speed
        assert_eq!(part(&way(5000.0, None, [0.0, 0.0])), Ok((1.0, [0.0, 5000.0])));
        assert_eq!(part(&way(5000.0, None, [20.0, 20.0])), Ok((1.0, [500.0, 4500.0])));
        let short = part(&way(4000.0, Some(9000.0), [0.0, 0.0]));
        assert!(short.is_err_and(|reason| reason.contains("4.000 km")));
        let (factor, _) = part(&way(4900.0, Some(70_000.0), [0.0, 0.0])).expect("one road");
        assert!((factor - 5000.0 / 4900.0).abs() < 1e-12);
        // a part of it, by its positions
        assert_eq!(part(&way(2000.0, Some(1000.0), [20.0, 0.0])), Ok((1.0, [1000.0, 2500.0])));
        assert_eq!(part(&way(2000.0, Some(1000.0), [0.0, 20.0])), Ok((1.0, [1500.0, 3000.0])));
        assert_eq!(part(&way(4999.0, Some(0.7), [0.4, 0.4])), Ok((1.0, [0.0, 5000.0])));
        assert!(part(&way(f64::NAN, None, [0.0, 0.0])).is_err());
    }
}
