//! Sums that need no pair, or only near ones: which of them serves a kernel, and the way to it.

use super::{Interaction, Method, Options, Outputs, Plan, Reason, Run, Sources, Wanted, moments, neighbours, sorted};
use crate::error::{Error, Result};
use crate::kernel::{Far, Kernel};
use crate::mollifier::Mollifier;
use crate::real::Real;

/// Fewer pairs than this are faster one by one than sorted.
const FEW_PAIRS: usize = 2048;

/// A method that can serve a sum.
enum Skip<T> {
    Moments(Far<T>),
    Sorted(Far<T>),
    Neighbours,
}

impl<T> Skip<T> {
    fn method(&self) -> (Method, Reason) {
        match self {
            Skip::Moments(_) => (Method::Moments, Reason::EvenPowers),
            Skip::Sorted(_) => (Method::Sorted, Reason::OneDimension),
            Skip::Neighbours => (Method::Neighbours, Reason::CompactLaplacian),
        }
    }
}

fn skip<T: Real, const D: usize>(kernel: &Kernel<'_, T, D>, wanted: Wanted) -> Option<Skip<T>> {
    let only_laplacian = wanted.laplacian && !wanted.potential && !wanted.gradient;
    if only_laplacian && kernel.is_newtonian() && !matches!(kernel.mollifier(), Mollifier::Gaussian { .. }) {
        return Some(Skip::Neighbours);
    }
    let far = kernel.far()?;
    if far.is_even() && far.degree() <= moments::DEGREE {
        // Without a mollifier a coincident pair contributes nothing, and moments cannot leave it out: of all outputs that
        // matters for the constant Laplacian of |x|^2 alone.
        let constant = far.coefficients.get(2).is_some_and(|&c| c != T::ZERO);
        if !(kernel.is_singular() && wanted.laplacian && constant) {
            return Some(Skip::Moments(far));
        }
    }
    (D == 1).then_some(Skip::Sorted(far))
}

/// The method, why, and its workspace for so many workers, if one of these serves the sum.
///
/// # Errors
/// [`Error::Unsupported`]: the caller forces one of these where it cannot serve.
pub(super) fn choose<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    sizes: (usize, usize),
    wanted: Wanted,
    options: &Options,
) -> Result<Option<(Method, Reason)>> {
    let found = kernel.sum().and_then(|kernel| skip(kernel, wanted)).map(|skip| skip.method());
    match (options.method, found) {
        (Some(forced @ (Method::Moments | Method::Sorted | Method::Neighbours)), found) => match found {
            Some((method, _)) if method == forced => Ok(Some((method, Reason::Forced))),
            _ => Err(Error::Unsupported),
        },
        (Some(_), _) => Ok(None),
        (None, Some((Method::Sorted, _))) if sizes.0.saturating_mul(sizes.1) < FEW_PAIRS => Ok(None),
        (None, found) => Ok(found),
    }
}

/// Bytes of workspace of these methods.
pub(super) fn workspace_bytes<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    method: Method,
    (n_sources, n_targets): (usize, usize),
    workers: usize,
) -> Result<usize> {
    match method {
        Method::Moments => {
            let degree = kernel.sum().and_then(Kernel::far).map_or(0, |far| far.degree());
            moments::workspace_bytes::<T, D>(degree, n_sources, workers)
        }
        Method::Sorted => sorted::workspace_bytes::<T>(n_sources, n_targets),
        Method::Neighbours => neighbours::workspace_bytes::<T, D>(n_sources),
        _ => Ok(0),
    }
}

/// Runs one of these methods; the caller has checked the arguments against the plan.
#[allow(clippy::too_many_arguments, reason = "the front door's arguments")]
pub(super) fn evaluate<T: Real, const D: usize>(
    plan: &Plan,
    kernel: &dyn Interaction<T, D>,
    sources: Sources<'_, T, D>,
    targets: &[[T; D]],
    outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    // A plan for another kernel may ask for what this one cannot do.
    let kernel = kernel.sum().ok_or(Error::Unsupported)?;
    let skip = skip(kernel, plan.wanted()).filter(|skip| skip.method().0 == plan.method()).ok_or(Error::Unsupported)?;
    match skip {
        Skip::Neighbours => {
            let coefficient = kernel.newtonian_coefficient();
            neighbours::evaluate(coefficient, kernel.blob(), sources, targets, outputs, workspace, run)
        }
        Skip::Moments(far) => moments::evaluate(&far, plan.options(), sources, targets, outputs, workspace, run),
        Skip::Sorted(far) => sorted::evaluate(kernel, &far, sources, targets, outputs, workspace, run),
    }
}
