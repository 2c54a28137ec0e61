//! Mollifiers that decay like a power of the distance, as particle codes soften gravity and vortices.
//!
//! With q = r^2 + delta^2, w = r^4 + delta^4, N the dimension and S_N the measure of the unit sphere:
//!
//! | S_N times | Plummer | algebraic | Vatistas, 2D |
//! |---|---|---|---|
//! | psi | N delta^2 / q^(N/2+1) | N (N+2)/2 delta^4 / q^(N/2+2) | 2 delta^4 / w^(3/2) |
//! | g | 1 / q^(N/2) | (r^2 + (1 + N/2) delta^2) / q^(N/2+1) | 1 / w^(1/2) |
//! | h | -N / q^(N/2+1) | -(N r^2 + N (N+4)/2 delta^2) / q^(N/2+2) | -2 r^2 / w^(3/2) |
//! | phi, 1D | q^(1/2) | (r^2 + delta^2/2) / q^(1/2) | |
//! | phi, 2D | log(q) / 2 | log(q) / 2 - delta^2 / (2 q) | log((r^2 + w^(1/2)) / 2) / 2 |
//! | phi, 3D | -1 / q^(1/2) | -(r^2 + 3/2 delta^2) / q^(3/2) | |
//!
//! Nothing cancels but the logarithm of a number near 1. Plummer's potential is the bare one at the distance q^(1/2); in vortex methods it is the low-order
//! algebraic kernel of Rosenhead and Moore. The second column is the high-order algebraic kernel of Winckelmans & Leonard (J. Comput. Phys. 109, 1993), the third the
//! velocity of Vatistas, Kozel & Mih (Exp. Fluids 11, 1991) with n = 2.

use super::Quantity;
use super::distance::{Distance, sphere};
use super::scaled::Scaled;
use crate::real::{DoubleWord, Real};

/// Which of the three.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Plummer,
    Algebraic,
    Vatistas,
}

impl Kind {
    /// Moment k in units of delta^k: infinite where the integral of |x|^k psi diverges. To some units in the last place.
    pub fn moment<T: Real>(self, dimension: usize, k: u32) -> DoubleWord<T> {
        if k == 0 {
            return DoubleWord::ONE;
        }
        let number = T::from_f64;
        let (n, k) = (dimension as f64, f64::from(k));
        // B(a, b) = Gamma(a) Gamma(b) / Gamma(a + b) times a factor, from integrals over s = (r / delta)^2.
        let beta = |a: f64, b: f64| number(a).gamma() * number(b).gamma() / number(a + b).gamma();
        let moment = match self {
            Self::Plummer if k < 2.0 => number(0.5 * n) * beta(0.5 * (n + k), 1.0 - 0.5 * k),
            Self::Algebraic if k < 4.0 => number(0.25 * n * (n + 2.0)) * beta(0.5 * (n + k), 2.0 - 0.5 * k),
            Self::Vatistas if k < 4.0 => T::HALF * beta(0.25 * k + 0.5, 1.0 - 0.25 * k),
            _ => T::INFINITY,
        };
        DoubleWord::from(moment)
    }

    pub fn place<T: Real, const D: usize>(self, delta: Distance<T>, r: Distance<T>) -> Soft<T, D> {
        let (delta, r) = (delta.squared(), r.squared());
        let sum = if self == Self::Vatistas { r.times(r).plus(delta.times(delta)) } else { r.plus(delta) };
        Soft { shape: self, delta, r, sum }
    }
}

/// A point at some distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Soft<T, const D: usize> {
    shape: Kind,
    /// delta^2.
    delta: Scaled<T>,
    /// r^2.
    r: Scaled<T>,
    /// q or w.
    sum: Scaled<T>,
}

impl<T: Real, const D: usize> Soft<T, D> {
    pub fn value(&self, quantity: Quantity) -> Scaled<T> {
        let times_sphere = match quantity {
            Quantity::Density => self.density(),
            Quantity::DensitySlope => self.density_slope(),
            Quantity::Potential => self.potential(),
            Quantity::GradientFactor => self.gradient(),
            Quantity::HessianFactor => self.hessian(),
            Quantity::EnclosedMass => {
                let power = self.r.powi(D as u32 / 2);
                let power = if D % 2 == 1 { power.times(self.r.sqrt()) } else { power };
                return self.gradient().times(power);
            }
        };
        times_sphere.over(sphere(D))
    }

    /// `numerator` over the n-th power of the root of q or w.
    fn over_root(&self, numerator: Scaled<T>, n: u32) -> Scaled<T> {
        let even = numerator.over(self.sum.powi(n / 2));
        if n % 2 == 1 { even.over(self.sum.sqrt()) } else { even }
    }

    /// r^2 + a delta^2.
    fn shifted(&self, a: f64) -> Scaled<T> {
        self.r.plus(self.delta.times(number(a)))
    }

    fn density(&self) -> Scaled<T> {
        let (n, d) = (D as f64, D as u32);
        let square = self.delta.times(self.delta);
        match self.shape {
            Kind::Plummer => self.over_root(self.delta.times(number(n)), d + 2),
            Kind::Algebraic => self.over_root(square.times(number(0.5 * n * (n + 2.0))), d + 4),
            Kind::Vatistas => self.over_root(square.times(number(2.0)), 3),
        }
    }

    fn density_slope(&self) -> Scaled<T> {
        let (n, d) = (D as f64, D as u32);
        let square = self.delta.times(self.delta);
        match self.shape {
            Kind::Plummer => self.over_root(self.delta.times(number(-n * (n + 2.0))), d + 4),
            Kind::Algebraic => self.over_root(square.times(number(-0.5 * n * (n + 2.0) * (n + 4.0))), d + 6),
            Kind::Vatistas => self.over_root(square.times(self.r).times(number(-12.0)), 5),
        }
    }

    fn gradient(&self) -> Scaled<T> {
        let d = D as u32;
        match self.shape {
            Kind::Plummer => self.over_root(number(1.0), d),
            Kind::Algebraic => self.over_root(self.shifted(1.0 + 0.5 * D as f64), d + 2),
            Kind::Vatistas => self.over_root(number(1.0), 1),
        }
    }

    fn hessian(&self) -> Scaled<T> {
        let (n, d) = (D as f64, D as u32);
        match self.shape {
            Kind::Plummer => self.over_root(number(-n), d + 2),
            Kind::Algebraic => self.over_root(self.shifted(0.5 * (n + 4.0)).times(number(-n)), d + 4),
            Kind::Vatistas => self.over_root(self.r.times(number(-2.0)), 3),
        }
    }

    fn potential(&self) -> Scaled<T> {
        let half_log = |of: Scaled<T>| Scaled::new(of.log(), -1);
        match (self.shape, D) {
            (Kind::Plummer, 1) => self.sum.sqrt(),
            (Kind::Plummer, 2) => half_log(self.sum),
            (Kind::Plummer, _) => self.over_root(number(-1.0), 1),
            (Kind::Algebraic, 1) => self.over_root(self.shifted(0.5), 1),
            (Kind::Algebraic, 2) => half_log(self.sum).plus(self.delta.over(self.sum).times(number(-0.5))),
            (Kind::Algebraic, _) => self.over_root(self.shifted(1.5).times(number(-1.0)), 3),
            (Kind::Vatistas, _) => half_log(self.r.plus(self.sum.sqrt()).shift(-1)),
        }
    }
}

/// A constant, exact.
fn number<T: Real>(x: f64) -> Scaled<T> {
    Scaled::from(T::from_f64(x))
}
