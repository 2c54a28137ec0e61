//! The mollifier for the fits: in units of delta, in double precision, with exact moments.

use core::f64::consts::PI;

use crate::checked::Present;
use crate::mollifier::{Blob, MAX_COEFFICIENTS, Mollifier, gaussian_weights};
use crate::real::{DoubleWord, Scalar};

/// Coefficients of b(t), padded with zeros.
pub(crate) const TERMS: usize = MAX_COEFFICIENTS;

/// psi in units of delta.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Profile {
    /// psi = b(t)/S_d, t = 1 - |y|^2, supported on |y| <= 1; coefficients of t^0, t^1, ...
    Compact {
        /// Coefficients of b, all exact.
        b: [f64; TERMS],
        /// M.
        exponent: u32,
        /// K, half the order.
        half_order: u32,
    },
    /// psi = sum w e^{-|y|^2/c^2}/(pi^{d/2} c^d); (w, c), unused ones with w = 0.
    Gaussian {
        /// Weights and widths.
        parts: [(f64, f64); 3],
        /// K, half the order.
        half_order: u32,
    },
}

/// The surface area of the unit sphere in n dimensions, n = 1..=5.
pub(crate) const fn sphere(n: usize) -> f64 {
    match n {
        1 => 2.0,
        2 => 2.0 * PI,
        3 => 4.0 * PI,
        4 => 2.0 * PI * PI,
        _ => 8.0 * PI * PI / 3.0,
    }
}

/// (a)_n = a (a+1) ... (a+n-1).
pub(crate) fn pochhammer(a: f64, n: u32) -> f64 {
    (0..n).map(|k| a + f64::from(k)).product()
}

/// The exact coefficients of b(t).
fn compact<const D: usize>(mollifier: Mollifier) -> Option<[f64; TERMS]> {
    let blob = Blob::<f64, D>::new(mollifier, 1.0).ok()?;
    Some(*blob.polynomials()?.density.padded())
}

impl Profile {
    /// Of what a combination combines. `None` without a mollifier, and for algebraic ones, which have no fits.
    pub(crate) fn new(mollifier: Mollifier, dimension: usize) -> Option<Self> {
        match mollifier.part() {
            // What a combination combines is none.
            Mollifier::None
            | Mollifier::Plummer
            | Mollifier::Algebraic
            | Mollifier::Vatistas
            | Mollifier::Richardson { .. } => None,
            mollifier @ Mollifier::Compact { order, exponent } => {
                let mut b = [0.0; TERMS];
                let coefficients = match dimension {
                    1 => compact::<1>(mollifier)?,
                    2 => compact::<2>(mollifier)?,
                    _ => compact::<3>(mollifier)?,
                };
                b.iter_mut().zip(coefficients).for_each(|(slot, c)| *slot = c);
                let half_order = order / 2;
                Some(Self::Compact { b, exponent, half_order })
            }
            Mollifier::Gaussian { order } => {
                let parts = gaussian_weights(dimension, order).map(|(weight, square)| (weight, Scalar::sqrt(square)));
                Some(Self::Gaussian { parts, half_order: order / 2 })
            }
        }
    }

    /// The moment of |y|^{2n}. Vanishing moments are exact zeros.
    pub(crate) fn moment(&self, n: u32, dimension: usize) -> DoubleWord<f64> {
        let half = 0.5 * dimension as f64;
        match *self {
            // Orthogonality (Rodrigues' formula) gives
            // mu_2n = prod_{j=1}^{K-1} (j-n)/j (d/2)_n/(d/2+M+K)_n
            Self::Compact { exponent, half_order, .. } => {
                let edge = half + f64::from(exponent + half_order);
                let mut product = DoubleWord::ONE;
                for j in 1..half_order {
                    product = product * (f64::from(j) - f64::from(n)) / f64::from(j);
                }
                for k in 0..n {
                    product = product * (half + f64::from(k)) / (edge + f64::from(k));
                }
                product
            }
            Self::Gaussian { parts, half_order } => {
                if n > 0 && n < half_order {
                    return DoubleWord::ZERO;
                }
                // widths are powers of two or of sqrt 2, so their squares are exact after rounding
                let square = |c: f64| Scalar::round(c * c);
                let one = |sum, &(w, c): &(f64, f64)| sum + DoubleWord::product(w, Scalar::powi(square(c), n));
                parts.iter().fold(DoubleWord::ZERO, one) * pochhammer(half, n)
            }
        }
    }
}

impl Profile {
    /// b and b' of a compact mollifier. Not used for a Gaussian.
    pub(crate) fn factors(&self) -> [Factors; 2] {
        let Self::Compact { b, exponent, half_order } = self else { return [Factors::new(&[0.0; TERMS], 0, 0); 2] };
        let mut slope = [0.0; TERMS];
        for ((slot, &c), k) in slope.iter_mut().zip(b.iter().skip(1)).zip(1_u32..) {
            *slot = f64::from(k) * c;
        }
        let count = half_order.saturating_sub(1) as usize;
        [Factors::new(b, *exponent, count), Factors::new(&slope, exponent.saturating_sub(1), count)]
    }

    /// psi at r, where 1 - r^2 = t, in units of delta.
    pub(crate) fn density(&self, dimension: usize, r: f64, t: f64) -> f64 {
        match *self {
            Self::Compact { .. } => {
                let [b, _] = self.factors();
                if t > 0.0 { b.at(t) / sphere(dimension) } else { 0.0 }
            }
            Self::Gaussian { parts, .. } => {
                let root = PI.sqrt();
                let one = |&(w, c): &(f64, f64)| {
                    w * Scalar::exp(-(r / c) * (r / c)) / Scalar::powi(root * c, dimension as u32)
                };
                parts.iter().map(one).sum()
            }
        }
    }
}

/// A polynomial c t^n (t - t_1) ... (t - t_m), m <= 3: b and b'. At high orders sums of their coefficients cancel by up to four digits; the
/// factors do not. (All zeros are simple, in (0, 1) and well separated: b is a Jacobi polynomial times t^M.)
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factors {
    leading: f64,
    power: u32,
    roots: [f64; 3],
    count: usize,
}

impl Factors {
    /// Factors sum c_k t^k, which has the lowest power `power` and at most three more terms.
    pub(crate) fn new(coefficients: &[f64; TERMS], power: u32, count: usize) -> Self {
        let count = count.min(3);
        let mut rest = [0.0; 4];
        for (slot, &c) in rest.iter_mut().take(count + 1).zip(coefficients.iter().skip(power as usize)) {
            *slot = c;
        }
        let whole = rest;
        let mut roots = [0.0; 3];
        for (k, slot) in roots.iter_mut().take(count).enumerate() {
            let degree = count - k;
            // For a polynomial with only real zeros, Newton's iterates from the left of the smallest zero increase to it.
            let mut root = 0.0;
            for _ in 0..60 {
                let (value, slope) = with_slope(rest.get(..=degree).present_or(&[]), root);
                root -= value / slope;
            }
            // Two more steps with the whole polynomial, its value in two words.
            for _ in 0..2 {
                let all = whole.get(..=count).present_or(&[]);
                let value = all.iter().rev().fold(DoubleWord::ZERO, |sum, &c| sum * root + DoubleWord::from(c));
                root -= value.hi / with_slope(all, root).1;
            }
            *slot = root;
            // divided by (t - root), from the highest coefficient down
            let mut carry = 0.0;
            for c in rest.iter_mut().take(degree + 1).rev() {
                (carry, *c) = (*c + root * carry, carry);
            }
        }
        Self { leading: whole.get(count).copied().unwrap_or(0.0), power, roots, count }
    }

    /// The value at t >= 0.
    #[inline]
    pub(crate) fn at(&self, t: f64) -> f64 {
        let start = self.leading * Scalar::powi(t, self.power);
        self.roots.iter().take(self.count).fold(start, |product, root| product * (t - root))
    }
}

/// sum c_k x^k and its derivative.
fn with_slope(coefficients: &[f64], x: f64) -> (f64, f64) {
    coefficients.iter().rev().fold((0.0, 0.0), |(value, slope), &c| (value * x + c, slope * x + value))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compared with sums of the exact coefficients in two words. The value and each factor have five roundings. Those of a factor
    /// matter only next to a zero, where the bound is relative to the largest value.
    #[test]
    fn factors_are_the_polynomial() {
        for dimension in 1..=3 {
            for (order, exponent) in (1..=4).flat_map(|k| (1..=9).map(move |m| (2 * k, m))) {
                let profile = Profile::new(Mollifier::Compact { order, exponent }, dimension).unwrap();
                let Profile::Compact { b, half_order, .. } = profile else { panic!() };
                let factors = Factors::new(&b, exponent, half_order as usize - 1);
                let exact = |t: f64| b.iter().rev().fold(DoubleWord::ZERO, |sum, &c| sum * t + DoubleWord::from(c)).hi;
                let largest = (0..=1000).map(|k| exact(1e-3 * f64::from(k)).abs()).fold(0.0, f64::max);
                for t in (0..=1000).map(|k| 1e-3 * f64::from(k)) {
                    let error = (factors.at(t) - exact(t)).abs();
                    let bound = f64::EPSILON * (f64::from(exponent + 5) * exact(t).abs() + 2.0 * largest);
                    assert!(error <= bound, "{dimension} {order} {exponent} {t}: {error:e} {bound:e}");
                }
            }
        }
    }
}
