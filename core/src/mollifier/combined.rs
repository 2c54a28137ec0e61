//! Richardson combinations of compact mollifiers of order 2, of the radii delta j / K (Anderson (8) to (10)).
//!
//! The weights alpha_j of `sum alpha_j psi_(gamma_j delta)`, gamma_j = j / K, solve `sum alpha_j = 1, sum alpha_j gamma_j^(2i) = 0 for i = 1..K-1`. With these radii
//! they are those of the central difference that does so,
//!
//! `alpha_j = 2 (-1)^(j+1) C(2K, K+j) / C(2K, K)`:
//!
//! | K | order | alpha_1, alpha_2, ... |
//! |---|---|---|
//! | 2 | 4 | 4/3, -1/3: (9) |
//! | 3 | 6 | 3/2, -3/5, 1/10: (10) |
//! | 4 | 8 | 8/5, -4/5, 8/35, -1/35 |

use super::compact::Compact;
use super::distance::Distance;
use super::newtonian::Newtonian;
use super::scaled::Scaled;
use super::series::Exact;
use super::{Mollifier, Quantity};
use crate::real::{DoubleWord, Real};

/// Combinations are left out with kernels other than the Newtonian one, whose tables their sums use (`no_combined.rs`).
pub(super) const RICHARDSON: bool = true;

/// j and alpha_j, for so many radii.
fn weights<T: Real>(count: u32) -> impl Iterator<Item = (u32, DoubleWord<T>)> {
    let whole = |n: u32| T::from_usize(n as usize);
    let mut weight = DoubleWord::from(-T::TWO);
    (1..=count).map(move |j| {
        weight = -(weight * whole(count + 1 - j) / whole(count + j));
        (j, weight)
    })
}

impl Mollifier {
    /// The number of radii of a combination; 1 of other mollifiers.
    pub(crate) fn radii(self) -> u32 {
        if let Self::Richardson { order, .. } = self { order / 2 } else { 1 }
    }

    /// The mollifiers that it combines: each one's weight, and its radius in units of delta. Itself, if it is no combination.
    pub(crate) fn parts(self) -> impl Iterator<Item = (f64, f64)> {
        let count = self.radii();
        weights::<f64>(count).map(move |(j, weight)| (weight.hi, f64::from(j) / f64::from(count)))
    }

    /// What it combines.
    pub(crate) fn part(self) -> Self {
        if let Self::Richardson { exponent, .. } = self { Self::Compact { order: 2, exponent } } else { self }
    }
}

/// The shape of a combination, without a length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Combined<T, const D: usize> {
    part: Compact<T, D>,
    count: u32,
}

/// A point inside the support.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parts<'a, T, const D: usize> {
    shape: &'a Combined<T, D>,
    delta: Distance<T>,
    r: Distance<T>,
}

impl<T: Real, const D: usize> Combined<T, D> {
    /// The shape of a mollifier that is a combination.
    pub fn of(mollifier: Mollifier) -> Option<Self> {
        let Mollifier::Richardson { order, exponent } = mollifier else { return None };
        Some(Self { part: Compact::new(2, exponent), count: order / 2 })
    }

    /// The coefficients of a part.
    pub fn series(&self) -> &Exact<T, D> {
        &self.part.series
    }

    /// The point at distance `r` <= `delta`.
    pub fn inside(&self, delta: Distance<T>, r: Distance<T>) -> Parts<'_, T, D> {
        Parts { shape: self, delta, r }
    }

    /// The moment of order k in units of that of a part of radius delta: the sum of alpha_j gamma_j^k. Where it vanishes, exactly 0.
    pub fn moment(&self, k: u32) -> DoubleWord<T> {
        if k > 0 && k < 2 * self.count && k.is_multiple_of(2) {
            return DoubleWord::ZERO;
        }
        let gamma = |j: u32| DoubleWord::quotient(T::from_usize(j as usize), T::from_usize(self.count as usize));
        weights(self.count).fold(DoubleWord::ZERO, |sum, (j, weight)| sum + weight * gamma(j).powi(k))
    }
}

impl<T: Real, const D: usize> Parts<'_, T, D> {
    pub fn value(&self, quantity: Quantity) -> Scaled<T> {
        let &Self { shape, delta, r } = self;
        weights(shape.count).fold(Scaled::ZERO, |sum, (j, weight)| {
            let radius = delta.fraction(j, shape.count);
            let part = if r.exceeds(&radius) {
                Newtonian::<T, D> { r }.value(quantity)
            } else {
                shape.part.inside(radius, r).value(quantity)
            };
            sum.plus(part.scale(weight))
        })
    }
}
