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

unsafe fn mollifier<T: Real, const D: usize>(
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

unsafe fn heaviside<T: Real>(
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

unsafe fn moment<T: Real, const D: usize>(mollifier: mollis_mollifier, delta: T, k: u32, value: *mut T) -> Result<()> {
    let output = Output::new(value, 1)?;
    let moment = Blob::<T, D>::new(mollifier.to_core()?, delta)?.moment(k)?;
    // SAFETY: the caller promises the crate's contract.
    for value in unsafe { output.slice() } {
        *value = moment;
    }
    Ok(())
}

/// A mollifier and its Newtonian field in two dimensions, as functions of n distances r[n] (their magnitudes).
///
/// With psi_delta(x) = delta^-2 psi(x/delta) and phi = K * psi_delta, K = log|x|/(2 pi), writes density = psi_delta(r), density_slope
/// = psi_delta'(r)/r, potential = phi(r), gradient_factor g = phi'(r)/r (grad phi = g x), hessian_factor h = g'(r)/r
/// (Hess phi = g I + h x x^T) and enclosed_mass, the integral of psi_delta over |x| < r: n values each, overwritten.
/// A null output is not wanted and not computed. Without a mollifier all are 0 at r = 0, the density everywhere.
///
/// Values are within 1 ulp, the density of orders above 2 (it has zeros) too; they overflow and underflow only where the
/// true value does. Half a microsecond each (compact; the potential in 2D 2), 5 to 50 (Gaussian): not for sums over particles.
///
/// Refused, with every output as it was: MOLLIS_ERR_DELTA, MOLLIS_ERR_ORDER, MOLLIS_ERR_EXPONENT, MOLLIS_ERR_UNKNOWN_VALUE,
/// MOLLIS_ERR_NOT_FINITE (some r), MOLLIS_ERR_NULL_POINTER (r, with n > 0), MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE,
/// MOLLIS_ERR_OVERLAP.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier2_eval(
    mollifier: mollis_mollifier,
    delta: f64,
    n: usize,
    r: *const f64,
    density: *mut f64,
    density_slope: *mut f64,
    potential: *mut f64,
    gradient_factor: *mut f64,
    hessian_factor: *mut f64,
    enclosed_mass: *mut f64,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe {
        self::mollifier::<f64, 2>(
            mollifier,
            delta,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        )
    }
}

/// As mollis_mollifier2_eval, in single precision.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier2_eval_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    n: usize,
    r: *const f32,
    density: *mut f32,
    density_slope: *mut f32,
    potential: *mut f32,
    gradient_factor: *mut f32,
    hessian_factor: *mut f32,
    enclosed_mass: *mut f32,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe {
        self::mollifier::<f32, 2>(
            mollifier,
            delta,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        )
    }
}

/// As mollis_mollifier2_eval, in one dimension: K = |x|/2.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier1_eval(
    mollifier: mollis_mollifier,
    delta: f64,
    n: usize,
    r: *const f64,
    density: *mut f64,
    density_slope: *mut f64,
    potential: *mut f64,
    gradient_factor: *mut f64,
    hessian_factor: *mut f64,
    enclosed_mass: *mut f64,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe {
        self::mollifier::<f64, 1>(
            mollifier,
            delta,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        )
    }
}

/// As mollis_mollifier2_eval, in one dimension, single precision: K = |x|/2.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier1_eval_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    n: usize,
    r: *const f32,
    density: *mut f32,
    density_slope: *mut f32,
    potential: *mut f32,
    gradient_factor: *mut f32,
    hessian_factor: *mut f32,
    enclosed_mass: *mut f32,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe {
        self::mollifier::<f32, 1>(
            mollifier,
            delta,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        )
    }
}

/// As mollis_mollifier2_eval, in three dimensions: K = -1/(4 pi |x|).
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier3_eval(
    mollifier: mollis_mollifier,
    delta: f64,
    n: usize,
    r: *const f64,
    density: *mut f64,
    density_slope: *mut f64,
    potential: *mut f64,
    gradient_factor: *mut f64,
    hessian_factor: *mut f64,
    enclosed_mass: *mut f64,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe {
        self::mollifier::<f64, 3>(
            mollifier,
            delta,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        )
    }
}

/// As mollis_mollifier2_eval, in three dimensions, single precision: K = -1/(4 pi |x|).
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier3_eval_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    n: usize,
    r: *const f32,
    density: *mut f32,
    density_slope: *mut f32,
    potential: *mut f32,
    gradient_factor: *mut f32,
    hessian_factor: *mut f32,
    enclosed_mass: *mut f32,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe {
        self::mollifier::<f32, 3>(
            mollifier,
            delta,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        )
    }
}

/// The smooth Heaviside function of a mollifier in one dimension at n places x[n]: the integral of psi_delta from -infinity
/// to x, written to values[n]. 0 left and 1 right of a compact support; without a mollifier the step, 1/2 at 0.
///
/// Refused as mollis_mollifier1_eval does; values must not be null for n > 0.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_heaviside1_eval(
    mollifier: mollis_mollifier,
    delta: f64,
    n: usize,
    x: *const f64,
    values: *mut f64,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(heaviside(mollifier, delta, n, x, values)) }
}

/// As mollis_heaviside1_eval, in single precision.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_heaviside1_eval_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    n: usize,
    x: *const f32,
    values: *mut f32,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(heaviside(mollifier, delta, n, x, values)) }
}

/// The moment of order k of a mollifier in two dimensions: the integral of |x|^k psi_delta(x), written to *value.
/// Exactly 0 for even k above 0 and below the mollifier's order.
///
/// Refused: MOLLIS_ERR_OUT_OF_DOMAIN (k > 64), MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_DELTA, MOLLIS_ERR_ORDER, MOLLIS_ERR_EXPONENT,
/// MOLLIS_ERR_UNKNOWN_VALUE.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_moment2_eval(
    mollifier: mollis_mollifier,
    delta: f64,
    k: u32,
    value: *mut f64,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(moment::<f64, 2>(mollifier, delta, k, value)) }
}

/// As mollis_moment2_eval, in single precision.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_moment2_eval_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    k: u32,
    value: *mut f32,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(moment::<f32, 2>(mollifier, delta, k, value)) }
}

/// As mollis_moment2_eval, in one dimension.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_moment1_eval(
    mollifier: mollis_mollifier,
    delta: f64,
    k: u32,
    value: *mut f64,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(moment::<f64, 1>(mollifier, delta, k, value)) }
}

/// As mollis_moment2_eval, in one dimension, single precision.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_moment1_eval_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    k: u32,
    value: *mut f32,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(moment::<f32, 1>(mollifier, delta, k, value)) }
}

/// As mollis_moment2_eval, in three dimensions.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_moment3_eval(
    mollifier: mollis_mollifier,
    delta: f64,
    k: u32,
    value: *mut f64,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(moment::<f64, 3>(mollifier, delta, k, value)) }
}

/// As mollis_moment2_eval, in three dimensions, single precision.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_moment3_eval_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    k: u32,
    value: *mut f32,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(moment::<f32, 3>(mollifier, delta, k, value)) }
}
