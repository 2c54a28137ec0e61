//! Made from `ffi/abi/templates/mollifier.rs` by `cargo xtask header`: do not edit.

#![allow(missing_docs, reason = "documented at the plane's")]

use crate::mollifier::combinations::combination;
use crate::mollifier::points::field;
use crate::mollifier::radii::{heaviside, moment};
use crate::mollifier::{mollis_mollifier, radii};
use crate::status::{mollis_status, status};

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
        radii::mollifier::<f64, 2>(
            mollifier,
            delta,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        )
    }
}

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
        radii::mollifier::<f32, 2>(
            mollifier,
            delta,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        )
    }
}

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
        radii::mollifier::<f64, 1>(
            mollifier,
            delta,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        )
    }
}

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
        radii::mollifier::<f32, 1>(
            mollifier,
            delta,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        )
    }
}

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
        radii::mollifier::<f64, 3>(
            mollifier,
            delta,
            n,
            r,
            [density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass],
        )
    }
}

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
        radii::mollifier::<f32, 3>(
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
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier1_heaviside(
    mollifier: mollis_mollifier,
    delta: f64,
    n: usize,
    x: *const f64,
    values: *mut f64,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(heaviside(mollifier, delta, n, x, values)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier1_heaviside_f32(
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
pub unsafe extern "C" fn mollis_mollifier2_moment(
    mollifier: mollis_mollifier,
    delta: f64,
    k: u32,
    value: *mut f64,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(moment::<f64, 2>(mollifier, delta, k, value)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier2_moment_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    k: u32,
    value: *mut f32,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(moment::<f32, 2>(mollifier, delta, k, value)) }
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier1_moment(
    mollifier: mollis_mollifier,
    delta: f64,
    k: u32,
    value: *mut f64,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(moment::<f64, 1>(mollifier, delta, k, value)) }
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier1_moment_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    k: u32,
    value: *mut f32,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(moment::<f32, 1>(mollifier, delta, k, value)) }
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier3_moment(
    mollifier: mollis_mollifier,
    delta: f64,
    k: u32,
    value: *mut f64,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(moment::<f64, 3>(mollifier, delta, k, value)) }
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier3_moment_f32(
    mollifier: mollis_mollifier,
    delta: f32,
    k: u32,
    value: *mut f32,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(moment::<f32, 3>(mollifier, delta, k, value)) }
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
pub unsafe extern "C" fn mollis_mollifier2_field(
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

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier2_field_f32(
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

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier1_field(
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

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier1_field_f32(
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

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier3_field(
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

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier3_field_f32(
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
pub unsafe extern "C" fn mollis_mollifier2_richardson(
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

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier2_richardson_f32(
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

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier1_richardson(
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

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier1_richardson_f32(
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

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier3_richardson(
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

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier3_richardson_f32(
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
