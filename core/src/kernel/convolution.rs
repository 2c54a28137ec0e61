//! K * psi by quadrature, in units of delta. All fits are made from these samples.
//!
//! In polar coordinates about the target the kernel's singularity is at the end of the outer integral, which suits the double
//! exponential rule, and the mollifier is in the inner integral:
//!
//! u(r) = int_0^inf K(q) q^{d-1} A_d(q, r) dq,  A_n(q, r) = integral over directions of psi at distance |r e - q w|.
//!
//! The gradient factor needs no quotient: u'/r is the same convolution two dimensions up, of K'/q with
//! -psi'/(2 pi y), because (-1/(2 pi r)) d/dr maps a radial function with a given Fourier transform from d to d + 2
//! dimensions. It is applied to both factors. The result is regular at r = 0 and nothing cancels. The Laplacian is the convolution of
//! psi with that of K where it is integrable, else grad K * grad psi, which gives the distributional one.
//!
//! Each integral comes with its size, the outer integral of the magnitudes. Its roundings are about 1e-15 of that size.

use core::f64::consts::PI;

use super::law::MAX_KNOTS;
use super::profile::{Factors, Profile, TERMS, sphere};
use super::quadrature::{DoubleExponential, gauss_legendre};
use crate::real::{DoubleWord, Scalar};
use crate::special::bessel::{i0_scaled, i1_scaled_over_x};

/// Half-width of the interval on which a Gaussian is not negligible: e^{-6.6^2} = 1.2e-19.
pub(crate) const REACH: f64 = 6.6;

/// Nodes of the inner rule. In the plane the integrand is a trigonometric polynomial of degree 14 on part of a circle; in other dimensions
/// it is a polynomial of degree 13.
const PLANE: usize = 28;
const LINE: usize = 8;

/// The quadrature rules and the mollifier, prepared for many targets.
pub(crate) struct Convolution {
    dimension: usize,
    profile: Profile,
    /// b and b'.
    factors: [Factors; 2],
    outer: DoubleExponential,
    plane: [(f64, f64); PLANE],
    line: [(f64, f64); LINE],
    /// The decay rate of the kernel. With a Gaussian mollifier it shifts the peak of the integrand.
    kappa: f64,
    /// Where the kernel is not smooth: ascending, infinite where there are no more.
    knots: [f64; MAX_KNOTS],
}

/// Below this q the integral over directions of grad psi uses its Taylor series, because its terms cancel there.
const SMALL: f64 = 1e-6;

/// Integrals over directions: psi in d dimensions, -psi'/(2 pi y) in d + 2, and (r c - q) psi'/y in d.
struct Directions {
    plain: f64,
    raised: f64,
    weak: f64,
}

/// The largest number below 1.
const FAR: f64 = 1.0 - 0.5 * f64::EPSILON;

/// A target's distance, in units of delta.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    r: f64,
    /// 1 - r, accurate to its last bits. Rough kernels need this accuracy next to the edge.
    gap: f64,
}

impl Target {
    /// The target with t = 1 - r^2 in [0, 1].
    pub(crate) fn inside(t: f64) -> Self {
        let r = (1.0 - t).sqrt();
        Self { r, gap: t / (1.0 + r) }
    }

    /// The target with t = 1 - 1/r^2 in [0, 1]; for t = 1 one at a very large distance.
    pub(crate) fn outside(t: f64) -> Self {
        let t = t.min(FAR);
        let r = 1.0 / (1.0 - t).sqrt();
        Self { r, gap: -t * r / (1.0 + 1.0 / r) }
    }

    /// The target with t = 1 - 1/r in [0, 1]; for t = 1 as above.
    pub(crate) fn reciprocal(t: f64) -> Self {
        let t = t.min(FAR);
        let r = 1.0 / (1.0 - t);
        Self { r, gap: -t * r }
    }

    /// The target at distance r, for uses that do not need an accurate 1 - r.
    pub(crate) fn at(r: f64) -> Self {
        Self { r, gap: 1.0 - r }
    }

    pub(crate) fn r(self) -> f64 {
        self.r
    }

    /// 1 - r^2.
    pub(crate) fn t(self) -> f64 {
        self.gap * (1.0 + self.r)
    }
}

/// Value, gradient factor and Laplacian, and their sizes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sample {
    pub(crate) values: [f64; 3],
    pub(crate) sizes: [f64; 3],
}

impl Sample {
    pub(crate) const ZERO: Self = Self { values: [0.0; 3], sizes: [0.0; 3] };
}

/// Running sums of an integral.
struct Sums {
    values: [DoubleWord<f64>; 3],
    sizes: [f64; 3],
}

impl Sums {
    const ZERO: Self = Self { values: [DoubleWord::ZERO; 3], sizes: [0.0; 3] };
}

impl Convolution {
    pub(crate) fn new(dimension: usize, profile: Profile, kappa: f64) -> Self {
        Self::with_knots(dimension, profile, kappa, [f64::INFINITY; MAX_KNOTS])
    }

    /// The same of a kernel with knots, in units of delta.
    pub(crate) fn with_knots(dimension: usize, profile: Profile, kappa: f64, knots: [f64; MAX_KNOTS]) -> Self {
        Self {
            dimension,
            profile,
            factors: profile.factors(),
            outer: DoubleExponential::new(),
            plane: gauss_legendre(),
            line: gauss_legendre(),
            kappa,
            knots,
        }
    }

    /// Value, gradient factor and Laplacian at a target. `kernel(q, y)` gives K, K' and its Laplacian at distance q = r + y, all times
    /// q^(d-1), so that none overflows for tiny q. `weak` selects grad K * grad psi. `None` when a value is not finite.
    pub(crate) fn at(
        &self,
        target: Target,
        weak: bool,
        kernel: &mut dyn FnMut(f64, f64) -> [f64; 3],
    ) -> Option<Sample> {
        let Target { r, gap } = target;
        let mut total = Sample::ZERO;
        match self.profile {
            Profile::Compact { exponent, .. } => {
                let inside = gap > 0.0;
                let small = if weak && inside { self.slope_at_centre(r, gap) } else { 0.0 };
                // 1 + y = gap + q, without cancellation where q starts at -gap
                if inside {
                    let mut directions = |q, y, x| self.compact(r, gap + x, small, q, y);
                    self.segment([0.0, -r, gap], weak, kernel, 1.0, &mut total, &mut directions);
                }
                let (start, from, lift) = if inside { (gap, gap - r, 2.0 * gap) } else { (-gap, -1.0, 0.0) };
                let whole = if inside { 2.0 * r } else { 2.0 };
                // Next to the edge of a rough mollifier the integrand is a power of q from q = |gap| on, so it is integrated by decades.
                let decades = weak && exponent == 1 && start > 0.0;
                let mut done = 0.0;
                while done < whole {
                    let next = if decades { (done + 9.0 * (start + done)).min(whole) } else { whole };
                    let mut directions = |q, y, x| self.compact(r, lift + done + x, small, q, y);
                    let piece = [start + done, from + done, next - done];
                    self.segment(piece, weak, kernel, 1.0, &mut total, &mut directions);
                    done = next;
                }
            }
            Profile::Gaussian { parts, .. } => {
                for (weight, width) in parts.into_iter().filter(|&(weight, _)| weight != 0.0) {
                    let reach = REACH * width;
                    let before = r.min(reach + 0.5 * self.kappa * width * width);
                    let mut directions = |q, y, _| self.gaussian(width, r, q, y);
                    self.segment([r - before, -before, before], weak, kernel, weight, &mut total, &mut directions);
                    self.segment([r, 0.0, reach], weak, kernel, weight, &mut total, &mut directions);
                }
            }
        }
        total.values.iter().all(|v| v.is_finite()).then_some(total)
    }

    /// Adds a weight times the integral over q from `start`, y from `from`. (For large r, y = q - r would cancel.)
    fn segment(
        &self,
        [start, from, length]: [f64; 3],
        weak: bool,
        kernel: &mut dyn FnMut(f64, f64) -> [f64; 3],
        factor: f64,
        total: &mut Sample,
        directions: &mut dyn FnMut(f64, f64, f64) -> Directions,
    ) {
        let mut done = 0.0;
        for knot in self.knots {
            let next = knot - start;
            if next > done && next < length {
                let from = [start + done, from + done, next - done];
                let mut shifted = |q, y, x| directions(q, y, done + x);
                self.piece(from, weak, kernel, factor, total, &mut shifted);
                done = next;
            }
        }
        let from = [start + done, from + done, length - done];
        self.piece(from, weak, kernel, factor, total, &mut |q, y, x| directions(q, y, done + x));
    }

    /// [`Convolution::segment`] without a knot inside.
    fn piece(
        &self,
        [start, from, length]: [f64; 3],
        weak: bool,
        kernel: &mut dyn FnMut(f64, f64) -> [f64; 3],
        factor: f64,
        total: &mut Sample,
        directions: &mut dyn FnMut(f64, f64, f64) -> Directions,
    ) {
        if length <= 0.0 {
            return;
        }
        let mut sums = Sums::ZERO;
        self.outer.integrate(length, |x, weight| {
            let (q, y) = (start + x, from + x);
            let at = directions(q, y, x);
            let [value, slope, laplacian] = kernel(q, y);
            let last = if weak { slope * at.weak } else { laplacian * at.plain };
            let add = [weight * value * at.plain, weight * q * slope * at.raised, weight * last];
            let mut matters = false;
            for ((sum, size), part) in sums.values.iter_mut().zip(&mut sums.sizes).zip(add) {
                *sum = sum.plus(part);
                *size += part.abs();
                // a NaN must not count as negligible
                matters |= part.is_nan() || part.abs() > 1e-20 * *size;
            }
            matters
        });
        for k in 0..3 {
            let (Some(value), Some(size)) = (total.values.get_mut(k), total.sizes.get_mut(k)) else { continue };
            *value += factor * sums.values.get(k).map_or(0.0, |v| v.hi);
            *size += factor.abs() * sums.sizes.get(k).copied().unwrap_or(0.0);
        }
    }

    /// The limit as q goes to 0 of the integral over directions of w . grad psi, over -q S_d: Laplacian psi/d, psi_ss = b'', psi_s = -b'.
    fn slope_at_centre(&self, r: f64, gap: f64) -> f64 {
        let Profile::Compact { b, .. } = self.profile else { return 0.0 };
        let (n, t) = (self.dimension as f64, gap * (1.0 + r));
        let curvature = b.iter().zip(0..TERMS as u32).skip(2).rev().fold(DoubleWord::ZERO, |sum, (&c, k)| {
            sum * t + DoubleWord::from(c) * (f64::from(k) * (f64::from(k) - 1.0))
        });
        let [_, slope] = &self.factors;
        (4.0 * r * r * curvature.hi - 2.0 * n * slope.at(t)) / n
    }

    /// Directions for b(t): t = (1 - y)(1 + y) - 2 r q (1 - c) is linear in the cosine c. `lift` is 1 + y, `small` is the result of
    /// [`Convolution::slope_at_centre`].
    fn compact(&self, r: f64, lift: f64, small: f64, q: f64, y: f64) -> Directions {
        let d = self.dimension;
        let [b, slope] = &self.factors;
        let top = (1.0 - y) * lift;
        let twice = 2.0 * r * q;
        let mut sums = Directions { plain: 0.0, raised: 0.0, weak: 0.0 };
        let mut add = |one_minus_c: f64, plain: f64, raised: f64| {
            let t = top - twice * one_minus_c;
            if t > 0.0 {
                let slope = slope.at(t);
                sums.plain += plain * b.at(t);
                sums.raised += raised * slope;
                // psi'/y = -2 b'/S_d; r c - q = -y - r (1 - c)
                sums.weak += plain * (y + r * one_minus_c) * 2.0 * slope;
            }
        };
        // 1 - c ranges up to 2, or to where t = 0.
        let whole = 2.0 * twice <= top;
        match d {
            2 => {
                // c = cos theta: the measure of directions is 2 dtheta, and 4 pi sin^2 theta dtheta two dimensions up.
                let end = if whole { PI } else { 2.0 * libm::asin((0.5 * top / twice).max(0.0).sqrt()) };
                for &(x, w) in &self.plane {
                    let sine = Scalar::sin(0.5 * end * x);
                    let square = sine * sine;
                    // 1 - c = 2 sin^2(theta/2), sin^2 theta = 4 sin^2(theta/2) cos^2(theta/2)
                    add(2.0 * square, 2.0 * end * w, 16.0 * PI * end * w * square * (1.0 - square));
                }
            }
            1 => {
                add(0.0, 1.0, 0.0);
                add(2.0, 1.0, 0.0);
                let end = if whole { 2.0 } else { top / twice };
                for &(x, w) in &self.line {
                    add(end * x, 0.0, 2.0 * PI * end * w);
                }
            }
            _ => {
                // The measure of directions is 2 pi dc, and 2 pi^2 (1 - c^2) dc two dimensions up.
                let end = if whole { 2.0 } else { top / twice };
                for &(x, w) in &self.line {
                    let z = end * x;
                    add(z, 2.0 * PI * end * w, 2.0 * PI * PI * end * w * z * (2.0 - z));
                }
            }
        }
        let s = sphere(d);
        if whole && q < SMALL {
            // up to O(q^3)
            sums.weak = -q * s * small;
        }
        // -psi'/(2 pi y) = b'/(pi S_d)
        Directions { plain: sums.plain / s, raised: sums.raised / (PI * s), weak: sums.weak / s }
    }

    /// Directions for a unit Gaussian of width c: e^{-y^2/c^2} times the mean of e^{-x(1 - cosine)}, x = 2 r q/c^2.
    fn gaussian(&self, width: f64, r: f64, q: f64, y: f64) -> Directions {
        let d = self.dimension;
        let scaled = y / width;
        let x = 2.0 * r * q / (width * width);
        let e = Scalar::exp(-(scaled * scaled));
        // means over directions in d and d + 2 dimensions, and of the cosine in d
        let (plain, raised, cosine) = if d == 1 {
            let flat = if x < 1e-8 { 1.0 - x } else { -(-2.0 * x).expm1() / (2.0 * x) };
            (0.5 * (1.0 + Scalar::exp(-2.0 * x)), flat, -0.5 * Scalar::expm1(-2.0 * x))
        } else if d == 3 {
            // e^-x sinh(x) / x, and with its derivative f: e^-x f, 3 e^-x f / x.
            let flat = if x < 1e-8 { 1.0 - x } else { -Scalar::expm1(-2.0 * x) / (2.0 * x) };
            let over_x = if x < 1.0 {
                // f / x = sum of 2 k x^(2k-2) / (2k + 1)!
                let (mut sum, mut term) = (1.0 / 3.0, 1.0 / 3.0);
                for k in 1..9 {
                    let k = f64::from(k);
                    term *= x * x / (2.0 * k * (2.0 * k + 3.0));
                    sum += term;
                }
                sum * Scalar::exp(-x)
            } else {
                (0.5 * (1.0 + Scalar::exp(-2.0 * x)) - flat) / (x * x)
            };
            (flat, 3.0 * over_x, x * over_x)
        } else {
            let one = i1_scaled_over_x(x);
            (i0_scaled(x), 2.0 * one, x * one)
        };
        let unit = e / Scalar::powi(PI.sqrt() * width, d as u32);
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
