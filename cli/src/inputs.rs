//! What users write, read without running anything: for checks with arbitrary bytes.

use std::path::Path;

use crate::particles::Particles;
use crate::{points, scene};

/// Reads a scene from a text; files that it names are taken to hold no densities. Gives the number of its cases.
///
/// # Errors
/// Each mistake with its line, from 1.
pub fn scene(text: &str, quick: bool) -> Result<usize, Vec<(usize, String)>> {
    let file = scene::parse(text, quick, &|_, _| Ok(false))
        .map_err(|list| list.into_iter().map(|mistake| (mistake.line, mistake.text)).collect::<Vec<_>>())?;
    for case in &file.cases {
        // The columns of a run rest on all that was read.
        assert!(!case.columns().is_empty());
    }
    Ok(file.cases.len())
}

/// Reads a file of points for so many dimensions. Gives coordinates, masses, and densities (NaN: none), and whether the file's head promised these.
///
/// # Errors
/// A sentence that begins with the path.
pub fn points(path: &Path, dimension: usize) -> anyhow::Result<([Vec<f64>; 3], bool)> {
    let promised = points::has_density(path, dimension);
    let mut particles = Particles { dimension, ..Particles::default() };
    points::read(path, 0, &mut particles)?;
    Ok(([particles.positions, particles.masses, particles.densities], promised?))
}
