//! f64 with an exponent of its own: for numbers that may leave the range although a product with another is within it.

use super::Scalar;

/// `value * 2^exponent`. The magnitude of `value` is 0, or from 1/2 to below 1, or `value` is not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extended {
    value: f64,
    exponent: i32,
}

impl Extended {
    pub(crate) const ZERO: Self = Self { value: 0.0, exponent: 0 };

    /// `value * 2^exponent`.
    pub(crate) fn new(value: f64, exponent: i32) -> Self {
        let (value, shift) = Scalar::frexp(value);
        Self { value, exponent: if value == 0.0 { 0 } else { exponent.saturating_add(shift) } }
    }

    pub(crate) fn is_zero(self) -> bool {
        self.value == 0.0
    }

    /// The exponent; none for zero.
    pub(crate) fn exponent(self) -> Option<i32> {
        (!self.is_zero()).then_some(self.exponent)
    }

    /// The number divided by 2^`unit`: infinite or zero only if that is.
    pub(crate) fn in_units(self, unit: i32) -> f64 {
        Scalar::ldexp(self.value, self.exponent.saturating_sub(unit))
    }

    /// The number: infinite or zero only if it is.
    pub(crate) fn get(self) -> f64 {
        self.in_units(0)
    }

    /// The product.
    pub(crate) fn times(self, other: Self) -> Self {
        Self::new(self.value * other.value, self.exponent.saturating_add(other.exponent))
    }

    /// The product with a plain number.
    pub(crate) fn scale(self, factor: f64) -> Self {
        self.times(Self::new(factor, 0))
    }

    /// The magnitude.
    pub(crate) fn abs(self) -> Self {
        Self { value: self.value.abs(), ..self }
    }

    /// The product with 2^`n`.
    pub(crate) fn shift(self, n: i32) -> Self {
        if self.is_zero() { self } else { Self { exponent: self.exponent.saturating_add(n), ..self } }
    }

    /// The quotient; `other` is not zero.
    pub(crate) fn over(self, other: Self) -> Self {
        Self::new(self.value / other.value, self.exponent.saturating_sub(other.exponent))
    }

    /// The sum.
    pub(crate) fn plus(self, other: Self) -> Self {
        if self.is_zero() {
            return other;
        }
        if other.is_zero() {
            return self;
        }
        let top = self.exponent.max(other.exponent);
        Self::new(self.in_units(top) + other.in_units(top), top)
    }

    /// `|self| < |other|` of numbers that are not zero.
    pub(crate) fn is_smaller(self, other: Self) -> bool {
        (self.exponent, self.value.abs()) < (other.exponent, other.value.abs())
    }

    /// The n-th root of a positive number, n = 1, 2, 3.
    pub(crate) fn root(self, n: i32) -> Self {
        // The exponent becomes a multiple of n.
        let rest = self.exponent.rem_euclid(n);
        let value = self.value.ldexp(rest);
        let root = match n {
            1 => value,
            2 => Scalar::sqrt(value),
            _ => value.pow(1.0 / 3.0),
        };
        Self::new(root, (self.exponent - rest) / n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_beyond_the_range() {
        let big = Extended::new(3e300, 0).times(Extended::new(5e300, 0));
        assert_eq!(big.get(), f64::INFINITY);
        assert!((big.times(Extended::new(1e-300, 0)).scale(1e-300).get() / 15.0 - 1.0).abs() < 1e-14);
        assert_eq!(Extended::new(0.75, 0).plus(Extended::new(-0.5, 1)).get(), -0.25);
        assert_eq!(Extended::new(0.0, 7).plus(Extended::new(3.0, -2)).shift(2).get(), 3.0);
    }
}
