//! The field of all mass at its centre, optionally with second moments: Dirichlet data, and the gradient outside the mesh.

use crate::real::{Real, length, quotient};
use crate::special::bessel::{k0_scaled, k1_scaled};
use crate::special::elementary::{euler, log_2};

/// The field of `mass` at `centre`, with the kernel of the equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monopole<T> {
    /// The total mass, including that outside the mesh.
    pub mass: T,
    /// Its centre.
    pub centre: [T; 2],
    /// The kernel's k; 0 for the Newtonian kernel.
    pub screening: T,
    /// At smaller distances the field is the one at this distance, so it is finite everywhere.
    pub floor: T,
    /// [sum m (x^2 - y^2), sum 2 m x y] of the mass inside the mesh, about the centre, in units of mass times `reach`^2. 0 except
    /// for [`super::Walls::FreeQuadrupole`].
    pub quadrupole: [T; 2],
    /// The length unit of `quadrupole`: a power of two, at least the sides of the mesh. The square of a side may be out of range.
    pub reach: T,
}

/// The offset of a point from the centre, in a length unit chosen for this point.
struct Offset<T> {
    /// The difference of the coordinates.
    d: [T; 2],
    /// The distance, at least `floor`; between 1 and 3.
    r: T,
    /// The unit is 2 to this power.
    exponent: i32,
}

impl<T: Real> Monopole<T> {
    fn offset(&self, x: [T; 2]) -> Offset<T> {
        // Halves do not overflow. Only bits below the smallest normal number are lost, and `floor` is at least half of that number.
        let half = |x: T, c: T| x * T::HALF - c * T::HALF;
        let (d, floor) = ([half(x[0], self.centre[0]), half(x[1], self.centre[1])], self.floor * T::HALF);
        let exponent = d[0].abs().max(d[1].abs()).max(floor).frexp().1 - 1;
        let d = d.map(|d| d.ldexp(-exponent));
        let r = (d[0] * d[0] + d[1] * d[1]).sqrt().max(floor.ldexp(-exponent));
        Offset { d, r, exponent: exponent + 1 }
    }

    /// The distance for the second moments, in the unit of `offset`. At less than the root mean square distance of the masses the
    /// expansion is not valid, so smaller distances are replaced by that one.
    fn limited(&self, offset: &Offset<T>) -> T {
        let safe = if self.mass == T::ZERO { T::ONE } else { self.mass.abs() };
        let mean = length(&self.quadrupole) / safe;
        let limits = self.mass != T::ZERO && mean.is_finite();
        let least = (T::TWO * if limits { mean } else { T::ZERO }).sqrt();
        offset.r.max(least * self.reach.ldexp(-offset.exponent))
    }

    /// `mass V(x - centre)`, V = log r / (2 pi) or -K0(k r) / (2 pi): (3.10) with the sign of V * rho. With second moments
    /// Q = sum m z^2, z = x + i y, the next term of the expansion of sum m log(z - z_j) is added: -Re(Q / z^2) / 2.
    pub fn potential(&self, x: [T; 2]) -> T {
        let offset = self.offset(x);
        let r = offset.r.ldexp(offset.exponent);
        let k = self.screening;
        let v = if k > T::ZERO { -screened(k, r) } else { r.log() };
        let mut sum = self.mass * v;
        let [a, b] = self.quadrupole;
        if a != T::ZERO || b != T::ZERO {
            let r = self.limited(&offset);
            let [x, y] = offset.d.map(|d| quotient(d, r));
            let s = self.reach.ldexp(-offset.exponent) / r;
            sum -= T::HALF * (a * (x * x - y * y) + b * T::TWO * x * y) * (s * s);
        }
        sum / (T::TWO * T::PI)
    }

    /// The gradient of [`Monopole::potential`]: (3.8).
    pub fn gradient(&self, x: [T; 2]) -> [T; 2] {
        let offset = self.offset(x);
        let Offset { d, r, exponent } = offset;
        let k = self.screening;
        // V' r; 1 without screening.
        let pull = if k > T::ZERO { unscaled(k * r.ldexp(exponent), product) } else { T::ONE };
        let factor = self.mass * (pull / (r * r));
        let mut sum = [factor * d[0], factor * d[1]];
        let [a, b] = self.quadrupole;
        if a != T::ZERO || b != T::ZERO {
            // conj(Q / z^3) = conj(Q) z^3 / r^6
            let r = self.limited(&offset);
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
        // -log(x / 2) - gamma. The product k r may be below the range.
        return (log_2::<T>().hi - euler::<T>().hi) - (k.log() + r.log());
    }
    unscaled(x, k0_scaled)
}

/// e^x x K1(x), which is 1 at x = 0.
fn product<T: Real>(x: T) -> T {
    if x < T::EPSILON { T::ONE } else { x * k1_scaled(x) }
}

/// e^-x times the scaled function; 0 where that is below the scalar's range, whatever the range of the function.
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
        // The remainder begins with the third moments: 1/r^3 in the potential, 1/r^4 in its gradient.
        let ([u, g], [u2, g2]) = (error(4.0), error(8.0));
        assert!((6.0..10.0).contains(&(u / u2)) && (12.0..20.0).contains(&(g / g2)), "{u:e} {u2:e} {g:e} {g2:e}");
        assert!(u < 1e-4, "{u:e}");
    }

    /// Value and gradient at distance r from the origin, in direction `angle`.
    fn at<T: Real>(field: &Monopole<T>, angle: f64, r: T) -> (f64, [f64; 2]) {
        let (sin, cos) = angle.sin_cos();
        let x = [cos, sin].map(|c| T::from_f64(c) * r);
        // The gradient in units of mass / r.
        (field.potential(x).to_f64(), field.gradient(x).map(|g| (g * r).to_f64()))
    }

    /// The same field in other length units: log r changes by the logarithm of the unit, everything else scales.
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
                    // A logarithm of |log r| <= 710 and about ten roundings. Gradients agree to the bit except for the rounding of x.
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
        // K0(x) = -log(x / 2) - gamma to rounding, also where k r underflows: k = 1e-300, r = 1e-100.
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
