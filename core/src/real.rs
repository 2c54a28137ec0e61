//! The scalar of all mathematics: f32 or f64, with its instructions.

pub use crate::scalar::{DoubleWord, Scalar};
pub(crate) use crate::scalar::{Extended, length, normal_exponent, quotient, single};
use crate::simd::Dispatch;

/// f32 or f64. The methods are those of [`Scalar`]; algorithms over lanes are dispatched by [`Dispatch`].
pub trait Real: Scalar + Dispatch {}

impl Real for f32 {}
impl Real for f64 {}
