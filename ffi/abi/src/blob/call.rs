//! The arguments of a call: checked, then answered.

use core::ffi::c_void;

use mollis_core::aggregation::{self, Advance, Plan, Progress, Report, State, Trajectories, Wanted};
use mollis_core::build;
use mollis_core::kernel::Kernel;
use mollis_core::memory::{Carve, Measure, Plain, Space};
use mollis_core::{Error, Real, Result};

use super::options::{field_options, mollis_blob_options, mollis_blob_report, read_options};
use crate::arrays::{Column, Extents, Points, Way, apart, fetch, of_structure};
use crate::buffers::{Input, Output, aligned, with_slack};
use crate::first_bad::MOLLIS_NONE_BAD;
use crate::run::{CallReport, HostRun, mollis_run, with_run};
use crate::status::mollis_status;

/// The layout of `mollis_particles1` and the like, which say what the members are.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "they stand where C programs read them")]
pub struct ParticlesOf<T, const D: usize> {
    pub n: usize,
    pub positions: [*mut T; D],
    pub stride: usize,
    pub masses: *const T,
    pub mass_stride: usize,
    pub density: *mut T,
    pub density_stride: usize,
    pub velocity: [*mut T; D],
    pub velocity_stride: usize,
    pub divergence: *mut T,
    pub divergence_stride: usize,
}

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

/// The arrays of particles or of tracers, checked.
struct Arrays<T, const D: usize> {
    n: usize,
    positions: Points<T, D>,
    /// None of tracers.
    masses: Option<Column<T>>,
    density: Option<Column<T>>,
    velocity: Option<Points<T, D>>,
    divergence: Option<Column<T>>,
}

/// Arrays of the workspace in place of a caller's that have gaps.
struct Copies<'w, T, const D: usize> {
    positions: &'w mut [[T; D]],
    masses: &'w mut [T],
    density: &'w mut [T],
    velocity: &'w mut [[T; D]],
    divergence: &'w mut [T],
}

impl<T: Real, const D: usize> Arrays<T, D>
where
    [T; D]: Plain,
{
    /// # Safety
    /// The crate's contract for the structure.
    unsafe fn read(given: *const ParticlesOf<T, D>, massless: bool) -> Result<Self> {
        // SAFETY: passed on.
        let given = unsafe { fetch(given)? };
        let n = given.n;
        if massless && !given.divergence.is_null() {
            return Err(Error::Unsupported);
        }
        let arrays = Self {
            n,
            positions: Points::new(given.positions, given.stride, n)?,
            masses: if massless { None } else { Some(Column::new(given.masses.cast_mut(), given.mass_stride, n)?) },
            density: Column::optional(given.density, given.density_stride, n)?,
            velocity: Points::optional(given.velocity, given.velocity_stride, n)?,
            divergence: Column::optional(given.divergence, given.divergence_stride, n)?,
        };
        let beside = arrays.velocity.is_some() || arrays.divergence.is_some();
        let gaps = !build::STRIDES && !arrays.is_dense();
        if gaps || !build::TRACERS && (massless || beside) { Err(Error::Unsupported) } else { Ok(arrays) }
    }

    fn is_dense(&self) -> bool {
        let columns = [self.masses, self.density, self.divergence];
        self.positions.is_dense()
            && columns.iter().flatten().all(Column::is_dense)
            && self.velocity.is_none_or(|velocity| velocity.is_dense())
    }

    fn extents(&self, outputs: &mut Extents, inputs: &mut Extents) {
        outputs.add(self.positions.extents()).add(self.density.map(|c| c.extent()));
        outputs.add(self.velocity.iter().flat_map(Points::extents)).add(self.divergence.map(|c| c.extent()));
        inputs.add(self.masses.map(|c| c.extent()));
    }

    fn layout<'w>(&self, space: &mut impl Space<'w>) -> Result<Copies<'w, T, D>> {
        let unless = |dense: bool| if dense { 0 } else { self.n };
        let column = |column: Option<Column<T>>| unless(column.is_none_or(|c| c.is_dense()));
        Ok(Copies {
            positions: space.try_array(unless(self.positions.is_dense()))?,
            masses: space.try_array(column(self.masses))?,
            density: space.try_array(column(self.density))?,
            velocity: space.try_array(unless(self.velocity.is_none_or(|v| v.is_dense())))?,
            divergence: space.try_array(column(self.divergence))?,
        })
    }

    /// The masses, and what is advanced or wanted: the caller's arrays, or copies of them.
    ///
    /// # Safety
    /// The crate's contract for the arrays, which overlap nothing.
    unsafe fn state<'a>(&self, copies: &'a mut Copies<'_, T, D>) -> (&'a [T], Trajectories<'a, T, D>) {
        // SAFETY: passed on.
        unsafe {
            if build::STRIDES {
                if !self.positions.is_dense() {
                    self.positions.gather(copies.positions);
                }
                if let Some(masses) = self.masses.filter(|masses| !masses.is_dense()) {
                    masses.gather(copies.masses);
                }
                if let Some(density) = self.density.filter(|density| !density.is_dense()) {
                    density.gather(copies.density);
                }
            }
            let column =
                |column: Column<T>, copy: &'a mut [T]| if column.is_dense() { column.array_mut() } else { copy };
            let points = |points: Points<T, D>, copy: &'a mut [[T; D]]| {
                if points.is_dense() { points.array_mut() } else { copy }
            };
            let masses = match self.masses {
                Some(masses) if masses.is_dense() => masses.array(),
                _ => copies.masses,
            };
            let trajectories = Trajectories {
                positions: points(self.positions, copies.positions),
                density: self.density.map(|density| column(density, copies.density)),
                velocity: self.velocity.map(|velocity| points(velocity, copies.velocity)),
                divergence: self.divergence.map(|divergence| column(divergence, copies.divergence)),
            };
            (masses, trajectories)
        }
    }

    /// Brings copies back to the caller; velocities and divergences only if `finished`.
    ///
    /// # Safety
    /// As [`Arrays::state`], whose results are no longer used.
    unsafe fn scatter(&self, copies: &Copies<'_, T, D>, finished: bool) {
        let columns = [(self.density, &*copies.density), (self.divergence.filter(|_| finished), &*copies.divergence)];
        let points =
            [(Some(self.positions), &*copies.positions), (self.velocity.filter(|_| finished), &*copies.velocity)];
        // SAFETY: passed on.
        unsafe {
            for (column, copy) in columns {
                if let Some(column) = column.filter(|column| !column.is_dense()) {
                    column.scatter(copy.iter().copied(), Way::PLAIN);
                }
            }
            for (points, copy) in points {
                if let Some(points) = points.filter(|points| !points.is_dense()) {
                    points.scatter(copy, Way::PLAIN);
                }
            }
        }
    }
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
        if tracers.is_some_and(|tracers| tracers.n > 0 && tracers.density.is_some() != particles.density.is_some()) {
            return Err(Error::LengthMismatch);
        }
        let wanted = Wanted {
            density: particles.density.is_some(),
            velocity: particles.velocity.is_some() || tracers.is_some_and(|tracers| tracers.velocity.is_some()),
            divergence: particles.divergence.is_some(),
            energy: self.options.watch_energy != 0,
        };
        aggregation::plan(kernel, particles.n, n_tracers, wanted, &field_options(&self.options))
    }

    /// Bytes of the step's own workspace, and of the whole with copies of arrays that have gaps, wherever it begins.
    fn bytes(&self, plan: &Plan, workers: usize) -> Result<[usize; 2]> {
        let own = plan.workspace_bytes::<T, D>(workers)?;
        if !build::STRIDES {
            return Ok([own, with_slack(own)?]);
        }
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
        apart(&[bytes.range().into()], &[kernel.range().into()])?;
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
        let (mut outputs, mut inputs) = (Extents::new(), Extents::new());
        checked.particles.extents(&mut outputs, &mut inputs);
        checked.tracers.iter().for_each(|tracers| tracers.extents(&mut outputs, &mut inputs));
        outputs.add([workspace.range().into()]).add(report.map(|report| report.range().into()));
        outputs.add(host.outputs().into_iter().flatten().map(Into::into));
        inputs.add([kernel.range().into(), of_structure(self.particles)?]);
        if !self.tracers.is_null() {
            inputs.add([of_structure(self.tracers)?]);
        }
        apart(outputs.as_slice(), inputs.as_slice())?;
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
        if build::STRIDES {
            // SAFETY: as above; the state is no longer used. A refused call left the copies, and so what is written, as they were.
            unsafe {
                particles.scatter(&copies, result.is_ok());
                if let (Some(tracers), Some(copies)) = (tracers, &of_tracers) {
                    tracers.scatter(copies, result.is_ok());
                }
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
