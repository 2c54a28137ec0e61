//! Memory that will be read soon.

/// Asks the processor for some numbers ahead of their use. It changes no result.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub fn fetch_ahead<T>(numbers: &[T]) {
    use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};

    for line in numbers.chunks(64 / size_of::<T>().max(1)) {
        // SAFETY: the address is that of a reference; the instruction, part of every x86-64 processor, would not fault at any other either.
        #[expect(unsafe_code, reason = "an instruction")]
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(line.as_ptr().cast());
        }
    }
}

/// Other processors find out for themselves.
#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
pub fn fetch_ahead<T>(_numbers: &[T]) {}
