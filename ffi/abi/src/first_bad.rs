//! Which element of an input is not finite.

use mollis_core::Real;
use mollis_core::Result;

use crate::buffers::{Input, Output, disjoint};
use crate::diagnostics::put;
use crate::status::{mollis_status, status};

/// No element is bad.
pub const MOLLIS_NONE_BAD: u64 = u64::MAX;

/// The first index at which a point or a number is not finite.
pub(crate) fn first_bad<T: Real, const D: usize>(points: &[[T; D]], numbers: &[T]) -> Option<usize> {
    let point = points.iter().position(|x| !x.iter().all(|c| c.is_finite()));
    let number = numbers.iter().position(|v| !v.is_finite());
    point.into_iter().chain(number).min()
}

unsafe fn search<T: Real>(n: usize, each: usize, values: *const T, first: *mut u64) -> Result<()> {
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

/// Writes the index of the first of n elements of `each` numbers (n points in D dimensions: `each` is D) that holds one that is not finite, or
/// `MOLLIS_NONE_BAD`: which element a function meant that returned `MOLLIS_ERR_NOT_FINITE` and takes no `mollis_run` to tell it.
///
/// Refused, with `first` as it was: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
///
/// # Safety
/// The contract of this header.
#[cfg(feature = "double")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_first_bad_eval(
    n: usize,
    each: usize,
    values: *const f64,
    first: *mut u64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { search(n, each, values, first) })
}

/// As `mollis_first_bad_eval`, in float.
///
/// # Safety
/// The contract of this header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_first_bad_eval_f32(
    n: usize,
    each: usize,
    values: *const f32,
    first: *mut u64,
) -> mollis_status {
    // SAFETY: the crate's contract.
    status(unsafe { search(n, each, values, first) })
}
