//! The field of all mass at its centre, with or without its second moments: Dirichlet data, and the drift outside the mesh.

use crate::real::{Real, length, quotient};
use crate::special::bessel::{k0_scaled, k1_scaled};
use crate::special::elementary::{euler, log_2};

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
    /// [sum m (x^2 - y^2), sum 2 m x y] about the centre, of what is inside the mesh, in units of mass times `reach`^2; 0 unless the
    /// border takes them ([`super::Walls::FreeQuadrupole`]).
    pub quadrupole: [T; 2],
    /// A power of two, the unit of length of `quadrupole`: at least the mesh's sides, of which not even the square need be in the range.
    pub reach: T,
}

/// Where a point is, seen from the centre, in units of length of its own.
struct Seen<T> {
    /// The difference of the coordinates.
    d: [T; 2],
    /// The distance, at least the floor; from 1 to 3.
    r: T,
    /// The unit is 2 to this power.
    exponent: i32,
}

impl<T: Real> Monopole<T> {
    fn see(&self, x: [T; 2]) -> Seen<T> {
        // Halves, which don't overflow. No bit is lost but below the smallest normal number, of which the floor is at least the half.
        let half = |x: T, c: T| x * T::HALF - c * T::HALF;
        let (d, floor) = ([half(x[0], self.centre[0]), half(x[1], self.centre[1])], self.floor * T::HALF);
        let exponent = d[0].abs().max(d[1].abs()).max(floor).frexp().1 - 1;
        let d = d.map(|d| d.ldexp(-exponent));
        let r = (d[0] * d[0] + d[1] * d[1]).sqrt().max(floor.ldexp(-exponent));
        Seen { d, r, exponent: exponent + 1 }
    }

    /// The distance that the second moments see, in the units of `seen`: nearer than the root mean square of the masses' distances the
    /// expansion means nothing, and is kept from growing.
    fn limited(&self, seen: &Seen<T>) -> T {
        let safe = if self.mass == T::ZERO { T::ONE } else { self.mass.abs() };
        let mean = length(&self.quadrupole) / safe;
        let limits = self.mass != T::ZERO && mean.is_finite();
        let least = (T::TWO * if limits { mean } else { T::ZERO }).sqrt();
        seen.r.max(least * self.reach.ldexp(-seen.exponent))
    }

    /// `mass V(x - centre)`, V = log r / (2 pi) or -K0(k r) / (2 pi): (3.10) with the sign of V * rho; with second moments
    /// Q = sum m z^2, z = x + i y, the next term of the expansion of sum m log(z - z_j), -Re(Q / z^2) / 2.
    pub fn potential(&self, x: [T; 2]) -> T {
        let seen = self.see(x);
        let r = seen.r.ldexp(seen.exponent);
        let k = self.screening;
        let v = if k > T::ZERO { -screened(k, r) } else { r.log() };
        let mut sum = self.mass * v;
        let [a, b] = self.quadrupole;
        if a != T::ZERO || b != T::ZERO {
            let r = self.limited(&seen);
            let [x, y] = seen.d.map(|d| quotient(d, r));
            let s = self.reach.ldexp(-seen.exponent) / r;
            sum -= T::HALF * (a * (x * x - y * y) + b * T::TWO * x * y) * (s * s);
        }
        sum / (T::TWO * T::PI)
    }

    /// The gradient of [`Monopole::potential`]: (3.8).
    pub fn gradient(&self, x: [T; 2]) -> [T; 2] {
        let seen = self.see(x);
        let Seen { d, r, exponent } = seen;
        let k = self.screening;
        // V' r, which is 1 without screening.
        let pull = if k > T::ZERO { unscaled(k * r.ldexp(exponent), product) } else { T::ONE };
        let factor = self.mass * (pull / (r * r));
        let mut sum = [factor * d[0], factor * d[1]];
        let [a, b] = self.quadrupole;
        if a != T::ZERO || b != T::ZERO {
            // conj(Q / z^3) = conj(Q) z^3 / r^6
            let r = self.limited(&seen);
            let [x, y] = d.map(|d| quotient(d, r));
            let (x2, y2, three) = (x * x, y * y, T::from_i32(3));
            let (re, im) = (x * (x2 - three * y2), y * (three * x2 - y2));
            let s = self.reach.ldexp(-exponent) / r;
            let per = s * s / r;
            sum = [sum[0] + (a * re + b * im) * per, sum[1] + (a * im - b * re) * per];
        }
        sum.map(|g| quotient(g, T::TWO * T::PI).ldexp(-exponent))
    }
}

/// K0(k r).
fn screened<T: Real>(k: T, r: T) -> T {
    let x = k * r;
    if x < T::EPSILON {
        // -log(x / 2) - gamma; the product may be below the range.
        return (log_2::<T>().hi - euler::<T>().hi) - (k.log() + r.log());
    }
    unscaled(x, k0_scaled)
}

/// e^x x K1(x), which is 1 at x = 0.
fn product<T: Real>(x: T) -> T {
    if x < T::EPSILON { T::ONE } else { x * k1_scaled(x) }
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
        let reach = 8.0;
        let quadrupole = quadrupole.map(|q| q / (reach * reach));
        let field = Monopole { mass: total, centre, screening: 0.0, floor: 0.01, quadrupole, reach };
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

    /// Of a circle of half a unit about the origin: value and gradient at distance r.
    fn at<T: Real>(field: &Monopole<T>, angle: f64, r: T) -> (f64, [f64; 2]) {
        let (sin, cos) = angle.sin_cos();
        let x = [cos, sin].map(|c| T::from_f64(c) * r);
        // The gradient in units of mass / r.
        (field.potential(x).to_f64(), field.gradient(x).map(|g| (g * r).to_f64()))
    }

    /// The same field in other units of length: log r changes by the unit's logarithm, everything else scales.
    fn scales<T: Real>(exponents: impl Iterator<Item = i32>) {
        let of = |x: f64, e: i32| T::from_f64(x).ldexp(e);
        let field = |e: i32, screening: f64| Monopole::<T> {
            mass: T::from_f64(0.7),
            centre: [T::ZERO; 2],
            screening: of(screening, -e),
            floor: of(0.125, e),
            quadrupole: if screening > 0.0 { [T::ZERO; 2] } else { [T::from_f64(0.03), T::from_f64(-0.05)] },
            reach: of(2.0, e),
        };
        let u = T::EPSILON.to_f64();
        for e in exponents {
            for screening in [0.0, 0.3] {
                for r in [0.5, 1.0, 3.0] {
                    let (u0, g0) = at(&field(0, screening), 0.7, T::from_f64(r));
                    let (u1, g1) = at(&field(e, screening), 0.7, of(r, e));
                    let log = if screening > 0.0 { 0.0 } else { f64::from(e) * core::f64::consts::LN_2 };
                    let want = u0 + 0.7 * log / (2.0 * core::f64::consts::PI);
                    // A logarithm of |log r| <= 710 and some ten roundings; gradients are the same to the bit but for x's rounding.
                    assert!((u1 - want).abs() <= 16.0 * u * (1.0 + log.abs()), "{e} {screening} {r}: {u1} {want}");
                    for k in 0..2 {
                        assert!((g1[k] - g0[k]).abs() <= 16.0 * u, "{e} {screening} {r}: {g1:?} {g0:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn no_length_is_too_long_or_too_short() {
        scales::<f64>((-1010..=1010).step_by(10));
        scales::<f32>((-115..=115).step_by(5));
    }

    #[test]
    fn a_vanishing_screening_is_the_logarithm() {
        // K0(x) = -log(x / 2) - gamma to rounding, also where k r has no number: k = 1e-300, r = 1e-100.
        let field = Monopole {
            mass: 1.0,
            centre: [0.0; 2],
            screening: 1e-300,
            floor: 1e-200,
            quadrupole: [0.0; 2],
            reach: 1.0,
        };
        let r = 1e-100_f64;
        let want = (400.0 * core::f64::consts::LN_10 + core::f64::consts::LN_2 - 0.577_215_664_901_532_9)
            / -core::f64::consts::TAU;
        assert!((field.potential([r, 0.0]) / want - 1.0).abs() < 1e-15);
        assert!((field.gradient([r, 0.0])[0] * r * core::f64::consts::TAU - 1.0).abs() < 1e-15);
    }
}
