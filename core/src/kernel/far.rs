//! Kernels that are polynomials of the distance beyond a reach: what moments and sorted sums can use.

use super::convolution::REACH;
use super::edge_series::laurent;
use super::fitted_term::Variable;
use super::law::is_multiple;
use super::profile::Profile;
use super::{Kernel, Law};
use crate::real::{Extended, Real, Scalar};

/// Coefficients of |x|^0 .. |x|^9.
pub(crate) const POWERS: usize = 10;

/// K_delta = sum c_k |x|^k for |x| > reach, with coefficients of any size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Far {
    pub(crate) coefficients: [Extended; POWERS],
    /// 0 where the polynomial holds everywhere.
    pub(crate) reach: f64,
}

/// The coefficients in the units of a sum ([`Far::in_units`]).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scaled<T> {
    pub(crate) coefficients: [T; POWERS],
    /// The binary exponent that they lack.
    pub(crate) exponent: i32,
}

impl Far {
    /// The highest power.
    pub(crate) fn degree(&self) -> usize {
        self.coefficients.iter().rposition(|c| !c.is_zero()).unwrap_or(0)
    }

    /// The polynomial of lengths in units, |x| being the true one times 2^`position`, less a power of two: at |x| = 2^`largest` its largest term is about
    /// |x| to its degree. So no term overflows there, and a coefficient that underflows has no part in values of that size.
    pub(crate) fn in_units<T: Real>(&self, position: i32, largest: i32) -> Scaled<T> {
        let in_units = |k: usize, c: Extended| c.shift(position.saturating_mul(k as i32).saturating_neg());
        let scaled = || self.coefficients.iter().enumerate().map(|(k, &c)| in_units(k, c));
        let degree = self.degree();
        let size = |(k, c): (usize, Extended)| {
            c.exponent()
                .map(|exponent| exponent.saturating_sub(largest.saturating_mul(degree.saturating_sub(k) as i32)))
        };
        let exponent = scaled().enumerate().filter_map(size).max().unwrap_or(0);
        let mut coefficients = [T::ZERO; POWERS];
        coefficients.iter_mut().zip(scaled()).for_each(|(to, c)| *to = T::from_f64(c.in_units(exponent)));
        Scaled { coefficients, exponent }
    }

    /// Whether it is a polynomial of |x|^2.
    pub(crate) fn is_even(&self) -> bool {
        self.coefficients.iter().skip(1).step_by(2).all(|c| c.is_zero())
    }
}

impl<T: Real, const D: usize> Kernel<'_, T, D> {
    /// The polynomial, if every term is one: even powers in any dimension, Newtonian and odd powers in 1D, up to 9.
    pub(crate) fn far(&self) -> Option<Far> {
        if !self.is_known() || self.mollifier().is_algebraic() {
            return None;
        }
        let profile = Profile::new(self.mollifier(), D);
        let delta = self.delta().to_f64();
        let reach = match profile {
            None => 0.0,
            Some(Profile::Compact { .. }) => delta,
            Some(Profile::Gaussian { parts, .. }) => {
                parts.iter().fold(0.0, |most: f64, &(w, c)| if w == 0.0 { most } else { most.max(c) }) * REACH * delta
            }
        };
        let mut far = Far { coefficients: [Extended::ZERO; POWERS], reach: 0.0 };
        for term in self.terms() {
            let (law, factor) = term.law.canonical(D);
            let coefficient = factor * term.coefficient;
            // the Newtonian kernel in 1D is |x|/2, also outside any mollifier
            let (p, terms, scale) = match law {
                Law::Newtonian if D == 1 => (1.0, None, 0.5 * coefficient),
                Law::Power { exponent: p } if (1.0..POWERS as f64).contains(&p) && is_multiple(p, 1.0) => {
                    if !is_multiple(p, 2.0) && D != 1 {
                        return None;
                    }
                    (p, profile.as_ref().map(|profile| laurent(p, D, profile)), coefficient / p)
                }
                _ => return None,
            };
            if !is_multiple(p, 2.0) {
                far.reach = reach;
            }
            let mut add = |power: usize, value: Extended| {
                if let Some(slot) = far.coefficients.get_mut(power) {
                    *slot = slot.plus(value);
                }
            };
            let scale = Extended::new(scale, 0);
            match terms {
                None => add(p as usize, scale),
                Some(None) => return None,
                Some(Some((c, count))) => {
                    for (weight, radius) in self.mollifier().parts() {
                        let length = Extended::new(radius * delta, 0);
                        let (square, mut scale) = (length.times(length), scale.scale(weight));
                        for (n, c) in c.iter().take(count).enumerate() {
                            add((p as usize).saturating_sub(2 * n), scale.scale(c.hi));
                            scale = scale.times(square);
                        }
                    }
                }
            }
        }
        Some(far)
    }
}

/// Most powers of t inside a compact mollifier: M + K + 1 of the Newtonian kernel, and one for each step up to |x|^9.
const EDGE: usize = 20;
/// Most powers of s: |x|^8.
const SQUARE: usize = 5;

/// K_delta, delta K_delta'/r and the Laplacian inside a compact mollifier in 1D: sums of powers of t = 1 - (r/delta)^2 and of
/// s = (r/delta)^2, each times a power of two so that the largest coefficient is about 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near<T> {
    pub(crate) edge: [[T; EDGE]; 3],
    pub(crate) edge_terms: usize,
    pub(crate) square: [[T; SQUARE]; 3],
    pub(crate) square_terms: usize,
    /// The binary exponents that the coefficients lack.
    pub(crate) exponents: [i32; 3],
}

/// What is added up before exponents are known.
struct Sums {
    edge: [[Extended; EDGE]; 3],
    square: [[Extended; SQUARE]; 3],
}

impl<T: Real, const D: usize> Kernel<'_, T, D> {
    /// The polynomials, if that is what all terms are: those of [`Kernel::far`], in 1D under a compact mollifier.
    pub(crate) fn near(&self) -> Option<Near<T>> {
        let p = self.blob.polynomials().filter(|_| D == 1)?;
        let mut sums = Sums { edge: [[Extended::ZERO; EDGE]; 3], square: [[Extended::ZERO; SQUARE]; 3] };
        let (mut edge_terms, mut square_terms) = (0, 0);
        let delta = self.delta().to_f64();
        if self.newtonian != T::ZERO {
            // delta P / 2, delta times G / (2 delta), b / (2 delta)
            let half = Extended::new(self.newtonian.to_f64(), 0).shift(-1);
            let (fraction, exponent) = Scalar::frexp(delta);
            let series = [
                (&p.potential, half.times(Extended::new(fraction, exponent))),
                (&p.gradient, half),
                (&p.density, half.times(Extended::new(1.0 / fraction, exponent.saturating_neg()))),
            ];
            for (to, (from, scale)) in sums.edge.iter_mut().zip(series) {
                edge_terms = edge_terms.max(from.coefficients().len());
                to.iter_mut().zip(from.coefficients()).for_each(|(to, &from)| *to = scale.scale(from.to_f64()));
            }
        }
        let series = self.others.first().map_or(&[][..], |others| others.series);
        for part in self.parts() {
            let panel = part.panel(series, 0)?;
            let coefficients = panel.coefficients(series);
            let to: [&mut [Extended]; 3] = match panel.variable {
                Variable::EdgePowers if panel.len <= EDGE => {
                    edge_terms = edge_terms.max(panel.len);
                    sums.edge.each_mut().map(|c| &mut c[..])
                }
                Variable::SquarePowers if panel.len <= SQUARE => {
                    square_terms = square_terms.max(panel.len);
                    sums.square.each_mut().map(|c| &mut c[..])
                }
                _ => return None,
            };
            let factors = [1.0, delta, 1.0];
            for ((to, k), factor) in to.into_iter().zip(0..3).zip(factors) {
                for (to, c) in to.iter_mut().zip(coefficients) {
                    let c = c.get(k).copied().unwrap_or(0.0);
                    *to = to.plus(Extended::new(c, 0).scale(factor));
                }
            }
        }
        let mut near = Near {
            edge: [[T::ZERO; EDGE]; 3],
            edge_terms,
            square: [[T::ZERO; SQUARE]; 3],
            square_terms,
            exponents: [0; 3],
        };
        let to = near.edge.iter_mut().zip(&mut near.square).zip(&mut near.exponents);
        for (((edge, square), exponent), (from, from_square)) in to.zip(sums.edge.iter().zip(&sums.square)) {
            let all = from.iter().chain(from_square);
            *exponent = all.clone().filter_map(|c| c.exponent()).max().unwrap_or(0);
            edge.iter_mut().chain(square).zip(all).for_each(|(to, c)| *to = T::from_f64(c.in_units(*exponent)));
        }
        Some(near)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Term;
    use crate::mollifier::Mollifier;
    use std::vec;

    /// In builds without other kernels too, which keep no terms' records.
    #[test]
    fn a_prepared_newtonian_kernel_has_its_polynomial() {
        let terms = [Term { law: Law::Newtonian, coefficient: 3.0 }];
        let bytes = Kernel::<f64, 1>::workspace_bytes(&terms, Mollifier::None).unwrap();
        let mut memory = vec![0_u8; bytes + 64];
        let start = memory.as_ptr().align_offset(64);
        let block = &mut memory[start..start + bytes];
        let kernel = Kernel::<f64, 1>::prepare(block, &terms, Mollifier::None, 1.0).unwrap();
        let far = kernel.far().unwrap();
        assert_eq!((far.degree(), far.coefficients[1].get()), (1, 1.5));
    }

    #[test]
    fn the_polynomial_is_the_kernel_beyond_the_reach() {
        let terms = [
            Term { law: Law::Newtonian, coefficient: 2.0 },
            Term { law: Law::Power { exponent: 3.0 }, coefficient: -1.5 },
            Term { law: Law::Power { exponent: 4.0 }, coefficient: 0.5 },
        ];
        for mollifier in [
            Mollifier::None,
            Mollifier::Compact { order: 2, exponent: 3 },
            Mollifier::Compact { order: 6, exponent: 5 },
            Mollifier::Gaussian { order: 6 },
        ] {
            let bytes = Kernel::<f64, 1>::workspace_bytes(&terms, mollifier).unwrap();
            let mut memory = vec![0_u8; bytes + 64];
            let start = memory.as_ptr().align_offset(64);
            let kernel = Kernel::<f64, 1>::prepare(&mut memory[start..start + bytes], &terms, mollifier, 0.2).unwrap();
            let far = kernel.far().unwrap();
            assert!(far.degree() == 4 && !far.is_even());
            let near = kernel.near();
            assert_eq!(near.is_some(), matches!(mollifier, Mollifier::Compact { .. }));
            for (near, r) in near.iter().flat_map(|near| [0.0, 0.03, 0.11, 0.199].map(|r| (near, r))) {
                let s = r / 0.2 * (r / 0.2);
                let horner = |c: &[f64], x: f64| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
                let want = kernel.pair(r, [true; 3]);
                for (k, ((edge, square), want)) in near.edge.iter().zip(&near.square).zip(want).enumerate() {
                    let got = (horner(edge, 1.0 - s) + horner(square, s)).ldexp(near.exponents[k]);
                    let want = if k == 1 { 0.2 * want } else { want };
                    // some thirty roundings of the largest coefficients, at most 2 * 8/delta (psi of order 6)
                    assert!((got - want).abs() < 32.0 * f64::EPSILON * 80.0, "{mollifier:?} {r} {got} {want}");
                }
            }
            for r in [1.01, 2.0, 30.0].map(|f: f64| f * far.reach.max(0.1)) {
                let coefficients = far.coefficients.map(Extended::get);
                let want = coefficients.iter().rev().fold(0.0, |sum, c| sum * r + c);
                let size = coefficients.iter().rev().fold(0.0, |sum, c| sum * r + c.abs());
                // fits miss 1e-15 of the largest value, which the sum of magnitudes bounds within a panel's factor 2^4
                assert!((kernel.value(r) - want).abs() < 64.0 * f64::EPSILON * size, "{mollifier:?} {r}");
            }
        }
        let other = Kernel::<f64, 2>::newtonian(1.0, Mollifier::None, 1.0).unwrap();
        assert!(other.far().is_none());
    }
}
