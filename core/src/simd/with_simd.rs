//! Runs plain code compiled for the machine's with_simd registers.

use super::Level;

/// Loops to be compiled for several instruction sets: the loop's variables, and its body.
///
/// A trait and not a closure, because only a function can be marked `#[inline(always)]`, and what is not inlined is
/// compiled for the baseline: that holds for `run` and everything it calls.
pub(crate) trait Loops {
    /// What the loops return.
    type Out;
    /// The loops. Mark it `#[inline(always)]`.
    fn run(self) -> Self::Out;
}

/// Runs `job` in a context where the compiler may use the with_simd vectors of `level`.
///
/// For loops whose lanes are independent and that use only + - * / sqrt and integers: no operation is fused, so the bits are
/// the same at every level and on every machine, and callers pass [`Level::best`] unless they test just that. A level
/// that the machine lacks is replaced by its best.
#[inline]
pub(crate) fn with_simd<J: Loops>(level: Level, job: J) -> J::Out {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl")]
        fn avx512<J: Loops>(job: J) -> J::Out {
            job.run()
        }
        #[target_feature(enable = "avx2")]
        fn avx2<J: Loops>(job: J) -> J::Out {
            job.run()
        }
        match level.min(Level::best()) {
            // SAFETY: `best` has found the instructions, and the system saves their registers.
            #[expect(unsafe_code, reason = "enters code compiled for instructions that were found")]
            Level::Avx512 => unsafe { avx512(job) },
            // SAFETY: as above.
            #[expect(unsafe_code, reason = "enters code compiled for instructions that were found")]
            Level::Avx2 => unsafe { avx2(job) },
            Level::Neon | Level::Portable => job.run(),
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        // Neon belongs to the baseline where it exists.
        let _ = level;
        job.run()
    }
}
