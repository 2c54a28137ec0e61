//! The coefficients of compact mollifiers in powers of t = 1 - (r/delta)^2, in a scalar type.

use super::distance::{Distance, sphere};
use super::law::MAX_COEFFICIENTS;
use super::scaled::Scaled;
use crate::checked::Present;
use crate::real::{DoubleWord, Real};

/// Coefficients c_0, c_1, ... of powers of t, padded with zeros.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series<C> {
    coefficients: [C; MAX_COEFFICIENTS],
    terms: usize,
}

impl<C: Copy> Series<C> {
    fn empty(zero: C) -> Self {
        Self { coefficients: [zero; MAX_COEFFICIENTS], terms: 0 }
    }

    fn set(&mut self, k: usize, value: C) {
        if let Some(c) = self.coefficients.get_mut(k) {
            *c = value;
            self.terms = self.terms.max(k + 1);
        }
    }

    /// c_0 to c_degree.
    #[inline]
    #[must_use]
    pub fn coefficients(&self) -> &[C] {
        self.coefficients.get(..self.terms).present_or(&[])
    }

    /// All coefficients, the zeros above the degree included.
    #[inline]
    #[must_use]
    pub fn padded(&self) -> &[C; MAX_COEFFICIENTS] {
        &self.coefficients
    }

    /// The degree.
    #[inline]
    #[must_use]
    pub fn degree(&self) -> usize {
        self.terms.saturating_sub(1)
    }
}

impl<T: Real> Series<T> {
    /// The value at t, by Horner's rule.
    #[inline]
    #[must_use]
    pub fn at(&self, t: T) -> T {
        self.coefficients().iter().rev().fold(T::ZERO, |sum, &c| sum * t + c)
    }
}

/// The polynomials in t that describe a compact mollifier and its field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Polynomial {
    /// b.
    Density,
    /// B'/r: -2 b'.
    DensitySlope,
    /// G.
    Gradient,
    /// H.
    Hessian,
    /// P.
    Potential,
}

/// The exact coefficients, in two words. For N = 1, 2, 3 all but the potential's fit in one f64.
///
/// Only those of G are stored, which keeps the value small. All others are computed from one or two of them when needed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exact<T, const D: usize> {
    exponent: u16,
    terms: u16,
    gradient: [DoubleWord<T>; MAX_COEFFICIENTS - 1],
}

impl<T: Real, const D: usize> Exact<T, D> {
    /// The coefficients of a mollifier that [`Mollifier::check`](super::Mollifier::check) accepts.
    pub fn new(order: u32, exponent: u32) -> Self {
        let (m, half_order) = (exponent as usize, order as usize / 2);
        let small = |n: usize| T::from_usize(n);
        let mut gradient = [DoubleWord::ZERO; MAX_COEFFICIENTS - 1];
        let terms = m + half_order;
        let mut taylor = DoubleWord::ONE;
        for (k, slot) in gradient.iter_mut().enumerate().take(terms) {
            *slot = taylor;
            taylor = taylor * small(D + 2 * k) / small(2 * (k + 1));
        }
        // W_(M+i) is a sum over j = i..K-1 of integers over 2^(K-1) (K-1)!, exact here: (-1)^(K-1+j) C(K-1, j) times the product of
        // N + 2 f over f = M+j+1..M+j+K-1.
        let (mut sum, mut factor) = (T::ZERO, T::ONE);
        let below = (1..half_order).fold(T::ONE, |product, s| product * small(2 * s));
        for j in (1..half_order).rev() {
            sum += (1..half_order).fold(factor, |product, s| product * small(D + 2 * (m + j + s)));
            factor = -(factor * small(j) / small(half_order - j));
            if let Some(top) = gradient.get_mut(m + j) {
                *top = *top * sum / below;
            }
        }
        Self { exponent: m as u16, terms: terms as u16, gradient }
    }

    /// M.
    pub fn exponent(&self) -> u32 {
        u32::from(self.exponent)
    }

    fn g(&self, k: usize) -> DoubleWord<T> {
        self.gradient.get(k).copied().unwrap_or(DoubleWord::ZERO)
    }

    /// `2 (k+1) g_(k+1)`.
    fn above(&self, k: usize) -> DoubleWord<T> {
        self.g(k + 1) * T::from_usize(k + 1) * T::TWO
    }

    /// The coefficient of `t^k`.
    pub fn coefficient(&self, of: Polynomial, k: usize) -> DoubleWord<T> {
        let small = |n: usize| T::from_usize(n);
        match of {
            // (N + 2k) g_k - 2 (k+1) g_(k+1); exactly zero below k = M
            Polynomial::Density if k < usize::from(self.exponent) => DoubleWord::ZERO,
            Polynomial::Density => self.g(k) * small(D + 2 * k) - self.above(k),
            Polynomial::DensitySlope => -(self.coefficient(Polynomial::Density, k + 1) * small(2 * (k + 1))),
            Polynomial::Gradient => self.g(k),
            Polynomial::Hessian => -self.above(k),
            Polynomial::Potential if k > 0 => -(self.g(k - 1) / small(2 * k)),
            // The value at the edge: 2 - N
            Polynomial::Potential => (T::TWO - small(D)).into(),
        }
    }

    /// The coefficients, rounded.
    pub fn plain(&self, of: Polynomial) -> Series<T> {
        let mut series = Series::empty(T::ZERO);
        for k in 0..self.terms(of) {
            series.set(k, self.coefficient(of, k).hi);
        }
        series
    }

    /// The number of coefficients, including zeros at the start.
    pub fn terms(&self, of: Polynomial) -> usize {
        let terms = usize::from(self.terms);
        match of {
            Polynomial::Density | Polynomial::Gradient => terms,
            Polynomial::DensitySlope | Polynomial::Hessian => terms - 1,
            Polynomial::Potential => terms + 1,
        }
    }

    /// The value without its lowest terms, divided by `t^low`, by Horner's rule.
    pub fn above_low(&self, of: Polynomial, low: usize, t: DoubleWord<T>) -> DoubleWord<T> {
        (low..self.terms(of)).rev().fold(DoubleWord::ZERO, |sum, k| sum * t + self.coefficient(of, k))
    }

    /// The coefficients R_j = sum over k >= j of g_k / (k+1), highest first, of the 1D potential in the form (delta/2) (centre + (s/2) R(t)),
    /// s = 1 - t. All are positive for orders 2 and 4. The centre is 1 - R_0 / 2.
    pub fn rise(&self) -> impl Iterator<Item = DoubleWord<T>> {
        let mut sum = DoubleWord::ZERO;
        (0..usize::from(self.terms)).rev().map(move |k| {
            sum = sum + self.g(k) / T::from_usize(k + 1);
            sum
        })
    }
}

/// A compact mollifier and its Newtonian field inside the support, for sums over many particles in single-word arithmetic.
///
/// With t = 1 - (r/delta)^2 >= 0: density = `scale` b(t), gradient factor = `scale` G(t), Hessian factor =
/// `hessian_scale` H(t), B'/r = `hessian_scale` Q(t), potential = `potential_scale` P(t) + `potential_offset`. With
/// Horner's rule in T, errors are below (6n + 4) u times the sum of the coefficients' magnitudes, n being the degree (test
/// `plain_polynomials_meet_their_bound`). For G and H at orders 2 and 4 that sum is the function's maximum. Errors found at these
/// orders over all M: 14 u for G and H, 11 u for P in 2D and 3D, 51 u in 1D, 31 u of its maximum for the density.
/// [`Blob`](super::Blob) has the accurate functions. Scale factors overflow or underflow
/// where delta^(N+2) does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polynomials<T> {
    /// b(t).
    pub density: Series<T>,
    /// Q(t).
    pub density_slope: Series<T>,
    /// G(t).
    pub gradient: Series<T>,
    /// H(t).
    pub hessian: Series<T>,
    /// P(t).
    pub potential: Series<T>,
    /// delta.
    pub delta: T,
    /// 1 / (S_N delta^N).
    pub scale: T,
    /// 1 / (S_N delta^(N+2)).
    pub hessian_scale: T,
    /// delta^(2-N) / S_N.
    pub potential_scale: T,
    /// log(delta) / (2 pi) in 2D, else 0.
    pub potential_offset: T,
}

impl<T: Real> Polynomials<T> {
    pub(super) fn new<const D: usize>(exact: &Exact<T, D>, delta: T) -> Self {
        let plain = |of: Polynomial| exact.plain(of);
        let length = Distance::new(delta);
        let scale = Scaled::from(T::ONE).over(sphere(D).times(length.power(D as u32)));
        let square = length.squared();
        let offset = if D == 2 { Scaled::new(length.log(), 0).over(sphere(2)).round() } else { T::ZERO };
        Self {
            density: plain(Polynomial::Density),
            density_slope: plain(Polynomial::DensitySlope),
            gradient: plain(Polynomial::Gradient),
            hessian: plain(Polynomial::Hessian),
            potential: plain(Polynomial::Potential),
            delta,
            scale: scale.round(),
            hessian_scale: scale.over(square).round(),
            potential_scale: scale.times(square).round(),
            potential_offset: offset,
        }
    }
}
