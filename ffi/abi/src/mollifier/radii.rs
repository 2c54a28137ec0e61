//! Functions of the distance r.

use mollis_core::mollifier::{Blob, Quantity};
use mollis_core::{Error, Real, Result};

use super::mollis_mollifier;
use crate::buffers::{Input, Output, disjoint};
use crate::status::{mollis_status, status};

/// Outputs in the order of [`Quantity::ALL`].
pub(super) type Outputs<T> = [*mut T; Quantity::ALL.len()];

/// Checks the buffers, makes the function, then writes each wanted quantity of each radius.
///
/// # Safety
/// The crate's contract.
pub(super) unsafe fn each_radius<T: Real, F: Fn(Quantity, T) -> T>(
    n: usize,
    r: *const T,
    outputs: Outputs<T>,
    function: impl FnOnce() -> Result<F>,
) -> Result<()> {
    let input = Input::new(r, n)?;
    let mut ranges = [None; Quantity::ALL.len()];
    for (range, &pointer) in ranges.iter_mut().zip(&outputs) {
        *range = Output::optional(pointer, n)?.map(Output::range);
    }
    disjoint(&ranges, &[input.range()])?;
    let function = function()?;
    // SAFETY: the caller promises the crate's contract.
    let r = unsafe { input.slice() };
    if !r.iter().all(|r| r.is_finite()) {
        return Err(Error::NotFinite);
    }
    for (&quantity, &pointer) in Quantity::ALL.iter().zip(&outputs) {
        let Some(buffer) = Output::optional(pointer, n)? else { continue };
        // SAFETY: as above, and the outputs overlap nothing.
        let output = unsafe { buffer.slice() };
        for (value, &r) in output.iter_mut().zip(r) {
            *value = function(quantity, r);
        }
    }
    Ok(())
}

pub(crate) unsafe fn mollifier<T: Real, const D: usize>(
    mollifier: mollis_mollifier,
    delta: T,
    n: usize,
    r: *const T,
    outputs: Outputs<T>,
) -> mollis_status {
    let function = || {
        let blob = Blob::<T, D>::new(mollifier.to_core()?, delta)?;
        Ok(move |quantity, r| blob.evaluate(quantity, r))
    };
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { each_radius(n, r, outputs, function) })
}

pub(crate) unsafe fn heaviside<T: Real>(
    mollifier: mollis_mollifier,
    delta: T,
    n: usize,
    x: *const T,
    values: *mut T,
) -> Result<()> {
    let (input, output) = (Input::new(x, n)?, Output::new(values, n)?);
    disjoint(&[Some(output.range())], &[input.range()])?;
    let blob = Blob::<T, 1>::new(mollifier.to_core()?, delta)?;
    // SAFETY: the caller promises the crate's contract.
    let x = unsafe { input.slice() };
    if !x.iter().all(|x| x.is_finite()) {
        return Err(Error::NotFinite);
    }
    // SAFETY: as above, and the output overlaps nothing.
    for (value, &x) in unsafe { output.slice() }.iter_mut().zip(x) {
        *value = blob.heaviside(x);
    }
    Ok(())
}

pub(crate) unsafe fn moment<T: Real, const D: usize>(
    mollifier: mollis_mollifier,
    delta: T,
    k: u32,
    value: *mut T,
) -> Result<()> {
    let output = Output::new(value, 1)?;
    let moment = Blob::<T, D>::new(mollifier.to_core()?, delta)?.moment(k)?;
    // SAFETY: the caller promises the crate's contract.
    for value in unsafe { output.slice() } {
        *value = moment;
    }
    Ok(())
}
