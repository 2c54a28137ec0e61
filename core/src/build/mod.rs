//! What this build contains: the one place that asks for the feature `small`, besides modules that it selects.
//!
//! Bodies name what they need, for example [`TRACERS`]. A constant that is false lets the compiler drop the code behind it, which a choice at run time would keep linked.

#[cfg(not(feature = "small"))]
mod full;
#[cfg(not(feature = "small"))]
pub use full::*;

#[cfg(feature = "small")]
mod small;
#[cfg(feature = "small")]
pub use small::*;
