//! Made from `ffi/abi/templates/kernel.rs` by `cargo xtask header`: do not edit.

#![allow(missing_docs, reason = "documented at the plane's")]

use core::ffi::c_void;

use crate::kernel::{eval, mollis_kernel_term, mollis_radial_kernel, prepare, size};
use crate::mollifier::mollis_mollifier;
use crate::status::{mollis_status, status};

/// Writes the exact size in bytes of a prepared kernel in two dimensions: the sum of n_terms terms (at most
/// MOLLIS_KERNEL_MAX_TERMS) and, if not null, a host's own kernel, under a mollifier. It does not depend on delta.
///
/// Under MOLLIS_MOLLIFIER_RICHARDSON a term that is not Newtonian counts for as many as there are radii, and a host's own kernel is refused (MOLLIS_ERR_UNSUPPORTED).
///
/// Refused: MOLLIS_ERR_KERNEL_TERMS (none or too many), MOLLIS_ERR_KERNEL_PARAMETER, MOLLIS_ERR_NOT_FINITE,
/// MOLLIS_ERR_UNKNOWN_VALUE, MOLLIS_ERR_ORDER, MOLLIS_ERR_EXPONENT, MOLLIS_ERR_DIMENSION (Vatistas' mollifier but in the plane),
/// MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel2_bytes(
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { size::<f64, 2>(terms, n_terms, own, mollifier, bytes) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel2_bytes_f32(
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { size::<f32, 2>(terms, n_terms, own, mollifier, bytes) })
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel1_bytes(
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { size::<f64, 1>(terms, n_terms, own, mollifier, bytes) })
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel1_bytes_f32(
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { size::<f32, 1>(terms, n_terms, own, mollifier, bytes) })
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel3_bytes(
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { size::<f64, 3>(terms, n_terms, own, mollifier, bytes) })
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel3_bytes_f32(
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { size::<f32, 3>(terms, n_terms, own, mollifier, bytes) })
}

/// Prepares the sum of n_terms terms and, if not null, a host's own kernel, mollified over the length delta, in two dimensions.
///
/// `kernel` holds as many `bytes` as the size query asked, at a multiple of 8 (sums are a little faster at a multiple of 64); it is overwritten. The prepared block holds no
/// pointers: it may be copied, moved, saved, and read by several threads at a time. Closed forms take microseconds, fits
/// milliseconds to tens of them. delta is not looked at without a mollifier.
///
/// Refused: as by the size query, and MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_DELTA, MOLLIS_ERR_UNSUPPORTED (delta is many times
/// a length l or 1/k: about 600 times, 13 to 26 under a Gaussian mollifier; or exponent M = 1 with a power 0 < p + d - 1 < 0.08, whose
/// Laplacian is all but infinite at delta; or a mollified power above about 20, whose fits do not converge), MOLLIS_ERR_KERNEL_REACH, MOLLIS_ERR_KERNEL_KNOTS, MOLLIS_ERR_KERNEL_FIT (the own kernel),
/// MOLLIS_ERR_OUT_OF_DOMAIN (its `least` or tolerance; or a coefficient leaves the scalar's range, in
/// single precision at some 90 lengths, 4.7 to 13 under a Gaussian mollifier; or K'/r of a kernel that isn't Newtonian leaves double precision at
/// distances of about delta, without a mollifier of about its length), MOLLIS_ERR_NOT_FINITE (the own kernel returned such a value), or the status
/// that the own kernel returned. After an error the block is not prepared, unless it was before and the size query or MOLLIS_ERR_DELTA refused.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel2_prepare(
    kernel: *mut c_void,
    bytes: usize,
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    delta: f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    unsafe { prepare::<f64, 2>(kernel, bytes, terms, n_terms, own, mollifier, delta) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel2_prepare_f32(
    kernel: *mut c_void,
    bytes: usize,
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    delta: f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    unsafe { prepare::<f32, 2>(kernel, bytes, terms, n_terms, own, mollifier, delta) }
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel1_prepare(
    kernel: *mut c_void,
    bytes: usize,
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    delta: f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    unsafe { prepare::<f64, 1>(kernel, bytes, terms, n_terms, own, mollifier, delta) }
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel1_prepare_f32(
    kernel: *mut c_void,
    bytes: usize,
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    delta: f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    unsafe { prepare::<f32, 1>(kernel, bytes, terms, n_terms, own, mollifier, delta) }
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel3_prepare(
    kernel: *mut c_void,
    bytes: usize,
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    delta: f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    unsafe { prepare::<f64, 3>(kernel, bytes, terms, n_terms, own, mollifier, delta) }
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel3_prepare_f32(
    kernel: *mut c_void,
    bytes: usize,
    terms: *const mollis_kernel_term,
    n_terms: usize,
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    delta: f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    unsafe { prepare::<f32, 3>(kernel, bytes, terms, n_terms, own, mollifier, delta) }
}

/// Writes K_delta(r), K_delta'(r)/r and the Laplacian of K_delta at n distances (their magnitudes), of a kernel prepared in
/// two dimensions. Null outputs are not wanted; the others are overwritten. Without a mollifier all are 0 at r = 0.
///
/// Either precision computes in double and rounds once. Errors of a term are below 8 ulp of |value| for closed forms (powers 2, 4, 6, ...;
/// in one and three dimensions and without a Gaussian mollifier 1, 3, 5, ... too), and else below 1e-13 of the larger of |value| and the term's
/// scale at delta: the magnitude that it has there without a mollifier (for a logarithm at least 1; for the Laplacian at least that of the
/// gradient factor). Where delta is more than 5 times a length l or 1/k, the scale is |K| * |psi_delta| at r, if that is larger. (Beyond some 100 lengths, and beyond power 12 under a
/// Gaussian mollifier, errors are up to 2e-12.) Results are
/// infinite or zero only where the true ones leave the range; K_delta'(r)/r may, where the gradient does not.
/// From 10 (closed forms) to some hundred nanoseconds a term and distance.
///
/// Refused, with every output as it was: MOLLIS_ERR_NOT_PREPARED, MOLLIS_ERR_WRONG_VERSION, MOLLIS_ERR_WRONG_SCALAR,
/// MOLLIS_ERR_WRONG_BYTE_ORDER, MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_NOT_FINITE (some r), MOLLIS_ERR_NULL_POINTER,
/// MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel2_eval(
    kernel: *const c_void,
    bytes: usize,
    n: usize,
    r: *const f64,
    value: *mut f64,
    gradient_factor: *mut f64,
    laplacian: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { eval::<f64, 2>(kernel, bytes, n, r, [value, gradient_factor, laplacian]) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel2_eval_f32(
    kernel: *const c_void,
    bytes: usize,
    n: usize,
    r: *const f32,
    value: *mut f32,
    gradient_factor: *mut f32,
    laplacian: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { eval::<f32, 2>(kernel, bytes, n, r, [value, gradient_factor, laplacian]) })
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel1_eval(
    kernel: *const c_void,
    bytes: usize,
    n: usize,
    r: *const f64,
    value: *mut f64,
    gradient_factor: *mut f64,
    laplacian: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { eval::<f64, 1>(kernel, bytes, n, r, [value, gradient_factor, laplacian]) })
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel1_eval_f32(
    kernel: *const c_void,
    bytes: usize,
    n: usize,
    r: *const f32,
    value: *mut f32,
    gradient_factor: *mut f32,
    laplacian: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { eval::<f32, 1>(kernel, bytes, n, r, [value, gradient_factor, laplacian]) })
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel3_eval(
    kernel: *const c_void,
    bytes: usize,
    n: usize,
    r: *const f64,
    value: *mut f64,
    gradient_factor: *mut f64,
    laplacian: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { eval::<f64, 3>(kernel, bytes, n, r, [value, gradient_factor, laplacian]) })
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_kernel3_eval_f32(
    kernel: *const c_void,
    bytes: usize,
    n: usize,
    r: *const f32,
    value: *mut f32,
    gradient_factor: *mut f32,
    laplacian: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { eval::<f32, 3>(kernel, bytes, n, r, [value, gradient_factor, laplacian]) })
}
