//! The scalar type: f32 or f64. Functions that `core` lacks without `std` are taken from libm.
//!
//! The trait is sealed. `sqrt` compiles to the hardware instruction. The other functions are libm's or defined here, and their
//! results do not depend on the machine.

use core::fmt::{Debug, Display};
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::build;

mod double_word;
mod extended;
mod root;
pub(crate) mod single;
mod wide;

pub use double_word::DoubleWord;
pub(crate) use extended::Extended;
use root::{sqrt_f32, sqrt_f64};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// f32 or f64.
pub trait Scalar:
    sealed::Sealed
    + Copy
    + Default
    + Debug
    + Display
    + PartialEq
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + crate::memory::Plain
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// 2.
    const TWO: Self;
    /// 1/2.
    const HALF: Self;
    /// pi, correctly rounded.
    const PI: Self;
    /// The distance from 1 to the next larger number, 2u.
    const EPSILON: Self;
    /// The smallest positive normal number.
    const MIN_POSITIVE: Self;
    /// The largest finite number.
    const MAX: Self;
    /// +infinity.
    const INFINITY: Self;
    /// A quiet NaN.
    const NAN: Self;
    /// Bits of the significand, the hidden one included: 24 or 53.
    const DIGITS: u32;
    /// The largest exponent e of a finite number m 2^e with 1 <= m < 2: 127 or 1023.
    const MAX_EXPONENT: i32;
    /// 4 or 8, as recorded in a prepared object.
    const BYTES: u32;

    /// The nearest value to `x`.
    fn from_f64(x: f64) -> Self;
    /// [`Scalar::from_f64`] for numbers that are not constants.
    fn from_wide(x: f64) -> Self;
    /// `x` + `self` in double precision.
    fn add_to(self, x: f64) -> f64;
    /// The integer part, for |x| < 2^31.
    fn to_i32(self) -> i32;
    /// The integer part, clamped to the range of 32 bits.
    fn to_u32(self) -> u32;
    /// Exact.
    fn from_f32(x: f32) -> Self;
    /// Exact.
    fn to_f64(self) -> f64;
    /// The nearest value to `n`.
    fn from_usize(n: usize) -> Self;
    /// The nearest value to `n`.
    fn from_i32(n: i32) -> Self;
    /// The nearest value to `n`.
    fn from_i64(n: i64) -> Self;

    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// NaN.
    fn is_nan(self) -> bool;
    /// |x|.
    fn abs(self) -> Self;
    /// The magnitude of `self` with the sign of `sign`.
    fn copysign(self, sign: Self) -> Self;
    /// The smaller number; if one is NaN, the other one.
    fn min(self, other: Self) -> Self;
    /// The larger number; if one is NaN, the other one.
    fn max(self, other: Self) -> Self;
    /// Correctly rounded square root.
    fn sqrt(self) -> Self;
    /// The largest integer <= x.
    fn floor(self) -> Self;
    /// The smallest integer >= x.
    fn ceil(self) -> Self;
    /// The nearest integer, halves away from zero.
    fn round(self) -> Self;
    /// `self * 2^n`, rounded once.
    fn ldexp(self, n: i32) -> Self;
    /// `(m, e)` with `self = m 2^e` and 0.5 <= |m| < 1; `(self, 0)` for zero, infinity, NaN.
    fn frexp(self) -> (Self, i32);
    /// e^x.
    fn exp(self) -> Self;
    /// e^x - 1, accurate near zero.
    fn expm1(self) -> Self;
    /// Natural logarithm.
    fn log(self) -> Self;
    /// log(1 + x), accurate near zero.
    fn log1p(self) -> Self;
    /// x^y.
    fn pow(self, y: Self) -> Self;
    /// sin x.
    fn sin(self) -> Self;
    /// cos x.
    fn cos(self) -> Self;
    /// The error function.
    fn erf(self) -> Self;
    /// 1 - erf(x), accurate for large x.
    fn erfc(self) -> Self;
    /// Gamma(x).
    fn gamma(self) -> Self;
    /// log |Gamma(x)|.
    fn log_gamma(self) -> Self;
    /// The bits; those of an f32 in the low half.
    fn bits(self) -> u64;
    /// The number with these bits.
    fn from_bits(bits: u64) -> Self;

    /// The numbers, if they are f32.
    fn singles(numbers: &[Self]) -> Option<&[f32]>;
    /// The numbers, if they are f64.
    fn doubles(numbers: &[Self]) -> Option<&[f64]>;
    /// The numbers, if they are f32.
    fn singles_mut(numbers: &mut [Self]) -> Option<&mut [f32]>;
    /// The numbers, if they are f64.
    fn doubles_mut(numbers: &mut [Self]) -> Option<&mut [f64]>;

    /// `self` to a small non-negative power, by repeated squaring.
    #[inline(always)]
    fn powi(self, n: u32) -> Self {
        let (mut base, mut left, mut result) = (self, n, Self::ONE);
        while left > 0 {
            if left & 1 == 1 {
                result *= base;
            }
            left >>= 1;
            // The square after the last factor is not needed and might overflow.
            if left > 0 {
                base *= base;
            }
        }
        result
    }
}

/// `a / b`, never inlined. The compiler would combine two adjacent single-precision divisions in one vector. Its unused lanes
/// would divide zero by zero, which raises an exception.
#[inline(never)]
pub(crate) fn quotient<T: Scalar>(a: T, b: T) -> T {
    a / b
}

/// The exponent next to the given one with which 2^e and 2^-e are normal numbers.
// Not `clamp`: where it is not inlined, its check of the bounds is a way to panic.
pub(crate) fn normal_exponent<T: Scalar>(exponent: i32) -> i32 {
    let most = T::MAX_EXPONENT - 1;
    exponent.max(-most).min(most)
}

/// The Euclidean length of `x`. Components are scaled by one power of two, so that squares are in range whenever the length is.
/// An infinite component, or a length out of range, gives infinity; a NaN gives NaN.
pub(crate) fn length<T: Scalar, const D: usize>(x: &[T; D]) -> T {
    let (_, exponent) = x.iter().fold(T::ZERO, |largest, c| largest.max(c.abs())).frexp();
    let square = x.iter().map(|c| c.ldexp(-exponent)).fold(T::ZERO, |sum, c| sum + c * c);
    square.sqrt().ldexp(exponent)
}

/// Implements the slice conversions for one type.
macro_rules! names {
    (f32) => {
        names!(singles singles_mut f32, doubles doubles_mut f64);
    };
    (f64) => {
        names!(doubles doubles_mut f64, singles singles_mut f32);
    };
    ($own:ident $own_mut:ident $t:ty, $other:ident $other_mut:ident $u:ty) => {
        #[inline(always)]
        fn $own(numbers: &[Self]) -> Option<&[$t]> {
            Some(numbers)
        }
        #[inline(always)]
        fn $own_mut(numbers: &mut [Self]) -> Option<&mut [$t]> {
            Some(numbers)
        }
        #[inline(always)]
        fn $other(_: &[Self]) -> Option<&[$u]> {
            None
        }
        #[inline(always)]
        fn $other_mut(_: &mut [Self]) -> Option<&mut [$u]> {
            None
        }
    };
}

macro_rules! real {
    ($t:tt, $bytes:literal, $digits:literal, $max_exponent:literal, $sqrt:path, $narrow:ident,
     $exp:path, $log:path,
     $floor:ident $ceil:ident $round:ident $expm1:ident $log1p:ident
     $pow:ident $sin:ident $cos:ident $erf:ident $erfc:ident $gamma:ident $log_gamma:ident) => {
        impl Scalar for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const TWO: Self = 2.0;
            const HALF: Self = 0.5;
            const PI: Self = core::$t::consts::PI;
            const EPSILON: Self = $t::EPSILON;
            const MIN_POSITIVE: Self = $t::MIN_POSITIVE;
            const MAX: Self = $t::MAX;
            const INFINITY: Self = $t::INFINITY;
            const NAN: Self = $t::NAN;
            const DIGITS: u32 = $digits;
            const MAX_EXPONENT: i32 = $max_exponent;
            const BYTES: u32 = $bytes;

            names!($t);
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                x as $t
            }
            #[inline(always)]
            fn from_wide(x: f64) -> Self {
                wide::$narrow(x)
            }
            #[inline(always)]
            fn add_to(self, x: f64) -> f64 {
                wide::sum(x, f64::from(self))
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn to_i32(self) -> i32 {
                self as i32
            }
            #[inline(always)]
            fn to_u32(self) -> u32 {
                // The conversion saturates, but may raise an exception when it does. Machines without double precision saturate without one.
                if !build::DOUBLE {
                    return self as u32;
                }
                let x = f64::from(self);
                let x = if x > 0.0 { x } else { 0.0 };
                (if x < 4_294_967_295.0 { x } else { 4_294_967_295.0 }) as u32
            }
            #[inline(always)]
            fn from_f32(x: f32) -> Self {
                $t::from(x)
            }
            #[inline(always)]
            fn from_usize(n: usize) -> Self {
                n as $t
            }
            #[inline(always)]
            fn from_i32(n: i32) -> Self {
                n as $t
            }
            #[inline(always)]
            fn from_i64(n: i64) -> Self {
                n as $t
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                // Compares bits where a floating-point comparison may be a function call.
                if build::DOUBLE { $t::is_finite(self) } else { self.to_bits() << 1 < $t::INFINITY.to_bits() << 1 }
            }
            #[inline(always)]
            fn is_nan(self) -> bool {
                $t::is_nan(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $t::abs(self)
            }
            #[inline(always)]
            fn copysign(self, sign: Self) -> Self {
                $t::copysign(self, sign)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if build::SHARED { single::least(self, other) } else { $t::min(self, other) }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if build::SHARED { -single::least(-self, -other) } else { $t::max(self, other) }
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            #[inline]
            fn floor(self) -> Self {
                libm::$floor(self)
            }
            #[inline]
            fn ceil(self) -> Self {
                libm::$ceil(self)
            }
            #[inline]
            fn round(self) -> Self {
                libm::$round(self)
            }
            #[inline]
            fn ldexp(self, n: i32) -> Self {
                // Three factors, for 2^n from the least subnormal number to the largest number. The factors are selected, not the products, which
                // would overflow for other n if the compiler computed all of them. After a product becomes subnormal, the remaining factors bring
                // the result below all numbers, so nothing is rounded twice.
                const LARGEST: i32 = $max_exponent;
                const LEAST: i32 = 1 - LARGEST + $digits;
                let part = |n: i32| {
                    if n > LARGEST {
                        LARGEST
                    } else if n < 1 - LARGEST {
                        LEAST
                    } else {
                        n
                    }
                };
                let first = part(n);
                let second = part(n.saturating_sub(first));
                let third = n.saturating_sub(first).saturating_sub(second).max(1 - LARGEST).min(LARGEST);
                let power = |n: i32| $t::from_bits((((n + LARGEST) as u64) << ($digits - 1)) as _);
                self * power(first) * power(second) * power(third)
            }
            #[inline]
            fn frexp(self) -> (Self, i32) {
                // A subnormal number is first scaled into the normal range, exactly. The factor is selected, not the product, which
                // would overflow for other numbers if the compiler computed both.
                let (factor, least) = if $t::abs(self) < $t::MIN_POSITIVE {
                    (18_446_744_073_709_551_616.0, $max_exponent + 63)
                } else {
                    (1.0, $max_exponent - 1)
                };
                let x = self * factor;
                let (bits, all) = (x.to_bits(), 2 * $max_exponent + 1);
                let exponent = (bits >> ($digits - 1)) & all;
                if exponent == 0 || exponent == all {
                    return (self, 0);
                }
                let half = bits & !(all << ($digits - 1)) | ($max_exponent - 1) << ($digits - 1);
                ($t::from_bits(half), exponent as i32 - least)
            }
            #[inline]
            fn exp(self) -> Self {
                $exp(self)
            }
            #[inline]
            fn expm1(self) -> Self {
                libm::$expm1(self)
            }
            #[inline]
            fn log(self) -> Self {
                $log(self)
            }
            #[inline]
            fn log1p(self) -> Self {
                libm::$log1p(self)
            }
            #[inline]
            fn pow(self, y: Self) -> Self {
                libm::$pow(self, y)
            }
            #[inline]
            fn sin(self) -> Self {
                libm::$sin(self)
            }
            #[inline]
            fn cos(self) -> Self {
                libm::$cos(self)
            }
            #[inline]
            fn erf(self) -> Self {
                libm::$erf(self)
            }
            #[inline]
            fn erfc(self) -> Self {
                libm::$erfc(self)
            }
            #[inline]
            fn gamma(self) -> Self {
                libm::$gamma(self)
            }
            #[inline]
            fn log_gamma(self) -> Self {
                libm::$log_gamma(self)
            }
            #[inline(always)]
            fn bits(self) -> u64 {
                self.to_bits().into()
            }
            #[inline(always)]
            fn from_bits(bits: u64) -> Self {
                $t::from_bits(bits as _)
            }
        }
    };
}

real!(f32, 4, 24, 127, sqrt_f32, narrow, single::exp, single::log, floorf ceilf roundf expm1f log1pf powf sinf cosf
      erff erfcf tgammaf lgammaf);
real!(f64, 8, 53, 1023, sqrt_f64, same, libm::exp, libm::log, floor ceil round expm1 log1p pow sin cos erf erfc tgamma
      lgamma);

#[cfg(test)]
mod tests {
    use super::{Scalar, length};

    #[test]
    fn conversions_saturate() {
        for x in
            [0.0, -0.0, 0.7, 1.0, 65_535.9, 16_777_217.0, 4e9, 4_294_967_294.0, 4_294_967_295.5, 5e9, 1e30, -1.0, -1e30]
        {
            assert_eq!((Scalar::to_u32(x), Scalar::to_u32(x as f32)), (x as u32, x as f32 as u32), "{x}");
        }
        for x in [f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
            assert_eq!((Scalar::to_u32(x), Scalar::to_u32(x as f32)), (x as u32, x as u32));
        }
    }

    #[test]
    fn powers_of_two_are_multiplied_as_by_libm() {
        let mut bits = 1_u64;
        for n in (-2300..2300).chain([i32::MIN, i32::MAX, -1_000_000, 1_000_000]) {
            for _ in 0..40 {
                bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                // includes subnormal numbers
                let bits = if bits.is_multiple_of(3) { bits & !(0x7FF << 52) } else { bits };
                let (x, y) = (f64::from_bits(bits), f32::from_bits((bits >> 32) as u32));
                if !x.is_nan() {
                    assert_eq!(Scalar::ldexp(x, n).to_bits(), libm::ldexp(x, n).to_bits(), "{x:e} {n}");
                }
                if !y.is_nan() {
                    assert_eq!(Scalar::ldexp(y, n).to_bits(), libm::ldexpf(y, n).to_bits(), "{y:e} {n}");
                }
            }
            for x in [0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE, 5e-324] {
                assert_eq!(Scalar::ldexp(x, n).to_bits(), libm::ldexp(x, n).to_bits(), "{x:e} {n}");
            }
        }
        assert!(Scalar::ldexp(f64::NAN, 3).is_nan() && Scalar::ldexp(f32::NAN, -3).is_nan());
    }

    #[test]
    fn lengths_over_the_whole_range() {
        // 3, 4, 5: exact at every power of two at which 3 is exact.
        for exponent in -1074..1021 {
            let at = |x: f64| Scalar::ldexp(x, exponent);
            assert_eq!(length(&[at(3.0), at(-4.0)]), at(5.0), "{exponent}");
            assert_eq!(length(&[at(2.0), at(6.0), at(-3.0)]), at(7.0), "{exponent}");
        }
        for exponent in -149..125 {
            let at = |x: f32| Scalar::ldexp(x, exponent);
            assert_eq!(length(&[at(3.0), at(-4.0)]), at(5.0), "{exponent}");
        }
        assert_eq!(length(&[0.0_f64; 3]), 0.0);
        assert_eq!(length(&[-5e-324_f64]), 5e-324);
        assert_eq!(length(&[f64::MAX, f64::MAX]), f64::INFINITY);
        assert_eq!(length(&[f64::NEG_INFINITY, 1.0]), f64::INFINITY);
        assert!(length(&[f32::NAN, 1.0]).is_nan() && length(&[f32::NAN, f32::INFINITY]).is_nan());
    }
}
