//! Bounds in WebAssembly. Its `min` and `max` take care of NaN and signed zeros, which costs eight
//! instructions of a CPU; its pseudo-minimum and pseudo-maximum are those of x86, and cost one.

use super::Lanes;
use fearless_simd::{f64x2, f64x4, prelude::*};
use std::arch::wasm32::{f64x2_pmax, f64x2_pmin, v128};

/// The larger one of each pair.
#[inline(always)]
pub(super) fn larger<S: Simd>(a: Lanes<S>, b: Lanes<S>) -> Lanes<S> {
    of_quarters(a, b, |a, b| f64x2_pmax(b, a))
}

/// The smaller one of each pair.
#[inline(always)]
pub(super) fn smaller<S: Simd>(a: Lanes<S>, b: Lanes<S>) -> Lanes<S> {
    of_quarters(a, b, |a, b| f64x2_pmin(b, a))
}

/// An operation on vectors of two numbers.
#[inline(always)]
fn of_quarters<S: Simd>(
    a: Lanes<S>,
    b: Lanes<S>,
    operation: impl Fn(v128, v128) -> v128,
) -> Lanes<S> {
    let quarter =
        |a: f64x2<S>, b: f64x2<S>| -> f64x2<S> { operation(a.into(), b.into()).simd_into(a.simd) };
    let half = |a: f64x4<S>, b: f64x4<S>| {
        let ((a, c), (b, d)) = (a.split(), b.split());
        quarter(a, b).combine(quarter(c, d))
    };
    let ((a, c), (b, d)) = (a.split(), b.split());
    half(a, b).combine(half(c, d))
}
