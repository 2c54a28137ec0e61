//! The blob method for the aggregation equation (Craig & Bertozzi, Definitions 2.2 and 2.3).
//!
//! * [`plan()`], [`step`]: positions, densities, velocities and divergences along trajectories, k steps in one call
//! * [`stable_step`], [`stable_step_anywhere`]: how long a step may be
//! * [`moments()`], [`energy_of`], [`smallest_overlap`]: what a run conserves or dissipates, and how well its blobs overlap
//! * [`norm`], [`distance`], [`Lattice::dual_norm`]: discrete norms L^p_h and W^{-1,2}_h
//! * [`radial`]: exact solutions for the Newtonian kernel, to compare with
//! * [`steady`]: steady states known in closed form
mod dual_norm;
mod moments;
mod norms;
pub mod radial;
mod run;
mod stability;
pub mod steady;
mod sums;

pub use dual_norm::Lattice;
pub use moments::{Moments, Sum, moments, smallest_overlap};
pub use norms::{distance, norm};
pub use run::{Advance, AfterStep, Plan, Progress, Report, State, Trajectories, Wanted, energy_of, plan, step};
pub use stability::{stable_step, stable_step_anywhere};
