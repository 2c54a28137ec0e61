//! Kernels that are polynomials of the distance beyond a reach: what moments and sorted sums can use.

use super::convolution::REACH;
use super::edge_series::laurent;
use super::law::is_multiple;
use super::part::Variable;
use super::profile::Profile;
use super::{Kernel, Law};
use crate::real::Real;

/// Coefficients of |x|^0 .. |x|^9.
pub(crate) const POWERS: usize = 10;

/// K_delta = sum c_k |x|^k for |x| > reach.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Far<T> {
    pub(crate) coefficients: [T; POWERS],
    /// 0 where the polynomial holds everywhere.
    pub(crate) reach: T,
}

impl<T: Real> Far<T> {
    /// The highest power.
    pub(crate) fn degree(&self) -> usize {
        self.coefficients.iter().rposition(|&c| c != T::ZERO).unwrap_or(0)
    }

    /// The polynomial of lengths in units, |x| being the true one times 2^`position`, less a power of two that is returned: the largest of its
    /// coefficients is about 1, so that none overflows, and one that underflows has no part in values of that size.
    pub(crate) fn in_units(&self, position: i32) -> (Self, i32) {
        let exponent = |k: usize, c: T| c.frexp().1.saturating_sub(position.saturating_mul(k as i32));
        let numbered = || self.coefficients.iter().enumerate().filter(|(_, c)| **c != T::ZERO);
        let largest = numbered().map(|(k, &c)| exponent(k, c)).max().unwrap_or(0);
        let mut scaled = *self;
        for (k, c) in scaled.coefficients.iter_mut().enumerate() {
            *c = c.ldexp(position.saturating_mul(k as i32).saturating_add(largest).saturating_neg());
        }
        scaled.reach = self.reach.ldexp(position);
        (scaled, largest)
    }

    /// Whether it is a polynomial of |x|^2.
    pub(crate) fn is_even(&self) -> bool {
        self.coefficients.iter().skip(1).step_by(2).all(|&c| c == T::ZERO)
    }
}

impl<T: Real, const D: usize> Kernel<'_, T, D> {
    /// The polynomial, if every term is one: even powers in any dimension, Newtonian and odd powers in 1D, up to 9.
    pub(crate) fn far(&self) -> Option<Far<T>> {
        if !self.is_known() {
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
        let mut sum = [0.0_f64; POWERS];
        let mut far = Far { coefficients: [T::ZERO; POWERS], reach: T::ZERO };
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
                far.reach = T::from_f64(reach);
            }
            let mut add = |power: usize, value: f64| {
                if let Some(slot) = sum.get_mut(power) {
                    *slot += value;
                }
            };
            match terms {
                None => add(p as usize, scale),
                Some(None) => return None,
                Some(Some((c, count))) => {
                    let mut length = 1.0;
                    for (n, c) in c.iter().take(count).enumerate() {
                        add((p as usize).saturating_sub(2 * n), scale * c.hi * length);
                        length *= delta * delta;
                    }
                }
            }
        }
        for (slot, value) in far.coefficients.iter_mut().zip(sum) {
            *slot = T::from_f64(value);
        }
        Some(far)
    }
}

/// Most powers of t inside a compact mollifier: M + K + 1 of the Newtonian kernel, and one for each step up to |x|^9.
const EDGE: usize = 20;
/// Most powers of s: |x|^8.
const SQUARE: usize = 5;

/// K_delta, K_delta'/r and the Laplacian inside a compact mollifier: sums of powers of t = 1 - (r/delta)^2 and of s = (r/delta)^2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near<T> {
    pub(crate) edge: [[T; EDGE]; 3],
    pub(crate) edge_terms: usize,
    pub(crate) square: [[T; SQUARE]; 3],
    pub(crate) square_terms: usize,
    /// 1/delta.
    pub(crate) per_delta: T,
}

impl<T: Real> Near<T> {
    /// The polynomials of lengths in units, less the power of two that [`Far::in_units`] returned.
    pub(crate) fn in_units(&self, position: i32, largest: i32) -> Self {
        let mut scaled = *self;
        let shifts =
            [0, 2, 2].map(|times: i32| position.saturating_mul(times).saturating_add(largest).saturating_neg());
        for ((edge, square), shift) in scaled.edge.iter_mut().zip(&mut scaled.square).zip(shifts) {
            edge.iter_mut().chain(square).for_each(|c| *c = c.ldexp(shift));
        }
        scaled.per_delta = self.per_delta.ldexp(-position);
        scaled
    }
}

impl<T: Real, const D: usize> Kernel<'_, T, D> {
    /// The polynomials, if that is what all terms are: those of [`Kernel::far`], under a compact mollifier.
    pub(crate) fn near(&self) -> Option<Near<T>> {
        let p = self.blob.polynomials()?;
        let mut near = Near {
            edge: [[T::ZERO; EDGE]; 3],
            edge_terms: 0,
            square: [[T::ZERO; SQUARE]; 3],
            square_terms: 0,
            per_delta: T::ONE / p.delta,
        };
        if self.newtonian != T::ZERO {
            let c = self.newtonian;
            let series = [(&p.potential, p.potential_scale), (&p.gradient, p.scale), (&p.density, p.scale)];
            for (to, (from, scale)) in near.edge.iter_mut().zip(series) {
                near.edge_terms = near.edge_terms.max(from.coefficients().len());
                to.iter_mut().zip(from.coefficients()).for_each(|(to, &from)| *to = c * (scale * from));
            }
            near.edge[0][0] += c * p.potential_offset;
        }
        let series = self.others.first().map_or(&[][..], |others| others.series);
        for part in self.parts() {
            let panel = part.panel(series, 0)?;
            let coefficients = panel.coefficients(series);
            let to: [&mut [T]; 3] = match panel.variable {
                Variable::EdgePowers if panel.len <= EDGE => {
                    near.edge_terms = near.edge_terms.max(panel.len);
                    near.edge.each_mut().map(|c| &mut c[..])
                }
                Variable::SquarePowers if panel.len <= SQUARE => {
                    near.square_terms = near.square_terms.max(panel.len);
                    near.square.each_mut().map(|c| &mut c[..])
                }
                _ => return None,
            };
            let [value, gradient, laplacian] = to;
            for (((u, g), l), c) in value.iter_mut().zip(gradient).zip(laplacian).zip(coefficients) {
                let c = c.map(T::from_f64);
                (*u, *g, *l) = (*u + c[0], *g + c[1], *l + c[2]);
            }
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
        assert_eq!((far.degree(), far.coefficients[1]), (1, 1.5));
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
                let s = r * near.per_delta * (r * near.per_delta);
                let horner = |c: &[f64], x: f64| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
                let want = kernel.pair(r, [true; 3]);
                for ((edge, square), want) in near.edge.iter().zip(&near.square).zip(want) {
                    let got = horner(edge, 1.0 - s) + horner(square, s);
                    // some thirty roundings of the largest coefficients, at most 2 * 8/delta (psi of order 6)
                    assert!((got - want).abs() < 32.0 * f64::EPSILON * 80.0, "{mollifier:?} {r} {got} {want}");
                }
            }
            for r in [1.01, 2.0, 30.0].map(|f: f64| f * far.reach.max(0.1)) {
                let want = far.coefficients.iter().rev().fold(0.0, |sum, c| sum * r + c);
                let size = far.coefficients.iter().rev().fold(0.0, |sum, c| sum * r + c.abs());
                // fits miss 1e-15 of the largest value, which the sum of magnitudes bounds within a panel's factor 2^4
                assert!((kernel.value(r) - want).abs() < 64.0 * f64::EPSILON * size, "{mollifier:?} {r}");
            }
        }
        let other = Kernel::<f64, 2>::newtonian(1.0, Mollifier::None, 1.0).unwrap();
        assert!(other.far().is_none());
    }
}
