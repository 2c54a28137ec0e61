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

// Rust's own library offers C's mathematics too (fmod, ...), weakly, in objects that name the unwinder's entry, which a library
// without unwinding lacks: a C program that called fmod would not link with the archive. The name is therefore defined, as the
// address 0, out of sight of the shared library's users and giving way to any other definition.
#[cfg(all(panic = "abort", target_os = "linux"))]
mod unwinder {
    #![expect(unsafe_code, reason = "the assembler's word for a name at address 0")]
    core::arch::global_asm!(".weak rust_eh_personality", ".hidden rust_eh_personality", ".set rust_eh_personality, 0");
}
