//! The bare kernels: names, parameter ranges, and K, K'/r, Laplacian K away from the origin.

use core::cell::Cell;

use crate::error::{Error, Result};
use crate::real::{DoubleWord, Extended, Real, Scalar};
use crate::special::bessel::{k0_scaled, k1_scaled};

/// One radial kernel without its coefficient. Newtonian and screened kernels are fundamental solutions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// Laplacian K = +Dirac: |x|/2, log|x|/(2 pi), -1/(4 pi |x|) in 1, 2, 3 dimensions.
    Newtonian,
    /// |x|^p / p, and log|x| for p = 0. Real p > 1 - d. In one dimension also p = 0, with a principal-value gradient.
    Power {
        /// p.
        exponent: f64,
    },
    /// e^{-|x|/l}: a term of a Morse potential.
    Exponential {
        /// l > 0.
        length: f64,
    },
    /// (Laplacian - k^2) K = Dirac: -e^{-k|x|}/(2k), -K0(k|x|)/(2 pi), -e^{-k|x|}/(4 pi |x|).
    Screened {
        /// k > 0, an inverse length.
        k: f64,
    },
}

/// A kernel with its coefficient: +1 attracts where K grows, -1 repels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Which kernel.
    pub law: Law,
    /// Its factor in the sum; any finite number.
    pub coefficient: f64,
}

/// The most terms of a sum.
pub const MAX_TERMS: usize = 8;

impl Law {
    /// Checks that the parameter is in its range in this dimension.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::KernelParameter`].
    pub fn check(self, dimension: usize) -> Result<()> {
        let d = dimension as f64;
        let (value, allowed) = match self {
            Law::Newtonian => return Ok(()),
            // In 1D p = 0 is p = 1 - d, but log|x| is locally integrable and has a principal-value gradient.
            Law::Power { exponent: p } => (p, p > 1.0 - d || (dimension == 1 && p == 0.0)),
            Law::Exponential { length } => (length, length > 0.0),
            Law::Screened { k } => (k, k > 0.0),
        };
        if !value.is_finite() {
            return Err(Error::NotFinite);
        }
        if allowed { Ok(()) } else { Err(Error::KernelParameter) }
    }

    /// Whether [`Law::canonical`] is Newtonian. It contains no division, which a compiler could hoist out of its branch.
    pub(crate) fn is_newtonian(self, dimension: usize) -> bool {
        match self {
            Law::Newtonian => true,
            Law::Power { exponent } => exponent == 2.0 - dimension as f64,
            Law::Exponential { .. } | Law::Screened { .. } => false,
        }
    }

    /// The same kernel as a multiple of a simpler law: Newtonian for some powers, screened for 1D exponentials.
    pub(crate) fn canonical(self, dimension: usize) -> (Self, f64) {
        use core::f64::consts::PI;
        match self {
            Law::Power { exponent } if exponent == 2.0 - dimension as f64 => match dimension {
                1 => (Law::Newtonian, 2.0),
                2 => (Law::Newtonian, 2.0 * PI),
                _ => (Law::Newtonian, 4.0 * PI),
            },
            // e^{-k|x|} = -2k V with V = -e^{-k|x|}/(2k)
            Law::Exponential { length } if dimension == 1 => (Law::Screened { k: 1.0 / length }, -2.0 / length),
            law => (law, 1.0),
        }
    }

    /// Kind and parameter, as stored in a prepared block.
    pub(crate) fn to_numbers(self) -> (f64, f64) {
        match self {
            Law::Newtonian => (0.0, 0.0),
            Law::Power { exponent } => (1.0, exponent),
            Law::Exponential { length } => (2.0, length),
            Law::Screened { k } => (3.0, k),
        }
    }

    /// The law of such numbers; `None`: of no law.
    pub(crate) fn from_numbers(kind: f64, parameter: f64) -> Option<Self> {
        match kind as u32 {
            0 => Some(Law::Newtonian),
            1 => Some(Law::Power { exponent: parameter }),
            2 => Some(Law::Exponential { length: parameter }),
            3 => Some(Law::Screened { k: parameter }),
            _ => None,
        }
    }

    /// K, K'/r and the Laplacian of K at r > 0.
    pub(crate) fn bare<T: Real, const D: usize>(self, r: T) -> [T; 3] {
        let d = T::from_usize(D);
        let per_r = T::ONE / r;
        match self {
            Law::Newtonian => match D {
                1 => [T::HALF * r, T::HALF * per_r, T::ZERO],
                2 => {
                    let c = T::HALF / T::PI;
                    [c * r.log(), c * per_r * per_r, T::ZERO]
                }
                _ => {
                    let c = T::from_f64(0.25) / T::PI * per_r;
                    [-c, c * per_r * per_r, T::ZERO]
                }
            },
            Law::Power { exponent } => {
                let p = T::from_f64(exponent);
                let power = power(r, exponent);
                let gradient = power * per_r * per_r;
                let value = if exponent == 0.0 { r.log() } else { power / p };
                [value, gradient, (p + d - T::TWO) * gradient]
            }
            Law::Exponential { length } => {
                let k = T::from_f64(1.0 / length);
                let e = (-(k * r)).exp();
                let gradient = -k * e * per_r;
                [e, gradient, k * k * e + (d - T::ONE) * gradient]
            }
            Law::Screened { k } => {
                let k = T::from_f64(k);
                let x = k * r;
                let e = (-x).exp();
                let (value, gradient) = match D {
                    1 => (-T::HALF / k * e, T::HALF * e * per_r),
                    2 => {
                        let c = T::HALF / T::PI * e;
                        (-c * k0_scaled(x), c * k * k1_scaled(x) * per_r)
                    }
                    _ => {
                        let c = T::from_f64(0.25) / T::PI * e * per_r;
                        (-c, c * (T::ONE + x) * per_r * per_r)
                    }
                };
                [value, gradient, k * k * value]
            }
        }
    }
}

impl Law {
    /// [`Law::bare`] for one distance r > 0, in double precision. Each result has a few roundings, and overflows or
    /// underflows only where its own value does.
    pub(crate) fn alone<const D: usize>(self, r: f64) -> [f64; 3] {
        use core::f64::consts::PI;
        let d = D as f64;
        match self {
            Law::Newtonian => match D {
                1 => [0.5 * r, 0.5 / r, 0.0],
                2 => [Scalar::log(r) * (0.5 / PI), 0.5 / PI / r / r, 0.0],
                _ => [-0.25 / PI / r, 0.25 / PI / r / r / r, 0.0],
            },
            Law::Power { exponent: p } => {
                let gradient = real_power(r, p - 2.0);
                let value = if p == 0.0 { Scalar::log(r) } else { real_power(r, p) / p };
                [value, gradient, (p + d - 2.0) * gradient]
            }
            Law::Exponential { length } => {
                let e = decay(1.0 / length, r);
                [e, -(e / length / r), (e / length) * (1.0 / length - (d - 1.0) / r)]
            }
            Law::Screened { k } => {
                let (x, e) = (k * r, decay(k, r));
                let (value, gradient) = match D {
                    1 => (-0.5 * e / k, 0.5 * e / r),
                    2 => (-0.5 / PI * e * k0_scaled(x), 0.5 / PI * e * k * k1_scaled(x) / r),
                    _ => (-0.25 / PI * e / r, 0.25 / PI * e * (1.0 + x) / r / r / r),
                };
                [value, gradient, k * (k * value)]
            }
        }
    }
}

impl Law {
    /// [`Law::alone`] with exponents, so that no power of r leaves the range.
    pub(crate) fn scaled<const D: usize>(self, r: f64) -> [Extended; 3] {
        use core::f64::consts::PI;
        match self {
            Law::Newtonian => {
                let (f, e) = Scalar::frexp(r);
                let f = if f > 0.0 { f } else { 1.0 };
                let (value, gradient) = match D {
                    1 => (Extended::new(0.5 * f, e), Extended::new(0.5 / f, e.saturating_neg())),
                    2 => (
                        Extended::new(Scalar::log(r) * (0.5 / PI), 0),
                        Extended::new(0.5 / PI / f / f, e.saturating_mul(-2)),
                    ),
                    _ => (
                        Extended::new(-0.25 / PI / f, e.saturating_neg()),
                        Extended::new(0.25 / PI / f / f / f, e.saturating_mul(-3)),
                    ),
                };
                [value, gradient, Extended::ZERO]
            }
            Law::Power { exponent: p } => {
                let gradient = extended_power(r, p - 2.0);
                let value =
                    if p == 0.0 { Extended::new(Scalar::log(r), 0) } else { extended_power(r, p).scale(1.0 / p) };
                [value, gradient, gradient.scale(p + D as f64 - 2.0)]
            }
            law => law.alone::<D>(r).map(|v| Extended::new(v, 0)),
        }
    }

    /// K'(r) with the same accuracy. It is finite where K'/r may overflow.
    pub(crate) fn slope<const D: usize>(self, r: f64) -> f64 {
        use core::f64::consts::PI;
        match self {
            Law::Newtonian => match D {
                1 => 0.5,
                2 => 0.5 / PI / r,
                _ => 0.25 / PI / r / r,
            },
            Law::Power { exponent: p } => real_power(r, p - 1.0),
            Law::Exponential { length } => -(decay(1.0 / length, r) / length),
            Law::Screened { k } => {
                let (x, e) = (k * r, decay(k, r));
                match D {
                    1 => 0.5 * e,
                    2 => 0.5 / PI * e * k * k1_scaled(x),
                    _ => 0.25 / PI * e * (1.0 + x) / r / r,
                }
            }
        }
    }
}

/// e^{-kr}. The rounding of a large k r would be amplified k r times, so it is corrected to first order.
pub(crate) fn decay(k: f64, r: f64) -> f64 {
    let product = DoubleWord::product(k, r);
    let e = Scalar::exp(-(k * r));
    // beyond 1e300 the product's second word is not finite, and e is 0
    if product.lo.is_finite() { e - e * product.lo } else { e }
}

/// Whether p is a multiple of n = 1 or 2. (The remainder of two doubles would call libc's `fmod`, whose static replacement needs
/// an unwinder.)
pub(crate) fn is_multiple(p: f64, n: f64) -> bool {
    let quotient = p / n;
    libm::floor(quotient) == quotient
}

/// r^p in double precision, to one or two ulp.
pub(crate) fn real_power(r: f64, p: f64) -> f64 {
    if p == 0.0 {
        1.0
    } else if p == 1.0 {
        r
    } else {
        Scalar::pow(r, p)
    }
}

/// r^p: by multiplications and a square root for small half-integers, otherwise by `pow`.
#[inline]
pub(crate) fn power<T: Real>(r: T, p: f64) -> T {
    let doubled = 2.0 * p;
    if doubled.abs() > 32.0 || doubled != f64::from(doubled as i32) {
        return r.pow(T::from_f64(p));
    }
    let n = (doubled as i32).unsigned_abs();
    let whole = r.powi(n / 2);
    let result = if n % 2 == 1 { whole * r.sqrt() } else { whole };
    if p < 0.0 { T::ONE / result } else { result }
}

/// A radial kernel that the user supplies.
///
/// It is called only while a kernel is prepared and never stored. The three functions must be consistent, because the library does not
/// differentiate. They may be unbounded as r goes to 0, but r^(d-1) K and r^d K' must be integrable there.
pub trait RadialKernel {
    /// `[K(r), K'(r)/r, (Laplacian K)(r)]` at r > 0, accurate at every r up to the reach: what is computed as 1 - e^(-r^2), for instance, is not at
    /// small r, -expm1(-r^2) is.
    fn at(&self, r: f64) -> [f64; 3];
}

/// The most knots of a user's kernel.
pub const MAX_KNOTS: usize = 8;

/// A user's kernel in a sum.
///
/// Its functions are fitted. The fits are compared with them between their nodes, and the largest error of each function is kept
/// ([`crate::kernel::Kernel::fit_errors`]); above the tolerance the kernel is refused.
#[derive(Clone, Copy)]
pub struct Supplied<'a> {
    /// The kernel. It is called only while the sum is prepared.
    pub kernel: &'a dyn RadialKernel,
    /// Its factor in the sum.
    pub coefficient: f64,
    /// Pairs further apart than this get no contribution, and are counted ([`crate::exec::Statistics::beyond_reach`]). With a mollifier, the kernel
    /// is also called for slightly larger r. Finite: there is no table to infinity.
    pub reach: f64,
    /// Radii at which the kernel is not smooth, such as those where the pieces of a spline meet: strictly increasing, between `least` and the reach,
    /// at most [`MAX_KNOTS`]. One function is fitted on each side of a knot. K itself must be continuous.
    pub knots: &'a [f64],
    /// The largest error, in each function, with which the kernel is accepted. 0: 1e-10, in single precision 1e-5. Infinity accepts any.
    pub tolerance: f64,
    /// Not used under a mollifier. For smaller r, K continues with the power of r that K'/r has here: exact for powers and logarithms, and in the limit for most. 0: 2^-52
    /// of the reach, and the kernel is compared with it; otherwise not less than that, and the kernel is not called for smaller r.
    pub least: f64,
    /// If there, gets the errors, also of a kernel that is refused for them.
    pub achieved: Option<&'a Cell<[f64; 3]>>,
}

impl<'a> Supplied<'a> {
    /// A smooth kernel with the default tolerance.
    #[must_use]
    pub fn new(kernel: &'a dyn RadialKernel, coefficient: f64, reach: f64) -> Self {
        Self { kernel, coefficient, reach, knots: &[], tolerance: 0.0, least: 0.0, achieved: None }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::NotFinite`]: the coefficient, or a number that is NaN. [`Error::KernelReach`], [`Error::KernelKnots`]. [`Error::OutOfDomain`]: `least`, or a
    /// negative tolerance.
    pub fn check(&self) -> Result<()> {
        let Self { coefficient, reach, knots, tolerance, least, .. } = *self;
        if !coefficient.is_finite() || reach.is_nan() || tolerance.is_nan() || least.is_nan() {
            return Err(Error::NotFinite);
        }
        if knots.iter().any(|knot| knot.is_nan()) {
            return Err(Error::NotFinite);
        }
        if !(reach > 1e-150 && reach < 1e150) {
            return Err(Error::KernelReach);
        }
        if tolerance < 0.0 || least != 0.0 && !(LEAST * reach..=0.5 * reach).contains(&least) {
            return Err(Error::OutOfDomain);
        }
        // A knot may not be another, but for rounding.
        let apart = |a: f64, b: f64| b > a * (1.0 + 1e-10);
        let ordered = knots.iter().zip(knots.iter().skip(1)).all(|(&a, &b)| apart(a, b));
        let inside = knots.iter().all(|&knot| apart(self.least(), knot) && apart(knot, reach));
        if knots.len() > MAX_KNOTS || !ordered || !inside { Err(Error::KernelKnots) } else { Ok(()) }
    }

    /// The least distance of the fits without a mollifier.
    pub(crate) fn least(&self) -> f64 {
        if self.least > 0.0 { self.least } else { LEAST * self.reach }
    }
}

/// 2^-52: what is not a power of r at smaller ones is a power to rounding, for kernels that change over a hundredth of the reach.
const LEAST: f64 = f64::EPSILON;

impl core::fmt::Debug for Supplied<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { coefficient, reach, knots, tolerance, least, .. } = self;
        let mut shown = f.debug_struct("Supplied");
        shown.field("coefficient", coefficient).field("reach", reach).field("knots", knots);
        shown.field("tolerance", tolerance).field("least", least).finish_non_exhaustive()
    }
}

/// r^p for r > 0, in range or not.
pub(crate) fn extended_power(r: f64, p: f64) -> Extended {
    let plain = real_power(r, p);
    if (f64::MIN_POSITIVE..=f64::MAX).contains(&plain) || !r.is_finite() {
        return Extended::new(plain, 0);
    }
    let (fraction, exponent) = Scalar::frexp(r);
    // The product without its rounding, which the power of two would multiply by some hundreds.
    let DoubleWord { hi, lo } = DoubleWord::product(p, f64::from(exponent));
    let whole = libm::floor(hi);
    let rest = (hi - whole) + lo;
    let value = real_power(fraction, p) * Scalar::pow(2.0, rest);
    // The conversion saturates.
    Extended::new(value, whole as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_beyond_the_range() {
        for (r, p) in [(1e-120_f64, -3.0_f64), (1e200, 2.5), (1e-200, 9.0), (1e-308, -1.5)] {
            let half = Extended::new(r.powf(0.25 * p), 0);
            let want = half.times(half).times(half).times(half);
            let ratio = extended_power(r, p).times(Extended::new(1.0, 0)).plus(want.scale(-1.0));
            assert!(ratio.in_units(want.exponent().unwrap_or(0)).abs() < 1e-12, "{r} {p}");
        }
    }
}
