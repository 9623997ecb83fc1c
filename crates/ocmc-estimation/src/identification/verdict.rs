//! Parameters that the data do not determine: at the edges of their boxes, or with wide intervals.

use super::identify::DriverParameterFit;
use super::problem::{LATEST_S, Problem};

/// A parameter is identified where its interval is not wider than this share of it, to either side.
const WIDEST: f64 = 0.5;

impl Problem<'_> {
    /// Whether parameter `k` stands at one of its bounds.
    pub(super) fn is_at_bound(&self, k: usize, x: &[f64]) -> bool {
        let [lower, upper] = self.bounds[k];
        self.bounds[k].iter().any(|bound| (x[k] - bound).abs() <= 1e-6 * (upper - lower))
    }

    /// Names of those of start, set speed and truck that ended at an edge of their box, where no
    /// log of one wanted speed and of this truck has it: there the fit is none.
    pub(super) fn edges(&self, x: &[f64]) -> Option<String> {
        let outer = |k: &usize| match self.names[*k] {
            "set_speed_mps" | "start_speed_mps" | "mass_kg" | "resistance_share" => true,
            // no driver reacts before he sees something
            "delay_s" => x[*k] > 0.5 * LATEST_S,
            _ => false,
        };
        let places = (0..x.len()).filter(|k| outer(k) && self.is_at_bound(*k, x));
        let names: Vec<&str> = places.map(|k| self.names[k]).collect();
        (!names.is_empty()).then(|| {
            format!(
                "the fit fails, it ended at an edge of what is looked for: {}",
                names.join(", ")
            )
        })
    }

    /// Why a parameter is not determined by the data.
    pub(super) fn verdict(&self, k: usize, fit: &DriverParameterFit) -> Option<&'static str> {
        if fit.at_bound {
            return Some("it ended at a bound");
        }
        // what matters of a speed is the error: its scale is 1 m/s; of a start 1
        // and of a delay 1 s
        let size = match fit.name {
            "set_speed_mps" | "start_integral" | "start_speed_mps" | "delay_s"
            | "resistance_share" => 1.0,
            _ => fit.value.abs(),
        };
        let width = |ends: [f64; 2]| (ends[1] - fit.value).max(fit.value - ends[0]);
        if width(fit.spread) > WIDEST * size {
            return Some("different values fit equally well");
        }
        let interval = fit.interval?;
        if interval[0] <= self.bounds[k][0] && interval[1] >= self.bounds[k][1] {
            return Some("its interval is the whole box");
        }
        (width(interval) > WIDEST * size).then_some("its interval is wider than half of it")
    }
}
