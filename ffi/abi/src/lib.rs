//! The C ABI of mollis: each function validates its arguments, converts them and calls `mollis-core`.
//!
//! No mathematics stands here. The header `include/mollis.h` is generated from this crate, so doc comments on `extern`
//! functions are written for readers of C.
//!
//! # Safety
//! One contract holds for every function. A pointer with a length must be null (only with length 0) or point to that
//! many initialised elements, aligned for their type; an output must be writable and overlap nothing else of the call.
//! What can be checked (null, alignment, overlap, sizes) is checked before the first write.
#![no_std]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![allow(
    rustdoc::broken_intra_doc_links,
    reason = "comments are for readers of C, whose brackets are shapes, not links"
)]
#![expect(unsafe_code, reason = "the C boundary")]
#![allow(clippy::missing_safety_doc, reason = "one contract, stated above")]
#![allow(non_camel_case_types, reason = "names in C")]

mod arrays;
mod blob;
mod buffers;
mod diagnostics;
mod field;
mod first_bad;
mod functions;
mod grid;
mod kernel;
mod mollifier;
mod norms;
mod options;
mod pks;
mod random;
mod run;
mod status;

pub use blob::*;
pub use field::*;
pub use first_bad::*;
pub use functions::*;
pub use grid::*;
pub use kernel::*;
pub use mollifier::*;
pub use pks::*;
pub use random::*;
pub use run::*;
pub use status::*;

/// Ends the program without unwinding, printing or returning.
pub fn trap() -> ! {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: `ud2` stops the program; nothing runs after it.
    unsafe {
        core::arch::asm!("ud2", options(noreturn, nomem, nostack))
    }
    #[cfg(target_arch = "aarch64")]
    // SAFETY: as above.
    unsafe {
        core::arch::asm!("brk #1", options(noreturn, nomem, nostack))
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    loop {}
}
