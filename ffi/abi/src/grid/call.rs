//! The arguments of a field on a mesh: checked, then answered.

use core::ffi::c_void;

use mollis_core::memory::{Carve, Measure, Plain, Space};
use mollis_core::{Error, Real, Result};

use super::medium::Problem;
use super::{mollis_grid2_options, mollis_mesh2};
use crate::arrays::{Column, Extents, Points, Way, apart, fetch, gathered, gathered_column, of_structure};
use crate::buffers::{Output, aligned, with_slack};
use crate::field::call::{Places, read_targets};
use crate::field::{SourcesOf, TargetsOf};
use crate::first_bad::first_bad;
use crate::options;
use crate::run::{CallReport, HostRun, mollis_run, with_run};
use crate::status::mollis_status;

/// The layout of `mollis_grid2_outputs`, which says what the members are.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "they stand where C programs read them")]
pub struct GridOutputsOf<T> {
    pub gradient: [*mut T; 2],
    pub gradient_stride: usize,
    pub node_mass: *mut T,
    pub node_potential: *mut T,
    pub node_gradient: *mut [T; 2],
    pub total: *mut [T; 3],
    pub outside: *mut u64,
}

/// What size query and evaluation are both given.
#[derive(Clone, Copy)]
pub(crate) struct Ask<T> {
    pub mesh: *const mollis_mesh2,
    pub sources: *const SourcesOf<T, 2>,
    pub targets: *const TargetsOf<T, 2>,
    pub outputs: *const GridOutputsOf<T>,
    pub options: *const mollis_grid2_options,
}

/// The arguments, checked as far as sizes and addresses go.
struct Checked<T> {
    problem: Problem<T>,
    positions: Points<T, 2>,
    masses: Column<T>,
    /// None: the sources.
    targets: Option<Points<T, 2>>,
    gradient: Option<Points<T, 2>>,
    node_mass: Option<Output<T>>,
    node_potential: Option<Output<T>>,
    node_gradient: Option<Output<[T; 2]>>,
    total: Option<Output<[T; 3]>>,
    outside: Option<Output<u64>>,
}

/// The workspace: copies of arrays that have gaps, and the grid's own.
struct Scratch<'w, T> {
    positions: &'w mut [[T; 2]],
    masses: &'w mut [T],
    targets: &'w mut [[T; 2]],
    gradient: &'w mut [[T; 2]],
    grid: &'w mut [u8],
}

impl<T: Real> Checked<T>
where
    [T; 2]: Plain,
    [T; 3]: Plain,
{
    /// # Safety
    /// The crate's contract for the structures.
    unsafe fn read(ask: &Ask<T>) -> Result<Self> {
        // SAFETY: passed on.
        let (mesh, options, sources, outputs) = unsafe {
            (mollis_mesh2::read::<T>(ask.mesh)?, options::read(ask.options)?, fetch(ask.sources)?, fetch(ask.outputs)?)
        };
        if !sources.radii.is_null() || sources.strengths.iter().any(|strength| !strength.is_null()) {
            return Err(Error::Unsupported);
        }
        // SAFETY: passed on.
        let problem = unsafe { Problem::read(mesh, &options)? };
        let (n, nodes) = (sources.n, mesh.nodes());
        // SAFETY: passed on.
        let Places { points: targets, n: n_targets, .. } = unsafe { read_targets(ask.targets, n)? };
        Ok(Self {
            problem,
            positions: Points::new(sources.positions.map(<*const T>::cast_mut), sources.stride, n)?,
            masses: Column::new(sources.masses.cast_mut(), sources.mass_stride, n)?,
            targets,

            gradient: Points::optional(outputs.gradient, outputs.gradient_stride, n_targets)?,
            node_mass: Output::optional(outputs.node_mass, nodes)?,
            node_potential: Output::optional(outputs.node_potential, nodes)?,
            node_gradient: Output::optional(outputs.node_gradient, nodes)?,
            total: Output::optional(outputs.total, 1)?,
            outside: Output::optional(outputs.outside, 1)?,
        })
    }

    /// The only statement of the layout.
    fn layout<'w>(&self, space: &mut impl Space<'w>, grid: usize) -> Result<Scratch<'w, T>> {
        Ok(Scratch {
            positions: space.try_array(self.positions.copied())?,
            masses: space.try_array(self.masses.copied())?,
            targets: space.try_array(self.targets.as_ref().map_or(0, Points::copied))?,
            gradient: space.try_array(self.gradient.as_ref().map_or(0, Points::copied))?,
            grid: space.try_array(grid)?,
        })
    }

    /// Bytes of the grid's own workspace, and of all of it, wherever it begins.
    fn bytes(&self, workers: usize) -> Result<[usize; 2]> {
        let own = self.problem.bytes(workers)?;
        Ok([own, with_slack(Measure::of(|space| self.layout(space, own).map(|_| ()))?)?])
    }

    fn extents(&self, ask: &Ask<T>) -> Result<(Extents, Extents)> {
        let (mut outputs, mut inputs) = (Extents::new(), Extents::new());
        outputs.add(self.gradient.iter().flat_map(Points::extents));
        outputs.add(self.node_mass.map(|o| o.range().into())).add(self.node_potential.map(|o| o.range().into()));
        outputs.add(self.node_gradient.map(|o| o.range().into())).add(self.total.map(|o| o.range().into()));
        outputs.add(self.outside.map(|o| o.range().into())).add(self.problem.output().map(Into::into));
        inputs.add(self.positions.extents()).add([self.masses.extent()]);
        inputs.add(self.targets.iter().flat_map(Points::extents));
        inputs.add(self.problem.inputs()).add([
            of_structure(ask.mesh)?,
            of_structure(ask.sources)?,
            of_structure(ask.outputs)?,
        ]);
        if !ask.targets.is_null() {
            inputs.add([of_structure(ask.targets)?]);
        }
        Ok((outputs, inputs))
    }
}

impl<T: Real> Ask<T>
where
    [T; 2]: Plain,
    [T; 3]: Plain,
{
    /// # Safety
    /// The crate's contract.
    pub(crate) unsafe fn bytes(self, run: *const mollis_run, bytes: *mut usize) -> Result<()> {
        let bytes = Output::new(bytes, 1)?;
        // SAFETY: passed on.
        let (checked, run) = unsafe { (Checked::read(&self)?, HostRun::read(run)?) };
        let [_, needed] = checked.bytes(run.workers())?;
        // SAFETY: passed on.
        unsafe { bytes.slice() }.fill(needed);
        Ok(())
    }

    /// # Safety
    /// The crate's contract.
    pub(crate) unsafe fn evaluate(self, run: *const mollis_run, workspace: (*mut c_void, usize)) -> mollis_status {
        // SAFETY: passed on.
        unsafe { with_run(run, |host, told| self.solve(host, workspace, told)) }
    }

    /// # Safety
    /// The crate's contract.
    unsafe fn solve(
        &self,
        host: &HostRun,
        (workspace, workspace_bytes): (*mut c_void, usize),
        told: &mut CallReport,
    ) -> Result<()> {
        // SAFETY: passed on.
        let checked = unsafe { Checked::read(self)? };
        let memory = Output::new(workspace.cast::<u8>(), workspace_bytes)?;
        let (mut outputs, inputs) = checked.extents(self)?;
        outputs.add([memory.range().into()]).add(host.outputs().into_iter().flatten().map(Into::into));
        apart(outputs.as_slice(), inputs.as_slice())?;
        let [own, needed] = checked.bytes(host.workers())?;
        if workspace_bytes < needed {
            return told.too_small(needed);
        }
        // SAFETY: passed on; outputs and workspace overlap nothing.
        let (space, sources, masses, targets) = unsafe {
            let space = checked.layout(&mut Carve::reopen(aligned(memory.slice()))?, own)?;
            let sources = gathered(checked.positions, space.positions);
            let masses = gathered_column(checked.masses, space.masses);
            let targets = checked.targets.map_or(sources, |targets| gathered(targets, space.targets));
            (Scratch { positions: &mut [], masses: &mut [], targets: &mut [], ..space }, sources, masses, targets)
        };
        if !sources.iter().chain(targets).flatten().chain(masses).all(|v| v.is_finite()) {
            told.first_bad = first_bad(sources, masses)
                .or_else(|| first_bad::<T, 2>(targets, &[]).map(|index| sources.len().saturating_add(index)));
            return Err(Error::NotFinite);
        }
        host.enter(|run| {
            // SAFETY: as above.
            let mut field = unsafe { checked.problem.field(space.grid, run.resources())? };
            let go_on = || if run.should_stop.is_some_and(|ask| ask()) { Err(Error::Stopped) } else { Ok(()) };
            field.deposit(sources, masses, run.resources())?;
            let mut solved = Ok(());
            go_on()?;
            let wanted =
                checked.gradient.is_some() || checked.node_potential.is_some() || checked.node_gradient.is_some();
            if wanted || checked.problem.memory.is_some() {
                solved = field.solve(run.resources());
                // SAFETY: as above.
                unsafe { field.tell() };
                // The last iterate is a result.
                solved = if solved == Err(Error::NotConverged) { solved } else { Ok(solved?) };
                go_on()?;
            } else {
                field.locate_mass();
            }
            let grid = field.grid();
            // SAFETY: as above, for each output.
            unsafe {
                if let Some(points) = checked.gradient {
                    if points.is_dense() {
                        grid.interpolate(targets, points.array_mut(), run.resources())?;
                    } else {
                        grid.interpolate(targets, space.gradient, run.resources())?;
                        points.scatter(space.gradient, Way::PLAIN);
                    }
                }
                if let Some(out) = checked.node_mass {
                    grid.masses(out.slice())?;
                }
                if let Some(out) = checked.node_potential {
                    grid.potential(out.slice())?;
                }
                if let Some(out) = checked.node_gradient {
                    out.slice().iter_mut().zip(grid.gradient()).for_each(|(slot, &value)| *slot = value);
                }
                if let Some(out) = checked.total {
                    let monopole = grid.monopole();
                    let [x, y] = monopole.centre;
                    out.slice().fill([monopole.mass, x, y]);
                }
                if let Some(out) = checked.outside {
                    out.slice().fill(grid.outside());
                }
                field.save()?;
            }
            solved
        })
    }
}
