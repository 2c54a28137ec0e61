//! Diagnostics of the blob method: what a run conserves, how long a step may be, how well its blobs overlap.

use core::ffi::c_void;

use mollis_core::diagnostics::{self, Moments};
use mollis_core::memory::Plain;
use mollis_core::{Real, Result};

use crate::buffers::{Input, Output, disjoint};
use crate::kernel;

/// Writes one value where it is wanted.
///
/// # Safety
/// The crate's contract.
pub(crate) unsafe fn put<V: Plain>(to: Option<Output<V>>, value: V) {
    // SAFETY: the caller promises the crate's contract.
    for slot in to.map(|to| unsafe { to.slice() }).unwrap_or_default() {
        *slot = value;
    }
}

pub(crate) unsafe fn moments<T: Real, const D: usize>(
    n: usize,
    positions: *const [T; D],
    masses: *const T,
    [mass, absolute_mass, second]: [*mut T; 3],
    centre: *mut [T; D],
) -> Result<()>
where
    [T; D]: Plain,
{
    let (positions, masses) = (Input::new(positions, n)?, Input::new(masses, n)?);
    let (mass, absolute_mass) = (Output::optional(mass, 1)?, Output::optional(absolute_mass, 1)?);
    let (second, centre) = (Output::optional(second, 1)?, Output::optional(centre, 1)?);
    let outputs = [mass, absolute_mass, second].map(|o| o.map(Output::range));
    disjoint(&[outputs[0], outputs[1], outputs[2], centre.map(Output::range)], &[positions.range(), masses.range()])?;
    // SAFETY: the caller promises the crate's contract; the outputs overlap nothing.
    unsafe {
        let Moments { mass: m, absolute_mass: a, centre: c, second: s } =
            diagnostics::moments(positions.slice(), masses.slice())?;
        put(mass, m);
        put(absolute_mass, a);
        put(centre, c);
        put(second, s);
    }
    Ok(())
}

pub(crate) unsafe fn stable_step<T: Real, const D: usize>(
    (kernel, bytes): (*const c_void, usize),
    n: usize,
    positions: *const [T; D],
    masses: *const T,
    step: *mut T,
) -> Result<()>
where
    [T; D]: Plain,
{
    let block = Input::new(kernel.cast::<u8>(), bytes)?;
    let (positions, masses, step) = (Input::new(positions, n)?, Input::new(masses, n)?, Output::new(step, 1)?);
    disjoint(&[Some(step.range())], &[block.range(), positions.range(), masses.range()])?;
    // SAFETY: the caller promises the crate's contract; the output overlaps nothing.
    unsafe {
        let kernel = kernel::open::<T, D>(kernel, bytes)?;
        put(Some(step), diagnostics::stable_step(&kernel, positions.slice(), masses.slice())?);
    }
    Ok(())
}

pub(crate) unsafe fn stable_step_anywhere<T: Real, const D: usize>(
    (kernel, bytes): (*const c_void, usize),
    absolute_mass: T,
    diameter: T,
    step: *mut T,
) -> Result<()> {
    let (block, step) = (Input::new(kernel.cast::<u8>(), bytes)?, Output::new(step, 1)?);
    disjoint(&[Some(step.range())], &[block.range()])?;
    // SAFETY: the caller promises the crate's contract; the output overlaps nothing.
    unsafe {
        let kernel = kernel::open::<T, D>(kernel, bytes)?;
        put(Some(step), diagnostics::stable_step_anywhere(&kernel, absolute_mass, diameter)?);
    }
    Ok(())
}

pub(crate) unsafe fn overlap<T: Real, const D: usize>(
    n: usize,
    delta: T,
    masses: *const T,
    densities: *const T,
    smallest: *mut T,
) -> Result<()> {
    let (masses, densities) = (Input::new(masses, n)?, Input::new(densities, n)?);
    let smallest = Output::new(smallest, 1)?;
    disjoint(&[Some(smallest.range())], &[masses.range(), densities.range()])?;
    // SAFETY: the caller promises the crate's contract; the output overlaps nothing.
    unsafe {
        let found = diagnostics::smallest_overlap::<T, D>(delta, masses.slice(), densities.slice())?;
        put(Some(smallest), found.unwrap_or(T::NAN));
    }
    Ok(())
}
