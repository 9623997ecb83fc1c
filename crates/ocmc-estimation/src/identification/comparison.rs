//! A simulated drive beside the log of its event.

use super::fit_test::ComparedRow;
use ocmc_core::kernel::drive::pedal_event::EventSeries;

/// How a drive compares with its log.
#[derive(Clone, Debug, Default)]
pub(super) struct Comparison {
    /// The rows that are compared.
    pub(super) rows: Vec<ComparedRow>,
    /// Root mean square of all pedal residuals.
    pub(super) pedal_rms: f64,
    /// Root mean square of measured less simulated speed, in m/s.
    pub(super) speed_rms_mps: f64,
    /// The objective, in s.
    pub(super) objective: f64,
}

/// Accelerator, brake and speed of a drive at rising times, from step to step.
pub(super) fn interpolated(drive: &EventSeries, time_s: f64, step: &mut usize) -> [f64; 3] {
    let times = &drive.time_s;
    if times.is_empty() {
        return [f64::NAN; 3];
    }
    while *step + 1 < times.len() && times[*step + 1] < time_s {
        *step += 1;
    }
    let (k, next) = (*step, (*step + 1).min(times.len() - 1));
    let width = times[next] - times[k];
    let part = if width > 0.0 { ((time_s - times[k]) / width).clamp(0.0, 1.0) } else { 0.0 };
    let at = |values: &[f64]| values[k] + part * (values[next] - values[k]);
    [at(&drive.accelerator), at(&drive.brake), at(&drive.speed_mps)]
}
