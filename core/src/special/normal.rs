//! The standard normal distribution: distribution function, density and quantile.

use super::gamma_series;
use crate::real::Real;

/// `a * b` as a rounded product and its exact error (Dekker's product with Veltkamp splitting). |a| and |b| must be far from the
/// ends of the exponent range.
fn two_product<T: Real>(a: T, b: T) -> (T, T) {
    let split = |x: T| {
        // 2^ceil(digits / 2) + 1.
        let scaled = x * (T::ONE.ldexp(T::DIGITS.div_ceil(2) as i32) + T::ONE);
        let high = scaled - (scaled - x);
        (high, x - high)
    };
    let product = a * b;
    let ((a1, a0), (b1, b0)) = (split(a), split(b));
    (product, a0 * b0 - (((product - a1 * b1) - a0 * b1) - a1 * b0))
}

/// `Phi(x) = P(N(0, 1) <= x)`, with full relative accuracy down to the smallest normal number: a few units in the last
/// place (test `normal_distribution`).
///
/// In double precision it is `erfc(-x / sqrt 2) / 2`. The rounding of the argument would cost x^2 units and is corrected to first order.
#[must_use]
pub fn distribution<T: Real>(x: T) -> T {
    if x.is_nan() {
        return x;
    }
    if x < T::from_i32(-40) {
        return T::ZERO;
    }
    if x > T::from_i32(40) {
        return T::ONE;
    }
    if T::DIGITS <= 24 {
        return narrow(x);
    }
    let root_half = T::from_f64(core::f64::consts::FRAC_1_SQRT_2);
    // 1/sqrt 2 in two words.
    let rest = -4.833_646_656_726_458e-17;
    let (y, error) = two_product(-x, root_half);
    let error = error - x * T::from_f64(rest);
    // erfc(y + e) = erfc(y) - e (2/sqrt pi) e^{-y^2} + ...
    let slope = T::from_f64(core::f64::consts::FRAC_2_SQRT_PI) * (-(y * y)).exp();
    T::HALF * (y.erfc() - error * slope)
}

/// [`distribution`] in single precision, computed from the parts of the incomplete gamma functions, so that firmware needs no erfc. With
/// h = x^2 / 2, P(1/2, h) = 2 |x| density(x) S and Q(1/2, h) = |x| density(x) F are P and Q of |N(0, 1)| <= |x|.
fn narrow<T: Real>(x: T) -> T {
    let (h, lost) = two_product(x, T::HALF * x);
    // e^-(h + lost)
    let d = x * T::from_f64(0.398_942_280_401_432_7) * ((-h).exp() * (T::ONE - lost));
    if h < T::HALF {
        return T::HALF + d * gamma_series::lower_series(T::HALF, h);
    }
    let tail = T::HALF * d * gamma_series::upper_fraction(T::HALF, h);
    if x > T::ZERO { T::ONE - tail } else { -tail }
}

/// The density `exp(-x^2/2) / sqrt(2 pi)`.
#[must_use]
pub fn density<T: Real>(x: T) -> T {
    T::from_f64(0.398_942_280_401_432_7) * (-(T::HALF * x * x)).exp()
}

/// The x with `Phi(x) = p`: -inf at 0, +inf at 1, NaN outside [0, 1].
///
/// Newton's method for `log Phi`, which is concave, so that the iterates increase to the root. Near p = 1/2 it is applied to `Phi - 1/2`,
/// which keeps the relative accuracy of a small result. Above 1/2 by symmetry. About ten evaluations, so not for inner loops.
#[must_use]
pub fn quantile<T: Real>(p: T) -> T {
    if !(p >= T::ZERO && p <= T::ONE) {
        return T::NAN;
    }
    let centred = p - T::HALF;
    if centred.abs() < T::from_f64(0.1) {
        let root_half = T::from_f64(core::f64::consts::FRAC_1_SQRT_2);
        let mut x = centred * T::from_f64(2.506_628_274_631_000_7); // sqrt(2 pi)
        for _ in 0..8 {
            let step = (T::HALF * (x * root_half).erf() - centred) / density(x);
            x -= step;
            if step.abs() <= T::EPSILON * x.abs() {
                break;
            }
        }
        return x;
    }
    if p > T::HALF {
        return -quantile(T::ONE - p);
    }
    if p == T::ZERO {
        return -T::INFINITY;
    }
    let log_p = p.log();
    // Phi(-t) <= exp(-t^2/2) / 2 for t >= 0, so this initial value is below the root.
    let mut x = -(-(T::TWO * log_p)).sqrt();
    for _ in 0..64 {
        let phi = distribution(x);
        // Where Phi underflows, the slope of log Phi is -x to leading order.
        let (value, slope) = if phi > T::ZERO { ((phi / p).log(), density(x) / phi) } else { (-T::ONE, -x) };
        let step = value / slope;
        x -= step;
        if step.abs() <= T::TWO * T::EPSILON * x.abs() {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (x, Phi(x)), rounded from 60-digit arithmetic.
    const TABLE: &[(f64, f64)] = &include!("../../../tests/data/normal.in");

    #[test]
    fn normal_distribution() {
        for &(x, want) in TABLE {
            let got = distribution(x);
            // libm's erfc is accurate to about 1 ulp; the terms of the correction add about one more.
            assert!((got - want).abs() <= 4.0 * f64::EPSILON * want, "{x}: {got:e} {want:e}");
            if x.abs() < 12.0 {
                // f32 inputs are rounded. The expected value is moved to the rounded point by the slope of the function.
                let (narrow, rounding) = (x as f32, f64::from(x as f32) - x);
                let want = want + rounding * density(x) * (1.0 - 0.5 * rounding * x);
                let got = f64::from(distribution(narrow));
                assert!((got - want).abs() <= 4.0 * f64::from(f32::EPSILON) * want + 1e-45, "{x}: {got:e} {want:e}");
            }
        }
    }

    #[test]
    fn normal_quantile() {
        for &(x, p) in TABLE {
            if p < 1.0 && x < 5.0 {
                // p is rounded by half a unit, which moves x by p u / phi(x).
                let conditioned = p / density(x) * f64::EPSILON;
                let got = quantile(p);
                assert!((got - x).abs() <= 4.0 * (conditioned + f64::EPSILON * x.abs()), "{x}: {got}");
            }
        }
        assert_eq!(quantile(0.5), 0.0);
        assert_eq!((quantile(0.0), quantile(1.0)), (f64::NEG_INFINITY, f64::INFINITY));
        assert!(quantile(-0.1_f64).is_nan() && quantile(f64::NAN).is_nan() && quantile(1.1_f32).is_nan());
        // The iteration also ends for the smallest numbers.
        assert!((quantile(f64::MIN_POSITIVE) + 37.5).abs() < 0.1 && quantile(1e-38_f32) < -12.0);
    }
}
