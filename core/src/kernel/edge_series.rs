//! Interior solutions as series in t = 1 - (r/delta)^2 that continue the exterior solution from the edge.
//!
//! Laplacian u - kappa^2 u = f with f = sum f_n t^n is, in units of delta,
//!
//! 4 (n+2)(n+1) w_{n+2} = [4 (n+1) n + 2 d (n+1)] w_{n+1} + kappa^2 w_n + f_n,    u = sum w_n t^n,
//!
//! Value and slope at t = 0 are those of the exterior solution, which has a closed form. The coefficients are the
//! truncated Taylor series of that solution, and nothing cancels at the edge or at small kappa. Beyond degree M + K, terms of
//! the source's size must cancel to nearly zero, so the recurrence uses double-word arithmetic.

use super::law::is_multiple;
use super::profile::{Profile, TERMS};
use crate::real::{DoubleWord, Scalar};
use crate::special::bessel::{k0_scaled, k1_scaled};
use crate::special::elementary::exp;

/// Coefficients of a series, padded with zeros.
pub(crate) type Series = [DoubleWord<f64>; LENGTH];

/// Most coefficients of a series.
pub(crate) const LENGTH: usize = 64;

/// The coefficients w_0 .. w_{len-1}; `source` is f.
pub(crate) fn series(
    dimension: usize,
    kappa: f64,
    value: DoubleWord<f64>,
    slope: DoubleWord<f64>,
    source: &[DoubleWord<f64>],
    len: usize,
) -> Series {
    let d = dimension as f64;
    let square = DoubleWord::product(kappa, kappa);
    let mut w = [DoubleWord::ZERO; LENGTH];
    let (mut now, mut next) = (value, slope);
    for (n, slot) in w.iter_mut().take(len).enumerate() {
        *slot = now;
        let f = source.get(n).copied().unwrap_or(DoubleWord::ZERO);
        let n = n as f64;
        let after =
            (next * (4.0 * (n + 1.0) * n + 2.0 * d * (n + 1.0)) + square * now + f) / (4.0 * (n + 2.0) * (n + 1.0));
        (now, next) = (next, after);
    }
    w
}

/// Value and slope in t at the edge of S_d times the screened kernel outside, in units of delta: F V(1), -F V'(1)/2. In two words except in
/// the plane: an error in them excites the solution that is singular at the centre, whose series in t converges slowly in 3D.
pub(crate) fn screened_edge(
    kappa: f64,
    dimension: usize,
    factor: DoubleWord<f64>,
) -> (DoubleWord<f64>, DoubleWord<f64>) {
    let (m, n) = exp(DoubleWord::from(-kappa));
    let e = factor * m.ldexp(n);
    match dimension {
        1 => (-(e / kappa), e * -0.5),
        2 => (e * -k0_scaled(kappa), e * (-0.5 * kappa * k1_scaled(kappa))),
        _ => (-e, e * DoubleWord::sum(1.0, kappa) * -0.5),
    }
}

/// The coefficients, which are exact, in two words.
pub(crate) fn exact(b: &[f64; TERMS]) -> [DoubleWord<f64>; TERMS] {
    b.map(DoubleWord::from)
}

/// Coefficients c_n of |x|^p * psi = r^p sum_n c_n (delta/r)^{2n} outside: (-p/2)_n (1-(p+d)/2)_n/(n! (d/2)_n) mu_2n.
/// The sum ends for even p and for even p + d. The second value is then the number of terms.
pub(crate) fn laurent(p: f64, dimension: usize, profile: &Profile) -> Option<(Series, usize)> {
    let d = dimension as f64;
    let terms = if p >= 0.0 && is_multiple(p, 2.0) {
        0.5 * p + 1.0
    } else if is_multiple(p + d, 2.0) && p + d >= 2.0 {
        0.5 * (p + d)
    } else {
        return None;
    };
    if terms > 20.0 {
        return None;
    }
    let mut c = [DoubleWord::ZERO; LENGTH];
    let mut factor = DoubleWord::ONE;
    for (n, slot) in c.iter_mut().take(terms as usize).enumerate() {
        *slot = factor * profile.moment(n as u32, dimension);
        let n = n as f64;
        factor = factor * ((n - 0.5 * p) * (n + 1.0 - 0.5 * (p + d))) / ((n + 1.0) * (n + 0.5 * d));
    }
    Some((c, terms as usize))
}

/// The factor F(kappa) of the exterior screened solution, V * psi = F V, in two words, and its derivative:
/// F = sum_n mu_2n (kappa^2/4)^n / (n! (d/2)_n), with terms of one sign from n = K on (the sum over the coefficients of b would
/// cancel for orders above 2). `None` where it overflows.
pub(crate) fn exterior_factor(kappa: f64, dimension: usize, profile: &Profile) -> Option<(DoubleWord<f64>, f64)> {
    let half = 0.5 * dimension as f64;
    if let Profile::Gaussian { parts, .. } = profile {
        // sum w e^{kappa^2 c^2/4}
        let (mut sum, mut slope) = (DoubleWord::ZERO, 0.0);
        for &(w, c) in parts {
            // the squares of the widths are integers
            let square = Scalar::round(c * c);
            let (m, n) = exp(DoubleWord::product(kappa, kappa) * (0.25 * square));
            let e = m.ldexp(n) * w;
            sum = sum + e;
            slope += e.hi * 0.5 * kappa * square;
        }
        return (sum.hi.is_finite() && slope.is_finite()).then_some((sum, slope));
    }
    let quarter = DoubleWord::product(kappa, kappa) * 0.25;
    let (mut factor, mut sum, mut slope) = (DoubleWord::ONE, DoubleWord::ZERO, 0.0);
    for n in 0..3000_u32 {
        let term = profile.moment(n, dimension) * factor;
        let k = f64::from(n);
        sum = sum + term;
        slope += 2.0 * k * term.hi;
        factor = factor * quarter / ((k + 1.0) * (half + k));
        // stop beyond the largest term and the vanishing moments
        if k > 8.0 && factor.hi < 1e-3 && 2.0 * k * term.hi.abs() <= 1e-19 * slope.abs() {
            break;
        }
    }
    let derivative = if kappa > 0.0 { slope / kappa } else { 0.0 };
    (sum.hi.is_finite() && derivative.is_finite()).then_some((sum, derivative))
}

/// Coefficients of |x|^p/p * psi inside, in units of delta, for p = p_0 + 2k above the Newtonian power p_0 = 2 - d (odd powers in 1D and
/// 3D). By Laplacian(|x|^p/p) = (p+d-2)(p-2) [|x|^(p-2)/(p-2)] each step needs one series. Returns value and
/// Laplacian coefficients and their number. `profile` is compact.
pub(crate) fn odd_power(p: f64, dimension: usize, profile: &Profile) -> Option<(Series, Series, usize)> {
    let Profile::Compact { b, exponent, half_order } = *profile else { return None };
    let d = dimension as f64;
    let mut at = 2.0 - d;
    // The Newtonian power: |x| * psi in 1D, -1/|x| * psi in 3D, with Laplacians 2 psi = b and 4 pi psi = b.
    let mut len = (exponent + half_order) as usize + 1;
    let source = exact(&b);
    let mut w = series(dimension, 0.0, DoubleWord::from(1.0 / at), DoubleWord::from(-0.5), &source, len);
    let mut laplacian = [DoubleWord::ZERO; LENGTH];
    laplacian.iter_mut().zip(source).for_each(|(l, b)| *l = b);
    while at < p {
        let factor = (at + d) * at;
        at += 2.0;
        laplacian = w.map(|v| v * factor);
        let (c, terms) = laurent(at, dimension, profile)?;
        let sum = |weight: &dyn Fn(f64) -> f64| {
            let terms = c.iter().take(terms).enumerate();
            terms.fold(DoubleWord::ZERO, |sum, (n, &c)| sum + c * weight(n as f64)) / at
        };
        let value = sum(&|_| 1.0);
        // du/dt = -(u'/r)/2 at the edge
        let gradient = sum(&|n| at - 2.0 * n);
        len += 1;
        if len > LENGTH {
            return None;
        }
        w = series(dimension, 0.0, value, gradient * -0.5, &laplacian, len);
    }
    Some((w, laplacian, len))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::profile::pochhammer;
    use crate::mollifier::Mollifier;

    #[test]
    fn the_published_coefficients() {
        // 1D |x|^3/3, M = 4, order 2: gradient factor and Laplacian in powers of t
        let profile = Profile::new(Mollifier::Compact { order: 2, exponent: 4 }, 1).unwrap();
        let (w, laplacian, len) = odd_power(3.0, 1, &profile).unwrap();
        assert_eq!(len, 7);
        let gradient = [12.0 / 11.0, -5.0 / 11.0, -1.0 / 11.0, -3.0 / 88.0, -5.0 / 352.0, -7.0 / 1408.0];
        for (n, want) in gradient.into_iter().enumerate() {
            let got = -2.0 * (n as f64 + 1.0) * w[n + 1].hi;
            // each step of the recurrence is four roundings of numbers below 2
            assert!((got - want).abs() < 32.0 * f64::EPSILON, "{n}: {got} {want}");
        }
        let second = [1.0, -0.5, -0.125, -1.0 / 16.0, -5.0 / 128.0, -7.0 / 256.0].map(|c: f64| 2.0 * c);
        for (n, want) in second.into_iter().enumerate() {
            assert!((laplacian[n].hi - want).abs() < 16.0 * f64::EPSILON, "{n}: {:?} {want}", laplacian[n]);
        }
    }

    #[test]
    fn factor_of_a_gaussian_and_of_small_kappa() {
        let compact = Profile::new(Mollifier::Compact { order: 2, exponent: 4 }, 2).unwrap();
        let (f, slope) = exterior_factor(0.01, 2, &compact).unwrap();
        // 1 + kappa^2 mu_2/(2d) and the next term, mu_2 = 1/6, mu_4 = 2/(6 7)
        let want = 1.0 + 1e-4 / 24.0 + 1e-8 / 64.0 / 21.0;
        assert!((f.hi - want).abs() < 3e-16 && (slope - 0.01 / 12.0).abs() < 1e-8, "{f:?} {slope}");
        assert!(exterior_factor(2000.0, 2, &compact).is_none());
        let high = Profile::new(Mollifier::Compact { order: 8, exponent: 9 }, 3).unwrap();
        assert!((exterior_factor(0.1, 3, &high).unwrap().0.hi - 1.0).abs() < 1e-12);
        assert!(pochhammer(0.5, 3) == 1.875);
    }
}
