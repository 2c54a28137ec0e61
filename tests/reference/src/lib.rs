//! Slow, obvious twins of what `mollis-core` computes. Nothing here is shared with it: a mistake would have to be made
//! twice to pass unseen.
pub mod blob;
pub mod field;
pub mod grid;
pub mod kernel;
pub mod mollifier;
pub mod pks;
pub mod random;
