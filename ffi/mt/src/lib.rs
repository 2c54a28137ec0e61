//! mollis with a ready thread pool: everything in `mollis-abi`, and an executor over rayon.
//!
//! A library of its own (`libmollis_mt`), because it needs std and an allocator, which the C library `libmollis` must not
//! gain by being built together with it. The mathematics has no knowledge of it.

mod pool;

pub use mollis_abi::*;
pub use pool::Pool;
