//! Exact solutions: under a Newtonian kernel one round part, one ellipse of vortices, or two particles; Barenblatt's under diffusion alone.

use mollis_core::exact::radial::{self, Bump};
use mollis_core::exact::vortex::{self, Flow};

use super::density::Density;
use super::types::{Diffusion, Law, Part, Scene, Shape};

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
    /// A round part that is Barenblatt's profile of its diffusion at the time `age`: distances grow like t^rate.
    Spreading { age: f64, rate: f64, center: Vec<f64>, density: Density },
    /// Two particles in the plane.
    Pair { points: [[f64; 2]; 2], masses: [f64; 2] },
}

impl Exact {
    /// The solution of a scene, if it has one in closed form.
    pub fn of(scene: &Scene) -> Option<Self> {
        let ([term], [part]) = (scene.kernel.as_slice(), scene.initial.as_slice()) else { return None };
        if let Some(diffusion) = &scene.diffusion {
            let motion = Motion::spreading(part, diffusion, scene.dimension).filter(|_| term.coefficient == 0.0)?;
            return Some(Self { flow: Flow { coefficient: 0.0, a: 1.0, b: 0.0 }, motion });
        }
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
            Motion::Spreading { age, rate, center, .. } => {
                let factor = (1.0 + t / age).powf(*rate);
                start.iter().zip(center).map(|(x, c)| c + factor * (x - c)).collect()
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
            Motion::Spreading { age, rate, density, center } => {
                let stretch = (1.0 + t / age).powf(*rate);
                density.at(start).unwrap_or(0.0) * stretch.powi(-(center.len() as i32))
            }
            Motion::Pair { .. } => f64::NAN,
        }
    }

    /// When the first particles meet; infinity if they never do.
    pub fn blow_up(&self) -> f64 {
        match &self.motion {
            Motion::Round { density, .. } => radial::blow_up_time(self.attraction(), density.maximum()),
            Motion::Ellipse { .. } | Motion::Spreading { .. } => f64::INFINITY,
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

    /// For m = 1 + 1/k: `rho^(m-1) = height^(m-1) (1 - r^2 / radius^2)` with `height^(m-1) / radius^2 = rate (m-1) / (2 m nu age)`.
    fn spreading(part: &Part, diffusion: &Diffusion, dimension: usize) -> Option<Self> {
        let Shape::Polynomial(k @ 1..) = part.shape else { return None };
        let m = 1.0 + 1.0 / f64::from(k);
        let (&radius, others) = part.axes.split_first()?;
        if others.iter().any(|&axis| axis != radius) || (diffusion.exponent - m).abs() > 1e-9 {
            return None;
        }
        let density = Density::new(part, dimension);
        let rate = 1.0 / (dimension as f64 * (m - 1.0) + 2.0);
        let curvature = density.maximum().powf(m - 1.0) / (radius * radius);
        let age = rate * (m - 1.0) / (2.0 * m * diffusion.coefficient * curvature);
        Some(Self::Spreading { age, rate, center: part.center.clone(), density })
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

#[cfg(test)]
mod tests {
    use super::super::read::parse;
    use super::*;

    fn exact(combination: &str, initial: &str) -> Option<Exact> {
        let text = format!(
            "title = \"t\"\nmodel = \"blob\"\ndimension = 2\ncombination = {combination}\n\
             [[kernel]]\nkind = \"newtonian\"\ncoefficient = 0.8\n[mollifier]\nkind = \"compact\"\norder = 4\n\
             delta = 0.1\n[[initial]]\n{initial}\n[sampling]\nkind = \"grid\"\nh = 0.1\n[time]\nend = 1\ndt = 0.5\n"
        );
        parse(&text, false, &|_, _| Ok(false)).unwrap().cases[0].exact()
    }

    /// Velocities by central differences are those of the gradients that are known.
    #[test]
    fn paths_follow_the_velocity() {
        let (t, dt) = (0.4, 1e-5);
        let rate = |exact: &Exact, start: &[f64]| -> [f64; 2] {
            let (after, before) = (exact.position(start, t + dt), exact.position(start, t - dt));
            [0, 1].map(|k| (after[k] - before[k]) / (2.0 * dt))
        };
        let close = |got: [f64; 2], want: [f64; 2]| {
            assert!((got[0] - want[0]).hypot(got[1] - want[1]) < 1e-7, "{got:?} {want:?}");
        };
        for (a, b) in [(1.0, 0.0), (0.0, -1.0), (0.5, 2.0), (-1.0, 0.25)] {
            let combination = format!("[{a:?}, {b:?}]");
            // A disc of density r: grad u = c r x / 2, with the density along the trajectory.
            let disc = exact(&combination, "shape = \"disc\"\nheight = 1.5\ncenter = [0.3, -0.2]").unwrap();
            let start = [0.6, 0.1];
            let (at, r) = (disc.position(&start, t), disc.density(&start, t));
            let (x, y) = (at[0] - 0.3, at[1] + 0.2);
            let factor = -0.4 * r;
            close(rate(&disc, &start), [factor * (a * x - b * y), factor * (a * y + b * x)]);
            assert_eq!(disc.blow_up(), if a > 0.0 { 1.0 / (0.8 * a * 1.5) } else { f64::INFINITY });
            // Two points of equal masses.
            let given = "shape = \"points\"\npoints = [[0.5, 0], [-0.5, 0.5]]\nmasses = [2, 2]";
            let pair = exact(&combination, given).unwrap();
            let [first, second] = [[0.5, 0.0], [-0.5, 0.5]].map(|start| pair.position(&start, t));
            let (x, y) = (first[0] - second[0], first[1] - second[1]);
            let factor = -0.8 * 2.0 / (2.0 * std::f64::consts::PI * (x * x + y * y));
            close(rate(&pair, &[0.5, 0.0]), [factor * (a * x - b * y), factor * (a * y + b * x)]);
            close(rate(&pair, &[-0.5, 0.5]), [-factor * (a * x - b * y), -factor * (a * y + b * x)]);
            let blow_up = 1.25 * std::f64::consts::PI / (0.8 * 4.0 * a);
            assert!(if a > 0.0 {
                (pair.blow_up() / blow_up - 1.0).abs() < 1e-14
            } else {
                pair.blow_up().is_infinite()
            });
            // An ellipse is known if nothing attracts.
            let ellipse = exact(&combination, "shape = \"ellipse\"\naxes = [1, 0.5]\nheight = 1.5");
            assert_eq!(ellipse.is_some(), a == 0.0);
        }
        // On the long axis, at the start: v = -b c rho q x / (p + q), across.
        let ellipse = exact("[0, -1]", "shape = \"ellipse\"\naxes = [1, 0.5]\nheight = 1.5").unwrap();
        let after = ellipse.position(&[0.8, 0.0], 1e-6);
        assert!(
            (after[1] / 1e-6 - 0.8 * 1.5 * 0.5 * 0.8 / 1.5).abs() < 1e-5 && ellipse.density(&[0.8, 0.0], 1.0) == 1.5
        );
        assert!(exact("[0, -1]", "shape = \"points\"\npoints = [[1, 0], [1, 0]]\nmasses = [1, 1]").is_none());
    }
}
