//! Made from `ffi/abi/templates/pks.rs` by `cargo xtask header`: do not edit.

#![allow(missing_docs, reason = "documented at the plane's")]

use core::ffi::c_void;

use crate::pks::step::{Call, size};
use crate::pks::{
    mollis_pks_attraction, mollis_pks_events, mollis_pks_options, mollis_pks_progress, mollis_pks_report,
};
use crate::random::mollis_generator;
use crate::run::mollis_run;
use crate::status::{mollis_status, status};

/// The arrays of coalescing particles, each with room for as many; the first progress->count are alive.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_pks_particles {
    /// Elements of each array.
    pub room: usize,
    /// [room][2]; read and written.
    pub positions: *mut [f64; 2],
    /// Positive; a merged particle has the sum.
    pub masses: *mut f64,
    /// All different; a merged particle keeps its lowest.
    pub labels: *mut u64,
    /// Travels with the particles; may be null.
    pub species: *mut u32,
    /// w_i = m_i / chi_i, positive, for particles of different sensitivities; a merged particle has the sum. Null: all chi_i are 1.
    pub weights: *mut f64,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_pks_particles_f32 {
    pub room: usize,
    pub positions: *mut [f32; 2],
    pub masses: *mut f32,
    pub labels: *mut u64,
    pub species: *mut u32,
    pub weights: *mut f32,
}

/// Bytes of the workspace that mollis_pks_step needs for arrays with room for so many particles, wherever it begins, with this run's executor and communicator: on
/// ranks each has so much room.
///
/// Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP, MOLLIS_ERR_OPTIONS_SIZE, MOLLIS_ERR_NOT_INITIALISED, MOLLIS_ERR_UNKNOWN_VALUE, MOLLIS_ERR_NOT_FINITE,
/// MOLLIS_ERR_OUT_OF_DOMAIN (a negative noise, separation or probability not between 0 and 1, an empty mesh),
/// MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_UNSUPPORTED (heavy particles in a box, or by a singular kernel), and those of an unprepared kernel.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_workspace_bytes(
    room: usize,
    attraction: *const mollis_pks_attraction,
    options: *const mollis_pks_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { size::<f64>(room, attraction, options, run, bytes) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_workspace_bytes_f32(
    room: usize,
    attraction: *const mollis_pks_attraction,
    options: *const mollis_pks_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { size::<f32>(room, attraction, options, run, bytes) })
}

/// Advances coalescing particles by `steps` steps of length dt (Zhelezov & Fatkullin, Section 3.2): finds the clusters that may collide, moves
/// every particle by chi times the attraction and its own noise, decides the collisions and merges at the centre of mass.
///
/// Events are appended: every merge. `generator`: the host's stream, drawn in array order, then for heavy particles; null: the built-in one with options->seed, a
/// stream a label. The report is added to, and may be null, as `run` may.
///
/// Merging lowers progress->count; the particles that are left keep their order. Arrays, progress and the generator's state are all that a
/// run is: copied away and back between calls it continues bit for bit. With the built-in generator the result does not
/// depend on the executor.
///
/// Sensitivities (Section 4.5): with weights particle i drifts by chi_i = m_i / w_i times chi times the attraction, which masses alone make, and diffuses with noise / w_i. With these a pair's forces are mutual, so
/// that the centre of the weights rests but for noise; clusters merge there, and have the index (2.7) of their masses. MOLLIS_ERR_MASS: a weight is not positive. MOLLIS_ERR_OUT_OF_DOMAIN: a sensitivity out of range.
/// MOLLIS_ERR_UNSUPPORTED with heavy particles, on more than one rank, for a sum with noise and another merging than MOLLIS_PKS_MERGE_ALL, and in firmware.
///
/// Range: the result does not depend on the units, up to rounding; a mesh in free space loses digits by the logarithm of its size. Masses, and chi, noise and gamma where they are not 0, have to be normal
/// numbers of the scalar (MOLLIS_ERR_OUT_OF_DOMAIN), and the gradient (mass / length) and chi times it have to be
/// in range, as must mass / length^2 for heavy particles; what leaves the range ends in MOLLIS_ERR_BECAME_NOT_FINITE or MOLLIS_ERR_TOO_MANY_SUBSTEPS. An attraction so strong against
/// a positive noise that indices are out of range (chi M^2 / noise above 1e38 for f32, M being the mass of all particles) is MOLLIS_ERR_OUT_OF_DOMAIN.
/// Masses below 1e-19 of M (f32; 1e-154 for f64) do not collide with one another.
///
/// On ranks (`run->communicator`) the particles are those of all ranks, and each passes its own. Results are bit for bit those of one process whose arrays are the ranks' one after the
/// other. All ranks get all events; a merged particle stays where the one with its lowest label was, and any rank may be left without particles. Give all of them arrays of the same room, and
/// buffers of events of the same room. The report's sub-steps and normals are the rank's own, its other numbers those of all. An attraction by a sum, heavy particles, a medium, an attractant with a memory, and noise from the host's generator
/// are MOLLIS_ERR_UNSUPPORTED with more than one rank.
///
/// MOLLIS_ERR_EVENTS_FULL: the step stopped before a merge that has no room; empty the buffers (or give larger ones) and call again with the
/// same workspace (or its bytes at an address that is equal modulo MOLLIS_ALIGN): it goes on with progress->pending merges. Any other status leaves the state of the last completed step:
/// MOLLIS_ERR_TOO_MANY_SUBSTEPS, MOLLIS_ERR_BECAME_NOT_FINITE, MOLLIS_ERR_STOPPED, the generator's or executor's own, as they returned it. Refused with nothing
/// written: MOLLIS_ERR_NOT_FINITE (run->first_bad: the particle), MOLLIS_ERR_MASS, MOLLIS_ERR_TIME_STEP, MOLLIS_ERR_OUT_OF_DOMAIN, MOLLIS_ERR_LENGTH_MISMATCH (count > room),
/// MOLLIS_ERR_OVERLAP, MOLLIS_ERR_UNSUPPORTED (heavy particles in a box, or by a singular kernel), MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_NOT_PREPARED (pending merges that the workspace does not hold).
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_step(
    particles: *const mollis_pks_particles,
    progress: *mut mollis_pks_progress,
    attraction: *const mollis_pks_attraction,
    generator: *const mollis_generator,
    dt: f64,
    steps: usize,
    events: *mut mollis_pks_events,
    options: *const mollis_pks_options,
    run: *const mollis_run,
    workspace: *mut c_void,
    workspace_bytes: usize,
    report: *mut mollis_pks_report,
) -> mollis_status {
    let particles = particles.cast();
    let call = Call::<f64> {
        particles,
        progress,
        attraction,
        generator,
        dt,
        steps,
        events,
        options,
        run,
        workspace,
        workspace_bytes,
        report,
    };
    // SAFETY: the caller promises the crate's contract.
    unsafe { call.step() }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_step_f32(
    particles: *const mollis_pks_particles_f32,
    progress: *mut mollis_pks_progress,
    attraction: *const mollis_pks_attraction,
    generator: *const mollis_generator,
    dt: f64,
    steps: usize,
    events: *mut mollis_pks_events,
    options: *const mollis_pks_options,
    run: *const mollis_run,
    workspace: *mut c_void,
    workspace_bytes: usize,
    report: *mut mollis_pks_report,
) -> mollis_status {
    let particles = particles.cast();
    let call = Call::<f32> {
        particles,
        progress,
        attraction,
        generator,
        dt,
        steps,
        events,
        options,
        run,
        workspace,
        workspace_bytes,
        report,
    };
    // SAFETY: the caller promises the crate's contract.
    unsafe { call.step() }
}
