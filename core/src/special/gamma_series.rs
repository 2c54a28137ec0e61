//! The series and the continued fraction of the incomplete gamma functions, without their common factor `x^a e^-x / Gamma(a + 1)`.

use crate::real::Real;

/// P / factor = 1 + x/(a+1) + x^2/((a+1)(a+2)) + ...
pub(super) fn lower_series<T: Real>(a: T, x: T) -> T {
    let (mut sum, mut term, mut k) = (T::ONE, T::ONE, a);
    for _ in 0..2000 {
        k += T::ONE;
        term = term * x / k;
        sum += term;
        if term <= T::HALF * T::EPSILON * sum {
            break;
        }
    }
    sum
}

/// Q / (a factor): the continued fraction 1/(x+1-a- 1(1-a)/(x+3-a- ...)), by Lentz's method. Single precision starts at a fixed depth,
/// which suffices for x >= 1/2 if a <= 1, and for x > a + 1 if a < 25 or x > 2 a.
pub(super) fn upper_fraction<T: Real>(a: T, x: T) -> T {
    if T::DIGITS <= 24 {
        let b = x + T::ONE - a;
        let tail = (1..64).rev().fold(T::ZERO, |tail, k| {
            let k = T::from_i32(k);
            k * (a - k) / (b + T::TWO * k + tail)
        });
        return T::ONE / (b + tail);
    }
    let tiny = T::MIN_POSITIVE / T::EPSILON;
    let away = |v: T| if v.abs() < tiny { tiny } else { v };
    let mut b = x + T::ONE - a;
    let mut c = T::ONE / tiny;
    let mut d = T::ONE / away(b);
    let mut result = d;
    let mut k = T::ZERO;
    for _ in 0..2000 {
        k += T::ONE;
        let numerator = k * (a - k);
        b += T::TWO;
        d = T::ONE / away(numerator * d + b);
        c = away(b + numerator / c);
        let change = c * d;
        result *= change;
        if (change - T::ONE).abs() <= T::EPSILON {
            break;
        }
    }
    result
}
