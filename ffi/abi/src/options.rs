//! Option structures: filled by an `_init` function that is told their size, so that a program compiled against an older
//! header is never overrun by a newer library.

use mollis_core::{Error, Result};

/// A structure of options: starts with its size in bytes, as the caller's header has it.
///
/// # Safety
/// `#[repr(C)]`, `u32` first, no references, and any prefix of whole members may be replaced by bytes of an older version of it.
pub(crate) unsafe trait Options: Copy {
    /// The defaults of this library, the size included.
    const DEFAULT: Self;
    /// Where members end: the sizes that a caller may state.
    const ENDS: &[usize];

    /// Refuses a size that is none of these.
    fn check(size: usize) -> Result<()> {
        if Self::ENDS.contains(&size) { Ok(()) } else { Err(Error::OptionsSize) }
    }
}

/// Makes a structure one of [`Options`], with these defaults for all of its members but the size. A member that is left out does not
/// compile, so none can be missing in the table of sizes.
macro_rules! options {
    ($name:ident { $($member:ident: $default:expr),* $(,)? }) => {
        // SAFETY: `repr(C)`, the size first; all members take any bytes that an older caller wrote, and only whole ones are taken.
        unsafe impl $crate::options::Options for $name {
            const DEFAULT: Self = Self { size: size_of::<Self>() as u32, $($member: $default),* };
            // A member ends where the next one begins, and the last where the structure does.
            const ENDS: &[usize] = &[$(core::mem::offset_of!($name, $member),)* size_of::<$name>()];
        }
    };
}
pub(crate) use options;

/// Writes the first `size` bytes of the defaults; the size field says `size`.
///
/// # Safety
/// The crate's contract for `options` as `size` writable bytes.
pub(crate) unsafe fn init<T: Options>(options: *mut T, size: usize) -> Result<()> {
    if options.is_null() {
        return Err(Error::NullPointer);
    }
    if !options.addr().is_multiple_of(align_of::<T>()) {
        return Err(Error::Misaligned);
    }
    T::check(size)?;
    let stated = u32::try_from(size).map_err(|_| Error::OptionsSize)?;
    let defaults = T::DEFAULT;
    // SAFETY: `size` is at most the size of both; the caller promises that many writable bytes. The first four are the
    // size field, by the trait's contract.
    unsafe {
        core::ptr::copy_nonoverlapping((&raw const defaults).cast::<u8>(), options.cast::<u8>(), size);
        options.cast::<u32>().write(stated);
    }
    Ok(())
}

/// The caller's options; what its header did not know yet, and everything for null, is the default.
///
/// # Safety
/// The crate's contract for `options` as as many bytes as its first member says.
pub(crate) unsafe fn read<T: Options>(options: *const T) -> Result<T> {
    let mut known = T::DEFAULT;
    if options.is_null() {
        return Ok(known);
    }
    if !options.addr().is_multiple_of(align_of::<T>()) {
        return Err(Error::Misaligned);
    }
    // SAFETY: the size comes first, by the trait's contract.
    let size = usize::try_from(unsafe { options.cast::<u32>().read() }).map_err(|_| Error::OptionsSize)?;
    if size == 0 {
        return Err(Error::NotInitialised);
    }
    T::check(size)?;
    // SAFETY: `size` bytes are readable, as the caller promises, and fit; any prefix of whole members may be replaced.
    unsafe { core::ptr::copy_nonoverlapping(options.cast::<u8>(), (&raw mut known).cast::<u8>(), size) };
    Ok(known)
}
