//! Particles that interact through softened ("mollified") potentials: all the mathematics of mollis.
//!
//! The crate allocates nothing, prints nothing and never panics in a release build. The caller owns all memory.
//! Its floors, from the ground; a module uses only what stands on its own floor or below:
//!
//! 1. [`error`], [`real`] (the scalar trait over f32 and f64), [`special`] (functions libm lacks), [`space`] (carving a
//!    caller's workspace), [`parallel`] (the executor a host passes in), [`isa`] (lanes and the one dispatch)
//! 2. [`mollifier`] (psi), [`kernel`] (K)
//! 3. [`field`] (sums over sources), [`grid`] (mesh fields), [`random`] (any generator to normals)
//! 4. [`blob`] (aggregation equation), [`pks`] (coalescing particles), on the steppers [`rk4`] and [`euler_maruyama`]
#![no_std]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![cfg_attr(test, allow(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic))]

#[cfg(test)]
extern crate std;

pub mod error;
pub mod isa;
pub mod parallel;
pub mod real;
pub mod space;
pub mod special;

pub mod kernel;
pub mod mollifier;

pub mod field;
pub mod grid;
pub mod random;

pub mod blob;
pub mod euler_maruyama;
pub mod pks;
pub mod rk4;

pub use error::{Error, Result};
pub use real::Real;
