//! Pointers and lengths become slices here, and nowhere else.

use mollis_core::space::{ALIGN, Plain};
use mollis_core::{Error, Result};

/// The byte range of a buffer, for overlap checks. Empty buffers have an empty range.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    start: usize,
    bytes: usize,
}

impl Range {
    fn of<T>(pointer: *const T, n: usize) -> Result<Self> {
        Self::check(pointer.addr(), size_of::<T>(), align_of::<T>(), n)
    }

    /// One function for all types: `n` elements of `each` bytes, aligned to `align`, at `start`.
    fn check(start: usize, each: usize, align: usize, n: usize) -> Result<Self> {
        let bytes = each.checked_mul(n).filter(|&b| b <= isize::MAX as usize).ok_or(Error::TooLarge)?;
        if bytes == 0 {
            return Ok(Self { start: 0, bytes: 0 });
        }
        if start == 0 {
            return Err(Error::NullPointer);
        }
        // A power of two, so no division.
        if start & (align - 1) != 0 {
            return Err(Error::Misaligned);
        }
        // A range that would pass the end of the address space is no buffer.
        start.checked_add(bytes).ok_or(Error::TooLarge)?;
        Ok(Self { start, bytes })
    }

    fn overlaps(self, other: Self) -> bool {
        self.bytes > 0
            && other.bytes > 0
            && self.start < other.start + other.bytes
            && other.start < self.start + self.bytes
    }
}

/// `n` elements to read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Input<T> {
    pointer: *const T,
    n: usize,
    range: Range,
}

impl<T: Plain> Input<T> {
    /// Checks null, alignment and size.
    pub(crate) fn new(pointer: *const T, n: usize) -> Result<Self> {
        Ok(Self { pointer, n, range: Range::of(pointer, n)? })
    }

    pub(crate) fn range(self) -> Range {
        self.range
    }

    /// The elements.
    ///
    /// # Safety
    /// The crate's contract holds for pointer and length, for as long as the slice is used.
    pub(crate) unsafe fn slice<'a>(self) -> &'a [T] {
        if self.range.bytes == 0 {
            return &[];
        }
        // SAFETY: checked for null and alignment; the caller promises the rest.
        unsafe { core::slice::from_raw_parts(self.pointer, self.n) }
    }
}

/// `n` elements to write, or to read and write.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Output<T> {
    pointer: *mut T,
    n: usize,
    range: Range,
}

impl<T: Plain> Output<T> {
    /// Checks null, alignment and size.
    pub(crate) fn new(pointer: *mut T, n: usize) -> Result<Self> {
        Ok(Self { pointer, n, range: Range::of(pointer.cast_const(), n)? })
    }

    /// As [`Output::new`]; null means "not wanted".
    pub(crate) fn optional(pointer: *mut T, n: usize) -> Result<Option<Self>> {
        if pointer.is_null() { Ok(None) } else { Self::new(pointer, n).map(Some) }
    }

    pub(crate) fn range(self) -> Range {
        self.range
    }

    /// The elements.
    ///
    /// # Safety
    /// As [`Input::slice`], and nothing else reads or writes them meanwhile.
    pub(crate) unsafe fn slice<'a>(self) -> &'a mut [T] {
        if self.range.bytes == 0 {
            return &mut [];
        }
        // SAFETY: checked for null and alignment; the caller promises the rest.
        unsafe { core::slice::from_raw_parts_mut(self.pointer, self.n) }
    }
}

/// A workspace: `Output<u8>` that must be aligned to [`ALIGN`].
pub(crate) fn workspace(pointer: *mut core::ffi::c_void, bytes: usize) -> Result<Output<u8>> {
    let output = Output::new(pointer.cast::<u8>(), bytes)?;
    if bytes > 0 && !pointer.addr().is_multiple_of(ALIGN) { Err(Error::Misaligned) } else { Ok(output) }
}

/// Refuses outputs that overlap each other or an input.
pub(crate) fn disjoint(outputs: &[Option<Range>], inputs: &[Range]) -> Result<()> {
    for (k, output) in outputs.iter().enumerate().filter_map(|(k, o)| o.map(|o| (k, o))) {
        let later = outputs.iter().skip(k + 1).flatten();
        if later.chain(inputs).any(|&other| output.overlaps(other)) {
            return Err(Error::Overlap);
        }
    }
    Ok(())
}
