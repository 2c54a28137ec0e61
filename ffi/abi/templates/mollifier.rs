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
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier{d}_eval{f}(
    mollifier: mollis_mollifier,
    delta: {T},
    n: usize,
    r: *const {T},
    density: *mut {T},
    density_slope: *mut {T},
    potential: *mut {T},
    gradient_factor: *mut {T},
    hessian_factor: *mut {T},
    enclosed_mass: *mut {T},
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe {
        radii::mollifier::<{T}, {d}>(
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
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier1_heaviside{f}(
    mollifier: mollis_mollifier,
    delta: {T},
    n: usize,
    x: *const {T},
    values: *mut {T},
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(heaviside(mollifier, delta, n, x, values)) }
}

/// The moment of order k of a mollifier in two dimensions: the integral of |x|^k psi_delta(x), written to *value.
/// Exactly 0 for even k above 0 and below the mollifier's order.
///
/// Refused: MOLLIS_ERR_OUT_OF_DOMAIN (k > 64), MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_DELTA, MOLLIS_ERR_ORDER, MOLLIS_ERR_EXPONENT,
/// MOLLIS_ERR_UNKNOWN_VALUE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier{d}_moment{f}(
    mollifier: mollis_mollifier,
    delta: {T},
    k: u32,
    value: *mut {T},
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(moment::<{T}, {d}>(mollifier, delta, k, value)) }
}

/// A mollifier's Newtonian field about a particle of unit mass at the origin, at n points x[n][2] of the plane: density[n],
/// potential[n], gradient[n][2], hessian[n][2][2] (symmetric, its trace the density), overwritten; null ones are not computed.
///
/// Of compact mollifiers values are within 1 ulp, but for the density at points closer to the edge of the support than rounding of
/// x can tell. Gaussians are evaluated plainly, in tens of nanoseconds (their Hessian in tens of microseconds): to a few ulp, the
/// density of its maximum, the potential in 2D of 1 + |log delta|. Without a mollifier everything is 0 at x = 0.
///
/// Refused as mollis_mollifier2_eval does; MOLLIS_ERR_NOT_FINITE for any coordinate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier{d}_field{f}(
    mollifier: mollis_mollifier,
    delta: {T},
    n: usize,
    x: *const [{T}; {d}],
    density: *mut {T},
    potential: *mut {T},
    gradient: *mut [{T}; {d}],
    hessian: *mut [[{T}; {d}]; {d}],
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe { status(field::<{T}, {d}>(mollifier, delta, n, x, density, potential, gradient, hessian)) }
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
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_mollifier{d}_richardson{f}(
    mollifier: mollis_mollifier,
    delta: {T},
    n_radii: usize,
    radii: *const {T},
    weights: *mut {T},
    n: usize,
    r: *const {T},
    density: *mut {T},
    density_slope: *mut {T},
    potential: *mut {T},
    gradient_factor: *mut {T},
    hessian_factor: *mut {T},
    enclosed_mass: *mut {T},
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe {
        status(combination::<{T}, {d}>(
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
