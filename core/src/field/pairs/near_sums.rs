//! The sums of [`super::near`].

use core::sync::atomic::{AtomicUsize, Ordering};

use super::Call;
use super::erased::{ErasedKernel, Shared, Tally};
use super::near::{Groups, NearCall, Task, each_group, part};
use super::packed::{Packed, Units};
use super::passes::passes;
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Chunks, Ranges, Run, Statistics, par_chunks};
use crate::field::Outputs;
use crate::memory::Carve;
use crate::real::Real;
use crate::simd::Level;

/// A task of [`sums`].
struct Piece<'a, T: Real, const D: usize> {
    shared: &'a Shared<'a, T, D>,
    targets: &'a [[T; D]],
    /// Their core radii, where a pair's depends on them.
    radii: &'a [T],
    outputs: Outputs<'a, T, D>,
    level: Level,
    pairs: u64,
    /// What became of the sums.
    result: Result<()>,
}

impl<T: Real, const D: usize> Task<T> for Piece<'_, T, D> {
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
            let sources: u64 = ranges.unwrap_or_default().iter().map(|&[from, to, _]| u64::from(to - from)).sum();
            self.pairs += sources * targets.len() as u64;
        }
        let all = 0..self.targets.len();
        let outputs = part(&mut self.outputs, all);
        let result = passes(self.shared, (self.targets, self.radii), outputs, Some(groups), self.level);
        self.result = self.result.and(result);
    }
}

/// Overwrites the outputs, those of the tasks in the order of the targets.
pub(super) fn sums<T: Real, const D: usize>(
    potentials: bool,
    (kernel, units): (&dyn ErasedKernel<T, D>, Units<T>),
    call: Call<'_, T, D>,
    near: NearCall<'_, T>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let Call { options, sources, targets, outputs, near: _ } = call;
    let NearCall { method, scratch, each } = near;
    let starts = method.starts();
    let extras = [sources.radii.is_some(), sources.strengths.is_some()];
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
    let shared = Shared { kernel, packed: &packed, units, options, sources, ordered: true, tally: &tally };
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
            let mut piece = Piece { shared: &shared, targets, radii, outputs, level, pairs: 0, result: Ok(()) };
            method.run(task, level, scratch, &mut piece)?;
            piece.result?;
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
