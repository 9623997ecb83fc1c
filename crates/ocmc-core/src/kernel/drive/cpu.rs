//! Instruction sets of the kernel. The records do not depend on them.
//!
//! The unit tests of this crate, and builds without optimisation, take the baseline at every level:
//! they are compiled in a part of the time. All others have every level that the CPU has.

use crate::lanes::baseline;
#[cfg(target_arch = "x86_64")]
use fearless_simd::Level;
use fearless_simd::Simd;

/// A set of instructions that the kernel is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CpuLevel {
    /// Instructions that every CPU of the platform has.
    Baseline,
    /// AVX2, with what x86-64-v3 has beside it.
    Avx2,
    /// AVX-512 as of Ice Lake and Zen 4.
    Avx512,
}

/// Computation with one set of instructions.
pub(super) trait SimdTask {
    /// Result of the computation.
    type Answer;

    /// Computes it. To be inlined always, so that it is compiled for the CPU of the level.
    fn run<S: Simd>(self, simd: S) -> Self::Answer;
}

impl CpuLevel {
    /// Runs a task with the instructions of this level.
    pub(super) fn run<T: SimdTask>(self, task: T) -> T::Answer {
        #[cfg(target_arch = "x86_64")]
        if cfg!(not(any(test, unoptimised)))
            && self == Self::Avx512
            && let Some(simd) = Level::new().as_avx512()
        {
            return simd.vectorize(
                #[inline(always)]
                || task.run(simd),
            );
        }
        #[cfg(target_arch = "x86_64")]
        if cfg!(not(any(test, unoptimised)))
            && self >= Self::Avx2
            && let Some(simd) = Level::new().as_avx2()
        {
            return simd.vectorize(
                #[inline(always)]
                || task.run(simd),
            );
        }
        let simd = baseline();
        simd.vectorize(
            #[inline(always)]
            || task.run(simd),
        )
    }

    /// All levels, from the lowest.
    pub const ALL: [Self; 3] = [Self::Baseline, Self::Avx2, Self::Avx512];

    /// Whether this CPU has it.
    pub fn is_available(self) -> bool {
        match self {
            Self::Baseline => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => Level::new().as_avx2().is_some(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => Level::new().as_avx512().is_some(),
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// The highest level that this CPU has.
    pub fn best() -> Self {
        Self::ALL.into_iter().rev().find(|level| level.is_available()).unwrap_or(Self::Baseline)
    }

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }
}
