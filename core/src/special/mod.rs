//! Special functions that libm lacks, stated once over the scalar.

pub mod incomplete_gamma;
pub mod normal;
