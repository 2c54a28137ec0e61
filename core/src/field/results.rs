//! Results in an order of a method's own, back in the caller's.

use crate::checked::Present;
use crate::error::Result;
use crate::exec::{Chunks, Run, par_chunks};
use crate::real::Real;

/// Targets of a task.
const TARGETS: usize = 4096;

/// An output: so many numbers for each target.
pub(super) struct Output<'a, T> {
    pub each: usize,
    pub from: &'a [T],
    /// Where it goes; none: it is not wanted.
    pub to: Option<&'a mut [T]>,
}

/// Brings results to the caller's order: that of target k is number `ranks[k]`. In the plane the components of the second output are combined
/// ([`super::Options::combination`]).
pub(super) fn bring_back<T: Real, const N: usize>(
    ranks: &[u32],
    mut outputs: [Output<'_, T>; N],
    combination: (f64, f64),
    run: &Run<'_>,
) -> Result<()> {
    for (number, Output { each, from, to }) in outputs.iter_mut().enumerate() {
        let Some(to) = to else { continue };
        let combination = Some(combination).filter(|&pair| number == 1 && *each == 2 && pair != (1.0, 0.0));
        match each {
            1 => copy::<T, 1>(ranks, from, to, run)?,
            2 => copy::<T, 2>(ranks, from, to, run)?,
            3 => copy::<T, 3>(ranks, from, to, run)?,
            _ => copy::<T, 4>(ranks, from, to, run)?,
        }
        if let Some((a, b)) = combination {
            combine(to.as_chunks_mut().0, (T::from_f64(a), T::from_f64(b)));
        }
    }
    Ok(())
}

/// Brings outputs of `N` numbers a target to the caller's order.
fn copy<T: Real, const N: usize>(ranks: &[u32], from: &[T], to: &mut [T], run: &Run<'_>) -> Result<()> {
    let (from, to) = (from.as_chunks::<N>().0, to.as_chunks_mut::<N>().0);
    par_chunks(run.executor, ranks.len().div_ceil(TARGETS), Chunks::new(to, TARGETS), (), &|task, to, ()| {
        let ranks = ranks.get(task.saturating_mul(TARGETS)..).present()?;
        for (to, &rank) in to.iter_mut().zip(ranks) {
            *to = from.get(rank as usize).copied().present()?;
        }
        Ok(())
    })
}

/// a times a vector and b times the vector rotated by +90 degrees. A factor of zero takes nothing from a component that has overflowed.
fn combine<T: Real>(vectors: &mut [[T; 2]], (a, b): (T, T)) {
    let times = |factor: T, x: T| if factor == T::ZERO { T::ZERO } else { factor * x };
    for vector in vectors {
        let [x, y] = *vector;
        *vector = [times(a, x) - times(b, y), times(a, y) + times(b, x)];
    }
}
