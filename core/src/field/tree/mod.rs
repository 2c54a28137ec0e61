//! Fast sums of any kernel that is smooth away from zero, on the line, in the plane and in space: sums over n sources at n targets in a time proportional to n, to a tolerance.
//!
//! ```text
//! sort sources and targets into cells                                                    (cells)
//! moments of the sources of each cell, from the leaves up                                (basis)
//! for each level: interpolate the kernel between cells that are not adjacent,            (operators)
//!     and lead the moments of source cells to the local expansions of target cells
//! local expansions from the largest cells down                                           (basis)
//! at each leaf: evaluate at its targets, and sum the near pairs                          (near; `pairs`, the engine for sums over all pairs)
//! bring the results to the caller's order
//! ```
//!
//! Nothing is asked of the kernel but its values, which the engine for pairs computes at the nodes of the interpolation. It is the black-box fast multipole method of Fong & Darve
//! (2009) with two changes: products of Chebyshev polynomials are cut by the Euclidean norm of their degrees, not each degree by itself, and the number of terms follows, step by step,
//! from the coefficients. No decomposition is needed.
//!
//! # Mollifiers
//! Cells are never narrower than the support of a compact mollifier or a Gaussian, so a mollified pair is always near and summed by the engine. Kernels whose mollifier has no
//! end (algebraic ones) are smooth at all distances and interpolated as they are.
//!
//! # Accuracy
//! The coefficients of each step between cells say what a cut leaves out ([`operators::Allowed`]); where no cut is within the tolerance, the pairs of these cells are summed one by
//! one. So an unsuitable kernel takes longer and is no less accurate.
//!
//! # Code
//! Nothing below is generic over the dimension: it is compiled once for each scalar. A divisor, or a length of pieces, that is zero for all that the compiler knows would be a way to
//! panic; such ones are written `.max(1)`.

mod alone;
mod basis;
mod cells;
mod essential;
mod levels;
mod near;
mod operators;
mod settings;

use super::options::{Options, PairRadius};
use super::pairs::{self, Call, ErasedCall, NearCall, Packed, Units, largest};
use super::problem::{Interaction, Outputs, Sources, Wanted};
use super::results::{Output, bring_back};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{MAX_WORKERS, Run};
use crate::memory::{Carve, Measure, Space};
use crate::real::Real;
use crate::sort::words::BUCKETS;
use alone::{Alone, SAMPLE, fill_sample, mean_sizes};
use basis::Basis;
use cells::{Cells, DEPTH, Limits, STACK, TARGETS, Words, index};
pub use essential::{essential, essential_bytes};
use levels::{AtLevel, FIRST, Far, Operators, Passes};
use near::{Leaves, Scratch, TASK};
use operators::{Allowed, Nodes};
pub(super) use settings::Settings;
use settings::{crossover, effective, floor};

/// What an interpolation may leave out, in root mean square, relative to the tolerance.
const SHARE: f64 = 2.0;

/// The settings for a sum of `kernel`, if the method serves it: to the tolerance, which has a least value, or, where the method is forced, to that.
pub(super) fn settings<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    wanted: Wanted,
    options: &Options,
) -> Option<Settings> {
    // Beyond the core of a Newtonian kernel the Laplacian is zero.
    let no_laplacian = kernel.newtonian().is_some_and(|(_, blob)| pairs::support::<T>(D, blob.mollifier()).is_some());
    // Where cores end is known; afar they don't matter.
    let serves = (!options.radii || no_laplacian)
        && options.pair_radius == PairRadius::Source
        && !wanted.hessian
        && (!wanted.laplacian || no_laplacian)
        && (options.method.is_some() || options.tolerance >= floor::<T>());
    serves.then(|| Settings::new(effective::<T>(options.tolerance), D, kernel.newtonian().is_some()))
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
    /// The sources in their order, as the engine for pairs lays them out, and one source for samples of the kernel.
    packed: &'w mut [u8],
    one: &'w mut [u8],
    /// Of vector strengths the components, one after the other, in the order of the sources.
    components: &'w mut [T],
    /// Keys and indices.
    words: [&'w mut [u64]; 2],
    spare: &'w mut [u64],
    counts: &'w mut [u32],
    cells: Cells<'w, T>,
    basis: Basis<'w, T>,
    nodes: Nodes<'w, T>,
    moments: &'w mut [T],
    locals: &'w mut [T],
    operators: Operators<'w, T>,
    /// The sample of distances, the kernel there, and its gradient.
    sample: &'w mut [T],
    sample_values: &'w mut [T],
    sample_slopes: &'w mut [T],
    /// The targets in their order, and where each result comes from.
    points: &'w mut [T],
    ranks: &'w mut [u32],
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

/// Bytes of the engine's sources.
fn packed_bytes<T: Real>(dimension: usize, n: usize, extras: [bool; 2]) -> Result<usize> {
    match dimension {
        1 => pairs::workspace_bytes::<T, 1>(n, extras),
        2 => pairs::workspace_bytes::<T, 2>(n, extras),
        _ => pairs::workspace_bytes::<T, 3>(n, extras),
    }
}

/// The engine's sources: positions, masses, vector strengths, origins.
type Placed<'w, T> = (&'w mut [T], &'w mut [T], &'w mut [T], &'w mut [u32]);

/// Opens the engine's sources.
fn open_packed<T: Real>(dimension: usize, packed: &mut [u8], n: usize, extras: [bool; 2]) -> Result<Placed<'_, T>> {
    fn of<T: Real, const D: usize>(packed: &mut [u8], n: usize, extras: [bool; 2]) -> Result<Placed<'_, T>> {
        let packed = Packed::<T, D>::layout(&mut Carve::reopen(packed)?, n, extras)?;
        let strengths = packed.strengths.as_flattened_mut();
        Ok((packed.positions.as_flattened_mut(), packed.masses, strengths, packed.origins))
    }
    match dimension {
        1 => of::<T, 1>(packed, n, extras),
        2 => of::<T, 2>(packed, n, extras),
        _ => of::<T, 3>(packed, n, extras),
    }
}

fn layout<'w, T: Real>(space: &mut impl Space<'w>, sizes: Sizes) -> Result<Arrays<'w, T>> {
    let Sizes { sources, targets, wanted, workers, settings, extras } = sizes;
    let dimension = settings.dimension;
    let most = sources.max(targets);
    if u32::try_from(most).is_err() {
        return Err(Error::TooLarge);
    }
    let shape = [dimension, settings.order, settings.terms];
    let n_cells = cells::room(most, settings.leaf)?;
    let each = Measure::of(|space| Scratch::<T>::layout(space, settings.terms).map(|_| ()))?;
    let times = |a: usize, b: usize| a.checked_mul(b).ok_or(Error::TooLarge);
    let basis = Basis::layout(space, dimension, settings.order)?;
    let components = if extras[1] { 3 } else { 1 };
    let expansions = times(n_cells, basis.stride * components)?;
    // A task ends when the next leaf would make it too large, so any two neighbours have more than that.
    let n_tasks = times(targets.div_ceil(TASK), 2)?.saturating_add(2);
    let some = |wanted: bool| if wanted { targets } else { 0 };
    Ok(Arrays {
        packed: space.try_array(packed_bytes::<T>(dimension, sources, extras)?)?,
        one: space.try_array(packed_bytes::<T>(dimension, 1, [false; 2])?)?,
        components: space.try_array(if extras[1] { times(sources, components)? } else { 0 })?,
        words: [space.try_array(sources)?, space.try_array(targets)?],
        spare: space.try_array(most)?,
        counts: space.try_array(BUCKETS)?,
        cells: Cells::layout(space, dimension, n_cells)?,
        basis,
        nodes: Nodes::layout(space, settings.nodes, settings.order)?,
        moments: space.try_array(expansions)?,
        locals: space.try_array(expansions)?,
        operators: Operators::layout(space, shape, settings.nodes, workers)?,
        sample: space.try_array(SAMPLE * SAMPLE * dimension)?,
        sample_values: space.try_array(SAMPLE * SAMPLE)?,
        sample_slopes: space.try_array(SAMPLE * SAMPLE * dimension)?,
        points: space.try_array(times(targets, dimension)?)?,
        ranks: space.try_array(targets)?,
        potential: space.try_array(some(wanted.potential))?,
        gradient: space.try_array(times(some(wanted.gradient), dimension)?)?,
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

/// A point in three coordinates.
fn spatial<T: Real>(point: &[T], factor: T) -> [T; 3] {
    let mut x = [T::ZERO; 3];
    x.iter_mut().zip(point).for_each(|(to, &x)| *to = x * factor);
    x
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
    let settings = Settings::new(options.tolerance, d, newtonian.is_some());
    let (n_sources, n_targets) = (positions.len() / d.max(1), targets.len() / d.max(1));
    let workers = run.executor.workers().min(MAX_WORKERS);
    let extras = [radii.is_some(), strengths.is_some()];
    let sizes = Sizes { sources: n_sources, targets: n_targets, wanted, workers, settings, extras };
    // Nothing is read before it is written.
    let arrays = layout::<T>(&mut Carve::reopen(workspace)?, sizes)?;
    let Arrays {
        packed, one, components, words, spare, counts, mut cells, mut basis, mut nodes, moments, locals, ..
    } = arrays;
    let Arrays { mut operators, sample, sample_values, sample_slopes, points, ranks, .. } = arrays;
    let Arrays { potential, gradient, laplacian, leaves, stack, tasks, starts, scratch, each, .. } = arrays;
    if n_targets == 0 {
        return Ok(());
    }

    let reach = match (radii, newtonian) {
        (Some(radii), Some((_, mollifier, _))) => {
            pairs::support::<T>(d, mollifier).ok_or(Error::Unsupported)? * largest(T::ZERO, radii)
        }
        _ => call.reach,
    };
    let length = largest(largest(T::ZERO, positions), targets).max(reach);
    let units = Units::new(length, largest(T::ZERO, strengths.unwrap_or(masses)));
    let unit = T::ONE.ldexp(units.position);
    let [source_words, target_words] = words;
    let mut count = 0;
    let per_source = if strengths.is_some() { d.max(1) } else { 1 };
    let of_sources = strengths.unwrap_or(masses);
    for (source, mass) in of_sources.chunks(per_source.max(1)).enumerate() {
        if mass.iter().any(|&m| m != T::ZERO) {
            *source_words.get_mut(count).present()? = source as u64;
            count += 1;
        }
    }
    let source_words = source_words.get_mut(..count).present()?;
    // Targets that are the sources are in the same cells in the same order.
    let same = core::ptr::eq(positions, targets) && count == n_targets;
    let target_words = target_words.get_mut(..if same { 0 } else { n_targets }).present()?;
    target_words.iter_mut().enumerate().for_each(|(k, word)| *word = k as u64);
    let of = |points: &[T], k: usize| spatial(points.get(k * d..).and_then(|rest| rest.get(..d)).present_or(&[]), unit);
    let (source_point, target_point) = (|k: usize| of(positions, k), |k: usize| of(targets, k));
    let counts = counts.first_chunk_mut().present()?;
    let words = Words { sorts: [&mut *source_words, &mut *target_words], spare, counts };
    let limits = Limits { leaf: settings.leaf, width: reach.ldexp(units.position) };
    let leaf = cells.divide(words, limits, &[&source_point, &target_point])?;
    cells.find_adjacent()?;
    if same {
        cells.share();
    }
    let target_words = if same { &*source_words } else { &*target_words };
    let (in_order, heavy, vectors, origins) = open_packed::<T>(d, packed, n_sources, extras)?;
    let in_order = in_order.get_mut(..count * d).present()?;
    let of_mass = T::ONE.ldexp(units.mass);
    for ((to, origin), &word) in in_order.chunks_mut(d.max(1)).zip(origins).zip(&*source_words) {
        let source = index(word);
        let from = positions.get(source * d..).and_then(|rest| rest.get(..d)).present()?;
        to.iter_mut().zip(from).for_each(|(to, &x)| *to = x * unit);
        *origin = source as u32;
    }
    // The masses, or the components of the strengths one after the other.
    let loads = if strengths.is_some() { components } else { &mut *heavy };
    let loads = loads.get_mut(..count * per_source).present()?;
    for (component, loads) in loads.chunks_mut(count.max(1)).enumerate() {
        for (to, &word) in loads.iter_mut().zip(&*source_words) {
            *to = of_sources.get(index(word) * per_source + component).copied().present()? * of_mass;
        }
    }
    if radii.is_none() {
        cells.merge(leaf, (&mut *loads, count), &|k| {
            spatial(in_order.get(k * d..).and_then(|rest| rest.get(..d)).unwrap_or_default(), T::ONE)
        });
    }
    if strengths.is_some() {
        for (component, loads) in loads.chunks(count.max(1)).enumerate() {
            let to = vectors.iter_mut().skip(component).step_by(per_source.max(1));
            to.zip(loads).for_each(|(to, &x)| *to = x);
        }
    }
    for ((rank, to), &word) in (0..).zip(points.chunks_mut(d.max(1))).zip(target_words) {
        let target = index(word);
        let from = targets.get(target * d..).and_then(|rest| rest.get(..d)).present()?;
        to.iter_mut().zip(from).for_each(|(to, &x)| *to = x);
        *ranks.get_mut(target).present()? = rank;
    }

    basis.prepare()?;
    nodes.prepare(settings.order);
    let passes = Passes { cells: &cells, basis: &basis, nodes: &nodes };
    let stride = basis.stride;
    let size = (cells.len() * stride).max(1);
    let moments = moments.get_mut(..size * per_source).present()?;
    let locals = locals.get_mut(..size * per_source).present()?;
    for component in 0..per_source {
        let moments = moments.get_mut(component * size..).and_then(|rest| rest.get_mut(..size)).present()?;
        let loads = loads.get(component * count..).and_then(|rest| rest.get(..count)).present()?;
        passes.up((in_order, loads), moments, &mut operators, run)?;
    }
    if strengths.is_some() {
        heavy.get_mut(..count).present()?.fill(T::ONE);
    }
    locals.fill(T::ZERO);

    // The mean sizes are those of the largest mass, as the masses are in units of it.
    let mut alone = Alone { of: call.kernel_alone(), of_pairs, mass: T::ONE.ldexp(-units.mass), workspace: one };
    let [n_sample, of_target] = fill_sample(d, in_order, (points, unit), sample);
    let sample = sample.get_mut(..n_sample * d).present()?;
    sample.iter_mut().for_each(|x| *x = x.ldexp(-units.position));
    let sample_values = sample_values.get_mut(..n_sample).present()?;
    let sample_slopes = sample_slopes.get_mut(..n_sample * d).present()?;
    alone.at(sample, sample_values, Some(&mut *sample_slopes), run)?;
    let mean = mean_sizes(d, sample, (sample_values, sample_slopes), of_target);

    let mut far = Far { few: settings.few, rough: [0; DEPTH + 1] };
    let share = T::from_f64(SHARE * options.tolerance);
    for depth in FIRST..cells.n_levels() {
        let width = cells.width(depth).ldexp(-units.position);
        let allowed = Allowed { share, mean: [mean[0], mean[1] * width] };
        let mut at_level = |points: &mut [T], values: &mut [T], run: &mut Run<'_>| {
            points.iter_mut().for_each(|x| *x *= width);
            alone.at(points, values, None, run)
        };
        let mut level = AtLevel { depth, allowed, kernel: &mut at_level };
        passes.across(&mut level, (moments, &mut *locals), &mut far, &mut operators, run)?;
    }
    for locals in locals.chunks_mut(size.max(1)) {
        passes.down(locals, &mut operators, run)?;
    }

    let n_leaves = cells.leaves(leaves, stack)?;
    let leaves = leaves.get(..n_leaves).present()?;
    let n_tasks = cut(&cells, leaves, tasks, starts)?;
    let method = Leaves {
        cells: &cells,
        basis: &basis,
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
