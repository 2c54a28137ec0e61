//! Slow and simple reference implementations of what `mollis-core` computes. They share no code with it, so a mistake passes the tests
//! only if it is made in both.
pub mod blob;
pub mod diffusion;
pub mod field;
pub mod grid;
pub mod kernel;
pub mod mollifier;
pub mod pks;
pub mod random;
