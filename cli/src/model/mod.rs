//! What moves: the models of scenes, and the loop that each runs in.
//!
//! [`simulation`] is the loop; [`blob`], [`pks`], [`cluster`] and [`profile`] are the models; [`kernel`] prepares the sums of
//! a scene; [`stop`] is the wish to stop.

pub mod blob;
pub mod cluster;
pub mod kernel;
pub mod pks;
pub mod profile;
mod simulation;
pub mod stop;

pub use simulation::{Ending, Simulation, Watch, drive};
