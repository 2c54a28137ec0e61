//! Numbers with a separate exponent, so that intermediate results neither overflow nor underflow.

use crate::real::{DoubleWord, Real};
use crate::special::elementary::{log, log_2};

/// `value * 2^exponent`. Operations keep `value` near 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scaled<T> {
    value: DoubleWord<T>,
    exponent: i32,
}

impl<T: Real> Scaled<T> {
    pub const ZERO: Self = Self { value: DoubleWord::ZERO, exponent: 0 };

    /// `value * 2^exponent`.
    pub fn new(value: DoubleWord<T>, exponent: i32) -> Self {
        let (hi, shift) = value.hi.frexp();
        Self { value: DoubleWord { hi, lo: value.lo.ldexp(-shift) }, exponent: exponent.saturating_add(shift) }
    }

    pub fn is_zero(self) -> bool {
        self.value.hi == T::ZERO
    }

    pub fn times(self, other: Self) -> Self {
        Self::new(self.value * other.value, self.exponent.saturating_add(other.exponent))
    }

    pub fn over(self, other: Self) -> Self {
        Self::new(self.value / other.value, self.exponent.saturating_sub(other.exponent))
    }

    pub fn scale(self, factor: DoubleWord<T>) -> Self {
        Self::new(self.value * factor, self.exponent)
    }

    /// `self * 2^n`.
    pub fn shift(self, n: i32) -> Self {
        Self { value: self.value, exponent: self.exponent.saturating_add(n) }
    }

    pub fn plus(self, other: Self) -> Self {
        if self.is_zero() {
            return other;
        }
        if other.is_zero() {
            return self;
        }
        let (large, small) = if self.exponent >= other.exponent { (self, other) } else { (other, self) };
        // A term below 2^-200 of the larger one does not change the sum, so the shift may underflow.
        let small = small.value.ldexp(small.exponent.saturating_sub(large.exponent));
        Self::new(large.value + small, large.exponent)
    }

    pub fn powi(self, n: u32) -> Self {
        (0..n).fold(Self::new(DoubleWord::ONE, 0), |power, _| power.times(self))
    }

    /// The root of a number that is not negative.
    pub fn sqrt(self) -> Self {
        let odd = self.exponent & 1;
        Self::new(self.value.ldexp(odd).sqrt(), (self.exponent - odd) >> 1)
    }

    /// The natural logarithm of a positive number. Absolute error about 100 u^2 max(1, |log|), relative error below 2 u.
    pub fn log(self) -> DoubleWord<T> {
        if self.exponent.abs() < 8 {
            // Near 1 the contribution of the exponent would cancel.
            return log(self.value.ldexp(self.exponent));
        }
        log(self.value) + log_2() * T::from_i32(self.exponent)
    }

    /// The value multiplied by 2^exponent. It overflows or underflows only if the number does.
    pub fn double_word(self) -> DoubleWord<T> {
        self.value.ldexp(self.exponent)
    }

    /// Rounded to `T`; infinite beyond its range, without the exception that a host may trap.
    pub fn round(self) -> T {
        let hi = self.value.hi;
        if hi != T::ZERO && hi.frexp().1.saturating_add(self.exponent) > T::MAX_EXPONENT + 1 {
            return if hi < T::ZERO { -T::INFINITY } else { T::INFINITY };
        }
        hi.ldexp(self.exponent)
    }
}

impl<T: Real> From<T> for Scaled<T> {
    /// `x`, which is finite.
    fn from(x: T) -> Self {
        Self::new(DoubleWord::from(x), 0)
    }
}
