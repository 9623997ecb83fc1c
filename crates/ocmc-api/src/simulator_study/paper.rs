//! The numbers that the paper prints of its driving simulator.
//!
//! Source: Romano, Godio, Bruzelius, Johannesson, the paper in hand: tables of the analysis of
//! variance, of the estimated parameters, and of accelerations.

use ocmc_estimation::fit::curve_speed::CurveSpeedFit;
use ocmc_estimation::fit::speed_change::SpeedChangeFit;

/// How a number is read off the fits of one repetition.
type OfFits = fn(&CurveSpeedFit, &SpeedChangeFit) -> Option<f64>;
/// A printed number: its table and its quantity with the unit, for people, the number, and how it
/// is read off.
pub(super) type Printed = (&'static str, &'static str, f64, OfFits);

fn f_of(fit: &CurveSpeedFit, term: &str) -> Option<f64> {
    fit.anova.iter().find(|row| row.term == term)?.f
}

fn median_of(fit: &SpeedChangeFit, change: &str) -> Option<f64> {
    Some(fit.by_category.iter().find(|law| law.category == change)?.median_mps2)
}

fn sd_of(fit: &SpeedChangeFit, change: &str) -> Option<f64> {
    fit.by_category.iter().find(|law| law.category == change)?.log_sd
}

const ANOVA: &str = "curve speed, analysis of variance";
const ESTIMATED: &str = "curve speed, estimated exponent";
const FIXED: &str = "curve speed, exponent 0.5";
const MEDIANS: &str = "speed changes, median in m/s²";
const SDS: &str = "speed changes, SD of the logarithm";

/// All of them, in the order of the paper.
pub(super) const PRINTED: [Printed; 18] = [
    (ANOVA, "F of the radius", 87.6916, |curves, _| f_of(curves, "radius")),
    (ANOVA, "F of the driver", 65.7463, |curves, _| f_of(curves, "driver")),
    (ANOVA, "F of the direction", 0.0882, |curves, _| f_of(curves, "direction")),
    (ESTIMATED, "exponent", 0.23, |curves, _| Some(curves.estimated.exponent)),
    (ESTIMATED, "speed at 250 m, km/h", 60.0, |fit, _| {
        Some(3.6 * fit.estimated.reference_speed_mps)
    }),
    (ESTIMATED, "SD between drivers, %", 16.0, |fit, _| Some(100.0 * fit.estimated.driver_sd?)),
    (ESTIMATED, "SD of the residual, %", 4.8, |fit, _| Some(100.0 * fit.estimated.residual_sd)),
    (FIXED, "speed at 250 m, km/h", 66.0, |fit, _| Some(3.6 * fit.fixed.reference_speed_mps)),
    (FIXED, "SD between drivers, %", 16.0, |fit, _| Some(100.0 * fit.fixed.driver_sd?)),
    (FIXED, "SD of the residual, %", 9.6, |fit, _| Some(100.0 * fit.fixed.residual_sd)),
    (MEDIANS, "70-to-40", -1.16, |_, changes| median_of(changes, "70-to-40")),
    (MEDIANS, "40-to-70", 0.52, |_, changes| median_of(changes, "40-to-70")),
    (MEDIANS, "70-to-60", -1.06, |_, changes| median_of(changes, "70-to-60")),
    (MEDIANS, "60-to-70", 0.44, |_, changes| median_of(changes, "60-to-70")),
    (SDS, "70-to-40", 0.28, |_, changes| sd_of(changes, "70-to-40")),
    (SDS, "40-to-70", 0.18, |_, changes| sd_of(changes, "40-to-70")),
    (SDS, "70-to-60", 0.16, |_, changes| sd_of(changes, "70-to-60")),
    (SDS, "60-to-70", 0.18, |_, changes| sd_of(changes, "60-to-70")),
];

/// Medians of the accelerations, by change, in m/s².
pub(super) const MEDIANS_MPS2: [(&str, f64); 4] =
    [("70-to-40", -1.16), ("40-to-70", 0.52), ("70-to-60", -1.06), ("60-to-70", 0.44)];
