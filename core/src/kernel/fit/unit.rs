//! A law under a mollifier in units of the mollifier's length: what is fitted.

use crate::kernel::convolution::{Convolution, REACH, Sample, Target};
use crate::kernel::law::Law;
use crate::kernel::profile::Profile;
use crate::real::Scalar;

/// A law and a mollifier in units of delta.
pub(super) struct Unit {
    pub(super) law: Law,
    pub(super) dimension: usize,
    pub(super) profile: Profile,
    pub(super) convolution: Convolution,
    /// delta / length, or k delta.
    pub(super) kappa: f64,
    /// Whether the Laplacian is too singular to convolve.
    pub(super) weak: bool,
    /// The power of t in which the functions are smooth at a compact mollifier's edge; 0 means log t.
    pub(super) root: f64,
    /// Magnitudes at delta: of the bare kernel, and of the functions outside.
    pub(super) least: [f64; 3],
    pub(super) least_outside: [f64; 3],
}

impl Unit {
    pub(super) fn new(law: Law, dimension: usize, delta: f64, profile: Profile) -> Self {
        let d = dimension as f64;
        let (kappa, weak) = match law {
            Law::Exponential { length } => (delta / length, false),
            Law::Screened { k } => (delta * k, false),
            Law::Power { exponent } => (0.0, exponent < 2.5 - d),
            Law::Newtonian => (0.0, true),
        };
        let convolution = Convolution::new(dimension, profile, kappa);
        let (root, least) = (edge_root(law, d, profile), [0.0; 3]);
        let mut unit = Self { law, dimension, profile, convolution, kappa, weak, root, least, least_outside: least };
        unit.least = magnitudes(unit.bare(1.0));
        unit.least_outside = magnitudes(unit.relative(1.0, 0.0, 1.0, false));
        if law == (Law::Power { exponent: 0.0 }) {
            (unit.least[0], unit.least_outside[0]) = (1.0, 1.0);
        }
        unit
    }

    /// K, K' and the Laplacian at q, times q^(d-1).
    pub(super) fn bare(&self, q: f64) -> [f64; 3] {
        let d = self.dimension as f64;
        if let Law::Power { exponent: p } = self.law {
            let slope = Scalar::pow(q, p + d - 2.0);
            let value =
                if p == 0.0 { Scalar::powi(q, self.dimension as u32 - 1) * Scalar::log(q) } else { slope * q / p };
            // the Laplacian is not used where it is too singular
            return [value, slope, if self.weak { 0.0 } else { (p + d - 2.0) * slope / q }];
        }
        let law = match self.law {
            Law::Exponential { .. } => Law::Exponential { length: 1.0 / self.kappa },
            Law::Screened { .. } => Law::Screened { k: self.kappa },
            law @ (Law::Newtonian | Law::Power { .. }) => law,
        };
        let [value, gradient, laplacian] = match self.dimension {
            1 => law.bare::<f64, 1>(q),
            2 => law.bare::<f64, 2>(q),
            _ => law.bare::<f64, 3>(q),
        };
        let volume = Scalar::powi(q, self.dimension as u32 - 1);
        [value * volume, gradient * q * volume, laplacian * volume]
    }

    /// The function itself.
    pub(super) fn inside(&self, target: Target, delta: f64) -> Option<Sample> {
        let mut sample = self.convolution.at(target, self.weak, &mut |q, _| self.bare(q))?;
        match self.law {
            Law::Power { exponent: 0.0 } => sample.values[0] += Scalar::log(delta),
            Law::Screened { .. } => {
                // Laplacian u = psi + k^2 u
                let psi = self.profile.density(self.dimension, target.r(), target.t());
                let square = self.kappa * self.kappa;
                sample.values[2] = psi + square * sample.values[0];
                sample.sizes[2] = psi.abs() + square * sample.sizes[0];
            }
            _ => {}
        }
        sample.sizes.iter_mut().zip(self.least).for_each(|(size, least)| *size = size.max(least));
        Some(sample)
    }

    /// The function relative to the bare kernel at the target: divided by r^p, r^(p-2), r^(p-2) for powers (minus log r for the logarithm), by
    /// e^{-kappa r} (1, 1/r, 1) for exponentials.
    pub(super) fn outside(&self, target: Target) -> Option<Sample> {
        let rho = target.r();
        // Next to the edge q still reaches 0. Further out grad psi would only add cancellation.
        let near = match self.profile {
            Profile::Compact { .. } => rho < 1.5,
            Profile::Gaussian { parts, .. } => {
                rho < parts.iter().fold(0.0, |most: f64, &(w, c)| if w == 0.0 { most } else { most.max(c) }) * REACH
            }
        };
        let weak = self.weak && near;
        let mut sample = self.convolution.at(target, weak, &mut |q, y| self.relative(q, y, rho, weak))?;
        sample.sizes.iter_mut().zip(self.least_outside).for_each(|(size, least)| *size = size.max(least));
        Some(sample)
    }

    /// The bare kernel K, K' and its Laplacian at q = rho + y, times q^(d-1), scaled as in [`Unit::outside`].
    pub(super) fn relative(&self, q: f64, y: f64, rho: f64, weak: bool) -> [f64; 3] {
        let d = self.dimension as f64;
        let volume = |x: f64| Scalar::powi(x, self.dimension as u32 - 1);
        match self.law {
            Law::Power { exponent: p } => {
                // next to the edge 1 + y/rho would be 0 for tiny q
                let near = y < -0.5 * rho;
                let ratio = if near { q / rho } else { 1.0 + y / rho };
                // K'/rho^(p-2) q^(d-1) = ratio^(p+d-2) rho^d
                let power = Scalar::pow(ratio, p + d - 2.0) * volume(rho);
                let value = match (p == 0.0, near) {
                    (true, true) => volume(q) * Scalar::log(ratio),
                    (true, false) => volume(q) * (y / rho).log1p(),
                    _ => power * ratio / p,
                };
                [value, power * rho, if weak { 0.0 } else { (p + d - 2.0) * power / ratio }]
            }
            _ => {
                let e = Scalar::exp(-(self.kappa * y)) * volume(q);
                let slope = -self.kappa * e;
                [e, slope * rho, self.kappa * self.kappa * e + (d - 1.0) * slope / q]
            }
        }
    }
}

/// Magnitudes of value, gradient factor and Laplacian. The Laplacian's is at least the gradient factor's, as it may vanish.
pub(super) fn magnitudes([value, gradient, laplacian]: [f64; 3]) -> [f64; 3] {
    [value.abs(), gradient.abs(), laplacian.abs().max(gradient.abs())]
}

/// The power of t in which K_delta is smooth enough at the edge for a Chebyshev series. In t it is smooth except for terms t^(a + j),
/// j = 0, 1, ..., times log t for integer a. a = M + p + d - 2 in the Laplacian and one more in each integral of it; for exponentials p = 1,
/// or no such terms in 1D and 3D. v = t^(1/2) leaves coefficients like n^-(4 a + 1), v = t^(a/m) gives powers v^m and v^(m/a).
pub(super) fn edge_root(law: Law, d: f64, profile: Profile) -> f64 {
    let Profile::Compact { exponent, .. } = profile else { return 1.0 };
    let a = f64::from(exponent) - 2.0
        + match law {
            Law::Power { exponent: p } => p + d,
            Law::Exponential { .. } if d == 2.0 => 1.0 + d,
            _ => return 1.0,
        };
    if a >= 2.5 {
        0.5
    } else if a >= 1.0 {
        0.25
    } else if a > 0.0 {
        a / (5.0 * a).ceil()
    } else {
        0.0
    }
}
