//! What a leaf's targets get: the values of its local expansion, and the sums over near sources, by the engine for pairs.

use super::cells::{Cells, SOURCES, TARGETS};
use super::levels::{FIRST, Far};
use super::series::{Frame, Series, Targets};
use crate::checked::Present;
use crate::error::Result;
use crate::field::pairs::{Groups, Near, Task, Units};
use crate::memory::{Carve, Space};
use crate::real::Real;
use crate::simd::Level;

/// Targets of a task, at most, where a leaf has no more.
pub(super) const TASK: usize = 1024;
/// Room for groups of targets and ranges of sources.
const GROUPS: usize = 128;
const RANGES: usize = 4096;
/// Targets at a time where sources have vector strengths.
const SOME: usize = 64;

/// What all tasks share.
pub(super) struct Leaves<'a, 'w, T: Real> {
    pub cells: &'a Cells<'w, T>,
    pub dimension: usize,
    pub series: &'a dyn Series<T>,
    pub far: &'a Far,
    pub units: Units<T>,
    /// How many sources there are.
    pub count: usize,
    /// The local expansions of all cells; of vectors those of one component before those of the next.
    pub locals: &'a [T],
    /// Whether sources have vector strengths.
    pub vectors: bool,
    /// The targets, in true units.
    pub points: &'a [T],
    /// The leaves with targets; the first and one beyond the last of each task, and where the tasks' targets begin.
    pub list: &'a [u32],
    pub tasks: &'a [[u32; 2]],
    pub starts: &'a [u32],
}

/// The scratch of a worker.
pub(super) struct Scratch<'s, T> {
    numbers: &'s mut [T],
    groups: &'s mut [[u32; 4]],
    ranges: &'s mut [[u32; 3]],
}

impl<'s, T: Real> Scratch<'s, T> {
    /// The layout, for so many numbers of scratch of the series.
    pub fn layout(space: &mut impl Space<'s>, numbers: usize) -> Result<Self> {
        Ok(Self {
            numbers: space.try_array(numbers)?,
            groups: space.try_array(GROUPS)?,
            ranges: space.try_array(RANGES)?,
        })
    }
}

impl<T: Real> Near<T> for Leaves<'_, '_, T> {
    fn units(&self) -> Units<T> {
        self.units
    }

    fn sources(&self) -> usize {
        self.count
    }

    fn starts(&self) -> &[u32] {
        self.starts
    }

    fn run(&self, task: usize, level: Level, scratch: &mut [u8], to: &mut dyn Task<T>) -> Result<()> {
        let Scratch { numbers, groups, ranges } =
            Scratch::<T>::layout(&mut Carve::reopen(scratch)?, self.series.scratch())?;
        for output in to.outputs().into_iter().flatten() {
            output.fill(T::ZERO);
        }
        let [first, last] = self.tasks.get(task).copied().present()?;
        let start = *self.starts.get(task).present()?;
        let (mut n_groups, mut n_ranges) = (0, 0_usize);
        for &leaf in self.list.get(first as usize..last as usize).present()? {
            self.values(leaf as usize, start, level, (&mut *numbers, &mut *to))?;
            let [from, end] = self.cells.get(leaf as usize).spans[TARGETS];
            let targets = [from - start, end - start];
            let mut first_range = n_ranges;
            self.each_range(leaf as usize, |[from, end]| {
                if let Some([_, last, _]) =
                    n_ranges.checked_sub(1).filter(|&at| at >= first_range).and_then(|at| ranges.get_mut(at))
                    && *last == from
                {
                    *last = end;
                    return Ok(());
                }
                if n_ranges == RANGES {
                    // Some ranges of these targets now, the others later.
                    *groups.get_mut(n_groups).present()? =
                        [targets[0], targets[1], first_range as u32, n_ranges as u32];
                    let groups = groups.get(..=n_groups).present()?;
                    to.add_near(Groups { groups, ranges });
                    (n_groups, n_ranges, first_range) = (0, 0, 0);
                }
                *ranges.get_mut(n_ranges).present()? = [from, end, 0];
                n_ranges += 1;
                Ok(())
            })?;
            if n_ranges > first_range {
                *groups.get_mut(n_groups).present()? = [targets[0], targets[1], first_range as u32, n_ranges as u32];
                n_groups += 1;
            }
            if n_groups + 1 >= GROUPS {
                let groups = groups.get(..n_groups).present()?;
                to.add_near(Groups { groups, ranges: ranges.get(..n_ranges).present()? });
                (n_groups, n_ranges) = (0, 0);
            }
        }
        let groups = groups.get(..n_groups).present()?;
        to.add_near(Groups { groups, ranges: ranges.get(..n_ranges).present()? });
        Ok(())
    }
}

impl<T: Real> Leaves<'_, '_, T> {
    /// Adds the values of a leaf's local expansion.
    fn values(&self, leaf: usize, start: u32, level: Level, (scratch, to): (&mut [T], &mut dyn Task<T>)) -> Result<()> {
        let (series, cell) = (self.series, self.cells.get(leaf));
        let (d, depth, stride) = (self.dimension, cell.level as usize, series.stride());
        if depth < FIRST {
            return Ok(());
        }
        let points = cell.points(TARGETS);
        let at = points.start - start as usize..points.end - start as usize;
        let per_half = T::TWO / self.cells.width(depth);
        let frame = Frame { centre: self.cells.centre(&cell), per_half, factor: T::ONE.ldexp(self.units.position) };
        let of_component = |component: usize| {
            let start = (component * self.cells.len() + leaf) * stride;
            self.locals.get(start..).and_then(|rest| rest.get(..stride)).present()
        };
        let targets = self.points.get(points.start * d..points.end * d).present()?;
        let [potential, gradient, ..] = to.outputs();
        let gradient = gradient.and_then(|g| g.get_mut(at.start * d..at.end * d));
        if !self.vectors {
            let potential = potential.and_then(|p| p.get_mut(at));
            series.values(of_component(0)?, Targets { points: targets, frame, potential, gradient }, scratch, level);
            return Ok(());
        }
        for (points, to) in targets.chunks(3 * SOME).zip(gradient.unwrap_or_default().chunks_mut(3 * SOME)) {
            for component in 0..3 {
                let mut slopes = [T::ZERO; 3 * SOME];
                let gradient = slopes.get_mut(..points.len());
                let to_slopes = Targets { points, frame, potential: None, gradient };
                series.values(of_component(component)?, to_slopes, scratch, level);
                // grad A x e of the unit vector e along the component's axis.
                for (to, &[x, y, z]) in to.as_chunks_mut::<3>().0.iter_mut().zip(slopes.as_chunks::<3>().0) {
                    let product = match component {
                        0 => [T::ZERO, z, -y],
                        1 => [-z, T::ZERO, x],
                        _ => [y, -x, T::ZERO],
                    };
                    to.iter_mut().zip(product).for_each(|(to, x)| *to += x);
                }
            }
        }
        Ok(())
    }

    /// The ranges of sources that the targets of a leaf meet one by one.
    fn each_range(&self, leaf: usize, mut meet: impl FnMut([u32; 2]) -> Result<()>) -> Result<()> {
        let cells = self.cells;
        let mut some = |k: usize| {
            let [from, end] = cells.get(k).spans[SOURCES];
            if end > from { meet([from, end]) } else { Ok(()) }
        };
        cells.each_near(leaf, &mut some)?;
        let mut next = Some(leaf);
        while let Some(k) = next {
            let cell = cells.get(k);
            cells.each_apart(
                k,
                |other, steps| {
                    if self.far.is_far(cells, (k, other), steps) { Ok(()) } else { some(other) }
                },
            )?;
            next = cell.parent();
        }
        Ok(())
    }
}
