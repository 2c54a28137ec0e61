//! Particles that interact through softened ("mollified") potentials: all the mathematics of mollis.
//!
//! The crate allocates nothing, prints nothing and never panics in a release build. The caller owns all memory.
//!
//! ```
//! use mollis_core::exec::Run;
//! use mollis_core::field::{self, Options, Outputs, Sources, Wanted};
//! use mollis_core::kernel::Kernel;
//! use mollis_core::memory::ALIGN;
//! use mollis_core::mollifier::Mollifier;
//!
//! // Two masses in the plane, and the Newtonian kernel log|x| / (2 pi), smoothed within 0.1.
//! let (x, mass) = ([[0.0, 0.0], [1.0, 0.0]], [3.0, 5.0]);
//! let kernel = Kernel::<f64, 2>::newtonian(1.0, Mollifier::Compact { order: 2, exponent: 4 }, 0.1)?;
//!
//! // The plan says which method runs and how much memory it needs.
//! let wanted = Wanted { gradient: true, ..Wanted::default() };
//! let plan = field::plan(&kernel, x.len(), x.len(), wanted, &Options::default())?;
//! let bytes = plan.workspace_bytes(1)?;
//! let mut memory = vec![0; bytes + ALIGN];
//! let start = memory.as_ptr().align_offset(ALIGN);
//! let workspace = &mut memory[start..start + bytes];
//!
//! let mut gradient = [[0.0; 2]; 2];
//! let outputs = Outputs { gradient: Some(&mut gradient), ..Outputs::default() };
//! let sources = Sources::new(&x, &mass);
//! field::evaluate(&plan, &kernel, sources, &x, outputs, workspace, &mut Run::default())?;
//!
//! // Outside 0.1 the field is exactly that of points: grad u = sum m (x - y) / (2 pi |x - y|^2).
//! assert!((gradient[1][0] - 3.0 / std::f64::consts::TAU).abs() < 1e-15);
//! # Ok::<(), mollis_core::Error>(())
//! ```
//!
//! `examples/` holds whole programs: a field sum, the blob method, coalescing particles.
//!
//! # Modules
//! Its layers, from the bottom up; a module uses only its own layer and those below, and no two modules use each other:
//!
//! 1. [`build`] (what is in it), [`error`], `checked` (access to what must be there), [`scalar`] and [`real`] (f32 and f64), [`special`] (functions libm lacks), [`memory`] (the layout of a caller's workspace),
//!    [`simd`] (lanes, instruction sets, the one dispatch), [`exec`] (the context of a call), `sort`
//! 2. [`mollifier`] (psi), [`kernel`] (K)
//! 3. [`field`] (sums over sources), [`grid`] (mesh fields), [`random`] (any generator to normals)
//! 4. [`aggregation`] (the blob method), [`pks`] (coalescing particles), on the steppers [`rk4`] and [`euler_maruyama`]; [`diagnostics`],
//!    [`exact`] (solutions in closed form)
#![no_std]
#![cfg_attr(not(test), warn(clippy::pedantic))]
#![allow(clippy::inline_always, reason = "loops over lanes have to be in line to be compiled for the instruction set")]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    reason = "conversions among counts, exponents, bits and numbers whose ranges stand beside them"
)]
#![allow(
    clippy::doc_markdown,
    clippy::many_single_char_names,
    clippy::similar_names,
    reason = "formulas have the symbols of the papers"
)]
#![allow(
    clippy::float_cmp,
    clippy::needless_bitwise_bool,
    clippy::unreadable_literal,
    reason = "exact comparisons, conditions without a branch, and coefficients as they were printed"
)]
#![allow(
    clippy::return_self_not_must_use,
    clippy::needless_pass_by_value,
    clippy::trivially_copy_pass_by_ref,
    clippy::struct_excessive_bools,
    reason = "arithmetic, visitors of outputs, and options that mirror the C structures"
)]
#![allow(
    clippy::items_after_statements,
    clippy::needless_for_each,
    clippy::single_match_else,
    clippy::too_many_lines,
    clippy::wildcard_imports,
    reason = "matters of style, among them all intrinsics of an instruction set by one import"
)]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![cfg_attr(
    test,
    allow(
        clippy::disallowed_methods,
        clippy::indexing_slicing,
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic
    )
)]

#[cfg(test)]
extern crate std;

pub mod build;
mod checked;
pub mod error;
pub mod exec;
pub mod memory;
pub mod real;
pub mod scalar;
pub mod simd;
mod sort;
pub mod special;

pub mod kernel;
pub mod mollifier;

pub mod field;
pub mod grid;
pub mod random;

pub mod aggregation;
pub mod diagnostics;
pub mod euler_maruyama;
pub mod exact;
pub mod pks;
pub mod rk4;

pub use error::{Error, Result};
pub use real::{Real, Scalar};
