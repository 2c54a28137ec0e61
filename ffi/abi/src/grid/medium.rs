//! A medium whose coefficients depend on the place, and the field of a mesh with or without it, or with a memory.

use mollis_core::exec::Resources;
use mollis_core::grid::{Coefficients, Equation, Grid, Limits, Mesh, Order, Parabolic, Variable};
use mollis_core::memory::{Carve, Measure, Plain, Space};
use mollis_core::pks::{Attraction, Heavy};
use mollis_core::{Error, Real, Result};

use super::parabolic::Memory;
use super::{equation, mollis_grid2_options};
use crate::arrays::{Extent, fetch, of_structure};
use crate::buffers::{Input, Output, Range};

/// A medium: G and k^2 of div(G grad u) - k^2 u = density at the nodes of a mesh, in double precision for both scalars, and when the iteration ends that solves for u.
///
/// Nodes stand for the cells around them, and faces between them have the harmonic mean of G. The error is of second order in the mesh width where G and k^2 are smooth or jump along
/// lines midway between nodes, of first order where a jump crosses the mesh elsewhere. About 25 iterations for jumps of 10 and a tolerance of 1e-10, on every mesh.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_medium2 {
    /// G > 0 at the nodes, in any unit, the least at least 2.2e-16 (single precision: 1.2e-7) of the largest. In free space the same everywhere on the border.
    pub diffusivity: *const f64,
    /// k^2 >= 0 at the nodes, in the unit of G over length^2; null: 0 everywhere. In free space the same everywhere on the border, and 0 there only if it is everywhere.
    pub decay: *const f64,
    /// The relative residual to be reached, positive: 1e-10, say. If k^2 / G is the same everywhere, sqrt(max G / min G) times it bounds the relative error of the solve in the energy norm. Rounding keeps it above 2e-16
    /// (single precision: 2e-7) times the square root of the number of nodes.
    pub tolerance: f64,
    /// The most iterations: 100, say. If they do not suffice, the call ends with MOLLIS_ERR_NOT_CONVERGED.
    pub iterations: u64,
    /// Two numbers, overwritten by the iterations that were made and the residual that was reached, also with MOLLIS_ERR_NOT_CONVERGED; null: not wanted.
    pub report: *mut [f64; 2],
}

/// The caller's, checked as far as sizes and addresses go.
#[derive(Clone, Copy)]
pub(crate) struct Medium {
    diffusivity: Input<f64>,
    decay: Option<Input<f64>>,
    tolerance: f64,
    iterations: u32,
    report: Option<Output<[f64; 2]>>,
    own: Extent,
}

/// The coefficients in the scalar of the call.
struct Copies<'w, T> {
    diffusivity: &'w mut [T],
    decay: &'w mut [T],
}

impl Medium {
    /// # Safety
    /// The crate's contract for what the options point to.
    unsafe fn read(options: &mollis_grid2_options, nodes: usize) -> Result<Option<Self>> {
        if options.medium.is_null() {
            return Ok(None);
        }
        // SAFETY: passed on.
        let given = unsafe { fetch(options.medium)? };
        let decay = if given.decay.is_null() { None } else { Some(Input::new(given.decay, nodes)?) };
        Ok(Some(Self {
            diffusivity: Input::new(given.diffusivity, nodes)?,
            decay,
            tolerance: given.tolerance,
            iterations: u32::try_from(given.iterations).unwrap_or(u32::MAX),
            report: Output::optional(given.report, 1)?,
            own: of_structure(options.medium)?,
        }))
    }

    /// The arrays that are read, and the structure.
    fn inputs(&self) -> impl Iterator<Item = Extent> + use<> {
        let ranges = [Some(self.diffusivity), self.decay].into_iter().flatten().map(|array| array.range().into());
        ranges.chain([self.own])
    }

    /// The only statement of the layout.
    fn layout<'w, T: Plain>(&self, space: &mut impl Space<'w>, nodes: usize) -> Result<Copies<'w, T>> {
        let decay = if self.decay.is_some() { nodes } else { 0 };
        Ok(Copies { diffusivity: space.try_array(nodes)?, decay: space.try_array(decay)? })
    }
}

/// What is solved on a mesh: an equation, and its medium if that varies, or its memory if it has one.
#[derive(Clone, Copy)]
pub(crate) struct Problem<T> {
    pub mesh: Mesh<T>,
    pub equation: Equation<T>,
    pub medium: Option<Medium>,
    pub memory: Option<Memory>,
}

impl<T: Real> Problem<T> {
    /// # Safety
    /// The crate's contract for what the options point to.
    pub(crate) unsafe fn read(mesh: Mesh<T>, options: &mollis_grid2_options) -> Result<Self> {
        // SAFETY: passed on.
        let (equation, medium) = (equation(options)?, unsafe { Medium::read(options, mesh.nodes())? });
        // SAFETY: passed on.
        let memory = unsafe { Memory::read(options.parabolic, mesh.nodes())? };
        if medium.is_some() && memory.is_some() {
            return Err(Error::Unsupported);
        }
        if medium.is_some() && (equation.screening != T::ZERO || equation.order != Order::Second) {
            return Err(Error::Unsupported);
        }
        Ok(Self { mesh, equation, medium, memory })
    }

    pub(crate) fn inputs(&self) -> impl Iterator<Item = Extent> + use<T> {
        let memory = self.memory.map(|memory| memory.input());
        self.medium.into_iter().flat_map(|medium| medium.inputs()).chain(memory)
    }

    /// The medium's report, or the attractant.
    pub(crate) fn output(&self) -> Option<Range> {
        let attractant = self.memory.map(|memory| memory.output().range());
        attractant.or(self.medium.and_then(|medium| medium.report).map(|report| report.range()))
    }

    /// Bytes of the copies and of the field behind them.
    fn parts(&self, workers: usize) -> Result<[usize; 2]> {
        if self.memory.is_some() {
            let copy = Memory::bytes::<T>(self.mesh.nodes())?;
            return Ok([copy, Parabolic::workspace_bytes(&self.mesh, &self.equation, workers)?]);
        }
        let Some(medium) = self.medium else {
            return Ok([0, Grid::workspace_bytes(&self.mesh, &self.equation, workers)?]);
        };
        let nodes = self.mesh.nodes();
        let copies = Measure::of(|space| medium.layout::<T>(space, nodes).map(|_| ()))?;
        Ok([copies, Variable::workspace_bytes(&self.mesh, self.equation.walls, workers)?])
    }

    /// Bytes that [`Problem::field`] needs.
    pub(crate) fn bytes(&self, workers: usize) -> Result<usize> {
        let [copies, own] = self.parts(workers)?;
        copies.checked_add(own).ok_or(Error::TooLarge)
    }

    /// The field, without mass.
    ///
    /// # Safety
    /// The crate's contract for the medium's arrays and the attractant.
    pub(crate) unsafe fn field<'w>(&self, memory: &'w mut [u8], resources: Resources<'_>) -> Result<Field<'w, T>> {
        let (Self { mesh, equation, medium, memory: past }, workers) = (*self, resources.executor.workers());
        if let Some(past) = past {
            let [copy, _] = self.parts(workers)?;
            let (copy, own) = memory.split_at_mut_checked(copy).ok_or(Error::WorkspaceTooSmall)?;
            let copy = Memory::layout(&mut Carve::reopen(copy)?, mesh.nodes())?;
            let mut field = Parabolic::prepare(own, mesh, equation, T::from_f64(past.time_scale), workers)?;
            // SAFETY: passed on.
            unsafe { past.give(copy, &mut field, resources)? };
            return Ok(Field::Parabolic(field, past, copy));
        }
        let Some(medium) = medium else {
            return Grid::prepare(memory, mesh, equation, workers).map(Field::Uniform);
        };
        let [copies, _] = self.parts(workers)?;
        let (copies, own) = memory.split_at_mut_checked(copies).ok_or(Error::WorkspaceTooSmall)?;
        let Copies { diffusivity, decay } = medium.layout(&mut Carve::reopen(copies)?, mesh.nodes())?;
        // SAFETY: passed on.
        let given = unsafe { (medium.diffusivity.slice(), medium.decay.map(|decay| decay.slice())) };
        diffusivity.iter_mut().zip(given.0).for_each(|(own, &g)| *own = T::from_f64(g));
        decay.iter_mut().zip(given.1.unwrap_or_default()).for_each(|(own, &k)| *own = T::from_f64(k));
        let coefficients = Coefficients { diffusivity, decay: medium.decay.map(|_| &*decay) };
        let field = Variable::prepare(own, mesh, equation.walls, &coefficients, workers)?;
        let limits = Limits { tolerance: T::from_f64(medium.tolerance), iterations: medium.iterations };
        Ok(Field::Medium(field, limits, medium.report))
    }
}

/// The field of a mesh.
#[expect(clippy::large_enum_variant, reason = "there is no heap, and a call has one of them")]
pub(crate) enum Field<'w, T: Real> {
    /// Solved directly.
    Uniform(Grid<'w, T>),
    /// Solved by iteration; last the report's place.
    Medium(Variable<'w, T>, Limits<T>, Option<Output<[f64; 2]>>),
    /// Advanced in time; last the room for a copy of the attractant.
    Parabolic(Parabolic<'w, T>, Memory, &'w mut [T]),
}

impl<'w, T: Real> Field<'w, T> {
    pub(crate) fn grid(&self) -> &Grid<'w, T> {
        match self {
            Self::Uniform(grid) => grid,
            Self::Medium(field, ..) => field.grid(),
            Self::Parabolic(field, ..) => field.grid(),
        }
    }

    pub(crate) fn deposit(&mut self, positions: &[[T; 2]], masses: &[T], resources: Resources<'_>) -> Result<()> {
        match self {
            Self::Uniform(grid) => grid.deposit(positions, masses, resources),
            Self::Medium(field, ..) => field.deposit(positions, masses, resources),
            Self::Parabolic(field, ..) => field.deposit(positions, masses, resources),
        }
    }

    pub(crate) fn locate_mass(&mut self) {
        match self {
            Self::Uniform(grid) => grid.locate_mass(),
            Self::Medium(field, ..) => field.locate_mass(),
            // A step in time does.
            Self::Parabolic(..) => {}
        }
    }

    pub(crate) fn solve(&mut self, resources: Resources<'_>) -> Result<()> {
        match self {
            Self::Uniform(grid) => grid.solve(resources),
            Self::Medium(field, limits, _) => field.solve(limits, resources).map(|_| ()),
            Self::Parabolic(field, memory, _) => {
                field.look_ahead(T::from_f64(memory.time), resources)?;
                field.keep();
                Ok(())
            }
        }
    }

    /// Writes the medium's report.
    ///
    /// # Safety
    /// The crate's contract for the report.
    pub(crate) unsafe fn tell(&self) {
        if let Self::Medium(field, _, Some(to)) = self {
            let report = field.report();
            // SAFETY: passed on.
            unsafe { to.slice() }.fill([f64::from(report.iterations), report.residual.to_f64()]);
        }
    }

    /// Writes the attractant that is kept.
    ///
    /// # Safety
    /// The crate's contract for its array.
    pub(crate) unsafe fn save(&mut self) -> Result<()> {
        match self {
            // SAFETY: passed on.
            Self::Parabolic(field, memory, copy) => unsafe { memory.take(copy, field) },
            _ => Ok(()),
        }
    }

    /// The attraction of coalescing particles.
    pub(crate) fn attraction<'a>(&'a mut self, heavy: Option<&'a Heavy<'a, T>>) -> Attraction<'a, 'w, T> {
        match self {
            Self::Uniform(grid) => Attraction::Mesh(grid, heavy),
            Self::Medium(field, limits, _) => Attraction::Medium(field, *limits),
            Self::Parabolic(field, ..) => Attraction::Parabolic(field),
        }
    }
}
