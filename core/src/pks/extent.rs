//! What one pass over the particles tells: whether they may be stepped, their box, their masses.

use crate::build;
use crate::error::{Error, Result};
use crate::exec::{Chunks, Executor, par_chunks};
use crate::real::Real;

/// Up to this many particles are processed in one pass, more in [`PARTS`].
const FEW: usize = 1 << 14;
const PARTS: usize = 32;

/// Bounds of the particles' positions and masses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent<T> {
    /// The lower corner of their bounding box.
    pub low: [T; 2],
    /// The upper corner.
    pub high: [T; 2],
    /// The smallest mass.
    pub smallest: T,
    /// The largest mass.
    pub largest: T,
    /// The sum of the masses, as rounded by some order of summation.
    pub total: T,
}

impl<T: Real> Extent<T> {
    /// The extent of these particles, as many positions as masses; the sum does not depend on the executor. Without particles the box is the origin
    /// and no mass is the smallest.
    ///
    /// # Errors
    /// [`Error::NotFinite`]: a number or the sum of the masses; [`Error::Mass`]: one is not positive; the executor's.
    pub fn of(positions: &[[T; 2]], masses: &[T], executor: &dyn Executor) -> Result<Self> {
        let RawExtent { extent, poison } = RawExtent::by(positions, masses, executor)?;
        if poison.is_nan() || !extent.total.is_finite() {
            return Err(Error::NotFinite);
        }
        if masses.is_empty() {
            let origin = [T::ZERO; 2];
            return Ok(Self { low: origin, high: origin, ..extent });
        }
        if extent.smallest > T::ZERO { Ok(extent) } else { Err(Error::Mass) }
    }

    /// That of both together.
    #[inline(always)]
    pub(super) fn with(&self, other: &Self) -> Self {
        let less = |a: T, b: T| if b < a { b } else { a };
        let more = |a: T, b: T| if b > a { b } else { a };
        Self {
            low: [less(self.low[0], other.low[0]), less(self.low[1], other.low[1])],
            high: [more(self.high[0], other.high[0]), more(self.high[1], other.high[1])],
            smallest: less(self.smallest, other.smallest),
            largest: more(self.largest, other.largest),
            total: self.total + other.total,
        }
    }
}

/// The extent of some particles, not yet validated.
#[derive(Clone, Copy)]
struct RawExtent<T> {
    extent: Extent<T>,
    /// The sum of zero times each number: NaN once one is not finite.
    poison: T,
}

impl<T: Real> RawExtent<T> {
    #[inline(always)]
    fn none() -> Self {
        let (low, high) = ([T::INFINITY; 2], [-T::INFINITY; 2]);
        let extent = Extent { low, high, smallest: T::INFINITY, largest: T::ZERO, total: T::ZERO };
        Self { extent, poison: T::ZERO }
    }

    #[inline(always)]
    fn with(&self, other: &Self) -> Self {
        Self { extent: self.extent.with(&other.extent), poison: self.poison + other.poison }
    }

    /// Of one particle.
    #[inline(always)]
    fn one(x: [T; 2], m: T) -> Self {
        let extent = Extent { low: x, high: x, smallest: m, largest: m, total: m };
        Self { extent, poison: (x[0] * T::ZERO + x[1] * T::ZERO) + m * T::ZERO }
    }

    #[inline(always)]
    fn few(positions: &[[T; 2]], masses: &[T]) -> Self {
        positions.iter().zip(masses).fold(Self::none(), |all, (&x, &m)| all.with(&Self::one(x, m)))
    }

    /// In this thread.
    #[inline(always)]
    fn here(positions: &[[T; 2]], masses: &[T]) -> Self {
        if !build::TILES {
            return Self::few(positions, masses);
        }
        // In pieces, so that the sum has few roundings.
        const EACH: usize = 1024;
        let pieces = positions.chunks(EACH).zip(masses.chunks(EACH));
        pieces.fold(Self::none(), |all, (positions, masses)| all.with(&Self::few(positions, masses)))
    }

    /// Through the executor, if they are many.
    #[inline(always)]
    fn by(positions: &[[T; 2]], masses: &[T], executor: &dyn Executor) -> Result<Self> {
        if build::WORKERS && masses.len() > FEW {
            let mut parts = [Self::none(); PARTS];
            let each = masses.len().div_ceil(PARTS);
            par_chunks(executor, PARTS, Chunks::new(&mut parts, 1), (), &|task, part, ()| {
                let from = task.saturating_mul(each).min(masses.len());
                let to = from.saturating_add(each).min(masses.len());
                if let ([part], Some(positions), Some(masses)) = (part, positions.get(from..to), masses.get(from..to)) {
                    *part = Self::here(positions, masses);
                }
                Ok(())
            })?;
            return Ok(parts.iter().fold(Self::none(), |all, part| all.with(part)));
        }
        Ok(Self::here(positions, masses))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::Serial;
    use std::vec::Vec;

    #[test]
    fn bounds_and_refusals_at_every_size() {
        for n in (1..50).chain([FEW, FEW + 1, FEW + 33]) {
            let positions: Vec<[f64; 2]> = (0..n).map(|i| [(i * 7 % n) as f64, -((i * 3 % n) as f64)]).collect();
            let masses: Vec<f64> = (0..n).map(|i| 1.0 + (i * 5 % n) as f64).collect();
            let extent = Extent::of(&positions, &masses, &Serial).unwrap();
            for k in 0..2 {
                let column = || positions.iter().map(|x| x[k]);
                assert_eq!(extent.low[k], column().fold(f64::INFINITY, f64::min));
                assert_eq!(extent.high[k], column().fold(-f64::INFINITY, f64::max));
            }
            assert_eq!(extent.smallest, masses.iter().copied().fold(f64::INFINITY, f64::min));
            assert_eq!(extent.largest, masses.iter().copied().fold(0.0, f64::max));
            assert_eq!(extent.total, masses.iter().sum::<f64>());
            for at in (0..n).step_by(1 + n / 64) {
                for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY] {
                    for k in 0..2 {
                        let mut positions = positions.clone();
                        positions[at][k] = bad;
                        assert_eq!(Extent::of(&positions, &masses, &Serial), Err(Error::NotFinite));
                    }
                    let mut masses = masses.clone();
                    masses[at] = bad;
                    assert_eq!(Extent::of(&positions, &masses, &Serial), Err(Error::NotFinite));
                }
                for bad in [0.0, -0.0, -1.0] {
                    let mut masses = masses.clone();
                    masses[at] = bad;
                    assert_eq!(Extent::of(&positions, &masses, &Serial), Err(Error::Mass));
                }
            }
        }
        assert_eq!(Extent::of(&[[0.0_f64; 2]; 2], &[1e308; 2], &Serial), Err(Error::NotFinite));
        let none = Extent::<f32>::of(&[], &[], &Serial).unwrap();
        assert_eq!((none.total, none.low, none.high), (0.0, [0.0; 2], [0.0; 2]));
    }
}
