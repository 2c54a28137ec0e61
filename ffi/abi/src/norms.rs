//! Discrete norms of grid functions and of differences of trajectories.

use core::ffi::c_void;

use mollis_core::diagnostics::{self, Lattice};
use mollis_core::memory::Plain;
use mollis_core::{Real, Result};

use crate::buffers::{Input, Output, disjoint, workspace};
use crate::diagnostics::put;
use crate::status::{mollis_status, status};

unsafe fn norm<T: Real>(n: usize, values: *const T, cell: T, p: T, norm: *mut T) -> Result<()> {
    let (values, norm) = (Input::new(values, n)?, Output::new(norm, 1)?);
    disjoint(&[Some(norm.range())], &[values.range()])?;
    // SAFETY: the caller promises the crate's contract; the output overlaps nothing.
    unsafe { put(Some(norm), diagnostics::norm(values.slice(), cell, p)?) };
    Ok(())
}

unsafe fn distance<T: Real, const D: usize>(
    n: usize,
    a: *const [T; D],
    b: *const [T; D],
    cell: T,
    p: T,
    norm: *mut T,
) -> Result<()>
where
    [T; D]: Plain,
{
    let (a, b, norm) = (Input::new(a, n)?, Input::new(b, n)?, Output::new(norm, 1)?);
    disjoint(&[Some(norm.range())], &[a.range(), b.range()])?;
    // SAFETY: the caller promises the crate's contract; the output overlaps nothing.
    unsafe { put(Some(norm), diagnostics::distance(a.slice(), b.slice(), cell, p)?) };
    Ok(())
}

unsafe fn lattice<T: Real, const D: usize>(
    points: *const [usize; D],
    spacing: T,
    margin: usize,
) -> Result<Lattice<T, D>>
where
    [usize; D]: Plain,
{
    // SAFETY: the caller promises the crate's contract.
    let points = unsafe { Input::new(points, 1)?.slice() }.first().copied().unwrap_or([0; D]);
    Ok(Lattice { points, spacing, margin })
}

unsafe fn dual_norm_size<T: Real, const D: usize>(
    points: *const [usize; D],
    margin: usize,
    bytes: *mut usize,
) -> Result<()>
where
    [usize; D]: Plain,
{
    let (given, bytes) = (Input::new(points, 1)?, Output::new(bytes, 1)?);
    disjoint(&[Some(bytes.range())], &[given.range()])?;
    // SAFETY: the caller promises the crate's contract; the output overlaps nothing.
    unsafe { put(Some(bytes), lattice::<T, D>(points, T::ONE, margin)?.workspace_bytes()?) };
    Ok(())
}

unsafe fn dual_norm<T: Real, const D: usize>(
    points: *const [usize; D],
    (spacing, margin): (T, usize),
    values: *const T,
    norm: *mut T,
    (memory, bytes): (*mut c_void, usize),
) -> Result<()>
where
    [usize; D]: Plain,
{
    let given = Input::new(points, 1)?;
    // SAFETY: the caller promises the crate's contract.
    let lattice = unsafe { lattice::<T, D>(points, spacing, margin) }?;
    let count = lattice.points.iter().try_fold(1_usize, |product, &n| product.checked_mul(n));
    let values = Input::new(values, count.ok_or(mollis_core::Error::TooLarge)?)?;
    let (norm, memory) = (Output::new(norm, 1)?, workspace(memory, bytes)?);
    disjoint(&[Some(norm.range()), Some(memory.range())], &[given.range(), values.range()])?;
    // SAFETY: the caller promises the crate's contract; the outputs overlap nothing.
    unsafe { put(Some(norm), lattice.dual_norm(values.slice(), memory.slice())?) };
    Ok(())
}

/// Writes the L^p_h norm (sum |v_i|^p cell)^(1/p) of n values, cell = h^d, 1 <= p; the largest |v_i| for infinite p. The sum is
/// compensated and in double precision: a few roundings whatever n.
///
/// Refused, with `norm` as it was: MOLLIS_ERR_OUT_OF_DOMAIN (p or cell), MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED,
/// MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP. NaN gives NaN.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_norm_eval(
    n: usize,
    values: *const f64,
    cell: f64,
    p: f64,
    norm: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { self::norm::<f64>(n, values, cell, p, norm) })
}

/// As `mollis_norm_eval`, in float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_norm_eval_f32(
    n: usize,
    values: *const f32,
    cell: f32,
    p: f32,
    norm: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { self::norm::<f32>(n, values, cell, p, norm) })
}

/// Writes the L^p_h norm of the distances |a_i - b_i| of n pairs of points in two dimensions: the error of trajectories.
///
/// Refused as by `mollis_norm_eval`.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_distance2_eval(
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

/// As `mollis_distance2_eval`, in float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_distance2_eval_f32(
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

/// As `mollis_distance2_eval`, in one dimension.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_distance1_eval(
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

/// As `mollis_distance2_eval`, in one dimension and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_distance1_eval_f32(
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

/// As `mollis_distance2_eval`, in three dimensions.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_distance3_eval(
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

/// As `mollis_distance2_eval`, in three dimensions and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_distance3_eval_f32(
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

/// Writes the bytes of workspace that `mollis_dual_norm2_eval` needs for a box of points[0] x points[1] lattice points (one
/// array of two sizes) and this margin.
///
/// Refused: MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm2_workspace_bytes(
    points: *const [usize; 2],
    margin: usize,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm_size::<f64, 2>(points, margin, bytes) })
}

/// As `mollis_dual_norm2_workspace_bytes`, in float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm2_workspace_bytes_f32(
    points: *const [usize; 2],
    margin: usize,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm_size::<f32, 2>(points, margin, bytes) })
}

/// As `mollis_dual_norm2_workspace_bytes`, in one dimension.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm1_workspace_bytes(
    points: *const [usize; 1],
    margin: usize,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm_size::<f64, 1>(points, margin, bytes) })
}

/// As `mollis_dual_norm2_workspace_bytes`, in one dimension and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm1_workspace_bytes_f32(
    points: *const [usize; 1],
    margin: usize,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm_size::<f32, 1>(points, margin, bytes) })
}

/// As `mollis_dual_norm2_workspace_bytes`, in three dimensions.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm3_workspace_bytes(
    points: *const [usize; 3],
    margin: usize,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { dual_norm_size::<f64, 3>(points, margin, bytes) })
}

/// As `mollis_dual_norm2_workspace_bytes`, in three dimensions and float.
///
/// # Safety
/// The contract of this header.
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
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm2_eval(
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

/// As `mollis_dual_norm2_eval`, in float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm2_eval_f32(
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

/// As `mollis_dual_norm2_eval`, in one dimension.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm1_eval(
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

/// As `mollis_dual_norm2_eval`, in one dimension and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm1_eval_f32(
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

/// As `mollis_dual_norm2_eval`, in three dimensions.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm3_eval(
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

/// As `mollis_dual_norm2_eval`, in three dimensions and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_dual_norm3_eval_f32(
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
