//! Fast sums over n sources at n targets, in a time proportional to n, to a tolerance: of any kernel that is smooth away from zero, on the line, in the plane and in space, and by the fast multipole method of
//! Newtonian kernels in space.
//!
//! ```text
//! sort sources and targets into cells                                                    (placed, cells)
//! moments of the sources of each cell, from the leaves up                                (levels)
//! for each level: lead the moments of source cells to the local expansions
//!     of target cells that are not adjacent
//! local expansions from the largest cells down
//! at each leaf: evaluate at its targets, and sum the near pairs                          (near; `pairs`, the engine for sums over all pairs)
//! bring the results to the caller's order
//! ```
//!
//! Expansions are a [`Series`]: Chebyshev polynomials, which ask nothing of the kernel but its values ([`chebyshev`]), or solid harmonics ([`harmonics`]).
//!
//! # Mollifiers
//! Cells are never narrower than the support of a compact mollifier or a Gaussian, so a mollified pair is always near and summed by the engine. Kernels whose mollifier has no
//! end (algebraic ones) are smooth at all distances and interpolated as they are.
//!
//! # Code
//! Nothing below is generic over the dimension: it is compiled once for each scalar. A divisor, or a length of pieces, that is zero for all that the compiler knows would be a way to
//! panic; such ones are written `.max(1)`.

mod cells;
mod chebyshev;
mod essential;
mod harmonics;
mod levels;
mod near;
mod placed;
mod series;
mod settings;

use super::options::{Method, Options, PairRadius};
use super::pairs::{self, Call, ErasedCall, NearCall, largest};
use super::problem::{Interaction, Outputs, Sources, Wanted};
use super::results::{Output, bring_back};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{MAX_WORKERS, Run};
use crate::memory::{Carve, Measure, Space};
use crate::real::Real;
use cells::{Cells, DEPTH, STACK, TARGETS};
use chebyshev::Alone;
pub use essential::{essential, essential_bytes};
use levels::{Far, Passes, Workers};
use near::{Leaves, Scratch, TASK};
use placed::{Placed, packed_bytes};
use series::Series;
pub(super) use settings::Settings;
use settings::{crossover, effective, floor};

/// The settings for a sum of `kernel`, if the method serves it: to the tolerance, which has a least value, or, where the method is forced, to that.
pub(super) fn settings<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    wanted: Wanted,
    options: &Options,
) -> Option<Settings> {
    let support = kernel.newtonian().map(|(_, blob)| pairs::support::<T>(D, blob.mollifier()).is_some());
    // Beyond the core of a Newtonian kernel the Laplacian is zero.
    let no_laplacian = support == Some(true);
    // Where cores end is known; afar they don't matter.
    let serves = (!options.radii || no_laplacian)
        && options.pair_radius == PairRadius::Source
        && !wanted.hessian
        && (!wanted.laplacian || no_laplacian)
        && (options.method.is_some() || options.tolerance >= floor::<T>());
    serves.then(|| Settings::of(&Options { tolerance: effective::<T>(options.tolerance), ..*options }, D, support))
}

/// What the method is called: with harmonics the fast multipole method.
pub(super) fn method(settings: Settings) -> Method {
    if settings.harmonics { Method::Fmm } else { Method::Tree }
}

/// Whether so many sources and targets take less time than the sum over all pairs.
pub(super) fn pays(settings: Settings, (sources, targets): (usize, usize)) -> bool {
    let pairs = sources.saturating_mul(targets);
    pairs / 2 > crossover(settings).saturating_mul(sources.saturating_add(targets) / 4)
}

/// The numbers of sources and targets from which the method is chosen, for a plan's text.
pub(super) fn least_size(settings: Settings) -> usize {
    crossover(settings)
}

/// The workspace.
struct Arrays<'w, T> {
    placing: placed::Room<'w, T>,
    expansions: Expansions<'w, T>,
    moments: &'w mut [T],
    locals: &'w mut [T],
    workers: Workers<'w>,
    potential: &'w mut [T],
    gradient: &'w mut [T],
    laplacian: &'w mut [T],
    leaves: &'w mut [u32],
    stack: &'w mut [u32],
    tasks: &'w mut [[u32; 2]],
    starts: &'w mut [u32],
    scratch: &'w mut [u8],
    /// Bytes of scratch of a worker.
    each: usize,
}

/// What the series needs.
#[allow(clippy::large_enum_variant, reason = "there is one, on the stack of a sum")]
enum Expansions<'w, T> {
    /// And the engine's workspace for one source, for samples of the kernel.
    Chebyshev(chebyshev::Expansions<'w, T>, &'w mut [u8]),
    Harmonics(harmonics::Expansions<'w, T>),
}

/// What a layout depends on.
#[derive(Clone, Copy, Debug)]
struct Sizes {
    sources: usize,
    targets: usize,
    wanted: Wanted,
    workers: usize,
    settings: Settings,
    /// Whether sources have core radii, and vector strengths.
    extras: [bool; 2],
}

fn layout<'w, T: Real>(space: &mut impl Space<'w>, sizes: Sizes) -> Result<Arrays<'w, T>> {
    let Sizes { sources, targets, wanted, workers, settings, extras } = sizes;
    let d = settings.dimension;
    let most = sources.max(targets);
    if u32::try_from(most).is_err() {
        return Err(Error::TooLarge);
    }
    let times = |a: usize, b: usize| a.checked_mul(b).ok_or(Error::TooLarge);
    let n_cells = settings.cells(most)?;
    let placing = placed::Room::layout(space, settings, (sources, targets), extras)?;
    let expansions = if settings.harmonics {
        Expansions::Harmonics(harmonics::Expansions::layout(space, settings.order)?)
    } else {
        let one = space.try_array(packed_bytes::<T>(d, 1, [false; 2])?)?;
        Expansions::Chebyshev(
            chebyshev::Expansions::layout(space, [d, settings.order, settings.terms, settings.nodes])?,
            one,
        )
    };
    let (series, lists): (&dyn Series<T>, usize) = match &expansions {
        Expansions::Chebyshev(of, _) => (&of.basis, chebyshev::BATCH),
        Expansions::Harmonics(of) => (of, levels::CLASSES),
    };
    let (stride, numbers) = (series.stride(), series.scratch());
    let numbers_of_cells = times(n_cells, stride * if extras[1] { 3 } else { 1 })?;
    let each = Measure::of(|space| Scratch::<T>::layout(space, numbers).map(|_| ()))?;
    // A task ends when the next leaf would make it too large, so any two neighbours have more than that.
    let n_tasks = times(targets.div_ceil(TASK), 2)?.saturating_add(2);
    let some = |wanted: bool| if wanted { targets } else { 0 };
    Ok(Arrays {
        placing,
        expansions,
        moments: space.try_array(numbers_of_cells)?,
        locals: space.try_array(numbers_of_cells)?,
        workers: Workers::layout::<T>(space, (lists, numbers), workers)?,
        potential: space.try_array(some(wanted.potential))?,
        gradient: space.try_array(times(some(wanted.gradient), d)?)?,
        laplacian: space.try_array(some(wanted.laplacian))?,
        leaves: space.try_array(n_cells)?,
        stack: space.try_array(STACK)?,
        tasks: space.try_array(n_tasks)?,
        starts: space.try_array(n_tasks + 1)?,
        scratch: space.try_array(times(each, workers.max(1))?)?,
        each,
    })
}

/// Bytes of workspace.
///
/// # Errors
/// [`Error::TooLarge`].
pub(super) fn workspace_bytes<T: Real>(
    settings: Settings,
    (sources, targets): (usize, usize),
    wanted: Wanted,
    options: &Options,
    workers: usize,
) -> Result<usize> {
    let extras = [options.radii, options.strengths];
    let sizes = Sizes { sources, targets, wanted, workers, settings, extras };
    Measure::of(|space| layout::<T>(space, sizes).map(|_| ()))
}

/// Overwrites the outputs, which are among those wanted of the plan. The caller has checked lengths, values and the workspace's size.
pub(super) fn evaluate<T: Real, const D: usize>(
    (kernel, _): (&dyn Interaction<T, D>, Wanted),
    options: &Options,
    (sources, targets): (Sources<'_, T, D>, &[[T; D]]),
    outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let options = Options { tolerance: effective::<T>(options.tolerance), ..*options };
    let call = Call { options: &options, sources, targets, outputs, near: None };
    pairs::erased(true, (in_single, in_double), kernel, call, workspace, run)
}

fn in_single(call: ErasedCall<'_, f32>, workspace: &mut [u8], run: &mut Run<'_>) -> Result<()> {
    sums(call, pairs::in_single, workspace, run)
}

fn in_double(call: ErasedCall<'_, f64>, workspace: &mut [u8], run: &mut Run<'_>) -> Result<()> {
    sums(call, pairs::in_double, workspace, run)
}

/// Tasks of about as many targets each: their first leaves, and where their targets begin. Returns how many there are.
fn cut<T: Real>(cells: &Cells<'_, T>, leaves: &[u32], tasks: &mut [[u32; 2]], starts: &mut [u32]) -> Result<usize> {
    let (mut n, mut first, mut size) = (0, 0, 0);
    for (number, &leaf) in leaves.iter().enumerate() {
        let points = cells.get(leaf as usize).points(TARGETS);
        if number > first && size + points.len() > TASK {
            *tasks.get_mut(n).present()? = [first as u32, number as u32];
            (n, first, size) = (n + 1, number, 0);
        }
        if size == 0 {
            *starts.get_mut(n).present()? = points.start as u32;
        }
        size += points.len();
        *starts.get_mut(n + 1).present()? = points.end as u32;
    }
    *tasks.get_mut(n).present()? = [first as u32, leaves.len() as u32];
    Ok(n + 1)
}

/// The whole method; `of_pairs` is the engine for pairs.
fn sums<T: Real>(
    call: ErasedCall<'_, T>,
    of_pairs: pairs::Sum<T>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let wanted = Wanted {
        potential: call.potential.is_some(),
        gradient: call.gradient.is_some(),
        laplacian: call.laplacian.is_some(),
        hessian: false,
    };
    let ErasedCall { dimension: d, newtonian, options, positions, masses, strengths, targets, radii, .. } = call;
    let support = newtonian.and_then(|(_, mollifier, _)| pairs::support::<T>(d, mollifier));
    let settings = Settings::of(options, d, newtonian.map(|_| support.is_some()));
    let (n_sources, n_targets) = (positions.len() / d.max(1), targets.len() / d.max(1));
    let workers = run.executor.workers().min(MAX_WORKERS);
    let extras = [radii.is_some(), strengths.is_some()];
    let sizes = Sizes { sources: n_sources, targets: n_targets, wanted, workers, settings, extras };
    // Nothing is read before it is written.
    let arrays = layout::<T>(&mut Carve::reopen(workspace)?, sizes)?;
    let Arrays { placing, mut expansions, moments, locals, mut workers, potential, gradient, laplacian, .. } = arrays;
    let Arrays { leaves, stack, tasks, starts, scratch, each, .. } = arrays;
    if n_targets == 0 {
        return Ok(());
    }
    let reach = match radii {
        Some(radii) => support.ok_or(Error::Unsupported)? * largest(T::ZERO, radii),
        None => call.reach,
    };
    let mut placed = placing.place(&call, settings, reach)?;
    let mut far = Far { few: settings.few, rough: [0; DEPTH + 1] };
    let of = Expanding {
        components: if extras[1] { d } else { 1 },
        moments,
        locals: &mut *locals,
        far: &mut far,
        workers: &mut workers,
    };
    let series: &dyn Series<T> = match &mut expansions {
        Expansions::Chebyshev(expansions, one) => {
            // The kernel's sizes are those of the largest mass, as the masses are in units of it.
            let mass = T::ONE.ldexp(-placed.units.mass);
            let alone = Alone { of: call.kernel_alone(), of_pairs, mass, workspace: one };
            of.in_polynomials(&mut placed, (expansions, alone), options.tolerance, run)?;
            &expansions.basis
        }
        Expansions::Harmonics(expansions) => {
            let (coefficient, ..) = newtonian.ok_or(Error::Unsupported)?;
            of.in_harmonics(&mut placed, expansions, coefficient, run)?;
            expansions
        }
    };

    let Placed { cells, units, count, points, ranks, packed, .. } = placed;
    let n_leaves = cells.leaves(leaves, stack)?;
    let leaves = leaves.get(..n_leaves).present()?;
    let n_tasks = cut(&cells, leaves, tasks, starts)?;
    let method = Leaves {
        cells: &cells,
        dimension: d,
        series,
        far: &far,
        units,
        count,
        locals,
        vectors: strengths.is_some(),
        points,
        list: leaves,
        tasks: tasks.get(..n_tasks).present()?,
        starts: starts.get(..=n_tasks).present()?,
    };
    // The engine does not combine the gradient's components, as that of distant sources is there already.
    let plain = Options { combination: (1.0, 0.0), ..*options };
    let near = ErasedCall {
        options: &plain,
        positions,
        masses,
        radii,
        strengths,
        targets: points,
        potential: wanted.potential.then_some(&mut *potential),
        gradient: wanted.gradient.then_some(&mut *gradient),
        laplacian: wanted.laplacian.then_some(&mut *laplacian),
        near: Some(NearCall { method: &method, scratch, each }),
        ..call.kernel_alone()
    };
    of_pairs(near, packed, run)?;
    let outputs = [
        Output { each: 1, from: potential, to: call.potential },
        Output { each: d, from: gradient, to: call.gradient },
        Output { each: 1, from: laplacian, to: call.laplacian },
    ];
    bring_back(ranks, outputs, options.combination, run)
}

/// From sources in their order to the local expansions of all cells. Of vectors those of one component stand before those of the next.
struct Expanding<'a, 'w, T> {
    components: usize,
    moments: &'a mut [T],
    locals: &'a mut [T],
    far: &'a mut Far,
    workers: &'a mut Workers<'w>,
}

impl<T: Real> Expanding<'_, '_, T> {
    /// The moments of all cells; local expansions are zero after it. Numbers of the expansions of a component.
    fn up(&mut self, placed: &mut Placed<'_, T>, series: &dyn Series<T>, run: &Run<'_>) -> Result<usize> {
        let (count, size) = (placed.count, (placed.cells.len() * series.stride()).max(1));
        let dimension = placed.dimension;
        self.locals.get_mut(..size * self.components).present()?.fill(T::ZERO);
        for component in 0..self.components {
            let (cells, points, loads) = placed.parts()?;
            let passes = Passes { cells, dimension, series };
            let moments = self.moments.get_mut(component * size..).and_then(|rest| rest.get_mut(..size)).present()?;
            let loads = loads.get(component * count..).and_then(|rest| rest.get(..count)).present()?;
            passes.up((points, loads), moments, self.workers, run)?;
        }
        Ok(size)
    }

    fn in_polynomials(
        mut self,
        placed: &mut Placed<'_, T>,
        (expansions, mut alone): (&mut chebyshev::Expansions<'_, T>, Alone<'_, T>),
        tolerance: f64,
        run: &mut Run<'_>,
    ) -> Result<()> {
        expansions.prepare()?;
        let size = self.up(placed, &expansions.basis, run)?;
        let (units, points, dimension) = (placed.units, placed.points, placed.dimension);
        let (cells, sources, _) = placed.parts()?;
        let mean = expansions.mean_sizes(units, (sources, points), &mut alone, run)?;
        let moments = self.moments.get(..size * self.components).present()?;
        let locals = self.locals.get_mut(..size * self.components).present()?;
        let both = (moments, &mut *locals);
        chebyshev::across(
            (units, tolerance, mean),
            expansions,
            cells,
            both,
            (self.far, &mut alone),
            self.workers,
            run,
        )?;
        let passes = Passes { cells, dimension, series: &expansions.basis };
        locals.chunks_mut(size.max(1)).try_for_each(|locals| passes.down(locals, self.workers, run))
    }

    fn in_harmonics(
        mut self,
        placed: &mut Placed<'_, T>,
        expansions: &mut harmonics::Expansions<'_, T>,
        coefficient: T,
        run: &Run<'_>,
    ) -> Result<()> {
        expansions.prepare(coefficient, placed.units)?;
        let size = self.up(placed, expansions, run)?;
        let cells = &placed.cells;
        let passes = Passes { cells, dimension: placed.dimension, series: expansions };
        for (locals, moments) in
            self.locals.chunks_mut(size.max(1)).zip(self.moments.chunks(size.max(1))).take(self.components)
        {
            harmonics::across(expansions, &passes, (moments, &mut *locals), self.far, self.workers, run)?;
            passes.down(locals, self.workers, run)?;
        }
        Ok(())
    }
}
