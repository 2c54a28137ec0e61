//! Initial data: from a scene's parts to particles.
//!
//! [`density`] knows the papers' shapes and their integrals, [`sample`] turns them into particles on a grid or at random,
//! [`mod@file`] reads a user's own points, [`exact`] knows how some of them move.

use std::path::Path;

use anyhow::Result;

use crate::scene::{Sampling, Scene, Shape};

mod density;
pub mod exact;
mod file;
mod sample;

pub use density::Density;
pub use sample::diffusion;

/// Particles as arrays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// Dimensions of space.
    pub dimension: usize,
    /// Coordinates, particle by particle.
    pub positions: Vec<f64>,
    /// Masses.
    pub masses: Vec<f64>,
    /// Densities at the particles; 0 where a file gives none.
    pub densities: Vec<f64>,
    /// The part of the initial data that each belongs to.
    pub parts: Vec<u8>,
}

impl Particles {
    /// Their number.
    pub fn len(&self) -> usize {
        self.masses.len()
    }

    fn push(&mut self, position: &[f64], mass: f64, density: f64, part: usize) {
        self.positions.extend_from_slice(position);
        self.masses.push(mass);
        self.densities.push(density);
        self.parts.push(part as u8);
    }
}

/// The particles of a scene, with `h` in place of the scene's own spacing if given. Paths are relative to `folder`.
pub fn particles(scene: &Scene, h: Option<f64>, folder: &Path) -> Result<Particles> {
    let mut particles = Particles { dimension: scene.dimension, ..Particles::default() };
    let shares = sample::shares(scene)?;
    for (index, part) in scene.initial.iter().enumerate() {
        match &part.shape {
            Shape::Points(points, masses) => {
                for (point, &mass) in points.iter().zip(masses) {
                    particles.push(point, mass, 0.0, index);
                }
            }
            Shape::File(path, _) => file::read(&folder.join(path), index, &mut particles)?,
            _ => {
                let density = Density::new(part, scene.dimension);
                match scene.sampling {
                    Some(Sampling::Random { .. }) => {
                        let (count, mass) = shares[index];
                        sample::random(&density, count, mass, index, scene.seed, &mut particles)?;
                    }
                    Some(Sampling::Grid { h: own }) => sample::grid(&density, h.unwrap_or(own), index, &mut particles)?,
                    None => anyhow::bail!("initial[{index}]: a density needs sampling"),
                }
            }
        }
    }
    anyhow::ensure!(particles.len() > 0, "there is no particle: the grid is coarser than the support");
    Ok(particles)
}
