//! Diagnostics of the blob method: what a run conserves, how long a step may be, how well its blobs overlap.

use core::ffi::c_void;

use mollis_core::diagnostics::{self, Moments};
use mollis_core::memory::Plain;
use mollis_core::{Real, Result};

use crate::buffers::{Input, Output, disjoint};
use crate::kernel;
use crate::status::{mollis_status, status};

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

unsafe fn moments<T: Real, const D: usize>(
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

unsafe fn stable_step<T: Real, const D: usize>(
    (kernel, bytes): (*const c_void, usize),
    n: usize,
    masses: *const T,
    positions: *const [T; D],
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

unsafe fn stable_step_anywhere<T: Real, const D: usize>(
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

unsafe fn overlap<T: Real, const D: usize>(
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

/// Writes total mass, sum of |m|, centre of mass (one point; 0 where the total mass is 0) and second moment about it,
/// sum m |x - centre|^2, of n particles in two dimensions.
///
/// `positions` [n][2], `masses` [n], of any sign. Null outputs are not wanted; the others are overwritten. Compensated sums in double
/// precision: a few roundings whatever n. A result is infinite only where the true one is beyond the range. Values that are not finite give results
/// that are not.
///
/// Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_moments2_eval(
    n: usize,
    positions: *const [f64; 2],
    masses: *const f64,
    mass: *mut f64,
    absolute_mass: *mut f64,
    centre: *mut [f64; 2],
    second: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { moments::<f64, 2>(n, positions, masses, [mass, absolute_mass, second], centre) })
}

/// As `mollis_moments2_eval`, in float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_moments2_eval_f32(
    n: usize,
    positions: *const [f32; 2],
    masses: *const f32,
    mass: *mut f32,
    absolute_mass: *mut f32,
    centre: *mut [f32; 2],
    second: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { moments::<f32, 2>(n, positions, masses, [mass, absolute_mass, second], centre) })
}

/// As `mollis_moments2_eval`, in one dimension.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_moments1_eval(
    n: usize,
    positions: *const [f64; 1],
    masses: *const f64,
    mass: *mut f64,
    absolute_mass: *mut f64,
    centre: *mut [f64; 1],
    second: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { moments::<f64, 1>(n, positions, masses, [mass, absolute_mass, second], centre) })
}

/// As `mollis_moments2_eval`, in one dimension and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_moments1_eval_f32(
    n: usize,
    positions: *const [f32; 1],
    masses: *const f32,
    mass: *mut f32,
    absolute_mass: *mut f32,
    centre: *mut [f32; 1],
    second: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { moments::<f32, 1>(n, positions, masses, [mass, absolute_mass, second], centre) })
}

/// As `mollis_moments2_eval`, in three dimensions.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_moments3_eval(
    n: usize,
    positions: *const [f64; 3],
    masses: *const f64,
    mass: *mut f64,
    absolute_mass: *mut f64,
    centre: *mut [f64; 3],
    second: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { moments::<f64, 3>(n, positions, masses, [mass, absolute_mass, second], centre) })
}

/// As `mollis_moments2_eval`, in three dimensions and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_moments3_eval_f32(
    n: usize,
    positions: *const [f32; 3],
    masses: *const f32,
    mass: *mut f32,
    absolute_mass: *mut f32,
    centre: *mut [f32; 3],
    second: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { moments::<f32, 3>(n, positions, masses, [mass, absolute_mass, second], centre) })
}

/// Writes a time step with which the classical Runge-Kutta method is stable at this state of n particles in two dimensions: 2.785
/// over a bound of the Jacobian's spectral radius; infinity where nothing moves. Ask again when particles have moved by a
/// good part of delta. Cost: n (n - 1) kernel evaluations.
///
/// Without a mollifier a pair at one place has such a step only if each term of the kernel is a power with p >= 2.
///
/// Refused, with `step` as it was: MOLLIS_ERR_NOT_FINITE (a position, a mass, or the bound itself; a pair at one place, or whose distance,
/// or the kernel's second derivatives at it, are beyond the scalar's range, however small the masses), the codes of an unprepared kernel (see `mollis_kernel2_eval`), MOLLIS_ERR_NULL_POINTER,
/// MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_stable_step2_eval(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    masses: *const f64,
    positions: *const [f64; 2],
    step: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { stable_step::<f64, 2>((kernel, kernel_bytes), n, masses, positions, step) })
}

/// As `mollis_stable_step2_eval`, in float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_stable_step2_eval_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    masses: *const f32,
    positions: *const [f32; 2],
    step: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { stable_step::<f32, 2>((kernel, kernel_bytes), n, masses, positions, step) })
}

/// As `mollis_stable_step2_eval`, in one dimension.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_stable_step1_eval(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    masses: *const f64,
    positions: *const [f64; 1],
    step: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { stable_step::<f64, 1>((kernel, kernel_bytes), n, masses, positions, step) })
}

/// As `mollis_stable_step2_eval`, in one dimension and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_stable_step1_eval_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    masses: *const f32,
    positions: *const [f32; 1],
    step: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { stable_step::<f32, 1>((kernel, kernel_bytes), n, masses, positions, step) })
}

/// As `mollis_stable_step2_eval`, in three dimensions.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_stable_step3_eval(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    masses: *const f64,
    positions: *const [f64; 3],
    step: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { stable_step::<f64, 3>((kernel, kernel_bytes), n, masses, positions, step) })
}

/// As `mollis_stable_step2_eval`, in three dimensions and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_stable_step3_eval_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    masses: *const f32,
    positions: *const [f32; 3],
    step: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { stable_step::<f32, 3>((kernel, kernel_bytes), n, masses, positions, step) })
}

/// Writes a time step with which the Runge-Kutta method is stable at every state of this total |mass| in which no two
/// particles are farther apart than `diameter`, in two dimensions: shorter than `mollis_stable_step2_eval`'s, but good for a whole run.
///
/// Refused, with `step` as it was: MOLLIS_ERR_NOT_FINITE (an argument, or no such step: a kernel without a mollifier, unless each of its
/// terms is a power with p >= 2; a host's own kernel is not known to be one; or the kernel's second derivatives leave the scalar's range within
/// `diameter`, however small the mass),
/// MOLLIS_ERR_OUT_OF_DOMAIN (a negative argument), the codes of an unprepared kernel, MOLLIS_ERR_NULL_POINTER,
/// MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_stable_step_anywhere2_eval(
    kernel: *const c_void,
    kernel_bytes: usize,
    absolute_mass: f64,
    diameter: f64,
    step: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { stable_step_anywhere::<f64, 2>((kernel, kernel_bytes), absolute_mass, diameter, step) })
}

/// As `mollis_stable_step_anywhere2_eval`, in float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_stable_step_anywhere2_eval_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    absolute_mass: f32,
    diameter: f32,
    step: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { stable_step_anywhere::<f32, 2>((kernel, kernel_bytes), absolute_mass, diameter, step) })
}

/// As `mollis_stable_step_anywhere2_eval`, in one dimension.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_stable_step_anywhere1_eval(
    kernel: *const c_void,
    kernel_bytes: usize,
    absolute_mass: f64,
    diameter: f64,
    step: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { stable_step_anywhere::<f64, 1>((kernel, kernel_bytes), absolute_mass, diameter, step) })
}

/// As `mollis_stable_step_anywhere2_eval`, in one dimension and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_stable_step_anywhere1_eval_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    absolute_mass: f32,
    diameter: f32,
    step: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { stable_step_anywhere::<f32, 1>((kernel, kernel_bytes), absolute_mass, diameter, step) })
}

/// As `mollis_stable_step_anywhere2_eval`, in three dimensions.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_stable_step_anywhere3_eval(
    kernel: *const c_void,
    kernel_bytes: usize,
    absolute_mass: f64,
    diameter: f64,
    step: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { stable_step_anywhere::<f64, 3>((kernel, kernel_bytes), absolute_mass, diameter, step) })
}

/// As `mollis_stable_step_anywhere2_eval`, in three dimensions and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_stable_step_anywhere3_eval_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    absolute_mass: f32,
    diameter: f32,
    step: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { stable_step_anywhere::<f32, 3>((kernel, kernel_bytes), absolute_mass, diameter, step) })
}

/// Writes the smallest overlap of n blobs in two dimensions: delta over the spacing (m/density)^(1/2), which is what the sum of blobs
/// samples the density with. A Gaussian's sampling error is exp(-(pi overlap)^2) of the density: 5e-9 at 1.4, 5e-5 at 1. Particles
/// without mass or density are not counted; NaN if all are such.
///
/// Refused, with `smallest` as it was: MOLLIS_ERR_DELTA, MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE,
/// MOLLIS_ERR_OVERLAP.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_overlap2_eval(
    n: usize,
    delta: f64,
    masses: *const f64,
    densities: *const f64,
    smallest: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { overlap::<f64, 2>(n, delta, masses, densities, smallest) })
}

/// As `mollis_overlap2_eval`, in float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_overlap2_eval_f32(
    n: usize,
    delta: f32,
    masses: *const f32,
    densities: *const f32,
    smallest: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { overlap::<f32, 2>(n, delta, masses, densities, smallest) })
}

/// As `mollis_overlap2_eval`, in one dimension.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_overlap1_eval(
    n: usize,
    delta: f64,
    masses: *const f64,
    densities: *const f64,
    smallest: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { overlap::<f64, 1>(n, delta, masses, densities, smallest) })
}

/// As `mollis_overlap2_eval`, in one dimension and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_overlap1_eval_f32(
    n: usize,
    delta: f32,
    masses: *const f32,
    densities: *const f32,
    smallest: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { overlap::<f32, 1>(n, delta, masses, densities, smallest) })
}

/// As `mollis_overlap2_eval`, in three dimensions.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_overlap3_eval(
    n: usize,
    delta: f64,
    masses: *const f64,
    densities: *const f64,
    smallest: *mut f64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { overlap::<f64, 3>(n, delta, masses, densities, smallest) })
}

/// As `mollis_overlap2_eval`, in three dimensions and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_overlap3_eval_f32(
    n: usize,
    delta: f32,
    masses: *const f32,
    densities: *const f32,
    smallest: *mut f32,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { overlap::<f32, 3>(n, delta, masses, densities, smallest) })
}
