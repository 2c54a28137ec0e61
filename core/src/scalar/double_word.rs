//! Double-word arithmetic: numbers as an unevaluated sum of two, with twice the digits, from +, -, * and / alone.
//!
//! Algorithms 1 to 17 of M. Joldes, J.-M. Muller, V. Popescu, "Tight and rigorous error bounds for basic building blocks
//! of double-word arithmetic", ACM TOMS 44 (2017). Dekker's product (with Veltkamp's splitting) replaces the fused
//! multiply-add, so that the bits are the same on every machine. Relative errors with unit roundoff u: sum 3 u^2, product
//! 7 u^2, quotient 15 u^2 and root 4 u^2, if no part leaves the normal range. Callers scale by powers of two.

use core::ops::{Add, Div, Mul, Neg, Sub};

use super::Scalar;
use crate::build::shared;

/// `hi + lo`, with `hi` the sum rounded to nearest.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct DoubleWord<T> {
    /// The value, rounded.
    pub hi: T,
    /// The rounding error.
    pub lo: T,
}

/// `a + b` exactly, if |a| >= |b| or a = 0 (Dekker).
#[inline(always)]
fn fast_two_sum<T: Scalar>(a: T, b: T) -> DoubleWord<T> {
    let hi = a + b;
    DoubleWord { hi, lo: b - (hi - a) }
}

/// The upper half of the digits (Veltkamp).
#[inline(always)]
fn upper_half<T: Scalar>(a: T) -> T {
    let c = a * T::from_i32((1 << T::DIGITS.div_ceil(2)) + 1);
    c - (c - a)
}

impl<T: Scalar> DoubleWord<T> {
    /// 0.
    pub const ZERO: Self = Self { hi: T::ZERO, lo: T::ZERO };
    /// 1.
    pub const ONE: Self = Self { hi: T::ONE, lo: T::ZERO };

    /// `hi + lo` of two f64 parts, as accurate as `T` allows. For constants.
    #[inline(always)]
    #[must_use]
    pub fn from_parts(hi: f64, lo: f64) -> Self {
        let first = T::from_f64(hi);
        fast_two_sum(first, T::from_f64((hi - first.to_f64()) + lo))
    }

    /// pi.
    #[inline(always)]
    #[must_use]
    pub fn pi() -> Self {
        Self::from_parts(core::f64::consts::PI, 1.224_646_799_147_353_2e-16)
    }

    /// `a + b`, exactly (Knuth).
    #[inline(always)]
    #[must_use]
    pub fn sum(a: T, b: T) -> Self {
        let hi = a + b;
        let b_part = hi - a;
        let a_part = hi - b_part;
        Self { hi, lo: (a - a_part) + (b - b_part) }
    }

    /// The sum with a number: a two-sum and one renormalisation. For running sums.
    #[inline(always)]
    #[must_use]
    pub fn plus(self, b: T) -> Self {
        let sum = Self::sum(self.hi, b);
        fast_two_sum(sum.hi, sum.lo + self.lo)
    }

    /// `a b`, exactly (Dekker).
    #[inline(always)]
    #[must_use]
    pub fn product(a: T, b: T) -> Self {
        let hi = a * b;
        let (a1, b1) = (upper_half(a), upper_half(b));
        let (a2, b2) = (a - a1, b - b1);
        Self { hi, lo: a2 * b2 - (((hi - a1 * b1) - a2 * b1) - a1 * b2) }
    }

    /// `a / b`.
    #[inline(always)]
    #[must_use]
    pub fn quotient(a: T, b: T) -> Self {
        Self::from(a) / Self::from(b)
    }

    shared! {
        /// The positive square root; 0 for 0.
        #[must_use]
        pub fn sqrt(self) -> Self {
            if self.hi <= T::ZERO {
                return Self::ZERO;
            }
            let root = self.hi.sqrt();
            let rest = self - Self::product(root, root);
            fast_two_sum(root, rest.hi / (root + root))
        }
    }

    shared! {
        /// `self * 2^n`, exactly unless a part leaves the normal range.
        #[must_use]
        pub fn ldexp(self, n: i32) -> Self {
            Self { hi: self.hi.ldexp(n), lo: self.lo.ldexp(n) }
        }
    }

    shared! {
        /// `self` to a small non-negative power, by repeated multiplication.
        #[must_use]
        pub fn powi(self, n: u32) -> Self {
            (0..n).fold(Self::ONE, |power, _| power * self)
        }
    }
}

impl<T: Scalar> From<T> for DoubleWord<T> {
    #[inline(always)]
    fn from(hi: T) -> Self {
        Self { hi, lo: T::ZERO }
    }
}

impl<T: Scalar> Neg for DoubleWord<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl<T: Scalar> Add for DoubleWord<T> {
    type Output = Self;
    shared! {
        /// AccurateDWPlusDW. The bound holds for operands of opposite sign too.
        fn add(self, other: Self) -> Self {
            let s = Self::sum(self.hi, other.hi);
            let t = Self::sum(self.lo, other.lo);
            let v = fast_two_sum(s.hi, s.lo + t.hi);
            fast_two_sum(v.hi, t.lo + v.lo)
        }
    }
}

impl<T: Scalar> Sub for DoubleWord<T> {
    type Output = Self;
    shared! {
        fn sub(self, other: Self) -> Self {
            self + -other
        }
    }
}

impl<T: Scalar> Mul<T> for DoubleWord<T> {
    type Output = Self;
    shared! {
        fn mul(self, other: T) -> Self {
            let c = Self::product(self.hi, other);
            fast_two_sum(c.hi, c.lo + self.lo * other)
        }
    }
}

impl<T: Scalar> Mul for DoubleWord<T> {
    type Output = Self;
    shared! {
        fn mul(self, other: Self) -> Self {
            let c = Self::product(self.hi, other.hi);
            fast_two_sum(c.hi, c.lo + (self.hi * other.lo + self.lo * other.hi))
        }
    }
}

impl<T: Scalar> Div for DoubleWord<T> {
    type Output = Self;
    shared! {
        fn div(self, other: Self) -> Self {
            let first = self.hi / other.hi;
            let rest = self - other * first;
            fast_two_sum(first, rest.hi / other.hi)
        }
    }
}

impl<T: Scalar> Div<T> for DoubleWord<T> {
    type Output = Self;
    shared! {
        fn div(self, other: T) -> Self {
            self / Self::from(other)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f32 pairs compared with f64, which holds 53 digits for their 48: the stated bounds, for a lattice of difficult operands.
    #[test]
    fn operations_keep_their_bounds() {
        let u2 = 2_f64.powi(-48);
        let value = |x: DoubleWord<f32>| f64::from(x.hi) + f64::from(x.lo);
        let operands: std::vec::Vec<DoubleWord<f32>> = (0..200)
            .map(|i: i32| {
                let x = f64::from(i * i * 7919 % 1013 - 500) * 0.731_234_567_891_234 + 1e-4 * f64::from(i);
                DoubleWord::from_parts(x, 0.0)
            })
            .filter(|x| x.hi != 0.0)
            .collect();
        for &a in &operands {
            for &b in &operands {
                let close = |got: DoubleWord<f32>, want: f64, bound: f64| {
                    // f64 itself adds 2^-53, a thirtieth of u^2.
                    assert!((value(got) - want).abs() <= (bound + 0.1) * u2 * want.abs(), "{a:?} {b:?} {got:?} {want}");
                };
                close(a + b, value(a) + value(b), 3.0);
                close(a - b, value(a) - value(b), 3.0);
                close(a * b, value(a) * value(b), 7.0);
                close(a / b, value(a) / value(b), 15.0);
            }
            let root = (a * a).sqrt();
            assert!((value(root) - value(a).abs()).abs() <= 12.0 * u2 * value(a).abs());
        }
    }

    #[test]
    fn pi_has_both_words() {
        let pi = DoubleWord::<f32>::pi();
        assert!((f64::from(pi.hi) + f64::from(pi.lo) - core::f64::consts::PI).abs() < 1e-14);
        assert_eq!(DoubleWord::<f64>::pi().hi, core::f64::consts::PI);
    }
}
