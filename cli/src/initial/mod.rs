//! Initial data: from a scene's parts to particles.
//!
//! [`density`] knows the papers' shapes and their integrals, [`sample`] turns them into particles on a grid or at random,
//! [`mod@file`] reads a user's own points, [`exact`] knows how some of them move.

use std::path::Path;

use anyhow::Result;

use crate::scene::{Model, Sampling, Scene, Shape};

mod density;
pub mod exact;
mod file;
mod sample;

pub use density::Density;
pub use file::has_density;
pub use sample::{about, diffusion};

/// Particles as arrays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// Dimensions of space.
    pub dimension: usize,
    /// Coordinates, particle by particle.
    pub positions: Vec<f64>,
    /// Masses.
    pub masses: Vec<f64>,
    /// Densities at the particles: NaN where initial data give none, empty where a run carries none.
    pub densities: Vec<f64>,
    /// The part of the initial data that each belongs to.
    pub parts: Vec<u8>,
}

impl Particles {
    /// Their number.
    pub fn len(&self) -> usize {
        self.masses.len()
    }

    fn push(&mut self, position: &[f64], mass: f64, density: Option<f64>, part: usize) {
        self.positions.extend_from_slice(position);
        self.masses.push(mass);
        self.densities.push(density.unwrap_or(f64::NAN));
        self.parts.push(part as u8);
    }
}

/// Initial data, with what a user should know about them.
#[derive(Clone, Debug, Default)]
pub struct Start {
    /// The particles.
    pub particles: Particles,
    /// A line each.
    pub notes: Vec<String>,
}

/// The particles of a scene, with `h` in place of the scene's own spacing if given. Paths are relative to `folder`.
pub fn particles(scene: &Scene, h: Option<f64>, folder: &Path) -> Result<Start> {
    sparse(scene, h, folder, 1.0)
}

/// As [`particles`], but only about `share` of those that are sampled, with all of the mass.
pub fn sparse(scene: &Scene, h: Option<f64>, folder: &Path, share: f64) -> Result<Start> {
    let mut start = Start::default();
    let particles = &mut start.particles;
    particles.dimension = scene.dimension;
    let shares = sample::shares(scene)?;
    let mut massless = 0;
    for (index, part) in scene.initial.iter().enumerate() {
        match &part.shape {
            Shape::Points(points, masses) => {
                for (point, &mass) in points.iter().zip(masses) {
                    particles.push(point, mass, None, index);
                }
            }
            Shape::File(path, _) => start.notes.extend(file::read(&folder.join(path), index, particles)?),
            _ => {
                let density = Density::new(part, scene.dimension);
                match scene.sampling {
                    Some(Sampling::Random { .. }) => {
                        let (count, mass) = shares[index];
                        let count = (count as f64 * share).ceil() as u64;
                        sample::random(&density, count, mass, index, scene.seed, particles)?;
                    }
                    Some(Sampling::Grid { h: own }) => {
                        let h = h.unwrap_or(own) * share.powf(-1.0 / scene.dimension as f64);
                        // Coalescing particles have a mass. Elsewhere points on the border of the support show where it is.
                        let keep = scene.model != Model::Pks;
                        massless += sample::grid(&density, h, index, keep, particles)?;
                    }
                    None => anyhow::bail!("initial[{index}]: a density needs sampling"),
                }
            }
        }
    }
    anyhow::ensure!(particles.len() > 0, "there is no particle: the grid is coarser than the support");
    if massless > 0 {
        start.notes.push(format!("skipped: {massless} points of the grid without mass"));
    }
    Ok(start)
}
