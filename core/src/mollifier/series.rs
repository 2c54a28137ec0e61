//! The coefficients of compact mollifiers in powers of t = 1 - (r/delta)^2, prepared in a scalar type.

use super::distance::{Distance, sphere};
use super::law::{GRADIENT_TOPS, MAX_TERMS};
use super::scaled::Scaled;
use crate::real::{DoubleWord, Real};

/// Coefficients c_0, c_1, ... of powers of t, padded with zeros.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series<C> {
    coefficients: [C; MAX_TERMS],
    terms: usize,
}

impl<C: Copy> Series<C> {
    fn empty(zero: C) -> Self {
        Self { coefficients: [zero; MAX_TERMS], terms: 0 }
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
        self.coefficients.get(..self.terms).unwrap_or(&[])
    }

    /// All coefficients, the zeros above the degree included.
    #[inline]
    #[must_use]
    pub fn padded(&self) -> &[C; MAX_TERMS] {
        &self.coefficients
    }

    /// The degree.
    #[inline]
    #[must_use]
    pub fn degree(&self) -> usize {
        self.terms.saturating_sub(1)
    }

    fn map<E: Copy>(&self, zero: E, f: impl Fn(C) -> E) -> Series<E> {
        let mut result = Series::empty(zero);
        for (k, &c) in self.coefficients().iter().enumerate() {
            result.set(k, f(c));
        }
        result
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

/// The exact coefficients, as sums of two numbers. For N = 1, 2, 3 all but the potential's fit in one f64.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exact<T> {
    /// b.
    pub density: Series<DoubleWord<T>>,
    /// B'/r: -2 b'.
    pub density_slope: Series<DoubleWord<T>>,
    /// G.
    pub gradient: Series<DoubleWord<T>>,
    /// H.
    pub hessian: Series<DoubleWord<T>>,
    /// P.
    pub potential: Series<DoubleWord<T>>,
    /// In 1D the potential also is (delta/2) (`centre` + (s/2) R(t)), s = 1 - t, all positive for orders 2 and 4: R, empty
    /// in 2D and 3D.
    pub rise: Series<DoubleWord<T>>,
    pub centre: DoubleWord<T>,
}

impl<T: Real> Exact<T> {
    /// The coefficients of a mollifier that [`Mollifier::check`](super::Mollifier::check) accepts.
    pub fn new(dimension: usize, order: u32, exponent: u32) -> Self {
        let zero = DoubleWord::ZERO;
        let (m, half_order) = (exponent as usize, order as usize / 2);
        let small = |n: usize| T::from_usize(n);
        let mut gradient = Series::empty(zero);
        let mut taylor = DoubleWord::ONE;
        for k in 0..=m {
            gradient.set(k, taylor);
            taylor = taylor * small(dimension + 2 * k) / small(2 * (k + 1));
        }
        let tops = GRADIENT_TOPS
            .get(dimension.wrapping_sub(1))
            .and_then(|by_order| by_order.get(half_order.wrapping_sub(2)))
            .and_then(|by_exponent| by_exponent.get(m.wrapping_sub(1)));
        for (i, &top) in tops.into_iter().flatten().take(half_order.saturating_sub(1)).enumerate() {
            gradient.set(m + 1 + i, DoubleWord::from_parts(top, 0.0));
        }

        let mut result = Self {
            density: Series::empty(zero),
            density_slope: Series::empty(zero),
            gradient,
            hessian: Series::empty(zero),
            potential: Series::empty(zero),
            rise: Series::empty(zero),
            centre: zero,
        };
        let at_edge = [T::ONE, T::ZERO, -T::ONE];
        result.potential.set(0, at_edge.get(dimension.wrapping_sub(1)).copied().unwrap_or(T::ZERO).into());
        let mut next = gradient.coefficients().iter().skip(1);
        for (k, &g) in gradient.coefficients().iter().enumerate() {
            let above = next.next().copied().unwrap_or(zero) * small(k + 1);
            // (N + 2k) g_k - 2 (k+1) g_(k+1); below k = M it is zero exactly
            let b = if k < m { zero } else { g * small(dimension + 2 * k) - above * T::TWO };
            result.density.set(k, b);
            if k > 0 {
                result.density_slope.set(k - 1, -(b * small(2 * k)));
            }
            if k + 1 < m + half_order {
                result.hessian.set(k, -(above * T::TWO));
            }
            result.potential.set(k + 1, -(g / small(2 * (k + 1))));
        }
        if dimension == 1 {
            // R_j = sum over k >= j of g_k / (k+1), centre = 1 - R_0 / 2
            let mut sum = zero;
            for (k, &g) in gradient.coefficients().iter().enumerate().rev() {
                sum = sum + g / small(k + 1);
                result.rise.set(k, sum);
            }
            result.centre = DoubleWord::ONE - sum * T::HALF;
        }
        result
    }
}

/// A compact mollifier and its Newtonian field inside the support, for sums over many particles by plain arithmetic.
///
/// With t = 1 - (r/delta)^2 >= 0: density = `scale` b(t), gradient factor = `scale` G(t), Hessian factor =
/// `hessian_scale` H(t), B'/r = `hessian_scale` Q(t), potential = `potential_scale` P(t) + `potential_offset`. Evaluated so, by
/// Horner's rule in T, errors stay below 12 ulp for orders 2 and 4 (the density's and slope's of their maximum; the
/// potential's in 1D below 45 ulp); [`Blob`](super::Blob) has the accurate functions. Scale factors overflow or underflow
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
    pub(super) fn new(dimension: usize, exact: &Exact<T>, delta: T) -> Self {
        let plain = |series: &Series<DoubleWord<T>>| series.map(T::ZERO, |c| c.hi);
        let length = Distance::new(delta);
        let scale = Scaled::from(T::ONE).over(sphere(dimension).times(length.power(dimension as u32)));
        let square = length.squared();
        let offset = if dimension == 2 { Scaled::new(length.log(), 0).over(sphere(2)).round() } else { T::ZERO };
        Self {
            density: plain(&exact.density),
            density_slope: plain(&exact.density_slope),
            gradient: plain(&exact.gradient),
            hessian: plain(&exact.hessian),
            potential: plain(&exact.potential),
            delta,
            scale: scale.round(),
            hessian_scale: scale.over(square).round(),
            potential_scale: scale.times(square).round(),
            potential_offset: offset,
        }
    }
}
