//! The machine: lanes, instruction sets and the one dispatch. The only place, with `space`, that holds `unsafe` in core.
//!
//! An algorithm is a [`Job`]: safe code, stated once over [`Isa`], whose values prove that the processor has the
//! instructions. [`Level::run`] enters a machine: it instantiates the job inside a function with that machine's
//! features. Machines differ in one-line operations only (`portable`, `avx2`, `avx512`, `neon`).
//!
//! Everything between `run` and the operations must be `#[inline(always)]`, or it is compiled without the features.
//!
//! Lanes are independent: no operation mixes them, but for the questions [`Isa::any`] and [`Isa::bits`].

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
mod with_simd;

pub use lanes::{BlockJob, Isa, Job, MAX_LANES};
pub use level::Level;
pub(crate) use log::{log, log_numerator};
pub use rows::{OCTAVES, PANEL_BITS, ROW, ROWS, Rows};
pub(crate) use with_simd::{Loops, with_simd};

use crate::scalar::Scalar;

/// Enters machines: a job generic over the scalar finds its instructions.
pub trait Dispatch: Scalar {
    /// Runs `job` on `level`, or on [`Level::Portable`] where this machine lacks it.
    fn dispatch<J: Job<Self>>(level: Level, job: J) -> J::Out;

    /// Runs `job` on [`Level::Portable`].
    fn portable<J: Job<Self>>(job: J) -> J::Out;
}

macro_rules! dispatch {
    ($t:ty) => {
        impl Dispatch for $t {
            #[inline]
            fn dispatch<J: Job<Self>>(level: Level, job: J) -> J::Out {
                match level {
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx512 => match avx512::Avx512::new() {
                        Some(machine) => avx512::run::<$t, J>(machine, job),
                        None => job.run(portable::Portable),
                    },
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx2 => match avx2::Avx2::new() {
                        Some(machine) => avx2::run::<$t, J>(machine, job),
                        None => job.run(portable::Portable),
                    },
                    #[cfg(target_arch = "aarch64")]
                    Level::Neon => job.run(neon::Neon),
                    _ => job.run(portable::Portable),
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

/// Runs `job` at [`Level::Portable`], for jobs that gain nothing from another: they are compiled for it alone.
#[inline]
pub(crate) fn portable<T: Dispatch, J: Job<T>>(job: J) -> J::Out {
    T::portable(job)
}

impl Level {
    /// Runs `job` with this level's instructions.
    #[inline]
    pub fn run<T: Dispatch, J: Job<T>>(self, job: J) -> J::Out {
        T::dispatch(self, job)
    }
}
