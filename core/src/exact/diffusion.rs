//! Exact solutions of `rho_t = nu Laplacian(rho^m)`, m >= 1, alone and with quadratic attraction.
//!
//! * [`Spreading`]: the solution that starts from a point, a Gaussian for m = 1 (heat) and Barenblatt's profile for m > 1
//! * [`steady`]: the steady state with the kernel |x|^2 / 2
//!
//! Source: Barenblatt, *On some unsteady motions of a liquid or a gas in a porous medium*, 1952; Vazquez, *The Porous Medium Equation*, 2007, section 17.5.

use crate::error::{Error, Result};
use crate::real::Real;

/// A radial density about 0: `peak (1 - r^2 / square)^power` where that is positive, zero beyond; `peak e^(-r^2 / square)` for m = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile<T, const D: usize> {
    /// The density at the centre.
    pub peak: T,
    /// The square of the radius of the support; for m = 1 twice the variance of a coordinate.
    pub square: T,
    /// 1 / (m - 1); `None` for m = 1.
    pub power: Option<T>,
}

impl<T: Real, const D: usize> Profile<T, D> {
    /// The profile of this mass with `rho^(m-1) = c - k r^2`, or `rho ~ e^(-k r^2)` for m = 1.
    fn new(m: T, mass: T, k: T) -> Self {
        let half = T::from_usize(D) * T::HALF;
        if m == T::ONE {
            return Self { peak: mass * (k / T::PI).pow(half), square: T::ONE / k, power: None };
        }
        // The integral of (1 - |y|^2)^p over the unit ball is pi^(D/2) Gamma(p + 1) / Gamma(p + 1 + D/2).
        let p = T::ONE / (m - T::ONE);
        let ball = half * T::PI.log() + (p + T::ONE).log_gamma() - (p + T::ONE + half).log_gamma();
        let c = ((mass.log() + half * k.log() - ball) / (p + half)).exp();
        Self { peak: c.pow(p), square: c / k, power: Some(p) }
    }

    /// The density at distance `r` from the centre.
    #[must_use]
    pub fn density(&self, r: T) -> T {
        let s = r * r / self.square;
        match self.power {
            None => self.peak * (-s).exp(),
            Some(_) if s >= T::ONE => T::ZERO,
            Some(power) => self.peak * (T::ONE - s).pow(power),
        }
    }

    /// The mean of r^2.
    #[must_use]
    pub fn mean_square(&self) -> T {
        let half = T::from_usize(D) * T::HALF;
        let over = self.power.map_or(T::ONE, |p| p + T::ONE + half);
        self.square * half / over
    }
}

/// The solution that starts from a point of this mass at time 0.
///
/// ```
/// use mollis_core::exact::diffusion::Spreading;
///
/// let heat = Spreading::<f64, 1>::new(1.0, 0.5, 3.0)?;
/// // Twice the coefficient times the time: the variance.
/// assert!((heat.at(4.0).mean_square() - 4.0).abs() < 1e-14);
/// // The flow of a porous medium with m = 2 on the line widens like the cube root of time.
/// assert!((Spreading::<f64, 1>::new(2.0, 1.0, 1.0)?.stretch(1.0, 8.0) - 2.0).abs() < 1e-14);
/// # Ok::<(), mollis_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spreading<T, const D: usize> {
    exponent: T,
    coefficient: T,
    mass: T,
}

impl<T: Real, const D: usize> Spreading<T, D> {
    /// Of exponent m, coefficient nu and mass.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfDomain`]: m < 1, nu <= 0 or mass <= 0.
    pub fn new(exponent: T, coefficient: T, mass: T) -> Result<Self> {
        checked([exponent, coefficient, mass])?;
        Ok(Self { exponent, coefficient, mass })
    }

    /// 1 / (D (m - 1) + 2): lengths grow like t to this power.
    fn rate(&self) -> T {
        T::ONE / (T::from_usize(D) * (self.exponent - T::ONE) + T::TWO)
    }

    /// The density at time t > 0: with b = 1 / (D (m-1) + 2) and s = nu t,
    /// `rho^(m-1) = c s^(-D b (m-1)) - b (m-1) / (2 m) r^2 / s`.
    #[must_use]
    pub fn at(&self, t: T) -> Profile<T, D> {
        let m = self.exponent;
        let factor = if m == T::ONE { T::HALF } else { self.rate() * (m - T::ONE) / m };
        Profile::new(m, self.mass, T::HALF * factor / (self.coefficient * t))
    }

    /// The factor by which a point's distance from the centre grows from time `from` to time `to`: the velocity is `b x / t`.
    #[must_use]
    pub fn stretch(&self, from: T, to: T) -> T {
        (to / from).pow(self.rate())
    }
}

/// The steady state of this mass with the kernel `|x|^2 / 2`: `nu m / (m-1) rho^(m-1) + mass r^2 / 2` is constant where the density is positive; for m = 1 a Gaussian of variance
/// nu / mass.
///
/// # Errors
/// As [`Spreading::new`].
pub fn steady<T: Real, const D: usize>(exponent: T, coefficient: T, mass: T) -> Result<Profile<T, D>> {
    checked([exponent, coefficient, mass])?;
    let factor = if exponent == T::ONE { T::ONE } else { (exponent - T::ONE) / exponent };
    Ok(Profile::new(exponent, mass, T::HALF * factor * mass / coefficient))
}

fn checked<T: Real>([exponent, coefficient, mass]: [T; 3]) -> Result<()> {
    if ![exponent, coefficient, mass].iter().all(|x| x.is_finite()) {
        return Err(Error::NotFinite);
    }
    if exponent < T::ONE || coefficient <= T::ZERO || mass <= T::ZERO { Err(Error::OutOfDomain) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    /// The equation, by central differences of the profiles in time and radius.
    fn residual<const D: usize>(m: f64, r: f64, t: f64) -> f64 {
        let of = Spreading::<f64, D>::new(m, 0.7, 1.3).unwrap();
        let (dt, dr) = (1e-4, 1e-3);
        let rate = (of.at(t + dt).density(r) - of.at(t - dt).density(r)) / (2.0 * dt);
        let p = |r: f64| of.at(t).density(r).powf(m);
        let (slope, second) = ((p(r + dr) - p(r - dr)) / (2.0 * dr), (p(r + dr) - 2.0 * p(r) + p(r - dr)) / (dr * dr));
        rate - 0.7 * (second + (D as f64 - 1.0) / r * slope)
    }

    #[test]
    fn spreading_solves_the_equation() {
        for m in [1.0, 1.5, 2.0, 3.0] {
            for (r, t) in [(0.2, 1.0), (0.4, 2.0)] {
                for error in [residual::<1>(m, r, t), residual::<2>(m, r, t), residual::<3>(m, r, t)] {
                    // Differences of second order with steps of 1e-3 and 1e-4.
                    assert!(error.abs() < 1e-4, "{m} {r} {t} {error}");
                }
            }
        }
    }

    #[test]
    fn profiles_have_their_mass_and_second_moment() {
        fn check<const D: usize>(profile: Profile<f64, D>, mass: f64) {
            let end = profile.square.sqrt() * if profile.power.is_some() { 1.0 } else { 6.0 };
            let (n, sphere) = (400_000, [2.0, 2.0 * PI, 4.0 * PI][D - 1]);
            let sum = |power: i32| -> f64 {
                let h = end / f64::from(n);
                (0..n)
                    .map(|k| {
                        let r = (f64::from(k) + 0.5) * h;
                        sphere * r.powi(D as i32 - 1 + power) * profile.density(r) * h
                    })
                    .sum()
            };
            // The edge of (1 - s)^(1/2) makes an error like (h / R)^(3/2) of the midpoint rule.
            assert!((sum(0) / mass - 1.0).abs() < 1e-7);
            assert!((sum(2) / mass / profile.mean_square() - 1.0).abs() < 1e-7);
        }
        for m in [1.0, 1.5, 2.0, 3.0] {
            check(Spreading::<f64, 1>::new(m, 0.3, 2.0).unwrap().at(0.8), 2.0);
            check(Spreading::<f64, 2>::new(m, 0.3, 2.0).unwrap().at(0.8), 2.0);
            check(steady::<f64, 3>(m, 0.3, 2.0).unwrap(), 2.0);
        }
    }

    #[test]
    fn steady_states_are_at_rest() {
        for m in [1.0, 1.5, 2.0, 3.0] {
            let profile = steady::<f64, 2>(m, 0.3, 2.0).unwrap();
            // nu m rho^(m-2) rho' = -mass r.
            let (r, dr) = (0.5 * profile.square.sqrt(), 1e-6);
            let slope = (profile.density(r + dr) - profile.density(r - dr)) / (2.0 * dr);
            let force = 0.3 * m * profile.density(r).powf(m - 2.0) * slope;
            assert!((force / (-2.0 * r) - 1.0).abs() < 1e-8, "{m}");
        }
    }

    #[test]
    fn refusals() {
        assert_eq!(Spreading::<f64, 1>::new(0.5, 1.0, 1.0), Err(Error::OutOfDomain));
        assert_eq!(Spreading::<f64, 1>::new(1.0, 0.0, 1.0), Err(Error::OutOfDomain));
        assert_eq!(steady::<f64, 1>(1.0, 1.0, -1.0), Err(Error::OutOfDomain));
        assert_eq!(steady::<f64, 1>(f64::NAN, 1.0, 1.0), Err(Error::NotFinite));
    }
}
