//! Options of an estimator against what they may be.

use thiserror::Error;

/// An option out of its range.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("{option} is {value}; allowed is {allowed}")]
pub struct OptionError {
    /// Name of the option.
    pub option: &'static str,
    /// Its value.
    pub value: f64,
    /// Allowed values.
    pub allowed: &'static str,
}

/// An option, its value, what is allowed, and whether the value is.
pub(crate) type CheckedOption = (&'static str, f64, &'static str, bool);

/// A finite number above 0.
pub(crate) fn above_0(option: &'static str, value: f64) -> CheckedOption {
    (option, value, "a number above 0", value > 0.0 && value.is_finite())
}

/// A finite number from 0 on.
pub(crate) fn from_0(option: &'static str, value: f64) -> CheckedOption {
    (option, value, "a number from 0 on", value >= 0.0 && value.is_finite())
}

/// The first option that is not allowed is the error.
pub(crate) fn check_options<const N: usize>(
    options: [CheckedOption; N],
) -> Result<(), OptionError> {
    match options.into_iter().find(|option| !option.3) {
        Some((option, value, allowed, _)) => Err(OptionError { option, value, allowed }),
        None => Ok(()),
    }
}
