//! e^x and log x in double-word arithmetic, with +, -, *, / (in double precision the logarithm starts from libm's).

use crate::real::{DoubleWord, Real};

/// log 2.
pub(crate) fn log_2<T: Real>() -> DoubleWord<T> {
    DoubleWord::from_parts(core::f64::consts::LN_2, 2.319_046_813_846_299_6e-17)
}

/// Euler's constant.
pub(crate) fn euler<T: Real>() -> DoubleWord<T> {
    DoubleWord::from_parts(0.577_215_664_901_532_9, -4.942_915_152_430_645e-18)
}

/// e^x as `(m, n)`, e^x = m 2^n with 0.7 < m < 1.5, for |x| <= 2^15 (clamped beyond). Relative error below
/// (60 + 2 |x|) u^2.
pub(crate) fn exp<T: Real>(x: DoubleWord<T>) -> (DoubleWord<T>, i32) {
    let bound = T::from_i32(1 << 15);
    let x = if x.hi.abs() > bound { DoubleWord::from(bound.copysign(x.hi)) } else { x };
    // Rounds to the nearest integer; next to a half possibly to the other neighbour.
    let quotient = x.hi / log_2::<T>().hi;
    let n = (quotient + T::HALF.copysign(quotient)).to_i32();
    let whole = T::from_i32(n);
    // |r| <= 0.35. The subtraction cancels only leading digits of exact products.
    let r = x - log_2::<T>() * whole;
    // 1 + r (1 + r/2 (1 + r/3 ...)): 0.35^k / k! is below u^2 at k = 14 (f32), 24 (f64).
    let terms = if T::DIGITS > 24 { 24 } else { 14 };
    let m = (1..=terms).rev().fold(DoubleWord::ONE, |sum, k| DoubleWord::ONE + r * sum / T::from_i32(k));
    (m, n)
}

/// log x for x > 0 in the normal range. Absolute error below 100 u^2, relative error below 2 u, also near x = 1.
pub(crate) fn log<T: Real>(x: DoubleWord<T>) -> DoubleWord<T> {
    // Away from 1 the fraction keeps e^(-start) near 1. Near 1 no exponent is split off, so nothing cancels.
    let (fraction, shift) = if x.hi > T::HALF && x.hi < T::TWO { (x.hi, 0) } else { x.hi.frexp() };
    // Single precision starts from three terms of 2 artanh s, |s| <= 1/3, with an error of 2e-4. Firmware then needs no other logarithm.
    let (start, steps) = if T::DIGITS > 24 {
        (fraction.log(), 1)
    } else {
        let s = (fraction - T::ONE) / (fraction + T::ONE);
        let square = s * s;
        (s * (T::TWO + square * (T::from_f64(2.0 / 3.0) + square * T::from_f64(0.4))), 2)
    };
    let x = x.ldexp(-shift);
    let mut value = DoubleWord::from(start);
    for _ in 0..steps {
        // Newton's step: log x = start + log(x e^-start), where x e^-start - 1 is small, in the last step of the order u.
        let start = value.hi;
        let (m, n) = exp(DoubleWord::from(-start));
        let rest = x.ldexp(n) * m - DoubleWord::ONE;
        value = DoubleWord::sum(start, rest.hi);
    }
    value + log_2() * T::from_i32(shift)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// e^x e^-x = 1 and log e^x = x, to nearly twice the digits.
    fn inverses<T: Real>() {
        let u2 = T::EPSILON.to_f64() * T::EPSILON.to_f64() / 4.0;
        for i in -400..400 {
            let x = DoubleWord::<T>::from_parts(0.173_205_080_756_887_73 * f64::from(i), 1e-18);
            let ((a, n), (b, m)) = (exp(x), exp(-x));
            assert_eq!(n, -m);
            let product = a * b - DoubleWord::ONE;
            assert!(product.hi.to_f64().abs() < 2.0 * (60.0 + 2.0 * x.hi.to_f64().abs()) * u2, "{i} {product:?}");
            let back = log(a) + log_2() * T::from_i32(n) - x;
            assert!(back.hi.to_f64().abs() < (200.0 + 4.0 * x.hi.to_f64().abs()) * u2, "{i} {back:?}");
        }
    }

    #[test]
    fn exponential_and_logarithm_are_inverse() {
        inverses::<f64>();
        inverses::<f32>();
    }

    #[test]
    fn known_values() {
        // e = 2.718281828459045 0907955982984276...: the two f64 words.
        let (m, n) = exp(DoubleWord::<f64>::ONE);
        let e = m.ldexp(n);
        assert_eq!(e.hi, core::f64::consts::E);
        assert!((e.lo - 1.445_646_891_729_250_2e-16).abs() < 1e-30);
        let ten = log(DoubleWord::<f64>::from(10.0));
        assert_eq!(ten.hi, core::f64::consts::LN_10);
        assert!((ten.lo + 2.170_756_223_382_249_4e-16).abs() < 1e-30);
        assert_eq!(log(DoubleWord::<f32>::ONE), DoubleWord::ZERO);
    }
}
