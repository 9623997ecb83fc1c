//! Parameters that an identification fits, and their bounds.

use serde::Serialize;
use thiserror::Error;

/// Controller that is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ControllerKind {
    /// PID.
    Pid,
    /// Switched proportional.
    Switched,
}

/// Speed that the speed term compares with the set speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SpeedTerm {
    /// No speed term.
    None,
    /// The measured speed.
    Measured,
    /// The simulated speed.
    Simulated,
}

/// Parameter that may be unknown beside the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// How late the driver sees the speed.
    Delay,
    /// The mass of the truck.
    Mass,
    /// Rolling resistance and air drag of the truck.
    Resistance,
    /// Nothing.
    Nothing,
}

/// Parameters that are estimated with the controller, from what is known of them before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Unknowns {
    /// How late the driver sees the speed.
    pub delay: bool,
    /// The mass of the truck.
    pub mass: bool,
    /// Rolling resistance and air drag of the truck.
    pub resistance: bool,
}

impl Unknowns {
    /// All of them.
    pub const ALL: Self = Self { delay: true, mass: true, resistance: true };
    /// None of them: the truck is the study's, and its driver reacts at once.
    pub const NONE: Self = Self { delay: false, mass: false, resistance: false };

    /// Unknowns of a list.
    pub fn of(list: &[Unknown]) -> Self {
        let has = |unknown| list.contains(&unknown);
        Self {
            delay: has(Unknown::Delay),
            mass: has(Unknown::Mass),
            resistance: has(Unknown::Resistance),
        }
    }

    /// Unknowns that are estimated where nothing else is said: all with a PID whose pedals alone
    /// are compared; none with a switched driver, whose pedals jump, or with a speed term, which
    /// biases what is estimated.
    pub fn standard(controller: ControllerKind, speed_term: SpeedTerm) -> Self {
        match (controller, speed_term) {
            (ControllerKind::Pid, SpeedTerm::None) => Self::ALL,
            _ => Self::NONE,
        }
    }
}

/// Options of the identification.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct IdentifyOptions {
    /// Kind of the controller.
    pub controller: ControllerKind,
    /// Kind of the speed term.
    pub speed_term: SpeedTerm,
    /// Further unknowns.
    pub unknown: Unknowns,
    /// Number of starts.
    pub starts: usize,
    /// Resolution of the pedal sensors.
    pub resolution: f64,
    /// Whether intervals are worked out; they take several times as long as the fit.
    pub intervals: bool,
    /// Bounds of K_P, in s/m.
    pub proportional: [f64; 2],
    /// Bounds of K_I, in 1/m.
    pub integral: [f64; 2],
    /// Bounds of K_D, in s²/m. A lower bound of 0 is one of the gain: the estimate of a fit that
    /// has passed its tests may fall below, for noise moves it to both sides.
    pub derivative: [f64; 2],
    /// Bounds of a switched driver's threshold, in m/s.
    pub threshold_mps: [f64; 2],
    /// Threads; one for each CPU where it is 0. The answer does not depend on them.
    #[serde(skip)]
    pub threads: usize,
}

impl Default for IdentifyOptions {
    fn default() -> Self {
        Self {
            controller: ControllerKind::Pid,
            // the paper's readings bias the gains
            speed_term: SpeedTerm::None,
            unknown: Unknowns::ALL,
            starts: 8,
            resolution: 0.01,
            intervals: true,
            proportional: [0.01, 2.0],
            integral: [1e-4, 0.2],
            derivative: [0.0, 2.0],
            threshold_mps: [0.0, 3.0],
            threads: 0,
        }
    }
}

/// Bounds between which nothing can be looked for.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "the bounds of {name} are {} and {}: they have to rise, from {least} on", bounds[0], bounds[1]
)]
pub struct BoundsError {
    /// Name of the gain.
    name: &'static str,
    /// Its bounds.
    bounds: [f64; 2],
    /// Smallest lower bound.
    least: f64,
}

impl IdentifyOptions {
    /// Whether the bounds of the gains are bounds.
    ///
    /// # Errors
    /// [`BoundsError`] for the first gain whose bounds are none.
    pub fn check(&self) -> Result<(), BoundsError> {
        for (name, bounds, least) in [
            ("kp", self.proportional, 1e-3),
            ("ki", self.integral, 1e-6),
            ("kd", self.derivative, -2.0),
        ] {
            if !(bounds[0] >= least && bounds[1] > bounds[0] && bounds[1].is_finite()) {
                return Err(BoundsError { name, bounds, least });
            }
        }
        Ok(())
    }
}
