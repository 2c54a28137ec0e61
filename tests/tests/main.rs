//! What no single crate can test alone. One program, so that generic code is compiled once for all of it:
//! `cargo test -p mollis-tests NAME::` runs a module.

mod abi_equals_rust;
mod blob_abi;
mod blob_run;
mod border;
mod boundary_abi;
mod diagnostics_abi;
mod field_bounds;
mod field_ranges;
mod field_skips;
mod fmm;
mod grid;
mod grid_abi;
mod hessians;
mod kernel_abi;
mod kernel_oracle;
mod kernel_random;
mod kernel_twin;
mod mollifier;
mod mollifier_abi;
mod own_kernels;
mod pair_radii;
mod pks_abi;
mod pks_heavy;
mod pks_hitting;
mod pks_search;
mod pks_soft;
mod pks_step;
mod portable_bits;
mod random;
mod ranges;
mod softenings;
mod stable_steps;
mod step_layouts;
mod sum_layouts;
mod traps;
