//! Even stretches in place of a slope that scatters from row to row.
//!
//! The truck of the closed loop answers each slope of the log; noise that no truck has felt would
//! move its pedals. Where a slope scatters as white noise does, its change points are looked for by
//! binary segmentation: a stretch is cut in two where the two means explain most, as long as they
//! explain more than 4 ln(n) σ² (twice Schwarz's criterion for a place and a height), and each
//! stretch gets its mean. σ is the median of the absolute differences of neighbouring rows over
//! 0.954.
//!
//! P. Fryzlewicz, "Wild binary segmentation for multiple change-point detection", Annals of
//! Statistics 42 (2014) 2243-2281 (its section on standard binary segmentation).

use crate::identification::noise::median;

/// Scatter below this is left to the cells of the road.
const LEAST_SD: f64 = 3e-4;
/// Median of the absolute difference of two normal numbers, in standard deviations.
const MEDIAN_DIFFERENCE: f64 = 0.953873;
/// Differences of white noise that follow each other correlate by −0.5, those of a road that really
/// bends by more than this.
const ALTERNATING: f64 = -0.25;
/// Fewest rows that show whether a slope scatters.
const FEWEST_ROWS: usize = 30;

/// Scatter of a slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeScatter {
    /// Its standard deviation.
    pub sd: f64,
    /// Even stretches that stand for it.
    pub stretches: usize,
}

/// A slope without its scatter.
#[derive(Clone, Debug, PartialEq)]
pub struct EvenSlopes {
    /// The slope of each row.
    pub grade: Vec<f64>,
    /// Standard error of the stretch of each row.
    pub error: Vec<f64>,
    /// Scatter of the slopes.
    pub scatter: SlopeScatter,
}

impl SlopeScatter {
    /// Treatment of the scatter, in words.
    pub fn text(&self) -> String {
        let Self { sd, stretches } = self;
        let percent = 100.0 * sd;
        format!("the slope scatters by {percent:.2} %: {stretches} even stretches stand for it")
    }
}

/// The slopes with the means of even stretches, and what scatter they had; none where they do not
/// scatter as noise does.
pub fn even_slopes(grade: &[f64]) -> Option<EvenSlopes> {
    if grade.len() < FEWEST_ROWS {
        return None;
    }
    let steps: Vec<f64> = grade.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let sd = median(steps.iter().map(|step| step.abs()).collect()) / MEDIAN_DIFFERENCE;
    if !(sd > LEAST_SD) {
        return None;
    }
    // a change of the slope is no scatter
    let clipped: Vec<f64> = steps.iter().map(|step| step.clamp(-4.0 * sd, 4.0 * sd)).collect();
    let squares: f64 = clipped.iter().map(|step| step * step).sum();
    let products: f64 = clipped.windows(2).map(|pair| pair[0] * pair[1]).sum();
    if !(products < ALTERNATING * squares) {
        return None;
    }
    let mut sums = vec![0.0];
    for (row, value) in grade.iter().enumerate() {
        sums.push(sums[row] + value);
    }
    let threshold = 4.0 * libm::log(grade.len() as f64) * sd * sd;
    let (mut waiting, mut stretches) = (vec![(0, grade.len())], 0);
    let (mut even, mut error) = (grade.to_vec(), vec![0.0; grade.len()]);
    while let Some((first, end)) = waiting.pop() {
        if let Some((cut, _)) = best_cut(&sums, first, end).filter(|(_, gain)| *gain > threshold) {
            waiting.extend([(first, cut), (cut, end)]);
        } else {
            let rows = (end - first) as f64;
            even[first..end].fill((sums[end] - sums[first]) / rows);
            error[first..end].fill(sd / rows.sqrt());
            stretches += 1;
        }
    }
    Some(EvenSlopes { grade: even, error, scatter: SlopeScatter { sd, stretches } })
}

/// Where two means explain most of the rows, and by how much the sum of squares falls.
fn best_cut(sums: &[f64], first: usize, end: usize) -> Option<(usize, f64)> {
    let gain = |cut: usize| {
        let (left, right) = ((cut - first) as f64, (end - cut) as f64);
        let step = (sums[cut] - sums[first]) / left - (sums[end] - sums[cut]) / right;
        left * right / (left + right) * step * step
    };
    let cuts = (first + 1..end).map(|cut| (cut, gain(cut)));
    cuts.max_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    #[test]
    fn slopes_come_back_from_noise_and_stay_without() {
        let truth = |row: usize| match row {
            300..700 => 0.035,
            900..1000 => -0.015,
            _ => 0.0,
        };
        let exact: Vec<f64> = (0..1200).map(truth).collect();
        assert_eq!(even_slopes(&exact), None);
        for seed in 1..=3 {
            let mut draws = Draws::new(seed, 0, Stream::Pedals);
            let noisy: Vec<f64> = exact.iter().map(|g| g + 0.002 * draws.normal()).collect();
            let EvenSlopes { grade: even, scatter, .. } = even_slopes(&noisy).expect("it scatters");
            assert!(
                (scatter.sd / 0.002 - 1.0).abs() < 0.1 && scatter.stretches == 5,
                "{scatter:?}"
            );
            let off = even.iter().zip(&exact).filter(|(a, b)| (*a - *b).abs() > 5e-4).count();
            assert!(off <= 2, "{off} rows");
        }
    }

    #[test]
    fn a_road_that_bends_is_no_noise() {
        let road: Vec<f64> = (0..500).map(|row| 0.03 * libm::sin(0.2 * row as f64)).collect();
        assert_eq!(even_slopes(&road), None);
    }
}
