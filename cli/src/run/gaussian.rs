//! Newtonian kernels under a Gaussian mollifier in plain double precision, for sums.
//!
//! The functions of `mollis_core::mollifier` carry every number as a sum of two, at some microseconds a value. Sums of many
//! terms have no use for that: here are the same closed forms, good to a few units in the last place of each of their (up to
//! three) terms. Craig & Bertozzi, (3.1), (4.1), (4.2).

use mollis_core::field::Interaction;
use mollis_core::kernel::Kernel;
use mollis_core::mollifier::Mollifier;

/// (weight, width over delta) of the unit Gaussians that a mollifier is a sum of.
const PSI4_1D: &[(f64, f64)] = &[(4.0 / 3.0, 1.0), (-1.0 / 3.0, 2.0)];
const PSI6_1D: &[(f64, f64)] = &[(64.0 / 45.0, 1.0), (-4.0 / 9.0, 2.0), (1.0 / 45.0, 4.0)];
const PSI4_2D: &[(f64, f64)] = &[(2.0, 1.0), (-1.0, std::f64::consts::SQRT_2)];

/// A kernel whose Newtonian part is evaluated in plain double precision.
pub struct Plain<'a, const D: usize> {
    kernel: &'a Kernel<'a, f64, D>,
    terms: &'static [(f64, f64)],
}

impl<'a, const D: usize> Plain<'a, D> {
    /// The kernel, if it is one of a Newtonian term under a Gaussian.
    pub fn new(kernel: &'a Kernel<'a, f64, D>) -> Option<Self> {
        let terms = match (kernel.mollifier(), D) {
            (Mollifier::Gaussian { order: 4 }, 1) => PSI4_1D,
            (Mollifier::Gaussian { order: 6 }, 1) => PSI6_1D,
            (Mollifier::Gaussian { order: 4 }, 2) => PSI4_2D,
            _ => return None,
        };
        (kernel.newtonian_coefficient() != 0.0).then_some(Self { kernel, terms })
    }

    fn sum(&self, one: impl Fn(f64) -> f64) -> f64 {
        let delta = self.kernel.delta();
        self.kernel.newtonian_coefficient()
            * self.terms.iter().map(|(weight, width)| weight * one(width * delta)).sum::<f64>()
    }
}

impl<const D: usize> Interaction<f64, D> for Plain<'_, D> {
    fn value(&self, r: f64) -> f64 {
        // Only the energy asks for it.
        self.kernel.value(r)
    }

    fn gradient_factor(&self, r: f64) -> f64 {
        let near = if self.kernel.is_newtonian() { 0.0 } else { self.kernel.others(r)[1] };
        let root = std::f64::consts::PI.sqrt();
        near + self.sum(|width| match (D, r > 0.0) {
            (1, true) => libm::erf(r / width) / (2.0 * r),
            (1, false) => 1.0 / (root * width),
            (_, true) => -(-(r / width).powi(2)).exp_m1() / (2.0 * std::f64::consts::PI * r * r),
            (_, false) => 1.0 / (2.0 * std::f64::consts::PI * width * width),
        })
    }

    fn laplacian(&self, r: f64) -> f64 {
        let near = if self.kernel.is_newtonian() { 0.0 } else { self.kernel.others(r)[2] };
        let root = std::f64::consts::PI.sqrt();
        near + self.sum(|width| (-(r / width).powi(2)).exp() / (root * width).powi(D as i32))
    }

    fn is_singular(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn agrees<const D: usize>(order: u32) {
        let kernel = Kernel::<f64, D>::newtonian(-1.5, Mollifier::Gaussian { order }, 0.2).unwrap();
        let plain = Plain::new(&kernel).unwrap();
        let [scale, height] = [kernel.gradient_factor(0.0), kernel.laplacian(0.0)].map(f64::abs);
        for i in 0..400 {
            let r = 0.005 * f64::from(i);
            // The weights reach 2 and alternate; a dozen roundings of each term.
            let close = |a: f64, b: f64, scale: f64| {
                assert!((a - b).abs() <= 40.0 * f64::EPSILON * scale, "{D} {order} {r} {a} {b}")
            };
            close(plain.gradient_factor(r), kernel.gradient_factor(r), scale);
            close(plain.laplacian(r), kernel.laplacian(r), height);
        }
    }

    #[test]
    fn plain_forms_are_the_accurate_ones() {
        agrees::<1>(4);
        agrees::<1>(6);
        agrees::<2>(4);
    }
}
