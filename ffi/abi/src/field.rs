//! Field sums, their plan, executors and counters.
