//! Tables of polynomials. Each lane reads its own row.
//!
//! The row index consists of the argument's exponent and the leading [`PANEL_BITS`] bits of its significand. Computing it needs no root,
//! logarithm or division, and the index modulo [`ROWS`] is always inside the table. A row is one cache line of f64.

/// Numbers in a row.
pub const ROW: usize = 8;
/// An octave of the argument has 2 to this power rows.
pub const PANEL_BITS: u32 = 6;
/// Number of octaves of a table.
pub const OCTAVES: u32 = 64;
/// Number of rows of a table, a power of two.
pub const ROWS: usize = (OCTAVES as usize) << PANEL_BITS;

/// A table. The row of u has the index formed by its exponent and leading bits, modulo [`ROWS`].
pub type Rows<T> = [[T; ROW]; ROWS];

/// The addresses of the first rows. (`array::map` is not always put in line, and then compiled for the baseline processor.)
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(super) fn starts<T, const N: usize>(rows: &[&[T; ROW]; super::MAX_LANES]) -> [*const T; N] {
    let mut starts = [core::ptr::null(); N];
    starts.iter_mut().zip(rows).for_each(|(start, row)| *start = row.as_ptr());
    starts
}
