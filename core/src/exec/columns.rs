//! Division of a matrix among tasks by blocks of columns.

use core::marker::PhantomData;

use super::Partition;

/// A matrix stored by rows of `pitch` elements, divided into blocks of `each` columns. The last block may be narrower.
#[derive(Debug)]
pub struct Columns<'a, T> {
    start: *mut T,
    rows: usize,
    pitch: usize,
    each: usize,
    owner: PhantomData<&'a mut [T]>,
}

impl<'a, T> Columns<'a, T> {
    /// Divides the whole rows of `matrix` into blocks of `each` columns.
    pub fn new(matrix: &'a mut [T], pitch: usize, each: usize) -> Self {
        let rows = matrix.len().checked_div(pitch).unwrap_or(0);
        Self { start: matrix.as_mut_ptr(), rows, pitch, each, owner: PhantomData }
    }
}

// SAFETY: a `Columns` is the mutable borrow of a slice; pieces reach other threads, so `T: Send`.
#[expect(unsafe_code, reason = "an exclusive borrow, handed out in disjoint pieces")]
unsafe impl<T: Send> Sync for Columns<'_, T> {}
// SAFETY: as above.
#[expect(unsafe_code, reason = "an exclusive borrow, handed out in disjoint pieces")]
unsafe impl<T: Send> Send for Columns<'_, T> {}

/// One block of columns.
#[derive(Debug)]
pub struct Block<'a, T> {
    start: *mut T,
    rows: usize,
    pitch: usize,
    width: usize,
    owner: PhantomData<&'a mut [T]>,
}

impl<T> Block<'_, T> {
    /// The block's part of row `j`; empty for j beyond the last row.
    #[inline(always)]
    #[expect(unsafe_code, reason = "a part of a row, within the bounds that were checked")]
    pub fn row(&mut self, j: usize) -> &mut [T] {
        if j >= self.rows {
            return &mut [];
        }
        // SAFETY: j < rows and the block's columns are within the pitch, so the range is in the matrix. The block owns
        // these columns, and `&mut self` allows one row of it to be borrowed at a time.
        unsafe { core::slice::from_raw_parts_mut(self.start.add(j * self.pitch), self.width) }
    }
}

// SAFETY: blocks of different index hold different columns.
#[expect(unsafe_code, reason = "disjoint columns of one matrix")]
unsafe impl<T: Send + 'static> Partition for Columns<'_, T> {
    type Piece<'p> = Block<'p, T>;

    unsafe fn piece<'p>(&self, index: usize) -> Block<'p, T> {
        let from = index.saturating_mul(self.each).min(self.pitch);
        let width = self.each.min(self.pitch - from);
        let rows = if width == 0 { 0 } else { self.rows };
        // Without rows the matrix may be empty, and adding an offset would leave it.
        let from = if rows == 0 { 0 } else { from };
        // SAFETY: from < pitch and there is at least one row, or from = 0.
        let start = unsafe { self.start.add(from) };
        Block { start, rows, pitch: self.pitch, width, owner: PhantomData }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::Serial;
    use crate::exec::par_chunks;
    use std::vec;

    #[test]
    fn every_element_of_every_whole_row_once() {
        for (rows, pitch, each, extra) in
            [(3, 10, 4, 0), (1, 1, 1, 0), (5, 16, 16, 3), (2, 7, 100, 1), (0, 4, 2, 3), (3, 5, 0, 0)]
        {
            let mut matrix = vec![0_u32; rows * pitch + extra];
            let tasks = if each == 0 { 1 } else { pitch.div_ceil(each) + 1 };
            par_chunks(&Serial, tasks, Columns::new(&mut matrix, pitch, each), (), &|task, mut block, ()| {
                for j in 0..rows + 2 {
                    block.row(j).iter_mut().for_each(|v| *v += 1 + task as u32);
                }
                Ok(())
            })
            .unwrap();
            let whole = if each == 0 { 0 } else { rows * pitch };
            for (i, &v) in matrix.iter().enumerate() {
                assert_eq!(v, if i < whole { 1 + (i % pitch / each) as u32 } else { 0 });
            }
        }
        let mut none: [u8; 3] = [0; 3];
        par_chunks(&Serial, 1, Columns::new(&mut none, 0, 4), (), &|_, mut block, ()| {
            assert!(block.row(0).is_empty());
            Ok(())
        })
        .unwrap();
    }
}
