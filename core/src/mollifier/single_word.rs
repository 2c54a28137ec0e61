//! Gaussian mollifiers in 1D, and of order 4 in 2D, in single-word arithmetic, for sums over particles: tens of nanoseconds.
//!
//! 2D, with E = exp(-r^2/(2 delta^2)): psi = E (2E - 1/2) / (pi delta^2) and g = (1 - E)(1 + 2E) / (2 pi r^2), without cancellation.
//! 1D: sums of two or three error functions and Gaussians with weights of sum 1.

use super::gaussian::Gaussian;
use crate::real::Real;
use crate::special::elementary::{euler, log_2};
use crate::special::exponential_integral::plain_entire;

/// A point at distance r for a Gaussian mollifier of length delta; both squares are in the normal range.
#[derive(Clone, Copy, Debug)]
pub(super) struct SingleWord<T> {
    shape: Gaussian,
    dimension: usize,
    delta: T,
    square: T,
}

impl<T: Real> SingleWord<T> {
    /// `None` for other Gaussians, and where a square or the quotient of the two might leave the range. Callers then use the accurate functions.
    pub fn new(shape: Gaussian, dimension: usize, delta: T, x: &[T]) -> Option<Self> {
        if !(dimension == 1 || (dimension == 2 && shape.order() == 4)) {
            return None;
        }
        let square = x.iter().fold(T::ZERO, |sum, &c| sum + c * c);
        let (area, least) = (delta * delta, T::MIN_POSITIVE / T::EPSILON);
        let normal = |value: T| value > least && value < T::ONE / least;
        // At large distances the quotient would be infinite. Where it underflows it is negligible beside 1.
        let near = square * T::ONE.ldexp(20 - T::MAX_EXPONENT) < area;
        let fits = normal(area) && (square == T::ZERO || normal(square) && near);
        fits.then_some(Self { shape, dimension, delta, square })
    }

    /// psi_delta, to 4 u of its maximum (and (4 + 2 r^2/L^2) u of its terms).
    pub fn density(&self) -> T {
        let ratio = self.square / (self.delta * self.delta);
        if self.dimension == 2 {
            let e = (-(ratio * T::HALF)).exp();
            return e * (T::TWO * e - T::HALF) / (T::PI * self.delta * self.delta);
        }
        let sum = self.sum(|width| (-(ratio / (width * width))).exp() / width);
        sum / (T::PI.sqrt() * self.delta)
    }

    /// g, to 8 u.
    pub fn gradient_factor(&self) -> T {
        if self.dimension == 2 {
            let area = self.delta * self.delta;
            let half = self.square / area * T::HALF;
            let rest = (-half).expm1();
            // (1 - E) / (r^2/(2 delta^2)). It is 1 at r = 0, and to rounding wherever both are replaced by the least positive number.
            let fall = (-rest).max(T::MIN_POSITIVE) / half.max(T::MIN_POSITIVE);
            let e = T::ONE + rest;
            return fall * (T::ONE + T::TWO * e) / (T::TWO * T::TWO * T::PI * area);
        }
        if self.square == T::ZERO {
            // g(0) = psi(0) in 1D
            return self.density();
        }
        let r = self.square.sqrt();
        let z = r / self.delta;
        // The maximum is needed because the compiler may divide before the test r != 0.
        self.sum(|width| (z / width).erf()) / (T::TWO * r.max(T::MIN_POSITIVE))
    }

    /// The sum of w_i f(c_i).
    fn sum(&self, f: impl Fn(T) -> T) -> T {
        self.shape.terms().fold(T::ZERO, |sum, (weight, width): (T, T)| sum + weight * f(width))
    }

    /// phi: in 1D to 8 u; in 2D to 8 u (1 + |log delta| + |phi|).
    pub fn potential(&self) -> T {
        if self.dimension == 2 {
            // (log delta - log(2)/2 - gamma/2 + (2 Ein(xi) - Ein(xi/2))/2) / (2 pi)
            let ratio = self.square / (self.delta * self.delta);
            let rise = T::TWO * plain_entire(ratio) - plain_entire(ratio * T::HALF);
            let constant = log_2::<T>().hi + euler::<T>().hi;
            return (self.delta.log() + T::HALF * (rise - constant)) / (T::TWO * T::PI);
        }
        let z = self.square.sqrt() / self.delta;
        let root = T::PI.sqrt();
        let sum = self.sum(|width| {
            let y = z / width;
            z * y.erf() + width / root * (-(y * y)).exp()
        });
        T::HALF * self.delta * sum
    }
}
