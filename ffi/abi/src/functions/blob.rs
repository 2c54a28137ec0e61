//! Made from `ffi/abi/templates/blob.rs` by `cargo xtask header`: do not edit.

#![allow(missing_docs, reason = "documented at the plane's")]

use core::ffi::c_void;

use crate::blob::call::{Ask, Step};
use crate::blob::{mollis_blob_options, mollis_blob_report};
use crate::run::mollis_run;
use crate::status::{mollis_status, status};

/// The particles of the blob method in the plane, or massless points that follow their flow (tracers). Arrays as in mollis_sources2; null is not there.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_particles2 {
    /// How many.
    pub n: usize,
    /// Advanced in place.
    pub positions: [*mut f64; 2],
    /// From one to the next.
    pub stride: usize,
    /// Density times h^2, any sign; only read. Of tracers not looked at.
    pub masses: *const f64,
    /// From one to the next; 0: 1.
    pub mass_stride: usize,
    /// Advanced in place, or null; of tracers (if there are any) given if and only if it is of the particles.
    pub density: *mut f64,
    /// From one to the next; 0: 1.
    pub density_stride: usize,
    /// Overwritten with the velocity at the end, or null.
    pub velocity: [*mut f64; 2],
    /// From one to the next.
    pub velocity_stride: usize,
    /// Overwritten with the velocity's divergence at the end, or null; of tracers null.
    pub divergence: *mut f64,
    /// From one to the next; 0: 1.
    pub divergence_stride: usize,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_particles2_f32 {
    pub n: usize,
    pub positions: [*mut f32; 2],
    pub stride: usize,
    pub masses: *const f32,
    pub mass_stride: usize,
    pub density: *mut f32,
    pub density_stride: usize,
    pub velocity: [*mut f32; 2],
    pub velocity_stride: usize,
    pub divergence: *mut f32,
    pub divergence_stride: usize,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_particles1 {
    pub n: usize,
    pub positions: [*mut f64; 1],
    pub stride: usize,
    pub masses: *const f64,
    pub mass_stride: usize,
    pub density: *mut f64,
    pub density_stride: usize,
    pub velocity: [*mut f64; 1],
    pub velocity_stride: usize,
    pub divergence: *mut f64,
    pub divergence_stride: usize,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_particles1_f32 {
    pub n: usize,
    pub positions: [*mut f32; 1],
    pub stride: usize,
    pub masses: *const f32,
    pub mass_stride: usize,
    pub density: *mut f32,
    pub density_stride: usize,
    pub velocity: [*mut f32; 1],
    pub velocity_stride: usize,
    pub divergence: *mut f32,
    pub divergence_stride: usize,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_particles3 {
    pub n: usize,
    pub positions: [*mut f64; 3],
    pub stride: usize,
    pub masses: *const f64,
    pub mass_stride: usize,
    pub density: *mut f64,
    pub density_stride: usize,
    pub velocity: [*mut f64; 3],
    pub velocity_stride: usize,
    pub divergence: *mut f64,
    pub divergence_stride: usize,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_particles3_f32 {
    pub n: usize,
    pub positions: [*mut f32; 3],
    pub stride: usize,
    pub masses: *const f32,
    pub mass_stride: usize,
    pub density: *mut f32,
    pub density_stride: usize,
    pub velocity: [*mut f32; 3],
    pub velocity_stride: usize,
    pub divergence: *mut f32,
    pub divergence_stride: usize,
}

/// Bytes of workspace that mollis_blob2_step needs for the same arguments, wherever the workspace begins. Of the arrays only counts, strides and which pointers are null or beside
/// each other are looked at. Overwrites `bytes`.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob2_workspace_bytes(
    kernel: *const c_void,
    kernel_bytes: usize,
    particles: *const mollis_particles2,
    tracers: *const mollis_particles2,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    let (particles, tracers) = (particles.cast(), tracers.cast());
    let ask = Ask::<f64, 2> { kernel, kernel_bytes, particles, tracers, options, run };
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { ask.bytes(bytes) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob2_workspace_bytes_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    particles: *const mollis_particles2_f32,
    tracers: *const mollis_particles2_f32,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    let (particles, tracers) = (particles.cast(), tracers.cast());
    let ask = Ask::<f32, 2> { kernel, kernel_bytes, particles, tracers, options, run };
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { ask.bytes(bytes) })
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob1_workspace_bytes(
    kernel: *const c_void,
    kernel_bytes: usize,
    particles: *const mollis_particles1,
    tracers: *const mollis_particles1,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    let (particles, tracers) = (particles.cast(), tracers.cast());
    let ask = Ask::<f64, 1> { kernel, kernel_bytes, particles, tracers, options, run };
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { ask.bytes(bytes) })
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob1_workspace_bytes_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    particles: *const mollis_particles1_f32,
    tracers: *const mollis_particles1_f32,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    let (particles, tracers) = (particles.cast(), tracers.cast());
    let ask = Ask::<f32, 1> { kernel, kernel_bytes, particles, tracers, options, run };
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { ask.bytes(bytes) })
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob3_workspace_bytes(
    kernel: *const c_void,
    kernel_bytes: usize,
    particles: *const mollis_particles3,
    tracers: *const mollis_particles3,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    let (particles, tracers) = (particles.cast(), tracers.cast());
    let ask = Ask::<f64, 3> { kernel, kernel_bytes, particles, tracers, options, run };
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { ask.bytes(bytes) })
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob3_workspace_bytes_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    particles: *const mollis_particles3_f32,
    tracers: *const mollis_particles3_f32,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    let (particles, tracers) = (particles.cast(), tracers.cast());
    let ask = Ask::<f32, 3> { kernel, kernel_bytes, particles, tracers, options, run };
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { ask.bytes(bytes) })
}

/// Advances a solution of the aggregation equation by `steps` steps of length `dt` of the classical Runge-Kutta method
/// (Craig & Bertozzi, Definitions 2.2 and 2.3; without a mollifier: the particle method).
///
/// The velocity at x is `-sum_j masses[j] grad K(x - positions[j])`, in 2D or what `options->combination` makes of it: vortices, for example. With `options->diffusion` that of diffusion is added. `tracers`, `options`, `run` and `report` may be null. `steps` may be 0 (then `dt` is not looked at): the
/// velocities and divergences of the state as it is. The workspace is garbage afterwards. Cost: four field evaluations a step, one more if velocity, divergence or energy are
/// wanted; diffusion takes one or two sums more an evaluation; arrays with gaps are copied once a call.
///
/// A refused call writes nothing but `report` (and what `run` asks for). A run that stops (MOLLIS_ERR_BECAME_NOT_FINITE, also where only velocity, divergence or
/// energy overflow, MOLLIS_ERR_STOPPED, MOLLIS_ERR_ENERGY_ROSE, the executor's own status) leaves positions and densities as they were after the last
/// completed step, and velocity and divergence unwritten.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob2_step(
    kernel: *const c_void,
    kernel_bytes: usize,
    particles: *const mollis_particles2,
    tracers: *const mollis_particles2,
    dt: f64,
    steps: usize,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    workspace: *mut c_void,
    workspace_bytes: usize,
    report: *mut mollis_blob_report,
) -> mollis_status {
    let (particles, tracers) = (particles.cast(), tracers.cast());
    let ask = Ask::<f64, 2> { kernel, kernel_bytes, particles, tracers, options, run };
    // SAFETY: the caller promises the crate's contract.
    unsafe { ask.step(Step { dt, steps, workspace, workspace_bytes, report }) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob2_step_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    particles: *const mollis_particles2_f32,
    tracers: *const mollis_particles2_f32,
    dt: f64,
    steps: usize,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    workspace: *mut c_void,
    workspace_bytes: usize,
    report: *mut mollis_blob_report,
) -> mollis_status {
    let (particles, tracers) = (particles.cast(), tracers.cast());
    let ask = Ask::<f32, 2> { kernel, kernel_bytes, particles, tracers, options, run };
    // SAFETY: the caller promises the crate's contract.
    unsafe { ask.step(Step { dt, steps, workspace, workspace_bytes, report }) }
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob1_step(
    kernel: *const c_void,
    kernel_bytes: usize,
    particles: *const mollis_particles1,
    tracers: *const mollis_particles1,
    dt: f64,
    steps: usize,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    workspace: *mut c_void,
    workspace_bytes: usize,
    report: *mut mollis_blob_report,
) -> mollis_status {
    let (particles, tracers) = (particles.cast(), tracers.cast());
    let ask = Ask::<f64, 1> { kernel, kernel_bytes, particles, tracers, options, run };
    // SAFETY: the caller promises the crate's contract.
    unsafe { ask.step(Step { dt, steps, workspace, workspace_bytes, report }) }
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob1_step_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    particles: *const mollis_particles1_f32,
    tracers: *const mollis_particles1_f32,
    dt: f64,
    steps: usize,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    workspace: *mut c_void,
    workspace_bytes: usize,
    report: *mut mollis_blob_report,
) -> mollis_status {
    let (particles, tracers) = (particles.cast(), tracers.cast());
    let ask = Ask::<f32, 1> { kernel, kernel_bytes, particles, tracers, options, run };
    // SAFETY: the caller promises the crate's contract.
    unsafe { ask.step(Step { dt, steps, workspace, workspace_bytes, report }) }
}

#[cfg(all(feature = "dimensions", feature = "double"))]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob3_step(
    kernel: *const c_void,
    kernel_bytes: usize,
    particles: *const mollis_particles3,
    tracers: *const mollis_particles3,
    dt: f64,
    steps: usize,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    workspace: *mut c_void,
    workspace_bytes: usize,
    report: *mut mollis_blob_report,
) -> mollis_status {
    let (particles, tracers) = (particles.cast(), tracers.cast());
    let ask = Ask::<f64, 3> { kernel, kernel_bytes, particles, tracers, options, run };
    // SAFETY: the caller promises the crate's contract.
    unsafe { ask.step(Step { dt, steps, workspace, workspace_bytes, report }) }
}

#[cfg(feature = "dimensions")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob3_step_f32(
    kernel: *const c_void,
    kernel_bytes: usize,
    particles: *const mollis_particles3_f32,
    tracers: *const mollis_particles3_f32,
    dt: f64,
    steps: usize,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    workspace: *mut c_void,
    workspace_bytes: usize,
    report: *mut mollis_blob_report,
) -> mollis_status {
    let (particles, tracers) = (particles.cast(), tracers.cast());
    let ask = Ask::<f32, 3> { kernel, kernel_bytes, particles, tracers, options, run };
    // SAFETY: the caller promises the crate's contract.
    unsafe { ask.step(Step { dt, steps, workspace, workspace_bytes, report }) }
}
