//! Methods that avoid the sum over all pairs: their selection and execution.

use super::expansions::Expansions;
use super::neighbours::Sums;
use super::options::{Method, Options, Reason};
use super::problem::{Interaction, Outputs, Sources, Wanted};
use super::{moments, neighbours, pairs, sorted};
use crate::build;
use crate::error::{Error, Result};
use crate::exec::Run;
use crate::kernel::{Far, Kernel};
use crate::memory::{Carve, Measure, Space};
use crate::mollifier::Blob;
use crate::real::Real;

/// Fewer pairs than this are faster one by one than sorted.
const FEW_PAIRS: usize = 2048;

/// A method that can serve a sum.
enum FastMethod {
    Moments(Far),
    Sorted(Far),
    Neighbours,
    Split,
}

impl FastMethod {
    fn method(&self) -> (Method, Reason) {
        match self {
            FastMethod::Moments(_) => (Method::Moments, Reason::EvenPowers),
            FastMethod::Sorted(_) => (Method::Sorted, Reason::OneDimension),
            FastMethod::Neighbours => (Method::Neighbours, Reason::CompactLaplacian),
            FastMethod::Split => (Method::Split, Reason::SomeEvenPowers),
        }
    }
}

fn skip<T: Real, const D: usize>(kernel: &Kernel<'_, T, D>, wanted: Wanted) -> Option<FastMethod> {
    if wanted.hessian {
        return None;
    }
    let only_laplacian = wanted.laplacian && !wanted.potential && !wanted.gradient;
    if only_laplacian && kernel.is_newtonian() && kernel.mollifier().is_compact() {
        return Some(FastMethod::Neighbours);
    }
    let Some(far) = kernel.far() else {
        // Beside another table the even powers cost nothing.
        let without_table = kernel.mollifier().is_compact() && kernel.mollifier().radii() == 1;
        let (even, _) = kernel.without_even_powers().filter(|(_, rest)| rest.is_newtonian() && without_table)?;
        return even_powers(&even, wanted).map(|_| FastMethod::Split);
    };
    if let Some(far) = even_powers(kernel, wanted) {
        return Some(FastMethod::Moments(far));
    }
    (D == 1).then_some(FastMethod::Sorted(far))
}

/// The blob, if the kernel is a mollifier itself, compact or Gaussian, and neighbours serve the sum.
fn near_density<'a, T: Real, const D: usize>(
    kernel: &'a dyn Interaction<T, D>,
    wanted: Wanted,
    options: &Options,
) -> Option<&'a Blob<T, D>> {
    let served = !wanted.laplacian && !wanted.hessian && options.combination == (1.0, 0.0);
    kernel.density().filter(|blob| served && !blob.mollifier().is_algebraic())
}

/// The polynomial, if all terms are even powers and moments can serve them.
fn even_powers<T: Real, const D: usize>(kernel: &Kernel<'_, T, D>, wanted: Wanted) -> Option<Far> {
    let far = kernel.far()?;
    if far.is_even() && far.degree() <= moments::DEGREE {
        // Without a mollifier a coincident pair contributes nothing, and moments cannot leave it out: of all outputs that
        // matters for the constant Laplacian of |x|^2 alone.
        let constant = far.coefficients.get(2).is_some_and(|c| !c.is_zero());
        if !(kernel.is_singular() && wanted.laplacian && constant) {
            return Some(far);
        }
    }
    None
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
    if !build::METHODS {
        // Each method would stay linked for the sum that might choose it.
        return if matches!(options.method, None | Some(Method::Direct)) { Ok(None) } else { Err(Error::Unsupported) };
    }
    let found = kernel
        .sum()
        .filter(|_| !options.radii && !options.strengths)
        .and_then(|kernel| skip(kernel, wanted))
        .map(|skip| skip.method())
        .or(near_density(kernel, wanted, options).map(|_| (Method::Neighbours, Reason::ShortRange)));
    match (options.method, found) {
        (Some(forced @ (Method::Moments | Method::Sorted | Method::Neighbours | Method::Split)), found) => {
            match found {
                Some((method, _)) if method == forced => Ok(Some((method, Reason::Forced))),
                _ => Err(Error::Unsupported),
            }
        }
        (Some(forced @ (Method::Fmm | Method::Tree)), _) => match Expansions::of(kernel, wanted, options) {
            Some(expansions) if expansions.method() == forced => Ok(Some((forced, Reason::Forced))),
            _ => Err(Error::Unsupported),
        },
        (Some(_), _) => Ok(None),
        (None, None) => {
            let expansions = Expansions::of(kernel, wanted, options).filter(|expansions| expansions.pays(sizes));
            Ok(expansions.map(|expansions| (expansions.method(), Reason::Tolerance)))
        }
        (None, Some((Method::Sorted | Method::Split, _))) if sizes.0.saturating_mul(sizes.1) < FEW_PAIRS => Ok(None),
        (None, found) => Ok(found),
    }
}

/// Bytes of workspace of these methods.
pub(super) fn workspace_bytes<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    method: Method,
    (sizes @ (n_sources, n_targets), wanted): ((usize, usize), Wanted),
    options: &Options,
    workers: usize,
) -> Result<usize> {
    match method {
        Method::Moments => {
            let degree = kernel.sum().and_then(Kernel::far).map_or(0, |far| far.degree());
            moments::workspace_bytes::<T, D>(degree, n_sources, workers)
        }
        Method::Sorted => sorted::workspace_bytes::<T>(n_sources, n_targets),
        Method::Neighbours => neighbours::workspace_bytes::<T, D>(n_sources),
        Method::Split => {
            let (even, _) = kernel.sum().and_then(Kernel::without_even_powers).ok_or(Error::Unsupported)?;
            Measure::of(|space| Split::<T, D>::layout(space, &even, (n_sources, n_targets), workers).map(|_| ()))
        }
        Method::Fmm | Method::Tree => {
            let expansions = Expansions::of(kernel, wanted, options).ok_or(Error::Unsupported)?;
            expansions.workspace_bytes::<T>(sizes, wanted, options, workers)
        }
        Method::Direct => Ok(0),
    }
}

/// The workspace of [`Method::Split`]: the even powers' sums, then what either part needs.
struct Split<'w, T, const D: usize> {
    potential: &'w mut [T],
    gradient: &'w mut [[T; D]],
    laplacian: &'w mut [T],
    // two arrays, so that the size is linear in the number of workers, as plans assume
    moments: &'w mut [u8],
    pairs: &'w mut [u8],
}

impl<'w, T: Real, const D: usize> Split<'w, T, D>
where
    [T; D]: crate::memory::Plain,
{
    fn layout(
        space: &mut impl Space<'w>,
        even: &Kernel<'_, T, D>,
        (n_sources, n_targets): (usize, usize),
        workers: usize,
    ) -> Result<Self> {
        let degree = even.far().map_or(0, |far| far.degree());
        let moments = moments::workspace_bytes::<T, D>(degree, n_sources, workers)?;
        let pairs = pairs::workspace_bytes::<T, D>(n_sources, [false; 2])?;
        Ok(Self {
            potential: space.try_array(n_targets)?,
            gradient: space.try_array(n_targets)?,
            laplacian: space.try_array(n_targets)?,
            moments: space.try_array(moments)?,
            pairs: space.try_array(pairs)?,
        })
    }
}

/// Writes the sums of the terms that are not even powers, then adds those that are.
fn split<T: Real, const D: usize>(
    options: &Options,
    kernel: &Kernel<'_, T, D>,
    sources: Sources<'_, T, D>,
    targets: &[[T; D]],
    mut outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let (even, rest) = kernel.without_even_powers().ok_or(Error::Unsupported)?;
    let far = even.far().ok_or(Error::Unsupported)?;
    let (sizes, workers) = ((sources.positions.len(), targets.len()), run.executor.workers());
    let Split { potential, gradient, laplacian, moments: memory, pairs: of_pairs } =
        Split::<T, D>::layout(&mut Carve::new(workspace)?, &even, sizes, workers)?;
    let wanted = outputs.wanted();
    let some = Outputs {
        potential: wanted.potential.then_some(&mut *potential),
        gradient: wanted.gradient.then_some(&mut *gradient),
        laplacian: wanted.laplacian.then_some(&mut *laplacian),
        hessian: None,
    };
    // The sources without mass are counted with the pairs.
    let mut quiet = Run {
        level: run.level,
        executor: run.executor,
        should_stop: run.should_stop,
        counters: None,
        communicator: None,
    };
    moments::evaluate((&far, kernel.delta()), options, sources, targets, some, memory, &mut quiet)?;
    let pairs = Outputs {
        potential: outputs.potential.as_deref_mut(),
        gradient: outputs.gradient.as_deref_mut(),
        laplacian: outputs.laplacian.as_deref_mut(),
        hessian: None,
    };
    let call = pairs::Call { options, sources, targets, outputs: pairs, near: None };
    pairs::evaluate::<T, D, true>(&rest, call, of_pairs, run)?;
    let add = |to: Option<&mut [T]>, from: &[T]| {
        to.unwrap_or_default().iter_mut().zip(from).for_each(|(to, &from)| *to += from);
    };
    add(outputs.potential, potential);
    add(outputs.gradient.map(<[[T; D]]>::as_flattened_mut), gradient.as_flattened());
    add(outputs.laplacian, laplacian);
    Ok(())
}

/// Runs one of these methods; the caller has checked the arguments against the plan.
#[allow(clippy::too_many_arguments, reason = "the arguments of `field::evaluate`")]
pub(super) fn evaluate<T: Real, const D: usize>(
    (method, wanted): (Method, Wanted),
    options: &Options,
    kernel: &dyn Interaction<T, D>,
    sources: Sources<'_, T, D>,
    targets: &[[T; D]],
    outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    // A plan for another kernel may ask for what this one cannot do.
    if matches!(method, Method::Fmm | Method::Tree) {
        let expansions = Expansions::of(kernel, wanted, options).filter(|expansions| expansions.method() == method);
        let expansions = expansions.ok_or(Error::Unsupported)?;
        return expansions.evaluate((kernel, wanted), options, (sources, targets), outputs, workspace, run);
    }
    if let Some(blob) = near_density(kernel, wanted, options).filter(|_| method == Method::Neighbours) {
        let sums = Sums { density: outputs.potential, gradient: outputs.gradient };
        return neighbours::evaluate((T::ONE, blob), options, sources, targets, sums, workspace, run);
    }
    let kernel = kernel.sum().ok_or(Error::Unsupported)?;
    let skip = skip(kernel, wanted).filter(|skip| skip.method().0 == method).ok_or(Error::Unsupported)?;
    match skip {
        FastMethod::Neighbours => {
            let sums = Sums { density: outputs.laplacian, gradient: None };
            let kernel = (kernel.newtonian_coefficient(), kernel.blob());
            neighbours::evaluate(kernel, options, sources, targets, sums, workspace, run)
        }
        FastMethod::Moments(far) => {
            moments::evaluate((&far, kernel.delta()), options, sources, targets, outputs, workspace, run)
        }
        // The constant condition keeps it from being compiled for two and three dimensions.
        FastMethod::Sorted(far) if const { D == 1 } => {
            sorted::evaluate((kernel, &far), options, sources, targets, outputs, workspace, run)
        }
        FastMethod::Sorted(_) => Err(Error::Unsupported),
        FastMethod::Split => split(options, kernel, sources, targets, outputs, workspace, run),
    }
}
