//! Pointers and lengths become slices here, and nowhere else.

use core::ptr::NonNull;

use mollis_core::memory::{ALIGN, BLOCK_ALIGN, Plain};
use mollis_core::{Error, Result};

/// The byte range of a buffer, for overlap checks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    /// Not null, so that an optional range takes no more room.
    start: NonNull<u8>,
    bytes: usize,
}

impl Range {
    /// The address and the number of bytes.
    pub(crate) fn parts(self) -> (usize, usize) {
        (self.start.addr().get(), self.bytes)
    }

    fn overlaps(self, other: Self) -> bool {
        let (start, other_start) = (self.start.addr().get(), other.start.addr().get());
        self.bytes > 0 && other.bytes > 0 && start < other_start + other.bytes && other_start < start + self.bytes
    }
}

/// One function for all types: `n` elements of `each` bytes, aligned to `align`, at `pointer`, which may be null if there are none.
fn check(pointer: *mut u8, each: usize, align: usize, n: usize) -> Result<NonNull<u8>> {
    let bytes = each.checked_mul(n).filter(|&b| b <= isize::MAX as usize).ok_or(Error::TooLarge)?;
    if bytes == 0 {
        // No memory, but a valid start of none for any type.
        return Ok(NonNull::<Line>::dangling().cast());
    }
    let start = NonNull::new(pointer).ok_or(Error::NullPointer)?;
    // A power of two, so no division.
    if pointer.addr() & (align - 1) != 0 {
        return Err(Error::Misaligned);
    }
    // A range that would pass the end of the address space is no buffer.
    pointer.addr().checked_add(bytes).ok_or(Error::TooLarge)?;
    Ok(start)
}

/// Aligned as no type needs more.
#[repr(align(64))]
struct Line;

/// `n` elements to read.
#[derive(Debug)]
pub(crate) struct Input<T>(Output<T>);

impl<T> Clone for Input<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Input<T> {}

impl<T: Plain> Input<T> {
    /// Checks null, alignment and size.
    #[inline]
    pub(crate) fn new(pointer: *const T, n: usize) -> Result<Self> {
        Output::new(pointer.cast_mut(), n).map(Self)
    }

    #[inline]
    pub(crate) fn range(self) -> Range {
        self.0.range()
    }

    /// The elements.
    ///
    /// # Safety
    /// The crate's contract holds for pointer and length, for as long as the slice is used.
    #[inline]
    pub(crate) unsafe fn slice<'a>(self) -> &'a [T] {
        // SAFETY: checked for null and alignment; the caller promises the rest.
        unsafe { core::slice::from_raw_parts(self.0.start.as_ptr(), self.0.n) }
    }
}

/// `n` elements to write, or to read and write.
#[derive(Debug)]
pub(crate) struct Output<T> {
    start: NonNull<T>,
    n: usize,
}

impl<T> Clone for Output<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Output<T> {}

impl<T: Plain> Output<T> {
    /// Checks null, alignment and size.
    #[inline]
    pub(crate) fn new(pointer: *mut T, n: usize) -> Result<Self> {
        const { assert!(align_of::<T>() <= align_of::<Line>()) }
        Ok(Self { start: check(pointer.cast(), size_of::<T>(), align_of::<T>(), n)?.cast(), n })
    }

    pub(crate) fn len(self) -> usize {
        self.n
    }

    pub(crate) fn start(self) -> NonNull<T> {
        self.start
    }

    /// As [`Output::new`]; null means "not wanted".
    #[inline]
    pub(crate) fn optional(pointer: *mut T, n: usize) -> Result<Option<Self>> {
        if pointer.is_null() { Ok(None) } else { Self::new(pointer, n).map(Some) }
    }

    #[inline]
    pub(crate) fn range(self) -> Range {
        // Cannot overflow: it was checked.
        Range { start: self.start.cast(), bytes: self.n.wrapping_mul(size_of::<T>()) }
    }

    /// The elements.
    ///
    /// # Safety
    /// As [`Input::slice`], and nothing else reads or writes them meanwhile.
    #[inline]
    pub(crate) unsafe fn slice<'a>(self) -> &'a mut [T] {
        // SAFETY: checked for null and alignment; the caller promises the rest.
        unsafe { core::slice::from_raw_parts_mut(self.start.as_ptr(), self.n) }
    }
}

/// Bytes to ask for where so many, aligned to [`ALIGN`], must fit wherever the buffer begins.
pub(crate) fn with_slack(bytes: usize) -> Result<usize> {
    if bytes == 0 { Ok(0) } else { bytes.checked_add(ALIGN - 1).ok_or(Error::TooLarge) }
}

/// A workspace from its first aligned byte on.
pub(crate) fn aligned(memory: &mut [u8]) -> &mut [u8] {
    let ahead = memory.as_ptr().addr().wrapping_neg() & (ALIGN - 1);
    memory.get_mut(ahead..).unwrap_or_default()
}

/// A prepared object: `Output<u8>` that must be aligned to [`BLOCK_ALIGN`].
pub(crate) fn block(pointer: *mut core::ffi::c_void, bytes: usize) -> Result<Output<u8>> {
    let output = Output::new(pointer.cast::<u8>(), bytes)?;
    if bytes > 0 && !pointer.addr().is_multiple_of(BLOCK_ALIGN) { Err(Error::Misaligned) } else { Ok(output) }
}

/// Refuses outputs that overlap each other or an input.
pub(crate) fn disjoint(outputs: &[Option<Range>], inputs: &[Range]) -> Result<()> {
    let mut left = outputs;
    while let Some((&first, later)) = left.split_first() {
        left = later;
        let Some(output) = first else { continue };
        let meets = |other: &Range| output.overlaps(*other);
        if later.iter().flatten().any(meets) || inputs.iter().any(meets) {
            return Err(Error::Overlap);
        }
    }
    Ok(())
}
