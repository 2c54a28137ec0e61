//! Fields at points.

use mollis_core::memory::Plain;
use mollis_core::mollifier::Blob;
use mollis_core::{Error, Real, Result};

use super::mollis_mollifier;
use crate::buffers::{Input, Output, disjoint};

/// Writes a wanted function of each point.
///
/// # Safety
/// The crate's contract, and the output overlaps nothing.
pub(crate) unsafe fn write<P, R: Plain>(output: Option<Output<R>>, points: &[P], function: impl Fn(&P) -> R) {
    let Some(output) = output else { return };
    // SAFETY: the caller's promise.
    for (value, point) in unsafe { output.slice() }.iter_mut().zip(points) {
        *value = function(point);
    }
}

#[expect(clippy::too_many_arguments, reason = "one optional output each")]
pub(crate) unsafe fn field<T: Real, const D: usize>(
    mollifier: mollis_mollifier,
    delta: T,
    n: usize,
    x: *const [T; D],
    density: *mut T,
    potential: *mut T,
    gradient: *mut [T; D],
    hessian: *mut [[T; D]; D],
) -> Result<()> {
    let input = Input::new(x, n)?;
    let density = Output::optional(density, n)?;
    let potential = Output::optional(potential, n)?;
    let gradient = Output::optional(gradient, n)?;
    let hessian = Output::optional(hessian, n)?;
    let ranges = [
        density.map(Output::range),
        potential.map(Output::range),
        gradient.map(Output::range),
        hessian.map(Output::range),
    ];
    disjoint(&ranges, &[input.range()])?;
    let blob = Blob::<T, D>::new(mollifier.to_core()?, delta)?;
    // SAFETY: the caller promises the crate's contract.
    let points = unsafe { input.slice() };
    if !points.iter().flatten().all(|c| c.is_finite()) {
        return Err(Error::NotFinite);
    }
    // SAFETY: as above; `disjoint` has passed.
    unsafe {
        write(density, points, |x| blob.density_at(x));
        write(potential, points, |x| blob.potential_at(x));
        write(gradient, points, |x| blob.gradient_at(x));
        write(hessian, points, |x| blob.hessian_at(x));
    }
    Ok(())
}
