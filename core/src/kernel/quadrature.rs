//! Two rules for the convolution integrals: double exponential for the outer integral, which may have singular ends, and
//! Gauss-Legendre for the inner one, whose integrand is a polynomial or entire.

use core::f64::consts::PI;

use crate::real::{DoubleWord, Scalar};
use crate::special::elementary::exp;

/// Gauss-Legendre on [0, 1]: (node, weight), exact to degree 2 N - 1.
pub(crate) fn gauss_legendre<const N: usize>() -> [(f64, f64); N] {
    let n = N as f64;
    let mut rule = [(0.0, 0.0); N];
    for (k, slot) in rule.iter_mut().enumerate() {
        // Tricomi's initial value, then Newton's method on the Legendre polynomial.
        let mut x = Scalar::cos(PI * (k as f64 + 0.75) / (n + 0.5));
        let mut slope = 1.0;
        for _ in 0..5 {
            let (mut p, mut before) = (1.0, 0.0);
            for j in 0..N {
                let j = j as f64;
                (p, before) = (((2.0 * j + 1.0) * x * p - j * before) / (j + 1.0), p);
            }
            slope = n * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        *slot = (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope));
    }
    rule
}

/// Most nodes of [`DoubleExponential`] per side.
const SIDE: usize = 140;

/// The double exponential (tanh-sinh) rule of Takahasi and Mori on an interval. Its nodes cluster at both ends.
pub(crate) struct DoubleExponential {
    /// (distance from the nearer end, weight) on [0, 1], from the midpoint outwards. The first is the midpoint.
    side: [(f64, f64); SIDE],
    used: usize,
}

impl DoubleExponential {
    /// x = 1/(1 + e^{pi sinh(tau)}), dx/dtau = pi cosh(tau) x (1 - x), tau = k h.
    ///
    /// The error decreases as e^{-c/h}. For b of order 8 with M = 9 and e^{-10 q} it is 7e-14 of the integral's size at h = 1/16, the square
    /// of that at h = 1/32, and 1e-18 here.
    pub(crate) fn new() -> Self {
        let h = 1.0 / 22.0;
        let mut side = [(0.5, 0.0); SIDE];
        let mut used = 0;
        for (k, slot) in side.iter_mut().enumerate() {
            // in two words: with arguments of hundreds a single word would add its rounding to each node
            let (m, n) = exp(DoubleWord::from(h * k as f64));
            let e = m.ldexp(n);
            let below = DoubleWord::ONE / e;
            let (sinh, cosh) = ((e - below) * 0.5, ((e + below) * 0.5).hi);
            let (m, n) = exp(DoubleWord::<f64>::pi() * sinh);
            let x = (DoubleWord::ONE / (DoubleWord::ONE + m.ldexp(n))).hi;
            let weight = h * PI * cosh * x * (1.0 - x);
            if x < 1e-250 {
                break;
            }
            *slot = (x, weight);
            used = k + 1;
        }
        Self { side, used }
    }

    /// Adds `weight * f(from + x)` over [from, from + length]. `f` receives the distance from `from`, accurate to the last
    /// bit at that end, and the weight, and adds to the sums itself. It returns whether the addition mattered. A side ends
    /// after five successive nodes that did not.
    pub(crate) fn integrate(&self, length: f64, mut f: impl FnMut(f64, f64) -> bool) {
        for left in [true, false] {
            let mut idle = 0;
            for &(x, weight) in self.side.iter().take(self.used).skip(usize::from(!left)) {
                let place = if left { x } else { 1.0 - x };
                idle = if f(length * place, length * weight) { 0 } else { idle + 1 };
                if idle == 5 {
                    break;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_integrates_polynomials() {
        const GAUSS: usize = 28;
        let rule = gauss_legendre::<GAUSS>();
        for degree in 0..(2 * GAUSS) {
            let sum: f64 = rule.iter().map(|&(x, w)| w * Scalar::powi(x, degree as u32)).sum();
            let want = 1.0 / (degree as f64 + 1.0);
            // 28 positive terms. A node's error of u changes x^k by k u.
            assert!((sum - want).abs() < (28.0 + degree as f64) * f64::EPSILON * want, "{degree}: {sum}");
        }
    }

    #[test]
    fn double_exponential_integrates_end_singularities() {
        let rule = DoubleExponential::new();
        for power in [-0.9, -0.5, 0.0, 0.3, 2.0] {
            let mut sum = 0.0;
            rule.integrate(3.0, |x, w| {
                let term = w * Scalar::pow(x, power);
                sum += term;
                term.abs() > 1e-19 * sum.abs()
            });
            let want = Scalar::pow(3.0_f64, power + 1.0) / (power + 1.0);
            assert!(((sum - want) / want).abs() < 2e-15, "{power}: {sum} {want}");
        }
    }
}
