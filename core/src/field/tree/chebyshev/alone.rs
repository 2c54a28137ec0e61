//! The kernel by itself: its values where it is interpolated, and its mean sizes over the pairs of a sum.

use crate::checked::Present;
use crate::error::Result;
use crate::exec::Run;
use crate::field::Options;
use crate::field::pairs::{ErasedCall, Sum};
use crate::real::{Real, Scalar};
use crate::sort::words::by_key;

/// Sources and targets of which the mean sizes are estimated.
pub(in crate::field::tree) const SAMPLE: usize = 64;

/// The field of one source at the origin, by the engine for pairs.
pub(in crate::field::tree) struct Alone<'a, T: Real> {
    /// The sum whose kernel it is; of it neither sources nor outputs.
    pub of: ErasedCall<'a, T>,
    pub of_pairs: Sum<T>,
    pub mass: T,
    /// The engine's workspace for one source.
    pub workspace: &'a mut [u8],
}

impl<T: Real> Alone<'_, T> {
    /// The values at some points, and the gradients if there is room for them.
    pub fn at(&mut self, points: &[T], values: &mut [T], gradients: Option<&mut [T]>, run: &mut Run<'_>) -> Result<()> {
        let dimension = self.of.dimension;
        let (origin, mass) = ([T::ZERO; 3], [self.mass]);
        let options = Options { combination: (1.0, 0.0), ..*self.of.options };
        let call = ErasedCall {
            options: &options,
            positions: origin.get(..dimension).present()?,
            masses: &mass,
            targets: points,
            potential: Some(values),
            gradient: gradients,
            ..self.of.kernel_alone()
        };
        // What is computed here are no pairs of the sum.
        let mut quiet = Run {
            level: run.level,
            executor: run.executor,
            should_stop: run.should_stop,
            counters: None,
            communicator: None,
        };
        (self.of_pairs)(call, self.workspace, &mut quiet)
    }
}

/// Fills a sample of the differences between targets and sources, in the units of the sources; `unit` brings targets into these. Those of a target stand next to each other. Returns how
/// many there are, and how many of each target.
pub(in crate::field::tree) fn fill_sample<T: Real>(
    d: usize,
    sources: &[T],
    (targets, unit): (&[T], T),
    sample: &mut [T],
) -> [usize; 2] {
    let step = |points: &[T]| (points.len() / d.max(1)).div_ceil(SAMPLE).max(1);
    let (to_next_target, to_next_source) = (step(targets), step(sources));
    let mut slots = sample.chunks_mut(d.max(1));
    let (mut n, mut n_targets) = (0, 0);
    for target in targets.chunks(d.max(1)).step_by(to_next_target.max(1)) {
        n_targets += 1;
        for source in sources.chunks(d.max(1)).skip(to_next_source / 2).step_by(to_next_source.max(1)) {
            let Some(slot) = slots.next() else { break };
            slot.iter_mut().zip(target.iter().zip(source)).for_each(|(to, (&x, &y))| *to = x * unit - y);
            n += 1;
        }
    }
    [n, n / n_targets.max(1)]
}

/// The mean sizes of the kernel and of its gradient over a sample with so many differences of each target: of the means of the targets the median, as a close pair may be larger than
/// all others. Coincident pairs don't count.
pub(in crate::field::tree) fn mean_sizes<T: Real>(
    d: usize,
    sample: &[T],
    (values, slopes): (&[T], &[T]),
    each: usize,
) -> [T; 2] {
    let each = each.max(1);
    let numbers = (each * d).max(1);
    let mut means = [[0_u64; SAMPLE]; 2];
    let mut n = 0;
    let targets = sample.chunks(numbers).zip(values.chunks(each.max(1))).zip(slopes.chunks(numbers));
    for ((points, values), slopes) in targets.take(SAMPLE) {
        let (mut sums, mut pairs) = ([0.0, 0.0], 0);
        for ((point, &value), slope) in points.chunks(d.max(1)).zip(values).zip(slopes.chunks(d.max(1))) {
            if point.iter().any(|&x| x != T::ZERO) {
                sums[0] += value.to_f64().abs();
                sums[1] += Scalar::sqrt(slope.iter().map(|&x| x.to_f64() * x.to_f64()).sum::<f64>());
                pairs += 1;
            }
        }
        for (means, sum) in means.iter_mut().zip(sums) {
            let mean = sum / f64::from(pairs.max(1));
            means.get_mut(n).into_iter().for_each(|to| *to = if mean.is_finite() { mean.to_bits() } else { 0 });
        }
        n += 1;
    }
    means.map(|mut means| {
        // Numbers that are not negative are ordered as their bits.
        let means = means.get_mut(..n).present_or(&mut []);
        by_key(means, &|bits| bits);
        T::from_f64(means.get(n / 2).map_or(0.0, |&bits| f64::from_bits(bits)))
    })
}
