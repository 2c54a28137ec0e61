//! Made from `ffi/abi/templates/grid.rs` by `cargo xtask header`: do not edit.

#![allow(missing_docs, reason = "documented at the plane's")]

use core::ffi::c_void;

use super::field::*;
use crate::grid::call::Ask;
use crate::grid::{mollis_grid2_options, mollis_mesh2};
use crate::run::mollis_run;
use crate::status::{mollis_status, status};

/// Where the results of a field on a mesh go; each is overwritten, null is not computed. Arrays over the nodes run along x first.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_grid2_outputs {
    /// grad u at the targets, as in mollis_outputs2; outside the mesh that of all mass at its centre.
    pub gradient: [*mut f64; 2],
    /// From one to the next.
    pub gradient_stride: usize,
    /// The mass at each node.
    pub node_mass: *mut f64,
    /// u at the nodes; with order 4 sharpened for interpolation.
    pub node_potential: *mut f64,
    /// Its differences, [nodes][2].
    pub node_gradient: *mut [f64; 2],
    /// Total mass and its centre: three numbers.
    pub total: *mut [f64; 3],
    /// One number: sources outside the mesh (on its border they are inside); they act through the total mass only.
    pub outside: *mut u64,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_grid2_outputs_f32 {
    pub gradient: [*mut f32; 2],
    pub gradient_stride: usize,
    pub node_mass: *mut f32,
    pub node_potential: *mut f32,
    pub node_gradient: *mut [f32; 2],
    pub total: *mut [f32; 3],
    pub outside: *mut u64,
}

/// Bytes of workspace that mollis_grid2_eval needs for the same arguments, wherever it begins, with this run's executor. Of the arrays only counts, strides and which
/// pointers are null or beside each other are looked at.
///
/// Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_NOT_FINITE, MOLLIS_ERR_OUT_OF_DOMAIN (an empty rectangle, fewer than 2 cells, a corner beyond
/// 2^-13 of the scalar's largest number, a mesh width below its normal range, cells more than 2^40 times as long as wide),
/// MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_UNKNOWN_VALUE (walls, order), MOLLIS_ERR_KERNEL_PARAMETER (screening), MOLLIS_ERR_UNSUPPORTED (second
/// moments with screening; order 4 with long or coarse cells; a medium with screening, order 4 or second moments; a memory with those or a medium), MOLLIS_ERR_OPTIONS_SIZE,
/// MOLLIS_ERR_NOT_INITIALISED.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_grid2_workspace_bytes(
    mesh: *const mollis_mesh2,
    sources: *const mollis_sources2,
    targets: *const mollis_targets2,
    outputs: *const mollis_grid2_outputs,
    options: *const mollis_grid2_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    let ask = Ask::<f64> { mesh, sources: sources.cast(), targets: targets.cast(), outputs: outputs.cast(), options };
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { ask.bytes(run, bytes) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_grid2_workspace_bytes_f32(
    mesh: *const mollis_mesh2,
    sources: *const mollis_sources2_f32,
    targets: *const mollis_targets2_f32,
    outputs: *const mollis_grid2_outputs_f32,
    options: *const mollis_grid2_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    let ask = Ask::<f32> { mesh, sources: sources.cast(), targets: targets.cast(), outputs: outputs.cast(), options };
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { ask.bytes(run, bytes) })
}

/// The field of masses of any sign on a mesh: u(x) = sum_j masses[j] V(x - x_j), V = log r / (2 pi), or -K0(k r) / (2 pi) with
/// screening k. Cloud-in-cell deposit in 64-bit fixed point, the five-point scheme solved exactly, bilinear interpolation of its centred
/// differences (Zhelezov & Fatkullin, (3.6) to (3.10), whose c is -u); or the scheme of fourth order, see mollis_grid2_options.
///
/// With a medium V is the solution of div(G grad V) - k^2 V = Dirac, see mollis_medium2; MOLLIS_ERR_NOT_CONVERGED: the iteration did not reach its tolerance, and the outputs are those of the last
/// iterate. Refused beside what is below: MOLLIS_ERR_OUT_OF_DOMAIN (G <= 0, k^2 < 0, a G too far below the largest, a tolerance that is not positive), MOLLIS_ERR_UNSUPPORTED (free space
/// with coefficients that differ on the border), MOLLIS_ERR_NOT_FINITE (first_bad is not set).
///
/// With an attractant with a memory u is -c after the density has acted for its `time`, and c is written, whatever outputs there are; see mollis_parabolic2. The monopole acts nowhere then: total
/// and outside are as ever. Refused beside what is below: MOLLIS_ERR_OUT_OF_DOMAIN (a time scale that is not positive, values on a free border), MOLLIS_ERR_TIME_STEP, MOLLIS_ERR_NOT_FINITE
/// (first_bad is not set).
///
/// Masses are rounded to a unit between 2^-50 and 2^-49 of the sum of |masses|, four shares each: beside the others a mass below 2^-51 =
/// 4.4e-16 of that sum adds nothing, and one of 1e-12 has three digits. Of a source outside, the distance from the mesh's middle counts up to 1024 widths
/// of the mesh in the centre of mass.
///
/// Range: the sum of |masses| over a cell's width, and over the distance of a target outside, has to be in range; where it is not, gradients are infinite
/// or NaN.
///
/// What no output needs is not computed. Sources have masses alone (MOLLIS_ERR_UNSUPPORTED: core radii, vector strengths); null targets are the sources. The bits do not depend on the order of the
/// sources, on the executor or on the level. The workspace is scratch, of mollis_grid2_workspace_bytes.
///
/// Refused, with nothing written: the errors of mollis_grid2_workspace_bytes, MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_MISALIGNED,
/// MOLLIS_ERR_OVERLAP, MOLLIS_ERR_NOT_FINITE (run->first_bad: sources, then targets). MOLLIS_ERR_STOPPED, MOLLIS_ERR_EXECUTOR, the executor's
/// own: outputs are then undefined.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_grid2_eval(
    mesh: *const mollis_mesh2,
    sources: *const mollis_sources2,
    targets: *const mollis_targets2,
    outputs: *const mollis_grid2_outputs,
    options: *const mollis_grid2_options,
    run: *const mollis_run,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    let ask = Ask::<f64> { mesh, sources: sources.cast(), targets: targets.cast(), outputs: outputs.cast(), options };
    // SAFETY: the caller promises the crate's contract.
    unsafe { ask.evaluate(run, (workspace, workspace_bytes)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_grid2_eval_f32(
    mesh: *const mollis_mesh2,
    sources: *const mollis_sources2_f32,
    targets: *const mollis_targets2_f32,
    outputs: *const mollis_grid2_outputs_f32,
    options: *const mollis_grid2_options,
    run: *const mollis_run,
    workspace: *mut c_void,
    workspace_bytes: usize,
) -> mollis_status {
    let ask = Ask::<f32> { mesh, sources: sources.cast(), targets: targets.cast(), outputs: outputs.cast(), options };
    // SAFETY: the caller promises the crate's contract.
    unsafe { ask.evaluate(run, (workspace, workspace_bytes)) }
}
