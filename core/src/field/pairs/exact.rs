//! Pairs outside the range of a kernel's fast path, one by one, from the caller's own numbers.
//!
//! They may be all the pairs of a target, so they are summed in double words.

use super::erased::ErasedKernel;
use super::lanes::Want;
use super::output::Results;
use crate::field::{PairRadius, Sources};
use crate::real::Real;

/// Adds one source, with its own mass or another one, and with the core radius of each pair, to the targets of a register block whose bit is set; `each` is the number of lanes in a vector. Returns how
/// many there were.
#[cold]
#[inline(never)]
pub(super) fn add_pairs<T: Real, const D: usize>(
    kernel: &dyn ErasedKernel<T, D>,
    want: Want,
    (targets, results): (&[[T; D]], &mut Results<T, D>),
    (sources, source): (Sources<'_, T, D>, usize),
    (rule, radii): (PairRadius, &[T]),
    own: Option<T>,
    (lanes, each): (&[u32], usize),
) -> u64 {
    let strength = sources.strengths.and_then(|strengths| strengths.get(source));
    let mass = strength.map_or(own.or(sources.masses.get(source).copied()), |_| Some(T::ONE));
    let (Some(y), Some(mass)) = (sources.positions.get(source), mass) else { return 0 };
    let radius = sources.radii.and_then(|radii| radii.get(source)).copied();
    let mut count = 0;
    for (i, target) in targets.iter().enumerate() {
        let each = each.max(1);
        if lanes.get(i / each).is_none_or(|lanes| lanes >> (i % each) & 1 == 0) {
            continue;
        }
        let mut x = *target;
        x.iter_mut().zip(y).for_each(|(x, &y)| *x -= y);
        let radius = match (radius, radii.get(i)) {
            (Some(a), Some(&b)) => Some(pair_radius(rule, a, b)),
            _ => radius,
        };
        let mut pair = kernel.exact(&x, mass, radius, want);
        if let (Some(&[a, b, c]), [x, y, z]) = (strength.and_then(|s| s.first_chunk()), pair.gradient.as_mut_slice()) {
            (*x, *y, *z) = (*y * c - *z * b, *z * a - *x * c, *x * b - *y * a);
        }
        results.add(i, &pair);
        count += 1;
    }
    count
}

/// The core radius of a pair. Nothing overflows that does not in the result. Not in line: the compiler would compute it ahead of the question whether there are radii, and numbers
/// that are not there may raise an exception.
#[inline(never)]
fn pair_radius<T: Real>(rule: PairRadius, source: T, target: T) -> T {
    let most = source.max(target);
    let ratio = source.min(target) / most;
    match rule {
        PairRadius::Source => source,
        PairRadius::Maximum => most,
        PairRadius::Mean => most * (T::HALF + T::HALF * ratio),
        PairRadius::RootMeanSquare => most * (T::HALF + T::HALF * ratio * ratio).sqrt(),
    }
}
