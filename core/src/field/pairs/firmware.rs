//! The entry point of firmware: the Newtonian sum, by [`single`].

use super::newtonian::Newtonian;
use super::{Call, single};
use crate::error::{Error, Result};
use crate::exec::Run;
use crate::field::{Accumulation, Interaction, Options};
use crate::real::Real;

/// Overwrites the outputs with the sum over all pairs. Not `FULL`: no potential is wanted, and the options are the defaults.
pub(in crate::field) fn evaluate<T: Real, const D: usize, const FULL: bool>(
    kernel: &dyn Interaction<T, D>,
    call: Call<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let (coefficient, blob) = kernel.newtonian().ok_or(Error::Unsupported)?;
    let Options { accumulation, combination: (a, b), .. } = *call.options;
    if call.sources.radii.is_some() || call.sources.strengths.is_some() {
        return Err(Error::Unsupported);
    }
    let turned = (a.to_bits(), b.to_bits()) != (1.0_f64.to_bits(), 0);
    if !FULL && (call.outputs.potential.is_some() || turned || accumulation != Accumulation::Blocked) {
        return Err(Error::Unsupported);
    }
    single::sums::<T, D, FULL>(
        &Newtonian { blob, coefficient, largest: blob.delta(), table: None },
        call,
        workspace,
        run,
    )
}
