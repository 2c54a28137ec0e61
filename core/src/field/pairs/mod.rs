//! Sums over all pairs: the one engine, whatever the kernel.
//!
//! ```text
//! for each task of 128 targets (in parallel; entered once for the processor's instruction set)
//!     for each register block of 1 to 4 vectors of targets
//!         for each mass class (one, unless masses span more than 2^100 in f32, 2^900 in f64)
//!             for each block of 256 sources
//!                 kernel.add_block: one source after the other against the register block
//!                 pairs that the kernel leaves out as too close for its fast path: `close`, in lanes
//!                 other pairs that it leaves out: `exact`, one by one
//!                 the block's sums join the total
//!         the totals in true units go to the outputs
//! ```
//!
//! * [`packed`]: sources without the massless ones, in units in which nothing overflows, with the bounds of each block;
//! * [`lanes`]: a register block of targets, its sums, and what is common to all kernels;
//! * [`erased`], [`ready`], [`passes`]: the loops, compiled once for all kernels, and how they call one; [`near`], [`near_sums`]: those over nearby pairs alone;
//! * [`newtonian`], [`smooth`], [`tabulated`], [`called`]: the kernels, each an implementation of [`PairKernel`];
//! * [`left_out`], [`close`], [`exact`]: pairs outside the range of the fast path;
//! * [`output`]: from sums in units to results.
//!
//! # Terms
//! * *lane*: one target in a vector register; *register block*: the vectors of targets that stay in registers while sources pass;
//! * *in units*: coordinates and masses times powers of two that bring the largest ones near 1 ([`packed::Units`]); *rescaled*: the same for close pairs;
//! * *served*: a lane whose pair the kernel's fast path computes; *left out*: one that it does not (too close, or beyond the ends of its table);
//! * *deferred*: a source with a lane that was left out; the block's deferred sources are visited once more ([`left_out`]);
//! * *rough*: where a table has no Laplacian, because the mollifier's edge is not smooth enough.
//!
//! # Outputs
//! A kernel sums what is wanted in one pass or in two ([`Passes`]), and second derivatives in one more for each row but the last: these need no more of a kernel than what
//! gradient and Laplacian do, and a sum's [`Group`] makes the row of it. But the operations that lead to one output are the same
//! whatever else is wanted, so its bits are too (test `field_bounds::outputs_do_not_change_each_others_bits`).
//!
//! # Error
//! Every term carries c u, with u the unit roundoff and c stated by each kernel. Terms are added in blocks of B and the blocks' sums one after
//! the other, so to first order
//!
//! `|computed - exact| <= (c + B + n / B) u S`, S = sum_j |m_j| s(x_i - x_j), componentwise for gradients,
//!
//! where s is the kernel's scale: |K|, |grad K|, for the Newtonian kernel |K| + 1/(2 pi) in the plane and max psi_delta for its Laplacian; for kernels
//! in tables the largest of each over a range of distances ([`tabulated`]). B = 256, or with
//! [`Accumulation::Compensated`] B = 8 and blocks are added in double-word arithmetic: `(c + 8 + 4) u S + (n / 4) u^2 S`.
//! Roundings of sums are as good as independent, so errors of a few u are what is seen. The bound supposes that no result underflows.
//! Tests: `levels direct::the_error_bound_holds_in_f64` and `.._f32`, `field_bounds`.

mod called;
mod close;
mod erased;
mod exact;
#[cfg(feature = "small")]
mod firmware;
mod instances;
mod lanes;
mod left_out;
mod near;
mod near_sums;
mod newtonian;
mod output;
mod packed;
mod passes;
mod ready;
#[cfg(any(test, feature = "small"))]
mod single;
mod smooth;
mod tabulated;

#[cfg(feature = "small")]
pub(super) use firmware::evaluate;
#[cfg(not(feature = "small"))]
pub(super) use instances::{ErasedCall, Sum, erased, evaluate, in_double, in_single};
pub(in crate::field) use near::NearCall;
pub(in crate::field) use packed::{Packed, Units, power_of_two_pair};
#[cfg(not(feature = "small"))]
pub(in crate::field) use {
    near::{Groups, Near, Task},
    newtonian::support,
    packed::{largest, least_distance},
};

use super::{Options, Outputs, PairRadius, Sources};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Chunks, Run, Statistics, par_chunks};
use crate::memory::{Carve, Measure};
use crate::real::Real;
use crate::simd::Isa;
use erased::{ErasedKernel, Shared, Tally};
use lanes::{Bounds, Deferred, Group, List, Want, kept};
use output::{Contribution, Scales};
use passes::passes;
use ready::Ready;

/// Targets of one task: a multiple of every register block, so that blocks, and with them the bits of the results, do not depend on who
/// runs them.
const TASK: usize = 128;

/// Sources added up before their sum joins the total.
pub(in crate::field) const BLOCK: usize = 256;
/// The same for compensated sums.
pub(in crate::field) const SHORT_BLOCK: usize = 8;

/// The passes in which a kernel computes the outputs. Each kind of pass is compiled for itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::field) enum Passes {
    /// One for all outputs: whether the potential is wanted is asked for each source, which costs nothing beside a kernel of this size.
    One,
    /// One with the potential, one without.
    Together,
    /// No potential.
    None,
    /// One for the potential alone, one for the others.
    Apart,
}

/// What the engine asks of a kernel.
///
/// The three stages: a value of the implementing type is made once a call; [`PairKernel::prepare`] brings it into the call's units;
/// [`PairKernel::lanes`] spreads its numbers over a machine's lanes, once a task.
pub(in crate::field) trait PairKernel<T: Real, const D: usize>: Sync {
    /// The kernel in the call's units.
    type Prepared: Sync;
    /// Its numbers in every lane.
    type Lanes<V: Copy>;

    /// How the outputs share passes.
    const PASSES: Passes;
    /// Whether sources may have core radii from which those of pairs are made.
    const RADII: bool = false;
    /// Whether the kernel is a scalar function called for each pair, so that vectors bring nothing.
    const SCALAR: bool = false;

    /// A length of the kernel that the units must hold besides the coordinates: delta, the largest core radius, or zero.
    fn length(&self) -> T;

    /// Whether pairs at distance zero contribute nothing.
    fn is_singular(&self) -> bool {
        false
    }

    /// What is kept of the square of a core radius, in units, for [`lanes::cores`].
    fn core(&self, rule: PairRadius, square: T) -> T {
        kept(rule, square)
    }

    /// The kernel in units, with what potentials need if they are wanted. The rule is that of pairs' core radii, if sources have any.
    fn prepare(&self, units: Units<T>, rule: PairRadius, potentials: bool) -> Self::Prepared;

    /// The way from sums over sources of a mass class to results.
    fn scales(&self, units: Units<T>, class: usize) -> Scales<T>;

    /// The same numbers in every lane.
    fn lanes<I: Isa<T>>(prepared: &Self::Prepared, isa: I) -> Self::Lanes<I::V>;

    /// Adds what the sources give to the targets in a pass of kind `P`. Sources with a lane that is left out are noted; in a list of their own those of which the
    /// Laplacian alone is left out.
    fn add_block<I: Isa<T>, const NB: usize, const P: u8>(
        isa: I,
        prepared: (&Self::Prepared, &Self::Lanes<I::V>),
        block: &Block<'_, T, D>,
        groups: &mut [Group<I::V, D>; NB],
        noted: &mut [Deferred; 2],
        counts: &mut Statistics,
    );

    /// The lanes of a noted source, with its core, that were left out, one word a vector; `laplacian`: by the second list.
    fn left_out<I: Isa<T>, const NB: usize, const P: u8>(
        isa: I,
        prepared: (&Self::Prepared, &Self::Lanes<I::V>),
        source: (&[T; D], Option<&T>),
        groups: &[Group<I::V, D>; NB],
        laplacian: bool,
    ) -> [u32; NB];

    /// Whether pairs that are left out may be served by [`PairKernel::add_close`] in closer units.
    fn has_closer(_prepared: &Self::Prepared) -> bool {
        false
    }

    /// Adds what a source gives to the lanes that the outer units leave out and the inner ones don't. `pairs`: differences, source minus target,
    /// and their squares in the outer units; afterwards in the inner ones. Returns the lanes that either leaves out.
    #[inline(always)]
    fn add_close<I: Isa<T>, const NB: usize, const P: u8>(
        _isa: I,
        _outer: &Self::Lanes<I::V>,
        _inner: (&Self::Prepared, &Self::Lanes<I::V>),
        _laplacian: bool,
        _pairs: &mut ([[I::V; D]; NB], [I::V; NB]),
        _mass: T,
        _groups: &mut [Group<I::V, D>; NB],
    ) -> [[u32; NB]; 2] {
        [[0; NB]; 2]
    }

    /// What a source of this mass and core radius gives to a target at x = target - source, in true units and at any distance.
    fn exact(&self, x: &[T; D], mass: T, radius: Option<T>, want: Want) -> Contribution<T, D>;
}

/// A block of sources as a kernel sees it.
pub(in crate::field) struct Block<'a, T, const D: usize> {
    /// Positions and masses, in units.
    pub sources: List<'a, T, D>,
    /// What the kernel keeps of their core radii ([`PairKernel::core`]); empty without any.
    pub cores: &'a [T],
    /// Their vector strengths, in units; empty without any.
    pub strengths: &'a [[T; D]],
    /// The bounds of the sources, and of the targets of the register block.
    pub bounds: [&'a Bounds<T, D>; 2],
    /// Whether no pair is known to be within the kernel's core, or closer than lanes serve.
    pub apart: bool,
    /// Whether the pass computes potentials.
    pub potential: bool,
    /// Whether it computes Laplacians.
    pub laplacian: bool,
    /// One bit a lane: whether it holds a target.
    pub valid: &'a [u32],
}

/// The arguments of a sum, checked.
pub(in crate::field) struct Call<'a, T, const D: usize> {
    pub options: &'a Options,
    pub sources: Sources<'a, T, D>,
    pub targets: &'a [[T; D]],
    pub outputs: Outputs<'a, T, D>,
    /// Who knows which pairs are near, if not all are summed.
    pub near: Option<NearCall<'a, T>>,
}

/// Bytes for the compacted sources; with core radii, with vector strengths.
pub(in crate::field) fn workspace_bytes<T: Real, const D: usize>(n_sources: usize, extras: [bool; 2]) -> Result<usize> {
    Measure::of(|space| Packed::<T, D>::layout(space, n_sources, extras).map(|_| ()))
}

/// Overwrites the outputs with the sums of a kernel; the potential only if `potentials`.
fn sums<T: Real, const D: usize, K: PairKernel<T, D>>(
    potentials: bool,
    kernel: &K,
    call: Call<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let units = match &call.near {
        Some(near) => near.method.units(),
        None => {
            let [coordinate, mass] = call.sources.largest(1);
            Units::of([coordinate.max(kernel.length()), mass], call.targets)
        }
    };
    let (rule, potential) = (call.options.pair_radius, call.outputs.potential.is_some());
    let prepared = kernel.prepare(units, rule, potential);
    let closer = close::prepare(kernel, (units, rule, potential), &prepared);
    let ready = Ready { kernel, prepared: &prepared, closer: &closer };
    erased_sums(potentials, (&ready, units), call, workspace, run)
}

/// The same of a kernel in units.
fn erased_sums<T: Real, const D: usize>(
    potentials: bool,
    (kernel, units): (&dyn ErasedKernel<T, D>, Units<T>),
    call: Call<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let Call { options, sources, targets, outputs, near } = call;
    if let Some(near) = near {
        let call = Call { options, sources, targets, outputs, near: None };
        return near_sums::sums(potentials, (kernel, units), call, near, workspace, run);
    }
    let extras = [sources.radii.is_some(), sources.strengths.is_some()];
    let mut packed = Packed::<T, D>::layout(&mut Carve::reopen(workspace)?, sources.positions.len(), extras)?;
    let rule = options.pair_radius;
    packed.fill(units, sources, kernel.length(), &|square| kernel.core(rule, square));
    let pieces = (
        outputs.potential.map(|p| Chunks::new(p, TASK)),
        outputs.gradient.map(|g| Chunks::new(g, TASK)),
        outputs.laplacian.map(|l| Chunks::new(l, TASK)),
        outputs.hessian.map(|h| Chunks::new(h, TASK)),
    );
    let tally = Tally::default();
    let shared = Shared { kernel, packed: &packed, units, options, sources, ordered: false, tally: &tally };
    let (level, should_stop) = (run.level, run.should_stop);
    par_chunks(
        run.executor,
        targets.len().div_ceil(TASK),
        pieces,
        (),
        &|task, (potential, gradient, laplacian, hessian), ()| {
            if should_stop.is_some_and(|stop| stop()) {
                return Err(Error::Stopped);
            }
            let start = task.saturating_mul(TASK);
            let targets = targets.get(start..).present()?;
            let targets = targets.get(..TASK).unwrap_or(targets);
            let radii = sources.target_radii.map_or(&[][..], |radii| radii.get(start..).present_or(&[]));
            let potential = potential.filter(|_| potentials);
            passes(&shared, (targets, radii), Outputs { potential, gradient, laplacian, hessian }, None, level)
        },
    )?;
    if let Some(counters) = run.counters.as_deref_mut() {
        let pairs = (packed.len() as u64).saturating_mul(targets.len() as u64);
        let massless = sources.positions.len().saturating_sub(packed.len()) as u64;
        counters.add(&Statistics { pairs, massless_sources: massless, ..tally.counters() });
    }
    Ok(())
}
