//! Made from `ffi/abi/templates/norms.rs` by `cargo xtask header`: do not edit.

#![allow(missing_docs, reason = "documented at the plane's")]

use core::ffi::c_void;

use crate::first_bad::search;
use crate::norms::{distance, dual_norm, dual_norm_size, sobolev};
use crate::status::{mollis_status, status};

/// Writes the L^p_h norm (sum |v_i|^p cell)^(1/p) of n values, cell = h^d, 1 <= p; the largest |v_i| for infinite p. The sum is
/// compensated and in double precision: a few roundings whatever n.
///
/// Refused, with `norm` as it was: MOLLIS_ERR_OUT_OF_DOMAIN (p or cell), MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED,
/// MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP. NaN gives NaN.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_norm(n: usize, values: *const f64, cell: f64, p: f64, norm: *mut f64) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { crate::norms::norm::<f64>(n, values, cell, p, norm) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_norm_f32(
    n: usize,
    values: *const f32,
    cell: f32,
    p: f32,
    norm: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { crate::norms::norm::<f32>(n, values, cell, p, norm) })
}

/// Writes the L^p_h norm of the distances |a_i - b_i| of n pairs of points in two dimensions: the error of trajectories.
///
/// Refused as by `mollis_norm`.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_distance_norm2(
    n: usize,
    a: *const [f64; 2],
    b: *const [f64; 2],
    cell: f64,
    p: f64,
    norm: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { distance::<f64, 2>(n, a, b, cell, p, norm) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_distance_norm2_f32(
    n: usize,
    a: *const [f32; 2],
    b: *const [f32; 2],
    cell: f32,
    p: f32,
    norm: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { distance::<f32, 2>(n, a, b, cell, p, norm) })
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_distance_norm1(
    n: usize,
    a: *const [f64; 1],
    b: *const [f64; 1],
    cell: f64,
    p: f64,
    norm: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { distance::<f64, 1>(n, a, b, cell, p, norm) })
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_distance_norm1_f32(
    n: usize,
    a: *const [f32; 1],
    b: *const [f32; 1],
    cell: f32,
    p: f32,
    norm: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { distance::<f32, 1>(n, a, b, cell, p, norm) })
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_distance_norm3(
    n: usize,
    a: *const [f64; 3],
    b: *const [f64; 3],
    cell: f64,
    p: f64,
    norm: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { distance::<f64, 3>(n, a, b, cell, p, norm) })
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_distance_norm3_f32(
    n: usize,
    a: *const [f32; 3],
    b: *const [f32; 3],
    cell: f32,
    p: f32,
    norm: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { distance::<f32, 3>(n, a, b, cell, p, norm) })
}

/// Writes the W^{1,p}_h norm of a function on a box of the lattice h Z^2: (|v|^p + sum_j |D_j v|^p)^(1/p) in L^p_h, with forward differences D_j over
/// h; for infinite p the largest of all. Outside the box the function is zero, so differences at its border count.
///
/// `values` holds points[0] * points[1] numbers, the first axis fastest; `spacing` is h; 1 <= p.
///
/// Refused, with `norm` as it was: MOLLIS_ERR_OUT_OF_DOMAIN (p, or h or h^2 out of range), MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_NULL_POINTER,
/// MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP. NaN gives NaN.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_sobolev_norm2(
    points: *const [usize; 2],
    spacing: f64,
    p: f64,
    values: *const f64,
    norm: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { sobolev::<f64, 2>(points, values, (spacing, p), norm) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_sobolev_norm2_f32(
    points: *const [usize; 2],
    spacing: f32,
    p: f32,
    values: *const f32,
    norm: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { sobolev::<f32, 2>(points, values, (spacing, p), norm) })
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_sobolev_norm1(
    points: *const [usize; 1],
    spacing: f64,
    p: f64,
    values: *const f64,
    norm: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { sobolev::<f64, 1>(points, values, (spacing, p), norm) })
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_sobolev_norm1_f32(
    points: *const [usize; 1],
    spacing: f32,
    p: f32,
    values: *const f32,
    norm: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { sobolev::<f32, 1>(points, values, (spacing, p), norm) })
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_sobolev_norm3(
    points: *const [usize; 3],
    spacing: f64,
    p: f64,
    values: *const f64,
    norm: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { sobolev::<f64, 3>(points, values, (spacing, p), norm) })
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_sobolev_norm3_f32(
    points: *const [usize; 3],
    spacing: f32,
    p: f32,
    values: *const f32,
    norm: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { sobolev::<f32, 3>(points, values, (spacing, p), norm) })
}

/// Writes the bytes of workspace that `mollis_dual_norm2` needs for a box of points[0] x points[1] lattice points (one
/// array of two sizes) and this margin.
///
/// Refused: MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm2_workspace_bytes(
    points: *const [usize; 2],
    margin: usize,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm_size::<f64, 2>(points, margin, bytes) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm2_workspace_bytes_f32(
    points: *const [usize; 2],
    margin: usize,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm_size::<f32, 2>(points, margin, bytes) })
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm1_workspace_bytes(
    points: *const [usize; 1],
    margin: usize,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm_size::<f64, 1>(points, margin, bytes) })
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm1_workspace_bytes_f32(
    points: *const [usize; 1],
    margin: usize,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm_size::<f32, 1>(points, margin, bytes) })
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm3_workspace_bytes(
    points: *const [usize; 3],
    margin: usize,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm_size::<f64, 3>(points, margin, bytes) })
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm3_workspace_bytes_f32(
    points: *const [usize; 3],
    margin: usize,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm_size::<f32, 3>(points, margin, bytes) })
}

/// Writes the W^{-1,2}_h norm of a function on a box of the lattice h Z^2, in which the density of the blob method converges.
///
/// `values` holds points[0] * points[1] numbers, the first axis fastest; `spacing` is h; `margin` points of zeros on each side
/// stand for the rest of the lattice, and cut off about e^{-2 margin h} of the norm. A discrete Poisson problem by conjugate
/// gradients: about 10 sqrt(1 + 8/h^2) sweeps over box and margin.
///
/// Refused, with `norm` as it was: MOLLIS_ERR_NOT_FINITE (a value), MOLLIS_ERR_OUT_OF_DOMAIN (the spacing), MOLLIS_ERR_TOO_LARGE,
/// MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm2(
    points: *const [usize; 2],
    spacing: f64,
    margin: usize,
    values: *const f64,
    norm: *mut f64,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm::<f64, 2>(points, (spacing, margin), values, norm, (workspace, workspace_bytes)) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm2_f32(
    points: *const [usize; 2],
    spacing: f32,
    margin: usize,
    values: *const f32,
    norm: *mut f32,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm::<f32, 2>(points, (spacing, margin), values, norm, (workspace, workspace_bytes)) })
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm1(
    points: *const [usize; 1],
    spacing: f64,
    margin: usize,
    values: *const f64,
    norm: *mut f64,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm::<f64, 1>(points, (spacing, margin), values, norm, (workspace, workspace_bytes)) })
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm1_f32(
    points: *const [usize; 1],
    spacing: f32,
    margin: usize,
    values: *const f32,
    norm: *mut f32,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm::<f32, 1>(points, (spacing, margin), values, norm, (workspace, workspace_bytes)) })
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm3(
    points: *const [usize; 3],
    spacing: f64,
    margin: usize,
    values: *const f64,
    norm: *mut f64,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm::<f64, 3>(points, (spacing, margin), values, norm, (workspace, workspace_bytes)) })
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm3_f32(
    points: *const [usize; 3],
    spacing: f32,
    margin: usize,
    values: *const f32,
    norm: *mut f32,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm::<f32, 3>(points, (spacing, margin), values, norm, (workspace, workspace_bytes)) })
}

/// Writes the index of the first of n elements of `each` numbers (n points in D dimensions: `each` is D) that holds one that is not finite, or
/// `MOLLIS_NONE_BAD`: which element a function meant that returned `MOLLIS_ERR_NOT_FINITE` and takes no `mollis_run` to tell it.
///
/// Refused, with `first` as it was: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_first_bad(n: usize, each: usize, values: *const f64, first: *mut u64) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { search(n, each, values, first) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_first_bad_f32(
    n: usize,
    each: usize,
    values: *const f32,
    first: *mut u64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { search(n, each, values, first) })
}
