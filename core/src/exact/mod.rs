//! Solutions in closed form, to compare with.
//!
//! * [`radial`]: radial solutions of the aggregation equation with the Newtonian kernel
//! * [`steady`]: steady states of repulsive-attractive kernels

pub mod radial;
pub mod steady;
