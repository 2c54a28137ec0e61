//! Particles as a scene and its runs hold them.

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

    /// Adds one; without a density that is NaN.
    pub fn push(&mut self, position: &[f64], mass: f64, density: Option<f64>, part: usize) {
        self.positions.extend_from_slice(position);
        self.masses.push(mass);
        self.densities.push(density.unwrap_or(f64::NAN));
        self.parts.push(part as u8);
    }
}
