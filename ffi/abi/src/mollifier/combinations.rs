//! Richardson combinations.

use mollis_core::mollifier::{MAX_COMBINED, Richardson};
use mollis_core::{Error, Real, Result};

use super::mollis_mollifier;
use super::radii::{Outputs, each_radius};
use crate::buffers::{Input, Output, disjoint};
use crate::status::{mollis_status, status};

#[expect(clippy::too_many_arguments, reason = "one optional output each")]
unsafe fn combination<T: Real, const D: usize>(
    mollifier: mollis_mollifier,
    delta: T,
    n_radii: usize,
    radii: *const T,
    weights: *mut T,
    n: usize,
    r: *const T,
    outputs: Outputs<T>,
) -> Result<()> {
    if !(1..=MAX_COMBINED).contains(&n_radii) {
        return Err(Error::LengthMismatch);
    }
    let radii = Input::new(radii, n_radii)?;
    let weights = Output::optional(weights, n_radii)?;
    // `each_radius` checks its own buffers; here those that only this function has, against all.
    let mut inputs = [radii.range(); 2 + 6];
    if let Some(slot) = inputs.get_mut(1) {
        *slot = Input::new(r, n)?.range();
    }
    let mut ranges = [None; 6];
    for (range, pointer) in ranges.iter_mut().zip(outputs) {
        *range = Output::optional(pointer, n)?.map(Output::range);
    }
    for (input, range) in inputs.iter_mut().skip(2).zip(ranges.iter().flatten()) {
        *input = *range;
    }
    disjoint(&[weights.map(Output::range)], &inputs)?;
    disjoint(&ranges, &[radii.range()])?;
    // SAFETY: the caller promises the crate's contract.
    let combination = Richardson::<T, D>::new(mollifier.to_core()?, delta, unsafe { radii.slice() })?;
    // SAFETY: as above.
    unsafe { each_radius(n, r, outputs, || Ok(|quantity, r| combination.evaluate(quantity, r)))? };
    if let Some(weights) = weights {
        // SAFETY: as above, and the weights overlap nothing.
        for (slot, weight) in unsafe { weights.slice() }.iter_mut().zip(combination.weights()) {
            *slot = weight;
        }
    }
    Ok(())
}

/// A Richardson combination in two dimensions (Anderson (8) to (10)): the sum over j of weight[j] B_gamma, gamma = radii[j], of one
/// mollifier at lengths radii[j] * delta, 1 to 4 different radii in (0, 1]. Of order p + 2 (n_radii - 1) for a mollifier of order p.
///
/// weights[n_radii] is written if not null; the functions of n distances r[n] are those of mollis_mollifier2_eval.
///
/// Errors are below 1 ulp where the parts do not cancel, for lengths radii[j] * delta as they are rounded to the scalar. (The rounding of
/// that product moves each part by up to half an ulp of its length; it is exact for powers of two.)
///
/// Refused as there; also MOLLIS_ERR_LENGTH_MISMATCH (no radius or more than 4), MOLLIS_ERR_OUT_OF_DOMAIN (a radius outside (0, 1] or
/// two equal ones), MOLLIS_ERR_UNSUPPORTED (no mollifier).
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_richardson2_eval(
    mollifier: mollis_mollifier,
    delta: f64,
    n_radii: usize,
    radii: *const f64,
    weights: *mut f64,
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
        status(combination::<f64, 2>(
            mollifier,
            delta,
            n_radii,
            radii,
            weights,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        ))
    }
}

/// As mollis_richardson2_eval, in single precision.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_richardson2_eval_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    n_radii: usize,
    radii: *const f32,
    weights: *mut f32,
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
        status(combination::<f32, 2>(
            mollifier,
            delta,
            n_radii,
            radii,
            weights,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        ))
    }
}

/// As mollis_richardson2_eval, in one dimension.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_richardson1_eval(
    mollifier: mollis_mollifier,
    delta: f64,
    n_radii: usize,
    radii: *const f64,
    weights: *mut f64,
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
        status(combination::<f64, 1>(
            mollifier,
            delta,
            n_radii,
            radii,
            weights,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        ))
    }
}

/// As mollis_richardson2_eval, in one dimension, single precision.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_richardson1_eval_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    n_radii: usize,
    radii: *const f32,
    weights: *mut f32,
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
        status(combination::<f32, 1>(
            mollifier,
            delta,
            n_radii,
            radii,
            weights,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        ))
    }
}

/// As mollis_richardson2_eval, in three dimensions.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_richardson3_eval(
    mollifier: mollis_mollifier,
    delta: f64,
    n_radii: usize,
    radii: *const f64,
    weights: *mut f64,
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
        status(combination::<f64, 3>(
            mollifier,
            delta,
            n_radii,
            radii,
            weights,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        ))
    }
}

/// As mollis_richardson2_eval, in three dimensions, single precision.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_richardson3_eval_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    n_radii: usize,
    radii: *const f32,
    weights: *mut f32,
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
        status(combination::<f32, 3>(
            mollifier,
            delta,
            n_radii,
            radii,
            weights,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        ))
    }
}
