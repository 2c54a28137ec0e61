//! Exact radial solutions of the aggregation equation with the Newtonian kernel, by mass coordinates.
//!
//! With K = c times the Newtonian kernel (Laplacian = +Dirac) and a radial density, the mass enclosed by a particle's
//! sphere is constant. So `r^(d-1) r' = -c m / S_d` with `S_d` = 2, 2 pi, 4 pi, and the density along a trajectory
//! satisfies `rho' = c rho^2`:
//!
//! `r(t)^d = r(0)^d - c d m t / S_d`,  `rho(t) = 1 / (1 / rho(0) - c t)`.
//!
//! Craig & Bertozzi, section 4.1 (their m is m / S_d); Bertozzi, Garnett, Laurent, *Characterization of radially
//! symmetric finite time blowup in multidimensional aggregation equations*, 2012.

use crate::error::{Error, Result};
use crate::kernel::sphere;
use crate::real::Real;

/// The radial density `height (1 - (r / radius)^2)^exponent` for `r <= radius`, zero beyond.
///
/// Exponent 0 is the indicator of a ball: Craig & Bertozzi (4.4); 20 and 10 are (4.3) and (4.5); 2 is the first plot of
/// their Figure 5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump<T> {
    height: T,
    radius: T,
    exponent: u32,
}

impl<T: Real> Bump<T> {
    /// The largest exponent.
    pub const MAX_EXPONENT: u32 = 64;

    /// A bump of this height and radius.
    ///
    /// # Errors
    /// [`Error::NotFinite`]: height or radius is not finite. [`Error::OutOfDomain`]: the radius is not positive or the
    /// exponent is above [`Bump::MAX_EXPONENT`].
    pub fn new(height: T, radius: T, exponent: u32) -> Result<Self> {
        if !height.is_finite() || !radius.is_finite() {
            return Err(Error::NotFinite);
        }
        if radius <= T::ZERO || exponent > Self::MAX_EXPONENT {
            return Err(Error::OutOfDomain);
        }
        Ok(Self { height, radius, exponent })
    }

    /// The density at distance `r >= 0` from the centre.
    #[must_use]
    pub fn density(&self, r: T) -> T {
        let t = self.edge(r);
        // The ball is closed: the indicator is 1 at its edge, as in Craig & Bertozzi (4.4).
        if r > self.radius { T::ZERO } else { self.height * t.powi(self.exponent) }
    }

    /// The mass within distance `r >= 0` of the centre, in `D` = 1, 2, 3 dimensions.
    ///
    /// `J_k = int_0^r x^(D-1) (1 - x^2)^k dx` follows from `J_0 = r^D / D` and
    /// `(2 k + D) J_k = r^D (1 - r^2)^k + 2 k J_(k-1)`, by parts. All terms are positive, so each step has a few roundings.
    #[must_use]
    pub fn enclosed_mass<const D: usize>(&self, r: T) -> T {
        let inside = if r < self.radius { r } else { self.radius };
        let d = T::from_usize(D);
        let volume = (inside / self.radius).powi(D as u32);
        let (t, mut power, mut integral) = (self.edge(inside), T::ONE, volume / d);
        for k in 1..=self.exponent {
            power *= t;
            let two_k = T::from_usize(2 * k as usize);
            integral = (volume * power + two_k * integral) / (two_k + d);
        }
        T::from_f64(sphere(D)) * self.height * self.radius.powi(D as u32) * integral
    }

    /// 1 - (r / radius)^2, without cancellation near the edge, at least zero.
    fn edge(&self, r: T) -> T {
        let q = r / self.radius;
        ((self.radius - r) / self.radius * (T::ONE + q)).max(T::ZERO)
    }
}

/// The factor of the distance from the centre after time `t`, for a particle that starts at distance `r`
/// around the mass `enclosed`: `r(t) = factor r`. Zero after the particle has reached the centre; one at `r = 0`.
///
/// `coefficient` is c of the kernel: 1 attracts, -1 repels.
#[must_use]
pub fn contraction<T: Real, const D: usize>(coefficient: T, enclosed: T, r: T, t: T) -> T {
    if r <= T::ZERO {
        return T::ONE;
    }
    let d = T::from_usize(D);
    // r(t)^D / r^D. In one dimension sum and root are the identity.
    let cube = (T::ONE - coefficient * d * enclosed * t / (T::from_f64(sphere(D)) * r.powi(D as u32))).max(T::ZERO);
    match D {
        1 => cube,
        2 => cube.sqrt(),
        _ if cube == T::ZERO => T::ZERO,
        _ => {
            // One Newton step corrects for the rounded exponent 1/3.
            let root = cube.pow(T::ONE / T::from_i32(3));
            root - (root - cube / (root * root)) / T::from_i32(3)
        }
    }
}

/// The density along a trajectory at time `t`: `1 / (1 / density - c t)`; 0 for zero density. Infinite or of the wrong
/// sign at and after the blow-up time ([`blow_up_time`]).
#[must_use]
pub fn density_along<T: Real>(coefficient: T, density: T, t: T) -> T {
    density / (T::ONE - coefficient * density * t)
}

/// The time at which the density along a trajectory becomes infinite: `1 / (c density)`; infinity if it never does.
#[must_use]
pub fn blow_up_time<T: Real>(coefficient: T, density: T) -> T {
    let rate = coefficient * density;
    if rate > T::ZERO { T::ONE / rate } else { T::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::real::Scalar;

    /// Simpson's rule with 4000 panels: error below 1e-12 for these polynomials of degree <= 42.
    fn simpson(f: impl Fn(f64) -> f64, b: f64) -> f64 {
        let n = 4000;
        let h = b / f64::from(n);
        let weight = |i: i32| {
            if i == 0 || i == n {
                1.0
            } else if i % 2 == 1 {
                4.0
            } else {
                2.0
            }
        };
        (0..=n).map(|i| weight(i) * f(f64::from(i) * h)).sum::<f64>() * h / 3.0
    }

    #[test]
    fn enclosed_mass_is_the_integral_of_the_density() {
        for exponent in [0, 1, 2, 10, 20] {
            let bump = Bump::new(1.5, 0.8, exponent).unwrap();
            for r in [0.0, 1e-3, 0.3, 0.79, 0.8, 1.0] {
                let end = f64::min(r, 0.8);
                let check = |got: f64, want: f64| assert!((got - want).abs() < 1e-11, "{exponent} {r} {got} {want}");
                check(bump.enclosed_mass::<1>(r), 2.0 * simpson(|x| bump.density(x), end));
                check(bump.enclosed_mass::<2>(r), 2.0 * f64::PI * simpson(|x| x * bump.density(x), end));
                check(bump.enclosed_mass::<3>(r), 4.0 * f64::PI * simpson(|x| x * x * bump.density(x), end));
            }
            assert!(bump.density(0.8000001) == 0.0);
        }
        assert_eq!(Bump::new(f64::NAN, 1.0, 2), Err(Error::NotFinite));
        assert_eq!(Bump::new(1.0, 0.0, 2), Err(Error::OutOfDomain));
        assert_eq!(Bump::new(1.0, 1.0, 65), Err(Error::OutOfDomain));
    }

    /// A uniform ball contracts by the same factor everywhere, and its density is mass over volume.
    fn uniform<const D: usize>(coefficient: f64) {
        let ball = Bump::new(1.0, 1.0, 0).unwrap();
        let t = 0.7;
        let density = density_along(coefficient, 1.0, t);
        for r in [1e-8, 0.1, 0.5, 1.0] {
            let factor: f64 = contraction::<f64, D>(coefficient, ball.enclosed_mass::<D>(r), r, t);
            assert!((factor.powi(D as i32) * density - 1.0).abs() < 8.0 * f64::EPSILON, "{D} {r} {factor}");
        }
        assert_eq!(contraction::<f64, D>(coefficient, 0.0, 0.0, t), 1.0);
    }

    #[test]
    fn mass_times_volume_is_kept() {
        for coefficient in [1.0, -1.0, 0.5] {
            uniform::<1>(coefficient);
            uniform::<2>(coefficient);
            uniform::<3>(coefficient);
        }
        assert_eq!(contraction::<f64, 3>(1.0, 4.0 * f64::PI, 1.0, 5.0), 0.0);
        assert_eq!(blow_up_time(1.0, 0.5), 2.0);
        assert_eq!(blow_up_time(-1.0, 0.5), f64::INFINITY);
        assert_eq!(density_along(1.0, 0.0, 5.0), 0.0);
    }
}
