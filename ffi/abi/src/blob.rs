//! The blob method: sizes and runs.

use core::ffi::c_void;
use core::ptr::null_mut;

use mollis_core::blob::{self, Advance, Progress, Report, State, Trajectories, Wanted};
use mollis_core::field;
use mollis_core::kernel::Kernel;
use mollis_core::space::Plain;
use mollis_core::{Error, Real, Result};

use crate::buffers::{Input, Output, disjoint, workspace};
use crate::options::{self, Options};
use crate::run::{HostRun, mollis_run};
use crate::status::{mollis_status, status};

/// The step will be given densities to advance.
pub const MOLLIS_BLOB_DENSITY: u32 = 1;
/// The step will be asked for velocities.
pub const MOLLIS_BLOB_VELOCITY: u32 = 2;
/// The step will be asked for the velocity's divergence.
pub const MOLLIS_BLOB_DIVERGENCE: u32 = 4;

/// `first_bad` of a report when no value is bad.
pub const MOLLIS_BLOB_NONE_BAD: u64 = u64::MAX;

/// How a run of the blob method is done. Fill it with `mollis_blob_options_init`; null means the defaults.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_blob_options {
    /// Bytes of this structure, as `mollis_blob_options_init` sets it.
    pub size: u32,
    /// Nonzero: watch the regularised energy, and stop with `MOLLIS_ERR_ENERGY_ROSE` when it rises beyond rounding. Default 0.
    pub watch_energy: i32,
    /// The relative error that field sums may spend for speed; 0 (the default) asks for rounding alone.
    pub tolerance: f64,
    /// Called after each step with the number of steps completed in this call and the call's own arrays (`double (*)[D]`
    /// or `float (*)[D]`; `density` is null if none is advanced), to be read through these pointers and not written.
    /// Nonzero stops the run with `MOLLIS_ERR_STOPPED`. May be null.
    pub after_step: Option<
        unsafe extern "C" fn(
            context: *mut c_void,
            steps: usize,
            positions: *const c_void,
            density: *const c_void,
        ) -> i32,
    >,
    /// Passed to `after_step`.
    pub context: *mut c_void,
}

// SAFETY: `repr(C)`, the size first; any prefix may be replaced by what an older caller wrote.
unsafe impl Options for mollis_blob_options {
    const DEFAULT: Self = Self {
        size: size_of::<Self>() as u32,
        watch_energy: 0,
        tolerance: 0.0,
        after_step: None,
        context: core::ptr::null_mut(),
    };
}

/// What a run says about itself. Written by every step that got as far as reading its arrays, also when it then refuses or
/// stops.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_blob_report {
    /// Steps completed in this call: the state in the arrays is the one after them.
    pub steps: u64,
    /// With `MOLLIS_ERR_NOT_FINITE`: the index of the first particle with a coordinate, mass or density that is not finite
    /// (tracers count after the particles); else `MOLLIS_BLOB_NONE_BAD`.
    pub first_bad: u64,
    /// The regularised energy before the first step; NaN if not watched.
    pub energy_first: f64,
    /// The last energy computed; NaN if not watched.
    pub energy_last: f64,
}

/// Fills `options` with the defaults. `size` is `sizeof *options`.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_blob_options_init(options: *mut mollis_blob_options, size: usize) -> mollis_status {
    // SAFETY: this function's own contract.
    status(unsafe { options::init(options, size) })
}

/// The options, checked.
fn read_options(options: *const mollis_blob_options) -> Result<mollis_blob_options> {
    // SAFETY: the callers' contract.
    let options = unsafe { options::read(options) }?;
    if !Real::is_finite(options.tolerance) {
        return Err(Error::NotFinite);
    }
    // By its bits, as a comparison of doubles is a function where there are none: negative and not -0.
    if options.tolerance.to_bits() > (-0.0_f64).to_bits() { Err(Error::OutOfDomain) } else { Ok(options) }
}

fn field_options(options: &mollis_blob_options) -> field::Options {
    field::Options { tolerance: options.tolerance, ..field::Options::default() }
}

/// The arguments of a size query.
struct Query {
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    tracers: usize,
    wanted: u32,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    bytes: *mut usize,
}

impl Query {
    fn answer<T: Real, const D: usize>(self) -> Result<()> {
        let kernel = Input::<u8>::new(self.kernel.cast(), self.kernel_bytes)?;
        let bytes = Output::new(self.bytes, 1)?;
        disjoint(&[Some(bytes.range())], &[kernel.range()])?;
        let options = read_options(self.options)?;
        if self.wanted > MOLLIS_BLOB_DENSITY | MOLLIS_BLOB_VELOCITY | MOLLIS_BLOB_DIVERGENCE {
            return Err(Error::UnknownValue);
        }
        let has = |flag: u32| self.wanted & flag != 0;
        let wanted = Wanted {
            density: has(MOLLIS_BLOB_DENSITY),
            velocity: has(MOLLIS_BLOB_VELOCITY),
            divergence: has(MOLLIS_BLOB_DIVERGENCE),
            energy: options.watch_energy != 0,
        };
        // SAFETY: the contract of the extern functions.
        let (host, kernel) = unsafe { (HostRun::read(self.run)?, Kernel::<T, D>::open(kernel.slice())?) };
        let plan = blob::plan(&kernel, self.n, self.tracers, wanted, &field_options(&options))?;
        let answer = plan.workspace_bytes::<T, D>(host.workers())?;
        // SAFETY: as above.
        unsafe { bytes.slice() }.fill(answer);
        Ok(())
    }
}

/// The arguments of a step.
struct Call<T, const D: usize> {
    kernel: *const c_void,
    kernel_bytes: usize,
    n: usize,
    masses: *const T,
    positions: *mut [T; D],
    density: *mut T,
    velocity: *mut [T; D],
    divergence: *mut T,
    tracers: usize,
    tracer_positions: *mut [T; D],
    tracer_density: *mut T,
    tracer_velocity: *mut [T; D],
    dt: f64,
    steps: usize,
    options: *const mollis_blob_options,
    run: *const mollis_run,
    report: *mut mollis_blob_report,
    workspace: *mut c_void,
    workspace_bytes: usize,
}

impl<T: Real, const D: usize> Call<T, D>
where
    [T; D]: Plain,
{
    fn step(self) -> Result<()> {
        let n = self.n;
        let all = self.all()?;
        let kernel = Input::<u8>::new(self.kernel.cast(), self.kernel_bytes)?;
        let masses = Input::new(self.masses, n)?;
        let positions = Output::new(self.positions, n)?;
        let density = Output::optional(self.density, n)?;
        let velocity = Output::optional(all.velocity, n)?;
        let divergence = Output::optional(all.divergence, n)?;
        let tracer_positions = Output::new(all.tracer_positions, all.tracers)?;
        let tracer_density = Output::optional(all.tracer_density, all.tracers)?;
        let tracer_velocity = Output::optional(all.tracer_velocity, all.tracers)?;
        // The report is four numbers of eight bytes; as such it takes part in the overlap check.
        let report = Output::optional(self.report.cast::<u64>(), size_of::<mollis_blob_report>() / 8)?;
        let workspace = workspace(self.workspace, self.workspace_bytes)?;
        let inputs = [kernel.range(), masses.range()];
        let always =
            [Some(workspace.range()), Some(positions.range()), density.map(Output::range), report.map(Output::range)];
        if cfg!(feature = "small") {
            disjoint(&always, &inputs)?;
        } else {
            let [workspace, positions, density, report] = always;
            let outputs = [
                positions,
                density,
                velocity.map(Output::range),
                divergence.map(Output::range),
                Some(tracer_positions.range()),
                tracer_density.map(Output::range),
                tracer_velocity.map(Output::range),
                report,
                workspace,
            ];
            disjoint(&outputs, &inputs)?;
        }
        let options = read_options(self.options)?;
        if cfg!(feature = "small") && options.after_step.is_some() {
            return Err(Error::Unsupported);
        }
        // SAFETY: the contract of the extern functions.
        let (host, kernel) = unsafe { (HostRun::read(self.run)?, Kernel::<T, D>::open(kernel.slice())) };
        // Looked at where it is: moving it out would take its size of the stack once more.
        let kernel = kernel.as_ref().map_err(|&error| error)?;
        // With no tracers the particles alone decide whether densities are advanced.
        if all.tracers > 0 && density.is_some() != tracer_density.is_some() {
            return Err(Error::LengthMismatch);
        }
        let wanted = Wanted {
            density: density.is_some(),
            velocity: velocity.is_some() || tracer_velocity.is_some(),
            divergence: divergence.is_some(),
            energy: options.watch_energy != 0,
        };
        let plan = blob::plan(kernel, n, all.tracers, wanted, &field_options(&options));
        let plan = plan.as_ref().map_err(|&error| error)?;
        // SAFETY: the contract of the extern functions; all ranges are disjoint.
        let state = unsafe {
            State {
                masses: masses.slice(),
                particles: Trajectories {
                    positions: positions.slice(),
                    density: density.map(|d| d.slice()),
                    velocity: velocity.map(|v| v.slice()),
                    divergence: divergence.map(|d| d.slice()),
                },
                tracers: Trajectories {
                    positions: tracer_positions.slice(),
                    density: tracer_density.filter(|_| wanted.density).map(|d| d.slice()),
                    velocity: tracer_velocity.map(|v| v.slice()),
                    divergence: None,
                },
            }
        };
        // SAFETY: as above.
        let scratch = unsafe { workspace.slice() };
        let mut after_step = |progress: Progress<'_, T, D>| {
            let Some(call) = options.after_step else { return true };
            let density = progress.density.map_or(core::ptr::null(), |d| d.as_ptr().cast());
            // SAFETY: the host's function, with its own context and pointers alive during the call.
            unsafe { call(options.context, progress.steps, progress.positions.as_ptr().cast(), density) == 0 }
        };
        let mut advance = Advance { dt: T::from_wide(self.dt), steps: self.steps, after_step: None };
        if cfg!(not(feature = "small")) {
            advance.after_step = Some(&mut after_step);
        }
        let mut said = Report::default();
        let result = host.enter(|run| blob::step(plan, kernel, state, advance, scratch, run, &mut said));
        if report.is_some() {
            let (energy_first, energy_last) = said.energy.unwrap_or((f64::NAN, f64::NAN));
            let first_bad = said.first_bad.map_or(MOLLIS_BLOB_NONE_BAD, |k| k as u64);
            let told = mollis_blob_report { steps: said.steps as u64, first_bad, energy_first, energy_last };
            // SAFETY: checked above as an output of this size and alignment.
            unsafe { self.report.write(told) };
        }
        result
    }

    /// What is beside the particles. With the feature `small` there is none, and whoever asks for it is refused.
    fn all(&self) -> Result<Beside<T, D>> {
        let none = Beside {
            velocity: null_mut(),
            divergence: null_mut(),
            tracers: 0,
            tracer_positions: null_mut(),
            tracer_density: null_mut(),
            tracer_velocity: null_mut(),
        };
        let &Self { velocity, divergence, tracers, tracer_positions, tracer_density, tracer_velocity, .. } = self;
        if cfg!(not(feature = "small")) {
            return Ok(Beside { velocity, divergence, tracers, tracer_positions, tracer_density, tracer_velocity });
        }
        // Without tracers their arrays are empty, wherever they are.
        if tracers > 0 || !velocity.is_null() || !divergence.is_null() { Err(Error::Unsupported) } else { Ok(none) }
    }
}

/// Tracers, and what is wanted at the end.
struct Beside<T, const D: usize> {
    velocity: *mut [T; D],
    divergence: *mut T,
    tracers: usize,
    tracer_positions: *mut [T; D],
    tracer_density: *mut T,
    tracer_velocity: *mut [T; D],
}

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
    status(call.step())
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
    status(call.step())
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
/// A refused call writes nothing but `report`. A run that stops (`MOLLIS_ERR_BECAME_NOT_FINITE`, `MOLLIS_ERR_STOPPED`,
/// `MOLLIS_ERR_ENERGY_ROSE`) leaves positions and densities as they were after the last completed step, and velocity and
/// divergence unwritten.
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
    status(call.step())
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
    status(call.step())
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
    status(call.step())
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
    status(call.step())
}
