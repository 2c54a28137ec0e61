//! Lengths as a squared fraction and an exponent: exact for a radius, accurate to a few u^2 for a point.

use super::scaled::Scaled;
use crate::real::{DoubleWord, Real};
use crate::special::elementary::{log, log_2};

/// A length L >= 0 with L^2 = `square` * 4^`exponent`, 1/4 <= `square` < 3; or zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct Distance<T> {
    pub square: DoubleWord<T>,
    pub exponent: i32,
}

impl<T: Real> Distance<T> {
    /// |r|, finite; its square is exact.
    pub fn new(r: T) -> Self {
        let (fraction, exponent) = r.frexp();
        Self { square: DoubleWord::product(fraction, fraction), exponent }
    }

    /// |x|, with x finite.
    pub fn of_point<const D: usize>(x: &[T; D]) -> Self {
        let (_, exponent) = x.iter().fold(T::ZERO, |largest, c| largest.max(c.abs())).frexp();
        // A coordinate whose square underflows is negligible beside the largest one.
        let square =
            x.iter().map(|c| c.ldexp(-exponent)).fold(DoubleWord::ZERO, |sum, c| sum + DoubleWord::product(c, c));
        Self { square, exponent }
    }

    /// The length times j / n, for 0 < j <= n, to a few u^2.
    pub fn fraction(&self, j: u32, n: u32) -> Self {
        let [above, below] = [j, n].map(|n| T::from_usize((n * n) as usize));
        let square = self.square * above / below;
        // Back into [1/4, 1), where it fell below that.
        let steps = (-square.hi.frexp().1).max(0) >> 1;
        Self { square: square.ldexp(2 * steps), exponent: self.exponent.saturating_sub(steps) }
    }

    pub fn is_zero(&self) -> bool {
        self.square.hi == T::ZERO
    }

    /// L^2.
    pub fn squared(&self) -> Scaled<T> {
        Scaled::new(self.square, self.exponent.saturating_mul(2))
    }

    /// L.
    pub fn length(&self) -> Scaled<T> {
        Scaled::new(self.square.sqrt(), self.exponent)
    }

    /// L^n.
    pub fn power(&self, n: u32) -> Scaled<T> {
        let even = self.squared().powi(n / 2);
        if n % 2 == 1 { even.times(self.length()) } else { even }
    }

    /// L^2 in units of `4^exponent`. It may underflow where it is negligible beside 1.
    pub fn square_in(&self, exponent: i32) -> DoubleWord<T> {
        self.square.ldexp(self.exponent.saturating_sub(exponent).saturating_mul(2))
    }

    /// `self > other`, exact for the stored squares.
    pub fn exceeds(&self, other: &Self) -> bool {
        // Zero has no exponent to compare.
        if self.is_zero() {
            return false;
        }
        // Squares are in [1/4, 3), so two of them differ by a factor below 4^2.
        let apart = self.exponent - other.exponent;
        apart >= 2 || (apart >= -2 && self.square_in(other.exponent) > other.square)
    }

    /// Natural logarithm of L; 0 for L = 0. Absolute error about 100 u^2 max(1, |log L|), relative error below 2 u.
    pub fn log(&self) -> DoubleWord<T> {
        if self.is_zero() {
            return DoubleWord::ZERO;
        }
        let root = self.square.sqrt();
        if self.exponent.abs() < 8 {
            // Near L = 1 the contribution of the exponent would cancel.
            return log(root.ldexp(self.exponent));
        }
        log(root) + log_2() * T::from_i32(self.exponent)
    }
}

/// The measure of the unit sphere in dimension N: 2, 2 pi, 4 pi. (Anderson's omega_1 is half of the first.)
pub(super) fn sphere<T: Real>(dimension: usize) -> Scaled<T> {
    match dimension {
        1 => Scaled::from(T::TWO),
        2 => Scaled::new(DoubleWord::pi(), 1),
        _ => Scaled::new(DoubleWord::pi(), 2),
    }
}
