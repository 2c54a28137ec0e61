//! Essential sources: checked, then answered.

use core::ffi::c_void;

use mollis_core::exec::Run;
use mollis_core::field::{Essential, Sources, essential, essential_bytes};
use mollis_core::kernel::Kernel;
use mollis_core::memory::{Carve, Measure, Plain, Space};
use mollis_core::{Error, Real, Result};

use super::call::SourcesOf;
use crate::arrays::{Column, Extents, Points, apart, fetch, gathered, gathered_column, of_structure};
use crate::buffers::{Input, Output, aligned, with_slack};
use crate::first_bad::first_bad;
use crate::kernel::open;
use crate::run::{CallReport, HostRun, mollis_run, with_run};
use crate::status::mollis_status;

/// What both functions are given.
#[derive(Clone, Copy)]
pub(crate) struct Reduce<T, const D: usize> {
    pub kernel: *const c_void,
    pub kernel_bytes: usize,
    pub sources: *const SourcesOf<T, D>,
    pub tolerance: f64,
}

/// The boxes, and where results go.
#[derive(Clone, Copy)]
pub(crate) struct Boxes<T, const D: usize> {
    pub n: usize,
    pub corners: *const [[T; D]; 2],
    pub starts: *mut u64,
    pub room: usize,
    pub positions: *mut [T; D],
    pub masses: *mut T,
    pub origins: *mut u64,
}

/// The sources, checked.
struct Arrays<T, const D: usize> {
    n: usize,
    positions: Points<T, D>,
    masses: Column<T>,
    radii: Option<Column<T>>,
}

/// The workspace: copies of arrays with gaps, and the search's own.
struct Scratch<'w, T, const D: usize> {
    positions: &'w mut [[T; D]],
    masses: &'w mut [T],
    radii: &'w mut [T],
    own: &'w mut [u8],
}

impl<T: Real, const D: usize> Arrays<T, D>
where
    [T; D]: Plain,
{
    /// # Safety
    /// The crate's contract for the structure.
    unsafe fn read(sources: *const SourcesOf<T, D>) -> Result<Self> {
        // SAFETY: passed on.
        let sources = unsafe { fetch(sources)? };
        let n = sources.n;
        if sources.strengths.iter().any(|pointer| !pointer.is_null()) {
            return Err(Error::Unsupported);
        }
        Ok(Self {
            n,
            positions: Points::new(sources.positions.map(<*const T>::cast_mut), sources.stride, n)?,
            masses: Column::new(sources.masses.cast_mut(), sources.mass_stride, n)?,
            radii: Column::optional(sources.radii.cast_mut(), sources.radius_stride, n)?,
        })
    }

    fn layout<'w>(&self, space: &mut impl Space<'w>, bytes: usize) -> Result<Scratch<'w, T, D>> {
        Ok(Scratch {
            positions: space.try_array(self.positions.copied())?,
            masses: space.try_array(self.masses.copied())?,
            radii: space.try_array(self.radii.as_ref().map_or(0, Column::copied))?,
            own: space.try_array(bytes)?,
        })
    }

    /// Bytes of the search, and of the workspace wherever it begins.
    fn bytes(&self, kernel: &Kernel<'_, T, D>, tolerance: f64) -> Result<[usize; 2]> {
        let own = essential_bytes(kernel, self.n, tolerance)?;
        Ok([own, with_slack(Measure::of(|space| self.layout(space, own).map(|_| ()))?)?])
    }
}

impl<T: Real, const D: usize> Reduce<T, D>
where
    [T; D]: Plain,
    [[T; D]; 2]: Plain,
{
    /// # Safety
    /// The crate's contract.
    pub(crate) unsafe fn bytes(self, bytes: *mut usize) -> Result<()> {
        let output = Output::new(bytes, 1)?;
        apart(&[output.range().into()], &[Input::new(self.kernel.cast::<u8>(), self.kernel_bytes)?.range().into()])?;
        // SAFETY: passed on.
        let (arrays, kernel) =
            unsafe { (Arrays::<T, D>::read(self.sources)?, open::<T, D>(self.kernel, self.kernel_bytes)?) };
        let [_, needed] = arrays.bytes(&kernel, self.tolerance)?;
        // SAFETY: passed on.
        unsafe { output.slice() }.fill(needed);
        Ok(())
    }

    /// # Safety
    /// The crate's contract.
    pub(crate) unsafe fn find(
        self,
        boxes: Boxes<T, D>,
        run: *const mollis_run,
        workspace: (*mut c_void, usize),
    ) -> mollis_status {
        // SAFETY: passed on.
        unsafe { with_run(run, |host, told| self.found(boxes, host, workspace, told)) }
    }

    /// # Safety
    /// The crate's contract.
    unsafe fn found(
        self,
        boxes: Boxes<T, D>,
        host: &HostRun,
        (workspace, workspace_bytes): (*mut c_void, usize),
        told: &mut CallReport,
    ) -> Result<()> {
        // SAFETY: passed on.
        let arrays = unsafe { Arrays::<T, D>::read(self.sources)? };
        let corners = Input::new(boxes.corners, boxes.n)?;
        let starts = Output::new(boxes.starts, boxes.n.checked_add(1).ok_or(Error::TooLarge)?)?;
        // Without a place for the positions nothing but the numbers is wanted.
        let wanted = !boxes.positions.is_null() || boxes.room > 0;
        let room = if wanted { boxes.room } else { 0 };
        let (positions, masses) = (Output::new(boxes.positions, room)?, Output::new(boxes.masses, room)?);
        let origins = Output::optional(boxes.origins, room)?;
        let memory = Output::new(workspace.cast::<u8>(), workspace_bytes)?;
        let (mut outputs, mut inputs) = (Extents::new(), Extents::new());
        outputs.add([starts.range().into(), positions.range().into(), masses.range().into()]);
        outputs.add(origins.map(|origins| origins.range().into())).add([memory.range().into()]);
        outputs.add(host.outputs().into_iter().flatten().map(Into::into));
        inputs.add(arrays.positions.extents()).add([arrays.masses.extent()]).add(arrays.radii.map(|r| r.extent()));
        inputs.add([corners.range().into(), of_structure(self.sources)?]);
        inputs.add([Input::new(self.kernel.cast::<u8>(), self.kernel_bytes)?.range().into()]);
        apart(outputs.as_slice(), inputs.as_slice())?;
        // SAFETY: passed on.
        let kernel = unsafe { open::<T, D>(self.kernel, self.kernel_bytes)? };
        let [own, needed] = arrays.bytes(&kernel, self.tolerance)?;
        if workspace_bytes < needed {
            return told.too_small(needed);
        }
        // SAFETY: passed on; the workspace overlaps nothing.
        let memory = aligned(unsafe { memory.slice() });
        let space = arrays.layout(&mut Carve::reopen(memory)?, own)?;
        // SAFETY: passed on; outputs and workspace overlap nothing.
        let (from, to) = unsafe {
            let from = Sources {
                positions: gathered(arrays.positions, space.positions),
                masses: gathered_column(arrays.masses, space.masses),
                radii: arrays.radii.map(|radii| gathered_column(radii, space.radii)),
                target_radii: None,
                strengths: None,
            };
            let origins = origins.map(|origins| origins.slice());
            (from, Essential { positions: positions.slice(), masses: masses.slice(), origins })
        };
        // SAFETY: as above.
        let (corners, starts) = unsafe { (corners.slice(), starts.slice()) };
        let result = host.enter(|run| {
            let (level, executor, should_stop) = (run.level, run.executor, run.should_stop);
            let mut run = Run { level, executor, should_stop, counters: None, communicator: None };
            essential(&kernel, from, self.tolerance, corners, (starts, wanted.then_some(to)), space.own, &mut run)
        });
        if result == Err(Error::NotFinite) {
            let radii = first_bad::<T, D>(&[], from.radii.unwrap_or(&[]));
            told.first_bad = first_bad(from.positions, from.masses).into_iter().chain(radii).min();
        }
        result
    }
}
