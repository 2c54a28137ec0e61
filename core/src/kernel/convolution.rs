//! K * psi by quadrature, in units of delta: what every fit is made from.
//!
//! Polar coordinates about the target put the kernel's singularity at the end of the outer integral, where the double
//! exponential rule wants it, and leave the mollifier to the inner one:
//!
//! u(r) = int_0^inf K(q) q^{d-1} A_d(q, r) dq,  A_n(q, r) = integral over directions of psi at distance |r e - q w|.
//!
//! The gradient factor has no quotient: u'/r is the same convolution two dimensions up, of K'/q with
//! -psi'/(2 pi y), because (-1/(2 pi r)) d/dr carries a radial function with a given Fourier transform from d to d + 2
//! dimensions (and back: apply it to both factors). It is regular at r = 0 and cancels nothing. The Laplacian is that of
//! K convolved with psi where it is integrable, else grad K * grad psi, the distributional one.

use core::f64::consts::PI;

use super::profile::{Profile, TERMS, horner, sphere};
use super::quadrature::{DoubleExponential, GAUSS, gauss_legendre};
use crate::real::Real;
use crate::special::bessel::{i0_scaled, i1_scaled_over_x};

/// Half-width of the interval on which a Gaussian counts: e^{-6.6^2} = 1.2e-19.
pub(crate) const REACH: f64 = 6.6;

/// The rules and the mollifier, ready for many targets.
pub(crate) struct Convolution {
    dimension: usize,
    profile: Profile,
    /// Coefficients of b'.
    slope: [f64; TERMS],
    outer: DoubleExponential,
    inner: [(f64, f64); GAUSS],
    /// The rate at which the kernel decays: under a Gaussian it moves the integrand's peak.
    kappa: f64,
}

/// Below this q the integral over directions of grad psi is taken from its Taylor series: its terms cancel there.
const SMALL: f64 = 1e-6;

/// Integrals over directions: psi in d dimensions, -psi'/(2 pi y) in d + 2, and (r c - q) psi'/y in d.
struct Directions {
    plain: f64,
    raised: f64,
    weak: f64,
}

impl Convolution {
    pub(crate) fn new(dimension: usize, profile: Profile, kappa: f64) -> Self {
        let mut slope = [0.0; TERMS];
        if let Profile::Compact { b, .. } = profile {
            for (k, (slot, &c)) in slope.iter_mut().zip(b.iter().skip(1)).enumerate() {
                *slot = (k as f64 + 1.0) * c;
            }
        }
        Self { dimension, profile, slope, outer: DoubleExponential::new(), inner: gauss_legendre(), kappa }
    }

    /// Value, gradient factor and Laplacian at r. `kernel(q, y)` gives K, K'/q and its Laplacian at distance q = r + y;
    /// `weak` asks for grad K * grad psi. None when a value is not finite.
    pub(crate) fn at(&self, r: f64, weak: bool, kernel: &mut dyn FnMut(f64, f64) -> [f64; 3]) -> Option<[f64; 3]> {
        let mut total = [0.0; 3];
        match self.profile {
            Profile::Compact { b, .. } => {
                let (near, far) = if r < 1.0 { (1.0 - r, 2.0 * r) } else { (0.0, 2.0) };
                self.segment(0.0, near, r, weak, kernel, &mut total, &mut |q, y| self.compact(&b, r, q, y));
                let start = if r < 1.0 { near } else { r - 1.0 };
                self.segment(start, far, r, weak, kernel, &mut total, &mut |q, y| self.compact(&b, r, q, y));
            }
            Profile::Gaussian { parts, .. } => {
                for (weight, width) in parts.into_iter().filter(|&(weight, _)| weight != 0.0) {
                    let reach = REACH * width;
                    let start = (r - reach - 0.5 * self.kappa * width * width).max(0.0);
                    let mut add = [0.0; 3];
                    let mut directions = |q, y| self.gaussian(width, r, q, y);
                    self.segment(start, r - start, r, weak, kernel, &mut add, &mut directions);
                    self.segment(r, reach, r, weak, kernel, &mut add, &mut directions);
                    total.iter_mut().zip(add).for_each(|(sum, part)| *sum += weight * part);
                }
            }
        }
        total.iter().all(|v| v.is_finite()).then_some(total)
    }

    /// Adds the integral over q in [start, start + length].
    #[allow(clippy::too_many_arguments, reason = "one integral, stated once for both mollifiers")]
    fn segment(
        &self,
        start: f64,
        length: f64,
        r: f64,
        weak: bool,
        kernel: &mut dyn FnMut(f64, f64) -> [f64; 3],
        total: &mut [f64; 3],
        directions: &mut dyn FnMut(f64, f64) -> Directions,
    ) {
        if length <= 0.0 {
            return;
        }
        let mut sums = [0.0; 3];
        self.outer.integrate(length, |x, weight| {
            let q = start + x;
            // the offset from the target without a subtraction of nearly equal numbers where r is large
            let y = (start - r) + x;
            let at = directions(q, y);
            let [value, gradient, laplacian] = kernel(q, y);
            let volume = weight * Real::powi(q, self.dimension.saturating_sub(1) as u32);
            let last = if weak { gradient * q * at.weak } else { laplacian * at.plain };
            let add = [volume * value * at.plain, volume * q * q * gradient * at.raised, volume * last];
            let mut matters = false;
            for (sum, part) in sums.iter_mut().zip(add) {
                *sum += part;
                // a NaN must not look like nothing
                matters |= part.is_nan() || part.abs() > 1e-20 * sum.abs();
            }
            matters
        });
        total.iter_mut().zip(sums).for_each(|(t, s)| *t += s);
    }

    /// Directions for b(t): t = (1 - y)(1 + y) - 2 r q (1 - c) is linear in the cosine c.
    fn compact(&self, b: &[f64; TERMS], r: f64, q: f64, y: f64) -> Directions {
        let d = self.dimension;
        let top = (1.0 - y) * (1.0 + y);
        let twice = 2.0 * r * q;
        let mut sums = Directions { plain: 0.0, raised: 0.0, weak: 0.0 };
        let mut add = |one_minus_c: f64, plain: f64, raised: f64| {
            let t = top - twice * one_minus_c;
            if t > 0.0 {
                let slope = horner(&self.slope, t);
                sums.plain += plain * horner(b, t);
                sums.raised += raised * slope;
                // psi'/y = -2 b'/S_d; r c - q = -y - r (1 - c)
                sums.weak += plain * (y + r * one_minus_c) * 2.0 * slope;
            }
        };
        // 1 - c runs to 2, or to where t = 0.
        let whole = 2.0 * twice <= top;
        let small = whole && q < SMALL;
        match d {
            2 => {
                // c = cos theta: directions are 2 dtheta, and 4 pi sin^2 theta dtheta two dimensions up.
                let end = if whole { PI } else { 2.0 * libm::asin((0.5 * top / twice).max(0.0).sqrt()) };
                for &(x, w) in &self.inner {
                    let half = 0.5 * end * x;
                    let (sine, cosine) = (half.sin(), half.cos());
                    let full = 2.0 * sine * cosine;
                    add(2.0 * sine * sine, 2.0 * end * w, 4.0 * PI * end * w * full * full);
                }
            }
            1 => {
                add(0.0, 1.0, 0.0);
                add(2.0, 1.0, 0.0);
                let end = if whole { 2.0 } else { top / twice };
                for &(x, w) in &self.inner {
                    add(end * x, 0.0, 2.0 * PI * end * w);
                }
            }
            _ => {
                // 2 pi dc, and 2 pi^2 (1 - c^2) dc two dimensions up.
                let end = if whole { 2.0 } else { top / twice };
                for &(x, w) in &self.inner {
                    let z = end * x;
                    add(z, 2.0 * PI * end * w, 2.0 * PI * PI * end * w * z * (2.0 - z));
                }
            }
        }
        let s = sphere(d);
        if small {
            // int (w . grad psi)(x - q w) dw = -q S_d/d Laplacian psi + O(q^3); psi_ss = b'', psi_s = -b'
            let t = (1.0 - r) * (1.0 + r);
            let mut curvature = [0.0; TERMS];
            for (k, (slot, &c)) in curvature.iter_mut().zip(self.slope.iter().skip(1)).enumerate() {
                *slot = (k as f64 + 1.0) * c;
            }
            let n = d as f64;
            sums.weak = -q * s / n * (4.0 * r * r * horner(&curvature, t) - 2.0 * n * horner(&self.slope, t));
        }
        // -psi'/(2 pi y) = b'/(pi S_d)
        Directions { plain: sums.plain / s, raised: sums.raised / (PI * s), weak: sums.weak / s }
    }

    /// Directions for a unit Gaussian of width c: e^{-y^2/c^2} times the mean of e^{-x(1 - cosine)}, x = 2 r q/c^2.
    fn gaussian(&self, width: f64, r: f64, q: f64, y: f64) -> Directions {
        let d = self.dimension;
        let scaled = y / width;
        let x = 2.0 * r * q / (width * width);
        let e = (-(scaled * scaled)).exp();
        // means over directions in d and d + 2 dimensions, and of the cosine in d
        let (plain, raised, cosine) = if d == 1 {
            let flat = if x < 1e-8 { 1.0 - x } else { -(-2.0 * x).expm1() / (2.0 * x) };
            (0.5 * (1.0 + (-2.0 * x).exp()), flat, -0.5 * (-2.0 * x).expm1())
        } else {
            let one = i1_scaled_over_x(x);
            (i0_scaled(x), 2.0 * one, x * one)
        };
        let unit = e / Real::powi(PI.sqrt() * width, d as u32);
        let up = unit / (PI * width * width);
        // grad psi = -2/c^2 psi (x - y): (r c - q)(-2/c^2) psi
        let weak = -2.0 / (width * width) * (r * cosine - q * plain);
        Directions {
            plain: sphere(d) * unit * plain,
            raised: sphere(d + 2) * up * raised,
            weak: sphere(d) * unit * weak,
        }
    }
}
