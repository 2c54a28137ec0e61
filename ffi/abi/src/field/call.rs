//! The arguments of a sum: checked, then answered.

use core::ffi::{c_char, c_void};

use mollis_core::exec::{Run, Statistics};
use mollis_core::field::{self, Outputs, Plan, Sources, Wanted};
use mollis_core::kernel::Kernel;
use mollis_core::memory::{Carve, Measure, Plain, Space};
use mollis_core::{Error, Real, Result};

use super::options::{mollis_field_counts, mollis_field_options};
use crate::arrays::{Column, Extents, Matrices, Points, Way, apart, fetch, gathered, gathered_column, of_structure};
use crate::buffers::{Input, Output, aligned, with_slack};
use crate::first_bad::first_bad;
use crate::kernel::open;
use crate::options::read;
use crate::run::{CallReport, HostRun, mollis_run, with_run};
use crate::status::mollis_status;

/// The layout of `mollis_sources1` and the like, which say what the members are.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "they stand where C programs read them")]
pub struct SourcesOf<T, const D: usize> {
    pub n: usize,
    pub positions: [*const T; D],
    pub stride: usize,
    pub masses: *const T,
    pub mass_stride: usize,
    pub radii: *const T,
    pub radius_stride: usize,
    pub strengths: [*const T; D],
    pub strength_stride: usize,
}

/// The layout of `mollis_targets1` and the like.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "they stand where C programs read them")]
pub struct TargetsOf<T, const D: usize> {
    pub n: usize,
    pub positions: [*const T; D],
    pub stride: usize,
    pub radii: *const T,
    pub radius_stride: usize,
}

/// The layout of `mollis_outputs1` and the like.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "they stand where C programs read them")]
pub struct OutputsOf<T, const D: usize> {
    pub potential: *mut T,
    pub potential_stride: usize,
    pub gradient: [*mut T; D],
    pub gradient_stride: usize,
    pub laplacian: *mut T,
    pub laplacian_stride: usize,
    pub hessian: *mut T,
    pub hessian_stride: usize,
    pub factor: f64,
    pub add: i32,
    pub reserved: i32,
}

/// What every function of a sum is given, in this order.
#[derive(Clone, Copy)]
pub(crate) struct Ask<T, const D: usize> {
    pub kernel: *const c_void,
    pub kernel_bytes: usize,
    pub sources: *const SourcesOf<T, D>,
    pub targets: *const TargetsOf<T, D>,
    pub outputs: *const OutputsOf<T, D>,
    pub options: *const mollis_field_options,
}

/// The targets of a sum: the sources, if there are no points.
pub(crate) struct Places<T, const D: usize> {
    pub points: Option<Points<T, D>>,
    pub n: usize,
    pub radii: Option<Column<T>>,
}

/// The targets; for null the sources, whose number is given.
///
/// # Safety
/// The crate's contract for the structure.
pub(crate) unsafe fn read_targets<T: Real, const D: usize>(
    given: *const TargetsOf<T, D>,
    n_sources: usize,
) -> Result<Places<T, D>> {
    if given.is_null() {
        return Ok(Places { points: None, n: n_sources, radii: None });
    }
    // SAFETY: passed on.
    let TargetsOf { n, positions, stride, radii, radius_stride } = unsafe { fetch(given)? };
    let points = Points::new(positions.map(<*const T>::cast_mut), stride, n)?;
    Ok(Places { points: Some(points), n, radii: Column::optional(radii.cast_mut(), radius_stride, n)? })
}

/// The arrays of a sum, checked.
struct Arrays<T, const D: usize> {
    n: usize,
    positions: Points<T, D>,
    /// None with vector strengths.
    masses: Option<Column<T>>,
    radii: Option<Column<T>>,
    strengths: Option<Points<T, D>>,
    /// None: the sources.
    targets: Option<Points<T, D>>,
    n_targets: usize,
    target_radii: Option<Column<T>>,
    potential: Option<Column<T>>,
    gradient: Option<Points<T, D>>,
    laplacian: Option<Column<T>>,
    hessian: Option<Matrices<T, D>>,
    way: Way,
}

/// The workspace: arrays in which inputs are gathered and from which results are brought to the caller, where theirs have other strides, and the sum's own.
struct Scratch<'w, T, const D: usize> {
    positions: &'w mut [[T; D]],
    masses: &'w mut [T],
    radii: &'w mut [T],
    strengths: &'w mut [[T; D]],
    targets: &'w mut [[T; D]],
    target_radii: &'w mut [T],
    potential: &'w mut [T],
    gradient: &'w mut [[T; D]],
    laplacian: &'w mut [T],
    hessian: &'w mut [[[T; D]; D]],
    sum: &'w mut [u8],
}

impl<T: Real, const D: usize> Arrays<T, D>
where
    [T; D]: Plain,
{
    /// # Safety
    /// The crate's contract for the structures.
    unsafe fn read(ask: &Ask<T, D>) -> Result<Self> {
        // SAFETY: passed on.
        let (sources, outputs) = unsafe { (fetch(ask.sources)?, fetch(ask.outputs)?) };
        let n = sources.n;
        let of_sources = sources.positions.map(<*const T>::cast_mut);
        // SAFETY: passed on.
        let Places { points: targets, n: n_targets, radii: target_radii } = unsafe { read_targets(ask.targets, n)? };
        // 0 is a structure's member that was left alone.
        let factor = if outputs.factor.to_bits() << 1 == 0 { 1.0 } else { outputs.factor };
        if !mollis_core::Scalar::is_finite(factor) {
            return Err(Error::NotFinite);
        }
        let add = match outputs.add {
            0 => false,
            1 => true,
            _ => return Err(Error::UnknownValue),
        };
        let strengths = Points::optional(sources.strengths.map(<*const T>::cast_mut), sources.strength_stride, n)?;
        let masses = match strengths {
            Some(_) => None,
            None => Some(Column::new(sources.masses.cast_mut(), sources.mass_stride, n)?),
        };
        Ok(Self {
            n,
            positions: Points::new(of_sources, sources.stride, n)?,
            masses,
            strengths,
            radii: Column::optional(sources.radii.cast_mut(), sources.radius_stride, n)?,
            targets,
            n_targets,
            target_radii,
            potential: Column::optional(outputs.potential, outputs.potential_stride, n_targets)?,
            gradient: Points::optional(outputs.gradient, outputs.gradient_stride, n_targets)?,
            laplacian: Column::optional(outputs.laplacian, outputs.laplacian_stride, n_targets)?,
            hessian: Matrices::optional(outputs.hessian, outputs.hessian_stride, n_targets)?,
            way: Way { factor, add },
        })
    }

    fn wanted(&self) -> Wanted {
        Wanted {
            potential: self.potential.is_some(),
            gradient: self.gradient.is_some(),
            laplacian: self.laplacian.is_some(),
            hessian: self.hessian.is_some(),
        }
    }

    /// # Safety
    /// The crate's contract for the kernel and the options.
    unsafe fn plan<'k>(&self, ask: &Ask<T, D>) -> Result<(Plan, Kernel<'k, T, D>)> {
        // SAFETY: passed on.
        let (kernel, options) = unsafe { (open::<T, D>(ask.kernel, ask.kernel_bytes)?, read(ask.options)?) };
        let (radii, strengths) = (self.radii.is_some(), self.strengths.is_some());
        let options = field::Options { radii, strengths, ..options.to_core()? };
        Ok((field::plan(&kernel, self.n, self.n_targets, self.wanted(), &options)?, kernel))
    }

    /// The only statement of the layout.
    fn layout<'w>(&self, space: &mut impl Space<'w>, bytes: usize) -> Result<Scratch<'w, T, D>> {
        let plain = self.way.is_plain();
        // Where results are added or multiplied, they come from an array of the workspace too.
        let of = |copied: usize| if plain { copied } else { self.n_targets };
        Ok(Scratch {
            positions: space.try_array(self.positions.copied())?,
            masses: space.try_array(self.masses.as_ref().map_or(0, Column::copied))?,
            radii: space.try_array(self.radii.as_ref().map_or(0, Column::copied))?,
            strengths: space.try_array(self.strengths.as_ref().map_or(0, Points::copied))?,
            targets: space.try_array(self.targets.as_ref().map_or(0, Points::copied))?,
            target_radii: space.try_array(self.target_radii.as_ref().map_or(0, Column::copied))?,
            potential: space.try_array(self.potential.as_ref().map_or(0, |column| of(column.copied())))?,
            gradient: space.try_array(self.gradient.as_ref().map_or(0, |gradient| of(gradient.copied())))?,
            laplacian: space.try_array(self.laplacian.as_ref().map_or(0, |column| of(column.copied())))?,
            hessian: space.try_array(self.hessian.as_ref().map_or(0, |hessian| of(hessian.copied())))?,
            sum: space.try_array(bytes)?,
        })
    }

    /// Bytes of the workspace, wherever it begins.
    fn bytes(&self, plan: &Plan, workers: usize) -> Result<usize> {
        let own = plan.workspace_bytes(workers)?;
        let bytes = Measure::of(|space| self.layout(space, own).map(|_| ()))?;
        with_slack(bytes)
    }

    /// All arrays of the caller's.
    fn extents(&self, ask: &Ask<T, D>) -> Result<(Extents, Extents)> {
        let (mut outputs, mut inputs) = (Extents::new(), Extents::new());
        outputs.add(self.potential.map(|c| c.extent())).add(self.laplacian.map(|c| c.extent()));
        outputs.add(self.gradient.iter().flat_map(Points::extents)).add(self.hessian.map(|h| h.extent()));
        inputs.add(self.positions.extents()).add(self.masses.map(|c| c.extent())).add(self.radii.map(|c| c.extent()));
        inputs.add(self.strengths.iter().flat_map(Points::extents));
        inputs.add(self.targets.iter().flat_map(Points::extents)).add(self.target_radii.map(|c| c.extent()));
        inputs.add([Input::new(ask.kernel.cast::<u8>(), ask.kernel_bytes)?.range().into()]);
        inputs.add([of_structure(ask.sources)?, of_structure(ask.outputs)?]);
        if !ask.targets.is_null() {
            inputs.add([of_structure(ask.targets)?]);
        }
        Ok((outputs, inputs))
    }
}

impl<T: Real, const D: usize> Ask<T, D>
where
    [T; D]: Plain,
{
    /// # Safety
    /// The crate's contract.
    pub(crate) unsafe fn bytes(self, run: *const mollis_run, bytes: *mut usize) -> Result<()> {
        let output = Output::new(bytes, 1)?;
        apart(&[output.range().into()], &[Input::new(self.kernel.cast::<u8>(), self.kernel_bytes)?.range().into()])?;
        // SAFETY: passed on.
        let (run, arrays) = unsafe { (HostRun::read(run)?, Arrays::read(&self)?) };
        // SAFETY: passed on.
        let (plan, _) = unsafe { arrays.plan(&self)? };
        let needed = arrays.bytes(&plan, run.workers())?;
        // SAFETY: passed on.
        unsafe { output.slice() }.fill(needed);
        Ok(())
    }

    /// # Safety
    /// The crate's contract.
    pub(crate) unsafe fn text(self, text: *mut c_char, size: usize, length: *mut usize) -> Result<()> {
        let (buffer, count) = (Output::new(text.cast::<u8>(), size)?, Output::optional(length, 1)?);
        let kernel = Input::new(self.kernel.cast::<u8>(), self.kernel_bytes)?;
        let mut outputs = Extents::new();
        outputs.add([buffer.range().into()]).add(count.map(|count| count.range().into()));
        apart(outputs.as_slice(), &[kernel.range().into()])?;
        // SAFETY: passed on.
        let (plan, _) = unsafe { Arrays::read(&self)?.plan(&self)? };
        // SAFETY: passed on.
        let mut writer = Text { left: unsafe { buffer.slice() }, written: 0 };
        plan.describe(|text| writer.add(text));
        let written = writer.written;
        writer.end();
        if let Some(count) = count {
            // SAFETY: passed on.
            unsafe { count.slice() }.fill(written);
        }
        Ok(())
    }

    /// # Safety
    /// The crate's contract.
    pub(crate) unsafe fn evaluate(
        self,
        run: *const mollis_run,
        workspace: (*mut c_void, usize),
        counters: *mut mollis_field_counts,
    ) -> mollis_status {
        // SAFETY: passed on.
        unsafe { with_run(run, |host, told| self.sum(host, workspace, counters, told)) }
    }

    /// # Safety
    /// The crate's contract.
    unsafe fn sum(
        &self,
        host: &HostRun,
        (workspace, workspace_bytes): (*mut c_void, usize),
        counters: *mut mollis_field_counts,
        told: &mut CallReport,
    ) -> Result<()> {
        // SAFETY: passed on.
        let arrays = unsafe { Arrays::read(self)? };
        let (memory, counts) = (Output::new(workspace.cast::<u8>(), workspace_bytes)?, Output::optional(counters, 1)?);
        let (mut outputs, inputs) = arrays.extents(self)?;
        outputs.add([memory.range().into()]).add(counts.map(|counts| counts.range().into()));
        outputs.add(host.outputs().into_iter().flatten().map(Into::into));
        apart(outputs.as_slice(), inputs.as_slice())?;
        // SAFETY: passed on.
        let (plan, kernel) = unsafe { arrays.plan(self)? };
        let needed = arrays.bytes(&plan, host.workers())?;
        if workspace_bytes < needed {
            return told.too_small(needed);
        }
        // SAFETY: passed on; the workspace overlaps nothing.
        let memory = aligned(unsafe { memory.slice() });
        let own = plan.workspace_bytes(host.workers())?;
        let space = arrays.layout(&mut Carve::reopen(memory)?, own)?;
        // SAFETY: passed on; outputs and workspace overlap nothing.
        let (positions, masses, radii, strengths, targets, target_radii) = unsafe {
            (
                gathered(arrays.positions, space.positions),
                arrays.masses.map_or(&[][..], |masses| gathered_column(masses, space.masses)),
                arrays.radii.map(|radii| gathered_column(radii, space.radii)),
                arrays.strengths.map(|vectors| gathered(vectors, space.strengths)),
                arrays.targets.map(|targets| gathered(targets, space.targets)),
                arrays.target_radii.map(|radii| gathered_column(radii, space.target_radii)),
            )
        };
        let sources = Sources { positions, masses, radii, target_radii, strengths };
        let targets = targets.unwrap_or(positions);
        let (plain, n) = (arrays.way.is_plain(), arrays.n_targets);
        let mut done = Statistics::default();
        {
            // SAFETY: as above.
            let results = unsafe {
                Outputs {
                    potential: arrays.potential.map(|c| here(plain && c.is_dense(), || c.array_mut(), space.potential)),
                    gradient: arrays.gradient.map(|g| here(plain && g.is_dense(), || g.array_mut(), space.gradient)),
                    laplacian: arrays.laplacian.map(|c| here(plain && c.is_dense(), || c.array_mut(), space.laplacian)),
                    hessian: arrays.hessian.map(|h| here(plain && h.is_dense(), || h.array_mut(), space.hessian)),
                }
            };
            let result = host.enter(|run| {
                let (level, executor, should_stop) = (run.level, run.executor, run.should_stop);
                let mut run = Run { level, executor, should_stop, counters: Some(&mut done), communicator: None };
                field::evaluate(&plan, &kernel, sources, targets, results, space.sum, &mut run)
            });
            if result == Err(Error::NotFinite) {
                let of_sources = first_bad(positions, masses)
                    .into_iter()
                    .chain(first_bad::<T, D>(strengths.unwrap_or(&[]), radii.unwrap_or(&[])));
                let of_targets = || {
                    let found = first_bad::<T, D>(targets, target_radii.unwrap_or(&[]));
                    found.map(|index| arrays.n.saturating_add(index))
                };
                told.first_bad = of_sources.min().or_else(of_targets);
            }
            result?;
        }
        // SAFETY: as above; the results above are no longer used.
        unsafe {
            if let Some(column) = arrays.potential.filter(|c| !(plain && c.is_dense())) {
                column.scatter(space.potential.iter().copied().take(n), arrays.way);
            }
            if let Some(points) = arrays.gradient.filter(|g| !(plain && g.is_dense())) {
                points.scatter(space.gradient, arrays.way);
            }
            if let Some(column) = arrays.laplacian.filter(|c| !(plain && c.is_dense())) {
                column.scatter(space.laplacian.iter().copied().take(n), arrays.way);
            }
            if let Some(matrices) = arrays.hessian.filter(|h| !(plain && h.is_dense())) {
                matrices.scatter(space.hessian, arrays.way);
            }
        }
        if let Some(counts) = counts {
            // SAFETY: as above.
            for to in unsafe { counts.slice() } {
                to.pairs = to.pairs.saturating_add(done.pairs);
                to.near_pairs = to.near_pairs.saturating_add(done.near_pairs);
                to.polynomial_blocks = to.polynomial_blocks.saturating_add(done.polynomial_blocks);
                to.all_near_blocks = to.all_near_blocks.saturating_add(done.all_near_blocks);
                to.scaled_pairs = to.scaled_pairs.saturating_add(done.scaled_pairs);
                to.massless_sources = to.massless_sources.saturating_add(done.massless_sources);
                to.beyond_reach = to.beyond_reach.saturating_add(done.beyond_reach);
            }
        }
        Ok(())
    }
}

/// The caller's array, or one of the workspace.
fn here<'a, X>(direct: bool, own: impl FnOnce() -> &'a mut [X], space: &'a mut [X]) -> &'a mut [X] {
    if direct { own() } else { space }
}

/// Text into a caller's buffer: what does not fit is counted and dropped; always ended by a zero.
struct Text<'a> {
    left: &'a mut [u8],
    written: usize,
}

impl Text<'_> {
    fn add(&mut self, s: &str) {
        self.written = self.written.saturating_add(s.len());
        // One byte stays for the end.
        let room = self.left.len().saturating_sub(1).min(s.len());
        let left = core::mem::take(&mut self.left);
        if let Some((here, rest)) = left.split_at_mut_checked(room) {
            here.iter_mut().zip(s.as_bytes()).for_each(|(to, &from)| *to = from);
            self.left = rest;
        }
    }

    fn end(self) {
        if let Some(last) = self.left.first_mut() {
            *last = 0;
        }
    }
}
