//! Special functions that libm lacks, stated once over the scalar.
