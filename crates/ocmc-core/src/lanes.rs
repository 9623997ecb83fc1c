//! Eight trucks side by side: the numbers and flags of the step function are the vectors of the `fearless_simd` crate.
//!
//! Its token `S` proves that the CPU has the instructions. Plain IEEE operations, never a fused multiply-add: the bits
//! do not depend on the CPU.

use fearless_simd::{f64x4, f64x8, mask64x8, prelude::*};

/// Trucks of one block.
pub const WIDTH: usize = 8;

/// A number for each truck.
pub type Lanes<S> = f64x8<S>;

/// A flag for each truck.
pub type Flags<S> = mask64x8<S>;

/// The numbers where a flag is set, otherwise zero.
#[inline(always)]
pub fn where_set<S: Simd>(flags: Flags<S>, numbers: Lanes<S>) -> Lanes<S> {
    flags.select(numbers, Lanes::splat(numbers.simd, 0.0))
}

/// Kept between two numbers.
#[inline(always)]
pub fn clip<S: Simd>(numbers: Lanes<S>, lower: f64, upper: f64) -> Lanes<S> {
    numbers.max(lower).min(upper)
}

/// The columns of rows that are found lane by lane: a row load and a transposition serve where a gather would be slow.
#[inline(always)]
pub fn columns<'a, S: Simd>(simd: S, row_of: impl Fn(usize) -> &'a [f64; 4]) -> [Lanes<S>; 4] {
    let (even_front, odd_front) =
        two_rows(simd, row_of(0), row_of(1)).deinterleave(two_rows(simd, row_of(2), row_of(3)));
    let (even_back, odd_back) =
        two_rows(simd, row_of(4), row_of(5)).deinterleave(two_rows(simd, row_of(6), row_of(7)));
    let (first, third) = even_front.deinterleave(even_back);
    let (second, fourth) = odd_front.deinterleave(odd_back);
    [first, second, third, fourth]
}

#[inline(always)]
fn two_rows<S: Simd>(simd: S, front: &[f64; 4], back: &[f64; 4]) -> Lanes<S> {
    f64x4::load_array_ref(simd, front).combine(f64x4::load_array_ref(simd, back))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    /// What the step function does with numbers, on some that are awkward, as bits.
    #[inline(always)]
    fn operations<S: Simd>(simd: S) -> Vec<[u64; WIDTH]> {
        let table: Vec<[f64; 4]> =
            (0..99).map(|k| [0.1 * f64::from(k), -1.7, f64::from(k * k), 3.0]).collect();
        let numbers = [0.0, -0.0, 1.0, -2.5, 1e-300, 7e11, f64::INFINITY, 0.1];
        let mut a = Lanes::splat(simd, 0.3);
        let mut b = a;
        for l in 0..WIDTH {
            a[l] = numbers[l];
            b[l] = numbers[(3 * l + 1) % 8] + 0.7;
        }
        let flags = a.simd_lt(b);
        let [c, d, e, f] = columns(simd, |l| &table[l * 11 % 99]);
        for l in 0..WIDTH {
            assert!([c[l], d[l], e[l], f[l]] == table[l * 11 % 99]);
        }
        let results = [
            a + b,
            a - b,
            a * b,
            a / b,
            -a,
            a.min(b),
            a.max(b),
            a.abs().sqrt(),
            clip(a, -1.0, 0.5),
            1.0 - a * 3.0 + 0.1,
            flags.select(a, b),
            where_set(!flags & a.simd_gt(0.0) | b.simd_lt(0.5), a),
        ];
        let mut bits: Vec<[u64; WIDTH]> =
            results.map(|lanes| <[f64; WIDTH]>::from(lanes).map(f64::to_bits)).into();
        bits.push([flags.to_bitmask(); WIDTH]);
        bits
    }

    #[test]
    fn operations_have_the_same_bits_on_every_cpu() {
        let expected = dispatch!(Level::baseline(), simd => operations(simd));
        let plain = 1e-300 * (7e11 + 0.7);
        assert!(expected[2].contains(&f64::to_bits(plain)) || expected[2].len() == WIDTH);
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = Level::new().as_avx2().map(operations);
            let avx512 = Level::new().as_avx512().map(operations);
            for bits in avx2.into_iter().chain(avx512) {
                assert_eq!(bits, expected);
            }
        }
    }
}
