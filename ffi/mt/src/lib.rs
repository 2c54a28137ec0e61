//! mollis with a ready thread pool: everything in `mollis-abi`, and an executor over rayon.
//!
//! This is a separate library (`libmollis_mt`, header `mollis_mt.h`), because it needs std and an allocator, which the C library
//! `libmollis` must not contain. A C program makes a pool, puts the pool's executor into a `mollis_run` and makes the same calls as
//! without it. A Rust program passes a [`Pool`] as the executor.

mod c;

pub use c::{mollis_pool, mollis_pool_executor, mollis_pool_free, mollis_pool_init};
pub use mollis_abi::*;
pub use mollis_host::pool::Pool;
