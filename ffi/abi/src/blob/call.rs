//! The arguments of a call: checked, then answered.

use core::ffi::c_void;

use mollis_core::aggregation::{self, Advance, Plan, Progress, Report, State, Trajectories, Wanted};
use mollis_core::build;
use mollis_core::kernel::Kernel;
use mollis_core::memory::{Carve, Measure, Plain, Space};
use mollis_core::{Error, Real, Result};

use super::arrays::Arrays;
use super::options::{diffusion, field_options, mollis_blob_options, mollis_blob_report, read_options};
use super::particles::ParticlesOf;
use crate::buffers::{Input, Output, aligned, disjoint, with_slack};
use crate::first_bad::MOLLIS_NONE_BAD;
use crate::run::{CallReport, HostRun, mollis_run, with_run};
use crate::status::mollis_status;

/// What size query and step are both given.
#[derive(Clone, Copy)]
pub(crate) struct Ask<T, const D: usize> {
    pub kernel: *const c_void,
    pub kernel_bytes: usize,
    pub particles: *const ParticlesOf<T, D>,
    pub tracers: *const ParticlesOf<T, D>,
    pub options: *const mollis_blob_options,
    pub run: *const mollis_run,
}

/// What a step is given besides.
#[derive(Clone, Copy)]
pub(crate) struct Step {
    pub dt: f64,
    pub steps: usize,
    pub workspace: *mut c_void,
    pub workspace_bytes: usize,
    pub report: *mut mollis_blob_report,
}

/// All arguments, checked as far as sizes and addresses go.
struct Checked<T, const D: usize> {
    particles: Arrays<T, D>,
    tracers: Option<Arrays<T, D>>,
    options: mollis_blob_options,
}

impl<T: Real, const D: usize> Checked<T, D>
where
    [T; D]: Plain,
{
    fn plan(&self, kernel: &Kernel<'_, T, D>) -> Result<Plan> {
        let (particles, tracers) = (&self.particles, self.tracers.as_ref());
        let n_tracers = tracers.map_or(0, |tracers| tracers.n);
        // With no tracers the particles alone decide whether densities are advanced.
        let ours = particles.wanted();
        let theirs = tracers.map(Arrays::wanted).unwrap_or_default();
        if n_tracers > 0 && theirs.density != ours.density {
            return Err(Error::LengthMismatch);
        }
        let velocity = ours.velocity || theirs.velocity;
        let wanted = Wanted { velocity, energy: self.options.watch_energy != 0, ..ours };
        let options = field_options(&self.options);
        let plan = aggregation::plan(kernel, particles.n, n_tracers, wanted, &options)?;
        match diffusion(&self.options)? {
            Some(diffusion) => plan.with_diffusion::<T, D>(&diffusion, &options),
            None => Ok(plan),
        }
    }

    /// Bytes of the step's own workspace, and of the whole with copies of arrays that have gaps, wherever it begins.
    fn bytes(&self, plan: &Plan, workers: usize) -> Result<[usize; 2]> {
        let own = plan.workspace_bytes::<T, D>(workers)?;
        let all = Measure::of(|space| {
            self.particles.layout(space)?;
            self.tracers.as_ref().map_or(Ok(()), |tracers| tracers.layout(space).map(|_| ()))?;
            space.try_array::<u8>(own).map(|_| ())
        })?;
        Ok([own, with_slack(all)?])
    }
}

impl<T: Real, const D: usize> Ask<T, D>
where
    [T; D]: Plain,
{
    /// # Safety
    /// The crate's contract.
    unsafe fn check(&self) -> Result<Checked<T, D>> {
        // SAFETY: passed on.
        unsafe {
            let particles = Arrays::read(self.particles, false)?;
            let tracers = if self.tracers.is_null() { None } else { Some(Arrays::read(self.tracers, true)?) };
            Ok(Checked { particles, tracers, options: read_options(self.options)? })
        }
    }

    /// # Safety
    /// The crate's contract.
    pub(crate) unsafe fn bytes(self, bytes: *mut usize) -> Result<()> {
        let (kernel, bytes) = (Input::<u8>::new(self.kernel.cast(), self.kernel_bytes)?, Output::new(bytes, 1)?);
        disjoint(&[Some(bytes.range())], &[kernel.range()])?;
        // SAFETY: passed on.
        let (checked, host, kernel) =
            unsafe { (self.check()?, HostRun::read(self.run)?, Kernel::<T, D>::open(kernel.slice())?) };
        let [_, needed] = checked.bytes(&checked.plan(&kernel)?, host.workers())?;
        // SAFETY: passed on.
        unsafe { bytes.slice() }.fill(needed);
        Ok(())
    }

    /// # Safety
    /// The crate's contract.
    pub(crate) unsafe fn step(self, step: Step) -> mollis_status {
        // SAFETY: passed on.
        unsafe { with_run(self.run, |host, told| self.advance(&step, host, told)) }
    }

    /// # Safety
    /// The crate's contract.
    unsafe fn advance(&self, step: &Step, host: &HostRun, told: &mut CallReport) -> Result<()> {
        // SAFETY: passed on.
        let checked = unsafe { self.check()? };
        let kernel = Input::<u8>::new(self.kernel.cast(), self.kernel_bytes)?;
        let workspace = Output::new(step.workspace.cast::<u8>(), step.workspace_bytes)?;
        // The report is four numbers of eight bytes; as such it takes part in the overlap check.
        let report = Output::optional(step.report.cast::<u64>(), size_of::<mollis_blob_report>() / 8)?;
        let [bad, needed] = host.outputs();
        let outputs = [Some(workspace.range()), report.map(Output::range), bad, needed];
        let structure =
            |pointer: *const ParticlesOf<T, D>| Input::new(pointer.cast::<u8>(), size_of::<ParticlesOf<T, D>>());
        let ours = structure(self.particles)?;
        let theirs = if self.tracers.is_null() { ours } else { structure(self.tracers)? };
        Arrays::check(
            &checked.particles,
            checked.tracers.as_ref(),
            &outputs,
            &[kernel.range(), ours.range(), theirs.range()],
        )?;
        if !build::AFTER_STEP && checked.options.after_step.is_some() {
            return Err(Error::Unsupported);
        }
        // SAFETY: passed on.
        let kernel = unsafe { Kernel::<T, D>::open(kernel.slice()) };
        // Looked at where it is: moving it out would take its size of the stack once more.
        let kernel = kernel.as_ref().map_err(|&error| error)?;
        let plan = checked.plan(kernel);
        let plan = plan.as_ref().map_err(|&error| error)?;
        let [own, needed] = checked.bytes(plan, host.workers())?;
        if step.workspace_bytes < needed {
            return told.too_small(needed);
        }
        // SAFETY: passed on; nothing overlaps.
        let mut space = Carve::reopen(aligned(unsafe { workspace.slice() }))?;
        let (particles, tracers) = (&checked.particles, checked.tracers.as_ref());
        let mut copies = particles.layout(&mut space)?;
        let mut of_tracers = tracers.map(|tracers| tracers.layout(&mut space)).transpose()?;
        let scratch = space.try_array(own)?;
        // SAFETY: as above.
        let state = unsafe {
            let (masses, particles) = particles.state(&mut copies);
            let tracers = match (tracers, &mut of_tracers) {
                (Some(tracers), Some(copies)) => tracers.state(copies).1,
                _ => Trajectories::none(),
            };
            let density = tracers.density.filter(|_| particles.density.is_some());
            State { masses, particles, tracers: Trajectories { density, ..tracers } }
        };
        let options = &checked.options;
        let mut after_step = |progress: Progress<'_, T, D>| {
            let Some(call) = options.after_step else { return true };
            let density = progress.density.map_or(core::ptr::null(), |d| d.as_ptr().cast());
            // SAFETY: the host's function, with its own context and pointers alive during the call.
            unsafe { call(options.context, progress.steps, progress.positions.as_ptr().cast(), density) == 0 }
        };
        let mut advance = Advance { dt: T::from_wide(step.dt), steps: step.steps, after_step: None };
        if build::AFTER_STEP {
            advance.after_step = Some(&mut after_step);
        }
        let mut said = Report::default();
        let result = host.enter(|run| aggregation::step(plan, kernel, state, advance, scratch, run, &mut said));
        // SAFETY: as above; the state is no longer used. A refused call left the copies, and so what is written, as they were.
        unsafe {
            particles.scatter(&copies, result.is_ok());
            if let (Some(tracers), Some(copies)) = (tracers, &of_tracers) {
                tracers.scatter(copies, result.is_ok());
            }
        }
        told.first_bad = said.first_bad;
        if report.is_some() {
            let (energy_first, energy_last) = said.energy.unwrap_or((f64::NAN, f64::NAN));
            let first_bad = said.first_bad.map_or(MOLLIS_NONE_BAD, |k| k as u64);
            let told = mollis_blob_report { steps: said.steps as u64, first_bad, energy_first, energy_last };
            // SAFETY: checked above as an output of this size and alignment.
            unsafe { step.report.write(told) };
        }
        result
    }
}
