//! Firmware: sums over pairs in single precision, one pair after the other, in kilobytes of flash and of stack.

#![allow(missing_docs, reason = "what the constants mean stands in `full.rs`")]

pub const WORKERS: bool = false;
pub const METHODS: bool = false;
pub const KERNELS: bool = cfg!(feature = "kernels");
pub const BESIDES: bool = false;
pub const TRACERS: bool = false;
pub const AFTER_STEP: bool = false;
pub const MESHES: bool = false;
pub const NOISELESS: bool = false;
pub const PRINTED_LAW: bool = false;
pub const STRANG: bool = false;
pub const REPORTS: bool = false;
pub const PHILOX: bool = false;
/// Any number.
pub const FEW: usize = u32::MAX as usize;
pub const TILES: bool = false;
/// Many machines without it, so single precision does not use it.
pub const DOUBLE: bool = false;
pub const MANY: bool = false;
pub const WEIGHTS: bool = false;
pub const RANKS: bool = false;
pub const SHARED: bool = true;

/// A short function of arithmetic: one for all callers.
macro_rules! shared {
    ($($function:tt)*) => { #[inline(never)] $($function)* };
}
pub(crate) use shared;
