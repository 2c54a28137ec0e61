//! Particles that interact through softened ("mollified") potentials: all the mathematics of mollis.
//!
//! The crate allocates nothing, prints nothing and never panics in a release build. The caller owns all memory.
//! Its layers, from the bottom up; a module uses only its own layer and those below, and no two modules use each other:
//!
//! 1. [`error`], [`scalar`] and [`real`] (f32 and f64), [`special`] (functions libm lacks), [`memory`] (the layout of a caller's workspace),
//!    [`simd`] (lanes, instruction sets, the one dispatch), [`exec`] (the context of a call), [`sort`](mod@sort)
//! 2. [`mollifier`] (psi), [`kernel`] (K)
//! 3. [`field`] (sums over sources), [`grid`] (mesh fields), [`random`] (any generator to normals)
//! 4. [`aggregation`] (the blob method), [`pks`] (coalescing particles), on the steppers [`rk4`] and [`euler_maruyama`]; [`diagnostics`],
//!    [`exact`] (solutions in closed form)
#![no_std]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![cfg_attr(test, allow(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic))]

#[cfg(test)]
extern crate std;

pub mod error;
pub mod exec;
pub mod memory;
pub mod real;
pub mod scalar;
pub mod simd;
mod sort;
pub mod special;

pub mod kernel;
pub mod mollifier;

pub mod field;
pub mod grid;
pub mod random;

pub mod aggregation;
pub mod diagnostics;
pub mod euler_maruyama;
pub mod exact;
pub mod pks;
pub mod rk4;

pub use error::{Error, Result};
pub use real::{Real, Scalar};
