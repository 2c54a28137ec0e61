//! The square root as one instruction.
//!
//! libm's version is inline assembly, which prevents vectorisation.

#[cfg(target_arch = "x86_64")]
mod machine {
    use core::arch::x86_64::{_mm_cvtsd_f64, _mm_cvtss_f32, _mm_set_sd, _mm_set_ss, _mm_sqrt_pd, _mm_sqrt_ss};

    #[inline(always)]
    #[expect(unsafe_code, reason = "SSE2 belongs to every x86_64 target")]
    pub fn sqrt_f64(x: f64) -> f64 {
        // SAFETY: every x86_64 target has SSE2.
        unsafe { _mm_cvtsd_f64(_mm_sqrt_pd(_mm_set_sd(x))) }
    }

    #[inline(always)]
    #[expect(unsafe_code, reason = "SSE belongs to every x86_64 target")]
    pub fn sqrt_f32(x: f32) -> f32 {
        // SAFETY: every x86_64 target has SSE.
        unsafe { _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x))) }
    }
}
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
mod machine {
    pub fn sqrt_f64(x: f64) -> f64 {
        libm::sqrt(x)
    }

    #[inline(always)]
    pub fn sqrt_f32(x: f32) -> f32 {
        // Argument and result are in s0. The number encodes `vsqrt.f32 s0, s0`. The assembler accepts the mnemonic
        // only with more floating-point features than a Cortex-M4F has.
        #[unsafe(naked)]
        extern "C" fn vsqrt(x: f32) -> f32 {
            core::arch::naked_asm!(".inst.w 0xeeb10ac0", "bx lr")
        }
        vsqrt(x)
    }
}
#[cfg(not(any(target_arch = "x86_64", all(target_arch = "arm", target_abi = "eabihf"))))]
mod machine {
    pub fn sqrt_f64(x: f64) -> f64 {
        libm::sqrt(x)
    }
    pub fn sqrt_f32(x: f32) -> f32 {
        libm::sqrtf(x)
    }
}
pub(crate) use machine::{sqrt_f32, sqrt_f64};
