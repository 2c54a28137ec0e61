//! Sources of a block with at least one lane outside the range of the fast path.

use super::close::{self, Close};
use super::erased::LeftOut;
use super::lanes::{Want, distances};
use super::{PairKernel, exact};
use crate::real::Real;
use crate::simd::{Isa, Part};

/// Adds what they give to these lanes: in closer units, or one pair after the other. A function of its own, as it is seldom needed.
pub(super) struct AddLeftOut<'a, T: Real, V: Copy, const D: usize, const NB: usize, K: PairKernel<T, D>, const P: u8> {
    pub kernel: &'a K,
    pub prepared: &'a K::Prepared,
    /// The same in the units of close pairs.
    pub closer: &'a [Option<K::Prepared>; close::RESCALINGS],
    pub lanes: &'a K::Lanes<V>,
    pub left_out: LeftOut<'a, T, V, D, NB>,
}

impl<T: Real, I: Isa<T>, const D: usize, const NB: usize, K: PairKernel<T, D>, const P: u8> Part<T, I>
    for AddLeftOut<'_, T, I::V, D, NB, K, P>
{
    type Out = ();

    #[inline(always)]
    fn run(self, isa: I) {
        let Self { kernel, prepared, closer: of_levels, lanes, left_out } = self;
        let LeftOut { shared, want, targets, sources, cores, origins, noted, close, groups, valid, counts } = left_out;
        let (targets, radii, results) = targets;
        let (mut closer, has_closer) = ([const { None }; close::RESCALINGS], of_levels[0].is_some());
        let singular = kernel.is_singular();
        for (list, laplacian) in noted.iter_mut().zip([false, true]) {
            let want = if laplacian { Want { potential: false, gradient: false, ..want } } else { want };
            for at in list.take() {
                let (Some(x), Some(&mass)) = (sources.0.get(at), sources.1.get(at)) else { continue };
                let origin = origins.get(at).map_or(usize::MAX, |&origin| origin as usize);
                if singular {
                    let lanes = K::left_out::<I, NB, P>(isa, (prepared, lanes), (x, cores.get(at)), groups, laplacian);
                    // Where no bit of a coordinate was lost by the change of units, who coincides there coincides.
                    let is_exact = x.iter().all(|x| x.abs() > T::MIN_POSITIVE.ldexp(T::DIGITS as i32));
                    let (mut pairs, mut others) = (0, !is_exact);
                    let (d, _) = distances(isa, x, groups);
                    for ((d, &lanes), &valid) in d.iter().zip(&lanes).zip(valid) {
                        let (zero, mut apart) = (isa.splat(T::ZERO), 0);
                        for &d in d {
                            apart |= isa.bits(isa.lt(zero, isa.abs(d)));
                        }
                        others |= lanes & valid & apart != 0;
                        pairs += u64::from((lanes & valid).count_ones());
                    }
                    if !others {
                        counts.scaled_pairs += pairs;
                        continue;
                    }
                }
                let left_out = if !laplacian && has_closer {
                    if closer[0].is_none() {
                        for (to, prepared) in closer.iter_mut().zip(of_levels) {
                            if let Some(prepared) = prepared {
                                *to = Some((prepared, K::lanes(prepared, isa)));
                            }
                        }
                    }
                    let zero = isa.splat(T::ZERO);
                    let axis = groups.first().map_or([zero; D], |group| group.axis);
                    let close = close.get_or_insert_with(|| Close::new(zero, axis));
                    let [served, left] =
                        close.add::<T, I, K, P>(isa, lanes, &closer, want.laplacian, (x, mass), groups);
                    for ((served, left), valid) in served.iter().zip(&left).zip(valid) {
                        counts.scaled_pairs += u64::from((served & !left & valid).count_ones());
                    }
                    left
                } else {
                    K::left_out::<I, NB, P>(isa, (prepared, lanes), (x, cores.get(at)), groups, laplacian)
                };
                if left_out.iter().all(|&lanes| lanes == 0) {
                    continue;
                }
                let pairs = (shared.sources, origin);
                let own = shared.ordered.then(|| mass.ldexp(shared.units.class(0).saturating_neg()));
                counts.scaled_pairs += exact::add_pairs(
                    shared.kernel,
                    want,
                    (targets, &mut *results),
                    pairs,
                    (shared.options.pair_radius, radii),
                    own,
                    (&left_out, I::LANES),
                );
            }
        }
    }
}
