//! The passes over all cells of a level: moments from the leaves up, from moments to local expansions, and these down to the leaves.

use super::basis::{Basis, Frame, Moments};
use super::cells::{Cells, DEPTH, SOURCES, TARGETS};
use super::operators::{self, Allowed, Apply, CLASSES, Matrix, Nodes, Quality, class_of, step_of};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Chunks, Run, par_chunks};
use crate::memory::{Carve, Measure, Space};
use crate::real::Real;
use crate::simd::MAX_LANES;

/// The first level with cells that are not adjacent.
pub(super) const FIRST: usize = 2;
/// Cells of a task.
const CELLS: usize = 32;
/// Operators at a time, at most.
const BATCH: usize = 8;
/// Numbers of their matrices at a time, if they are more than one.
const NUMBERS: usize = 1 << 21;
/// Pairs of a task's cells that have a step but for its signs.
const PAIRS: usize = 8 * CELLS;

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

/// How many operators are made at a time.
pub(super) fn batch(terms: usize) -> usize {
    let each = terms.saturating_mul(terms).max(1);
    let some = (NUMBERS / each).max(1);
    if some > BATCH { BATCH } else { some }
}

/// Room for a batch of operators.
pub(super) struct Operators<'w, T> {
    /// The nodes, then the closest point, and the kernel there; its coefficients.
    pub points: &'w mut [T],
    pub values: &'w mut [T],
    spare: &'w mut [T],
    numbers: &'w mut [T],
    columns: &'w mut [u16],
    /// Of each operator its class, and P; 0: it is zero or not to be used.
    classes: &'w mut [[u32; 2]],
    scratch: &'w mut [u8],
    each: usize,
    /// Nodes with the closest point and numbers of an operator, and blocks of rows.
    nodes: usize,
    size: usize,
    blocks: usize,
}

/// The scratch of a worker.
struct Scratch<'s, T> {
    lists: &'s mut [[u32; 3]],
    columns: &'s mut [T],
    cubes: &'s mut [T],
    sums: &'s mut [[T; MAX_LANES]],
}

impl<'s, T: Real> Scratch<'s, T> {
    fn layout(space: &mut impl Space<'s>, [dimension, order, terms]: [usize; 3]) -> Result<Self> {
        let stride = terms.next_multiple_of(MAX_LANES);
        Ok(Self {
            lists: space.try_array(PAIRS * BATCH)?,
            columns: space.try_array(operators::apply_scratch(stride))?,
            cubes: space.try_array(Basis::<T>::shift_scratch(dimension, order))?,
            sums: space.try_array(terms)?,
        })
    }
}

impl<'w, T: Real> Operators<'w, T> {
    /// The layout, for a basis and so many nodes along an axis.
    pub fn layout(space: &mut impl Space<'w>, shape: [usize; 3], n: usize, workers: usize) -> Result<Self> {
        let [dimension, _, terms] = shape;
        let (nodes, some) = (n.pow(dimension as u32) + 1, batch(terms));
        let (size, blocks) = operators::matrix_size(terms).ok_or(Error::TooLarge)?;
        let each = Measure::of(|space| Scratch::<T>::layout(space, shape).map(|_| ()))?;
        let times = |a: usize, b: usize| a.checked_mul(b).ok_or(Error::TooLarge);
        Ok(Self {
            points: space.try_array(times(some, nodes * dimension)?)?,
            values: space.try_array(times(some, nodes)?)?,
            spare: space.try_array(times(some, nodes)?)?,
            numbers: space.try_array(times(some, size)?)?,
            columns: space.try_array(times(some, blocks)?)?,
            classes: space.try_array(some)?,
            scratch: space.try_array(times(each, workers.max(1))?)?,
            each,
            nodes,
            size,
            blocks,
        })
    }
}

/// A level.
pub(super) struct AtLevel<'a, T> {
    pub depth: usize,
    pub allowed: Allowed<T>,
    /// Computes the kernel's values at some points, which are in widths of the level's cells and may be overwritten.
    pub kernel: &'a mut Values<'a, T>,
}

/// See [`AtLevel::kernel`].
pub(super) type Values<'a, T> = dyn FnMut(&mut [T], &mut [T], &mut Run<'_>) -> Result<()> + 'a;

/// What all passes share.
pub(super) struct Passes<'a, 'w, T> {
    pub cells: &'a Cells<'w, T>,
    pub basis: &'a Basis<'w, T>,
    pub nodes: &'a Nodes<'w, T>,
}

impl<T: Real> Passes<'_, '_, T> {
    fn shape(&self) -> [usize; 3] {
        [self.basis.dimension, self.basis.order, self.basis.exponents.len()]
    }

    /// The moments of all cells with sources, from level [`FIRST`] on.
    pub fn up(
        &self,
        (points, masses): (&[T], &[T]),
        moments: &mut [T],
        room: &mut Operators<'_, T>,
        run: &Run<'_>,
    ) -> Result<()> {
        let (cells, basis, stride) = (self.cells, self.basis, self.basis.stride);
        let (level, d, should_stop) = (run.level, basis.dimension, run.should_stop);
        for depth in (FIRST..cells.n_levels()).rev() {
            let range = cells.of_level(depth);
            let per_half = T::TWO / cells.width(depth);
            let (own, below) = moments.split_at_mut_checked(range.end * stride).present()?;
            let (own, below) = (own.get_mut(range.start * stride..).present()?, &*below);
            let pieces = (Chunks::new(own, CELLS * stride), Chunks::new(&mut *room.scratch, room.each));
            par_chunks(
                run.executor,
                range.len().div_ceil(CELLS),
                pieces.0,
                pieces.1,
                &|task, own, scratch: &mut [u8]| {
                    if should_stop.is_some_and(|stop| stop()) {
                        return Err(Error::Stopped);
                    }
                    let Scratch { cubes, sums, .. } = Scratch::<T>::layout(&mut Carve::reopen(scratch)?, self.shape())?;
                    for (number, to) in own.chunks_mut(stride.max(1)).enumerate() {
                        let cell = cells.get(range.start + task * CELLS + number);
                        let sources = cell.points(SOURCES);
                        to.fill(T::ZERO);
                        if sources.is_empty() {
                            continue;
                        }
                        if cell.is_leaf() {
                            level.run(Moments {
                                basis,
                                points: points.get(sources.start * d..sources.end * d).present()?,
                                masses: masses.get(sources).present()?,
                                frame: Frame { centre: cells.centre(&cell), per_half, factor: T::ONE },
                                sums: &mut *sums,
                                to,
                            });
                            continue;
                        }
                        for part in cell.parts() {
                            let from = below.get((part - range.end) * stride..).and_then(|rest| rest.get(..stride));
                            basis.shift(&cells.get(part), false, (from.present()?, &mut *to), cubes, level);
                        }
                    }
                    Ok(())
                },
            )?;
        }
        Ok(())
    }

    /// Adds the local expansions of larger cells to those of their parts.
    pub fn down(&self, locals: &mut [T], room: &mut Operators<'_, T>, run: &Run<'_>) -> Result<()> {
        let (cells, basis, stride, level) = (self.cells, self.basis, self.basis.stride, run.level);
        for depth in FIRST + 1..cells.n_levels() {
            let range = cells.of_level(depth);
            let (above, own) = locals.split_at_mut_checked(range.start * stride).present()?;
            let own = own.get_mut(..range.len() * stride).present()?;
            let above = &*above;
            let pieces = (Chunks::new(own, CELLS * stride), Chunks::new(&mut *room.scratch, room.each));
            par_chunks(
                run.executor,
                range.len().div_ceil(CELLS),
                pieces.0,
                pieces.1,
                &|task, own, scratch: &mut [u8]| {
                    let Scratch { cubes, .. } = Scratch::<T>::layout(&mut Carve::reopen(scratch)?, self.shape())?;
                    for (number, to) in own.chunks_mut(stride.max(1)).enumerate() {
                        let cell = cells.get(range.start + task * CELLS + number);
                        if cell.points(TARGETS).is_empty() {
                            continue;
                        }
                        let parent = cell.parent().present()?;
                        let from = above.get(parent * stride..).and_then(|rest| rest.get(..stride)).present()?;
                        basis.shift(&cell, true, (from, to), cubes, level);
                    }
                    Ok(())
                },
            )?;
        }
        Ok(())
    }

    /// Adds what the cells of a level give to each other. Of vectors the moments of one component of all cells stand before those of the next.
    pub fn across(
        &self,
        of: &mut AtLevel<'_, T>,
        (moments, locals): (&[T], &mut [T]),
        far: &mut Far,
        room: &mut Operators<'_, T>,
        run: &mut Run<'_>,
    ) -> Result<()> {
        let (cells, basis, depth) = (self.cells, self.basis, of.depth);
        let range = cells.of_level(depth);
        let mut counts = [0_usize; CLASSES];
        for k in range.clone().filter(|&k| !cells.get(k).points(TARGETS).is_empty()) {
            cells.each_apart(k, |other, steps| {
                if far.is_far(cells, (k, other), steps) {
                    *counts.get_mut(class_of(steps).0).present()? += 1;
                }
                Ok(())
            })?;
        }
        let (stride, size) = (basis.stride, (cells.len() * basis.stride).max(1));
        let mut wanted = counts.iter().enumerate().filter(|(_, count)| **count > 0).map(|(class, _)| class).peekable();
        while wanted.peek().is_some() {
            let mut n = 0;
            for slot in room.classes.iter_mut() {
                let Some(class) = wanted.next() else { break };
                *slot = [class as u32, 0];
                n += 1;
            }
            self.prepare(n, of, far, room, run)?;
            for (component, locals) in locals.chunks_mut(size.max(1)).enumerate() {
                let moments = moments.get(component * size..).and_then(|rest| rest.get(..size)).present()?;
                let own = locals.get_mut(range.start * stride..range.end * stride).present()?;
                self.apply(n, (depth, far), (moments, own), room, run)?;
            }
        }
        Ok(())
    }

    /// Makes the first `n` operators.
    fn prepare(
        &self,
        n: usize,
        of: &mut AtLevel<'_, T>,
        far: &mut Far,
        room: &mut Operators<'_, T>,
        run: &mut Run<'_>,
    ) -> Result<()> {
        let (depth, allowed) = (of.depth, &of.allowed);
        let (d, nodes, along) = (self.basis.dimension.max(1), room.nodes.max(1), self.nodes.n.max(1));
        let points = room.points.get_mut(..n * nodes * d).present()?;
        for (points, &[class, _]) in points.chunks_mut((nodes * d).max(1)).zip(&*room.classes) {
            let step = step_of(class as usize);
            let (at_nodes, last) = points.split_at_mut_checked((nodes - 1) * d).present()?;
            last.iter_mut().zip(operators::closest(class as usize)).for_each(|(x, at)| *x = T::from_usize(at));
            for (number, point) in at_nodes.chunks_mut(d.max(1)).enumerate() {
                let mut left = number;
                for (x, &step) in point.iter_mut().zip(&step) {
                    *x = T::from_usize(step) + self.nodes.at.get(left % along).copied().present()?;
                    left /= along;
                }
            }
        }
        let values = room.values.get_mut(..n * nodes).present()?;
        (of.kernel)(points, values, run)?;
        let pieces = (
            Chunks::new(values, nodes),
            Chunks::new(&mut *room.spare, nodes),
            Chunks::new(&mut *room.numbers, room.size),
            Chunks::new(&mut *room.columns, room.blocks),
            Chunks::new(&mut *room.classes, 1),
        );
        par_chunks(run.executor, n, pieces, (), &|_, (values, spare, numbers, columns, class), ()| {
            let (&mut corner, values) = values.split_last_mut().present()?;
            let [number, order] = class.first_mut().present()?;
            let (at, room) = ((*number as usize, corner), (&mut *values, spare));
            *order = match operators::interpolate(self.nodes, self.basis, at, room, allowed) {
                Quality::Zero => 0,
                Quality::Rough => u32::MAX,
                Quality::Order(order) => {
                    operators::fill(self.nodes, self.basis, (values, order), (numbers, columns))?;
                    order as u32
                }
            };
            Ok(())
        })?;
        for [class, order] in room.classes.iter_mut().take(n) {
            if *order == u32::MAX {
                *far.rough.get_mut(depth).present()? |= 1 << *class;
                *order = 0;
            }
        }
        Ok(())
    }

    /// Applies the first `n` operators.
    fn apply(
        &self,
        n: usize,
        (depth, far): (usize, &Far),
        (moments, own): (&[T], &mut [T]),
        room: &mut Operators<'_, T>,
        run: &Run<'_>,
    ) -> Result<()> {
        let (cells, basis, stride) = (self.cells, self.basis, self.basis.stride);
        let (range, level, should_stop) = (cells.of_level(depth), run.level, run.should_stop);
        let mut slots = [u8::MAX; CLASSES];
        for (slot, [class, _]) in room.classes.iter().take(n).enumerate().filter(|(_, [_, order])| *order > 0) {
            *slots.get_mut(*class as usize).present()? = slot as u8;
        }
        let (numbers, columns, size, blocks) = (&*room.numbers, &*room.columns, room.size, room.blocks);
        let pieces = (Chunks::new(own, CELLS * stride), Chunks::new(&mut *room.scratch, room.each));
        par_chunks(run.executor, range.len().div_ceil(CELLS), pieces.0, pieces.1, &|task, to, scratch: &mut [u8]| {
            if should_stop.is_some_and(|stop| stop()) {
                return Err(Error::Stopped);
            }
            let Scratch { lists, columns: moved, .. } =
                Scratch::<T>::layout(&mut Carve::reopen(scratch)?, self.shape())?;
            let mut lengths = [0_usize; BATCH];
            for number in 0..to.len() / stride.max(1) {
                let k = range.start + task * CELLS + number;
                if cells.get(k).points(TARGETS).is_empty() {
                    continue;
                }
                cells.each_apart(k, |other, steps| {
                    let (class, axes) = class_of(steps);
                    let slot = usize::from(slots.get(class).copied().present()?);
                    if slot < n && far.is_far(cells, (k, other), steps) {
                        let length = lengths.get_mut(slot).present()?;
                        *lists.get_mut(slot * PAIRS + *length).present()? = [other as u32, number as u32, axes as u32];
                        *length += 1;
                    }
                    Ok(())
                })?;
            }
            for (slot, &length) in lengths.iter().enumerate().filter(|(_, length)| **length > 0) {
                level.run(Apply {
                    basis,
                    matrix: Matrix {
                        numbers: numbers.get(slot * size..).and_then(|rest| rest.get(..size)).present()?,
                        columns: columns.get(slot * blocks..).and_then(|rest| rest.get(..blocks)).present()?,
                    },
                    pairs: lists.get(slot * PAIRS..).and_then(|rest| rest.get(..length)).present()?,
                    from: moments,
                    to: &mut *to,
                    scratch: &mut *moved,
                });
            }
            Ok(())
        })
    }
}
