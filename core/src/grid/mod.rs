//! Mesh fields: deposit, Poisson solve, interpolation (Zhelezov & Fatkullin, Section 3.4).
