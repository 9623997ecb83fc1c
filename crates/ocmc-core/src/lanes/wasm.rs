//! Bounds in WebAssembly. Its `min` and `max` take care of NaN and signed zeros, which costs eight
//! instructions of a CPU; its pseudo-minimum and pseudo-maximum are those of x86, and cost one.

use super::Lanes;
use fearless_simd::{f64x2, prelude::*};
use std::arch::wasm32::{f64x2_pmax, f64x2_pmin, v128};

/// The larger one of each pair.
#[inline(always)]
pub(super) fn larger<S: Simd>(a: Lanes<S>, b: Lanes<S>) -> Lanes<S> {
    of_halves(a, b, |a, b| f64x2_pmax(b, a))
}

/// The smaller one of each pair.
#[inline(always)]
pub(super) fn smaller<S: Simd>(a: Lanes<S>, b: Lanes<S>) -> Lanes<S> {
    of_halves(a, b, |a, b| f64x2_pmin(b, a))
}

/// An operation on vectors of two numbers.
#[inline(always)]
fn of_halves<S: Simd>(
    a: Lanes<S>,
    b: Lanes<S>,
    operation: impl Fn(v128, v128) -> v128,
) -> Lanes<S> {
    let half =
        |a: f64x2<S>, b: f64x2<S>| -> f64x2<S> { operation(a.into(), b.into()).simd_into(a.simd) };
    let ((a, c), (b, d)) = (a.split(), b.split());
    half(a, b).combine(half(c, d))
}
