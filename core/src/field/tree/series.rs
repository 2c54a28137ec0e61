//! What the passes over the cells ask of a series in which fields are expanded.

use crate::real::Real;
use crate::simd::{Isa, Level, MAX_LANES};

/// Where a cell is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<T> {
    pub centre: [T; 3],
    /// One over half the width.
    pub per_half: T,
    /// What coordinates are multiplied by first.
    pub factor: T,
}

/// The vectors of some points' coordinates in their cell; lanes beyond the last point hold zeros.
#[inline(always)]
pub(super) fn load_points<T: Real, I: Isa<T>, const N: usize>(
    isa: I,
    points: &[T],
    dimension: usize,
    frame: &Frame<T>,
) -> [[I::V; N]; 3] {
    let mut vectors = [[isa.splat(T::ZERO); N]; 3];
    let (inverse, dimension) = (isa.splat(frame.per_half), dimension.max(1));
    for (axis, (vectors, &centre)) in vectors.iter_mut().zip(&frame.centre).enumerate().take(dimension) {
        for (vector, points) in vectors.iter_mut().zip(points.chunks((I::LANES * dimension).max(1))) {
            let mut lanes = [centre; MAX_LANES];
            let coordinates = points.iter().skip(axis).step_by(dimension);
            lanes.iter_mut().zip(coordinates).for_each(|(to, &x)| *to = x * frame.factor);
            *vector = isa.mul(isa.sub(isa.load(&lanes), isa.splat(centre)), inverse);
        }
    }
    vectors
}

/// The cell from which, the one to which, and a set of axes, one bit each.
pub(super) type Pair = [u32; 3];

/// The targets of a leaf and their results, which are added to.
pub(super) struct Targets<'a, T> {
    pub points: &'a [T],
    pub frame: Frame<T>,
    pub potential: Option<&'a mut [T]>,
    pub gradient: Option<&'a mut [T]>,
}

/// A series: *moments* of the sources of a cell, which say what their field is far away, and a *local expansion* of the field in a cell.
///
/// Scratch is [`Series::scratch`] numbers, and garbage afterwards.
pub(super) trait Series<T: Real>: Sync {
    /// Numbers of an expansion, as it is stored.
    fn stride(&self) -> usize;

    /// Numbers of scratch.
    fn scratch(&self) -> usize;

    /// Adds the moments of sources.
    fn moments(&self, sources: (&[T], &[T]), frame: Frame<T>, outputs: (&mut [T], &mut [T]), level: Level);

    /// Adds the moments of parts to those of the cells around them, or the local expansions of cells to those of their parts (`down`). The axes of a pair are those along which the part is the upper
    /// half.
    fn shift(&self, down: bool, pairs: &[Pair], arrays: (&[T], &mut [T], &mut [T]), level: Level);

    /// Adds the values of a local expansion.
    fn values(&self, from: &[T], to: Targets<'_, T>, scratch: &mut [T], level: Level);
}
