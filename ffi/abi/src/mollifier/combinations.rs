//! Richardson combinations.

use mollis_core::mollifier::{MAX_COMBINED, Richardson};
use mollis_core::{Error, Real, Result};

use super::mollis_mollifier;
use super::radii::{Outputs, each_radius};
use crate::buffers::{Input, Output, disjoint};

#[expect(clippy::too_many_arguments, reason = "one optional output each")]
pub(crate) unsafe fn combination<T: Real, const D: usize>(
    mollifier: mollis_mollifier,
    delta: T,
    n_radii: usize,
    radii: *const T,
    weights: *mut T,
    n: usize,
    r: *const T,
    outputs: Outputs<T>,
) -> Result<()> {
    if !(1..=MAX_COMBINED).contains(&n_radii) {
        return Err(Error::LengthMismatch);
    }
    let radii = Input::new(radii, n_radii)?;
    let weights = Output::optional(weights, n_radii)?;
    // `each_radius` checks its own buffers; here those that only this function has, against all.
    let mut inputs = [radii.range(); 2 + 6];
    if let Some(slot) = inputs.get_mut(1) {
        *slot = Input::new(r, n)?.range();
    }
    let mut ranges = [None; 6];
    for (range, pointer) in ranges.iter_mut().zip(outputs) {
        *range = Output::optional(pointer, n)?.map(Output::range);
    }
    for (input, range) in inputs.iter_mut().skip(2).zip(ranges.iter().flatten()) {
        *input = *range;
    }
    disjoint(&[weights.map(Output::range)], &inputs)?;
    disjoint(&ranges, &[radii.range()])?;
    // SAFETY: the caller promises the crate's contract.
    let combination = Richardson::<T, D>::new(mollifier.to_core()?, delta, unsafe { radii.slice() })?;
    // SAFETY: as above.
    unsafe { each_radius(n, r, outputs, || Ok(|quantity, r| combination.evaluate(quantity, r)))? };
    if let Some(weights) = weights {
        // SAFETY: as above, and the weights overlap nothing.
        for (slot, weight) in unsafe { weights.slice() }.iter_mut().zip(combination.weights()) {
            *slot = weight;
        }
    }
    Ok(())
}
