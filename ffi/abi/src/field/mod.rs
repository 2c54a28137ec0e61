//! Field sums: plan (method, reason, bytes, text) and evaluation.

pub(crate) mod call;
pub(crate) mod essential;
mod options;

pub use call::{OutputsOf, SourcesOf, TargetsOf};
pub use options::*;
