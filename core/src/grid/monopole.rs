//! The field of all mass at its centre: Dirichlet data, and the drift outside the mesh.

use crate::real::Real;
use crate::special::bessel::{k0_scaled, k1_scaled};

/// `mass` at `centre`, with the kernel of the equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monopole<T> {
    /// The total mass, what is outside the mesh included.
    pub mass: T,
    /// Its centre.
    pub centre: [T; 2],
    /// The kernel's k; 0: Newtonian.
    pub screening: T,
    /// Below this distance the field is that at this distance: finite wherever it is asked for.
    pub floor: T,
}

impl<T: Real> Monopole<T> {
    fn distance(&self, x: [T; 2]) -> ([T; 2], T) {
        let d = [x[0] - self.centre[0], x[1] - self.centre[1]];
        (d, (d[0] * d[0] + d[1] * d[1]).sqrt().max(self.floor))
    }

    /// `mass V(x - centre)`, V = log r / (2 pi) or -K0(k r) / (2 pi): (3.10) with the sign of V * rho.
    pub fn potential(&self, x: [T; 2]) -> T {
        let (_, r) = self.distance(x);
        let v = if self.screening > T::ZERO { -unscaled(self.screening * r, k0_scaled) } else { r.log() };
        self.mass * v / (T::TWO * T::PI)
    }

    /// The gradient of [`Monopole::potential`]: (3.8).
    pub fn gradient(&self, x: [T; 2]) -> [T; 2] {
        let (d, r) = self.distance(x);
        let k = self.screening;
        // V' / r
        let slope = if k > T::ZERO { k * unscaled(k * r, k1_scaled) / r } else { T::ONE / (r * r) };
        let factor = self.mass * slope / (T::TWO * T::PI);
        [factor * d[0], factor * d[1]]
    }
}

/// e^-x times the scaled function; 0 where that is below the scalar's range, whatever the function's own range is.
fn unscaled<T: Real>(x: T, scaled: impl Fn(T) -> T) -> T {
    let decay = (-x).exp();
    if decay > T::ZERO { decay * scaled(x) } else { T::ZERO }
}
