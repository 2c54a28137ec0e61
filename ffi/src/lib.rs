//! The C library: everything in `mollis-abi`, linked without std, with the panic handler that such a library must have.
//! (Profiles whose panics unwind, as development and tests do, take std's.)
#![cfg_attr(panic = "abort", no_std)]

pub use mollis_abi::*;

/// Unreachable: `cargo xtask symbols` proves that no panic is linked. Were it reached, looping would hide it.
#[cfg(panic = "abort")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    mollis_abi::trap()
}
