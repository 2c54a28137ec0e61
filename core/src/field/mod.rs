//! Sums over sources: `u(x_i) = sum_j m_j K_delta(x_i - x_j)`, its gradient, Laplacian and second derivatives.
//!
//! Two entry points: [`plan`] selects the method and reports the reason, the omitted work and the size of the workspace;
//! [`evaluate`] runs it. Masses may have either sign; targets may or may not be the sources. A mollified kernel counts
//! every pair, a target on a source included; without a mollifier coincident pairs contribute nothing, and coincidence
//! is by position, so no index map is needed.

mod density;
mod evaluate;
mod expansions;
mod finite;
#[cfg_attr(feature = "small", path = "no_expansions.rs")]
mod fmm;
mod kernels;
mod moments;
mod neighbours;
mod options;
mod pairs;
mod plan;
mod problem;
#[cfg(not(feature = "small"))]
mod results;
mod skips;
mod sorted;
#[cfg_attr(feature = "small", path = "no_expansions.rs")]
mod tree;

pub use density::Density;
pub use evaluate::evaluate;
pub(crate) use evaluate::{drift, drift_bytes, flow};
pub use options::{Accumulation, Method, Options, PairRadius, Reason};
pub use plan::{Plan, plan};
pub use problem::{Essential, Interaction, Outputs, PROXY, Sources, Wanted};
pub use tree::{essential, essential_bytes};
