//! The regularised incomplete gamma functions, and the inverse of the upper one.
//!
//! `P(a, x) = gamma(a, x) / Gamma(a)`, `Q(a, x) = Gamma(a, x) / Gamma(a)`, P + Q = 1. With U ~ Gamma(a, 1), Q is P(U > x): the distribution of
//! the time at which a squared Bessel process of index -a hits zero (Zhelezov & Fatkullin (2.10)).
//!
//! There are four methods, each used where it does not cancel (Gautschi 1979; Temme 1994; Gil, Segura & Temme 2012):
//! * a <= 1, x <= 1: the series at zero, with `1 - x^a / Gamma(1 + a)` taken from expm1;
//! * a >= 25 and x / a within about (0.3, 2.4): Temme's uniform expansion;
//! * otherwise, for x <= a + 1 the series of P, for larger x the continued fraction of Q.
//!
//! The common factor `x^a e^{-x} / Gamma(a + 1)` is `exp(-a phi(x / a))` times a smooth function of a, with
//! `phi(l) = l - 1 - log l`, so that small tails keep their relative accuracy. The error is a few units plus some units times the
//! logarithm of the result (test `against_sixty_digits`). The rounding of x alone has an effect of that size.

use super::gamma_series::{lower_series, upper_fraction};
use crate::real::Real;

/// Terms of Temme's expansion.
const TERMS: usize = 26;

/// The Taylor coefficients of `eta / (lambda - 1)` in eta, where `eta^2 / 2 = lambda - 1 - log lambda` with the sign of lambda - 1.
///
/// From `(1 + w) eta = w w'`, `w = lambda - 1 = sum a_k eta^k`: (n + 1) a_n = a_{n-1} - sum_{k=2}^{n-1} k a_k a_{n+1-k}; then the
/// reciprocal series of w / eta. (Temme 1979; the numbers begin 1, -1/3, 1/12, -2/135.)
#[expect(clippy::indexing_slicing, reason = "evaluated by the compiler alone")]
const EXPANSION: [f64; TERMS] = {
    let mut a = [0.0; TERMS + 2];
    a[1] = 1.0;
    let mut n = 2;
    while n < TERMS + 2 {
        let mut sum = a[n - 1];
        let mut k = 2;
        while k < n {
            sum -= k as f64 * a[k] * a[n + 1 - k];
            k += 1;
        }
        a[n] = sum / (n as f64 + 1.0);
        n += 1;
    }
    let mut f = [0.0; TERMS];
    f[0] = 1.0;
    let mut n = 1;
    while n < TERMS {
        let mut sum = 0.0;
        let mut k = 1;
        while k <= n {
            sum -= a[k + 1] * f[n - k];
            k += 1;
        }
        f[n] = sum;
        n += 1;
    }
    f
};

/// The coefficients needed in single precision: |eta| < 1, and each term is about a third of the previous one.
#[expect(clippy::indexing_slicing, reason = "evaluated by the compiler alone")]
const NARROW: [f32; 14] = {
    let mut narrow = [0.0; 14];
    let mut k = 0;
    while k < narrow.len() {
        narrow[k] = EXPANSION[k] as f32;
        k += 1;
    }
    narrow
};

/// (1 / Gamma(1 + a) - 1) / a for 0 <= a <= 1 in single precision: the Chebyshev fit of degree 8, error 3.2e-10 (from 60 digits).
/// (libm's single-precision functions compute in double precision, which is too large for firmware.)
fn gamma_rise<T: Real>(a: T) -> T {
    const FIT: [f32; 9] = [
        0.00012755832,
        -0.001_670_031_6,
        0.0076638551,
        -0.009_862_522,
        -0.04211904,
        0.16652387,
        -0.042001232,
        -0.6558781,
        0.5772157,
    ];
    FIT.iter().fold(T::ZERO, |sum, &c| sum * a + T::from_f32(c))
}

/// log(1 + y) for y > -1, with relative accuracy near zero: libm's, in single precision computed from functions that are linked anyway.
fn log1p<T: Real>(y: T) -> T {
    if T::DIGITS > 24 {
        return y.log1p();
    }
    if y.abs() > T::HALF { (T::ONE + y).log() } else { y - log_excess(y) }
}

/// e^y - 1, as [`log1p`].
fn expm1<T: Real>(y: T) -> T {
    if T::DIGITS > 24 {
        return y.expm1();
    }
    if y.abs() > T::HALF {
        return y.exp() - T::ONE;
    }
    // y (1 + y/2 (1 + y/3 ...)). The remainder, 2^-9 / 10!, is far below a rounding.
    y * (2..10).rev().fold(T::ONE, |sum, k| T::ONE + y * sum / T::from_i32(k))
}

/// log Gamma(1 + a) for 0 <= a <= 1, with relative accuracy down to a = 0.
fn log_gamma_1p<T: Real>(a: T) -> T {
    if T::DIGITS <= 24 {
        return -log1p(a * gamma_rise(a));
    }
    let y = T::ONE + a;
    let lost = a - (y - T::ONE);
    // psi(1 + a) = -gamma + a pi^2/6 - ...: the correction is below a rounding, so two digits of its factor suffice.
    let digamma = T::from_f64(1.645) * a / (T::ONE + T::from_f64(0.6) * a) - T::from_f64(0.577_215_664_901_532_9);
    y.log_gamma() + lost * digamma
}

/// `mu - log(1 + mu)` for mu > -1.
fn log_excess<T: Real>(mu: T) -> T {
    if mu.abs() > T::HALF {
        // Near -1, 1 + mu is exact.
        return mu - if T::DIGITS > 24 { mu.log1p() } else { (T::ONE + mu).log() };
    }
    // log(1 + mu) = 2 artanh(r), r = mu / (2 + mu), and 2 r = mu - r mu. So the difference is r (mu - 2 (r^2/3 + r^4/5 + ...)).
    let r = mu / (T::TWO + mu);
    let square = r * r;
    let mut sum = T::ZERO;
    let mut power = square;
    let mut odd = 3;
    while odd < 60 {
        let term = power / T::from_i32(odd);
        sum += term;
        if term <= T::HALF * T::EPSILON * sum {
            break;
        }
        power *= square;
        odd += 2;
    }
    r * (mu - T::TWO * sum)
}

/// `a phi(x / a)`.
fn exponent<T: Real>(a: T, x: T) -> T {
    let ratio = x / a;
    if ratio > T::HALF && ratio < T::TWO {
        return a * log_excess((x - a) / a);
    }
    (x - a) - a * if ratio.is_finite() && ratio > T::ZERO { ratio.log() } else { x.log() - a.log() }
}

/// `a^a e^{-a} / Gamma(a + 1)`.
fn scale<T: Real>(a: T) -> T {
    if T::DIGITS <= 24 && a < T::from_i32(3) {
        // 1 / Gamma(1 + a) = 1 / (a (a - 1) ... Gamma(1 + f)), f the fractional part.
        if a == T::ZERO {
            return T::ONE;
        }
        let (mut f, mut product) = (a, T::ONE);
        while f > T::ONE {
            product *= f;
            f -= T::ONE;
        }
        return (a * a.log() - a).exp() * (T::ONE + f * gamma_rise(f)) / product;
    }
    if T::DIGITS > 24 && a < T::from_i32(10) {
        return if a == T::ZERO { T::ONE } else { a.pow(a) * (-a).exp() / (T::ONE + a).gamma() };
    }
    // Stirling's series. The first omitted term is below 7e-16 at a = 10.
    let (r, square) = (T::ONE / a, T::ONE / (a * a));
    let tail = if T::DIGITS > 24 {
        [1.0 / 1188.0, -1.0 / 1680.0, 1.0 / 1260.0, -1.0 / 360.0, 1.0 / 12.0]
            .iter()
            .fold(T::from_f64(-691.0 / 360_360.0), |sum, &c| sum * square + T::from_f64(c))
    } else {
        // Below 5e-8 at a = 3.
        [-1.0 / 1680.0, 1.0 / 1260.0, -1.0 / 360.0, 1.0 / 12.0]
            .iter()
            .fold(T::ZERO, |sum, &c| sum * square + T::from_f32(c))
    };
    (-(r * tail)).exp() / (T::TWO * T::PI * a).sqrt()
}

/// `x^a e^{-x} / Gamma(a + 1)`: P without its series, and -dQ/d(log x) / a.
fn factor<T: Real>(a: T, x: T) -> T {
    (-exponent(a, x)).exp() * scale(a)
}

/// Temme's uniform expansion: (P, Q) = erfc(-+eta sqrt(a/2))/2 -+ R, R = e^{-a eta^2/2} S(eta) / sqrt(2 pi a), with S by the
/// backward recursion of Gil, Segura & Temme (2012), Section 3.4.
fn uniform<T: Real>(a: T, x: T) -> (T, T) {
    let energy = exponent(a, x); // a eta^2 / 2
    let sign = if x < a { -T::ONE } else { T::ONE };
    let eta = sign * (T::TWO * energy / a).sqrt();
    let (mut next, mut here) = (T::ZERO, T::ZERO);
    let mut series = T::ZERO;
    // beta_{k-1} = f_k + (k + 1) beta_{k+1} / a, for k down to 1. The series is the sum of beta_k eta^k.
    let mut step = |k: usize, f: T| {
        let value = f + T::from_usize(k + 1) * next / a;
        (next, here) = (here, value);
        series = series * eta + value;
    };
    if T::DIGITS > 24 {
        EXPANSION.iter().enumerate().skip(1).rev().for_each(|(k, &f)| step(k, T::from_f64(f)));
    } else {
        NARROW.iter().enumerate().skip(1).rev().for_each(|(k, &f)| step(k, T::from_f32(f)));
    }
    // The last two are beta_0 and beta_1.
    let s = series / (T::ONE + next / a);
    let r = (-energy).exp() * s / (T::TWO * T::PI * a).sqrt();
    let tail = if T::DIGITS > 24 {
        T::HALF * energy.sqrt().erfc()
    } else {
        super::normal::distribution(-(T::TWO * energy).sqrt())
    };
    if sign > T::ZERO {
        let q = tail + r;
        (T::ONE - q, q)
    } else {
        let p = tail - r;
        (p, T::ONE - p)
    }
}

/// (P(a, x), Q(a, x)). The smaller one has full relative accuracy. NaN outside a >= 0, x >= 0 (and at a = x = 0).
///
/// For a = 0 the limit: Q(0, x) = 0 for x > 0.
#[must_use]
pub fn ratios<T: Real>(a: T, x: T) -> (T, T) {
    if !(a >= T::ZERO && x >= T::ZERO && a.is_finite()) || a == T::ZERO && x == T::ZERO {
        return (T::NAN, T::NAN);
    }
    if x == T::ZERO {
        return (T::ZERO, T::ONE);
    }
    if a == T::ZERO || x == T::INFINITY {
        return (T::ONE, T::ZERO);
    }
    if a <= T::ONE && x <= T::ONE {
        let t = a * x.log() - log_gamma_1p(a);
        // sum_{n >= 1} (-x)^n / ((a + n) n!)
        let (mut sum, mut power, mut n) = (T::ZERO, T::ONE, T::ZERO);
        for _ in 0..40 {
            n += T::ONE;
            power = -(power * x) / n;
            let term = power / (a + n);
            sum += term;
            if term.abs() <= T::HALF * T::EPSILON * sum.abs() {
                break;
            }
        }
        let e = t.exp();
        return (e * (T::ONE + a * sum), -expm1(t) - e * a * sum);
    }
    let ratio = x / a;
    if a >= T::from_i32(25) && ratio > T::from_f64(0.31) && ratio < T::from_f64(2.35) {
        return uniform(a, x);
    }
    if x <= a + T::ONE && a > T::ONE {
        let p = factor(a, x) * lower_series(a, x);
        (p, T::ONE - p)
    } else {
        let q = a * factor(a, x) * upper_fraction(a, x);
        (T::ONE - q, q)
    }
}

/// The regularised upper incomplete gamma function Q(a, x).
#[must_use]
pub fn upper<T: Real>(a: T, x: T) -> T {
    ratios(a, x).1
}

/// The regularised lower incomplete gamma function P(a, x).
#[must_use]
pub fn lower<T: Real>(a: T, x: T) -> T {
    ratios(a, x).0
}

/// The x with Q(a, x) = u: +inf at u = 0, 0 at u = 1 (and where it underflows), NaN outside a > 0, 0 <= u <= 1.
///
/// Newton's method for `log Q` as a function of `log x`, which is concave and decreasing. From the right of the root the iterates decrease
/// to it, and one step from the left leads to the right. The initial value is the median for a >= 1. The accuracy of the result is limited by
/// the last bit of u: its relative error is about `EPSILON u / (a factor)` (test `the_inverse_inverts`).
#[must_use]
pub fn upper_inverse<T: Real>(a: T, u: T) -> T {
    if !(a > T::ZERO && a.is_finite() && u >= T::ZERO && u <= T::ONE) {
        return T::NAN;
    }
    if u == T::ZERO {
        return T::INFINITY;
    }
    if u == T::ONE {
        return T::ZERO;
    }
    let mut y = start(a, u);
    // The last point known to be left of the root.
    let mut left = None;
    for _ in 0..100 {
        let x = y.exp();
        if x == T::ZERO {
            return T::ZERO;
        }
        let q = upper(a, x);
        if q == T::ZERO || x == T::INFINITY {
            // Q underflows: move back to the left.
            y = left.map_or(y - T::HALF, |l: T| T::HALF * (l + y));
            continue;
        }
        if q > u {
            left = Some(y);
        }
        let slope = a * factor(a, x) / q;
        if slope <= T::ZERO || slope.is_nan() {
            // Q is 1 to rounding and its slope is zero: move to the right.
            y += T::ONE;
            continue;
        }
        let step = (q / u).log() / slope;
        // A step from far left of the root may overshoot, so it is limited.
        let step = step.min(T::from_i32(8));
        y += step;
        if step.abs() <= T::TWO * T::EPSILON {
            break;
        }
    }
    y.exp()
}

/// An initial value for [`upper_inverse`], as log x.
fn start<T: Real>(a: T, u: T) -> T {
    if a >= T::ONE {
        // The median, by the Wilson-Hilferty approximation.
        let w = T::ONE - T::ONE / (T::from_i32(9) * a);
        return (a * w * w * w).log();
    }
    let scaled = u / a;
    if scaled < T::from_f64(0.2) {
        // Q is at most about a e^{-x} for x >= 1.
        return (-scaled.log()).max(T::ONE).log();
    }
    // P = x^a / Gamma(a + 1) to leading order; |log Gamma(a + 1)| / a is below 0.6.
    log1p(-u) / a
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (a, x, P, Q), rounded from 60-digit arithmetic.
    const TABLE: &[(f64, f64, f64, f64)] = &include!("../../../tests/data/incomplete_gamma.in");

    #[test]
    fn the_expansion_begins_as_temme_has_it() {
        let want = [1.0, -1.0 / 3.0, 1.0 / 12.0, -2.0 / 135.0, 1.0 / 864.0, 1.0 / 2835.0, -139.0 / 777_600.0];
        for (got, want) in EXPANSION.iter().zip(want) {
            assert!((got - want).abs() < 1e-16, "{got} {want}");
        }
    }

    #[test]
    fn against_sixty_digits() {
        let mut worst: f64 = 0.0;
        for &(a, x, p, q) in TABLE {
            let (got_p, got_q) = ratios(a, x);
            for (got, want) in [(got_p, p), (got_q, q)] {
                if want < 1e-290 {
                    assert!(got < 1e-280);
                    continue;
                }
                // The larger one is 1 minus the smaller and has absolute accuracy. The relative rounding of the exponent is multiplied by
                // its size, -log(want): three of its roundings, and some tens of additions in the sums.
                let allowed = (40.0 - 4.0 * want.ln()) * f64::EPSILON * want;
                worst = worst.max((got - want).abs() / allowed);
                assert!(
                    (got - want).abs() <= allowed,
                    "a {a:e} x {x:e}: {got:e} {want:e} {}",
                    (got - want).abs() / want / f64::EPSILON
                );
            }
        }
        std::println!("worst fraction of the bound {worst}");
    }

    #[test]
    fn single_precision_follows_double() {
        for &(a, x, ..) in TABLE {
            let (a, x) = (a as f32, x as f32);
            if !(a > 1e-30 && x.is_finite() && x > 0.0) {
                continue;
            }
            let (want, wide) = (ratios(f64::from(a), f64::from(x)), ratios(a, x));
            for (got, want) in [(wide.0, want.0), (wide.1, want.1)] {
                if want < 1e-30 {
                    continue;
                }
                let allowed = (40.0 - 4.0 * want.ln()) * f64::from(f32::EPSILON) * want;
                assert!((f64::from(got) - want).abs() <= allowed, "a {a:e} x {x:e}: {got:e} {want:e}");
            }
        }
    }

    #[test]
    fn the_inverse_inverts() {
        for a in [1e-9_f64, 3e-4, 0.1, 0.5, 1.0, 1.5, 4.0, 11.9, 12.1, 100.0, 2e5, 3e9] {
            for u in [1e-300_f64, 1e-40, 1e-10, 1e-4, 0.01, 0.3, 0.5, 0.9, 0.999, 1.0 - 1e-12] {
                let x = upper_inverse(a, u);
                if x < 1e-300 {
                    continue;
                }
                let q = upper(a, x);
                // x is accurate to a few units. The error of Q is that times its slope, plus its own.
                let slope = a * factor(a, x) / q;
                let allowed = (40.0 - 4.0 * u.ln() + 8.0 * slope * (1.0 + x.ln().abs())) * f64::EPSILON;
                assert!((q / u - 1.0).abs() <= allowed, "a {a} u {u}: x {x:e} q {q:e} {:e}", q / u - 1.0);
                let narrow = f64::from(upper_inverse(a as f32, u as f32));
                if u > 1e-30 && u < 0.9999 && (0.1..1e4).contains(&a) {
                    let x = upper_inverse(f64::from(a as f32), f64::from(u as f32));
                    let slope = a * factor(a, x) / q;
                    let allowed =
                        ((60.0 - 6.0 * u.ln()) / slope + 8.0 * (1.0 + x.ln().abs())) * f64::from(f32::EPSILON) * x;
                    assert!((narrow - x).abs() <= allowed, "a {a} u {u}: {narrow} {x}");
                }
            }
        }
        assert_eq!(upper_inverse(2.0, 0.0), f64::INFINITY);
        assert_eq!(upper_inverse(2.0, 1.0), 0.0);
        assert!(upper_inverse(0.0_f64, 0.5).is_nan() && upper_inverse(1.0, f64::NAN).is_nan());
    }

    #[test]
    fn ends_of_the_range() {
        assert_eq!(ratios(0.0, 1.0), (1.0, 0.0));
        assert_eq!(ratios(3.0, 0.0), (0.0, 1.0));
        assert_eq!(ratios(3.0, f64::INFINITY), (1.0, 0.0));
        assert!(
            ratios(-1.0_f64, 1.0).0.is_nan() && ratios(0.0_f64, 0.0).0.is_nan() && ratios(1.0, f64::NAN).0.is_nan()
        );
        for a in [f64::MIN_POSITIVE, 1e-200, 1e15, 1e300] {
            for x in [f64::MIN_POSITIVE, 1e-200, 1.0, 1e15, 1e300, f64::MAX] {
                let (p, q) = ratios(a, x);
                assert!((0.0..=1.0).contains(&p) && (0.0..=1.0).contains(&q), "{a:e} {x:e} {p} {q}");
            }
        }
    }
}
