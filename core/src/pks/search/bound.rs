//! Lower bounds of second moments, which say of most large cells that nothing can collide in them.

use crate::real::{Real, Scalar};

/// Bounds of second moments from the keys of the particles.
#[derive(Clone, Copy)]
pub struct Bound<'a, T> {
    /// Where the buckets begin, and the end of the last.
    pub starts: &'a [u32],
    /// Sums of the coordinates of the keys and of their squares, over all buckets before each.
    pub sums: &'a [[u64; 3]],
    /// Side of the cells of the keys.
    pub width: f64,
    /// The smallest mass.
    pub smallest: T,
}

impl<T: Real> Bound<'_, T> {
    /// A lower bound of `sum m |x - c|^2` over the particles from `first` to `end` in the order, if they are all of some buckets.
    ///
    /// No mass is below the smallest, and no point is a better centre than their mean. Particles lie anywhere in the cells that their keys
    /// stand for; these offsets deviate from their own mean by at most half a width along each axis, 0.71 widths in all, which is the most that they take
    /// off the root mean square (Minkowski). The rest of a width is for the rounding of coordinates.
    pub fn spread(&self, first: u32, end: u32) -> Option<T> {
        let from = self.starts.partition_point(|&start| start <= first).checked_sub(1)?;
        let to = self.starts.partition_point(|&start| start < end);
        if self.starts.get(from) != Some(&first) || self.starts.get(to) != Some(&end) {
            return None;
        }
        let (a, b) = (self.sums.get(from)?, self.sums.get(to)?);
        let of = |a: u64, b: u64| b.wrapping_sub(a) as f64;
        let (x, y, squares) = (of(a[0], b[0]), of(a[1], b[1]), of(a[2], b[2]));
        let count = f64::from(end - first);
        let variance = ((squares - (x * x + y * y) / count) / count).max(0.0);
        let deviation = (Scalar::sqrt(variance) - 1.0).max(0.0) * self.width;
        // A margin for roundings.
        Some(T::from_f64(0.99 * count * deviation * deviation * self.smallest.to_f64()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_of_whole_buckets_only() {
        // Keys (0, 0), (0, 10) in the first bucket, none in the second, (30, 0), (30, 10), (30, 20) in the third.
        let (starts, sums) = ([0, 2, 2, 5], [[0; 3], [0, 10, 100], [0, 10, 100], [90, 40, 3300]]);
        let bound = Bound { starts: &starts, sums: &sums, width: 0.5, smallest: 2.0 };
        for (first, end, squares) in [(0, 2, 50.0), (2, 5, 200.0), (0, 5, 1360.0_f64)] {
            let count = f64::from(end - first);
            let want = 0.99 * 2.0 * count * (0.5 * ((squares / count).sqrt() - 1.0)).powi(2);
            assert!((bound.spread(first, end).unwrap() / want - 1.0).abs() < 1e-12, "{first} {end}");
        }
        assert!(bound.spread(1, 5).is_none() && bound.spread(0, 4).is_none());
    }
}
