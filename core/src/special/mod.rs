//! Special functions that libm does not provide, generic over the scalar.

pub mod bessel;
pub(crate) mod elementary;
pub mod exponential_integral;
mod gamma_series;
pub mod incomplete_gamma;
pub mod normal;
