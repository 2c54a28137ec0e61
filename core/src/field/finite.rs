//! Whether all numbers of an input are finite.

use crate::build;
use crate::real::Real;
use crate::simd::{Level, Loops, with_simd};

/// Whether all numbers are finite.
pub(super) fn finite<T: Real>(numbers: &[T], level: Level) -> bool {
    if !build::TILES {
        return numbers.iter().all(|x| x.is_finite());
    }
    struct Finite<'a, T>(&'a [T]);
    impl<T: Real> Loops for Finite<'_, T> {
        type Out = bool;
        #[inline(always)]
        fn run(self) -> bool {
            // no early exit within a piece, so that its loop runs in lanes: 0 x is 0 or NaN
            self.0.chunks(256).all(|piece| {
                let (lanes, rest) = piece.as_chunks::<16>();
                let mut sums = [T::ZERO; 16];
                for lane in lanes {
                    sums.iter_mut().zip(lane).for_each(|(s, &x)| *s += x * T::ZERO);
                }
                sums.iter().chain(rest).all(|x| x.is_finite())
            })
        }
    }
    with_simd(level, Finite(numbers))
}
