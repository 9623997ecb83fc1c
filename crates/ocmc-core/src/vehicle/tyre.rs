//! Tyre codes: from `315/70R22.5` to the dynamic radius.
//!
//! Diameter d = rim + 2 · width · aspect; dynamic radius r = 3.05 d / 2π, the rolling circumference
//! of radial tyres that VECTO takes for 15° rims (recalled with confidence). 315/70R22.5: d =
//! 1012.5 mm, r = 0.4915 m.

use std::str::FromStr;
use thiserror::Error;

/// Rolling circumference over diameter.
const CIRCUMFERENCE: f64 = 3.05;
/// Metres in an inch.
const INCH_M: f64 = 0.0254;

/// A tyre's size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TyreSize {
    /// Width, in m.
    pub width_m: f64,
    /// Height of the section over its width.
    pub aspect: f64,
    /// Diameter of the rim, in m.
    pub rim_m: f64,
}

/// A text that is no tyre code.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "`{code}` is no tyre code; one is width in mm / aspect in % R rim in inches, as in 315/70R22.5"
)]
pub struct TyreCodeError {
    /// The text.
    pub code: String,
}

impl TyreSize {
    /// Diameter without load, in m.
    pub fn diameter_m(&self) -> f64 {
        self.rim_m + 2.0 * self.width_m * self.aspect
    }

    /// Dynamic radius, in m.
    pub fn dynamic_radius_m(&self) -> f64 {
        CIRCUMFERENCE * self.diameter_m() / std::f64::consts::TAU
    }
}

impl FromStr for TyreSize {
    type Err = TyreCodeError;

    fn from_str(code: &str) -> Result<Self, TyreCodeError> {
        let wrong = || TyreCodeError { code: code.to_owned() };
        let plain: String = code.chars().filter(|c| !c.is_whitespace()).collect();
        let (width, rest) = plain.split_once('/').ok_or_else(wrong)?;
        let (aspect, rim) = rest.split_once(['R', 'r', 'D', '-']).ok_or_else(wrong)?;
        let number = |text: &str, minimum: f64, maximum: f64| {
            let number = text.parse::<f64>().ok();
            number.filter(|n| (minimum..=maximum).contains(n)).ok_or_else(wrong)
        };
        // what stands behind the rim's digits is load and speed
        let digits = rim.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rim.len());
        Ok(Self {
            width_m: number(width, 50.0, 600.0)? / 1000.0,
            aspect: number(aspect, 10.0, 120.0)? / 100.0,
            rim_m: number(&rim[..digits], 8.0, 60.0)? * INCH_M,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_the_sources() {
        let size: TyreSize = "315/70R22.5".parse().unwrap();
        assert!((size.diameter_m() - 1.0125).abs() < 1e-9);
        // VECTO's tyres: dynamic radius .488 to .492 m
        assert!((size.dynamic_radius_m() - 0.4915).abs() < 1e-4);
        let spaced: TyreSize = "245/70 R19.5 136/134M".parse().unwrap();
        // VECTO, 12t Delivery Truck: 406.9 mm
        assert!((spaced.dynamic_radius_m() - 0.4069).abs() < 5e-4, "{}", spaced.dynamic_radius_m());
        for code in ["", "315", "315/70", "x/70R22.5", "315/70R", "1e9/70R22.5", "315/NaNR22.5"] {
            assert!(code.parse::<TyreSize>().is_err(), "{code}");
        }
    }
}
