//! Rows of a drive cycle that are far apart: its corners, or samples of it.
//!
//! Between the corners of a cycle the speed is straight, and nothing is lost. Of a drive that was
//! sampled the speeds between the rows are not known: the drive cycles of public tools, thinned to
//! 10, 20, 30 and 60 s, take up to 5, 9, 12 and 16 % less. How much is lost is told by what half of
//! the rows lose: the squares of speeds that a vehicle gains.

use super::Finding;
use crate::number_text::rounded;
use ocmc_core::prescribed::DriveCycle;

/// Name of the check.
const NAME: &str = "rows-far-apart";
/// Longest step in which a vehicle moves, in s: cycles of 1 Hz are driven by their rows.
const LONGEST_STEP_S: f64 = 1.0;
/// Step from which on rows at equal times may be too far apart for a drive, in s.
const SAMPLED_S: f64 = 2.0;
/// Share of the gained squares of speeds that every second row loses, from which on all of them
/// have lost too much (judgement).
const LOST: f64 = 0.02;
/// The same of steps of 10 s or more, of which half of the rows tell less.
const LONG_S: f64 = 10.0;
const LOST_OF_LONG: f64 = 0.003;
/// Share of the moving steps that are equally long in a cycle that was sampled.
const EQUAL: f64 = 0.9;
/// Fewest moving steps of which that is known.
const FEWEST: usize = 8;
/// Relative difference of equal times.
const ROUNDING: f64 = 1e-3;

/// Looks at the steps of a cycle that is driven in steps of `step_s` instead.
pub fn judge(cycle: &DriveCycle, step_s: f64) -> Option<Finding> {
    let longest_s = cycle.longest_moving_step_s();
    if longest_s <= LONGEST_STEP_S {
        return None;
    }
    let moving = cycle.steps().filter(|step| step.speed.distance_m() > 0.0);
    let mut steps_s: Vec<f64> = moving.map(|step| step.speed.dt_s).collect();
    steps_s.sort_by(f64::total_cmp);
    let usual_s = steps_s[steps_s.len() / 2];
    let equal = steps_s.iter().filter(|dt_s| (*dt_s / usual_s - 1.0).abs() < ROUNDING).count();
    let sampled = steps_s.len() >= FEWEST && equal as f64 >= EQUAL * steps_s.len() as f64;
    let lost = lost_by_half(cycle);
    let most = if usual_s >= LONG_S { LOST_OF_LONG } else { LOST };
    if sampled && usual_s >= SAMPLED_S && lost > most {
        let text = format!(
            "its rows are {} s apart: what the vehicle did between them is not known, and is \
             driven straight",
            rounded(usual_s)
        );
        let remedy = "drives sampled each 10 to 60 s take up to 5 to 16 % less than they did; give \
                      rows of 1 s, unless these are all corners of the speed";
        return Some(Finding::warned(NAME, [lost, most], text, remedy));
    }
    let text = format!(
        "rows are up to {} s apart: driven in steps of {step_s} s, the speed straight between the \
         rows",
        rounded(longest_s)
    );
    Some(Finding::mended(NAME, [longest_s, LONGEST_STEP_S], text))
}

/// Share of the squares of speeds, as far as they are gained, that every second row loses.
fn lost_by_half(cycle: &DriveCycle) -> f64 {
    let speeds: Vec<f64> = cycle.points().map(|[_, speed_mps, _]| speed_mps).collect();
    let gained = |first: usize, every: usize| {
        let kept: Vec<f64> = speeds.iter().skip(first).step_by(every).copied().collect();
        kept.windows(2).map(|w| (w[1] * w[1] - w[0] * w[0]).max(0.0)).sum::<f64>()
    };
    let all = gained(0, 1);
    let half = 0.5 * (gained(0, 2) + gained(1, 2));
    if all > 0.0 { 1.0 - half / all } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intake::End;

    fn end(time_s: &[f64]) -> Option<End> {
        let speed_mps = (0..time_s.len()).map(|k| 5.0 + 4.0 * (k % 3) as f64).collect();
        let cycle = DriveCycle::new(time_s.to_vec(), speed_mps, vec![0.0; time_s.len()]);
        judge(&cycle.unwrap(), 0.5).map(|finding| finding.end)
    }

    #[test]
    fn samples_are_warned_of_and_corners_are_not() {
        let each = |dt_s: f64| (0..30).map(|k| dt_s * f64::from(k)).collect::<Vec<f64>>();
        assert_eq!(end(&each(1.0)), None);
        assert_eq!(end(&each(1.5)), Some(End::Mended));
        assert_eq!(end(&each(10.0)), Some(End::Warned));
        let corners: Vec<f64> = (0..30).map(|k| f64::from(k * k)).collect();
        assert_eq!(end(&corners), Some(End::Mended));
    }

    #[test]
    fn a_ramp_loses_its_first_and_last_steps_to_every_second_row() {
        let numbers = |count: u32| (0..count).map(f64::from).collect::<Vec<f64>>();
        let cycle = DriveCycle::new(numbers(21), numbers(21), vec![0.0; 21]).unwrap();
        // squares gained: 20² of all rows, 20² from the first row on, 19² - 1² from the second one
        assert!((lost_by_half(&cycle) - (1.0 - 0.5 * (400.0 + 360.0) / 400.0)).abs() < 1e-12);
    }
}
