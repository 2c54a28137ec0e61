//! Solutions in closed form, for comparison.
//!
//! * [`radial`]: radial solutions of the aggregation equation with the Newtonian kernel
//! * [`steady`]: steady states of repulsive-attractive kernels
//! * [`vortex`]: pairs, circular and elliptical patches whose velocity is a turned gradient

pub mod radial;
pub mod steady;
pub mod vortex;
