//! Discrete norms of grid functions and of differences of trajectories.

use core::ffi::c_void;

use mollis_core::diagnostics::{self, Lattice};
use mollis_core::memory::Plain;
use mollis_core::{Error, Real, Result};

use crate::buffers::{Input, Output, aligned, disjoint, with_slack};
use crate::diagnostics::put;

pub(crate) unsafe fn norm<T: Real>(n: usize, values: *const T, cell: T, p: T, norm: *mut T) -> Result<()> {
    let (values, norm) = (Input::new(values, n)?, Output::new(norm, 1)?);
    disjoint(&[Some(norm.range())], &[values.range()])?;
    // SAFETY: the caller promises the crate's contract; the output overlaps nothing.
    unsafe { put(Some(norm), diagnostics::norm(values.slice(), cell, p)?) };
    Ok(())
}

pub(crate) unsafe fn distance<T: Real, const D: usize>(
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

pub(crate) unsafe fn sobolev<T: Real, const D: usize>(
    points: *const [usize; D],
    values: *const T,
    (spacing, p): (T, T),
    norm: *mut T,
) -> Result<()>
where
    [usize; D]: Plain,
{
    let given = Input::new(points, 1)?;
    // SAFETY: the caller promises the crate's contract.
    let points = unsafe { given.slice() }.first().copied().unwrap_or([0; D]);
    let count = points.iter().try_fold(1_usize, |product, &n| product.checked_mul(n)).ok_or(Error::TooLarge)?;
    let (values, norm) = (Input::new(values, count)?, Output::new(norm, 1)?);
    disjoint(&[Some(norm.range())], &[given.range(), values.range()])?;
    // SAFETY: the caller promises the crate's contract; the output overlaps nothing.
    unsafe { put(Some(norm), diagnostics::sobolev(&points, values.slice(), spacing, p)?) };
    Ok(())
}

pub(crate) unsafe fn lattice<T: Real, const D: usize>(
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

pub(crate) unsafe fn dual_norm_size<T: Real, const D: usize>(
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
    unsafe { put(Some(bytes), with_slack(lattice::<T, D>(points, T::ONE, margin)?.workspace_bytes()?)?) };
    Ok(())
}

pub(crate) unsafe fn dual_norm<T: Real, const D: usize>(
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
    let values = Input::new(values, count.ok_or(Error::TooLarge)?)?;
    let (norm, memory) = (Output::new(norm, 1)?, Output::new(memory.cast::<u8>(), bytes)?);
    disjoint(&[Some(norm.range()), Some(memory.range())], &[given.range(), values.range()])?;
    if bytes < with_slack(lattice.workspace_bytes()?)? {
        return Err(Error::WorkspaceTooSmall);
    }
    // SAFETY: the caller promises the crate's contract; the outputs overlap nothing.
    unsafe { put(Some(norm), lattice.dual_norm(values.slice(), aligned(memory.slice()))?) };
    Ok(())
}
