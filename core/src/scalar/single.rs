//! e^x and log x in single precision, in half the flash of libm's, and helpers that the random numbers use too.

use super::Scalar;
use crate::build::shared;

shared! {
    /// Horner's rule, the highest power first.
    pub(crate) fn series<T: Scalar>(coefficients: &[f32], z: T) -> T {
        coefficients.iter().fold(T::ZERO, |sum, &c| sum * z + T::from_f32(c))
    }
}

shared! {
    /// log((1 + f) 2^e) for sqrt(1/2) <= 1 + f < sqrt(2) and an integer e, to about an ulp (msun e_log.c, e_logf.c).
    pub(crate) fn logarithm<T: Scalar>(f: T, e: T) -> T {
        let c = T::from_f64;
        // log(1 + f) = f - f^2/2 + s (f^2/2 + R(s^2)), s = f / (2 + f).
        let s = f / (T::TWO + f);
        let (z, half) = (s * s, T::HALF * f * f);
        let r = if T::DIGITS > 24 {
            let w = z * z;
            let even =
                w * (c(3.999_999_999_940_942e-1) + w * (c(2.222_219_843_214_978_4e-1) + w * c(1.531_383_769_920_937_3e-1)));
            let odd = z
                * (c(6.666_666_666_666_735e-1)
                    + w * (c(2.857_142_874_366_239e-1)
                        + w * (c(1.818_357_216_161_805e-1) + w * c(1.479_819_860_511_658_6e-1))));
            even + odd
        } else {
            z * series(&[0.242_790_79, 0.284_987_87, 0.400_009_72, 0.666_666_6], z)
        };
        let (high, low) = (c(6.931_471_803_691_238e-1), c(1.908_214_929_270_587_7e-10));
        e * high - ((half - (s * (half + r) + e * low)) - f)
    }
}

shared! {
    /// The smaller number; if one is NaN, the other one.
    pub(super) fn least<T: Scalar>(a: T, b: T) -> T {
        if a < b || b.is_nan() { a } else { b }
    }
}

/// log x.
pub(super) fn log(x: f32) -> f32 {
    if x.is_nan() || x <= 0.0 || x == f32::INFINITY {
        return if x == 0.0 {
            f32::NEG_INFINITY
        } else if x > 0.0 {
            x
        } else {
            f32::NAN
        };
    }
    let (m, e) = Scalar::frexp(x);
    let (m, e) = if m < core::f32::consts::FRAC_1_SQRT_2 { (m + m, e - 1) } else { (m, e) };
    logarithm(m - 1.0, e as f32)
}

/// e^x as 2^n e^r, with n the integer nearest to x / log 2 and r = x - n log 2, |r| < 0.35. The first omitted term of the Taylor series of
/// e^r is below 6e-9.
pub(super) fn exp(x: f32) -> f32 {
    if x.is_nan() {
        return x;
    }
    // Clamped beyond both ends of the range.
    let x = if x.abs() > 150.0 { 150.0_f32.copysign(x) } else { x };
    let n = (x * core::f32::consts::LOG2_E + 0.5_f32.copysign(x)) as i32;
    let whole = n as f32;
    // log 2 in two parts. The first has 16 digits, so that its product is exact.
    let r = (x - whole * 0.693_145_75) - whole * 1.428_606_8e-6;
    let s = series(&[1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5], r);
    Scalar::ldexp(1.0 + (r + r * r * s), n)
}

#[cfg(test)]
mod tests {
    use super::{exp, log};

    /// Compared with double precision, in units in the last place of the result.
    #[test]
    fn within_an_ulp_and_a_half() {
        for i in -103_000..88_700 {
            let x = 0.001 * i as f32 + 1e-5;
            let (got, want) = (f64::from(exp(x)), libm::exp(f64::from(x)));
            let ulp = f64::from(f32::EPSILON) * want.max(f64::from(f32::MIN_POSITIVE));
            assert!((got - want).abs() <= 1.5 * ulp, "{x} {got:e} {want:e}");
        }
        for i in 1..400_000_u32 {
            let x = f32::from_bits(i.wrapping_mul(5333));
            let (got, want) = (f64::from(log(x)), libm::log(f64::from(x)));
            if x.is_finite() {
                assert!((got - want).abs() <= 1.5 * f64::from(f32::EPSILON) * want.abs(), "{x:e} {got:e} {want:e}");
            }
        }
        assert_eq!((log(0.0), log(f32::INFINITY), log(1.0), exp(0.0)), (f32::NEG_INFINITY, f32::INFINITY, 0.0, 1.0));
        assert_eq!((exp(-1e9), exp(1e9), exp(f32::NEG_INFINITY)), (0.0, f32::INFINITY, 0.0));
        assert!(log(-1.0).is_nan() && log(f32::NAN).is_nan() && exp(f32::NAN).is_nan());
    }
}
