//! The passes over all cells of a level: moments from the leaves up, from moments to local expansions, and these down to the leaves.

use super::cells::{Cells, DEPTH, SOURCES, TARGETS};
use super::series::{Frame, Pair, Series};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Chunks, Run, par_chunks};
use crate::memory::{Carve, Measure, Space};
use crate::real::Real;

/// The first level with cells that are not adjacent.
pub(super) const FIRST: usize = 2;
/// Cells of a task.
const CELLS: usize = 32;
/// Pairs of a task's cells that have a step but for its signs.
const PAIRS: usize = 8 * CELLS;

/// Steps between cells that are not adjacent while those around them are, but for the signs, by their first, second and third component.
pub(super) const CLASSES: usize = 64;

/// The number of a step but for its signs, and the axes along which it is negative, one bit each.
pub(super) fn class_of(steps: [i32; 3]) -> (usize, usize) {
    let [x, y, z] = steps.map(|step| step.unsigned_abs() as usize);
    let negative = steps.iter().enumerate().fold(0, |axes, (axis, &step)| axes | usize::from(step < 0) << axis);
    (x + 4 * y + 16 * z, negative)
}

/// The step of a class.
pub(super) fn step_of(class: usize) -> [usize; 3] {
    [class % 4, class / 4 % 4, class / 16]
}

/// Which pairs of cells are summed by expansions.
pub(super) struct Far {
    /// Pairs of cells with at most so many pairs of points are not.
    pub few: usize,
    /// The steps for which the kernel cannot be interpolated, a bit each, by level.
    pub rough: [u64; DEPTH + 1],
}

impl Far {
    /// Whether a target cell and a source cell that it meets are.
    pub fn is_far<T: Real>(&self, cells: &Cells<'_, T>, (target, source): (usize, usize), steps: [i32; 3]) -> bool {
        let (target, source) = (cells.get(target), cells.get(source));
        let pairs = target.points(TARGETS).len().saturating_mul(source.points(SOURCES).len());
        let rough = self.rough.get(target.level as usize).copied().present_or(u64::MAX);
        pairs > self.few && rough >> class_of(steps).0 & 1 == 0
    }
}

/// The scratch of all workers.
pub(super) struct Workers<'w> {
    bytes: &'w mut [u8],
    each: usize,
    lists: usize,
    numbers: usize,
}

/// That of one.
struct Scratch<'s, T> {
    lists: &'s mut [Pair],
    numbers: &'s mut [T],
}

impl<'s, T: Real> Scratch<'s, T> {
    fn layout(space: &mut impl Space<'s>, lists: usize, numbers: usize) -> Result<Self> {
        Ok(Self { lists: space.try_array(PAIRS * lists)?, numbers: space.try_array(numbers)? })
    }
}

impl<'w> Workers<'w> {
    /// The layout, for so many lists of pairs at a time, and so many numbers of scratch of a series.
    pub fn layout<T: Real>(
        space: &mut impl Space<'w>,
        (lists, numbers): (usize, usize),
        workers: usize,
    ) -> Result<Self> {
        let each = Measure::of(|space| Scratch::<T>::layout(space, lists, numbers).map(|_| ()))?;
        let bytes = each.checked_mul(workers.max(1)).ok_or(Error::TooLarge)?;
        Ok(Self { bytes: space.try_array(bytes)?, each, lists, numbers })
    }
}

/// What leads from the moments of some cells to the local expansions of others, by the number of a list: the pairs, the moments, the local expansions, and scratch.
pub(super) type Across<'a, T> = dyn Fn(usize, &[Pair], (&[T], &mut [T], &mut [T])) + Sync + 'a;

/// What all passes share.
pub(super) struct Passes<'a, 'w, T> {
    pub cells: &'a Cells<'w, T>,
    pub dimension: usize,
    pub series: &'a dyn Series<T>,
}

impl<T: Real> Passes<'_, '_, T> {
    /// The moments of all cells with sources, from level [`FIRST`] on.
    pub fn up(
        &self,
        (points, masses): (&[T], &[T]),
        moments: &mut [T],
        workers: &mut Workers<'_>,
        run: &Run<'_>,
    ) -> Result<()> {
        let (cells, series, stride, d) = (self.cells, self.series, self.series.stride(), self.dimension);
        let (level, should_stop, sizes) = (run.level, run.should_stop, (workers.lists, workers.numbers));
        for depth in (FIRST..cells.n_levels()).rev() {
            let range = cells.of_level(depth);
            let per_half = T::TWO / cells.width(depth);
            let (own, below) = moments.split_at_mut_checked(range.end * stride).present()?;
            let (own, below) = (own.get_mut(range.start * stride..).present()?, &*below);
            let pieces = (Chunks::new(own, CELLS * stride), Chunks::new(&mut *workers.bytes, workers.each));
            par_chunks(
                run.executor,
                range.len().div_ceil(CELLS),
                pieces.0,
                pieces.1,
                &|task, own, scratch: &mut [u8]| {
                    if should_stop.is_some_and(|stop| stop()) {
                        return Err(Error::Stopped);
                    }
                    let Scratch { lists, numbers } = Scratch::layout(&mut Carve::reopen(scratch)?, sizes.0, sizes.1)?;
                    let mut n = 0;
                    for (number, to) in own.chunks_mut(stride.max(1)).enumerate() {
                        let cell = cells.get(range.start + task * CELLS + number);
                        let sources = cell.points(SOURCES);
                        to.fill(T::ZERO);
                        if sources.is_empty() {
                            continue;
                        }
                        if cell.is_leaf() {
                            let points = points.get(sources.start * d..sources.end * d).present()?;
                            let frame = Frame { centre: cells.centre(&cell), per_half, factor: T::ONE };
                            let sources = (points, masses.get(sources).present()?);
                            series.moments(sources, frame, (to, &mut *numbers), level);
                            continue;
                        }
                        for part in cell.parts() {
                            let axes = cells.get(part).half();
                            *lists.get_mut(n).present()? = [(part - range.end) as u32, number as u32, axes];
                            n += 1;
                        }
                    }
                    series.shift(false, lists.get(..n).present()?, (below, own, numbers), level);
                    Ok(())
                },
            )?;
        }
        Ok(())
    }

    /// Adds the local expansions of larger cells to those of their parts.
    pub fn down(&self, locals: &mut [T], workers: &mut Workers<'_>, run: &Run<'_>) -> Result<()> {
        let (cells, series, stride, level) = (self.cells, self.series, self.series.stride(), run.level);
        let sizes = (workers.lists, workers.numbers);
        for depth in FIRST + 1..cells.n_levels() {
            let range = cells.of_level(depth);
            let (above, own) = locals.split_at_mut_checked(range.start * stride).present()?;
            let own = own.get_mut(..range.len() * stride).present()?;
            let above = &*above;
            let pieces = (Chunks::new(own, CELLS * stride), Chunks::new(&mut *workers.bytes, workers.each));
            par_chunks(
                run.executor,
                range.len().div_ceil(CELLS),
                pieces.0,
                pieces.1,
                &|task, own, scratch: &mut [u8]| {
                    let Scratch { lists, numbers } = Scratch::layout(&mut Carve::reopen(scratch)?, sizes.0, sizes.1)?;
                    let mut n = 0;
                    for number in 0..own.len() / stride.max(1) {
                        let cell = cells.get(range.start + task * CELLS + number);
                        if cell.points(TARGETS).is_empty() {
                            continue;
                        }
                        let parent = cell.parent().present()? as u32;
                        *lists.get_mut(n).present()? = [parent, number as u32, cell.half()];
                        n += 1;
                    }
                    series.shift(true, lists.get(..n).present()?, (above, own, numbers), level);
                    Ok(())
                },
            )?;
        }
        Ok(())
    }

    /// How many pairs of a level's cells have a step of each class.
    pub fn counts(&self, (depth, far): (usize, &Far)) -> Result<[usize; CLASSES]> {
        let (cells, mut counts) = (self.cells, [0_usize; CLASSES]);
        for k in cells.of_level(depth).filter(|&k| !cells.get(k).points(TARGETS).is_empty()) {
            cells.each_apart(k, |other, steps| {
                if far.is_far(cells, (k, other), steps) {
                    *counts.get_mut(class_of(steps).0).present()? += 1;
                }
                Ok(())
            })?;
        }
        Ok(counts)
    }

    /// Adds to the local expansions of a level's cells what the moments of others give to them. A list is one of a class of steps, or none (`lists`).
    pub fn across(
        &self,
        (depth, far): (usize, &Far),
        lists: &[u8; CLASSES],
        step: &Across<'_, T>,
        (moments, own): (&[T], &mut [T]),
        workers: &mut Workers<'_>,
        run: &Run<'_>,
    ) -> Result<()> {
        let (cells, stride, range) = (self.cells, self.series.stride(), self.cells.of_level(depth));
        let (should_stop, sizes, of_class) = (run.should_stop, (workers.lists, workers.numbers), lists);
        let pieces = (Chunks::new(own, CELLS * stride), Chunks::new(&mut *workers.bytes, workers.each));
        par_chunks(run.executor, range.len().div_ceil(CELLS), pieces.0, pieces.1, &|task, to, scratch: &mut [u8]| {
            if should_stop.is_some_and(|stop| stop()) {
                return Err(Error::Stopped);
            }
            let Scratch { lists, numbers } = Scratch::layout(&mut Carve::reopen(scratch)?, sizes.0, sizes.1)?;
            let mut lengths = [0_usize; CLASSES];
            for number in 0..to.len() / stride.max(1) {
                let k = range.start + task * CELLS + number;
                if cells.get(k).points(TARGETS).is_empty() {
                    continue;
                }
                cells.each_apart(k, |other, steps| {
                    let (class, axes) = class_of(steps);
                    let list = usize::from(of_class.get(class).copied().present()?);
                    if list < sizes.0 && far.is_far(cells, (k, other), steps) {
                        let length = lengths.get_mut(list).present()?;
                        *lists.get_mut(list * PAIRS + *length).present()? = [other as u32, number as u32, axes as u32];
                        *length += 1;
                    }
                    Ok(())
                })?;
            }
            for (list, &length) in lengths.iter().enumerate().filter(|(_, length)| **length > 0) {
                let pairs = lists.get(list * PAIRS..).and_then(|rest| rest.get(..length)).present()?;
                step(list, pairs, (moments, &mut *to, &mut *numbers));
            }
            Ok(())
        })
    }
}
