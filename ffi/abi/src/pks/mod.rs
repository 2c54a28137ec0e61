//! Coalescing particles: the size of the workspace, and the step.

#[cfg_attr(feature = "small", path = "no_meshes.rs")]
mod meshes;
mod options;
pub(crate) mod step;
mod theory;

pub use options::*;
pub use step::PksParticlesOf;
pub use theory::*;
