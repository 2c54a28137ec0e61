//! Which element of an input is not finite.

use mollis_core::Real;
use mollis_core::Result;

use crate::buffers::{Input, Output, disjoint};
use crate::diagnostics::put;

/// No element is bad.
pub const MOLLIS_NONE_BAD: u64 = u64::MAX;

/// The first index at which a point or a number is not finite.
pub(crate) fn first_bad<T: Real, const D: usize>(points: &[[T; D]], numbers: &[T]) -> Option<usize> {
    let point = points.iter().position(|x| !x.iter().all(|c| c.is_finite()));
    let number = numbers.iter().position(|v| !v.is_finite());
    point.into_iter().chain(number).min()
}

pub(crate) unsafe fn search<T: Real>(n: usize, each: usize, values: *const T, first: *mut u64) -> Result<()> {
    let all = n.checked_mul(each).ok_or(mollis_core::Error::TooLarge)?;
    let (values, first) = (Input::new(values, all)?, Output::new(first, 1)?);
    disjoint(&[Some(first.range())], &[values.range()])?;
    // SAFETY: the caller promises the crate's contract; the output overlaps nothing.
    unsafe {
        let bad = values.slice().iter().position(|v| !v.is_finite()).and_then(|index| index.checked_div(each));
        put(Some(first), bad.map_or(MOLLIS_NONE_BAD, |index| index as u64));
    }
    Ok(())
}
