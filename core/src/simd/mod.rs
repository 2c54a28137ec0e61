//! Lanes, instruction sets and their dispatch. `unsafe` is used only here and in `memory`, `exec` and `scalar`.
//!
//! An algorithm is a [`Job`]: safe code, written once over [`Isa`], whose values prove that the processor has the
//! instructions. [`Level::run`] instantiates the job inside a function with the features of that level.
//! Instruction sets differ in one-line operations only (`portable`, `avx2`, `avx512`, `neon`).
//!
//! Everything between `run` and the operations must be `#[inline(always)]`. Otherwise it is compiled without the features.
//! [`Isa::apart`] runs a [`Part`] as a function of its own, with the features: a loop that needs all registers.
//!
//! Lanes are independent: no operation mixes them, except the predicates [`Isa::any`] and [`Isa::bits`].

mod ahead;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod lanes;
mod level;
mod log;
#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;
mod rows;
#[cfg_attr(all(feature = "small", not(any(target_arch = "x86_64", target_arch = "aarch64"))), path = "one_lane.rs")]
#[cfg_attr(
    not(all(feature = "small", not(any(target_arch = "x86_64", target_arch = "aarch64")))),
    path = "four_lanes.rs"
)]
mod vectors;
mod with_simd;

pub use ahead::fetch_ahead;
pub use lanes::{BlockJob, Isa, Job, MAX_LANES, Part, Row};
pub use level::Level;
pub(crate) use log::{log, log_numerator, log_of};
pub use rows::{OCTAVES, PANEL_BITS, ROW, ROWS, Rows};
pub(crate) use with_simd::{Loops, with_simd};

use crate::scalar::Scalar;

/// Selects the instruction set for a job that is generic over the scalar.
pub trait Dispatch: Scalar {
    /// Runs `job` at `level`, or at [`Level::Portable`] if this machine lacks it.
    fn dispatch<J: Job<Self>>(level: Level, job: J) -> J::Out;

    /// Runs `job` at `level`, or in AVX2's lanes at those with wider ones; `false`: at neither, as the level is [`Level::Portable`] or this machine lacks it.
    fn narrow<J: Job<Self, Out = ()>>(level: Level, job: J) -> bool;

    /// Runs `job` at [`Level::Portable`].
    fn portable<J: Job<Self>>(job: J) -> J::Out;
}

macro_rules! dispatch {
    ($t:ty) => {
        impl Dispatch for $t {
            #[inline]
            fn dispatch<J: Job<Self>>(level: Level, job: J) -> J::Out {
                // One call of the portable lanes, so that they are compiled once.
                match level {
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx512 => {
                        if let Some(machine) = avx512::Avx512::new() {
                            return avx512::run::<$t, J>(machine, job);
                        }
                    }
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx2 => {
                        if let Some(machine) = avx2::Avx2::new() {
                            return avx2::run::<$t, J>(machine, job);
                        }
                    }
                    #[cfg(target_arch = "aarch64")]
                    Level::Neon => return job.run(neon::Neon),
                    _ => {}
                }
                job.run(portable::Portable)
            }

            #[inline]
            fn narrow<J: Job<Self, Out = ()>>(level: Level, job: J) -> bool {
                match level {
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx512 | Level::Avx2 => {
                        let Some(machine) = avx2::Avx2::new() else { return false };
                        avx2::run::<$t, J>(machine, job);
                        true
                    }
                    #[cfg(target_arch = "aarch64")]
                    Level::Neon => {
                        job.run(neon::Neon);
                        true
                    }
                    _ => {
                        let _ = job;
                        false
                    }
                }
            }

            #[inline]
            fn portable<J: Job<Self>>(job: J) -> J::Out {
                job.run(portable::Portable)
            }
        }
    };
}
dispatch!(f32);
dispatch!(f64);

/// Runs `job` at [`Level::Portable`]. For jobs that gain nothing from other levels; they are compiled for this one alone.
#[inline]
pub(crate) fn portable<T: Dispatch, J: Job<T>>(job: J) -> J::Out {
    T::portable(job)
}

/// Makes the compiler align the stack of the function that calls this to cache lines: it holds an aligned variable. Vectors that don't fit into the registers of a loop
/// would otherwise lie across two lines, which costs up to a tenth of the time.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(crate) fn aligned_stack() {
    #[repr(align(64))]
    struct Line(#[expect(dead_code, reason = "its size and alignment are what matters")] [u8; 64]);
    core::hint::black_box(&core::mem::MaybeUninit::<Line>::uninit());
}

impl Level {
    /// Runs `job` with this level's instructions.
    #[inline]
    pub fn run<T: Dispatch, J: Job<T>>(self, job: J) -> J::Out {
        T::dispatch(self, job)
    }

    /// Runs `job` with this level's instructions, but in lanes of at most 256 bits, and not at [`Level::Portable`] (`false`): for jobs that few programs run, as each level more
    /// takes time to compile.
    #[inline]
    pub(crate) fn run_narrow<T: Dispatch, J: Job<T, Out = ()>>(self, job: J) -> bool {
        T::narrow(self, job)
    }
}
