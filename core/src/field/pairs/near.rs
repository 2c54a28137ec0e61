//! Sums over nearby pairs alone, for a method that computes the others in another way.
//!
//! The method has packed the sources in an order of its own ([`Packed`], one class). It runs a task ([`Near::run`]), in which it lists groups of targets, each with the
//! ranges of sources that are near it; the engine adds their sums to the outputs ([`Task::add_near`]).

use core::ops::Range;
use core::sync::atomic::{AtomicUsize, Ordering};

use super::packed::{Packed, Units};
use super::{Call, PairKernel, Shared, Tally, close, passes};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Chunks, Ranges, Run, Statistics, par_chunks};
use crate::field::Outputs;
use crate::memory::Carve;
use crate::real::Real;
use crate::simd::Level;

/// Groups of targets of a task, and the sources that they meet.
#[derive(Clone, Copy, Debug)]
pub(in crate::field) struct Groups<'a> {
    /// Of each group the first target and one beyond the last, counted from the task's first, and the first range and one beyond the last.
    pub groups: &'a [[u32; 4]],
    /// Of each range the first source and one beyond the last.
    pub ranges: &'a [[u32; 2]],
}

/// A task, as the method sees it.
pub(in crate::field) trait Task<T> {
    /// The task's part of the potential, of the gradient's components, of the Laplacian and of the second derivatives, as far as they are wanted. They hold arbitrary numbers
    /// at first.
    fn outputs(&mut self) -> [Option<&mut [T]>; 4];

    /// Adds what nearby sources give.
    fn add_near(&mut self, groups: Groups<'_>);
}

/// The method that knows which pairs are near.
pub(in crate::field) trait Near<T>: Sync {
    /// The units of the packed sources.
    fn units(&self) -> Units<T>;

    /// How many sources are packed.
    fn sources(&self) -> usize;

    /// Where the targets of each task begin, and the end.
    fn starts(&self) -> &[u32];

    /// Writes the outputs of a task. The scratch holds arbitrary bytes.
    ///
    /// # Errors
    /// [`Error::Internal`].
    fn run(&self, task: usize, level: Level, scratch: &mut [u8], to: &mut dyn Task<T>) -> Result<()>;
}

/// A method, and the scratch of its tasks.
pub(in crate::field) struct NearCall<'a, T> {
    pub method: &'a dyn Near<T>,
    pub scratch: &'a mut [u8],
    /// Bytes of scratch of each worker.
    pub each: usize,
}

/// The targets of each group and their ranges; all targets, and all sources, without groups.
#[inline(always)]
pub(super) fn each_group(
    groups: Option<Groups<'_>>,
    targets: usize,
) -> impl Iterator<Item = (Range<usize>, Option<&[[u32; 2]]>)> {
    let whole = groups.is_none().then_some((0..targets, None));
    let (groups, ranges) = groups.map_or((&[][..], &[][..]), |Groups { groups, ranges }| (groups, ranges));
    whole.into_iter().chain(groups.iter().map(move |&[from, to, first, last]| {
        (from as usize..to as usize, Some(ranges.get(first as usize..last as usize).present_or(&[])))
    }))
}

/// The outputs of some targets.
#[inline(always)]
pub(super) fn part<'o, T, const D: usize>(
    outputs: &'o mut Outputs<'_, T, D>,
    range: Range<usize>,
) -> Outputs<'o, T, D> {
    Outputs {
        potential: outputs.potential.as_deref_mut().and_then(|p| p.get_mut(range.clone())),
        gradient: outputs.gradient.as_deref_mut().and_then(|g| g.get_mut(range.clone())),
        laplacian: outputs.laplacian.as_deref_mut().and_then(|l| l.get_mut(range.clone())),
        hessian: outputs.hessian.as_deref_mut().and_then(|h| h.get_mut(range)),
    }
}

/// A task of [`sums`].
struct Piece<'a, T: Real, const D: usize, K: PairKernel<T, D>> {
    shared: &'a Shared<'a, T, D, K>,
    targets: &'a [[T; D]],
    /// Their core radii, where a pair's depends on them.
    radii: &'a [T],
    outputs: Outputs<'a, T, D>,
    level: Level,
    pairs: u64,
}

impl<T: Real, const D: usize, K: PairKernel<T, D>> Task<T> for Piece<'_, T, D, K> {
    fn outputs(&mut self) -> [Option<&mut [T]>; 4] {
        let Outputs { potential, gradient, laplacian, hessian } = &mut self.outputs;
        [
            potential.as_deref_mut(),
            gradient.as_deref_mut().map(<[[T; D]]>::as_flattened_mut),
            laplacian.as_deref_mut(),
            hessian.as_deref_mut().map(|hessian| hessian.as_flattened_mut().as_flattened_mut()),
        ]
    }

    fn add_near(&mut self, groups: Groups<'_>) {
        for (targets, ranges) in each_group(Some(groups), 0) {
            let sources: u64 = ranges.unwrap_or_default().iter().map(|&[from, to]| u64::from(to - from)).sum();
            self.pairs += sources * targets.len() as u64;
        }
        let all = 0..self.targets.len();
        passes(self.shared, (self.targets, self.radii), part(&mut self.outputs, all), Some(groups), self.level);
    }
}

/// Overwrites the outputs, those of the tasks in the order of the targets.
pub(super) fn sums<T: Real, const D: usize, K: PairKernel<T, D>>(
    potentials: bool,
    kernel: &K,
    call: Call<'_, T, D>,
    near: NearCall<'_, T>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let Call { options, sources, targets, outputs, near: _ } = call;
    let NearCall { method, scratch, each } = near;
    let (units, starts, wanted) = (method.units(), method.starts(), outputs.wanted());
    let extras = [sources.radii.is_some(), false];
    let packed = Packed::<T, D>::layout(&mut Carve::reopen(workspace)?, sources.positions.len(), extras)?;
    let rule = options.pair_radius;
    let core = |square: T| kernel.core(rule, square);
    let packed = packed.ordered(units, sources.radii, kernel.length(), method.sources(), &core);
    let pieces = (
        outputs.potential.map(|p| Ranges::new(p, starts)).transpose()?,
        outputs.gradient.map(|g| Ranges::new(g, starts)).transpose()?,
        outputs.laplacian.map(|l| Ranges::new(l, starts)).transpose()?,
        outputs.hessian.map(|h| Ranges::new(h, starts)).transpose()?,
    );
    let (tally, pairs) = (Tally::default(), AtomicUsize::new(0));
    let prepared = kernel.prepare(units, rule, wanted.potential);
    let closer = close::prepare(kernel, (units, rule, wanted.potential), &prepared);
    let shared = Shared {
        kernel,
        prepared: &prepared,
        closer: &closer,
        packed: &packed,
        units,
        options,
        sources,
        ordered: true,
        tally: &tally,
    };
    let (level, should_stop) = (run.level, run.should_stop);
    par_chunks(
        run.executor,
        starts.len().saturating_sub(1),
        pieces,
        Chunks::new(scratch, each),
        &|task, (potential, gradient, laplacian, hessian), scratch: &mut [u8]| {
            if should_stop.is_some_and(|stop| stop()) {
                return Err(Error::Stopped);
            }
            let range = starts.get(task).zip(starts.get(task + 1)).map(|(&from, &to)| from as usize..to as usize);
            let start = range.as_ref().map_or(0, |range| range.start);
            let targets = range.and_then(|range| targets.get(range)).present()?;
            let radii = sources.target_radii.map_or(&[][..], |radii| radii.get(start..).present_or(&[]));
            let outputs = Outputs { potential: potential.filter(|_| potentials), gradient, laplacian, hessian };
            let mut piece = Piece { shared: &shared, targets, radii, outputs, level, pairs: 0 };
            method.run(task, level, scratch, &mut piece)?;
            pairs.fetch_add(piece.pairs as usize, Ordering::Relaxed);
            Ok(())
        },
    )?;
    if let Some(counters) = run.counters.as_deref_mut() {
        let massless = sources.positions.len().saturating_sub(method.sources()) as u64;
        let pairs = pairs.load(Ordering::Relaxed) as u64;
        counters.add(&Statistics { pairs, massless_sources: massless, ..tally.counters() });
    }
    Ok(())
}
