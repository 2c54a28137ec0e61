//! The exponential integrals E1 and Ein, which libm does not provide.
//!
//! E1(x) = integral of e^-u / u over (x, infinity) and Ein(x) = integral of (1 - e^-u) / u over (0, x), an entire function;
//! E1(x) = Ein(x) - log x - gamma (DLMF 6.2.1 to 6.2.4).

use super::elementary::{euler, exp, log};
use crate::real::{DoubleWord, Real};

/// The power series is used below this value, the continued fraction above.
const SPLIT: f64 = 2.0;

/// E1(x), x > 0, within 1 ulp; with one more rounding where it is subnormal. +infinity at 0, 0 at +infinity,
/// NaN for negative and NaN arguments.
///
/// About a hundred double-word operations: microseconds.
#[must_use]
pub fn exponential_integral<T: Real>(x: T) -> T {
    if x.is_nan() || x < T::ZERO {
        return T::NAN;
    }
    if x == T::ZERO {
        return T::INFINITY;
    }
    // For larger x, e^-x / x is below the smallest subnormal number.
    if x.to_f64() > 760.0 {
        return T::ZERO;
    }
    let (value, exponent) = scaled_exponential_integral(x.into());
    value.hi.ldexp(exponent)
}

/// E1(x) as `(m, n)`, E1(x) = m 2^n, for 0 < x <= 2^15.
pub(crate) fn scaled_exponential_integral<T: Real>(x: DoubleWord<T>) -> (DoubleWord<T>, i32) {
    if x.hi.to_f64() < SPLIT {
        // At most six bits cancel (Ein(2) = 1.32, E1(2) = 0.049).
        return (entire_series(x) - normal_log(x) - euler(), 0);
    }
    // e^-x / (x + 1 - 1/(x + 3 - 4/(x + 5 - 9/(...)))) (DLMF 6.9.1, even part), evaluated from the tail. Its error is about
    // 4 pi e^(x - 4 sqrt(n x)): 8e-21 at x = 2 with 80 terms, 5e-11 with 24, at most u/1000.
    let terms = if T::DIGITS > 24 { 80 } else { 24 };
    let odd = |k: i32| x + DoubleWord::from(T::from_i32(2 * k + 1));
    let tail = (1..=terms).rev().fold(odd(terms), |rest, k| odd(k - 1) - DoubleWord::from(T::from_i32(k * k)) / rest);
    let (m, n) = exp(-x);
    (m / tail, n)
}

/// Ein(x), 0 <= x <= 2^15, with a relative error below u/1000.
pub(crate) fn entire_exponential_integral<T: Real>(x: DoubleWord<T>) -> DoubleWord<T> {
    if x.hi.to_f64() < SPLIT {
        return entire_series(x);
    }
    let (value, exponent) = scaled_exponential_integral(x);
    value.ldexp(exponent) + log(x) + euler()
}

/// Ein(x), x >= 0, in single-word arithmetic: error about 8 u of max(1, Ein), tens to hundreds of nanoseconds.
pub(crate) fn plain_entire<T: Real>(x: T) -> T {
    if x < T::TWO {
        // x - x^2/(2 2!) + x^3/(3 3!) - ...: 2^k/(k k!) is below u/100 at k = 16 (f32), 26 (f64).
        let terms = if T::DIGITS > 24 { 26 } else { 16 };
        let (mut sum, mut term) = (x, x);
        for k in 2..=terms {
            let k = T::from_i32(k);
            term = -(term * x) / k;
            sum += term / k;
        }
        return sum;
    }
    let far = x.log() + euler::<T>().hi;
    if x > T::from_i32(T::DIGITS as i32) {
        return far;
    }
    // As above, with enough terms for e^-40.
    let terms = 10 + (T::from_i32(90) / x).to_i32();
    let odd = |k: i32| x + T::from_i32(2 * k + 1);
    let tail = (1..=terms).rev().fold(odd(terms), |rest, k| odd(k - 1) - T::from_i32(k * k) / rest);
    far + (-x).exp() / tail
}

/// Ein(x) = e^-x sum over k >= 1 of H_k x^k / k!, with H_k = 1 + 1/2 + ... + 1/k: no term is negative.
fn entire_series<T: Real>(x: DoubleWord<T>) -> DoubleWord<T> {
    let (mut sum, mut term, mut harmonic) = (DoubleWord::ZERO, DoubleWord::ONE, DoubleWord::ZERO);
    // 2^k / k! is below u^2 at k = 22 (f32), 36 (f64).
    let terms = if T::DIGITS > 24 { 36 } else { 22 };
    for k in 1..=terms {
        let k = T::from_i32(k);
        term = term * x / k;
        harmonic = harmonic + DoubleWord::ONE / k;
        sum = sum + term * harmonic;
    }
    let (m, n) = exp(-x);
    sum * m.ldexp(n)
}

/// log x, also for subnormal x.
fn normal_log<T: Real>(x: DoubleWord<T>) -> DoubleWord<T> {
    let (_, shift) = x.hi.frexp();
    if shift.abs() < 64 {
        return log(x);
    }
    log(x.ldexp(-shift)) + super::elementary::log_2() * T::from_i32(shift)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x, E1(x) and its rounding error, by mpmath 1.3 at 120 digits.
    #[rustfmt::skip]
    const TABLE: &[(f64, f64, f64)] = &[
        (1e-300, 690.1983122333122, -3.5943937330508644e-14),
        (2.5e-40, 90.60989732298614, -3.347914688348092e-15),
        (1e-10, 22.448635265138925, -1.4333659254039727e-15),
        (0.001, 6.331539364136149, 2.7165441847358475e-16),
        (0.1, 1.8229239584193906, 2.7093545264763093e-17),
        (0.5, 0.5597735947761608, -3.152032504186642e-17),
        (0.9, 0.26018393932599965, -1.6437182552284956e-17),
        (1.0, 0.21938393439552029, -1.2176656266205919e-17),
        (1.25, 0.1464133725259102, -1.3664930808864609e-17),
        (1.5, 0.10001958240663265, -1.9684726038497914e-18),
        (1.75, 0.06948868460463879, 2.636096429731133e-19),
        (1.9990234375, 0.04896664081526858, 2.793810372918044e-19),
        (2.0, 0.04890051070806112, 1.6856555120420878e-18),
        (2.25, 0.0347620731194446, -4.703115740343508e-19),
        (2.5, 0.024914917870269736, -9.53956373421134e-19),
        (3.0, 0.013048381094197037, 5.678388936001898e-19),
        (4.0, 0.0037793524098489067, -2.1550914743272418e-19),
        (5.5, 0.0006409260498657627, -2.1967036321956436e-20),
        (8.0, 3.76656228439249e-05, 2.135151584383e-21),
        (12.0, 4.751081824672494e-07, -2.0258113058073246e-23),
        (20.0, 9.835525290649882e-11, 1.5055525966679167e-27),
        (40.0, 1.036773261451657e-19, -4.8121749868957976e-36),
        (80.0, 2.228543258688473e-37, 2.558294587994277e-55),
        (87.0, 1.870476548141561e-40, -3.2016859233300064e-57),
        (300.0, 1.71038427680451e-133, 8.31820700997734e-150),
        (700.0, 1.406518766234033e-307, -1e-323),
        (738.0, 5e-324, -0.0),
    ];

    #[test]
    fn values_are_within_one_ulp() {
        for &(x, hi, lo) in TABLE {
            let ulp = f64::from_bits(hi.to_bits() + 1) - hi;
            let got = exponential_integral(x);
            assert!(((got - hi) - lo).abs() <= ulp, "{x} {got} {hi}");
            let single = x as f32;
            if f64::from(single) == x {
                let want = hi as f32;
                let ulp = f64::from(f32::from_bits(want.to_bits() + 1)) - f64::from(want);
                assert!((f64::from(exponential_integral(single)) - hi).abs() <= ulp, "{x} in f32");
            }
        }
    }

    #[test]
    fn the_plain_form_agrees() {
        fn check<T: Real>() {
            for i in 0..2000 {
                let x = T::from_f64(0.03 * f64::from(i));
                let want = entire_exponential_integral(DoubleWord::from(x)).hi;
                let error = (plain_entire(x) - want).abs().to_f64();
                assert!(error <= 4.0 * T::EPSILON.to_f64() * want.to_f64().max(1.0), "{x} {error}");
            }
        }
        check::<f64>();
        check::<f32>();
    }

    #[test]
    fn the_two_ways_agree_where_they_meet() {
        let x = DoubleWord::from(SPLIT);
        let below = entire_series(x) - log(x) - euler();
        let (m, n) = scaled_exponential_integral(x);
        // The truncation error of the fraction at x = 2.
        assert!(((below - m.ldexp(n)).hi / below.hi).abs() < 2e-20);
    }

    #[test]
    fn edges() {
        assert_eq!(exponential_integral(0.0), f64::INFINITY);
        assert_eq!(exponential_integral(f64::INFINITY), 0.0);
        assert_eq!(exponential_integral(1e9_f32), 0.0);
        assert!(exponential_integral(-1.0_f64).is_nan() && exponential_integral(f32::NAN).is_nan());
        assert_eq!(entire_exponential_integral(DoubleWord::<f64>::ZERO), DoubleWord::ZERO);
    }
}
