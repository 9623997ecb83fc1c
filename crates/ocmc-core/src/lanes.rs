//! `W` numbers side by side: the arithmetic of the step function.
//!
//! Operators are loops over an array, which the compiler turns into vector instructions of whatever CPU the
//! function is compiled for. Plain IEEE operations, never a fused multiply-add: the bits do not depend on the CPU or on `W`.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// `W` lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Lanes<const W: usize>(pub [f64; W]);

impl<const W: usize> Lanes<W> {
    /// Zero in all lanes.
    pub const ZERO: Self = Self([0.0; W]);

    /// The same in all lanes.
    #[inline(always)]
    pub fn all(value: f64) -> Self {
        Self([value; W])
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut out = [0.0; W];
        for l in 0..W {
            out[l] = f(self.0[l]);
        }
        Self(out)
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = [0.0; W];
        for l in 0..W {
            out[l] = f(self.0[l], other.0[l]);
        }
        Self(out)
    }

    /// The smaller one; the second where they do not compare.
    #[inline(always)]
    #[must_use]
    pub fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    /// The larger one; the second where they do not compare.
    #[inline(always)]
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    /// Kept between two numbers.
    #[inline(always)]
    #[must_use]
    pub fn clip(self, lower: f64, upper: f64) -> Self {
        self.max(Self::all(lower)).min(Self::all(upper))
    }

    /// Absolute value.
    #[inline(always)]
    #[must_use]
    pub fn abs(self) -> Self {
        self.map(f64::abs)
    }

    /// Square root.
    #[inline(always)]
    #[must_use]
    pub fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    /// `x` where `a < b`, otherwise `y`.
    #[inline(always)]
    pub fn select_lt(a: Self, b: Self, x: Self, y: Self) -> Self {
        let mut out = [0.0; W];
        for l in 0..W {
            out[l] = if a.0[l] < b.0[l] { x.0[l] } else { y.0[l] };
        }
        Self(out)
    }

    /// One where `a < b`, otherwise zero.
    #[inline(always)]
    pub fn flag_lt(a: Self, b: Self) -> Self {
        a.zip(b, |a, b| if a < b { 1.0 } else { 0.0 })
    }

    /// `x` where the flag is set, otherwise `y`.
    #[inline(always)]
    #[must_use]
    pub fn choose(self, x: Self, y: Self) -> Self {
        Self::select_lt(Self::ZERO, self, x, y)
    }

    /// The other flag.
    #[inline(always)]
    #[must_use]
    #[expect(
        clippy::should_implement_trait,
        reason = "flags are lanes; `and` and `or` stand beside it"
    )]
    pub fn not(self) -> Self {
        self.choose(Self::ZERO, Self::all(1.0))
    }

    /// Both flags. Written as a selection, which the compiler turns into operations on masks.
    #[inline(always)]
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        self.choose(other, Self::ZERO)
    }

    /// Either flag.
    #[inline(always)]
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        self.choose(Self::all(1.0), other)
    }

    /// One bit for each lane that is above zero.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        let mut bits = 0;
        for l in 0..W {
            bits |= u32::from(self.0[l] > 0.0) << l;
        }
        bits
    }

    /// Whether any lane is above zero.
    #[inline(always)]
    pub fn any(self) -> bool {
        let mut any = false;
        for l in 0..W {
            any |= self.0[l] > 0.0;
        }
        any
    }
}

/// Rows, one a lane, as columns: a row load and a transposition serve where a gather would be slow.
#[inline(always)]
pub fn transpose<const W: usize, const N: usize>(rows: &[[f64; N]; W]) -> [Lanes<W>; N] {
    let mut columns = [Lanes::ZERO; N];
    for l in 0..W {
        for n in 0..N {
            columns[n].0[l] = rows[l][n];
        }
    }
    columns
}

impl<const W: usize> Add for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<const W: usize> Sub for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<const W: usize> Mul for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl<const W: usize> Mul<f64> for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.map(|a| a * other)
    }
}

impl<const W: usize> Div for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

impl<const W: usize> Neg for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}
