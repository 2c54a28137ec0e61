//! Tables of polynomials that each lane reads at a place of its own.
//!
//! The argument's exponent and the leading [`PANEL_BITS`] bits of its significand name the row, so finding it takes neither a root nor
//! a logarithm nor a division, and taking the number modulo [`ROWS`] can't leave the table. A row is one cache line of f64.

/// Numbers in a row.
pub const ROW: usize = 8;
/// An octave of the argument has 2^this rows.
pub const PANEL_BITS: u32 = 6;
/// Octaves that a table holds.
pub const OCTAVES: u32 = 64;
/// Rows of a table: a power of two.
pub const ROWS: usize = (OCTAVES as usize) << PANEL_BITS;

/// A table. The row of u is the number that its exponent and leading bits make, modulo [`ROWS`].
pub type Rows<T> = [[T; ROW]; ROWS];
