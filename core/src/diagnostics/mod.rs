//! What a run conserves or dissipates, how well its blobs overlap, how long a step may be; discrete norms.
//!
//! * [`moments()`], [`smallest_overlap`]: mass, centre, second moment; the least overlap of neighbouring blobs
//! * [`norm`], [`distance`], [`Lattice::dual_norm`]: discrete norms L^p_h and W^{-1,2}_h (Craig & Bertozzi, Section 5)
//! * [`stable_step`], [`stable_step_anywhere`]: a bound of the blob method's step

mod compensated;
mod dual_norm;
mod moments;
mod norms;
mod stability;
pub(crate) mod sums;

pub use compensated::Sum;
pub use dual_norm::Lattice;
pub use moments::{Moments, moments, smallest_overlap};
pub use norms::{distance, norm};
pub use stability::{stable_step, stable_step_anywhere};
