//! Sums over sources of K_delta, its gradient and its Laplacian; the plan that picks a method; the methods.
