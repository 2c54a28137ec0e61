//! Chebyshev series: fitting three functions at once, and evaluating them by Clenshaw's recurrence.

use core::f64::consts::PI;

use crate::error::{Error, Result};
use crate::real::Real;

/// Most coefficients of a fit.
pub(crate) const CAPACITY: usize = 128;

/// Three series over one variable: value, gradient factor, Laplacian.
pub(crate) struct Fit {
    /// Coefficients, a triple a degree.
    pub(crate) coefficients: [[f64; 3]; CAPACITY],
    /// How many are used.
    pub(crate) len: usize,
    /// The size of the last coefficients that a longer series would still improve, over the largest one: what the fit
    /// misses, relative to the function's size.
    pub(crate) error: f64,
    /// The largest coefficient of each function.
    pub(crate) size: [f64; 3],
    /// The largest one of the last quarter.
    pub(crate) missed: [f64; 3],
}

/// A tail below this, relative to the largest coefficient, is noise.
const NOISE: f64 = 1e-15;
/// Coefficients below this are not stored.
const STORED: f64 = 1.0e-16;

/// Fits what `sample(x)` returns on [-1, 1], with at most `most` coefficients: 16 nodes of the first kind, doubled until
/// the last quarter of the coefficients is noise.
pub(crate) fn fit(most: usize, mut sample: impl FnMut(f64) -> Option<[f64; 3]>) -> Result<Fit> {
    let most = most.clamp(16, CAPACITY);
    let mut n = 16;
    loop {
        let mut fit = interpolate(n, &mut sample)?;
        let scale = fit.coefficients.iter().take(n).fold([0.0; 3], larger);
        fit.size = scale;
        let tail = fit.coefficients.iter().take(n).skip(n - n / 4).fold([0.0; 3], larger);
        fit.missed = tail;
        fit.error = tail.iter().zip(scale).filter(|&(_, s)| s > 0.0).fold(0.0, |e: f64, (&t, s)| e.max(t / s));
        if fit.error > NOISE && 2 * n <= most {
            n *= 2;
            continue;
        }
        let matters = |c: &[f64; 3]| c.iter().zip(scale).any(|(v, s)| v.abs() > STORED * s);
        fit.len = fit.coefficients.iter().take(n).rposition(matters).map_or(1, |last| last + 1);
        return Ok(fit);
    }
}

fn larger(mut most: [f64; 3], c: &[f64; 3]) -> [f64; 3] {
    most.iter_mut().zip(c).for_each(|(m, v)| *m = m.max(v.abs()));
    most
}

/// Interpolation at x_k = cos(pi (k + 1/2)/n): c_j = (2 - [j = 0])/n sum_k f(x_k) cos(j pi (k + 1/2)/n).
fn interpolate(n: usize, sample: &mut dyn FnMut(f64) -> Option<[f64; 3]>) -> Result<Fit> {
    // cos(pi m/(2n)) for m in 0..4n, from the first octant so that symmetric ones are equal
    let mut cosines = [0.0; 4 * CAPACITY];
    let quarter = |m: usize| (PI * m as f64 / (2.0 * n as f64)).cos();
    for (m, slot) in cosines.iter_mut().take(4 * n).enumerate() {
        let fold = if m > 2 * n { 4 * n - m } else { m };
        *slot = if fold <= n { quarter(fold) } else { -quarter(2 * n - fold) };
        if fold == n {
            *slot = 0.0;
        }
    }
    let cosine = |m: usize| cosines.get(m % (4 * n).max(1)).copied().unwrap_or(0.0);
    let mut fit = Fit { coefficients: [[0.0; 3]; CAPACITY], len: n, error: 0.0, size: [0.0; 3], missed: [0.0; 3] };
    for k in 0..n {
        let values = sample(cosine(2 * k + 1)).ok_or(Error::NotFinite)?;
        for (j, c) in fit.coefficients.iter_mut().take(n).enumerate() {
            let factor = if j == 0 { 1.0 } else { 2.0 } / n as f64 * cosine(j * (2 * k + 1));
            c.iter_mut().zip(values).for_each(|(sum, v)| *sum += factor * v);
        }
    }
    Ok(fit)
}

/// sum c_k T_k(x), by Clenshaw's recurrence.
#[inline(always)]
pub(crate) fn clenshaw<T: Real>(coefficients: &[[T; 3]], x: T) -> [T; 3] {
    let twice = x + x;
    let (mut b1, mut b2) = ([T::ZERO; 3], [T::ZERO; 3]);
    let Some((first, rest)) = coefficients.split_first() else { return b1 };
    for c in rest.iter().rev() {
        let next = [twice * b1[0] - b2[0] + c[0], twice * b1[1] - b2[1] + c[1], twice * b1[2] - b2[2] + c[2]];
        b2 = b1;
        b1 = next;
    }
    [x * b1[0] - b2[0] + first[0], x * b1[1] - b2[1] + first[1], x * b1[2] - b2[2] + first[2]]
}

/// sum c_k x^k, three at once.
#[inline(always)]
pub(crate) fn horner3<T: Real>(coefficients: &[[T; 3]], x: T) -> [T; 3] {
    coefficients.iter().rev().fold([T::ZERO; 3], |sum, c| [sum[0] * x + c[0], sum[1] * x + c[1], sum[2] * x + c[2]])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fits_analytic_functions_to_rounding() {
        let f = |x: f64| [x.exp(), (5.0 * x).sin(), 1.0 / (2.0 + x)];
        let fit = fit(CAPACITY, |x| Some(f(x))).unwrap();
        assert!(fit.len < 48 && fit.error <= NOISE, "{} {}", fit.len, fit.error);
        for k in 0..=100 {
            let x = -1.0 + 0.02 * f64::from(k);
            let got = clenshaw(&fit.coefficients[..fit.len], x);
            // Rounding of n samples and of Clenshaw's recurrence: c sqrt(n) u, c ~ 4, times the largest value (e, 1, 1).
            got.iter().zip(f(x)).for_each(|(g, w)| assert!((g - w).abs() < 28.0 * f64::EPSILON * 1.4, "{x} {g} {w}"));
        }
    }

    #[test]
    fn a_slow_series_reports_what_it_misses_and_nan_is_refused() {
        let fit = fit(64, |x| Some([x.abs(), 0.0, 0.0])).unwrap();
        assert!(fit.error > 1e-5 && fit.len <= 64);
        assert_eq!(super::fit(64, |x| (x < 0.5).then_some([x; 3])).err(), Some(Error::NotFinite));
    }
}
