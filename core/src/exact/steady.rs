//! Steady states in closed form, for comparison with long runs.

use crate::error::{Error, Result};
use crate::real::Real;

/// The radius of the ring (uniform density on a circle, total mass 1) that is a steady state in the plane of
/// `K = |x|^a / a - |x|^b / b`, for `a > b > 0`.
///
/// On a ring of radius R the radial force of |x|^p / p is proportional to `(2 R)^(p-1) B((p+1)/2, 1/2)`, so
/// `R = (1/2) (B((b+1)/2, 1/2) / B((a+1)/2, 1/2))^(1/(a-b))`.
///
/// Source: Kolokolnikov, Sun, Uminsky, Bertozzi, *Stability of ring patterns arising from two-dimensional particle
/// interactions*, 2011.
///
/// # Errors
/// [`Error::NotFinite`]; [`Error::OutOfDomain`]: not `a > b > 0`.
pub fn ring_radius<T: Real>(a: T, b: T) -> Result<T> {
    if !a.is_finite() || !b.is_finite() {
        return Err(Error::NotFinite);
    }
    if b <= T::ZERO || a <= b {
        return Err(Error::OutOfDomain);
    }
    // log B(x, 1/2) = log Gamma(x) + log Gamma(1/2) - log Gamma(x + 1/2). Gamma(1/2) cancels in the quotient.
    let log_beta = |p: T| {
        let x = (p + T::ONE) * T::HALF;
        x.log_gamma() - (x + T::HALF).log_gamma()
    };
    Ok(T::HALF * ((log_beta(b) - log_beta(a)) / (a - b)).exp())
}

/// The radial steady state of `K = |x|^4 / 4 - log|x| / (2 pi)` in the plane with total mass 1:
/// `rho(r) = 4 r^2 + 4 q` for `r <= radius`, zero beyond.
///
/// Where the density is positive, `0 = Laplacian(K * rho) = 4 (r^2 + q) - rho` with q the second moment. Mass and second moment of
/// that density give `s = 2 pi R^4 = 1 / (1 + 2 / sqrt 3)` and `q = (4 pi / 3) R^6 / (1 - s)`.
///
/// Source: Fetecau, Huang, Kolokolnikov, *Swarm dynamics and equilibria for a nonlocal aggregation model*, 2011 (their
/// q = 4). The closed form follows from the two conditions above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuarticLogarithmic<T> {
    /// R, the radius of the support.
    pub radius: T,
    /// q, the second moment of the density about its centre.
    pub second_moment: T,
}

impl<T: Real> QuarticLogarithmic<T> {
    /// The steady state of mass 1.
    #[must_use]
    pub fn new() -> Self {
        let three = T::from_i32(3);
        let s = T::ONE / (T::ONE + T::TWO / three.sqrt());
        let square = (s / (T::TWO * T::PI)).sqrt();
        let second_moment = T::from_i32(4) * T::PI / three * square.powi(3) / (T::ONE - s);
        Self { radius: square.sqrt(), second_moment }
    }

    /// The density at distance `r >= 0` from the centre.
    #[must_use]
    pub fn density(&self, r: T) -> T {
        if r > self.radius { T::ZERO } else { T::from_i32(4) * (r * r + self.second_moment) }
    }

    /// The mass within distance `r >= 0` of the centre: `2 pi (r^4 + 2 q r^2)`.
    #[must_use]
    pub fn enclosed_mass(&self, r: T) -> T {
        let square = r.min(self.radius).powi(2);
        T::TWO * T::PI * square * (square + T::TWO * self.second_moment)
    }
}

impl<T: Real> Default for QuarticLogarithmic<T> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::real::Scalar;

    /// The radial force on a ring, by the trapezium rule over the angle (the integrand vanishes at the pole).
    #[test]
    fn the_ring_is_at_rest() {
        for (a, b) in [(4.0, 1.5), (7.0, 1.5), (2.0, 1.0), (3.0, 2.5)] {
            let radius: f64 = ring_radius(a, b).unwrap();
            let n = 200_000;
            let mean = |p: f64| {
                let term = |k: i32| {
                    let half = f64::PI * (f64::from(k) + 0.5) / f64::from(n);
                    // |x - y| = 2 R sin(half); its radial part is |x - y| sin(half).
                    (2.0 * radius * half.sin()).powf(p - 1.0) * half.sin()
                };
                (0..n).map(term).sum::<f64>() / f64::from(n)
            };
            // The midpoint rule's error at the zeros of sin^p is O((pi / n)^(p+1)); 1e-12 for the roundings of the sum.
            let tolerance = (f64::PI / f64::from(n)).powf(b + 1.0) + 1e-12;
            assert!((mean(a) - mean(b)).abs() < tolerance * mean(a), "{a} {b} {radius}");
        }
        assert_eq!(ring_radius(1.0, 2.0), Err(Error::OutOfDomain));
        assert_eq!(ring_radius(1.0, 0.0), Err(Error::OutOfDomain));
        assert_eq!(ring_radius(f64::NAN, 1.0), Err(Error::NotFinite));
    }

    #[test]
    fn the_radial_state_has_mass_one_and_its_second_moment() {
        let state = QuarticLogarithmic::<f64>::new();
        let n = 200_000;
        let h = state.radius / f64::from(n);
        let sum = |power: i32| -> f64 {
            let ring = |k: i32| {
                let r = (f64::from(k) + 0.5) * h;
                2.0 * f64::PI * r.powi(power + 1) * state.density(r) * h
            };
            (0..n).map(ring).sum()
        };
        // The midpoint rule's error is about (h / R)^2 = 2.5e-11.
        assert!((sum(0) - 1.0).abs() < 1e-9 && (sum(2) - state.second_moment).abs() < 1e-9);
        assert!((state.enclosed_mass(1.0) - 1.0).abs() < 1e-14);
        // Equilibrium: the force of the quartic part, r (r^2 + 2 q), equals that of the enclosed mass, m / (2 pi r).
        for r in [0.1, 0.3, state.radius] {
            let quartic = r * (r * r + 2.0 * state.second_moment);
            assert!((quartic - state.enclosed_mass(r) / (2.0 * f64::PI * r)).abs() < 1e-14);
        }
    }
}
