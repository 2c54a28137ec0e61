//! The machine: lanes, instruction sets and the one dispatch. The only place, with `space`, that holds `unsafe` in core.

mod level;
pub(crate) mod root;
mod widest;

pub use level::Level;
pub(crate) use widest::{Plain, widest};
