//! Sums over sources: `u(x_i) = sum_j m_j K_delta(x_i - x_j)`, its gradient and its Laplacian.
//!
//! One front door: [`plan`] picks the method and says why, what is skipped and how many workspace bytes it takes;
//! [`evaluate`] runs it. Masses may have either sign; targets may or may not be the sources. A mollified kernel counts
//! every pair, a target on a source included; without a mollifier coincident pairs contribute nothing, and coincidence
//! is by position, so no index map is needed.

mod kernels;
mod moments;
mod neighbours;
mod pairs;
mod plan;
mod radix;
mod skips;
mod sorted;

pub use plan::{Accumulation, Method, Options, Plan, Reason, plan};

use crate::error::{Error, Result};
use crate::isa::{Level, Plain, widest};
use crate::kernel::Kernel;
use crate::mollifier::{Blob, Mollifier};
use crate::parallel::{Executor, Serial};
use crate::real::Real;

/// What a sum asks of its kernel.
pub trait Interaction<T: Real, const D: usize>: Sync {
    /// K_delta(r).
    fn value(&self, r: T) -> T;
    /// K_delta'(r) / r, so that the gradient is this times x.
    fn gradient_factor(&self, r: T) -> T;
    /// The Laplacian of K_delta at distance r.
    fn laplacian(&self, r: T) -> T;
    /// The coefficient and the blob, where the kernel is Newtonian: such sums have loops of their own for each instruction set.
    fn newtonian(&self) -> Option<(T, &Blob<T, D>)> {
        None
    }
    /// The sum of known kernels that this is, if it is one: some sums have faster methods.
    fn sum(&self) -> Option<&Kernel<'_, T, D>> {
        None
    }
    /// Value, gradient factor and Laplacian for a pair at distance r; what is not wanted may be anything.
    fn pair(&self, r: T, wanted: Wanted) -> [T; 3] {
        [
            if wanted.potential { self.value(r) } else { T::ZERO },
            if wanted.gradient { self.gradient_factor(r) } else { T::ZERO },
            if wanted.laplacian { self.laplacian(r) } else { T::ZERO },
        ]
    }
    /// [`Interaction::pair`] in double precision, for kernels whose values leave the range of single precision.
    fn pair_wide(&self, r: f64, wanted: Wanted) -> [f64; 3] {
        self.pair(T::from_f64(r), wanted).map(T::to_f64)
    }
    /// Whether the kernel has no mollifier, so that coincident pairs contribute nothing.
    fn is_singular(&self) -> bool;
}

/// The Newtonian kernel with coefficient 1.
impl<T: Real, const D: usize> Interaction<T, D> for Blob<T, D> {
    fn value(&self, r: T) -> T {
        self.potential(r)
    }
    fn gradient_factor(&self, r: T) -> T {
        Blob::gradient_factor(self, r)
    }
    fn laplacian(&self, r: T) -> T {
        self.density(r)
    }
    fn newtonian(&self) -> Option<(T, &Blob<T, D>)> {
        Some((T::ONE, self))
    }
    fn is_singular(&self) -> bool {
        self.mollifier() == Mollifier::None
    }
}

/// What attracts: positions `[n][D]` and masses `[n]` of any sign. A mass is the density times the cell volume h^D.
#[derive(Clone, Copy, Debug)]
pub struct Sources<'a, T, const D: usize> {
    /// Where the sources are.
    pub positions: &'a [[T; D]],
    /// Their masses; those that are zero are dropped before the sum starts.
    pub masses: &'a [T],
}

impl<'a, T: Real, const D: usize> Sources<'a, T, D> {
    /// The largest coordinate and the largest mass of every `stride`-th source.
    fn largest(self, stride: usize) -> [T; 2] {
        let larger = |most: T, x: T| if x.abs() > most { x.abs() } else { most };
        let coordinates = self.positions.iter().step_by(stride).flatten();
        let masses = self.masses.iter().step_by(stride);
        [coordinates.fold(T::ZERO, |most, &x| larger(most, x)), masses.fold(T::ZERO, |most, &m| larger(most, m))]
    }
}

/// Where results go, each `[n_targets]`. All are overwritten; `None` is not computed.
#[derive(Debug)]
pub struct Outputs<'a, T, const D: usize> {
    /// `sum_j m_j K_delta(x_i - x_j)`.
    pub potential: Option<&'a mut [T]>,
    /// `sum_j m_j grad K_delta(x_i - x_j)`, or what [`Options::combination`] makes of it.
    pub gradient: Option<&'a mut [[T; D]]>,
    /// `sum_j m_j Laplacian K_delta(x_i - x_j)`.
    pub laplacian: Option<&'a mut [T]>,
}

impl<T, const D: usize> Default for Outputs<'_, T, D> {
    fn default() -> Self {
        Self { potential: None, gradient: None, laplacian: None }
    }
}

impl<T, const D: usize> Outputs<'_, T, D> {
    /// Which outputs are there.
    #[must_use]
    pub fn wanted(&self) -> Wanted {
        Wanted {
            potential: self.potential.is_some(),
            gradient: self.gradient.is_some(),
            laplacian: self.laplacian.is_some(),
        }
    }

    /// Whether every output there has this length.
    fn have_length(&self, n: usize) -> bool {
        self.potential.as_ref().is_none_or(|p| p.len() == n)
            && self.gradient.as_ref().is_none_or(|g| g.len() == n)
            && self.laplacian.as_ref().is_none_or(|l| l.len() == n)
    }
}

/// Which outputs a plan is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Wanted {
    /// The potential.
    pub potential: bool,
    /// The gradient.
    pub gradient: bool,
    /// The Laplacian.
    pub laplacian: bool,
}

/// How a call runs: on which instruction set, through which executor. Nothing of it is ever stored.
pub struct Run<'a> {
    /// The instruction set.
    pub level: Level,
    /// Who runs the tasks.
    pub executor: &'a dyn Executor,
    /// Asked between tasks; `true` ends the call with [`Error::Stopped`].
    pub should_stop: Option<&'a (dyn Fn() -> bool + Sync)>,
    /// Added to, when the call succeeds.
    pub counters: Option<&'a mut Counters>,
}

impl Default for Run<'_> {
    fn default() -> Self {
        Self { level: Level::best(), executor: &Serial, should_stop: None, counters: None }
    }
}

impl core::fmt::Debug for Run<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Run").field("level", &self.level).field("workers", &self.executor.workers()).finish()
    }
}

/// What a sum did: skipped work is a tested count, not a guess from a clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Counters {
    /// Pairs of a target and a source with mass whose distance was computed.
    pub pairs: u64,
    /// Of these, pairs closer than delta.
    pub near_pairs: u64,
    /// Blocks (one source against one register block of targets) that evaluated the mollifier's polynomial.
    pub polynomial_blocks: u64,
    /// Blocks in which every lane was near, so that nothing was divided.
    pub all_near_blocks: u64,
    /// Pairs that took the scaled path, because r^2 or r^D leaves the normal range.
    pub scaled_pairs: u64,
    /// Sources without mass that were dropped.
    pub massless_sources: u64,
}

impl Counters {
    /// Adds another count.
    pub fn add(&mut self, other: &Counters) {
        let Counters { pairs, near_pairs, polynomial_blocks, all_near_blocks, scaled_pairs, massless_sources } = other;
        self.pairs = self.pairs.saturating_add(*pairs);
        self.near_pairs = self.near_pairs.saturating_add(*near_pairs);
        self.polynomial_blocks = self.polynomial_blocks.saturating_add(*polynomial_blocks);
        self.all_near_blocks = self.all_near_blocks.saturating_add(*all_near_blocks);
        self.scaled_pairs = self.scaled_pairs.saturating_add(*scaled_pairs);
        self.massless_sources = self.massless_sources.saturating_add(*massless_sources);
    }
}

/// Overwrites `outputs` with the sums over `sources` at `targets`.
///
/// `workspace` needs [`Plan::workspace_bytes`] for the executor's number of workers, aligned to [`crate::space::ALIGN`];
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

/// As [`evaluate`], for solvers. Firmware's want gradients and Laplacians by default options, and what leads to potentials is not linked.
pub(crate) fn flow<T: Real, const D: usize>(
    plan: &Plan,
    kernel: &dyn Interaction<T, D>,
    sources: Sources<'_, T, D>,
    targets: &[[T; D]],
    outputs: Outputs<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    checked::<T, D, { !cfg!(feature = "small") }>(plan, kernel, sources, targets, outputs, workspace, run)
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
    let call = pairs::Call { options: &Options::DEFAULT, sources, targets: sources.positions, outputs };
    pairs::evaluate::<T, D, false>(kernel, call, workspace, run)
}

/// Bytes that [`drift`] needs.
///
/// # Errors
/// [`Error::TooLarge`].
pub(crate) fn drift_bytes<T: Real, const D: usize>(n: usize) -> Result<usize> {
    pairs::workspace_bytes::<T, D>(n)
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
        || sources.masses.len() != plan.n_sources()
        || targets.len() != plan.n_targets()
        || !outputs.have_length(targets.len())
    {
        return Err(Error::LengthMismatch);
    }
    if !plan.covers(outputs.wanted()) || !run.level.is_available() {
        return Err(Error::Unsupported);
    }
    if workspace.len() < plan.workspace_bytes(run.executor.workers())? {
        return Err(Error::WorkspaceTooSmall);
    }
    let same = core::ptr::eq(sources.positions, targets);
    let by_itself = plan.method() == Method::Moments;
    if !((by_itself || finite(sources.positions.as_flattened(), run.level))
        && (same || finite(targets.as_flattened(), run.level))
        && (by_itself || finite(sources.masses, run.level)))
    {
        return Err(Error::NotFinite);
    }
    if cfg!(not(feature = "small")) && plan.method() != Method::Direct {
        return skips::evaluate(plan, kernel, sources, targets, outputs, workspace, run);
    }
    let call = pairs::Call { options: plan.options(), sources, targets, outputs };
    pairs::evaluate::<T, D, FULL>(kernel, call, workspace, run)
}

/// Whether all numbers are finite.
fn finite<T: Real>(numbers: &[T], level: Level) -> bool {
    if cfg!(feature = "small") {
        return numbers.iter().all(|x| x.is_finite());
    }
    struct Finite<'a, T>(&'a [T]);
    impl<T: Real> Plain for Finite<'_, T> {
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
    widest(level, Finite(numbers))
}
