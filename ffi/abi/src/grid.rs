//! Mesh fields.
