//! The blob method for the aggregation equation (Craig & Bertozzi, Definitions 2.2 and 2.3).
//!
//! [`Diffusion`] adds degenerate diffusion (Carrillo, Craig & Patacchini).
//!
//! [`plan()`], [`step()`]: positions, densities, velocities and divergences along trajectories, k steps in one call.

mod diffusion;
mod step;

pub use diffusion::Diffusion;
pub use step::{Advance, AfterStep, Plan, Progress, Report, State, Trajectories, Wanted, energy_of, plan, step};
