//! The blob method: sizes and runs.

#[cfg_attr(feature = "small", path = "no_gaps.rs")]
mod arrays;
pub(crate) mod call;
mod options;
mod particles;

pub use options::*;
pub use particles::ParticlesOf;
