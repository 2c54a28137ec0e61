//! The functions and structures that exist for every dimension and scalar: each file is made from the template of its name in `ffi/abi/templates`.

mod blob;
mod diagnostics;
mod field;
mod grid;
mod kernel;
mod mollifier;
mod norms;
mod pks;
mod random;

pub use blob::*;
pub use diagnostics::*;
pub use field::*;
pub use grid::*;
pub use kernel::*;
pub use mollifier::*;
pub use norms::*;
pub use pks::*;
pub use random::*;
