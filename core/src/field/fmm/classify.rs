//! Which source boxes are well separated from a target box: lanes are source boxes.

use super::tree::Shape;
use crate::checked::Present;
use crate::real::Real;
use crate::simd::{Isa, Job, MAX_LANES, ROW};

/// The least number of lanes of a build that has this method.
pub(super) const LEAST_LANES: usize = 2;

/// Looks at some source boxes; returns how many there are to a pair of flags.
pub(super) struct Classify<'a, T> {
    /// The geometry of all source boxes, as a row each.
    pub shapes: &'a [[T; ROW]],
    pub boxes: &'a [u32],
    pub target: Shape<T>,
    /// The opening, and the least square of a distance between centres.
    pub opening: T,
    pub least: T,
    /// Of every vector of boxes the lanes that are well separated, with nothing mollified between them, and those that are no larger than the target box.
    pub flags: &'a mut [[u32; 2]],
}

impl<T: Real> Job<T> for Classify<'_, T> {
    type Out = usize;

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) -> usize {
        let Self { shapes, boxes, target, opening, least, flags } = self;
        let none = [T::ZERO; ROW];
        let (zero, opening_lanes) = (isa.splat(T::ZERO), isa.splat(opening));
        let (opening_square, least) = (isa.splat(opening * opening), isa.splat(least));
        let slack = isa.splat(T::ONE + T::from_f64(64.0) * T::EPSILON);
        let [target_x, target_y] = [isa.splat(target.centre[0]), isa.splat(target.centre[1])];
        let [target_half_x, target_half_y] = [isa.splat(target.half[0]), isa.splat(target.half[1])];
        let own = isa.splat(target.radius);
        for (flags, boxes) in flags.iter_mut().zip(boxes.chunks(I::LANES)) {
            let mut rows = [&none; MAX_LANES];
            for (row, &k) in rows.iter_mut().zip(boxes) {
                *row = shapes.get(k as usize).present_or(&none);
            }
            let [x, y, half_x, half_y, radius, reach, _, _] = isa.columns(&rows);
            let (dx, dy) = (isa.sub(x, target_x), isa.sub(y, target_y));
            let square = isa.mul_add(dx, dx, isa.mul(dy, dy));
            let sum = isa.select(
                isa.lt(own, radius),
                isa.mul_add(opening_lanes, own, radius),
                isa.mul_add(opening_lanes, radius, own),
            );
            let separate = isa.bits(isa.lt(isa.mul(sum, sum), isa.mul(opening_square, square)));
            let apart = isa.bits(isa.lt(least, square));
            let gap_x = isa.sub(isa.sub(isa.abs(dx), half_x), target_half_x);
            let gap_y = isa.sub(isa.sub(isa.abs(dy), half_y), target_half_y);
            let gap_x = isa.select(isa.lt(zero, gap_x), gap_x, zero);
            let gap_y = isa.select(isa.lt(zero, gap_y), gap_y, zero);
            let gap = isa.mul_add(gap_x, gap_x, isa.mul(gap_y, gap_y));
            let support = isa.mul(reach, slack);
            let clear = isa.bits(isa.lt(isa.mul(support, support), gap)) | !isa.bits(isa.lt(zero, reach));
            *flags = [separate & apart & clear, !isa.bits(isa.lt(own, radius))];
        }
        I::LANES
    }
}
