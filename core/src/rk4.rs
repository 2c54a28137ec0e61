//! Classical fixed-step Runge-Kutta of order 4 on caller-owned buffers.
