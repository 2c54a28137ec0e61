//! A caller's arrays at constant strides: arrays of structures, columns, and arrays of their own.

use core::ptr::NonNull;

use mollis_core::memory::Plain;
use mollis_core::{Error, Real, Result};

use crate::buffers::{Input, Output, Range};

/// `n` numbers, each `stride` numbers after the one before.
#[derive(Clone, Copy)]
pub(crate) struct Column<T> {
    start: NonNull<T>,
    stride: usize,
    n: usize,
}

impl<T: Plain> Column<T> {
    /// Checks null, alignment and size; a stride of 0 is 1.
    pub(crate) fn new(pointer: *mut T, stride: usize, n: usize) -> Result<Self> {
        let stride = stride.max(1);
        let span = if n > 0 { (n - 1).checked_mul(stride).and_then(|last| last.checked_add(1)) } else { Some(0) };
        let all = Output::new(pointer, span.ok_or(Error::TooLarge)?)?;
        Ok(Self { start: all.start(), stride, n })
    }

    /// As [`Column::new`]; null means "not there".
    pub(crate) fn optional(pointer: *mut T, stride: usize, n: usize) -> Result<Option<Self>> {
        if pointer.is_null() { Ok(None) } else { Self::new(pointer, stride, n).map(Some) }
    }

    /// Whether the numbers follow one another.
    pub(crate) fn is_dense(&self) -> bool {
        self.stride == 1
    }

    /// How many numbers a copy takes: none of an array without gaps.
    // Inlined, it may be computed for an array that is not there, before that is asked: no harm, but a checker of memory reports it.
    #[inline(never)]
    pub(crate) fn copied(&self) -> usize {
        if self.is_dense() { 0 } else { self.n }
    }

    pub(crate) fn extent(&self) -> Extent {
        let each = size_of::<T>();
        Extent { start: self.start.addr().get(), each, stride: self.stride.wrapping_mul(each), n: self.n }
    }

    /// The numbers, which follow one another, to read.
    ///
    /// # Safety
    /// The crate's contract, and [`Column::is_dense`].
    pub(crate) unsafe fn array<'a>(self) -> &'a [T] {
        // SAFETY: passed on.
        unsafe { core::slice::from_raw_parts(self.start.as_ptr(), self.n) }
    }

    /// The same, to write.
    ///
    /// # Safety
    /// The crate's contract, and [`Column::is_dense`].
    pub(crate) unsafe fn array_mut<'a>(self) -> &'a mut [T] {
        // SAFETY: passed on.
        unsafe { core::slice::from_raw_parts_mut(self.start.as_ptr(), self.n) }
    }

    /// The addresses of the numbers.
    fn pointers(self) -> impl Iterator<Item = *mut T> {
        // Within the span that `new` has checked.
        (0..self.n).map(move |i| self.start.as_ptr().wrapping_add(i.wrapping_mul(self.stride)))
    }

    /// Copies the numbers to an array.
    ///
    /// # Safety
    /// The crate's contract for the column.
    pub(crate) unsafe fn gather(self, to: &mut [T]) {
        for (to, from) in to.iter_mut().zip(self.pointers()) {
            // SAFETY: in the span that was checked; the caller promises numbers there.
            *to = unsafe { from.read() };
        }
    }
}

/// How results reach a caller's numbers.
#[derive(Clone, Copy)]
pub(crate) struct Way {
    pub factor: f64,
    pub add: bool,
}

impl Way {
    pub(crate) const PLAIN: Self = Self { factor: 1.0, add: false };

    /// Results as they are, in place of what was there.
    pub(crate) fn is_plain(self) -> bool {
        self.factor.to_bits() == 1.0_f64.to_bits() && !self.add
    }
}

impl<T: Real> Column<T> {
    /// Brings results to the caller.
    ///
    /// # Safety
    /// The crate's contract for the column.
    pub(crate) unsafe fn scatter(self, from: impl Iterator<Item = T>, way: Way) {
        for (from, to) in from.zip(self.pointers()) {
            // In double precision, as the factor may be beyond single precision where the product is not.
            let result = T::from_wide(way.factor * from.to_f64());
            // SAFETY: in the span that was checked; the caller promises numbers there.
            unsafe { to.write(if way.add { to.read() + result } else { result }) };
        }
    }
}

/// Points: a column for each coordinate.
#[derive(Clone, Copy)]
pub(crate) struct Points<T, const D: usize>([Column<T>; D]);

impl<T: Plain, const D: usize> Points<T, D> {
    /// Points whose coordinates begin at `pointers`. If all but the first are null, the coordinates of a point follow one another. A stride of 0 is that of arrays without
    /// gaps.
    pub(crate) fn new(pointers: [*mut T; D], stride: usize, n: usize) -> Result<Self> {
        let [first, others @ ..] = pointers.as_slice() else { return Err(Error::Dimension) };
        let together = others.iter().all(|pointer| pointer.is_null());
        let stride = match stride {
            0 if together => D,
            // Coordinates of one point would be those of the next.
            stride if together && stride < D && n > 1 => return Err(Error::OutOfDomain),
            stride => stride,
        };
        let mut columns = [Column::new(*first, stride, n)?; D];
        for (k, (column, &pointer)) in columns.iter_mut().zip(&pointers).enumerate().skip(1) {
            // A first pointer that is null, without points, stays null.
            let pointer = if together && !first.is_null() { first.wrapping_add(k) } else { pointer };
            *column = Column::new(pointer, stride, n)?;
        }
        Ok(Self(columns))
    }

    /// As [`Points::new`]; null pointers mean "not there".
    pub(crate) fn optional(pointers: [*mut T; D], stride: usize, n: usize) -> Result<Option<Self>> {
        if pointers.iter().all(|pointer| pointer.is_null()) {
            Ok(None)
        } else {
            Self::new(pointers, stride, n).map(Some)
        }
    }

    /// Whether they are an array `[n][D]`.
    pub(crate) fn is_dense(&self) -> bool {
        let start = self.0.first().map(|column| column.start.as_ptr());
        let follows =
            |(k, column): (usize, &Column<T>)| start.map(|start| start.wrapping_add(k)) == Some(column.start.as_ptr());
        self.0.iter().all(|column| column.stride == D || column.n == 0)
            && (self.0.iter().enumerate().all(follows) || self.is_empty())
    }

    /// How many points a copy takes: none of an array without gaps. Not inlined, as [`Column::copied`].
    #[inline(never)]
    pub(crate) fn copied(&self) -> usize {
        if self.is_dense() { 0 } else { self.start().1 }
    }

    fn is_empty(&self) -> bool {
        self.0.iter().all(|column| column.n == 0)
    }

    pub(crate) fn extents(&self) -> impl Iterator<Item = Extent> {
        self.0.iter().map(Column::extent)
    }

    fn start(&self) -> (*mut [T; D], usize) {
        self.0.first().map_or((NonNull::dangling().as_ptr(), 0), |column| (column.start.as_ptr().cast(), column.n))
    }

    /// The points, which are an array, to read.
    ///
    /// # Safety
    /// The crate's contract, and [`Points::is_dense`].
    pub(crate) unsafe fn array<'a>(self) -> &'a [[T; D]] {
        let (start, n) = self.start();
        // SAFETY: passed on; the span of the last column ends where the last point does.
        unsafe { core::slice::from_raw_parts(start, n) }
    }

    /// The same, to write.
    ///
    /// # Safety
    /// The crate's contract, and [`Points::is_dense`].
    pub(crate) unsafe fn array_mut<'a>(self) -> &'a mut [[T; D]] {
        let (start, n) = self.start();
        // SAFETY: passed on; the span of the last column ends where the last point does.
        unsafe { core::slice::from_raw_parts_mut(start, n) }
    }

    /// Copies the points to an array.
    ///
    /// # Safety
    /// The crate's contract for the columns.
    pub(crate) unsafe fn gather(self, to: &mut [[T; D]]) {
        for (k, column) in self.0.into_iter().enumerate() {
            for (to, from) in to.iter_mut().filter_map(|to| to.get_mut(k)).zip(column.pointers()) {
                // SAFETY: in the span that was checked; the caller promises numbers there.
                *to = unsafe { from.read() };
            }
        }
    }
}

impl<T: Real, const D: usize> Points<T, D> {
    /// Brings results to the caller.
    ///
    /// # Safety
    /// The crate's contract for the columns.
    pub(crate) unsafe fn scatter(self, from: &[[T; D]], way: Way) {
        for (k, column) in self.0.into_iter().enumerate() {
            // SAFETY: passed on.
            unsafe { column.scatter(from.iter().filter_map(|from| from.get(k)).copied(), way) };
        }
    }
}

/// Matrices of D rows, which follow one another, each `stride` numbers after the one before.
#[derive(Clone, Copy)]
pub(crate) struct Matrices<T, const D: usize> {
    start: NonNull<T>,
    stride: usize,
    n: usize,
}

impl<T: Real, const D: usize> Matrices<T, D> {
    /// As [`Column::optional`]; a stride of 0 is that of arrays without gaps.
    pub(crate) fn optional(pointer: *mut T, stride: usize, n: usize) -> Result<Option<Self>> {
        if pointer.is_null() {
            return Ok(None);
        }
        let stride = match stride {
            0 => D * D,
            stride if stride < D * D && n > 1 => return Err(Error::OutOfDomain),
            stride => stride,
        };
        let span = if n > 0 { (n - 1).checked_mul(stride).and_then(|last| last.checked_add(D * D)) } else { Some(0) };
        let all = Output::new(pointer, span.ok_or(Error::TooLarge)?)?;
        Ok(Some(Self { start: all.start(), stride, n }))
    }

    pub(crate) fn is_dense(&self) -> bool {
        self.stride == D * D
    }

    /// How many matrices a copy takes. Not inlined, as [`Column::copied`].
    #[inline(never)]
    pub(crate) fn copied(&self) -> usize {
        if self.is_dense() { 0 } else { self.n }
    }

    pub(crate) fn extent(&self) -> Extent {
        let each = size_of::<T>();
        let (start, stride) = (self.start.addr().get(), self.stride.wrapping_mul(each));
        Extent { start, each: D * D * each, stride, n: self.n }
    }

    /// The matrices, which follow one another, to write.
    ///
    /// # Safety
    /// The crate's contract, and [`Matrices::is_dense`].
    pub(crate) unsafe fn array_mut<'a>(self) -> &'a mut [[[T; D]; D]] {
        // SAFETY: passed on.
        unsafe { core::slice::from_raw_parts_mut(self.start.as_ptr().cast(), self.n) }
    }

    /// Brings results to the caller.
    ///
    /// # Safety
    /// The crate's contract for the matrices.
    pub(crate) unsafe fn scatter(self, from: &[[[T; D]; D]], way: Way) {
        for k in 0..D * D {
            // SAFETY: within the span that was checked.
            let start = unsafe { self.start.add(k) };
            let column = Column { start, stride: self.stride, n: self.n };
            // SAFETY: passed on.
            unsafe { column.scatter(from.iter().filter_map(|from| from.as_flattened().get(k)).copied(), way) };
        }
    }
}

/// The caller's points where they are an array, else a copy.
///
/// # Safety
/// The crate's contract for the points.
pub(crate) unsafe fn gathered<T: Real, const D: usize>(points: Points<T, D>, to: &mut [[T; D]]) -> &[[T; D]]
where
    [T; D]: Plain,
{
    // SAFETY: passed on.
    unsafe {
        if points.is_dense() {
            return points.array();
        }
        points.gather(to);
    }
    to
}

/// As [`gathered`].
///
/// # Safety
/// The crate's contract for the column.
pub(crate) unsafe fn gathered_column<T: Real>(column: Column<T>, to: &mut [T]) -> &[T] {
    // SAFETY: passed on.
    unsafe {
        if column.is_dense() {
            return column.array();
        }
        column.gather(to);
    }
    to
}

/// The bytes of a column, for overlap checks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    start: usize,
    /// Bytes of an element, and from one to the next.
    each: usize,
    stride: usize,
    n: usize,
}

impl From<Range> for Extent {
    fn from(range: Range) -> Self {
        let (start, bytes) = range.parts();
        Self { start, each: bytes, stride: bytes, n: usize::from(bytes > 0) }
    }
}

impl Extent {
    fn end(&self) -> usize {
        // Checked when the column was made.
        self.start.wrapping_add(self.n.wrapping_sub(1).wrapping_mul(self.stride)).wrapping_add(self.each)
    }

    /// Whether they share a byte. Columns of the same stride, and single elements, may lie within each other, as members of an array of structures do; those of different
    /// strides are taken to meet where their ranges do.
    fn meets(&self, other: &Self) -> bool {
        if self.n == 0 || other.n == 0 || self.end() <= other.start || other.end() <= self.start {
            return false;
        }
        let stride = if self.n == 1 { other.stride } else { self.stride };
        if self.n > 1 && other.n > 1 && self.stride != other.stride {
            return true;
        }
        // From an element of the other column to the next one of this.
        let apart = |from: usize, to: usize| to.wrapping_sub(from).checked_rem(stride);
        let after = if self.start >= other.start {
            apart(other.start, self.start)
        } else {
            apart(self.start, other.start).map(|before| if before == 0 { 0 } else { stride.wrapping_sub(before) })
        };
        after.is_none_or(|after| after < other.each || stride.wrapping_sub(after) < self.each)
    }
}

/// Refuses outputs that share a byte with each other or with an input.
pub(crate) fn apart(outputs: &[Extent], inputs: &[Extent]) -> Result<()> {
    let mut left = outputs;
    while let Some((output, later)) = left.split_first() {
        left = later;
        if later.iter().chain(inputs).any(|other| output.meets(other)) {
            return Err(Error::Overlap);
        }
    }
    Ok(())
}

/// A list of extents without a heap.
pub(crate) struct Extents {
    list: [Extent; 24],
    n: usize,
}

impl Extents {
    pub(crate) fn new() -> Self {
        Self { list: [Extent { start: 0, each: 0, stride: 0, n: 0 }; 24], n: 0 }
    }

    /// Adds some; there is room for what a call has.
    pub(crate) fn add(&mut self, extents: impl IntoIterator<Item = Extent>) -> &mut Self {
        for extent in extents {
            debug_assert!(self.n < self.list.len(), "more arrays than a call has");
            if let Some(slot) = self.list.get_mut(self.n) {
                *slot = extent;
                self.n += 1;
            }
        }
        self
    }

    pub(crate) fn as_slice(&self) -> &[Extent] {
        self.list.get(..self.n).unwrap_or(&[])
    }
}

/// Copies a structure of a caller's out, or refuses the pointer.
///
/// # Safety
/// The crate's contract for `pointer`.
pub(crate) unsafe fn fetch<X: Copy>(pointer: *const X) -> Result<X> {
    if pointer.is_null() {
        return Err(Error::NullPointer);
    }
    if !pointer.is_aligned() {
        return Err(Error::Misaligned);
    }
    // SAFETY: not null, aligned, and the caller promises an initialised value there.
    Ok(unsafe { pointer.read() })
}

/// The bytes of a structure of the caller's.
pub(crate) fn of_structure<X>(pointer: *const X) -> Result<Extent> {
    Ok(Input::new(pointer.cast::<u8>(), size_of::<X>())?.range().into())
}
