use core::ffi::c_void;

use crate::blob::call::{Ask, Step};
use crate::blob::{mollis_blob_options, mollis_blob_report};
use crate::run::mollis_run;
use crate::status::{mollis_status, status};

/// The particles of the blob method in the plane, or massless points that follow their flow (tracers). Arrays as in mollis_sources2; null is not there.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_particles{d}{f} {
    /// How many.
    pub n: usize,
    /// Advanced in place.
    pub positions: [*mut {T}; {d}],
    /// From one to the next.
    pub stride: usize,
    /// Density times h^2, any sign; only read. Of tracers not looked at.
    pub masses: *const {T},
    /// From one to the next; 0: 1.
    pub mass_stride: usize,
    /// Advanced in place, or null; of tracers (if there are any) given if and only if it is of the particles.
    pub density: *mut {T},
    /// From one to the next; 0: 1.
    pub density_stride: usize,
    /// Overwritten with the velocity at the end, or null.
    pub velocity: [*mut {T}; {d}],
    /// From one to the next.
    pub velocity_stride: usize,
    /// Overwritten with the velocity's divergence at the end, or null; of tracers null.
    pub divergence: *mut {T},
    /// From one to the next; 0: 1.
    pub divergence_stride: usize,
}

/// Bytes of workspace that mollis_blob2_step needs for the same arguments, wherever the workspace begins. Of the arrays only counts, strides and which pointers are null or beside
/// each other are looked at. Overwrites `bytes`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob{d}_workspace_bytes{f}(
    kernel: *const c_void,
    kernel_bytes: usize,
    particles: *const mollis_particles{d}{f},
    tracers: *const mollis_particles{d}{f},
    options: *const mollis_blob_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    let (particles, tracers) = (particles.cast(), tracers.cast());
    let ask = Ask::<{T}, {d}> { kernel, kernel_bytes, particles, tracers, options, run };
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
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob{d}_step{f}(
    kernel: *const c_void,
    kernel_bytes: usize,
    particles: *const mollis_particles{d}{f},
    tracers: *const mollis_particles{d}{f},
    dt: f64,
    steps: usize,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    workspace: *mut c_void,
    workspace_bytes: usize,
    report: *mut mollis_blob_report,
) -> mollis_status {
    let (particles, tracers) = (particles.cast(), tracers.cast());
    let ask = Ask::<{T}, {d}> { kernel, kernel_bytes, particles, tracers, options, run };
    // SAFETY: the caller promises the crate's contract.
    unsafe { ask.step(Step { dt, steps, workspace, workspace_bytes, report }) }
}
