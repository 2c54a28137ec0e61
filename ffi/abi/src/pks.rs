//! Coalescing particles.
