//! The blob method: sizes and runs.

pub(crate) mod call;
mod options;

pub use call::ParticlesOf;
pub use options::*;
