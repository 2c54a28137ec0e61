//! Sums over nearby pairs alone, for a method that computes the others in another way.
//!
//! The method has packed the sources in an order of its own ([`super::Packed`], one class). It runs a task ([`Near::run`]), in which it lists groups of targets, each with the
//! ranges of sources that are near it; the engine adds their sums to the outputs ([`Task::add_near`]).

use core::ops::Range;

use super::packed::Units;
use crate::checked::Present;
use crate::error::Result;
use crate::field::Outputs;
use crate::simd::Level;

/// Groups of targets of a task, and the sources that they meet.
#[derive(Clone, Copy, Debug)]
pub(in crate::field) struct Groups<'a> {
    /// Of each group the first target and one beyond the last, counted from the task's first, and the first range and one beyond the last.
    pub groups: &'a [[u32; 4]],
    /// Of each range the first source, one beyond the last, and 1 if the method knows that none of them is within its support, or closer than [`least_distance`], of any
    /// target of the group; else 0.
    pub ranges: &'a [[u32; 3]],
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
) -> impl Iterator<Item = (Range<usize>, Option<&[[u32; 3]]>)> {
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
