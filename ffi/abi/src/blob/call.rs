//! The arguments of a call: checked, then answered.

use core::ffi::c_void;
use core::ptr::null_mut;

use mollis_core::aggregation::{self, Advance, Progress, Report, State, Trajectories, Wanted};
use mollis_core::build;
use mollis_core::kernel::Kernel;
use mollis_core::memory::Plain;
use mollis_core::{Error, Real, Result};

use super::options::{
    MOLLIS_BLOB_DENSITY, MOLLIS_BLOB_DIVERGENCE, MOLLIS_BLOB_NONE_BAD, MOLLIS_BLOB_VELOCITY, field_options,
    mollis_blob_options, mollis_blob_report, read_options,
};
use crate::buffers::{Input, Output, disjoint, workspace};
use crate::run::{CallReport, HostRun, mollis_run, with_run};
use crate::status::mollis_status;

/// The arguments of a size query.
pub struct Query {
    pub kernel: *const c_void,
    pub kernel_bytes: usize,
    pub n: usize,
    pub tracers: usize,
    pub wanted: u32,
    pub options: *const mollis_blob_options,
    pub run: *const mollis_run,
    pub bytes: *mut usize,
}

impl Query {
    pub fn answer<T: Real, const D: usize>(self) -> Result<()> {
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
        let plan = aggregation::plan(&kernel, self.n, self.tracers, wanted, &field_options(&options))?;
        let answer = plan.workspace_bytes::<T, D>(host.workers())?;
        // SAFETY: as above.
        unsafe { bytes.slice() }.fill(answer);
        Ok(())
    }
}

/// The arguments of a step.
pub struct Call<T, const D: usize> {
    pub kernel: *const c_void,
    pub kernel_bytes: usize,
    pub n: usize,
    pub masses: *const T,
    pub positions: *mut [T; D],
    pub density: *mut T,
    pub velocity: *mut [T; D],
    pub divergence: *mut T,
    pub tracers: usize,
    pub tracer_positions: *mut [T; D],
    pub tracer_density: *mut T,
    pub tracer_velocity: *mut [T; D],
    pub dt: f64,
    pub steps: usize,
    pub options: *const mollis_blob_options,
    pub run: *const mollis_run,
    pub report: *mut mollis_blob_report,
    pub workspace: *mut c_void,
    pub workspace_bytes: usize,
}

impl<T: Real, const D: usize> Call<T, D>
where
    [T; D]: Plain,
{
    pub fn step(self) -> mollis_status {
        // SAFETY: the contract of the extern functions.
        unsafe { with_run(self.run, |host, told| self.advance(host, told)) }
    }

    fn advance(&self, host: &HostRun, told: &mut CallReport) -> Result<()> {
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
        let always = [
            Some(workspace.range()),
            Some(positions.range()),
            density.map(Output::range),
            report.map(Output::range),
            host.first_bad(),
        ];
        if !build::TRACERS {
            disjoint(&always, &inputs)?;
        } else {
            let [workspace, positions, density, report, bad] = always;
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
                bad,
            ];
            disjoint(&outputs, &inputs)?;
        }
        let options = read_options(self.options)?;
        if !build::AFTER_STEP && options.after_step.is_some() {
            return Err(Error::Unsupported);
        }
        // SAFETY: the contract of the extern functions.
        let kernel = unsafe { Kernel::<T, D>::open(kernel.slice()) };
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
        let plan = aggregation::plan(kernel, n, all.tracers, wanted, &field_options(&options));
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
        if build::AFTER_STEP {
            advance.after_step = Some(&mut after_step);
        }
        let mut said = Report::default();
        let result = host.enter(|run| aggregation::step(plan, kernel, state, advance, scratch, run, &mut said));
        told.first_bad = said.first_bad;
        if report.is_some() {
            let (energy_first, energy_last) = said.energy.unwrap_or((f64::NAN, f64::NAN));
            let first_bad = said.first_bad.map_or(MOLLIS_BLOB_NONE_BAD, |k| k as u64);
            let told = mollis_blob_report { steps: said.steps as u64, first_bad, energy_first, energy_last };
            // SAFETY: checked above as an output of this size and alignment.
            unsafe { self.report.write(told) };
        }
        result
    }

    /// Tracers and outputs at the end, if this build has them.
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
        if build::TRACERS {
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
