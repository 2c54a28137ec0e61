//! Exact radial solutions: one round part under a Newtonian kernel.

use mollis_core::exact::radial::{self, Bump};

use super::density::Density;
use super::types::{Law, Scene, Shape};

/// How the particles of a radial density move under a Newtonian kernel: Craig & Bertozzi, section 4.1.
#[derive(Clone, Debug)]
pub struct Exact {
    coefficient: f64,
    bump: Bump<f64>,
    center: Vec<f64>,
    density: Density,
}

impl Exact {
    /// The solution of a scene, if it has one in closed form.
    pub fn of(scene: &Scene) -> Option<Self> {
        let ([term], [part]) = (scene.kernel.as_slice(), scene.initial.as_slice()) else { return None };
        let k = match part.shape {
            Shape::Polynomial(k) => k,
            Shape::Flat => 0,
            _ => return None,
        };
        let (&radius, others) = part.axes.split_first()?;
        if term.law != Law::Newtonian || others.iter().any(|&axis| axis != radius) {
            return None;
        }
        let density = Density::new(part, scene.dimension);
        let bump = Bump::new(density.maximum(), radius, k).ok()?;
        Some(Self { coefficient: term.coefficient, bump, center: part.center.clone(), density })
    }

    /// Where the particle that starts at `start` is at time `t`.
    pub fn position(&self, start: &[f64], t: f64) -> Vec<f64> {
        let factor = self.factor(start, t);
        start.iter().zip(&self.center).map(|(x, c)| c + factor * (x - c)).collect()
    }

    /// The density at the particle that started at `start`.
    pub fn density(&self, start: &[f64], t: f64) -> f64 {
        radial::density_along(self.coefficient, self.density.at(start).unwrap_or(0.0), t)
    }

    /// When the first particles meet; infinity for a repulsive kernel.
    pub fn blow_up(&self) -> f64 {
        radial::blow_up_time(self.coefficient, self.density.maximum())
    }

    fn factor(&self, start: &[f64], t: f64) -> f64 {
        let r = start.iter().zip(&self.center).map(|(x, c)| (x - c) * (x - c)).sum::<f64>().sqrt();
        match start.len() {
            1 => radial::contraction::<f64, 1>(self.coefficient, self.bump.enclosed_mass::<1>(r), r, t),
            2 => radial::contraction::<f64, 2>(self.coefficient, self.bump.enclosed_mass::<2>(r), r, t),
            _ => radial::contraction::<f64, 3>(self.coefficient, self.bump.enclosed_mass::<3>(r), r, t),
        }
    }
}
