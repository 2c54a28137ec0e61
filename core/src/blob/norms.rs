//! Discrete norms of grid functions and of differences of trajectories (Craig & Bertozzi, section 3).

use crate::error::{Error, Result};
use crate::real::Real;

/// `(sum_i |u_i|^p cell)^(1/p)`, the L^p_h norm with `cell` = h^d; the largest `|u_i|` for infinite `p`.
///
/// Scaled by the largest value, so that no power overflows. No values give 0; NaN in, NaN out. About n roundings of
/// positive terms.
///
/// # Errors
/// [`Error::OutOfDomain`]: `p` is below 1 or NaN, or `cell` is not positive and finite.
pub fn norm<T: Real>(values: &[T], cell: T, p: T) -> Result<T> {
    power_mean(values.iter().map(|v| v.abs()), cell, p)
}

/// The L^p_h norm of `|a_i - b_i|` (Euclidean): the error of trajectories.
///
/// # Errors
/// [`Error::LengthMismatch`]; those of [`norm`].
pub fn distance<T: Real, const D: usize>(a: &[[T; D]], b: &[[T; D]], cell: T, p: T) -> Result<T> {
    if a.len() != b.len() {
        return Err(Error::LengthMismatch);
    }
    let apart = |(a, b): (&[T; D], &[T; D])| length::<T, D>(core::array::from_fn(|k| part(a, k) - part(b, k)));
    power_mean(a.iter().zip(b).map(apart), cell, p)
}

fn part<T: Real, const D: usize>(x: &[T; D], k: usize) -> T {
    x.get(k).copied().unwrap_or(T::ZERO)
}

/// The Euclidean length, scaled by the largest component.
fn length<T: Real, const D: usize>(x: [T; D]) -> T {
    let largest = x.iter().fold(T::ZERO, |m, c| if c.abs() > m || c.is_nan() { c.abs() } else { m });
    if largest == T::ZERO || !largest.is_finite() {
        return largest;
    }
    largest * x.iter().fold(T::ZERO, |sum, &c| sum + (c / largest) * (c / largest)).sqrt()
}

fn power_mean<T: Real>(values: impl Iterator<Item = T> + Clone, cell: T, p: T) -> Result<T> {
    if p.is_nan() || p < T::ONE || !(cell > T::ZERO && cell.is_finite()) {
        return Err(Error::OutOfDomain);
    }
    let largest = values.clone().fold(T::ZERO, |m, v| if v > m || v.is_nan() { v } else { m });
    if largest == T::ZERO || !largest.is_finite() || p == T::INFINITY {
        return Ok(largest);
    }
    let power = |v: T| if p == T::ONE { v } else { v.pow(p) };
    let sum = values.fold(T::ZERO, |sum, v| sum + power(v / largest));
    Ok(largest * if p == T::ONE { sum * cell } else { (sum * cell).pow(T::ONE / p) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_norms() {
        let values = [3.0, -4.0, 0.0];
        assert_eq!(norm(&values, 0.25, 1.0), Ok(1.75));
        assert_eq!(norm(&values, 0.25, 2.0), Ok(2.5));
        assert_eq!(norm(&values, 0.25, f64::INFINITY), Ok(4.0));
        assert_eq!(norm(&[1e300, 1e300], 0.5, 2.0), Ok(1e300));
        assert_eq!(norm::<f32>(&[], 0.5, 3.0), Ok(0.0));
        assert!(norm(&[1.0, f64::NAN, 2.0], 0.5, 2.0).unwrap().is_nan());
        assert_eq!(distance(&[[3.0, 4.0], [0.0, 1.0]], &[[0.0, 0.0], [0.0, 0.0]], 0.5, 1.0), Ok(3.0));
        // Five roundings.
        let huge: f64 = distance(&[[3.0e200, 4.0e200]], &[[0.0; 2]], 1.0, 1.0).unwrap();
        assert!((huge / 5e200 - 1.0).abs() < 5.0 * f64::EPSILON);
    }

    #[test]
    fn refusals() {
        for p in [0.5, f64::NAN, -1.0] {
            assert_eq!(norm(&[1.0], 1.0, p), Err(Error::OutOfDomain));
        }
        for cell in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(norm(&[1.0], cell, 1.0), Err(Error::OutOfDomain));
        }
        assert_eq!(distance(&[[1.0]], &[], 1.0, 1.0), Err(Error::LengthMismatch));
    }
}
