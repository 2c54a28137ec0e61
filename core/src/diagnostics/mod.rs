//! Conserved and dissipated quantities, the overlap of blobs, bounds of the time step, discrete norms.
//!
//! * [`moments()`], [`smallest_overlap`]: mass, centre, second moment; the smallest overlap of neighbouring blobs
//! * [`norm`], [`distance`], [`sobolev`], [`Lattice::dual_norm`]: discrete norms L^p_h, W^{1,p}_h and W^{-1,2}_h (Craig & Bertozzi, Sections 3 and 5)
//! * [`stable_step`], [`stable_step_anywhere`]: bounds of the blob method's time step

mod compensated;
mod dual_norm;
mod moments;
mod norms;
mod stability;
pub(crate) mod sums;

pub use compensated::Sum;
pub use dual_norm::Lattice;
pub use moments::{Moments, moments, smallest_overlap};
pub use norms::{distance, norm, sobolev};
pub use stability::{stable_step, stable_step_anywhere};
