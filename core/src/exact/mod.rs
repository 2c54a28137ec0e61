//! Solutions in closed form, for comparison.
//!
//! * [`radial`]: radial solutions of the aggregation equation with the Newtonian kernel
//! * [`steady`]: steady states of repulsive-attractive kernels

pub mod radial;
pub mod steady;
