//! The softening: compact polynomial and Gaussian mollifiers psi (Anderson; Craig & Bertozzi), with their Newtonian fields.
