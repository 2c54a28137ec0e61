//! Exact motions in the plane under a Newtonian kernel whose gradient is partly or wholly turned: vortices.
//!
//! Particles move by `x' = -(a + b J) grad u`, with J the turn by +90 degrees, `u = sum_j m_j K(x - x_j)` and K = c log r / (2 pi)
//! ([`Options::combination`](crate::field::Options::combination)). (a, b) = (0, -1) and c = 1 are the Euler equations with circulations m and the
//! vorticity `Laplacian(u)`: Craig & Bertozzi (1.4). A mollifier of compact support changes none of this for points farther apart than its length.
//!
//! Source: Lamb, *Hydrodynamics*, 1932, sections 155 (pairs) and 159 (Kirchhoff's ellipse).

use crate::real::Real;

/// A velocity law: the kernel's coefficient and the combination (a, b).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow<T> {
    /// c of the kernel.
    pub coefficient: T,
    /// The share of the gradient.
    pub a: T,
    /// The share of the gradient turned by +90 degrees.
    pub b: T,
}

impl<T: Real> Flow<T> {
    /// The Euler equations: c = 1, (a, b) = (0, -1).
    #[must_use]
    pub fn euler() -> Self {
        Self { coefficient: T::ONE, a: T::ZERO, b: -T::ONE }
    }

    /// What becomes, after time `t`, of a vector of length `r` from the centre of a circularly symmetric mass to a point of it: the factor of its length, and the angle by
    /// which it turns counter-clockwise. `enclosed` is the mass within r. The factor is 0, and the angle too, once the point has reached the centre.
    ///
    /// `(r^2)' = -a c m / pi` and `angle' = -b c m / (2 pi r^2)`, hence `angle = (b / a) log(factor)`, or `-b c m t / (2 pi r^2)` for a = 0.
    #[must_use]
    pub fn about(&self, enclosed: T, r: T, t: T) -> [T; 2] {
        if r <= T::ZERO {
            return [T::ONE, T::ZERO];
        }
        let per_time = self.coefficient * enclosed / (T::PI * r * r);
        if self.a == T::ZERO {
            return [T::ONE, -T::HALF * self.b * per_time * t];
        }
        let lost = self.a * per_time * t;
        if lost >= T::ONE {
            return [T::ZERO, T::ZERO];
        }
        let logarithm = T::HALF * (-lost).log1p();
        [(T::ONE - lost).sqrt(), self.b / self.a * logarithm]
    }

    /// Where two particles are after time `t`. They turn about, approach or leave their centre of mass, which rests; masses of opposite sign and equal
    /// size move side by side. Not finite for two particles at one place.
    ///
    /// With d = x1 - x2 and M = m1 + m2, `d' = -(a + b J) c M d / (2 pi |d|^2)`.
    #[must_use]
    pub fn pair(&self, [x, y]: [[T; 2]; 2], [m, n]: [T; 2], t: T) -> [[T; 2]; 2] {
        let [dx, dy] = [x[0] - y[0], x[1] - y[1]];
        let whole = m + n;
        if whole == T::ZERO {
            // Both move with -(a + b J) c n d / (2 pi |d|^2).
            let factor = -self.coefficient * n * t / ((T::TWO * T::PI) * (dx * dx + dy * dy));
            let by = [factor * (self.a * dx - self.b * dy), factor * (self.a * dy + self.b * dx)];
            return [x, y].map(|[p, q]| [p + by[0], q + by[1]]);
        }
        let [factor, angle] = self.about(whole, (dx * dx + dy * dy).sqrt(), t);
        let turned = turn([factor * dx, factor * dy], angle);
        let centre = [(m * x[0] + n * y[0]) / whole, (m * x[1] + n * y[1]) / whole];
        let at = |share: T| [centre[0] + share * turned[0], centre[1] + share * turned[1]];
        [at(n / whole), at(-(m / whole))]
    }
}

/// The rate at which an ellipse of constant vorticity turns, in radians a unit of time: `vorticity p q / (p + q)^2` for half axes p and q.
#[must_use]
pub fn ellipse_rate<T: Real>(vorticity: T, axes: [T; 2]) -> T {
    let [p, q] = axes;
    vorticity * p * q / ((p + q) * (p + q))
}

/// Where a point within an ellipse of constant vorticity is after time `t`: Kirchhoff's solution. The ellipse has its centre at 0, and its half axes along the
/// coordinates at time 0. Within it the point goes around on a similar ellipse, at the rate at which the whole turns ([`ellipse_rate`]).
#[must_use]
pub fn ellipse<T: Real>(vorticity: T, axes: [T; 2], start: [T; 2], t: T) -> [T; 2] {
    let [p, q] = axes;
    let angle = ellipse_rate(vorticity, axes) * t;
    let [x, y] = turn([start[0] / p, start[1] / q], angle);
    turn([p * x, q * y], angle)
}

fn turn<T: Real>([x, y]: [T; 2], angle: T) -> [T; 2] {
    let (cosine, sine) = (angle.cos(), angle.sin());
    [cosine * x - sine * y, sine * x + cosine * y]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::real::Scalar;
    use core::f64::consts::PI;

    /// Velocities by central differences of the exact motions are those of the law.
    #[test]
    fn motions_have_the_velocities_of_the_law() {
        let (dt, t) = (1e-4, 0.3);
        let near = |got: f64, want: f64| assert!((got - want).abs() < 1e-7, "{got} {want}");
        for (a, b) in [(0.0, -1.0), (1.0, 0.0), (0.5, 2.0), (-0.3, 0.7)] {
            let flow = Flow { coefficient: 0.8, a, b };
            for masses in [[1.0, 0.5], [1.0, -1.0], [2.0, -0.5]] {
                let at = |t: f64| flow.pair([[0.3, 0.4], [-0.9, 0.1]], masses, t);
                let (now, before, after) = (at(t), at(t - dt), at(t + dt));
                for (i, j) in [(0, 1), (1, 0)] {
                    let d: [f64; 2] = [now[i][0] - now[j][0], now[i][1] - now[j][1]];
                    let factor = -0.8 * masses[j] / (2.0 * PI * (d[0] * d[0] + d[1] * d[1]));
                    near((after[i][0] - before[i][0]) / (2.0 * dt), factor * (a * d[0] - b * d[1]));
                    near((after[i][1] - before[i][1]) / (2.0 * dt), factor * (a * d[1] + b * d[0]));
                }
            }
        }
        // A single vortex of circulation 2 pi r^2 turns a point of its edge once a unit of time and radian, counter-clockwise.
        let [factor, angle] = Flow::<f64>::euler().about(2.0 * PI * 0.25, 0.5, 1.0);
        assert!(factor == 1.0 && (angle - 1.0).abs() < 1e-15);
        assert_eq!(Flow { coefficient: 1.0, a: 1.0, b: 1.0 }.about(PI, 1.0, 1.0), [0.0, 0.0]);
        assert_eq!(Flow::<f64>::euler().about(1.0, 0.0, 1.0), [1.0, 0.0]);
    }

    /// In axes along the ellipse the velocity is w (-p y, q x) / (p + q).
    #[test]
    fn points_of_an_ellipse_have_kirchhoffs_velocity() {
        let (axes, w, start, dt, t) = ([1.5, 0.4], 0.7, [0.6, -0.2], 1e-4, 2.1);
        let at = |t: f64| ellipse(w, axes, start, t);
        let along = turn(at(t), -ellipse_rate(w, axes) * t);
        let want = turn([-w * 1.5 * along[1] / 1.9, w * 0.4 * along[0] / 1.9], ellipse_rate(w, axes) * t);
        for k in 0..2 {
            let rate = (at(t + dt)[k] - at(t - dt)[k]) / (2.0 * dt);
            assert!(Scalar::abs(rate - want[k]) < 1e-8, "{rate} {want:?}");
        }
        // A circle turns at half its vorticity, as a point and as a whole each a half of that.
        let quarter = ellipse(1.0, [1.0, 1.0], [1.0, 0.0], PI);
        assert!(quarter[0].abs() < 1e-15 && (quarter[1] - 1.0).abs() < 1e-15);
    }
}
