//! Status codes, their texts, and the version.

use core::ffi::c_char;

use mollis_core::{Error, Result};

/// What every function returns: `MOLLIS_OK` or one of `MOLLIS_ERR_*`.
#[allow(non_camel_case_types, reason = "its name in C")]
pub type mollis_status = i32;

/// The status of a result.
pub(crate) fn status(result: Result<()>) -> mollis_status {
    match result {
        Ok(()) => 0,
        Err(error) => error as i32,
    }
}

/// A sentence that explains a status. Static text, never null; any value is accepted.
#[unsafe(no_mangle)]
pub extern "C" fn mollis_status_text(status: mollis_status) -> *const c_char {
    let text = match (status, Error::from_code(status)) {
        (0, _) => c"success",
        (_, Some(error)) => error.text(),
        _ => c"unknown status",
    };
    text.as_ptr()
}

/// The version of the binary interface: it changes when a program built with an older header may break.
#[unsafe(no_mangle)]
pub extern "C" fn mollis_abi_version() -> u32 {
    1
}
