//! Pairs closer than the range of the fast path: the same vector operations in rescaled units.
//!
//! A source with a lane that the fast path leaves out meets its register block once more. Of the lanes that were left out the differences are multiplied
//! by a power of two that makes the least r^2 of the fast path 1, and what they give is summed in units of its own; lanes that are still too
//! close are multiplied once more. With [`RESCALINGS`] = 2 pairs down to 2^-84 of the largest coordinate (f64: 2^-180) are served;
//! those below, coincident ones included, are computed one by one ([`super::exact`]).

use super::PairKernel;
use super::lanes::{Group, Sums, Total, distances};
use super::packed::{Units, least_square_exponent};
use crate::field::PairRadius;
use crate::real::Real;
use crate::simd::{Isa, Part};

/// The number of successive rescalings of lengths.
pub(super) const RESCALINGS: usize = 2;

/// A length in the units of a level is one in the units of the level before times 2^this.
pub(super) const fn step<T: Real>() -> i32 {
    least_square_exponent::<T>() / 2
}

/// The units of a level, for [`PairKernel::prepare`] and [`PairKernel::scales`].
pub(super) fn units_of<T: Real>(units: Units<T>, level: usize) -> Units<T> {
    units.closer(level as i32 * step::<T>())
}

/// The kernel in the units of each level, as far as it leaves anything out in those of the level before.
pub(super) fn prepare<T: Real, const D: usize, K: PairKernel<T, D>>(
    kernel: &K,
    (units, rule, potentials): (Units<T>, PairRadius, bool),
    prepared: &K::Prepared,
) -> [Option<K::Prepared>; RESCALINGS] {
    let first = K::has_closer(prepared).then(|| kernel.prepare(units_of(units, 1), rule, potentials));
    let second = first
        .as_ref()
        .filter(|first| K::has_closer(first))
        .map(|_| kernel.prepare(units_of(units, 2), rule, potentials));
    [first, second]
}

/// The kernel in the units of a level, if there is one.
pub(super) type Level<'a, T, const D: usize, K, V> =
    Option<(&'a <K as PairKernel<T, D>>::Prepared, <K as PairKernel<T, D>>::Lanes<V>)>;

/// The sums of a register block in the units of each level.
pub(super) struct Close<V, const D: usize, const NB: usize> {
    groups: [[Group<V, D>; NB]; RESCALINGS],
    totals: [[Total<V, D>; NB]; RESCALINGS],
}

impl<V: Copy, const D: usize, const NB: usize> Close<V, D, NB> {
    #[inline(always)]
    pub fn new(zero: V, axis: [V; D]) -> Self {
        let group = Group { x: [zero; D], axis, core: zero, sums: Sums::splat(zero) };
        Self { groups: [[group; NB]; RESCALINGS], totals: [[Total::splat(zero); NB]; RESCALINGS] }
    }

    /// Adds what a noted source gives to the lanes that the fast path left out. Returns the lanes that it left out and those that are left out still.
    #[inline(always)]
    pub fn add<T: Real, I: Isa<T, V = V>, K: PairKernel<T, D>, const P: u8>(
        &mut self,
        isa: I,
        outer: &K::Lanes<V>,
        inner: &[Level<'_, T, D, K, V>; RESCALINGS],
        laplacian: bool,
        (source, mass): (&[T; D], T),
        groups: &[Group<V, D>; NB],
    ) -> [[u32; NB]; 2] {
        let mut pairs = distances(isa, source, groups);
        let (mut outer, mut result) = (outer, None);
        for (inner, groups) in inner.iter().zip(&mut self.groups) {
            let Some((prepared, inner)) = inner else { break };
            let [before, after] =
                K::add_close::<I, NB, P>(isa, outer, (prepared, inner), laplacian, &mut pairs, mass, groups);
            let [_, left] = result.get_or_insert([before, after]);
            *left = after;
            if after.iter().all(|&lanes| lanes == 0) {
                break;
            }
            outer = inner;
        }
        result.unwrap_or([[0; NB]; 2])
    }

    /// The totals of each level, from the first.
    #[inline(always)]
    pub fn totals(&self) -> impl Iterator<Item = &[Total<V, D>; NB]> {
        self.totals.iter()
    }
}

/// The block's sums join the totals; a function of its own, as close pairs are few.
pub(super) struct FinishBlock<'a, V, const D: usize, const NB: usize> {
    pub close: &'a mut Close<V, D, NB>,
    pub compensated: bool,
}

impl<T: Real, I: Isa<T>, const D: usize, const NB: usize> Part<T, I> for FinishBlock<'_, I::V, D, NB> {
    type Out = ();

    #[inline(always)]
    fn run(self, isa: I) {
        let Close { groups, totals } = self.close;
        for (total, group) in totals.as_flattened_mut().iter_mut().zip(groups.as_flattened_mut()) {
            let sums = core::mem::replace(&mut group.sums, Sums::splat(isa.splat(T::ZERO)));
            if self.compensated {
                total.add_compensated(isa, sums);
            } else {
                total.add(isa, sums);
            }
        }
    }
}
