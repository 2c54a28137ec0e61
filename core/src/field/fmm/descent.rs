//! Who meets whom, and the local expansions, from the root of the target boxes down.
//!
//! A target box is visited with a list of open source boxes, which its parent has left to it. Each open box is, for this target box,
//!
//! * well separated ([`super::settings`]), and no mollified pair between them: its expansion is translated;
//! * else left open for the parts of the target box, if that is the larger one or the source box is a leaf;
//! * else divided, and its parts looked at in the same way.
//!
//! At a leaf nothing is left open: source leaves that are near are met pair by pair. Nothing is kept of these lists but what the boxes on the way down need. Parts
//! of a box stand next to each other in the lists, so near leaves that follow each other become one range of sources.
//!
//! Boxes of more than [`TASK`] targets come first, one after the other ([`Descent::begin`]); then every largest box of fewer is a task. A task repeats the lists of
//! the boxes above it, but not their translations. Where room for a list ends, the pair of boxes is summed pair by pair, which is always right: it takes longer.

use super::expansions::{Lower, Order, Room, Scatter};
use super::translate::Translate;
use super::tree::{Shape, Tree};
use super::upward::TASK;
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::field::pairs::{Groups, Near, Task, Units, least_distance};
use crate::memory::{Carve, Space};
use crate::real::Real;
use crate::simd::{Level, fetch_ahead};

/// Room for open boxes, for boxes to be divided, well separated ones, near ones, depths below a task's box, groups and ranges.
const OPEN: usize = 8192;
const DIVIDED: usize = 1024;
const FAR: usize = 128;
const NEAR: usize = 64;
const DEPTH: usize = 48;
const GROUPS: usize = 256;
const RANGES: usize = 4096;
/// The exponent of [`Descent::least`].
pub(super) const fn least_square<T: Real>() -> i32 {
    if T::DIGITS > 24 { -400 } else { -56 }
}

/// No box.
const NONE: u32 = u32::MAX;

/// What all tasks share.
pub(super) struct Descent<'a, 'w, T: Real> {
    pub order: Order<'a, T>,
    pub units: Units<T>,
    pub sources: &'a Tree<'w, T>,
    /// How many sources there are.
    pub count: usize,
    /// The roots of the source trees.
    pub roots: &'a [u32],
    /// The expansions of the source boxes.
    pub from: &'a [T],
    pub targets: &'a Tree<'w, T>,
    /// The targets, in true units.
    pub points: &'a [[T; 2]],
    pub potential: bool,
    /// Whether the support of a pair may be that of the target.
    pub symmetric: bool,
    /// [`super::settings::OPENING`], and the least square of a distance between centres: its inverse must be a normal number.
    pub opening: T,
    pub least: T,
    /// The way to true potentials, gradients and second derivatives, in factors one after the other.
    pub scales: [[T; 3]; 3],
    /// The box of each task, and the number of the local expansion of the box above it.
    pub tasks: &'a [[u32; 2]],
    pub starts: &'a [u32],
    /// Local expansions of boxes above tasks.
    pub tops: &'a [T],
}

/// The scratch of a worker.
pub(super) struct Scratch<'s, T> {
    lists: Lists<'s>,
    pending: &'s mut [[u32; 5]],
    locals: &'s mut [T],
    groups: &'s mut [[u32; 4]],
    ranges: &'s mut [[u32; 3]],
}

/// Numbers of a local expansion.
pub(super) fn local_length(stride: usize) -> usize {
    2 * stride + 1
}

impl<'s, T: Real> Scratch<'s, T> {
    /// The layout, for expansions of this stride.
    pub fn layout(space: &mut impl Space<'s>, stride: usize) -> Result<Self> {
        Ok(Self {
            // Every box is written to the end of every list.
            lists: Lists {
                open: space.try_array(OPEN + 1)?,
                divided: space.try_array(DIVIDED + 1)?,
                near: space.try_array(NEAR)?,
                far: space.try_array(FAR)?,
                ..Lists::default()
            },
            pending: space.try_array(DEPTH + 2)?,
            locals: space.try_array(DEPTH * local_length(stride))?,
            groups: space.try_array(GROUPS)?,
            ranges: space.try_array(RANGES)?,
        })
    }
}

/// What the boxes above tasks leave to them.
pub(super) struct Tops<'w, T> {
    /// Local expansions.
    pub locals: &'w mut [T],
    pub tasks: &'w mut [[u32; 2]],
    pub starts: &'w mut [u32],
}

/// The visits of a task.
struct Walk<'a, 's, 'w, T: Real> {
    of: &'a Descent<'a, 'w, T>,
    level: Level,
    scratch: Scratch<'s, T>,
    room: Room<T>,
    n_groups: usize,
    n_ranges: usize,
    /// The first range of the group that is being made.
    first_range: usize,
}

/// The lists of a visit, and how many boxes are on each; where the open ones end.
#[derive(Default)]
struct Lists<'s> {
    open: &'s mut [u32],
    divided: &'s mut [u32],
    near: &'s mut [u32],
    far: &'s mut [u32],
    n_open: usize,
    n_divided: usize,
    n_near: usize,
    n_far: usize,
}

impl Lists<'_> {
    /// Whether the lists of well separated or of near boxes may have no room for two more.
    #[inline(always)]
    fn are_full(&self) -> bool {
        (self.n_far + 2 > FAR) | (self.n_near + 2 > NEAR)
    }
}

/// A target box, and what tells how it stands to a source box.
struct Looks<'a, 'w, T: Real> {
    of: &'a Descent<'a, 'w, T>,
    target: Shape<T>,
    /// Of the largest source box that is as far from it as `opening` asks of any: `opening` times its own radius.
    opened: T,
    is_leaf: bool,
}

impl<T: Real> Looks<'_, '_, T> {
    /// Whether a source box is well separated from the target box and nothing between them is mollified.
    #[inline(always)]
    fn is_far(&self, source: &Shape<T>) -> bool {
        let Self { of, target, opened, .. } = self;
        let (dx, dy) = (source.centre[0] - target.centre[0], source.centre[1] - target.centre[1]);
        let square = dx * dx + dy * dy;
        let (a, b) = (source.radius + *opened, target.radius + of.opening * source.radius);
        let sum = if a > b { a } else { b };
        let reach = of.reach(source, target);
        let is_clear = reach == T::ZERO || Descent::is_apart(source, target, reach);
        // All of them, without a branch between them.
        is_clear & (sum * sum < of.opening * of.opening * square) & (square > of.least)
    }

    /// Puts a source box on the list of what is to be done with it. It is written to all of them, and then counted in one: which one it is, is hard to predict.
    #[inline(always)]
    fn look(&self, source: u32, lists: &mut Lists<'_>) -> Result<()> {
        let shape = self.of.sources.shape(source as usize);
        let is_far = self.is_far(&shape);
        let is_leaf = self.of.sources.parts(source as usize).is_none();
        let is_small = is_leaf | (self.target.radius >= shape.radius);
        let is_open = !is_far & !self.is_leaf & is_small & (lists.n_open < OPEN);
        let is_divided = !is_far & !is_leaf & (self.is_leaf | !is_small) & (lists.n_divided < DIVIDED);
        for (list, n, is) in [
            (&mut *lists.far, &mut lists.n_far, is_far),
            (&mut *lists.open, &mut lists.n_open, is_open),
            (&mut *lists.divided, &mut lists.n_divided, is_divided),
            (&mut *lists.near, &mut lists.n_near, !(is_far | is_open | is_divided)),
        ] {
            *list.get_mut(*n).present()? = source;
            *n += usize::from(is);
        }
        Ok(())
    }
}

/// What to do with the boxes that a target box meets.
struct Meet<'t, 'l, T> {
    /// The targets of the box, counted from the task's first, and who sums pairs; none above tasks.
    near: Option<([u32; 2], &'t mut dyn Task<T>)>,
    /// The local expansion; none where it is there already.
    local: Option<&'l mut [T]>,
    leaf: bool,
}

impl<T: Real> Descent<'_, '_, T> {
    /// The largest support of a pair of two boxes.
    #[inline(always)]
    fn reach(&self, source: &Shape<T>, target: &Shape<T>) -> T {
        if self.symmetric { source.reach.max(target.reach) } else { source.reach }
    }

    /// Whether all pairs of two boxes are farther from each other than `reach`.
    #[inline(always)]
    fn is_apart(source: &Shape<T>, target: &Shape<T>, reach: T) -> bool {
        let gap = |axis: usize| {
            let of = |values: [T; 2]| values.get(axis).copied().present_or(T::ZERO);
            let gap = (of(source.centre) - of(target.centre)).abs() - of(source.half) - of(target.half);
            if gap > T::ZERO { gap } else { T::ZERO }
        };
        let (x, y, reach) = (gap(0), gap(1), reach * (T::ONE + T::from_f64(64.0) * T::EPSILON));
        x * x + y * y > reach * reach
    }

    /// Visits the boxes of more than [`TASK`] targets. Returns how many tasks there are.
    pub fn begin(&self, scratch: &mut [u8], level: Level, to: Tops<'_, T>) -> Result<usize> {
        let Tops { locals: tops, tasks, starts } = to;
        let length = local_length(self.order.stride);
        let mut walk = Walk::new(self, level, scratch)?;
        let (mut n_tops, mut n_tasks, mut waiting) = (0, 0, 1);
        // A box above tasks adds one task to those that there would be without it.
        let room = tops.len().checked_div(length).unwrap_or(0).min(tasks.len()).min(starts.len().saturating_sub(1));
        let open = walk.start(0)?;
        *walk.scratch.pending.first_mut().present()? = [0, 0, open, NONE, NONE];
        while waiting > 0 {
            waiting -= 1;
            let [k, from, end, above, slot] = walk.scratch.pending.get(waiting).copied().present()?;
            let target = k as usize;
            let points = self.targets.points(target);
            let parts =
                self.targets.parts(target).filter(|_| points.len() > TASK && n_tops + 1 < room && waiting + 2 <= DEPTH);
            let Some([first, second]) = parts else {
                *tasks.get_mut(n_tasks).present()? = [k, slot];
                *starts.get_mut(n_tasks).present()? = points.start as u32;
                n_tasks += 1;
                continue;
            };
            let (before, local) = tops.split_at_mut_checked(n_tops * length).present()?;
            let local = local.get_mut(..length).present()?;
            local.fill(T::ZERO);
            let large = before.get((slot as usize).saturating_mul(length)..).and_then(|rest| rest.get(..length));
            if let (false, Some(large)) = (above == NONE, large) {
                let (from, shape) = ((large, self.targets.shape(above as usize)), self.targets.shape(target));
                level.run(Lower { order: self.order, from, shape, room: &mut walk.room, to: &mut *local });
            }
            let next = walk.visit(target, [from, end], Meet { near: None, local: Some(local), leaf: false })?;
            let number = n_tops as u32;
            n_tops += 1;
            let entries = [[second as u32, end, next, k, number], [first as u32, end, next, k, number]];
            push(walk.scratch.pending, &mut waiting, entries)?;
        }
        *starts.get_mut(n_tasks).present()? = self.targets.points(0).end as u32;
        Ok(n_tasks)
    }
}

impl<T: Real> Near<T> for Descent<'_, '_, T> {
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
        for output in to.outputs().into_iter().flatten() {
            output.fill(T::ZERO);
        }
        let [node, slot] = self.tasks.get(task).copied().present()?;
        let length = local_length(self.order.stride);
        let mut walk = Walk::new(self, level, scratch)?;
        let tree = self.targets;
        let all = tree.points(node as usize);
        let start = all.start as u32;
        let relative = |points: core::ops::Range<usize>| [points.start as u32 - start, points.end as u32 - start];
        // The boxes above.
        let (mut k, mut above, mut from) = (0, NONE, 0);
        let mut end = walk.start(0)?;
        while k != node as usize {
            let meet = Meet { near: Some((relative(all.clone()), &mut *to)), local: None, leaf: false };
            let next = walk.visit(k, [from, end], meet)?;
            walk.close(relative(all.clone()), to);
            let [first, second] = tree.parts(k).present()?;
            above = k as u32;
            k = if (node as usize) < second { first } else { second };
            (from, end) = (end, next);
        }
        *walk.scratch.pending.first_mut().present()? = [node, from, end, above, 0];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let [k, from, end, above, depth] = walk.scratch.pending.get(waiting).copied().present()?;
            let (target, depth) = (k as usize, depth as usize);
            let shape = tree.shape(target);
            let parts = tree.parts(target).filter(|_| depth + 1 < DEPTH && waiting + 2 <= DEPTH);
            // The scratch's locals are taken out while a box is visited.
            let locals = core::mem::take(&mut walk.scratch.locals);
            let (before, local) = locals.split_at_mut_checked(depth * length).present()?;
            let local = local.get_mut(..length).present()?;
            local.fill(T::ZERO);
            let large = match depth.checked_sub(1) {
                Some(last) => before.get(last * length..),
                None => self.tops.get((slot as usize).saturating_mul(length)..),
            };
            if let (false, Some(large)) = (above == NONE, large.and_then(|rest| rest.get(..length))) {
                let from = (large, tree.shape(above as usize));
                level.run(Lower { order: self.order, from, shape, room: &mut walk.room, to: &mut *local });
            }
            let points = relative(tree.points(target));
            let meet = Meet { near: Some((points, &mut *to)), local: Some(&mut *local), leaf: parts.is_none() };
            let next = walk.visit(target, [from, end], meet)?;
            match parts {
                Some([first, second]) => {
                    let depth = depth as u32 + 1;
                    let entries = [[second as u32, end, next, k, depth], [first as u32, end, next, k, depth]];
                    push(walk.scratch.pending, &mut waiting, entries)?;
                }
                None => {
                    let [from, to_end] = points.map(|at| at as usize);
                    let [potential, gradient, _, hessian] = to.outputs();
                    level.run(Scatter {
                        order: self.order,
                        from: &*local,
                        shape,
                        points: (self.points.get(tree.points(target)).present()?, self.factor()),
                        potential: potential.and_then(|p| p.get_mut(from..to_end)),
                        gradient: gradient.and_then(|g| g.as_chunks_mut().0.get_mut(from..to_end)),
                        hessian: hessian.and_then(|h| h.as_chunks_mut().0.as_chunks_mut().0.get_mut(from..to_end)),
                        scales: self.scales,
                    });
                    walk.close(points, to);
                }
            }
            walk.scratch.locals = locals;
        }
        walk.flush(to);
        Ok(())
    }
}

impl<T: Real> Descent<'_, '_, T> {
    /// What a true coordinate is multiplied by.
    fn factor(&self) -> T {
        T::ONE.ldexp(self.units.position)
    }
}

/// Puts two entries on a stack of so many.
#[inline(always)]
fn push<E>(stack: &mut [E], n: &mut usize, [a, b]: [E; 2]) -> Result<()> {
    let [to_a, to_b, ..] = stack.get_mut(*n..).present()? else { return Err(Error::Internal) };
    (*to_a, *to_b) = (a, b);
    *n += 2;
    Ok(())
}

impl<'a, 's, 'w, T: Real> Walk<'a, 's, 'w, T> {
    fn new(of: &'a Descent<'a, 'w, T>, level: Level, scratch: &'s mut [u8]) -> Result<Self> {
        let scratch = Scratch::layout(&mut Carve::reopen(scratch)?, of.order.stride)?;
        Ok(Self { of, level, scratch, room: Room::new(), n_groups: 0, n_ranges: 0, first_range: 0 })
    }

    /// Opens the roots; where the list ends.
    fn start(&mut self, at: usize) -> Result<u32> {
        let n = self.of.roots.len();
        let slots = self.scratch.lists.open.get_mut(at..at + n).present()?;
        slots.iter_mut().zip(self.of.roots).for_each(|(slot, &root)| *slot = root);
        Ok((at + n) as u32)
    }

    /// Visits a target box with the open boxes from one place to another. What it leaves open follows these; returns its end.
    fn visit(&mut self, k: usize, [from, end]: [u32; 2], mut meet: Meet<'_, '_, T>) -> Result<u32> {
        let (of, target) = (self.of, self.of.targets.shape(k));
        let looks = Looks { of, target, opened: of.opening * target.radius, is_leaf: meet.leaf };
        let mut lists = core::mem::take(&mut self.scratch.lists);
        lists.n_open = end as usize;
        for at in from as usize..end as usize {
            let source = lists.open.get(at).copied().present()?;
            looks.look(source, &mut lists)?;
            if lists.are_full() {
                self.finish(&target, &mut lists, &mut meet);
            }
        }
        let mut at = 0;
        while at < lists.n_divided {
            let source = lists.divided.get(at).copied().present()?;
            let [first, second] = of.sources.parts(source as usize).present()?;
            looks.look(first as u32, &mut lists)?;
            looks.look(second as u32, &mut lists)?;
            if lists.are_full() {
                self.finish(&target, &mut lists, &mut meet);
            }
            at += 1;
        }
        self.finish(&target, &mut lists, &mut meet);
        lists.n_divided = 0;
        let next = lists.n_open as u32;
        self.scratch.lists = lists;
        Ok(next)
    }

    /// Does what the lists of well separated and of near boxes ask. Not in line, so that the loops before it keep their registers.
    #[inline(never)]
    fn finish(&mut self, target: &Shape<T>, lists: &mut Lists<'_>, meet: &mut Meet<'_, '_, T>) {
        if let Some(local) = meet.local.as_deref_mut() {
            self.translate(target, lists.far.get(..lists.n_far).unwrap_or_default(), local);
        }
        for &source in lists.near.get(..lists.n_near).unwrap_or_default() {
            self.meet(source, target, meet);
        }
        (lists.n_far, lists.n_near) = (0, 0);
    }

    /// Translates the well separated boxes that wait for it.
    fn translate(&mut self, target: &Shape<T>, list: &[u32], local: &mut [T]) {
        let of = self.of;
        let each = 2 * of.order.stride;
        for &source in list {
            fetch_ahead(of.from.get(source as usize * each..).and_then(|rest| rest.get(..each)).present_or(&[]));
        }
        if !list.is_empty() {
            let log_exponent = T::from_i32(of.units.position.saturating_mul(-2));
            self.level.run(Translate {
                order: of.order,
                tree: of.sources,
                from: of.from,
                list,
                shape: *target,
                log_exponent: of.potential.then_some(log_exponent),
                room: &mut self.room,
                to: local,
            });
        }
    }

    /// Lists the sources of a box as near.
    fn meet(&mut self, source: u32, target: &Shape<T>, meet: &mut Meet<'_, '_, T>) {
        let Some((targets, to)) = &mut meet.near else { return };
        let shape = &self.of.sources.shape(source as usize);
        let reach = self.of.reach(shape, target).max(least_distance::<T>());
        let apart = u32::from(Descent::is_apart(shape, target, reach));
        let tree = self.of.sources;
        let range = match tree.parts(source as usize) {
            None => tree.sources(source as usize),
            Some(_) => {
                let points = tree.points(source as usize);
                [points.start as u32, points.end as u32]
            }
        };
        let last = self.n_ranges.checked_sub(1).filter(|&last| last >= self.first_range);
        if let Some([_, end, same]) = last.and_then(|last| self.scratch.ranges.get_mut(last))
            && *end == range[0]
            && *same == apart
        {
            *end = range[1];
            return;
        }
        if self.n_ranges == RANGES {
            self.close(*targets, &mut **to);
            self.flush(&mut **to);
        }
        if let Some(slot) = self.scratch.ranges.get_mut(self.n_ranges) {
            *slot = [range[0], range[1], apart];
            self.n_ranges += 1;
        }
    }

    /// Ends the group of ranges of some targets.
    fn close(&mut self, [start, end]: [u32; 2], to: &mut dyn Task<T>) {
        if self.n_ranges == self.first_range {
            return;
        }
        if let Some(slot) = self.scratch.groups.get_mut(self.n_groups) {
            *slot = [start, end, self.first_range as u32, self.n_ranges as u32];
            self.n_groups += 1;
        }
        self.first_range = self.n_ranges;
        if self.n_groups == GROUPS {
            self.flush(to);
        }
    }

    /// Sums the pairs of all groups.
    fn flush(&mut self, to: &mut dyn Task<T>) {
        let groups = self.scratch.groups.get(..self.n_groups).unwrap_or_default();
        let ranges = self.scratch.ranges.get(..self.n_ranges).unwrap_or_default();
        to.add_near(Groups { groups, ranges });
        (self.n_groups, self.n_ranges, self.first_range) = (0, 0, 0);
    }
}
