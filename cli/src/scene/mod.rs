//! Scene files: what they may say, read with every mistake named by file, line and key.
//!
//! [`tree`] reads TOML with lines, [`schema`] states every key, [`check`] holds one against the other, [`build`] makes the
//! typed [`Scene`] of it and checks what concerns more than one key, [`read`] does all that for a file with its cases.
//! [`records`] says what a run records, [`possible`] refuses pictures and expectations that such a run can't give,
//! [`folders`] names where the data of cases go. [`density`] knows the papers' shapes and their integrals, [`exact`] how some
//! of them move.

mod build;
mod check;
mod command;
mod density;
mod exact;
mod folders;
mod mistake;
mod possible;
mod read;
mod records;
mod schema;
#[cfg(test)]
mod tests;
mod tree;
mod types;

pub use command::{Args, main};
pub use density::Density;
pub use exact::Exact;
pub use folders::{CHECKPOINT, SUMMARY};
pub use read::{load, parse};
pub use records::SLACK;
pub use types::*;
