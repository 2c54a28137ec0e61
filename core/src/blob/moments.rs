//! What a run conserves or dissipates, from positions and masses alone: total mass, centre of mass, second moment; and
//! the overlap of the blobs.

use crate::error::{Error, Result};
use crate::real::Real;

/// A sum that carries its own rounding error: Neumaier's variant of Kahan's summation.
///
/// The result is within 2 u |sum| + (n u)^2 sum |x_j|, to leading order, of the exact sum of the terms as given (Ogita,
/// Rump, Oishi, *Accurate sum and dot product*, 2005, the bound of their Sum2).
#[derive(Clone, Copy, Debug, Default)]
pub struct Sum<T> {
    high: T,
    low: T,
}

impl<T: Real> Sum<T> {
    /// Adds one term.
    #[inline]
    pub fn add(&mut self, term: T) {
        let total = self.high + term;
        self.low += if self.high.abs() >= term.abs() { (self.high - total) + term } else { (term - total) + self.high };
        self.high = total;
    }

    /// The sum so far.
    #[inline]
    #[must_use]
    pub fn value(&self) -> T {
        self.high + self.low
    }
}

/// Sums over the particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments<T, const D: usize> {
    /// sum m_j.
    pub mass: T,
    /// sum |m_j|.
    pub absolute_mass: T,
    /// sum m_j x_j / sum m_j; zero where the total mass is zero.
    pub centre: [T; D],
    /// sum m_j |x_j - centre|^2.
    pub second: T,
}

/// Mass, centre of mass and second moment about it.
///
/// | argument    | shape    | unit   |
/// |-------------|----------|--------|
/// | `positions` | `[n][D]` | length |
/// | `masses`    | `[n]`    | mass, any sign |
///
/// Two passes, compensated sums: each term costs two roundings, the sums a few more, whatever n. No particles give
/// zeros. Not finite in, not finite out.
///
/// # Errors
/// [`Error::LengthMismatch`].
pub fn moments<T: Real, const D: usize>(positions: &[[T; D]], masses: &[T]) -> Result<Moments<T, D>> {
    if positions.len() != masses.len() {
        return Err(Error::LengthMismatch);
    }
    let (mut mass, mut absolute) = (Sum::default(), Sum::default());
    let mut first = [Sum::<T>::default(); D];
    for (x, &m) in positions.iter().zip(masses) {
        mass.add(m);
        absolute.add(m.abs());
        for (sum, &c) in first.iter_mut().zip(x) {
            sum.add(m * c);
        }
    }
    let total = mass.value();
    let centre = first.map(|sum| if total == T::ZERO { T::ZERO } else { sum.value() / total });
    let mut second = Sum::default();
    for (x, &m) in positions.iter().zip(masses) {
        let distance = x.iter().zip(&centre).fold(T::ZERO, |sum, (&a, &c)| sum + (a - c) * (a - c));
        second.add(m * distance);
    }
    Ok(Moments { mass: total, absolute_mass: absolute.value(), centre, second: second.value() })
}

/// The smallest overlap of the blobs: delta over the local spacing of the particles.
///
/// A particle of mass m in a density rho stands for the volume m / rho, so its spacing is `(m / rho)^(1/D)` and the
/// overlap `delta (rho / m)^(1/D)`. Particles without mass or density are not counted; `None` if all are such.
///
/// The sum of blobs samples the density on a lattice of that spacing, with the aliasing error of the mollifier's
/// transform at 2 pi / spacing (Poisson's summation): for a Gaussian of width delta, `exp(-(pi overlap)^2)`. Where a flow spreads the particles
/// (repulsion), the overlap falls and this error takes over from delta^m: an overlap of 1.4 to 1.7 leaves 5e-9 to 4e-13 times the
/// density at the start, but 1 leaves 5e-5. For a compact mollifier delta is the radius of the support, so its overlap must be
/// larger by the ratio of the widths (2D, order 2: sqrt(M + 2)).
///
/// # Errors
/// [`Error::LengthMismatch`]; [`Error::Delta`]: delta is not positive and finite.
pub fn smallest_overlap<T: Real, const D: usize>(delta: T, masses: &[T], densities: &[T]) -> Result<Option<T>> {
    if masses.len() != densities.len() {
        return Err(Error::LengthMismatch);
    }
    if !(delta > T::ZERO && delta.is_finite()) {
        return Err(Error::Delta);
    }
    let quotients = masses.iter().zip(densities).map(|(&m, &rho)| (rho / m).abs());
    let sparsest = quotients.filter(|q| q.is_finite() && *q > T::ZERO).reduce(Real::min);
    Ok(sparsest.map(|q| match D {
        1 => delta * q,
        2 => delta * q.sqrt(),
        _ => delta * q.pow(T::ONE / T::from_i32(3)),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn known_moments() {
        let positions = [[1.0, 0.0], [-1.0, 0.0], [0.0, 3.0]];
        let got = moments(&positions, &[1.0, 1.0, 2.0]).unwrap();
        assert_eq!((got.mass, got.absolute_mass, got.centre), (4.0, 4.0, [0.0, 1.5]));
        assert_eq!(got.second, 2.0 * (1.0 + 2.25) + 2.0 * 2.25);
        let got = moments(&positions, &[1.0, 1.0, -2.0]).unwrap();
        assert_eq!((got.mass, got.absolute_mass, got.centre, got.second), (0.0, 4.0, [0.0; 2], 2.0 - 18.0));
        let none = moments::<f32, 3>(&[], &[]).unwrap();
        assert_eq!((none.mass, none.centre, none.second), (0.0, [0.0; 3], 0.0));
        assert_eq!(moments(&positions, &[1.0]), Err(Error::LengthMismatch));
    }

    /// 1e5 terms of cancelling size: the compensated sum is as good as one in twice the precision.
    #[test]
    fn sums_do_not_lose_digits() {
        let terms: Vec<f32> = (0..100_000).map(|k| (k as f32 * 0.37).sin() * 1e3 + 0.1).collect();
        let mut sum = Sum::default();
        terms.iter().for_each(|&t| sum.add(t));
        let exact: f64 = terms.iter().map(|&t| f64::from(t)).sum();
        // 2 u |sum|, plus n^2 u^2 sum |x| in the worst case, which is n u^2 sum|x| at most here: below 1e-3.
        assert!((f64::from(sum.value()) - exact).abs() <= 2.0 * f64::from(f32::EPSILON) * exact.abs() + 1e-3);
    }

    #[test]
    fn overlap_of_a_lattice() {
        let masses = [0.01; 4];
        assert_eq!(smallest_overlap::<f64, 2>(0.2, &masses, &[1.0, 4.0, 0.0, 1.0]), Ok(Some(2.0)));
        assert_eq!(smallest_overlap::<f64, 1>(0.2, &[0.1, 0.0], &[0.5, 0.5]), Ok(Some(1.0)));
        assert!((smallest_overlap::<f64, 3>(0.2, &[0.001], &[1.0]).unwrap().unwrap() - 2.0).abs() < 1e-15);
        assert_eq!(smallest_overlap::<f64, 1>(0.2, &[0.0], &[0.5]), Ok(None));
        assert_eq!(smallest_overlap::<f64, 1>(0.0, &[0.0], &[0.5]), Err(Error::Delta));
    }
}
