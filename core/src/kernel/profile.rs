//! The mollifier as the fits need it: in units of delta, in double precision, with its exact moments.

use core::f64::consts::PI;

use crate::mollifier::{Blob, MAX_TERMS, Mollifier};
use crate::real::{DoubleWord, Real};

/// Coefficients of b(t), padded with zeros.
pub(crate) const TERMS: usize = MAX_TERMS;

/// psi in units of delta.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Profile {
    /// psi = b(t)/S_d, t = 1 - |y|^2, supported on |y| <= 1; coefficients of t^0, t^1, ...
    Compact {
        /// Coefficients of b.
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

/// The surface of the unit sphere in n dimensions, n = 1..=5.
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
    /// None without a mollifier.
    pub(crate) fn new(mollifier: Mollifier, dimension: usize) -> Option<Self> {
        match mollifier {
            Mollifier::None => None,
            Mollifier::Compact { order, exponent } => {
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
                // Craig & Bertozzi (3.1), (4.1), (4.2), as sums of unit Gaussians.
                let parts = match (dimension, order) {
                    (1, 6) => [(64.0 / 45.0, 1.0), (-4.0 / 9.0, 2.0), (1.0 / 45.0, 4.0)],
                    (1, _) => [(4.0 / 3.0, 1.0), (-1.0 / 3.0, 2.0), (0.0, 1.0)],
                    _ => [(2.0, 1.0), (-1.0, core::f64::consts::SQRT_2), (0.0, 1.0)],
                };
                Some(Self::Gaussian { parts, half_order: order / 2 })
            }
        }
    }

    /// The moment of |y|^{2n}; the vanishing ones are exact zeros.
    pub(crate) fn moment(&self, n: u32, dimension: usize) -> DoubleWord<f64> {
        let half = 0.5 * dimension as f64;
        match *self {
            // ERRATA section 5 for n = K; in general orthogonality (Rodrigues' formula) gives
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
                // widths are powers of two or of sqrt 2, so that their squares are exact once rounded
                let square = |c: f64| Real::round(c * c);
                let one = |sum, &(w, c): &(f64, f64)| sum + DoubleWord::product(w, Real::powi(square(c), n));
                parts.iter().fold(DoubleWord::ZERO, one) * pochhammer(half, n)
            }
        }
    }
}

/// sum c_k t^k.
#[inline]
pub(crate) fn horner(coefficients: &[f64], t: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, &c| sum * t + c)
}
