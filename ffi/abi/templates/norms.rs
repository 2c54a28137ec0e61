use core::ffi::c_void;

use crate::first_bad::search;
use crate::norms::{distance, dual_norm, dual_norm_size, sobolev};
use crate::status::{mollis_status, status};

/// Writes the L^p_h norm (sum |v_i|^p cell)^(1/p) of n values, cell = h^d, 1 <= p; the largest |v_i| for infinite p. The sum is
/// compensated and in double precision: a few roundings whatever n.
///
/// Refused, with `norm` as it was: MOLLIS_ERR_OUT_OF_DOMAIN (p or cell), MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED,
/// MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP. NaN gives NaN.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_norm{f}(
    n: usize,
    values: *const {T},
    cell: {T},
    p: {T},
    norm: *mut {T},
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { crate::norms::norm::<{T}>(n, values, cell, p, norm) })
}

/// Writes the L^p_h norm of the distances |a_i - b_i| of n pairs of points in two dimensions: the error of trajectories.
///
/// Refused as by `mollis_norm`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_distance_norm{d}{f}(
    n: usize,
    a: *const [{T}; {d}],
    b: *const [{T}; {d}],
    cell: {T},
    p: {T},
    norm: *mut {T},
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { distance::<{T}, {d}>(n, a, b, cell, p, norm) })
}

/// Writes the W^{1,p}_h norm of a function on a box of the lattice h Z^2: (|v|^p + sum_j |D_j v|^p)^(1/p) in L^p_h, with forward differences D_j over
/// h; for infinite p the largest of all. Outside the box the function is zero, so differences at its border count.
///
/// `values` holds points[0] * points[1] numbers, the first axis fastest; `spacing` is h; 1 <= p.
///
/// Refused, with `norm` as it was: MOLLIS_ERR_OUT_OF_DOMAIN (p, or h or h^2 out of range), MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_NULL_POINTER,
/// MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP. NaN gives NaN.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_sobolev_norm{d}{f}(
    points: *const [usize; {d}],
    spacing: {T},
    p: {T},
    values: *const {T},
    norm: *mut {T},
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { sobolev::<{T}, {d}>(points, values, (spacing, p), norm) })
}

/// Writes the bytes of workspace that `mollis_dual_norm2` needs for a box of points[0] x points[1] lattice points (one
/// array of two sizes) and this margin.
///
/// Refused: MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm{d}_workspace_bytes{f}(
    points: *const [usize; {d}],
    margin: usize,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm_size::<{T}, {d}>(points, margin, bytes) })
}

/// Writes the W^{-1,2}_h norm of a function on a box of the lattice h Z^2, in which the density of the blob method converges.
///
/// `values` holds points[0] * points[1] numbers, the first axis fastest; `spacing` is h; `margin` points of zeros on each side
/// stand for the rest of the lattice, and cut off about e^{-2 margin h} of the norm. A discrete Poisson problem by conjugate
/// gradients: about 10 sqrt(1 + 8/h^2) sweeps over box and margin.
///
/// Refused, with `norm` as it was: MOLLIS_ERR_NOT_FINITE (a value), MOLLIS_ERR_OUT_OF_DOMAIN (the spacing), MOLLIS_ERR_TOO_LARGE,
/// MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm{d}{f}(
    points: *const [usize; {d}],
    spacing: {T},
    margin: usize,
    values: *const {T},
    norm: *mut {T},
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm::<{T}, {d}>(points, (spacing, margin), values, norm, (workspace, workspace_bytes)) })
}

/// Writes the index of the first of n elements of `each` numbers (n points in D dimensions: `each` is D) that holds one that is not finite, or
/// `MOLLIS_NONE_BAD`: which element a function meant that returned `MOLLIS_ERR_NOT_FINITE` and takes no `mollis_run` to tell it.
///
/// Refused, with `first` as it was: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_first_bad{f}(
    n: usize,
    each: usize,
    values: *const {T},
    first: *mut u64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { search(n, each, values, first) })
}
