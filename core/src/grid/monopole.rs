//! The field of all mass at its centre, with or without its second moments: Dirichlet data, and the drift outside the mesh.

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
    /// [sum m (x^2 - y^2), sum 2 m x y] about the centre, of what is inside the mesh; 0 unless the border takes them
    /// ([`super::Walls::FreeQuadrupole`]).
    pub quadrupole: [T; 2],
}

impl<T: Real> Monopole<T> {
    fn distance(&self, x: [T; 2]) -> ([T; 2], T) {
        let d = [x[0] - self.centre[0], x[1] - self.centre[1]];
        (d, (d[0] * d[0] + d[1] * d[1]).sqrt().max(self.floor))
    }

    /// r^2 for the second moments: nearer than the root mean square of the masses' distances the expansion means nothing, and
    /// is kept from growing.
    fn square(&self, r: T) -> T {
        let [a, b] = self.quadrupole;
        let mean = (a * a + b * b).sqrt() / self.mass.abs();
        (r * r).max(if mean.is_finite() { T::TWO * mean } else { T::ZERO })
    }

    /// `mass V(x - centre)`, V = log r / (2 pi) or -K0(k r) / (2 pi): (3.10) with the sign of V * rho; with second moments
    /// Q = sum m z^2, z = x + i y, the next term of the expansion of sum m log(z - z_j), -Re(Q / z^2) / 2.
    pub fn potential(&self, x: [T; 2]) -> T {
        let (d, r) = self.distance(x);
        let v = if self.screening > T::ZERO { -unscaled(self.screening * r, k0_scaled) } else { r.log() };
        let mut sum = self.mass * v;
        let [a, b] = self.quadrupole;
        if a != T::ZERO || b != T::ZERO {
            let r2 = self.square(r);
            sum -= T::HALF * (a * (d[0] * d[0] - d[1] * d[1]) + b * T::TWO * d[0] * d[1]) / (r2 * r2);
        }
        sum / (T::TWO * T::PI)
    }

    /// The gradient of [`Monopole::potential`]: (3.8).
    pub fn gradient(&self, x: [T; 2]) -> [T; 2] {
        let (d, r) = self.distance(x);
        let k = self.screening;
        // V' / r
        let slope = if k > T::ZERO { k * unscaled(k * r, k1_scaled) / r } else { T::ONE / (r * r) };
        let factor = self.mass * slope;
        let mut sum = [factor * d[0], factor * d[1]];
        let [a, b] = self.quadrupole;
        if a != T::ZERO || b != T::ZERO {
            // conj(Q / z^3) = conj(Q) z^3 / r^6
            let r2 = self.square(r);
            let (x2, y2) = (d[0] * d[0], d[1] * d[1]);
            let three = T::from_f64(3.0);
            let (re, im) = (d[0] * (x2 - three * y2), d[1] * (three * x2 - y2));
            let per = T::ONE / (r2 * r2 * r2);
            sum = [sum[0] + (a * re + b * im) * per, sum[1] + (a * im - b * re) * per];
        }
        sum.map(|g| g / (T::TWO * T::PI))
    }
}

/// e^-x times the scaled function; 0 where that is below the scalar's range, whatever the function's own range is.
fn unscaled<T: Real>(x: T, scaled: impl Fn(T) -> T) -> T {
    let decay = (-x).exp();
    if decay > T::ZERO { decay * scaled(x) } else { T::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_moments_are_the_next_term_of_the_sum_over_all_masses() {
        let masses = [(0.3_f64, [0.2, -0.1]), (0.5, [-0.15, 0.3]), (0.2, [0.05, 0.25])];
        let total: f64 = masses.iter().map(|(m, _)| m).sum();
        let centre = [0, 1].map(|k| masses.iter().map(|(m, x)| m * x[k]).sum::<f64>() / total);
        let about = masses.map(|(m, x)| (m, [x[0] - centre[0], x[1] - centre[1]]));
        let sum = |f: fn([f64; 2]) -> f64| about.iter().map(|&(m, x)| m * f(x)).sum::<f64>();
        let quadrupole = [sum(|[x, y]| x * x - y * y), sum(|[x, y]| 2.0 * x * y)];
        let field = Monopole { mass: total, centre, screening: 0.0, floor: 0.01, quadrupole };
        let error = |distance: f64| {
            (0..12).fold([0.0_f64; 2], |[of_u, of_g], k| {
                let (sin, cos) = (f64::from(k) * 0.52).sin_cos();
                let at = [centre[0] + distance * cos, centre[1] + distance * sin];
                let (mut u, mut g) = (0.0, [0.0; 2]);
                for (m, x) in masses {
                    let d = [at[0] - x[0], at[1] - x[1]];
                    let r2 = d[0] * d[0] + d[1] * d[1];
                    u += m * 0.5 * r2.ln() / (2.0 * core::f64::consts::PI);
                    g = [0, 1].map(|k| g[k] + m * d[k] / r2 / (2.0 * core::f64::consts::PI));
                }
                let got = field.gradient(at);
                [of_u.max((field.potential(at) - u).abs()), of_g.max((got[0] - g[0]).hypot(got[1] - g[1]))]
            })
        };
        // What is left begins with the third moments: 1/r^3 in the potential, 1/r^4 in its gradient.
        let ([u, g], [u2, g2]) = (error(4.0), error(8.0));
        assert!((6.0..10.0).contains(&(u / u2)) && (12.0..20.0).contains(&(g / g2)), "{u:e} {u2:e} {g:e} {g2:e}");
        assert!(u < 1e-4, "{u:e}");
    }
}
