//! The expansions of all source boxes, from the leaves up.

use super::expansions::{Gather, Order, Raise, Room};
use super::tree::{MAX_ROOTS, Tree};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Ranges, Run, par_chunks};
use crate::real::Real;
use crate::simd::Level;

/// Points of a task, at most, where a box can be divided.
pub(super) const TASK: usize = 1024;

/// Room for lists of boxes above tasks, and of tasks.
pub(super) struct Lists<'w> {
    pub above: &'w mut [u32],
    pub tasks: &'w mut [u32],
    pub starts: &'w mut [u32],
}

/// Computes the expansions `to` of the boxes of `tree`, whose points are sources.
pub(super) fn expand<T: Real>(
    tree: &Tree<'_, T>,
    (points, masses): (&[[T; 2]], &[T]),
    order: Order<'_, T>,
    to: &mut [T],
    lists: Lists<'_>,
    run: &Run<'_>,
) -> Result<()> {
    let Lists { above, tasks, starts } = lists;
    let (mut n_above, mut n_tasks) = (0, 0);
    let room = tasks.len().min(starts.len().saturating_sub(1));
    let limit = above.len().min(room.saturating_sub(MAX_ROOTS));
    tree.cut(
        TASK,
        |k| {
            // A box above tasks adds one task to those that there would be without it.
            let slot = above.get_mut(n_above).filter(|_| n_above < limit);
            let has_room = slot.is_some();
            slot.into_iter().for_each(|slot| *slot = k as u32);
            n_above += usize::from(has_room);
            has_room
        },
        |k| {
            if let Some(slot) = tasks.get_mut(n_tasks) {
                *slot = k as u32;
            }
            n_tasks += 1;
        },
    );
    let (above, tasks) = (above.get(..n_above).present()?, tasks.get(..n_tasks).present()?);
    let each = 2 * order.stride;
    for (start, &k) in starts.iter_mut().zip(tasks) {
        *start = u32::try_from(k as usize * each).map_err(|_| Error::TooLarge)?;
    }
    *starts.get_mut(n_tasks).present()? = u32::try_from(tree.len() * each).map_err(|_| Error::TooLarge)?;
    let starts = starts.get(..=n_tasks).present()?;
    let (level, should_stop) = (run.level, run.should_stop);
    par_chunks(run.executor, n_tasks, Ranges::new(to, starts)?, (), &|task, to, ()| {
        if should_stop.is_some_and(|stop| stop()) {
            return Err(Error::Stopped);
        }
        let first = tasks.get(task).copied().present()? as usize;
        let mut room = Room::new();
        for k in (first..tree.last(first)).rev() {
            of_box(tree, (points, masses), order, (k, first), (&mut *to, &mut room), level)?;
        }
        Ok(())
    })?;
    let mut room = Room::new();
    let below = |&k: &u32| of_box(tree, (points, masses), order, (k as usize, 0), (&mut *to, &mut room), level);
    above.iter().rev().try_for_each(below)
}

/// The expansion of box `k`, where those below it are there already; `to` begins with that of box `first`.
fn of_box<T: Real>(
    tree: &Tree<'_, T>,
    (points, masses): (&[[T; 2]], &[T]),
    order: Order<'_, T>,
    (k, first): (usize, usize),
    (to, room): (&mut [T], &mut Room<T>),
    level: Level,
) -> Result<()> {
    let each = 2 * order.stride;
    let (to, below) = to.split_at_mut_checked((k + 1 - first) * each).present()?;
    let to = to.get_mut((k - first) * each..).present()?;
    let shape = tree.shape(k);
    to.fill(T::ZERO);
    let Some(parts) = tree.parts(k) else {
        let [start, end] = tree.sources(k).map(|at| at as usize);
        let (points, masses) = (points.get(start..end).present()?, masses.get(start..end).present()?);
        level.run(Gather { order, points, masses, shape, to });
        return Ok(());
    };
    for part in parts {
        let from = below.get((part - k - 1) * each..).and_then(|rest| rest.get(..each)).present()?;
        level.run(Raise { order, from: (from, tree.shape(part)), shape, room: &mut *room, to: &mut *to });
    }
    Ok(())
}
