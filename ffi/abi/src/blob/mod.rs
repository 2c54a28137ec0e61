//! The blob method: sizes and runs.

#[cfg_attr(feature = "small", path = "no_gaps.rs")]
mod arrays;
pub(crate) mod call;
mod options;

pub use call::ParticlesOf;
pub use options::*;
