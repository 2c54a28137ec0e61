use core::ffi::c_void;

use crate::diagnostics::{moments, overlap, stable_step, stable_step_anywhere};
use crate::status::{mollis_status, status};

/// Writes total mass, sum of |m|, centre of mass (one point; 0 where the total mass is 0) and second moment about it,
/// sum m |x - centre|^2, of n particles in two dimensions.
///
/// `positions` [n][2], `masses` [n], of any sign. Null outputs are not wanted; the others are overwritten. Compensated sums in double
/// precision: a few roundings whatever n. A result is infinite only where the true one is beyond the range. Values that are not finite give results
/// that are not.
///
/// Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_moments{d}{f}(
    n: usize,
    positions: *const [{T}; {d}],
    masses: *const {T},
    mass: *mut {T},
    absolute_mass: *mut {T},
    centre: *mut [{T}; {d}],
    second: *mut {T},
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { moments::<{T}, {d}>(n, positions, masses, [mass, absolute_mass, second], centre) })
}

/// Writes a time step with which the classical Runge-Kutta method is stable at this state of n particles in two dimensions: 2.785
/// over a bound of the Jacobian's spectral radius; infinity where nothing moves. Ask again when particles have moved by a
/// good part of delta. Cost: n (n - 1) kernel evaluations. With `combination` (a, b) of mollis_blob_options divide it by 1.07 sqrt(a^2 + b^2): then no mode grows that does not
/// grow in the exact solution, as those of vortices do where they strain each other.
///
/// Without a mollifier a pair at one place has such a step only if each term of the kernel is a power with p >= 2.
///
/// Refused, with `step` as it was: MOLLIS_ERR_NOT_FINITE (a position, a mass, or the bound itself; a pair at one place, or whose distance,
/// or the kernel's second derivatives at it, are beyond the scalar's range, however small the masses), the codes of an unprepared kernel (see `mollis_kernel2_eval`), MOLLIS_ERR_NULL_POINTER,
/// MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_stable_step{d}{f}(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    positions: *const [{T}; {d}],
    masses: *const {T},
    step: *mut {T},
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { stable_step::<{T}, {d}>((kernel, kernel_bytes), n, positions, masses, step) })
}

/// Writes a time step with which the Runge-Kutta method is stable at every state of this total |mass| in which no two
/// particles are farther apart than `diameter`, in two dimensions: shorter than `mollis_stable_step2`'s, but good for a whole run. With
/// `combination` (a, b) divide it by 1.07 sqrt(a^2 + b^2) too.
///
/// Refused, with `step` as it was: MOLLIS_ERR_NOT_FINITE (an argument, or no such step: a kernel without a mollifier, unless each of its
/// terms is a power with p >= 2; a host's own kernel is not known to be one; or the kernel's second derivatives leave the scalar's range within
/// `diameter`, however small the mass),
/// MOLLIS_ERR_OUT_OF_DOMAIN (a negative argument), the codes of an unprepared kernel, MOLLIS_ERR_NULL_POINTER,
/// MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_stable_step{d}_anywhere{f}(
    kernel: *const c_void,
    kernel_bytes: usize,
    absolute_mass: {T},
    diameter: {T},
    step: *mut {T},
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { stable_step_anywhere::<{T}, {d}>((kernel, kernel_bytes), absolute_mass, diameter, step) })
}

/// Writes the smallest overlap of n blobs in two dimensions: delta over the spacing (m/density)^(1/2), which is what the sum of blobs
/// samples the density with. A Gaussian's sampling error is exp(-(pi overlap)^2) of the density: 5e-9 at 1.4, 5e-5 at 1. Particles
/// without mass or density are not counted; NaN if all are such.
///
/// Refused, with `smallest` as it was: MOLLIS_ERR_DELTA, MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE,
/// MOLLIS_ERR_OVERLAP.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_overlap{d}{f}(
    n: usize,
    delta: {T},
    masses: *const {T},
    densities: *const {T},
    smallest: *mut {T},
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { overlap::<{T}, {d}>(n, delta, masses, densities, smallest) })
}
