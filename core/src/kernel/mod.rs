//! The interaction: kernels K and their mollified forms K_delta = K * psi_delta.
