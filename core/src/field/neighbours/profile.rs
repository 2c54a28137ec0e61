//! Mollifiers as the sums over near pairs see them: functions of the distance squared that end.

use crate::mollifier::{MAX_COMBINED, Mollifier, Polynomials, gaussian_weights};
use crate::real::{Real, Scalar, quotient};

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

/// A combination of compact mollifiers of the radii gamma delta: `sum w gamma^-D psi(s / gamma^2)`.
pub(super) struct Combination<T> {
    part: Polynomials<T>,
    /// w gamma^-D, gamma^-2.
    parts: [(T, T); MAX_COMBINED],
    used: usize,
}

impl<T: Real> Combination<T> {
    /// Of what a mollifier combines, which is `part`.
    pub fn new(dimension: usize, mollifier: Mollifier, part: Polynomials<T>) -> Self {
        let mut parts = [(T::ZERO, T::ZERO); MAX_COMBINED];
        for (to, (weight, radius)) in parts.iter_mut().zip(mollifier.parts()) {
            let per_radius = quotient(1.0, radius);
            let factor = weight * Scalar::powi(per_radius, dimension as u32);
            *to = (T::from_f64(factor), T::from_f64(per_radius * per_radius));
        }
        Self { part, parts, used: mollifier.radii() as usize }
    }

    /// `of` at t of each part that is there, times the factors.
    #[inline(always)]
    fn sum(&self, s: T, of: impl Fn(T, T) -> T) -> T {
        self.parts.iter().take(self.used).fold(T::ZERO, |sum, &(weight, per_square)| {
            let t = T::ONE - s * per_square;
            if t > T::ZERO { sum + weight * of(t, per_square) } else { sum }
        })
    }
}

impl<T: Real> Profile<T> for Combination<T> {
    fn end(&self) -> T {
        T::ONE
    }
    #[inline(always)]
    fn density(&self, s: T) -> T {
        self.sum(s, |t, _| self.part.density.at(t))
    }
    #[inline(always)]
    fn slope(&self, s: T) -> T {
        self.sum(s, |t, per_square| per_square * self.part.density_slope.at(t))
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
