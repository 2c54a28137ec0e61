//! Checks that take arbitrary bytes. `cargo xtask fuzz` finds inputs for them by libFuzzer; the test `replay` runs those that are kept in `corpus/`.
//!
//! A check decodes its input, so that every input says something, and panics where a promise is broken.

mod abi;
mod draw;
mod fmm;
mod memory;
mod readers;
mod search;

pub use abi::abi;
pub use fmm::fmm;
pub use readers::{points, scene};
pub use search::search;

/// A check; it panics where a promise is broken.
pub type Check = fn(&[u8]);

/// The checks by name, as their folders below `corpus/`.
pub const TARGETS: [(&str, Check); 5] =
    [("abi", abi), ("scene", scene), ("points", points), ("fmm", fmm), ("search", search)];
