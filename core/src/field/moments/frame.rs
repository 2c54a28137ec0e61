//! The centre and the units of a sum.

use super::{SMALL_SPREAD, Sources, Units, largest_distance, least_distance};
use crate::real::{Real, quotient};

/// Where offsets are taken from, and the powers of two that bring them and masses into units.
#[derive(Clone, Copy)]
pub(super) struct Frame<T, const D: usize> {
    /// In units.
    pub(super) centre: [T; D],
    /// A length in units is the true one times 2^position, a mass 2^mass.
    pub(super) position: i32,
    pub(super) mass: i32,
    /// What a length and a mass are multiplied by: these powers of two.
    pub(super) factors: [T; 2],
    /// The least and the largest distances of targets, in units, whose powers are in range.
    pub(super) distances: [T; 2],
}

impl<T: Real, const D: usize> Frame<T, D> {
    /// Units from every `stride`-th source, all targets and delta, for powers up to `degree`.
    pub(super) fn new(sources: Sources<'_, T, D>, targets: &[[T; D]], delta: T, degree: usize, stride: usize) -> Self {
        let [length, mass] = sources.largest(stride);
        let Units { position, mass, .. } = Units::of([length.max(delta), mass], targets);
        let frame = Self::centred(sources, stride, position, mass);
        // Around a centre far from zero, distances are small beside the coordinates.
        let near = frame.spread_of_sources(sources, stride).max(delta.ldexp(position));
        let mut spread = if near < T::from_f64(SMALL_SPREAD) { frame.spread(targets).max(near) } else { T::ONE };
        if spread == T::ZERO {
            return frame;
        }
        // The sources' own powers stay in range too; targets that are then too far away have units of their own, and so have those that are too close to
        // sources which are all in one place.
        let (largest, least) = (largest_distance::<T>(degree), least_distance::<T>(degree));
        if near > T::ZERO {
            spread = spread.min(near.ldexp(largest + least));
        }
        // Coordinates stay in range, and so does the factor.
        let limit = T::MAX_EXPONENT - 2;
        let raised = largest.saturating_sub(spread.frexp().1).min(limit - 2);
        let mut frame = Self::centred(sources, stride, position.saturating_add(raised).min(limit), mass);
        let least = if near > T::ZERO { T::ZERO } else { T::ONE.ldexp(-least) };
        frame.distances = [least, T::ONE.ldexp(largest + 1)];
        frame
    }

    /// Units as they are given; as centre the mean of every `stride`-th source by |mass|.
    pub(super) fn centred(sources: Sources<'_, T, D>, stride: usize, position: i32, mass: i32) -> Self {
        let factors @ [length, unit] = [position, mass].map(|exponent| T::ONE.ldexp(exponent));
        let mut frame = Self { centre: [T::ZERO; D], position, mass, factors, distances: [T::ZERO, T::MAX] };
        let sample = sources.positions.iter().zip(sources.masses).step_by(stride);
        let (weight, sum) = sample.fold((T::ZERO, [T::ZERO; D]), |(weight, mut sum), (x, &m)| {
            let share = m.abs() * unit;
            sum.iter_mut().zip(x).for_each(|(s, &x)| *s += share * (x * length));
            (weight + share, sum)
        });
        for (c, s) in frame.centre.iter_mut().zip(sum) {
            let mean = if weight > T::ZERO { quotient(s, weight) } else { T::ZERO };
            *c = if mean.is_finite() { mean } else { T::ZERO };
        }
        frame
    }

    /// The largest distance of a point from the centre along an axis, in units.
    pub(super) fn spread<'x>(&self, points: impl IntoIterator<Item = &'x [T; D]>) -> T
    where
        T: 'x,
    {
        let [length, _] = self.factors;
        let away =
            |x: &[T; D]| x.iter().zip(&self.centre).fold(T::ZERO, |most, (&x, &c)| most.max((x * length - c).abs()));
        points.into_iter().fold(T::ZERO, |most, x| most.max(away(x)))
    }

    /// The same of every `stride`-th source that has a mass.
    pub(super) fn spread_of_sources(&self, sources: Sources<'_, T, D>, stride: usize) -> T {
        let sample = sources.positions.iter().zip(sources.masses).step_by(stride);
        self.spread(sample.filter(|(_, m)| **m != T::ZERO).map(|(x, _)| x))
    }
}
