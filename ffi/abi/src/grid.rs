//! Mesh fields.

use core::ffi::c_void;

use mollis_core::grid::{Equation, Grid, Mesh, Order, Walls};
use mollis_core::{Error, Real, Result};

use crate::buffers::{Input, Output, disjoint, workspace};
use crate::first_bad::first_bad;
use crate::options;
use crate::run::{CallReport, HostRun, mollis_run, with_run};
use crate::status::{mollis_status, status};

/// Free space: the field of all mass at its centre is prescribed on the mesh's border, and acts outside. Closer to the centre than half of
/// the smaller mesh width its potential is that at this distance, and its gradient falls linearly to 0.
pub const MOLLIS_WALLS_FREE: i32 = 0;
/// No flux through the border: particles outside act from, and are driven at, their mirror places.
pub const MOLLIS_WALLS_NO_FLUX: i32 = 1;
/// Free space, with the second moments of the mass in that field as well: for long or divided mass. Without screening only.
/// Closer to the centre than sqrt(2 |Q| / |M|), Q = sum m (x + i y)^2 about it, where this expansion means nothing, their part grows no more.
pub const MOLLIS_WALLS_FREE_QUADRUPOLE: i32 = 2;

/// A rectangle cut into cells[0] by cells[1] equal cells, at least 2 each way. It has (cells[0] + 1) (cells[1] + 1) nodes; arrays over
/// the nodes run along x first.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_mesh2 {
    /// The lower left corner.
    pub lower: [f64; 2],
    /// The upper right corner.
    pub upper: [f64; 2],
    /// Cells along x and y.
    pub cells: [usize; 2],
}

impl mollis_mesh2 {
    /// # Safety
    /// The crate's contract for `mesh`.
    pub(crate) unsafe fn read<T: Real>(mesh: *const Self) -> Result<Mesh<T>> {
        if mesh.is_null() {
            return Err(Error::NullPointer);
        }
        if !mesh.is_aligned() {
            return Err(Error::Misaligned);
        }
        // SAFETY: not null, aligned, and the caller promises a mesh there.
        let mesh = unsafe { *mesh };
        Mesh::new(mesh.lower.map(T::from_f64), mesh.upper.map(T::from_f64), mesh.cells)
    }
}

/// Which field a grid solves for. Fill it with `mollis_grid2_options_init`; null means the defaults.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_grid2_options {
    /// Bytes of this structure, as `mollis_grid2_options_init` sets it.
    pub size: u32,
    /// `MOLLIS_WALLS_*`. Default: free space.
    pub walls: i32,
    /// k >= 0 of Laplacian(u) - k^2 u = density. Default: 0.
    pub screening: f64,
    /// How fast the error of the particles' attraction, summed over many, falls with the mesh width where their density is smooth: 2 (five points; the
    /// default) or 4 (nine points, a density sharpened by what deposit and interpolation smooth it; for cells whose sides are within a factor of
    /// 1.25 and at most 1/k).
    pub order: i32,
    /// Ignored.
    pub reserved: i32,
}

options::options!(mollis_grid2_options { walls: MOLLIS_WALLS_FREE, screening: 0.0, order: 2, reserved: 0 });

pub(crate) fn equation<T: Real>(options: &mollis_grid2_options) -> Result<Equation<T>> {
    let walls = match options.walls {
        MOLLIS_WALLS_FREE => Walls::Free,
        MOLLIS_WALLS_NO_FLUX => Walls::NoFlux,
        MOLLIS_WALLS_FREE_QUADRUPOLE => Walls::FreeQuadrupole,
        _ => return Err(Error::UnknownValue),
    };
    let order = match options.order {
        2 => Order::Second,
        4 => Order::Fourth,
        _ => return Err(Error::UnknownValue),
    };
    Ok(Equation { screening: T::from_f64(options.screening), walls, order })
}

/// Fills `options` with the defaults. `size` is `sizeof *options`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_grid2_options_init(options: *mut mollis_grid2_options, size: usize) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { options::init(options, size) })
}

unsafe fn workspace_bytes<T: Real>(
    mesh: *const mollis_mesh2,
    options: *const mollis_grid2_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> Result<()> {
    let bytes = Output::new(bytes, 1)?;
    // SAFETY: the caller promises the crate's contract.
    let (mesh, options, run) =
        unsafe { (mollis_mesh2::read::<T>(mesh)?, options::read(options)?, HostRun::read(run)?) };
    let needed = Grid::workspace_bytes(&mesh, &equation(&options)?, run.workers())?;
    // SAFETY: as above.
    unsafe { bytes.slice() }.iter_mut().for_each(|slot| *slot = needed);
    Ok(())
}

/// The exact size of the workspace that mollis_grid2_eval needs for this mesh and these options, with this run's executor.
///
/// Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_NOT_FINITE, MOLLIS_ERR_OUT_OF_DOMAIN (an empty rectangle, fewer than 2 cells, a corner beyond
/// 2^-13 of the scalar's largest number, a mesh width below its normal range, cells more than 2^40 times as long as wide),
/// MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_UNKNOWN_VALUE (walls, order), MOLLIS_ERR_KERNEL_PARAMETER (screening), MOLLIS_ERR_UNSUPPORTED (second
/// moments with screening; order 4 with long or coarse cells), MOLLIS_ERR_OPTIONS_SIZE, MOLLIS_ERR_NOT_INITIALISED.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_grid2_workspace_bytes(
    mesh: *const mollis_mesh2,
    options: *const mollis_grid2_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { workspace_bytes::<f64>(mesh, options, run, bytes) })
}

/// As mollis_grid2_workspace_bytes, for mollis_grid2_eval_f32.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_grid2_workspace_bytes_f32(
    mesh: *const mollis_mesh2,
    options: *const mollis_grid2_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { workspace_bytes::<f32>(mesh, options, run, bytes) })
}

#[expect(clippy::too_many_arguments, reason = "one optional output each")]
unsafe fn eval<T: Real>(
    mesh: *const mollis_mesh2,
    options: *const mollis_grid2_options,
    n_sources: usize,
    sources: *const [T; 2],
    masses: *const T,
    n_targets: usize,
    targets: *const [T; 2],
    gradient: *mut [T; 2],
    node_mass: *mut T,
    node_potential: *mut T,
    node_gradient: *mut [T; 2],
    total: *mut [T; 3],
    outside: *mut u64,
    memory: *mut c_void,
    bytes: usize,
    run: &HostRun,
    told: &mut CallReport,
) -> Result<()> {
    // SAFETY: the caller promises the crate's contract, here and below.
    let (mesh, options) = unsafe { (mollis_mesh2::read::<T>(mesh)?, options::read(options)?) };
    let (nodes, equation) = (mesh.nodes(), equation(&options)?);
    let (sources, masses) = (Input::new(sources, n_sources)?, Input::new(masses, n_sources)?);
    let targets = Input::new(targets, n_targets)?;
    let gradient = Output::optional(gradient, n_targets)?;
    let node_mass = Output::optional(node_mass, nodes)?;
    let node_potential = Output::optional(node_potential, nodes)?;
    let node_gradient = Output::optional(node_gradient, nodes)?;
    let total = Output::optional(total, 1)?;
    let outside = Output::optional(outside, 1)?;
    let memory = workspace(memory, bytes)?;
    disjoint(
        &[
            gradient.map(Output::range),
            node_mass.map(Output::range),
            node_potential.map(Output::range),
            node_gradient.map(Output::range),
            total.map(Output::range),
            outside.map(Output::range),
            Some(memory.range()),
            run.first_bad(),
        ],
        &[sources.range(), masses.range(), targets.range()],
    )?;
    // SAFETY: as above; outputs overlap nothing.
    let (sources, masses, targets) = unsafe { (sources.slice(), masses.slice(), targets.slice()) };
    run.enter(|run| {
        // SAFETY: as above.
        let memory = unsafe { memory.slice() };
        let mut grid = Grid::prepare(memory, mesh, equation, run.executor.workers())?;
        if !sources.iter().chain(targets).flatten().chain(masses).all(|v| v.is_finite()) {
            told.first_bad = first_bad(sources, masses)
                .or_else(|| first_bad::<T, 2>(targets, &[]).map(|index| sources.len().saturating_add(index)));
            return Err(Error::NotFinite);
        }
        let go_on = || if run.should_stop.is_some_and(|ask| ask()) { Err(Error::Stopped) } else { Ok(()) };
        grid.deposit(sources, masses, run.resources())?;
        go_on()?;
        if gradient.is_some() || node_potential.is_some() || node_gradient.is_some() {
            grid.solve(run.resources())?;
            go_on()?;
        } else {
            grid.locate_mass();
        }
        // SAFETY: as above, for each output.
        unsafe {
            if let Some(out) = gradient {
                grid.interpolate(targets, out.slice(), run.resources())?;
            }
            if let Some(out) = node_mass {
                grid.masses(out.slice())?;
            }
            if let Some(out) = node_potential {
                grid.potential(out.slice())?;
            }
            if let Some(out) = node_gradient {
                for (slot, &value) in out.slice().iter_mut().zip(grid.gradient()) {
                    *slot = value;
                }
            }
            if let Some(out) = total {
                let monopole = grid.monopole();
                let [x, y] = monopole.centre;
                out.slice().iter_mut().for_each(|slot| *slot = [monopole.mass, x, y]);
            }
            if let Some(out) = outside {
                out.slice().iter_mut().for_each(|slot| *slot = grid.outside());
            }
        }
        Ok(())
    })
}

/// The field of n_sources masses (any sign) on a mesh: u = sum_j masses[j] V(x - sources[j]), V = log r / (2 pi), or -K0(k r) / (2 pi) with
/// screening k. Cloud-in-cell deposit in 64-bit fixed point, the five-point scheme solved exactly, bilinear interpolation of its centred
/// differences (Zhelezov & Fatkullin, (3.6) to (3.10), whose c is -u); or the scheme of fourth order, see mollis_grid2_options.
///
/// Masses are rounded to a unit between 2^-50 and 2^-49 of the sum of |masses|, four shares each: beside the others a mass below 2^-51 =
/// 4.4e-16 of that sum adds nothing, and one of 1e-12 has three digits. Of a source outside, the distance from the mesh's middle counts up to 1024 widths
/// of the mesh in the centre of mass.
///
/// Range: the sum of |masses| over a cell's width, and over the distance of a target outside, has to be in range; where it is not, gradients are infinite
/// or NaN.
///
/// | output            | shape        |                                                                                  |
/// |-------------------|--------------|----------------------------------------------------------------------------------|
/// | gradient          | n_targets, 2 | grad u at the targets; outside the mesh that of all mass at its centre            |
/// | node_mass         | nodes        | the mass at each node                                                            |
/// | node_potential    | nodes        | u at the nodes; with order 4 sharpened for interpolation                          |
/// | node_gradient     | nodes, 2     | its differences                                                                  |
/// | total             | 3            | total mass and its centre                                                        |
/// | outside           | 1            | sources outside the mesh (on its border they are inside); they act through the total mass only |
///
/// Each output is overwritten, null is "not wanted"; what no output needs is not computed. The bits do not depend on the order of the
/// sources, on the executor or on the level. The workspace is scratch, of mollis_grid2_workspace_bytes.
///
/// Refused, with nothing written: the errors of mollis_grid2_workspace_bytes, MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_MISALIGNED,
/// MOLLIS_ERR_OVERLAP, MOLLIS_ERR_NOT_FINITE (run->first_bad: sources, then targets). MOLLIS_ERR_STOPPED, MOLLIS_ERR_EXECUTOR, the executor's
/// own: outputs are then undefined.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_grid2_eval(
    mesh: *const mollis_mesh2,
    options: *const mollis_grid2_options,
    n_sources: usize,
    sources: *const [f64; 2],
    masses: *const f64,
    n_targets: usize,
    targets: *const [f64; 2],
    gradient: *mut [f64; 2],
    node_mass: *mut f64,
    node_potential: *mut f64,
    node_gradient: *mut [f64; 2],
    total: *mut [f64; 3],
    outside: *mut u64,
    workspace: *mut c_void,
    bytes: usize,
    run: *const mollis_run,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe {
        with_run(run, |host, told| {
            eval(
                mesh,
                options,
                n_sources,
                sources,
                masses,
                n_targets,
                targets,
                gradient,
                node_mass,
                node_potential,
                node_gradient,
                total,
                outside,
                workspace,
                bytes,
                host,
                told,
            )
        })
    }
}

/// As mollis_grid2_eval, in single precision.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_grid2_eval_f32(
    mesh: *const mollis_mesh2,
    options: *const mollis_grid2_options,
    n_sources: usize,
    sources: *const [f32; 2],
    masses: *const f32,
    n_targets: usize,
    targets: *const [f32; 2],
    gradient: *mut [f32; 2],
    node_mass: *mut f32,
    node_potential: *mut f32,
    node_gradient: *mut [f32; 2],
    total: *mut [f32; 3],
    outside: *mut u64,
    workspace: *mut c_void,
    bytes: usize,
    run: *const mollis_run,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    unsafe {
        with_run(run, |host, told| {
            eval(
                mesh,
                options,
                n_sources,
                sources,
                masses,
                n_targets,
                targets,
                gradient,
                node_mass,
                node_potential,
                node_gradient,
                total,
                outside,
                workspace,
                bytes,
                host,
                told,
            )
        })
    }
}
