//! The fast multipole method in the plane (Greengard & Rokhlin 1987), for Newtonian kernels: sums over n sources at n targets in a time proportional to n, to a
//! tolerance.
//!
//! ```text
//! sort the sources, and the targets where they are others, and make trees of boxes      (tree)
//! expand the sources of each box about its centre, from the leaves up                   (upward, expansions)
//! from the largest target boxes down:                                                   (descent)
//!     take over what the larger box knows; translate the expansions of boxes that are well separated from this one  (translate)
//!     at a leaf: evaluate at its targets; list the sources that are near
//!     sum the near pairs                                                                (`pairs`, the engine for sums over all pairs)
//! bring the results to the caller's order
//! ```
//!
//! # Mollifiers
//! Beyond its support a mollified kernel is the bare one. Two boxes closer than the largest support of the sources in the one are not well separated, so every mollified
//! pair is summed by the engine, exactly. With core radii of their own, sources whose support differs by more than a factor of eight are in trees of their own
//! ([`MAX_ROOTS`] of them), so that a few large ones don't keep others from being expanded. The field of an algebraic mollifier approaches the bare one like
//! (delta/r)^2 or (delta/r)^4 only: such sums are not offered, and the plan takes the sum over all pairs.
//!
//! # Accuracy
//! [`settings`] derives the number of terms from the tolerance: the error of each output in the l2 norm over the targets, relative to that of sum_j |m_j| |K_j|
//! (with masses of one sign, to the output itself). Laplacians come from near pairs alone and have the engine's error.
//!
//! # Design
//! * The tree is one of halves, not of quarters: parts of two to one are met with half as many translations. Square cells may be leaves of twice as many points as others, since
//!   those have more neighbours: with a million uniform points that takes three quarters of the time.
//! * Pairs of boxes that are farther from each other than they must be are translated with fewer terms ([`translate`]).
//! * Boxes are as small as their points allow, so clustered points, points on a line and on a ring cost no more than uniform ones.
//! * No list is stored. A task of about a thousand targets visits the tree from its root.
//! * Coordinates and masses are in units ([`Units`]), expansions are scaled by the box: nothing overflows.
//! * The number of tasks depends on the points alone, and a task's result on nothing else: same bits for any executor.

mod descent;
mod expansions;
mod settings;
mod translate;
mod tree;
mod upward;

use core::ops::Range;

use super::options::{Options, PairRadius};
use super::pairs::{self, Call, ErasedCall, NearCall, Packed, Units, largest};
use super::problem::{Interaction, Outputs, Sources, Wanted};
use super::results::{Output, bring_back};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Chunks, MAX_WORKERS, Run, par_chunks};
use crate::kernel::sphere;
use crate::memory::{Carve, Measure, Space};
use crate::real::Real;
use crate::sort::words::BUCKETS;
use descent::{Descent, Scratch, Tops, least_square, local_length};
use expansions::{Factorials, Order};
pub(super) use settings::Settings;
use settings::{OPENING, crossover, effective, floor};
use tree::{MAX_ROOTS, Tree, boxes};
use upward::TASK;

/// Points of a task that copies.
const COPIES: usize = 4096;

/// The settings for a sum of `kernel`, if the method serves it: to the tolerance, which has a least value, or, where the method is forced, to that.
pub(super) fn settings<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    wanted: Wanted,
    options: &Options,
) -> Option<Settings> {
    let serves = D == 2 && !options.strengths && (options.method.is_some() || options.tolerance >= floor::<T>());
    let (_, blob) = kernel.newtonian().filter(|_| serves)?;
    pairs::support::<T>(D, blob.mollifier())
        .map(|_| Settings::new::<T>(effective::<T>(options.tolerance, wanted), wanted))
}

/// Whether so many sources and targets take less time than the sum over all pairs.
pub(super) fn pays(settings: Settings, (sources, targets): (usize, usize)) -> bool {
    let pairs = sources.saturating_mul(targets);
    pairs / 2 > crossover(settings.terms).saturating_mul(sources.saturating_add(targets) / 4)
}

/// The numbers of sources and targets from which the method is chosen, for a plan's text.
pub(super) fn least_size(settings: Settings) -> usize {
    crossover(settings.terms)
}

/// The workspace.
struct Arrays<'w, T> {
    /// The sources in their order, as the engine for pairs lays them out.
    packed: &'w mut [u8],
    /// Keys and indices.
    words: &'w mut [u64],
    spare: &'w mut [u64],
    counts: &'w mut [u32],
    sources: Tree<'w, T>,
    targets: Tree<'w, T>,
    expansions: &'w mut [T],
    /// The targets in their order, and where each result comes from.
    points: &'w mut [[T; 2]],
    ranks: &'w mut [u32],
    /// Their core radii, where a pair's depends on them.
    target_radii: &'w mut [T],
    potential: &'w mut [T],
    gradient: &'w mut [[T; 2]],
    laplacian: &'w mut [T],
    hessian: &'w mut [[[T; 2]; 2]],
    /// Boxes above tasks, tasks, and their starts.
    above: &'w mut [u32],
    tasks: &'w mut [[u32; 2]],
    starts: &'w mut [u32],
    tops: &'w mut [T],
    scratch: &'w mut [u8],
    /// Bytes of scratch of a worker.
    each: usize,
}

/// What a layout depends on.
#[derive(Clone, Copy, Debug)]
struct Sizes {
    sources: usize,
    targets: usize,
    radii: bool,
    /// Whether a pair's core radius depends on the target.
    symmetric: bool,
    wanted: Wanted,
    workers: usize,
    settings: Settings,
}

fn layout<'w, T: Real>(space: &mut impl Space<'w>, sizes: Sizes) -> Result<Arrays<'w, T>> {
    let Sizes { sources, targets, radii, symmetric, wanted, workers, settings } = sizes;
    let (most, stride) = (sources.max(targets), settings.stride::<T>());
    if u32::try_from(most).is_err() {
        return Err(Error::TooLarge);
    }
    let of_sources = boxes(sources, settings.leaf)?;
    let tasks = most.div_ceil(TASK).checked_mul(4).and_then(|n| n.checked_add(16)).ok_or(Error::TooLarge)?;
    let each = Measure::of(|space| Scratch::<T>::layout(space, stride).map(|_| ()))?;
    let some = |wanted: bool| if wanted { targets } else { 0 };
    let times = |a: usize, b: usize| a.checked_mul(b).ok_or(Error::TooLarge);
    Ok(Arrays {
        packed: space.try_array(pairs::workspace_bytes::<T, 2>(sources, [radii, false])?)?,
        words: space.try_array(most)?,
        spare: space.try_array(most)?,
        counts: space.try_array(BUCKETS)?,
        sources: Tree::layout(space, of_sources)?,
        targets: Tree::layout(space, boxes(targets, settings.leaf)?)?,
        expansions: space.try_array(times(of_sources, 2 * stride)?)?,
        points: space.try_array(targets)?,
        ranks: space.try_array(targets)?,
        target_radii: space.try_array(some(symmetric))?,
        potential: space.try_array(some(wanted.potential))?,
        gradient: space.try_array(some(wanted.gradient))?,
        laplacian: space.try_array(some(wanted.laplacian))?,
        hessian: space.try_array(some(wanted.hessian))?,
        above: space.try_array(tasks)?,
        tasks: space.try_array(tasks)?,
        starts: space.try_array(tasks + 1)?,
        tops: space.try_array(times(tasks, local_length(stride))?)?,
        // One worker at least: boxes above tasks need scratch too.
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
    let symmetric = options.pair_radius != PairRadius::Source;
    let sizes = Sizes { sources, targets, radii: options.radii, symmetric, wanted, workers, settings };
    Measure::of(|space| layout::<T>(space, sizes).map(|_| ()))
}

/// Overwrites the outputs, which are among those wanted of the plan. The caller has checked lengths, values and the workspace's size.
pub(super) fn evaluate<T: Real, const D: usize>(
    (kernel, wanted): (&dyn Interaction<T, D>, Wanted),
    options: &Options,
    (sources, targets): (Sources<'_, T, D>, &[[T; D]]),
    outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    // The plan's settings are those of all that it is for.
    let options = Options { tolerance: effective::<T>(options.tolerance, wanted), ..*options };
    let call = Call { options: &options, sources, targets, outputs, near: None };
    pairs::erased(true, (in_single, in_double), kernel, call, workspace, run)
}

fn in_single(call: ErasedCall<'_, f32>, workspace: &mut [u8], run: &mut Run<'_>) -> Result<()> {
    sums(call, pairs::in_single, workspace, run)
}

fn in_double(call: ErasedCall<'_, f64>, workspace: &mut [u8], run: &mut Run<'_>) -> Result<()> {
    sums(call, pairs::in_double, workspace, run)
}

/// The sources of a sum, in the caller's order.
struct Given<'a, T> {
    positions: &'a [[T; 2]],
    masses: &'a [T],
    radii: Option<&'a [T]>,
    /// The largest core radius, or delta.
    largest: T,
    /// The support of a core of length one.
    support: T,
    units: Units<T>,
}

/// Which point a word is of.
fn index(word: u64) -> usize {
    (word & u64::from(u32::MAX)) as usize
}

/// What sorting takes.
struct Sort<'a> {
    words: &'a mut [u64],
    spare: &'a mut [u64],
    counts: &'a mut [u32; BUCKETS],
}

/// The source trees.
#[derive(Clone, Copy, Default)]
struct Forest {
    roots: [u32; MAX_ROOTS],
    n_roots: usize,
    /// Sources with mass.
    count: usize,
    /// The most points of a leaf.
    leaf: usize,
}

impl<T: Real> Given<'_, T> {
    /// A core's support, in units.
    fn reach(&self, radius: T) -> T {
        radius.ldexp(self.units.position) * self.support
    }

    /// The core radius, in units, below which it does not matter how large it is: the mean distance of as many uniform points.
    fn least_radius(&self) -> T {
        let (mut least, mut most) = ([T::INFINITY; 2], [-T::INFINITY; 2]);
        for x in self.positions {
            let [x, y] = self.units.point(x);
            least = [least[0].min(x), least[1].min(y)];
            most = [most[0].max(x), most[1].max(y)];
        }
        let side = (most[0] - least[0]).max(most[1] - least[1]).max(T::ZERO);
        side / T::from_usize(self.positions.len().max(1)).sqrt()
    }

    /// The class of a source by its core radius: three binary orders of magnitude each, the last one open.
    fn class(&self, source: usize, least: T) -> usize {
        let Some(&radius) = self.radii.and_then(|radii| radii.get(source)) else { return 0 };
        let exponent = |radius: T| radius.frexp().1;
        let radius = radius.ldexp(self.units.position).max(least);
        let below = exponent(self.largest.ldexp(self.units.position)).saturating_sub(exponent(radius));
        (below.max(0) as usize / 3).min(MAX_ROOTS - 1)
    }

    /// Sorts the sources with mass and makes a tree of each class.
    fn sort(&self, sort: &mut Sort<'_>, tree: &mut Tree<'_, T>, leaf: usize) -> Result<Forest> {
        let with_mass = || self.masses.iter().enumerate().filter(|(_, m)| **m != T::ZERO).map(|(source, _)| source);
        let (mut starts, mut counts, mut sum) = ([0; MAX_ROOTS], [0_usize; MAX_ROOTS], 0);
        if self.radii.is_none() {
            for (word, source) in sort.words.iter_mut().zip(with_mass()) {
                *word = source as u64;
                sum += 1;
            }
            counts[0] = sum;
        } else {
            let least = self.least_radius();
            for source in with_mass() {
                counts.get_mut(self.class(source, least)).into_iter().for_each(|count| *count += 1);
            }
            for (start, count) in starts.iter_mut().zip(counts) {
                (*start, sum) = (sum, sum + count);
            }
            let mut next = starts;
            for source in with_mass() {
                if let Some(next) = next.get_mut(self.class(source, least)) {
                    sort.words.get_mut(*next).into_iter().for_each(|word| *word = source as u64);
                    *next += 1;
                }
            }
        }
        let point = |k: usize| self.units.point(&self.positions.get(k).copied().present_or_default());
        let mut forest = Forest { count: sum, leaf, ..Forest::default() };
        'again: loop {
            tree.clear();
            forest.n_roots = 0;
            for (start, count) in starts.into_iter().zip(counts).filter(|&(_, count)| count > 0) {
                forest.roots.get_mut(forest.n_roots).into_iter().for_each(|root| *root = tree.len() as u32);
                forest.n_roots += 1;
                if !tree.add(sort.words, start..start + count, (&mut *sort.spare, sort.counts), forest.leaf, &point)? {
                    // Larger leaves need fewer boxes. Any order of the words will do.
                    forest.leaf = forest.leaf.saturating_mul(2);
                    continue 'again;
                }
            }
            return Ok(forest);
        }
    }

    /// Copies the sources in the order of the words, in units, and to `points`, if they are the targets, as they are.
    fn place(
        &self,
        words: &[u64],
        (positions, masses, origins): (&mut [[T; 2]], &mut [T], &mut [u32]),
        points: Option<&mut [[T; 2]]>,
        run: &Run<'_>,
    ) -> Result<()> {
        let (tasks, of_mass) = (positions.len().div_ceil(COPIES), T::ONE.ldexp(self.units.mass));
        let pieces = (
            Chunks::new(positions, COPIES),
            Chunks::new(masses, COPIES),
            Chunks::new(origins, COPIES),
            points.map(|points| Chunks::new(points, COPIES)),
        );
        par_chunks(run.executor, tasks, pieces, (), &|task, (positions, masses, origins, points), ()| {
            let words = words.get(task.saturating_mul(COPIES)..).present()?;
            let mut points = points.unwrap_or_default().iter_mut();
            for (((to, mass), origin), &word) in positions.iter_mut().zip(masses).zip(origins).zip(words) {
                let source = index(word);
                let position = self.positions.get(source).present()?;
                *to = self.units.point(position);
                *mass = self.masses.get(source).copied().present()? * of_mass;
                *origin = source as u32;
                points.next().into_iter().for_each(|point| *point = *position);
            }
            Ok(())
        })
    }
}

/// Copies the targets in the order of the words.
fn place_targets<T: Real>(targets: &[[T; 2]], words: &[u64], points: &mut [[T; 2]], run: &Run<'_>) -> Result<()> {
    let tasks = targets.len().div_ceil(COPIES);
    par_chunks(run.executor, tasks, Chunks::new(points, COPIES), (), &|task, points, ()| {
        let words = words.get(task.saturating_mul(COPIES)..).present()?;
        for (to, &word) in points.iter_mut().zip(words) {
            *to = targets.get(index(word)).copied().present()?;
        }
        Ok(())
    })
}

/// The whole method; `of_pairs` is the engine for pairs.
fn sums<T: Real>(
    call: ErasedCall<'_, T>,
    of_pairs: pairs::Sum<T>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let (coefficient, mollifier, delta) = call.newtonian.ok_or(Error::Unsupported)?;
    let support = pairs::support::<T>(2, mollifier).ok_or(Error::Unsupported)?;
    let (positions, targets) = (call.positions.as_chunks::<2>().0, call.targets.as_chunks::<2>().0);
    let ErasedCall { masses, radii, target_radii: of_targets, options, .. } = call;
    let wanted = Wanted {
        potential: call.potential.is_some(),
        gradient: call.gradient.is_some(),
        laplacian: call.laplacian.is_some(),
        hessian: call.hessian.is_some(),
    };
    let settings = Settings::new::<T>(options.tolerance, wanted);
    let sizes = Sizes {
        sources: positions.len(),
        targets: targets.len(),
        radii: radii.is_some(),
        symmetric: of_targets.is_some(),
        wanted,
        workers: run.executor.workers().min(MAX_WORKERS),
        settings,
    };
    // Nothing is read before it is written.
    let arrays = layout::<T>(&mut Carve::reopen(workspace)?, sizes)?;
    let Arrays { packed, words, spare, counts, sources: mut tree, targets: mut target_tree, expansions, .. } = arrays;
    let Arrays { points, ranks, target_radii, potential, gradient, laplacian, hessian, .. } = arrays;
    let Arrays { above, tasks, starts, tops, scratch, each, .. } = arrays;
    let mut sort = Sort { words, spare, counts: counts.first_chunk_mut().present()? };

    let largest_radius = radii.map_or(delta, |radii| largest(T::ZERO, radii));
    let at_sources = core::ptr::eq(call.positions, call.targets);
    let farthest = if at_sources { T::ZERO } else { largest(T::ZERO, call.targets) };
    let most = largest(largest_radius, of_targets.unwrap_or_default());
    let length = largest(T::ZERO, call.positions).max(farthest).max(most);
    let units = Units::new(length, largest(T::ZERO, masses));
    let given = Given { positions, masses, radii, largest: largest_radius, support, units };
    let Forest { roots, n_roots, count, leaf } = given.sort(&mut sort, &mut tree, settings.leaf)?;
    let Packed { positions: in_order, masses: heavy, origins, .. } =
        Packed::<T, 2>::layout(&mut Carve::reopen(&mut *packed)?, positions.len(), [radii.is_some(), false])?;
    let (in_order, heavy) = (in_order.get_mut(..count).present()?, heavy.get_mut(..count).present()?);
    let origins = origins.get_mut(..count).present()?;
    // Targets that are the sources have the same boxes in the same order.
    let own_radii = of_targets.is_none_or(|targets| radii.is_some_and(|radii| core::ptr::eq(targets, radii)));
    let same = at_sources && own_radii && count == positions.len() && n_roots == 1;
    let copies = same.then_some(&mut *points);
    given.place(sort.words, (&mut *in_order, &mut *heavy, &mut *origins), copies, run)?;
    let of_all = given.reach(largest_radius);
    let reach = |range: Range<usize>| match radii {
        None => of_all,
        Some(radii) => origins
            .get(range)
            .present_or(&[])
            .iter()
            .fold(T::ZERO, |most, &k| most.max(given.reach(radii.get(k as usize).copied().present_or(T::ZERO)))),
    };
    tree.fit((in_order, T::ONE), &reach);
    if wanted.hessian {
        tree.widen();
    }
    tree.merge(leaf, heavy, &reach);

    if !same {
        let Sort { words, spare, counts } = &mut sort;
        words.iter_mut().take(targets.len()).enumerate().for_each(|(k, word)| *word = k as u64);
        let point = |k: usize| units.point(&targets.get(k).copied().present_or_default());
        let mut leaf = settings.leaf;
        while !target_tree.add(words, 0..targets.len(), (&mut *spare, counts), leaf, &point)? {
            target_tree.clear();
            leaf = leaf.saturating_mul(2);
        }
        place_targets(targets, words, points, run)?;
    }
    for (rank, &word) in sort.words.iter().take(targets.len()).enumerate() {
        *ranks.get_mut(index(word)).present()? = rank as u32;
    }
    for (to, &word) in target_radii.iter_mut().zip(&*sort.words) {
        *to = of_targets.and_then(|radii| radii.get(index(word))).copied().present()?;
    }
    if !same {
        let reach = |range: Range<usize>| {
            let radii = if target_radii.is_empty() { &[] } else { target_radii.get(range).present_or(&[]) };
            given.reach(largest(T::ZERO, radii))
        };
        target_tree.fit((points, T::ONE.ldexp(units.position)), &reach);
        if wanted.hessian {
            target_tree.widen();
        }
    }

    let factorials = Factorials::new();
    let order = Order { terms: settings.terms, stride: settings.stride::<T>(), factorials: &factorials };
    let expansions = expansions.get_mut(..tree.len() * 2 * order.stride).present()?;
    let lists = upward::Lists { above, tasks: tasks.as_flattened_mut(), starts: &mut *starts };
    upward::expand(&tree, (in_order, heavy), order, expansions, lists, run)?;

    let factor = coefficient / T::from_f64(sphere(2));
    let scale = |exponent: i32| {
        let [a, b] = pairs::power_of_two_pair::<T>(exponent);
        [factor, a, b]
    };
    let mut descent = Descent {
        order,
        units,
        sources: &tree,
        count,
        roots: roots.get(..n_roots).present()?,
        from: expansions,
        targets: if same { &tree } else { &target_tree },
        points,
        potential: wanted.potential,
        symmetric: of_targets.is_some(),
        opening: T::from_f64(OPENING),
        least: T::ONE.ldexp(least_square::<T>()),
        scales: [0, 1, 2].map(|n: i32| scale(n.saturating_mul(units.position).saturating_sub(units.mass))),
        tasks: &[],
        starts: &[],
        tops: &[],
    };
    if targets.is_empty() {
        return Ok(());
    }
    let n_tasks =
        descent.begin(scratch, run.level, Tops { locals: &mut *tops, tasks: &mut *tasks, starts: &mut *starts })?;
    descent.tasks = tasks.get(..n_tasks).present()?;
    descent.starts = starts.get(..=n_tasks).present()?;
    descent.tops = tops;
    // The engine does not combine the gradient's components, as that of distant sources is there already.
    let plain = Options { combination: (1.0, 0.0), ..*options };
    let ErasedCall {
        potential: to_potential, gradient: to_gradient, laplacian: to_laplacian, hessian: to_hessian, ..
    } = call;
    let near = ErasedCall {
        targets: points.as_flattened(),
        target_radii: of_targets.map(|_| &*target_radii),
        options: &plain,
        potential: wanted.potential.then_some(&mut *potential),
        gradient: wanted.gradient.then_some(gradient.as_flattened_mut()),
        laplacian: wanted.laplacian.then_some(&mut *laplacian),
        hessian: wanted.hessian.then_some(hessian.as_flattened_mut().as_flattened_mut()),
        near: Some(NearCall { method: &descent, scratch, each }),
        ..call
    };
    of_pairs(near, packed, run)?;
    let hessian = hessian.as_flattened().as_flattened();
    let outputs = [
        Output { each: 1, from: potential, to: to_potential },
        Output { each: 2, from: gradient.as_flattened(), to: to_gradient },
        Output { each: 1, from: laplacian, to: to_laplacian },
        Output { each: 4, from: hessian, to: to_hessian },
    ];
    bring_back(ranks, outputs, options.combination, run)
}
