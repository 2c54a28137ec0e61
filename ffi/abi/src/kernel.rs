//! Kernel sums: prepare into a caller's buffer.
