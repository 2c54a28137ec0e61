//! The polynomials inside a compact mollifier's support, in the call's units and in lanes.

use crate::mollifier::{Blob, MAX_COEFFICIENTS, Polynomial};
use crate::real::Real;
use crate::simd::Isa;

/// Coefficients in powers of t, highest first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Descending<C> {
    pub(super) coefficients: [C; MAX_COEFFICIENTS],
    pub(super) terms: usize,
}

/// The coefficients of a polynomial of the blob, times `scale`, highest power of t first; how many. None without a compact mollifier.
pub(in crate::field::pairs) fn descending<T: Real, const D: usize>(
    to: &mut [T; MAX_COEFFICIENTS],
    blob: &Blob<T, D>,
    polynomial: Polynomial,
    scale: T,
) -> usize {
    let terms = blob.terms(polynomial).unwrap_or(0).min(MAX_COEFFICIENTS);
    for (to, k) in to.iter_mut().zip((0..terms).rev()) {
        *to = blob.coefficient(polynomial, k) * scale;
    }
    terms
}

/// [`descending`] for what leads to S_D K, twice that in 2D, and what is added to it; `delta` is in units.
pub(in crate::field::pairs) fn descending_potential<T: Real, const D: usize>(
    to: &mut [T; MAX_COEFFICIENTS],
    blob: &Blob<T, D>,
    delta: T,
) -> (usize, T) {
    let per = T::ONE / delta;
    match D {
        1 => {
            // R_j = sum over k >= j of g_k / (k + 1); c = 1 - R_0 / 2: every term is positive for orders 2 to 6.
            let terms = blob.terms(Polynomial::Gradient).unwrap_or(0).min(MAX_COEFFICIENTS);
            let mut sum = T::ZERO;
            for (to, k) in to.iter_mut().zip((0..terms).rev()) {
                sum += blob.coefficient(Polynomial::Gradient, k) / T::from_usize(k + 1);
                // s R(t) = (r2 / delta^2) R(t); the r2 is multiplied later.
                *to = sum * (T::HALF * per);
            }
            (terms, delta * (T::ONE - T::HALF * sum))
        }
        2 => (descending(to, blob, Polynomial::Potential, T::TWO), T::TWO * blob.delta().log()),
        _ => (descending(to, blob, Polynomial::Potential, per), T::ZERO),
    }
}

impl<T: Real> Descending<T> {
    pub(super) const NONE: Self = Self { coefficients: [T::ZERO; MAX_COEFFICIENTS], terms: 0 };

    /// Those of a polynomial of the blob, times `scale`.
    pub(super) fn of<const D: usize>(blob: &Blob<T, D>, polynomial: Polynomial, scale: T) -> Self {
        let mut series = Self::NONE;
        series.terms = descending(&mut series.coefficients, blob, polynomial, scale);
        series
    }

    /// Those that lead to S_D K, and what is added to it.
    pub(super) fn of_potential<const D: usize>(blob: &Blob<T, D>, delta: T) -> (Self, T) {
        let mut series = Self::NONE;
        let (terms, offset) = descending_potential(&mut series.coefficients, blob, delta);
        series.terms = terms;
        (series, offset)
    }

    #[inline(always)]
    pub(super) fn lanes<I: Isa<T>>(&self, isa: I) -> Descending<I::V> {
        let mut coefficients = [isa.splat(T::ZERO); MAX_COEFFICIENTS];
        coefficients.iter_mut().zip(&self.coefficients).for_each(|(to, &c)| *to = isa.splat(c));
        Descending { coefficients, terms: self.terms }
    }
}

impl<V: Copy> Descending<V> {
    /// Horner's rule. A `TERMS` above 0 must be the number of terms, as [`Descending::terms`] says it.
    #[inline(always)]
    pub(super) fn at<T: Real, I: Isa<T, V = V>, const N: usize, const TERMS: usize>(
        &self,
        isa: I,
        t: &[V; N],
    ) -> [V; N] {
        let terms = if TERMS > 0 { TERMS } else { self.terms };
        let Some((&first, rest)) = self.coefficients.get(..terms).and_then(<[V]>::split_first) else {
            return [isa.splat(T::ZERO); N];
        };
        let mut sums = [first; N];
        for &c in rest {
            for (sum, &t) in sums.iter_mut().zip(t) {
                *sum = isa.mul_add(*sum, t, c);
            }
        }
        sums
    }
}

/// The inside of a compact mollifier's support, in units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inside<C> {
    /// 1 / delta^2.
    pub(super) per_square: C,
    pub(super) gradient: Descending<C>,
    pub(super) potential: Descending<C>,
    /// Added to the potential: 2 log delta in 2D (true units), delta c in 1D.
    pub(super) offset: C,
    pub(super) density: Descending<C>,
}

impl<T: Real> Inside<T> {
    pub(super) const NONE: Self = Self {
        per_square: T::ZERO,
        gradient: Descending::NONE,
        potential: Descending::NONE,
        offset: T::ZERO,
        density: Descending::NONE,
    };

    /// The polynomials in units of a delta; that of potentials, whose coefficients and logarithm take microseconds, only if it is wanted.
    pub(super) fn new<const D: usize>(blob: &Blob<T, D>, delta: T, potentials: bool) -> Self {
        let per = T::ONE / delta;
        let scale = per.powi(D as u32);
        let (potential, offset) =
            if potentials { Descending::of_potential(blob, delta) } else { (Descending::NONE, T::ZERO) };
        Self {
            per_square: per * per,
            gradient: Descending::of(blob, Polynomial::Gradient, scale),
            potential,
            offset,
            density: Descending::of(blob, Polynomial::Density, scale),
        }
    }
}

impl<V: Copy> Inside<V> {
    /// The gradient's polynomial in powers of r2 - delta^2 = -delta^2 t (two roundings more a power), and -delta^2.
    #[inline(always)]
    pub(super) fn shifted<T: Real, I: Isa<T, V = V>>(&self, isa: I, square: V) -> (Descending<V>, V) {
        let zero = isa.splat(T::ZERO);
        let mut shifted = self.gradient;
        let mut factor = isa.splat(T::ONE);
        for c in shifted.coefficients.iter_mut().take(shifted.terms).rev() {
            *c = isa.mul(*c, factor);
            factor = isa.sub(zero, isa.mul(factor, self.per_square));
        }
        (shifted, isa.sub(zero, square))
    }

    /// t of each square.
    #[inline(always)]
    pub(super) fn t<T: Real, I: Isa<T, V = V>, const N: usize>(&self, isa: I, r2: &[V; N]) -> [V; N] {
        let one = isa.splat(T::ONE);
        let mut t = *r2;
        t.iter_mut().for_each(|t| *t = isa.neg_mul_add(*t, self.per_square, one));
        t
    }

    /// S_D K_delta, twice that in 2D.
    #[inline(always)]
    pub(super) fn potential<T: Real, I: Isa<T, V = V>, const D: usize, const N: usize>(
        &self,
        isa: I,
        t: &[V; N],
        r2: &[V; N],
    ) -> [V; N] {
        let mut k = self.potential.at::<T, I, N, 0>(isa, t);
        for (k, &r2) in k.iter_mut().zip(r2) {
            *k = if D == 1 { isa.mul_add(*k, r2, self.offset) } else { isa.add(*k, self.offset) };
        }
        k
    }
}
