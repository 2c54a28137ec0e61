//! Numbers in double precision with an exponent of their own: what a kernel gives may leave the range where its product with a mass does not.

use crate::real::Scalar;

/// `value` times 2^`exponent`, the value's magnitude being 0 or between 1/2 and 1 (or not finite).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wide {
    value: f64,
    pub(crate) exponent: i32,
}

impl Wide {
    pub(crate) const ZERO: Self = Self { value: 0.0, exponent: 0 };

    /// `value` times 2^`exponent`.
    pub(crate) fn new(value: f64, exponent: i32) -> Self {
        let (value, shift) = Scalar::frexp(value);
        Self { value, exponent: if value == 0.0 { 0 } else { exponent.saturating_add(shift) } }
    }

    pub(crate) fn is_zero(self) -> bool {
        self.value == 0.0
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        if self.is_zero() {
            return other;
        }
        if other.is_zero() {
            return self;
        }
        let exponent = self.exponent.max(other.exponent);
        Self::new(self.over(exponent) + other.over(exponent), exponent)
    }

    pub(crate) fn times(self, other: Self) -> Self {
        Self::new(self.value * other.value, self.exponent.saturating_add(other.exponent))
    }

    pub(crate) fn scale(self, factor: f64) -> Self {
        self.times(Self::new(factor, 0))
    }

    /// Times 2^n.
    pub(crate) fn shift(self, n: i32) -> Self {
        if self.is_zero() { self } else { Self { exponent: self.exponent.saturating_add(n), ..self } }
    }

    /// Divided by 2^n, as a number.
    pub(crate) fn over(self, n: i32) -> f64 {
        Scalar::ldexp(self.value, self.exponent.saturating_sub(n))
    }

    /// The number itself, which may overflow or underflow.
    pub(crate) fn to_f64(self) -> f64 {
        self.over(0)
    }
}

/// r^p for r > 0, in range or not.
pub(crate) fn power(r: f64, p: f64) -> Wide {
    let plain = super::law::real_power(r, p);
    if (f64::MIN_POSITIVE..=f64::MAX).contains(&plain) || !r.is_finite() {
        return Wide::new(plain, 0);
    }
    let (fraction, exponent) = Scalar::frexp(r);
    let whole = libm::floor(p * f64::from(exponent));
    let rest = p * f64::from(exponent) - whole;
    let value = super::law::real_power(fraction, p) * Scalar::pow(2.0, rest);
    // The conversion saturates.
    Wide::new(value, whole as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_beyond_the_range() {
        let big = Wide::new(3e300, 0).times(Wide::new(5e300, 0));
        assert_eq!(big.to_f64(), f64::INFINITY);
        assert!((big.times(Wide::new(1e-300, 0)).scale(1e-300).to_f64() / 15.0 - 1.0).abs() < 1e-14);
        assert_eq!(Wide::new(0.75, 0).plus(Wide::new(-0.5, 1)).to_f64(), -0.25);
        assert_eq!(Wide::new(0.0, 7).plus(Wide::new(3.0, -2)).shift(2).to_f64(), 3.0);
        for (r, p) in [(1e-120_f64, -3.0_f64), (1e200, 2.5), (1e-200, 9.0), (1e-308, -1.5)] {
            let half = Wide::new(r.powf(0.25 * p), 0);
            let want = half.times(half).times(half).times(half);
            let ratio = power(r, p).times(Wide::new(1.0, 0)).plus(want.scale(-1.0));
            assert!(ratio.over(want.exponent).abs() < 1e-12, "{r} {p}");
        }
    }
}
