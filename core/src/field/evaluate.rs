//! Runs a plan: checks the arguments, then calls the method.

use super::finite::finite;
use super::options::{Method, Options, PairRadius};
use super::plan::Plan;
use super::problem::{Interaction, Outputs, Sources};
use super::{pairs, plan as plans, skips};
use crate::build;
use crate::error::{Error, Result};
use crate::exec::Run;
use crate::real::Real;

/// Overwrites `outputs` with the sums over `sources` at `targets`.
///
/// `workspace` needs [`Plan::workspace_bytes`] for the executor's number of workers, aligned to [`crate::memory::ALIGN`];
/// it is garbage afterwards. The same call gives the same bits for any executor.
///
/// # Errors
/// [`Error::LengthMismatch`]: a length is not the plan's. [`Error::Unsupported`]: an output that the plan is not for, or
/// a level that this machine lacks. [`Error::NotFinite`]: a coordinate or mass. [`Error::WorkspaceTooSmall`],
/// [`Error::Misaligned`]: the workspace. All of these leave the outputs as they were. [`Error::Stopped`],
/// [`Error::Executor`], or the executor's own error: the outputs are then partly written.
pub fn evaluate<T: Real, const D: usize>(
    plan: &Plan,
    kernel: &dyn Interaction<T, D>,
    sources: Sources<'_, T, D>,
    targets: &[[T; D]],
    outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    checked::<T, D, true>(plan, kernel, sources, targets, outputs, workspace, run)
}

/// As [`evaluate`], for the particle methods. Without [`build::BESIDES`] only gradients and Laplacians with default options; code for potentials is not linked.
pub(crate) fn flow<T: Real, const D: usize>(
    plan: &Plan,
    kernel: &dyn Interaction<T, D>,
    sources: Sources<'_, T, D>,
    targets: &[[T; D]],
    outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    checked::<T, D, { build::BESIDES }>(plan, kernel, sources, targets, outputs, workspace, run)
}

/// The gradient of the sum over sources that are the targets too, for solvers that have checked everything but the positions.
///
/// # Errors
/// As [`evaluate`].
pub(crate) fn drift<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    sources: Sources<'_, T, D>,
    gradient: &mut [[T; D]],
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    if !finite(sources.positions.as_flattened(), run.level) {
        return Err(Error::NotFinite);
    }
    let outputs = Outputs { gradient: Some(gradient), ..Outputs::default() };
    let call = pairs::Call { options: &Options::DEFAULT, sources, targets: sources.positions, outputs, near: None };
    pairs::evaluate::<T, D, false>(kernel, call, workspace, run)
}

/// Bytes that [`drift`] needs.
///
/// # Errors
/// [`Error::TooLarge`].
pub(crate) fn drift_bytes<T: Real, const D: usize>(n: usize) -> Result<usize> {
    pairs::workspace_bytes::<T, D>(n, [false; 2])
}

/// [`evaluate`]; not `FULL`: no potential is wanted, and the options are the defaults.
fn checked<T: Real, const D: usize, const FULL: bool>(
    plan: &Plan,
    kernel: &dyn Interaction<T, D>,
    sources: Sources<'_, T, D>,
    targets: &[[T; D]],
    outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    if sources.positions.len() != plan.n_sources()
        || sources.strengths.map_or(sources.masses.len(), <[_]>::len) != plan.n_sources()
        || (sources.strengths.is_some() && !sources.masses.is_empty())
        || sources.radii.is_some_and(|radii| radii.len() != plan.n_sources())
        || targets.len() != plan.n_targets()
        || !outputs.have_length(targets.len())
    {
        return Err(Error::LengthMismatch);
    }
    let (radii, strengths) = (sources.radii.is_some(), sources.strengths.is_some());
    if [radii, strengths] != [plan.options().radii, plan.options().strengths]
        || !plans::serves(kernel, plan.options())
        || !plan.covers(outputs.wanted())
        || !run.level.is_available()
    {
        return Err(Error::Unsupported);
    }
    if workspace.len() < plan.workspace_bytes(run.executor.workers())? {
        return Err(Error::WorkspaceTooSmall);
    }
    let same = core::ptr::eq(sources.positions, targets);
    let symmetric = build::METHODS && plan.options().pair_radius != PairRadius::Source;
    let target_radii = sources.target_radii.or(sources.radii.filter(|_| same)).filter(|_| symmetric);
    if symmetric && target_radii.is_none_or(|radii| radii.len() != targets.len()) {
        return Err(Error::LengthMismatch);
    }
    let sources = Sources { target_radii, ..sources };
    let by_itself = plan.method() == Method::Moments;
    if !((by_itself || finite(sources.positions.as_flattened(), run.level))
        && (same || finite(targets.as_flattened(), run.level))
        && (by_itself || finite(sources.masses, run.level)))
    {
        return Err(Error::NotFinite);
    }
    if sources.strengths.is_some_and(|strengths| !finite(strengths.as_flattened(), run.level)) {
        return Err(Error::NotFinite);
    }
    for radii in sources.radii.into_iter().chain(target_radii) {
        if !finite(radii, run.level) {
            return Err(Error::NotFinite);
        }
        if radii.iter().any(|&radius| radius <= T::ZERO) {
            return Err(Error::Delta);
        }
    }
    // On the line the second derivative is the Laplacian.
    let Outputs { potential, gradient, laplacian, hessian } = outputs;
    let (mut twin, hessian) = match hessian {
        Some(hessian) if build::METHODS && D == 1 => (Some(hessian.as_flattened_mut().as_flattened_mut()), None),
        hessian => (None, hessian),
    };
    if let (Some(twin), None) = (&mut twin, &laplacian) {
        let outputs = Outputs { potential, gradient, laplacian: Some(&mut **twin), hessian };
        return by_method::<T, D, FULL>(plan, kernel, (sources, targets), outputs, workspace, run);
    }
    let mut laplacian = laplacian;
    let outputs = Outputs { potential, gradient, laplacian: laplacian.as_deref_mut(), hessian };
    by_method::<T, D, FULL>(plan, kernel, (sources, targets), outputs, workspace, run)?;
    if let (Some(twin), Some(laplacian)) = (twin, laplacian) {
        twin.iter_mut().zip(laplacian).for_each(|(to, from)| *to = *from);
    }
    Ok(())
}

/// Runs the plan's method; everything is checked.
#[inline(always)]
fn by_method<T: Real, const D: usize, const FULL: bool>(
    plan: &Plan,
    kernel: &dyn Interaction<T, D>,
    (sources, targets): (Sources<'_, T, D>, &[[T; D]]),
    outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    if build::METHODS && plan.method() != Method::Direct {
        return skips::evaluate(
            (plan.method(), plan.wanted().in_dimension(D)),
            plan.options(),
            kernel,
            sources,
            targets,
            outputs,
            workspace,
            run,
        );
    }
    let call = pairs::Call { options: plan.options(), sources, targets, outputs, near: None };
    pairs::evaluate::<T, D, FULL>(kernel, call, workspace, run)
}
