//! Trucks side by side, eight or four: the numbers and flags of the step function are the vectors
//! of the `fearless_simd` crate.
//!
//! Its token `S` proves that the CPU has the instructions. Plain IEEE operations, never a fused
//! multiply-add: the bits do not depend on the CPU.

use fearless_simd::{Level, SimdInto, f64x4, f64x8, prelude::*};

#[cfg(target_arch = "wasm32")]
mod wasm;
#[cfg(four_lanes)]
use fearless_simd::{f64x4 as Numbers, mask64x4 as Truths, u64x4 as Integers};
#[cfg(not(four_lanes))]
use fearless_simd::{f64x8 as Numbers, mask64x8 as Truths, u64x8 as Integers};
#[cfg(target_arch = "wasm32")]
use wasm::{larger, smaller};

/// Trucks of one block: four in WebAssembly, whose vectors have two numbers each, and without
/// optimisation, where the time of the compiler counts.
pub const WIDTH: usize = if cfg!(four_lanes) { 4 } else { 8 };

/// A number that never binds: a distance, a speed or a squared speed.
pub const UNBOUNDED: f64 = 1e9;

/// A number for each truck.
pub type Lanes<S> = Numbers<S>;

/// A flag for each truck.
pub type Flags<S> = Truths<S>;

/// The instructions that every CPU of the platform has.
#[cfg(target_arch = "x86_64")]
pub type Baseline = fearless_simd::x86::Sse2;
/// The instructions that every CPU of the platform has.
#[cfg(target_arch = "aarch64")]
pub type Baseline = fearless_simd::aarch64::Neon;
/// The instructions that every browser with vectors has.
#[cfg(target_arch = "wasm32")]
pub type Baseline = fearless_simd::wasm32::WasmSimd128;
/// The instructions that every CPU of the platform has.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64", target_arch = "wasm32")))]
pub type Baseline = fearless_simd::Fallback;

#[cfg(all(target_arch = "wasm32", not(target_feature = "simd128")))]
compile_error!("trucks side by side need vectors: build with `-C target-feature=+simd128`");

/// The token of these instructions. `dispatch!` would compile for all the others, too.
#[inline(always)]
pub fn baseline() -> Baseline {
    #[cfg(target_arch = "x86_64")]
    let token = Level::baseline().as_sse2();
    #[cfg(target_arch = "aarch64")]
    let token = Level::baseline().as_neon();
    #[cfg(target_arch = "wasm32")]
    let token = Level::baseline().as_wasm_simd128();
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64", target_arch = "wasm32")))]
    let token = Some(Baseline::new());
    token.expect("what every CPU has")
}

/// A number in all lanes, to ask a function of the kernel about one case.
#[inline(always)]
pub fn one(number: f64) -> Lanes<Baseline> {
    Lanes::splat(baseline(), number)
}

/// The numbers where a flag is set, otherwise zero.
#[inline(always)]
pub fn masked<S: Simd>(flags: Flags<S>, numbers: Lanes<S>) -> Lanes<S> {
    flags.select(numbers, Lanes::splat(numbers.simd, 0.0))
}

/// Whether the steps of two blocks are interleaved, so that the CPU works on one while it waits for
/// results of the other.
///
/// That is for vectors of eight numbers. With narrower ones a step has so many instructions that
/// those of two blocks do not fit into the first-level cache of 32 KB, and one block alone takes a
/// quarter less time.
#[inline(always)]
pub fn interleaves_blocks<S: Simd>(simd: S) -> bool {
    match simd.level() {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(_) => true,
        _ => false,
    }
}

/// A scheduling barrier: these numbers are computed before what comes after the next barrier.
///
/// Where the steps of two blocks are interleaved, the compiler would put all parts of one block
/// first, and those of the other behind them, beyond what the CPU can see at once. One block alone
/// is compiled a little better with the barriers, too. A barrier costs a store. WebAssembly has
/// none: the browser schedules its instructions anew.
#[inline(always)]
pub fn scheduling_barrier<S: Simd>(numbers: Lanes<S>) {
    if cfg!(not(target_arch = "wasm32")) {
        std::hint::black_box(&numbers);
    }
}

/// Kept between two numbers.
#[inline(always)]
pub fn clip<S: Simd>(numbers: Lanes<S>, lower: f64, upper: f64) -> Lanes<S> {
    numbers.at_least(lower).at_most(upper)
}

/// Bounds of numbers: what `max` and `min` are, in one instruction on all platforms.
pub trait Bounded<S: Simd>: Sized {
    /// The larger one of each pair.
    #[must_use]
    fn at_least(self, lower: impl SimdInto<Self, S>) -> Self;

    /// The smaller one of each pair.
    #[must_use]
    fn at_most(self, upper: impl SimdInto<Self, S>) -> Self;
}

impl<S: Simd> Bounded<S> for Lanes<S> {
    #[inline(always)]
    fn at_least(self, lower: impl SimdInto<Self, S>) -> Self {
        larger(self, lower.simd_into(self.simd))
    }

    #[inline(always)]
    fn at_most(self, upper: impl SimdInto<Self, S>) -> Self {
        smaller(self, upper.simd_into(self.simd))
    }
}

#[cfg(not(target_arch = "wasm32"))]
#[inline(always)]
fn larger<S: Simd>(a: Lanes<S>, b: Lanes<S>) -> Lanes<S> {
    a.max(b)
}

#[cfg(not(target_arch = "wasm32"))]
#[inline(always)]
fn smaller<S: Simd>(a: Lanes<S>, b: Lanes<S>) -> Lanes<S> {
    a.min(b)
}

/// Linear interpolation: the first number at share 0, the second one at share 1.
#[inline(always)]
pub fn lerp<S: Simd>(share: Lanes<S>, first: Lanes<S>, second: Lanes<S>) -> Lanes<S> {
    first + share * (second - first)
}

/// The columns of rows that are found lane by lane: a row load and a transposition serve where a
/// gather would be slow.
#[inline(always)]
pub fn columns<'a, S: Simd>(simd: S, row_of: impl Fn(usize) -> &'a [f64; 4]) -> [Lanes<S>; 4] {
    transposed(simd, row_of)
}

#[cfg(four_lanes)]
#[inline(always)]
fn transposed<'a, S: Simd>(simd: S, row_of: impl Fn(usize) -> &'a [f64; 4]) -> [Lanes<S>; 4] {
    let rows = |front, back| two_rows(simd, row_of(front), row_of(back));
    let (even, odd) = rows(0, 1).deinterleave(rows(2, 3));
    let each_second = |numbers: f64x8<S>| {
        let (front, back) = numbers.split();
        front.deinterleave(back)
    };
    let ((first, third), (second, fourth)) = (each_second(even), each_second(odd));
    [first, second, third, fourth]
}

#[cfg(not(four_lanes))]
#[inline(always)]
fn transposed<'a, S: Simd>(simd: S, row_of: impl Fn(usize) -> &'a [f64; 4]) -> [Lanes<S>; 4] {
    let rows = |front, back| two_rows(simd, row_of(front), row_of(back));
    let (even_front, odd_front) = rows(0, 1).deinterleave(rows(2, 3));
    let (even_back, odd_back) = rows(4, 5).deinterleave(rows(6, 7));
    let (first, third) = even_front.deinterleave(even_back);
    let (second, fourth) = odd_front.deinterleave(odd_back);
    [first, second, third, fourth]
}

#[inline(always)]
fn two_rows<S: Simd>(simd: S, front: &[f64; 4], back: &[f64; 4]) -> f64x8<S> {
    f64x4::load_array_ref(simd, front).combine(f64x4::load_array_ref(simd, back))
}

/// Natural logarithms of positive normal numbers: the bits of [`libm::log`], whose algorithm it is
/// (FreeBSD, `e_log.c`).
///
/// x = 2ᵏ (1 + f) with 1 + f from √½ to √2; with s = f/(2 + f), ln(1 + f) = f − f²/2 + s (f²/2 +
/// R(s²)).
#[inline(always)]
pub fn ln<S: Simd>(x: Lanes<S>) -> Lanes<S> {
    const FRACTION: u64 = (1 << 52) - 1;
    const ROOT_OF_HALF: u64 = 0x3fe6_a09e_0000_0000;
    const ONE: u64 = 0x3ff0_0000_0000_0000;
    /// 2⁵² as a number, where the last binary digit counts ones.
    const TWO_TO_52: u64 = 0x4330_0000_0000_0000;
    let bits: Integers<S> = x.bitcast::<Integers<S>>() + (ONE - ROOT_OF_HALF);
    let exponent: Lanes<S> = ((bits >> 52) | TWO_TO_52).bitcast();
    let k = exponent - (f64::from_bits(TWO_TO_52) + 1023.0);
    let reduced: Lanes<S> = ((bits & FRACTION) + ROOT_OF_HALF).bitcast();
    let f = reduced - 1.0;
    let half_square = 0.5 * f * f;
    let s = f / (2.0 + f);
    let (z, w) = (s * s, s * s * (s * s));
    let odd = w * (LN[1] + w * (LN[3] + w * LN[5]));
    let even = z * (LN[0] + w * (LN[2] + w * (LN[4] + w * LN[6])));
    s * (half_square + (even + odd)) + k * LN2_LOW - half_square + f + k * LN2_HIGH
}

const LN2_HIGH: f64 = 6.931_471_803_691_238_164_90e-01;
const LN2_LOW: f64 = 1.908_214_929_270_587_700_02e-10;
const LN: [f64; 7] = [
    6.666_666_666_666_735_130e-01,
    3.999_999_999_940_941_908e-01,
    2.857_142_874_366_239_149e-01,
    2.222_219_843_214_978_396e-01,
    1.818_357_216_161_805_012e-01,
    1.531_383_769_920_937_332e-01,
    1.479_819_860_511_658_591e-01,
];

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::dispatch;

    const A: [f64; WIDTH] = [0.0, -0.0, 1.0, -2.5, 1e-300, 7e11, f64::INFINITY, 0.1];
    const B: [f64; WIDTH] = [1.7, 0.1, 0.7, -1.8, 3.3, 7e11, 0.8, -0.3];

    /// Results of the step function's operations on numbers, as bits.
    #[inline(always)]
    fn operations<S: Simd>(simd: S) -> Vec<[u64; WIDTH]> {
        let (a, b) = (Lanes::load_array(simd, A), Lanes::load_array(simd, B));
        let less = a.simd_lt(b);
        let results = [
            a + b,
            a - b,
            a * b,
            a / b,
            -a,
            a.at_most(b),
            a.at_least(b),
            a.abs().sqrt(),
            clip(a, -1.0, 0.5),
            1.0 - a * 3.0 + 0.1,
            less.select(a, b),
            masked(!less & a.simd_gt(0.0) | b.simd_lt(0.5), a),
        ];
        let mut bits: Vec<[u64; WIDTH]> =
            results.iter().map(|lanes| <[f64; WIDTH]>::from(*lanes).map(f64::to_bits)).collect();
        bits.push([less.to_bitmask(); WIDTH]);
        let table: Vec<[f64; 4]> =
            (0..99).map(|k| [0.1 * f64::from(k), -1.7, f64::from(k * k), 3.0]).collect();
        for column in columns(simd, |l| &table[l * 11 % 99]) {
            bits.push(<[f64; WIDTH]>::from(column).map(f64::to_bits));
        }
        bits
    }

    /// The same with plain numbers.
    fn plain() -> Vec<[u64; WIDTH]> {
        let all = |f: &dyn Fn(f64, f64) -> f64| std::array::from_fn(|l| f(A[l], B[l]).to_bits());
        let mut bits = vec![
            all(&|a, b| a + b),
            all(&|a, b| a - b),
            all(&|a, b| a * b),
            all(&|a, b| a / b),
            all(&|a, _| -a),
            all(&|a, b| if a < b { a } else { b }),
            all(&|a, b| if a > b { a } else { b }),
            all(&|a, _| a.abs().sqrt()),
            all(&|a, _| a.clamp(-1.0, 0.5)),
            all(&|a, _| 1.0 - a * 3.0 + 0.1),
            all(&|a, b| if a < b { a } else { b }),
            all(&|a, b| if (a >= b && a > 0.0) || b < 0.5 { a } else { 0.0 }),
        ];
        bits.push([(0..WIDTH).map(|l| u64::from(A[l] < B[l]) << l).sum(); WIDTH]);
        for n in 0..4 {
            let row = |k: u32| [0.1 * f64::from(k), -1.7, f64::from(k * k), 3.0];
            bits.push(std::array::from_fn(|l| row(l as u32 * 11 % 99)[n].to_bits()));
        }
        bits
    }

    #[test]
    fn logarithms_are_those_of_plain_numbers() {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            // any positive normal number: an exponent from 1 to 2046
            f64::from_bits((state >> 12) | ((1 + (state & 0xfff) % 2046) << 52))
        };
        let near_one = [0.5, 0.7, 0.75, 1.0 - 1e-16, 1.0, 1.0 + 3e-16, 1.4, 2.0];
        let mut all: Vec<[f64; WIDTH]> =
            (0..10_000).map(|_| std::array::from_fn(|_| next())).collect();
        all.push(near_one);
        for x in all {
            let logarithms: [f64; WIDTH] =
                dispatch!(Level::new(), simd => ln(Lanes::load_array(simd, x)).into());
            for (x, logarithm) in x.into_iter().zip(logarithms) {
                assert_eq!(logarithm.to_bits(), libm::log(x).to_bits(), "{x}");
            }
        }
    }

    #[test]
    fn operations_are_those_of_plain_numbers_on_every_cpu() {
        assert_eq!(dispatch!(Level::baseline(), simd => operations(simd)), plain());
        #[cfg(target_arch = "x86_64")]
        {
            if let Some(simd) = Level::new().as_avx2() {
                assert_eq!(simd.vectorize(|| operations(simd)), plain());
            }
            if let Some(simd) = Level::new().as_avx512() {
                assert_eq!(simd.vectorize(|| operations(simd)), plain());
            }
        }
    }
}
