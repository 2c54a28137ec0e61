//! Firmware: sums over pairs in single precision, one pair after the other, in kilobytes of flash and of stack.

/// As in other builds.
pub const WORKERS: bool = false;
/// As in other builds.
pub const METHODS: bool = false;
/// As in other builds.
pub const KERNELS: bool = cfg!(feature = "kernels");
/// As in other builds.
pub const BESIDES: bool = false;
/// As in other builds.
pub const TRACERS: bool = false;
/// As in other builds.
pub const AFTER_STEP: bool = false;
/// As in other builds.
pub const MESHES: bool = false;
/// As in other builds.
pub const NOISELESS: bool = false;
/// As in other builds.
pub const PRINTED_LAW: bool = false;
/// As in other builds.
pub const STRANG: bool = false;
/// As in other builds.
pub const REPORTS: bool = false;
/// As in other builds.
pub const PHILOX: bool = false;
/// Any number.
pub const FEW: usize = u32::MAX as usize;
/// As in other builds.
pub const TILES: bool = false;
/// Many machines without it, so single precision does not use it.
pub const DOUBLE: bool = false;
/// As in other builds.
pub const MANY: bool = false;
/// As in other builds.
pub const SHARED: bool = true;

/// A short function of arithmetic: one for all callers.
macro_rules! shared {
    ($($function:tt)*) => { #[inline(never)] $($function)* };
}
pub(crate) use shared;
