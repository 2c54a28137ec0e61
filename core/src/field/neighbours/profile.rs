//! Mollifiers as the sums over near pairs see them: functions of the distance squared that end.

use crate::mollifier::{Polynomials, gaussian_weights};
use crate::real::{Real, Scalar};

/// A mollifier as a function of s = (r / delta)^2, without its factors.
pub(super) trait Profile<T: Real>: Sync {
    /// The s at which it ends.
    fn end(&self) -> T;
    /// The density.
    fn density(&self, s: T) -> T;
    /// Its slope over the distance.
    fn slope(&self, s: T) -> T;
}

impl<T: Real> Profile<T> for Polynomials<T> {
    fn end(&self) -> T {
        T::ONE
    }
    #[inline(always)]
    fn density(&self, s: T) -> T {
        self.density.at(T::ONE - s)
    }
    #[inline(always)]
    fn slope(&self, s: T) -> T {
        self.density_slope.at(T::ONE - s)
    }
}

/// A sum of Gaussians of widths c delta: `sum w c^-D e^(-s / c^2)`.
pub(super) struct Gaussians<T> {
    /// w c^-D, c^-2.
    parts: [(T, T); 3],
    used: usize,
}

impl<T: Real> Gaussians<T> {
    /// A Gaussian ends where it is below e^-this of its largest value: less than rounding takes.
    const REACH: f64 = if T::DIGITS > 24 { 40.0 } else { 20.0 };

    pub fn new(dimension: usize, order: u32) -> Self {
        let part = |(weight, square): (f64, f64)| {
            let per_width = (1.0 / square).sqrt();
            (T::from_f64(weight * Scalar::powi(per_width, dimension as u32)), T::from_f64(1.0 / square))
        };
        let used = (order / 2) as usize;
        Self { parts: gaussian_weights(dimension, order).map(part), used }
    }

    #[inline(always)]
    fn sum(&self, s: T, factor: impl Fn(T) -> T) -> T {
        let parts = self.parts.iter().take(self.used);
        parts.fold(T::ZERO, |sum, &(weight, per_square)| sum + factor(per_square) * weight * (-(s * per_square)).exp())
    }
}

impl<T: Real> Profile<T> for Gaussians<T> {
    fn end(&self) -> T {
        let widest = self.parts.iter().take(self.used).fold(T::ZERO, |most, part| most.max(T::ONE / part.1));
        T::from_f64(Self::REACH) * widest
    }
    #[inline(always)]
    fn density(&self, s: T) -> T {
        self.sum(s, |_| T::ONE)
    }
    #[inline(always)]
    fn slope(&self, s: T) -> T {
        self.sum(s, |per_square| -(T::TWO * per_square))
    }
}
