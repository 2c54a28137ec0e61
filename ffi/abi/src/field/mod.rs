//! Field sums: plan (method, reason, bytes, text) and evaluation. `functions` is made from `templates/field.rs`.

mod call;
mod functions;
mod options;

pub use call::{OutputsOf, SourcesOf, TargetsOf};
pub use functions::*;
pub use options::*;
