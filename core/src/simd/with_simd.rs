//! Compiles plain loops for the vector registers of the machine.

use super::Level;

/// Loops to be compiled for several instruction sets: their variables and their body.
///
/// This is a trait and not a closure, because only a function can be marked `#[inline(always)]`. Code that is not inlined is
/// compiled for the baseline; this applies to `run` and everything it calls.
pub(crate) trait Loops {
    /// The return type of the loops.
    type Out;
    /// The loops. Mark it `#[inline(always)]`.
    fn run(self) -> Self::Out;
}

/// Runs `job` in a context where the compiler may use the vector registers of `level`.
///
/// For loops with independent lanes that use only + - * / sqrt and integers. No operation is fused, so the bits are
/// the same at every level and on every machine. Callers pass [`Level::best`], except tests of levels. A level
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
            // SAFETY: `best` has detected the instructions, and the operating system saves their registers.
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
        // Neon is part of the baseline of every aarch64.
        let _ = level;
        job.run()
    }
}
