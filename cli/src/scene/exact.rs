//! Exact solutions under a Newtonian kernel: one round part, one ellipse of vortices, or two particles.

use mollis_core::exact::radial::{self, Bump};
use mollis_core::exact::vortex::{self, Flow};

use super::density::Density;
use super::types::{Law, Part, Scene, Shape};

/// How the particles of a scene move, if that is known in closed form.
#[derive(Clone, Debug)]
pub struct Exact {
    flow: Flow<f64>,
    motion: Motion,
}

#[derive(Clone, Debug)]
enum Motion {
    /// A radial density: Craig & Bertozzi, section 4.1; its particles also turn if part of the gradient is turned.
    Round { bump: Bump<f64>, center: Vec<f64>, density: Density },
    /// An ellipse of constant density under a turned gradient: Kirchhoff's.
    Ellipse { axes: [f64; 2], center: [f64; 2], density: f64 },
    /// Two particles in the plane.
    Pair { points: [[f64; 2]; 2], masses: [f64; 2] },
}

impl Exact {
    /// The solution of a scene, if it has one in closed form.
    pub fn of(scene: &Scene) -> Option<Self> {
        let ([term], [part]) = (scene.kernel.as_slice(), scene.initial.as_slice()) else { return None };
        if term.law != Law::Newtonian {
            return None;
        }
        let [a, b] = scene.combination;
        let flow = Flow { coefficient: term.coefficient, a, b };
        let motion = match part.shape {
            Shape::Polynomial(k) => Motion::round(part, k, scene.dimension)?,
            Shape::Flat => Motion::round(part, 0, scene.dimension).or_else(|| Motion::ellipse(part, a))?,
            Shape::Points(ref points, ref masses) => Motion::pair(points, masses)?,
            _ => return None,
        };
        Some(Self { flow, motion })
    }

    /// Where the particle that starts at `start` is at time `t`.
    pub fn position(&self, start: &[f64], t: f64) -> Vec<f64> {
        match &self.motion {
            Motion::Round { bump, center, .. } => {
                let away: Vec<f64> = start.iter().zip(center).map(|(x, c)| x - c).collect();
                let factor = self.factor(bump, &away, t);
                let mut moved: Vec<f64> = away.iter().map(|x| factor * x).collect();
                if let ([x, y], true) = (moved.as_mut_slice(), self.flow.b != 0.0) {
                    let r = away[0].hypot(away[1]);
                    let [_, angle] = self.flow.about(bump.enclosed_mass::<2>(r), r, t);
                    let (sine, cosine) = angle.sin_cos();
                    (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
                }
                moved.iter().zip(center).map(|(x, c)| c + x).collect()
            }
            Motion::Ellipse { axes, center, density } => {
                let vorticity = -self.flow.b * self.flow.coefficient * density;
                let [x, y] = vortex::ellipse(vorticity, *axes, [start[0] - center[0], start[1] - center[1]], t);
                vec![x + center[0], y + center[1]]
            }
            Motion::Pair { points, masses } => {
                let which = usize::from(start != points[0]);
                self.flow.pair(*points, *masses, t)[which].to_vec()
            }
        }
    }

    /// The density at the particle that started at `start`; not a number for particles without one.
    pub fn density(&self, start: &[f64], t: f64) -> f64 {
        match &self.motion {
            Motion::Round { density, .. } => {
                radial::density_along(self.attraction(), density.at(start).unwrap_or(0.0), t)
            }
            Motion::Ellipse { density, .. } => *density,
            Motion::Pair { .. } => f64::NAN,
        }
    }

    /// When the first particles meet; infinity if they never do.
    pub fn blow_up(&self) -> f64 {
        match &self.motion {
            Motion::Round { density, .. } => radial::blow_up_time(self.attraction(), density.maximum()),
            Motion::Ellipse { .. } => f64::INFINITY,
            // The square of the distance falls by a c (m + n) / pi a unit of time.
            Motion::Pair { points: [x, y], masses: [m, n] } => {
                let square = (x[0] - y[0]).powi(2) + (x[1] - y[1]).powi(2);
                let rate = self.attraction() * (m + n) / std::f64::consts::PI;
                if rate > 0.0 { square / rate } else { f64::INFINITY }
            }
        }
    }

    /// The coefficient of the part of the velocity that is a gradient.
    fn attraction(&self) -> f64 {
        self.flow.a * self.flow.coefficient
    }

    fn factor(&self, bump: &Bump<f64>, away: &[f64], t: f64) -> f64 {
        let r = away.iter().map(|x| x * x).sum::<f64>().sqrt();
        let coefficient = self.attraction();
        match away.len() {
            1 => radial::contraction::<f64, 1>(coefficient, bump.enclosed_mass::<1>(r), r, t),
            2 => radial::contraction::<f64, 2>(coefficient, bump.enclosed_mass::<2>(r), r, t),
            _ => radial::contraction::<f64, 3>(coefficient, bump.enclosed_mass::<3>(r), r, t),
        }
    }
}

impl Motion {
    fn round(part: &Part, k: u32, dimension: usize) -> Option<Self> {
        let (&radius, others) = part.axes.split_first()?;
        if others.iter().any(|&axis| axis != radius) {
            return None;
        }
        let density = Density::new(part, dimension);
        let bump = Bump::new(density.maximum(), radius, k).ok()?;
        Some(Self::Round { bump, center: part.center.clone(), density })
    }

    fn ellipse(part: &Part, a: f64) -> Option<Self> {
        let (&[p, q], &[x, y]) = (part.axes.as_slice(), part.center.as_slice()) else { return None };
        (a == 0.0).then(|| Self::Ellipse { axes: [p, q], center: [x, y], density: Density::new(part, 2).maximum() })
    }

    fn pair(points: &[Vec<f64>], masses: &[f64]) -> Option<Self> {
        let ([x, y], &[m, n]) = (points, masses) else { return None };
        let (&[x1, x2], &[y1, y2]) = (x.as_slice(), y.as_slice()) else { return None };
        (x != y).then_some(Self::Pair { points: [[x1, x2], [y1, y2]], masses: [m, n] })
    }
}
