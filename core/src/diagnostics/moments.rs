//! Conserved and dissipated quantities from positions and masses alone: total mass, centre of mass, second moment; and
//! the overlap of the blobs.

use super::sums::sum_of_products;
use crate::error::{Error, Result};
use crate::real::{Extended, Real, Scalar};

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
/// Two passes with compensated sums in double precision. Each term has two roundings and the sums a few more, for any n. No particles give
/// zeros. Masses and positions are scaled by powers of two where products would leave the range, so a result in range is found
/// for any intermediate values. Input that is not finite gives output that is not finite.
///
/// # Errors
/// [`Error::LengthMismatch`].
pub fn moments<T: Real, const D: usize>(positions: &[[T; D]], masses: &[T]) -> Result<Moments<T, D>> {
    if positions.len() != masses.len() {
        return Err(Error::LengthMismatch);
    }
    let weights = masses.iter().map(|m| m.to_f64());
    let mass = sum_of_products(weights.clone().map(|m| [m]));
    let absolute_mass = sum_of_products(weights.clone().map(|m| [m.abs()]));
    // Distances are measured from the heaviest particle: about a centre that is rounded, particles at one place would have a second moment.
    let heavier = |best: (T, usize), (i, m): (usize, &T)| if m.abs() > best.0 { (m.abs(), i) } else { best };
    let (_, heaviest) = masses.iter().enumerate().fold((T::ZERO, 0), heavier);
    let (mut centre, mut second) = ([T::ZERO; D], Extended::ZERO);
    for (k, slot) in centre.iter_mut().enumerate() {
        let along = positions.iter().map(|x| x.get(k).map_or(0.0, |c| c.to_f64()));
        let first = sum_of_products(weights.clone().zip(along.clone()).map(|(m, x)| [m, x]));
        let middle = if mass.is_zero() { Extended::ZERO } else { first.over(mass) };
        *slot = T::from_f64(middle.get());
        // The unit of distances, chosen so that none overflows: 1, unless a position is close to the end of the range.
        let farthest = along.clone().fold(0.0_f64, |most, x| if x.abs() > most { x.abs() } else { most });
        let unit = farthest.frexp().1.saturating_sub(1000).max(0);
        let scale = 1.0_f64.ldexp(-unit);
        let origin = positions.get(heaviest).and_then(|x| x.get(k)).filter(|_| !mass.is_zero());
        let origin = origin.map_or(0.0, |x| x.to_f64() * scale);
        let offsets = along.map(|x| x * scale - origin);
        let first = sum_of_products(weights.clone().zip(offsets.clone()).map(|(m, d)| [m, d]));
        let middle = if mass.is_zero() { Extended::ZERO } else { first.over(mass) };
        // The same for the centre, which may be far outside if masses have both signs.
        let farther = middle.exponent().unwrap_or(0).saturating_sub(1000).max(0);
        let (scale, middle) = (1.0_f64.ldexp(-farther), middle.in_units(farther));
        let apart = offsets.map(|d| d * scale - middle);
        let moment = sum_of_products(weights.clone().zip(apart).map(|(m, d)| [m, d, d]));
        second = second.plus(moment.times(Extended::new(1.0, 2 * (unit + farther))));
    }
    let narrow = |sum: Extended| T::from_f64(sum.get());
    Ok(Moments { mass: narrow(mass), absolute_mass: narrow(absolute_mass), centre, second: narrow(second) })
}

/// The smallest overlap of the blobs: delta over the local spacing of the particles.
///
/// A particle of mass m in a density rho represents the volume m / rho, so its spacing is `(m / rho)^(1/D)` and the
/// overlap `delta (rho / m)^(1/D)`. Particles without mass or density are ignored; `None` if there are no others.
///
/// The sum of blobs samples the density on a lattice of that spacing. Its aliasing error is the mollifier's
/// transform at 2 pi / spacing (Poisson's summation): for a Gaussian of width delta, `exp(-(pi overlap)^2)`. Where a flow spreads the
/// particles (repulsion), the overlap decreases and this error exceeds delta^m: an overlap of 1.4 to 1.7 leaves 5e-9 to 4e-13 times the
/// initial density, but 1 leaves 5e-5. For a compact mollifier delta is the radius of the support, so its overlap must be
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
    let wide = |x: &T| Extended::new(x.to_f64(), 0);
    let counted = |x: &T| x.is_finite() && *x != T::ZERO;
    let pairs = masses.iter().zip(densities).filter(|(m, rho)| counted(m) && counted(rho));
    let quotients = pairs.map(|(m, rho)| wide(&rho.abs()).over(wide(&m.abs())));
    let sparsest = quotients.reduce(|least, q| if q.is_smaller(least) { q } else { least });
    Ok(sparsest.map(|q| T::from_f64(q.root(D as i32).times(wide(&delta)).get())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostics::Sum;
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

    /// Sun and planet in metres and kilograms. In single precision m x is out of range, but the centre is not.
    #[test]
    fn finite_moments_of_factors_whose_product_is_not() {
        let (sun, earth, distance) = (1.989e30_f32, 5.972e24_f32, 1.496e11_f32);
        let got = moments(&[[0.0, 0.0], [distance, 0.0]], &[sun, earth]).unwrap();
        let (m, e, r) = (f64::from(sun), f64::from(earth), f64::from(distance));
        // Each value is rounded once to single precision.
        let same = |got: f32, want: f64| assert!((f64::from(got) / want - 1.0).abs() <= 0.5 * f64::from(f32::EPSILON));
        same(got.mass, m + e);
        same(got.centre[0], e * r / (m + e));
        assert_eq!(got.centre[1], 0.0);
        // The second moment, 1.3e47, is out of range.
        assert_eq!(got.second, f32::INFINITY);
        // The same in double precision at the ends of its range.
        for (mass, length) in [(1e300, 1e200), (1e-300, 1e-200), (1e300, 1e-300), (1e-300, 1e307), (3e-320, 1e200)] {
            let got = moments(&[[length, -length], [-3.0 * length, length]], &[mass, 3.0 * mass]).unwrap();
            let close = |got: f64, want: f64| {
                // Subnormal values are rounded to the smallest unit.
                assert!(
                    (got - want).abs() <= 4.0 * f64::EPSILON * want.abs() + 5e-324,
                    "{mass} {length}: {got:e} {want:e}"
                );
            };
            close(got.mass, 4.0 * mass);
            close(got.centre[0], -2.0 * length);
            close(got.centre[1], 0.5 * length);
            // 9 + 3 along x, 9/4 + 3/4 along y.
            let want = sum_of_products([[15.0 * mass, length, length]].into_iter()).get();
            assert!(got.second == want || (got.second / want - 1.0).abs() < 8.0 * f64::EPSILON);
        }
    }

    /// The centre of particles at one place is rounded; their second moment is zero all the same.
    #[test]
    fn particles_at_one_place_have_no_second_moment() {
        for x in [0.1, 1.88e171, -1.7e308] {
            for n in [1, 3, 10] {
                let masses: Vec<f64> = (0..n).map(|k| 1.43 + f64::from(k)).collect();
                let got = moments(&std::vec![[x, 0.3 * x]; n as usize], &masses).unwrap();
                assert!(got.second == 0.0 && (got.centre[0] / x - 1.0).abs() < 1e-15, "{x} {n} {got:?}");
            }
        }
        let got = moments(&[[1.2e19_f32]; 10], &[2.05e37; 10]).unwrap();
        assert_eq!(got.second, 0.0);
    }

    #[test]
    fn a_heavy_particle_does_not_hide_a_far_one() {
        // 1e200 at the origin, 1e-200 at 1e300: their centre is at 1e-100.
        let got = moments(&[[0.0], [1e300]], &[1e200, 1e-200]).unwrap();
        assert!((got.centre[0] / 1e-100 - 1.0).abs() < 4.0 * f64::EPSILON);
        // A centre out of range is infinite.
        let got = moments(&[[1e300], [0.0]], &[1.0, 1e-17 - 1.0]).unwrap();
        assert_eq!((got.mass, got.centre[0]), (0.0, 0.0));
        let got = moments(&[[1e300], [0.0]], &[1.0, -1.0 + f64::EPSILON]).unwrap();
        assert_eq!(got.centre[0], f64::INFINITY);
    }

    /// In single precision 2^24 + 1 is 2^24.
    #[test]
    fn many_light_particles_beside_a_heavy_one() {
        let n = 1 << 20;
        let masses: Vec<f32> = core::iter::once(16_777_216.0).chain((0..n).map(|_| 1.0)).collect();
        let positions: Vec<[f32; 1]> = core::iter::once([0.0]).chain((0..n).map(|_| [17.0])).collect();
        let got = moments(&positions, &masses).unwrap();
        let total = 17_825_792.0;
        assert_eq!((got.mass, got.absolute_mass, got.centre), (total, total, [1.0]));
        assert_eq!(got.second, 16_777_216.0 + 256.0 * n as f32);
    }

    /// 1e5 terms that cancel: the compensated sum is as accurate as a sum in twice the precision.
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
        assert_eq!(smallest_overlap::<f64, 1>(0.2, &[1.0, f64::NAN], &[0.0, 0.5]), Ok(None));
        // (rho / m)^(1/2), where the quotient is out of range at either end.
        for (m, rho, want) in [(1e-200, 1e200, 1e200), (1e200, 1e-200, 1e-200)] {
            let got = smallest_overlap::<f64, 2>(1.0, &[m, m], &[rho, 1.5 * rho]).unwrap().unwrap();
            assert!((got / want - 1.0).abs() < 4.0 * f64::EPSILON, "{got:e} {want:e}");
        }
        assert_eq!(smallest_overlap::<f64, 1>(0.0, &[0.0], &[0.5]), Err(Error::Delta));
    }
}
