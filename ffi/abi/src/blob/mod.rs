//! The blob method: sizes and runs.

mod call;
mod options;

use core::ffi::c_void;

use crate::run::mollis_run;
use crate::status::{mollis_status, status};
use call::{Call, Query};
pub use options::*;

/// As `mollis_blob2_workspace_bytes`, in one dimension.
///
/// # Safety
/// The contract of this header.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob1_workspace_bytes(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    tracers: usize,
    wanted: u32,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    status(Query { kernel, kernel_bytes, n, tracers, wanted, options, run, bytes }.answer::<f64, 1>())
}

/// As `mollis_blob2_step`, in one dimension.
///
/// # Safety
/// The contract of this header.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob1_step(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    masses: *const f64,
    positions: *mut [f64; 1],
    density: *mut f64,
    velocity: *mut [f64; 1],
    divergence: *mut f64,
    tracers: usize,
    tracer_positions: *mut [f64; 1],
    tracer_density: *mut f64,
    tracer_velocity: *mut [f64; 1],
    dt: f64,
    steps: usize,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    report: *mut mollis_blob_report,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    let call = Call {
        kernel,
        kernel_bytes,
        n,
        masses,
        positions,
        density,
        velocity,
        divergence,
        tracers,
        tracer_positions,
        tracer_density,
        tracer_velocity,
        dt,
        steps,
        options,
        run,
        report,
        workspace,
        workspace_bytes,
    };
    call.step()
}

/// As `mollis_blob2_workspace_bytes`, in one dimension and float.
///
/// # Safety
/// The contract of this header.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob1_workspace_bytes_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    tracers: usize,
    wanted: u32,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    status(Query { kernel, kernel_bytes, n, tracers, wanted, options, run, bytes }.answer::<f32, 1>())
}

/// As `mollis_blob2_step`, in one dimension and float.
///
/// # Safety
/// The contract of this header.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob1_step_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    masses: *const f32,
    positions: *mut [f32; 1],
    density: *mut f32,
    velocity: *mut [f32; 1],
    divergence: *mut f32,
    tracers: usize,
    tracer_positions: *mut [f32; 1],
    tracer_density: *mut f32,
    tracer_velocity: *mut [f32; 1],
    dt: f64,
    steps: usize,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    report: *mut mollis_blob_report,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    let call = Call {
        kernel,
        kernel_bytes,
        n,
        masses,
        positions,
        density,
        velocity,
        divergence,
        tracers,
        tracer_positions,
        tracer_density,
        tracer_velocity,
        dt,
        steps,
        options,
        run,
        report,
        workspace,
        workspace_bytes,
    };
    call.step()
}

/// Bytes of workspace that `mollis_blob2_step` needs.
///
/// `kernel` is a block of `mollis_kernel2_prepare`; `n` particles and `tracers` tracers; `wanted` is the sum of
/// `MOLLIS_BLOB_DENSITY`, `_VELOCITY` and `_DIVERGENCE` for which the step will be given arrays (of particles or tracers). Options and
/// run must be those of the step. Overwrites `bytes`.
///
/// # Safety
/// The contract of this header.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob2_workspace_bytes(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    tracers: usize,
    wanted: u32,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    status(Query { kernel, kernel_bytes, n, tracers, wanted, options, run, bytes }.answer::<f64, 2>())
}

/// Advances a solution of the aggregation equation by `steps` steps of length `dt` of the classical Runge-Kutta method
/// (Craig & Bertozzi, Definitions 2.2 and 2.3; without a mollifier: the particle method).
///
/// | array              | shape           |                                                              |
/// |--------------------|-----------------|--------------------------------------------------------------|
/// | `masses`           | `[n]`           | density times h^D, any sign; read only                       |
/// | `positions`        | `[n][2]`        | advanced in place                                            |
/// | `density`          | `[n]`           | advanced in place, or null                                   |
/// | `velocity`         | `[n][2]`        | overwritten with the velocity at the end, or null            |
/// | `divergence`       | `[n]`           | overwritten with the velocity's divergence at the end, or null |
/// | `tracer_positions` | `[tracers][2]`  | massless points, advanced in place; null if there are none   |
/// | `tracer_density`   | `[tracers]`     | advanced in place; given if and only if `density` is         |
/// | `tracer_velocity`  | `[tracers][2]`  | overwritten with the velocity at the end, or null            |
///
/// The velocity at x is `-sum_j masses[j] grad K(x - positions[j])`. `steps` may be 0 (then `dt` is not looked at): the outputs
/// of the state as it is. `options`, `run` and `report` may be null. The workspace is garbage afterwards. Cost: four field evaluations a
/// step, one more if velocity, divergence or energy are wanted.
///
/// A refused call writes nothing but `report` (and `run->first_bad`). A run that stops (`MOLLIS_ERR_BECAME_NOT_FINITE`, also where only velocity, divergence or
/// energy overflow, `MOLLIS_ERR_STOPPED`, `MOLLIS_ERR_ENERGY_ROSE`, the executor's own status) leaves positions and densities as they were after the last
/// completed step, and velocity and divergence unwritten.
///
/// # Safety
/// The contract of this header.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob2_step(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    masses: *const f64,
    positions: *mut [f64; 2],
    density: *mut f64,
    velocity: *mut [f64; 2],
    divergence: *mut f64,
    tracers: usize,
    tracer_positions: *mut [f64; 2],
    tracer_density: *mut f64,
    tracer_velocity: *mut [f64; 2],
    dt: f64,
    steps: usize,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    report: *mut mollis_blob_report,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    let call = Call {
        kernel,
        kernel_bytes,
        n,
        masses,
        positions,
        density,
        velocity,
        divergence,
        tracers,
        tracer_positions,
        tracer_density,
        tracer_velocity,
        dt,
        steps,
        options,
        run,
        report,
        workspace,
        workspace_bytes,
    };
    call.step()
}

/// As `mollis_blob2_workspace_bytes`, in two dimensions and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob2_workspace_bytes_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    tracers: usize,
    wanted: u32,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    status(Query { kernel, kernel_bytes, n, tracers, wanted, options, run, bytes }.answer::<f32, 2>())
}

/// As `mollis_blob2_step`, in two dimensions and float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob2_step_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    masses: *const f32,
    positions: *mut [f32; 2],
    density: *mut f32,
    velocity: *mut [f32; 2],
    divergence: *mut f32,
    tracers: usize,
    tracer_positions: *mut [f32; 2],
    tracer_density: *mut f32,
    tracer_velocity: *mut [f32; 2],
    dt: f64,
    steps: usize,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    report: *mut mollis_blob_report,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    let call = Call {
        kernel,
        kernel_bytes,
        n,
        masses,
        positions,
        density,
        velocity,
        divergence,
        tracers,
        tracer_positions,
        tracer_density,
        tracer_velocity,
        dt,
        steps,
        options,
        run,
        report,
        workspace,
        workspace_bytes,
    };
    call.step()
}

/// As `mollis_blob2_workspace_bytes`, in three dimensions.
///
/// # Safety
/// The contract of this header.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob3_workspace_bytes(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    tracers: usize,
    wanted: u32,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    status(Query { kernel, kernel_bytes, n, tracers, wanted, options, run, bytes }.answer::<f64, 3>())
}

/// As `mollis_blob2_step`, in three dimensions.
///
/// # Safety
/// The contract of this header.
#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob3_step(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    masses: *const f64,
    positions: *mut [f64; 3],
    density: *mut f64,
    velocity: *mut [f64; 3],
    divergence: *mut f64,
    tracers: usize,
    tracer_positions: *mut [f64; 3],
    tracer_density: *mut f64,
    tracer_velocity: *mut [f64; 3],
    dt: f64,
    steps: usize,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    report: *mut mollis_blob_report,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    let call = Call {
        kernel,
        kernel_bytes,
        n,
        masses,
        positions,
        density,
        velocity,
        divergence,
        tracers,
        tracer_positions,
        tracer_density,
        tracer_velocity,
        dt,
        steps,
        options,
        run,
        report,
        workspace,
        workspace_bytes,
    };
    call.step()
}

/// As `mollis_blob2_workspace_bytes`, in three dimensions and float.
///
/// # Safety
/// The contract of this header.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob3_workspace_bytes_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    tracers: usize,
    wanted: u32,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    status(Query { kernel, kernel_bytes, n, tracers, wanted, options, run, bytes }.answer::<f32, 3>())
}

/// As `mollis_blob2_step`, in three dimensions and float.
///
/// # Safety
/// The contract of this header.
#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob3_step_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    masses: *const f32,
    positions: *mut [f32; 3],
    density: *mut f32,
    velocity: *mut [f32; 3],
    divergence: *mut f32,
    tracers: usize,
    tracer_positions: *mut [f32; 3],
    tracer_density: *mut f32,
    tracer_velocity: *mut [f32; 3],
    dt: f64,
    steps: usize,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    report: *mut mollis_blob_report,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    let call = Call {
        kernel,
        kernel_bytes,
        n,
        masses,
        positions,
        density,
        velocity,
        divergence,
        tracers,
        tracer_positions,
        tracer_density,
        tracer_velocity,
        dt,
        steps,
        options,
        run,
        report,
        workspace,
        workspace_bytes,
    };
    call.step()
}
