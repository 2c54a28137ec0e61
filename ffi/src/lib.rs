//! The C library: everything in `mollis-abi`, linked without std, with the panic handler that such a library must have.
//! (Profiles with unwinding panics, for development and tests, use that of std.)
#![cfg_attr(panic = "abort", no_std)]

pub use mollis_abi::*;

/// Unreachable: `cargo xtask symbols` checks that no panic is linked. A loop here would hide a panic, so the handler traps.
#[cfg(panic = "abort")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    mollis_abi::trap()
}

// Rust's compiler-builtins also offer C's mathematical functions (fmod, ...) as weak symbols, in objects that refer to the entry of the
// unwinder. A library without unwinding lacks this entry, so a C program that calls fmod would not link with the archive. The name is
// therefore defined here at address 0, as a weak symbol that is hidden from users of the shared library. Any other definition has priority.
#[cfg(all(panic = "abort", target_os = "linux"))]
mod unwinder {
    #![expect(unsafe_code, reason = "the assembler's word for a name at address 0")]
    core::arch::global_asm!(".weak rust_eh_personality", ".hidden rust_eh_personality", ".set rust_eh_personality, 0");
}
