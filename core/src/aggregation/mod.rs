//! The blob method for the aggregation equation (Craig & Bertozzi, Definitions 2.2 and 2.3).
//!
//! [`plan()`], [`step()`]: positions, densities, velocities and divergences along trajectories, k steps in one call.

mod step;

pub use step::{Advance, AfterStep, Plan, Progress, Report, State, Trajectories, Wanted, energy_of, plan, step};
