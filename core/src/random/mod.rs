//! Any generator to normals; a ready counter-based Philox4x32-10.
