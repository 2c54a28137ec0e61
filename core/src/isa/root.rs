//! The square root as one instruction.
//!
//! libm's is inline assembly, which hides the operation from the vectoriser.

#[cfg(target_arch = "x86_64")]
mod machine {
    use core::arch::x86_64::{_mm_cvtsd_f64, _mm_cvtss_f32, _mm_set_sd, _mm_set_ss, _mm_sqrt_pd, _mm_sqrt_ss};

    #[inline(always)]
    #[expect(unsafe_code, reason = "SSE2 belongs to every x86_64 target")]
    pub fn sqrt_f64(x: f64) -> f64 {
        // SAFETY: SSE2 belongs to every x86_64 target.
        unsafe { _mm_cvtsd_f64(_mm_sqrt_pd(_mm_set_sd(x))) }
    }

    #[inline(always)]
    #[expect(unsafe_code, reason = "SSE belongs to every x86_64 target")]
    pub fn sqrt_f32(x: f32) -> f32 {
        // SAFETY: SSE belongs to every x86_64 target.
        unsafe { _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x))) }
    }
}
#[cfg(not(target_arch = "x86_64"))]
mod machine {
    pub fn sqrt_f64(x: f64) -> f64 {
        libm::sqrt(x)
    }
    pub fn sqrt_f32(x: f32) -> f32 {
        libm::sqrtf(x)
    }
}
pub(crate) use machine::{sqrt_f32, sqrt_f64};
