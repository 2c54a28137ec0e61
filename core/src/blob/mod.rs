//! The blob method for the aggregation equation (Craig & Bertozzi, Definitions 2.2 and 2.3).
//!
//! * [`moments()`]: what a run conserves or dissipates, from positions and masses alone
//! * [`radial`]: exact solutions for the Newtonian kernel, to compare with
//! * [`steady`]: steady states known in closed form
mod moments;
pub mod radial;
pub mod steady;

pub use moments::{Moments, Sum, moments, smallest_overlap};
