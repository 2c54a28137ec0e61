//! Fields at points.

use mollis_core::memory::Plain;
use mollis_core::mollifier::Blob;
use mollis_core::{Error, Real, Result};

use super::mollis_mollifier;
use crate::buffers::{Input, Output, disjoint};
use crate::status::{mollis_status, status};

/// Writes a wanted function of each point.
///
/// # Safety
/// The crate's contract, and the output overlaps nothing.
unsafe fn write<P, R: Plain>(output: Option<Output<R>>, points: &[P], function: impl Fn(&P) -> R) {
    let Some(output) = output else { return };
    // SAFETY: the caller's promise.
    for (value, point) in unsafe { output.slice() }.iter_mut().zip(points) {
        *value = function(point);
    }
}

#[expect(clippy::too_many_arguments, reason = "one optional output each")]
unsafe fn field<T: Real, const D: usize>(
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

/// A mollifier's Newtonian field about a particle of unit mass at the origin, at n points x[n][2] of the plane: density[n],
/// potential[n], gradient[n][2], hessian[n][2][2] (symmetric, its trace the density), overwritten; null ones are not computed.
///
/// Of compact mollifiers values are within 1 ulp, but for the density at points closer to the edge of the support than rounding of
/// x can tell. Gaussians are evaluated plainly, in tens of nanoseconds (their Hessian in tens of microseconds): to a few ulp, the
/// density of its maximum, the potential in 2D of 1 + |log delta|. Without a mollifier everything is 0 at x = 0.
///
/// Refused as mollis_mollifier2_eval does; MOLLIS_ERR_NOT_FINITE for any coordinate.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier_field2_eval(
    mollifier: mollis_mollifier,
    delta: f64,
    n: usize,
    x: *const [f64; 2],
    density: *mut f64,
    potential: *mut f64,
    gradient: *mut [f64; 2],
    hessian: *mut [[f64; 2]; 2],
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(field::<f64, 2>(mollifier, delta, n, x, density, potential, gradient, hessian)) }
}

/// As mollis_mollifier_field2_eval, in single precision: x[n][2].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier_field2_eval_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    n: usize,
    x: *const [f32; 2],
    density: *mut f32,
    potential: *mut f32,
    gradient: *mut [f32; 2],
    hessian: *mut [[f32; 2]; 2],
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(field::<f32, 2>(mollifier, delta, n, x, density, potential, gradient, hessian)) }
}

/// As mollis_mollifier_field2_eval, in one dimension: x[n][1].
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier_field1_eval(
    mollifier: mollis_mollifier,
    delta: f64,
    n: usize,
    x: *const [f64; 1],
    density: *mut f64,
    potential: *mut f64,
    gradient: *mut [f64; 1],
    hessian: *mut [[f64; 1]; 1],
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(field::<f64, 1>(mollifier, delta, n, x, density, potential, gradient, hessian)) }
}

/// As mollis_mollifier_field2_eval, in one dimension, single precision: x[n][1].
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier_field1_eval_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    n: usize,
    x: *const [f32; 1],
    density: *mut f32,
    potential: *mut f32,
    gradient: *mut [f32; 1],
    hessian: *mut [[f32; 1]; 1],
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(field::<f32, 1>(mollifier, delta, n, x, density, potential, gradient, hessian)) }
}

/// As mollis_mollifier_field2_eval, in three dimensions: x[n][3].
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier_field3_eval(
    mollifier: mollis_mollifier,
    delta: f64,
    n: usize,
    x: *const [f64; 3],
    density: *mut f64,
    potential: *mut f64,
    gradient: *mut [f64; 3],
    hessian: *mut [[f64; 3]; 3],
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(field::<f64, 3>(mollifier, delta, n, x, density, potential, gradient, hessian)) }
}

/// As mollis_mollifier_field2_eval, in three dimensions, single precision: x[n][3].
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier_field3_eval_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    n: usize,
    x: *const [f32; 3],
    density: *mut f32,
    potential: *mut f32,
    gradient: *mut [f32; 3],
    hessian: *mut [[f32; 3]; 3],
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(field::<f32, 3>(mollifier, delta, n, x, density, potential, gradient, hessian)) }
}
