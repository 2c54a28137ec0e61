//! Made from `ffi/abi/templates/random.rs` by `cargo xtask header`: do not edit.

#![allow(missing_docs, reason = "documented at the plane's")]

use crate::random::{normals, philox_normals};
use crate::status::{mollis_status, status};

/// Overwrites normals[i] with two independent standard normal numbers for the particle labels[i], i < n: what mollis_normals
/// makes of words 0 and 1 of mollis_philox_words, many particles at a time. The bits are the same on every machine.
///
/// Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_philox_normals(
    seed: u64,
    n: usize,
    labels: *const u64,
    step: u32,
    substep: u32,
    normals: *mut [f64; 2],
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { philox_normals(seed, n, labels, step, substep, normals) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_philox_normals_f32(
    seed: u64,
    n: usize,
    labels: *const u64,
    step: u32,
    substep: u32,
    normals: *mut [f32; 2],
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { philox_normals(seed, n, labels, step, substep, normals) })
}

/// Overwrites out[0 .. n] with independent standard normal numbers from uniform 64-bit words (Box & Muller 1958). `words` holds n
/// words, n + 1 if n is odd. The bits are the same on every machine; |out| <= 8.58.
///
/// Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_normals(n: usize, words: *const u64, out: *mut f64) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { normals(n, words, out) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_normals_f32(n: usize, words: *const u64, out: *mut f32) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { normals(n, words, out) })
}
