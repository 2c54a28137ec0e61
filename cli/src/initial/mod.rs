//! Initial data: from a scene's parts to particles.
//!
//! [`sample`] turns densities into particles on a grid or at random; points of the user's own are read as they are.

use std::path::Path;

use anyhow::Result;

use crate::particles::Particles;
use crate::points;
use crate::scene::{Density, Model, Sampling, Scene, Shape};

mod sample;

pub use sample::{about, diffusion};

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
            Shape::File(path, _) => start.notes.extend(points::read(&folder.join(path), index, particles)?),
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
