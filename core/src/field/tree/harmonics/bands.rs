//! How matrices are stored.

/// Rows of a band. Matrices are stored in bands of so many rows, the last one of fewer, and a band column by column.
pub(super) const BAND: usize = 4;

/// Where a number of a matrix is.
pub(super) fn place((row, column): (usize, usize), rows: usize, columns: usize) -> usize {
    let band = row / BAND;
    let height = if rows - band * BAND < BAND { rows - band * BAND } else { BAND };
    band * BAND * columns + column * height + row % BAND
}
