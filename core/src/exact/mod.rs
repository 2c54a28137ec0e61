//! Solutions in closed form, for comparison.
//!
//! * [`diffusion`]: densities that spread by (degenerate) diffusion, and its balance with attraction
//! * [`radial`]: radial solutions of the aggregation equation with the Newtonian kernel
//! * [`steady`]: steady states of repulsive-attractive kernels
//! * [`vortex`]: pairs, circular and elliptical patches whose velocity is a turned gradient

pub mod diffusion;
pub mod radial;
pub mod steady;
pub mod vortex;
