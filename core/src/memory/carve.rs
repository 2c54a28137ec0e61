//! Measuring a workspace, carving it into arrays, reopening it.

use core::marker::PhantomData;
use core::mem::MaybeUninit;

use crate::error::{Error, Result};

/// The alignment of every workspace and of every array in it, in bytes: a cache line, and an AVX-512 register.
pub const ALIGN: usize = 64;

/// The alignment of a prepared block, in bytes: that of its numbers. At a multiple of [`ALIGN`] its tables take fewer cache lines.
pub const BLOCK_ALIGN: usize = 8;

/// Plain-data types: any bytes are a valid value, and a value owns nothing.
///
/// # Safety
/// Every bit pattern must be a valid value; the type must have no padding, no pointers and no destructor, and its
/// alignment must not exceed [`ALIGN`].
#[expect(unsafe_code, reason = "implementors promise that all bytes are valid")]
pub unsafe trait Plain: Copy + Send + Sync + 'static {}

macro_rules! plain {
    ($($t:ty)*) => { $(
        // SAFETY: a primitive number.
        #[expect(unsafe_code, reason = "primitive numbers")]
        unsafe impl Plain for $t {}
    )* };
}
plain!(u8 u16 u32 u64 usize i8 i16 i32 i64 isize f32 f64);
// SAFETY: an array has no padding between its elements.
#[expect(unsafe_code, reason = "arrays of plain elements")]
unsafe impl<T: Plain, const N: usize> Plain for [T; N] {}

/// The same bits, without signs.
#[expect(unsafe_code, reason = "two integers of one size")]
pub(crate) fn unsigned(words: &mut [i64]) -> &mut [u64] {
    // SAFETY: as many of the same size and alignment, borrowed as long, and any bits are integers of either kind.
    unsafe { core::slice::from_raw_parts_mut(words.as_mut_ptr().cast(), words.len()) }
}

/// The source of a layout's arrays.
pub trait Space<'w> {
    /// The next `n` elements, aligned to [`ALIGN`]. They are zeroed by [`Carve::new`] and unchanged after [`Carve::reopen`].
    ///
    /// # Errors
    /// [`Error::TooLarge`]: the size overflows. [`Error::WorkspaceTooSmall`]: not enough bytes are left.
    fn try_array<T: Plain>(&mut self, n: usize) -> Result<&'w mut [T]>;

    /// As [`Space::try_array`], for layouts of many arrays that check for an error once, with [`Space::finish`]. After an error arrays are empty.
    fn array<T: Plain>(&mut self, n: usize) -> &'w mut [T];

    /// Returns the first error of [`Space::array`].
    ///
    /// # Errors
    /// As [`Space::try_array`].
    fn finish(&self) -> Result<()>;
}

/// Bytes of `n` elements of `each` bytes, rounded up to a multiple of [`ALIGN`].
fn padded_bytes(each: usize, n: usize) -> Result<usize> {
    let bytes = each.checked_mul(n).ok_or(Error::TooLarge)?;
    let padded = bytes.checked_next_multiple_of(ALIGN).ok_or(Error::TooLarge)?;
    // No allocation exceeds isize::MAX. Refusing such sizes here keeps later pointer arithmetic sound.
    if padded > isize::MAX as usize { Err(Error::TooLarge) } else { Ok(padded) }
}

/// Counts the bytes of a layout.
#[derive(Debug, Default)]
pub struct Measure {
    bytes: usize,
    error: Option<Error>,
}

impl Measure {
    /// The exact size of `layout` in bytes.
    ///
    /// # Errors
    /// [`Error::TooLarge`], and whatever `layout` returns.
    pub fn of(layout: impl FnOnce(&mut Self) -> Result<()>) -> Result<usize> {
        let mut measure = Self::default();
        layout(&mut measure)?;
        Ok(measure.bytes)
    }

    /// Bytes counted so far.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.bytes
    }
}

impl Measure {
    /// Counts `n` elements of `each` bytes. Not generic, so that all types share one function.
    fn add(&mut self, each: usize, n: usize) -> Result<()> {
        self.bytes = self.bytes.checked_add(padded_bytes(each, n)?).ok_or(Error::TooLarge)?;
        if self.bytes > isize::MAX as usize { Err(Error::TooLarge) } else { Ok(()) }
    }
}

impl Measure {
    fn note(&mut self, each: usize, n: usize) {
        if let Err(error) = self.add(each, n) {
            self.error.get_or_insert(error);
        }
    }
}

impl<'w> Space<'w> for Measure {
    #[inline]
    fn try_array<T: Plain>(&mut self, n: usize) -> Result<&'w mut [T]> {
        self.add(size_of::<T>(), n)?;
        Ok(&mut [])
    }

    #[inline]
    fn array<T: Plain>(&mut self, n: usize) -> &'w mut [T] {
        self.note(size_of::<T>(), n);
        &mut []
    }

    fn finish(&self) -> Result<()> {
        self.error.map_or(Ok(()), Err)
    }
}

/// Hands out consecutive arrays of a caller's buffer.
#[derive(Debug)]
pub struct Carve<'w> {
    next: *mut u8,
    left: usize,
    fresh: bool,
    /// What its start is aligned to.
    align: usize,
    error: Option<Error>,
    owner: PhantomData<&'w mut [MaybeUninit<u8>]>,
}

impl<'w> Carve<'w> {
    /// Starts carving zeroed arrays out of `memory`, whose previous content is ignored.
    ///
    /// # Errors
    /// [`Error::Misaligned`]: `memory` does not start at a multiple of [`ALIGN`].
    pub fn new(memory: &'w mut [u8]) -> Result<Self> {
        Self::start(memory.as_mut_ptr(), memory.len(), true, ALIGN)
    }

    /// As [`Carve::new`], for a block of numbers that begins at a multiple of [`BLOCK_ALIGN`].
    ///
    /// # Errors
    /// [`Error::Misaligned`]: it does not; later, an array of a type that needs more.
    pub fn block(memory: &'w mut [u8]) -> Result<Self> {
        Self::start(memory.as_mut_ptr(), memory.len(), true, BLOCK_ALIGN)
    }

    /// As [`Carve::new`], over memory that may be uninitialised.
    ///
    /// # Errors
    /// As [`Carve::new`].
    pub fn new_uninit(memory: &'w mut [MaybeUninit<u8>]) -> Result<Self> {
        Self::start(memory.as_mut_ptr().cast(), memory.len(), true, ALIGN)
    }

    /// Finds the arrays again with their content; nothing is zeroed. The type of `memory` guarantees that it is initialised.
    ///
    /// # Errors
    /// As [`Carve::new`].
    pub fn reopen(memory: &'w mut [u8]) -> Result<Self> {
        Self::start(memory.as_mut_ptr(), memory.len(), false, ALIGN)
    }

    fn start(next: *mut u8, left: usize, fresh: bool, align: usize) -> Result<Self> {
        // An empty layout needs no memory, so its pointer need not be aligned.
        if left > 0 && !next.addr().is_multiple_of(align) {
            return Err(Error::Misaligned);
        }
        Ok(Self { next, left, fresh, align, error: None, owner: PhantomData })
    }

    /// Bytes that are not handed out yet.
    #[must_use]
    pub fn left(&self) -> usize {
        self.left
    }
}

impl Carve<'_> {
    /// The start of the next `n` elements of `each` bytes. Not generic, so that all types share one function.
    #[expect(unsafe_code, reason = "steps through the buffer")]
    fn take(&mut self, each: usize, n: usize) -> Result<*mut u8> {
        let bytes = padded_bytes(each, n)?;
        if bytes > self.left {
            return Err(Error::WorkspaceTooSmall);
        }
        if bytes == 0 {
            // No memory is needed, but the address is aligned for any type.
            return Ok(core::ptr::without_provenance_mut(ALIGN));
        }
        let start = self.next;
        if self.fresh {
            // SAFETY: `bytes` bytes from `start` lie in the buffer that `self` borrows mutably for 'w.
            unsafe { start.write_bytes(0, bytes) };
        }
        // SAFETY: as above; `next` stays inside the buffer or one past its end.
        self.next = unsafe { start.add(bytes) };
        self.left -= bytes;
        Ok(start)
    }

    /// As [`Carve::take`]. After an error the number of elements is zero.
    fn take_part(&mut self, each: usize, n: usize) -> (*mut u8, usize) {
        match self.take(each, n) {
            Ok(start) if self.error.is_none() => (start, n),
            result => {
                self.error = self.error.or(result.err());
                (core::ptr::without_provenance_mut(ALIGN), 0)
            }
        }
    }
}

impl<'w> Space<'w> for Carve<'w> {
    #[inline]
    #[expect(unsafe_code, reason = "turns a checked part of the buffer into an array")]
    fn try_array<T: Plain>(&mut self, n: usize) -> Result<&'w mut [T]> {
        const { assert!(align_of::<T>() <= ALIGN) }
        if align_of::<T>() > self.align {
            return Err(Error::Misaligned);
        }
        let start = self.take(size_of::<T>(), n)?;
        // SAFETY: the range is in the buffer or empty, aligned for T (the start is, and all steps are multiples of ALIGN), initialised
        // (zeroed above, or initialised by the argument type of `reopen`), valid as `T: Plain`, and handed out once.
        Ok(unsafe { core::slice::from_raw_parts_mut(start.cast::<T>(), n) })
    }

    #[inline]
    #[expect(unsafe_code, reason = "turns a checked part of the buffer into an array")]
    fn array<T: Plain>(&mut self, n: usize) -> &'w mut [T] {
        const { assert!(align_of::<T>() <= ALIGN) }
        if align_of::<T>() > self.align {
            self.error = self.error.or(Some(Error::Misaligned));
        }
        let (start, n) = self.take_part(size_of::<T>(), n);
        // SAFETY: as in `try_array`; after an error n = 0, with an address aligned for any type.
        unsafe { core::slice::from_raw_parts_mut(start.cast::<T>(), n) }
    }

    fn finish(&self) -> Result<()> {
        self.error.map_or(Ok(()), Err)
    }
}

/// Finds the arrays of a prepared block again, read-only. Several threads may do so at the same time.
#[derive(Clone, Copy, Debug)]
pub struct View<'w> {
    rest: &'w [u8],
}

impl<'w> View<'w> {
    /// Starts at the beginning of `memory`.
    ///
    /// # Errors
    /// [`Error::Misaligned`]: `memory` does not start at a multiple of [`BLOCK_ALIGN`].
    pub fn new(memory: &'w [u8]) -> Result<Self> {
        if !memory.is_empty() && !memory.as_ptr().addr().is_multiple_of(BLOCK_ALIGN) {
            return Err(Error::Misaligned);
        }
        Ok(Self { rest: memory })
    }

    /// The next `n` elements with their content.
    ///
    /// # Errors
    /// [`Error::TooLarge`]: the size overflows. [`Error::WorkspaceTooSmall`]: not enough bytes are left.
    #[expect(unsafe_code, reason = "turns a checked part of the buffer into an array")]
    pub fn try_array<T: Plain>(&mut self, n: usize) -> Result<&'w [T]> {
        const { assert!(align_of::<T>() <= BLOCK_ALIGN) }
        let bytes = padded_bytes(size_of::<T>(), n)?;
        let (mine, rest) = self.rest.split_at_checked(bytes).ok_or(Error::WorkspaceTooSmall)?;
        self.rest = rest;
        if mine.is_empty() {
            return Ok(&[]);
        }
        // SAFETY: `mine` holds the bytes of n elements, starts at a multiple of BLOCK_ALIGN (the block does, and all steps are
        // multiples of it), is initialised, and any bytes are valid as `T: Plain`.
        Ok(unsafe { core::slice::from_raw_parts(mine.as_ptr().cast::<T>(), n) })
    }
}

// SAFETY: `Carve` is the mutable borrow of the buffer, which may move between threads.
#[expect(unsafe_code, reason = "an exclusive borrow of bytes")]
unsafe impl Send for Carve<'_> {}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    fn aligned(memory: &mut [u8], bytes: usize) -> &mut [u8] {
        let start = memory.as_ptr().align_offset(ALIGN);
        &mut memory[start..start + bytes]
    }

    #[test]
    fn measure_and_carve_agree_to_the_byte() {
        for n in [0, 1, 7, 8, 9, 63, 64, 65] {
            let layout = |space: &mut dyn FnMut(usize) -> Result<()>| space(n);
            let mut measure = Measure::default();
            layout(&mut |n| {
                measure.try_array::<f64>(n)?;
                measure.try_array::<[f32; 3]>(n)?;
                measure.try_array::<u8>(n).map(|_| ())
            })
            .unwrap();
            let bytes = measure.bytes();
            for short in [0, 1] {
                let mut memory = vec![0xAA_u8; bytes + ALIGN];
                let Some(given) = bytes.checked_sub(short) else { continue };
                let mut carve = Carve::new(aligned(&mut memory, given)).unwrap();
                let mut run = || {
                    let a = carve.try_array::<f64>(n)?;
                    let b = carve.try_array::<[f32; 3]>(n)?;
                    let c = carve.try_array::<u8>(n)?;
                    assert!(a.iter().all(|&v| v == 0.0) && b.len() == n && c.iter().all(|&v| v == 0));
                    Ok(())
                };
                assert_eq!(run(), if short == 0 { Ok(()) } else { Err(Error::WorkspaceTooSmall) });
            }
        }
    }

    #[test]
    fn refuses_misaligned_and_overflowing() {
        let mut memory = vec![0_u8; 256];
        let whole = aligned(&mut memory, 128);
        assert_eq!(Carve::new(&mut whole[1..]).err(), Some(Error::Misaligned));
        assert_eq!(Measure::default().try_array::<f64>(usize::MAX / 4).err(), Some(Error::TooLarge));
        assert_eq!(Measure::default().try_array::<u8>(usize::MAX).err(), Some(Error::TooLarge));
    }

    #[test]
    fn reopening_finds_what_was_left() {
        let mut memory = vec![0xAA_u8; 256 + ALIGN];
        let whole = aligned(&mut memory, 256);
        Carve::new(whole).unwrap().try_array::<u32>(5).unwrap().fill(7);
        let mut again = Carve::reopen(whole).unwrap();
        assert_eq!(again.try_array::<u32>(5).unwrap(), &[7; 5]);
    }
}
