//! Expansions in Chebyshev polynomials: for any kernel that is smooth away from zero.
//!
//! The black-box fast multipole method of Fong & Darve (2009) with two changes: products of Chebyshev polynomials are cut by the Euclidean norm of their degrees, not each degree by itself,
//! and the number of terms follows, step by step, from the coefficients. No decomposition is needed.
//!
//! # Accuracy
//! The coefficients of each step between cells say what a cut leaves out ([`operators::Allowed`]); where no cut is within the tolerance, the pairs of these cells are summed one by
//! one. So an unsuitable kernel takes longer and is no less accurate.

mod alone;
pub(super) mod basis;
mod operators;

use super::levels::{CLASSES, FIRST, Far, Passes, Workers, step_of};
use super::series::Pair;
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Chunks, Run, par_chunks};
use crate::field::pairs::Units;
use crate::memory::Space;
use crate::real::Real;
pub(super) use alone::Alone;
use alone::{SAMPLE, fill_sample, mean_sizes};
use basis::Basis;
pub(super) use basis::MAX_ORDER;
use operators::{Allowed, Apply, Matrix, Nodes, Quality};
pub(super) use operators::{along_axes, most_shells};

/// What an interpolation may leave out, in root mean square, relative to the tolerance.
const SHARE: f64 = 2.0;
/// Operators at a time, at most.
pub(super) const BATCH: usize = 8;
/// Numbers of their matrices at a time, if they are more than one.
const NUMBERS: usize = 1 << 21;

/// How many operators are made at a time.
fn batch(terms: usize) -> usize {
    let each = terms.saturating_mul(terms).max(1);
    let some = (NUMBERS / each).max(1);
    if some > BATCH { BATCH } else { some }
}

/// The series, and room for a batch of operators.
pub(super) struct Expansions<'w, T> {
    pub basis: Basis<'w, T>,
    nodes: Nodes<'w, T>,
    /// The sample of distances, the kernel there, and its gradient.
    sample: &'w mut [T],
    sample_values: &'w mut [T],
    sample_slopes: &'w mut [T],
    operators: Operators<'w, T>,
}

/// Room for a batch of operators.
struct Operators<'w, T> {
    /// The nodes, then the closest point, and the kernel there; its coefficients.
    points: &'w mut [T],
    values: &'w mut [T],
    spare: &'w mut [T],
    numbers: &'w mut [T],
    columns: &'w mut [u16],
    /// Of each operator its class, and P; 0: it is zero or not to be used.
    classes: &'w mut [[u32; 2]],
    /// Nodes with the closest point and numbers of an operator, and blocks of rows.
    nodes: usize,
    size: usize,
    blocks: usize,
}

impl<'w, T: Real> Expansions<'w, T> {
    /// The layout, for a basis in a dimension, of an order and so many terms, and nodes along an axis.
    pub fn layout(space: &mut impl Space<'w>, [dimension, order, terms, n]: [usize; 4]) -> Result<Self> {
        let (nodes, some) = (n.pow(dimension as u32) + 1, batch(terms));
        let (size, blocks) = operators::matrix_size(terms).ok_or(Error::TooLarge)?;
        let times = |a: usize, b: usize| a.checked_mul(b).ok_or(Error::TooLarge);
        Ok(Self {
            basis: Basis::layout(space, dimension, order)?,
            nodes: Nodes::layout(space, n, order)?,
            sample: space.try_array(SAMPLE * SAMPLE * dimension)?,
            sample_values: space.try_array(SAMPLE * SAMPLE)?,
            sample_slopes: space.try_array(SAMPLE * SAMPLE * dimension)?,
            operators: Operators {
                points: space.try_array(times(some, nodes * dimension)?)?,
                values: space.try_array(times(some, nodes)?)?,
                spare: space.try_array(times(some, nodes)?)?,
                numbers: space.try_array(times(some, size)?)?,
                columns: space.try_array(times(some, blocks)?)?,
                classes: space.try_array(some)?,
                nodes,
                size,
                blocks,
            },
        })
    }

    /// Fills the tables.
    pub fn prepare(&mut self) -> Result<()> {
        self.basis.prepare()?;
        self.nodes.prepare(self.basis.order);
        Ok(())
    }

    /// The mean sizes of the kernel and its gradient, of the largest mass, over the pairs of sources, in their units, and targets.
    pub fn mean_sizes(
        &mut self,
        units: Units<T>,
        (sources, targets): (&[T], &[T]),
        alone: &mut Alone<'_, T>,
        run: &mut Run<'_>,
    ) -> Result<[T; 2]> {
        let d = self.basis.dimension;
        let [n_sample, of_target] = fill_sample(d, sources, (targets, T::ONE.ldexp(units.position)), self.sample);
        let sample = self.sample.get_mut(..n_sample * d).present()?;
        sample.iter_mut().for_each(|x| *x = x.ldexp(-units.position));
        let values = self.sample_values.get_mut(..n_sample).present()?;
        let slopes = self.sample_slopes.get_mut(..n_sample * d).present()?;
        alone.at(sample, values, Some(&mut *slopes), run)?;
        Ok(mean_sizes(d, sample, (values, slopes), of_target))
    }
}

/// A level.
struct AtLevel<'a, T> {
    depth: usize,
    allowed: Allowed<T>,
    /// Computes the kernel's values at some points, which are in widths of the level's cells and may be overwritten.
    kernel: &'a mut Values<'a, T>,
}

/// See [`AtLevel::kernel`].
type Values<'a, T> = dyn FnMut(&mut [T], &mut [T], &mut Run<'_>) -> Result<()> + 'a;

/// The moments of all cells and their local expansions. Of vectors those of one component stand before those of the next.
pub(super) type Both<'a, T> = (&'a [T], &'a mut [T]);

/// Adds to the local expansions of all levels what the moments give to them.
pub(super) fn across<T: Real>(
    (units, tolerance, mean): (Units<T>, f64, [T; 2]),
    expansions: &mut Expansions<'_, T>,
    cells: &super::cells::Cells<'_, T>,
    (moments, locals): Both<'_, T>,
    (far, alone): (&mut Far, &mut Alone<'_, T>),
    workers: &mut Workers<'_>,
    run: &mut Run<'_>,
) -> Result<()> {
    let Expansions { basis, nodes, operators, .. } = expansions;
    let passes = Passes { cells, dimension: basis.dimension, series: &*basis };
    let share = T::from_f64(SHARE * tolerance);
    for depth in FIRST..cells.n_levels() {
        let width = cells.width(depth).ldexp(-units.position);
        let allowed = Allowed { share, mean: [mean[0], mean[1] * width] };
        let mut at_level = |points: &mut [T], values: &mut [T], run: &mut Run<'_>| {
            points.iter_mut().for_each(|x| *x *= width);
            alone.at(points, values, None, run)
        };
        let mut level = AtLevel { depth, allowed, kernel: &mut at_level };
        let mut step = Step { passes: &passes, basis, nodes, room: operators };
        step.across(&mut level, (moments, &mut *locals), far, workers, run)?;
    }
    Ok(())
}

/// What the operators of a level need.
struct Step<'a, 'c, 'w, T> {
    passes: &'a Passes<'a, 'c, T>,
    basis: &'a Basis<'w, T>,
    nodes: &'a Nodes<'w, T>,
    room: &'a mut Operators<'w, T>,
}

impl<T: Real> Step<'_, '_, '_, T> {
    /// Adds what the cells of a level give to each other.
    fn across(
        &mut self,
        of: &mut AtLevel<'_, T>,
        (moments, locals): Both<'_, T>,
        far: &mut Far,
        workers: &mut Workers<'_>,
        run: &mut Run<'_>,
    ) -> Result<()> {
        let (cells, depth, stride) = (self.passes.cells, of.depth, self.basis.stride);
        let (range, size) = (cells.of_level(depth), (cells.len() * stride).max(1));
        let counts = self.passes.counts((depth, far))?;
        let mut wanted = counts.iter().enumerate().filter(|(_, count)| **count > 0).map(|(class, _)| class).peekable();
        while wanted.peek().is_some() {
            let mut n = 0;
            for slot in self.room.classes.iter_mut() {
                let Some(class) = wanted.next() else { break };
                *slot = [class as u32, 0];
                n += 1;
            }
            self.prepare(n, of, far, run)?;
            for (component, locals) in locals.chunks_mut(size.max(1)).enumerate() {
                let moments = moments.get(component * size..).and_then(|rest| rest.get(..size)).present()?;
                let own = locals.get_mut(range.start * stride..range.end * stride).present()?;
                self.apply(n, (depth, far), (moments, own), workers, run)?;
            }
        }
        Ok(())
    }

    /// Makes the first `n` operators.
    fn prepare(&mut self, n: usize, of: &mut AtLevel<'_, T>, far: &mut Far, run: &mut Run<'_>) -> Result<()> {
        let (depth, allowed) = (of.depth, &of.allowed);
        let Self { basis, nodes: of_nodes, room, .. } = self;
        let (basis, of_nodes): (&Basis<'_, T>, &Nodes<'_, T>) = (basis, of_nodes);
        let (d, nodes, along) = (basis.dimension.max(1), room.nodes.max(1), of_nodes.n.max(1));
        let points = room.points.get_mut(..n * nodes * d).present()?;
        for (points, &[class, _]) in points.chunks_mut((nodes * d).max(1)).zip(&*room.classes) {
            let step = step_of(class as usize);
            let (at_nodes, last) = points.split_at_mut_checked((nodes - 1) * d).present()?;
            last.iter_mut().zip(operators::closest(class as usize)).for_each(|(x, at)| *x = T::from_usize(at));
            for (number, point) in at_nodes.chunks_mut(d.max(1)).enumerate() {
                let mut left = number;
                for (x, &step) in point.iter_mut().zip(&step) {
                    *x = T::from_usize(step) + of_nodes.at.get(left % along).copied().present()?;
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
            *order = match operators::interpolate(of_nodes, basis, at, room, allowed) {
                Quality::Zero => 0,
                Quality::Rough => u32::MAX,
                Quality::Order(order) => {
                    operators::fill(of_nodes, basis, (values, order), (numbers, columns))?;
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
        at: (usize, &Far),
        (moments, own): Both<'_, T>,
        workers: &mut Workers<'_>,
        run: &Run<'_>,
    ) -> Result<()> {
        let (basis, level) = (self.basis, run.level);
        let Operators { numbers, columns, size, blocks, classes, .. } = &*self.room;
        let mut lists = [u8::MAX; CLASSES];
        for (list, [class, _]) in classes.iter().take(n).enumerate().filter(|(_, [_, order])| *order > 0) {
            *lists.get_mut(*class as usize).present()? = list as u8;
        }
        let step = |list: usize, pairs: &[Pair], (from, to, scratch): (&[T], &mut [T], &mut [T])| {
            let numbers = numbers.get(list * size..).and_then(|rest| rest.get(..*size)).present_or_default();
            let columns = columns.get(list * blocks..).and_then(|rest| rest.get(..*blocks)).present_or_default();
            level.run(Apply { basis, matrix: Matrix { numbers, columns }, pairs, from, to, scratch });
        };
        self.passes.across(at, &lists, &step, (moments, own), workers, run)
    }
}
