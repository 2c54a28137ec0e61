//! Chebyshev series: fitting three functions together, and evaluation by Clenshaw's recurrence.

use core::f64::consts::PI;

use super::convolution::Sample;
use crate::error::{Error, Result};
use crate::real::{DoubleWord, Real, Scalar};

/// Most coefficients of a fit: 64 intervals between nodes.
pub(crate) const CAPACITY: usize = 65;

/// Three series over one variable: value, gradient factor, Laplacian.
pub(crate) struct Fit {
    /// Coefficients, one triple per degree.
    pub(crate) coefficients: [[f64; 3]; CAPACITY],
    /// The number of coefficients in use.
    pub(crate) len: usize,
    /// The largest of the last quarter of the coefficients, relative to the function's largest size. A longer series would reduce it.
    pub(crate) error: f64,
    /// Whether the series is accurate over the whole interval.
    pub(crate) good: bool,
}

/// A tail below this, relative to the function's largest size, is rounding noise.
const NOISE: f64 = 1e-15;
/// A tail below this, relative to the function's smallest size, is accepted.
const SMALL: f64 = 1e-14;
/// Coefficients below this are not stored.
const STORED: f64 = 1e-16;
/// The largest ratio of a function's sizes on an interval. Roundings are relative to the largest size.
const SPREAD: f64 = 64.0;

/// Fits `sample(x)` on [-1, 1] at the 17 extrema of T_16, then at the 33 of T_32 and the 65 of T_64, which include the previous ones,
/// until the last quarter of the coefficients is noise. If a size changes by more than [`SPREAD`] over the interval, the fit stops after
/// the first nodes and returns no coefficients.
pub(crate) fn fit(sample: impl FnMut(f64) -> Option<Sample>) -> Result<Fit> {
    fit_within(SPREAD, sample)
}

/// [`fit`] whatever the sizes on the interval.
pub(crate) fn fit_any(sample: impl FnMut(f64) -> Option<Sample>) -> Result<Fit> {
    fit_within(f64::INFINITY, sample)
}

fn fit_within(spread: f64, mut sample: impl FnMut(f64) -> Option<Sample>) -> Result<Fit> {
    const STEPS: usize = CAPACITY - 1;
    let cosine = cosines();
    let mut nodes = [Sample::ZERO; CAPACITY];
    let mut fit = Fit { coefficients: [[0.0; 3]; CAPACITY], len: 0, error: 0.0, good: false };
    let mut n = STEPS / 4;
    loop {
        let stride = STEPS / n;
        for (k, slot) in nodes.iter_mut().enumerate().step_by(stride) {
            // the samples of the previous nodes are kept
            if n == STEPS / 4 || k % (2 * stride) != 0 {
                *slot = sample(cosine(k)).ok_or(Error::NotFinite)?;
            }
        }
        let used = || nodes.iter().step_by(stride);
        let largest = used().fold([0.0; 3], |most, s| larger(most, &s.sizes));
        let smallest = used().fold([f64::INFINITY; 3], |least, s| smaller(least, &s.sizes));
        if largest.iter().zip(smallest).any(|(&largest, smallest)| largest > spread * smallest) {
            return Ok(fit);
        }
        // c_j = 2/n sum'' f(x_k) cos(pi j k/n); the first and the last term and coefficient are halved
        for (j, c) in fit.coefficients.iter_mut().take(n + 1).enumerate() {
            let mut sum = [DoubleWord::ZERO; 3];
            for (k, node) in nodes.iter().enumerate().step_by(stride) {
                let end = if k == 0 || k == STEPS { 0.5 } else { 1.0 };
                let factor = end * cosine(j * k);
                sum.iter_mut().zip(node.values).for_each(|(sum, v)| *sum = sum.plus(factor * v));
            }
            let front = if j == 0 || j == n { 1.0 } else { 2.0 } / n as f64;
            *c = sum.map(|sum| front * sum.hi);
        }
        let tail = fit.coefficients.iter().take(n + 1).skip(n + 1 - n / 4).fold([0.0; 3], larger);
        let relative = |to: [f64; 3]| {
            let pairs = tail.into_iter().zip(to).filter(|&(_, size)| size > 0.0);
            pairs.fold(0.0, |most: f64, (tail, size)| most.max(tail / size))
        };
        fit.error = relative(largest);
        fit.good = fit.error <= NOISE || relative(smallest) <= SMALL;
        if fit.error > NOISE && n < STEPS {
            n *= 2;
            continue;
        }
        // A host's function may have noise of its own, which is not stored.
        let stored = if spread.is_finite() || fit.error <= NOISE { STORED } else { STORED.max(2.0 * fit.error) };
        let matters = |c: &[f64; 3]| c.iter().zip(largest).any(|(v, s)| v.abs() > stored * s);
        fit.len = fit.coefficients.iter().take(n + 1).rposition(matters).map_or(1, |last| last + 1);
        return Ok(fit);
    }
}

fn larger(mut most: [f64; 3], c: &[f64; 3]) -> [f64; 3] {
    most.iter_mut().zip(c).for_each(|(m, v)| *m = m.max(v.abs()));
    most
}

fn smaller(mut least: [f64; 3], c: &[f64; 3]) -> [f64; 3] {
    least.iter_mut().zip(c).for_each(|(m, v)| *m = m.min(*v));
    least
}

/// cos(pi m/64) for any m, computed in the first octant so that symmetric values are equal.
fn cosines() -> impl Fn(usize) -> f64 {
    const STEPS: usize = CAPACITY - 1;
    let mut quarter = [0.0; STEPS / 2 + 1];
    for (m, slot) in quarter.iter_mut().enumerate() {
        let angle = PI * m as f64 / STEPS as f64;
        *slot = if 4 * m <= STEPS { Scalar::cos(angle) } else { Scalar::sin(0.5 * PI - angle) };
    }
    if let Some(last) = quarter.last_mut() {
        *last = 0.0;
    }
    move |m: usize| {
        let m = m % (2 * STEPS);
        let fold = if m > STEPS { 2 * STEPS - m } else { m };
        let (sign, place) = if 2 * fold <= STEPS { (1.0, fold) } else { (-1.0, STEPS - fold) };
        sign * quarter.get(place).copied().unwrap_or(0.0)
    }
}

/// sum c_k T_k(x), by Clenshaw's recurrence.
#[inline(always)]
pub(crate) fn clenshaw<T: Real>(coefficients: &[[f64; 3]], x: T) -> [T; 3] {
    let twice = x + x;
    let (mut b1, mut b2) = ([T::ZERO; 3], [T::ZERO; 3]);
    let Some((first, rest)) = coefficients.split_first() else { return b1 };
    for c in rest.iter().rev() {
        let c = c.map(T::from_f64);
        let next = [twice * b1[0] - b2[0] + c[0], twice * b1[1] - b2[1] + c[1], twice * b1[2] - b2[2] + c[2]];
        b2 = b1;
        b1 = next;
    }
    let c = first.map(T::from_f64);
    [x * b1[0] - b2[0] + c[0], x * b1[1] - b2[1] + c[1], x * b1[2] - b2[2] + c[2]]
}

/// sum c_k x^k, for three series at once.
#[inline(always)]
pub(crate) fn horner3<T: Real>(coefficients: &[[f64; 3]], x: T) -> [T; 3] {
    coefficients.iter().rev().fold([T::ZERO; 3], |sum, c| {
        let c = c.map(T::from_f64);
        [sum[0] * x + c[0], sum[1] * x + c[1], sum[2] * x + c[2]]
    })
}

/// [`horner3`] in double-word arithmetic.
pub(crate) fn horner_words(high: &[[f64; 3]], low: &[[f64; 3]], x: DoubleWord<f64>) -> [f64; 3] {
    let mut sums = [DoubleWord::ZERO; 3];
    for (high, low) in high.iter().zip(low).rev() {
        for ((sum, &hi), &lo) in sums.iter_mut().zip(high).zip(low) {
            *sum = *sum * x + DoubleWord { hi, lo };
        }
    }
    sums.map(|sum| sum.hi)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples whose sizes are at least 1.
    fn of(values: [f64; 3]) -> Option<Sample> {
        Some(Sample { values, sizes: values.map(|v| v.abs().max(1.0)) })
    }

    #[test]
    fn fits_analytic_functions_to_rounding() {
        let f = |x: f64| [x.exp(), (5.0 * x).sin(), 1.0 / (2.0 + x)];
        let fit = fit(|x| of(f(x))).unwrap();
        assert!(fit.len < 48 && fit.good, "{} {}", fit.len, fit.error);
        for k in 0..=100 {
            let x = -1.0 + 0.02 * f64::from(k);
            let got = clenshaw(&fit.coefficients[..fit.len], x);
            // Rounding of n samples and of Clenshaw's recurrence: c sqrt(n) u, c ~ 4, times the largest value (e, 1, 1).
            got.iter().zip(f(x)).for_each(|(g, w)| assert!((g - w).abs() < 28.0 * f64::EPSILON * 1.4, "{x} {g} {w}"));
        }
    }

    #[test]
    fn a_slow_series_reports_what_it_misses_and_nan_is_refused() {
        let fit = fit(|x| of([x.abs(), 0.0, 0.0])).unwrap();
        assert!(fit.error > 1e-5 && fit.len == CAPACITY && !fit.good);
        let refused = super::fit(|x| if x < 0.5 { of([x; 3]) } else { None });
        assert_eq!(refused.err(), Some(Error::NotFinite));
        let uneven = super::fit(|x| of([1.0, (5.0 * x).exp(), 1.0])).unwrap();
        assert!(uneven.len == 0 && !uneven.good);
    }
}
